//! det(z−M)/det(z−R) of an orbit as a function of z, from its equations J(z); and J(z) with the nearest poles kept apart.
//!
//! f′/f = tr J⁻¹J′ costs O(n r²) for n modes and r impacts. Next to a simple pole q with its dyad a·c, J is bordered:
//!
//! ```text
//! (z−q)·det J = det [ J without the pole   a   ]
//!                   [ −q·c                 z−q ]
//! ```
//!
//! which is regular there: a multiplier is told from its pole however close the two are.

use std::borrow::Cow;

use nalgebra::{Complex, DMatrix};
use smallvec::SmallVec;
use vibrochain_breather::{BlochEquations, ShapeErrors, Shift};

use crate::zeros::{Meromorphic, Value, modulus};

type C = Complex<f64>;

/// Poles closer than this part of z are bordered: beyond, sums over them lose fewer digits than estimates of errors are wide.
const NEAR: f64 = 1e-2;

/// The most poles that are bordered: where many crowd, these are the nearest, and what is lost on the others is estimated.
const MOST_NEAR: usize = 6;

/// In place of an infinite f′/f.
const HUGE: f64 = 1e200;

/// A simple pole of one mode; or, of a double one, one of the mode's two coordinates.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pole {
    pub(super) mode: usize,
    /// q = e^{λT}, and λ.
    pub(super) value: C,
    pub(super) rate: C,
    /// Whether it is the first or the second one of its mode.
    pub(super) which: usize,
    /// Error of q.
    pub(super) error: f64,
}

/// J₀ of one form: errors of its entries, and what they change by with the time of their row's impact.
#[derive(Debug, Clone, Default)]
pub(super) struct Constant {
    pub(super) errors: Vec<f64>,
    pub(super) slides: Vec<f64>,
}

/// Errors of pairs as [`vibrochain_lattice::Coordinates::carried`] has them: where no mode has coordinates of their own, all second numbers are 0
/// and take no room.
#[derive(Debug, Default)]
pub(super) struct PairErrors([Vec<f64>; 2]);

impl PairErrors {
    fn with_room(count: usize) -> Self {
        Self([Vec::with_capacity(count), Vec::new()])
    }

    fn push(&mut self, [first, second]: [f64; 2]) {
        let Self([firsts, seconds]) = self;
        if second != 0.0 || !seconds.is_empty() {
            seconds.resize(firsts.len(), 0.0);
            seconds.push(second);
        }
        firsts.push(first);
    }

    fn get(&self, place: usize) -> [f64; 2] {
        let Self([firsts, seconds]) = self;
        [firsts[place], seconds.get(place).copied().unwrap_or(0.0)]
    }

    /// The first or the second numbers of these places; none where all are 0.
    pub(super) fn numbers(&self, which: usize, places: std::ops::Range<usize>) -> &[f64] {
        self.0[which].get(places).unwrap_or_default()
    }
}

/// The function, with what its evaluation needs.
#[derive(Debug)]
pub(crate) struct SpectralFunction<'a> {
    /// Those of the orbit; of one that may begin at any time without its own derivative, if that can be left out.
    pub(super) equations: Cow<'a, BlochEquations>,
    pub(super) shift: Option<Shift>,
    /// All poles, two for each mode.
    pub(super) poles: Vec<C>,
    /// The modes whose poles are double.
    double: Vec<usize>,
    /// Errors of A_k and C_k, [mode][row].
    pub(super) row_errors: PairErrors,
    pub(super) column_errors: PairErrors,
    /// Of J₀ outside and inside.
    pub(super) constants: [Constant; 2],
    matrix: Vec<C>,
    derivative: Vec<C>,
}

impl<'a> SpectralFunction<'a> {
    /// The function of the equations, of an orbit that may begin at any time without the two zeros at 1.
    pub(crate) fn new(equations: &'a BlochEquations, conservative: bool) -> Self {
        Self::of(Cow::Borrowed(equations), conservative)
    }

    /// The same of equations that are not needed any more: of a large ring there is no room for two of them.
    pub(crate) fn taking(equations: BlochEquations, conservative: bool) -> Self {
        Self::of(Cow::Owned(equations), conservative)
    }

    fn of(mut equations: Cow<'a, BlochEquations>, conservative: bool) -> Self {
        let shift = if conservative { equations.to_mut().leave_out_shift() } else { None };
        let (modes, size) = (equations.kernel().modes(), equations.size());
        let since = equations.since_cut();
        let longest = since.iter().copied().fold(0.0, f64::max);
        let (count, all) = (modes.len(), size * modes.len());
        let mut poles = Vec::with_capacity(2 * count);
        let [mut row_errors, mut column_errors] = [(); 2].map(|()| PairErrors::with_room(all));
        let (mut double, mut doubts) = (Vec::new(), ShapeErrors::default());
        let mut constants =
            [(); 2].map(|()| Constant { errors: vec![0.0; size * size], slides: vec![0.0; size * size] });
        for (k, mode) in modes.iter().enumerate() {
            poles.extend(mode.poles());
            double.extend(mode.coordinates.are_parabolic().then_some(k));
            let (rows, columns) = (equations.rows(k), equations.columns(k));
            let (from, coordinates) = (k * size, mode.coordinates);
            let part =
                f64::EPSILON * (6.0 + 3.0 * (mode.rate + mode.decay.abs()) * longest) + mode.rate_error * longest;
            equations.shape_errors(k, &mut doubts);
            for (table, doubts, errors) in
                [(rows, &doubts[0], &mut row_errors), (columns, &doubts[1], &mut column_errors)]
            {
                let pairs = table.iter().zip(doubts);
                pairs.for_each(|(entries, error)| errors.push(coordinates.with_part(*error, part, *entries)));
            }
            if let Some(shift) = &shift {
                // Sums over the impacts, times (1−R)⁻¹, of which each term is turned, and the pole is moved.
                let near = (mode.poles()[0] - 1.0).norm().recip();
                let part = part + 2.0 * near * mode.pole_error;
                let sum = |before: &dyn Fn(usize) -> [f64; 2], doubts: &[[f64; 2]]| {
                    let error = |r: usize| coordinates.with_part(doubts[r], part, before(r))[0];
                    let terms = shift.weights.iter().enumerate().map(|(i, weight)| weight.abs() * error(2 * i + 1));
                    near * terms.sum::<f64>()
                };
                row_errors.0[0][from + shift.place] = sum(&|r| shift.row_before(rows, k, r), &doubts[0]);
                column_errors.0[0][from + shift.place] = sum(&|r| shift.column_before(columns, k, r), &doubts[1]);
            }
            for (i, row) in rows.iter().enumerate() {
                let moved = mode.coordinates.seen(*row, mode.generator());
                for (j, column) in columns.iter().enumerate() {
                    if shift.as_ref().is_some_and(|shift| i == shift.place || j == shift.place) {
                        continue;
                    }
                    let earlier = since[i / 2] > since[j / 2];
                    let (form, sign) = if earlier { (0, 1.0) } else { (1, -1.0) };
                    let Constant { errors, slides } = &mut constants[form];
                    errors[i * size + j] += coordinates
                        .reach_error([*row, row_errors.get(from + i)], [*column, column_errors.get(from + j)]);
                    if i / 2 != j / 2 {
                        slides[i * size + j] += sign * (moved[0] * column[0] + moved[1] * column[1]);
                    }
                }
            }
        }
        constants[0].slides.iter_mut().zip(equations.sliding()).for_each(|(slide, died)| *slide += died);
        let is_kept = |i: usize| shift.as_ref().is_none_or(|shift| shift.place != 2 * i + 1);
        let hit = |i: usize| if is_kept(i) { equations.hit_error(i) } else { 0.0 };
        let hits: SmallVec<[f64; 8]> = (0..size / 2).map(hit).collect();
        for (form, Constant { errors, .. }) in constants.iter_mut().enumerate() {
            let entries = equations.constant(form == 1);
            errors.iter_mut().zip(entries).for_each(|(error, entry)| *error += 4.0 * f64::EPSILON * entry.abs());
            let sent = equations.sent_errors().iter().filter(|_| form == 0);
            errors.iter_mut().zip(sent).for_each(|(error, sent)| *error += sent);
            for (i, hit) in hits.iter().enumerate() {
                let at = 2 * i * (size + 1);
                errors[at + 1] += hit;
                errors[at + size] += hit;
            }
            let slides = equations.slide_errors().into_iter().flatten().enumerate();
            let kept = slides.filter(|(i, _)| is_kept(*i));
            kept.for_each(|(i, error)| errors[(2 * i + 1) * (size + 1)] += error);
        }
        let (matrix, derivative) = (Vec::new(), Vec::new());
        Self { equations, shift, poles, double, row_errors, column_errors, constants, matrix, derivative }
    }

    /// Both poles of mode `k`. A double pole is there twice, once for each of the mode's two coordinates.
    pub(super) fn poles_of(&self, k: usize) -> [Pole; 2] {
        let mode = &self.equations.kernel().modes()[k];
        let (rates, errors) = (mode.rates(), mode.pole_errors());
        let value = |which: usize| self.poles[2 * k + which];
        [0, 1].map(|which| Pole { mode: k, value: value(which), rate: rates[which], which, error: errors[which] })
    }

    /// The modes whose poles are simple.
    pub(super) fn of_simple_poles(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.poles.len() / 2).filter(|k| self.double.binary_search(k).is_err())
    }

    /// How many poles are simple.
    pub(super) fn simple(&self) -> usize {
        self.poles.len() - 2 * self.double.len()
    }

    /// The poles next to z: double ones, both coordinates of each, and the simple ones, the nearest first.
    pub(super) fn near(&self, z: C) -> Vec<Pole> {
        let reach = NEAR * NEAR * z.norm_sqr();
        let distance = |pole: &C| (z - pole).norm_sqr();
        let both = |k: usize| &self.poles[2 * k..2 * k + 2];
        let mut near = Vec::new();
        for k in self.of_simple_poles().filter(|k| both(*k).iter().any(|pole| distance(pole) < reach)) {
            near.extend(self.poles_of(k).into_iter().filter(|pole| distance(&pole.value) < reach));
        }
        near.sort_by(|a, b| distance(&a.value).total_cmp(&distance(&b.value)));
        near.truncate(MOST_NEAR);
        let double = self.double.iter().filter(|k| distance(&both(**k)[0]) < reach).take(MOST_NEAR / 2);
        near.splice(0..0, double.flat_map(|k| self.poles_of(*k)));
        near
    }

    /// Error of A_k and of C_k, each against its largest row.
    pub(super) fn relative(&self, mode: usize) -> f64 {
        let own = mode * self.equations.size()..(mode + 1) * self.equations.size();
        let part = |table: &[[f64; 2]], errors: &PairErrors| {
            let length = |[x, y]: [f64; 2]| modulus(C::new(x, y));
            let size = table.iter().map(|entries| length(*entries)).fold(0.0, f64::max);
            let error = own.clone().map(|place| length(errors.get(place))).fold(0.0, f64::max);
            if size == 0.0 { 0.0 } else { error / size }
        };
        part(self.equations.rows(mode), &self.row_errors) + part(self.equations.columns(mode), &self.column_errors)
    }

    /// a and c of a simple pole.
    pub(super) fn dyad(&self, pole: &Pole) -> [SmallVec<[C; 8]>; 2] {
        let coordinates = self.equations.kernel().modes()[pole.mode].coordinates;
        let complex = |v: &[f64; 2]| v.map(|x| C::new(x, 0.0));
        let rows = self.equations.rows(pole.mode).iter().map(|v| coordinates.seen_of_pole(pole.which, complex(v)));
        let columns =
            self.equations.columns(pole.mode).iter().map(|v| coordinates.given_to_pole(pole.which, complex(v)));
        [rows.collect(), columns.collect()]
    }

    /// J(z) bordered by the poles `near`, by rows of `size` + the number of these.
    pub(super) fn bordered(&self, z: C, near: &[Pole]) -> Vec<C> {
        let size = self.equations.size();
        let apart: Vec<usize> = near.iter().map(|pole| pole.mode).collect();
        let mut entries = Vec::new();
        self.equations.fill_without(z, &apart, &mut entries, None);
        let is_near = |pole: &Pole| near.iter().any(|other| other.mode == pole.mode && other.which == pole.which);
        // The other pole of a mode whose one pole is near.
        let mut simple: SmallVec<[usize; MOST_NEAR]> =
            apart.iter().copied().filter(|k| self.double.binary_search(k).is_err()).collect();
        simple.sort_unstable();
        simple.dedup();
        for pole in simple.into_iter().flat_map(|k| self.poles_of(k)).filter(|pole| !is_near(pole)) {
            let [a, c] = self.dyad(&pole);
            let factor = pole.value * (z - pole.value).inv();
            for (i, a) in a.iter().enumerate() {
                for (j, c) in c.iter().enumerate() {
                    entries[i * size + j] += factor * a * c;
                }
            }
        }
        if near.is_empty() {
            return entries;
        }
        let all = size + near.len();
        let mut matrix = vec![C::default(); all * all];
        for (row, entries) in matrix.chunks_exact_mut(all).zip(entries.chunks_exact(size)) {
            row[..size].copy_from_slice(entries);
        }
        for (place, pole) in near.iter().enumerate() {
            let border = size + place;
            let mode = &self.equations.kernel().modes()[pole.mode];
            if mode.coordinates.are_parabolic() {
                // (z−R)⁻¹ of both coordinates together: R = q + rJ, J² = 0.
                let (own, other) = (mode.period.even, if pole.which == 0 { mode.period.odd } else { 0.0 });
                for (i, (row, column)) in
                    self.equations.rows(pole.mode).iter().zip(self.equations.columns(pole.mode)).enumerate()
                {
                    matrix[i * all + border] = C::new(row[pole.which], 0.0);
                    matrix[border * all + i] = C::new(-own * column[pole.which] - other * column[1], 0.0);
                }
                matrix[border * all + border] = z - own;
                if pole.which == 0 {
                    matrix[border * all + border + 1] = C::new(-other, 0.0);
                }
                continue;
            }
            let [a, c] = self.dyad(pole);
            for i in 0..size {
                matrix[i * all + border] = a[i];
                matrix[border * all + i] = -pole.value * c[i];
            }
            matrix[border * all + border] = z - pole.value;
        }
        matrix
    }
}

impl Meromorphic for SpectralFunction<'_> {
    /// f is told as 1: the iteration asks for f′/f alone.
    fn evaluate(&mut self, z: C) -> Value {
        let size = self.equations.size();
        self.equations.fill(z, &mut self.matrix, Some(&mut self.derivative));
        let factors = DMatrix::from_row_slice(size, size, &self.matrix).lu();
        let quotient = factors.solve(&DMatrix::from_row_slice(size, size, &self.derivative));
        // At a zero to the last digit, or at a pole, the step is none.
        let finite = |value: &C| value.re.is_finite() && value.im.is_finite();
        let told = quotient.map(|quotient| (quotient.trace(), f64::EPSILON * size as f64 * quotient.norm()));
        let (slope, slope_error) = told.filter(|(slope, _)| finite(slope)).unwrap_or((C::new(HUGE, 0.0), 0.0));
        let poles = self.poles.iter().map(|pole| (z - pole).inv()).filter(finite).sum();
        Value { f: C::new(1.0, 0.0), slope, poles, noise: 0.0, slope_error }
    }
}

impl SpectralFunction<'_> {
    /// The sum of all zeros, tr M, from f far out: Σq − tr J₀⁻¹ΣA_kR_kC_k; with its error by rounding.
    pub(super) fn trace(&self) -> Option<(C, f64)> {
        let (equations, size) = (&*self.equations, self.equations.size());
        let shift = self.shift.as_ref();
        let mut first = DMatrix::<f64>::zeros(size, size);
        for (k, mode) in equations.kernel().modes().iter().enumerate() {
            let (rows, columns) = (equations.rows(k), equations.columns(k));
            for i in 0..size {
                let row = shift.map_or(rows[i], |shift| shift.row_before(rows, k, i));
                let seen = mode.coordinates.seen(row, mode.period);
                for j in 0..size {
                    let column = shift.map_or(columns[j], |shift| shift.column_before(columns, k, j));
                    first[(i, j)] += seen[0] * column[0] + seen[1] * column[1];
                }
            }
        }
        let constant = shift.map_or(equations.constant(false), Shift::constant_before);
        let constant = DMatrix::from_row_slice(size, size, constant);
        let inverse = constant.try_inverse()?;
        let reach = inverse.norm() * first.norm();
        let error = 8.0 * f64::EPSILON * size as f64 * reach;
        Some((self.poles.iter().sum::<C>() - (inverse * first).trace(), error))
    }
}

/// The same function of ν = ½(z + 1/z), where neither impacts nor modes lose energy: a multiplier comes with its inverse, f is real for
/// real ν, and a pair that is on the circle, or real, is one real zero.
#[derive(Debug)]
pub(super) struct OfHalfSum<'f, 'a>(pub(super) &'f mut SpectralFunction<'a>);

/// The multiplier of modulus 1 or more that belongs to ν.
pub(super) fn outer(nu: C) -> C {
    let root = (nu - 1.0).sqrt() * (nu + 1.0).sqrt();
    let (plus, minus) = (nu + root, nu - root);
    if plus.norm_sqr() >= minus.norm_sqr() { plus } else { minus }
}

impl Meromorphic for OfHalfSum<'_, '_> {
    fn evaluate(&mut self, nu: C) -> Value {
        let z = outer(nu);
        let value = self.0.evaluate(z);
        let by = z * z * 2.0 / (z * z - 1.0);
        let finite = |value: &C| value.re.is_finite() && value.im.is_finite();
        // Of an orbit's own derivative both row and column are divided by z−1, and (z−1)² is 2z(ν−1).
        let slope = if self.0.shift.is_some() { value.slope + z.inv() } else { value.slope };
        let slope = Some(slope * by).filter(finite).unwrap_or(C::new(HUGE, 0.0));
        let modes = self.0.equations.kernel().modes();
        let poles: Vec<C> = modes.iter().map(|mode| (nu - mode.period.even).inv()).filter(finite).collect();
        // z is rounded otherwise than ν, which is felt next to a pole.
        let nearest = poles.iter().map(|pole| pole.norm_sqr()).fold(0.0, f64::max);
        let slope_error = value.slope_error * modulus(by) + 4.0 * f64::EPSILON * modulus(nu) * nearest;
        let slope_error = if slope_error.is_finite() { slope_error } else { 0.0 };
        let poles = poles.into_iter().sum();
        Value { slope, poles, slope_error, ..value }
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_breather::LinearImpact;
    use vibrochain_lattice::BlochKernel;

    use super::super::ImpactSpectrum;
    use super::*;

    /// A fast mode that dies within a period turns thousands of times between impacts: its flights are rounded as often, which moves the
    /// multipliers, though no pole of it is left.
    #[test]
    fn rounding_of_flights_grows_with_their_turns() {
        let period = 4.0;
        let (mut checked, mut felt) = (0, 0);
        for (turns, lapse) in [(1e3, 0.05), (1e4, 0.05), (1e5, 0.03), (1e5, 0.1), (1e6, 0.02)] {
            for (slow, accelerations) in [(0.7, [0.3, -0.2]), (1.9, [0.5, 0.4]), (1.1, [-0.6, 0.1])] {
                let equations = |unit: f64| {
                    let mut kernel = BlochKernel::new(period, 2);
                    kernel.push_oscillator(slow, 0.05, &[1.0, 0.3]);
                    let fast = turns / period * (1.0 + unit * f64::EPSILON);
                    kernel.push_decaying(25.0 / period, fast * fast, &[0.8, -0.9]);
                    let impact = |contact: usize, time: f64, impulse: f64| LinearImpact {
                        contact,
                        time,
                        impulse,
                        restitution: 0.8,
                        acceleration_before: accelerations[contact],
                    };
                    BlochEquations::new(kernel, vec![impact(0, 0.0, 1.1), impact(1, lapse * period, -0.7)])
                };
                let [here, aside] = [0.0, 4.0].map(|unit| ImpactSpectrum::new(&equations(unit)));
                if !(here.is_certified && aside.is_certified) {
                    continue;
                }
                for (z, error) in here.multipliers.iter().zip(&here.errors) {
                    let distance = |(other, of): (&C, &f64)| (modulus(other - z), *of);
                    let nearest = aside.multipliers.iter().zip(&aside.errors).map(distance);
                    let (apart, of) = nearest.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
                    assert!(apart <= 4.0 * (error + of), "{turns} {lapse} {z}: {apart:e} {error:e}");
                    felt += usize::from(apart > 100.0 * f64::EPSILON * modulus(*z));
                    checked += 1;
                }
            }
        }
        assert!(checked >= 40 && felt >= 10, "{checked} {felt}");
    }
}

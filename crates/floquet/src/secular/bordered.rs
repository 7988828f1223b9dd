//! K̂ of words of any sites as a function on circles |z| ≥ 1, however near to its poles.
//!
//! With ζ = ½(z+p)/(z−p), K̂ = Σ ζ b²φφᵀ ⊗ wṽ + conj. + constant. Where the circle is nearer to the poles than they are to each other, the
//! nearest ones, ζ − ½ = 1/(z/p−1), are not added up but border the matrix,
//!
//! ```text
//! 𝓑 = (K̂ without them   u  ),     det 𝓑 = det K̂ · Π(1−z/p),     u ṽᵀ/(z/p−1) what was left out,
//!     (     ṽᵀ        1−z/p)
//! ```
//!
//! which has no poles near.

use std::f64::consts::TAU;
use std::ops::Range;

use nalgebra::{Complex, DMatrix};
use vibrochain_breather::{Condition, Prepared};

use super::error::SecularError;
use super::growth::modulus;
use super::impact_matrix::{FeltMode, ImpactMatrix};

type C = Complex<f64>;

/// Neighbours on either side that border the matrix with the pole that is passed.
const SIDE: usize = 2;

/// Poles whose angles are closer are passed together.
const TOGETHER: f64 = 1e-9;

/// A pole this close to ±1 (a rigid mode, an edge on ω/2) has no side.
const REAL: f64 = 1e-9;

/// Modes of one frequency: one pole and its conjugate.
#[derive(Debug, Clone)]
pub(super) struct Group {
    pole: C,
    ratio: f64,
    /// A norm of what ζ multiplies, and its relative error.
    size: f64,
    relative: f64,
    /// Error of the pole.
    error: f64,
    /// Its modes in the impact matrix.
    pub(super) modes: Range<usize>,
}

/// A pole on the circle: angle, group, whether it is the conjugate.
pub(super) type Pole = (f64, usize, bool);

/// 𝓑 of one orbit; also the work space.
#[derive(Debug, Clone, Default)]
pub(super) struct Bordered {
    pub(super) matrix: ImpactMatrix,
    pub(super) groups: Vec<Group>,
    /// b²φ_iφ_j e^{iΩ(t_i−t_j)} for i ≥ j, real parts and imaginary parts: [group][2][pair].
    parts: Vec<f64>,
    /// What does not depend on z.
    constant: Option<DMatrix<C>>,
    /// By rising angle.
    pub(super) poles: Vec<Pole>,
    /// Those that are passed together.
    pub(super) clusters: Vec<Range<usize>>,
    /// Error of the constant part.
    data: f64,
    /// Of each group: bit 0 for the pole, bit 1 for its conjugate, left out of the sum.
    left_out: Vec<u8>,
    bordering: Vec<(usize, bool)>,
    sums: Vec<f64>,
}

impl Bordered {
    /// Takes over an orbit.
    ///
    /// # Errors
    /// [`SecularError::Coincident`] for a pole at ±1.
    pub(super) fn set(&mut self, prepared: Prepared<'_>, condition: &Condition) -> Result<(), SecularError> {
        self.matrix.set(prepared);
        let (orbit, omega) = (prepared.orbit(), prepared.response().omega());
        let n = self.matrix.impacts;
        let pairs = n * (n + 1) / 2;
        let e = orbit.model().restitution();
        let late = condition.impacts.iter().map(|error| error.time.abs()).fold(0.0, f64::max);
        self.data = orbit
            .impacts()
            .iter()
            .zip(&condition.impacts)
            .zip(&self.matrix.kappas)
            .map(|((impact, error), kappa)| {
                let of_acceleration = error.acceleration / ((1.0 + e) * impact.velocity_before * omega);
                of_acceleration.abs()
                    + (kappa * (error.impulse / impact.impulse)).abs()
                    + 8.0 * f64::EPSILON * kappa.abs()
            })
            .sum();
        self.groups.clear();
        self.parts.clear();
        let (modes, waves) = (&self.matrix.modes, &self.matrix.waves);
        let of_sum = f64::EPSILON * (2.0 * modes.len() as f64).sqrt();
        let mut first = 0;
        for alike in modes.chunk_by(|one, other| one.pole == other.pole && one.frequency == other.frequency) {
            let FeltMode { pole, weight, frequency, ratio, error, .. } = alike[0];
            let range = first..first + alike.len();
            first = range.end;
            let own = &waves[range.start * n..range.end * n];
            let square: f64 = own.iter().map(|wave| wave.norm_sqr()).sum();
            let shape_error = alike.iter().map(|mode| mode.shape_error).fold(0.0, f64::max);
            let phases = f64::EPSILON * (8.0 + 3.0 * frequency * self.matrix.longest) + 2.0 * frequency * late;
            let relative = phases + 2.0 * shape_error + of_sum;
            let start = self.parts.len();
            self.parts.resize(start + 2 * pairs, 0.0);
            let (real, imaginary) = self.parts[start..].split_at_mut(pairs);
            for wave in own.chunks_exact(n) {
                let mut at = 0;
                for i in 0..n {
                    for j in 0..=i {
                        let product = wave[i] * wave[j].conj() * weight;
                        real[at] += product.re;
                        imaginary[at] += product.im;
                        at += 1;
                    }
                }
            }
            let size = weight * square * 0.5 * (ratio + 1.0 / ratio);
            self.groups.push(Group { pole, ratio, size, relative, error, modes: range });
        }
        self.poles.clear();
        for (g, group) in self.groups.iter().enumerate() {
            if group.pole.im.abs() < REAL {
                return Err(SecularError::Coincident { mode: g });
            }
            let angle = group.pole.im.atan2(group.pole.re);
            self.poles.extend([(angle, g, false), (-angle, g, true)]);
        }
        self.poles.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.clusters.clear();
        let mut first = 0;
        for cluster in self.poles.chunk_by(|one, other| other.0 - one.0 < TOGETHER) {
            self.clusters.push(first..first + cluster.len());
            first += cluster.len();
        }
        self.left_out.clear();
        self.left_out.resize(self.groups.len(), 0);
        self.bordering.clear();
        self.set_constant();
        Ok(())
    }

    /// ±½R and what the impacts add.
    fn set_constant(&mut self) {
        let n = self.matrix.impacts;
        let pairs = n * (n + 1) / 2;
        let mut constant = DMatrix::zeros(2 * n, 2 * n);
        let add = |at: &mut C, value: f64| at.re += value;
        for (group, parts) in self.groups.iter().zip(self.parts.chunks_exact(2 * pairs)) {
            let mut at = 0;
            for i in 0..n {
                for j in 0..=i {
                    let (even, odd) = (0.5 * parts[at], 0.5 * parts[pairs + at]);
                    at += 1;
                    if i == j {
                        continue;
                    }
                    for (i, j, even) in [(i, j, even), (j, i, -even)] {
                        add(&mut constant[(2 * i, 2 * j)], even);
                        add(&mut constant[(2 * i + 1, 2 * j + 1)], even);
                        add(&mut constant[(2 * i, 2 * j + 1)], odd / group.ratio);
                        add(&mut constant[(2 * i + 1, 2 * j)], -odd * group.ratio);
                    }
                }
            }
        }
        for i in 0..n {
            add(&mut constant[(2 * i, 2 * i)], self.matrix.half_loss);
            add(&mut constant[(2 * i + 1, 2 * i + 1)], self.matrix.half_loss);
            add(&mut constant[(2 * i + 1, 2 * i)], self.matrix.kappas[i]);
        }
        self.constant = Some(constant);
    }

    /// 𝓑 at a place.
    pub(super) fn evaluate(&mut self, z: C) -> DMatrix<C> {
        let n = self.matrix.impacts;
        let pairs = n * (n + 1) / 2;
        let size = 2 * n;
        self.sums.clear();
        self.sums.resize(12 * pairs, 0.0);
        for ((group, parts), out) in self.groups.iter().zip(self.parts.chunks_exact(2 * pairs)).zip(&self.left_out) {
            let forth = if out & 1 == 0 { zeta(z, group.pole) } else { C::new(0.5, 0.0) };
            let back = if out & 2 == 0 { zeta(z, group.pole.conj()) } else { C::new(0.5, 0.0) };
            let (both, off) = (forth + back, (forth - back) * C::i());
            let (up, down) = (group.ratio, 1.0 / group.ratio);
            let [real, imaginary] = [&parts[..pairs], &parts[pairs..]];
            let factors = [both, off * up, off * down, off, both * up, both * down];
            for (k, (sums, factor)) in self.sums.chunks_exact_mut(2 * pairs).zip(factors).enumerate() {
                let part = if k < 3 { real } else { imaginary };
                let (re, im) = sums.split_at_mut(pairs);
                for ((re, im), part) in re.iter_mut().zip(im).zip(part) {
                    *re += factor.re * part;
                    *im += factor.im * part;
                }
            }
        }
        let bordered = size + self.bordering.iter().map(|&(g, _)| self.groups[g].modes.len()).sum::<usize>();
        let mut out = DMatrix::zeros(bordered, bordered);
        if let Some(constant) = &self.constant {
            out.view_mut((0, 0), (size, size)).copy_from(constant);
        }
        let sum =
            |k: usize, pair: usize| C::new(self.sums[2 * k * pairs + pair], self.sums[(2 * k + 1) * pairs + pair]);
        let mut pair = 0;
        for i in 0..n {
            for j in 0..=i {
                let [even, up, down, even_odd, up_odd, down_odd] = std::array::from_fn(|k| sum(k, pair) * 0.5);
                pair += 1;
                for (i, j, sign) in [(i, j, 1.0), (j, i, -1.0)] {
                    if i == j && sign < 0.0 {
                        continue;
                    }
                    let same = even + even_odd * sign;
                    out[(2 * i, 2 * j)] += same;
                    out[(2 * i + 1, 2 * j + 1)] += same;
                    out[(2 * i, 2 * j + 1)] -= down - down_odd * sign;
                    out[(2 * i + 1, 2 * j)] += up - up_odd * sign;
                }
            }
        }
        let mut row = size;
        for &(g, conjugate) in &self.bordering {
            let group = &self.groups[g];
            let (pole, sign) = if conjugate { (group.pole.conj(), -1.0) } else { (group.pole, 1.0) };
            let (fast, slow) = (C::new(0.0, sign * group.ratio), C::new(0.0, -sign / group.ratio));
            for m in group.modes.clone() {
                let waves = &self.matrix.waves[m * n..(m + 1) * n];
                let square: f64 = waves.iter().map(|wave| wave.norm_sqr()).sum();
                let own = self.matrix.modes[m].weight * square * 0.5 * (group.ratio + 1.0 / group.ratio);
                let (u, v) =
                    ((square * (1.0 + group.ratio.powi(2))).sqrt(), (square * (1.0 + group.ratio.powi(-2))).sqrt());
                for (i, wave) in waves.iter().enumerate() {
                    let wave = if conjugate { wave.conj() } else { *wave };
                    out[(2 * i, row)] = wave / u;
                    out[(2 * i + 1, row)] = wave * fast / u;
                    out[(row, 2 * i)] = wave.conj() / v;
                    out[(row, 2 * i + 1)] = wave.conj() * slow / v;
                }
                out[(row, row)] = (z - pole) * pole.conj() * -own.recip();
                row += 1;
            }
        }
        out
    }

    /// Bounds of ‖d³𝓑/dθ³‖ over a step, and of the errors of 𝓑.
    pub(super) fn bounds(&self, radius: f64, angle: f64, step: f64) -> (f64, f64) {
        let z = C::from_polar(radius, angle);
        let (reach, least) = (radius * step, radius - 1.0);
        let (mut third, mut error) = (0.0, self.data);
        for (group, out) in self.groups.iter().zip(&self.left_out) {
            let mut factor = 0.0;
            let mut shift = 0.0;
            for (bit, pole) in [(1, group.pole), (2, group.pole.conj())] {
                let distance = (modulus(z - pole) - reach).max(least);
                if out & bit != 0 {
                    let dyads = group.modes.len() as f64;
                    third += radius / group.size * dyads;
                    error += dyads * (2.0 * group.relative + radius * group.error / group.size);
                    continue;
                }
                let near = if distance > 0.0 { 1.0 / distance } else { f64::INFINITY };
                let by = radius * near;
                third += group.size * by * near * (6.0 * by * by + 6.0 * by + 1.0);
                factor += radius * near;
                shift += radius * near * near;
            }
            error += group.size * (group.relative * (factor + 2.0) + group.error * shift);
        }
        (third, error)
    }

    /// Whether the circle is nearer to these poles and their neighbours than they are to each other.
    pub(super) fn is_near(&self, radius: f64, passed: usize) -> bool {
        let count = self.clusters.len();
        let angle = |cluster: usize| self.poles[self.clusters[cluster % count].start].0;
        radius - 1.0 < (angle(passed + 1) - angle(passed + count - 1)).rem_euclid(TAU)
    }

    /// Poles that are passed and their neighbours border the matrix, where the circle is near; whether these are others than before.
    pub(super) fn border(&mut self, passed: Option<usize>) -> bool {
        let count = self.clusters.len();
        let mut wanted: Vec<(usize, bool)> = Vec::new();
        for cluster in passed.into_iter().flat_map(|passed| (0..=2 * SIDE).map(move |i| passed + i)) {
            let cluster = self.clusters[(cluster + SIDE * (count - 1)) % count].clone();
            for &(_, g, conjugate) in &self.poles[cluster] {
                if !wanted.contains(&(g, conjugate)) {
                    wanted.push((g, conjugate));
                }
            }
        }
        if wanted == self.bordering {
            return false;
        }
        self.left_out.iter_mut().for_each(|out| *out = 0);
        for &(g, conjugate) in &wanted {
            self.left_out[g] |= if conjugate { 2 } else { 1 };
        }
        self.bordering = wanted;
        true
    }

    /// The sum of the arguments of all 1/(z/p − 1) of the border at an angle from 0 to π, each pole passed on its outer side.
    pub(super) fn of_bordering(&self, radius: f64, angle: f64) -> f64 {
        let argument = |&(g, conjugate): &(usize, bool)| {
            let Group { pole, modes, .. } = &self.groups[g];
            let pole = if conjugate { pole.conj() } else { *pole };
            let off = C::from_polar(radius, angle) * pole.conj() - 1.0;
            let argument = off.im.atan2(off.re);
            let past = angle - pole.im.atan2(pole.re) > 1.0 && argument < 0.0;
            -(argument + if past { TAU } else { 0.0 }) * modes.len() as f64
        };
        self.bordering.iter().map(argument).sum()
    }
}

/// ½(z+p)/(z−p), its real part never below 0 for |z| ≥ 1.
fn zeta(z: C, pole: C) -> C {
    let difference = z - pole;
    (z + pole) * difference.conj() * (0.5 / difference.norm_sqr())
}

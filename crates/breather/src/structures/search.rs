//! All orbits of one impact or two, and those of longer words that starts lead to.
//!
//! Under a load of one harmonic, (c, s) = (cos, sin) of jωψ: impulses, offsets, c and s obey linear equations once the times are given, and
//! c² + s² = 1 is left. Of one impact that is a quadratic equation; of two the zeros of one analytic function of the time between them,
//!
//! ```text
//! F(φ) = Δ²(c² + s² − 1),      Δ the determinant of the linear equations.
//! ```
//!
//! Without loads the positions give the impulses, and one of Newton's laws is left.

use std::f64::consts::TAU;

use smallvec::SmallVec;
use vibrochain_lattice::{Barrier, Complex};

use super::equations::{Equations, Point, Strike};
use super::error::StructureOrbitError;
use super::model::StructureModel;
use super::orbit::StructureOrbit;
use super::two_impacts::Function;
use crate::equations::linear::{Factors, Matrix, Vector, zeros};
use crate::word::Word;

/// Places at which a function of one variable is looked at, for each turn of the fastest mode that counts, and at least and at most.
const PLACES: f64 = 24.0;
const LEAST_PLACES: usize = 240;
const MOST_PLACES: usize = 20_000;

/// Starts of a word of three impacts or more.
const STARTS: usize = 600;

/// Two orbits whose times agree to this part of the period, and impulses to this part of themselves, are one.
const SAME: f64 = 1e-7;

/// What is known of a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(tag = "by", rename_all = "kebab-case"))]
pub enum StructureSearch {
    /// Closed form: the list is complete.
    ClosedForm,
    /// Closed form of instants half a period apart, without loads: others are not looked for.
    HalfPeriod,
    /// Enclosures of a function of one variable show on intervals where it has no zero and that each one found is alone: the list is complete
    /// but for impacts of one contact closer than 1e-4 of the period, and for so many places where two may have merged.
    Enclosures {
        /// Intervals enclosed.
        intervals: usize,
        /// Places left open.
        unresolved: usize,
    },
    /// A function of one variable has been looked at in so many places: what lies between two of them may be missed.
    Scan {
        /// How many.
        places: usize,
    },
    /// Newton's method from so many starts: the list is not complete.
    Starts {
        /// How many.
        starts: usize,
    },
}

/// Orbits of a word.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureFound {
    /// The orbits, physical or not.
    pub orbits: Vec<StructureOrbit>,
    /// How they were sought.
    pub search: StructureSearch,
}

/// All orbits of a word that are found: contacts stand in place of sites. Those of one impact or two are listed with their signs as they are,
/// pulled or not; of longer words only those whose barriers push. An orbit is listed once, whichever impact it begins with, and not where it
/// repeats itself sooner.
///
/// # Errors
/// [`StructureOrbitError`].
pub fn structure_orbits(
    model: &StructureModel,
    word: &Word,
    force_periods: u32,
) -> Result<StructureFound, StructureOrbitError> {
    let mut letters: SmallVec<[(usize, Barrier); 4]> = SmallVec::new();
    for letter in word.letters() {
        model.barrier(letter.site, letter.barrier)?;
        letters.push((letter.site, letter.barrier));
    }
    let equations = Equations::new(model, force_periods, letters.iter().map(|(contact, _)| *contact))?;
    if equations.forced
        && letters.iter().all(|&(contact, _)| equations.swings(contact).all(|(_, swing)| swing.norm() == 0.0))
    {
        return Err(StructureOrbitError::Unfelt);
    }
    if letters.len() > word.instants().len() && (equations.forced || word.instants().len() > 2) {
        return Err(StructureOrbitError::AtOnce);
    }
    if !equations.forced && !model.structure().is_lossless() {
        return Err(StructureOrbitError::LossWithoutLoad);
    }
    let contacts: SmallVec<[usize; 4]> = letters.iter().map(|(contact, _)| *contact).collect();
    equations.off_resonance(&contacts)?;
    let search = Search { equations: &equations, letters };
    let (points, search) = if letters_at_once(word) { search.reversible(word)? } else { search.points()? };
    let mut orbits: Vec<StructureOrbit> = Vec::new();
    for point in points {
        let Ok(solved) = equations.solve(point) else { continue };
        let Ok(orbit) = StructureOrbit::new(&equations, force_periods, solved) else { continue };
        let pulls = orbit.impacts().iter().any(|impact| impact.barrier.sign() * impact.impulse >= 0.0);
        let in_order = letters_at_once(word) || orbit.impacts().windows(2).all(|pair| pair[1].time > pair[0].time);
        let sound = in_order
            && orbit.impacts().last().is_some_and(|last| last.time < orbit.period())
            && !(pulls && matches!(search, StructureSearch::Starts { .. }));
        // An impulse below its own error is none.
        let hits = orbit.impacts().iter().all(|impact| impact.impulse.abs() > impact.impulse_error);
        let new = || !orbits.iter().any(|other| (0..word.letters().count()).any(|turn| is_same(other, &orbit, turn)));
        if sound && hits && !repeats_sooner(&orbit) && new() {
            orbits.push(orbit);
        }
    }
    Ok(StructureFound { orbits, search })
}

/// Whether several contacts are hit at one instant.
fn letters_at_once(word: &Word) -> bool {
    word.letters().count() > word.instants().len()
}

/// Whether the second orbit, begun at its impact number `turn`, is the first one.
fn is_same(a: &StructureOrbit, b: &StructureOrbit, turn: usize) -> bool {
    let (period, n) = (a.period(), b.impacts().len());
    let begins = b.impacts()[turn].time;
    let around = |x: f64, period: f64| x.rem_euclid(period).min((-x).rem_euclid(period));
    let psi = match (a.psi(), b.psi()) {
        (Some(a_psi), Some(b_psi)) => around(a_psi - b_psi - begins, a.model().period()) < SAME * period,
        _ => true,
    };
    psi && (0..n).all(|i| {
        let (own, other) = (&a.impacts()[i], &b.impacts()[(i + turn) % n]);
        let close = (own.impulse - other.impulse).abs() < SAME * own.impulse.abs().max(other.impulse.abs());
        own.contact == other.contact
            && own.barrier == other.barrier
            && around(own.time - (other.time - begins), period) < SAME * period
            && close
    })
}

/// Whether an orbit is one of fewer periods, gone through several times.
fn repeats_sooner(orbit: &StructureOrbit) -> bool {
    let (n, periods) = (orbit.impacts().len(), orbit.force_periods() as usize);
    // Without loads any part of the period may be one.
    let parts = |part: usize| n.is_multiple_of(part) && (orbit.psi().is_none() || periods.is_multiple_of(part));
    (2..=n).filter(|&part| parts(part)).any(|part| {
        let shift = n / part;
        let lapse = orbit.period() / part as f64;
        (0..n).all(|i| {
            let (own, other) = (&orbit.impacts()[i], &orbit.impacts()[(i + shift) % n]);
            let later = other.time + if i + shift >= n { orbit.period() } else { 0.0 };
            own.contact == other.contact
                && own.barrier == other.barrier
                && (later - own.time - lapse).abs() < SAME * orbit.period()
                && (own.impulse - other.impulse).abs() < SAME * own.impulse.abs()
        })
    })
}

impl Equations<'_> {
    /// The same point with offsets that bring the impacts to their barriers as well as they can.
    pub(super) fn with_offsets(&self, mut point: Point) -> Result<Point, StructureOrbitError> {
        if self.rigid.is_empty() {
            return Ok(point);
        }
        let system = self.system(&point)?;
        let count = self.rigid.len();
        let shape = |k: usize, i: usize| Self::shape(self.rigid[k], point.strikes[i].contact);
        let matrix = Matrix::from_fn(count, |k, l| (0..point.strikes.len()).map(|i| shape(k, i) * shape(l, i)).sum());
        let right: Vector =
            (0..count).map(|k| (0..point.strikes.len()).map(|i| -shape(k, i) * system.rows[i]).sum()).collect();
        let moves = matrix.solve(&right).ok_or(StructureOrbitError::Unbalanced)?;
        point.offsets.iter_mut().zip(&moves).for_each(|(offset, by)| *offset += by);
        Ok(point)
    }
}

struct Search<'a> {
    equations: &'a Equations<'a>,
    letters: SmallVec<[(usize, Barrier); 4]>,
}

impl Search<'_> {
    fn points(&self) -> Result<(Vec<Point>, StructureSearch), StructureOrbitError> {
        let n = self.letters.len();
        let single = self.equations.single().is_some();
        match (n, self.equations.forced) {
            (1, true) if single => Ok((self.on_a_line(&[0.0])?, StructureSearch::ClosedForm)),
            (1, false) => {
                let x = self.linear(&[0.0])?.solve().ok_or(StructureOrbitError::Singular)?;
                Ok((vec![self.point(&[0.0], &x)], StructureSearch::ClosedForm))
            }
            (2, true) if single => self.proved().unwrap_or_else(|| self.scan()),
            (2, false) => self.scan(),
            _ => self.starts(),
        }
    }

    /// The linear equations of impulses, offsets and, under a load, (c, s), at given times.
    fn linear(&self, times: &[f64]) -> Result<Linear, StructureOrbitError> {
        let equations = self.equations;
        let (n, rigid) = (times.len(), equations.rigid.len());
        let load = equations.single();
        // Positions, balances and, under a load, Newton's laws.
        let rows = n + rigid + if load.is_some() { n } else { 0 };
        let columns = n + rigid + if load.is_some() { 2 } else { 0 };
        let mut linear = Linear { columns, rows: Vec::with_capacity(rows), right: Vector::new(), laws: Vec::new() };
        let mut laws = Vec::new();
        for (i, &(contact, barrier)) in self.letters.iter().enumerate() {
            let (mut place, mut law) = (zeros(columns), zeros(columns));
            let weight = 1.0 + equations.restitution(contact);
            for (j, &(other, _)) in self.letters.iter().enumerate() {
                let lapse = if i == j { 0.0 } else { times[i] - times[j] };
                let (jet, _) = equations.kernel.jet(contact, other, lapse);
                (place[j], law[j]) = (jet[0], weight * jet[1]);
            }
            law[i] += equations.mobility(contact);
            for (k, mode) in equations.rigid.iter().enumerate() {
                place[n + k] = Equations::shape(mode, contact);
            }
            if let Some((rate, swing)) = load {
                let there = swing[contact] * Complex::from_polar(1.0, rate * times[i]);
                let speed = there * Complex::new(0.0, rate) * weight;
                (place[n + rigid], place[n + rigid + 1]) = (there.re, -there.im);
                (law[n + rigid], law[n + rigid + 1]) = (speed.re, -speed.im);
            }
            linear.rows.push(place);
            linear.right.push(equations.model.barrier(contact, barrier)? - equations.still(contact));
            laws.push(law);
        }
        for mode in &equations.rigid {
            let mut row = zeros(columns);
            for (j, &(contact, _)) in self.letters.iter().enumerate() {
                row[j] = Equations::shape(mode, contact);
            }
            linear.rows.push(row);
            linear.right.push(-Equations::push(mode) * equations.period());
        }
        if load.is_some() {
            for law in laws {
                linear.rows.push(law);
                linear.right.push(0.0);
            }
        } else {
            linear.laws = laws;
        }
        Ok(linear)
    }

    /// The point of a solution of the linear equations.
    fn point(&self, times: &[f64], x: &[f64]) -> Point {
        let (n, rigid) = (times.len(), self.equations.rigid.len());
        let strikes = self.letters.iter().zip(times).zip(x).map(|((&(contact, barrier), &time), &impulse)| Strike {
            contact,
            barrier,
            time,
            impulse,
        });
        let psi = match self.equations.single() {
            Some((rate, _)) => x[n + rigid + 1].atan2(x[n + rigid]) / rate,
            None => 0.0,
        };
        Point { strikes: strikes.collect(), psi, offsets: x[n..n + rigid].iter().copied().collect() }
    }

    /// Without loads, instants half a period apart: by reversal of time Newton's laws hold, and positions give the impulses.
    fn reversible(&self, word: &Word) -> Result<(Vec<Point>, StructureSearch), StructureOrbitError> {
        let period = self.equations.period();
        let times: Vec<f64> = (word.instants().iter().enumerate())
            .flat_map(|(number, instant)| instant.iter().map(move |_| 0.5 * period * number as f64))
            .collect();
        let x = self.linear(&times)?.solve().ok_or(StructureOrbitError::Singular)?;
        let search = if word.instants().len() == 1 { StructureSearch::ClosedForm } else { StructureSearch::HalfPeriod };
        Ok((vec![self.point(&times, &x)], search))
    }

    /// Both phases where the equations leave a line of (c, s), which meets the circle: of one impact; and of two half a period apart where
    /// what the second one asks is what the first one does.
    fn on_a_line(&self, times: &[f64]) -> Result<Vec<Point>, StructureOrbitError> {
        let mut linear = self.linear(times)?;
        let size = linear.columns;
        linear.rows.truncate(size - 1);
        linear.right.truncate(size - 1);
        // (c, s) along a direction in which the equations determine the rest best.
        let best = [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(a, b)| {
            let mut bordered = linear.clone();
            let mut row = zeros(size);
            (row[size - 2], row[size - 1]) = (a, b);
            bordered.rows.push(row);
            bordered.right.push(0.0);
            let determinant = Factors::new(bordered.matrix()).map_or(0.0, |factors| factors.determinant.abs());
            (determinant, bordered)
        });
        let Some((_, mut bordered)) = best.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)) else {
            return Ok(Vec::new());
        };
        let Some(base) = bordered.solve() else { return Ok(Vec::new()) };
        if let Some(last) = bordered.right.last_mut() {
            *last = 1.0;
        }
        let Some(moved) = bordered.solve() else { return Ok(Vec::new()) };
        let along: Vector = moved.iter().zip(&base).map(|(a, b)| a - b).collect();
        // |(c, s)|² = 1 on base + τ·along
        let [c, s] = [size - 2, size - 1].map(|place| (base[place], along[place]));
        let (square, half, rest) = (c.1 * c.1 + s.1 * s.1, c.0 * c.1 + s.0 * s.1, c.0 * c.0 + s.0 * s.0 - 1.0);
        let under = half * half - square * rest;
        if under < 0.0 || square == 0.0 {
            return Ok(Vec::new());
        }
        let far = -(half + under.sqrt().copysign(half));
        let roots = [far / square, if far == 0.0 { 0.0 } else { rest / far }];
        let at = |tau: f64| base.iter().zip(&along).map(|(base, along)| base + tau * along).collect::<Vector>();
        Ok(roots.into_iter().map(|tau| self.point(times, &at(tau))).collect())
    }

    /// Zeros of the function of the time between two impacts, all of them; `None` where it cannot be enclosed, or takes too long.
    fn proved(&self) -> Option<Result<(Vec<Point>, StructureSearch), StructureOrbitError>> {
        let contacts = [self.letters[0].0, self.letters[1].0];
        let place = |i: usize| {
            let (contact, barrier) = self.letters[i];
            Some(self.equations.model.barrier(contact, barrier).ok()? - self.equations.still(contact))
        };
        let function = Function::new(self.equations, contacts, [place(0)?, place(1)?])?;
        let zeros = function.zeros();
        if zeros.exhausted > 0 {
            return None;
        }
        let half = 0.5 * self.equations.period();
        let unresolved = zeros.unresolved.iter().filter(|phi| (*phi - half).abs() > SAME * half).count();
        let mut unresolved = unresolved;
        let mut points = || -> Result<Vec<Point>, StructureOrbitError> {
            // A structure that is its own mirror image has a double zero there.
            let mut points = self.on_a_line(&[0.0, half])?;
            for phi in &zeros.simple {
                let here = if function.is_homogeneous() {
                    self.on_a_line(&[0.0, *phi])?
                } else {
                    self.linear(&[0.0, *phi])?.solve().map(|x| self.point(&[0.0, *phi], &x)).into_iter().collect()
                };
                // A zero whose orbit is not reached is told, not dropped.
                if here.is_empty() || here.iter().any(|point| self.equations.solve(point.clone()).is_err()) {
                    unresolved += 1;
                }
                points.extend(here);
            }
            for phi in &zeros.unresolved {
                points.extend(self.on_a_line(&[0.0, *phi])?);
                points.extend(self.linear(&[0.0, *phi])?.solve().map(|x| self.point(&[0.0, *phi], &x)));
            }
            Ok(points)
        };
        let found = points();
        let search = StructureSearch::Enclosures { intervals: zeros.intervals, unresolved };
        Some(found.map(|points| (points, search)))
    }

    /// Zeros of the function of the time between two impacts, by its values in many places.
    fn scan(&self) -> Result<(Vec<Point>, StructureSearch), StructureOrbitError> {
        let period = self.equations.period();
        let felt = |(rate, size): (f64, f64)| if size > 0.0 { rate } else { 0.0 };
        let modes = self.equations.model.structure().modes();
        let fastest = modes.iter().map(|mode| {
            let size: f64 = self
                .letters
                .iter()
                .map(|&(contact, _)| mode.rows[contact][0].abs() + mode.rows[contact][1].abs())
                .sum();
            felt((mode.rate, size))
        });
        let fastest = fastest.fold(self.equations.model.omega(), f64::max);
        let places = ((PLACES * fastest * period / TAU) as usize).clamp(LEAST_PLACES, MOST_PLACES);
        let at = |phi: f64| self.value(phi).map(|value| value[0]);
        let both: Vec<(f64, [f64; 2])> = (1..places)
            .map(|i| period * i as f64 / places as f64)
            .map(|phi| Ok((phi, self.value(phi)?)))
            .collect::<Result<_, StructureOrbitError>>()?;
        let grid: Vec<(f64, f64)> = both.iter().map(|&(phi, [value, _])| (phi, value)).collect();
        let mut zeros_found = Vec::new();
        for pair in grid.windows(2) {
            let [(a, left), (b, right)] = [pair[0], pair[1]];
            if left == 0.0 {
                zeros_found.push(a);
            } else if left * right < 0.0 {
                zeros_found.push(closed_in(|phi| at(phi).unwrap_or(f64::NAN), (a, left), (b, right)));
            }
        }
        // A structure that is its own mirror image: there F has a double zero, and no sign changes.
        let mut points = if self.equations.forced { self.on_a_line(&[0.0, 0.5 * period])? } else { Vec::new() };
        // Where Δ = 0, F is a sum of squares: between two places with F < 0 that is a pair of zeros, or of all barriers at the rest
        // position a double one, with F = −Δ² all around.
        for pair in both.windows(2) {
            let [(a, [left, first]), (b, [right, last])] = [pair[0], pair[1]];
            if self.equations.forced && left < 0.0 && right < 0.0 && first * last < 0.0 {
                let determinant = |phi: f64| self.value(phi).map_or(f64::NAN, |value| value[1]);
                let place = closed_in(determinant, (a, first), (b, last));
                points.extend(self.on_a_line(&[0.0, place])?);
                let value = at(place)?;
                if value > 0.0 {
                    for end in [(a, left), (b, right)] {
                        zeros_found.push(closed_in(|phi| at(phi).unwrap_or(f64::NAN), end, (place, value)));
                    }
                }
            }
        }
        for three in grid.windows(3) {
            // Two zeros between two places show as a dip.
            let [left, middle, right] = [three[0].1, three[1].1, three[2].1];
            if left * middle > 0.0 && middle * right > 0.0 && middle.abs() < left.abs() && middle.abs() < right.abs() {
                // With its sign: |F| itself is least at either zero, where rounding alone decides on which side.
                let signed = |phi: f64| at(phi).map_or(f64::NAN, |value| value * middle.signum());
                let turn = lowest(signed, three[0].0, three[2].0);
                let value = at(turn)?;
                if value * middle <= 0.0 {
                    for end in [three[0], three[2]] {
                        zeros_found.push(closed_in(|phi| at(phi).unwrap_or(f64::NAN), end, (turn, value)));
                    }
                }
            }
        }
        for phi in zeros_found {
            if let Some(x) = self.linear(&[0.0, phi])?.solve() {
                points.push(self.point(&[0.0, phi], &x));
            }
        }
        Ok((points, StructureSearch::Scan { places }))
    }

    /// F(φ), or the law that is left times the determinant; and the determinant Δ.
    fn value(&self, phi: f64) -> Result<[f64; 2], StructureOrbitError> {
        let linear = self.linear(&[0.0, phi])?;
        let Some(factors) = Factors::new(linear.matrix()) else { return Ok([0.0; 2]) };
        let (x, scale) = (factors.solve(&linear.right), factors.determinant);
        let value = if self.equations.forced {
            let (c, s) = (x[linear.columns - 2] * scale, x[linear.columns - 1] * scale);
            c * c + s * s - scale * scale
        } else {
            linear.laws[1].iter().zip(&x).map(|(law, x)| law * x).sum::<f64>() * scale
        };
        Ok([value, scale])
    }

    /// Starts spread over times and phase, with impulses that fit them.
    fn starts(&self) -> Result<(Vec<Point>, StructureSearch), StructureOrbitError> {
        let (n, period) = (self.letters.len(), self.equations.period());
        let mut points = Vec::with_capacity(STARTS);
        for number in 0..STARTS {
            // Additive recurrence by roots of the golden kind: even in all dimensions.
            let spread = |axis: usize| (0.5 + (number + 1) as f64 * golden(axis, n + 1)).fract();
            let mut times: Vec<f64> = (1..n).map(|axis| period * spread(axis)).collect();
            times.push(0.0);
            times.sort_by(f64::total_cmp);
            let psi = self.equations.model.period() * spread(0);
            points.extend(self.start(&times, psi)?);
        }
        Ok((points, StructureSearch::Starts { starts: STARTS }))
    }

    /// Impulses by Newton's laws at given times and phase, offsets by the positions.
    fn start(&self, times: &[f64], psi: f64) -> Result<Option<Point>, StructureOrbitError> {
        let n = times.len();
        let strikes = self.letters.iter().zip(times).map(|(&(contact, barrier), &time)| Strike {
            contact,
            barrier,
            time,
            impulse: 0.0,
        });
        let offsets = smallvec::smallvec![0.0; self.equations.rigid.len()];
        let mut point = Point { strikes: strikes.collect(), psi, offsets };
        let mut law = Matrix::zeros(n);
        let mut right = zeros(n);
        for (i, strike) in point.strikes.iter().enumerate() {
            let weight = 1.0 + self.equations.restitution(strike.contact);
            let load = self.equations.load(strike.contact, strike.time + psi);
            right[i] = if self.equations.forced {
                -weight * load[1]
            } else {
                self.equations.model.barrier(strike.contact, strike.barrier)? - self.equations.still(strike.contact)
            };
            for (j, other) in point.strikes.iter().enumerate() {
                let lapse = if i == j { 0.0 } else { strike.time - other.time };
                let (jet, _) = self.equations.kernel.jet(strike.contact, other.contact, lapse);
                law[(i, j)] = if self.equations.forced { weight * jet[1] } else { jet[0] };
            }
            if self.equations.forced {
                law[(i, i)] += self.equations.mobility(strike.contact);
            }
        }
        let Some(impulses) = law.solve(&right) else { return Ok(None) };
        point.strikes.iter_mut().zip(&impulses).for_each(|(strike, impulse)| strike.impulse = *impulse);
        // A start that pulls leads to orbits that do.
        if point.strikes.iter().any(|strike| strike.barrier.sign() * strike.impulse > 0.0) {
            return Ok(None);
        }
        self.equations.with_offsets(point).map(Some)
    }
}

/// Linear equations, square or one short, and Newton's laws where these are left over.
#[derive(Debug, Clone)]
struct Linear {
    columns: usize,
    rows: Vec<Vector>,
    right: Vector,
    laws: Vec<Vector>,
}

impl Linear {
    fn matrix(&self) -> Matrix {
        Matrix::from_fn(self.columns, |i, j| self.rows[i][j])
    }

    fn solve(&self) -> Option<Vector> {
        self.matrix().solve(&self.right)
    }
}

/// The zero between two places of other signs, by halving and secants (Illinois).
fn closed_in(f: impl Fn(f64) -> f64, (mut a, mut left): (f64, f64), (mut b, mut right): (f64, f64)) -> f64 {
    for _ in 0..200 {
        let middle = if right == left { 0.5 * (a + b) } else { (a * right - b * left) / (right - left) };
        if (b - a).abs() <= 4.0 * f64::EPSILON * b.abs() {
            return middle;
        }
        let value = f(middle);
        if value == 0.0 {
            return middle;
        }
        if value * right < 0.0 {
            (a, left) = (b, right);
        } else {
            left *= 0.5;
        }
        (b, right) = (middle, value);
    }
    0.5 * (a + b)
}

/// Where a function is least between two places, by golden sections.
fn lowest(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let (mut x, mut y) = (b - golden * (b - a), a + golden * (b - a));
    let (mut at_x, mut at_y) = (f(x), f(y));
    for _ in 0..60 {
        if at_x < at_y {
            (b, y, at_y) = (y, x, at_x);
            x = b - golden * (b - a);
            at_x = f(x);
        } else {
            (a, x, at_x) = (x, y, at_y);
            y = a + golden * (b - a);
            at_y = f(y);
        }
    }
    0.5 * (a + b)
}

/// Powers of the inverse of the root of x^{d+1} = x + 1.
fn golden(axis: usize, dimensions: usize) -> f64 {
    let mut root: f64 = 2.0;
    for _ in 0..30 {
        root = (1.0 + root).powf(1.0 / (dimensions as f64 + 1.0));
    }
    root.powi(-(axis as i32 + 1))
}

//! What vanishes at an event of an orbit of a structure.
//!
//! det J(z₀) vanishes where z₀ is a multiplier, on grazing orbits like elsewhere: with the sign of the impulses it goes smoothly on where one
//! of them vanishes, so that nothing here knows of the square root that maps of such orbits have.

use nalgebra::Complex;
use smallvec::{SmallVec, smallvec};
use vibrochain_breather::system::{Evaluation, Vector};
use vibrochain_breather::{BlochEquations, BranchError, StructureMotion, StructureOrbit};
use vibrochain_lattice::Barrier;

use crate::linear::{determinant, moved_by};
use crate::locate::Event;

type C = Complex<f64>;

/// A mode's poles farther from a multiplier than this leave its size alone.
const NEAR: f64 = 0.05;

/// Rounding of an entry, with room for the few operations that it takes.
const ENTRY: f64 = 4.0 * f64::EPSILON;

/// Values of a test function.
pub(super) type Values = SmallVec<[f64; 2]>;

/// Of an event what vanishes there, in unknowns of the orbit and perhaps one more, its mark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Test {
    /// det J(1) of the orbit's own equations: a multiplier +1, where the branch turns back or another leaves it.
    One,
    /// det J(1) without the orbit's own derivative, of one that may begin at any time: another multiplier +1, as where its energy is extreme.
    AnotherOne,
    /// det J(−1)
    MinusOne,
    /// det J(e^{iθ}), which is complex; the mark is θ.
    Circle,
    /// The same and its derivative by θ, of an orbit without losses, where it is real; the mark is θ.
    Collision,
    /// The velocity before an impact.
    Velocity(usize),
    /// The distance of a contact to a barrier where it turns round; the mark is when, in periods.
    Touch(usize, Barrier),
}

impl Test {
    /// Of an event as it is known by a mark.
    pub(super) fn event(self, turns: bool) -> Event {
        match self {
            Self::One if turns => Event::Fold,
            Self::One | Self::AnotherOne => Event::Pitchfork,
            Self::MinusOne => Event::PeriodDoubling,
            Self::Circle | Self::Collision => Event::NeimarkSacker,
            Self::Velocity(_) | Self::Touch(..) => Event::Grazing,
        }
    }

    /// Whether it has a mark.
    pub(super) fn is_marked(self) -> bool {
        matches!(self, Self::Circle | Self::Collision | Self::Touch(..))
    }

    /// Its values at an orbit, each over a size of its own.
    pub(super) fn values(
        self,
        here: &Evaluation<StructureOrbit, Vector>,
        mark: Option<f64>,
    ) -> Result<Values, BranchError> {
        let (orbit, mark) = (&here.orbit, mark.unwrap_or(0.0));
        Ok(match self {
            Self::One => smallvec![here.full_determinant],
            Self::AnotherOne => smallvec![another_one(orbit).ok_or(BranchError::NoConvergence)?],
            Self::MinusOne => smallvec![minus_one(orbit)],
            Self::Circle => {
                let [value, _] = at(orbit, &orbit.bloch_equations().0, mark);
                smallvec![value.re, value.im]
            }
            Self::Collision => {
                let [value, slope] = at(orbit, &orbit.bloch_equations().0, mark);
                smallvec![value.re, slope.re]
            }
            Self::Velocity(i) => {
                let impact = orbit.impacts().get(i).ok_or(BranchError::NoConvergence)?;
                smallvec![impact.velocity_before / speed(orbit)]
            }
            Self::Touch(contact, barrier) => {
                let wall = orbit.model().barrier(contact, barrier)?;
                let [place, velocity] = place(orbit, contact, mark)?;
                let speed = speed(orbit);
                smallvec![(wall - place) * orbit.model().omega() / speed, velocity / speed]
            }
        })
    }
}

/// det J(−1), which is real, made regular.
pub(super) fn minus_one(orbit: &StructureOrbit) -> f64 {
    at(orbit, &orbit.bloch_equations().0, std::f64::consts::PI)[0].re
}

/// det J(1) without the orbit's own derivative; `None` of orbits that have a phase, and where a mode's pole is 1.
pub(super) fn another_one(orbit: &StructureOrbit) -> Option<f64> {
    if !orbit.is_conservative() {
        return None;
    }
    Some(of_another_one(orbit)?.values()[0].re)
}

/// What vanishes there.
pub(super) fn of_another_one(orbit: &StructureOrbit) -> Option<Regular> {
    let (equations, _) = orbit.bloch_equations().0.without_shift()?;
    Some(Regular::of(orbit, &equations, 0.0))
}

/// det J(e^{iθ}) made regular, and its derivative by θ where it vanishes. Both are real without losses.
fn at(orbit: &StructureOrbit, equations: &BlochEquations, theta: f64) -> [C; 2] {
    Regular::of(orbit, equations, theta).values()
}

/// J(e^{iθ}) and its derivative by θ, and what makes its determinant regular.
///
/// Rows are divided by the lengths they would have without resonance; each mode's poles p are taken away by (z−p₁)(z−p₂)/z, over its size
/// where z is far from them; and columns are measured by impulses, whose signs are taken away.
pub(super) struct Regular {
    size: usize,
    matrix: Vec<C>,
    slopes: Vec<C>,
    /// Of the entries.
    errors: Vec<f64>,
    factor: C,
}

impl Regular {
    pub(super) fn of(orbit: &StructureOrbit, equations: &BlochEquations, theta: f64) -> Self {
        let z = if theta == std::f64::consts::PI { C::new(-1.0, 0.0) } else { C::from_polar(1.0, theta) };
        let (size, modes) = (equations.size(), equations.kernel().modes());
        let (mut matrix, mut slopes) = (Vec::new(), Vec::new());
        equations.fill(z, &mut matrix, Some(&mut slopes));
        let mut terms: Vec<f64> = equations.constant(false).iter().map(|entry| entry.abs()).collect();
        let mut errors: Vec<f64> = terms.iter().map(|term| ENTRY * term).collect();
        let mut factor = C::new(orbit.impacts().iter().map(|impact| impact.impulse.signum()).product(), 0.0);
        for (k, mode) in modes.iter().enumerate() {
            let (rows, columns) = (equations.rows(k), equations.columns(k));
            let [one, other] = mode.poles();
            let away = (z - one) * (z - other) / z;
            factor *= away / away.norm().hypot(NEAR);
            // Sums of the past have 1/(z−p), and its error is that of the pole.
            let near = (z - one).norm().min((z - other).norm()).recip().max(1.0);
            let relative = near * (ENTRY * (1.0 + (mode.rate + mode.decay.abs()) * equations.kernel().period()));
            let error = relative + near * (mode.shape_error + mode.pole_error * near);
            for (i, row) in rows.iter().enumerate() {
                for (j, column) in columns.iter().enumerate() {
                    let reach = mode.coordinates.reach(*row, *column);
                    terms[i * size + j] += reach;
                    errors[i * size + j] += error * reach;
                }
            }
        }
        for (i, terms) in terms.chunks(size).enumerate() {
            let length = terms.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
            let own = i * size..(i + 1) * size;
            matrix[own.clone()].iter_mut().for_each(|entry| *entry /= length);
            // dz/dθ = iz
            slopes[own.clone()].iter_mut().for_each(|entry| *entry *= C::i() * z / length);
            errors[own].iter_mut().for_each(|error| *error /= length);
        }
        Self { size, matrix, slopes, errors, factor }
    }

    /// The determinant and its derivative where it vanishes.
    fn values(mut self) -> [C; 2] {
        let size = self.size;
        let slope: C = (0..size)
            .map(|i| {
                let mut one = self.matrix.clone();
                one[i * size..(i + 1) * size].copy_from_slice(&self.slopes[i * size..(i + 1) * size]);
                determinant(&mut one, size)
            })
            .sum();
        [determinant(&mut self.matrix, size) * self.factor, slope * self.factor]
    }

    /// What rounding does to the determinant.
    pub(super) fn rounding(mut self) -> f64 {
        moved_by(&mut self.matrix, &self.errors, self.size) * self.factor.norm()
    }
}

/// How fast contacts of an orbit are: what velocities are measured by.
pub(super) fn speed(orbit: &StructureOrbit) -> f64 {
    let omega = orbit.model().omega();
    let of = orbit.impacts().iter().map(|one| one.velocity_before.abs().max(one.acceleration_before.abs() / omega));
    of.fold(f64::MIN_POSITIVE, f64::max)
}

/// Place and velocity of a contact at a part of the period.
fn place(orbit: &StructureOrbit, contact: usize, part: f64) -> Result<[f64; 2], BranchError> {
    let motion = StructureMotion::new(orbit)?;
    let (impacts, period) = (orbit.impacts(), orbit.period());
    let time = part.rem_euclid(1.0) * period;
    let last = impacts.iter().rposition(|impact| impact.time <= time).unwrap_or(impacts.len() - 1);
    let since = (time - impacts[last].time).rem_euclid(period);
    let [place, velocity, _] = motion.contact(contact, last, since);
    Ok([place, velocity])
}

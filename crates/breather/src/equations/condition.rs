//! How far an orbit can be trusted: its distance to the places where its equations lose their grip, and the errors of
//! its impulses, times and accelerations that follow from there.
//!
//! Errors δF of the terms of the equations (`equations`) pass through the inverse of the Jacobian. Those of a mode's
//! amplitude 1/(2 sin Ω_kT/2), which next to a resonance are by far the largest, are common to all terms of that mode and
//! are carried as one; the rest is taken with the worst signs, |δx| ≤ |J⁻¹| δF. Masses without coupling have equations that know of no
//! resonance (`flights`).

use smallvec::SmallVec;
use vibrochain_lattice::{ImpulseResponse, KernelJet, WaveTerm};

use crate::equations::flights::Flights;
use crate::equations::linear::{Vector, dot, zeros};
use crate::equations::unknowns::Unknowns;
use crate::equations::{Equations, Errors, System, UNIT};
use crate::motion::Motion;
use crate::orbit::{Impact, Orbit};
use crate::worse;

/// Estimated absolute errors of an impact. Dimensionless, like what they are errors of.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ImpactError {
    /// Of its time.
    pub time: f64,
    /// Of its impulse.
    pub impulse: f64,
    /// Of the acceleration there.
    pub acceleration: f64,
}

/// Errors of one origin: what it does to each impact, with signs.
pub type Together = SmallVec<[ImpactError; 2]>;

/// How well an orbit is determined: distances to resonance and grazing, the conditioning of its equations, and the errors that
/// follow. Dimensionless.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[must_use]
pub struct Condition {
    /// Distance to resonance: the smallest |Ω_k − jω|/Ω_k over modes and harmonics j ≥ 1, at most 1; ω is the orbit's base
    /// frequency. So many digits of the kernels are lost as this has zeros.
    pub resonance: f64,
    /// Distance to grazing: the smallest velocity before an impact, in units of the force's ω times half the gap. Saltation grows
    /// like its inverse.
    pub grazing: f64,
    /// Reciprocal condition number of the orbit's equations, rows and columns scaled: at most 1, and 0 at a fold or a pitchfork,
    /// but no distance to either. For a mirror-symmetric conservative orbit, whose times are fixed, of the equations for its impulses alone.
    pub fold: f64,
    /// Estimated error of the force's phase ψ, as a time; 0 without force.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub psi_error: f64,
    /// Estimated errors of the impacts.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub impacts: SmallVec<[ImpactError; 2]>,
    /// The same by origin: what depends on several data of the orbit moves by the sum over these of the moduli, and hardly at all
    /// where the errors of one origin cancel.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub origins: Vec<Together>,
}

impl Condition {
    /// Largest error of an impulse, relative to the largest impulse.
    pub fn impulse_error(&self, orbit: &Orbit) -> f64 {
        let largest = orbit.impacts().iter().map(|impact| impact.impulse.abs()).fold(f64::MIN_POSITIVE, f64::max);
        self.impacts.iter().map(|error| error.impulse).fold(0.0, worse) / largest
    }

    /// Largest error of a time relative to the period of the orbit, or of the phase relative to that of the force.
    pub fn time_error(&self, orbit: &Orbit) -> f64 {
        let phase = self.psi_error / orbit.model().period();
        self.impacts.iter().map(|error| error.time / orbit.period()).fold(phase, worse)
    }

    pub(crate) fn of(orbit: &Orbit, response: &ImpulseResponse, motion: &mut Motion) -> Self {
        let omega = orbit.model().omega();
        let grazing = orbit.impacts().iter().map(|impact| impact.velocity_before.abs()).fold(f64::INFINITY, f64::min);
        let mut condition = Self {
            resonance: 1.0 / response.condition(),
            grazing: grazing / omega,
            fold: 0.0,
            psi_error: 0.0,
            impacts: orbit.impacts().iter().map(|_| ImpactError::default()).collect(),
            origins: Vec::new(),
        };
        if let Some(flights) = Flights::of(orbit) {
            condition.by_flights(orbit, &flights);
            return condition;
        }
        let equations = Equations::new(orbit, response);
        let (unknowns, system) = (equations.unknowns, equations.system());
        condition.fold = system.reciprocal_condition;
        if condition.fold == 0.0 {
            condition.lose_all();
            return condition;
        }
        let errors = equations.row_errors(Errors::WithoutAmplitudes);
        let gradients: SmallVec<[Vector; 2]> =
            (0..orbit.impacts().len()).map(|i| equations.acceleration_gradient(i)).collect();
        for (i, gradient) in gradients.iter().enumerate() {
            let acceleration = equations.acceleration_rounding(i, motion);
            condition.apart(i, ImpactError { acceleration, ..ImpactError::default() });
            condition.impacts[i].acceleration = acceleration + system.through(gradient, &errors);
        }
        condition.take(&equations, &system, &system.spread(&errors));
        for (row, error) in errors.iter().enumerate().filter(|(_, error)| **error > 0.0) {
            let mut rows = zeros(errors.len());
            rows[row] = *error;
            let moved = system.solve(&rows);
            let carried = gradients.iter().map(|gradient| dot(gradient, &moved));
            condition.origins.push(together(&unknowns, &moved, carried));
        }
        equations.amplitudes(&system, &gradients, &mut condition);
        for i in 1..condition.impacts.len() {
            // A time that symmetry fixes is rounded, too.
            let time = f64::EPSILON * orbit.period();
            condition.impacts[i].time += time;
            condition.apart(i, ImpactError { time, ..ImpactError::default() });
        }
        condition
    }

    /// An error of one impact that no other one shares.
    fn apart(&mut self, i: usize, error: ImpactError) {
        let mut origin: Together = self.impacts.iter().map(|_| ImpactError::default()).collect();
        origin[i] = error;
        self.origins.push(origin);
    }

    /// Errors of an orbit without coupling.
    fn by_flights(&mut self, orbit: &Orbit, flights: &Flights) {
        let (model, system) = (orbit.model(), &flights.system);
        self.fold = system.reciprocal_condition;
        if self.fold == 0.0 {
            self.lose_all();
            return;
        }
        let (force, stiffness) = (model.force_wave(), model.chain().gamma1());
        let jets: SmallVec<[[f64; 4]; 2]> =
            orbit.impacts().iter().map(|impact| force.jet(impact.time + orbit.psi_or_zero())).collect();
        for (row, left) in flights.left.iter().enumerate() {
            let mut rows = zeros(flights.left.len());
            rows[row] = *left;
            let moved = system.solve(&rows);
            let psi = moved[flights.psi()];
            let time = |i: usize| flights.time(i).map_or(0.0, |place| moved[place]);
            let error = |(i, jet): (usize, &[f64; 4])| {
                // At a barrier the spring's force is known.
                ImpactError { time: time(i), impulse: moved[i], acceleration: jet[1] * (psi + time(i)) }
            };
            self.origins.push(jets.iter().enumerate().map(error).collect());
            self.psi_error += psi.abs();
        }
        self.psi_error += UNIT * model.period();
        for (i, (impact, jet)) in orbit.impacts().iter().zip(&jets).enumerate() {
            let pull = stiffness * model.barrier(impact.barrier);
            let turned = impact.time.abs() + orbit.psi_or_zero().abs();
            let rounding = UNIT * (pull.abs() + force.bound(0) + turned * force.bound(1));
            let off = (impact.acceleration - (jet[0] - pull)).abs();
            self.apart(i, ImpactError { acceleration: off + rounding, ..ImpactError::default() });
            self.apart(i, ImpactError { impulse: UNIT * impact.impulse.abs(), ..ImpactError::default() });
            if i > 0 {
                self.apart(i, ImpactError { time: UNIT * orbit.period(), ..ImpactError::default() });
            }
        }
        self.origins.iter().for_each(|origin| add_moduli(&mut self.impacts, origin));
    }

    /// Nothing is known of an orbit whose equations are singular.
    fn lose_all(&mut self) {
        self.psi_error = f64::INFINITY;
        self.impacts.fill(ImpactError { time: f64::INFINITY, impulse: f64::INFINITY, acceleration: f64::INFINITY });
        self.origins = vec![self.impacts.clone()];
    }

    /// Adds errors of the unknowns.
    fn take(&mut self, equations: &Equations<'_>, system: &System, errors: &[f64]) {
        let unknowns = equations.unknowns;
        let rounded = system.impulse_rounding(&unknowns, f64::EPSILON);
        for j in 0..self.impacts.len() {
            let impulse = rounded[j] + UNIT * equations.impulse(j).abs();
            self.impacts[j].impulse += errors[j] + impulse;
            self.apart(j, ImpactError { impulse, ..ImpactError::default() });
            if let Some(place) = unknowns.time(j) {
                let time = UNIT * equations.response.period();
                self.impacts[j].time += errors[place] + time;
                self.apart(j, ImpactError { time, ..ImpactError::default() });
            }
        }
        if let Some(psi) = unknowns.psi() {
            self.psi_error += errors[psi] + UNIT * equations.orbit.model().period();
        }
    }
}

/// What a change of the unknowns does to the impacts, with that of their accelerations.
fn together(unknowns: &Unknowns, moved: &[f64], accelerations: impl Iterator<Item = f64>) -> Together {
    let time = |i: usize| unknowns.time(i).map_or(0.0, |place| moved[place]);
    let error = |(i, acceleration)| ImpactError { time: time(i), impulse: moved[i], acceleration };
    accelerations.enumerate().map(error).collect()
}

fn add_moduli(sums: &mut [ImpactError], origin: &[ImpactError]) {
    for (sum, part) in sums.iter_mut().zip(origin) {
        sum.time += part.time.abs();
        sum.impulse += part.impulse.abs();
        sum.acceleration += part.acceleration.abs();
    }
}

/// Modes whose amplitude rounding changes by more than this many of its units are next to a resonance: what they do is carried by
/// origin. There are few of them, and the others matter little.
const RESONANT: f64 = 1e3;

/// Digits beyond which a lost one could show in a verdict.
const DELICATE: f64 = 1e-6;

/// Next to a resonance, to grazing or to a fold, by signs that cost little.
pub(crate) fn is_delicate(orbit: &Orbit, response: &ImpulseResponse) -> bool {
    let slowest = orbit.impacts().iter().map(|impact| impact.velocity_before.abs()).fold(f64::INFINITY, f64::min);
    delicate(response, orbit.model().omega(), (slowest, orbit.velocity_scale()))
        || !orbit.is_reversible() && Equations::new(orbit, response).system().reciprocal_condition < DELICATE
}

/// Next to a resonance or to grazing, by the slowest velocity before an impact and the scale of velocities.
pub(crate) fn delicate(response: &ImpulseResponse, omega: f64, (slowest, fastest): (f64, f64)) -> bool {
    response.condition() > 1.0 / DELICATE || slowest < DELICATE * fastest || fastest > omega / DELICATE
}

impl Equations<'_> {
    /// Errors of the modes' amplitudes, one mode after the other, to impulses, times and accelerations.
    fn amplitudes(&self, system: &System, gradients: &[Vector], condition: &mut Condition) {
        let (response, unknowns, impacts) = (self.response, self.unknowns, self.orbit.impacts());
        let n = impacts.len();
        let mut rest = vec![ImpactError::default(); n];
        for k in 0..response.modes() {
            let error = UNIT * response.mode_detuning(k);
            if error == 0.0 {
                continue;
            }
            let square = response.frequencies()[k] * response.frequencies()[k];
            let mut rows = zeros(unknowns.size());
            for i in 0..n {
                let (mut position, mut velocity) = (0.0, 0.0);
                for (j, other) in impacts.iter().enumerate() {
                    let weight =
                        other.impulse * response.weights()[k] * response.shapes().even(k, impacts[i].site, other.site);
                    let t = self.elapsed(i, j);
                    // cos x/(2Ω sin y), what the amplitude multiplies.
                    position += weight * (response.mode_dynamic(k, t) + response.mode_static(k));
                    velocity += weight * response.mode_slope(k, t);
                }
                rows[i] = position;
                if let Some(row) = unknowns.newton(i) {
                    rows[row] = velocity;
                }
            }
            let mut moved = system.solve(&rows);
            moved.iter_mut().for_each(|x| *x *= -error);
            let carried = (0..n).map(|i| dot(&gradients[i], &moved) - error * square * rows[i]);
            let origin = together(&unknowns, &moved, carried);
            add_moduli(&mut condition.impacts, &origin);
            if response.mode_detuning(k) > RESONANT {
                condition.origins.push(origin);
            } else {
                add_moduli(&mut rest, &origin);
            }
            if let Some(psi) = unknowns.psi() {
                condition.psi_error += moved[psi].abs();
            }
        }
        for (i, ImpactError { time, impulse, acceleration }) in rest.into_iter().enumerate() {
            condition.apart(i, ImpactError { time, ..ImpactError::default() });
            condition.apart(i, ImpactError { impulse, ..ImpactError::default() });
            condition.apart(i, ImpactError { acceleration, ..ImpactError::default() });
        }
    }

    /// Error of the acceleration at impact `i` for exact impulses, times and amplitudes, in the form that
    /// [`Motion::just_after`] chooses.
    fn acceleration_rounding(&self, i: usize, motion: &mut Motion) -> f64 {
        let orbit = self.orbit;
        let chain = orbit.model().chain();
        let impact = &orbit.impacts()[i];
        motion.seek(i, 0.0);
        let (neighbours, modes) = motion.acceleration_sizes(impact.site);
        let bound = |site: usize, part: fn(KernelJet) -> f64| -> f64 {
            let term = |(j, other): (usize, &Impact)| {
                let t = self.elapsed(i, j);
                other.impulse.abs() * part(self.response.rounding_between(site, other.site, t))
            };
            UNIT * orbit.impacts().iter().enumerate().map(term).sum::<f64>()
        };
        if modes < neighbours {
            return UNIT * modes + self.force_rounding(i, 2) + bound(impact.site, |jet| jet.curvature);
        }
        // What rounding does to the displacement of the mass itself and of a neighbour.
        let displacement = |site: usize| {
            let still = UNIT * (orbit.uniform_offset().abs() + motion.site(site).displacement.abs());
            self.force_rounding(i, 0) + still + bound(site, |jet| jet.value)
        };
        let (force, t) = (orbit.model().force_wave(), impact.time + orbit.psi_or_zero());
        let turned = |term: &WaveTerm| (term.amplitude * (term.rate * t + term.phase)).abs();
        let force = force.terms().iter().map(turned).sum::<f64>();
        let sides = chain.neighbours(impact.site).map(|n| n.map_or(0.0, displacement));
        chain.spring_force_bound(displacement(impact.site), sides) + UNIT * (neighbours + force)
    }
}

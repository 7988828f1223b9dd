//! How far an orbit can be trusted: its distance to the places where its equations lose their grip, and the errors of
//! its impulses, times and accelerations that follow from there.
//!
//! Errors δF of the terms of the equations (`equations`) pass through the inverse of the Jacobian. Those of a mode's
//! amplitude 1/(2 sin Ω_kT/2), which next to a resonance are by far the largest, are common to all terms of that mode and
//! are carried as one; the rest is taken with the worst signs, |δx| ≤ |J⁻¹| δF. Masses without coupling have equations that know of no
//! resonance (`flights`).

use smallvec::SmallVec;
use vibrochain_lattice::{ImpulseResponse, WaveTerm};

use crate::equations::{Column, MOST, System, Terms};
use crate::flights::Flights;
use crate::motion::Motion;
use crate::orbit::Orbit;
use crate::worst::worse;

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

/// Distances of an orbit to where it ceases to be determined, and the errors that follow. Dimensionless.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Condition {
    /// Distance to resonance: the smallest |Ω_k − jω|/Ω_k over modes and harmonics j ≥ 1, at most 1; ω is the orbit's base
    /// frequency. So many digits of the kernels are lost as this has zeros.
    pub resonance: f64,
    /// Distance to grazing: the smallest velocity before an impact, in units of the force's ω times half the gap. Saltation grows
    /// like its inverse.
    pub grazing: f64,
    /// Distance to a fold or pitchfork: reciprocal condition number of the orbit's equations, rows and columns scaled, at
    /// most 1. For a mirror-symmetric conservative orbit, whose times are fixed, of the equations for its impulses alone.
    /// `None` for an orbit given by its impacts.
    pub fold: Option<f64>,
    /// Estimated error of the force's phase ψ, as a time; 0 without force.
    pub psi_error: f64,
    /// Estimated errors of the impacts.
    pub impacts: SmallVec<[ImpactError; 2]>,
    /// The same by origin: what depends on several data of the orbit moves by the sum over these of the moduli, and hardly at all
    /// where the errors of one origin cancel.
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
            fold: None,
            psi_error: 0.0,
            impacts: orbit.impacts().iter().map(|_| ImpactError::default()).collect(),
            origins: Vec::new(),
        };
        if let Some(flights) = Flights::of(orbit) {
            condition.by_flights(orbit, &flights);
            return condition;
        }
        let terms = Terms::new(orbit, response);
        let system = terms.system();
        let errors = system.as_ref().map(|system| terms.row_errors(system));
        for i in 0..orbit.impacts().len() {
            let mut error = terms.acceleration_rounding(i, motion);
            condition.apart(i, ImpactError { acceleration: error, ..ImpactError::default() });
            if let (Some(system), Some(errors)) = (&system, &errors) {
                error += system.through(&terms.acceleration_gradient(i, system), errors);
            }
            condition.impacts[i].acceleration = error;
        }
        if let (Some(system), Some(errors)) = (&system, &errors) {
            condition.fold = Some(system.reciprocal_condition);
            condition.take(&terms, system, &system.spread(errors));
            let gradients: SmallVec<[Column; 2]> =
                (0..orbit.impacts().len()).map(|i| terms.acceleration_gradient(i, system)).collect();
            for (row, error) in errors.iter().enumerate().filter(|(_, error)| **error > 0.0) {
                let mut rows = [0.0; MOST];
                rows[row] = *error;
                let moved = system.solve(&rows);
                let carried = |gradient: &Column| gradient.iter().zip(&moved).map(|(g, x)| g * x).sum();
                condition.origins.push(together(system, &moved, gradients.iter().map(carried)));
            }
        }
        terms.amplitudes(system.as_ref(), &mut condition);
        for i in 1..condition.impacts.len() {
            // A time that symmetry fixes is rounded, too.
            let time = f64::EPSILON * orbit.period();
            condition.impacts[i].time += time;
            condition.apart(i, ImpactError { time, ..ImpactError::default() });
        }
        if condition.fold == Some(0.0) {
            condition.lose_all();
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
        self.fold = Some(system.reciprocal_condition);
        if system.reciprocal_condition == 0.0 {
            self.lose_all();
            return;
        }
        let (force, stiffness) = (model.force_wave(), model.chain().gamma1());
        let jets: SmallVec<[[f64; 4]; 2]> =
            orbit.impacts().iter().map(|impact| force.jet(impact.time + orbit.psi_or_zero())).collect();
        let psi = |moved: &Column| system.layout.psi.map_or(0.0, |psi| moved[psi]);
        for row in 0..system.layout.size {
            let mut rows = [0.0; MOST];
            rows[row] = flights.left[row];
            let moved = system.solve(&rows);
            let later = |i: usize| psi(&moved) + system.layout.time.filter(|_| i == 1).map_or(0.0, |time| moved[time]);
            // At a barrier the spring's force is known.
            self.origins.push(together(system, &moved, jets.iter().enumerate().map(|(i, jet)| jet[1] * later(i))));
            self.psi_error += psi(&moved).abs();
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
    fn take(&mut self, terms: &Terms<'_>, system: &System, errors: &Column) {
        let rounded = system.impulse_rounding(f64::EPSILON);
        for j in 0..self.impacts.len() {
            let impulse = rounded[j] + UNIT * terms.impulse(j).abs();
            self.impacts[j].impulse += errors[j] + impulse;
            self.apart(j, ImpactError { impulse, ..ImpactError::default() });
        }
        if let (Some(place), 2..) = (system.layout.time, self.impacts.len()) {
            let time = UNIT * terms.response.period();
            self.impacts[1].time += errors[place] + time;
            self.apart(1, ImpactError { time, ..ImpactError::default() });
        }
        if let Some(psi) = system.layout.psi {
            self.psi_error += errors[psi] + UNIT * terms.orbit.model().period();
        }
    }
}

/// What a change of the unknowns does to the impacts, with that of their accelerations.
fn together(system: &System, moved: &Column, accelerations: impl Iterator<Item = f64>) -> Together {
    let time = |i: usize| system.layout.time.filter(|_| i == 1).map_or(0.0, |time| moved[time]);
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
    let fastest = orbit.velocity_scale();
    response.condition() > 1.0 / DELICATE
        || slowest < DELICATE * fastest
        || fastest > orbit.model().omega() / DELICATE
        || !orbit.is_reversible()
            && Terms::new(orbit, response).system().is_some_and(|system| system.reciprocal_condition < DELICATE)
}

/// Rounding of one operation, with room for the few that a term takes.
const UNIT: f64 = 2.0 * f64::EPSILON;

impl Terms<'_> {
    /// Error of G's derivative of some order at impact `i`.
    fn force_rounding(&self, i: usize, order: usize) -> f64 {
        let t = self.orbit.impacts()[i].time + self.orbit.psi_or_zero();
        let moduli = self.orbit.steady().moduli(t);
        UNIT * (moduli[order] + t.abs() * moduli[order + 1])
    }

    /// Rounding of the rows, the modes' amplitudes left out.
    fn row_errors(&self, system: &System) -> Column {
        let (orbit, layout) = (self.orbit, system.layout);
        let (n, q) = (layout.impacts, orbit.model().loss());
        let mut errors = [0.0; MOST];
        let displacement = self.static_displacement();
        for i in 0..n {
            let impact = &orbit.impacts()[i];
            let mut position = UNIT * (displacement.abs() + orbit.model().barrier(impact.barrier).abs());
            let mut newton = UNIT * (0.5 * q * impact.impulse).abs() + self.force_rounding(i, 1);
            for j in 0..n {
                let bound = self.response.rounding_at(0, self.elapsed(i, j));
                position += UNIT * self.impulse(j).abs() * bound.value;
                if j != i {
                    newton += UNIT * self.impulse(j).abs() * bound.slope;
                }
            }
            errors[i] = position + self.force_rounding(i, 0);
            if Terms::has_newton_row(layout, i) {
                errors[n + 1 + i] = newton;
            }
        }
        errors[n] = 2.0 * UNIT * (self.response.static_stiffness() * displacement).abs();
        errors
    }

    /// How the acceleration Σ_j P_j K″(t_i−t_j) + G̈(t_i+ψ) changes with the unknowns.
    fn acceleration_gradient(&self, i: usize, system: &System) -> Column {
        let mut gradient = [0.0; MOST];
        let mut jerk = self.force(i)[3];
        if let Some(psi) = system.layout.psi {
            gradient[psi] = jerk;
        }
        for j in 0..system.layout.impacts {
            let jet = self.jet(i, j);
            gradient[j] = jet.curvature;
            if j != i {
                jerk += self.impulse(j) * jet.third;
                if let Some(time) = system.layout.time.filter(|_| j == 1) {
                    gradient[time] -= self.impulse(j) * jet.third;
                }
            }
        }
        if let Some(time) = system.layout.time.filter(|_| i == 1) {
            gradient[time] += jerk;
        }
        gradient
    }

    /// Errors of the modes' amplitudes, one mode after the other, to impulses, times and accelerations.
    fn amplitudes(&self, system: Option<&System>, condition: &mut Condition) {
        let response = self.response;
        let n = self.orbit.impacts().len();
        let gradients: SmallVec<[Column; 2]> =
            (0..n).map(|i| system.map_or([0.0; MOST], |system| self.acceleration_gradient(i, system))).collect();
        let mut rest = vec![ImpactError::default(); n];
        for k in 0..response.modes() {
            let error = UNIT * response.mode_detuning(k);
            if error == 0.0 {
                continue;
            }
            let square = response.frequencies()[k] * response.frequencies()[k];
            let mut rows = [0.0; MOST];
            let mut accelerations: SmallVec<[f64; 2]> = SmallVec::new();
            for i in 0..n {
                let site = self.orbit.impacts()[i].site;
                let (mut position, mut velocity) = (0.0, 0.0);
                for (j, other) in self.orbit.impacts().iter().enumerate() {
                    let distance = site.abs_diff(other.site);
                    let weight = other.impulse * response.weights()[k] * response.cosines().shape(k, distance);
                    let t = self.elapsed(i, j);
                    // cos x/(2Ω sin y), what the amplitude multiplies.
                    position += weight * (response.mode_dynamic(k, t) + response.mode_static(k));
                    velocity += weight * response.mode_slope(k, t);
                }
                accelerations.push(-square * position);
                if let Some(system) = system {
                    rows[i] = position;
                    if Terms::has_newton_row(system.layout, i) {
                        rows[n + 1 + i] = velocity;
                    }
                }
            }
            let moved = system.map_or([0.0; MOST], |system| system.solve(&rows));
            let carried = |(direct, gradient): (&f64, &Column)| {
                direct - gradient.iter().zip(&moved).map(|(g, x)| g * x).sum::<f64>()
            };
            let accelerations: SmallVec<[f64; 2]> = accelerations.iter().zip(&gradients).map(carried).collect();
            let origin = Together::from_iter((0..n).map(|i| {
                let time = system.and_then(|system| system.layout.time).filter(|_| i == 1);
                let impulse = if system.is_some() { -error * moved[i] } else { 0.0 };
                let acceleration = error * accelerations[i];
                ImpactError { time: time.map_or(0.0, |time| -error * moved[time]), impulse, acceleration }
            }));
            add_moduli(&mut condition.impacts, &origin);
            if response.mode_detuning(k) > RESONANT {
                condition.origins.push(origin);
            } else {
                add_moduli(&mut rest, &origin);
            }
            if let Some(psi) = system.and_then(|system| system.layout.psi) {
                condition.psi_error += error * moved[psi].abs();
            }
        }
        for (i, ImpactError { time, impulse, acceleration }) in rest.into_iter().enumerate() {
            condition.apart(i, ImpactError { time, ..ImpactError::default() });
            condition.apart(i, ImpactError { impulse, ..ImpactError::default() });
            condition.apart(i, ImpactError { acceleration, ..ImpactError::default() });
        }
    }

    /// Error of the acceleration at impact `i` for exact impulses, times and amplitudes, in the form that
    /// [`Motion::acceleration_from_forces`] chooses.
    fn acceleration_rounding(&self, i: usize, motion: &mut Motion) -> f64 {
        let orbit = self.orbit;
        let chain = orbit.model().chain();
        let impact = &orbit.impacts()[i];
        motion.seek(i, 0.0);
        let (neighbours, modes) = motion.acceleration_sizes(impact.site);
        let ring = motion.sites();
        let bound = |site: usize, part: fn(vibrochain_lattice::KernelJet) -> f64| -> f64 {
            let term = |(j, other): (usize, &crate::orbit::Impact)| {
                let distance = site.abs_diff(other.site) % ring;
                other.impulse.abs() * part(self.response.rounding_at(distance, self.elapsed(i, j)))
            };
            UNIT * orbit.impacts().iter().enumerate().map(term).sum::<f64>()
        };
        if modes < neighbours {
            return UNIT * modes + self.force_rounding(i, 2) + bound(impact.site, |jet| jet.curvature);
        }
        // What rounding does to the displacement of the mass itself and of a neighbour.
        let displacement = |site: usize| {
            let still = UNIT * (orbit.uniform_offset().abs() + motion.site(site % ring).displacement.abs());
            self.force_rounding(i, 0) + still + bound(site, |jet| jet.value)
        };
        let (force, t) = (orbit.model().force_wave(), impact.time + orbit.psi_or_zero());
        let turned = |term: &WaveTerm| (term.amplitude * (term.rate * t + term.phase)).abs();
        let force = force.terms().iter().map(turned).sum::<f64>();
        let (own, next) = (displacement(impact.site), displacement(impact.site + 1));
        chain.gamma1() * own + 2.0 * chain.gamma2() * (own + next) + UNIT * (neighbours + force)
    }
}

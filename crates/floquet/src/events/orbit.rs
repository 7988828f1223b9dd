//! What test functions ask of an orbit, be it a chain's or any structure's.

use nalgebra::Complex;
use smallvec::SmallVec;
use vibrochain_breather::{
    BlochEquations, BranchError, BreatherError, Family, Impact, Motion, Orbit, StructureMotion, StructureOrbit,
};
use vibrochain_lattice::{Barrier, ImpulseResponse, Resonance, Spectrum};

use crate::followed::Followed;

/// What is lost this near to the resonance of a mode, as a part of its frequency, ends there.
const NEAR: f64 = 1e-3;

/// A pole of the equations this near to them, as |1−e^{λT}|², is taken away from what is differentiated.
const BESIDE: f64 = 0.1;

/// The state at an impact, just before it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Arrival {
    pub(crate) impulse: f64,
    pub(crate) velocity: f64,
    /// What rounding does to it; `None` where no bound is known but the velocities of the orbit.
    pub(crate) velocity_error: Option<f64>,
    pub(crate) acceleration: f64,
}

/// An orbit of which events are told.
pub(crate) trait EventOrbit: Followed {
    /// ω of the force.
    fn omega(&self) -> f64;
    /// Whether neither impacts nor modes lose energy.
    fn is_lossless(&self) -> bool;
    /// The impacts, in order of time.
    fn arrivals(&self) -> SmallVec<[Arrival; 2]>;
    /// The acceleration after a plastic impact, and its error; `None` of others.
    fn acceleration_after(&self, _impact: usize) -> Result<Option<[f64; 2]>, BranchError> {
        Ok(None)
    }
    /// J(z).
    fn linearised(&self) -> Result<BlochEquations, BranchError>;
    /// Where a contact has a barrier.
    fn wall(&self, contact: usize, barrier: Barrier) -> Result<f64, BranchError>;
    /// Place and velocity of a contact at a time within the period.
    fn state(&self, contact: usize, time: f64) -> Result<[f64; 2], BranchError>;
    /// Those of all contacts.
    fn states(&self, time: f64) -> Result<Vec<[f64; 2]>, BranchError>;

    /// What rounding does to that place; `None` where no bound of it is known but its size.
    fn place_error(&self, contact: usize, time: f64) -> Option<f64>;

    /// How far it is from repeating or mirroring itself half a period later; of none where its own equations keep that.
    fn unevenness(&self) -> Vec<f64>;
    /// Whether a more symmetric orbit lies between this one and another of its branch.
    fn is_across(&self, other: &Self) -> bool;
    /// Whether its second half hits the same places as its first, in the same order. Where its branch ends on more symmetric orbits, these then
    /// repeat after half its period; where it does not, they are their own mirror images.
    fn is_hit_again(&self) -> bool {
        let hits = self.hits();
        let (one, other) = hits.split_at(hits.len() / 2);
        let mut pairs = one.iter().zip(other);
        one.len() == other.len() && pairs.all(|(a, b)| (a.site, a.barrier) == (b.site, b.barrier))
    }

    /// Whether others of less symmetry may leave it at a multiplier +1.
    fn may_lose_symmetry(&self) -> bool;

    /// Of a family that has a name, whether the second impact is in the second half of the period: of the same orbit begun at either, that is
    /// the one that is listed of doubled ones.
    fn is_late(&self) -> Option<bool>;

    /// Of each mode the pole λ of its motion, the upper of two.
    fn rates(&self) -> Vec<Complex<f64>>;

    /// The resonance that the orbit stands next to, of a mode that nothing damps.
    fn resonance(&self) -> Option<Resonance> {
        let omega = std::f64::consts::TAU / self.period();
        let told = |(mode, rate): (usize, Complex<f64>)| {
            let (frequency, harmonic) = (rate.im, (rate.im / omega).round());
            let distance = (-harmonic).mul_add(omega, frequency);
            let near = rate.re == 0.0 && harmonic > 0.0 && distance.abs() <= NEAR * frequency;
            near.then_some(Resonance { harmonic: harmonic as u64, mode, frequency, omega, distance })
        };
        let all = self.rates().into_iter().enumerate().filter_map(told);
        all.min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()))
    }

    /// How far e^{iθ} and 1 are from the nearest pole e^{λT} that is not always there; 1 at most.
    fn room(&self, theta: f64) -> f64 {
        let at = [Complex::new(1.0, 0.0), Complex::from_polar(1.0, theta), Complex::from_polar(1.0, -theta)];
        let poles = self.rates().into_iter().filter(|rate| rate.norm() > 0.0).map(|rate| (rate * self.period()).exp());
        let apart = poles.flat_map(|pole| at.map(|at| (pole - at).norm()));
        apart.filter(|apart| *apart > 0.0).fold(1.0, f64::min)
    }

    /// What the equations are multiplied by to have no pole: Π|1−e^{λT}|² over some modes, or over those of which it is small. Those.
    fn without_poles(&self, modes: Option<&[usize]>) -> (f64, SmallVec<[usize; 4]>) {
        let (rates, period) = (self.rates(), self.period());
        let apart = |rate: Complex<f64>| {
            let left = (rate.re * period).exp();
            (1.0 - left).powi(2) + 4.0 * left * (0.5 * rate.im * period).sin().powi(2)
        };
        let is_near = |mode: &usize| rates[*mode].im > 0.0 && apart(rates[*mode]) < BESIDE;
        let near = || (0..rates.len()).filter(is_near).collect();
        let modes: SmallVec<[usize; 4]> = modes.map_or_else(near, SmallVec::from_slice);
        (modes.iter().map(|&mode| rates.get(mode).map_or(1.0, |rate| apart(*rate))).product(), modes)
    }

    /// How fast contacts are: what velocities are measured by.
    fn speed(&self) -> f64 {
        let of = |one: Arrival| one.velocity.abs().max(one.acceleration.abs() / self.omega());
        self.arrivals().into_iter().map(of).fold(f64::MIN_POSITIVE, f64::max)
    }
}

impl EventOrbit for Orbit {
    fn omega(&self) -> f64 {
        self.model().omega()
    }

    fn is_lossless(&self) -> bool {
        self.model().loss() == 0.0
    }

    fn arrivals(&self) -> SmallVec<[Arrival; 2]> {
        let of = self.impacts().iter().map(|one| Arrival {
            impulse: one.impulse,
            velocity: one.velocity_before,
            // Impulses are unknowns, and 0 is 0.
            velocity_error: Some(f64::EPSILON * one.velocity_before.abs()),
            acceleration: one.acceleration,
        });
        of.collect()
    }

    fn linearised(&self) -> Result<BlochEquations, BranchError> {
        Ok(BlochEquations::of(self, &response(self)?).0)
    }

    fn wall(&self, _contact: usize, barrier: Barrier) -> Result<f64, BranchError> {
        Ok(self.model().barrier(barrier))
    }

    fn state(&self, contact: usize, time: f64) -> Result<[f64; 2], BranchError> {
        let mass = Motion::of(self)?.at(contact, time);
        Ok([mass.displacement, mass.velocity])
    }

    fn states(&self, time: f64) -> Result<Vec<[f64; 2]>, BranchError> {
        let mut motion = Motion::of(self)?;
        let _ = motion.at(0, time);
        let of = (0..motion.sites()).map(|site| motion.site(site));
        Ok(of.map(|mass| [mass.displacement, mass.velocity]).collect())
    }

    /// How large the terms are that the displacement is summed of: those of each impact, over all modes, and that of the force.
    fn place_error(&self, contact: usize, time: f64) -> Option<f64> {
        let response = response(self).ok()?;
        let [place, _] = self.state(contact, time).ok()?;
        let of = |impact: &Impact| {
            let elapsed = (time - impact.time).rem_euclid(self.period());
            impact.impulse.abs() * response.sensitivity_between(contact, impact.site, elapsed).value
        };
        let phase = self.omega() * (time + self.psi().unwrap_or(0.0));
        let force = self.steady().bound(0) * (1.0 + phase);
        Some(2.0 * f64::EPSILON * (self.impacts().iter().map(of).sum::<f64>() + force + place.abs()))
    }

    fn unevenness(&self) -> Vec<f64> {
        Vec::new()
    }

    fn is_across(&self, other: &Self) -> bool {
        let side = |orbit: &Self| orbit.phi().map_or(0.0, |phi| phi - 0.5 * orbit.period());
        side(self) * side(other) < 0.0
    }

    fn may_lose_symmetry(&self) -> bool {
        self.family() == Family::DoubleSided
    }

    fn is_late(&self) -> Option<bool> {
        (self.family() != Family::Word).then(|| self.phi().is_some_and(|phi| phi > 0.5 * self.period()))
    }

    fn rates(&self) -> Vec<Complex<f64>> {
        let spectrum = Spectrum::new(*self.model().chain());
        spectrum.frequencies().iter().map(|&frequency| Complex::new(0.0, frequency)).collect()
    }
}

fn response(orbit: &Orbit) -> Result<ImpulseResponse, BranchError> {
    let spectrum = Spectrum::new(*orbit.model().chain());
    Ok(ImpulseResponse::new(&spectrum, orbit.frequency()).map_err(BreatherError::from)?)
}

impl EventOrbit for StructureOrbit {
    fn omega(&self) -> f64 {
        self.model().omega()
    }

    fn is_lossless(&self) -> bool {
        self.model().structure().is_lossless()
    }

    fn arrivals(&self) -> SmallVec<[Arrival; 2]> {
        let of = self.impacts().iter().map(|one| Arrival {
            impulse: one.impulse,
            velocity: one.velocity_before,
            velocity_error: None,
            acceleration: one.acceleration_before,
        });
        of.collect()
    }

    fn acceleration_after(&self, impact: usize) -> Result<Option<[f64; 2]>, BranchError> {
        Ok(self.acceleration_after(impact)?)
    }

    fn linearised(&self) -> Result<BlochEquations, BranchError> {
        Ok(self.bloch_equations().0)
    }

    fn wall(&self, contact: usize, barrier: Barrier) -> Result<f64, BranchError> {
        Ok(self.model().barrier(contact, barrier)?)
    }

    fn state(&self, contact: usize, time: f64) -> Result<[f64; 2], BranchError> {
        let (motion, (last, since)) = (StructureMotion::new(self)?, flight(self, time));
        let [place, velocity, _] = motion.contact(contact, last, since);
        Ok([place, velocity])
    }

    fn states(&self, time: f64) -> Result<Vec<[f64; 2]>, BranchError> {
        let (motion, (last, since)) = (StructureMotion::new(self)?, flight(self, time));
        let contacts = 0..self.model().structure().contacts().len();
        let of = contacts.map(|contact| motion.contact(contact, last, since));
        Ok(of.map(|[place, velocity, _]| [place, velocity]).collect())
    }

    fn place_error(&self, _contact: usize, _time: f64) -> Option<f64> {
        None
    }

    fn unevenness(&self) -> Vec<f64> {
        self.unevenness()
    }

    fn is_across(&self, other: &Self) -> bool {
        self.is_across(other)
    }

    fn may_lose_symmetry(&self) -> bool {
        true
    }

    fn is_late(&self) -> Option<bool> {
        None
    }

    fn rates(&self) -> Vec<Complex<f64>> {
        self.model().structure().modes().iter().map(|mode| mode.rates()[0]).collect()
    }
}

/// The impact before a time within the period, and how long ago it was.
fn flight(orbit: &StructureOrbit, time: f64) -> (usize, f64) {
    let impacts = orbit.impacts();
    let last = impacts.iter().rposition(|impact| impact.time <= time).unwrap_or(impacts.len() - 1);
    (last, (time - impacts[last].time).rem_euclid(orbit.period()))
}

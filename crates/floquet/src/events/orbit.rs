//! What test functions ask of an orbit.

use nalgebra::Complex;
use smallvec::SmallVec;
use vibrochain_breather::{BlochEquations, BranchError, StructureOrbit};
use vibrochain_lattice::{Barrier, Resonance};

use crate::followed::Followed;

/// What is lost this near to the resonance of a mode, as a part of its frequency, ends there.
const NEAR: f64 = 1e-3;

/// A pole of the equations this near to them, as |1−e^{λT}|², is taken away from what is differentiated.
const BESIDE: f64 = 0.1;

/// The state at an impact, just before it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Arrival {
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
}

/// What events ask of an orbit.
pub(crate) trait EventOrbit: Followed {
    /// ω of the loads.
    fn omega(&self) -> f64;
    /// Whether neither impacts nor modes lose energy.
    fn is_lossless(&self) -> bool;
    /// The impacts, in order of time.
    fn arrivals(&self) -> SmallVec<[Arrival; 2]>;
    /// J(z).
    fn linearised(&self) -> BlochEquations;
    /// Where a contact has a barrier.
    fn wall(&self, contact: usize, barrier: Barrier) -> Result<f64, BranchError>;
    /// Whether its second half hits the same places as its first, in the same order. Where its branch ends on more symmetric orbits, these then
    /// repeat after half its period; where it does not, they are their own mirror images.
    fn is_hit_again(&self) -> bool;
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

impl EventOrbit for StructureOrbit {
    fn omega(&self) -> f64 {
        self.model().omega()
    }

    fn is_lossless(&self) -> bool {
        self.model().structure().is_lossless()
    }

    fn arrivals(&self) -> SmallVec<[Arrival; 2]> {
        let of = self
            .impacts()
            .iter()
            .map(|one| Arrival { velocity: one.velocity_before, acceleration: one.acceleration_before });
        of.collect()
    }

    fn linearised(&self) -> BlochEquations {
        self.bloch_equations().0
    }

    fn wall(&self, contact: usize, barrier: Barrier) -> Result<f64, BranchError> {
        Ok(self.model().barrier_at(contact, barrier)?)
    }

    fn is_hit_again(&self) -> bool {
        let (one, other) = self.impacts().split_at(self.impacts().len() / 2);
        let mut pairs = one.iter().zip(other);
        one.len() == other.len() && pairs.all(|(a, b)| (a.contact, a.barrier) == (b.contact, b.barrier))
    }

    fn rates(&self) -> Vec<Complex<f64>> {
        self.model().structure().modes().iter().map(|mode| mode.rates()[0]).collect()
    }
}

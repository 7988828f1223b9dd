//! The poles of an orbit's equations: e^{λT} of the modes, at 1 where one resonates.

use nalgebra::Complex;
use smallvec::SmallVec;
use vibrochain_breather::ContactOrbit;
use vibrochain_lattice::Resonance;

/// What is lost this near to the resonance of a mode, as a part of its frequency, ends there.
const NEAR: f64 = 1e-3;

/// A pole of the equations this near to them, as |1−e^{λT}|², is taken away from what is differentiated.
const BESIDE: f64 = 0.1;

/// Of each mode the pole λ of its motion, the upper of two.
fn rates(orbit: &ContactOrbit) -> impl Iterator<Item = Complex<f64>> + '_ {
    orbit.model().structure().modes().iter().map(|mode| mode.rates()[0])
}

/// The resonance that an orbit stands next to, of a mode that nothing damps.
pub(crate) fn resonance_beside(orbit: &ContactOrbit) -> Option<Resonance> {
    let omega = std::f64::consts::TAU / orbit.period();
    let told = |(mode, rate): (usize, Complex<f64>)| {
        let (frequency, harmonic) = (rate.im, (rate.im / omega).round());
        let distance = (-harmonic).mul_add(omega, frequency);
        let near = rate.re == 0.0 && harmonic > 0.0 && distance.abs() <= NEAR * frequency;
        near.then_some(Resonance { harmonic: harmonic as u64, mode, frequency, omega, distance })
    };
    let all = rates(orbit).enumerate().filter_map(told);
    all.min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()))
}

/// How far e^{iθ} and 1 are from the nearest pole that is not always there; 1 at most.
pub(crate) fn room(orbit: &ContactOrbit, theta: f64) -> f64 {
    let at = [Complex::new(1.0, 0.0), Complex::from_polar(1.0, theta), Complex::from_polar(1.0, -theta)];
    let poles = rates(orbit).filter(|rate| rate.norm() > 0.0).map(|rate| (rate * orbit.period()).exp());
    let apart = poles.flat_map(|pole| at.map(|at| (pole - at).norm()));
    apart.filter(|apart| *apart > 0.0).fold(1.0, f64::min)
}

/// What the equations are multiplied by to have no pole: Π|1−e^{λT}|² over some modes, or over those of which it is small. Those.
pub(crate) fn without_poles(orbit: &ContactOrbit, modes: Option<&[usize]>) -> (f64, SmallVec<[usize; 4]>) {
    let (rates, period) = (rates(orbit).collect::<Vec<_>>(), orbit.period());
    let apart = |rate: Complex<f64>| {
        let left = (rate.re * period).exp();
        (1.0 - left).powi(2) + 4.0 * left * (0.5 * rate.im * period).sin().powi(2)
    };
    let is_near = |mode: &usize| rates[*mode].im > 0.0 && apart(rates[*mode]) < BESIDE;
    let near = || (0..rates.len()).filter(is_near).collect();
    let modes: SmallVec<[usize; 4]> = modes.map_or_else(near, SmallVec::from_slice);
    (modes.iter().map(|&mode| rates.get(mode).map_or(1.0, |rate| apart(*rate))).product(), modes)
}

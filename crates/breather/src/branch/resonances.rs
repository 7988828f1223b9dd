//! Where a branch meets a resonance.

use std::cell::OnceCell;

use vibrochain_lattice::{Model, Parameter, Resonance, Shapes, Spectrum};

use crate::branch::{Branch, BranchPoint};
use crate::orbit::{Impact, Orbit};
use crate::roots::bracket::zero;
use crate::tracer::corrector::Continuation;

/// A harmonic of which symmetry leaves no more than this part moves no mode: some roundings of its terms. Next to a resonance that
/// does move its mode the impulses, too, conspire against it, but by the square of the distance.
pub(crate) const STILL: f64 = 64.0 * f64::EPSILON;

/// Whether a harmonic of the impulses pushes a mode.
pub(crate) fn pushes(orbit: &Orbit, shapes: &Shapes, mode: usize, harmonic: f64) -> bool {
    let rate = harmonic * orbit.frequency();
    let share = |one: &Impact, other: &Impact| {
        let turned = (rate * (one.time - other.time)).cos();
        one.impulse * other.impulse * shapes.even(mode, one.site, other.site) * turned
    };
    let impacts = orbit.impacts();
    let size: f64 = impacts.iter().map(|impact| share(impact, impact)).sum();
    let all = impacts.iter().flat_map(|one| impacts.iter().map(move |other| share(one, other)));
    all.sum::<f64>() > STILL * size
}

impl Branch {
    /// The first resonance as the parameter goes from that of a point to another value, and the value where it is: a harmonic of
    /// the orbit's frequency on a mode that it pushes.
    pub(crate) fn resonance_within(&self, point: &BranchPoint, to: f64) -> Option<(f64, Resonance)> {
        // Of a lattice that is the same all along the branch but for its stiffness; most steps meet none.
        let shapes = OnceCell::new();
        self.equations.meeting(point.value(), to, |mode, harmonic| {
            let shapes = shapes.get_or_init(|| Shapes::new(self.equations.origin.model().chain()));
            pushes(point.orbit(), shapes, mode, harmonic)
        })
    }
}

impl Continuation {
    /// Whether some harmonic meets some mode between two values, be it pushed or not: there the equations have a pole.
    pub(crate) fn has_pole_between(&self, from: f64, to: f64) -> bool {
        self.meeting(from, to, |_, _| true).is_some()
    }

    fn meeting(&self, from: f64, to: f64, counts: impl Fn(usize, f64) -> bool) -> Option<(f64, Resonance)> {
        if !matches!(self.free[0], Parameter::Gamma1 | Parameter::Gamma2 | Parameter::Gamma3 | Parameter::Omega) {
            return None;
        }
        let periods = f64::from(self.origin.force_periods());
        let of = |model: &Model| (Spectrum::new(*model.chain()), model.omega() / periods);
        let model = |value: f64| self.model(&[value]).ok();
        let ((first, omega), (last, last_omega)) = (of(&model(from)?), of(&model(to)?));
        let frequencies = first.frequencies().iter().copied().zip(last.frequencies().iter().copied()).enumerate();
        let at = |mode: usize, value: f64| {
            let (spectrum, omega) = of(&model(value)?);
            Some((spectrum.frequencies().get(mode).copied()?, omega))
        };
        nearest([(from, omega), (to, last_omega)], frequencies, at, counts)
    }
}

/// The nearest resonance between two values, each with the orbit's base frequency there: that of a mode of these frequencies at both, by its number,
/// that passes a harmonic which counts. `at` tells the frequency of a mode, and the orbit's, at a value.
pub(crate) fn nearest(
    [(from, omega), (to, last_omega)]: [(f64, f64); 2],
    frequencies: impl Iterator<Item = (usize, (f64, f64))>,
    at: impl Fn(usize, f64) -> Option<(f64, f64)>,
    counts: impl Fn(usize, f64) -> bool,
) -> Option<(f64, Resonance)> {
    let mut nearest: Option<(f64, Resonance)> = None;
    for (mode, (start, end)) in frequencies {
        let [before, behind] = [start / omega, end / last_omega].map(f64::floor);
        if before == behind {
            continue;
        }
        let harmonic = if behind > before { before + 1.0 } else { before };
        if harmonic < 1.0 || !counts(mode, harmonic) {
            continue;
        }
        let off = |omega: f64, frequency: f64| (-harmonic).mul_add(omega, frequency);
        let there = |value: f64| {
            let (frequency, omega) = at(mode, value)?;
            let distance = off(omega, frequency);
            Some((value, Resonance { harmonic: harmonic as u64, mode, frequency, omega, distance }))
        };
        let distance = |value: f64| there(value).map(|(_, resonance)| resonance.distance).ok_or(());
        let ends = [(from, off(omega, start)), (to, off(last_omega, end))];
        let hit = zero(ends[0], ends[1], from.abs().max(to.abs()), distance).ok().and_then(there);
        let closer = |(value, _): &(f64, Resonance)| {
            nearest.as_ref().is_none_or(|(old, _)| (value - from).abs() < (old - from).abs())
        };
        if hit.as_ref().is_some_and(closer) {
            nearest = hit;
        }
    }
    nearest
}

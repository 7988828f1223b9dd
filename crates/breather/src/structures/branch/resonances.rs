//! Where a branch meets a resonance.

use vibrochain_lattice::{LinearMode, Resonance};

use super::continuation::{Branch, BranchPoint};
use crate::roots::bracket::zero;
use crate::structures::model::LoadedStructure;
use crate::structures::orbit::ContactOrbit;

/// A harmonic of which symmetry leaves no more than this part moves no mode: some roundings of its terms. Next to a resonance that
/// does move its mode the impulses, too, conspire against it, but by the square of the distance.
pub(crate) const STILL: f64 = 64.0 * f64::EPSILON;

impl ContactOrbit {
    /// Whether a harmonic of the impulses pushes a mode.
    fn pushes(&self, mode: &LinearMode, harmonic: f64) -> bool {
        let rate = harmonic * std::f64::consts::TAU / self.period();
        let (mut sums, mut size) = ([[0.0; 2]; 2], 0.0);
        for impact in self.impacts() {
            let (sin, cos) = (rate * impact.time).sin_cos();
            for (sum, entry) in sums.iter_mut().zip(mode.columns[impact.site]) {
                let given = impact.impulse * entry;
                *sum = [sum[0] + given * cos, sum[1] + given * sin];
                size += given * given;
            }
        }
        sums.as_flattened().iter().map(|sum| sum * sum).sum::<f64>() > STILL * size
    }
}

impl Branch {
    /// The first resonance between two points, and the value where it is: a harmonic of the orbit's frequency on a mode that nothing damps and that
    /// it pushes; in a lattice the mode by its wave.
    pub fn resonance_between(&self, from: &BranchPoint, to: &BranchPoint) -> Option<(f64, Resonance)> {
        let end = (to.value(), std::f64::consts::TAU / to.orbit().period());
        self.first_resonance(from, end, to.orbit().model())
    }

    /// The same up to a value.
    pub(crate) fn resonance_within(&self, from: &BranchPoint, to: f64) -> Option<(f64, Resonance)> {
        let model = self.equations.model_at(to)?;
        let periods = from.orbit().period() / from.orbit().model().period();
        self.first_resonance(from, (to, model.omega() / periods), &model)
    }

    /// The same up to the model at a value, and the orbit's base frequency there.
    fn first_resonance(&self, from: &BranchPoint, to: (f64, f64), model: &LoadedStructure) -> Option<(f64, Resonance)> {
        let (first, last) = (from.orbit().model().structure().modes(), model.structure().modes());
        let both = first.iter().zip(last).enumerate();
        let frequencies = both.filter_map(|(number, (mode, end))| {
            Some((number, (mode.resonant_frequency()?, end.resonant_frequency()?)))
        });
        // All orbits of a branch last the same number of periods of the loads.
        let periods = from.orbit().period() / from.orbit().model().period();
        let at = |number: usize, value: f64| {
            let model = self.equations.model_at(value)?;
            Some((model.structure().modes().get(number)?.resonant_frequency()?, model.omega() / periods))
        };
        let counts = |number: usize, harmonic: f64| from.orbit().pushes(&first[number], harmonic);
        let start = (from.value(), std::f64::consts::TAU / from.orbit().period());
        let (value, resonance) = nearest([start, to], frequencies, at, counts)?;
        Some((value, self.equations.model_at(value)?.by_wave(resonance)))
    }
}

/// The nearest resonance between two values, each with the orbit's base frequency there: that of a mode of these frequencies at both, by its number,
/// that passes a harmonic which counts. `at` tells the frequency of a mode, and the orbit's, at a value.
fn nearest(
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

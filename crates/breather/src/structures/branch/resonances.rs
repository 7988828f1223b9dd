//! Where a branch meets a resonance.

use vibrochain_lattice::{LinearMode, Resonance, Turn};

use super::continuation::{Branch, BranchPoint};
use crate::branch::resonances::{STILL, nearest};
use crate::structures::orbit::StructureOrbit;

/// The frequency of a mode that nothing damps.
fn frequency(mode: &LinearMode) -> Option<f64> {
    (mode.decay == 0.0 && mode.turn == Turn::Circular).then_some(mode.rate)
}

impl StructureOrbit {
    /// Whether a harmonic of the impulses pushes a mode.
    fn pushes(&self, mode: &LinearMode, harmonic: f64) -> bool {
        let rate = harmonic * std::f64::consts::TAU / self.period();
        let (mut sums, mut size) = ([[0.0; 2]; 2], 0.0);
        for impact in self.impacts() {
            let (sin, cos) = (rate * impact.time).sin_cos();
            for (sum, entry) in sums.iter_mut().zip(mode.columns[impact.contact]) {
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
    /// it pushes.
    pub fn resonance_between(&self, from: &BranchPoint, to: &BranchPoint) -> Option<(f64, Resonance)> {
        let end = |point: &BranchPoint| (point.value(), std::f64::consts::TAU / point.orbit().period());
        let (first, last) = (from.orbit().model().structure().modes(), to.orbit().model().structure().modes());
        let both = first.iter().zip(last).enumerate();
        let frequencies = both.filter_map(|(number, (mode, end))| Some((number, (frequency(mode)?, frequency(end)?))));
        // All orbits of a branch last the same number of periods of the loads.
        let periods = from.orbit().period() / from.orbit().model().period();
        let at = |number: usize, value: f64| {
            let model = self.equations.model_at(value)?;
            Some((frequency(model.structure().modes().get(number)?)?, model.omega() / periods))
        };
        let counts = |number: usize, harmonic: f64| from.orbit().pushes(&first[number], harmonic);
        nearest([end(from), end(to)], frequencies, at, counts)
    }
}

//! Where a branch meets a resonance.

use vibrochain_lattice::{LinearMode, Resonance, Turn};

use super::continuation::{StructureBranch, StructureBranchPoint};
use crate::roots::bracket::zero;
use crate::structures::orbit::StructureOrbit;

/// A harmonic of which symmetry leaves no more than this part moves no mode: some roundings of its terms. Next to a resonance that does move its
/// mode the impulses, too, conspire against it, but by the square of the distance.
const STILL: f64 = 64.0 * f64::EPSILON;

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

impl StructureBranch {
    /// The first resonance between two points, and the value where it is: a harmonic of the orbit's frequency on a mode that nothing damps and that
    /// it pushes.
    pub fn resonance_between(
        &self,
        from: &StructureBranchPoint,
        to: &StructureBranchPoint,
    ) -> Option<(f64, Resonance)> {
        let base = |point: &StructureBranchPoint| std::f64::consts::TAU / point.orbit().period();
        let (omega, last_omega, scale) = (base(from), base(to), from.value().abs().max(to.value().abs()));
        let modes = |point: &'_ StructureBranchPoint| point.orbit().model().structure().clone();
        let (first, last) = (modes(from), modes(to));
        let mut nearest: Option<(f64, Resonance)> = None;
        for (number, (mode, end)) in first.modes().iter().zip(last.modes()).enumerate() {
            let (Some(start), Some(end)) = (frequency(mode), frequency(end)) else { continue };
            let [before, behind] = [start / omega, end / last_omega].map(f64::floor);
            let harmonic = if behind > before { before + 1.0 } else { before };
            if before == behind || harmonic < 1.0 || !from.orbit().pushes(mode, harmonic) {
                continue;
            }
            let off = |omega: f64, frequency: f64| (-harmonic).mul_add(omega, frequency);
            // Along the branch the frequency goes from that of one point to that of the other.
            let periods = from.orbit().model().omega() / omega;
            let at = |value: f64| {
                let model = self.equations.model_at(value)?;
                let (frequency, omega) = (frequency(model.structure().modes().get(number)?)?, model.omega() / periods);
                let distance = off(omega, frequency);
                Some((value, Resonance { harmonic: harmonic as u64, mode: number, frequency, omega, distance }))
            };
            let distance = |value: f64| at(value).map(|(_, resonance)| resonance.distance).ok_or(());
            let ends = [(from.value(), off(omega, start)), (to.value(), off(last_omega, end))];
            let hit = zero(ends[0], ends[1], scale, distance).ok().and_then(at);
            let away = |value: f64| (value - from.value()).abs();
            if let Some(hit) = hit
                && nearest.as_ref().is_none_or(|(old, _)| away(hit.0) < away(*old))
            {
                nearest = Some(hit);
            }
        }
        nearest
    }
}

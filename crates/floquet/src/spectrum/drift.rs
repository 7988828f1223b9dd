//! How a multiplier moves with the orbit: from the equations of two neighbours of the orbit on its branch.

use nalgebra::Complex;

use super::function::{Pole, SpectralFunction};
use super::refine::Product;
use crate::zeros::modulus;

type C = Complex<f64>;

/// What a multiplier may leave of J, as a part of its largest entry: more, and it is that of a mode which the equations leave out.
const MOST_DEFECT: f64 = 1e-4;

/// By how much a multiplier differs between two neighbouring orbits of a branch, and the rounding error of that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Drift {
    pub(crate) value: C,
    pub(crate) error: f64,
}

impl SpectralFunction<'_> {
    /// The drift of the multiplier next to `z` from the equations `before` to those `behind`, −xᵀ(B₊ − B₋)y/xᵀB′y with its null vectors here.
    /// Halfway between two that are h apart that is right but for h³. `None` where there is no simple one.
    pub(crate) fn drift(&self, z: C, [before, behind]: [&SpectralFunction<'_>; 2]) -> Option<Drift> {
        let null = self.null(z, 1)?;
        // Not a number is no multiplier, either.
        if null.defect.is_nan() || null.defect > MOST_DEFECT {
            return None;
        }
        let vectors = (null.left.column(0), null.right.column(0));
        let vectors = (vectors.0.as_slice(), vectors.1.as_slice());
        let Product { slope, slope_error, .. } = self.product(z, &null.near, vectors, &[])?;
        let at = |there: &SpectralFunction<'_>| there.product(z, &there.alike(self, &null.near)?, vectors, &[]);
        let (low, high) = (at(before)?, at(behind)?);
        let size = modulus(slope) - slope_error;
        let drift =
            Drift { value: (low.value - high.value) / slope, error: (low.value_error + high.value_error) / size };
        (size > 0.0 && drift.value.re.is_finite() && drift.value.im.is_finite()).then_some(drift)
    }

    /// The poles here of the same modes as some of a neighbour's.
    fn alike(&self, other: &SpectralFunction<'_>, poles: &[Pole]) -> Option<Vec<Pole>> {
        let alike = self.poles.len() == other.poles.len() && self.simple() == other.simple();
        let own = |pole: &Pole| self.poles_of(pole.mode)[pole.which];
        alike.then(|| poles.iter().map(own).collect())
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_breather::{BlochEquations, LinearImpact};

    use super::super::clusters::zeros;
    use super::super::random_equations;
    use super::*;

    /// Against multipliers of the neighbours themselves.
    #[test]
    fn multipliers_move_as_their_null_vectors_say() {
        let mut random = vibrochain_testkit::Random(19);
        let mut checked = 0;
        for _ in 0..60 {
            let equations = random_equations(&mut random, 0.3);
            let turn = random.between(-1.0, 1.0);
            let moved = |by: f64| {
                let impacts = equations.impacts().iter().enumerate().map(|(i, impact)| LinearImpact {
                    time: impact.time + if i == 0 { 0.0 } else { by },
                    impulse: impact.impulse * (1.0 + turn * by),
                    ..*impact
                });
                BlochEquations::new(equations.kernel().clone(), impacts.collect())
            };
            let h = 1e-5;
            let [low, high] = [moved(-h), moved(h)];
            let sides = [&low, &high].map(|one| zeros(one, false, &[]));
            let [here, low, high] = [&equations, &low, &high].map(|one| SpectralFunction::new(one, false));
            let all = zeros(&equations, false, &[]);
            if !(all.certified && sides.iter().all(|one| one.certified)) {
                continue;
            }
            for zero in all.list.iter().filter(|zero| modulus(zero.z) > 1e-3) {
                let next = |z: C, list: &[super::super::Zero]| {
                    let mut apart: Vec<(f64, C)> = list.iter().map(|one| (modulus(one.z - z), one.z)).collect();
                    apart.sort_by(|a, b| a.0.total_cmp(&b.0));
                    (apart[0].0, apart.get(1).map_or(f64::INFINITY, |other| other.0), apart[0].1)
                };
                let [before, behind] = sides.each_ref().map(|one| next(zero.z, &one.list));
                if before.0.max(behind.0) > 0.05 * before.1.min(behind.1) {
                    continue;
                }
                let drift = here.drift(zero.z, [&low, &high]).unwrap();
                let expected = behind.2 - before.2;
                let size = modulus(expected) + h * modulus(zero.z);
                assert!(modulus(drift.value - expected) < 1e-3 * size, "{:?} {expected}", drift.value);
                assert!(drift.error < 1e-3 * size, "{:e} of {size:e}", drift.error);
                checked += 1;
            }
        }
        assert!(checked > 150, "{checked}");
    }
}

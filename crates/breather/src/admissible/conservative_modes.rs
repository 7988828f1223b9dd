//! Where [`crate::MapBreather`]es are made: the modes of a conservative breather just after its first impact, four at a time, and what is left of
//! its conditions.

use vibrochain_lattice::simd::lanes::{LANES, Lane, all, four, groups, total};
use vibrochain_lattice::{Barrier, ImpulseResponse, Model, Shapes};
use wide::f64x4;

use crate::admissible::grid::{Flight, MOST_MODES};
use crate::worse;

/// Modes of one breather after the other, in the same memory.
#[derive(Debug, Clone, Default)]
pub(crate) struct ConservativeModes {
    /// cos(2πkn/M) of the half ring of so many masses, [mode][mass] in whole groups.
    sites: usize,
    shapes: Vec<Lane>,
    /// Displacements and velocities of the modes just after the first impact.
    start: [Vec<Lane>; 2],
}

/// Impulses at 0 and T/2, the latter 0 if there is none, and what their sum holds up at the site that is hit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TwoImpulses {
    pub(crate) impulses: [f64; 2],
    pub(crate) one: bool,
    pub(crate) static_displacement: f64,
}

impl TwoImpulses {
    fn barriers(&self) -> [Barrier; 2] {
        [if self.one { Barrier::Lower } else { Barrier::Upper }, Barrier::Lower]
    }

    /// Every mass moves outward before its impact.
    pub(crate) fn is_right_signed(&self) -> bool {
        let outward = |(impulse, barrier): (f64, Barrier)| -0.5 * impulse * barrier.sign() > 0.0;
        self.impulses.into_iter().zip(self.barriers()).take(if self.one { 1 } else { 2 }).all(outward)
    }
}

impl ConservativeModes {
    /// Takes over the motion of a breather; its residual, `None` where that is no number or the ring is too large.
    pub(crate) fn take(&mut self, model: &Model, response: &ImpulseResponse, two: &TwoImpulses) -> Option<f64> {
        if response.modes() > MOST_MODES {
            return None;
        }
        self.set_shapes(response.shapes(), response.modes());
        let [first, second] = two.impulses;
        let net = two.static_displacement * response.static_stiffness();
        let held = two.static_displacement * response.uniform_share();
        let [displacements, velocities] = &mut self.start;
        displacements.clear();
        velocities.clear();
        // Displacements of the site that is hit at both impacts, and the weights.
        let mut sums = [f64x4::ZERO; 3];
        for (group, [weight, still, at_impulse, at_half]) in response.in_fours().enumerate() {
            let mut still = (four(still) * all(net)).to_array();
            if group == 0 {
                // Of the uniform mode it is known to its last digits.
                still[0] = held / weight[0];
            }
            let [weight, still, at_impulse, at_half] = [weight, still, at_impulse, at_half].map(four);
            let start = weight * (still + all(first) * at_impulse + all(second) * at_half);
            let end = weight * (still + all(first) * at_half + all(second) * at_impulse);
            displacements.push(start.to_array());
            // Just after the impact the velocity is half the jump above its mean.
            velocities.push((weight * all(0.5 * first)).to_array());
            sums = [sums[0] + start, sums[1] + end, sums[2] + weight];
        }
        let [start, end, weight] = sums.map(total);
        let scale = first.abs().max(second.abs());
        let mut residual = 0.0;
        for (i, (place, barrier)) in [start, end].into_iter().zip(two.barriers()).enumerate() {
            if i == 1 && two.one {
                continue;
            }
            // v(t_i) − (a±1) and w_i, half the jump below the velocity after the impact, over the largest terms.
            let mean = 0.5 * two.impulses[i] * weight - 0.5 * two.impulses[i];
            residual = worse(worse(residual, (place - model.barrier(barrier)).abs()), (mean / scale).abs());
        }
        residual.is_finite().then_some(residual)
    }

    fn set_shapes(&mut self, shapes: &Shapes, modes: usize) {
        if self.sites == shapes.sites() && !self.shapes.is_empty() {
            return;
        }
        self.sites = shapes.sites();
        let groups = groups(modes);
        self.shapes.clear();
        self.shapes.resize(modes * groups, [0.0; LANES]);
        for (k, row) in self.shapes.chunks_exact_mut(groups).enumerate() {
            let masses = row.as_flattened_mut().iter_mut().enumerate().take(modes);
            masses.for_each(|(n, shape)| *shape = shapes.even(k, n, 0));
        }
    }

    pub(crate) fn flight<'a>(&'a self, response: &'a ImpulseResponse) -> Flight<'a> {
        let [displacements, velocities] = &self.start;
        Flight::of_ring(response.frequencies(), &self.shapes, [displacements, velocities])
    }
}

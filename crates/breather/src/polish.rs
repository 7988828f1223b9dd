//! Newton steps on the equations themselves, for orbits whose reduced equation left digits behind.
//!
//! The zero of E fixes φ to its own rounding; where X, Y and Δ of Cramer's rule nearly vanish together the phase that
//! follows from it is worse than the equations allow. The residual shows it.

use vibrochain_lattice::ImpulseResponse;

use crate::equations::{MOST, Terms};
use crate::motion::Motion;
use crate::orbit::{Draft, Orbit};

/// Residuals below this many roundings of the largest term are as good as zero.
const ROUNDINGS: f64 = 64.0;

/// Steps at most; each squares the error.
const STEPS: usize = 3;

/// Improves `orbit`, assembled from `draft`, as long as its residual falls. `motion` holds it before and after.
pub(crate) fn polish(orbit: &mut Orbit, mut draft: Draft, response: &ImpulseResponse, motion: &mut Motion) {
    for _ in 0..STEPS {
        let largest = orbit.impacts().iter().map(|impact| impact.impulse.abs()).fold(1.0, f64::max);
        let scale = largest.max(orbit.force_response().abs() * orbit.model().omega().max(1.0));
        if !(orbit.residual() > ROUNDINGS * f64::EPSILON * scale) {
            return;
        }
        let terms = Terms::new(orbit, response);
        let Some(system) = terms.system().filter(|system| system.reciprocal_condition > f64::EPSILON) else { return };
        let mut rows = [0.0; MOST];
        for i in 0..system.layout.impacts {
            let (position, newton) = orbit.violation(i, motion);
            rows[i] = position;
            if Terms::has_newton_row(system.layout, i) {
                rows[system.layout.impacts + 1 + i] = newton;
            }
        }
        let step = system.solve(&rows);
        let displacement = terms.static_displacement() - step[system.layout.impacts];
        for (impact, change) in draft.impacts.iter_mut().zip(&step) {
            impact.3 -= change;
        }
        if let (Some(time), Some(impact)) = (system.layout.time, draft.impacts.get_mut(1)) {
            impact.2 -= step[time];
        }
        if let Some(psi) = system.layout.psi {
            draft.psi = (draft.psi - step[psi]).rem_euclid(orbit.model().period());
        }
        if let Some(source) = draft.sources.first_mut() {
            source.net_impulse = displacement * response.static_stiffness();
        }
        draft.uniform_offset = displacement * response.uniform_share();
        let inside = draft.impacts.iter().all(|impact| (0.0..response.period()).contains(&impact.2));
        let better = Orbit::assemble(orbit.model(), response, motion, draft.clone());
        match better {
            Ok(better) if inside && better.residual() < 0.5 * orbit.residual() => *orbit = better,
            _ => {
                motion.load(orbit, response);
                return;
            }
        }
    }
}

//! Newton steps on the equations themselves, for orbits whose reduced equation left digits behind.
//!
//! The zero of E fixes φ to its own rounding; where X, Y and Δ of Cramer's rule nearly vanish together the phase that
//! follows from it is worse than the equations allow. What is left of the equations shows it.

use vibrochain_lattice::ImpulseResponse;

use crate::equations::{MOST, System, Terms};
use crate::motion::Motion;
use crate::orbit::{Draft, Orbit};

/// Violations below this many roundings of the largest term are as good as zero.
const SOUND: f64 = 16.0 * f64::EPSILON;

/// Steps at most; each squares the error.
const STEPS: usize = 4;

/// Improves `orbit`, assembled from `draft`, as long as its violations fall. Mirror-symmetric orbits come from closed forms
/// that leave nothing to improve.
pub(crate) fn polish(orbit: &mut Orbit, mut draft: Draft, response: &ImpulseResponse, motion: &mut Motion) {
    if orbit.is_reversible() {
        return;
    }
    let mut worst = Terms::new(orbit, response).worst_violation();
    for _ in 0..STEPS {
        if worst <= SOUND {
            return;
        }
        let terms = Terms::new(orbit, response);
        let Some(system) = terms.system().filter(|system| system.reciprocal_condition > f64::EPSILON) else { return };
        improve(&mut draft, &system, &terms);
        if !draft.impacts.iter().all(|impact| (0.0..response.period()).contains(&impact.time)) {
            return;
        }
        let Ok(next) = Orbit::assemble(orbit.model(), response, motion, draft.clone()) else { return };
        let left = Terms::new(&next, response).worst_violation();
        if left >= worst {
            return;
        }
        (*orbit, worst) = (next, left);
    }
}

/// One Newton step of the draft.
fn improve(draft: &mut Draft, system: &System, terms: &Terms<'_>) {
    let (layout, response) = (system.layout, terms.response);
    let mut rows = [0.0; MOST];
    for i in 0..layout.impacts {
        let [position, newton] = terms.violation(i);
        rows[i] = position;
        if Terms::has_newton_row(layout, i) {
            rows[layout.impacts + 1 + i] = newton;
        }
    }
    let change = system.solve(&rows);
    for (impact, change) in draft.impacts.iter_mut().zip(&change) {
        impact.impulse -= change;
    }
    if let (Some(time), Some(impact)) = (layout.time, draft.impacts.get_mut(1)) {
        impact.time -= change[time];
    }
    if let Some(psi) = layout.psi {
        draft.psi = (draft.psi - change[psi]).rem_euclid(terms.orbit.model().period());
    }
    let static_displacement = terms.static_displacement() - change[layout.impacts];
    if let Some(source) = draft.sources.first_mut() {
        source.net_impulse = static_displacement * response.static_stiffness();
    }
    draft.uniform_offset = static_displacement * response.uniform_share();
}

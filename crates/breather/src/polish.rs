//! Newton steps on the equations themselves, for orbits whose reduced equation left digits behind.
//!
//! The zero of E fixes φ to its own rounding; where X, Y and Δ of Cramer's rule nearly vanish together the phase that
//! follows from it is worse than the equations allow. The residual shows it.

use smallvec::SmallVec;
use vibrochain_lattice::ImpulseResponse;

use crate::equations::{MOST, System, Terms};
use crate::motion::Motion;
use crate::orbit::{Draft, Orbit};

/// Violations below this many roundings of the largest term are as good as zero.
const SOUND: f64 = 16.0 * f64::EPSILON;

/// Steps at most; each squares the error.
const STEPS: usize = 4;

/// Improves `orbit`, assembled from `draft`, as long as its violations fall. `motion` holds the orbit before; another or
/// the same after.
pub(crate) fn polish(orbit: &mut Orbit, mut draft: Draft, response: &ImpulseResponse, motion: &mut Motion) {
    if orbit.residual() <= SOUND {
        return;
    }
    let (mut violations, mut worst) = violations(orbit, motion);
    for _ in 0..STEPS {
        if worst <= SOUND {
            return;
        }
        let terms = Terms::new(orbit, response);
        let Some(system) = terms.system().filter(|system| system.reciprocal_condition > f64::EPSILON) else { return };
        let static_displacement = terms.static_displacement();
        step(&mut draft, &system, response, &violations, (static_displacement, orbit.model().period()));
        let inside = draft.impacts.iter().all(|impact| (0.0..response.period()).contains(&impact.2));
        let Ok(next) = Orbit::assemble(orbit.model(), response, motion, draft.clone()) else { return };
        let (next_violations, next_worst) = self::violations(&next, motion);
        if !inside || next_worst >= worst {
            return;
        }
        (*orbit, violations, worst) = (next, next_violations, next_worst);
    }
}

/// The violations of the equations, and the largest relative to the terms that should cancel.
fn violations(orbit: &Orbit, motion: &mut Motion) -> (SmallVec<[(f64, f64); 2]>, f64) {
    let violations: SmallVec<[(f64, f64); 2]> =
        (0..orbit.impacts().len()).map(|i| orbit.violation(i, motion)).collect();
    let (length, velocity) = (orbit.force_response().abs().max(1.0), orbit.velocity_scale());
    let size = |&(position, newton): &(f64, f64)| (position / length).abs().max((newton / velocity).abs());
    let worst = violations.iter().map(size).fold(0.0, f64::max);
    (violations, worst)
}

/// One Newton step of the draft.
fn step(
    draft: &mut Draft,
    system: &System,
    response: &ImpulseResponse,
    violations: &[(f64, f64)],
    (static_displacement, force_period): (f64, f64),
) {
    let layout = system.layout;
    let mut rows = [0.0; MOST];
    for (i, &(position, newton)) in violations.iter().enumerate() {
        rows[i] = position;
        if Terms::has_newton_row(layout, i) {
            rows[layout.impacts + 1 + i] = newton;
        }
    }
    let change = system.solve(&rows);
    for (impact, change) in draft.impacts.iter_mut().zip(&change) {
        impact.3 -= change;
    }
    if let (Some(time), Some(impact)) = (layout.time, draft.impacts.get_mut(1)) {
        impact.2 -= change[time];
    }
    if let Some(psi) = layout.psi {
        draft.psi = (draft.psi - change[psi]).rem_euclid(force_period);
    }
    let static_displacement = static_displacement - change[layout.impacts];
    if let Some(source) = draft.sources.first_mut() {
        source.net_impulse = static_displacement * response.static_stiffness();
    }
    draft.uniform_offset = static_displacement * response.uniform_share();
}

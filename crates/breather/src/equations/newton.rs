//! Newton steps on the equations themselves, for orbits whose reduced equation left digits behind and for words given by
//! hand.
//!
//! The zero of F fixes φ to its own rounding; where the numbers of Cramer's rule nearly vanish together the phase that
//! follows from it is worse than the equations allow. What is left of the equations shows it.

use vibrochain_lattice::ImpulseResponse;

use crate::equations::Equations;
use crate::equations::unknowns::Template;
use crate::motion::Motion;
use crate::orbit::Orbit;

/// Violations below this many roundings of the largest term are as good as zero.
const SOUND: f64 = 16.0 * f64::EPSILON;

/// Steps at most; each squares the error.
pub(crate) const STEPS: usize = 4;

/// The same from a guess, whose first steps only halve it or so.
pub(crate) const STEPS_FROM_AFAR: usize = 50;

/// Violations up to this are those of an orbit whose terms lose a few digits, as next to a fold.
pub(crate) const CONVERGED: f64 = 1e-12;

/// Improves `orbit` by at most `steps` steps, as long as its violations fall, and returns what is left.
pub(crate) fn polish(orbit: &mut Orbit, steps: usize, response: &ImpulseResponse, motion: &mut Motion) -> f64 {
    let mut worst = Equations::new(orbit, response).worst_violation();
    for _ in 0..steps {
        if worst <= SOUND {
            break;
        }
        let Some(next) = improved(orbit, response, motion) else { break };
        let left = Equations::new(&next, response).worst_violation();
        if left < worst {
            (*orbit, worst) = (next, left);
        } else {
            break;
        }
    }
    worst
}

/// One Newton step.
fn improved(orbit: &Orbit, response: &ImpulseResponse, motion: &mut Motion) -> Option<Orbit> {
    let equations = Equations::new(orbit, response);
    let (unknowns, system) = (equations.unknowns, equations.system());
    if system.reciprocal_condition <= f64::EPSILON {
        return None;
    }
    let mut x = unknowns.read(orbit, response);
    let mut rows = equations.residuals();
    // The net impulse is what s says; summed it would only be rounded.
    rows[unknowns.impacts] = 0.0;
    let change = system.solve(&rows);
    x.iter_mut().zip(change).for_each(|(x, change)| *x -= change);
    let draft = Template::of(orbit).draft(&unknowns, &x, orbit.model(), response)?;
    Orbit::assemble(orbit.model(), response, motion, draft).ok()
}

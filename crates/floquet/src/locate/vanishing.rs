//! Where all impulses of a branch vanish together: the motion that the loads drive alone touches a barrier there, the impacts merge, and the equations
//! have no other orbit next to them.

use vibrochain_breather::{BranchPoint, ContactOrbit, LoadedStructure};
use vibrochain_lattice::Barrier;

use super::answer::End;
use super::ends::{BranchEnds, Ended};
use crate::bracket::zero;
use crate::events::strongest;

/// The touch is no farther than this from where the branch is lost, as a part of the range.
const NEAR: f64 = 1e-3;

/// Impulses this much smaller than at the start, or than contacts are fast, are about to vanish.
const FAINT: f64 = 1e-2;

/// Newton's steps for a peak that is nearly met.
const PEAK_STEPS: usize = 6;

/// How far beyond a barrier the driven motion of a contact is at its peak next to a time.
fn beyond(model: &LoadedStructure, (contact, barrier): (usize, Barrier), mut t: f64) -> Option<f64> {
    for _ in 0..PEAK_STEPS {
        let [_, velocity, acceleration, _] = model.driven(contact, t).ok()?;
        t -= velocity / acceleration;
    }
    let [place, ..] = model.driven(contact, t).ok()?;
    Some(barrier.sign() * (place - model.barrier(contact, barrier).ok()?))
}

impl BranchEnds {
    /// The value right ahead of a point, where a branch is lost, at which all impulses vanish; `first` is the strongest where the branch began.
    pub(super) fn vanishing_ahead(&self, point: &BranchPoint, first: f64) -> Option<Ended> {
        let orbit = point.orbit();
        if strongest(orbit) > FAINT * first.max(orbit.speed()) {
            return None;
        }
        let value = self.touch_beside(orbit, point.value())?;
        Some(Ended { value, end: End::ImpulsesVanish, event: None })
    }

    /// The value next to one at which the driven motion alone touches the barrier of an orbit's first impact.
    pub(super) fn touch_beside(&self, orbit: &ContactOrbit, value: f64) -> Option<f64> {
        let (impact, psi) = (orbit.impacts().first()?, orbit.psi()?);
        let family = orbit.model().like(&self.family, &[value]);
        let touch = |value: f64| {
            let model = family(&[value]).ok()?;
            let t = (impact.time + psi) * model.period() / orbit.model().period();
            beyond(&model, (impact.site, impact.barrier), t)
        };
        // Impulses that have turned round by rounding may have led a little beyond it.
        let [from, to] = [-NEAR, NEAR].map(|by| value + by * self.range);
        let (low, high) = (touch(from)?, touch(to)?);
        let differ = (low > 0.0) != (high > 0.0);
        differ.then(|| zero((from, low), (to, high), to.abs(), |value| touch(value).ok_or(())).ok())?
    }
}

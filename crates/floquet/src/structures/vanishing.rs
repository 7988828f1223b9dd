//! Where all impulses of a branch vanish together: the motion that the loads drive alone touches a barrier there, the impacts merge, and the equations
//! have no other orbit next to them.

use vibrochain_breather::{StructureBranchPoint, StructureModel, StructureOrbit};
use vibrochain_lattice::Barrier;

use super::ends::OfStructure;
use crate::bracket::zero;
use crate::events::{EventOrbit, strongest};
use crate::locate::End;
use crate::locate::follower::Ended;

/// The touch is no farther than this from where the branch is lost, as a part of the range.
const NEAR: f64 = 1e-3;

/// Impulses this much smaller than at the start, or than contacts are fast, are about to vanish.
const FAINT: f64 = 1e-2;

/// Newton's steps for a peak that is nearly met.
const PEAK_STEPS: usize = 6;

/// How far beyond a barrier the driven motion of a contact is at its peak next to a time.
fn beyond(model: &StructureModel, (contact, barrier): (usize, Barrier), mut t: f64) -> Option<f64> {
    for _ in 0..PEAK_STEPS {
        let [_, velocity, acceleration, _] = model.driven(contact, t).ok()?;
        t -= velocity / acceleration;
    }
    let [place, ..] = model.driven(contact, t).ok()?;
    Some(barrier.sign() * (place - model.barrier(contact, barrier).ok()?))
}

impl OfStructure {
    /// The value at which all impulses vanish, if it is right ahead of a point where the branch is lost; `first` is the strongest impulse where the
    /// branch began.
    pub(super) fn vanishing_ahead(&self, point: &StructureBranchPoint, first: f64) -> Option<Ended<StructureOrbit>> {
        let orbit = point.orbit();
        let (impact, psi) = (orbit.impacts().first()?, orbit.psi()?);
        if strongest(orbit) > FAINT * first.max(orbit.speed()) {
            return None;
        }
        let touch = |value: f64| {
            let model = (self.family)(&[value]).ok()?;
            let t = (impact.time + psi) * model.period() / orbit.model().period();
            beyond(&model, (impact.contact, impact.barrier), t)
        };
        // Impulses that have turned round by rounding may have led a little beyond it.
        let [from, to] = [-NEAR, NEAR].map(|by| point.value() + by * self.range);
        let (low, high) = (touch(from)?, touch(to)?);
        let differ = (low > 0.0) != (high > 0.0);
        let value = differ.then(|| zero((from, low), (to, high), to.abs(), |value| touch(value).ok_or(())).ok())??;
        Some(Ended { value, end: End::ImpulsesVanish, event: None })
    }
}

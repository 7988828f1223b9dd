//! Where all impulses of a branch vanish together: the motion that the loads drive alone touches a barrier there, the impacts merge, and the equations
//! have no other orbit next to them.

use vibrochain_breather::{StructureBranchPoint, StructureModel};
use vibrochain_lattice::{Barrier, Complex};

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
    let (structure, omega) = (model.structure(), model.omega());
    let resting = structure.still();
    let modes = structure.modes().iter().zip(&resting);
    let still: f64 = modes.map(|(mode, [x, y])| mode.rows[contact][0] * x + mode.rows[contact][1] * y).sum();
    let swings = structure.harmonics().iter().enumerate().map(|(place, harmonic)| {
        let swing = structure.steady_at(place, omega).ok()?[contact];
        Some((f64::from(*harmonic) * omega, swing))
    });
    let swings = swings.collect::<Option<Vec<_>>>()?;
    let derivative = |order: u32, t: f64| -> f64 {
        let of = |(rate, swing): &(f64, Complex<f64>)| {
            (swing * Complex::from_polar(1.0, rate * t) * Complex::new(0.0, *rate).powu(order)).re
        };
        swings.iter().map(of).sum()
    };
    for _ in 0..PEAK_STEPS {
        t -= derivative(1, t) / derivative(2, t);
    }
    Some(barrier.sign() * (still + derivative(0, t) - model.barrier(contact, barrier).ok()?))
}

impl OfStructure {
    /// The end of a branch whose `first` orbit was so strong, where that is right ahead.
    pub(super) fn vanishing_ahead(
        &self,
        point: &StructureBranchPoint,
        first: f64,
    ) -> Option<Ended<vibrochain_breather::StructureOrbit>> {
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

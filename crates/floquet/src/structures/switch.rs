//! At which events branches of a structure leave another.

use vibrochain_breather::{Approach, Departure, Hit, StructureMotion, StructureOrbit};
use vibrochain_lattice::Barrier;

use crate::events::EventOrbit;
use crate::locate::{Event, Evidence, Located};

/// A contact touches a barrier where it is this near to it, over the fastest velocity and ω, and its own velocity this small: a located grazing is
/// known to rounding, its time, a square root, to half the digits.
const TOUCHING: f64 = 1e-9;
const STILL: f64 = 1e-4;

/// Two impacts of one contact within this part of the period are one.
const TOGETHER: f64 = 1e-4;

/// How other orbits leave a branch at an event, if they do.
pub(super) fn departure(located: &Located<StructureOrbit>) -> Option<Departure> {
    let orbit = &located.orbit;
    match (located.event, located.evidence) {
        (Event::Grazing, Evidence::Touch(touch)) => Some(Departure::Touching(touching(orbit, &touch)?)),
        (Event::Grazing, Evidence::Impact(lost)) => {
            // Where all are lost nothing is left.
            let slow = STILL * orbit.speed();
            let left = orbit.impacts().iter().any(|impact| impact.velocity_before.abs() > slow);
            left.then_some(Departure::Without(lost))
        }
        (Event::PeriodDoubling, _) if !orbit.is_conservative() => Some(Departure::PeriodDoubling),
        (Event::Pitchfork, _) => Some(Departure::Pitchfork),
        _ => None,
    }
}

/// All contacts that touch a barrier where one does: symmetry may have several do it at once, half a period later, or at the mirror image of its
/// time.
fn touching(orbit: &StructureOrbit, touch: &Approach) -> Option<Vec<Hit>> {
    let (model, period) = (orbit.model(), orbit.period());
    let motion = StructureMotion::new(orbit).ok()?;
    let speed = orbit.speed();
    let mut hits: Vec<Hit> = Vec::new();
    for time in [touch.time, period - touch.time, touch.time + 0.5 * period, 1.5 * period - touch.time] {
        let time = time.rem_euclid(period);
        let last = orbit.impacts().iter().rposition(|impact| impact.time <= time)?;
        for contact in 0..model.structure().contacts().len() {
            let [place, velocity, _] = motion.contact(contact, last, time - orbit.impacts()[last].time);
            for barrier in [Barrier::Lower, Barrier::Upper] {
                let near = model.barrier(contact, barrier).is_ok_and(|wall| {
                    (place - wall).abs() * model.omega() <= TOUCHING * speed && velocity.abs() <= STILL * speed
                });
                let apart = |other: f64| {
                    let apart = (other - time).rem_euclid(period);
                    apart.min(period - apart) > TOGETHER * period
                };
                let own = orbit.impacts().iter().filter(|impact| impact.contact == contact).map(|impact| impact.time);
                let known = hits.iter().filter(|hit| hit.site == contact).map(|hit| hit.time);
                if near && own.chain(known).all(apart) {
                    hits.push(Hit::new(contact, barrier, time, 0.0));
                }
            }
        }
    }
    (!hits.is_empty()).then_some(hits)
}

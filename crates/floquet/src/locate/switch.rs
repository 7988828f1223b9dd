//! At which events branches leave another, and the first step along one.

use vibrochain_breather::system::System;
use vibrochain_breather::{Approach, ContactOrbit, Departure, Hit, SolutionCurve, SolutionPoint};
use vibrochain_lattice::Barrier;

use super::answer::{Event, Evidence, Located};
use vibrochain_breather::time_between;

/// A contact touches a barrier where it is this near to it, over the fastest velocity and ω, and its own velocity this small: a located grazing is
/// known to rounding, its time, a square root, to half the digits.
const TOUCHING: f64 = 1e-9;
const STILL: f64 = 1e-4;

/// Two impacts of one contact within this part of the period are one.
const TOGETHER: f64 = 1e-4;

/// The first step along a branch that leaves another, in units: far enough for the two to be told apart. Six tries end at 5e-6.
const FIRST: f64 = 0.005;
const TRIES: i32 = 6;

/// Lengths of a step to be tried one after the other, each a quarter of the last: next to a fold the first is too long.
pub(super) fn shrinking(longest: f64, tries: i32) -> impl Iterator<Item = f64> {
    (0..tries).map(move |i| longest * 0.25f64.powi(i))
}

/// How orbits of less symmetry leave one at a bifurcation, if they do.
pub(super) fn bifurcation(event: Event, orbit: &ContactOrbit) -> Option<Departure> {
    match event {
        Event::PeriodDoubling if !orbit.is_conservative() => Some(Departure::PeriodDoubling),
        Event::Pitchfork => Some(Departure::Pitchfork),
        _ => None,
    }
}

/// How orbits of another kind leave a branch at an event, if they do.
pub(super) fn departure(located: &Located, orbit: &ContactOrbit) -> Option<Departure> {
    match (located.event, located.evidence) {
        (Event::Grazing, Evidence::Touch(touch)) => Some(Departure::Touching(touching(orbit, &touch)?)),
        (Event::Grazing, Evidence::Impact(lost)) => {
            // Where all are lost nothing is left.
            let slow = STILL * orbit.speed();
            let left = orbit.impacts().iter().any(|impact| impact.velocity_before.abs() > slow);
            left.then_some(Departure::Without(lost))
        }
        (event, _) => bifurcation(event, orbit),
    }
}

/// All contacts that touch a barrier where one does: symmetry may have several do it at once, half a period later, or at the mirror image of its
/// time.
fn touching(orbit: &ContactOrbit, touch: &Approach) -> Option<Vec<Hit>> {
    let (period, speed, own) = (orbit.period(), orbit.speed(), orbit.hits());
    let mut hits: Vec<Hit> = Vec::new();
    for time in [touch.time, period - touch.time, touch.time + 0.5 * period, 1.5 * period - touch.time] {
        let time = time.rem_euclid(period);
        for (contact, [place, velocity]) in orbit.states(time).ok()?.into_iter().enumerate() {
            for barrier in [Barrier::Lower, Barrier::Upper] {
                let near = orbit.model().barrier_at(contact, barrier).is_ok_and(|wall| {
                    (place - wall).abs() * orbit.model().omega() <= TOUCHING * speed && velocity.abs() <= STILL * speed
                });
                let apart = |other: f64| time_between(other, time, period) > TOGETHER * period;
                let known = || own.iter().chain(&hits).filter(|hit| hit.site == contact).map(|hit| hit.time);
                if near && known().all(apart) {
                    hits.push(Hit::new(contact, barrier, time, 0.0));
                }
            }
        }
    }
    (!hits.is_empty()).then_some(hits)
}

/// The first point of a branch that leaves another, on the side where its orbits are.
pub(crate) fn first_step<S: System>(
    branch: &mut SolutionCurve<S>,
    start: &SolutionPoint<S::Orbit>,
    departure: &Departure,
    mut is_physical: impl FnMut(&S::Orbit) -> bool,
) -> Option<SolutionPoint<S::Orbit>> {
    let mut taken = |sign: f64| shrinking(FIRST, TRIES).find_map(|length| branch.step(start, sign * length).ok());
    if matches!(departure, Departure::Pitchfork | Departure::PeriodDoubling) {
        // The other way leads to the same orbits, mirrored or begun later.
        return taken(1.0);
    }
    let ways: Vec<_> = [1.0, -1.0]
        .into_iter()
        .filter_map(|sign| taken(sign).map(|point| if sign < 0.0 { point.reversed() } else { point }))
        .collect();
    ways.into_iter().find(|point| is_physical(point.orbit()))
}

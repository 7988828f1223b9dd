//! What figures of orbits, branches and curves hold.

pub(crate) mod contact_panes;
pub(crate) mod diagram;
pub(crate) mod event_curves;
pub(crate) mod orbit_panes;

use vibrochain_floquet::Event;

use crate::panels::curves::Mark;

/// The shape that stands for a cusp: a star, which no event has.
const CUSP: usize = 5;

/// The shape of the event that stands at the star's place.
const STICKING: usize = 6;

/// How what happens at a point is marked, in every picture alike: an event by its filled shape; a resonance of multipliers by an outline, of three or
/// four corners where it is 1:3 or 1:4.
pub(crate) fn mark(name: &str) -> Mark {
    match name {
        "1:1" => Mark::Hollow(0),
        "1:2" => Mark::Hollow(3),
        "1:3" => Mark::Hollow(2),
        "1:4" => Mark::Hollow(1),
        _ => Mark::Filled(match Event::from_name(name) {
            None => CUSP,
            Some(Event::Sticking) => STICKING,
            Some(event) => event as usize,
        }),
    }
}

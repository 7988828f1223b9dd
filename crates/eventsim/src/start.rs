//! Whence runs start: the state given, checked, and what contacts on their barriers do there.

use std::sync::Arc;

use crate::cascade::Change;
use crate::error::StateError;
use crate::event_loop::EventLoop;
use crate::flight::Flight;
use crate::flight::modal_flight::ModalFlight;
use crate::flight::places::Place;
use crate::flight::rest_series::Series;
use crate::flight::system::System;
use crate::motion::Motion;
use crate::watch::Contact;
use vibrochain_lattice::{Barrier, ModalStructure, Model};

/// Largest speed and force in units of the gap and of the fastest rate.
const FASTEST: f64 = 1e12;

/// How far behind a barrier a mass may start: the rounding of its displacement. It is put on the barrier.
const OVERSHOOT: f64 = 4.0 * f64::EPSILON;

/// Nearer to a barrier than this a mass is measured from there: its distance is known as well as its displacement.
const NEAR: f64 = 0.25;

/// How far behind a barrier modes may put a contact, relative to the terms it is made of: it is put on the barrier.
const OVERSHOOT_OF_MODES: f64 = 1e-12;

/// Rounding of a place, relative to the same: a contact so close to its barrier is on it.
const ON: f64 = 16.0 * f64::EPSILON;

/// Coordinates of modes beyond this are as good as infinite.
const LARGEST: f64 = 1e100;

/// From displacements and velocities of all masses of a chain.
pub(crate) fn of_masses(model: &Model, psi: f64, [u, v]: [&[f64]; 2]) -> Result<EventLoop, StateError> {
    let (sites, layout) = (model.chain().sites(), model.chain().layout());
    let name = |site: usize| format!("site {}", layout.name(site));
    for (what, values) in [("displacement", u), ("velocity", v)] {
        if values.len() != sites {
            return Err(StateError::Length { name: what, found: values.len(), sites });
        }
        if let Some(site) = values.iter().position(|x| !x.is_finite()) {
            return Err(StateError::not_finite(format!("{what} of {}", name(site)), values[site]));
        }
    }
    let system = System::of_chain(model, phase(psi, model.period())?);
    let fastest = system.fastest;
    let limit = FASTEST * fastest;
    if let Some(&value) = v.iter().find(|v| v.abs() > limit) {
        return Err(StateError::TooFast { name: "velocity", value, limit });
    }
    let limit = FASTEST * fastest * fastest;
    if model.amplitude() > limit {
        return Err(StateError::TooFast { name: "amplitude", value: model.amplitude(), limit });
    }
    let mut near = Vec::new();
    let mut within = u.to_vec();
    for (site, u) in within.iter_mut().enumerate() {
        for barrier in [Barrier::Lower, Barrier::Upper] {
            let position = model.barrier(barrier);
            let outside = barrier.sign() * (*u - position);
            if outside > OVERSHOOT {
                return Err(StateError::outside((site, name(site)), barrier, [*u, position]));
            }
            *u = if outside > 0.0 { position } else { *u };
            if outside > -NEAR {
                near.push((site, barrier, *u - position));
                break;
            }
        }
    }
    let flight = Flight::of_coordinates(&system, [within, v.to_vec()]);
    let mut motion = Motion::with(system, flight);
    for &(site, barrier, x) in &near {
        motion.anchor(site, barrier, x);
    }
    let mut untold = Vec::new();
    for &(site, barrier, _) in near.iter().filter(|(.., x)| *x == 0.0) {
        let outward = barrier.sign() * v[site];
        if outward == 0.0 {
            motion.rest_or_leave(site, barrier, &mut untold);
        } else if outward < 0.0 {
            motion.places.touch(site, Contact::Leaving(barrier, 1));
        }
    }
    Ok(EventLoop::new(motion, Vec::new(), untold))
}

/// From ξ of all modes of a structure.
pub(crate) fn of_modes(
    structure: Arc<ModalStructure>,
    (omega, psi): (f64, f64),
    modes: &[[f64; 2]],
) -> Result<EventLoop, StateError> {
    let wanted = structure.modes().len();
    if modes.len() != wanted {
        return Err(StateError::Modes { given: modes.len(), wanted });
    }
    let range = |what: &str, value, requirement| Err(StateError::Range { what: what.to_owned(), value, requirement });
    if !(omega.is_finite() && omega > 0.0) {
        return range("omega", omega, "a frequency above 0");
    }
    let psi = phase(psi, std::f64::consts::TAU / omega)?;
    if let Some(value) = modes.iter().flatten().find(|value| !is_sound(value)) {
        return range("the state of a mode", *value, "numbers between -1e100 and 1e100");
    }
    let system = System::new(structure, omega, psi).local_if_faster();
    let mut motion = Motion::new(system, modes);
    let measured = motion.system.about_equilibrium(modes);
    let reach = motion.system.reach(&measured).into_iter().map(|reach| reach.min(LARGEST)).collect();
    let mut touching = Vec::new();
    for contact in 0..motion.places.len() {
        let terms = motion.system.seen_by(contact).map(|(k, _, row)| [row[0] * modes[k][0], row[1] * modes[k][1]]);
        let (value, terms) = terms.flatten().fold((0.0, 0.0), |(sum, size), term| (sum + term, size + term.abs()));
        for barrier in [Barrier::Lower, Barrier::Upper] {
            let Some(place) = motion.system.limits(contact).barrier(barrier) else { continue };
            let excess = barrier.sign() * (value - place);
            let size = terms + place.abs() + motion.system.origins[contact].abs();
            if excess > OVERSHOOT_OF_MODES * size {
                return Err(StateError::outside((contact, format!("contact {contact}")), barrier, [value, place]));
            }
            if excess >= -ON * size {
                motion.anchor(contact, barrier, 0.0);
                touching.push((contact, barrier));
            }
        }
    }
    let untold = part_or_rest(&mut motion, measured, &touching);
    Ok(EventLoop::new(motion, reach, untold))
}

/// Contacts on their barriers are at rest, leave, or (the queue's business) are about to hit; with the events of that.
fn part_or_rest(motion: &mut Motion, measured: Vec<[f64; 2]>, touching: &[(usize, Barrier)]) -> Vec<Change> {
    let mut untold = Vec::new();
    let flight = ModalFlight::new(&motion.system, measured, 0.0);
    let series = Series::tendencies(&motion.system, &flight, &motion.places);
    for &(contact, barrier) in touching {
        let outward = barrier.sign() * series.contacts[contact][1];
        if outward.abs() <= 4.0 * series.doubts[contact][1] {
            motion.rest_or_leave(contact, barrier, &mut untold);
        } else if outward < 0.0 {
            let v = Some(barrier.sign() * outward / series.length);
            motion.places.set(contact, Place { v, touch: Contact::Leaving(barrier, 1), ..motion.places[contact] });
        }
    }
    untold
}

/// The force repeats: a phase of many periods is brought into one.
fn phase(psi: f64, period: f64) -> Result<f64, StateError> {
    if psi.is_finite() { Ok(psi.rem_euclid(period)) } else { Err(StateError::not_finite("psi".to_owned(), psi)) }
}

/// Neither infinite nor as good as that, nor not a number.
fn is_sound(value: &f64) -> bool {
    value.abs() <= LARGEST
}

//! Flight from a base, by modes or by local series.
//!
//! Local series carry coordinates: the masses of a chain, and those of any structure with a diagonal M where that is faster. By modes ξ flies by
//! e^{At} of each mode, whatever the ratio of their rates, and a contact is a sum of damped sines, of which bounds are known. Where a contact
//! rests on its barrier, or leaves it so slowly that only its own distance tells it from resting, modes fly by a Taylor series with the forces of
//! resting contacts in it.
//!
//! | file | holds |
//! |---|---|
//! | `loads` | what static and harmonic loads add to each mode, at resonances and to rigid modes, too |
//! | `system` | the structure and what stays the same during a run |
//! | `local`, `local_flight`, `local_part`, `local_reading` | local series of coordinates, flight by them, their windows and restarts, what they tell |
//! | `modal_flight` | exact flight in modes |
//! | `approach` | a certified step towards the first contact, by modes |
//! | `rest_series` | Taylor series of modes with resting contacts |
//! | `near` | what contacts do at an instant, by either |
//! | `places` | where contacts are, and which of them are at a barrier |

pub(crate) mod approach;
pub(crate) mod loads;
pub(crate) mod local;
pub(crate) mod local_flight;
pub(crate) mod local_part;
pub(crate) mod local_reading;
pub(crate) mod modal_flight;
pub(crate) mod near;
pub(crate) mod places;
pub(crate) mod rest_series;
pub(crate) mod system;

use crate::flight::local_flight::LocalFlight;
use crate::flight::modal_flight::ModalFlight;
use crate::flight::near::Tendencies;
use crate::flight::places::Places;
use crate::flight::rest_series::Series;
use crate::flight::system::System;
use vibrochain_lattice::Complex;

/// State at the base, with all that its flight needs.
#[derive(Debug, Clone)]
pub(crate) enum Flight {
    Modes(ModalFlight),
    Local(Box<LocalFlight>),
}

impl Flight {
    /// From ξ measured from where the static load holds the modes, at a time within a period.
    pub(crate) fn new(system: &System, xi: Vec<[f64; 2]>, offset: f64) -> Self {
        match &system.local {
            Some(local) => Self::Local(Box::new(LocalFlight::of_modes(system, local.clone(), &xi, offset))),
            None => Self::Modes(ModalFlight::new(system, xi, offset)),
        }
    }

    /// From q and q′ of a system that flies by its coordinates.
    pub(crate) fn of_coordinates(system: &System, state: [Vec<f64>; 2]) -> Self {
        let turned = system.loads.turned(0.0);
        match &system.local {
            Some(local) => Self::Local(Box::new(LocalFlight::new(system, local.clone(), state, turned))),
            None => Self::Modes(ModalFlight::new(system, Vec::new(), 0.0)),
        }
    }

    /// e^{iw(t+ψ)} of each load.
    pub(crate) fn turned(&self) -> &[Complex<f64>] {
        match self {
            Self::Modes(flight) => &flight.turned,
            Self::Local(flight) => &flight.turned,
        }
    }

    /// g of a contact at the base.
    pub(crate) fn place(&self, system: &System, contact: usize) -> f64 {
        match self {
            Self::Modes(flight) => flight.place(system, contact),
            Self::Local(flight) => flight.place(contact),
        }
    }

    /// g′ of a contact at the base.
    pub(crate) fn velocity(&self, system: &System, contact: usize) -> f64 {
        match self {
            Self::Modes(flight) => flight.velocity(system, contact),
            Self::Local(flight) => flight.velocity(contact),
        }
    }

    /// How far it swings: in flight g has some units in the last place of that as its rounding.
    pub(crate) fn scale(&self, system: &System, contact: usize) -> f64 {
        match self {
            Self::Modes(flight) => flight.scale(system, contact),
            Self::Local(flight) => flight.scale(contact),
        }
    }

    /// An impulse at a contact.
    pub(crate) fn strike(&mut self, system: &System, contact: usize, impulse: f64) {
        match self {
            Self::Modes(flight) => flight.strike(system, contact, impulse),
            Self::Local(flight) => flight.strike(contact, impulse),
        }
    }

    /// Moves contact `contact` without moving it on: M⁻¹w times `amount` is added to the coordinates.
    pub(crate) fn shift(&mut self, system: &System, contact: usize, amount: f64) {
        match self {
            Self::Modes(flight) => flight.shift(system, contact, amount),
            Self::Local(flight) => flight.shift(contact, amount),
        }
    }

    /// Moves contact `contact` by `amount`, and stiff modes next to nothing.
    pub(crate) fn lean(&mut self, system: &System, contact: usize, amount: f64) {
        match self {
            Self::Modes(flight) => flight.lean(system, contact, amount),
            Self::Local(flight) => flight.shift(contact, amount / system.mobility(contact, contact)),
        }
    }

    /// Where contacts tend to.
    pub(crate) fn tendencies(&self, system: &System, places: &Places) -> Tendencies {
        match self {
            Self::Modes(flight) => Tendencies::Modes(Series::tendencies(system, flight, places)),
            Self::Local(flight) => flight.tendencies(system, places),
        }
    }

    /// Takes note of an event at `s`.
    pub(crate) fn note_event(&mut self, s: f64) {
        if let Self::Local(flight) = self {
            flight.pace.note_event(s * flight.local.scale);
        }
    }
}

//! Event-driven simulation of any linear structure with stops: one loop.
//!
//! Local series carry coordinates as they carry the masses of a chain ([`crate`]). By modes ξ flies by e^{At} of each mode, whatever the ratio of their rates, and a contact is
//! a sum of damped sines, of which bounds are known. Where a contact rests on its barrier, or leaves it so slowly that only its own
//! distance tells it from resting, the motion is a Taylor series with the forces of resting contacts in it.
//!
//! | file | holds |
//! |---|---|
//! | `loads` | what static and harmonic loads add to each mode, at resonances and to rigid modes, too |
//! | `system` | the structure and what stays the same during a run |
//! | `local`, `local_flight`, `local_part` | local series of coordinates, flight by them, their windows and restarts |
//! | `modal_flight` | exact flight in modes |
//! | `flight` | either of both |
//! | `near` | what contacts do at an instant, by either |
//! | `places` | where contacts are, and which of them are at a barrier |
//! | `approach` | a certified step towards the first contact |
//! | `series` | Taylor series with resting contacts |
//! | `motion` | the state between events: modes, contacts, clock |
//! | `reading` | what it tells at any time |
//! | `collision` | impacts, in sequence where contacts share coordinates |
//! | `rest` | chatter, rest and release |
//! | `event` | what a run reports |
//! | `tangent` | small perturbations of a run, to first order |
//! | `event_loop` | the event loop |
//! | `simulation` | a run from modes |

mod approach;
mod collision;
mod event;
mod event_loop;
mod flight;
mod loads;
mod local;
mod local_flight;
mod local_part;
mod modal_flight;
mod motion;
mod near;
mod places;
mod reading;
mod rest;
mod series;
mod simulation;
mod system;
mod tangent;

pub use event::{ContactEvent, StructureOutcome, StructureReport, StructureStateError};
pub use local::FlightChoice;
pub use rest::CHATTER_TIME;
pub use simulation::{ContactState, StructureSimulation, StructureState};
pub use tangent::StructureTangents;

pub(crate) use event_loop::EventLoop;
pub(crate) use flight::Flight;
pub(crate) use motion::Motion;
pub(crate) use system::System;
pub(crate) use tangent::{Alone, Company, Riders, TangentVectors};

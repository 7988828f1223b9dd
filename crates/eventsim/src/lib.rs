//! Event-driven simulation of vibro-impact chains.

mod bound;
mod collision;
mod engine;
mod error;
mod event;
mod restart;
mod ring;
mod series;
mod simulation;
mod time;
mod units;
mod watch;

pub use collision::CHATTER_TIME;
pub use error::StateError;
pub use event::{BOUNCE_TIME, Event, EventKind, Limits, MAX_BOUNCES, MAX_FLIGHTS, Outcome, Report, Work};
pub use simulation::{Simulation, State};
pub use time::Time;

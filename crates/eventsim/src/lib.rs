//! Event-driven simulation of vibro-impact chains, and of any linear structure with stops: exact flight between certified events.
//!
//! ```text
//! Model, state ──> Simulation ── run(Limits) ────────> Event, Event, …; Report: Outcome, Time, Work
//!                      └──────── run_with(Tangents) ─> Growth ──> Exponent
//! ```
//!
//! The unit masses of a lattice, each between two rigid barriers at a − 1 and a + 1, move freely until one of them meets a
//! barrier. On a ring
//!
//! ```text
//! ü_n = −γ₁u_n − γ₂(2u_n − u_{n+1} − u_{n−1}) + F(t+ψ) ,      |u_n − a| ≤ 1 ,      v⁺ = −e v⁻ ,
//! ```
//!
//! and the same in rows with free or fixed ends and in several layers, as a [`Chain`](vibrochain_lattice::Chain) has them. A
//! [`ModalStructure`](vibrochain_lattice::ModalStructure) has contacts g = wᵀq, each at one barrier or between two, instead of masses; one event
//! loop serves both, and flies by local series of coordinates or by modes.
//!
//! Three things are promised:
//! - **No time-step error.** Between events the motion is the Taylor series of the exact flow, with a remainder below
//!   rounding, at every size of lattice and with masses at rest on their barriers.
//! - **No missed event.** The next contact of *any* mass is found with bounds on derivatives, not by samples: a contact
//!   cannot hide between two points, be it a peak 1e-6 beyond a barrier or two masses 1e-12 apart in time. The argument
//!   is below.
//! - **An outcome, always.** Accumulations of impacts are completed at their limit and the mass rests until the force
//!   lets it go; what cannot be resolved ends the run with an [`Outcome`] that says so.
//!
//! Nothing here knows closed-form orbits or their stability; agreement with them is evidence.
//!
//! # Why no impact is missed
//!
//! 1. At the start of a window of length H every mass's motion x(s) is a polynomial, exact to rounding for as long as
//!    no event touches it (`series`, `flight::local`). One nested pass (`series::bound`) gives an upper and a lower bound of x over the
//!    whole of \[0, H\]. A mass whose bounds, enlarged by their own rounding, stay inside the gap has no contact in the
//!    window.
//! 2. Every other mass has one entry in a queue, with a time before which it has no contact: at first from the bound,
//!    then from steps to the first root of a parabola that lies below its distance to the barrier (`watch`). The
//!    parabola's curvature is a bound over the window, so a step never passes a contact.
//! 3. The mass with the earliest such time is advanced until it is not the earliest any more, or its contact is reached.
//!    A contact that is reached while its time is the earliest is therefore the first of all masses (`motion`).
//! 4. After an event the masses that can feel it within the window, to rounding, get new polynomials, bounds and
//!    entries from that instant on; those of the others remain true (`flight::local_part`).
//!
//! A distance below four units in the last place of its terms counts as a contact; no tolerance is larger.
//!
//! # Conventions
//!
//! Everything is dimensionless, as in `vibrochain_lattice`: mass and half the gap are 1, times are in the units of 1/ω, 1/√γ.
//! Masses are numbered as a [`Chain`](vibrochain_lattice::Chain) numbers them, 0 … M−1 in one row. Velocities are signed, positive towards the upper barrier. The start is t = 0; the force is
//! A cos ω(t+ψ), or Σ A_j cos(jω(t+ψ) + θ_j). A [`Time`] is a number of whole periods T = 2π/ω and a rest. A state at the time of an event is that
//! after it.
//!
//! | name | what it is |
//! |---|---|
//! | [`Time`] | a clock that does not drift |
//! | [`Event`], [`Limits`], [`Outcome`], [`Work`] | impacts, sticking and release; when a run ends, and what it took |
//! | [`Tangents`] | small perturbations of a run, to first order |
//! | [`Growth`] | from what they have grown to an exponent and its error |
//! | [`Simulation`], [`State`], [`ContactState`] | a run of a chain, or of any linear structure with stops |
//! | [`FlightChoice`] | whether it flies by modes or by local series |
//!
//! With the feature `serde` values are written by the names of `mapgen`'s tables; those without a [`Time`] are read, too.
//!
//! # Example
//!
//! A hot ring of five: all impacts of ten periods, and the energy that is left.
//!
//! ```
//! use vibrochain_eventsim::{EventKind, Limits, Outcome, Simulation, Time};
//! use vibrochain_lattice::{Chain, Model, Point};
//!
//! let model = Point::ring(5).gamma1(0.2).gamma2(0.1).omega(1.5).asymmetry(0.4).restitution(0.9).model()?;
//! let mut simulation = Simulation::new(&model, 0.0, &[0.0; 5], &[2.0, -1.0, 1.5, 0.5, -0.5])?;
//! let start = simulation.energy().ok_or("unknown")?;
//! let (report, events) = simulation.collect(&Limits::until(Time::new(&model, 10, 0.0)));
//! assert_eq!(report.outcome, Outcome::TimeReached);
//! // Each impact takes (1−e²)v²/2.
//! let lost: f64 = events.iter().map(|e| 0.5 * (e.velocity_before.powi(2) - e.velocity_after.powi(2))).sum();
//! assert!(events.iter().all(|e| e.kind == EventKind::Impact));
//! assert!((start - lost - simulation.energy().ok_or("unknown")?).abs() < 1e-13);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod balance;
mod cascade;
mod collision;
mod directions;
mod error;
mod event;
mod event_loop;
mod flight;
mod growth;
mod motion;
mod reading;
mod rest;
mod series;
mod simulation;
mod start;
mod stop_check;
mod tangent;
mod time;
mod units;
mod watch;
mod with_tangents;

pub use balance::EnergyBalance;
pub use error::{StateError, TangentError};
pub use event::{BOUNCE_TIME, Event, EventKind, Limits, MAX_BOUNCES, MAX_FLIGHTS, Outcome, Report, Work};
pub use flight::local::FlightChoice;
pub use growth::{Exponent, Growth};
pub use rest::CHATTER_TIME;
pub use simulation::{ContactState, Simulation, State};
pub use tangent::Tangents;
pub use time::Time;

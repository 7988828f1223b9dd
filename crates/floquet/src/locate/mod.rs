//! Where a branch of orbits bifurcates: the value of one parameter at which a multiplier meets +1, −1 or the circle, at which
//! a mass touches a barrier, or at which the branch turns back.
//!
//! | event | what vanishes |
//! |---|---|
//! | fold | det ∂F/∂x of the orbit's equations, solved together with them; the branch ends there in the parameter |
//! | pitchfork | det ∂F/∂x where the branch goes on; for conservative orbits det(ν−1) times all impulses |
//! | period doubling | det(M+1) on the even subspace, for conservative orbits det(ν+1), times all impulses |
//! | Neimark–Sacker | \|μ\|² − 1 of one pair, followed; without loss (ν₁−ν₂)² of the two that collide |
//! | grazing | the smallest distance of any mass to a barrier, or the velocity before an impact |
//!
//! The branch is followed both ways from the start by its length ([`vibrochain_breather::Branch`]); where a function
//! changes sign the zero is bracketed and found by Brent's method in that length. The error of the parameter is what
//! rounding is seen to do to function and parameter next to the zero, and what rounding of all other parameters would do.
//! One that is wider than the distance over which the sign was seen to change is no claim ([`Unresolved`]).
//!
//! At a period doubling of a single-sided orbit the doubled orbit is handed over, at a pitchfork of a double-sided one the
//! pair of asymmetric orbits, on the side where they exist.
//!
//! A conservative orbit has a multiplier +1 besides its trivial pair also where its energy is extreme as ω goes on along the
//! branch. That is found as a pitchfork, too, but nothing is handed over: nothing branches off.

mod answer;
mod beside_resonance;
mod between;
mod branch_off;
mod chain;
mod collision;
mod course;
mod crossings;
mod diagram;
mod follow;
pub(crate) mod follower;
mod seen;
#[cfg(feature = "serde")]
mod serde_impl;
mod settle;
mod switch;

pub use answer::{Answer, BranchedOrbit, Branching, End, Event, Evidence, LocateError, Located, Search, Unresolved};
pub use chain::{locate, locate_until};
pub use course::{Course, Diagram, DiagramPoint, FollowedBranch, Origin, Station, is_physical_about};
pub(crate) use diagram::{Tracing, both_ways, grown};
pub use diagram::{diagram, diagram_until};

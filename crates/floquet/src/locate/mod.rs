//! Where a branch of orbits bifurcates: the value of one parameter at which a multiplier meets +1, −1 or the circle, at which
//! a mass touches a barrier, or at which the branch turns back.
//!
//! | module | holds |
//! |---|---|
//! | `answer`, `course` | what is asked, and what is answered |
//! | `follower` | who follows a branch and finds what happens on it |
//! | `diagram`, `switch`, `branch_off` | the branches that leave a branch |
//! | `ends`, `vanishing` | what stands at the ends of branches, and beside them |
//! | `lattice` | branches of a lattice's orbits |
//!
//! The branch is followed both ways from the start by its length ([`vibrochain_breather::Branch`]); where a test function (`events`)
//! changes its sign, the orbit's equations are solved together with it. The error of the parameter is what rounding of both does to it.
//! One that is wider than the step is no claim ([`Unresolved`]).
//!
//! At a period doubling the doubled orbit is handed over, at a pitchfork the pair of asymmetric orbits, on the side where they exist.
//!
//! A conservative orbit has a multiplier +1 besides its trivial pair also where its energy is extreme as ω goes on along the
//! branch. That is found as a pitchfork, too, but nothing is handed over: nothing branches off.

mod answer;
pub(crate) mod branch_off;
mod course;
mod diagram;
mod ends;
pub(crate) mod follower;
mod lattice;
#[cfg(feature = "serde")]
mod serde_impl;
mod switch;
mod vanishing;

pub use answer::{
    Answer, BranchedOrbit, Branching, End, Event, EventSide, Evidence, LocateError, Located, Search, Unresolved,
};
pub use course::{Course, Diagram, DiagramPoint, FollowedBranch, Origin, Station, is_physical_about};
pub use diagram::{BranchRequest, branch_events, branches};
pub use lattice::{diagram, diagram_until, locate, locate_until};

//! Events of orbits as solutions: where a test function vanishes.
//!
//! | module | holds |
//! |---|---|
//! | `by_matrix` | multipliers where determinants do not count them |
//! | `mirrored` | ν = ½(μ + 1/μ) of orbits that are their own mirror images in time, with impacts at several contacts |
//! | `half_sums` | spectra on their way: pairs, and those that meet on the circle |
//! | `order` | without losses, the order of pairs along the circle, with their Krein signatures |
//! | `regular` | det J(z), made regular, and what rounding does to it |
//! | `test_function` | what vanishes at each event |
//! | `rounding` | what rounding does to that |
//! | `unfolding` | what makes the equations regular where symmetry is lost |
//! | `system` | the orbit's equations with a test function: an event is a point, over two numbers a curve |
//! | `watcher` | who looks at orbits on the way |

pub(crate) mod by_matrix;
pub(crate) mod half_sums;
mod mirrored;
mod order;
mod poles;
mod regular;
mod rounding;
mod system;
mod test_function;
mod unfolding;
mod watcher;

pub(crate) use order::Order;
pub(crate) use poles::{resonance_beside, room, without_poles};
pub(crate) use system::{AtEvent, EventSystem, Solved, solve};
pub(crate) use test_function::{Test, another_one, minus_one};
pub(crate) use watcher::{FAINT, TOUCHES, UNBOUNDED, Watcher, bounded, strongest};

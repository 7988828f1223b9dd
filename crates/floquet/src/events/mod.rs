//! Events of orbits as solutions: where a test function vanishes, of a chain's orbits or of any structure's.
//!
//! | module | holds |
//! |---|---|
//! | `orbit` | what is asked of an orbit |
//! | `half_sums` | spectra on their way: pairs, and those that meet on the circle |
//! | `of_chains` | who looks at a chain's orbits |
//! | `regular` | det J(z), made regular, and what rounding does to it |
//! | `test_function` | what vanishes at each event |
//! | `rounding` | what rounding does to that |
//! | `unfolding` | what makes the equations regular where symmetry is lost |
//! | `system` | the orbit's equations with a test function: an event is a point, over two numbers a curve |
//! | `watcher` | who looks at orbits on the way |

pub(crate) mod half_sums;
mod of_chains;
mod orbit;
mod regular;
mod rounding;
mod system;
mod test_function;
mod unfolding;
mod watcher;

pub(crate) use of_chains::OfChains;
pub(crate) use orbit::EventOrbit;
pub(crate) use system::{AtEvent, EventSystem, Solved, solve};
pub(crate) use test_function::{Test, another_one, minus_one};
pub(crate) use watcher::{Spectrum, TOUCHES, UNBOUNDED, Watcher, strongest};

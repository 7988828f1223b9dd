//! Events of orbits as solutions: where a test function vanishes, of a chain's orbits or of any structure's.
//!
//! | module | holds |
//! |---|---|
//! | `orbit` | what is asked of an orbit |
//! | `regular` | det J(z), made regular, and what rounding does to it |
//! | `test_function` | what vanishes at each event |
//! | `rounding` | what rounding does to that |
//! | `unfolding` | what makes the equations regular where symmetry is lost |
//! | `system` | the orbit's equations with a test function: an event is a point, over two numbers a curve |

mod orbit;
mod regular;
mod rounding;
mod system;
mod test_function;
mod unfolding;

pub(crate) use orbit::EventOrbit;
pub(crate) use system::{AtEvent, EventSystem, Solved, solve};
pub(crate) use test_function::{Test, another_one, minus_one};

//! The one predictor–corrector: orbits over one free parameter, a branch, and events over two, a curve; and lines through a window of two.
//!
//! | module | holds |
//! |---|---|
//! | `line` | lines through a window of two parameters, point by point |
//! | `pace` | how long steps are |
//! | `solution_curve` | steps along tangents, and the points they lead to |
//! | `system` | any equations that are followed, and Newton's method |
//! | `walk` | the one loop of steps |

pub mod line;
pub(crate) mod pace;
pub(crate) mod solution_curve;
pub mod system;
pub mod walk;

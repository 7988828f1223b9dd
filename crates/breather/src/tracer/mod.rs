//! The one predictor–corrector: orbits over one free parameter, a branch, and events over two, a curve; and lines through a window of two.
//!
//! | module | holds |
//! |---|---|
//! | `corrector` | the equations of a chain's orbits, with free parameters |
//! | `line` | lines through a window of two parameters, point by point |
//! | `pace` | how long steps are |
//! | `solution_curve` | steps along tangents, and the points they lead to |
//! | `reduction` | orbits of a symmetry among themselves |
//! | `system` | any equations that are followed, and Newton's method |
//! | `walk` | the one loop of steps |

pub(crate) mod corrector;
pub mod line;
pub(crate) mod pace;
pub(crate) mod reduction;
pub(crate) mod solution_curve;
pub mod system;
pub mod walk;

//! What becomes of perturbed breathers.

mod end;
mod ensemble;
mod exponent;
mod follow;
mod repeat;
mod run;
mod start;

pub use end::End;
pub use ensemble::{Ensemble, OutOfRange};
pub use exponent::{Measured, Unmeasured, measure};
pub use run::{Fate, Home};
pub use start::{ModeShape, Start};

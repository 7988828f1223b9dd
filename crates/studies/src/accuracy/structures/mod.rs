//! Random structures, each answer against many digits: is every ± a bound?
//!
//! | module | holds |
//! |---|---|
//! | [`draws`] | structures of each kind, as scenes |
//! | `checks` | the orbits of one and their multipliers against the truth |
//! | `report` | the table of all kinds |

mod checks;
pub mod draws;
pub(crate) mod report;

pub use checks::check_structure;
pub use report::{KindTally, check_structures};

//! One orbit with all that is said about it.

use vibrochain_breather::{Admissibility, Condition, Orbit};
use vibrochain_floquet::{FloquetError, Multipliers};

use crate::orbit::modes::OrbitModes;

/// One orbit with all that is said about it.
pub(crate) struct Solution {
    pub(crate) orbit: Orbit,
    pub(crate) admissibility: Admissibility,
    pub(crate) condition: Condition,
    pub(crate) multipliers: Result<Multipliers, FloquetError>,
    pub(crate) modes: Option<OrbitModes>,
    /// Of a word of several sites that is unstable through +1: by how much each of its breathers runs ahead.
    pub(crate) phases: Option<Vec<(usize, f64)>>,
}

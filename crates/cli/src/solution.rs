//! One orbit with all that is said about it.

use vibrochain_breather::{Admissibility, Condition, Orbit};
use vibrochain_floquet::{FloquetError, Stability};

use crate::orbit_modes::OrbitModes;

/// One orbit with all that is said about it.
pub(crate) struct Solution {
    pub(crate) orbit: Orbit,
    pub(crate) admissibility: Admissibility,
    pub(crate) condition: Condition,
    pub(crate) stability: Result<Stability, FloquetError>,
    pub(crate) modes: Option<OrbitModes>,
}

//! Any impacts at one site: f(z) = 1 + Σ ρ/(z−p) + conj., for maps with losses and for large rings.
//!
//! | module | holds |
//! |---|---|
//! | `multipliers` | [`SecularMultipliers`](multipliers::SecularMultipliers): all multipliers |
//! | `four_poles`, `other_modes` | the residues, four poles at a time |
//! | `verdict` | [`ForcedSecular`](verdict::ForcedSecular): stable or not |

pub(crate) mod four_poles;
pub(crate) mod multipliers;
pub(crate) mod other_modes;
pub(crate) mod verdict;

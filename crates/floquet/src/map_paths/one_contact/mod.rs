//! Any impacts at one site: f(z) = 1 + Σ ρ/(z−p) + conj., for maps with losses and for large rings.
//!
//! | module | holds |
//! |---|---|
//! | `multipliers` | [`SecularMultipliers`](multipliers::SecularMultipliers): all multipliers |
//! | `four_poles`, `other_modes` | the residues, four poles at a time |
//! | `verdict` | [`ForcedSecular`](verdict::ForcedSecular): stable or not |
//! | `impact_matrix`, `refine` | the determinant itself: a multiplier refined by null vectors, without allocating |
//! | `beyond` | whether a real multiplier is surely beyond some modulus |
//! | `shapes` | [`ModalShape`](shapes::ModalShape): the perturbation that belongs to a multiplier |

pub(crate) mod beyond;
pub(crate) mod four_poles;
pub(crate) mod impact_matrix;
pub(crate) mod multipliers;
pub(crate) mod other_modes;
pub(crate) mod refine;
pub(crate) mod shapes;
pub(crate) mod verdict;

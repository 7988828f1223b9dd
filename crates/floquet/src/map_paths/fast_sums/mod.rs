//! What rings of 10⁵ and 10⁶ masses need: sums over poles in O(M). A fast path: `tests/map_paths.rs` holds it against the spectrum,
//! `map_paths/tests/large.rs` against sums over pairs; `cargo bench --bench spectrum`, group `large`, times it.
//!
//! | module | holds |
//! |---|---|
//! | `multipole` | Cauchy sums of all poles at all poles |
//! | `evaluate`, `neighbourhood` | F or f next to some poles, the far ones expanded |
//! | `large_reversible` | residues of reversible orbits |
//! | `off_axis_roots`, `zero_search` | zeros that brackets do not show |

pub(crate) mod evaluate;
pub(crate) mod large_reversible;
pub(crate) mod multipole;
pub(crate) mod neighbourhood;
pub(crate) mod off_axis_roots;
pub(crate) mod zero_search;

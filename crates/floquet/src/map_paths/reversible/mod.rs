//! Conservative orbits with impacts at one site at 0 and half a period later: a real function F(ν) = Σ R/(ν−d) of ν = ½(μ + 1/μ), whose
//! zeros are counted by the signs of its residues.
//!
//! | module | holds |
//! |---|---|
//! | `single_sided`, `double_sided` | derivation and residues of F |
//! | `residues`, `pole` | [`Residues`](residues::Residues): poles, residues, certificates |
//! | `sign_screen` | whether all residues are surely positive: most stable orbits of a map |
//! | `verdict`, `gap`, `complex_pairs` | stable or not by counting, and what the count leaves to be sought |
//! | `root`, `roots`, `by_roots` | all ν, for large rings |
//! | `product_form` | a leading multiplier from F as a product of sums, where close poles hide it |

pub(crate) mod by_roots;
pub(crate) mod complex_pairs;
pub(crate) mod double_sided;
pub(crate) mod gap;
pub(crate) mod pole;
pub(crate) mod product_form;
pub(crate) mod residues;
pub(crate) mod root;
pub(crate) mod roots;
pub(crate) mod sign_screen;
pub(crate) mod single_sided;
pub(crate) mod verdict;

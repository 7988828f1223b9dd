//! Scenes of any linear structure with stops: `[structure]` in place of `[model]`.
//!
//! | module | holds |
//! |---|---|
//! | `scene` | [`StructureScene`]: what a file asks, checked |
//! | `tables`, `named` | what a scene may hold, and the files that it names |
//! | `damped_chain` | scenes of chains that no lattice is, as with stops of their own |
//! | `setting` | [`Setting`]: each number of it by name, to be varied |
//! | `sizes` | how large a structure may be |
//! | `definition` | matrices, modes or a chain, from which the structure is made |
//! | `matrix_market` | matrices in the files of other tools |
//! | `along` | models as numbers vary, and what branches and curves of them hold |
//! | `answer` | [`Answered`]: an orbit with all that is said of it, as JSON |
//! | `first_obstruction` | what is in the way of a candidate that is not physical |
//! | `told` | heading, numbers and axes in words |
//! | `cell` | [`StructureCell`]: what a point of a map says |
//! | `map` | what lives at each point of a grid |

pub mod along;
pub mod answer;
mod cell;
mod damped_chain;
mod definition;
pub mod map;
mod matrix_market;
mod named;
pub mod scene;
pub mod setting;
mod sizes;
mod tables;
mod told;

pub use answer::Answered;
pub use cell::{StructureCell, StructureClass};
pub use scene::StructureScene;
pub use setting::Setting;
pub use sizes::MOST_COORDINATES;
pub use tables::ChainTable;

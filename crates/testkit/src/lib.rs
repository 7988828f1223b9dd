//! What the tests of all crates share, for tests only: random models, a simulated return map that shares nothing with the
//! crates, the table of checked cases, the program in a folder of its own and the form of what it writes, and checksums that forgive rounding.
#![allow(clippy::unwrap_used, clippy::panic, clippy::missing_panics_doc, reason = "a test stops at the first surprise")]

mod digest;
mod given;
mod models;
mod net;
mod picture;
mod plane;
mod printed;
mod random;
mod reference;
mod ring;
mod runs;
pub mod scenes;
mod schema;
mod structures;
pub mod svg;
mod test_dir;
mod words;

pub use digest::Digest;
pub use given::equations_as_given;
pub use models::{Meeting, Ranges, Values, paper_map};
pub use net::Net;
pub use picture::{Cells, Picture};
pub use plane::Plane;
pub use printed::{STRIPES_SCENE, output, printed_numbers};
pub use random::Random;
pub use reference::{Case, reference};
pub use ring::{ReturnMap, Ring, stiffness};
pub use runs::run_follows;
pub use schema::{Schema, checked, written};
pub use structures::{Before, Structure, StructureImpact, structures};
pub use test_dir::*;
pub use words::{WordCase, words};

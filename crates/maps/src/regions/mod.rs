//! Regions of the plane of two parameters, from the curves between them: what no raster can show, a stripe thinner than any cell,
//! and the area of each class with its error.
//!
//! | module | holds |
//! |---|---|
//! | `window` | [`Window`]: parameters as parts of the unit square |
//! | `smooth`, `strands` | curves between their points; chords fine enough, matched where curves run side by side, ends joined |
//! | `noding`, `boxes` | chords cut where they meet, in whole numbers; which of many may meet |
//! | `triangles`, `subdivision` | triangles between them; [`Subdivision`]: the faces |
//! | `gaps` | where a face reaches through a gap between borders |
//! | `classes`, `plane` | what lives in the faces; [`Regions`]: areas, outlines, the class at any point |
//!
//! None of it knows of breathers: what lives at a point is for the caller to say.

mod boxes;
mod classes;
mod gaps;
mod noding;
mod plane;
mod smooth;
mod strands;
mod subdivision;
mod triangles;
mod window;

pub(crate) use crate::regions::classes::Faces;
pub use crate::regions::plane::{Area, Part, Region, Regions, Unexplained};
pub use crate::regions::subdivision::Subdivision;
pub use crate::regions::window::Window;

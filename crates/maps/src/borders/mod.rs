//! Borders of a scene's window: every curve on which what lives there changes, each an event to its own digits, not to those of a
//! raster.
//!
//! | module | holds |
//! |---|---|
//! | `border` | [`Border`], [`Borders`]: what is found |
//! | `asked` | [`BorderRequest`]: how well, how far |
//! | `part` | one family or word of the scene at a time, and what lives at a place |
//! | `grid` | a coarse look: which changes between neighbouring places a border explains |
//! | `known` | whether a place lies on a border that is known |
//! | `lanes` | stripes of conservative breathers, however thin, each edge from row to row |
//! | `courses` | all stripes of a window |
//! | `meet` | a change between two places, enclosed, and the events that make it |
//! | `change` | the border between two classes by the classes themselves, where no event tells it |
//! | `search` | all of it for one part |
//! | `all` | that of all parts, until nothing is left unexplained in the faces between |
//!
//! Stripes come first, from where two modes of the breather meet: their edges need no raster to be found. What a raster shows besides
//! is enclosed between two neighbours; the event there is located and followed both ways. A border marks all changes that it passes
//! between, so that each is followed once. At last the window is cut by all borders ([`crate::regions`]), and faces in which
//! places still differ are asked the same question.

mod all;
mod asked;
mod border;
mod change;
mod courses;
mod grid;
mod known;
mod lanes;
mod meet;
mod part;
mod search;

pub use asked::{BorderRequest, Stage};
pub use border::{Border, BorderKind, BorderPoint, Borders, MergedStripes, StripeEdge, UnexplainedChange};

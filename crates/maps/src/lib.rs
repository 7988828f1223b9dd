//! Maps of breathers over parameters, as values and as files: what the program `mapgen` and other front ends share. It knows
//! neither command lines nor pictures.
//!
//! ```text
//! Scene ── walk_models ──> Model ── Worker::cell ──> Cell ──> row of a table
//!   └───── sweep: on many threads ─────────────────> Cell, Cell, … in order; Summary
//! ```
//!
//! | module | holds |
//! |---|---|
//! | `numbers` | numbers as they are typed and written |
//! | `scene` | what to sweep and what to compute, checked, with errors that point at lines |
//! | `structure` | the same of any linear structure with stops |
//! | `grid` | what sweeps, chunks and tables ask of both |
//! | `cell`, `summary` | one cell: a point and what lives there; the counts of many |
//! | `absence` | why a point has no physical orbit |
//! | `table` | its columns, rows of cells written and read back, the forms of its file |
//! | `manifest` | where a table came from |
//! | `borders`, `regions` | the curves on which what lives in a scene's window changes; what lives between them, and how much of it
//! | | there is |
//! | `followed` | branches and curves of events as rows |
//! | `sweep` | all cells, in chunks that outlive the process |
//! | `files` | files that appear whole or not at all, pipes, devices |
//! | `caption` | what captions say of models and events |
//! | `text`, `lines`, `fields` | text from outside, read and shown; lines of text that comes in pieces; fields of a row |
//! | `hints` | what is said of a name that is not known |
//! | `error` | why there is none |

// The first, so that all have its macros.
#[macro_use]
pub mod error;

pub mod absence;
pub mod borders;
pub mod caption;
pub mod cell;
mod chain_grid;
pub mod fields;
pub mod files;
pub mod first_obstruction;
pub mod followed;
pub mod grid;
pub mod hints;
pub mod lines;
pub mod manifest;
pub mod numbers;
pub mod obstructions;
pub mod regions;
pub mod scene;
mod standing;
pub mod structure;
pub mod summary;
pub mod sweep;
pub mod table;
pub mod text;

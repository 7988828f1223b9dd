//! The parts of the program `mapgen`, for its tests and benchmarks; see `mapgen --help` for its use.
//!
//! | module | holds |
//! |---|---|
//! | `program`, `console` | the whole program as a function, and what it talks to |
//! | `accuracy` | error against run time, `mapgen accuracy` (feature `accuracy`) |
//! | `args` | the command line |
//! | `parameter`, `force`, `numbers`, `scene` | points of the parameter space, forces of several harmonics, numbers as they are typed, scene files |
//! | `cell`, `sweep` | one cell; all cells, in chunks that outlive the process |
//! | `table`, `table_file`, `columnar`, `manifest`, `pictures` | the files a sweep writes |
//! | `destination`, `output`, `stream`, `csv_file` | where a file goes, whole or as it comes; tables of other commands |
//! | `text`, `threads` | text from outside, read and shown; threads to compute on |
//! | `estimate`, `report` | what a sweep will cost, what it has found |
//! | `plot` | pictures (feature `plot`) |
//! | `figures`, `orbit_plots` | every figure of the paper; all pictures of an orbit (feature `plot`) |
//! | `forms`, `errata` | the paper's closed forms with their misprints; the corrections, each with its evidence |
//! | `stripes` | where two modes collide, over a map (feature `plot`) |
//! | `orbit_modes` | signatures of the modes of a conservative orbit, and which have collided |
//! | `start`, `recording`, `pace` | where a simulation starts, what it leaves behind, how far it is |
//! | `field` | all masses of a run in space and time, thinned for a picture (feature `plot`) |
//! | `sweep_command`, `merge_command`, `orbit_command`, `locate_command`, `simulate_command`, `validate_command` | the subcommands |

#[cfg(feature = "accuracy")]
pub mod accuracy;
pub mod args;
pub mod cell;
#[cfg(feature = "parquet")]
mod columnar;
pub mod console;
mod csv_file;
mod destination;
pub mod errata;
pub mod error;
mod estimate;
#[cfg(feature = "plot")]
pub mod field;
#[cfg(feature = "plot")]
pub mod figures;
pub mod force;
mod forms;
mod lines;
pub mod locate_command;
pub mod manifest;
pub mod merge_command;
mod multiplier_file;
pub mod numbers;
pub mod orbit_command;
mod orbit_modes;
#[cfg(feature = "plot")]
mod orbit_plots;
pub mod output;
mod pace;
pub mod parameter;
mod pictures;
#[cfg(feature = "plot")]
pub mod plot;
pub mod program;
mod recording;
mod report;
pub mod scene;
pub mod simulate_command;
pub mod start;
mod stream;
#[cfg(feature = "plot")]
pub mod stripes;
pub mod sweep;
pub mod sweep_command;
pub mod table;
mod table_file;
mod text;
mod threads;
pub mod validate_command;

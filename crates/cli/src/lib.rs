//! The parts of the program `mapgen`, for its tests and benchmarks; see `mapgen --help` for its use.
//!
//! | module | holds |
//! |---|---|
//! | `program`, `console` | the whole program as a function, and what it talks to |
//! | `accuracy` | error against run time, `mapgen accuracy` (feature `accuracy`) |
//! | `args` | the command line |
//! | `parameter`, `force`, `scene` | points of the parameter space, forces of several harmonics, scene files |
//! | `cell`, `sweep` | one cell, all cells |
//! | `table`, `manifest`, `output` | the files a sweep writes |
//! | `plot` | pictures (feature `plot`) |
//! | `figures`, `orbit_plots` | every figure of the paper; all pictures of an orbit (feature `plot`) |
//! | `forms`, `errata` | the paper's closed forms with their misprints; the corrections, each with its evidence |
//! | `start`, `recording` | where a simulation starts, what it leaves behind |
//! | `sweep_command`, `orbit_command`, `locate_command`, `simulate_command`, `validate_command` | the subcommands |

#[cfg(feature = "accuracy")]
pub mod accuracy;
pub mod args;
pub mod cell;
pub mod console;
pub mod errata;
pub mod error;
#[cfg(feature = "plot")]
pub mod figures;
pub mod force;
mod forms;
pub mod locate_command;
pub mod manifest;
mod multiplier_file;
pub mod orbit_command;
#[cfg(feature = "plot")]
mod orbit_plots;
pub mod output;
pub mod parameter;
#[cfg(feature = "plot")]
pub mod plot;
pub mod program;
mod recording;
pub mod scene;
pub mod simulate_command;
pub mod start;
pub mod sweep;
pub mod sweep_command;
pub mod table;
pub mod validate_command;

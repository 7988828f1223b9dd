//! The parts of the program `mapgen`, for its tests and benchmarks; see `mapgen --help` for its use.
//!
//! | module | holds |
//! |---|---|
//! | `program`, `console` | the whole program as a function, and what it talks to |
//! | `accuracy` | error against run time, `mapgen accuracy` (feature `accuracy`) |
//! | `args` | the command line |
//! | `threads` | threads to compute on |
//! | `pictures` | pictures of a table that is being written |
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
pub mod console;
pub mod errata;
pub mod error;
mod estimate;
#[cfg(feature = "plot")]
pub mod field;
#[cfg(feature = "plot")]
pub mod figures;
mod forms;
pub mod locate_command;
pub mod merge_command;
mod multiplier_file;
pub mod orbit_command;
mod orbit_modes;
#[cfg(feature = "plot")]
mod orbit_plots;
mod pace;
mod pictures;
#[cfg(feature = "plot")]
pub mod plot;
pub mod program;
mod recording;
mod report;
pub mod simulate_command;
pub mod start;
#[cfg(feature = "plot")]
pub mod stripes;
pub mod sweep_command;
mod threads;
pub mod validate_command;

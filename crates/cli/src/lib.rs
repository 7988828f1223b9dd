//! The parts of the program `mapgen`, for its tests and benchmarks; see `mapgen --help` for its use.

// | file | holds |
// |---|---|
// | `entry`, `program`, `console` | where it begins and ends; the whole program as a function, and what it talks to |
// | `args` | the command line |
// | `tips` | what is said of a flag or a command that is not there |
// | `setup_command`, `version` | a scene to begin with, completions, manual pages; what this build can do |
// | `model`, `which` | the model a command is asked about, and which of its breathers |
// | `threads`, `progress` | threads to compute on; bars that tell how far long work is |
// | `chunked_run` | a table in chunks, which outlive the process and may be shared by many |
// | `pictures`, `picture_files` | pictures of a table that is being written; the files of any picture |
// | `table_manifest`, `table_rows` | what a table is of, in a file beside it; a table read again |
// | `branch_table`, `curve_table` | the tables of a bifurcation diagram and of curves in two parameters, written and read |
// | `border_search` | all borders of a scene, with a bar |
// | `estimate`, `report` | what a sweep will cost, what it has found |
// | `branch_plot`, `curve_plot` | the pictures of a bifurcation diagram and of curves in two parameters (feature `plot`) |
// | `orbit_plots` | all pictures of an orbit (feature `plot`) |
// | `stripes` | where two modes collide, over a map (feature `plot`) |
// | `solution`, `orbit_modes` | one orbit with all that is said about it; signatures of the modes of a conservative orbit, and which have collided |
// | `schemas` | the form of every JSON that is written or read |
// | `fate_report`, `fate_plot` | what an ensemble has come to, in words and as a picture |
// | `start`, `recording`, `section`, `pace` | where a simulation starts, what it leaves behind, how far it is |
// | `explore` | the page in a browser, and what it asks this program (feature `explore`) |
// | `orbit_trajectory` | a period of an orbit as a table |
// | `sweep_command`, `merge_command`, `draw_command`, `orbit_command`, `locate_command`, `branch_command`, `curve_command`, `curves_command`, `schema_command`, `simulate_command`, `fate_command`, `words_command` | the subcommands |

mod animate;
pub mod args;
mod border_search;
pub mod branch_command;
#[cfg(feature = "plot")]
mod branch_plot;
#[cfg_attr(not(feature = "plot"), allow(dead_code, reason = "only pictures are drawn from what is read"))]
mod branch_table;
pub mod caption;
mod chunked_run;
pub mod console;
pub mod curve_command;
#[cfg(feature = "plot")]
mod curve_plot;
#[cfg_attr(not(feature = "plot"), allow(dead_code, reason = "only pictures are drawn from what is read"))]
mod curve_table;
pub mod curves_command;
#[cfg(feature = "plot")]
pub mod draw_command;
pub mod entry;
pub mod error;
mod estimate;
#[cfg(feature = "explore")]
mod explore;
pub mod fate_command;
mod fate_plot;
mod fate_report;
pub mod locate_command;
pub mod merge_command;
pub mod model;
mod multiplier_file;
pub mod orbit_command;
mod orbit_modes;
#[cfg(feature = "plot")]
mod orbit_plots;
mod orbit_trajectory;
mod pace;
pub mod page_args;
mod picture_files;
mod pictures;
pub mod program;
mod progress;
pub mod recording;
mod report;
pub mod schema_command;
pub mod schemas;
mod section;
pub mod setup_command;
pub mod simulate_command;
mod solution;
pub mod start;
#[cfg(feature = "plot")]
pub mod stripes;
pub mod sweep_command;
#[cfg_attr(not(feature = "plot"), allow(dead_code, reason = "only pictures are drawn from what is read"))]
mod table_manifest;
#[cfg(feature = "plot")]
mod table_rows;
pub mod threads;
mod tips;
mod version;
pub mod which;
pub mod words_command;

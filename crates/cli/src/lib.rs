//! The parts of the program `mapgen`, for its tests and benchmarks; see `mapgen --help` for its use.

// | folder or file | holds |
// |---|---|
// | `along` | an orbit to start from as its numbers vary, of a chain or of a structure: for `locate`, `branch` and `curve` |
// | `common` | what commands share: console, models and orbits asked for, pictures, tables in chunks, schemas |
// | `args`, `program` | the command line; the whole program as a function |
// | `orbit`, `sweep`, `branch`, `curve`, `fate`, `simulate`, `explore`, `setup` | a command and its parts; `sweep` has `merge` and `draw`, too |
// | `structures` | what commands do for a structure of any kind |
// | `curves`, `locate`, `schema`, `words` | commands of one file |

// Its `ensure!` and `refuse!`.
#[macro_use]
extern crate vibrochain_maps;

mod along;
pub mod args;
pub mod branch;
pub mod common;
pub mod curve;
pub mod curves;
#[cfg(feature = "explore")]
mod explore;
pub mod fate;
pub mod locate;
pub mod orbit;
pub mod program;
pub mod schema;
pub mod setup;
pub mod simulate;
pub mod stripes;
mod structures;
pub mod sweep;
pub mod words;

//! Sweeps: cells in parallel, results in a fixed order whatever the number of threads, in chunks that outlive the process.
//!
//! | module | holds |
//! |---|---|
//! | `engine` | cells on many threads, handed on in order |
//! | `plan` | how a scene is cut into chunks, and what tells two sweeps apart |
//! | `chunk` | the file of one chunk |
//! | `store` | the folder of chunks |
//! | `shard` | which chunks are whose |
//! | `content` | what is computed of each cell, and stands in rows |
//! | `assemble` | the table, of rows as they come or of all chunks |
//! | `work` | computes the chunks that are missing |

mod assemble;
mod chunk;
mod content;
mod engine;
mod plan;
mod shard;
mod store;
mod work;

pub use assemble::{Assembly, Unassembled, Watcher};
pub use chunk::{Fault, Writer};
pub use content::{Cells, Content, ReadRows, Sink};
pub use engine::{Block, Ended, Job, blocks, sweep};
pub use plan::{Plan, Settings};
pub use shard::{Shard, ShardFlag};
pub use store::{Claim, Store};
pub use work::{Grown, Todo, Work, Worked, work};

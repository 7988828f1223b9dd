//! The parts of the program `studies`, for its tests: what vibrochain is checked by. See `studies --help`.

// | file | holds |
// |---|---|
// | `program`, `args` | the whole program as a function, its command line |
// | `figures` | every figure of the paper, with the numbers behind it |
// | `forms`, `errata` | the paper's closed forms with their misprints; the corrections, each with its evidence |
// | `validate` | closed forms against simulation |
// | `stripes` | lines on which two modes collide; width and growth of stripes against a law |
// | `accuracy` | error against run time |
// | `loops` | inner loops, for a tool that counts their instructions |

pub mod accuracy;
pub mod args;
pub mod errata;
pub mod figures;
mod forms;
pub mod loops;
pub mod program;
pub mod stripes;
pub mod validate;

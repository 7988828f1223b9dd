//! Maps in a browser: one page, served on this machine alone, and what it asks for.
//!
//! A tile `z/x/y` is [`CELLS`] by `CELLS` cells of a plane of two parameters; at z = 0 one tile is the window of a scene, and each
//! further z halves it. Its cells are those of the scene that [`View::tile`] hands out, computed as a sweep computes them.

// | file | holds |
// |---|---|
// | `refusal` | why there is no answer, and by which code of HTTP |
// | `view` | the scene that is flown over, and the scene of each of its tiles |
// | `tile` | the cells of a tile, and their bytes |
// | `colours`, `scale` | the colours and textures of printed maps, for the page; how numbers become colours |
// | `page` | the files of the page |
// | `token`, `guard` | who may ask |
// | `work` | computations: so many at a time, so many in wait, ended when nobody waits for them any more |
// | `answers`, `route` | from a request to its answer |
// | `connection`, `server` | connections |

// Its `ensure!` and `refuse!`.
#[macro_use]
extern crate vibrochain_maps;

mod answers;
mod colours;
mod connection;
mod guard;
mod page;
mod refusal;
mod route;
mod scale;
mod server;
mod tile;
mod token;
mod view;
mod work;

pub use answers::Answers;
pub use guard::port_will_do;
pub use refusal::Refusal;
pub use server::Explorer;
pub use tile::{BYTES, compute};
pub use view::{CELLS, MOST_DENSE, MOST_SITES, View, fits};

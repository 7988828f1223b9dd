//! Files that appear whole or not at all, and what is no plain file.

mod csv_file;
mod destination;
mod folder;
#[cfg(feature = "compress")]
mod gzip;
mod output;
mod stream;

pub use csv_file::CsvFile;
pub use destination::{Destination, distinct, ending, name_within, promises, promises_folder};
pub use folder::{Entry, entries};
#[cfg(feature = "compress")]
pub use gzip::Gzip;
pub use output::{Output, remove_if_abandoned, sync_folder};
pub use stream::halt_on;

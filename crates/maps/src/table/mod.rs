//! The table of a sweep.
//!
//! | module | holds |
//! |---|---|
//! | `columns` | its columns: name, kind, and how each is taken from a cell and put into one |
//! | `rows` | rows of text, written and read back |
//! | `writer` | the rows of a sweep |
//! | `parquet` | the same values by columns |
//! | `file` | its file, in the form that the end of its name asks for |

mod columns;
mod file;
#[cfg(feature = "parquet")]
mod parquet;
mod rows;
mod writer;

pub use columns::{Column, Kind, Value, columns, names, parameters};
pub use file::{Form, TableFile, stem};
pub use rows::{Reader, Rows, Table, header};
pub use writer::RowWriter;

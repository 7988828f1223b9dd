//! The table of a sweep.
//!
//! | module | holds |
//! |---|---|
//! | `columns` | the columns of a chain: name, kind, and how each is taken from a cell and put into one |
//! | `codes` | words as numbers, for tables in memory |
//! | `fields` | the columns of any scene, and fields that have quotes |
//! | `rows` | rows of text, written and read back |
//! | `writer` | the rows of a sweep |
//! | `parquet` | the same values by columns |
//! | `file` | its file, in the form that the end of its name asks for |

mod codes;
pub(crate) mod columns;
mod fields;
mod file;
#[cfg(feature = "parquet")]
mod parquet;
mod rows;
mod writer;

pub use codes::{Codes, Numbers};
pub use columns::{Column, Kind, Value, columns, parameters};
pub use fields::{ColumnType, Layout, push_text, split};
pub use file::{Form, TableFile, stem};
pub use rows::{Reader, Rows, Table, header};
pub use writer::RowWriter;

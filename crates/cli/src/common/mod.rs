//! What commands share: the console, models and orbits asked for, pictures, tables in chunks.

pub(crate) mod answer;
pub(crate) mod border_search;
pub mod caption;
pub(crate) mod chunked_run;
pub mod console;
pub mod entry;
pub mod error;
pub(crate) mod impact_table;
pub mod model;
pub mod pictures;
pub(crate) mod progress;
pub mod schemas;
pub(crate) mod solution;
pub(crate) mod swept_scene;
pub(crate) mod table_manifest;
pub(crate) mod table_rows;
pub mod threads;
pub(crate) mod tips;
pub(crate) mod version;
pub mod which;

//! Maps: their axes, chunks, shares, tables and manifests.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod again;
mod axes;
mod chunks;
mod columnar;
mod compressed;
mod shards;

//! Drawings as vectors, and the files that they become: SVG, PDF, PNG.

pub(crate) mod canvas;
pub(crate) mod coverage;
pub mod drawing;
pub(crate) mod format;
pub(crate) mod markers;
pub(crate) mod page;
#[cfg(feature = "files")]
pub(crate) mod pdf;
#[cfg(feature = "files")]
pub(crate) mod pixels;
pub(crate) mod png;
pub(crate) mod strokes;
pub(crate) mod svg;

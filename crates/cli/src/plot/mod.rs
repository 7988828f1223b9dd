//! Pictures. All of them are drawn with a font that is shipped with the program, so that a bare machine will do.

pub mod axes;
pub mod canvas;
mod curves;
pub mod decades;
mod lines;
mod map;
pub mod markers;
mod orbit;
pub mod palette;
mod run;
mod words;

pub use canvas::{Format, PlotError, open};
pub use curves::{Curves, Mark, Pane, Scale, Series, Stroke, curves_picture};
pub use map::{MapLine, MapPicture, is_shown, map_picture, map_with_lines};
pub use orbit::{OrbitPanels, orbit_picture};
pub use palette::{Palette, Tile};
pub use run::{RunPicture, run_picture};

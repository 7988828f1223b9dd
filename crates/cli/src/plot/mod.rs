//! Pictures. All of them are drawn with a font that is shipped with the program, so that a bare machine will do.

mod axes;
mod canvas;
mod curves;
mod decades;
mod lines;
mod map;
mod markers;
mod orbit;
mod palette;
mod run;
mod words;
#[cfg(feature = "accuracy")]
mod work_precision;

pub(crate) use canvas::open;
pub use canvas::{Format, PlotError};
pub use curves::{Curves, Mark, Pane, Scale, Series, Stroke, curves_picture};
pub use map::{MapLine, MapPicture, is_shown, map_picture, map_with_lines};
pub use orbit::{OrbitPanels, orbit_picture};
pub use palette::{Palette, Tile};
pub use run::{RunPicture, run_picture};
#[cfg(feature = "accuracy")]
pub use work_precision::{WorkPrecision, WorkPrecisionPanel, work_precision_picture};

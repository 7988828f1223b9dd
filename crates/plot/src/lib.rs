//! Pictures: maps, curves, orbits, runs, as bytes of PNG, SVG or PDF. A picture is drawn once, as vectors, for a [`Page`]; all letters
//! are outlines of a font that is shipped with the crate, so that a bare machine will do.
//!
//! | name | what it is |
//! |---|---|
//! | [`Page`] | width, resolution, size of letters |
//! | [`Format`], [`open`] | how a drawing becomes bytes |
//! | [`drawing`] | shapes, circles, words and rasters as values |
//! | [`MapPicture`], [`RegionsPicture`], [`EndsPicture`] | a map by its cells, by its regions, by what becomes of its breathers |
//! | [`OneAxisPicture`], [`Curves`] | the curves of a sweep over one parameter; any curves, in panels |
//! | [`OrbitPanels`], [`RunPicture`], [`Spacetime`] | an orbit in profile and time; a simulated run; all masses over a period |
//! | [`Animation`] | the chain between its barriers, moving |
//! | [`palette`], [`NumberScale`] | colours and textures of classes; how numbers become colours |
//! | [`field`] | all masses of a run in space and time, thinned while it runs |
//!
//! ```
//! use vibrochain_plot::{Format, OrbitPanels, orbit_picture};
//! let trace = (0..100).map(|i| (f64::from(i) / 100.0, (0.0628 * f64::from(i)).cos())).collect();
//! let (caption, x, profiles) = ("a swing".to_owned(), "site", Vec::new());
//! let orbit = OrbitPanels { caption, x, profiles, traces: vec![(0, trace)], barriers: (-1.0, 1.0) };
//! assert!(orbit_picture(&[orbit], Format::Svg)?.starts_with(b"<svg"));
//! # Ok::<(), vibrochain_plot::PlotError>(())
//! ```

mod animation;
mod axis;
mod canvas;
mod classes;
mod coverage;
mod curves;
pub mod drawing;
mod ends;
pub mod field;
mod font;
mod format;
mod frame;
mod key;
mod legend;
mod lines;
mod map;
mod markers;
mod motion;
mod moving_pixels;
mod moving_svg;
mod one_axis;
mod orbit;
mod page;
pub mod palette;
mod pane;
mod panels;
mod pdf;
mod pixels;
mod quantity;
mod raster;
mod regions;
mod run;
mod sheet;
mod shown;
#[cfg(test)]
mod sight;
mod spacetime;
mod stage;
mod strokes;
mod svg;
mod typeset;
mod words;

pub use animation::animation;
pub use axis::{place, power_of_ten};
pub use canvas::{open, render};
pub use classes::loss;
pub use curves::{Curves, Mark, Pane, Scale, Series, Stroke};
pub use ends::{EndsPicture, MOST_VALUES, ends_picture};
pub use format::{Format, PlotError};
pub use map::{MapBorder, MapLine, MapPicture, map_picture, map_with_lines};
pub use motion::{Animation, Instant, MOST_MASSES, Moving};
pub use one_axis::{OneAxisPicture, one_axis_picture};
pub use orbit::{OrbitPanels, Profile, orbit_picture};
pub use page::{Page, Purpose};
pub use palette::{Palette, Tile};
pub use panels::curves_picture;
pub use quantity::{NumberScale, Quantity, Shade, number_scale};
pub use regions::{RegionsPicture, regions_fit, regions_picture};
pub use run::{RunPicture, run_picture};
pub use sheet::about;
pub use shown::{Shown, is_shown};
pub use spacetime::{Spacetime, spacetime_picture};

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

mod axes;
mod backend;
mod map;
mod moving;
mod panels;
#[cfg(test)]
mod sight;
mod text;

pub use axes::axis::{place, power_of_ten};
pub use backend::canvas::{open, render};
pub use backend::drawing;
pub use backend::format::{Format, PlotError};
pub use backend::page::{Page, Purpose};
pub use map::classes::loss;
pub use map::ends::{EndsPicture, MOST_VALUES, ends_picture};
pub use map::map_raster::{Shown, is_shown};
pub use map::one_axis::{OneAxisPicture, one_axis_picture};
pub use map::palette;
pub use map::palette::{Palette, Tile};
pub use map::quantity::{NumberScale, Quantity, Shade, number_scale};
pub use map::regions::{RegionsPicture, regions_fit, regions_picture};
pub use map::sheet::about;
pub use map::{MapBorder, MapLine, MapPicture, map_picture, map_with_lines};
pub use moving::animation;
pub use moving::motion::{Animation, Instant, MOST_MASSES, Moving};
pub use panels::curves::{Curves, Mark, Pane, Scale, Series, Stroke};
pub use panels::curves_picture;
pub use panels::field;
pub use panels::orbit::{OrbitPanels, Profile, orbit_picture};
pub use panels::run::{RunPicture, run_picture};
pub use panels::spacetime::{Spacetime, spacetime_picture};

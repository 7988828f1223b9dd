//! Pictures: maps, curves, orbits, runs, as bytes of PNG, SVG or PDF. A picture is drawn once, as vectors, for a [`Page`]; all letters
//! are outlines of a font that is shipped with the crate, so that a bare machine will do.
//!
//! | module | holds |
//! |---|---|
//! | `page` | [`Page`]: width, resolution, size of letters |
//! | `format`, `canvas` | [`Format`], [`open`], and how a drawing becomes bytes |
//! | `drawing` | shapes, circles, words and rasters as values |
//! | `svg`, `pixels`, `pdf` | the three kinds of files |
//! | `font`, `typeset`, `words` | letters, where they stand, lines of a heading |
//! | `axis`, `frame`, `markers`, `strokes` | ticks, panels, marks and lines of all pictures |
//! | `map`, `raster`, `sheet`, `key`, `classes`, `lines`, `palette` | the picture of a map, its pixels, what stands about it, its legend and its words, lines over it, its colours and textures |
//! | `quantity` | numbers of cells, and how they become colours |
//! | `one_axis` | the curves of a sweep over one parameter |
//! | `ends` | what becomes of perturbed breathers, over a map |
//! | `regions`, `coverage` | the picture of a map by its regions: shapes, or pixels by exact area |
//! | `curves` | curves in panes |
//! | `orbit`, `run`, `spacetime` | an orbit in profile and time; a simulated run; all masses over a period |
//! | `animation` | the chain between its barriers, moving |
//! | `field` | all masses of a run in space and time, thinned while it runs |
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
mod lines;
mod map;
mod markers;
mod one_axis;
mod orbit;
mod page;
pub mod palette;
mod pdf;
mod pixels;
mod quantity;
mod raster;
mod regions;
mod run;
mod sheet;
mod spacetime;
mod strokes;
mod svg;
mod typeset;
mod words;

pub use animation::{Animation, Instant, MOST_MASSES, Moving, animation};
pub use axis::power_of_ten;
pub use canvas::{open, render};
pub use classes::loss;
pub use curves::{Curves, Mark, Pane, Scale, Series, Stroke, curves_picture};
pub use ends::{EndsPicture, MOST_VALUES, ends_picture};
pub use format::{Format, PlotError};
pub use map::{
    Cells, MapBorder, MapLine, MapPicture, is_shown, map_picture, map_with_lines, shown_cells, shown_within,
};
pub use one_axis::{OneAxisPicture, one_axis_picture};
pub use orbit::{OrbitPanels, Profile, orbit_picture};
pub use page::{Page, Purpose};
pub use palette::{Palette, Tile};
pub use quantity::{Quantity, Shade};
pub use regions::{RegionsPicture, regions_picture};
pub use run::{RunPicture, run_picture};
pub use spacetime::{Spacetime, spacetime_picture};

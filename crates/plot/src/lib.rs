//! Pictures: maps, curves, orbits, runs, as bytes of PNG or SVG. All of them are drawn with a font that is shipped with the crate,
//! so that a bare machine will do.
//!
//! | module | holds |
//! |---|---|
//! | `canvas` | [`Format`], [`open`], and how a drawing becomes bytes |
//! | `map`, `sheet`, `lines`, `palette` | the picture of a map, what stands about it, lines over it, its colours and textures |
//! | `quantity` | numbers of cells, and how they become colours |
//! | `one_axis` | the curves of a sweep over one parameter |
//! | `strokes` | thin lines over a map |
//! | `ends` | what becomes of perturbed breathers, over a map |
//! | `regions`, `coverage` | the picture of a map by its regions: shapes, or pixels by exact area |
//! | `curves`, `axes`, `ticks`, `decades`, `markers`, `words` | curves in panes; axes, marks and headings of all pictures |
//! | `orbit`, `run`, `spacetime` | an orbit in profile and time; a simulated run; all masses over a period |
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

pub mod axes;
pub mod canvas;
mod coverage;
mod curves;
pub mod decades;
mod ends;
pub mod field;
mod lines;
mod map;
pub mod markers;
mod one_axis;
mod orbit;
pub mod palette;
mod quantity;
mod regions;
mod run;
mod sheet;
mod spacetime;
mod strokes;
mod ticks;
mod words;

pub use canvas::{Format, PlotError, open};
pub use curves::{Curves, Mark, Pane, Scale, Series, Stroke, curves_picture};
pub use ends::{EndsPicture, MOST_VALUES, ends_picture};
pub use map::{Cells, MapBorder, MapLine, MapPicture, is_shown, map_picture, map_with_lines};
pub use one_axis::{OneAxisPicture, one_axis_picture};
pub use orbit::{OrbitPanels, Profile, orbit_picture};
pub use palette::{Palette, Tile};
pub use quantity::{Quantity, Shade};
pub use regions::{RegionsPicture, regions_picture};
pub use run::{RunPicture, run_picture};
pub use spacetime::{Spacetime, spacetime_picture};

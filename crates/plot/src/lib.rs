//! Pictures: maps, curves, orbits, runs, as bytes of PNG, SVG or PDF. A picture is drawn once, as vectors, for a [`Page`]; all letters
//! are outlines of a font that is shipped with the crate, so that a bare machine will do.
//!
//! | name | what it is |
//! |---|---|
//! | [`Page`] | width, resolution, size of letters |
//! | [`Format`], [`open`] | how a drawing becomes bytes |
//! | [`drawing`] | shapes, circles, words and rasters as values |
//! | [`MapPicture`], [`RegionsPicture`], [`EndsPicture`] | a map by its cells, by its regions, by what becomes of its breathers |
//! | [`diagram_curves`], [`event_curves`], [`orbit_panes`], [`contact_panes`] | panels of a bifurcation diagram, of event curves, of an orbit of a chain or of a structure |
//! | [`OneAxisPicture`], [`Curves`] | the curves of a sweep over one parameter; any curves, in panels |
//! | [`OrbitPanels`], [`RunPicture`], [`Spacetime`] | an orbit in profile, time and phase plane; a simulated run; all masses over a period |
//! | [`Animation`] | the chain between its barriers, moving |
//! | [`palette`], [`NumberScale`] | colours and textures of classes; how numbers become colours |
//! | [`field`] | all masses of a run in space and time, thinned while it runs |
//!
//! ```
//! use vibrochain_plot::{Format, OrbitPanels, Trace, orbit_picture, trace_pane};
//! let flight = (0..100).map(|i| f64::from(i) / 100.0).map(|t| [t, (6.28 * t).cos(), -6.28 * (6.28 * t).sin()]);
//! let swing = Trace { flights: vec![flight.collect()], ..Trace::default() };
//! let orbit = OrbitPanels { caption: "a swing".to_owned(), panes: vec![trace_pane("u", &[swing])] };
//! assert!(orbit_picture(&[orbit], Format::Svg)?.starts_with(b"<svg"));
//! # Ok::<(), vibrochain_plot::PlotError>(())
//! ```

mod axes;
mod backend;
mod figures;
mod map;
mod moving;
mod panels;
#[cfg(test)]
mod tests;
mod text;

pub use axes::axis::{ModulusAxis, modulus_axis, place, power_of_ten};
pub use backend::canvas::{open, render};
pub use backend::drawing;
pub use backend::format::{Format, PlotError};
pub use backend::page::{Page, Purpose};
pub use figures::contact_panes::contact_panes;
pub use figures::diagram::{Diagram, OrbitQuantity, diagram_curves};
pub use figures::event_curves::event_curves;
pub use figures::orbit_panes::{
    along, impact_name, multiplier_pane, orbit_flights, orbit_panes, orbit_profile, rows, state,
};
pub use map::classes::{class_words, loss};
pub use map::ends::{ENDS, EndsPicture, MOST_VALUES, ends_picture};
pub use map::map_cells::{MapCells, is_shown};
pub use map::mapped::{MapAxis, Mapped, about};
pub use map::one_axis::{OneAxisPicture, one_axis_picture};
pub use map::palette;
pub use map::palette::{Palette, Tile};
pub use map::quantity::{NumberScale, Quantity, Shade, number_scale};
pub use map::regions::{RegionsPicture, regions_fit, regions_picture};
pub use map::{MapBorder, MapPicture, map_picture};
pub use moving::animation;
pub use moving::motion::{Animation, Instant, MOST_MASSES, Moving};
pub use panels::curves::{Curves, Mark, Pane, Scale, Series, Stroke};
pub use panels::curves_picture;
pub use panels::field;
pub use panels::orbit::{
    OrbitPanels, Profile, Trace, orbit_picture, orbits_on_page, portrait_pane, profile_pane, trace_pane,
};
pub use panels::run::{RunPicture, run_picture, run_trace};
pub use panels::spacetime::{Spacetime, diverging, spacetime_picture};

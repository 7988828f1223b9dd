//! Curves of events in two parameters: where one bifurcation or grazing goes as a second parameter is varied, too.
//!
//! | module | holds |
//! |---|---|
//! | `answer` | [`Window`], [`Walk`], [`EventCurve`] with its points, its special points and its ends |
//! | `signal` | what vanishes all along the curve |
//! | `walker` | who walks, and what is known of a point |
//! | `walk` | steps along it: from what lies behind to what lies ahead, and onto it |
//! | `both_ways` | the curve through a start, to both its ends |
//! | `special` | where something else happens on it: points of codimension two |
//! | `error` | how well its points are known |
//!
//! The orbits at two free parameters make a surface ([`vibrochain_breather::Surface`]), on which the event's function g vanishes along a
//! curve. From the last points the next one is extrapolated in the tangents' plane; across the way there g = 0 is solved by secants.
//! So nothing is special where the curve turns in the parameters, not even a cusp, where it stands still in both. A step is as long as a
//! straight line between its ends may be.

mod answer;
mod both_ways;
mod error;
mod signal;
mod special;
mod walk;
mod walker;

pub use answer::{CurveEnd, CurveError, CurvePoint, EventCurve, Special, SpecialPoint, Walk, Window};
pub use both_ways::{curve, curve_along};

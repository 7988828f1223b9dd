//! Curves of events in two parameters: where one bifurcation or grazing goes as a second parameter is varied, too.
//!
//! | module | holds |
//! |---|---|
//! | `answer` | [`Window`], [`Walk`], [`EventCurve`] with its points, its special points and its ends |
//! | `tracer` | what is followed, from point to point |
//! | `monitors` | what else happens on the way: points of codimension two |
//! | `way` | the curve through a start, both ways to its ends |
//! | `event_curve` | [`event_curve()`], the way in |
//!
//! The orbit's equations with what vanishes at the event are one system, with two numbers free: a branch of its solutions is the curve. So nothing
//! is special where the curve turns in the parameters, not even a cusp, where it stands still in both. A step is as long as a straight line
//! between its ends may be.

mod answer;
mod event_curve;
mod monitors;
mod tracer;
mod way;

pub use answer::{CurveEnd, CurveError, CurvePoint, EventCurve, Special, SpecialPoint, Walk, Window};
pub use event_curve::{event_curve, event_curves};

//! An event of orbits, followed through a window of two numbers of their structure.

use vibrochain_breather::{BranchError, Continuation, ModelFamily};
use vibrochain_lattice::Stop;

use super::answer::{CurveError, EventCurve};
use super::tracer::CurveRequest;
use super::way::followed;
use crate::events::Watcher;
use crate::locate::Located;

/// A rectangle in the plane of two numbers of a structure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    /// Least values.
    pub from: [f64; 2],
    /// Largest values.
    pub to: [f64; 2],
}

impl Rectangle {
    /// A place as parts of both sides.
    #[must_use]
    pub fn parts(&self, values: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| (values[i] - self.from[i]) / (self.to[i] - self.from[i]))
    }

    fn holds(&self, values: [f64; 2]) -> bool {
        (0..2).all(|i| (self.from[i]..=self.to[i]).contains(&values[i]))
    }
}

/// Follows the event that was located, of orbits of `family` at two values, both ways through a window. A straight line between neighbouring
/// points is no farther than `tolerance` from the curve, as a part of the window's sides.
///
/// # Errors
/// [`CurveError`]. What stops the curve on its way is its end, not an error.
pub fn event_curve(
    located: &Located,
    family: &ModelFamily,
    start: [f64; 2],
    window: Rectangle,
    tolerance: f64,
    stop: &Stop,
) -> Result<EventCurve, CurveError> {
    let Rectangle { from, to } = window;
    if !((0..2).all(|i| from[i] < to[i]) && window.holds(start)) {
        let message = format!("the start {start:?} is not in the window from {from:?} to {to:?}");
        return Err(BranchError::Model(message).into());
    }
    if !(1e-12..=0.01).contains(&tolerance) {
        return Err(CurveError::Tolerance(tolerance));
    }
    let sides = [0, 1].map(|i| to[i] - from[i]);
    let &Located { event, evidence, ref orbit, .. } = located;
    let (name, orbit) = (orbit.family(), orbit.followed(stop).map_err(BranchError::from)?);
    let base = Continuation::through(&orbit, family.clone(), &start, &sides, stop)?;
    let (until, window) = (&|_: [f64; 2], _: Option<bool>| false, [from, to]);
    let asked = CurveRequest { event, evidence, name, window, tolerance, uncoupled: None, special: true, until };
    let curve = followed((base, &orbit), Watcher::default(), &asked);
    // On the way a failure is an end.
    stop.heard()?;
    curve
}

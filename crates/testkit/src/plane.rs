//! Curves of events over two parameters of a lattice.

use vibrochain_breather::{BranchError, Orbit};
use vibrochain_floquet::{CurveError, Event, EventCurve, Evidence, Walk, Window};
use vibrochain_lattice::{Parameter, Stop};

/// A window of two parameters.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    /// The two.
    pub parameters: [Parameter; 2],
    /// From where to where.
    pub window: Window,
}

impl Plane {
    /// From least to largest values.
    pub fn new(parameters: [Parameter; 2], from: [f64; 2], to: [f64; 2]) -> Self {
        Self { parameters, window: Window { from, to } }
    }

    /// The lengths of its sides.
    pub fn sides(&self) -> [f64; 2] {
        self.window.sides()
    }

    /// A place as parts of both sides.
    pub fn parts(&self, values: [f64; 2]) -> [f64; 2] {
        self.window.parts(values)
    }

    /// The curve of the event at an orbit.
    ///
    /// # Errors
    /// As [`event_curve`](vibrochain_floquet::event_curve).
    pub fn curve(
        &self,
        orbit: &Orbit,
        event: Event,
        evidence: Evidence,
        tolerance: f64,
    ) -> Result<EventCurve, CurveError> {
        let numbers = orbit.lattice().map_err(BranchError::from)?.numbers(&self.parameters, &Stop::default());
        vibrochain_floquet::event_curve(orbit, event, evidence, &numbers, &Walk::new(self.window, tolerance))
    }
}

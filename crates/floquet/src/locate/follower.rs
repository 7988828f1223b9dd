//! Who walks along a branch, and what is seen on the way.

use nalgebra::Complex;
use smallvec::SmallVec;
use vibrochain_breather::{Branch, BranchPoint, Finder, Orbit};
use vibrochain_lattice::{Parameter, Stop};

use super::answer::{Event, Located, Unresolved};
use crate::analyser::Analyser;
use crate::stripes::{OrderFinder, SignatureOrder};

/// The branch, what is watched along it, and work space.
pub(super) struct Follower {
    pub(super) branch: Branch,
    pub(super) free: Parameter,
    /// Least and largest value of the free parameter.
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) events: Vec<Event>,
    /// The branch is followed round its folds, all its points are kept, and every step is looked at in its middle, too.
    pub(super) whole: bool,
    pub(super) analyser: Analyser,
    pub(super) finder: Finder,
    pub(super) orders: OrderFinder,
    pub(super) passed: Vec<Passed>,
    pub(super) unresolved: Vec<Unresolved>,
    /// Steps without loss at an end of which Krein signatures could not be told.
    pub(super) untold: usize,
    /// Orbits assembled on other branches.
    pub(super) others: usize,
    pub(super) spectra: usize,
}

/// What the way has passed.
pub(super) enum Passed {
    /// A point, where the whole branch is asked for.
    Point(BranchPoint),
    Event(Located),
}

impl Passed {
    pub(super) fn event(self) -> Option<Located> {
        match self {
            Self::Point(_) => None,
            Self::Event(located) => Some(located),
        }
    }
}

/// What was seen at a point.
#[derive(Debug, Clone, Default)]
pub(super) struct Observation {
    /// Velocity before each impact, towards its barrier.
    pub(super) velocities: Vec<f64>,
    pub(super) margin: Option<f64>,
    pub(super) equations: f64,
    /// ln|D| and the sign of D, det(A + shift) made regular, of an event that has a shift.
    pub(super) determinants: SmallVec<[(Event, (f64, f64)); 2]>,
    /// Eigenvalues: μ, or ν of a reversible orbit.
    pub(super) values: Vec<Complex<f64>>,
    /// Without loss, (Im ν)² of the pairs off the circle, by Re ν.
    pub(super) openings: Vec<f64>,
    /// Of impacts at several sites, the order of Krein signatures along the circle.
    pub(super) order: Option<SignatureOrder>,
}

impl Observation {
    /// The determinant that shows an event.
    pub(super) fn determinant(&self, event: Event) -> Option<(f64, f64)> {
        self.determinants.iter().find(|(of, _)| *of == event).map(|(_, determinant)| *determinant)
    }
}

impl Follower {
    pub(super) fn new(branch: Branch, (from, to): (f64, f64), events: Vec<Event>, stop: &Stop) -> Self {
        let finder = Finder::new(branch.sites()).until(stop);
        let branch = branch.until(stop);
        let (free, analyser) = (branch.free(), Analyser::default());
        let (passed, unresolved) = (Vec::new(), Vec::new());
        Self {
            branch,
            free,
            from,
            to,
            events,
            whole: false,
            analyser,
            finder,
            orders: OrderFinder::default(),
            passed,
            unresolved,
            untold: 0,
            others: 0,
            spectra: 0,
        }
    }

    /// What ends its work early, which everything it works with looks at.
    pub(super) fn stop(&self) -> &Stop {
        self.finder.stop()
    }

    pub(super) fn watches(&self, event: Event) -> bool {
        self.events.contains(&event)
    }

    /// Length of the range.
    pub(super) fn range(&self) -> f64 {
        self.to - self.from
    }
}

/// The shift s of det(A + s) that shows an event, for those that the spectrum shows; `None` where the orbit's own equations
/// do. A holds μ, or ν of a reversible orbit, which are both ±1 together.
pub(super) fn shift_of(event: Event, orbit: &Orbit) -> Option<f64> {
    match event {
        Event::PeriodDoubling => Some(1.0),
        Event::Pitchfork if orbit.model().is_conservative() => Some(-1.0),
        _ => None,
    }
}

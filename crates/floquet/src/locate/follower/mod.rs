//! Who follows a branch.
//!
//! | module | holds |
//! |---|---|
//! | `follow` | steps, folds and ends, one way |
//! | `seen`, `between` | what is seen at a point; steps so short that no pair of events hides |
//! | `confirm`, `beside_resonance` | events where a test function changes its sign |
//! | `crossings`, `paths`, `cubic` | pairs of multipliers that cross the circle, by their slopes |
//! | `collision` | without losses, pairs that meet on it |

mod beside_resonance;
mod between;
mod collision;
pub(crate) mod confirm;
mod crossings;
mod cubic;
pub(crate) mod follow;
mod paths;
mod seen;

use nalgebra::Complex;
use vibrochain_breather::{Admissibility, Branch, BranchPoint, BreatherError};
use vibrochain_lattice::Stop;

use crate::events::{Order, Watcher, bounded};
use crate::locate::answer::{Event, Unresolved};
use crate::locate::course::{DiagramPoint, Station};
use crate::locate::ends::BranchEnds;
use crate::verdict::{Tolerance, Verdict};

/// What was seen at a point, as far as the events that are watched ask for it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Seen {
    /// Velocity before each impact, towards its barrier.
    pub(super) velocities: Vec<f64>,
    /// Acceleration after each impact that is plastic, away from its barrier.
    pub(super) releases: Vec<Option<f64>>,
    pub(super) admissibility: Option<Admissibility>,
    pub(super) minus_one: Option<f64>,
    pub(super) another_one: Option<f64>,
    /// Multipliers, or without losses ν of each pair.
    pub(super) values: Vec<Complex<f64>>,
    /// With losses, how they move.
    moving: crossings::Moving,
    /// Without loss, (Im ν)² of the pairs off the circle, by Re ν.
    pub(super) openings: Vec<f64>,
    /// Of an orbit without losses its pairs of multipliers in their order along the circle, with their Krein signatures.
    order: Option<Order>,
    /// Where it comes with the multipliers.
    pub(super) verdict: Option<Verdict>,
}

/// A point with what is seen there.
pub(super) type At<'a> = (&'a BranchPoint, &'a Seen);

/// How far a branch is followed, and what for.
#[derive(Debug, Clone)]
pub(crate) struct Stretch {
    /// Least and largest value.
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) events: Vec<Event>,
    pub(crate) tolerance: Tolerance,
    /// The branch is followed round its folds, and all its points are kept.
    pub(crate) whole: bool,
}

/// The branch, what is watched along it, and what has been passed.
pub(crate) struct Follower {
    pub(crate) branch: Branch,
    pub(crate) watcher: Watcher,
    pub(crate) ends: BranchEnds,
    pub(crate) stretch: Stretch,
    pub(crate) stop: Stop,
    pub(crate) passed: Vec<Station>,
    pub(crate) unresolved: Vec<Unresolved>,
    /// Steps without loss at an end of which Krein signatures could not be told; with losses parts of steps in which rounding leaves open what crosses
    /// the circle.
    pub(crate) untold: usize,
}

impl Follower {
    pub(crate) fn new(branch: Branch, watcher: Watcher, ends: BranchEnds, stretch: Stretch, stop: &Stop) -> Self {
        let (passed, unresolved, stop) = (Vec::new(), Vec::new(), stop.clone());
        Self { branch, watcher, ends, stretch, stop, passed, unresolved, untold: 0 }
    }

    pub(super) fn watches(&self, event: Event) -> bool {
        self.stretch.events.contains(&event)
    }

    /// Length of the range.
    pub(super) fn range(&self) -> f64 {
        self.stretch.to - self.stretch.from
    }

    pub(crate) fn evaluations(&self) -> usize {
        self.branch.evaluations()
    }

    pub(crate) fn spectra(&self) -> usize {
        self.watcher.spectra()
    }

    /// Tells a range in which rounding may hide an event. Ranges that touch become one.
    pub(super) fn hidden(&mut self, one: f64, other: f64) {
        let (mut from, mut to) = (one.min(other), one.max(other));
        self.unresolved.retain(|range| {
            let apart = range.to < from || to < range.from;
            if !apart {
                (from, to) = (from.min(range.from), to.max(range.to));
            }
            apart
        });
        self.unresolved.push(Unresolved { from, to });
    }

    /// A point as a diagram has it.
    pub(super) fn described(&mut self, point: &BranchPoint, seen: &Seen) -> Result<DiagramPoint, BreatherError> {
        let orbit = bounded(point.orbit());
        let own = seen.admissibility.is_none().then(|| self.watcher.admissibility(&orbit).ok()).flatten();
        let told = seen.admissibility.as_ref().or(own.as_ref());
        let (margin, physical) = (told.and_then(|told| told.margin), told.map(|told| told.is_physical()));
        let known = seen.verdict.map(|verdict| self.watcher.named(&orbit, verdict, self.stretch.tolerance));
        let verdict = known.or_else(|| self.watcher.verdict(&orbit, self.stretch.tolerance).ok());
        let orbit = orbit.to_orbit(self.ends.name)?;
        Ok(DiagramPoint { value: point.value(), orbit, margin, physical, verdict })
    }
}

//! Who follows a branch, and what its orbits have of their own, a chain's or a structure's.
//!
//! | module | holds |
//! |---|---|
//! | `follow` | steps, folds and ends, one way |
//! | `seen`, `between` | what is seen at a point; steps so short that no pair of events hides |
//! | `confirm`, `beside_resonance` | events where a test function changes its sign |
//! | `crossings`, `paths`, `cubic` | pairs of multipliers that cross the circle, by their slopes |
//! | `collision`, `order` | without losses, pairs that meet on it, and their Krein signatures |

mod beside_resonance;
mod between;
mod collision;
pub(crate) mod confirm;
mod crossings;
mod cubic;
pub(crate) mod follow;
mod order;
mod paths;
mod seen;

use nalgebra::Complex;
use vibrochain_breather::system::System;
use vibrochain_breather::{Admissibility, BranchError, Departure, SolutionCurve, SolutionPoint};
use vibrochain_lattice::{Resonance, Stop};

use crate::events::{EventOrbit, Watcher};
use crate::locate::answer::{End, Event, LocateError, Located, Unresolved};
use crate::locate::course::{DiagramPoint, Station};
use crate::verdict::{Tolerance, Verdict};

/// The orbits of an [`Ends`].
pub(crate) type OrbitOf<E> = <<E as Ends>::Watcher as Watcher>::Orbit;

/// A branch of them, and a point of it.
pub(crate) type Track<E> = SolutionCurve<<E as Ends>::System>;
pub(crate) type Point<E> = SolutionPoint<OrbitOf<E>>;

/// A branch, and the point of it to begin at.
pub(crate) type Begun<E> = (Track<E>, Point<E>);

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
    order: Option<order::Order>,
    /// Where it comes with the multipliers.
    pub(super) verdict: Option<Verdict>,
}

/// A point with what is seen there.
pub(super) type At<'a, E> = (&'a Point<E>, &'a Seen);

/// How a branch may end, by an event of other orbits there.
pub(crate) struct Ended<O> {
    pub(crate) value: f64,
    pub(crate) end: End,
    pub(crate) event: Option<Located<O>>,
}

/// What stands at the ends of branches, and beside them.
pub(crate) trait Ends: Sized {
    /// Who looks at orbits.
    type Watcher: Watcher<Orbit: EventOrbit>;
    /// Their equations.
    type System: System<Orbit = OrbitOf<Self>> + Clone;
    /// Impulses this small, against the first, are none.
    const VANISHED: f64;

    /// The resonance between two points, and where it is.
    fn resonance_between(branch: &Track<Self>, from: &Point<Self>, to: &Point<Self>) -> Option<(f64, Resonance)>;
    /// The resonance right ahead of a point, behind which there is none that could tell.
    fn resonance_ahead(&self, branch: &Track<Self>, point: &Point<Self>) -> Option<(f64, Resonance)>;
    /// Simpler orbits right ahead, of impulses that vanish, where the branch is lost; the `first` orbit was so strong.
    fn simpler_ahead(&mut self, point: &Point<Self>, first: f64) -> Option<Ended<OrbitOf<Self>>>;
    /// The event of more symmetric orbits that the branch comes to between two points, near `value`.
    fn meeting(
        &mut self,
        between: [&Point<Self>; 2],
        length: f64,
        value: f64,
    ) -> Result<Option<Located<OrbitOf<Self>>>, LocateError>;
    /// The branch that leaves an orbit at a value, and the point where it does.
    fn leaving(&self, at: (&OrbitOf<Self>, f64), departure: &Departure) -> Result<Begun<Self>, BranchError>;
    /// Who looks at orbits beside the branch.
    fn others(&mut self) -> &mut Self::Watcher;
    /// Orbits worked out beside the branch.
    fn evaluations(&self) -> usize {
        0
    }
    /// Spectra of these.
    fn spectra(&self) -> usize {
        0
    }
}

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
pub(crate) struct Follower<E: Ends> {
    pub(crate) branch: Track<E>,
    pub(crate) watcher: E::Watcher,
    pub(crate) ends: E,
    pub(crate) stretch: Stretch,
    pub(crate) stop: Stop,
    pub(crate) passed: Vec<Station<OrbitOf<E>>>,
    pub(crate) unresolved: Vec<Unresolved>,
    /// Steps without loss at an end of which Krein signatures could not be told; with losses parts of steps in which rounding leaves open what crosses
    /// the circle.
    pub(crate) untold: usize,
}

impl<E: Ends> Follower<E> {
    pub(crate) fn new(branch: Track<E>, watcher: E::Watcher, ends: E, stretch: Stretch, stop: &Stop) -> Self {
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
        self.branch.evaluations() + self.ends.evaluations()
    }

    pub(crate) fn spectra(&self) -> usize {
        self.watcher.spectra() + self.ends.spectra()
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
    pub(super) fn described(&mut self, point: &Point<E>, seen: &Seen) -> DiagramPoint<OrbitOf<E>> {
        let orbit = point.orbit();
        let own = seen.admissibility.is_none().then(|| self.watcher.admissibility(orbit).ok()).flatten();
        let told = seen.admissibility.as_ref().or(own.as_ref());
        let (margin, physical) = (told.and_then(|told| told.margin), told.map(|told| told.is_physical()));
        let verdict = seen.verdict.or_else(|| self.watcher.verdict(orbit, self.stretch.tolerance).ok());
        DiagramPoint { value: point.value(), orbit: orbit.clone(), margin, physical, verdict }
    }
}

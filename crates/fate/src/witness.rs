//! Whether one run keeps to its breather, and what its latest impacts repeat: the tests of an ensemble's runs, for a run that somebody
//! else carries on.

use vibrochain_breather::Orbit;
use vibrochain_eventsim::{Event, EventKind, Time};
use vibrochain_lattice::{Layout, Model};

use crate::end::End;
use crate::ensemble::Ensemble;
use crate::follow::{Follower, Track};
use crate::repeat::{Latest, REPETITIONS, word_of};
use crate::run::{CLOSE, LOOKED_AT};

/// Of a shorter run nothing is told: an impact of each kind may not have come yet.
const LEAST: f64 = 2.0;

/// Periods of a run that can tell that its impacts do not repeat: as many sequences of two periods as must be seen.
const TELLING: f64 = 2.0 * REPETITIONS as f64;

/// The impacts of a breather, which runs are held against.
#[derive(Debug, Clone)]
pub struct Pattern(Track);

impl Pattern {
    /// Of this breather.
    #[must_use]
    pub fn of(orbit: &Orbit) -> Self {
        Self(Track::of(orbit))
    }
}

/// What a run has come to.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// When it left the breather, in periods of the force since the start, if it did. It may have come back since.
    pub left: Option<f64>,
    /// How it ends: on the breather, on another motion whose impacts repeat, or without any. `None` where its impacts do not repeat, or it
    /// is [too short](Self::is_too_short) to tell.
    pub end: Option<End>,
    /// Whether no end was found because the run is too short to tell.
    pub is_too_short: bool,
}

/// Watches a run.
#[derive(Debug)]
pub struct Witness<'a> {
    pattern: Option<(&'a Track, f64, Follower<'a>)>,
    layout: Layout,
    forced: bool,
    close: f64,
    latest: Latest,
    /// The last event, and the last that was no impact.
    last: Option<f64>,
    rest: Option<Event>,
}

impl<'a> Witness<'a> {
    /// Of a run of `model`, from a breather at the time `start` of its own clock, or from anywhere.
    #[must_use]
    pub fn new(model: &Model, pattern: Option<(&'a Pattern, f64)>) -> Self {
        let Ensemble { tolerance, leave, .. } = Ensemble::default();
        let follow = |(Pattern(track), start): (&'a Pattern, f64)| (track, start, Follower::new(track, start, leave));
        let pattern = pattern.map(follow);
        let apart = pattern.as_ref().map_or(tolerance, |(track, ..)| track.shortest_wait() / track.unit);
        Self {
            pattern,
            layout: model.chain().layout(),
            forced: model.amplitude() > 0.0,
            close: CLOSE * tolerance.min(apart),
            latest: Latest::default(),
            last: None,
            rest: None,
        }
    }

    /// Takes note of an event.
    pub fn see(&mut self, event: &Event) {
        let now = event.time.in_periods();
        self.last = Some(now);
        if let Some((.., follower)) = &mut self.pattern {
            follower.see(event);
        }
        if event.kind == EventKind::Impact {
            self.latest.see(event, self.close);
            self.latest.forget(now - LOOKED_AT as f64);
        } else {
            self.rest = Some(*event);
        }
    }

    /// What the run has come to, which ends at `now`.
    #[must_use]
    pub fn outcome(mut self, now: Time) -> Outcome {
        let (tolerance, from) = (Ensemble::default().tolerance, now.in_periods() - LOOKED_AT as f64);
        let mut left = None;
        let mut span = 1.0;
        if let Some((track, _, follower)) = &mut self.pattern {
            span = track.span as f64;
            left = follower.left();
            follower.reach(now);
            // What never came is missed from the last event on.
            left = left.or(follower.left().map(|_| self.last.unwrap_or(0.0)));
        }
        if now.in_periods() < LEAST * span {
            return Outcome { left, end: None, is_too_short: true };
        }
        self.latest.forget(from);
        if let Some(rest) = self.rest.filter(|rest| rest.time.in_periods() >= from) {
            self.latest.see(&rest, self.close);
        }
        if self.latest.is_empty() {
            return Outcome { left, end: Some(End::Quiet), is_too_short: false };
        }
        self.latest.trim();
        let end = match &self.pattern {
            Some((track, start, _)) if self.latest.is(track, *start, tolerance) => Some(End::Breather),
            _ => {
                let repeated = self.latest.repeated(tolerance, self.forced);
                repeated.and_then(|instants| word_of(instants, |site| self.layout.place(site))).map(End::Periodic)
            }
        };
        let is_too_short = end.is_none() && now.in_periods() < TELLING;
        Outcome { left, end, is_too_short }
    }
}

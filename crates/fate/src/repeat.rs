//! What repeats in the latest impacts of a run: their word, if they have one.
//!
//! Modes that feel no impact keep what a perturbation has given them, for ever. So it is not the state that must repeat, but all that
//! impacts know of it: who hits what, when, and how fast.

use std::collections::VecDeque;

use vibrochain_breather::{Letter, MAX_IMPACTS, Word};
use vibrochain_eventsim::{Event, EventKind};
use vibrochain_lattice::Barrier;

use crate::follow::Track;

/// Impacts that are kept: of a word of the longest kind 64 repetitions.
const MOST: usize = 64 * MAX_IMPACTS;

/// A sequence must be seen so often before it is said to repeat.
pub(crate) const REPETITIONS: usize = 4;

/// One of the impacts of an instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hit {
    /// The mass, or the contact.
    pub(crate) site: usize,
    pub(crate) barrier: Barrier,
    velocity: f64,
}

/// The word of impacts by instants, with the site and the layer of each mass.
pub(crate) fn word_of(instants: Vec<Vec<Hit>>, place: impl Fn(usize) -> (usize, usize)) -> Option<Word> {
    let letter = |hit: &Hit| {
        let (site, layer) = place(hit.site);
        Letter { site, layer, barrier: hit.barrier }
    };
    Word::new(instants.iter().map(|hits| hits.iter().map(letter).collect()).collect()).ok()
}

/// Impacts at one time.
#[derive(Debug, Clone)]
struct Instant {
    periods: u64,
    /// In periods of the force.
    part: f64,
    hits: Vec<Hit>,
}

impl Instant {
    /// Time from `other` until here, in periods of the force.
    fn since(&self, other: &Self) -> f64 {
        (self.periods as f64 - other.periods as f64) + (self.part - other.part)
    }

    /// Same masses, same barriers; then the largest difference of velocities.
    fn differs(&self, other: &Self) -> Option<f64> {
        let pairs = || self.hits.iter().zip(&other.hits);
        let same = self.hits.len() == other.hits.len()
            && pairs().all(|(one, other)| (one.site, one.barrier) == (other.site, other.barrier));
        same.then(|| pairs().fold(0.0, |most: f64, (one, other)| most.max((one.velocity - other.velocity).abs())))
    }
}

/// The latest impacts of a run.
#[derive(Debug, Default)]
pub(crate) struct Latest {
    instants: VecDeque<Instant>,
    hits: usize,
    /// A mass has rested on a barrier: no word says that.
    rested: bool,
}

impl Latest {
    /// Takes note of an event. What is nearer to the one before than `close`, in periods, is of its instant.
    pub(crate) fn see(&mut self, event: &Event, close: f64) {
        if event.kind != EventKind::Impact {
            self.rested = true;
            return;
        }
        let hit = Hit { site: event.contact, barrier: event.barrier, velocity: event.velocity_before };
        let now = Instant { periods: event.time.periods(), part: event.time.part(), hits: vec![hit] };
        self.hits += 1;
        match self.instants.back_mut() {
            Some(last) if now.since(last) <= close && last.hits.iter().all(|other| other.site != hit.site) => {
                let place = last.hits.partition_point(|other| other.site < hit.site);
                last.hits.insert(place, hit);
            }
            _ => self.instants.push_back(now),
        }
        while self.hits > MOST {
            self.hits -= self.instants.pop_front().map_or(self.hits, |first| first.hits.len());
        }
    }

    /// Forgets what was before a time, in periods of the force.
    pub(crate) fn forget(&mut self, before: f64) {
        while self.instants.front().is_some_and(|first| first.periods as f64 + first.part < before) {
            self.hits -= self.instants.pop_front().map_or(0, |first| first.hits.len());
        }
    }

    /// Leaves out the first and the last instant, of which impacts may be missing.
    pub(crate) fn trim(&mut self) {
        for instant in [self.instants.pop_front(), self.instants.pop_back()].into_iter().flatten() {
            self.hits -= instant.hits.len();
        }
    }

    /// Whether there are no impacts.
    pub(crate) fn is_empty(&self) -> bool {
        self.instants.is_empty() && !self.rested
    }

    /// The shortest sequence that repeats throughout, in times (of a period) and velocities (of the fastest) to `tolerance`: how many
    /// instants it has. Under a force it takes whole periods of that.
    fn cycle(&self, tolerance: f64, forced: bool) -> Option<usize> {
        let (all, count) = (&self.instants, self.instants.len());
        if self.rested {
            return None;
        }
        let fastest =
            all.iter().flat_map(|instant| &instant.hits).fold(0.0, |most: f64, hit| most.max(hit.velocity.abs()));
        let repeats = |length: usize| {
            let first = all[length].since(&all[0]);
            let whole = if forced { first.round().max(1.0) } else { first };
            (0..count - length).all(|i| {
                let (one, next) = (&all[i], &all[i + length]);
                (next.since(one) - whole).abs() <= tolerance
                    && next.differs(one).is_some_and(|differs| differs <= tolerance * fastest)
            })
        };
        let of = |length: usize| all.iter().take(length).map(|instant| instant.hits.len()).sum::<usize>();
        (1..=count / REPETITIONS).take_while(|&length| of(length) <= MAX_IMPACTS).find(|&length| repeats(length))
    }

    /// Whether the latest impacts are those of the breather, at its own places and (under a force) times.
    pub(crate) fn is(&self, track: &Track, start: f64, tolerance: f64) -> bool {
        let (count, own) = (self.instants.len(), track.instants.len());
        if self.rested || count < own.max(2) {
            return false;
        }
        let matches = |at: usize, i: usize| {
            let (instant, expected) = (&self.instants[i], &track.instants[(at + i) % own]);
            let same = |hit: &Hit| {
                expected.iter().any(|one| {
                    (one.site, one.barrier) == (hit.site, hit.barrier)
                        && (one.velocity - hit.velocity).abs() <= tolerance * track.fastest
                })
            };
            let clock = ((instant.periods % track.span) as f64 + instant.part) * track.unit + start;
            let off_clock = if track.forced { track.apart(clock, expected[0].time) } else { 0.0 };
            let off_wait = if i > 0 {
                (instant.since(&self.instants[i - 1]) * track.unit - track.wait((at + i) % own)).abs()
            } else {
                0.0
            };
            let due = off_clock.max(off_wait);
            instant.hits.len() == expected.len() && instant.hits.iter().all(same) && due <= tolerance * track.period
        };
        (0..own).any(|at| (0..count).all(|i| matches(at, i)))
    }

    /// What repeats, if something does.
    pub(crate) fn repeated(&self, tolerance: f64, forced: bool) -> Option<Vec<Vec<Hit>>> {
        let length = self.cycle(tolerance, forced)?;
        Some(self.instants.iter().take(length).map(|instant| instant.hits.clone()).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::follow::Expected;
    use vibrochain_eventsim::Time;

    /// Impacts of one mass, once a period, with these velocities in turn.
    fn latest(velocities: &[f64]) -> Latest {
        let mut latest = Latest::default();
        for (period, velocity) in (0..40).zip(velocities.iter().cycle()) {
            let time = Time::of_period(2.0, period, 0.25);
            let (contact, barrier, kind) = (0, Barrier::Upper, EventKind::Impact);
            let (velocity_before, velocity_after, impulse) = (*velocity, -*velocity, -2.0 * *velocity);
            let event = Event { time, contact, barrier, velocity_before, velocity_after, impulse, kind };
            latest.see(&event, 1e-3);
        }
        latest
    }

    /// A run repeats where velocities do, too: times alone would call each of these one impact a period.
    #[test]
    fn velocities_that_differ_are_another_motion() {
        let tolerance = 0.02;
        for (velocities, instants) in [
            (vec![1.0], Some(1)),
            (vec![1.0, 1.01], Some(1)),
            (vec![1.0, 1.1], Some(2)),
            (vec![1.0, 1.1, 0.8], Some(3)),
            ((0..13).map(|i| 1.0 + 0.1 * f64::from(i)).collect(), None),
        ] {
            let found = latest(&velocities).repeated(tolerance, true).map(|instants| instants.len());
            assert_eq!(found, instants, "{velocities:?}");
        }
    }

    /// A run is on its breather if its impacts have the breather's times, velocities and masses; it is not if one of the three differs.
    #[test]
    fn a_run_is_on_its_breather_by_places_times_and_velocities() {
        let track = |site: usize, time: f64, velocity: f64| Track {
            instants: vec![vec![Expected { site, barrier: Barrier::Upper, time, velocity }]],
            fastest: velocity,
            period: std::f64::consts::PI,
            unit: std::f64::consts::PI,
            span: 1,
            forced: true,
        };
        let time = 0.25 * std::f64::consts::PI;
        for (own, is) in [
            (track(0, time, 1.0), true),
            (track(0, time, 1.01), true),
            (track(0, time, 1.1), false),
            (track(0, time, 0.9), false),
            (track(1, time, 1.0), false),
            (track(0, time + 0.1, 1.0), false),
        ] {
            assert_eq!(latest(&[1.0]).is(&own, 0.0, 0.02), is, "{own:?}");
        }
    }
}

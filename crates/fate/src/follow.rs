//! Whether a run follows its breather, impact by impact, and when it has left.

use vibrochain_breather::{Orbit, time_between};
use vibrochain_eventsim::{Event, EventKind, Time};
use vibrochain_lattice::Barrier;

/// An impact as the breather has it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Expected {
    pub(crate) site: usize,
    pub(crate) barrier: Barrier,
    /// Since the beginning of the breather's period.
    pub(crate) time: f64,
    pub(crate) velocity: f64,
}

/// The impacts of a breather by instants, and what deviations are measured by.
#[derive(Debug, Clone)]
pub(crate) struct Track {
    pub(crate) instants: Vec<Vec<Expected>>,
    /// The largest velocity at an impact.
    pub(crate) fastest: f64,
    pub(crate) period: f64,
    /// Period of the force.
    pub(crate) unit: f64,
    /// Periods of the force in one of the breather.
    pub(crate) span: u64,
    /// Impacts come at times that the force sets.
    pub(crate) forced: bool,
}

impl Track {
    pub(crate) fn of(orbit: &Orbit) -> Self {
        let expected = |impact: &vibrochain_breather::Impact| Expected {
            site: impact.site,
            barrier: impact.barrier,
            time: impact.time,
            velocity: impact.velocity_before,
        };
        Self {
            instants: orbit.instants().map(|impacts| impacts.iter().map(expected).collect()).collect(),
            fastest: orbit.impacts().iter().fold(0.0, |most: f64, impact| most.max(impact.velocity_before.abs())),
            period: orbit.period(),
            unit: orbit.force_period(),
            span: orbit.force_periods().into(),
            forced: orbit.is_forced(),
        }
    }

    /// Where no impact is expected.
    pub(crate) fn none(period: f64, forced: bool) -> Self {
        Self { instants: Vec::new(), fastest: 0.0, period, unit: period, span: 1, forced }
    }

    /// How long after the instant before it an instant comes; the only one of a period comes a period after itself.
    pub(crate) fn wait(&self, instant: usize) -> f64 {
        let count = self.instants.len();
        let [now, before] = [instant, (instant + count - 1) % count].map(|i| self.instants[i][0].time);
        if count == 1 { self.period } else { (now - before).rem_euclid(self.period) }
    }

    /// The shortest time between two instants.
    pub(crate) fn shortest_wait(&self) -> f64 {
        (0..self.instants.len()).map(|i| self.wait(i)).fold(self.period, f64::min)
    }

    /// The shortest distance of two times on the breather's period.
    pub(crate) fn apart(&self, one: f64, other: f64) -> f64 {
        time_between(one, other, self.period)
    }
}

/// Follows a run.
#[derive(Debug)]
pub(crate) struct Follower<'a> {
    track: &'a Track,
    /// Time of the run's start on the breather's clock.
    start: f64,
    /// Deviation from which the run has left.
    limit: f64,
    /// The instant that is due, and which of its impacts.
    instant: usize,
    open: Vec<bool>,
    /// When the latest instant began, on the run's clock in periods of the force and a rest; none before the first.
    last: Option<(u64, f64)>,
    /// Time when it left, in periods of the force.
    left: Option<f64>,
}

impl<'a> Follower<'a> {
    pub(crate) fn new(track: &'a Track, start: f64, limit: f64) -> Self {
        let open = track.instants.first().map_or(Vec::new(), |impacts| vec![true; impacts.len()]);
        Self { track, start, limit, instant: 0, open, last: None, left: None }
    }

    /// When it left, in periods of the force since the start.
    pub(crate) fn left(&self) -> Option<f64> {
        self.left
    }

    /// Time since the latest instant began.
    fn since_last(&self, time: Time) -> Option<f64> {
        self.last.map(|(periods, offset)| (time.periods() - periods) as f64 * self.track.unit + time.offset() - offset)
    }

    /// Takes note of an event.
    pub(crate) fn see(&mut self, event: &Event) {
        let is_watched = self.left.is_none() && !self.track.instants.is_empty();
        if is_watched && self.deviation(event) > self.limit {
            self.left = Some(event.time.in_periods());
        }
    }

    /// How far the event is from the impact that is due, as a part of the period or of the fastest impact; infinite where another was due.
    fn deviation(&mut self, event: &Event) -> f64 {
        let track = self.track;
        let impacts = &track.instants[self.instant];
        let place = impacts.iter().zip(&self.open).position(|(expected, open)| {
            *open
                && (expected.site, expected.barrier) == (event.contact, event.barrier)
                && event.kind == EventKind::Impact
        });
        let Some(place) = place else { return f64::INFINITY };
        let expected = impacts[place];
        let late = if track.forced {
            let on_clock = (event.time.periods() % track.span) as f64 * track.unit + event.time.offset() + self.start;
            track.apart(on_clock, expected.time)
        } else {
            // Without a force nothing says when, only how long after the one before: of impacts of one instant none.
            let first = self.open.iter().all(|open| *open);
            let wait = if first { track.wait(self.instant) } else { 0.0 };
            self.since_last(event.time).map_or(0.0, |since| (since - wait).abs())
        };
        if self.open.iter().all(|open| *open) {
            self.last = Some((event.time.periods(), event.time.offset()));
        }
        self.open[place] = false;
        if self.open.iter().all(|open| !open) {
            self.instant = (self.instant + 1) % track.instants.len();
            self.open = vec![true; track.instants[self.instant].len()];
        }
        let faster = (event.velocity_before - expected.velocity).abs() / track.fastest;
        faster.max(late / track.period)
    }

    /// Takes note that nothing else has happened up to `time`: an impact that is overdue is missed.
    pub(crate) fn reach(&mut self, time: Time) {
        let waited = self.since_last(time).unwrap_or_else(|| time.to_f64());
        let is_watched = self.left.is_none() && !self.track.instants.is_empty();
        if is_watched && waited > (1.0 + self.limit) * self.track.period {
            self.left = Some(time.in_periods());
        }
    }
}

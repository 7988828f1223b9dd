//! A step of a branch, so fine that no pair of events hides in it.
//!
//! Two zeros of one function in a step leave its signs as they were. So each step of a whole branch is looked at in its middle, too.
//! The parabola through the three values tells how far the function departs from its chords; where twice that could carry it to 0
//! and back, the step is halved. Halves that are near a touching zero are halved again.

use vibrochain_breather::BranchPoint;
use vibrochain_lattice::Barrier;

use super::confirm::Found;
use super::seen::value;
use super::{At, Follower, Seen};
use crate::events::Test;
use crate::locate::answer::{Event, LocateError};
use crate::locate::course::Station;

/// Halvings of a step at most: two zeros closer than this part of it stay hidden.
const DEEPEST: u32 = 12;

/// Halvings at most where signatures tell that a stripe is there: to the rounding of the step's length.
const THINNEST: u32 = 45;

/// Departures from the parabola that are allowed for, as a factor.
const SAFETY: f64 = 2.0;

/// Next to the edge of a stripe its opening grows by this factor at most within what is looked at at once.
const STEEPEST: f64 = 4.0;

impl Follower {
    /// All events on the way to `next`, and what is seen there.
    pub(super) fn watch(&mut self, from: At<'_>, next: &BranchPoint) -> Result<Seen, LocateError> {
        let length = self.branch.length_between(from.0, next);
        let seen = self.look_on(next, length)?;
        self.halved(from, (next, &seen), 0)?;
        self.pass(next, &seen)?;
        Ok(seen)
    }

    /// Keeps a point, if points are kept.
    pub(crate) fn pass(&mut self, point: &BranchPoint, seen: &Seen) -> Result<(), LocateError> {
        if self.stretch.whole {
            let point = self.described(point, seen)?;
            self.passed.push(Station::Point(point));
        }
        Ok(())
    }

    fn halved(&mut self, from: At<'_>, to: At<'_>, depth: u32) -> Result<(), LocateError> {
        let length = self.branch.length_between(from.0, to.0);
        let middle = self.branch.step(from.0, 0.5 * length)?;
        let seen = self.look_on(&middle, length)?;
        let between = (&middle, &seen);
        let clear = depth >= DEEPEST || self.is_clear([from, between, to]);
        let mut told = [false; 2];
        for (told, (from, to)) in told.iter_mut().zip([(from, between), (between, to)]) {
            // A stripe at ±1, however thin, shows in the signatures at both sides of it.
            let hidden = self.hides_doubling(from.1, to.1, depth);
            if depth >= THINNEST && hidden {
                self.hidden(from.0.value(), to.0.value());
            }
            *told = clear && (depth >= THINNEST || !hidden);
        }
        let mut crossings = self.crossings([from, between, to], told)?;
        for (part, (from, to)) in [(from, between), (between, to)].into_iter().enumerate() {
            if part == 1 {
                self.pass(&middle, &seen)?;
            }
            if told[part] {
                let found = self.all_between(from, to, std::mem::take(&mut crossings[part]))?;
                self.pass_events(from.0, found)?;
            } else {
                self.halved(from, to, depth + 1)?;
            }
        }
        Ok(())
    }

    /// Keeps events of a step. Between two of them there is something to see, however near to each other they are.
    fn pass_events(&mut self, from: &BranchPoint, found: Vec<Found>) -> Result<(), LocateError> {
        let mut last = None;
        for (at, located) in found {
            let middle = last.filter(|_| self.stretch.whole).map(|last: f64| self.branch.step(from, 0.5 * (last + at)));
            if let Some(Ok(middle)) = middle {
                let seen = self.look(&middle).unwrap_or_default();
                self.pass(&middle, &seen)?;
            }
            self.passed.push(Station::Event(located));
            last = Some(at);
        }
        Ok(())
    }

    /// All events between two neighbouring points, crossings of the circle among them, in the order of the way.
    pub(super) fn all_between(
        &mut self,
        from: At<'_>,
        to: At<'_>,
        crossings: Vec<Found>,
    ) -> Result<Vec<Found>, LocateError> {
        let mut found = Vec::new();
        self.zeros_between(from, to, &mut found)?;
        found.extend(crossings);
        if self.watches(Event::NeimarkSacker) && from.0.orbit().is_lossless() && to.0.orbit().is_lossless() {
            self.collisions(from, to, &mut found)?;
        }
        found.sort_by(|one, other| one.0.total_cmp(&other.0));
        Ok(found)
    }

    /// No function that is watched can vanish twice within either half of a step.
    fn is_clear(&self, [from, middle, to]: [At<'_>; 3]) -> bool {
        let (mut clear, mut clear_of_edges) = (true, true);
        let mut hold = |values: [f64; 3]| clear &= no_pair(values);
        let mut tests: Vec<Test> = (0..from.1.velocities.len()).map(Test::Velocity).collect();
        tests.extend((0..from.1.releases.len()).map(Test::Release));
        tests.extend([Test::Touch(0, Barrier::Lower), Test::One, Test::AnotherOne, Test::MinusOne]);
        for test in tests {
            let [a, m, b] = [from, middle, to].map(|at| value(test, at));
            if let (Some(a), Some(m), Some(b)) = (a, m, b) {
                hold([a, m, b]);
            }
        }
        // Two pairs that close on the circle and part again.
        let [from, middle, to] = [from.1, middle.1, to.1];
        if from.openings.len() == middle.openings.len() && middle.openings.len() == to.openings.len() {
            for ((a, m), b) in from.openings.iter().zip(&middle.openings).zip(&to.openings) {
                hold([*a, *m, *b]);
                // In the middle of a stripe they may close and part again within less than its width.
                clear_of_edges &= a.max(*m).max(*b) <= STEEPEST * a.min(*m).min(*b);
            }
        }
        clear && clear_of_edges
    }
}

/// The parabola through values at the beginning, the middle and the end of a step, its bend doubled, has no two zeros within either
/// half.
fn no_pair([from, middle, to]: [f64; 3]) -> bool {
    // From the chord of a half it departs by 4d u(1−u), u along the half.
    let departure = SAFETY * (0.5 * (from + to) - middle) / 4.0;
    [(from, middle), (middle, to)].into_iter().all(|(a, b)| {
        let apart = (a > 0.0) != (b > 0.0);
        // Towards 0: the chord lies on the bend's outer side.
        let towards = departure * a.signum() > 0.0;
        // |a|(1−u) + |b|u ≥ (√|a| + √|b|)² u(1−u), with equality somewhere.
        apart || !towards || 4.0 * departure.abs() <= (a.abs().sqrt() + b.abs().sqrt()).powi(2)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_of_zeros_is_suspected_and_a_straight_line_is_not() {
        let sample = |f: &dyn Fn(f64) -> f64| no_pair([f(0.0), f(0.5), f(1.0)]);
        // Two zeros in one half, seen from the outside alone.
        for centre in [0.2, 0.3, 0.75] {
            assert!(!sample(&|t| (t - centre) * (t - centre) - 1e-3), "{centre}");
            assert!(!sample(&|t| 1e-3 - (t - centre) * (t - centre)), "{centre}");
        }
        assert!(sample(&|t| 1.0 + t) && sample(&|t| t - 0.3) && sample(&|t| 1.0 + t * t) && sample(&|_| 0.0));
        // Far enough from 0, and bent away from it.
        assert!(sample(&|t| 0.2 + (t - 0.25) * (t - 0.25)) && sample(&|t| 1.0 - (t - 0.5) * (t - 0.5)));
    }
}

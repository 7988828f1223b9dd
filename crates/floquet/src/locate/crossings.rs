//! With losses: pairs of multipliers that cross the circle.

use nalgebra::Complex;
use vibrochain_breather::{BranchError, BreatherError};

use super::answer::{Event, LocateError};
use super::follower::{At, Ends, Follower, Point};
use super::settle::{BESIDE, Found};
use crate::events::half_sums::{Crossing, crossing, side, upper_half};
use crate::events::{EventOrbit, Test, Watcher};

/// Halvings of a step within which two multipliers must become distinguishable.
const HALVINGS: usize = 30;

/// A place on a step.
#[derive(Debug, Clone)]
struct Place {
    s: f64,
    /// One of each pair of multipliers.
    pairs: Vec<Complex<f64>>,
    /// Multipliers outside the circle, real ones among them.
    outside: usize,
}

impl Place {
    fn of(s: f64, values: &[Complex<f64>]) -> Self {
        Self { s, pairs: upper_half(values), outside: values.iter().filter(|mu| side(mu) > 0).count() }
    }
}

/// A part of a step, halved so many times.
struct Stretch {
    low: Place,
    high: Place,
    depth: usize,
}

impl<E: Ends> Follower<E> {
    /// All crossings between two points.
    pub(super) fn crossings(
        &mut self,
        from: At<'_, E>,
        to: At<'_, E>,
        found: &mut Vec<Found<E>>,
    ) -> Result<(), LocateError> {
        let length = self.branch.length_between(from.0, to.0);
        let mut parts = Vec::new();
        if let (Some(low), Some(high)) = (self.end(from.0, from, 0.0, length)?, self.end(from.0, to, length, -length)?)
        {
            parts.push(Stretch { low, high, depth: 0 });
        }
        while let Some(Stretch { low, high, depth }) = parts.pop() {
            match crossing(&low.pairs, &high.pairs) {
                Crossing::None => continue,
                Crossing::Pair(one, other) => {
                    let Some((along, located)) = self.crossing_of((from.0, to.0), [(low.s, one), (high.s, other)])
                    else {
                        if depth < HALVINGS {
                            self.halve(from.0, Stretch { low, high, depth }, &mut parts)?;
                        } else {
                            self.hidden_between(from.0, low.s, high.s);
                        }
                        continue;
                    };
                    // Others may be on both sides of it.
                    let beside = BESIDE * (high.s - low.s);
                    found.push((along, located));
                    for (end, s) in [(low, along - beside), (high, along + beside)] {
                        let before = s < along;
                        let outside = if before { s <= end.s } else { s >= end.s };
                        if depth >= HALVINGS || outside {
                            continue;
                        }
                        let Some(place) = self.pairs_at(from.0, s)? else { continue };
                        let (low, high) = if before { (end, place) } else { (place, end) };
                        parts.push(Stretch { low, high, depth: depth + 1 });
                    }
                }
                Crossing::Unclear if depth < HALVINGS => {
                    self.halve(from.0, Stretch { low, high, depth }, &mut parts)?
                }
                // The pairs are too near to each other to tell which one has crossed; their number tells that one has.
                Crossing::Unclear if low.outside.abs_diff(high.outside) > 1 => {
                    self.hidden_between(from.0, low.s, high.s);
                }
                Crossing::Unclear => {}
            }
        }
        Ok(())
    }

    /// An end of a step. Where losses end there all multipliers come to the circle: just before they have not.
    fn end(&mut self, from: &Point<E>, end: At<'_, E>, s: f64, length: f64) -> Result<Option<Place>, LocateError> {
        if !end.0.orbit().is_lossless() {
            return Ok((!end.1.values.is_empty()).then(|| Place::of(s, &end.1.values)));
        }
        self.pairs_at(from, s + BESIDE * length)
    }

    fn halve(
        &mut self,
        from: &Point<E>,
        Stretch { low, high, depth }: Stretch,
        parts: &mut Vec<Stretch>,
    ) -> Result<(), LocateError> {
        let Some(middle) = self.pairs_at(from, 0.5 * (low.s + high.s))? else { return Ok(()) };
        parts.push(Stretch { low: middle.clone(), high, depth: depth + 1 });
        parts.push(Stretch { low, high: middle, depth: depth + 1 });
        Ok(())
    }

    /// `None` at the end of what a parameter may be: beyond it there is nothing to cross to.
    fn pairs_at(&mut self, from: &Point<E>, s: f64) -> Result<Option<Place>, LocateError> {
        let there = match self.branch.step(from, s) {
            Err(BranchError::Breather(BreatherError::Parameter(_))) => return Ok(None),
            there => there?,
        };
        Ok(Some(Place::of(s, &self.watcher.spectrum(there.orbit(), self.stretch.tolerance)?.0)))
    }

    /// The crossing of the pair that goes from one value to another.
    fn crossing_of(
        &mut self,
        (from, to): (&Point<E>, &Point<E>),
        [(a, inside), (b, outside)]: [(f64, Complex<f64>); 2],
    ) -> Option<Found<E>> {
        let [one, other] = [inside, outside].map(|mu| mu.norm().ln());
        let share = one / (one - other);
        let angle = inside.arg() + share * (outside.arg() - inside.arg());
        let length = self.branch.length_between(from, to);
        let s = a + share * (b - a);
        let (solved, evidence) = self.solved(Test::Circle, (from, to), s / length, Some(angle))?;
        let along = self.length_to(from, &solved);
        // It is that pair's, and told from both ends.
        let reach = b - a;
        if !(a - reach..=b + reach).contains(&along) || solved.error > length * self.range() {
            return None;
        }
        Some((along, self.told(Event::NeimarkSacker, (from, along), solved, evidence)))
    }

    pub(super) fn hidden_between(&mut self, from: &Point<E>, low: f64, high: f64) {
        let ends = [low, high].map(|s| self.branch.step(from, s).map_or(from.value(), |end| end.value()));
        self.hidden(ends[0], ends[1]);
    }
}

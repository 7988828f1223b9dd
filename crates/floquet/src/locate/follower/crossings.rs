//! With losses: pairs of multipliers that cross the circle.

use nalgebra::Complex;
use vibrochain_breather::{BranchError, BreatherError};

use super::confirm::{BESIDE, Found, Part};
use super::seen::velocities;
use super::{At, Ends, Follower, Point};
use crate::bracket::zero;
use crate::events::half_sums::{Crossing, crossing, side, upper_half};
use crate::events::{EventOrbit, Test, Watcher};
use crate::locate::answer::{Event, LocateError};

/// Halvings of a step within which two multipliers must become distinguishable.
const HALVINGS: u32 = 30;

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

impl<E: Ends> Follower<E> {
    /// All crossings between two points.
    pub(super) fn crossings(
        &mut self,
        from: At<'_, E>,
        to: At<'_, E>,
        found: &mut Vec<Found<E>>,
    ) -> Result<(), LocateError> {
        let length = self.branch.length_between(from.0, to.0);
        let (vanishing, beside) = (self.vanishing((from.0, to.0), length)?, BESIDE * length);
        let mut parts: Vec<Part<Place>> = Vec::new();
        if let (Some(low), Some(high)) = (self.end(from.0, from, 0.0, length)?, self.end(from.0, to, length, -length)?)
        {
            parts.push(Part { from: low, to: high, depth: 0 });
        }
        while let Some(Part { from: low, to: high, depth }) = parts.pop() {
            let ends = [low.s, high.s];
            let vanishes = vanishing.iter().find(|s| (ends[0]..=ends[1]).contains(*s));
            let told = crossing(&low.pairs, &high.pairs);
            let located = match (vanishes, told) {
                (None, Crossing::Pair(one, other)) => {
                    let located = self.crossing_of((from.0, to.0), [(low.s, one), (high.s, other)]);
                    located.filter(|(along, _)| vanishing.iter().all(|s| (s - along).abs() >= beside))
                }
                _ => None,
            };
            let sides = match (vanishes, located, told) {
                (Some(s), ..) => self.sides(from.0, [s - beside, s + beside], ends)?,
                (_, Some((along, located)), _) => {
                    found.push((along, located));
                    // Others may be on both sides of it.
                    let beside = if depth < HALVINGS { BESIDE * (high.s - low.s) } else { f64::INFINITY };
                    self.sides(from.0, [along - beside, along + beside], ends)?
                }
                (.., Crossing::None) => continue,
                _ if depth < HALVINGS => {
                    let middle = self.pairs_at(from.0, 0.5 * (low.s + high.s))?;
                    [middle.clone(), middle]
                }
                // The pairs are too near to each other to tell which one has crossed; their number tells that one has.
                (.., Crossing::Unclear) if low.outside.abs_diff(high.outside) <= 1 => continue,
                _ => {
                    self.hidden_between(from.0, low.s, high.s);
                    continue;
                }
            };
            parts.extend(Part { from: low, to: high, depth }.parted(sides));
        }
        Ok(())
    }

    /// Where in a step an impulse vanishes. It damps nothing there, so that all pairs which feel it meet the circle at once, and are on the other
    /// side of it where it pulls: that is the grazing, and no crossing of any of them.
    fn vanishing(&mut self, (from, to): (&Point<E>, &Point<E>), length: f64) -> Result<Vec<f64>, LocateError> {
        let ends = velocities(from.orbit()).into_iter().zip(velocities(to.orbit())).enumerate();
        let places = ends.filter(|(_, (low, high))| (*low > 0.0) != (*high > 0.0)).map(|(i, (low, high))| {
            let at = |s: f64| Ok::<_, BranchError>(velocities(self.branch.step(from, s)?.orbit())[i]);
            Ok(zero((0.0, low), (length, high), length, at)?)
        });
        places.collect()
    }

    /// An end of a step. Where losses end there all multipliers come to the circle: just before they have not.
    fn end(&mut self, from: &Point<E>, end: At<'_, E>, s: f64, length: f64) -> Result<Option<Place>, LocateError> {
        if !end.0.orbit().is_lossless() {
            return Ok((!end.1.values.is_empty()).then(|| Place::of(s, &end.1.values)));
        }
        self.pairs_at(from, s + BESIDE * length)
    }

    /// Places on both sides of something in a part, as far as they are in it.
    fn sides(
        &mut self,
        from: &Point<E>,
        [before, behind]: [f64; 2],
        [low, high]: [f64; 2],
    ) -> Result<[Option<Place>; 2], LocateError> {
        let before = if before > low { self.pairs_at(from, before)? } else { None };
        Ok([before, if behind < high { self.pairs_at(from, behind)? } else { None }])
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

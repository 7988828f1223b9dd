//! Without loss: two pairs of multipliers that collide on the circle, or part there.
//!
//! Two collide only if their Krein signatures differ. On the circle none passes another of the other signature without leaving it;
//! so the signatures in the order of their pairs change only through such a stripe of instability. Where they have changed over a step
//! at both ends of which as many pairs are on the circle, a stripe hides between, however thin: halving finds it.

use nalgebra::Complex;
use vibrochain_breather::{BranchPoint, Orbit};

use super::answer::{Event, LocateError, Unresolved};
use super::follower::{Follower, Observation};
use super::spectrum_events::{collided, complex_count, half_sums};
use super::watch::{HALVINGS, Step, Test};
use crate::stripes::{Signature, signature};

/// Halvings of a step in search of a stripe: to the rounding of its length. Where the number of pairs on the circle changes
/// otherwise, as at a period doubling, only so many that what else the step holds is told from that.
const DEEPEST: u32 = 45;
const APART: u32 = 10;

/// Where a pair of edges was sought, and how far from an edge a collision is looked at, as a part of the step.
const REACH: f64 = 1e-4;

type Sums = Vec<Complex<f64>>;

impl Follower {
    /// The first collision in a step; with the place inside a stripe that was hidden in it.
    pub(super) fn collision(
        &mut self,
        step: Step<'_>,
        seen: &Observation,
        (next, next_seen): (&BranchPoint, &Observation),
    ) -> Result<Option<(f64, Test, Option<f64>)>, LocateError> {
        let reversible = step.point.orbit().is_reversible();
        let (on, off) = (half_sums(&seen.values, reversible), half_sums(&next_seen.values, reversible));
        if complex_count(&on) != complex_count(&off) {
            let edge = self.edge(step, (0.0, on), (step.length, off), REACH * step.length)?;
            return Ok(edge.map(|(s, _, test)| (s, test, None)));
        }
        let (Some(before), Some(after)) = (self.order(step.point.orbit(), &on)?, self.order(next.orbit(), &off)?)
        else {
            return Ok(None);
        };
        let Some([low, inside, high]) = self.hidden(step, (&on, before), after)? else { return Ok(None) };
        let reach = (0.5 * (high.0 - low.0)).min(REACH * step.length);
        // Where stripes overlap there may be a further edge before the place inside.
        let (at, several) = (inside.0, complex_count(&inside.1) > complex_count(&low.1) + 1);
        let edge = self.edge(step, low, inside, reach)?;
        Ok(edge.map(|(s, behind, test)| (s, test, Some(if several { behind } else { at }))))
    }

    /// The first end of a stripe between two places, of which one is inside; with a place just behind it.
    fn edge(
        &mut self,
        step: Step<'_>,
        (mut low, mut on): (f64, Sums),
        (mut high, mut off): (f64, Sums),
        reach: f64,
    ) -> Result<Option<(f64, f64, Test)>, LocateError> {
        let most = high;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let sums = self.sums(step, middle)?;
            if complex_count(&sums) == complex_count(&on) {
                (low, on) = (middle, sums);
            } else {
                (high, off) = (middle, sums);
            }
        }
        let (fewer, more) = if complex_count(&on) < complex_count(&off) { (&on, &off) } else { (&off, &on) };
        let Some(centre) = collided(fewer, more) else { return Ok(None) };
        let test = Test::Collision { centre: centre.re };
        // Far enough out for the two to be told from one.
        let (low, high) = ((low - reach).max(0.0), (high + reach).min(most));
        let mut ends = [(low, 0.0), (high, 0.0)];
        for (s, value) in &mut ends {
            let there = self.branch.step(step.point, *s)?;
            *value = self.value(test, &there, *s)?;
        }
        if (ends[0].1 > 0.0) == (ends[1].1 > 0.0) {
            return Ok(None);
        }
        Ok(Some((self.zero_of(test, step.point, ends[0], ends[1])?, high, test)))
    }

    fn sums(&mut self, step: Step<'_>, s: f64) -> Result<Sums, LocateError> {
        let there = self.branch.step(step.point, s)?;
        Ok(half_sums(&self.spectrum(there.orbit())?, there.orbit().is_reversible()))
    }

    /// A stripe hidden in a step: places before it, in it and behind it. One too thin for the signs of rounding is noted as
    /// unresolved.
    fn hidden(
        &mut self,
        step: Step<'_>,
        (on, before): (&Sums, Vec<Signature>),
        after: Vec<Signature>,
    ) -> Result<Option<[(f64, Sums); 3]>, LocateError> {
        let mut parts = vec![((0.0, before), (step.length, after), 0)];
        while let Some(((low, before), (high, after), depth)) = parts.pop() {
            if before == after || before.len() != after.len() && depth >= APART {
                continue;
            }
            let ends = [self.branch.step(step.point, low)?, self.branch.step(step.point, high)?];
            if depth >= DEEPEST {
                let [from, to] = ends.map(|end| end.value());
                self.unresolved.push(Unresolved { from: from.min(to), to: from.max(to) });
                continue;
            }
            let middle = 0.5 * (low + high);
            let there = self.branch.step(step.point, middle)?;
            let sums = half_sums(&self.spectrum(there.orbit())?, there.orbit().is_reversible());
            if complex_count(&sums) > complex_count(on) {
                let (before, behind) = (self.sums(step, low)?, self.sums(step, high)?);
                return Ok(Some([(low, before), (middle, sums), (high, behind)]));
            }
            let Some(order) = self.order(there.orbit(), &sums)? else { continue };
            parts.push(((middle, order.clone()), (high, after), depth + 1));
            parts.push(((low, before), (middle, order), depth + 1));
        }
        Ok(None)
    }

    /// Whether between two points a pair has left the circle at −1 or +1, against itself, and come back. It has the other signature then:
    /// the balance of signatures tells, while as many pairs as before are beyond either end.
    pub(super) fn hides_doubling(&mut self, from: &BranchPoint, to: &BranchPoint) -> Result<bool, LocateError> {
        let orbit = from.orbit();
        let at_ends = [Event::PeriodDoubling, Event::Pitchfork].into_iter().any(|event| self.watches(event));
        if !at_ends || orbit.model().loss() != 0.0 || orbit.centre().is_none() {
            return Ok(false);
        }
        let mut told = |point: &BranchPoint| -> Result<_, LocateError> {
            let orbit = point.orbit();
            let sums = half_sums(&self.spectrum(orbit)?, orbit.is_reversible());
            let order = self.order(orbit, &sums)?;
            let beyond = [-1.0, 1.0].map(|end| sums.iter().filter(|nu| nu.im == 0.0 && nu.re * end >= 1.0).count());
            let plus = |order: Vec<Signature>| order.iter().filter(|one| **one == Signature::Positive).count();
            Ok(order.map(|order| (beyond, complex_count(&sums), order.len(), plus(order))))
        };
        let (Some(before), Some(behind)) = (told(from)?, told(to)?) else { return Ok(false) };
        Ok((before.0, before.1, before.2) == (behind.0, behind.1, behind.2) && before.3 != behind.3)
    }

    /// Signatures of the pairs on the circle in the order of ν; `None` where one cannot be told.
    fn order(&mut self, orbit: &Orbit, sums: &[Complex<f64>]) -> Result<Option<Vec<Signature>>, LocateError> {
        if orbit.centre().is_none() {
            return Ok(None);
        }
        let mut on_circle: Vec<f64> =
            sums.iter().filter(|nu| nu.im == 0.0 && nu.re.abs() < 1.0).map(|nu| nu.re).collect();
        on_circle.sort_by(f64::total_cmp);
        let prepared = self.finder.prepared(orbit).map_err(crate::FloquetError::from)?;
        let told = |nu: &f64| signature(prepared, Complex::new(*nu, ((1.0 - nu) * (1.0 + nu)).sqrt()));
        Ok(on_circle.iter().map(told).collect())
    }
}

//! Without loss: two pairs of multipliers that collide on the circle, or part there.
//!
//! Two collide only if their Krein signatures differ. On the circle none passes another of the other signature without leaving it;
//! so the signatures in the order of their pairs change only through such a stripe of instability. Where they have changed over a step
//! at both ends of which as many pairs are on the circle, a stripe hides between, however thin: where the two meet that have changed
//! places is inside it. Pairs of parts that a symmetry keeps apart (`order`) have an order each: they pass through each other.
//!
//! Inside a stripe two pairs may close and two others part before the next point. Then the place among the others has changed that
//! those off the circle have. It does so without an event, too, where they drift past a pair that stays: so halving ends sooner.

use nalgebra::Complex;
use vibrochain_breather::BranchPoint;

use super::confirm::{Found, Part};
use super::{At, Follower, Seen};
use crate::events::Order;
use crate::events::half_sums::{SPLIT, collided, complex_count};
use crate::events::{Solved, Test};
use crate::locate::answer::{Event, Evidence, LocateError};

/// Halvings of a step in search of a stripe: to the rounding of its length.
const DEEPEST: u32 = 45;

/// Where the order may have changed otherwise, as at a period doubling, only so many: what else the step holds is told from that.
const APART: u32 = 10;

/// Halvings of a step by which other events in it are set apart from a doubling that hides.
const ASIDE: u32 = 5;

/// An edge is looked for by Newton's method in a part of a step halved so often: there it is alone but for thin stripes, which the order
/// tells of.
const ALONE: u32 = 8;

/// From so many halvings on, two that have changed places are looked for where they come nearest to each other; in so many steps.
const NEARBY: u32 = 3;
const PARABOLAS: usize = 24;

/// How near to an edge, as a part of what is beside it, the order is told at first, and if it cannot be.
const NEXT_TO: [f64; 3] = [1e-3, 1e-2, 1e-1];

/// Where else in a part its order may be told, if two meet right in its middle.
const BESIDE: [f64; 3] = [0.45, 0.6, 0.3];

/// Edges that are no farther apart than so many errors are the same one.
const SAME: f64 = 4.0;

type Sums = Vec<Complex<f64>>;

/// The end of a stripe, and how far along the step it is.
type Edge = (f64, Solved, Evidence);

/// A place on a step.
#[derive(Debug, Clone)]
struct Place {
    s: f64,
    sums: Sums,
    order: Option<Order>,
}

impl Place {
    fn new(s: f64, seen: &Seen) -> Self {
        Self { s, sums: seen.values.clone(), order: seen.order.clone() }
    }

    fn told(&self) -> Option<&Order> {
        told(&self.order)
    }

    fn off_circle(&self) -> usize {
        complex_count(&self.sums)
    }
}

/// An order of which every signature is told.
fn told(order: &Option<Order>) -> Option<&Order> {
    order.as_ref().filter(|order| order.is_told())
}

impl Follower {
    /// All collisions in a step.
    pub(super) fn collisions(
        &mut self,
        (point, seen): At<'_>,
        (next, next_seen): At<'_>,
        found: &mut Vec<Found>,
    ) -> Result<(), LocateError> {
        let length = self.branch.length_between(point, next);
        let first = Place::new(0.0, seen);
        let last = Place::new(length, next_seen);
        self.untold += usize::from(first.told().is_none() || last.told().is_none());
        let (mut parts, mut edges) = (vec![Part { from: first, to: last, depth: 0 }], Vec::new());
        while let Some(Part { from, to, depth }) = parts.pop() {
            let event = match from.off_circle().abs_diff(to.off_circle()) {
                0 => {
                    let (Some(before), Some(after)) = (from.told(), to.told()) else { continue };
                    let certain = before.swapped(after).is_some();
                    if before == after || !certain && depth >= APART {
                        continue;
                    }
                    if certain
                        && (NEARBY..DEEPEST).contains(&depth)
                        && let Some(inside) = self.meeting(point, [&from, &to])?
                    {
                        let part = Part { from, to, depth: depth.max(ALONE - 1) };
                        parts.extend(part.parted([Some(inside.clone()), Some(inside)]));
                        continue;
                    }
                    certain
                }
                2 if depth >= ALONE => {
                    let range = self.range();
                    let is_new = |(at, solved, _): &Edge| {
                        edges.iter().all(|edge: &Edge| (edge.0 - at).abs() * range > SAME * solved.error)
                    };
                    let edge = self.edge((point, next), length, [&from, &to]).filter(is_new);
                    if let Some((at, solved, evidence)) = edge {
                        edges.push((at, solved, evidence));
                        // On both sides of it there may be stripes besides.
                        if depth < DEEPEST {
                            let [before, behind] = [&from, &to].map(|end| self.next_to(point, at, end));
                            parts.extend(Part { from, to, depth }.parted([before?, behind?]));
                        }
                        continue;
                    }
                    true
                }
                _ => true,
            };
            let middle = if depth < DEEPEST { Some(self.between_places(point, from.s, to.s)?) } else { None };
            // Two that have changed places, but lie too near to each other all the way between.
            let swapped = event && from.off_circle() == to.off_circle();
            let known =
                |middle: &Place| !swapped || middle.told().is_some() || middle.off_circle() != from.off_circle();
            if let Some(middle) = middle.filter(known) {
                parts.extend(Part { from, to, depth }.parted([Some(middle.clone()), Some(middle)]));
            } else if event {
                self.hidden_between(point, from.s, to.s);
            }
        }
        edges.sort_by(|one, other| one.0.total_cmp(&other.0));
        let places: Vec<f64> = edges.iter().map(|edge| edge.0).collect();
        for (i, (at, solved, evidence)) in edges.into_iter().enumerate() {
            let neighbours = [i.checked_sub(1), Some(i + 1)].into_iter().flatten().filter_map(|i| places.get(i));
            let alone = neighbours.map(|other| (other - at).abs()).fold(length, f64::min);
            if solved.error <= alone * self.range() {
                found.push((at, self.told(Event::NeimarkSacker, (point, at), solved, evidence)?));
            } else {
                // It is there, but the stripe is too thin for its digits.
                self.hidden_between(point, (at - alone).max(0.0), (at + alone).min(length));
            }
        }
        Ok(())
    }

    /// Whether between two points a pair has left the circle at −1 or +1, against itself, and come back. It has the other signature then:
    /// the balance of signatures tells, while as many pairs as before are beyond either end.
    pub(super) fn hides_doubling(&self, from: &Seen, to: &Seen, depth: u32) -> bool {
        let at_ends = [Event::PeriodDoubling, Event::Pitchfork].into_iter().any(|event| self.watches(event));
        let (Some(before), Some(behind)) = (told(&from.order), told(&to.order)) else { return false };
        let off = |seen: &Seen, order: &Order| {
            let beyond = [-1.0, 1.0]
                .map(|end| seen.values.iter().filter(|nu| nu.im.abs() <= SPLIT && nu.re * end >= 1.0).count());
            (beyond, seen.openings.len(), order.size())
        };
        // Where other events change the numbers, halves that are free of them can tell.
        let comparable = off(from, before) == off(to, behind);
        at_ends && if comparable { before.kinds() != behind.kinds() } else { depth < ASIDE }
    }

    /// A place on the side of `end` so near to an edge as the order can be told.
    fn next_to(&mut self, point: &BranchPoint, edge: f64, end: &Place) -> Result<Option<Place>, LocateError> {
        for share in NEXT_TO {
            let place = self.place_at(point, edge + share * (end.s - edge))?;
            if place.told().is_some() && place.off_circle() == end.off_circle() {
                return Ok(Some(place));
            }
        }
        Ok(None)
    }

    /// Where the two meet that have changed places between two places: the least (ν₁ − ν₂)², by parabolas through three points.
    fn meeting(&mut self, point: &BranchPoint, [from, to]: [&Place; 2]) -> Result<Option<Place>, LocateError> {
        let (Some(before), Some(after)) = (from.told(), to.told()) else { return Ok(None) };
        let Some(swapped) = before.swapped(after) else { return Ok(None) };
        let gap = |place: &Place| place.order.as_ref()?.gap(swapped);
        let inside = |place: &Place| place.off_circle() > from.off_circle();
        let (Some(low), Some(high)) = (gap(from), gap(to)) else { return Ok(None) };
        let (mut low, mut high) = ((from.s, low), (to.s, high));
        let mut middle = 0.5 * (low.0 + high.0);
        for _ in 0..PARABOLAS {
            let place = self.place_at(point, middle)?;
            if inside(&place) {
                return Ok(Some(place));
            }
            let Some(value) = gap(&place) else { break };
            // The lowest point of the parabola through the three.
            let (left, right) = ((value - low.1) / (middle - low.0), (high.1 - value) / (high.0 - middle));
            let bend = (right - left) / (high.0 - low.0);
            let next = 0.5 * (low.0 + middle) - 0.5 * left / bend;
            if next.is_nan() || next <= low.0 || next >= high.0 || bend <= 0.0 {
                break;
            }
            if next < middle {
                high = (middle, value)
            } else {
                low = (middle, value)
            }
            if next == middle {
                break;
            }
            middle = next;
        }
        Ok(None)
    }

    /// The end of a stripe between two places, of which one is inside.
    fn edge(
        &mut self,
        (point, next): (&BranchPoint, &BranchPoint),
        length: f64,
        [from, to]: [&Place; 2],
    ) -> Option<Edge> {
        let (fewer, more) = if from.off_circle() < to.off_circle() { (from, to) } else { (to, from) };
        let angle = collided(&fewer.sums, &more.sums)?.re.clamp(-1.0, 1.0).acos();
        let share = 0.5 * (from.s + to.s) / length;
        let (solved, evidence) = self.solved(Test::Collision, (point, next), share, Some(angle))?;
        let at = self.length_to(point, &solved);
        // As long as the two are nearly one they seem to be on the circle: the end itself may lie beyond.
        let room = fewer.s - more.s;
        let (least, most) = (from.s + room.min(0.0), to.s + room.max(0.0));
        (least..=most).contains(&at).then_some((at, solved, evidence))
    }

    fn place_at(&mut self, point: &BranchPoint, s: f64) -> Result<Place, LocateError> {
        let there = self.branch.step(point, s)?;
        let (values, _) = self.watcher.spectrum(there.orbit(), self.stretch.tolerance)?;
        Ok(Place { s, order: Order::of_orbit(there.orbit(), &values), sums: values })
    }

    /// The middle, or where the order can be told beside it.
    fn between_places(&mut self, point: &BranchPoint, from: f64, to: f64) -> Result<Place, LocateError> {
        let mut place = self.place_at(point, 0.5 * (from + to))?;
        for share in BESIDE {
            if place.told().is_none() {
                place = self.place_at(point, from + share * (to - from))?;
            }
        }
        Ok(place)
    }
}

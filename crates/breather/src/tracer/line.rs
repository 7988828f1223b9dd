//! Lines through a window of two parameters, from point to point: curves of events, edges of stripes, borders between classes.
//!
//! The next point is foreseen through the last four and found by what the line is a line of. A step is as long as the straight line
//! between its ends may be, which is told by the second difference of the last three points.

use std::convert::Infallible;

use smallvec::SmallVec;

use crate::equations::linear::{Vector, zeros};
use crate::tracer::pace::Pace;
use crate::tracer::walk::{Stride, Walk, walk};

/// A step as short as this may bend: a corner is no curve.
const SHORT: f64 = 3e-5;

/// The straight line between two points may err by this part of the tolerance: what is foreseen is not quite what comes. One that errs
/// by more than all of it is drawn again, no shorter than by the second factor.
const ROOM: f64 = 0.6;
const LEAST: f64 = 0.1;

/// Points of a line at most, one way.
const MOST_POINTS: usize = 50_000;

/// Points through which the next one is foreseen, each farther from the next than this part of the step.
const THROUGH: usize = 4;
const CROWDED: f64 = 0.1;

/// A step along a line.
#[derive(Debug)]
pub enum Step<P, E> {
    /// To this point.
    On(P),
    /// Out of the window, where the line ends: at this point, or at the last.
    Out(Option<P>, E),
}

/// A line that is traced, one way.
pub trait Line {
    /// A point of it.
    type Point;
    /// Why it goes no farther.
    type End;

    /// The first step, where a side of the window is one unit, and so is a change of order 1 of the orbit.
    const FIRST: f64 = 1e-3;
    /// It is back where it began.
    const CLOSED: Self::End;
    /// It has more points than are ever followed.
    const LONG: Self::End;

    /// The step to a point about a length ahead of the last; `None` where a shorter one may succeed.
    fn ahead(&mut self, passed: &[Self::Point], length: f64) -> Option<Step<Self::Point, Self::End>>;

    /// The longest step from the last of some points.
    fn longest(&self, _passed: &[Self::Point]) -> f64 {
        Pace::LONGEST
    }

    /// By what the straight line between the last two of three points errs, as a part of the window's sides.
    fn bend(&self, through: [&Self::Point; 3]) -> f64;

    /// The first point once more, if the line is back there on its way to `next`.
    fn closed(&mut self, _passed: &[Self::Point], _next: &Self::Point) -> Option<Self::Point> {
        None
    }

    /// Adds a point that was reached, after what lies before it.
    fn pass(&mut self, passed: &mut Vec<Self::Point>, next: Self::Point) {
        passed.push(next);
    }

    /// What ends the line at the last point.
    fn ended(&mut self, passed: &mut Vec<Self::Point>) -> Option<Self::End>;

    /// What ends it behind the last point, where none was found, however near.
    fn lost(&self, passed: &[Self::Point]) -> Self::End;
}

/// Follows a line from a point of it, which is the first of all that are handed over. A straight line between two neighbours errs by
/// `tolerance` at most, as a part of the window's sides.
pub fn trace<L: Line>(line: &mut L, start: L::Point, tolerance: f64) -> (Vec<L::Point>, L::End) {
    let mut drawn = Drawn { line, passed: vec![start], tolerance };
    let Ok(end) = walk(&mut drawn, L::FIRST);
    (drawn.passed, end)
}

/// A line as far as it is drawn.
struct Drawn<'a, L: Line> {
    line: &'a mut L,
    passed: Vec<L::Point>,
    tolerance: f64,
}

impl<L: Line> Walk for Drawn<'_, L> {
    type End = L::End;
    type Error = Infallible;

    fn step(&mut self, length: f64) -> Result<Stride<L::End>, Infallible> {
        let Self { line, passed, tolerance } = self;
        let next = match line.ahead(passed, length) {
            Some(Step::On(next)) => next,
            Some(Step::Out(last, end)) => {
                last.into_iter().for_each(|last| line.pass(passed, last));
                return Ok(Stride::Ended(end));
            }
            None => return Ok(Stride::Failed),
        };
        let bend = passed.last_chunk().map_or(0.0, |[before, last]| line.bend([before, last, &next]));
        let wanted = if bend > 0.0 { (ROOM * *tolerance / bend).sqrt() } else { f64::INFINITY };
        if bend > *tolerance && length > SHORT {
            return Ok(Stride::Shorter(length * wanted.max(LEAST)));
        }
        if let Some(first) = line.closed(passed, &next) {
            line.pass(passed, first);
            return Ok(Stride::Ended(L::CLOSED));
        }
        line.pass(passed, next);
        Ok(match line.ended(passed) {
            Some(end) => Stride::Ended(end),
            None if passed.len() > MOST_POINTS => Stride::Ended(L::LONG),
            None => Stride::Made { wanted, longest: line.longest(passed) },
        })
    }

    fn lost(&mut self) -> Result<L::End, Infallible> {
        Ok(self.line.lost(&self.passed))
    }
}

/// The points of one line that was followed both ways from its start, the first of both.
pub fn joined<P>(behind: Vec<P>, ahead: Vec<P>) -> Vec<P> {
    behind.into_iter().rev().chain(ahead.into_iter().skip(1)).collect()
}

/// What a straight line between the last two of three places errs by, if the curve is a parabola through them: (1/8) of the second
/// difference across it, for steps of these lengths.
pub fn chord_error([a, b, c]: [[f64; 2]; 3], [before, last]: [f64; 2]) -> f64 {
    let chord = [c[0] - b[0], c[1] - b[1]];
    let bend = [0, 1].map(|i| 2.0 * (chord[i] / last - (b[i] - a[i]) / before) / (before + last));
    let norm = chord[0].hypot(chord[1]);
    // Where the curve stands still in the plane all of the bend counts.
    let bend = if norm > 0.0 { (bend[0] * chord[1] - bend[1] * chord[0]).abs() / norm } else { bend[0].hypot(bend[1]) };
    bend * last * last / 8.0
}

/// Where a curve is expected at the length `wanted`: on the polynomial through the last of its places, which come with their lengths, the last
/// one first. A place much nearer to the one after it than `wanted` is to the last tells nothing of how the curve bends, and is passed over.
/// `None` where fewer than two are left.
pub fn foreseen<'a>(places: impl IntoIterator<Item = (f64, &'a [f64])>, wanted: f64) -> Option<Vector> {
    let mut through: SmallVec<[(f64, &[f64]); THROUGH]> = SmallVec::new();
    for (at, place) in places {
        let [first, last] = [through.first(), through.last()].map(|one| one.map_or(at, |one| one.0));
        if through.is_empty() || (at - last).abs() > CROWDED * (wanted - first).abs() {
            through.push((at, place));
        }
        if through.len() == THROUGH {
            break;
        }
    }
    let [(_, last), _, ..] = &through[..] else { return None };
    let mut sum = zeros(last.len());
    for (i, (at, place)) in through.iter().enumerate() {
        // Lagrange's.
        let others = through.iter().enumerate().filter(|(j, _)| *j != i);
        let weight: f64 = others.map(|(_, (other, _))| (wanted - other) / (at - other)).product();
        sum.iter_mut().zip(*place).for_each(|(sum, x)| *sum += weight * x);
    }
    Some(sum)
}

/// A side of the window, whose sides are 1, on the way in a direction.
#[derive(Debug, Clone, Copy)]
pub struct Side {
    /// Which of the two parameters is at an end of its range there.
    pub parameter: usize,
    /// Its value there, 0 or 1.
    pub goal: f64,
    /// After how many times the direction.
    pub share: f64,
}

/// The side that is met first.
pub fn side_ahead(from: [f64; 2], direction: [f64; 2]) -> Option<Side> {
    let met = |i: usize| {
        let goal = if direction[i] > 0.0 { 1.0 } else { 0.0 };
        Side { parameter: i, goal, share: (goal - from[i]) / direction[i] }
    };
    (0..2).map(met).filter(|side| side.share >= 0.0).min_by(|a, b| a.share.total_cmp(&b.share))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chords_of_a_circle_err_by_their_sagitta() {
        // Three points of a circle of radius 1, uneven steps.
        let at = |t: f64| [t.cos(), t.sin()];
        for (before, last) in [(0.02_f64, 0.03_f64), (0.03, 0.01)] {
            let error = chord_error([at(0.0), at(before), at(before + last)], [before, last]);
            let sagitta = 1.0 - (0.5 * last).cos();
            assert!((error / sagitta - 1.0).abs() < 0.01, "{error} {sagitta}");
        }
        assert!(chord_error([[0.0, 0.0], [1.0, 1.0], [3.0, 3.0]], [1.0, 2.0]) < 1e-15);
    }
}

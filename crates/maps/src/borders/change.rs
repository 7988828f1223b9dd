//! The border between two classes by the classes themselves, where no event tells it: along a resonance, where impulses grow without
//! bound, and where events are too close to be told apart.

use super::meet::enclose;

/// How near the two sides are at a point, as a part of the window.
const FINE: f64 = 1e-14;

/// What is not known on the border may be this wide.
const DARK: f64 = 1e-6;

/// The first step, the longest and the shortest.
const FIRST: f64 = 1e-3;
const LONGEST: f64 = 0.02;
const SHORTEST: f64 = 1e-6;

/// How far to the sides both classes are looked for, as a part of the step.
const ASIDE: f64 = 0.2;

/// Directions in which the border is looked for at its start.
const DIRECTIONS: usize = 32;

/// The straight line between two points may err by this part of the tolerance: what is foreseen is not quite what comes.
const ROOM: f64 = 0.6;

/// Cosine of the angle between the directions in which a closed border leaves its start and comes back.
const ALONG: f64 = 0.5;

/// Points at most, one way.
const MOST_POINTS: usize = 20_000;

/// A border that was traced, in parts of the window's sides.
#[derive(Debug, Clone)]
pub(super) struct Traced {
    pub(super) points: Vec<([f64; 2], f64)>,
    pub(super) ends: [&'static str; 2],
}

/// What a straight line between the last two of three places errs by, if a parabola goes through them.
pub(super) fn sagitta([a, b, c]: [[f64; 2]; 3]) -> f64 {
    let minus = |to: [f64; 2], from: [f64; 2]| [to[0] - from[0], to[1] - from[1]];
    let (before, last) = (minus(b, a), minus(c, b));
    let lengths = [before[0].hypot(before[1]), last[0].hypot(last[1])];
    let turn = (before[0] * last[1] - before[1] * last[0]) / (lengths[0] * lengths[1]);
    let error = turn.abs() * lengths[1] * lengths[1] / (4.0 * (lengths[0] + lengths[1]));
    if error.is_finite() { error } else { 0.0 }
}

/// How long the next step should be, behind one of this length that erred by so much.
pub(super) fn next_step(step: f64, error: f64, tolerance: f64) -> f64 {
    let wanted = if error > 0.0 { (ROOM * tolerance / error).sqrt() } else { f64::INFINITY };
    step * wanted.clamp(0.4, 1.5)
}

/// Follows the border between two places both ways. `class` says what lives at a place, if that is known; `until` is told each place
/// and says whether the border need go no farther.
pub(super) fn trace<C: Copy + PartialEq>(
    class: &mut impl FnMut([f64; 2]) -> Option<C>,
    ends: [[f64; 2]; 2],
    tolerance: f64,
    until: &dyn Fn([f64; 2]) -> bool,
) -> Option<Traced> {
    let (ends, classes) = enclose(class, ends, FINE)?;
    let start = middle(ends);
    let headings = headings(class, start, classes);
    let mut tracer = Tracer { class, classes, tolerance, until };
    let ways: Vec<_> = headings.into_iter().map(|heading| tracer.follow(start, heading)).collect();
    let mut ways = ways.into_iter();
    let (ahead, end) = ways.next()?;
    let (behind, begin) = ways.next().unwrap_or((Vec::new(), OTHER));
    let mut points: Vec<([f64; 2], f64)> = if end == CLOSED { Vec::new() } else { behind.into_iter().rev().collect() };
    points.push((start, 0.5 * distance(ends[0], ends[1])));
    points.extend(ahead);
    (points.len() > 1).then(|| Traced { points, ends: if end == CLOSED { [CLOSED; 2] } else { [begin, end] } })
}

const CLOSED: &str = "where it began: it is closed";
const EDGE: &str = "at the edge of the window";
const OTHER: &str = "where something else begins";
const KNOWN: &str = "where it is known";
const LONG: &str = "unfinished: it is too long";

fn middle([a, b]: [[f64; 2]; 2]) -> [f64; 2] {
    [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn is_inside(place: [f64; 2]) -> bool {
    place.iter().all(|part| (0.0..=1.0).contains(part))
}

/// A direction, and on which side of it the first class lives: 1 on its left.
type Heading = ([f64; 2], f64);

/// The two directions in which a border leaves its start.
fn headings<C: Copy + PartialEq>(
    class: &mut impl FnMut([f64; 2]) -> Option<C>,
    start: [f64; 2],
    classes: [C; 2],
) -> Vec<Heading> {
    let at = |turn: f64| {
        let angle = std::f64::consts::TAU * turn;
        [start[0] + FIRST * angle.cos(), start[1] + FIRST * angle.sin()]
    };
    let turns: Vec<f64> = (0..=DIRECTIONS).map(|i| (i as f64 + 0.5) / DIRECTIONS as f64).collect();
    let seen: Vec<Option<C>> =
        turns.iter().map(|&turn| if is_inside(at(turn)) { class(at(turn)) } else { None }).collect();
    let mut headings = Vec::new();
    for i in 0..DIRECTIONS {
        let both = [seen[i], seen[i + 1]];
        let side = if both == [Some(classes[1]), Some(classes[0])] {
            1.0
        } else if both == [Some(classes[0]), Some(classes[1])] {
            -1.0
        } else {
            continue;
        };
        if let Some((ends, _)) = enclose(class, [at(turns[i]), at(turns[i + 1])], FINE) {
            let place = middle(ends);
            let length = distance(start, place);
            headings.push(([(place[0] - start[0]) / length, (place[1] - start[1]) / length], side));
        }
    }
    headings.truncate(2);
    headings
}

struct Tracer<'a, C, F> {
    class: &'a mut F,
    classes: [C; 2],
    tolerance: f64,
    until: &'a dyn Fn([f64; 2]) -> bool,
}

impl<C: Copy + PartialEq, F: FnMut([f64; 2]) -> Option<C>> Tracer<'_, C, F> {
    /// Where the border passes between two places, the first class living at the first.
    fn between(&mut self, ends: [[f64; 2]; 2]) -> Option<([f64; 2], f64)> {
        let inside = ends.map(|[x, y]| [x.clamp(0.0, 1.0), y.clamp(0.0, 1.0)]);
        if inside.map(|place| (self.class)(place)) != self.classes.map(Some) {
            return None;
        }
        let (found, classes) = enclose(self.class, inside, FINE)?;
        let error = 0.5 * distance(found[0], found[1]);
        (classes == self.classes && error <= DARK).then(|| (middle(found), error))
    }

    fn follow(&mut self, start: [f64; 2], (heading, side): Heading) -> (Vec<([f64; 2], f64)>, &'static str) {
        let mut places = vec![start];
        let mut points = Vec::new();
        let mut h = FIRST;
        loop {
            if h < SHORTEST {
                return (points, OTHER);
            }
            if points.len() > MOST_POINTS {
                return (points, LONG);
            }
            let last = places[places.len() - 1];
            let ahead = extrapolated(&places, heading, h);
            let length = distance(last, ahead);
            let direction = [(ahead[0] - last[0]) / length, (ahead[1] - last[1]) / length];
            if !is_inside(ahead) {
                // On its way out: the border meets the edge between two places of it.
                let (axis, goal) = met_first(last, direction);
                let share = (goal - last[axis]) / direction[axis];
                if share <= h {
                    let mut base = [last[0] + share * direction[0], last[1] + share * direction[1]];
                    base[axis] = goal;
                    let aside = (ASIDE * h).max(SHORTEST);
                    let left = [-direction[1], direction[0]];
                    let mut ends = [base; 2];
                    let other = 1 - axis;
                    let way = if left[other] * side > 0.0 { aside } else { -aside };
                    ends[0][other] += way;
                    ends[1][other] -= way;
                    if share <= 1e-12 {
                        return (points, EDGE);
                    }
                    if let Some(point) = self.between(ends) {
                        points.push(point);
                        return (points, EDGE);
                    }
                    h *= 0.5;
                    continue;
                }
            }
            let aside = [-direction[1] * side * ASIDE * h, direction[0] * side * ASIDE * h];
            let ends = [[ahead[0] + aside[0], ahead[1] + aside[1]], [ahead[0] - aside[0], ahead[1] - aside[1]]];
            let Some((place, error)) = self.between(ends) else {
                h *= 0.5;
                continue;
            };
            let bend = match places.len() {
                1 => 0.0,
                n => sagitta([places[n - 2], places[n - 1], place]),
            };
            if bend > self.tolerance && h > 10.0 * SHORTEST {
                h *= (ROOM * self.tolerance / bend).sqrt().max(0.2);
                continue;
            }
            let closed = places.len() > 3
                && distance(place, start) < h
                // Not back on the other side of a finger.
                && direction[0] * heading[0] + direction[1] * heading[1] > ALONG
                && (start[0] - last[0]) * direction[0] + (start[1] - last[1]) * direction[1] > 0.0;
            if closed {
                points.push((start, error));
                return (points, CLOSED);
            }
            h = next_step(h, bend, self.tolerance).min(LONGEST);
            places.push(place);
            points.push((place, error));
            if (self.until)(place) {
                return (points, KNOWN);
            }
        }
    }
}

/// Through the last places, at most four, a step ahead.
fn extrapolated(places: &[[f64; 2]], heading: [f64; 2], h: f64) -> [f64; 2] {
    let through = &places[places.len().saturating_sub(4)..];
    let last = places[places.len() - 1];
    if through.len() == 1 {
        return [last[0] + h * heading[0], last[1] + h * heading[1]];
    }
    let mut at = vec![0.0];
    for pair in through.windows(2) {
        at.push(at[at.len() - 1] + distance(pair[0], pair[1]));
    }
    lagrange(&at, through, at[at.len() - 1] + h)
}

/// The curve through places at these lengths, at another length.
pub(super) fn lagrange<const N: usize>(at: &[f64], places: &[[f64; N]], wanted: f64) -> [f64; N] {
    let mut sum = [0.0; N];
    for (i, place) in places.iter().enumerate() {
        let others =
            at.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| (wanted - other) / (at[i] - other));
        let weight: f64 = others.product();
        for (sum, one) in sum.iter_mut().zip(place) {
            *sum += weight * one;
        }
    }
    sum
}

/// The side of the window that is met first in a direction.
fn met_first(from: [f64; 2], direction: [f64; 2]) -> (usize, f64) {
    let met = |axis: usize| {
        let goal = if direction[axis] > 0.0 { 1.0 } else { 0.0 };
        let share = (goal - from[axis]) / direction[axis];
        (axis, goal, if share.is_nan() || share < 0.0 { f64::INFINITY } else { share })
    };
    let [one, other] = [met(0), met(1)];
    if one.2 <= other.2 { (one.0, one.1) } else { (other.0, other.1) }
}

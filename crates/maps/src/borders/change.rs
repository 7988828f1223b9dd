//! The border between two classes by the classes themselves, where no event tells it: along a resonance, where impulses grow without
//! bound, and where events are too close to be told apart.

use vibrochain_breather::line::{Line, Side, Step, chord_error, foreseen, joined, side_ahead, trace as trace_line};

use super::meet::enclose;

/// How near the two sides are at a point, as a part of the window.
const FINE: f64 = 1e-14;

/// What is not known on the border may be this wide.
const DARK: f64 = 1e-6;

/// The first step and the shortest: nearer to where borders meet, other classes are on both sides.
const FIRST: f64 = 1e-3;
const SHORTEST: f64 = 1e-6;

/// How far to the sides both classes are looked for, as a part of the step.
const ASIDE: f64 = 0.2;

/// Directions in which the border is looked for at its start.
const DIRECTIONS: usize = 32;

/// Cosine of the angle between the directions in which a closed border leaves its start and comes back.
const ALONG: f64 = 0.5;

/// A border that was traced, in parts of the window's sides.
#[derive(Debug, Clone)]
pub(super) struct Traced {
    pub(super) points: Vec<([f64; 2], f64)>,
    pub(super) ends: [&'static str; 2],
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
    let first = Place { at: 0.0, place: start, error: 0.5 * distance(ends[0], ends[1]) };
    let mut ways = headings.into_iter().map(|heading| {
        let mut way = Way { class: &mut *class, classes, until, heading };
        trace_line(&mut way, first, tolerance)
    });
    let (ahead, end) = ways.next()?;
    let (behind, begin) = ways.next().filter(|_| end != CLOSED).unwrap_or((vec![first], OTHER));
    let points: Vec<_> = joined(behind, ahead).into_iter().map(|place| (place.place, place.error)).collect();
    (points.len() > 1).then(|| Traced { points, ends: if end == CLOSED { [CLOSED; 2] } else { [begin, end] } })
}

const CLOSED: &str = "where it began: it is closed";
const EDGE: &str = "at the edge of the window";
const OTHER: &str = "where something else begins";
const KNOWN: &str = "where it is known";

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

/// A point of the border, and the length up to it.
#[derive(Debug, Clone, Copy)]
struct Place {
    at: f64,
    place: [f64; 2],
    error: f64,
}

/// One way along the border.
struct Way<'a, C, F> {
    class: &'a mut F,
    classes: [C; 2],
    until: &'a dyn Fn([f64; 2]) -> bool,
    heading: Heading,
}

impl<C: Copy + PartialEq, F: FnMut([f64; 2]) -> Option<C>> Way<'_, C, F> {
    /// Where the border passes between two places, the first class living at the first.
    fn between(&mut self, last: &Place, ends: [[f64; 2]; 2]) -> Option<Place> {
        let inside = ends.map(|[x, y]| [x.clamp(0.0, 1.0), y.clamp(0.0, 1.0)]);
        if inside.map(|place| (self.class)(place)) != self.classes.map(Some) {
            return None;
        }
        let (found, classes) = enclose(self.class, inside, FINE)?;
        let (place, error) = (middle(found), 0.5 * distance(found[0], found[1]));
        let at = last.at + distance(last.place, place);
        (classes == self.classes && error <= DARK).then_some(Place { at, place, error })
    }

    /// Where the border is expected, and the direction there.
    fn expected(&self, passed: &[Place], length: f64) -> ([f64; 2], [f64; 2]) {
        let (last, heading) = (&passed[passed.len() - 1], self.heading.0);
        let behind = passed.iter().rev().map(|place| (place.at, &place.place[..]));
        let ahead = match foreseen(behind, last.at + length) {
            Some(ahead) => [ahead[0], ahead[1]],
            None => [0, 1].map(|i| last.place[i] + length * heading[i]),
        };
        let far = distance(last.place, ahead);
        (ahead, [0, 1].map(|i| (ahead[i] - last.place[i]) / far))
    }
}

impl<C: Copy + PartialEq, F: FnMut([f64; 2]) -> Option<C>> Line for Way<'_, C, F> {
    type Point = Place;
    type End = &'static str;
    const FIRST: f64 = FIRST;
    const CLOSED: &'static str = CLOSED;
    const LONG: &'static str = "unfinished: it is too long";

    fn ahead(&mut self, passed: &[Place], length: f64) -> Option<Step<Place, &'static str>> {
        let (last, side) = (&passed[passed.len() - 1], self.heading.1);
        let (ahead, direction) = self.expected(passed, length);
        let left = [-side * direction[1], side * direction[0]];
        if length < SHORTEST {
            return None;
        }
        if is_inside(ahead) {
            let beside = |by: f64| [0, 1].map(|i| ahead[i] + by * length * left[i]);
            return self.between(last, [beside(ASIDE), beside(-ASIDE)]).map(Step::On);
        }
        // On its way out: the border meets the edge between two places of it.
        let Side { parameter: axis, goal, share } = side_ahead(last.place, direction)?;
        if share <= 1e-12 {
            return Some(Step::Out(None, EDGE));
        }
        let mut base = [0, 1].map(|i| last.place[i] + share * direction[i]);
        base[axis] = goal;
        let (mut ends, other) = ([base; 2], 1 - axis);
        let aside = (ASIDE * length).max(SHORTEST).copysign(left[other]);
        ends[0][other] += aside;
        ends[1][other] -= aside;
        let met = self.between(last, ends).filter(|_| share <= length)?;
        Some(Step::Out(Some(met), EDGE))
    }

    fn bend(&self, through: [&Place; 3]) -> f64 {
        let [a, b, c] = through.map(|place| place.at);
        chord_error(through.map(|place| place.place), [b - a, c - b])
    }

    fn closed(&mut self, passed: &[Place], next: &Place) -> Option<Place> {
        let (last, length) = (&passed[passed.len() - 1], next.at - passed[passed.len() - 1].at);
        let direction = [0, 1].map(|i| next.place[i] - last.place[i]);
        let along = |other: [f64; 2]| direction[0] * other[0] + direction[1] * other[1];
        let closed = passed.len() > 3
            && distance(next.place, passed[0].place) < length
            // Not back on the other side of a finger.
            && along(self.heading.0) > ALONG * length
            && along([0, 1].map(|i| passed[0].place[i] - last.place[i])) > 0.0;
        closed.then_some(Place { place: passed[0].place, ..*next })
    }

    fn ended(&mut self, passed: &mut Vec<Place>) -> Option<&'static str> {
        (self.until)(passed[passed.len() - 1].place).then_some(KNOWN)
    }

    fn lost(&self, _: &[Place]) -> &'static str {
        OTHER
    }
}

//! Stripes of conservative breathers: each followed along y, edge by edge, from rows in which it was found.

use vibrochain_breather::Family;
use vibrochain_breather::line::{Line, Step, chord_error, foreseen, joined, trace};
use vibrochain_floquet::{Stripe, StripeEnd, StripeFinder, StripeLine};

use super::part::{ClassProbe, Part};

/// The shortest step: a stripe that is not found over it is not found over a shorter one.
const SHORTEST: f64 = 2e-7;

const EDGE: &str = "at the edge of the window";

/// How far from where it was expected a stripe may be, as a part of the step, or of its width.
const ASTRAY: f64 = 0.05;

/// How much farther along x than along y a stripe goes at most, in parts of the sides.
const FLATTEST: f64 = 20.0;

/// A point of a lane: both edges, where they are in parts of the window's sides.
#[derive(Debug, Clone, Copy)]
pub(super) struct LanePoint {
    pub(super) y: f64,
    pub(super) edges: [f64; 2],
    /// Half the width in the parameter along x, and the error of an edge as a part of the window's side.
    pub(super) half_width: f64,
    pub(super) error: f64,
}

/// A stripe, followed.
#[derive(Debug, Clone)]
pub(super) struct Lane {
    pub(super) modes: (usize, usize),
    pub(super) harmonic: usize,
    pub(super) points: Vec<LanePoint>,
    pub(super) ends: [&'static str; 2],
}

/// What one row tells.
#[derive(Debug, Clone, Default)]
pub(super) struct Row {
    pub(super) y: f64,
    pub(super) stripes: Vec<Stripe>,
    pub(super) unresolved: Vec<[f64; 2]>,
}

/// Who follows stripes of one part.
pub(super) struct Liner<'a, 'b> {
    pub(super) probe: &'a mut ClassProbe<'b>,
    pub(super) part: &'a Part,
    pub(super) finder: &'a mut StripeFinder,
    pub(super) family: Family,
    pub(super) tolerance: f64,
}

impl Lane {
    /// Whether these are its edges at a place along y, as far as chords tell them.
    pub(super) fn has(&self, y: f64, edges: [f64; 2], reach: f64) -> bool {
        let after = self.points.partition_point(|point| point.y < y);
        let (Some(high), low) = (self.points.get(after), &self.points[after.saturating_sub(1)]) else { return false };
        if after == 0 && high.y > y {
            return false;
        }
        let share = if high.y > low.y { (y - low.y) / (high.y - low.y) } else { 0.0 };
        (0..2).all(|i| (low.edges[i] + share * (high.edges[i] - low.edges[i]) - edges[i]).abs() <= reach)
    }

    /// One of its edges.
    pub(super) fn line(&self, upper: bool) -> Vec<[f64; 2]> {
        self.points.iter().map(|point| [point.edges[usize::from(upper)], point.y]).collect()
    }
}

impl Liner<'_, '_> {
    fn line(&self, y: f64) -> Option<StripeLine> {
        let model = self.probe.model([0.0, y])?;
        Some(StripeLine { model, family: self.family, free: self.probe.scene.axes[0].parameter })
    }

    /// All stripes of a part of a row, of which so many points are looked at.
    pub(super) fn row(&mut self, y: f64, (from, to): (f64, f64), points: usize) -> Row {
        let [from, to] = [from, to].map(|x| self.probe.window.point([x, y])[0]);
        let found = self.line(y).and_then(|line| self.finder.outlines_along(&line, (from, to), points).ok());
        match found {
            Some(row) => Row { y, stripes: row.stripes, unresolved: row.unresolved },
            None => Row { y, stripes: Vec::new(), unresolved: vec![[from, to]] },
        }
    }

    /// The place of a stripe, if its breathers are physical.
    fn point(&self, y: f64, stripe: &Stripe) -> LanePoint {
        let part = |value: f64| self.probe.window.part([value, self.probe.window.point([0.0, y])[1]])[0];
        let [low, high] = stripe.edges.map(part);
        let side = self.probe.window.point([1.0, y])[0] - self.probe.window.point([0.0, y])[0];
        LanePoint { y, edges: [low, high], half_width: stripe.half_width, error: stripe.error / side }
    }

    fn is_physical(&mut self, point: &LanePoint) -> bool {
        let inside = point.edges.map(|x| x.clamp(0.0, 1.0));
        let places = [0.5 * (inside[0] + inside[1]), inside[0], inside[1]];
        places.into_iter().any(|x| self.probe.may_live(self.part, [x, point.y]))
    }

    /// A stripe of a row, followed both ways; none that is not one of two modes.
    pub(super) fn lane(&mut self, y: f64, stripe: &Stripe) -> Option<Lane> {
        let (modes, harmonic) = stripe.pair?;
        if stripe.ends != [StripeEnd::Edge; 2] {
            return None;
        }
        let line = self.line(y)?;
        // As the way will see it.
        let stripe = self.finder.outline(&line, modes, harmonic, stripe.centre).ok()?;
        let start = self.point(y, &stripe);
        let tolerance = self.tolerance;
        let [(down, begin), (up, end)] =
            [-1.0, 1.0].map(|way| trace(&mut Way { liner: self, modes, harmonic, way }, start, tolerance));
        let points = joined(down, up);
        (points.len() > 1).then_some(Lane { modes, harmonic, points, ends: [begin, end] })
    }
}

/// One way along a stripe.
struct Way<'a, 'b, 'c> {
    liner: &'a mut Liner<'b, 'c>,
    modes: (usize, usize),
    harmonic: usize,
    /// Up or down along y.
    way: f64,
}

impl Line for Way<'_, '_, '_> {
    type Point = LanePoint;
    type End = &'static str;
    /// Short against the distance of two stripes.
    const FIRST: f64 = 2e-6;
    const CLOSED: &'static str = "where it began: it is closed";
    const LONG: &'static str = "unfinished: it is too long";

    fn ahead(&mut self, passed: &[LanePoint], length: f64) -> Option<Step<LanePoint, &'static str>> {
        let last = passed[passed.len() - 1];
        let y = (last.y + self.way * length).clamp(0.0, 1.0);
        if y == last.y {
            return Some(Step::Out(None, EDGE));
        }
        if length < SHORTEST {
            return None;
        }
        let behind = passed.iter().rev().map(|point| (point.y, &point.edges[..]));
        let expected = foreseen(behind, y).map_or(last.edges, |edges| [edges[0], edges[1]]);
        let value = self.liner.probe.window.point([0.5 * (expected[0] + expected[1]), y])[0];
        let line = self.liner.line(y)?;
        let stripe = self.liner.finder.outline(&line, self.modes, self.harmonic, value).ok()?;
        let next = self.liner.point(y, &stripe);
        let moved = (0..2).map(|i| (next.edges[i] - expected[i]).abs()).fold(0.0, f64::max);
        let (step, width) = ((y - last.y).abs(), next.edges[1] - next.edges[0]);
        let reach = if passed.len() == 1 { FLATTEST * step } else { ASTRAY * (step + width) };
        (moved <= reach).then_some(Step::On(next))
    }

    /// Of either edge.
    fn bend(&self, through: [&LanePoint; 3]) -> f64 {
        let of = |edge: usize| {
            let places = through.map(|point| [point.edges[edge], point.y]);
            let apart = |i: usize| (places[i + 1][0] - places[i][0]).hypot(places[i + 1][1] - places[i][1]);
            chord_error(places, [apart(0), apart(1)])
        };
        of(0).max(of(1))
    }

    fn ended(&mut self, passed: &mut Vec<LanePoint>) -> Option<&'static str> {
        let last = passed[passed.len() - 1];
        if !self.liner.is_physical(&last) {
            return Some("where its breathers are not physical");
        }
        (last.edges[1] < 0.0 || last.edges[0] > 1.0).then_some(EDGE)
    }

    fn lost(&self, _: &[LanePoint]) -> &'static str {
        "where it is no stripe of two modes alone any more"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Edges on the chord between two points are a lane's own; beside it, below its first point and above its last one they are not.
    #[test]
    fn a_lane_has_what_lies_on_its_chords() {
        let point = |y: f64, low: f64, high: f64| LanePoint { y, edges: [low, high], half_width: 0.1, error: 0.0 };
        let points = vec![point(0.2, 0.4, 0.5), point(0.4, 0.6, 0.8), point(0.8, 0.6, 0.7)];
        let lane = Lane { modes: (1, 2), harmonic: 1, points, ends: [EDGE; 2] };
        for (y, edges) in
            [(0.2, [0.4, 0.5]), (0.3, [0.5, 0.65]), (0.4, [0.6, 0.8]), (0.7, [0.6, 0.725]), (0.8, [0.6, 0.7])]
        {
            assert!(lane.has(y, edges, 1e-12), "{y} {edges:?}");
            for aside in [[0.01, 0.0], [0.0, -0.01]] {
                assert!(!lane.has(y, [edges[0] + aside[0], edges[1] + aside[1]], 5e-3), "{y} {edges:?}");
            }
        }
        assert!(!lane.has(0.19, [0.4, 0.5], 0.02) && !lane.has(0.81, [0.6, 0.7], 0.02));
    }
}

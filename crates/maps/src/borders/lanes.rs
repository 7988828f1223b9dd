//! Stripes of conservative breathers: each followed along y, edge by edge, from rows in which it was found.

use vibrochain_breather::Family;
use vibrochain_floquet::{Stripe, StripeEnd, StripeFinder, StripeLine};

use super::change::{lagrange, next_step, sagitta};
use super::part::{Eye, Part};

/// The first step along y, short against the distance of two stripes, the longest and the shortest, as parts of the window's side.
const FIRST: f64 = 2e-6;
const LONGEST: f64 = 0.05;
const SHORTEST: f64 = 2e-7;

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
    pub(super) eye: &'a mut Eye<'b>,
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
        let model = self.eye.model([0.0, y])?;
        Some(StripeLine { model, family: self.family, free: self.eye.scene.axes[0].parameter })
    }

    /// All stripes of a part of a row, of which so many points are looked at.
    pub(super) fn row(&mut self, y: f64, (from, to): (f64, f64), points: usize) -> Row {
        let [from, to] = [from, to].map(|x| self.eye.window.point([x, y])[0]);
        let found = self.line(y).and_then(|line| self.finder.outlines_along(&line, (from, to), points).ok());
        match found {
            Some(row) => Row { y, stripes: row.stripes, unresolved: row.unresolved },
            None => Row { y, stripes: Vec::new(), unresolved: vec![[from, to]] },
        }
    }

    /// The place of a stripe, if its breathers are physical.
    fn point(&self, y: f64, stripe: &Stripe) -> LanePoint {
        let part = |value: f64| self.eye.window.part([value, self.eye.window.point([0.0, y])[1]])[0];
        let [low, high] = stripe.edges.map(part);
        let side = self.eye.window.point([1.0, y])[0] - self.eye.window.point([0.0, y])[0];
        LanePoint { y, edges: [low, high], half_width: stripe.half_width, error: stripe.error / side }
    }

    fn is_physical(&mut self, point: &LanePoint) -> bool {
        let inside = point.edges.map(|x| x.clamp(0.0, 1.0));
        let places = [0.5 * (inside[0] + inside[1]), inside[0], inside[1]];
        places.into_iter().any(|x| self.eye.may_live(self.part, [x, point.y]))
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
        let (down, begin) = self.follow((modes, harmonic), start, -1.0);
        let (up, end) = self.follow((modes, harmonic), start, 1.0);
        let mut points: Vec<LanePoint> = down.into_iter().rev().collect();
        points.push(start);
        points.extend(up);
        (points.len() > 1).then_some(Lane { modes, harmonic, points, ends: [begin, end] })
    }

    fn follow(
        &mut self,
        (modes, harmonic): ((usize, usize), usize),
        start: LanePoint,
        way: f64,
    ) -> (Vec<LanePoint>, &'static str) {
        let mut points = vec![start];
        let mut h = FIRST;
        let end = loop {
            let last = points[points.len() - 1];
            if last.y <= 0.0 && way < 0.0 || last.y >= 1.0 && way > 0.0 {
                break "at the edge of the window";
            }
            if h < SHORTEST {
                break "where it is no stripe of two modes alone any more";
            }
            let y = (last.y + way * h).clamp(0.0, 1.0);
            let through = &points[points.len().saturating_sub(4)..];
            let at: Vec<f64> = through.iter().map(|point| point.y).collect();
            let edges: Vec<[f64; 2]> = through.iter().map(|point| point.edges).collect();
            let expected = lagrange(&at, &edges, y);
            let centre = 0.5 * (expected[0] + expected[1]);
            let value = self.eye.window.point([centre, y])[0];
            let step = (y - last.y).abs();
            let found = self.line(y).and_then(|line| self.finder.outline(&line, modes, harmonic, value).ok());
            let Some(next) = found.map(|stripe| self.point(y, &stripe)) else {
                h = 0.5 * step;
                continue;
            };
            let moved = (0..2).map(|i| (next.edges[i] - expected[i]).abs()).fold(0.0, f64::max);
            let width = next.edges[1] - next.edges[0];
            let reach = if points.len() == 1 { FLATTEST * step } else { ASTRAY * (step + width) };
            if moved > reach {
                h = 0.5 * step;
                continue;
            }
            let bend = match points.len() {
                1 => 0.0,
                n => {
                    let edge = |i: usize| {
                        sagitta([&points[n - 2], &points[n - 1], &next].map(|point| [point.edges[i], point.y]))
                    };
                    edge(0).max(edge(1))
                }
            };
            if bend > self.tolerance && step > 10.0 * SHORTEST {
                h = next_step(step, bend, self.tolerance);
                continue;
            }
            points.push(next);
            if !self.is_physical(&next) {
                break "where its breathers are not physical";
            }
            if next.edges[1] < 0.0 || next.edges[0] > 1.0 {
                break "at the edge of the window";
            }
            h = next_step(step, bend, self.tolerance).min(LONGEST);
        };
        points.remove(0);
        (points, end)
    }
}

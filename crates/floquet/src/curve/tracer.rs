//! From point to point of a curve.

use vibrochain_breather::line::foreseen;
use vibrochain_breather::system::{Vector, dot};
use vibrochain_breather::{
    Admissibility, BranchError, BreatherError, ContactOrbit, Family, Obstruction, SolutionCurve, SolutionPoint,
};

use super::answer::{CurvePoint, Walk};
use crate::bracket::crossing;
use crate::events::{AtEvent, EventSystem, TOUCHES, Test, Watcher};
use crate::locate::{Event, Evidence};

/// The error is worked out at every so many points; between two it is no more than this times the larger of theirs.
const EVERY: usize = 16;
const BETWEEN: f64 = 2.0;

/// What holds symmetric orbits together, in units of their equations, is no more than this: rounding.
pub(super) const PUSHED: f64 = 1e-8;

/// The curve may be this part of a step away from where it was foreseen.
const ASTRAY: f64 = 0.1;

/// Cosine of the angle by which it may turn in a step.
const STRAIGHT: f64 = 0.9;

/// Steps shorter than this part of the last one are looked for along the tangent, too.
const FAR_SHORTER: f64 = 0.1;

/// A point of a curve.
pub(super) type TracedPoint = SolutionPoint<AtEvent>;

fn norm(vector: &[f64]) -> f64 {
    dot(vector, vector).sqrt()
}

/// Values of both numbers.
pub(super) fn values(point: &TracedPoint) -> [f64; 2] {
    let z = point.coordinates();
    [z[z.len() - 2], z[z.len() - 1]]
}

/// What is followed, and how.
pub(crate) struct CurveRequest<'a> {
    pub(crate) event: Event,
    pub(crate) evidence: Evidence,
    /// What its orbits are called while their impacts are those of it.
    pub(crate) name: Family,
    /// The number at whose least value masses are not coupled, if it is that.
    pub(crate) uncoupled: Option<usize>,
    /// Where to, and how.
    pub(crate) walk: &'a Walk<'a>,
}

/// Whether an orbit is physical, touches aside.
pub(super) fn is_physical(told: &Admissibility, orbit: &ContactOrbit) -> bool {
    match told.obstruction {
        None => true,
        Some(Obstruction::Crossing { excess, .. }) => excess <= TOUCHES * orbit.speed() / orbit.model().omega(),
        Some(Obstruction::WrongSign { velocity_before, .. }) => velocity_before.abs() <= TOUCHES * orbit.speed(),
        Some(Obstruction::Sticking { acceleration_after, .. }) => {
            acceleration_after.abs() <= TOUCHES * orbit.model().omega() * orbit.speed()
        }
    }
}

/// Who follows a curve.
pub(super) struct Tracer<'a> {
    pub(super) manifold: SolutionCurve<EventSystem>,
    pub(super) watcher: Watcher,
    pub(super) test: Test,
    pub(super) asked: &'a CurveRequest<'a>,
    /// Impulses of the first orbit.
    pub(super) strength: f64,
    /// All impulses vanish all along.
    pub(super) vanish: bool,
    /// The impacts that have no velocity all along.
    pub(super) grazing: Vec<usize>,
}

impl Tracer<'_> {
    pub(super) fn has_angle(&self) -> bool {
        matches!(self.test, Test::Circle | Test::Collision)
    }

    /// Where the curve is expected, a length ahead of the last of some points: through several of them, as edges of stripes are near to each other.
    pub(super) fn foreseen(&self, points: &[TracedPoint], length: f64) -> Option<Vector> {
        let last = points.last()?;
        let mut at = 0.0;
        let behind = points.windows(2).rev().map(|pair| {
            at -= self.manifold.distance(&pair[0], &pair[1]);
            (at, pair[0].coordinates())
        });
        let through = foreseen(std::iter::once((0.0, last.coordinates())).chain(behind), length);
        Some(through.unwrap_or_else(|| self.manifold.ahead(last, length)))
    }

    /// The point a length ahead of the last of some points, near where the points behind foresee it. Where none is found and the length is far
    /// shorter than the last step, it is looked for along the tangent, which tells the way on better there.
    pub(super) fn advance(&mut self, points: &[TracedPoint], length: f64) -> Result<TracedPoint, BranchError> {
        let foreseen = self.foreseen(points, length).ok_or(BranchError::NoConvergence)?;
        self.advance_to(points, &foreseen).or_else(|why| match points.last_chunk() {
            Some([before, last]) if length <= FAR_SHORTER * self.manifold.distance(before, last) => {
                self.advance_to(points, &self.manifold.ahead(last, length)).map_err(|_| why)
            }
            _ => Err(why),
        })
    }

    /// The point near where it is foreseen, across the way there.
    fn advance_to(&mut self, points: &[TracedPoint], foreseen: &[f64]) -> Result<TracedPoint, BranchError> {
        let last = points.last().ok_or(BranchError::NoConvergence)?;
        let way = self.manifold.chord_to(last, foreseen);
        let length = norm(&way);
        let direction = way.iter().map(|x| x / length).collect();
        let next = self.manifold.correct(foreseen, &direction, ASTRAY * length, false)?;
        // It does not turn back between two points.
        let back = points.len().checked_sub(2).map(|i| self.manifold.chord_to(last, points[i].coordinates()));
        let turns = |back: Vector| -dot(&back, &way) < STRAIGHT * length * norm(&back);
        // Symmetry is lost with the numbers themselves: no symmetric orbits are there that could lose it.
        let pushed = self.manifold.system().push(next.orbit()).abs() > PUSHED;
        if pushed || back.is_some_and(turns) { Err(BranchError::NoConvergence) } else { Ok(next) }
    }

    /// Where on a part of the step from the last of some points a function vanishes that has these values at the ends of that part.
    pub(super) fn located(
        &mut self,
        points: &[TracedPoint],
        [from, to]: [f64; 2],
        ends: [f64; 2],
        mut value: impl FnMut(&mut Self, &TracedPoint) -> Option<f64>,
    ) -> Option<(TracedPoint, f64)> {
        let length = to - from;
        let (s, error) = crossing(ends, length, |s| {
            let point = self.advance(points, from + s).ok()?;
            value(self, &point)
        })?;
        Some((self.advance(points, from + s).ok()?, error.min(length)))
    }

    /// How the curve goes on in the plane of both numbers.
    pub(super) fn heading(&self, point: &TracedPoint) -> [f64; 2] {
        let tangent = point.tangent();
        [tangent[tangent.len() - 2], tangent[tangent.len() - 1]]
    }

    /// Two folds meet where the curve turns back in both numbers.
    pub(super) fn cusp(&mut self, points: &[TracedPoint], to: &TracedPoint, length: f64) -> Option<(TracedPoint, f64)> {
        let before = self.heading(points.last()?);
        let against = |[x, y]: [f64; 2]| x * before[0] + y * before[1];
        let ends = [against(before), against(self.heading(to))];
        if ends[1] > 0.0 {
            return None;
        }
        self.located(points, [0.0, length], ends, |tracer, point| Some(against(tracer.heading(point))))
    }

    /// The error at each of the points, as a part of the window's sides.
    pub(super) fn errors(&mut self, points: &[TracedPoint]) -> Vec<f64> {
        let last = points.len().saturating_sub(1);
        let places: Vec<usize> = (0..last).step_by(EVERY).chain([last]).collect();
        let told: Vec<f64> =
            places.iter().map(|&i| self.manifold.system().error(&points[i]).unwrap_or(f64::INFINITY)).collect();
        let mut errors = vec![f64::INFINITY; points.len()];
        for (pair, told) in places.windows(2).zip(told.windows(2)) {
            errors[pair[0]..=pair[1]].fill(BETWEEN * told[0].max(told[1]));
        }
        places.iter().zip(&told).for_each(|(&i, error)| errors[i] = *error);
        errors
    }

    pub(super) fn described(&mut self, point: &TracedPoint, error: f64) -> Result<CurvePoint, BreatherError> {
        let AtEvent { orbit, mark, .. } = point.orbit();
        let told = self.watcher.admissibility(orbit).ok();
        let physical = told.map(|told| is_physical(&told, orbit));
        let angle = mark.filter(|_| self.has_angle()).map(|theta| theta.clamp(0.0, std::f64::consts::PI));
        let angle = angle.map(|theta| theta / std::f64::consts::PI);
        let orbit = orbit.to_orbit(self.asked.name)?;
        Ok(CurvePoint { values: values(point), error, orbit, angle, physical })
    }
}

//! With losses: pairs of multipliers that cross the circle.
//!
//! How many are outside at both ends of a step does not tell: two may change places, and one that leaves may come back. Slopes do. The cubic of
//! each through both ends is held against a point between; what is left between them, and how near the cubic comes to the circle, say whether it
//! is to be trusted. Where it is not, the step is halved.

use nalgebra::Complex;
use vibrochain_breather::system::{System, Vector, dot};
use vibrochain_breather::{BranchError, BranchPoint, BreatherError};

use super::confirm::{BESIDE, Found};
use super::paths::{Mover, Passing, Place, passings};
use super::seen::velocities;
use super::{At, Follower, Seen};
use crate::bracket::zero;
use crate::events::Test;
use crate::events::half_sums::{ON_CIRCLE, upper_half};
use crate::locate::answer::{Event, LocateError};
use crate::spectrum::SpectralFunction;

/// Halvings of a step within which two multipliers must become distinguishable.
const HALVINGS: u32 = 20;

/// Parts of a step that are looked at: dozens are usual where many pairs cross.
const MOST_PARTS: usize = 500;

/// Multipliers farther from the circle than this, as ln|μ|, do not come to it within a step.
const REACH: f64 = 0.25;

/// A slope is a difference between two points, one on each side of its own. Their distance from it is this part of the step within these bounds,
/// where neither the cubic term of the difference nor its rounding is felt.
const ASIDE: f64 = 1e-3;
const NEAREST: f64 = 1e-9;
const FARTHEST: f64 = 1e-5;

/// An event may be this part of the step beside the place where a cubic has it.
const SLACK: f64 = 0.1;

/// Parameters closer than this part of them are one to rounding.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Slopes of the multipliers above the real axis along the tangent of their point.
#[derive(Debug, Clone, Default)]
pub(super) struct Moving {
    along: Vector,
    movers: Vec<Mover>,
}

/// A part of a step, and how often that was halved for it.
struct Span {
    places: [Place; 3],
    depth: u32,
}

/// Whether the parameter hardly moves from one end to the other.
fn is_rounding([from, _, to]: &[Place; 3]) -> bool {
    (from.value - to.value).abs() <= ROUNDING * (from.value.abs() + to.value.abs())
}

impl Follower {
    /// As [`look`](Self::look), with the slopes of multipliers where crossings of the circle are watched; `length` is about that of the step.
    pub(super) fn look_on(&mut self, point: &BranchPoint, length: f64) -> Result<Seen, LocateError> {
        let mut seen = self.look(point)?;
        if self.watches(Event::NeimarkSacker) && !point.orbit().is_lossless() {
            seen.moving = self.moving(point, &seen.values, length);
        }
        Ok(seen)
    }

    /// All crossings of two halves of a step, those of each by their length from its beginning.
    pub(super) fn crossings(
        &mut self,
        [from, middle, to]: [At<'_>; 3],
        wanted: [bool; 2],
    ) -> Result<[Vec<Found>; 2], LocateError> {
        let mut found = [Vec::new(), Vec::new()];
        let lossless = |at: At<'_>| at.0.orbit().is_lossless();
        let unknown = [from, middle, to].into_iter().any(|at| !lossless(at) && at.1.values.is_empty());
        if !self.watches(Event::NeimarkSacker) || lossless(middle) || unknown {
            return Ok(found);
        }
        let length = self.branch.length_between(from.0, to.0);
        let half = self.branch.length_between(from.0, middle.0);
        let beside = BESIDE * length;
        let (mut spans, mut open) = (Vec::new(), false);
        let vanishing = self.vanishing((from.0, to.0), length)?;
        // Where losses end all multipliers come to the circle: just before they have not.
        let ends = [if lossless(from) { beside } else { 0.0 }, if lossless(to) { length - beside } else { length }];
        if vanishing.is_empty() && ends == [0.0, length] {
            let places = [(from, 0.0), (middle, half), (to, length)].map(|(at, s)| self.moved(from.0, at, s, length));
            spans.push(Span { places, depth: 0 });
        } else {
            let mut low = ends[0];
            for at in vanishing.into_iter().chain([f64::INFINITY]) {
                let high = (at - beside).min(ends[1]);
                let parts = if low < half && half < high { vec![[low, half], [half, high]] } else { vec![[low, high]] };
                for part in parts {
                    spans.extend(self.span(from.0, part)?);
                }
                low = at + beside;
            }
        }
        let mut parts = 0;
        while let Some(Span { places, depth }) = spans.pop() {
            parts += 1;
            let told = passings([&places[0], &places[1], &places[2]]);
            let is_last = depth == HALVINGS || parts >= MOST_PARTS || is_rounding(&places);
            let [low, between, high] = places;
            for ([low, high], told) in [[low, between.clone()], [between, high]].into_iter().zip(told) {
                let which = usize::from(low.s >= half);
                if !wanted[which] {
                    continue;
                }
                let bases = if which == 0 { [from.0, from.0] } else { [from.0, middle.0] };
                if let Some(located) = told.and_then(|told| self.located(bases, (to.0, length), &told)) {
                    found[which].extend(located);
                } else if is_last {
                    open = true;
                    self.hidden_between(from.0, low.s, high.s);
                } else if let Some(middle) = self.moved_at(from.0, 0.5 * (low.s + high.s), high.s - low.s)? {
                    spans.push(Span { places: [low, middle, high], depth: depth + 1 });
                }
            }
        }
        self.untold += usize::from(open);
        Ok(found)
    }

    /// A part of a step from its ends, if it has a length.
    fn span(&mut self, from: &BranchPoint, [low, high]: [f64; 2]) -> Result<Option<Span>, LocateError> {
        if low >= high {
            return Ok(None);
        }
        let mut at = |s: f64| self.moved_at(from, s, high - low);
        let places = [at(low)?, at(0.5 * (low + high))?, at(high)?];
        let [Some(low), Some(middle), Some(high)] = places else { return Ok(None) };
        Ok(Some(Span { places: [low, middle, high], depth: 0 }))
    }

    /// The events of passings in a step from the first of two points, by their lengths from the second; `None` if one of them is not found.
    fn located(
        &mut self,
        [from, base]: [&BranchPoint; 2],
        (to, length): (&BranchPoint, f64),
        told: &[Passing],
    ) -> Option<Vec<Found>> {
        let mut solutions = Vec::with_capacity(told.len());
        for passing in told {
            let (solved, evidence) = self.solved(Test::Circle, (from, to), passing.s / length, Some(passing.angle))?;
            let along = self.length_to(from, &solved);
            let [low, high] = passing.between;
            let slack = SLACK * (high - low);
            let angle = solved.at.mark.unwrap_or(0.0);
            let own = (low - slack..=high + slack).contains(&along) && (angle - passing.angle).abs() <= passing.room;
            if !own || solved.error > length * self.range() {
                return None;
            }
            solutions.push((solved, evidence));
        }
        let event = |(solved, evidence)| {
            let along = self.length_to(base, &solved);
            Some((along, self.told(Event::NeimarkSacker, (base, along), solved, evidence).ok()?))
        };
        solutions.into_iter().map(event).collect()
    }

    /// Where in a step an impulse vanishes. It damps nothing there, so that all pairs which feel it meet the circle at once, and are on the other
    /// side of it where it pulls: that is the grazing, and no crossing of any of them.
    fn vanishing(&mut self, (from, to): (&BranchPoint, &BranchPoint), length: f64) -> Result<Vec<f64>, LocateError> {
        let ends = velocities(from.orbit()).into_iter().zip(velocities(to.orbit())).enumerate();
        let places = ends.filter(|(_, (low, high))| (*low > 0.0) != (*high > 0.0)).map(|(i, (low, high))| {
            let at = |s: f64| Ok::<_, BranchError>(velocities(self.branch.step(from, s)?.orbit())[i]);
            Ok(zero((0.0, low), (length, high), length, at)?)
        });
        let mut places: Vec<f64> = places.collect::<Result<_, LocateError>>()?;
        places.sort_by(f64::total_cmp);
        Ok(places)
    }

    /// A point of a step that was looked at.
    fn moved(&mut self, from: &BranchPoint, (point, seen): At<'_>, s: f64, length: f64) -> Place {
        let own;
        let moving = if seen.moving.along.is_empty() {
            own = self.moving(point, &seen.values, length);
            &own
        } else {
            &seen.moving
        };
        // By the length along the tangent at the beginning.
        let by = dot(from.tangent(), &moving.along).recip();
        let turned =
            |one: &Mover| Mover { slope: one.slope.map(|slope| slope * by), error: one.error * by.abs(), ..*one };
        Place::new([s, point.value()], moving.movers.iter().map(turned).collect(), &seen.values)
    }

    /// `None` at the end of what a parameter may be: beyond it there is nothing to cross to.
    fn moved_at(&mut self, from: &BranchPoint, s: f64, length: f64) -> Result<Option<Place>, LocateError> {
        let there = match self.branch.step(from, s) {
            Err(BranchError::Breather(BreatherError::Parameter(_))) => return Ok(None),
            there => there?,
        };
        let values = self.watcher.spectrum(there.orbit(), self.stretch.tolerance)?.0;
        let seen = Seen { values, ..Seen::default() };
        Ok(Some(self.moved(from, (&there, &seen), s, length)))
    }

    /// How multipliers that are near the circle move along the tangent of their point.
    fn moving(&mut self, point: &BranchPoint, values: &[Complex<f64>], length: f64) -> Moving {
        let aside = (ASIDE * length.abs()).clamp(NEAREST, FARTHEST);
        let at = upper_half(values).into_iter().map(|mu| Mover { at: mu.ln(), slope: None, error: 0.0 });
        let mut movers: Vec<Mover> = at.collect();
        let near = |one: &Mover| one.at.re.abs() < REACH;
        if movers.iter().any(near) {
            let _ = self.add_slopes(point, aside, movers.iter_mut().filter(|one| near(one)));
        }
        // Those of modes that no impact feels stay on it.
        movers.retain(|one| one.slope.is_some() || one.at.re.abs() > ON_CIRCLE);
        Moving { along: point.tangent().clone(), movers }
    }

    /// Slopes by central differences of J, which at the end of what a parameter may be are taken on one side.
    fn add_slopes<'m>(
        &mut self,
        point: &BranchPoint,
        aside: f64,
        movers: impl Iterator<Item = &'m mut Mover>,
    ) -> Option<()> {
        let mut beside = |by: f64| {
            let z = self.branch.ahead(point, by);
            self.branch.system().evaluate(&z).ok().map(|there| there.orbit.bloch_equations().0)
        };
        let (low, high) = (beside(-aside), beside(aside));
        let here = point.orbit().bloch_equations().0;
        let apart = f64::from(u8::from(low.is_some()) + u8::from(high.is_some())) * aside;
        let function = |equations| SpectralFunction::new(equations, false);
        let middle = function(&here);
        let [low, high] = [function(low.as_ref().unwrap_or(&here)), function(high.as_ref().unwrap_or(&here))];
        for mover in movers {
            let mu = mover.at.exp();
            if let Some(drift) = middle.drift(mu, [&low, &high]) {
                let by = (mu * apart).inv();
                (mover.slope, mover.error) = (Some(drift.value * by), drift.error * by.norm());
            }
        }
        Some(())
    }

    pub(super) fn hidden_between(&mut self, from: &BranchPoint, low: f64, high: f64) {
        let ends = [low, high].map(|s| self.branch.step(from, s).map_or(from.value(), |end| end.value()));
        self.hidden(ends[0], ends[1]);
    }
}

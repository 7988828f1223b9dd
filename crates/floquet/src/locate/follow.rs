//! Along the branch, both ways: steps, what is watched at each, and the zero where it changes sign.

use nalgebra::Complex;
use vibrochain_breather::{Branch, BranchError, BranchPoint, BreatherError, Finder, Found, Orbit};
use vibrochain_lattice::Parameter;

use super::bracket::zero;
use super::handover::hand_over;
use super::secular::polished;
use super::spectrum_events::{
    Crossing, collided, complex_count, crossing, discriminant, follow, half_sums, log_determinant, upper_half,
};
use super::{Answer, End, Event, LocateError, Located, Search, Sign};
use crate::analyser::Analyser;
use crate::error::FloquetError;
use crate::multipliers::pair;
use crate::verdict::{Tolerance, Verdict};

/// The longest step, in units: the range is one unit, and so is a change of order 1 of the orbit.
const LONGEST: f64 = 0.02;

/// The shortest step: where even this one fails, the branch is lost.
const SHORTEST: f64 = 1e-9;

/// An orbit whose impulses have grown by this factor is on its way to infinity.
const UNBOUNDED: f64 = 1e4;

/// A branch that is lost this near to a resonance, as a part of the range, ends there.
const NEAR: f64 = 1e-3;

/// Steps at most in one direction.
const MOST_STEPS: usize = 20_000;

/// Halvings of a step within which two eigenvalues must become distinguishable.
const HALVINGS: usize = 30;

/// A multiplier farther than this from where it should be is not the zero of the function but a pole.
const POLE: f64 = 1e-4;

/// Points and distance at which the function's rounding is sampled next to its zero: far enough for rounding to be another
/// one, near enough for the function to be a straight line.
const SAMPLES: i32 = 4;
const SAMPLE_STEP: f64 = 1e-9;

/// Worst case over what a few samples show.
const SAFETY: f64 = 4.0;

/// Rounding of the data, and the relative step by which its effect is seen.
const DATA_ROUNDING: f64 = 2.0 * f64::EPSILON;
const DATA_STEP: f64 = 1e-7;

/// Events at most in one step, and how far behind one the next is looked for, as a part of the step.
const MOST_IN_STEP: usize = 32;
const BEHIND: f64 = 1e-4;

/// A small step away from an event, as a part of the parameter.
const AWAY: f64 = 1e-4;

/// A function of the point that changes sign at the event. Lengths are counted from the start of the step.
#[derive(Debug, Clone, Copy)]
enum Test {
    /// Velocity before an impact, towards its barrier.
    Impact(usize),
    /// Smallest distance to a barrier.
    Margin,
    /// Determinant of the orbit's equations.
    Equations,
    /// det(A + shift) over its size `log` at the start.
    Shifted { shift: f64, log: f64 },
    /// |μ|² − 1 of the pair that goes from one value to the other.
    Modulus { ends: [(f64, Complex<f64>); 2] },
    /// Discriminant of the two ν that collide.
    Collision { centre: f64 },
}

/// What was seen at a point.
#[derive(Debug, Clone, Default)]
struct Seen {
    /// Velocity before each impact, towards its barrier.
    velocities: Vec<f64>,
    margin: Option<f64>,
    equations: f64,
    /// ln|det(A + shift)| and its sign.
    determinant: (f64, f64),
    /// Eigenvalues: μ, or ν of a reversible orbit.
    values: Vec<Complex<f64>>,
}

pub(super) struct Follower {
    branch: Branch,
    analyser: Analyser,
    finder: Finder,
    search: Search,
    /// Orbits assembled on other branches.
    others: usize,
    spectra: usize,
}

pub(super) fn locate(orbit: &Orbit, search: &Search) -> Result<Answer, LocateError> {
    let Search { free, from, to, .. } = *search;
    let start = orbit.model().get(free);
    if !(from <= start && start <= to && from < to) {
        return Err(LocateError::Range { free, start, from, to });
    }
    for end in [from, to] {
        orbit.model().with(free, end).map_err(BreatherError::from)?;
    }
    if orbit.model().is_conservative() && matches!(free, Parameter::Amplitude | Parameter::Restitution) {
        return Err(LocateError::NoForce { free });
    }
    let mut follower = Follower {
        branch: Branch::through(orbit, free, to - from)?,
        analyser: Analyser::default(),
        finder: Finder::new(orbit.model().chain().sites()),
        search: *search,
        others: 0,
        spectra: 0,
    };
    let point = follower.branch.start()?;
    let (up, down) = if point.heading() < 0.0 { (point.reversed(), point) } else { (point.clone(), point.reversed()) };
    let mut located = Vec::new();
    let mut ends = Vec::new();
    for point in [down, up] {
        let (value, end) = follower.follow(point, &mut located)?;
        ends.push((value, end));
    }
    located.sort_by(|a, b| (a.value - start).abs().total_cmp(&(b.value - start).abs()));
    // A start right on the event is found from both sides.
    located.dedup_by(|b, a| (a.value - b.value).abs() <= a.error + b.error);
    let lost = || (start, End::Lost(BranchError::NoConvergence));
    let mut ends = ends.into_iter();
    let ends = [ends.next().unwrap_or_else(lost), ends.next().unwrap_or_else(lost)];
    Ok(Answer { located, ends, evaluations: follower.evaluations(), spectra: follower.spectra })
}

impl Follower {
    fn evaluations(&self) -> usize {
        self.branch.evaluations() + self.others
    }

    /// Follows one direction to the end of the way.
    fn follow(&mut self, start: BranchPoint, located: &mut Vec<Located>) -> Result<(f64, End), LocateError> {
        let upwards = start.heading() > 0.0;
        let limit = if upwards { self.search.to } else { self.search.from };
        let beyond = |value: f64| if upwards { value >= limit } else { value <= limit };
        let mut point = start;
        if point.value() == limit {
            return Ok((limit, End::Range));
        }
        let mut seen = self.look(&point)?;
        let mut length = 0.25 * LONGEST;
        let first = strength(point.orbit());
        for _ in 0..MOST_STEPS {
            let (next, last) = match self.advance(&point, length, limit, beyond) {
                Ok(next) => next,
                Err(error) => {
                    length *= 0.25;
                    if length < SHORTEST {
                        // Right before a resonance there is no next point that could tell.
                        let near = if upwards { NEAR } else { -NEAR } * (self.search.to - self.search.from);
                        return Ok(match self.branch.resonance_within(point.value(), point.value() + near) {
                            Some((value, resonance)) => (value, End::Resonance(resonance)),
                            None => (point.value(), End::Lost(error)),
                        });
                    }
                    continue;
                }
            };
            if let Some((value, resonance)) = self.branch.resonance_within(point.value(), next.value()) {
                return Ok((value, End::Resonance(resonance)));
            }
            if next.heading() * point.heading() <= 0.0 {
                return stopped(point.value(), self.turn(&point, &seen, &next, located));
            }
            let watched = self.look(&next).and_then(|next_seen| {
                self.all_between((&point, &seen), (&next, &next_seen), located)?;
                Ok(next_seen)
            });
            let next_seen = match watched {
                Ok(next_seen) => next_seen,
                Err(error) => return stopped(point.value(), Err(error)),
            };
            (point, seen) = (next, next_seen);
            if last {
                return Ok((limit, End::Range));
            }
            let growth = strength(point.orbit()) / first;
            if growth > UNBOUNDED {
                return Ok((point.value(), End::Unbounded));
            }
            // Impulses that grow without bound set a longer scale, as long as the parameter does not move far.
            let longest = LONGEST * growth.clamp(1.0, 1.0 / point.heading().abs());
            length = (1.5 * length).min(longest);
        }
        Ok((point.value(), End::Lost(BranchError::NoConvergence)))
    }

    /// The next point, at most at the limit; whether it is the last.
    fn advance(
        &mut self,
        point: &BranchPoint,
        length: f64,
        limit: f64,
        beyond: impl Fn(f64) -> bool,
    ) -> Result<(BranchPoint, bool), BranchError> {
        // The range is one unit of the parameter.
        let reached = point.value() + length * point.heading() * (self.search.to - self.search.from);
        if beyond(reached) {
            return Ok((self.branch.at(point, limit)?, true));
        }
        let next = self.branch.step(point, length)?;
        if beyond(next.value()) {
            return Ok((self.branch.at(point, limit)?, true));
        }
        Ok((next, false))
    }

    /// The branch turns back between two points: a fold, or the end of asymmetric orbits on the symmetric one.
    fn turn(
        &mut self,
        point: &BranchPoint,
        seen: &Seen,
        next: &BranchPoint,
        located: &mut Vec<Located>,
    ) -> Result<(f64, End), LocateError> {
        if next.determinant() * point.determinant() > 0.0 {
            // Asymmetric orbits end on the symmetric one and go on as their own mirror images: there the equations are
            // singular in two directions, but among symmetric orbits in none.
            let found = if self.search.event == Event::Pitchfork { self.on_symmetric(point, next)? } else { None };
            let value = found.as_ref().map_or(next.value(), |found| found.value);
            located.extend(found);
            return Ok((value, End::Pitchfork));
        }
        let fold = self.fold(point, next)?;
        if self.search.event == Event::Fold {
            let sign = self.nearest_to(&fold, Complex::new(1.0, 0.0))?;
            let error = fold.parameter_error() + 2.0 * f64::EPSILON * fold.value().abs();
            let found = self.describe(&fold, error, sign)?;
            located.push(found);
        } else if self.search.event != Event::Pitchfork || shift_of(Event::Pitchfork, point.orbit()).is_some() {
            // An event may lie before it; not a pitchfork of the equations, whose determinant vanishes at the fold itself.
            let at_fold = self.look(&fold)?;
            self.all_between((point, seen), (&fold, &at_fold), located)?;
        }
        Ok((fold.value(), End::Fold { error: fold.parameter_error() }))
    }

    /// The fold between two points: by its equations from the end that leads there, or from where the heading vanishes.
    fn fold(&mut self, point: &BranchPoint, next: &BranchPoint) -> Result<BranchPoint, LocateError> {
        let inside = |value: f64| (value - point.value()).abs() <= 0.5 * (self.search.to - self.search.from);
        for start in [point, next] {
            if let Some(fold) = self.branch.fold(start).ok().filter(|fold| inside(fold.value())) {
                return Ok(fold);
            }
        }
        let length = self.branch.length_between(point, next);
        let branch = &mut self.branch;
        let heading = |s: f64| branch.step(point, s).map(|there| there.heading());
        let s = zero((0.0, point.heading()), (length, next.heading()), length, heading)?;
        Ok(self.branch.step(point, s)?)
    }

    /// The pitchfork on the symmetric branch that asymmetric orbits meet between two points.
    fn on_symmetric(&mut self, point: &BranchPoint, next: &BranchPoint) -> Result<Option<Located>, LocateError> {
        let orbit = next.orbit();
        let mut found = Found::default();
        self.finder.find(orbit.model(), orbit.family(), &mut found)?;
        let impulse = |orbit: &Orbit| orbit.impacts().first().map_or(0.0, |impact| impact.impulse);
        let half = 0.5 * orbit.period();
        let symmetric = found.orbits.iter().filter(|one| one.phi().is_some_and(|phi| (phi - half).abs() < 1e-9 * half));
        let unlike = |one: &Orbit| (impulse(one) - impulse(orbit)).abs();
        let Some(nearest) = symmetric.min_by(|a, b| unlike(a).total_cmp(&unlike(b))) else { return Ok(None) };
        let reach = 2.0 * (next.value() - point.value()).abs() + 1e-6 * (self.search.to - self.search.from);
        let (from, to) = (next.value() - reach, next.value() + reach);
        let search = Search { from: from.max(self.search.from), to: to.min(self.search.to), ..self.search };
        let mut answer = locate(nearest, &search)?;
        self.others += answer.evaluations;
        self.spectra += answer.spectra;
        answer.located.truncate(1);
        Ok(answer.located.pop())
    }

    /// What the search needs to know of a point.
    fn look(&mut self, point: &BranchPoint) -> Result<Seen, LocateError> {
        let orbit = point.orbit();
        let mut seen = Seen { equations: point.determinant(), ..Seen::default() };
        match (self.search.event, shift_of(self.search.event, orbit)) {
            (Event::Fold, _) => {}
            (Event::Grazing, _) => {
                let impacts = orbit.impacts().iter();
                seen.velocities = impacts.map(|impact| impact.velocity_before * impact.barrier.sign()).collect();
                seen.margin = self.finder.admissibility(orbit)?.margin;
            }
            (Event::NeimarkSacker, _) => seen.values = self.spectrum(orbit)?,
            (_, Some(shift)) => {
                self.spectrum(orbit)?;
                seen.determinant = log_determinant(self.analyser.matrix_of(orbit), shift);
            }
            (_, None) => {}
        }
        Ok(seen)
    }

    /// Eigenvalues: μ, or ν of a reversible orbit.
    fn spectrum(&mut self, orbit: &Orbit) -> Result<Vec<Complex<f64>>, LocateError> {
        self.spectra += 1;
        self.analyser.solve(orbit, &mut self.finder)?;
        if self.analyser.values.is_empty() { Err(LocateError::NoMultiplier) } else { Ok(self.analyser.values.clone()) }
    }

    /// All events between two neighbouring points.
    fn all_between(
        &mut self,
        from: (&BranchPoint, &Seen),
        to: (&BranchPoint, &Seen),
        located: &mut Vec<Located>,
    ) -> Result<(), LocateError> {
        let (mut point, mut seen) = (from.0.clone(), from.1.clone());
        for _ in 0..MOST_IN_STEP {
            let length = self.branch.length_between(&point, to.0);
            let Some((s, found)) = self.between((&point, &seen), to)? else { break };
            located.extend(found);
            // On from just behind it.
            let behind = s + BEHIND * length;
            if behind >= length {
                break;
            }
            point = self.branch.step(&point, behind)?;
            seen = self.look(&point)?;
        }
        Ok(())
    }

    /// The first zero between two neighbouring points, and the event there if it is one.
    fn between(
        &mut self,
        (point, seen): (&BranchPoint, &Seen),
        (next, next_seen): (&BranchPoint, &Seen),
    ) -> Result<Option<(f64, Option<Located>)>, LocateError> {
        let length = self.branch.length_between(point, next);
        let changes = |a: f64, b: f64| (a > 0.0) != (b > 0.0);
        let mut found: Option<(f64, Test)> = None;
        match self.search.event {
            Event::Fold => {}
            Event::Grazing => {
                let velocities = seen.velocities.iter().zip(&next_seen.velocities).enumerate();
                let mut tests: Vec<(Test, f64, f64)> =
                    velocities.map(|(i, (&a, &b))| (Test::Impact(i), a, b)).collect();
                if let (Some(a), Some(b)) = (seen.margin, next_seen.margin) {
                    tests.push((Test::Margin, a, b));
                }
                for (test, a, b) in tests.into_iter().filter(|(_, a, b)| changes(*a, *b)) {
                    let s = self.zero_of(test, point, (0.0, a), (length, b))?;
                    if found.is_none_or(|(nearest, _)| s < nearest) {
                        found = Some((s, test));
                    }
                }
            }
            Event::NeimarkSacker => found = self.crossing(point, length, seen, next_seen)?,
            Event::Pitchfork | Event::PeriodDoubling => match shift_of(self.search.event, point.orbit()) {
                None if changes(seen.equations, next_seen.equations) => {
                    let s =
                        self.zero_of(Test::Equations, point, (0.0, seen.equations), (length, next_seen.equations))?;
                    found = Some((s, Test::Equations));
                }
                Some(shift) if changes(seen.determinant.1, next_seen.determinant.1) => {
                    let test = Test::Shifted { shift, log: seen.determinant.0 };
                    let (low, high) = (seen.determinant.1, next_seen.determinant);
                    let s =
                        self.zero_of(test, point, (0.0, low), (length, high.1 * (high.0 - seen.determinant.0).exp()))?;
                    found = Some((s, test));
                }
                _ => {}
            },
        }
        match found {
            Some((s, test)) => Ok(Some((s, self.settle(point, length, s, test)?))),
            None => Ok(None),
        }
    }

    fn zero_of(
        &mut self,
        test: Test,
        point: &BranchPoint,
        low: (f64, f64),
        high: (f64, f64),
    ) -> Result<f64, LocateError> {
        zero(low, high, high.0, |s| {
            let there = self.branch.step(point, s)?;
            self.value(test, &there, s)
        })
    }

    /// The function at a point `s` along the step.
    fn value(&mut self, test: Test, point: &BranchPoint, s: f64) -> Result<f64, LocateError> {
        let orbit = point.orbit();
        let lost = || FloquetError::NotConverged { dimension: 2 * orbit.model().chain().even_modes() };
        Ok(match test {
            Test::Impact(i) => {
                orbit.impacts().get(i).map_or(0.0, |impact| impact.velocity_before * impact.barrier.sign())
            }
            // An impact that turned its sign has no margin: beyond grazing.
            Test::Margin => self.finder.admissibility(orbit)?.margin.unwrap_or(-1.0),
            Test::Equations => point.determinant(),
            Test::Shifted { shift, log } => {
                self.spectrum(orbit)?;
                let (logarithm, sign) = log_determinant(self.analyser.matrix_of(orbit), shift);
                sign * (logarithm - log).exp()
            }
            Test::Modulus { ends: [(a, from), (b, to)] } => {
                let expected = from + (to - from) * ((s - a) / (b - a));
                let values = self.spectrum(orbit)?;
                let near = follow(expected, &values).ok_or_else(lost)?;
                let multiplier = polished(orbit, &mut self.finder, near)?;
                // |μ|² − 1 by factors: the sum of squares would round it.
                let modulus = multiplier.norm();
                (modulus - 1.0) * (modulus + 1.0)
            }
            Test::Collision { centre } => {
                let values = self.spectrum(orbit)?;
                discriminant(centre, &half_sums(&values, orbit.is_reversible())).ok_or_else(lost)?
            }
        })
    }

    /// The first pair that crosses the circle, or the first two that collide on it, in a step.
    fn crossing(
        &mut self,
        point: &BranchPoint,
        length: f64,
        seen: &Seen,
        next_seen: &Seen,
    ) -> Result<Option<(f64, Test)>, LocateError> {
        let reversible = point.orbit().is_reversible();
        if point.orbit().model().loss() == 0.0 {
            let (mut low, mut high) = (0.0, length);
            let (mut on, mut off) = (half_sums(&seen.values, reversible), half_sums(&next_seen.values, reversible));
            if complex_count(&on) == complex_count(&off) {
                return Ok(None);
            }
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                let there = self.branch.step(point, middle)?;
                let sums = half_sums(&self.spectrum(there.orbit())?, reversible);
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
            let reach = 1e-4 * length;
            let (low, high) = ((low - reach).max(0.0), (high + reach).min(length));
            let mut ends = [(low, 0.0), (high, 0.0)];
            for (s, value) in &mut ends {
                let there = self.branch.step(point, *s)?;
                *value = self.value(test, &there, *s)?;
            }
            if (ends[0].1 > 0.0) == (ends[1].1 > 0.0) {
                return Ok(None);
            }
            return Ok(Some((self.zero_of(test, point, ends[0], ends[1])?, test)));
        }
        let mut parts = vec![(0.0, upper_half(&seen.values), length, upper_half(&next_seen.values), 0)];
        while let Some((low, from, high, to, depth)) = parts.pop() {
            match crossing(&from, &to) {
                Crossing::None => {}
                Crossing::Pair(inside, outside) => {
                    let test = Test::Modulus { ends: [(low, inside), (high, outside)] };
                    let at = |s: f64, value: Complex<f64>| (s, value.norm_sqr() - 1.0);
                    let s = self.zero_of(test, point, at(low, inside), at(high, outside))?;
                    return Ok(Some((s, test)));
                }
                Crossing::Unclear if depth < HALVINGS => {
                    let middle = 0.5 * (low + high);
                    let there = self.branch.step(point, middle)?;
                    let between = upper_half(&self.spectrum(there.orbit())?);
                    parts.push((middle, between.clone(), high, to, depth + 1));
                    parts.push((low, from, middle, between, depth + 1));
                }
                Crossing::Unclear => {}
            }
        }
        Ok(None)
    }

    /// The event at `s` along a step: checked, with its error. `None` for a pole or another false alarm.
    fn settle(&mut self, point: &BranchPoint, length: f64, s: f64, test: Test) -> Result<Option<Located>, LocateError> {
        let there = self.branch.step(point, s)?;
        let sign = match test {
            Test::Impact(i) => Sign::Impact(i),
            Test::Margin => match self.finder.admissibility(there.orbit())?.closest {
                Some(closest) => Sign::Touch(closest),
                None => return Ok(None),
            },
            Test::Equations => self.nearest_to(&there, Complex::new(1.0, 0.0))?,
            Test::Shifted { shift, .. } => self.nearest_to(&there, Complex::new(-shift, 0.0))?,
            Test::Modulus { ends: [(a, from), (b, to)] } => {
                self.nearest_to(&there, from + (to - from) * ((s - a) / (b - a)))?
            }
            Test::Collision { centre } => {
                let angle = centre.clamp(-1.0, 1.0).acos();
                self.nearest_to(&there, Complex::from_polar(1.0, angle))?
            }
        };
        if let Sign::Multiplier(multiplier) = sign {
            let goal = match test {
                Test::Modulus { .. } => multiplier / multiplier.norm(),
                Test::Collision { centre } => Complex::from_polar(1.0, centre.clamp(-1.0, 1.0).acos()),
                Test::Shifted { shift, .. } => Complex::new(-shift, 0.0),
                _ => Complex::new(1.0, 0.0),
            };
            // Written so that a multiplier that is not a number is no event either.
            let near = (multiplier - goal).norm() <= POLE * (1.0 + self.analyser_norm(&there)?.ln().max(0.0));
            if !near {
                return Ok(None);
            }
        }
        let error = self.error(point, length, s, test, &there)?;
        self.describe(&there, error, sign).map(Some)
    }

    /// Norm of the matrix whose eigenvalues were last worked out.
    fn analyser_norm(&self, point: &BranchPoint) -> Result<f64, LocateError> {
        Ok(self.analyser.matrix_of(point.orbit()).norm().max(1.0))
    }

    /// The multiplier nearest to `goal`.
    fn nearest_to(&mut self, point: &BranchPoint, goal: Complex<f64>) -> Result<Sign, LocateError> {
        let orbit = point.orbit();
        let values = self.spectrum(orbit)?;
        let multipliers = values.iter().flat_map(|&value| {
            let [large, small] = if orbit.is_reversible() { pair(value) } else { [value, value] };
            [large, small]
        });
        let nearest = multipliers.min_by(|a, b| (a - goal).norm_sqr().total_cmp(&(b - goal).norm_sqr()));
        nearest.map(Sign::Multiplier).ok_or(LocateError::NoMultiplier)
    }

    /// Error of the parameter at a zero: rounding of the function and of the parameter along the curve, as samples show
    /// them, over the function's slope.
    fn error(
        &mut self,
        point: &BranchPoint,
        length: f64,
        s: f64,
        test: Test,
        there: &BranchPoint,
    ) -> Result<f64, LocateError> {
        let mut samples = Vec::new();
        for k in -SAMPLES..=SAMPLES {
            let at = s + f64::from(k) * SAMPLE_STEP;
            // Past the end of the parameter's range there are none.
            let Ok(sample) = self.branch.step(point, at) else { continue };
            samples.push((at - s, self.value(test, &sample, at)?, sample.value()));
        }
        let reach = 1e-3 * length;
        let mut side = |at: f64| -> Result<(f64, f64), LocateError> {
            let sample = self.branch.step(point, at)?;
            Ok((self.value(test, &sample, at)?, sample.value()))
        };
        // One-sided next to such an end.
        let (below, above) = (side(s - reach), side(s + reach));
        let (from, to) = (if below.is_ok() { s - reach } else { s }, if above.is_ok() { s + reach } else { s });
        let (low, high) = (below.or_else(|_| side(s))?, above.or_else(|_| side(s))?);
        let (slope, pace) = ((high.0 - low.0) / (to - from), (high.1 - low.1) / (to - from));
        // Departures from the straight line through their mean.
        let scatter = |of: fn(&(f64, f64, f64)) -> f64, slope: f64| {
            let rests: Vec<f64> = samples.iter().map(|sample| of(sample) - slope * sample.0).collect();
            let mean = rests.iter().sum::<f64>() / rests.len() as f64;
            rests.iter().map(|rest| (rest - mean).abs()).fold(0.0, f64::max)
        };
        let (of_value, of_parameter) = (scatter(|sample| sample.1, slope), scatter(|sample| sample.2, pace));
        let error = SAFETY * (of_value * (pace / slope).abs() + of_parameter);
        // Rounding that all samples share, such as that of the period, is a change of the data.
        let data = self.sensitivity(s, test, there)? * (pace / slope).abs() + there.value().abs();
        Ok(error + DATA_ROUNDING * data)
    }

    /// Σ |p ∂/∂p| of the function over all other parameters p of the model.
    fn sensitivity(&mut self, s: f64, test: Test, there: &BranchPoint) -> Result<f64, LocateError> {
        let (orbit, here) = (there.orbit(), self.value(test, there, s)?);
        let mut sum = 0.0;
        for parameter in Parameter::ALL {
            let value = orbit.model().get(parameter);
            let absent =
                orbit.model().is_conservative() && matches!(parameter, Parameter::Amplitude | Parameter::Restitution);
            if parameter == self.search.free || value == 0.0 || absent {
                continue;
            }
            // Downwards: restitution may be 1.
            let step = DATA_STEP * value;
            let mut across = Branch::through(orbit, parameter, value)?;
            // Where the change breaks a symmetry there is no such orbit at a pitchfork, nor rounding that would do it.
            let moved = across.start().and_then(|start| across.at(&start, value - step));
            self.others += across.evaluations();
            let Ok(moved) = moved else { continue };
            sum += (self.value(test, &moved, s)? - here).abs() / DATA_STEP;
        }
        Ok(sum)
    }

    /// The answer at a point.
    fn describe(&mut self, there: &BranchPoint, error: f64, sign: Sign) -> Result<Located, LocateError> {
        let verdicts = self.verdicts(there);
        let physical = self.finder.admissibility(there.orbit()).ok().map(|answer| answer.is_physical());
        let search = self.search;
        let distance = AWAY * there.value().abs().max(1e-2 * (search.to - search.from));
        let handover = hand_over(there.orbit(), search, distance, &mut self.analyser, &mut self.finder);
        Ok(Located {
            value: there.value(),
            error,
            orbit: there.orbit().clone(),
            sign,
            physical,
            verdicts,
            handover,
            evaluations: self.evaluations(),
        })
    }

    /// Verdicts a small step away on either side, of those that exist and can be judged.
    fn verdicts(&mut self, there: &BranchPoint) -> Vec<(f64, Verdict)> {
        let mut verdicts = Vec::new();
        for sign in [-1.0, 1.0] {
            // Along the curve: at a fold both sides lie on one side in the parameter.
            let Ok(side) = self.branch.step(there, sign * 1e-2 * LONGEST) else { continue };
            if let Ok(verdict) = self.analyser.verdict(side.orbit(), &mut self.finder, Tolerance::Rounding) {
                verdicts.push((side.value(), verdict));
            }
        }
        verdicts.sort_by(|a, b| a.0.total_cmp(&b.0));
        verdicts
    }
}

/// A failure on the way ends the way, it does not undo what was found before.
fn stopped(value: f64, result: Result<(f64, End), LocateError>) -> Result<(f64, End), LocateError> {
    match result {
        Err(LocateError::Branch(error)) => Ok((value, End::Lost(error))),
        Err(LocateError::Floquet(error)) => Ok((value, End::Unwatched(error))),
        other => other,
    }
}

/// The largest impulse.
fn strength(orbit: &Orbit) -> f64 {
    orbit.impacts().iter().map(|impact| impact.impulse.abs()).fold(f64::MIN_POSITIVE, f64::max)
}

/// The shift s of det(A + s) that shows an event, for those that the spectrum shows; `None` where the orbit's own equations
/// do. A holds μ, or ν of a reversible orbit, which are both ±1 together.
fn shift_of(event: Event, orbit: &Orbit) -> Option<f64> {
    match event {
        Event::PeriodDoubling => Some(1.0),
        Event::Pitchfork if orbit.model().is_conservative() => Some(-1.0),
        _ => None,
    }
}

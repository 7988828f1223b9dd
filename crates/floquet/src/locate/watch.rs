//! What is watched at each point of a branch, and the zeros of it between two.

use nalgebra::Complex;
use smallvec::SmallVec;
use vibrochain_breather::{BranchError, BranchPoint, BreatherError, Orbit};

use super::answer::{Event, LocateError, Located};
use super::follower::{Follower, Observation, Passed, shift_of};
use super::polish::{Polisher, polish};
use super::spectrum_events::{Crossing, crossing, discriminant, follow, half_sums, regular_determinant, upper_half};
use crate::bracket::zero;
use crate::error::FloquetError;

/// Halvings of a step within which two eigenvalues must become distinguishable.
pub(super) const HALVINGS: usize = 30;

/// Rounding of dense eigenvalues, in units of that of the norm; and how far from the circle they matter.
const DENSE: f64 = 100.0;
const NEAR_CIRCLE: f64 = 0.1;

/// However large the norm of a dense matrix is, its eigenvalues are no start for a search farther than this.
const FARTHEST: f64 = 1e-2;

/// Events at most in one step, and how far behind one the next is looked for, as a part of the step.
const MOST_IN_STEP: usize = 32;
const BEHIND: f64 = 1e-4;

/// How far before one that was found others are looked for, as a part of the way to it.
const BEFORE: f64 = 1e-3;

/// The zero of such a function.
struct Zero {
    at: f64,
    /// The event, if it is one.
    located: Option<Located>,
}

/// A function of the point that changes sign at the event. Lengths are counted from the start of the step.
#[derive(Debug, Clone, Copy)]
pub(super) enum Test {
    /// Velocity before an impact, towards its barrier.
    Impact(usize),
    /// Smallest distance to a barrier.
    Margin,
    /// Determinant of the orbit's equations.
    Equations,
    /// det(A + shift), made regular, over its size `log` at the start.
    Shifted { shift: f64, log: f64 },
    /// |μ|² − 1 of the pair that goes from one value to the other.
    Modulus { ends: [(f64, Complex<f64>); 2] },
    /// Discriminant of the two ν that collide.
    Collision { centre: f64 },
}

impl Follower {
    /// What is to be known of a point.
    pub(super) fn look(&mut self, point: &BranchPoint) -> Result<Observation, LocateError> {
        let orbit = point.orbit();
        let mut seen = Observation { equations: point.determinant(), ..Observation::default() };
        if self.watches(Event::Grazing) {
            let impacts = orbit.impacts().iter();
            seen.velocities = impacts.map(|impact| impact.velocity_before * impact.barrier.sign()).collect();
            seen.margin = self.finder.admissibility(orbit)?.margin;
        }
        let shifts: SmallVec<[(Event, f64); 2]> =
            self.events.iter().filter_map(|&event| Some((event, shift_of(event, orbit)?))).collect();
        // Signatures tell of thin stripes of any kind.
        let signed = self.whole && orbit.model().loss() == 0.0 && !shifts.is_empty();
        if self.watches(Event::NeimarkSacker) || signed {
            seen.values = self.pairs(orbit)?;
            if orbit.model().loss() == 0.0 {
                let mut off: Vec<Complex<f64>> = upper_half(&half_sums(&seen.values, orbit.is_reversible()));
                off.sort_by(|a, b| a.re.total_cmp(&b.re));
                seen.openings = off.iter().map(|nu| nu.im * nu.im).collect();
                // At one site signatures are those of each pair. The matrix of others does not see multipliers turn real as ν does.
                if self.whole && orbit.impact_site().is_none() && orbit.is_reversible() {
                    seen.order = self.orders.of(orbit).ok().flatten();
                }
            }
        } else if !shifts.is_empty() {
            self.spectrum(orbit)?;
        }
        let known = !self.analyser.dense.values.is_empty();
        for (event, shift) in shifts.into_iter().filter(|_| known) {
            let matrix = self.analyser.dense.matrix_of(orbit);
            seen.determinants.push((event, regular_determinant(orbit, matrix, shift)));
        }
        Ok(seen)
    }

    /// Eigenvalues: μ, or ν of a reversible orbit.
    pub(super) fn spectrum(&mut self, orbit: &Orbit) -> Result<Vec<Complex<f64>>, LocateError> {
        self.stop().heard()?;
        self.spectra += 1;
        self.analyser.dense.solve(orbit, &mut self.finder)?;
        // Masses without coupling have none, either, but on their way.
        if self.analyser.dense.values.is_empty() && orbit.model().chain().sites() == 1 {
            Err(LocateError::NoMultiplier)
        } else {
            Ok(self.analyser.dense.values.clone())
        }
    }

    /// What Neimark–Sacker points are seen by: all eigenvalues, or with loss one of each complex pair, where one could be near
    /// the circle to the last digits. One that cannot be told from the circle is put on it: it shows no crossing.
    pub(super) fn pairs(&mut self, orbit: &Orbit) -> Result<Vec<Complex<f64>>, LocateError> {
        let pairs = self.pairs_told(orbit)?;
        Ok(pairs.into_iter().map(|(value, told)| if told { value } else { value / value.norm() }).collect())
    }

    /// Those pairs, and whether each can be told from the circle.
    fn pairs_told(&mut self, orbit: &Orbit) -> Result<Vec<(Complex<f64>, bool)>, LocateError> {
        let values = self.spectrum(orbit)?;
        if orbit.model().loss() == 0.0 || orbit.impact_site().is_none() {
            return Ok(values.into_iter().map(|value| (value, true)).collect());
        }
        let slack = DENSE * f64::EPSILON * self.analyser.dense.matrix_of(orbit).norm();
        let near = |value: &Complex<f64>| (value.norm() - 1.0).abs() <= NEAR_CIRCLE + slack;
        let (mut near, far): (Vec<_>, Vec<_>) = upper_half(&values).into_iter().partition(near);
        let improved = polish(orbit, &mut self.finder, slack.min(FARTHEST), &mut near)?;
        let near = near.into_iter().zip(improved);
        let near = near.map(|(value, improved)| (value, improved || (value.norm() - 1.0).abs() > slack));
        Ok(near.chain(far.into_iter().map(|value| (value, true))).collect())
    }

    /// All events between two neighbouring points, in the order of the way.
    pub(super) fn all_between(
        &mut self,
        from: (&BranchPoint, &Observation),
        to: (&BranchPoint, &Observation),
    ) -> Result<(), LocateError> {
        let mut located = Vec::new();
        for event in self.events.clone() {
            if event == Event::NeimarkSacker && from.0.orbit().model().loss() == 0.0 {
                for edge in self.collisions(from, to)? {
                    let found = self.settle(event, from.0, edge.alone, (edge.at, edge.test))?;
                    located.extend(found.map(|found| (edge.at, found)));
                }
                continue;
            }
            // Each of its own: events of two kinds may be as near to each other as they like.
            let (mut point, mut seen, mut passed) = (from.0.clone(), from.1.clone(), 0.0);
            for _ in 0..MOST_IN_STEP {
                let length = self.branch.length_between(&point, to.0);
                let zero = match self.between(event, (&point, &seen), to) {
                    // Right at the end of what the parameter may be: beyond it there is nothing that could tell.
                    Err(LocateError::Branch(BranchError::Breather(BreatherError::Parameter(_)))) => None,
                    zero => zero?,
                };
                let Some(Zero { at, located: found }) = zero else { break };
                located.extend(found.map(|found| (passed + at, found)));
                // On from just behind it.
                let behind = at + BEHIND * length;
                if behind >= length {
                    break;
                }
                point = self.branch.step(&point, behind)?;
                seen = self.look(&point)?;
                passed += behind;
            }
        }
        located.sort_by(|one, other| one.0.total_cmp(&other.0));
        let mut last = None;
        for (at, found) in located {
            // Between two events there is something to see, however near to each other they are.
            let middle = last.filter(|_| self.whole).map(|last: f64| self.branch.step(from.0, 0.5 * (last + at)));
            self.passed.extend(middle.and_then(Result::ok).map(Passed::Point));
            self.passed.push(Passed::Event(found));
            last = Some(at);
        }
        Ok(())
    }

    /// The first zero between two neighbouring points, and the event there if it is one.
    fn between(
        &mut self,
        event: Event,
        (point, seen): (&BranchPoint, &Observation),
        (next, next_seen): (&BranchPoint, &Observation),
    ) -> Result<Option<Zero>, LocateError> {
        let length = self.branch.length_between(point, next);
        let changes = |a: f64, b: f64| (a > 0.0) != (b > 0.0);
        let mut found: Option<(f64, Test)> = None;
        match event {
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
            Event::Pitchfork | Event::PeriodDoubling => match shift_of(event, point.orbit()) {
                None if changes(seen.equations, next_seen.equations) => {
                    let s =
                        self.zero_of(Test::Equations, point, (0.0, seen.equations), (length, next_seen.equations))?;
                    found = Some((s, Test::Equations));
                }
                Some(shift) => {
                    if let (Some((log, low)), Some(high)) = (seen.determinant(event), next_seen.determinant(event)) {
                        let test = Test::Shifted { shift, log };
                        if changes(low, high.1) {
                            let high = (length, high.1 * (high.0 - log).exp());
                            found = Some((self.zero_of(test, point, (0.0, low), high)?, test));
                        }
                    }
                }
                None => {}
            },
        }
        let Some((at, test)) = found else { return Ok(None) };
        Ok(Some(Zero { at, located: self.settle(event, point, length, (at, test))? }))
    }

    pub(super) fn zero_of(
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
    pub(super) fn value(&mut self, test: Test, point: &BranchPoint, s: f64) -> Result<f64, LocateError> {
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
                let (logarithm, sign) = regular_determinant(orbit, self.analyser.dense.matrix_of(orbit), shift);
                sign * (logarithm - log).exp()
            }
            Test::Modulus { ends: [(a, from), (b, to)] } => {
                let multiplier = self.followed([(a, from), (b, to)], orbit, s)?.ok_or_else(lost)?;
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

    /// The multiplier that goes from one value to another, on its way.
    pub(super) fn followed(
        &mut self,
        [(a, from), (b, to)]: [(f64, Complex<f64>); 2],
        orbit: &Orbit,
        s: f64,
    ) -> Result<Option<Complex<f64>>, LocateError> {
        let expected = from + (to - from) * ((s - a) / (b - a));
        // An impact without speed has a matrix that tells nothing, but hardly moves the pair.
        if orbit.impact_site().is_some()
            && let Some(found) = Polisher::new(orbit, &mut self.finder)?.polished(expected, (to - from).norm())
        {
            return Ok(Some(found));
        }
        let pairs = self.pairs_told(orbit)?;
        let values: Vec<_> = pairs.iter().map(|pair| pair.0).collect();
        let nearest = follow(expected, &values);
        Ok(nearest.filter(|nearest| pairs.contains(&(*nearest, true))))
    }

    /// The first pair that crosses the circle in a step, where there are losses.
    fn crossing(
        &mut self,
        point: &BranchPoint,
        length: f64,
        seen: &Observation,
        next_seen: &Observation,
    ) -> Result<Option<(f64, Test)>, LocateError> {
        let mut parts = vec![(0.0, seen.values.clone(), length, next_seen.values.clone(), 0)];
        let mut first = None;
        while let Some((low, from, high, to, depth)) = parts.pop() {
            match crossing(&from, &to) {
                Crossing::None => continue,
                Crossing::Pair(inside, outside) => {
                    let test = Test::Modulus { ends: [(low, inside), (high, outside)] };
                    let at = |s: f64, value: Complex<f64>| (s, value.norm_sqr() - 1.0);
                    match self.zero_of(test, point, at(low, inside), at(high, outside)) {
                        Ok(s) => {
                            // Of several it need not be the first. What lies behind it is looked at later.
                            first = Some((s, test));
                            parts.clear();
                            let before = s - BEFORE * (s - low);
                            if depth < HALVINGS && before > low {
                                let there = self.branch.step(point, before)?;
                                let values = self.pairs(there.orbit())?;
                                parts.push((low, from, before, values, depth + 1));
                            }
                            continue;
                        }
                        // On its way it could not be told from the circle; from nearer points it may.
                        Err(LocateError::Floquet(_)) => {}
                        // Right at the end of what the parameter may be: beyond it there is nothing to cross to.
                        Err(LocateError::Branch(BranchError::Breather(BreatherError::Parameter(_)))) => {}
                        Err(error) => return Err(error),
                    }
                }
                Crossing::Unclear => {}
            }
            if depth < HALVINGS {
                let middle = 0.5 * (low + high);
                let there = match self.branch.step(point, middle) {
                    Err(BranchError::Breather(BreatherError::Parameter(_))) => continue,
                    there => there?,
                };
                let between = self.pairs(there.orbit())?;
                parts.push((middle, between.clone(), high, to, depth + 1));
                parts.push((low, from, middle, between, depth + 1));
            }
        }
        Ok(first)
    }
}

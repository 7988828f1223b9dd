//! From a zero to an answer: whether it is an event, its error, and what there is to say about it.

use nalgebra::Complex;
use vibrochain_breather::{Branch, BranchPoint, Pace};
use vibrochain_lattice::Parameter;

use super::answer::{Event, Evidence, LocateError, Located, Unresolved};
use super::follower::Follower;
use super::watch::Test;
use crate::bracket::{DATA_ROUNDING, JUMP, SAFETY, SAMPLE_STEP, spread};
use crate::verdict::{Tolerance, Verdict};
use crate::zeros::Nu;

/// A multiplier farther than this from where it should be is not the zero of the function but a pole.
const POLE: f64 = 1e-4;

/// Points to each side at which the function's rounding is sampled.
const SAMPLES: i32 = 4;

/// A loss that damps pairs by no more than a thousand roundings of a multiplier, of matrices whose norm is as large as a million.
const LEAST_LOSS: f64 = 1e-9;

/// Where both sides of a zero have one sign, they are looked at this much closer.
const CLOSER: f64 = 0.03;

/// The relative step by which the effect of rounding of the data is seen.
const DATA_STEP: f64 = 1e-7;

/// A small step away from an event, as a part of the parameter.
const AWAY: f64 = 1e-4;

/// How well the zero of a function is known.
pub(super) enum Known {
    /// To this error of the parameter.
    To(f64),
    /// The function does not change its sign, or jumps.
    NoZero,
    /// It changes its sign, but rounding hides where.
    NotResolved,
}

impl Follower {
    /// The event at `s` along a step: checked, with its error. `None` for a pole or another false alarm.
    pub(super) fn settle(
        &mut self,
        event: Event,
        point: &BranchPoint,
        length: f64,
        (s, test): (f64, Test),
    ) -> Result<Option<Located>, LocateError> {
        let there = self.branch.step(point, s)?;
        let sign = match test {
            Test::Impact(i) => Evidence::Impact(i),
            Test::Margin => match self.finder.admissibility(there.orbit())?.closest {
                Some(closest) => Evidence::Touch(closest),
                None => return Ok(None),
            },
            Test::Equations => self.nearest_to(&there, Complex::new(1.0, 0.0))?,
            Test::Shifted { shift, .. } => self.nearest_to(&there, Complex::new(-shift, 0.0))?,
            Test::Modulus { ends } => match self.followed(ends, there.orbit(), s)? {
                Some(multiplier) => Evidence::Multiplier(multiplier),
                None => return Ok(None),
            },
            Test::Collision { centre } => {
                let angle = centre.clamp(-1.0, 1.0).acos();
                self.nearest_to(&there, Complex::from_polar(1.0, angle))?
            }
        };
        if let Evidence::Multiplier(multiplier) = sign {
            let goal = match test {
                Test::Modulus { .. } => multiplier / multiplier.norm(),
                Test::Collision { centre } => Complex::from_polar(1.0, centre.clamp(-1.0, 1.0).acos()),
                Test::Shifted { shift, .. } => Complex::new(-shift, 0.0),
                _ => Complex::new(1.0, 0.0),
            };
            if !self.is_at(sign, goal, &there)? {
                return Ok(None);
            }
        }
        match self.error(point, length, s, test, &there)? {
            Known::To(error) => self.describe(event, &there, error, sign).map(Some),
            // Both sides of a collision have been seen: it is there, but too thin a stripe for its digits.
            Known::NoZero if !matches!(test, Test::Collision { .. }) => Ok(None),
            Known::NoZero | Known::NotResolved => {
                let (low, high) = if length < s { (s - length, s + length) } else { (0.0, length) };
                let ends = [low, high].map(|s| self.branch.step(point, s).map_or(there.value(), |end| end.value()));
                self.unresolved.push(Unresolved { from: ends[0].min(ends[1]), to: ends[0].max(ends[1]) });
                Ok(None)
            }
        }
    }

    /// Whether the multiplier told is where it should be.
    pub(super) fn is_at(
        &self,
        evidence: Evidence,
        goal: Complex<f64>,
        point: &BranchPoint,
    ) -> Result<bool, LocateError> {
        let Evidence::Multiplier(multiplier) = evidence else { return Ok(false) };
        // Written so that a multiplier that is not a number is no event either.
        Ok((multiplier - goal).norm() <= POLE * (1.0 + self.analyser_norm(point)?.ln()))
    }

    /// Norm of the matrix whose eigenvalues were last worked out.
    pub(super) fn analyser_norm(&self, point: &BranchPoint) -> Result<f64, LocateError> {
        Ok(self.analyser.dense.matrix_of(point.orbit()).norm().max(1.0))
    }

    /// The multiplier nearest to `goal`.
    pub(super) fn nearest_to(&mut self, point: &BranchPoint, goal: Complex<f64>) -> Result<Evidence, LocateError> {
        let orbit = point.orbit();
        let values = self.spectrum(orbit)?;
        let multipliers = values.iter().flat_map(|&value| {
            let [large, small] = if orbit.is_reversible() { Nu::of(value).multipliers() } else { [value, value] };
            [large, small]
        });
        let nearest = multipliers.min_by(|a, b| (a - goal).norm_sqr().total_cmp(&(b - goal).norm_sqr()));
        nearest.map(Evidence::Multiplier).ok_or(LocateError::NoMultiplier)
    }

    /// Error of the parameter at a zero: rounding of the function and of the parameter along the curve, as samples show
    /// them, over the function's slope.
    pub(super) fn error(
        &mut self,
        point: &BranchPoint,
        length: f64,
        s: f64,
        test: Test,
        there: &BranchPoint,
    ) -> Result<Known, LocateError> {
        // With so little loss all pairs are about as near to the circle as rounding brings them: which of them crosses it, nothing tells.
        let loss = there.orbit().model().loss();
        if matches!(test, Test::Modulus { .. }) && loss > 0.0 && loss < LEAST_LOSS {
            return Ok(Known::NotResolved);
        }
        let mut samples = Vec::new();
        for k in -SAMPLES..=SAMPLES {
            let at = s + f64::from(k) * SAMPLE_STEP.min(1e-3 * length);
            // Past the end of the parameter's range there are none.
            let Ok(sample) = self.branch.step(point, at) else { continue };
            samples.push((at - s, self.value(test, &sample, at)?, sample.value()));
        }
        let reach = 1e-3 * length;
        let mut side = |at: f64| -> Result<(f64, f64), LocateError> {
            let sample = self.branch.step(point, at)?;
            Ok((self.value(test, &sample, at)?, sample.value()))
        };
        let (mut reach, mut below, mut above) = (reach, side(s - reach), side(s + reach));
        let same = |below: &Result<(f64, f64), _>, above: &Result<(f64, f64), _>| match (below, above) {
            (Ok((below, _)), Ok((above, _))) => (*below > 0.0) == (*above > 0.0),
            // One-sided next to such an end.
            _ => false,
        };
        if same(&below, &above) {
            // Another zero may be as near.
            reach *= CLOSER;
            (below, above) = (side(s - reach), side(s + reach));
            if same(&below, &above) {
                let size = |side: &Result<(f64, f64), _>| side.as_ref().map_or(0.0, |(value, _)| value.abs());
                let noise = spread(samples.iter().map(|sample| sample.1));
                // In a step as short as rounding neither side tells.
                let hidden = size(&below).max(size(&above)) <= SAFETY * noise;
                return Ok(if hidden { Known::NotResolved } else { Known::NoZero });
            }
        }
        let (from, to) = (if below.is_ok() { s - reach } else { s }, if above.is_ok() { s + reach } else { s });
        let (low, high) = (below.or_else(|_| side(s))?, above.or_else(|_| side(s))?);
        // A pair that was taken for another one makes a jump, an impulse that vanishes a pole of the determinant: no zeros.
        let here = self.value(test, there, s)?.abs();
        let (slope, pace) = ((high.0 - low.0) / (to - from), (high.1 - low.1) / (to - from));
        // Departures from the straight line through their mean.
        let scatter = |of: fn(&(f64, f64, f64)) -> f64, slope: f64| {
            spread(samples.iter().map(|sample| of(sample) - slope * sample.0))
        };
        let (of_value, of_parameter) = (scatter(|sample| sample.1, slope), scatter(|sample| sample.2, pace));
        // What rounding leaves at the zero is no jump.
        if here > JUMP * low.0.abs().max(high.0.abs()) && here > SAFETY * of_value {
            return Ok(Known::NoZero);
        }
        // Rounding that all samples share, such as that of the period, is a change of the data.
        let data = self.sensitivity(s, test, there)?;
        let along = (SAFETY * of_value + DATA_ROUNDING * data) / slope.abs();
        // Not a number is no claim, either.
        Ok(if along <= to - from {
            Known::To(along * pace.abs() + SAFETY * of_parameter + DATA_ROUNDING * there.value().abs())
        } else {
            Known::NotResolved
        })
    }

    /// Σ |p ∂/∂p| of the function over all other parameters p of the model.
    pub(super) fn sensitivity(&mut self, s: f64, test: Test, there: &BranchPoint) -> Result<f64, LocateError> {
        let (orbit, here) = (there.orbit(), self.value(test, there, s)?);
        let mut sum = 0.0;
        for parameter in Parameter::ALL {
            let value = orbit.model().get(parameter);
            let absent =
                orbit.model().is_conservative() && matches!(parameter, Parameter::Amplitude | Parameter::Restitution);
            if parameter == self.free || value == 0.0 || absent {
                continue;
            }
            // Downwards: restitution may be 1.
            let step = DATA_STEP * value;
            let mut across = Branch::through(orbit, parameter, value)?.until(self.stop());
            // Where the change breaks a symmetry there is no such orbit at a pitchfork, nor rounding that would do it.
            let moved = across.start().and_then(|start| across.at(&start, value - step));
            self.others += across.evaluations();
            let Ok(moved) = moved else { continue };
            sum += (self.value(test, &moved, s)? - here).abs() / DATA_STEP;
        }
        Ok(sum)
    }

    /// The answer at a point.
    pub(super) fn describe(
        &mut self,
        event: Event,
        there: &BranchPoint,
        error: f64,
        evidence: Evidence,
    ) -> Result<Located, LocateError> {
        let verdicts = self.verdicts(there);
        let physical = self.finder.admissibility(there.orbit()).ok().map(|answer| answer.is_physical());
        let distance = AWAY * there.value().abs().max(1e-2 * self.range());
        let branching = self.branch_off(event, there.orbit(), distance);
        Ok(Located {
            event,
            value: there.value(),
            error,
            orbit: there.orbit().clone(),
            evidence,
            physical,
            verdicts,
            branching,
            evaluations: self.evaluations(),
        })
    }

    /// Verdicts a small step away on either side, of those that exist and can be judged.
    pub(super) fn verdicts(&mut self, there: &BranchPoint) -> Vec<(f64, Verdict)> {
        let mut verdicts = Vec::new();
        for sign in [-1.0, 1.0] {
            // Along the curve: at a fold both sides lie on one side in the parameter.
            let Ok(side) = self.branch.step(there, sign * 1e-2 * Pace::LONGEST) else { continue };
            if let Ok(verdict) = self.analyser.verdict(side.orbit(), &mut self.finder, Tolerance::Rounding) {
                verdicts.push((side.value(), verdict));
            }
        }
        verdicts.sort_by(|a, b| a.0.total_cmp(&b.0));
        verdicts
    }
}

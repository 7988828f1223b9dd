//! Events beside a resonance. There derivatives by the parameter and by the orbit's unknowns are large and nearly cancel along the branch, so that
//! Newton's method in all unknowns stops too early. A second Newton's method, in the length along the branch, takes over: its one derivative has
//! nothing to cancel.

use vibrochain_breather::BranchPoint;
use vibrochain_breather::system::{System, Vector};

use super::Follower;
use crate::events::{AtEvent, Solved, Test, room, without_poles};

/// Steps at most; three are usual.
const STEPS: usize = 8;

/// The difference along the branch moves the parameter by this part of what multipliers are off the resonance, and is no longer than this.
const SHARE: f64 = 1e-2;
const LONGEST: f64 = 1e-4;

/// The difference of a mark.
const MARK: f64 = 1e-6;

impl Follower {
    /// The same event, along the branch from `from`; as it is where no resonance is near.
    pub(super) fn beside_resonance(&mut self, test: Test, from: &BranchPoint, solved: Solved) -> Option<Solved> {
        let AtEvent { orbit, mark, .. } = &solved.at;
        if matches!(test, Test::One | Test::Fold) || without_poles(orbit, None).1.is_empty() {
            return Some(solved);
        }
        let room = room(orbit, mark.filter(|_| test.is_marked() && !matches!(test, Test::Touch(..))).unwrap_or(0.0));
        let (mut s, mut mark, mut last) = (self.length_to(from, &solved), *mark, f64::INFINITY);
        for _ in 0..STEPS {
            let heading = self.branch.step(from, s).ok()?.heading().abs().max(f64::EPSILON);
            let h = (SHARE * room * solved.value.abs() / (heading * self.range())).min(LONGEST);
            let here = self.tested(test, from, s, mark)?;
            let slope = difference(&self.tested(test, from, s - h, mark)?, &self.tested(test, from, s + h, mark)?, h);
            let (along, turned) = if let Some(at) = mark {
                let [low, high] = [at - MARK, at + MARK].map(|at| self.tested(test, from, s, Some(at)));
                let turn = difference(&low?, &high?, MARK);
                let determinant = slope[0] * turn[1] - slope[1] * turn[0];
                (
                    (here[0] * turn[1] - here[1] * turn[0]) / determinant,
                    (slope[0] * here[1] - slope[1] * here[0]) / determinant,
                )
            } else {
                (here[0] / slope[0], 0.0)
            };
            if !(along.is_finite() && turned.is_finite()) {
                return None;
            }
            (s, mark) = (s - along, mark.map(|at| at - turned));
            let shrinks = along.abs() < 0.5 * last;
            last = along.abs();
            if last <= f64::EPSILON || !shrinks {
                break;
            }
        }
        let point = self.branch.step(from, s).ok()?;
        // The last step is what rounding has left.
        let error = solved.error.max(last * point.heading().abs() * self.range());
        let at = AtEvent { orbit: point.orbit().clone(), mark, ..solved.at };
        Some(Solved { at, coordinates: point.coordinates().into(), value: point.value(), error })
    }

    fn tested(&mut self, test: Test, from: &BranchPoint, s: f64, mark: Option<f64>) -> Option<Vector> {
        let point = self.branch.step(from, s).ok()?;
        let here = self.branch.system().evaluate(point.coordinates()).ok()?;
        Some(test.values(&here, mark).ok()?.into_iter().collect())
    }
}

fn difference(low: &[f64], high: &[f64], h: f64) -> Vec<f64> {
    high.iter().zip(low).map(|(high, low)| (high - low) / (2.0 * h)).collect()
}

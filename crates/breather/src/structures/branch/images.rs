//! Whether an orbit is its own mirror image, and how far it is from that.

use super::reduction::IMAGE;
use crate::equations::linear::dot;
use crate::orbit::{Impact, time_between};
use crate::structures::orbit::ContactOrbit;

impl ContactOrbit {
    /// Whether what happens half a period later differs from what happens now the other way round than along `other`: between the two is an orbit
    /// that repeats or mirrors itself, if they are neighbours on one branch.
    pub fn is_across(&self, other: &Self) -> bool {
        dot(&self.unevenness(), &other.unevenness()) < 0.0
    }

    /// Whether what an impact does at one barrier its image may do at the other: all of them are as far from 0.
    pub fn is_centred(&self) -> bool {
        self.model().structure().contacts().iter().all(|contact| contact.lower == contact.upper.map(|upper| -upper))
    }

    /// Impulses and flights half the impacts later, less those now, as parts of the strongest and of the period: 0 of an orbit that repeats or
    /// mirrors itself. Where the second half hits the other barriers, and these are not as far away, time alone can mirror it: then of flights
    /// alone. None of an odd number of impacts.
    pub fn unevenness(&self) -> Vec<f64> {
        let (impacts, half) = (self.impacts(), self.impacts().len() / 2);
        if impacts.len() % 2 == 1 {
            return Vec::new();
        }
        let strongest = impacts.iter().map(|impact| impact.impulse.abs()).fold(f64::MIN_POSITIVE, f64::max);
        let end = |i: usize| impacts.get(i + 1).map_or(self.period(), |next| next.time);
        let flight = |i: usize| (end(i) - impacts[i].time) / self.period();
        let (one, other) = impacts.split_at(half);
        let alike = self.is_centred() || one.iter().zip(other).all(|(a, b)| a.barrier == b.barrier);
        let pairs = if alike { half } else { 0 };
        let impulses = (0..pairs).map(|i| (impacts[i + half].impulse.abs() - impacts[i].impulse.abs()) / strongest);
        impulses.chain((0..half).map(|i| flight(i + half) - flight(i))).collect()
    }
}

/// Whether an orbit is its own mirror image: half a period later it hits the opposite barriers with opposite impulses, or, without loads and losses,
/// it is the same backwards in time.
pub(super) fn is_own_image(orbit: &ContactOrbit) -> bool {
    let (impacts, period) = (orbit.impacts(), orbit.period());
    let alike = |one: &Impact, other: &Impact, sign: f64, time: f64| {
        one.site == other.site
            && (one.barrier == other.barrier) == (sign > 0.0)
            && time_between(other.time, time, period) <= IMAGE * period
            && (one.impulse - sign * other.impulse).abs() <= IMAGE * one.impulse.abs()
    };
    let holds = |sign: f64, of: &dyn Fn(f64) -> f64| {
        impacts.iter().all(|one| impacts.iter().any(|other| alike(one, other, sign, of(one.time))))
    };
    holds(-1.0, &|time| time + 0.5 * period)
        || orbit.is_conservative() && impacts.iter().any(|about| holds(1.0, &|time| about.time - time))
}

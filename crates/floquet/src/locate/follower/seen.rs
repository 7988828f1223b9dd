//! What is seen at a point of a branch, and what that tells of the step to the next one.

use vibrochain_breather::{Admissibility, BranchPoint, ContactOrbit, Hit};

use super::{At, Follower, Seen};
use crate::events::Order;
use crate::events::half_sums::upper_half;
use crate::events::{Test, another_one, minus_one};
use crate::locate::answer::{Event, LocateError};

impl Follower {
    /// What is to be known of a point.
    pub(crate) fn look(&mut self, point: &BranchPoint) -> Result<Seen, LocateError> {
        let orbit = point.orbit();
        let mut seen = Seen::default();
        if self.watches(Event::Grazing) {
            seen.velocities = velocities(orbit);
            seen.admissibility = Some(self.watcher.admissibility(orbit)?);
        }
        if self.watches(Event::Sticking) {
            seen.releases = releases(orbit);
        }
        if self.watches(Event::PeriodDoubling) {
            seen.minus_one = Some(minus_one(orbit)?);
        }
        if self.watches(Event::Pitchfork) {
            seen.another_one = another_one(orbit);
        }
        // Signatures tell of thin stripes of any kind.
        let lossless = orbit.is_lossless();
        let signed = lossless && (seen.minus_one.is_some() || seen.another_one.is_some());
        let watched = self.watches(Event::NeimarkSacker) || signed;
        if watched {
            (seen.values, seen.verdict) = self.watcher.spectrum(orbit, self.stretch.tolerance)?;
        }
        if lossless && watched {
            let mut off = upper_half(&seen.values);
            off.sort_by(|a, b| a.re.total_cmp(&b.re));
            seen.openings = off.iter().map(|nu| nu.im * nu.im).collect();
            seen.order = Order::of_orbit(orbit, &seen.values);
        }
        Ok(seen)
    }

    /// A test function of one value at a point.
    pub(super) fn read(&mut self, test: Test, point: &BranchPoint) -> Option<f64> {
        match test {
            Test::Velocity(i) => velocities(point.orbit()).get(i).copied(),
            Test::Release(i) => releases(point.orbit()).get(i).copied().flatten(),
            Test::Touch(..) | Test::Corner(..) => Some(margin(&self.watcher.admissibility(point.orbit()).ok()?)),
            Test::MinusOne => minus_one(point.orbit()).ok(),
            Test::AnotherOne => another_one(point.orbit()),
            _ => value(test, (point, &Seen::default())),
        }
    }
}

/// The velocity before each impact, towards its barrier.
pub(super) fn velocities(orbit: &ContactOrbit) -> Vec<f64> {
    orbit.impacts().iter().map(|impact| impact.barrier.sign() * impact.velocity_before).collect()
}

/// The acceleration after each plastic impact, away from its barrier; `None` of others.
pub(super) fn releases(orbit: &ContactOrbit) -> Vec<Option<f64>> {
    let of = |(i, hit): (usize, Hit)| {
        let [acceleration, _] = orbit.acceleration_after(i).ok()??;
        Some(-hit.barrier.sign() * acceleration)
    };
    orbit.hits().into_iter().enumerate().map(of).collect()
}

/// An impact that turned its sign has no margin: beyond grazing.
fn margin(told: &Admissibility) -> f64 {
    told.margin.unwrap_or(-1.0)
}

/// The value of a test function at a point, where it is one number that changes its sign.
pub(super) fn value(test: Test, (point, seen): At<'_>) -> Option<f64> {
    match test {
        Test::Fold => Some(point.fold_determinant()),
        Test::One => Some(point.determinant()),
        Test::AnotherOne => seen.another_one,
        Test::MinusOne => seen.minus_one,
        Test::Velocity(i) => seen.velocities.get(i).copied(),
        Test::Release(i) => seen.releases.get(i).copied().flatten(),
        Test::Touch(..) | Test::Corner(..) => seen.admissibility.as_ref().and_then(|told| told.margin),
        Test::Circle | Test::Collision => None,
    }
}

/// Whether a test function changes its sign between two points.
pub(super) fn changes(test: Test, from: At<'_>, to: At<'_>) -> bool {
    let values = (value(test, from), value(test, to));
    matches!(values, (Some(a), Some(b)) if (a > 0.0) != (b > 0.0))
}

/// What touches where the least distance changes its sign.
pub(super) fn touch_between(from: At<'_>, to: At<'_>) -> Option<Test> {
    let margin = |at: At<'_>| at.1.admissibility.as_ref()?.margin;
    let (before, after) = (margin(from)?, margin(to)?);
    let beyond = if before <= 0.0 { from.1 } else { to.1 };
    let closest = beyond.admissibility.as_ref()?.closest;
    let touch = closest.filter(|_| (before > 0.0) != (after > 0.0))?;
    Some(Test::Touch(touch.site, touch.barrier))
}

/// Where the contact that is closest to its barrier between two points is turned round by another one's impact.
pub(super) fn corners(ends: [At<'_>; 2]) -> impl Iterator<Item = Test> {
    let of = |(point, seen): At<'_>| Test::corner(&seen.admissibility.as_ref()?.closest?, point.orbit());
    ends.into_iter().filter_map(of)
}

/// Marks by which a touch between two points may be found, the likeliest first.
pub(super) fn marks(test: Test, ends: [At<'_>; 2]) -> Vec<Option<f64>> {
    let Test::Touch(site, barrier) = test else { return vec![None] };
    let of = |(point, seen): At<'_>| {
        let closest = seen.admissibility.as_ref()?.closest;
        let closest = closest.filter(|one| (one.site, one.barrier) == (site, barrier))?;
        Some(Some(closest.time / point.orbit().period()))
    };
    ends.into_iter().filter_map(of).collect()
}

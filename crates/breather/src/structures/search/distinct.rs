//! Which orbits of a list are one, and which are orbits of its word at all: all by their errors to first order,
//! which are there where no bound is known, too.

use crate::orbit::{Impact, time_between};
use crate::structures::orbit::ContactOrbit;

/// Rounding of a number that is not solved for, as the time from an impact to itself: sums and differences of a few times.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

impl ContactOrbit {
    /// The impact of another orbit from which on it is this one: nothing of them differs by more than their errors. `None` of two orbits.
    pub(in crate::structures) fn begun_at(&self, other: &Self) -> Option<usize> {
        (0..other.impacts().len()).find(|turn| self.is_same_from(other, *turn))
    }

    /// The same with the other orbit begun at its impact number `turn`.
    fn is_same_from(&self, other: &Self, turn: usize) -> bool {
        let (period, n) = (self.period(), other.impacts().len());
        let start = &other.impacts()[turn];
        let within = |apart: f64, errors: f64| apart <= errors + ROUNDING * period;
        let psi = match (self.psi(), other.psi()) {
            (Some(own), Some(psi)) => within(
                time_between(own, psi + start.time, self.model().loads_repeat()),
                self.psi_estimate() + other.psi_estimate() + other.estimate(turn).time,
            ),
            _ => true,
        };
        let periods = within((period - other.period()).abs(), self.period_error() + other.period_error());
        psi && periods
            && (0..n).all(|i| {
                let (place, own) = ((i + turn) % n, &self.impacts()[i]);
                let [one, two] = [self.estimate(i), other.estimate(place)];
                let errors = [one.impulse + two.impulse, one.time + two.time];
                are_alike(own, &other.impacts()[place], errors[0])
                    && within(
                        time_between(own.time, other.impacts()[place].time - start.time, period),
                        errors[1] + other.estimate(turn).time,
                    )
            })
    }

    /// Whether it is an orbit of fewer periods, gone through several times.
    pub(super) fn repeats_sooner(&self) -> bool {
        let (impacts, n) = (self.impacts(), self.impacts().len());
        // Without loads any part of the period may be one.
        let repeats = (self.period() / self.model().loads_repeat()).round() as usize;
        let parts = |part: usize| n.is_multiple_of(part) && (self.psi().is_none() || repeats.is_multiple_of(part));
        (2..=n).filter(|&part| parts(part)).any(|part| {
            let (shift, lapse) = (n / part, self.period() / part as f64);
            (0..n).all(|i| {
                let (place, own) = ((i + shift) % n, &impacts[i]);
                let [one, two] = [self.estimate(i), self.estimate(place)];
                let errors = [one.impulse + two.impulse, one.time + two.time];
                let apart = time_between(impacts[place].time, own.time + lapse, self.period());
                are_alike(own, &impacts[place], errors[0]) && apart <= errors[1] + ROUNDING * self.period()
            })
        })
    }

    /// Whether nothing is known of how large its errors are, to first order neither: its equations are singular.
    pub(super) fn is_singular(&self) -> bool {
        (0..self.impacts().len()).any(|i| !(self.estimate(i).impulse + self.estimate(i).time).is_finite())
    }

    /// Whether every impact has an impulse: one that is no larger than its error is none, and the orbit one of fewer impacts.
    pub(super) fn has_impulses(&self) -> bool {
        self.impacts().iter().enumerate().all(|(i, impact)| impact.impulse.abs() > self.estimate(i).impulse)
    }

    /// Whether the impacts come one after the other within the period, farther apart than their errors: else it is an orbit of fewer instants.
    pub(super) fn has_its_instants(&self) -> bool {
        let end = (self.period(), 0.0);
        let times = self.impacts().iter().enumerate().map(|(i, impact)| (impact.time, self.estimate(i).time));
        let later = times.clone().skip(1).chain([end]);
        times.zip(later).all(|((one, own), (time, error))| time - one > own + error)
    }
}

/// Whether two impacts are of one contact on one barrier and their impulses differ by no more than their errors.
fn are_alike(one: &Impact, other: &Impact, errors: f64) -> bool {
    let errors = errors + ROUNDING * one.impulse.abs();
    (one.site, one.barrier) == (other.site, other.barrier) && (one.impulse - other.impulse).abs() <= errors
}

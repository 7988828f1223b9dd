//! Time as whole periods and a rest, so that it keeps its resolution however long a simulation runs.

use vibrochain_lattice::Model;

/// A time since the start: whole periods T = 2π/ω and what is left of the current one.
///
/// The same instant as one number is [`Time::to_f64`]; it loses digits as periods pile up, this does not.
///
/// ```
/// use vibrochain_eventsim::Time;
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(3, 0.2, 0.1)?, 1.5, 0.4)?;
/// let time = Time::new(&model, 7, 0.25);
/// assert_eq!(time.periods(), 7);
/// assert!((time.to_f64() - 7.25 * model.period()).abs() < 1e-14);
/// # Ok::<(), vibrochain_lattice::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[must_use]
pub struct Time {
    periods: u64,
    offset: f64,
    period: f64,
}

impl Time {
    /// `periods` whole periods of `model` and the `part` of one more (0 ≤ `part` < 1; anything else is brought
    /// there by whole periods, a time before the start becomes the start).
    pub fn new(model: &Model, periods: u64, part: f64) -> Self {
        Self::of_period(model.period(), periods, part)
    }

    /// The same of any `period`: that of the loads of a structure.
    pub fn of_period(period: f64, periods: u64, part: f64) -> Self {
        let part = if part.is_finite() { part } else { 0.0 };
        let whole = part.floor();
        // Casts saturate: a part beyond every count of periods stays at the last one.
        let shifted =
            if whole < 0.0 { periods.checked_sub((-whole) as u64) } else { Some(periods.saturating_add(whole as u64)) };
        match shifted {
            Some(periods) => Self { periods, offset: (part - whole) * period, period },
            None => Self { periods: 0, offset: 0.0, period },
        }
    }

    pub(crate) fn from_parts(periods: u64, offset: f64, period: f64) -> Self {
        Self { periods, offset, period }
    }

    /// Whole periods.
    pub fn periods(&self) -> u64 {
        self.periods
    }

    /// Time since the last whole period, 0 ≤ offset ≤ T, in the units of 1/ω.
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// The part of the current period that has passed, offset/T.
    pub fn part(&self) -> f64 {
        self.offset / self.period
    }

    /// The time as one number, in periods.
    pub fn in_periods(&self) -> f64 {
        self.periods as f64 + self.part()
    }

    /// The time as one number, in the units of 1/ω.
    pub fn to_f64(&self) -> f64 {
        self.periods as f64 * self.period + self.offset
    }

    /// The time on a clock that shows `start` where the run begins, and 0 at an impact of the breather that it begins on: what rounding
    /// alone tells from 0 is 0.
    pub fn on_clock(&self, start: f64) -> f64 {
        let now = start + self.to_f64();
        if now.abs() <= 64.0 * f64::EPSILON * start.abs() { 0.0 } else { now }
    }
}

/// The running clock, in internal units of time.
///
/// The rest is held in two words and the period in two, so that neither the sum of a million short flights nor
/// the rounding of 2π/ω a million times drifts.
#[derive(Debug, Clone)]
pub(crate) struct Clock {
    periods: u64,
    high: f64,
    low: f64,
    period: f64,
    period_low: f64,
}

/// 2π = TAU + TAU_LOW to 32 digits.
const TAU_LOW: f64 = 2.449_293_598_294_706_4e-16;

/// a + b and its rounding error, exactly (Knuth).
pub(crate) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

impl Clock {
    /// The clock of a forcing frequency `omega` in internal units, at zero.
    pub(crate) fn new(omega: f64) -> Self {
        let period = std::f64::consts::TAU / omega;
        let period_low = ((-period).mul_add(omega, std::f64::consts::TAU) + TAU_LOW) / omega;
        Self { periods: 0, high: 0.0, low: 0.0, period, period_low }
    }

    pub(crate) fn advance(&mut self, step: f64) {
        let (high, rest) = two_sum(self.high, step);
        (self.high, self.low) = two_sum(high, self.low + rest);
        while self.high >= self.period {
            let (high, rest) = two_sum(self.high, -self.period);
            let (high, low) = two_sum(high, self.low + rest - self.period_low);
            if high < 0.0 {
                // The period's second word is not reached yet: the offset is T to the last digit, and stays there.
                break;
            }
            (self.high, self.low) = (high, low);
            self.periods += 1;
        }
    }

    /// Time since the last whole period.
    pub(crate) fn offset(&self) -> f64 {
        self.high
    }

    /// The clock `step` later, as (periods, offset) in internal units.
    pub(crate) fn after(&self, step: f64) -> (u64, f64) {
        let mut later = self.clone();
        later.advance(step);
        (later.periods, later.high)
    }

    /// Internal time from now until (`periods`, `offset`); negative if that has passed.
    pub(crate) fn until(&self, periods: u64, offset: f64) -> f64 {
        let whole =
            if periods >= self.periods { (periods - self.periods) as f64 } else { -((self.periods - periods) as f64) };
        whole * self.period + (offset - self.high) - self.low + whole * self.period_low
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibrochain_lattice::Chain;

    #[test]
    fn ten_million_steps_do_not_drift() {
        // An eighth of the first word of the period is exact, so that 10⁶ periods later only the second word is left.
        let mut clock = Clock::new(1.5);
        let step = 0.125 * clock.period;
        for _ in 0..8_000_000 {
            clock.advance(step);
        }
        let left = clock.until(1_000_000, 0.0);
        assert!((left - 1e6 * clock.period_low).abs() < 2.0 * f64::EPSILON * clock.period, "{left:e} {clock:?}");
        let (periods, offset) = clock.after(3.0);
        assert!((clock.until(periods, offset) - 3.0).abs() < 4.0 * f64::EPSILON * clock.period);
    }

    #[test]
    fn times_are_brought_into_their_period() {
        let model = Model::conservative(Chain::new(1, 1.0, 0.0).unwrap(), 2.0, 0.0).unwrap();
        assert_eq!(Time::new(&model, 3, 1.5), Time::new(&model, 4, 0.5));
        assert_eq!(Time::new(&model, 3, -0.5), Time::new(&model, 2, 0.5));
        assert_eq!(Time::new(&model, 0, -2.0).to_f64(), 0.0);
        assert_eq!(Time::new(&model, 2, f64::NAN).to_f64(), 2.0 * model.period());
    }
}

//! Stroboscopic sections: a state once a period of the force, always at the same phase of it.

use vibrochain_eventsim::Time;
use vibrochain_lattice::Model;

/// The instants of a section along a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strobe {
    period: f64,
    /// Time of the first, in periods since the start: 0 ≤ first < 1.
    first: f64,
}

impl Strobe {
    /// Instants at which t + ψ is a whole number of periods and the part `phase` of one, of a run whose force has the phase `psi` at
    /// its start. Without a force they are as far apart, from wherever.
    ///
    /// ```
    /// use vibrochain_fate::Strobe;
    /// use vibrochain_lattice::Point;
    /// let model = Point::ring(1).gamma1(1.0).gamma2(0.0).omega(2.0).amplitude(0.1).restitution(0.9).model()?;
    /// // The run begins an eighth of a period after the force was greatest.
    /// let strobe = Strobe::new(&model, model.period() / 8.0, 0.0);
    /// assert!((strobe.time(3).part() - 0.875).abs() < 1e-15 && strobe.time(3).periods() == 3);
    /// # Ok::<(), vibrochain_lattice::ParameterError>(())
    /// ```
    #[must_use]
    pub fn new(model: &Model, psi: f64, phase: f64) -> Self {
        Self::of_period(model.period(), psi, phase)
    }

    /// The same under a force of any period: the loads of a structure.
    #[must_use]
    pub fn of_period(period: f64, psi: f64, phase: f64) -> Self {
        let first = (phase - psi / period).rem_euclid(1.0);
        // What rounding puts a hair before the start is at the start; so is a whole period.
        let first = if first > 1.0 - 4.0 * f64::EPSILON { 0.0 } else { first };
        Self { period, first }
    }

    /// The instant number `i`, from 0.
    pub fn time(&self, i: u64) -> Time {
        Time::of_period(self.period, i, self.first)
    }
}

//! From the growth of tangent vectors to an exponent, with an error from the scatter of its parts.

/// Blocks kept at most. Then neighbours become one, and new ones are twice as long: so many for an error, however long a run.
const MOST: usize = 64;

/// Blocks below which nothing is said of an error.
const LEAST: usize = 8;

/// A Lyapunov exponent: rate of growth of a perturbation, in a unit of time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Exponent {
    /// Growth over the whole run, divided by its time.
    pub value: f64,
    /// Standard error of that mean, from 32 to 64 equal parts of the run (fewer of a short one). It takes them to be independent,
    /// which parts longer than the memory of the motion are; of one that settles it tells how far that has come.
    pub error: f64,
    /// The time.
    pub time: f64,
}

/// The growth of a perturbation along a run, told at equal steps of time.
///
/// ```
/// use vibrochain_eventsim::Growth;
/// let mut growth = Growth::default();
/// for step in 1..=1000 {
///     // Doubles every second, and wobbles.
///     let time = f64::from(step);
///     growth.reach(time, time * 2f64.ln() + time.sin());
/// }
/// let exponent = growth.exponent().ok_or("too short")?;
/// assert!((exponent.value - 2f64.ln()).abs() < 2e-3 && exponent.error < 2e-2);
/// # Ok::<(), &'static str>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Growth {
    /// Growth and time of whole blocks.
    blocks: Vec<[f64; 2]>,
    /// Steps of a block, as a power of two.
    doublings: u32,
    /// Steps of the block under way.
    steps: u64,
    /// Growth and time at the last whole block, and now.
    begun: [f64; 2],
    now: [f64; 2],
    /// Where it all began.
    start: [f64; 2],
}

impl Growth {
    /// Of a run that begins at `time` with the logarithm `log` of its growth; [`Growth::default`] begins at 0 with 0.
    #[must_use]
    pub fn from(time: f64, log: f64) -> Self {
        let start = [log, time];
        Self { start, begun: start, now: start, ..Self::default() }
    }

    /// At `time`, one step later, the logarithm of the growth is `log`.
    pub fn reach(&mut self, time: f64, log: f64) {
        self.now = [log, time];
        self.steps += 1;
        if self.steps < 1 << self.doublings {
            return;
        }
        self.blocks.push([log - self.begun[0], time - self.begun[1]]);
        (self.begun, self.steps) = (self.now, 0);
        if self.blocks.len() == MOST {
            self.blocks = self.blocks.chunks(2).map(|pair| [0, 1].map(|i| pair.iter().map(|b| b[i]).sum())).collect();
            self.doublings += 1;
        }
    }

    /// Logarithm of the growth so far.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.now[0] - self.start[0]
    }

    /// The exponent; none of fewer than eight steps, of no time, or where the growth is not finite.
    #[must_use]
    pub fn exponent(&self) -> Option<Exponent> {
        let time = self.now[1] - self.start[1];
        let value = self.total() / time;
        let count = self.blocks.len();
        if count < LEAST || !(time > 0.0 && value.is_finite()) {
            return None;
        }
        let n = count as f64;
        let rates = || self.blocks.iter().map(|[growth, time]| growth / time);
        let mean = rates().sum::<f64>() / n;
        let scatter = rates().map(|rate| (rate - mean).powi(2)).sum::<f64>();
        Some(Exponent { value, error: (scatter / (n * (n - 1.0))).sqrt(), time })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::spread;

    #[test]
    fn the_error_is_that_of_the_mean_whatever_the_length() {
        for steps in [20_u32, 63, 64, 65, 1000, 20_000] {
            // Many runs of independent steps: their exponents scatter as each of them says.
            let (mut seed, runs) = (u64::from(steps), 200);
            let (mut said, mut found) = (0.0, 0.0);
            for _ in 0..runs {
                let (mut growth, mut log) = (Growth::from(3.0, 5.0), 5.0);
                for step in 1..=steps {
                    log += 0.1 + spread(&mut seed);
                    growth.reach(3.0 + f64::from(step), log);
                }
                let exponent = growth.exponent().unwrap();
                assert_eq!(exponent.time, f64::from(steps));
                assert!((growth.total() - 0.1 * f64::from(steps)).abs() < 4.0 * f64::from(steps).sqrt());
                said += exponent.error.powi(2);
                found += (exponent.value - 0.1).powi(2);
            }
            let ratio = (said / found).sqrt();
            assert!((0.8..1.25).contains(&ratio), "{steps}: {ratio}");
            // Uniform in −1 … 1: variance 1/3.
            let expected = (1.0 / (3.0 * f64::from(steps))).sqrt();
            assert!(((found / f64::from(runs)).sqrt() / expected - 1.0).abs() < 0.25);
        }
    }

    #[test]
    fn nothing_is_said_of_what_is_too_short_or_not_finite() {
        let mut growth = Growth::default();
        for step in 1..LEAST {
            growth.reach(step as f64, 1.0);
            assert_eq!(growth.exponent(), None);
        }
        growth.reach(8.0, f64::NEG_INFINITY);
        assert_eq!(growth.exponent(), None);
    }
}

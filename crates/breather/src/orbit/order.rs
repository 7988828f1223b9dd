//! The order of orbits in every list: by φ, then by ψ.

use std::cmp::Ordering;

/// Steps of a period, a power of two. Times that differ by rounding alone are in one step; those that symmetry gives, halves and thirds of the
/// period, lie within a step, not at its end.
const STEPS: u64 = 1 << 30;

/// What decides where an orbit stands in a list.
pub(crate) struct Listed<I> {
    pub(crate) period: f64,
    /// The times of its impacts, from the first one on.
    pub(crate) times: I,
    /// The phase of the force.
    pub(crate) psi: Option<f64>,
}

impl<I: Iterator<Item = f64>> Listed<I> {
    /// By the times of the impacts after the first one, by the phase, then by the period, which differs where it is the orbit's own.
    pub(crate) fn compare(self, other: Self) -> Ordering {
        let (own, others) = (self.period, other.period);
        self.steps().cmp(other.steps()).then(own.total_cmp(&others))
    }

    /// The steps that the times are in; the end of a period is its beginning.
    fn steps(self) -> impl Iterator<Item = u64> {
        let scale = STEPS as f64 / self.period;
        self.times.skip(1).chain(self.psi).map(move |time| (time * scale + 0.5) as u64 % STEPS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half a period is one time however it is rounded, and a phase of a whole period is none.
    #[test]
    fn rounding_of_times_does_not_decide() {
        let half = 3.0f64;
        let mut list = [
            (half * (1.0 + 4.0 * f64::EPSILON), 1.0),
            (half, 2.0),
            (half * (1.0 - 4.0 * f64::EPSILON), 3.0),
            (2.0, 5.0),
            (half, 6.0 * (1.0 - f64::EPSILON)),
            (2.0, 4.0),
        ];
        let listed =
            |&(phi, psi): &(f64, f64)| Listed { period: 2.0 * half, times: [0.0, phi].into_iter(), psi: Some(psi) };
        list.sort_by(|one, other| listed(one).compare(listed(other)));
        assert_eq!(list.map(|(_, psi)| psi.round()), [4.0, 5.0, 6.0, 1.0, 2.0, 3.0]);
        let mut periods = [5.0, 3.0, 4.0];
        let listed = |&period: &f64| Listed { period, times: [0.0].into_iter(), psi: None };
        periods.sort_by(|one, other| listed(one).compare(listed(other)));
        assert_eq!(periods, [3.0, 4.0, 5.0]);
    }
}

//! The order of orbits in every list: by φ, then by ψ.

use smallvec::SmallVec;

/// Steps of a period. Times that differ by rounding alone are in one step; those that symmetry gives, halves and thirds of the period, lie
/// within a step, not at its end.
const STEPS: f64 = (1u64 << 30) as f64;

/// What decides where an orbit stands in a list: the times of its impacts after the first one, the phase of the force, then the period, which
/// differs where it is the orbit's own.
pub(crate) fn list_key(period: f64, times: impl Iterator<Item = f64>, psi: Option<f64>) -> SmallVec<[u64; 4]> {
    let step = |time: f64| (time / period * STEPS).round().rem_euclid(STEPS) as u64;
    // Positive numbers are in the order of their bits.
    times.skip(1).chain(psi).map(step).chain([period.to_bits()]).collect()
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
        list.sort_by_key(|&(phi, psi)| list_key(2.0 * half, [0.0, phi].into_iter(), Some(psi)));
        assert_eq!(list.map(|(_, psi)| psi.round()), [4.0, 5.0, 6.0, 1.0, 2.0, 3.0]);
        let mut periods = [5.0, 3.0, 4.0];
        periods.sort_by_key(|&period| list_key(period, [0.0].into_iter(), None));
        assert_eq!(periods, [3.0, 4.0, 5.0]);
    }
}

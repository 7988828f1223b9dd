//! The order of orbits in every list: by φ, then by ψ.

/// A period is divided into so many steps, and times of one step count as equal: they differ by rounding alone. The number is a power of two, so that
/// halves and thirds of the period, which symmetry gives, lie inside a step and not on the border of two.
const STEPS: u64 = 1 << 30;

/// What decides where an orbit stands in a list: its period, and the phase of the force at its first impact.
type Frame = (f64, Option<f64>);

/// Sorts orbits by the times of their impacts after the first one, by the phase of the force, then by the period, which differs where it is the
/// orbit's own.
pub(crate) fn sort<O, I>(
    orbits: &mut [O],
    frame: impl Fn(&O) -> Frame,
    impacts: impl Fn(&O) -> &[I],
    time: impl Fn(&I) -> f64,
) {
    orbits.sort_by(|one, other| {
        let [own, others] = [frame(one), frame(other)];
        // Most of them differ in φ by far more than a step.
        if let ([_, a, ..], [_, b, ..]) = (impacts(one), impacts(other)) {
            let ([a, b], room) = ([a, b].map(&time), 4.0 * own.0 / STEPS as f64);
            if own.0 == others.0 && (a - b).abs() > room && a.max(b) < own.0 - room {
                return a.total_cmp(&b);
            }
        }
        let [one, other] = [(one, own), (other, others)]
            .map(|(orbit, (period, psi))| steps(impacts(orbit).iter().skip(1).map(&time).chain(psi), period));
        one.cmp(other).then(own.0.total_cmp(&others.0))
    });
}

/// The number of the step in which each time lies; the end of the period counts as its beginning.
fn steps(times: impl Iterator<Item = f64>, period: f64) -> impl Iterator<Item = u64> {
    let scale = STEPS as f64 / period;
    times.map(move |time| (time * scale + 0.5) as u64 % STEPS)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times of half a period are equal however they are rounded, and a phase of a whole period equals 0.
    #[test]
    fn rounding_of_times_does_not_decide() {
        let half = 3.0f64;
        let mut list = [
            ([0.0, half * (1.0 + 4.0 * f64::EPSILON)], 1.0),
            ([0.0, half], 2.0),
            ([0.0, half * (1.0 - 4.0 * f64::EPSILON)], 3.0),
            ([0.0, 2.0], 5.0),
            ([0.0, half], 6.0 * (1.0 - f64::EPSILON)),
            ([0.0, 2.0], 4.0),
        ];
        sort(&mut list, |(_, psi)| (2.0 * half, Some(*psi)), |(times, _)| &times[..], |time| *time);
        assert_eq!(list.map(|(_, psi)| psi.round()), [4.0, 5.0, 6.0, 1.0, 2.0, 3.0]);
        let mut periods = [5.0, 3.0, 4.0];
        sort(&mut periods, |period| (*period, None), |_| &[0.0][..], |time| *time);
        assert_eq!(periods, [3.0, 4.0, 5.0]);
    }
}

//! What the equations of an orbit are solved for.

use smallvec::SmallVec;
use vibrochain_lattice::Barrier;

/// Times that differ by no more than this part of the period are one: more than rounding of simultaneous impacts, less than flights.
pub(super) const SAME_INSTANT: f64 = 1e-11;

/// An impact as its equations know it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Strike {
    pub(super) contact: usize,
    pub(super) barrier: Barrier,
    pub(super) time: f64,
    pub(super) impulse: f64,
}

/// What is solved for: the impacts, the phase of the loads or, where nothing gives it, the period, where rigid modes are, and states of open ones.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Point {
    pub(super) strikes: SmallVec<[Strike; 4]>,
    pub(super) psi: f64,
    /// Of a self-excited orbit an unknown, of others that of the equations.
    pub(super) period: f64,
    pub(super) offsets: SmallVec<[f64; 1]>,
}

/// Newton's method from a point has stayed at its orbit if it moved times and phase by less than this part of the period, and impulses by less
/// than this part of the strongest.
const SAME_ORBIT: f64 = 1e-4;

impl Point {
    /// The same impacts in order of time, of one instant where they are but for rounding; `None` if they are so already.
    pub(super) fn in_time(&self) -> Option<Self> {
        let same = SAME_INSTANT * self.period;
        // Just before 0, by rounding, is the first instant.
        let is_first = |strike: &Strike| {
            strike.time < 0.0 && -strike.time <= same || strike.time > 0.0 && self.period - strike.time <= same
        };
        let near = |pair: &[Strike]| {
            let flight = pair[1].time - pair[0].time;
            flight < 0.0 || 0.0 < flight && flight <= same
        };
        if !self.strikes.iter().any(is_first) && !self.strikes.windows(2).any(near) {
            return None;
        }
        let mut point = self.clone();
        point.strikes.iter_mut().filter(|strike| is_first(strike)).for_each(|strike| strike.time = 0.0);
        let mut strikes: SmallVec<[(usize, Strike); 4]> = point.strikes.drain(..).enumerate().collect();
        strikes.sort_by(|(_, one), (_, other)| one.time.total_cmp(&other.time));
        for i in 1..strikes.len() {
            let before = strikes[i - 1].1.time;
            let own = &mut strikes[i].1.time;
            *own = if *own - before <= same { before } else { *own };
        }
        // Those of one instant keep their order, which rounding would change between neighbours on a branch.
        strikes.sort_by(|(i, one), (j, other)| one.time.total_cmp(&other.time).then(i.cmp(j)));
        point.strikes.extend(strikes.into_iter().map(|(_, strike)| strike));
        Some(point)
    }

    /// The same impacts within a period, in order of time: that in which they have `begun`, but that those begun at one instant may part. `None` where
    /// others have overtaken each other, or two of one contact are one.
    pub(super) fn in_turn(&self, begun: &Self) -> Option<Self> {
        let same = SAME_INSTANT * self.period;
        let mut point = self.clone();
        let mut turns: SmallVec<[(f64, f64); 4]> = SmallVec::new();
        for (strike, begun) in point.strikes.iter_mut().zip(&begun.strikes) {
            let is_away = strike.time < -same || strike.time >= self.period;
            let time = if is_away { strike.time.rem_euclid(self.period) } else { strike.time };
            turns.push((time, begun.time + time - strike.time));
            strike.time = time;
        }
        turns.sort_by(|one, other| one.0.total_cmp(&other.0));
        // The first impact comes again.
        turns.push((self.period, self.period));
        let in_order = turns.windows(2).all(|pair| pair[1].1 - pair[0].1 >= -same);
        let flights = self.strikes.iter().enumerate().flat_map(|(j, other)| {
            self.strikes[..j].iter().filter(|one| one.contact == other.contact).map(|one| other.time - one.time)
        });
        let are_apart = flights
            .map(|flight| flight.rem_euclid(self.period))
            .all(|flight| flight > same && self.period - flight > same);
        (in_order && are_apart).then(|| point.in_time().unwrap_or(point))
    }

    /// Whether a point is of the same orbit, but for rounding.
    pub(super) fn is_near(&self, other: &Self) -> bool {
        let strongest = other.strikes.iter().map(|strike| strike.impulse.abs()).fold(0.0, f64::max);
        let phase = (self.psi - other.psi).abs() <= SAME_ORBIT * self.period;
        phase
            && self.strikes.iter().zip(&other.strikes).all(|(one, other)| {
                (one.time - other.time).abs() <= SAME_ORBIT * self.period
                    && (one.impulse - other.impulse).abs() <= SAME_ORBIT * strongest
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two masses that hit together and two that do so at the end of the period, by rounding one way or the other.
    #[test]
    fn impacts_of_one_instant_keep_their_order_whatever_rounding_says() {
        let point = |times: [f64; 5]| {
            let strike = |(contact, time)| Strike { contact, barrier: Barrier::Upper, time, impulse: -1.0 };
            Point {
                strikes: times.into_iter().enumerate().map(strike).collect(),
                psi: 0.0,
                period: 2.0,
                offsets: SmallVec::new(),
            }
        };
        for [first, second, last] in [[1e-13, -1e-13, -1e-13], [-1e-13, 1e-13, 1e-13], [0.0, 1e-13, 0.0]] {
            let told = point([0.0, 1.0 + first, 1.0 + second, 0.5, 2.0 - 1e-13 + last]).in_time().unwrap();
            let order: Vec<usize> = told.strikes.iter().map(|strike| strike.contact).collect();
            assert_eq!(order, [0, 4, 3, 1, 2], "{first:e} {second:e} {last:e}");
            let times: Vec<f64> = told.strikes.iter().map(|strike| strike.time).collect();
            assert!(times[0] == times[1] && times[3] == times[4], "{times:?}");
        }
    }
}

//! A contact on a window, by what it does at both ends and a bound of its fourth derivative.

use vibrochain_lattice::Barrier;
use vibrochain_lattice::simd::lanes::Number;
use wide::f64x4;

/// Of a velocity at the end of a flight below this part of those nearby the contact turns so close to the end that it is as near a barrier there,
/// to rounding.
pub(crate) const STILL: f64 = 1e-9;

/// The cubic that has a contact's place and velocity at both ends of a window, by Bézier's four points, between which it stays, and how far
/// the contact can be from it: h⁴/384 times a bound of |g⁗|, and √3h³/216 times that in its velocity. Of one contact, or of four.
pub(crate) struct Passage<T> {
    pub(crate) points: [T; 4],
    pub(crate) off: T,
    length: f64,
}

impl<T: Number> Passage<T> {
    pub(crate) fn new([place, velocity]: [T; 2], [end, last]: [T; 2], length: f64, fourth: T) -> Self {
        let third = length / 3.0;
        // What rounding adds is as small against the terms as this.
        let off = (fourth * length.powi(4) / T::of(384.0)) * (1.0 + 1e-9) + (place.modulus() + end.modulus()) * 1e-14;
        Self { points: [place, place + velocity * third, end - last * third, end], off, length }
    }

    /// How much room it surely leaves before a barrier.
    pub(crate) fn room(&self, barrier: Barrier, stop: T) -> T {
        let [a, b, c, d] = self.points.map(|place| (place - stop) * barrier.sign());
        -(a.at_least(b).at_least(c.at_least(d))) - self.off
    }
}

impl Passage<f64x4> {
    /// That of one of the four.
    pub(crate) fn of(&self, lane: usize) -> Passage<f64> {
        let own = |four: f64x4| four.to_array()[lane];
        Passage { points: self.points.map(own), off: own(self.off), length: self.length }
    }
}

impl Passage<f64> {
    /// Whether the velocity may vanish; at the ends that are `known`, where the flight ends, too, it may be 0 all the same.
    pub(crate) fn may_turn(&self, known: [bool; 2]) -> bool {
        let [a, b, c, d] = self.points;
        let slopes = [b - a, c - b, d - c].map(|way| way * 3.0 / self.length);
        let one_way = |list: &[f64], off: f64| list.iter().all(|x| *x > off) || list.iter().all(|x| *x < -off);
        // √3/216 of what is 1/384 in place.
        if one_way(&slopes, self.off * 3.08 / self.length) {
            return false;
        }
        let [first, middle, last] = slopes;
        let most = slopes.iter().fold(0.0, |most: f64, slope| most.max(slope.abs()));
        let is_still = known[0] && first.abs() <= STILL * most || known[1] && last.abs() <= STILL * most;
        // 1/12 in the acceleration, which is twice these over the length.
        !(is_still && one_way(&[middle - first, last - middle], 16.0 * self.off / self.length))
    }
}

#[cfg(test)]
mod tests;

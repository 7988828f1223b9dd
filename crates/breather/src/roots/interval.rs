//! All zeros of a smooth function on an interval, each one proved to be alone or reported as unresolved.
//!
//! An interval is discarded when an enclosure shows that the function cannot vanish there, settled when the
//! derivative cannot (at most one zero, found by its change of sign), and halved otherwise. What cannot be decided
//! at the resolution of the arithmetic is a double zero, or two closer than can be told apart: it is returned as
//! unresolved, not dropped.
//!
//! A zero is larger than its own rounding. Next to a double zero, and where a symmetry puts a zero that is no solution, values are rounding, and
//! change their sign as that does: a change is a zero if the function surely has both signs a few roundings away, while the derivative keeps its
//! own. Where this is so all the way to a zero that symmetry puts there, there is no other one.

use smallvec::SmallVec;
use vibrochain_lattice::Stop;
use vibrochain_lattice::simd::lanes::{LANES, Lane};

pub(crate) use crate::roots::clearance::{Clearance, one_by_one};

/// A function of one variable with an enclosure on any interval.
pub(crate) trait Enclosed {
    /// What enclosures say on |x − centre| ≤ radius, for four intervals.
    fn clearances(&self, centres: Lane, radii: Lane) -> [Clearance; LANES];

    /// The function and its derivative at a point.
    fn at(&self, x: f64) -> (f64, f64);

    /// Where the function vanishes by symmetry, at the ends of what is searched: no zero that is asked for.
    fn known_zeros(&self) -> SmallVec<[f64; 2]> {
        SmallVec::new()
    }
}

/// The zeros found.
#[derive(Debug, Clone, Default)]
pub(crate) struct Zeros {
    /// Simple zeros, rising.
    pub(crate) simple: Vec<f64>,
    /// Centres of intervals, as narrow as can be told apart, on which a double zero may sit.
    pub(crate) unresolved: Vec<f64>,
    /// Intervals not looked at because the budget was spent, or the search stopped.
    pub(crate) exhausted: usize,
    /// Intervals enclosed.
    pub(crate) intervals: usize,
    /// Evaluations spent, those that close in on a zero included.
    pub(crate) evaluations: usize,
    stack: Vec<(f64, f64)>,
    /// Places and widths of zeros, simple or not, in the order in which intervals were looked at.
    places: Vec<Place>,
    /// Where the derivative has one sign and the function may have either.
    sloping: Vec<Sloping>,
    /// Once raised, what is left is not looked at.
    pub(crate) stop: Stop,
}

/// Evaluations per piece that no sound problem needs on average; what is left then is reported as exhausted.
const MOST_PER_PIECE: usize = 200;

/// And at least this many in all, for problems of few pieces whose zeros crowd.
const LEAST_BUDGET: usize = 20_000;

/// Places of zeros after which the rest is reported as exhausted. Two impacts of a slow orbit have about 2/ω zeros: at ω = 10⁻⁷ they
/// filled 790 MB.
const MOST_PLACES: usize = 10_000;

/// An interval shorter than this part of the whole is looked at whether it is lost in rounding: such intervals would be halved down to the
/// resolution all over the place where they are.
const FINE: f64 = 1e-4;

/// Widths of rounding at which a sign is looked at again: beyond two it is sure, but for what the derivative changes by. Where three zeros are about
/// to be one there is not much more room than that.
const SURE: Lane = [2.1, 3.0, 5.0, 10.0];

/// 2⁻²⁶, the root of the rounding.
const SMALL: f64 = 1.4901161193847656e-8;

impl Zeros {
    /// Forgets what was found and spent, but keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.forget();
        (self.intervals, self.evaluations) = (0, 0);
    }

    /// Forgets what was found, not what was spent.
    pub(crate) fn forget(&mut self) {
        self.simple.clear();
        self.unresolved.clear();
        self.exhausted = 0;
    }

    /// Finds the zeros of `f` between `from` and `to`, starting from about `pieces` equal intervals. Intervals are
    /// not halved below the width `resolution(centre)`. Zero is a boundary of intervals where it lies inside, so that
    /// they can shrink towards it without end.
    pub(crate) fn find(
        &mut self,
        f: &impl Enclosed,
        from: f64,
        to: f64,
        pieces: usize,
        resolution: impl Fn(f64) -> f64,
    ) {
        let ranges = if from < 0.0 && to > 0.0 { &[[from, 0.0], [0.0, to]][..] } else { &[[from, to]] };
        self.find_in(f, ranges, |_| pieces.div_ceil(ranges.len()), resolution);
    }

    /// The same in several ranges, which rise, each begun with so many equal intervals for its length.
    pub(crate) fn find_in(
        &mut self,
        f: &impl Enclosed,
        ranges: &[[f64; 2]],
        pieces: impl Fn(f64) -> usize,
        resolution: impl Fn(f64) -> f64,
    ) {
        let whole = match ranges {
            [[from, _], ..] => ranges[ranges.len() - 1][1] - from,
            [] => return,
        };
        self.stack.clear();
        for &[from, to] in ranges.iter().rev() {
            // Intervals are kept by their ends, which neighbours share: no gap opens by rounding. Later ones go on the
            // stack first, so that zeros come out in order.
            let pieces = pieces(to - from);
            let end = |i: usize| if i == pieces { to } else { from + (to - from) * (i as f64 / pieces as f64) };
            self.stack.extend((0..pieces).rev().map(|i| (end(i), end(i + 1))));
        }
        let pieces = self.stack.len();
        let budget = self.evaluations + LEAST_BUDGET.max(MOST_PER_PIECE * pieces);
        self.places.clear();
        let known = f.known_zeros();
        while !self.stack.is_empty() {
            if self.evaluations > budget || self.places.len() >= MOST_PLACES || self.stop.is_raised() {
                self.exhausted += self.stack.len();
                break;
            }
            // Four at a time, the last one again where there are fewer.
            let taken: SmallVec<[(f64, f64); LANES]> = (0..LANES).map_while(|_| self.stack.pop()).collect();
            let interval = |i: usize| taken[i.min(taken.len() - 1)];
            let centres = std::array::from_fn(|i| 0.5 * (interval(i).0 + interval(i).1));
            let radii = std::array::from_fn(|i| (interval(i).1 - centres[i]).max(centres[i] - interval(i).0));
            let clearances = f.clearances(centres, radii);
            self.evaluations += taken.len();
            self.intervals += taken.len();
            // The first one goes on the stack last.
            for i in (0..taken.len()).rev() {
                let ((low, high), centre, radius) = (taken[i], centres[i], radii[i]);
                if clearances[i].function > 0.0 {
                    continue;
                }
                if clearances[i].derivative > 0.0 {
                    // Next to a zero that is known values are rounding.
                    if !known.is_empty() && clearances[i].ends.contains(&0.0) {
                        self.sloping.push(Sloping { low, high, sign: clearances[i].centre.1.signum() });
                    }
                    let zero = self.bracketed(f, [low, centre, high], &clearances[i]);
                    if let Some(zero) = zero.filter(|zero| !known.contains(zero)) {
                        let proved = self.proved(f, (low, zero, high), &clearances[i]);
                        let width = resolution(zero).max(proved.unwrap_or(0.0));
                        self.places.push(Place { zero, width, simple: proved.is_some() });
                    }
                } else if radius <= resolution(centre)
                    || radius <= FINE * whole && self.is_lost_in_rounding(f, [low, centre, high])
                {
                    self.places.push(Place { zero: centre, width: 8.0 * radius, simple: false });
                } else {
                    self.stack.push((centre, high));
                    self.stack.push((low, centre));
                }
            }
        }
        self.leave_out(&known);
        self.places.sort_unstable_by(|a, b| a.zero.total_cmp(&b.zero));
        for place in &self.places {
            push_distinct(if place.simple { &mut self.simple } else { &mut self.unresolved }, place.zero, place.width);
        }
    }

    /// Leaves out the places of zeros in intervals from which the derivative keeps its sign all the way to a zero that is known: there is no
    /// other one.
    fn leave_out(&mut self, known: &[f64]) {
        for zero in known {
            let (mut low, mut high, mut sign) = (*zero, *zero, 0.0);
            let neighbour = |sloping: &Sloping, low: f64, high: f64, sign: f64| {
                (sloping.high == low || sloping.low == high) && (sign == 0.0 || sloping.sign == sign)
            };
            while let Some(place) = self.sloping.iter().position(|sloping| neighbour(sloping, low, high, sign)) {
                let next = self.sloping.swap_remove(place);
                (low, high, sign) = (low.min(next.low), high.max(next.high), next.sign);
            }
            self.places.retain(|place| !(low..=high).contains(&place.zero));
        }
        self.sloping.clear();
    }

    /// How far from a zero, one that the function has changed its sign at as far as is known, it surely has both signs, while the derivative
    /// keeps its own: there is one zero there, and another one that close is the same. `None` next to a double zero, where rounding is all there is.
    fn proved(&mut self, f: &impl Enclosed, (low, zero, high): (f64, f64, f64), here: &Clearance) -> Option<f64> {
        if !here.ends.contains(&0.0) {
            return Some(0.0);
        }
        // What is left over of a series hides a sign that the function's own value shows: at the ends of the interval, or next to the zero.
        self.evaluations += 3;
        let points = f.clearances([low, high, zero, zero], [0.0; LANES]);
        if points[0].function > 0.0 && points[1].function > 0.0 {
            return Some(0.0);
        }
        self.evaluations += 2 + 4 * LANES;
        let Clearance { function, centre: (value, slope), .. } = points[2];
        // Without rounding of a function that vanishes there is no width; a zero at 0 is known as well as its interval.
        let width = ((value.abs() - function) / slope.abs()).max(f64::EPSILON * low.abs().max(high.abs()));
        let side = |side: f64| {
            let ends = SURE.map(|times| zero + side * times * width);
            let radii = SURE.map(|times| 0.5 * times * width);
            let (about, there) =
                (f.clearances(ends.map(|end| 0.5 * (zero + end)), radii), f.clearances(ends, [0.0; LANES]));
            let place = (0..LANES).find(|&i| about[i].derivative > 0.0 && there[i].function > 0.0)?;
            Some((f.at(ends[place]).0, SURE[place] * width))
        };
        let (below, above) = (side(-1.0)?, side(1.0)?);
        (below.0 * above.0 < 0.0).then_some(below.1.max(above.1))
    }

    /// Whether at both ends and in the middle function and derivative are no larger than their rounding.
    fn is_lost_in_rounding(&mut self, f: &impl Enclosed, [low, centre, high]: [f64; 3]) -> bool {
        self.evaluations += 3;
        let here = f.clearances([low, centre, high, centre], [0.0; LANES]);
        here.iter().all(|here| here.function <= 0.0 && here.derivative <= 0.0)
    }

    /// The zero of a monotone function on an interval, by its ends and its middle, if its sign changes: Newton kept inside the bracket.
    fn bracketed(&mut self, f: &impl Enclosed, [mut low, mut x, mut high]: [f64; 3], known: &Clearance) -> Option<f64> {
        let mut end = |x: f64, known: f64| {
            if known != 0.0 {
                return known;
            }
            self.evaluations += 1;
            f.at(x).0
        };
        let (f_low, f_high) = (end(low, known.ends[0]), end(high, known.ends[1]));
        if f_low == 0.0 {
            return Some(low);
        }
        if f_high == 0.0 {
            return Some(high);
        }
        if (f_low < 0.0) == (f_high < 0.0) {
            return None;
        }
        let (mut at, mut last) = (known.centre, f64::INFINITY);
        for _ in 0..100 {
            let (value, slope) = at;
            if value == 0.0 {
                return Some(x);
            }
            if (value < 0.0) == (f_low < 0.0) {
                low = x;
            } else {
                high = x;
            }
            let newton = x - value / slope;
            let (step, inside) = ((newton - x).abs(), newton > low && newton < high);
            // A step as small as the root of the rounding is followed by one of its size. One that does not fall, or leaves the
            // bracket, is rounding of the function.
            let rounding = last <= SMALL * x.abs() && (!inside || step >= 0.5 * last);
            if rounding || (inside && step <= f64::EPSILON * x.abs()) {
                return Some(if inside { newton } else { x });
            }
            let middle = 0.5 * (low + high);
            if !inside && (middle - x).abs() <= f64::EPSILON * x.abs() {
                return Some(middle);
            }
            (x, last) = if inside { (newton, step) } else { (middle, f64::INFINITY) };
            at = f.at(x);
            self.evaluations += 1;
        }
        Some(x)
    }
}

/// A zero, or the middle of an interval that may have two.
#[derive(Debug, Clone, Copy)]
struct Place {
    zero: f64,
    /// Another one closer than this is the same.
    width: f64,
    simple: bool,
}

/// An interval on which the derivative has this sign.
#[derive(Debug, Clone, Copy)]
struct Sloping {
    low: f64,
    high: f64,
    sign: f64,
}

fn push_distinct(list: &mut Vec<f64>, value: f64, width: f64) {
    if list.last().is_none_or(|&last| (value - last).abs() > width) {
        list.push(value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::roots::dual::{Algebra, Dual};

    /// sin²x − level: pairs of zeros that merge as the level goes to 0.
    struct Pairs {
        level: f64,
    }

    impl Pairs {
        fn enclose(&self, x: f64, radius: f64) -> Dual {
            let sine = Dual::wave(x.sin(), -x.cos(), 1.0, 1.0, radius);
            (sine * sine).shifted(-self.level)
        }
    }

    impl Enclosed for Pairs {
        fn clearances(&self, centres: Lane, radii: Lane) -> [Clearance; LANES] {
            one_by_one(centres, radii, |x, radius| self.enclose(x, radius))
        }

        fn at(&self, x: f64) -> (f64, f64) {
            self.enclose(x, 0.0).at_centre()
        }
    }

    #[test]
    fn close_pairs_are_told_apart_and_double_zeros_reported() {
        let resolution = |_: f64| 1e-12;
        for exponent in [1, 4, 8, 12] {
            let level = 10f64.powi(-exponent);
            let mut zeros = Zeros::default();
            zeros.find(&Pairs { level }, -1.0, 4.0, 7, resolution);
            let root = level.sqrt().asin();
            let pi = std::f64::consts::PI;
            assert_eq!(zeros.simple.len(), 4, "{level}");
            for (found, expected) in zeros.simple.iter().zip([-root, root, pi - root, pi + root]) {
                assert!((found - expected).abs() < 4e-16 / root, "{level}: {found} {expected}");
            }
            assert!(zeros.unresolved.is_empty() && zeros.evaluations < 500, "{}", zeros.evaluations);
        }
        let mut zeros = Zeros::default();
        zeros.find(&Pairs { level: 0.0 }, -1.0, 4.0, 7, resolution);
        assert!(zeros.simple.is_empty() && zeros.unresolved.len() == 2, "{zeros:?}");
    }

    /// x(x − b) or (x − b)², blurred as by rounding of far larger terms.
    struct Blurred {
        second: f64,
        twice: bool,
    }

    /// Rounding of its terms.
    const BLUR: f64 = 1e-9;

    impl Blurred {
        fn enclose(&self, x: f64, radius: f64) -> Dual {
            let first = if self.twice { self.second } else { 0.0 };
            let noise = BLUR * (1e13 * x).sin();
            let jet = [(x - first) * (x - self.second) + noise, 2.0 * x - first - self.second, 2.0, 0.0];
            Dual::from_jet(jet, 0.0, radius).widened([BLUR, BLUR])
        }
    }

    impl Enclosed for Blurred {
        fn clearances(&self, centres: Lane, radii: Lane) -> [Clearance; LANES] {
            one_by_one(centres, radii, |x, radius| self.enclose(x, radius))
        }

        fn at(&self, x: f64) -> (f64, f64) {
            self.enclose(x, 0.0).at_centre()
        }

        fn known_zeros(&self) -> SmallVec<[f64; 2]> {
            if self.twice { SmallVec::new() } else { smallvec::smallvec![0.0] }
        }
    }

    #[test]
    fn a_zero_is_larger_than_its_rounding() {
        let find = |second: f64, twice: bool, to: f64| {
            let mut zeros = Zeros::default();
            zeros.find(&Blurred { second, twice }, 0.0, to, 5, |_| 1e-14);
            assert!(zeros.exhausted == 0 && zeros.evaluations < 5000, "{second} {twice}: {}", zeros.evaluations);
            zeros
        };
        for i in 0..200 {
            let second = 0.3 + 1e-3 * f64::from(i);
            // The zero at 0 is known, the other one is found where it is there.
            let zeros = find(second, false, 1.0);
            assert!(zeros.simple.len() == 1 && zeros.unresolved.is_empty(), "{second} {zeros:?}");
            assert!((zeros.simple[0] - second).abs() < 4.0 * BLUR / second);
            let zeros = find(second, false, 0.8 * second);
            assert!(zeros.simple.is_empty() && zeros.unresolved.is_empty(), "{second} {zeros:?}");
            // Noise about a double zero is none.
            let zeros = find(second, true, 1.0);
            assert!(zeros.simple.is_empty() && !zeros.unresolved.is_empty(), "{second} {zeros:?}");
        }
    }

    /// x² − 2 with noise like the rounding of many terms of this size.
    struct Rounded {
        size: f64,
    }

    impl Enclosed for Rounded {
        fn clearances(&self, centres: Lane, radii: Lane) -> [Clearance; LANES] {
            one_by_one(centres, radii, |x, radius| self.enclose(x, radius))
        }

        fn at(&self, x: f64) -> (f64, f64) {
            self.enclose(x, 0.0).at_centre()
        }
    }

    impl Rounded {
        fn enclose(&self, x: f64, radius: f64) -> Dual {
            let noise = self.size * f64::EPSILON * (1e17 * x).sin();
            Dual::from_jet([x * x - 2.0 + noise, 2.0 * x, 2.0, 0.0], 0.0, radius)
        }
    }

    #[test]
    fn a_zero_is_closed_in_on_in_few_steps_whatever_the_rounding() {
        for size in [0.0, 1.0, 7.0, 3e2, 1e4, 5e5] {
            for shift in 0..50 {
                let mut zeros = Zeros::default();
                zeros.find(&Rounded { size }, 1.3, 1.6 + 1e-3 * f64::from(shift), 1, |_| 1e-12);
                assert_eq!(zeros.simple.len(), 1, "{size} {shift}");
                let error = (zeros.simple[0] - std::f64::consts::SQRT_2).abs();
                assert!(error <= f64::EPSILON * (1.0 + size), "{size} {shift}: {error}");
                assert!(zeros.evaluations <= 10, "{size} {shift}: {}", zeros.evaluations);
            }
        }
    }
}

//! The ways of multipliers through a step: cubics through ln μ and its slope at both ends, and what they tell of the circle, ln|μ| = 0.

use std::f64::consts::PI;

use nalgebra::Complex;

use super::cubic::{Path, conjugate};
use crate::events::half_sums::{ON_CIRCLE, SPLIT};
use crate::zeros::modulus;

type C = Complex<f64>;

/// Two are the same one if they are closer than this part of the distance to the next.
const CLEAR: f64 = 0.4;

/// What a cubic departs by in the middle of a step is of the fourth order: in halves of it a sixteenth is left, here with room.
const HALVED: f64 = 4.0 / 16.0;

/// A multiplier that has no partner has crossed nothing if it is farther from the circle than this many times its distance from the others.
const BEYOND: f64 = 2.0;

/// A multiplier above the real axis: ln μ, its slope along the step if it is known, and the error of that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mover {
    pub(super) at: C,
    pub(super) slope: Option<C>,
    pub(super) error: f64,
}

impl Mover {
    /// Where it is so far along.
    fn after(&self, length: f64) -> C {
        self.at + self.slope.unwrap_or_default() * length
    }
}

/// A place on a step.
#[derive(Debug, Clone, Default)]
pub(super) struct Place {
    pub(super) s: f64,
    /// Of the parameter.
    pub(super) value: f64,
    /// One of each pair of multipliers.
    pub(super) movers: Vec<Mover>,
    /// ln |μ| of real ones, the positive and the negative.
    pub(super) real: [Vec<f64>; 2],
}

impl Place {
    /// Of movers, and of all multipliers.
    pub(super) fn new([s, value]: [f64; 2], movers: Vec<Mover>, values: &[C]) -> Self {
        let real = |sign: f64| {
            let own = values.iter().filter(|mu| mu.im.abs() <= SPLIT && mu.re * sign > 0.0);
            own.map(|mu| mu.re.abs().ln()).collect()
        };
        Self { s, value, movers, real: [real(1.0), real(-1.0)] }
    }

    /// ln μ of real ones, where pairs meet.
    fn on_axis(&self) -> impl Iterator<Item = C> {
        let [positive, negative] = &self.real;
        let positive = positive.iter().map(|growth| C::new(*growth, 0.0));
        positive.chain(negative.iter().map(|growth| C::new(*growth, PI)))
    }
}

/// What is known of the way of a multiplier through half a step.
#[derive(Debug, Clone, Copy)]
enum Way {
    /// It ends within, far from the circle.
    None,
    Along(Path),
    /// It may come to the circle.
    Open,
}

/// A multiplier that crosses the circle in half a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Passing {
    /// Where, and between which places it is alone in doing so.
    pub(super) s: f64,
    pub(super) between: [f64; 2],
    /// Its argument there.
    pub(super) angle: f64,
    /// How far from there its argument may be found.
    pub(super) room: f64,
}

/// A multiplier at the places of a step, as far as it is known there.
type Chain<'a> = [Option<&'a Mover>; 3];

/// The multipliers that cross the circle in each half of a step; `None` for a half that is too long to tell.
pub(super) fn passings(places: [&Place; 3]) -> [Option<Vec<Passing>>; 2] {
    let [from, middle, to] = places;
    let lengths = [middle.s - from.s, to.s - middle.s];
    let (Some(first), Some(second)) = (paired(from, middle), paired(middle, to)) else { return [None, None] };
    let next = |j: usize| second.iter().find(|(own, _)| *own == j).map(|(_, k)| &to.movers[*k]);
    let mut chains: Vec<Chain<'_>> =
        first.iter().map(|&(i, j)| [Some(&from.movers[i]), Some(&middle.movers[j]), next(j)]).collect();
    let begun = second.iter().filter(|(own, _)| first.iter().all(|(_, j)| j != own));
    chains.extend(begun.map(|&(j, k)| [None, Some(&middle.movers[j]), Some(&to.movers[k])]));
    let ways: Vec<[Way; 2]> = chains.iter().map(|chain| through(*chain, lengths)).collect();
    let told = |half: usize, from: f64| {
        let mut found = Vec::new();
        for (own, way) in ways.iter().enumerate() {
            let path = match &way[half] {
                Way::Along(path) => path,
                Way::None => continue,
                Way::Open => return None,
            };
            let zeros = path.zeros()?;
            let others = || {
                let known = |(other, way): (usize, &[Way; 2])| match way[half] {
                    Way::Along(path) if other != own => Some((other, path)),
                    _ => None,
                };
                ways.iter().enumerate().filter_map(known)
            };
            let is_passed = |(other, there): (usize, Path)| {
                // The nearer end.
                let end = PI * (there.ends[0].im / PI).round();
                let images = [(there, None), (there.image(end), Some(end))];
                images.into_iter().any(|(there, image)| {
                    is_felt(path, &there, || pass(chains[own], chains[other], image, half, lengths))
                })
            };
            if !path.is_still() && others().any(is_passed) {
                return None;
            }
            for [before, t, behind] in zeros {
                let along = |t: f64| from + t * lengths[half];
                let nearest = others().map(|(_, other)| modulus(other.at(t) - path.at(t))).fold(1.0, f64::min);
                let (angle, room) = (path.at(t).im, CLEAR * nearest + path.error);
                found.push(Passing { s: along(t), between: [along(before), along(behind)], angle, room });
            }
        }
        Some(found)
    };
    [told(0, from.s), told(1, middle.s)]
}

/// Whether another one that comes by in half a step may bend the way of one to the circle: by as much as they are apart, or as their pass says.
fn is_felt(path: &Path, other: &Path, pass: impl Fn() -> f64) -> bool {
    let growths = path.turns().into_iter().map(|t| path.at(t).re.abs()).chain(path.ends.map(|end| end.re.abs()));
    let crosses = (path.ends[0].re > 0.0) != (path.ends[1].re > 0.0);
    let least = if crosses { 0.0 } else { growths.fold(f64::INFINITY, f64::min) };
    let [a, b] = [0, 1].map(|end| path.ends[end] - other.ends[end]);
    let way = b - a;
    let square = way.norm_sqr();
    let t = -(a.re * way.re + a.im * way.im) / square;
    let passes = (0.0..=1.0).contains(&t) && modulus(a + way * t) < square.sqrt();
    passes && least < FELT * modulus(a + way * t).max(pass())
}

/// How far apart two are where they come by each other: their distance squared has no root where they nearly meet, so that its cubic tells of what
/// happens within much less than a step.
fn pass(own: Chain<'_>, other: Chain<'_>, image: Option<f64>, half: usize, [first, second]: [f64; 2]) -> f64 {
    let square = |place: usize| {
        let (one, other) = (own[place]?, other[place]?);
        let slope = other.slope?;
        let (there, slope) = image.map_or((other.at, slope), |end| (conjugate(other.at, end), slope.conj()));
        let apart = one.at - there;
        Some((apart * apart, apart * (one.slope? - slope) * 2.0))
    };
    let cubic = |from: usize, to: usize, length: f64| {
        let ((a, p), (b, q)) = (square(from)?, square(to)?);
        Some(Path { ends: [a, b], slopes: [p * length, q * length], error: 0.0 })
    };
    let length = first + second;
    let told = || {
        let (whole, (middle, slope)) = (cubic(0, 2, length)?, square(1)?);
        let t = first / length;
        let departure = whole.departure(t, middle, slope * length);
        let part = if half == 0 { cubic(0, 1, first)? } else { cubic(1, 2, second)? };
        Some(part.size_at_rest() + HALVED * departure)
    };
    told().map_or(f64::INFINITY, f64::sqrt)
}

/// One that comes by is felt as far from the circle as this many times the distance that is left between the two: neither bends by more.
const FELT: f64 = 1.0;

/// A multiplier and its slope.
fn known(mover: Option<&Mover>) -> Option<(&Mover, C)> {
    let mover = mover?;
    Some((mover, mover.slope?))
}

/// The cubics of one multiplier through both halves of a step.
fn through([from, middle, to]: Chain<'_>, [first, second]: [f64; 2]) -> [Way; 2] {
    let (Some((from, p)), Some((middle, m)), Some((to, q))) = (known(from), known(middle), known(to)) else {
        let half = |from: Option<&Mover>, to: Option<&Mover>| {
            from.zip(to).map_or(Way::None, |(one, other)| straight(one, other))
        };
        return [half(from, middle), half(middle, to)];
    };
    let length = first + second;
    let whole = Path { ends: [from.at, to.at], slopes: [p * length, q * length], error: 0.0 };
    let t = first / length;
    let departure = whole.departure(t, middle.at, m * length);
    // Errors of slopes are felt by 4/27.
    let rounding = length * (from.error.max(middle.error).max(to.error) + f64::EPSILON);
    let error = departure * HALVED + rounding + ON_CIRCLE;
    let path = |ends: [C; 2], slopes: [C; 2]| Way::Along(Path { ends, slopes, error });
    [path([from.at, middle.at], [p * first, m * first]), path([middle.at, to.at], [m * second, q * second])]
}

/// The way of one that is too far from the circle to come there, or stays on it.
fn straight(from: &Mover, to: &Mover) -> Way {
    let way = to.at - from.at;
    let far = BEYOND * modulus(way) < from.at.re.abs().min(to.at.re.abs()) && from.at.re * to.at.re > 0.0;
    let still = from.at.re.abs().max(to.at.re.abs()) < ON_CIRCLE;
    if far || still { Way::Along(Path { ends: [from.at, to.at], slopes: [way; 2], error: 0.0 }) } else { Way::Open }
}

/// Which multipliers of two places are the same; `None` where one of which that cannot be told may have crossed the circle.
fn paired(from: &Place, to: &Place) -> Option<Vec<(usize, usize)>> {
    let half = 0.5 * (to.s - from.s);
    let ahead: Vec<C> = from.movers.iter().map(|one| one.after(half)).collect();
    let back: Vec<C> = to.movers.iter().map(|one| one.after(-half)).collect();
    let two = |one: C, others: &[C]| {
        let mut nearest = [(usize::MAX, f64::INFINITY); 2];
        for (i, other) in others.iter().enumerate() {
            let apart = modulus(other - one);
            if apart < nearest[0].1 {
                nearest = [(i, apart), nearest[0]];
            } else if apart < nearest[1].1 {
                nearest[1] = (i, apart);
            }
        }
        nearest
    };
    let (mut pairs, mut left) = (Vec::with_capacity(ahead.len()), Vec::new());
    let mut taken = vec![false; back.len()];
    for (i, one) in ahead.iter().enumerate() {
        let [(j, apart), (_, next)] = two(*one, &back);
        let sure = j != usize::MAX && {
            let [(back_to, _), (_, other)] = two(back[j], &ahead);
            back_to == i && apart <= CLEAR * next.min(other)
        };
        if sure {
            taken[j] = true;
            pairs.push((i, j));
        } else {
            left.push((from.movers[i].at, to));
        }
    }
    let others = to.movers.iter().zip(&taken).filter(|(_, taken)| !**taken).map(|(one, _)| (one.at, from));
    left.extend(others);
    let sides = |growth: f64| left.iter().all(|(at, _)| at.re * growth > 0.0);
    let harmless = left.iter().all(|(at, there)| {
        let near = there.movers.iter().map(|one| one.at).chain(there.on_axis());
        let nearest = near.map(|other| modulus(other - at)).fold(f64::INFINITY, f64::min);
        sides(at.re) && at.re.abs() > BEYOND * nearest
    });
    harmless.then_some(pairs)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places of a step of multipliers by their ln μ and slopes.
    fn places<const N: usize>(at: [f64; 3], movers: impl Fn(f64) -> [(C, C); N]) -> [Place; 3] {
        at.map(|s| {
            let movers = movers(s).map(|(at, slope)| Mover { at, slope: Some(slope), error: 0.0 });
            Place::new([s, s], movers.to_vec(), &[])
        })
    }

    fn told(places: &[Place; 3]) -> [Option<Vec<Passing>>; 2] {
        let [from, middle, to] = places;
        passings([from, middle, to])
    }

    #[test]
    fn one_that_leaves_and_comes_back_within_half_a_step_is_seen() {
        // ln|μ| = 0.04 − (s − 0.3)²: twice 0 in the first half; and one that stays inside.
        let growth = |s: f64| (C::new(0.04 - (s - 0.3) * (s - 0.3), 1.0 + s), C::new(-2.0 * (s - 0.3), 1.0));
        let inside = (C::new(-0.3, 2.8), C::default());
        let [first, second] = told(&places([0.0, 0.6, 1.2], |s| [growth(s), inside])).map(Option::unwrap);
        assert!(second.is_empty() && first.len() == 2, "{first:?} {second:?}");
        assert!((first[0].s - 0.1).abs() < 1e-12 && (first[0].angle - 1.1).abs() < 1e-12, "{first:?}");
        assert!((first[1].s - 0.5).abs() < 1e-12 && first[1].between[0] == 0.3, "{first:?}");
        // One that a cubic follows less well than it comes near the circle.
        let sharp = |s: f64| (C::new(-1e-4 - s.powi(4), 1.0), C::new(-4.0 * s.powi(3), 0.0));
        let open = told(&places([-0.2, 0.2, 0.6], |s| [sharp(s)]));
        assert!(open[0].is_none(), "{open:?}");
        let clear = told(&places([-0.02, 0.02, 0.06], |s| [sharp(s)]));
        assert_eq!(clear, [Some(Vec::new()), Some(Vec::new())]);
    }

    /// Two that pass each other and repel by ±b within 10⁻³ of the step: the ends tell nothing but by the square of their distance.
    #[test]
    fn two_that_bend_as_they_pass_are_looked_at_again() {
        let mut open = [0; 2];
        for (b, bends) in [(0.0, false), (1e-4, true)] {
            let pair = |s: f64| {
                // λ = −5e-5 + i ± √((δ + is)² + b²)
                let along = C::new(1e-6, s);
                let root = (along * along + b * b).sqrt();
                let root = if root.im * s < 0.0 { -root } else { root };
                let slope = along * C::new(0.0, 1.0) / root;
                [1.0, -1.0].map(|sign| (C::new(-5e-5, 1.0) + root * sign, slope * sign))
            };
            let all = told(&places([-0.11, 0.09, 0.29], pair));
            open[usize::from(bends)] += all.iter().filter(|half| half.is_none()).count();
        }
        assert_eq!(open, [0, 1]);
    }
}

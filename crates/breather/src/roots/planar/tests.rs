//! Zeros of two functions: those of waves, and quadratic maps that are made to have two zeros.

use vibrochain_testkit::Random;

use super::*;
use crate::roots::patch::Piece;

/// sin x = level and cos 3y = sin²x·bend: pairs in x and in y, that merge as level → 1.
struct Waves {
    level: f64,
}

impl Planar for Waves {
    type Strip = (f64, f64);

    fn strip(&self, centre: f64, radius: f64) -> (f64, f64) {
        (centre, radius)
    }

    fn enclose(&self, _: &(f64, f64), at: [f64; 2], radius: [f64; 2], form: usize) -> Option<([Patch; 2], bool)> {
        let sin = Piece::wave([at[0].sin(), -at[0].cos()], 1.0, 1.0).along(0, radius);
        let cos = Piece::wave([(3.0 * at[1]).cos(), (3.0 * at[1]).sin()], 3.0, 1.0).along(1, radius);
        (form == 0).then(|| ([sin.shifted(-self.level), cos - (sin * sin).scaled(0.5)], true))
    }
}

#[test]
fn close_pairs_are_told_apart_and_double_zeros_reported() {
    let pi = std::f64::consts::PI;
    for exponent in [1, 4, 8, 12] {
        let level = 1.0 - 10f64.powi(-exponent);
        let mut zeros = PlanarZeros::default();
        zeros.find(&Waves { level }, [0.0, pi], [0.0, 2.0 * pi], [3, 7], 1e-14);
        assert_eq!((zeros.simple.len(), zeros.unresolved.len()), (12, 0), "{level} {zeros:?}");
        let apart = 10f64.powf(-0.5 * f64::from(exponent));
        for [x, y] in zeros.simple {
            assert!((x.sin() - level).abs() < 4e-16 && (x - 0.5 * pi).abs() > apart, "{x}");
            assert!(((3.0 * y).cos() - 0.5 * level * level).abs() < 4e-15, "{y}");
        }
        assert!(zeros.evaluations < 4000, "{}", zeros.evaluations);
    }
    let mut zeros = PlanarZeros::default();
    zeros.find(&Waves { level: 1.0 }, [0.0, pi], [0.0, 2.0 * pi], [3, 7], 1e-14);
    assert_eq!((zeros.simple.len(), zeros.unresolved.len(), zeros.exhausted), (0, 6, 0));
    let mut zeros = PlanarZeros::default();
    zeros.find(&Waves { level: 1.0 + 1e-12 }, [0.0, pi], [0.0, 2.0 * pi], [3, 7], 1e-14);
    assert!(zeros.simple.is_empty() && zeros.unresolved.is_empty());
}

/// c + s·x + ½xᵀHx
#[derive(Debug, Clone, Copy)]
struct Quadratic {
    constant: f64,
    slope: [f64; 2],
    /// H₁₁, H₂₂ and H₁₂.
    bend: [f64; 3],
}

impl Quadratic {
    fn at(&self, [x, y]: [f64; 2]) -> f64 {
        let ([a, b], [xx, yy, xy]) = (self.slope, self.bend);
        self.constant + a * x + b * y + 0.5 * (xx * x * x + yy * y * y) + xy * x * y
    }

    /// One that vanishes at both places.
    fn through([one, other]: [[f64; 2]; 2], size: f64, random: &mut Random) -> Self {
        let number = |random: &mut Random, size: f64| random.between(-size, size);
        let slope = [number(random, 1.0), number(random, 1.0)];
        let bend = [(); 3].map(|()| number(random, size));
        let mut own = Self { constant: 0.0, slope, bend };
        let way = [other[0] - one[0], other[1] - one[1]];
        let off = (own.at(other) - own.at(one)) / (way[0] * way[0] + way[1] * way[1]);
        own.slope = [slope[0] - off * way[0], slope[1] - off * way[1]];
        own.constant = -own.at(one);
        own
    }

    /// Its enclosure about a place.
    fn around(&self, [x, y]: [f64; 2], radius: [f64; 2]) -> Patch {
        let ([a, b], [xx, yy, xy]) = (self.slope, self.bend);
        let line = |axis: usize, jet: [f64; 3]| Piece { jet, third: 0.0, doubt: 0.0 }.along(axis, radius);
        let first = line(0, [self.constant + a * x + 0.5 * xx * x * x, a + xx * x, xx]);
        let second = line(1, [b * y + 0.5 * yy * y * y, b + yy * y, yy]);
        first + second + line(0, [xy * x, xy, 0.0]) * line(1, [y, 1.0, 0.0])
    }
}

/// Two quadratic functions with two zeros in a rectangle: neither is excluded, or cut off, and no norm says that there is one alone. With the larger of
/// two columns in place of their sum many would be.
#[test]
fn a_rectangle_of_two_zeros_is_never_said_to_have_one() {
    let mut random = Random(29);
    let (mut judged, mut close, mut cut) = (0, 0, 0);
    for _ in 0..20_000 {
        let (radius, centre) = ([random.log(0.1, 2.0), random.log(0.1, 2.0)], [random.unit(), random.unit()]);
        // Half of them near a corner, where slopes differ most from those of the middle.
        let (corner, away) = ([0; 2].map(|_| random.of(&[-1.0, 1.0])), random.of(&[2.0, 0.4]));
        let mut place = || std::array::from_fn(|i| centre[i] + radius[i] * corner[i] * (1.0 - away * random.unit()));
        let zeros: [[f64; 2]; 2] = [place(), place()];
        let size = random.log(0.1, 3.0);
        let functions = [(); 2].map(|()| Quadratic::through(zeros, size, &mut random));
        let patches = functions.map(|function| function.around(centre, radius));
        let linear = match judge(&patches, radius, 0) {
            Verdict::Linear(linear) => linear,
            Verdict::Singular => continue,
            Verdict::Empty => panic!("{functions:?} {zeros:?} {centre:?} {radius:?}"),
        };
        assert!(!linear.alone, "{functions:?} {zeros:?} {centre:?} {radius:?}");
        let inverse = inverse(&patches, radius).unwrap();
        let columns = inverse.map(|row| {
            let of = |axis: usize| (0..2).map(|i| row[i].abs() * patches[i].swing()[axis] * radius[axis]).sum::<f64>();
            of(0).max(of(1))
        });
        close += usize::from(columns.iter().all(|column| *column < 0.99));
        let low: [f64; 2] = std::array::from_fn(|i| centre[i] - radius[i]);
        let rectangle = Rectangle { low, high: std::array::from_fn(|i| centre[i] + radius[i]) };
        for zero in zeros {
            for i in 0..2 {
                let away = (zero[i] - centre[i]) / radius[i] - linear.middle[i];
                assert!(away.abs() <= linear.reach[i] * (1.0 + 1e-9) + 1e-9, "{away} {linear:?}");
            }
            if let Some(shrunk) = shrunk(&rectangle, &linear, [false; 2]) {
                cut += 1;
                let holds = |i: usize| shrunk.low[i] - 1e-9 <= zero[i] && zero[i] <= shrunk.high[i] + 1e-9;
                assert!((0..2).all(holds), "{zero:?} {shrunk:?}");
            }
        }
        judged += 1;
    }
    assert!(judged > 15_000 && close > 50 && cut > 100, "{judged} {close} {cut}");
}

/// x + ½by² and y on the unit square: the slopes change by b, and the map is one-to-one up to there as far as the norm tells. A row of both columns.
#[test]
fn one_zero_is_said_to_be_alone_as_far_as_the_norm_goes() {
    for (bends, alone) in [
        ([0.0, 0.98], true),
        ([0.98, 0.0], true),
        ([0.0, 1.0], false),
        ([1.0, 0.0], false),
        ([0.49, 0.49], true),
        ([0.5, 0.5], false),
    ] {
        for swapped in [false, true] {
            let radius: [f64; 2] = [0.5, 2.0];
            let [xx, yy] = bends;
            // In units of the radii.
            let bend = [xx / radius[0].powi(2), yy / radius[1].powi(2), 0.0];
            let curved = Quadratic { constant: 0.1, slope: [1.0 / radius[0], 0.0], bend };
            let straight = Quadratic { constant: 0.1, slope: [0.0, 1.0 / radius[1]], bend: [0.0; 3] };
            let mut patches = [curved, straight].map(|function| function.around([0.0; 2], radius));
            if swapped {
                patches.swap(0, 1);
            }
            let Verdict::Linear(linear) = judge(&patches, radius, 3) else { panic!("{bends:?}") };
            assert_eq!((linear.alone, linear.form), (alone, 3), "{bends:?} {linear:?}");
            assert!((linear.reach[0] - 0.5 * (xx + yy)).abs() < 1e-12 && linear.reach[1] < 1e-12, "{linear:?}");
            assert!((linear.middle[0] + 0.1).abs() < 1e-12 && (linear.middle[1] + 0.1).abs() < 1e-12, "{linear:?}");
        }
    }
    // Outside by more than what is left over: none.
    let far = |constant: f64| {
        let curved = Quadratic { constant, slope: [1.0, 0.0], bend: [0.0, 0.5, 0.0] }.around([0.0; 2], [1.0; 2]);
        let straight = Quadratic { constant: 0.0, slope: [0.0, 1.0], bend: [0.0; 3] }.around([0.0; 2], [1.0; 2]);
        matches!(judge(&[curved, straight], [1.0; 2], 0), Verdict::Empty)
    };
    assert!(far(1.251) && far(-1.251) && !far(1.249) && !far(-1.249));
}

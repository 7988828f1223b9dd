//! Models of cubics, their sums and products, against samples and corners.

use vibrochain_testkit::Random;

use super::*;

/// A cubic of x or y or x + y about 0, and what it is at a point.
fn cubic(random: &mut Random, axes: [bool; 2], radius: [f64; 2]) -> (Taylor<2>, impl Fn([f64; 2]) -> f64 + use<>) {
    let [value, first, second, third] = [(); 4].map(|()| random.between(-1.0, 1.0));
    let at = move |x: [f64; 2]| {
        let s = (0..2).filter(|i| axes[*i]).map(|i| x[i]).sum::<f64>();
        value + s * (first + s * (0.5 * second + s * third / 6.0))
    };
    (Taylor::of_sum(axes, [value, first, second], third.abs(), radius), at)
}

/// The most that a function is away from the linear part, over `rest`; its size over `most`; and its least size.
fn worst(model: &Taylor<2>, at: impl Fn([f64; 2]) -> f64) -> [f64; 3] {
    let mut worst = [0.0_f64, 0.0, f64::INFINITY];
    for (i, j) in (-10..=10).flat_map(|i| (-10..=10).map(move |j| (i, j))) {
        let x = [f64::from(i) / 10.0 * model.radius[0], f64::from(j) / 10.0 * model.radius[1]];
        let (value, linear) = (at(x), model.value + model.slope[0] * x[0] + model.slope[1] * x[1]);
        worst[0] = worst[0].max((value - linear).abs() / model.rest);
        worst[1] = worst[1].max(value.abs() / model.most());
        worst[2] = worst[2].min(value.abs());
    }
    worst
}

/// A model, and the function that it is of.
type Modelled<'a> = (Taylor<2>, Box<dyn Fn([f64; 2]) -> f64 + 'a>);

/// Sums, differences and products of cubics on boxes: what is left over is within `rest`, which the corners of a box attain where all terms
/// have one sign; sizes are between clearance and most.
#[test]
fn what_is_left_over_is_within_the_rest_and_reaches_it() {
    let mut random = Random(7);
    let (mut attained, mut clear) = ([0; 4], 0);
    for round in 0..1200 {
        let radius = [random.log(1e-3, 1.0), random.log(1e-3, 1.0)];
        let axes = [[true, false], [false, true], [true, true]];
        let (f, f_at) = cubic(&mut random, axes[round % 3], radius);
        let (g, g_at) = cubic(&mut random, axes[(round / 3) % 3], radius);
        let factor = random.between(-3.0, 3.0);
        let all: [Modelled<'_>; 4] = [
            (f, Box::new(&f_at)),
            (f + g, Box::new(|x| f_at(x) + g_at(x))),
            (f.scaled(factor) - g.shifted(0.3), Box::new(|x| factor * f_at(x) - g_at(x) - 0.3)),
            (f * g, Box::new(|x| f_at(x) * g_at(x))),
        ];
        for (number, (model, at)) in all.iter().enumerate() {
            let [rest, most, least] = worst(model, at);
            assert!(rest <= 1.0 + 1e-12 && most <= 1.0 + 1e-12, "{round} {number}: {rest} {most} {model:?}");
            assert!(least >= model.clearance(), "{round} {number}: {least} {model:?}");
            attained[number] += usize::from(rest > 0.9);
            clear += usize::from(model.clearance() > 0.5 * least);
        }
    }
    assert!(attained.iter().all(|count| *count > 100) && attained[0] > 400 && clear > 1000, "{attained:?} {clear}");
}

/// Rounding is told as it is: of a value, of a sum that cancels, of a product.
#[test]
fn rounding_is_part_of_the_rest() {
    let at = |value: f64| Taylor::<1>::of_sum([true], [value, 0.0, 0.0], 0.0, [0.0]);
    let mut random = Random(9);
    for _ in 0..1000 {
        let [a, b] = [random.log(1e-6, 1e6), -random.log(1e-6, 1e6)];
        assert_eq!(at(a).rest, SUMS * a);
        let (sum, product) = (at(a) + at(b), at(a) * at(b));
        let told = [sum.rest - SUMS * (a - b), product.rest - SUMS * (2.0 + SUMS) * (a * b).abs()];
        // Half a unit in the last place is what one operation takes; a whole one is told.
        for (told, size) in told.into_iter().zip([a - b, (a * b).abs()]) {
            assert!(told > 0.9 * f64::EPSILON * size && told < 1.1 * f64::EPSILON * size, "{a} {b} {told:e}");
        }
    }
}

/// The ends of an interval: values there, and a doubt that also takes ends that are not quite where the radius says.
#[test]
fn ends_are_as_far_off_as_they_say() {
    let mut random = Random(11);
    for _ in 0..300 {
        let (radius, jet) = (random.log(1e-6, 1.0), [(); 3].map(|()| random.between(-1.0, 1.0)));
        let model = Taylor::<1>::of_sum([true], jet, 0.0, [radius]);
        let (ends, doubt) = model.ends();
        for (end, sign) in ends.into_iter().zip([-1.0, 1.0]) {
            for part in [1.0 - ROUNDED, 1.0] {
                let x = sign * radius * part;
                let value = jet[0] + x * (jet[1] + 0.5 * x * jet[2]);
                assert!((value - end).abs() <= doubt, "{value} {end} {doubt}");
            }
        }
        let least = radius * (0.5 * radius * jet[2].abs() + ROUNDED * jet[1].abs());
        assert!(doubt < 1.01 * least + 2.0 * SUMS * jet[0].abs(), "{doubt} {least}");
    }
}

//! Models of two variables, against samples and against what attains their bounds.

use vibrochain_testkit::Random;

use super::*;

#[test]
fn patches_contain_what_they_enclose() {
    // f = sin x (cos 3y − 0.3) + x-free and y-free terms + 1/(2 + sin(x + y)), about several centres.
    for (x0, y0) in [(0.0, 0.0), (1e-6, 0.3), (-1.0, 2.0), (0.4_f64, -0.7_f64)] {
        for r in [[0.5, 0.2], [0.1, 0.1], [1e-3, 1e-2]] {
            let sin = Piece::wave([x0.sin(), -x0.cos()], 1.0, 1.0).along(0, r);
            let cos = Piece::wave([(3.0 * y0).cos(), (3.0 * y0).sin()], 3.0, 1.0).along(1, r);
            let both = Piece::wave([(x0 + y0).sin(), -(x0 + y0).cos()], 1.0, 1.0).of([true; 2], r);
            let inverse = both.shifted(2.0).reciprocal().unwrap();
            let f = sin * cos.shifted(-0.3) + cos.scaled(2.0) - sin + inverse;
            for i in -20..=20 {
                for j in -20..=20 {
                    let (x, y) = (f64::from(i) / 20.0 * r[0], f64::from(j) / 20.0 * r[1]);
                    let (sx, cx) = (x0 + x).sin_cos();
                    let (sy, cy) = (3.0 * (y0 + y)).sin_cos();
                    let (sin, cos) = (x0 + x + y0 + y).sin_cos();
                    let (inverse, rise) = ((2.0 + sin).recip(), -cos / ((2.0 + sin) * (2.0 + sin)));
                    let value = sx * (cy - 0.3) + 2.0 * cy - sx + inverse;
                    let slopes = [cx * (cy - 0.3) - cx + rise, -3.0 * sx * sy - 6.0 * sy + rise];
                    let middle = f.value() + f.slope()[0] * x + f.slope()[1] * y;
                    assert!((value - middle).abs() <= f.rest() + 1e-15);
                    assert!(value.abs() <= f.bound() + 1e-15);
                    for k in 0..2 {
                        assert!((slopes[k] - f.slope()[k]).abs() <= f.swing()[k] + 1e-14);
                    }
                }
            }
            // Useful, not only safe: the excess is of second order.
            assert!(f.rest() < 40.0 * (r[0] * r[0] + r[1] * r[1]) + 1e-14);
        }
    }
}

/// Half widths of slopes are attained: by a cubic of either variable or of their sum, by the product of two lines, by an inverse; and rounding is
/// carried along with what multiplies it.
#[test]
fn swings_are_attained_and_not_exceeded() {
    let mut random = Random(13);
    for round in 0..300 {
        let radius = [random.log(1e-3, 0.5), random.log(1e-3, 0.5)];
        let jet = [(); 3].map(|()| random.between(-1.0, 1.0));
        let third = random.between(-1.0, 1.0);
        let axes = [[true, false], [false, true], [true, true]][round % 3];
        let patch = Piece { jet, third: third.abs(), doubt: 0.0 }.of(axes, radius);
        let s = reach(axes, radius);
        let slopes = [-s, s].map(|s| jet[1] + s * (jet[2] + 0.5 * s * third) - jet[1]);
        let most = slopes.iter().fold(0.0, |most: f64, slope| most.max(slope.abs()));
        for axis in 0..2 {
            let swing = patch.swing()[axis];
            assert!(if axes[axis] { swing >= most && swing < most * (1.0 + 1e-9) + 1e-14 } else { swing == 0.0 });
        }
        let line = |axis: usize, value: f64, slope: f64| {
            Piece { jet: [value, slope, 0.0], third: 0.0, doubt: 0.0 }.along(axis, radius)
        };
        // (a + bx)(c + dy): its slopes b(c + dy) and d(a + bx).
        let [a, b, c, d] = [(); 4].map(|()| random.between(-1.0, 1.0));
        let product = line(0, a, b) * line(1, c, d);
        let least = [(b * d).abs() * radius[1], (b * d).abs() * radius[0]];
        for axis in 0..2 {
            let swing = product.swing()[axis];
            assert!(swing >= least[axis] && swing < least[axis] * (1.0 + 1e-9) + 1e-13, "{swing} {least:?}");
        }
        // 1/(2 + bx) has the slope −b/(2 + bx)².
        let inverse = line(0, 2.0, b).reciprocal().unwrap();
        let x = -radius[0] * b.signum();
        let least = (b / (2.0 + b * x).powi(2) - b / 4.0).abs();
        assert!(
            inverse.swing()[0] >= least && inverse.swing()[0] < 1.9 * least + 1e-13,
            "{:?} {least}",
            inverse.swing()
        );
        assert!(inverse.swing()[1] < 1e-13);
        // A doubt of one factor is multiplied by the other, of a divisor by the inverse squared.
        let doubt = random.log(1e-9, 1e-6);
        let sum = line(0, a, b).doubted(doubt);
        let (scaled, shifted) = (sum.scaled(-3.0), sum.shifted(1.0));
        assert!((scaled.rounding / doubt - 3.0).abs() < 1e-5 && (shifted.rounding / doubt - 1.0).abs() < 1e-5);
        let by = (sum * line(1, c, d)).rounding / doubt;
        let most = c.abs() + d.abs() * radius[1];
        assert!(by >= most * (1.0 - 1e-5) && by < most * (1.0 + 1e-5) + 1e-5, "{by} {most}");
        let by = line(0, 2.0, b).doubted(doubt).reciprocal().unwrap().rounding / doubt;
        let most = (2.0 - b.abs() * radius[0]).powi(-2);
        assert!(by >= most * (1.0 - 1e-5) && by < most * 1.001, "{by} {most}");
    }
}

/// A sign is told only where the function has it all over the rectangle, and rounding alone is called so.
#[test]
fn signs_are_those_of_the_whole_rectangle() {
    let radius = [0.5, 0.25];
    let plane = |value: f64| {
        Piece { jet: [value, 1.0, 0.0], third: 0.0, doubt: 0.0 }.along(0, radius)
            + Piece { jet: [0.0, 2.0, 0.0], third: 0.0, doubt: 0.0 }.along(1, radius)
    };
    // x + 2y reaches 1 at a corner.
    for (value, sign) in [(1.001, 1.0), (0.999, 0.0), (-0.999, 0.0), (-1.001, -1.0)] {
        assert_eq!(plane(value).sign(), sign);
        assert_eq!(plane(value).excludes_zero(), sign != 0.0);
        assert_eq!(plane(value).reciprocal().is_some(), sign != 0.0);
        assert!((plane(value).bound() - (value.abs() + 1.0)).abs() < 1e-14);
    }
    assert!(plane(1.0).is_blurred() && !(plane(1.0) * plane(1.0)).is_blurred());
    let unknown = plane(0.5).unknown();
    assert!(!unknown.excludes_zero() && unknown.slope() == [0.0; 2] && unknown.rest() > 0.0);
}

//! Turning points of polynomials, against samples of their slopes.

use vibrochain_testkit::Random;

use super::*;

#[test]
fn a_turning_point_that_rounding_puts_before_a_piece_is_found_where_the_flight_goes_on() {
    // −10⁻¹⁷s − s²/2: turns at −10⁻¹⁷.
    let mut coefficients = [0.0; ORDER];
    (coefficients[1], coefficients[2]) = (-1e-17, -0.5);
    let polynomial = Polynomial { coefficients };
    let count = |range| {
        let (mut seen, mut pending) = (0, Vec::new());
        let mut note = |s: f64, value: f64| {
            assert!(s.abs() < 1e-15 && value.abs() < 1e-30);
            seen += 1;
            f64::INFINITY
        };
        turning_points(&polynomial, range, &mut pending, f64::INFINITY, &mut note, 0.0);
        seen
    };
    assert_eq!(count(with_overlap(1.0, [false, true])), 0);
    assert_eq!(count(with_overlap(1.0, [true, false])), 1);
    assert_eq!(with_overlap(2.0, [false; 2]), [0.0, 2.0]);
}

/// A sum of sines to rounding on −1 … 1.
fn sines(random: &mut Random) -> Polynomial {
    let mut coefficients = [0.0; ORDER];
    for _ in 0..3 {
        let (size, rate, phase) = (random.between(-1.0, 1.0), random.log(0.3, 3.0), random.between(0.0, 6.3));
        let mut term = size;
        for (k, c) in coefficients.iter_mut().enumerate() {
            *c += term * (phase + std::f64::consts::FRAC_PI_2 * k as f64).sin();
            term *= rate / (k + 1) as f64;
        }
    }
    Polynomial { coefficients }
}

/// All turning points of random motions, and of those that could come closer than what is known the closest; third derivatives within their bound,
/// which is attained where all terms have one sign.
#[test]
fn all_turning_points_are_found_and_the_closest_is_kept() {
    let mut random = Random(37);
    let (mut turns, mut skipped, mut closest) = (0, 0, 0);
    for _ in 0..600 {
        let polynomial = sines(&mut random);
        let range = [-random.between(0.0, 1.0), random.between(0.1, 1.0)];
        let at = |i: i32| range[0] + (range[1] - range[0]) * f64::from(i) / 2000.0;
        let slopes: Vec<f64> = (0..=2000).map(|i| polynomial.evaluate(at(i)).1).collect();
        let changes = slopes.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count();
        let mut pending = Vec::new();
        let mut places: Vec<(f64, f64)> = Vec::new();
        let mut note = |s: f64, value: f64| {
            places.push((s, value));
            f64::INFINITY
        };
        turning_points(&polynomial, range, &mut pending, f64::INFINITY, &mut note, 0.0);
        assert_eq!(places.len(), changes, "{polynomial:?} {range:?} {places:?}");
        for (s, value) in &places {
            let [there, slope, curvature] = polynomial.jet(*s);
            assert!(slope.abs() < 1e-7 * curvature.abs() && (there - value).abs() < 1e-15, "{slope} {curvature}");
        }
        turns += places.len();
        // Of those nearer to a barrier than what is known: about a middle, from a distance that is known.
        let (a, known) = (random.between(-0.5, 0.5), random.between(-0.5, 1.5));
        let distance = |value: f64| 1.0 - (value - a).abs();
        let least = places.iter().map(|(_, value)| distance(*value)).fold(known, f64::min);
        let (mut found, mut looked) = (known, 0);
        let mut keep = |_: f64, value: f64| {
            looked += 1;
            found = found.min(distance(value));
            found
        };
        turning_points(&polynomial, range, &mut pending, known, &mut keep, a);
        assert!((found - least).abs() < 1e-15, "{found} {least}");
        skipped += places.len() - looked;
        closest += usize::from(found < known);
        let bound = polynomial.third_bound(range[1].max(-range[0]));
        let third = |s: f64| {
            let terms = polynomial.coefficients.iter().enumerate().skip(3).rev();
            terms.fold(0.0, |sum, (k, c)| sum * s + c * (k * (k - 1) * (k - 2)) as f64)
        };
        assert!((0..=200).all(|i| third(at(10 * i)).abs() <= bound * (1.0 + 1e-14)));
        let mut positive = polynomial;
        positive.coefficients.iter_mut().for_each(|c| *c = c.abs());
        let all = Polynomial { coefficients: positive.coefficients };
        let most = all.coefficients.iter().enumerate().skip(3).rev();
        let most = most.fold(0.0, |sum, (k, c)| sum * 0.7 + c * (k * (k - 1) * (k - 2)) as f64);
        assert!((all.third_bound(0.7) / most - 1.0).abs() < 1e-14);
    }
    assert!(turns > 300 && skipped > 100 && closest > 100, "{turns} {skipped} {closest}");
}

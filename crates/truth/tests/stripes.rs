//! Widths and growth of stripes against multipliers in 57 digits, to which a stripe of width 1e-20 is a wide one.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::f64::consts::PI;

use vibrochain_breather::{Family, breathers};
use vibrochain_floquet::{Stripe, StripeEnd, StripeFinder, StripeLine};
use vibrochain_lattice::{Chain, Model, Parameter};
use vibrochain_testkit::Random;
use vibrochain_truth::{Complex, DEFAULT_BITS, Real, TrueOrbit, TrueSpectrum};

/// (½Δθ)² of the two multipliers that meet near the angle, negative off the circle: from the parabola through three values of the secular
/// function, about where it is lowest.
fn square(line: &StripeLine, value: f64, angle: f64, itself: bool) -> Real {
    let model = line.model.with(line.free, value).unwrap();
    let orbits = breathers(&model, line.family).unwrap().orbits;
    let orbit = orbits.iter().find(|orbit| orbit.is_reversible()).unwrap();
    let spectrum = TrueSpectrum::new(&TrueOrbit::refine(orbit, DEFAULT_BITS).unwrap()).unwrap();
    let bits = 2 * DEFAULT_BITS;
    // D depends on ν alone.
    let at = |nu: &Real| {
        let square = -(nu * nu) + 1.0;
        let z = if square.is_negative() {
            Complex::real(nu - &square.abs().sqrt())
        } else {
            Complex { re: nu.clone(), im: square.sqrt() }
        };
        spectrum.secular(&z).unwrap().re
    };
    let mut nu = Real::new(angle.cos(), bits);
    let mut step = 1e-9;
    for _ in 0..40 {
        let by = Real::new(step, bits);
        let (low, here, high) = (at(&(&nu - &by)), at(&nu), at(&(&nu + &by)));
        if itself {
            // One root ν, and θ = π ± √(2(1+ν)) about −1.
            let slope = (&high - &low) / (&by * 2.0);
            let next = &nu - &(&here / &slope);
            step = (&next - &nu).abs().to_f64().clamp(1e-26, 1e-9);
            nu = next;
            continue;
        }
        let bend = (&high + &low - &here * 2.0) / (&by * &by);
        let slope = (&high - &low) / (&by * 2.0);
        let move_by = -(&slope / &bend);
        let least = &here + &(&slope * &move_by * 0.5);
        let square = -(&least * 2.0 / &bend);
        if step <= 1e-24 {
            let sine = -(&nu * &nu) + 1.0;
            return square / sine;
        }
        nu = &nu + &move_by;
        step = (move_by.abs().to_f64() + 1e-2 * square.abs().sqrt().to_f64()).clamp(1e-25, 1e-9).min(0.1 * step);
    }
    assert!(itself);
    (nu + 1.0) * 2.0
}

/// Centre, half width and growth from the parabola that the square is along the line.
fn measured(line: &StripeLine, stripe: &Stripe) -> (f64, f64, f64) {
    let ((k, l), _) = stripe.pair.unwrap();
    let (angle, itself) = (stripe.multiplier.arg(), k == l);
    let angle = if itself { PI } else { angle };
    let ulp = |value: f64| value.next_up() - value;
    let mut centre = stripe.centre;
    let mut off = 0.0;
    let mut answer = (0.0, 0.0);
    for _ in 0..3 {
        // Next to the centre, where a parabola is all there is.
        let reach = (stripe.half_width / ulp(centre)).ceil().max(1.0) * ulp(centre);
        let values = [centre - reach, centre, centre + reach];
        let [low, here, high] = values.map(|value| square(line, value, angle, itself));
        let by = Real::new(reach, 2 * DEFAULT_BITS);
        let bend = (&high + &low - &here * 2.0) / (&by * &by);
        let slope = (&high - &low) / (&by * 2.0);
        let move_by = -(&slope / &bend);
        let least = &here + &(&slope * &move_by * 0.5);
        assert!(least.is_negative() && !bend.is_negative(), "{stripe:?} {} {}", least.to_f64(), bend.to_f64());
        answer = ((-(&least * 2.0 / &bend)).sqrt().to_f64(), (-&least).sqrt().to_f64());
        off = move_by.to_f64();
        let next = centre + off;
        if next == centre {
            break;
        }
        off -= next - centre;
        centre = next;
    }
    (centre + off, answer.0, answer.1)
}

#[test]
fn however_thin_a_stripe_is_its_width_and_growth_are_known() {
    let (mut random, mut finder) = (Random(11), StripeFinder::default());
    let (mut checked, mut thin, mut thinnest, mut doubling) = (0, 0, 1.0_f64, 0);
    let mut families = [0, 0];
    while checked < 32 {
        let single = checked % 4 == 3;
        let family = if single { Family::SingleSided } else { Family::DoubleSided };
        // Few stripes of single-sided breathers are thin, those of long rings with a soft coupling.
        let sites = if single { 8 + random.below(14) } else { 3 + random.below(6) };
        let (gamma2, omega) = (random.log(1e-3, 0.3), random.between(if single { 0.5 } else { 0.7 }, 1.6));
        let asymmetry = if single { random.between(0.1, 0.8) } else { random.log(1e-17, 0.8) };
        let model = Model::conservative(Chain::new(sites, 0.2, gamma2).unwrap(), omega, asymmetry).unwrap();
        let free = random.of(&[Parameter::Omega, Parameter::Gamma2, Parameter::Gamma1]);
        let line = StripeLine { model, family, free };
        let start = model.get(free);
        let row = finder.along(&line, (0.8 * start, 1.25 * start), 60).unwrap();
        // Not those that two modes enter and turn to −1 inside.
        let whole = |stripe: &&Stripe| {
            let alone = stripe.pair.is_some_and(|((k, l), _)| (k == l) == (stripe.multiplier.arg().abs() > PI - 1e-9));
            alone && stripe.half_width < 3e-4 * start && stripe.ends == [StripeEnd::Edge; 2]
        };
        let few: Vec<&Stripe> = row.stripes.iter().filter(whole).collect();
        if few.is_empty() {
            continue;
        }
        let stripe = few[random.below(few.len())];
        let (centre, half_width, growth) = measured(&line, stripe);
        let ((k, l), _) = stripe.pair.unwrap();
        // A stripe is no parabola, by its share of the distance of neighbouring modes; and phases carry rounding.
        let spacing = 4.0 * gamma2 / sites as f64;
        let share = (stripe.half_width / spacing).powi(2);
        let allowed = 10.0 * share + 1e-13 / spacing.powi(2);
        let story = format!("{line:?} {stripe:?}: {centre} {half_width:e} {growth:e}");
        assert!((centre - stripe.centre).abs() < stripe.error + 10.0 * share * spacing, "{story}");
        assert!((half_width / stripe.half_width - 1.0).abs() < allowed + 1e-7, "{story}");
        assert!((growth / stripe.growth - 1.0).abs() < allowed + 1e-5, "{story}");
        assert_eq!(stripe.resolved, stripe.half_width > 4.0 * stripe.error);
        if stripe.resolved {
            let angle = if k == l { PI } else { stripe.multiplier.arg() };
            for (part, off) in [(0.0, true), (0.5, true), (-0.5, true), (1.5, false), (-1.5, false)] {
                let square = square(&line, stripe.centre + part * stripe.half_width, angle, k == l);
                assert_eq!(square.is_negative(), off, "{part} {story}");
            }
        }
        checked += 1;
        thin += usize::from(!stripe.resolved);
        doubling += usize::from(k == l);
        families[usize::from(single)] += 1;
        thinnest = thinnest.min(stripe.half_width);
    }
    println!("{checked} stripes, {thin} unresolved, {doubling} of one mode, {families:?}, down to {thinnest:e}");
    assert!(thin > 6 && thinnest < 1e-17 && doubling > 6 && families[1] > 6, "{thin} {thinnest:e} {doubling}");
}

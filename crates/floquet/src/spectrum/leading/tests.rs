//! Zeros that lead, and discs about approximations.

use vibrochain_breather::{BlochEquations, LinearImpact};
use vibrochain_lattice::BlochKernel;
use vibrochain_testkit::Random;

use super::super::clusters::zeros;
use super::super::random_equations;
use super::*;

/// The leading zeros alone are those of all.
#[test]
fn those_that_lead_lead_all() {
    let mut random = Random(61);
    let (mut quick, mut all) = (0, 0);
    for _ in 0..400 {
        let equations = random_equations(&mut random, 0.9);
        let thorough = zeros(&equations, false, &[]);
        if !thorough.certified {
            continue;
        }
        all += 1;
        let Some(list) = SpectralFunction::new(&equations, false).leading(&[]) else { continue };
        quick += 1;
        let largest = |list: &[Zero]| list.iter().map(|zero| modulus(zero.z)).fold(0.0, f64::max);
        let (found, wanted) = (largest(&list), largest(&thorough.list));
        let room: f64 = list.iter().map(|zero| zero.error).fold(1e-13 * (1.0 + wanted), f64::max);
        assert!((found - wanted).abs() <= 4.0 * room, "{found} {wanted} {room:e} {equations:?}");
    }
    assert!(all > 300 && quick > all * 3 / 4, "{quick} of {all}");
}

/// f by its poles and residues is the determinant of J(z), whose own errors are told.
#[test]
fn poles_and_residues_have_the_determinant_of_the_equations() {
    let (mut random, mut checked) = (Random(42), 0);
    for _ in 0..300 {
        let equations = random_equations(&mut random, 0.5);
        let Some(form) = SpectralFunction::new(&equations, false).rational() else { continue };
        for radius in [0.3, 0.9, 1.1, 2.5] {
            let z = C::from_polar(radius, random.between(-3.1, 3.1));
            let (value, size) = (form.evaluate(z), equations.size());
            let expected = determinant(&mut equations.matrix(z), size) * equations.scale();
            let allowed = 1e-12 * value.noise + 4.0 * form.doubt(z);
            assert!((value.f - expected).norm() <= allowed, "{z}: {} {expected} {equations:?}", value.f);
            checked += 1;
        }
    }
    assert!(checked > 800, "{checked}");
}

/// Two modes of one frequency, which two contacts feel, have no simple poles.
#[test]
fn modes_of_one_frequency_are_no_sum_of_simple_poles() {
    let mut kernel = BlochKernel::new(2.4, 2);
    for shapes in [[0.6, 0.6], [0.8, -0.4], [0.0, 0.7]] {
        kernel.push_oscillator(if shapes[0] == 0.6 { 0.4 } else { 0.5 }, 0.0, &shapes);
    }
    let impact = |contact: usize, time: f64| LinearImpact {
        contact,
        time,
        impulse: -0.7,
        restitution: 0.9,
        acceleration_before: 0.3,
    };
    let equations = BlochEquations::new(kernel, vec![impact(0, 0.0), impact(1, 1.1)]);
    let function = SpectralFunction::new(&equations, false);
    assert!(function.rational().is_none() && function.leading(&[]).is_none());
    let all = zeros(&equations, false, &[]);
    assert!(all.certified && all.list.len() == 6, "{all:?}");
}

/// f with these zeros and poles, both in pairs; of each residue an error of this part of it.
fn rational(zeros: &[C], poles: &[C], error: f64) -> Rational {
    let all = poles.iter().flat_map(|pole| [*pole, pole.conj()]);
    let residue = |pole: &C| {
        let ways = all.clone().filter(|other| other != pole).map(|other| pole - other);
        zeros.iter().map(|zero| pole - zero).product::<C>() / ways.product::<C>()
    };
    let residues: Vec<C> = poles.iter().map(residue).collect();
    let mut form = Rational::default();
    fill(&mut form.pole_re, poles.iter().map(|pole| pole.re), 1e100);
    fill(&mut form.pole_im, poles.iter().map(|pole| pole.im), 0.0);
    fill(&mut form.residue_re, residues.iter().map(|residue| residue.re), 0.0);
    fill(&mut form.residue_im, residues.iter().map(|residue| residue.im), 0.0);
    fill(&mut form.residue_error, residues.iter().map(|residue| error * modulus(*residue)), 0.0);
    fill(&mut form.pole_error, poles.iter().map(|_| 0.0), 0.0);
    form
}

/// Poles in the upper half plane, apart from each other.
fn apart(count: usize, random: &mut Random) -> Vec<C> {
    let angle = |k: usize| std::f64::consts::PI * (k as f64 + 0.5) / count as f64;
    (0..count).map(|k| C::from_polar(random.between(0.6, 0.9), angle(k))).collect()
}

/// Of approximations all around a zero of multiplicity n each W reaches an n-th part of the way: with Smith's factor the discs reach it, and no
/// farther.
#[test]
fn discs_reach_a_multiple_zero_exactly() {
    let mut random = Random(71);
    for pairs in 1..=6 {
        let (n, centre, radius) = (2 * pairs, C::new(random.between(-0.5, 0.5), 0.0), random.log(1e-2, 0.5));
        let poles = apart(pairs, &mut random);
        let form = rational(&vec![centre; n], &poles, 0.0);
        let angle = |k: usize| std::f64::consts::PI * (2 * k + 1) as f64 / n as f64;
        let around = (0..pairs).map(|k| centre + C::from_polar(radius, angle(k)));
        let roots: Vec<C> = around.flat_map(|z| [z, z.conj()]).collect();
        let reaches = discs(&form, &poles, &roots);
        assert_eq!(reaches.len(), n);
        for reach in reaches {
            // Rounding of f, where it is as small as (r/|z−p|)ⁿ.
            let rounding = 1e-12 * radius.powi(1 - n as i32) * n as f64;
            assert!(
                reach >= radius * (1.0 - 1e-9) && reach <= radius * (1.0 + 1e-9) + rounding,
                "{n}: {reach} {radius}"
            );
        }
    }
}

/// Wherever the zeros are, each is in a disc; errors of residues move them no farther, and discs are no larger than both ask for.
#[test]
fn every_zero_is_in_a_disc() {
    let mut random = Random(73);
    let (mut checked, mut near) = (0, 0);
    for _ in 0..300 {
        let pairs = 1 + random.below(6);
        let poles = apart(pairs, &mut random);
        let mut pair = || C::new(random.between(-1.0, 1.0), random.between(0.05, 1.0));
        let zeros: Vec<C> = (0..pairs).map(|_| pair()).flat_map(|z| [z, z.conj()]).collect();
        let off = random.log(1e-8, 1e-2);
        let moved = zeros.chunks(2).map(|pair| pair[0] + C::from_polar(off, random.between(0.0, 6.3)));
        let roots: Vec<C> = moved.flat_map(|z| [z, z.conj()]).collect();
        let reaches = discs(&rational(&zeros, &poles, 0.0), &poles, &roots);
        for zero in &zeros {
            let inside = |(z, reach): (&C, &f64)| modulus(z - zero) <= *reach;
            assert!(roots.iter().zip(&reaches).any(inside), "{zeros:?} {roots:?} {reaches:?}");
            checked += 1;
        }
        near += usize::from(reaches.iter().all(|reach| *reach < 4.0 * zeros.len() as f64 * off));
        // The zeros of f with other residues, by Newton's method, where they are close by.
        let error = random.log(1e-9, 1e-6);
        let form = rational(&zeros, &poles, error);
        let mut other = form.clone();
        let turned = |x: &mut f64, random: &mut Random| *x *= 1.0 + error * random.between(-0.7, 0.7);
        other.residue_re.as_flattened_mut().iter_mut().for_each(|x| turned(x, &mut random));
        other.residue_im.as_flattened_mut().iter_mut().for_each(|x| turned(x, &mut random));
        let reaches = discs(&form, &poles, &zeros);
        for zero in &zeros {
            let mut z = *zero;
            for _ in 0..20 {
                let value = other.evaluate(z);
                z -= value.f / value.slope;
            }
            let inside = |(at, reach): (&C, &f64)| modulus(at - z) <= *reach;
            assert!(zeros.iter().zip(&reaches).any(inside), "{zero} {z} {reaches:?}");
            checked += 1;
        }
    }
    assert!(checked > 3000 && near > 150, "{checked} {near}");
}

//! f by its poles and residues, and what their errors do.

use vibrochain_testkit::Random;

use super::*;

/// What errors of poles and residues make of f is within the doubt, and with one pole, in the worst direction, as much as half of it: of the
/// pole and its conjugate.
#[test]
fn doubts_are_what_errors_do() {
    let mut random = Random(5);
    let mut near = 0;
    for round in 0..600 {
        let count = [1, 2, 5, 9][round % 4];
        let pole = |k: usize| C::from_polar(0.9, 3.0 * (k as f64 + 0.5) / count as f64);
        let residues: Vec<C> =
            (0..count).map(|_| C::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0))).collect();
        let z = C::from_polar(random.between(0.2, 2.0), random.between(-3.1, 3.1));
        let distance = (0..count).map(|k| (z - pole(k)).norm().min((z - pole(k).conj()).norm())).fold(9.0, f64::min);
        if distance < 0.05 {
            continue;
        }
        let [of_poles, of_residues] =
            [[0.0, 1e-7], [1e-7, 0.0], [1e-7, 1e-7]][round % 3].map(|size| size * random.unit());
        let form = |moved: bool, random: &mut Random| {
            let mut form = Rational::default();
            let way = |size: f64, random: &mut Random| {
                if moved { C::from_polar(size, random.between(0.0, 6.3)) } else { C::default() }
            };
            for (k, residue) in residues.iter().enumerate() {
                let (pole, residue) = (pole(k) + way(of_poles, random), residue + way(of_residues, random));
                let errors = [of_residues, of_poles * residue.norm()];
                let lists = [&mut form.pole_re, &mut form.pole_im, &mut form.residue_re, &mut form.residue_im];
                let values = [pole.re, pole.im, residue.re, residue.im];
                lists.into_iter().zip(values).for_each(|(list, value)| list.push([value, 1e100, 1e100, 1e100]));
                form.residue_error.push([errors[0], 0.0, 0.0, 0.0]);
                form.pole_error.push([errors[1], 0.0, 0.0, 0.0]);
            }
            for lists in [&mut form.residue_re, &mut form.residue_im] {
                lists.iter_mut().for_each(|lane| lane[1..].fill(0.0));
            }
            form.pole_im.iter_mut().for_each(|lane| lane[1..].fill(0.0));
            form
        };
        let plain = form(false, &mut random);
        let (doubt, value) = (plain.doubt(z), plain.evaluate(z));
        // f as it is written down.
        let direct = residues.iter().enumerate().fold(C::new(1.0, 0.0), |sum, (k, residue)| {
            sum + residue / (z - pole(k)) + residue.conj() / (z - pole(k).conj())
        });
        assert!((value.f - direct).norm() <= 4.0 * f64::EPSILON * value.noise, "{} {direct}", value.f);
        let size: f64 = (residues.iter().enumerate())
            .map(|(k, residue)| residue.norm() * (1.0 / (z - pole(k)).norm() + 1.0 / (z - pole(k).conj()).norm()))
            .sum();
        assert!(value.noise >= 1.0 + size * (1.0 - 1e-9) && value.noise <= 1.0 + size * 1.4143);
        let h = 1e-6;
        let slope = (plain.evaluate(z + h).f - plain.evaluate(z - h).f) / (2.0 * h);
        assert!((slope - value.slope).norm() < 1e-4 * (1.0 + value.slope.norm()) / distance.powi(2));
        let mut most = 0.0_f64;
        for _ in 0..20 {
            most = most.max((form(true, &mut random).evaluate(z).f - value.f).norm());
        }
        // Of second order: an error over the distance.
        assert!(most <= doubt * (1.0 + 1e-4), "{most:e} {doubt:e}");
        near += usize::from(most > 0.4 * doubt);
    }
    assert!(near > 200, "{near}");
}

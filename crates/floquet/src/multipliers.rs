//! From matrices to multipliers.

use nalgebra::Complex;
use vibrochain_breather::Orbit;
use vibrochain_lattice::Spectrum;

/// μ and 1/μ from ν = ½(μ + 1/μ), the larger modulus first.
pub(crate) fn pair(nu: Complex<f64>) -> [Complex<f64>; 2] {
    let one = Complex::new(1.0, 0.0);
    if nu.im == 0.0 && nu.re.abs() <= 1.0 {
        let im = ((1.0 - nu.re) * (1.0 + nu.re)).sqrt();
        return [Complex::new(nu.re, im), Complex::new(nu.re, -im)];
    }
    // √(ν²−1) by factors: next to ±1 the difference keeps its digits.
    let root = (nu - one).sqrt() * (nu + one).sqrt();
    let (plus, minus) = (nu + root, nu - root);
    let large = if plus.norm_sqr() >= minus.norm_sqr() { plus } else { minus };
    [large, large.inv()]
}

/// Multipliers of the modes odd about the one site that is hit, exactly e^{±iΩ_kT}: the impacts are at their node. In
/// pairs, k = 1 … ⌊(M−1)/2⌋; `None` for impacts at several sites, where no mode is spared.
pub fn odd_multipliers(orbit: &Orbit) -> Option<Vec<Complex<f64>>> {
    orbit.impact_site()?;
    let chain = orbit.model().chain();
    let spectrum = Spectrum::new(*chain);
    let pairs = spectrum.frequencies().iter().skip(1).take(chain.odd_modes());
    Some(pairs.flat_map(|f| [1.0, -1.0].map(|sign| Complex::from_polar(1.0, sign * f * orbit.period()))).collect())
}

/// Sorts by falling modulus, then by argument from −π to π. Moduli that differ from 1 by rounding count as 1, so that the
/// order on the circle is that of the angle.
pub fn sort_multipliers(values: &mut [Complex<f64>]) {
    let modulus = |value: &Complex<f64>| {
        let r = value.re.hypot(value.im);
        if (r - 1.0).abs() < 1e-12 { 1.0 } else { r }
    };
    values.sort_by(|a, b| modulus(b).total_cmp(&modulus(a)).then(a.arg().total_cmp(&b.arg())));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_reciprocal_and_on_the_circle_where_they_should_be() {
        for (re, im) in [(0.3, 0.0), (-1.0, 0.0), (1.0, 0.0), (1.5, 0.0), (-7.0, 0.0), (0.2, 0.4), (1.0 + 1e-12, 0.0)] {
            let nu = Complex::new(re, im);
            let [a, b] = pair(nu);
            assert!((a * b - Complex::new(1.0, 0.0)).norm() < 1e-15);
            assert!(((a + b) * 0.5 - nu).norm() < 1e-15 * (1.0 + nu.norm()));
            if im == 0.0 && re.abs() <= 1.0 {
                assert!((a.norm() - 1.0).abs() < 1e-15);
            }
        }
        // Just outside +1 the growth is √(2δ), to full relative accuracy.
        let delta = 2f64.powi(-40);
        let [a, _] = pair(Complex::new(1.0 + delta, 0.0));
        assert!(((a.re - 1.0) / ((2.0 * delta).sqrt() + delta) - 1.0).abs() < 1e-9);
    }
}

//! From matrices to multipliers.

use nalgebra::Complex;
use vibrochain_breather::Orbit;
use vibrochain_lattice::Spectrum;

/// Multipliers of the modes odd about the one site that is hit, exactly e^{±iΩ_kT}: the impacts are at their node. In
/// pairs, k = 1 … ⌊(M−1)/2⌋; `None` for impacts at several sites, where no mode is spared.
pub fn odd_multipliers(orbit: &Orbit) -> Option<Vec<Complex<f64>>> {
    orbit.centre()?;
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

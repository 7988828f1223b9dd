//! From matrices to multipliers.

use nalgebra::Complex;
use vibrochain_breather::Orbit;
use vibrochain_lattice::{Chain, Shapes, Spectrum};

use crate::map_paths::{by_frequency, sort_felt};

/// Multipliers of the modes that have a node at the one site that is hit, exactly e^{±iΩ_kT}: on a ring those odd about it, in
/// pairs, k = 1 … ⌊(M−1)/2⌋. `None` for impacts at several sites.
pub fn odd_multipliers(orbit: &Orbit) -> Option<Vec<Complex<f64>>> {
    let modes = spared_modes(orbit)?;
    let both = |f: f64| [1.0, -1.0].map(|sign| Complex::from_polar(1.0, sign * f * orbit.period()));
    Some(modes.into_iter().flat_map(|(_, frequency)| both(frequency)).collect())
}

/// Number and frequency of each mode that impacts at a site feel, by rising frequency: on a ring all that are even about it, on other
/// lattices those without a node there. (Of several modes with one frequency one combination is felt; all are listed.)
pub fn participating_modes(chain: &Chain, site: usize) -> Vec<(usize, f64)> {
    let spectrum = Spectrum::new(*chain);
    let frequencies = spectrum.frequencies();
    let order = if chain.is_ring() { (0..frequencies.len() as u32).collect() } else { felt(chain, site, frequencies) };
    order.into_iter().map(|k| (k as usize, frequencies[k as usize])).collect()
}

/// Numbers of the modes without a node at a site, by rising frequency.
fn felt(chain: &Chain, site: usize, frequencies: &[f64]) -> Vec<u32> {
    let squares: Vec<f64> = Shapes::new(chain).evens(site, site).take(frequencies.len()).collect();
    let mut order = Vec::new();
    sort_felt(frequencies, &squares, &mut order);
    order
}

/// Number and frequency of each mode that the impacts at the orbit's one site do not feel; of several modes with one frequency all but
/// one combination.
pub(crate) fn spared_modes(orbit: &Orbit) -> Option<Vec<(usize, f64)>> {
    let site = orbit.impact_site()?;
    let chain = orbit.model().chain();
    let spectrum = Spectrum::new(*chain);
    let frequencies = spectrum.frequencies();
    if chain.is_ring() {
        return Some(frequencies.iter().copied().enumerate().skip(1).take(chain.odd_modes()).collect());
    }
    let order = felt(chain, site, frequencies);
    let mut spared: Vec<usize> = (0..frequencies.len()).map(|k| chain.multiplicity(k)).collect();
    by_frequency(frequencies, &order).filter_map(|alike| alike.first()).for_each(|&first| spared[first as usize] -= 1);
    let all = spared.into_iter().enumerate().zip(frequencies);
    Some(all.flat_map(|((k, number), f)| std::iter::repeat_n((k, *f), number)).collect())
}

/// Sorts by falling modulus, then by argument from −π to π. Moduli that differ from 1 by rounding count as 1, so that the
/// order on the circle is that of the angle.
pub fn sort_multipliers(values: &mut [Complex<f64>]) {
    let arguments = |a: &Complex<f64>, b: &Complex<f64>| a.arg().total_cmp(&b.arg());
    values.sort_by(|a, b| modulus_in_order(b).total_cmp(&modulus_in_order(a)).then_with(|| arguments(a, b)));
}

/// |z| as multipliers are sorted by it.
pub(crate) fn modulus_in_order(z: &Complex<f64>) -> f64 {
    let r = z.re.hypot(z.im);
    if (r - 1.0).abs() < 1e-12 { 1.0 } else { r }
}

//! From matrices to multipliers.

use nalgebra::Complex;
use vibrochain_breather::{LatticeOrbit, Orbit};
use vibrochain_lattice::{Chain, Shapes, Spectrum};

use crate::map_paths::{by_frequency, sort_felt};

/// Multipliers of the modes that have a node at the one site that is hit, exactly e^{±iΩ_kT}: on a ring those odd about it, in
/// pairs, k = 1 … ⌊(M−1)/2⌋. `None` for impacts at several sites, with dashpots, and of other structures.
pub fn odd_multipliers(orbit: &Orbit) -> Option<Vec<Complex<f64>>> {
    let modes = spared_modes(orbit.lattice().ok()?)?;
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
pub(crate) fn spared_modes(orbit: LatticeOrbit<'_>) -> Option<Vec<(usize, f64)>> {
    let site = orbit.impact_site().filter(|_| !orbit.model().is_damped())?;
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

/// Frequencies of a lattice's modes, each as often as there are such modes, but for those that are felt.
pub(crate) fn unfelt_frequencies(chain: &Chain, felt: impl Iterator<Item = f64>) -> Vec<f64> {
    let spectrum = Spectrum::new(*chain);
    let own = spectrum.frequencies().iter().enumerate();
    let mut left: Vec<f64> = own.flat_map(|(k, f)| std::iter::repeat_n(*f, chain.multiplicity(k))).collect();
    left.sort_unstable_by(f64::total_cmp);
    for frequency in felt {
        let above = left.partition_point(|other| *other < frequency);
        let near = above.saturating_sub(1)..(above + 1).min(left.len());
        let nearest = near.min_by(|&a, &b| (left[a] - frequency).abs().total_cmp(&(left[b] - frequency).abs()));
        nearest.map(|place| left.remove(place));
    }
    left
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

#[cfg(test)]
mod tests {
    use nalgebra::SymmetricEigen;
    use vibrochain_breather::Hit;
    use vibrochain_lattice::{Barrier, Ends, Model};
    use vibrochain_testkit::stiffness;

    use super::*;

    /// Of each frequency of the stiffness matrix all modes but one combination are spared, and that one, too, where all have a node.
    #[test]
    fn spared_modes_are_those_with_a_node_at_the_site() {
        let ring = Chain::new(6, 0.3, 0.1).unwrap();
        let row = Chain::new(5, 0.3, 0.1).unwrap();
        let lattices = [
            ring,
            Chain::new(7, 0.3, 0.1).unwrap(),
            row.with_ends(Ends::Fixed),
            row.with_ends(Ends::Free),
            Chain::new(3, 0.3, 0.1).unwrap().with_layers(3, 0.1, Ends::Closed).unwrap(),
            row.with_ends(Ends::Fixed).with_layers(3, 0.04, Ends::Free).unwrap(),
        ];
        let (mut spared_in_all, mut nodes) = (0, 0);
        for chain in lattices {
            let eigen = SymmetricEigen::new(stiffness(&chain));
            let mut order: Vec<usize> = (0..chain.sites()).collect();
            order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
            for site in 0..chain.sites().min(4) {
                let (mut right, mut felt) = (Vec::new(), Vec::new());
                let alike = |i: &usize, j: &usize| (eigen.eigenvalues[*i] - eigen.eigenvalues[*j]).abs() < 1e-9;
                for alike in order.chunk_by(alike) {
                    let weight: f64 = alike.iter().map(|&k| eigen.eigenvectors[(site, k)].powi(2)).sum();
                    let frequency = eigen.eigenvalues[alike[0]].sqrt();
                    let has_node = weight < 1e-12;
                    nodes += usize::from(has_node);
                    right.extend(std::iter::repeat_n(frequency, alike.len() - usize::from(!has_node)));
                    felt.extend(Some(frequency).filter(|_| !has_node));
                }
                let model = Model::conservative(chain, 1.234, 0.2).unwrap();
                let orbit = Orbit::from_impulses(&model, 1, 0.0, &[Hit::new(site, Barrier::Lower, 0.0, 1.0)]).unwrap();
                let mut spared = spared_modes(orbit.lattice().unwrap()).unwrap();
                let spectrum = Spectrum::new(chain);
                assert!(spared.iter().all(|(k, frequency)| spectrum.frequencies()[*k] == *frequency), "{chain} {site}");
                spared.sort_by(|a, b| a.1.total_cmp(&b.1));
                let near = |told: &[f64], right: &[f64]| {
                    told.len() == right.len() && told.iter().zip(right).all(|(a, b)| (a - b).abs() < 1e-7)
                };
                let told: Vec<f64> = spared.iter().map(|(_, frequency)| *frequency).collect();
                assert!(near(&told, &right), "{chain} {site}: {told:?} {right:?}");
                spared_in_all += told.len();
                let multipliers = odd_multipliers(&orbit).unwrap();
                let turned = |frequency: &f64| Complex::from_polar(1.0, frequency * orbit.period());
                assert_eq!(multipliers.len(), 2 * right.len());
                for mu in right.iter().flat_map(|frequency| [turned(frequency), turned(frequency).conj()]) {
                    assert!(multipliers.iter().any(|other| (other - mu).norm() < 1e-6), "{chain} {site}: {mu}");
                }
                let mut modes: Vec<f64> = participating_modes(&chain, site).into_iter().map(|(_, f)| f).collect();
                modes.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
                assert!(near(&modes, &felt), "{chain} {site}: {modes:?} {felt:?}");
            }
        }
        assert!(spared_in_all > 50 && nodes > 5, "{spared_in_all} {nodes}");
    }

    /// By falling modulus; on the circle, to rounding, by the angle.
    #[test]
    fn multipliers_are_sorted_by_modulus_then_by_angle() {
        let polar = Complex::from_polar;
        let mut values =
            [polar(0.5, 0.0), polar(1.0 + 1e-14, 2.0), polar(1.0, -2.0), polar(3.0, 1.0), polar(1.0 - 1e-14, 0.1)];
        sort_multipliers(&mut values);
        let angles: Vec<f64> = values.iter().map(|z| z.arg()).collect();
        assert!(angles.iter().zip([1.0, -2.0, 0.1, 2.0, 0.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{angles:?}");
        assert!(modulus_in_order(&polar(1.0 + 1e-9, 0.3)) > 1.0 && modulus_in_order(&polar(1.0 - 1e-14, 0.3)) == 1.0);
    }
}

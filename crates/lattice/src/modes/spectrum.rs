//! Normal modes of the ring: Ω_k² = γ₁ + 4γ₂ sin²(πk/M).

use crate::model::chain::Chain;
use crate::modes::row::Line;

/// Frequencies and weights of the modes even about site 0, k = 0 … ⌊M/2⌋.
///
/// The modes odd about site 0 have the same frequencies, k = 1 … ⌊(M−1)/2⌋.
///
/// ```
/// use vibrochain_lattice::{Chain, Spectrum};
/// let spectrum = Spectrum::new(Chain::new(4, 0.2, 0.1)?);
/// let (low, high) = spectrum.band();
/// assert!((low * low - 0.2).abs() < 1e-15 && (high * high - 0.6).abs() < 1e-15);
/// # Ok::<(), vibrochain_lattice::ParameterError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    chain: Chain,
    /// 4 sin²(πk/M), which depends on M alone, and the same across layers.
    shape: Vec<f64>,
    shape_across: Vec<f64>,
    frequencies: Vec<f64>,
    weights: Vec<f64>,
}

impl Spectrum {
    /// The spectrum of a ring.
    pub fn new(chain: Chain) -> Self {
        let (shape, shape_across) = (Vec::new(), Vec::new());
        let mut spectrum = Self { chain, shape, shape_across, frequencies: Vec::new(), weights: Vec::new() };
        spectrum.resize(chain.lines());
        spectrum.reset(chain);
        spectrum
    }

    /// Takes over another chain; allocates only if there are other masses or other ends.
    pub fn reset(&mut self, chain: Chain) {
        if chain.lines() != self.chain.lines() {
            self.resize(chain.lines());
        }
        self.chain = chain;
        let along = self.shape.len();
        for (row, across) in self.frequencies.chunks_exact_mut(along).zip(&self.shape_across) {
            let held = chain.gamma3().mul_add(*across, chain.gamma1());
            for (frequency, shape) in row.iter_mut().zip(&self.shape) {
                *frequency = chain.gamma2().mul_add(*shape, held).sqrt();
            }
        }
    }

    fn resize(&mut self, [along, across]: [Line; 2]) {
        self.shape.clear();
        self.shape.extend(along.stiffnesses());
        self.shape_across.clear();
        self.shape_across.extend(across.stiffnesses());
        self.weights.clear();
        for l in 0..across.modes() {
            self.weights.extend((0..along.modes()).map(|k| along.weight(k) * across.weight(l)));
        }
        self.frequencies.clear();
        self.frequencies.resize(along.modes() * across.modes(), 0.0);
    }

    /// The lattice.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// Ω_k of all modes, those even about a site on a ring: lowest first, highest last; rising in one layer.
    pub fn frequencies(&self) -> &[f64] {
        &self.frequencies
    }

    /// δ_k = (c + 4c₂ sin²(πk/M))/2 of these modes, the rate at which each dies of dashpots c and c₂.
    pub fn decays(&self, [damping, coupling_damping]: [f64; 2]) -> impl Iterator<Item = f64> + '_ {
        let of = move |shape: &f64| 0.5 * coupling_damping.mul_add(*shape, damping);
        self.shape_across.iter().flat_map(move |_| self.shape.iter().map(of))
    }

    /// Which of these is nearest to a frequency.
    ///
    /// ```
    /// use vibrochain_lattice::{Chain, Spectrum};
    /// let spectrum = Spectrum::new(Chain::new(4, 0.2, 0.1)?);
    /// assert_eq!(spectrum.nearest(0.6_f64.sqrt() - 1e-3), 2);
    /// # Ok::<(), vibrochain_lattice::ParameterError>(())
    /// ```
    pub fn nearest(&self, frequency: f64) -> usize {
        let off = |&k: &usize| (self.frequencies[k] - frequency).abs();
        (0..self.frequencies.len()).min_by(|one, other| off(one).total_cmp(&off(other))).unwrap_or(0)
    }

    /// What [`crate::Shapes::even`] is to be multiplied by in a kernel. On a ring b_k², the squared amplitude of the even modes
    /// at any site; they sum to 1.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Lowest and highest frequency of the ring's modes. (The infinite chain's band is √γ₁ … √(γ₁+4γ₂); a ring
    /// of an odd number of masses stays a little below its upper edge.)
    pub fn band(&self) -> (f64, f64) {
        // The spectrum of a valid chain has at least the mode k = 0.
        let last = self.frequencies.last().copied().unwrap_or_default();
        (self.frequencies.first().copied().unwrap_or_default(), last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_rings_are_right_by_hand() {
        // One mass: its neighbours are itself, the coupling cancels.
        let one = Spectrum::new(Chain::new(1, 0.09, 5.0).unwrap());
        assert_eq!(one.frequencies().len(), 1);
        assert!((one.frequencies()[0] - 0.3).abs() < 1e-16);
        // Two masses joined by two springs: Ω₁² = γ₁ + 4γ₂.
        let two = Spectrum::new(Chain::new(2, 0.2, 0.1).unwrap());
        assert!((two.frequencies()[1].powi(2) - 0.6).abs() < 1e-15);
        assert_eq!(two.weights(), &[0.5, 0.5]);
    }

    #[test]
    fn weights_sum_to_one_and_frequencies_match_the_stiffness_matrix() {
        for sites in [1, 2, 3, 4, 5, 8, 21, 40] {
            let spectrum = Spectrum::new(Chain::new(sites, 0.2, 0.1).unwrap());
            assert!((spectrum.weights().iter().sum::<f64>() - 1.0).abs() < 1e-14);
            // Σ b_k² Ω_k² is the diagonal element of the stiffness matrix.
            let diagonal: f64 = spectrum.frequencies().iter().zip(spectrum.weights()).map(|(f, w)| w * f * f).sum();
            let expected = if sites == 1 { 0.2 } else { 0.4 };
            assert!((diagonal - expected).abs() < 1e-14, "{sites}");
        }
    }
}

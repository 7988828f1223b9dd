//! The modes of a lattice as contacts at some of its masses feel them.

use smallvec::SmallVec;

use crate::kernel::impulse::ImpulseResponse;

use super::bloch::{BlochKernel, Known};
use super::turn::Turned;

/// Frequencies this close are equal: each is worked out to 2ε.
const EQUAL: f64 = 4.0 * f64::EPSILON;

/// A square of a shape below this part of its mode's weight is rounding: on a ring of 10⁷ masses the least that is none is 5e-14.
const SPARED: f64 = 16.0 * f64::EPSILON;

/// Modes that have a node at every contact: their multipliers are e^{±iΩT} exactly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SparedModes {
    /// Number of the first mode of this frequency.
    pub mode: usize,
    /// Ω
    pub frequency: f64,
    /// How many there are.
    pub count: usize,
}

impl BlochKernel {
    /// The kernel between masses of the lattice of `response`, for its period; and the modes that none of them feels.
    ///
    /// Modes of one frequency are merged: the products of their shapes at the masses add up to one matrix, whose pivoted Cholesky
    /// factors are as many modes as the masses can feel.
    ///
    /// ```
    /// use vibrochain_lattice::{BlochKernel, Chain, Complex, ImpulseResponse, Spectrum};
    /// let response = ImpulseResponse::new(&Spectrum::new(Chain::new(9, 0.2, 0.1)?), 1.5)?;
    /// let (kernel, spared) = BlochKernel::of_lattice(&response, &[2, 5]);
    /// // z = 1 is the periodic kernel.
    /// let jet = kernel.jet(0, 1, 0.7, Complex::new(1.0, 0.0));
    /// assert!((jet.kernel[0] - response.value(3, 0.7)).norm() < 1e-14);
    /// assert_eq!(kernel.modes().len() + spared.iter().map(|spared| spared.count).sum::<usize>(), 9);
    /// # Ok::<(), vibrochain_lattice::LatticeError>(())
    /// ```
    pub fn of_lattice(response: &ImpulseResponse, sites: &[usize]) -> (Self, Vec<SparedModes>) {
        let (chain, shapes, modes) = (response.chain(), response.shapes(), response.modes());
        let (frequencies, weights) = (&response.frequencies()[..modes], response.weights());
        let mut order: Vec<usize> = (0..modes).collect();
        order.sort_unstable_by(|&a, &b| frequencies[a].total_cmp(&frequencies[b]).then(a.cmp(&b)));
        let mut kernel = Self::with_room(response.period(), sites.len(), modes);
        let mut spared = Vec::with_capacity(modes);
        let mut products = vec![0.0; sites.len() * sites.len()];
        for alike in order.chunk_by(|&low, &high| frequencies[high] - frequencies[low] <= EQUAL * frequencies[high]) {
            let k = alike[0];
            let (frequency, full): (f64, f64) = (frequencies[k], alike.iter().map(|&k| weights[k]).sum());
            products.fill(0.0);
            for &k in alike {
                for (i, row) in products.chunks_exact_mut(sites.len()).enumerate() {
                    for (entry, &from) in row.iter_mut().zip(sites) {
                        *entry += weights[k] * shapes.even(k, sites[i], from);
                    }
                }
            }
            let mut left: usize = alike.iter().map(|&k| chain.multiplicity(k)).sum();
            let (cos, sin) = (response.cos_half()[k], response.sin_half()[k]);
            let pole_error = f64::EPSILON * (2.0 + 2.0 * frequency * response.period());
            while let Some((shape, square)) = next_factor(&mut products, SPARED * full).filter(|_| left > 0) {
                if frequency > 0.0 {
                    // From half the phase, out of which the nearest multiple of π was taken exactly.
                    let period = Turned { even: (cos - sin) * (cos + sin), odd: 2.0 * sin * cos };
                    // Of the products, over the root of the pivot.
                    let shape_error = 2.0 * f64::EPSILON * full / square.sqrt();
                    kernel.push_known(frequency, Known { period, pole_error, shape_error }, &shape);
                } else {
                    kernel.push_oscillator(frequency, 0.0, &shape);
                }
                left -= 1;
            }
            if left > 0 {
                spared.push(SparedModes { mode: k, frequency, count: left });
            }
        }
        (kernel, spared)
    }
}

/// One step of the pivoted Cholesky decomposition of a symmetric matrix, which is taken out of it: the factor and its pivot, `None`
/// where the largest one left is below `least`.
pub(crate) fn next_factor(matrix: &mut [f64], least: f64) -> Option<(SmallVec<[f64; 4]>, f64)> {
    let size = matrix.len().isqrt();
    let pivots = (0..size).map(|i| (i, matrix[i * size + i]));
    let (pivot, square) = pivots.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, square)| *square > least)?;
    let scale = square.sqrt().recip();
    let factor: SmallVec<[f64; 4]> = (0..size).map(|i| matrix[i * size + pivot] * scale).collect();
    for (i, row) in matrix.chunks_exact_mut(size).enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry -= factor[i] * factor[j];
        }
    }
    Some((factor, square))
}

//! Modes whose poles nearly coincide, as contacts see them: as one.

use rustfft::num_complex::Complex;
use smallvec::SmallVec;

use super::bloch::{BlochKernel, BlochMode};

type C = Complex<f64>;

/// What contacts feel of a cluster below this part of all of it is rounding.
const SPARED: f64 = 16.0 * f64::EPSILON;

/// What is left of a cluster of modes when contacts feel some of their combinations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeCluster {
    /// The poles e^{λT} of its middle.
    pub poles: [Complex<f64>; 2],
    /// How far those of its modes are from there at most.
    pub width: f64,
    /// How many modes are left.
    pub count: usize,
}

impl BlochKernel {
    /// The same with neighbours on the scale of rates, no more than this part of them apart, as one mode in their middle: as many times as
    /// contacts can feel it, with the width of the cluster as error of its poles; and what is left of each cluster. `None` where nothing is.
    ///
    /// ```
    /// use vibrochain_lattice::BlochKernel;
    /// let mut kernel = BlochKernel::new(4.0, 1);
    /// for (frequency, shape) in [(1.3, 0.5), (1.3 + 1e-12, 0.7), (2.0, 0.3)] {
    ///     kernel.push_oscillator(frequency, 0.0, &[shape]);
    /// }
    /// let (merged, clusters) = kernel.clustered(1e-10).unwrap();
    /// assert_eq!((merged.modes().len(), clusters.len(), clusters[0].count), (2, 1, 1));
    /// assert!((merged.mobility(0, 0) - kernel.mobility(0, 0)).abs() < 1e-15 && clusters[0].width < 4.1e-12);
    /// assert!(kernel.clustered(1e-14).is_none());
    /// ```
    #[must_use]
    pub fn clustered(&self, gap: f64) -> Option<(Self, Vec<ModeCluster>)> {
        let modes = self.modes();
        let mut order: Vec<usize> = (0..modes.len()).collect();
        order.sort_by(|&a, &b| modes[a].rate.total_cmp(&modes[b].rate));
        let near = |&low: &usize, &high: &usize| {
            let (low, high) = (&modes[low], &modes[high]);
            let way = (high.rate - low.rate).max((high.decay - low.decay).abs());
            low.coordinates == high.coordinates && low.coordinates.are_circular() && way <= gap * high.rate
        };
        let mut kernel = Self::with_room(self.period(), self.contacts(), modes.len());
        let mut clusters = Vec::new();
        for alike in order.chunk_by(near) {
            match *alike {
                [k] => kernel.push_again(self, k),
                _ => clusters.extend(kernel.push_cluster(self, alike)),
            }
        }
        (!clusters.is_empty()).then_some((kernel, clusters))
    }

    /// Adds what contacts feel of some modes of another kernel; what is left of them.
    fn push_cluster(&mut self, of: &Self, alike: &[usize]) -> Option<ModeCluster> {
        let (contacts, modes) = (of.contacts(), of.modes());
        let number = |[x, y]: [f64; 2]| C::new(x, y);
        let length = |k: usize, of_contact: &dyn Fn(usize, usize) -> [f64; 2]| {
            (0..contacts).map(|i| number(of_contact(k, i)).norm()).fold(0.0, f64::max)
        };
        let sizes = |k: usize| [length(k, &|k, i| of.row(k, i)), length(k, &|k, i| of.column(k, i))];
        let weight = |k: usize| sizes(k)[0] * sizes(k)[1];
        let full: f64 = alike.iter().map(|&k| weight(k)).sum();
        let mean = alike.iter().map(|&k| weight(k) * modes[k].rate).sum::<f64>() / full;
        let off = |k: &usize| (modes[*k].rate - mean).abs();
        let middle = alike.iter().copied().min_by(|a, b| off(a).total_cmp(&off(b))).map(|k| modes[k])?;
        let [pole, _] = middle.poles();
        let farthest = |of: &dyn Fn(&BlochMode) -> f64| alike.iter().map(|&k| of(&modes[k])).fold(0.0, f64::max);
        let width = farthest(&|mode| (mode.poles()[0] - pole).norm() + mode.pole_error);
        let rates = farthest(&|mode| (mode.rates()[0] - middle.rates()[0]).norm() + mode.rate_error);
        // A row's conjugate times a column is what one contact has of an impulse at the other. Velocities just after it stay as they are.
        let mut products = vec![C::default(); contacts * contacts];
        let mut error = full * rates / middle.rate;
        for &k in alike {
            let ratio = modes[k].rate / middle.rate;
            for i in 0..contacts {
                let row = number(of.row(k, i)).conj() * ratio;
                for (j, entry) in products[i * contacts..(i + 1) * contacts].iter_mut().enumerate() {
                    *entry += row * number(of.column(k, j));
                }
            }
            let errors = |which: usize| (0..contacts).map(|i| of.shape_errors(k, i)[which][0]).fold(0.0, f64::max);
            error += sizes(k)[0] * errors(1) + sizes(k)[1] * errors(0);
        }
        let mut count = alike.len();
        while count > 0 {
            let largest =
                (0..products.len()).max_by(|&a, &b| products[a].norm_sqr().total_cmp(&products[b].norm_sqr()));
            let Some(at) = largest.filter(|&at| products[at].norm() > SPARED * full) else { break };
            let (pivot, size) = (products[at], products[at].norm());
            let (i, j) = (at / contacts, at % contacts);
            // In the units of a shape.
            let [seen, given] = [(middle.rate / size).sqrt(), (middle.rate * size).sqrt().recip()];
            let rows: SmallVec<[C; 4]> =
                (0..contacts).map(|k| products[k * contacts + j] * pivot.conj() / size).collect();
            let columns: SmallVec<[C; 4]> = (0..contacts).map(|k| products[i * contacts + k]).collect();
            let shape_error = seen * (error + f64::EPSILON * full);
            let mode = BlochMode { pole_error: width, rate_error: rates, shape_error, ..middle };
            let sight = |(row, column): (&C, &C)| {
                let (row, column) = (row.conj() * seen, column * given);
                [[row.re, row.im], [column.re, column.im]]
            };
            self.push_told(mode, rows.iter().zip(&columns).map(sight));
            for (line, row) in products.chunks_exact_mut(contacts).zip(&rows) {
                line.iter_mut().zip(&columns).for_each(|(entry, column)| *entry -= row * column / size);
            }
            count -= 1;
        }
        (count > 0).then_some(ModeCluster { poles: middle.poles(), width, count })
    }
}

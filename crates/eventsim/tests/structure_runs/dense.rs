//! A search that shares no code.

use nalgebra::{DMatrix, DVector};
use vibrochain_lattice::{Barrier, Contact, Structure};

/// States between impacts by the exponential of the state matrix with loads in it, sampled, and impacts by bisection.
pub(crate) struct Dense {
    pub(crate) generator: DMatrix<f64>,
    inverse: DMatrix<f64>,
    contacts: Vec<(DVector<f64>, Contact)>,
    /// q, q′, cos ω(t+ψ), sin ω(t+ψ), 1
    pub(crate) state: DVector<f64>,
    time: f64,
}

impl Dense {
    pub(crate) fn new(structure: &Structure, omega: f64, psi: f64, q: &DVector<f64>, v: &DVector<f64>) -> Self {
        let n = q.len();
        let inverse = structure.mass.clone().try_inverse().unwrap();
        let mut generator = DMatrix::zeros(2 * n + 3, 2 * n + 3);
        generator.view_mut((0, n), (n, n)).fill_with_identity();
        generator.view_mut((n, 0), (n, n)).copy_from(&-(&inverse * &structure.stiffness));
        generator.view_mut((n, n), (n, n)).copy_from(&-(&inverse * &structure.damping));
        let real = structure.loads[0].1.map(|f| f.re);
        let imaginary = structure.loads[0].1.map(|f| f.im);
        generator.view_mut((n, 2 * n), (n, 1)).copy_from(&(&inverse * real));
        generator.view_mut((n, 2 * n + 1), (n, 1)).copy_from(&-(&inverse * imaginary));
        generator.view_mut((n, 2 * n + 2), (n, 1)).copy_from(&(&inverse * &structure.static_load));
        (generator[(2 * n, 2 * n + 1)], generator[(2 * n + 1, 2 * n)]) = (-omega, omega);
        let mut state = DVector::zeros(2 * n + 3);
        state.rows_mut(0, n).copy_from(q);
        state.rows_mut(n, n).copy_from(v);
        (state[2 * n], state[2 * n + 1], state[2 * n + 2]) = ((omega * psi).cos(), (omega * psi).sin(), 1.0);
        Self { generator, inverse, contacts: structure.contacts.clone(), state, time: 0.0 }
    }

    pub(crate) fn gap(&self, state: &DVector<f64>, contact: usize, barrier: Barrier) -> f64 {
        let (w, limits) = &self.contacts[contact];
        let place = limits.barrier(barrier).unwrap_or(barrier.sign() * 1e9);
        barrier.sign() * (place - w.dot(&state.rows(0, w.len())))
    }

    /// Impacts up to `end`: contact, time, velocity before.
    pub(crate) fn impacts(&mut self, end: f64, step: f64) -> Vec<(usize, f64, f64)> {
        let mut found = Vec::new();
        let whole = (&self.generator * step).exp();
        let n = self.inverse.nrows();
        while self.time < end {
            let later = &whole * &self.state;
            let mut first: Option<(f64, usize)> = None;
            for contact in 0..self.contacts.len() {
                for barrier in [Barrier::Lower, Barrier::Upper] {
                    if self.gap(&later, contact, barrier) >= 0.0 {
                        continue;
                    }
                    let (mut low, mut high) = (0.0, step);
                    for _ in 0..60 {
                        let middle = 0.5 * (low + high);
                        let then = (&self.generator * middle).exp() * &self.state;
                        // Just after an impact it is on its barrier, to rounding.
                        let is_beyond = self.gap(&then, contact, barrier) < 0.0 && middle > 1e-9;
                        (low, high) = if is_beyond { (low, middle) } else { (middle, high) };
                    }
                    if first.is_none_or(|(time, _)| low < time) {
                        first = Some((low, contact));
                    }
                }
            }
            let Some((after, contact)) = first else {
                self.state = later;
                self.time += step;
                continue;
            };
            self.state = (&self.generator * after).exp() * &self.state;
            self.time += after;
            let (w, limits) = &self.contacts[contact];
            let velocity = w.dot(&self.state.rows(n, n));
            let jump = &self.inverse * w * (-(1.0 + limits.restitution) * velocity / w.dot(&(&self.inverse * w)));
            let mut rows = self.state.rows_mut(n, n);
            rows += jump;
            found.push((contact, self.time, velocity));
        }
        found
    }
}

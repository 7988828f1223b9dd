//! J(z) by rows, and its derivative.

use vibrochain_lattice::{Complex, Turned};

use super::BlochEquations;

type C = Complex<f64>;

impl BlochEquations {
    /// Whether J(z) is summed as J₀ + Σ A z(z−R)⁻¹C: inside all poles, where z goes to 0 without a large term.
    pub fn is_inside(&self, z: Complex<f64>) -> bool {
        z.norm_sqr() < 0.25 * self.innermost
    }

    /// J₀ of either form, by rows.
    pub fn constant(&self, inside: bool) -> &[f64] {
        if inside { &self.inside } else { &self.outside }
    }

    /// J(z) by rows; not finite at a pole.
    pub fn matrix(&self, z: Complex<f64>) -> Vec<Complex<f64>> {
        let mut matrix = Vec::new();
        self.fill(z, &mut matrix, None);
        matrix
    }

    /// J(z) and, if it is asked for, dJ/dz, by rows.
    pub fn fill(&self, z: Complex<f64>, matrix: &mut Vec<Complex<f64>>, derivative: Option<&mut Vec<Complex<f64>>>) {
        self.fill_without(z, &[], matrix, derivative);
    }

    /// The same without what some modes have between their poles: for those that z is too close to.
    pub fn fill_without(
        &self,
        z: Complex<f64>,
        left_out: &[usize],
        matrix: &mut Vec<Complex<f64>>,
        mut derivative: Option<&mut Vec<Complex<f64>>>,
    ) {
        let (size, inside) = (self.size(), self.is_inside(z));
        matrix.clear();
        matrix.extend(self.constant(inside).iter().map(|entry| C::new(*entry, 0.0)));
        if let Some(derivative) = &mut derivative {
            derivative.clear();
            derivative.resize(size * size, C::default());
        }
        let all = self.kernel.modes().iter().enumerate();
        for (k, mode) in all.filter(|(k, _)| !left_out.contains(k)) {
            let coordinates = mode.coordinates;
            let resolvent = coordinates.resolvent(mode.period, z);
            let past = coordinates.product(mode.period.complex(), resolvent);
            let sum = if inside { Turned { even: resolvent.even * z, odd: resolvent.odd * z } } else { past };
            let slope = coordinates.product(past, resolvent);
            let (rows, columns) = (self.rows(k), self.columns(k));
            for (i, row) in rows.iter().enumerate() {
                let seen = coordinates.seen(*row, sum);
                let line = &mut matrix[i * size..(i + 1) * size];
                for (entry, column) in line.iter_mut().zip(columns) {
                    *entry += seen[0] * column[0] + seen[1] * column[1];
                }
                if let Some(derivative) = &mut derivative {
                    let seen = coordinates.seen(*row, slope);
                    let line = &mut derivative[i * size..(i + 1) * size];
                    for (entry, column) in line.iter_mut().zip(columns) {
                        *entry -= seen[0] * column[0] + seen[1] * column[1];
                    }
                }
            }
        }
    }

    /// [`fill`](Self::fill) at a real z outside all poles, in real numbers: for a small part of the work.
    pub fn fill_real(&self, z: f64, matrix: &mut Vec<f64>) {
        matrix.clear();
        matrix.extend(self.constant(false));
        for (k, mode) in self.kernel.modes().iter().enumerate() {
            let coordinates = mode.coordinates;
            let past = coordinates.product(mode.period, coordinates.real_resolvent(mode.period, z));
            for (line, row) in matrix.chunks_exact_mut(self.size()).zip(self.rows(k)) {
                let seen = coordinates.seen(*row, past);
                for (entry, column) in line.iter_mut().zip(self.columns(k)) {
                    *entry += seen[0] * column[0] + seen[1] * column[1];
                }
            }
        }
    }
}

//! The secular determinant of an orbit with all impacts at one site.
//!
//! A perturbation x, multiplied by z a period, that has the displacement and velocity s_i at the site just before impact i,
//! is what all earlier impacts have sent out: with R(τ) the free flight of the modes even about the site, B their amplitudes
//! there, and D_j = S_j − 1 = [[−(1+e), 0], [κ_j, −(1+e)]],
//!
//! ```text
//! s_i = Σ_j G(t_i−t_j) D_j s_j,   G(τ) = Bᵀ(1−R(T)/z)⁻¹R(τ)B for τ > 0,  G(τ+T)/z for τ ≤ 0
//! D(z) = det(1 − [G(t_i−t_j) D_j]) = det(z−M)/det(z−R(T))
//! ```
//!
//! Mode by mode, with c = cos ΩT and ν = ½(z+1/z): (1−R(T)/z)⁻¹R(τ) = (zR(τ) − R(τ−T))/(2(ν−c)).

use crate::complex::{Complex, shifted};
use crate::flight::Flight;
use crate::linear::determinant;
use crate::spectrum::TrueSpectrum;

/// [[a, b], [c, d]]
type Block = [[Complex; 2]; 2];

impl TrueSpectrum {
    /// The determinant with the modes `explicit` kept, which multiplies it by z²−2cz+1 each; and Π(ν−c) over the others.
    pub(crate) fn evaluate(&self, z: &Complex, nu: &Complex, explicit: &[usize]) -> Option<(Complex, Complex)> {
        let n = self.kappas.len();
        let zero = || Complex::new(0.0, 0.0, self.work);
        let one = || Complex::new(1.0, 0.0, self.work);
        let mut factor = one();
        let mut shares: Vec<Option<Complex>> = Vec::with_capacity(self.poles.len());
        for (p, pole) in self.poles.iter().enumerate() {
            if explicit.contains(&p) {
                shares.push(None);
                continue;
            }
            let distance = shifted(nu, &-&pole.cos);
            if distance.is_zero() {
                return None;
            }
            shares.push(Some((&distance + &distance).inverse().scale(&pole.weight)));
            factor = factor * distance;
        }
        let total = shares.iter().flatten().fold(zero(), |sum, share| sum + share);
        let sums: Vec<Vec<[Complex; 3]>> = self
            .flights
            .iter()
            .map(|row| {
                let sum = |flights: &Vec<Flight>| {
                    let mut sums = [zero(), zero(), zero()];
                    for (flight, share) in flights.iter().zip(&shares) {
                        let Some(share) = share else { continue };
                        for (sum, part) in sums.iter_mut().zip([&flight.cos, &flight.sin_over, &flight.sin_times]) {
                            *sum = &*sum + share.scale(part);
                        }
                    }
                    sums
                };
                row.iter().map(sum).collect()
            })
            .collect();
        let inverse = z.inverse();
        let size = 2 * (n + explicit.len());
        let mut matrix: Vec<Vec<Complex>> =
            (0..size).map(|i| (0..size).map(|j| if i == j { one() } else { zero() }).collect()).collect();
        let mut subtract = |row: usize, column: usize, block: Block| {
            for (i, line) in block.into_iter().enumerate() {
                for (j, entry) in line.into_iter().enumerate() {
                    let target = &mut matrix[row + i][column + j];
                    *target = &*target - entry;
                }
            }
        };
        for i in 0..n {
            for j in 0..n {
                let [cos, up, down] = &sums[i][j];
                let [cos_back, up_back, down_back] = &sums[j][i];
                // zR(τ_ij) − R(−τ_ji), over z unless j < i; for j = i that is R(T) − 1/z.
                let mut parts = if i == j {
                    [cos - &inverse * &total, up.clone(), down.clone()]
                } else {
                    [z * cos - cos_back, z * up + up_back, z * down + down_back]
                };
                if j > i {
                    parts = parts.map(|part| part * &inverse);
                }
                let [cos, up, down] = parts;
                subtract(2 * i, 2 * j, self.after_impact(j, [[cos.clone(), up], [-down, cos]]));
            }
        }
        for (place, &p) in explicit.iter().enumerate() {
            let column = 2 * (n + place);
            let weight = &self.poles[p].weight;
            let block = |flight: &Flight| {
                let cos = Complex::real(flight.cos.clone());
                let (up, down) = (Complex::real(flight.sin_over.clone()), Complex::real(-&flight.sin_times));
                [[cos.clone(), up], [down, cos]]
            };
            let weighted = |block: Block| block.map(|line| line.map(|entry| entry.scale(weight)));
            let identity = || [[one(), zero()], [zero(), one()]];
            // (z − R(T)) x − Σ_j R(T−(t_j−t_0)) D_j s_j = 0
            let minus_z = identity().map(|line| line.map(|entry| (one() - z) * entry));
            subtract(column, column, minus_z);
            subtract(column, column, block(&self.flights[0][0][p]));
            for j in 0..n {
                subtract(column, 2 * j, self.after_impact(j, block(&self.flights[0][j][p])));
            }
            // and in the impacts' rows b²R(t_i−t_0) x + Σ_{j<i} b²R(t_i−t_j) D_j s_j.
            for i in 0..n {
                let arrival = if i == 0 { identity() } else { block(&self.flights[i][0][p]) };
                subtract(2 * i, column, weighted(arrival));
                for j in 0..i {
                    subtract(2 * i, 2 * j, self.after_impact(j, weighted(block(&self.flights[i][j][p]))));
                }
            }
        }
        Some((determinant(matrix, self.work), factor))
    }

    /// A block times D_j.
    fn after_impact(&self, j: usize, block: Block) -> Block {
        let loss = &self.restitution + 1.0;
        let kappa = &self.kappas[j];
        block.map(|[left, right]| [right.scale(kappa) - left.scale(&loss), -right.scale(&loss)])
    }
}

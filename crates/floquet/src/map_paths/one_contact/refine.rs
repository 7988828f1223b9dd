//! A multiplier held against the impacts' own equations, and how wrong it can be.
//!
//! Residues next to coincident poles are large and cancel, and sums over the moduli of their errors say next to nothing: an error of
//! one pole changes two residues at once. The equations K̂(z)y = 0 (see [`crate::map_paths::one_contact::impact_matrix`]) know of no such thing. With x, y the
//! null vectors, a first-order change of K̂ moves z by −xᵀδK̂y/xᵀK̂′y, and all of K̂ but its diagonal is a sum of dyads:
//!
//! ```text
//! xᵀK̂y = Σ b² [p/(z−p) AC + Σ_{i>j} a_i c_j] + conj. + Σ_i [½(q+1) x_i·y_i + κ'_i x_{v,i} y_{u,i}]
//!      = Σ b² [z/(z−p) AC − Σ_{i<j} a_i c_j] + conj. + Σ_i [½(q−1) x_i·y_i + κ'_i x_{v,i} y_{u,i}],
//! xᵀK̂′y = −Σ b² p/(z−p)² AC + conj.,   a_i = φ_ie^{iΩt_i}(x_i·w),  c_j = φ_je^{−iΩt_j}(ṽ·y_j),  A = Σa_i,  C = Σc_j,
//! ```
//!
//! the first form outside the circle and the second one inside, where nothing is left of them as z → ∞ and z → 0;
//! conj. stands for p̄, −Ω. Next to a pole A and C are small, and so is what their rounding does. Errors of x and y count to second
//! order. As −xᵀK̂y/xᵀK̂′y is a step of Newton's method besides, the multiplier is settled on the way.

use nalgebra::Complex;
use smallvec::{SmallVec, smallvec};
use vibrochain_breather::linear::{Pivots, eliminate, null_vectors};

use crate::map_paths::one_contact::impact_matrix::{FeltMode, ImpactMatrix};
use crate::zeros::modulus;

type C = Complex<f64>;

/// Steps: the first is as good as the start, the second has the digits there are; from a matrix whose norm hides them it takes more.
const STEPS: usize = 10;

/// A pole whose error is not small against its distance is not followed to first order.
const NEAR: f64 = 1e-2;

/// Errors of the orbit's own data at one impact.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct DataError {
    /// Of κ'.
    pub(crate) kappa: f64,
    /// Of the time since the first impact.
    pub(crate) time: f64,
}

/// Errors of one origin at all impacts, with their signs.
pub(crate) type Origin = SmallVec<[DataError; 2]>;

/// A multiplier and its error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Settled {
    pub(crate) z: C,
    /// Of rounding.
    pub(crate) error: f64,
    /// What the orbit's data bring along.
    pub(crate) data: f64,
}

/// How singular K̂ is, in units that make it as even as can be.
pub(crate) struct Singular {
    /// A norm of |x||K̂||y|.
    norm: f64,
    /// The last pivot but one, to the scale of |x||y|.
    second: f64,
    /// The last pivot, as a part of the largest entry.
    pub(crate) defect: f64,
}

/// xᵀK̂y, xᵀK̂′y and bounds of their errors, the last of the former from the orbit's data.
struct Product {
    value: C,
    slope: C,
    value_error: f64,
    slope_error: f64,
    data: f64,
}

impl ImpactMatrix {
    /// The multiplier next to `start`; `None` where first order is not enough.
    pub(crate) fn settle(&mut self, start: C, data: &[Origin]) -> Option<Settled> {
        let mut z = start;
        for _ in 0..STEPS {
            let Singular { norm, second, .. } = self.null_vectors(z)?;
            let Product { value, slope, value_error, slope_error, data } = self.product(z, data)?;
            // Errors of x and y, of both at once.
            let off = 16.0 * f64::EPSILON * norm;
            let error = value_error + off * off / second;
            let slope_size = modulus(slope) - slope_error;
            // Not a number is none, either.
            let sound = slope_size > 0.0;
            if !sound {
                return None;
            }
            let step = value / slope;
            // What the step is too long or too short by is of second order in it.
            if modulus(step) * slope_size <= error {
                let error = error / slope_size + modulus(step) + 2.0 * f64::EPSILON * modulus(z);
                let data = data / slope_size;
                return (error + data).is_finite().then_some(Settled { z, error, data });
            }
            z -= step;
            if !(z.re.is_finite() && z.im.is_finite()) {
                return None;
            }
        }
        None
    }

    /// Works out K̂(z) and its null vectors x and y, `left` and `right`, on a scale of their own.
    pub(crate) fn null_vectors(&mut self, z: C) -> Option<Singular> {
        let size = 2 * self.impacts;
        self.fill(z)?;
        self.balance_scales(size);
        let largest = self.entries.iter().map(|entry| entry.norm_sqr()).fold(0.0, f64::max).sqrt();
        let factors = eliminate(&mut self.entries, size, Pivots::Full)?;
        let pivot = |i: usize| self.entries[i * size + i].norm_sqr().sqrt();
        let (second, last) = (pivot(size - 2), pivot(size - 1));
        let [x, y] = null_vectors(&self.entries, size);
        let length = |v: &[C]| v.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
        let scale = length(&x) * length(&y);
        for vector in [&mut self.left, &mut self.right] {
            vector.clear();
            vector.resize(size, C::default());
        }
        for i in 0..size {
            let (row, column) = (factors.rows[i], factors.columns[i]);
            self.left[row] = x[i] / self.scales[row];
            self.right[column] = y[i] * self.scales[column];
        }
        Some(Singular { norm: largest * size as f64 * scale, second: second * scale, defect: last / largest })
    }

    /// Units in which rows and columns of one number are alike (as before a dense eigenvalue problem): neither stiff saltations nor
    /// soft answers, nor what far-off multipliers do to the order of impacts, stand out then.
    fn balance_scales(&mut self, size: usize) {
        let Self { entries: matrix, scales, .. } = self;
        scales.clear();
        scales.resize(size, 1.0);
        for _ in 0..if size > 2 { 3 } else { 1 } {
            for (i, scale) in scales.iter_mut().enumerate() {
                let others = (0..size).filter(|j| *j != i);
                let (row, column) = others.fold((0.0, 0.0), |(row, column), j| {
                    (row + matrix[i * size + j].norm_sqr(), column + matrix[j * size + i].norm_sqr())
                });
                let by = (row / column).sqrt().sqrt();
                if !by.is_normal() {
                    continue;
                }
                *scale *= by;
                for j in 0..size {
                    matrix[i * size + j] /= by;
                    matrix[j * size + i] *= by;
                }
            }
        }
    }

    /// The products with the null vectors last found.
    fn product(&self, z: C, data: &[Origin]) -> Option<Product> {
        const EPSILON: f64 = f64::EPSILON;
        let n = self.impacts;
        let mut out =
            Product { value: C::default(), slope: C::default(), value_error: 0.0, slope_error: 0.0, data: 0.0 };
        let mut slides: SmallVec<[C; 8]> = smallvec![C::default(); n];
        let (mut a, mut c) = (slides.clone(), slides.clone());
        let outside = z.norm_sqr() >= 1.0;
        let loss = self.even(outside);
        let mut sizes = 0.0;
        let of_time = data.iter().flatten().any(|error| error.time != 0.0);
        let entries = |v: &[C], i: usize| (v[2 * i], v[2 * i + 1]);
        // Σ|x_u|, Σ|x_v|, the same of y, and over ordered pairs x_u y_u, x_v y_u, x_u y_v, x_v y_v.
        let (mut x, mut y, mut pairs) = ([0.0; 2], [0.0; 2], [0.0; 4]);
        for i in 0..n {
            let ((xu, xv), (yu, yv)) = (entries(&self.left, i), entries(&self.right, i));
            let moduli = [modulus(xu), modulus(xv), modulus(yu), modulus(yv)];
            // Each x that meets a y before it, or each y that meets an x after it.
            let met = if outside { [0, 1].map(|k| moduli[k] * y[0]) } else { [0, 1].map(|k| x[k] * moduli[2]) };
            let met_fast = if outside { [0, 1].map(|k| moduli[k] * y[1]) } else { [0, 1].map(|k| x[k] * moduli[3]) };
            for (sum, part) in pairs.iter_mut().zip(met.into_iter().chain(met_fast)) {
                *sum += part;
            }
            for (sum, part) in x.iter_mut().chain(&mut y).zip(moduli) {
                *sum += part;
            }
            let (even, odd) = ((xu * yu + xv * yv) * loss, xv * yu * self.kappas[i]);
            let even_size = (modulus(xu) * modulus(yu) + modulus(xv) * modulus(yv)) * (0.5 + self.half_loss);
            out.value += even + odd;
            out.value_error += 4.0 * EPSILON * (even_size + modulus(odd));
            sizes += even_size + modulus(odd);
        }
        for (mode, waves) in self.modes.iter().zip(self.waves.chunks_exact(n)) {
            let FeltMode { pole, weight, frequency, ratio, error, shape_error } = *mode;
            // Moduli of all a and c, relative errors of each.
            let (a_size, c_size) = (x[0] + ratio * x[1], 0.5 * (y[0] + y[1] / ratio));
            let relative = EPSILON * (6.0 + 3.0 * frequency * self.longest) + shape_error;
            let (a_error, c_error) = (relative * a_size, relative * c_size);
            let [uu, vu, uv, vv] = pairs;
            let ordered_error = relative * (uu + ratio * vu + uv / ratio + vv);
            let distances = mode.distances(z)?;
            if !distances.iter().all(|(_, near)| error * near < NEAR) {
                return None;
            }
            for (sign, pole, (inverse, near)) in [(1.0, pole, distances[0]), (-1.0, pole.conj(), distances[1])] {
                let (mut a_sum, mut c_sum, mut ordered) = (C::default(), C::default(), C::default());
                let (forth, back) = (C::new(0.0, sign * ratio), C::new(0.0, -sign / ratio));
                for i in 0..n {
                    let ((xu, xv), (yu, yv)) = (entries(&self.left, i), entries(&self.right, i));
                    let wave = if sign > 0.0 { waves[i] } else { waves[i].conj() };
                    a[i] = (xu + forth * xv) * wave;
                    c[i] = (yu + back * yv) * wave.conj() * 0.5;
                    ordered += if outside { a[i] * c_sum } else { -(a_sum * c[i]) };
                    a_sum += a[i];
                    c_sum += c[i];
                }
                let factor = if outside { pole } else { z } * inverse;
                let factor_size = if outside { near } else { modulus(z) * near };
                let dyad = a_sum * c_sum;
                let size = modulus(dyad);
                let dyad_error = a_error * modulus(c_sum) + c_error * modulus(a_sum) + a_error * c_error;
                let steep = weight * near * near;
                out.value += (factor * dyad + ordered) * weight;
                out.slope -= pole * inverse * inverse * dyad * weight;
                sizes += weight * (factor_size * size + modulus(ordered));
                out.value_error += weight * (factor_size * (dyad_error + 6.0 * EPSILON * size) + ordered_error)
                    + steep * modulus(z) * error * size;
                out.slope_error += steep * (dyad_error + (8.0 * EPSILON + 3.0 * error * near) * size);
                if of_time {
                    let (mut a_before, mut c_before) = (C::default(), C::default());
                    let turning = C::new(0.0, sign * frequency * weight);
                    for i in 0..n {
                        let (of_c, of_a) = if outside {
                            (c_before, a_sum - a_before - a[i])
                        } else {
                            (c_before + c[i] - c_sum, -a_before)
                        };
                        slides[i] += turning * (a[i] * (factor * c_sum + of_c) - c[i] * (factor * a_sum + of_a));
                        a_before += a[i];
                        c_before += c[i];
                    }
                }
            }
        }
        // Of adding up.
        out.value_error += EPSILON * (self.modes.len() as f64).sqrt() * sizes;
        let omega = self.modes.first().map_or(1.0, |mode| mode.frequency / mode.ratio);
        out.data = data
            .iter()
            .map(|origin| {
                let moves = origin.iter().enumerate().take(n).map(|(i, error)| {
                    self.left[2 * i + 1] * self.right[2 * i] * (error.kappa / omega) + slides[i] * error.time
                });
                modulus(moves.sum::<C>())
            })
            .sum();
        Some(out)
    }
}

//! Multipliers refined by null vectors of the bordered equations, with their errors.
//!
//! With xᵀB = By = 0 a first-order change of B moves z by −xᵀδBy/xᵀB′y. Errors of x and y count to second order. As −xᵀBy/xᵀB′y is a
//! step of Newton's method besides, the multiplier is settled on the way. m multipliers that are no farther apart than their errors
//! are refined together: with the m null vectors of both sides they are the eigenvalues of the pencil XᵀBY + δXᵀB′Y.

use nalgebra::{Complex, DMatrix, Schur};
use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::{Coordinates, Turned};

use super::function::{PairErrors, Pole, SpectralFunction};
use super::null::Null;
use crate::singular::Singular;
use crate::zeros::modulus;

type C = Complex<f64>;

/// Steps at most: the first is as good as the start, the second has the digits there are.
const STEPS: usize = 12;

/// A pole that is not bordered and whose error is not small against its distance is not followed to first order.
const TOO_NEAR: f64 = 1e-2;

/// Errors of the orbit's own data at one impact, of one origin.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct DataError {
    /// Of g″⁻/(ωP).
    pub(crate) slide: f64,
    /// Of the time since the first impact.
    pub(crate) time: f64,
    /// Of the impulse, as a part of it.
    pub(crate) share: f64,
}

/// Errors of one origin at all impacts, with their signs.
pub(crate) type Origin = SmallVec<[DataError; 2]>;

/// A multiplier and its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Refined {
    pub(crate) z: C,
    /// Of rounding and of the orbit's own data.
    pub(crate) error: f64,
    /// Of rounding alone: how far it may be from a zero of the equations as they are.
    pub(crate) rounding: f64,
}

impl Refined {
    /// An approximation of which nothing is known.
    pub(crate) fn begun(z: C) -> Self {
        Self { z, error: 0.0, rounding: 0.0 }
    }
}

/// xᵀBy, xᵀB′y and bounds of their errors, the last of the former from the orbit's data.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Product {
    pub(super) value: C,
    pub(super) slope: C,
    pub(super) value_error: f64,
    pub(super) slope_error: f64,
    data: f64,
}

impl SpectralFunction<'_> {
    /// The multiplier next to `start`; `None` where first order is not enough.
    pub(crate) fn refine(&self, start: C, data: &[Origin]) -> Option<Refined> {
        self.refine_to(0.0, start, data)
    }

    /// The same of an orbit without losses, for a caller that a last step of length `enough` serves: its length counts as an error, and errors of
    /// the data are bounded alone, which takes half of the time of a step.
    pub(crate) fn refine_to(&self, enough: f64, start: C, data: &[Origin]) -> Option<Refined> {
        let worked_out = if enough > 0.0 { &[] } else { data };
        let mut z = start;
        for _ in 0..STEPS {
            let null = self.null(z, 1)?;
            let (x, y) = (null.left.column(0), null.right.column(0));
            let vectors = (x.as_slice(), y.as_slice());
            let Product { value, slope, value_error, slope_error, data: of_data } =
                self.product(z, &null.near, vectors, worked_out)?;
            // Errors of x and y, of both at once.
            let off = 16.0 * f64::EPSILON * null.norm;
            let error = value_error + off * off / null.second;
            let slope_size = modulus(slope) - slope_error;
            // Not a number is none, either.
            let sound = slope_size > 0.0;
            if !sound {
                return None;
            }
            let step = value / slope;
            // What the step is too long or too short by is of second order in it.
            if modulus(step) * slope_size <= error.max(enough * slope_size) {
                let of_data = if enough > 0.0 { self.data_bound(vectors, value_error, data) } else { of_data };
                let rounding = error / slope_size + modulus(step) + 2.0 * f64::EPSILON * modulus(z);
                let error = rounding + of_data / slope_size;
                // Errors are bounds: most steps this small are still in the right direction.
                z -= step;
                return error.is_finite().then_some(Refined { z, error, rounding });
            }
            z -= step;
            if !(z.re.is_finite() && z.im.is_finite()) {
                return None;
            }
        }
        None
    }

    /// `count` multipliers next to `start` together, each with the error of all.
    pub(crate) fn refine_together(&self, start: C, count: usize, data: &[Origin]) -> Option<(Vec<Refined>, bool)> {
        let mut z = start;
        for step in 0.. {
            let null = self.null(z, count)?;
            let (mut values, mut slopes) = (DMatrix::zeros(count, count), DMatrix::zeros(count, count));
            let (mut error, mut rounding, mut slope_error) = (0.0, 0.0, 0.0);
            for i in 0..count {
                for j in 0..count {
                    let (x, y) = (null.left.column(i), null.right.column(j));
                    let product = self.product(z, &null.near, (x.as_slice(), y.as_slice()), data)?;
                    (values[(i, j)], slopes[(i, j)]) = (product.value, product.slope);
                    error += (product.value_error + product.data).powi(2);
                    rounding += product.value_error.powi(2);
                    slope_error += product.slope_error.powi(2);
                }
            }
            let off = 16.0 * f64::EPSILON * null.norm;
            let of_vectors = count as f64 * off * off / null.second;
            let (error, rounding) = (error.sqrt() + of_vectors, f64::sqrt(rounding) + of_vectors);
            let definite = self.is_definite(z, &null, &slopes, slope_error.sqrt());
            let least = Singular::of(&slopes)?.least() - slope_error.sqrt();
            if least.is_nan() || least <= 0.0 {
                return None;
            }
            let moves = -(slopes.lu().solve(&values)?);
            let mean = moves.trace() / count as f64;
            let spread = (&moves - DMatrix::identity(count, count) * mean).norm();
            let reach = error / least;
            let creeps = modulus(mean) > reach.max(spread);
            if step + 1 < STEPS && creeps {
                z += mean;
                continue;
            }
            let shifts = Schur::try_new(moves, f64::EPSILON, 100 * count)?.eigenvalues()?;
            // All of them are within the spread of their mean; a pencil that is no multiple of one matrix moves them by a root.
            let m = count as f64;
            let moved = |reach: f64| {
                2.0 * (reach + spread.powf(1.0 - 1.0 / m) * reach.powf(1.0 / m)).min(2.0 * (reach + spread))
            };
            // Steps that have not ended leave the last one open.
            let left = 2.0 * f64::EPSILON * modulus(z) + if creeps { modulus(mean) } else { 0.0 };
            let (error, rounding) = (moved(reach) + left, moved(rounding / least) + left);
            let refined = shifts.iter().map(|shift| Refined { z: z + shift, error, rounding });
            return error.is_finite().then(|| (refined.collect(), definite));
        }
        None
    }

    /// Whether the Krein form is definite on the space of several multipliers next to z: then all of them are on the unit circle, if
    /// neither impacts nor modes lose energy. J is Hermitian there, so that the left null vectors are the right ones' conjugates, and the
    /// form is xᵀ(iz dJ/dz)y.
    fn is_definite(&self, z: C, null: &Null, slopes: &DMatrix<C>, slope_error: f64) -> bool {
        let (size, count) = (self.equations.size(), slopes.nrows());
        let (mut left, right) = (null.left.rows(0, size).clone_owned(), null.right.rows(0, size));
        if let Some(shift) = &self.shift {
            // Its row is divided by z−1, not by 1/z−1.
            left.row_mut(shift.place).iter_mut().for_each(|entry| *entry /= -z);
        }
        // X = conj(Y)·S
        let conjugate = right.conjugate();
        let Some(mix) = (conjugate.adjoint() * &conjugate).lu().solve(&(conjugate.adjoint() * &left)) else {
            return false;
        };
        let rest = (&conjugate * &mix - &left).norm();
        let Some(form) = mix.transpose().lu().solve(slopes) else { return false };
        let form = form * (C::new(0.0, 1.0) * z);
        let hermitian = (&form + form.adjoint()) * C::new(0.5, 0.0);
        let off = (&form - form.adjoint()).norm();
        let values = hermitian.symmetric_eigenvalues();
        let least = values.iter().map(|value| value.abs()).fold(f64::INFINITY, f64::min);
        let largest = values.iter().map(|value| value.abs()).fold(0.0, f64::max);
        let one_sign = values.iter().all(|value| *value > 0.0) || values.iter().all(|value| *value < 0.0);
        let sound = rest < 1e-3 * left.norm() && off < 0.1 * least && slope_error < 0.1 * least;
        one_sign && sound && least > 1e-6 * largest && count > 0
    }

    /// The products with two vectors of B(z).
    pub(super) fn product(&self, z: C, near: &[Pole], (x, y): (&[C], &[C]), data: &[Origin]) -> Option<Product> {
        const EPSILON: f64 = f64::EPSILON;
        let (equations, size) = (&self.equations, self.equations.size());
        let (n, inside, z_size) = (size / 2, equations.is_inside(z), modulus(z));
        let of_time = data.iter().flatten().any(|error| error.time != 0.0);
        // Only times and an orbit's own derivative are felt by way of the modes.
        let is_felt = of_time || !data.is_empty() && self.shift.is_some();
        let mut slides: SmallVec<[C; 8]> = smallvec![C::default(); n];
        // What a change of each impact's share in the orbit's own derivative does.
        let mut shares: SmallVec<[C; 8]> = smallvec![C::default(); n];
        let mut out = Product::default();
        let mut sizes = 0.0;
        let constant = &self.constants[usize::from(inside)];
        let [x_sizes, y_sizes] = [x, y].map(|v| v[..size].iter().map(|v| modulus(*v)).collect::<SmallVec<[f64; 8]>>());
        for (i, x) in x[..size].iter().enumerate() {
            for (j, y) in y[..size].iter().enumerate() {
                let at = i * size + j;
                let (product, length) = (x * y, x_sizes[i] * y_sizes[j]);
                let term = product * equations.constant(inside)[at];
                out.value += term;
                out.value_error += length * constant.errors[at];
                sizes += modulus(term);
                if of_time
                    && i / 2 != j / 2
                    && self.shift.as_ref().is_none_or(|shift| i != shift.place && j != shift.place)
                {
                    let slide = product * constant.slides[at];
                    slides[i / 2] += slide;
                    slides[j / 2] -= slide;
                }
            }
        }
        for (k, mode) in equations.kernel().modes().iter().enumerate() {
            let (rows, columns) = (equations.rows(k), equations.columns(k));
            let sum = |v: &[C], table: &[[f64; 2]]| {
                let add = |[p, q]: [C; 2], (v, [s, t]): (&C, &[f64; 2])| [p + v * *s, q + v * *t];
                v.iter().zip(table).fold([C::default(); 2], add)
            };
            let (xi, eta) = (sum(&x[..size], rows), sum(&y[..size], columns));
            let errors_of = |v: &[f64], table: &PairErrors, which: usize| {
                let own = table.numbers(which, k * size..(k + 1) * size);
                v.iter().zip(own).map(|(v, error)| v * error).sum::<f64>()
            };
            let (row_errors, column_errors) = (&self.row_errors, &self.column_errors);
            // Of real poles the sum of both coordinates is longer than their length.
            let widest = if mode.coordinates.are_circular() { 1.0 } else { std::f64::consts::SQRT_2 };
            let (a_error, c_error) =
                (widest * errors_of(&x_sizes, row_errors, 0), widest * 0.5 * errors_of(&y_sizes, column_errors, 0));
            if mode.coordinates.are_parabolic() {
                if let Some(place) = near.iter().position(|other| other.mode == k) {
                    let own = |v: &[C]| [v[size + place], v[size + place + 1]];
                    sizes += self.add_bordered_pair(z, k, [own(x), own(y), xi, eta], (a_error, c_error), &mut out);
                } else {
                    self.add_double_pole(z, k, [xi, eta], (2.0 * a_error, 4.0 * c_error), &mut out);
                }
                continue;
            }
            // What each impact's own rows and columns have of these; and what its time has in the orbit's own derivative, where that is left out.
            let of_impact = |i: usize| {
                let kept = |r: &usize| self.shift.as_ref().is_none_or(|shift| shift.place != *r);
                let own = |v: &[C], table: &[[f64; 2]]| {
                    let add = |[p, q]: [C; 2], r: usize| [p + v[r] * table[r][0], q + v[r] * table[r][1]];
                    [2 * i, 2 * i + 1].into_iter().filter(kept).fold([C::default(); 2], add)
                };
                let shifted = self.shift.as_ref().map(|shift| {
                    let (r, weight) = (2 * i + 1, shift.weights[i]);
                    let part = |v: &[C], pair: [f64; 2]| pair.map(|entry| v[shift.place] * (weight * entry));
                    [part(x, shift.row_before(rows, k, r)), part(y, shift.column_before(columns, k, r))]
                });
                ([own(x, rows), own(y, columns)], shifted)
            };
            let impacts: SmallVec<[_; 2]> = (0..if is_felt { n } else { 0 }).map(of_impact).collect();
            for pole in self.poles_of(k) {
                let a = mode.coordinates.seen_of_pole(pole.which, xi);
                let c = mode.coordinates.given_to_pole(pole.which, eta);
                let (a_error, c_error) = match mode.coordinates {
                    Coordinates::Shared(_) => (a_error, c_error),
                    Coordinates::Apart => {
                        (errors_of(&x_sizes, row_errors, pole.which), errors_of(&y_sizes, column_errors, pole.which))
                    }
                };
                // What the columns send on, and what the rows have received.
                let border = near.iter().position(|other| other.mode == k && other.which == pole.which);
                let (sent, received) = if let Some(place) = border {
                    let (xs, ys) = (x[size + place], y[size + place]);
                    let own = xs * (z - pole.value) * ys;
                    let terms = [a * ys, -(xs * pole.value * c), own];
                    out.value += terms[0] + terms[1] + terms[2];
                    out.slope += xs * ys;
                    let length: f64 = terms.iter().map(|term| modulus(*term)).sum();
                    sizes += length;
                    let rounding = pole.error + 2.0 * EPSILON * modulus(z);
                    out.value_error += a_error * modulus(ys)
                        + c_error * modulus(xs * pole.value)
                        + modulus(xs * ys) * rounding
                        + modulus(xs * c) * pole.error
                        + 6.0 * EPSILON * length;
                    out.slope_error += 4.0 * EPSILON * modulus(xs * ys);
                    (ys, -(xs * pole.value))
                } else {
                    let inverse = (z - pole.value).inv();
                    let [near, q, a_size, c_size] = [inverse, pole.value, a, c].map(modulus);
                    if pole.error * near >= TOO_NEAR || near.is_nan() {
                        return None;
                    }
                    let (factor, factor_size) =
                        if inside { (z * inverse, z_size * near) } else { (pole.value * inverse, q * near) };
                    let (dyad, size) = (a * c, a_size * c_size);
                    let dyad_error = a_error * c_size + c_error * a_size + a_error * c_error;
                    let steep = near * near * q;
                    out.value += factor * dyad;
                    out.slope -= pole.value * inverse * inverse * dyad;
                    sizes += factor_size * size;
                    out.value_error += factor_size * (dyad_error + 6.0 * EPSILON * size)
                        + near * near * z_size.max(q) * pole.error * size;
                    out.slope_error += steep * (dyad_error + (8.0 * EPSILON + 3.0 * pole.error * near) * size);
                    (factor * c, factor * a)
                };
                let components = |[xi, eta]: [[C; 2]; 2]| {
                    [mode.coordinates.seen_of_pole(pole.which, xi), mode.coordinates.given_to_pole(pole.which, eta)]
                };
                for (i, (own, shifted)) in impacts.iter().enumerate() {
                    let [mut own_a, mut own_c] = components(*own);
                    if let Some(shifted) = shifted {
                        let by = (pole.value - 1.0).inv();
                        let [part_a, part_c] = components(*shifted).map(|part| part * by);
                        own_a += part_a;
                        own_c += part_c;
                        shares[i] += part_a * sent + received * part_c;
                    }
                    slides[i] += pole.rate * (own_a * sent - received * own_c);
                }
            }
        }
        // Of adding up.
        out.value_error += EPSILON * (equations.kernel().modes().len() as f64).sqrt() * sizes;
        out.data = data
            .iter()
            .map(|origin| {
                let moves = origin.iter().enumerate().take(n).map(|(i, error)| {
                    let kept = self.shift.as_ref().is_none_or(|shift| shift.place != 2 * i + 1);
                    let slide = if kept { x[2 * i + 1] * y[2 * i + 1] * error.slide } else { C::default() };
                    slide + slides[i] * error.time + shares[i] * error.share
                });
                modulus(moves.sum::<C>())
            })
            .sum();
        Some(out)
    }

    /// The most that errors of the data make of a product of null vectors with this rounding error, of an orbit without losses. Rows and columns
    /// count as rounded by 6ε and by 3ε of their phase, and no share or time moves them otherwise. What all shares have in common scales the
    /// orbit's own derivative, which null vectors do not feel.
    fn data_bound(&self, (x, y): (&[C], &[C]), value_error: f64, data: &[Origin]) -> f64 {
        let longest = self.equations.since_cut().iter().copied().fold(0.0, f64::max);
        let of_impact = |(i, error): (usize, &DataError), common: f64| {
            let kept = self.shift.as_ref().is_none_or(|shift| shift.place != 2 * i + 1);
            let slide = if kept { modulus(x[2 * i + 1] * y[2 * i + 1]) * error.slide.abs() } else { 0.0 };
            let turned = if error.time == 0.0 { 0.0 } else { error.time.abs() / (3.0 * longest) };
            slide + (turned + (error.share - common).abs() / 6.0) * value_error / f64::EPSILON
        };
        let of_origin = |origin: &Origin| {
            let common = origin.first().map_or(0.0, |error| error.share);
            origin.iter().enumerate().map(|one| of_impact(one, common)).sum::<f64>()
        };
        data.iter().map(of_origin).sum()
    }

    /// What a mode with a double pole adds that is bordered: with xs and ys of its coordinates ξys + xs(z−R)ys − xsRη; the size of the terms.
    fn add_bordered_pair(
        &self,
        z: C,
        k: usize,
        [xs, ys, xi, eta]: [[C; 2]; 4],
        (a, c): (f64, f64),
        out: &mut Product,
    ) -> f64 {
        let mode = &self.equations.kernel().modes()[k];
        let (q, r) = (mode.period.even, mode.period.odd);
        let length = |v: [C; 2]| modulus(v[0]) + modulus(v[1]);
        let own = xs[0] * ys[0] + xs[1] * ys[1];
        let terms = [xi[0] * ys[0] + xi[1] * ys[1], own * (z - q), xs[0] * ys[1] * -r, xs[0] * eta[1] * -r];
        let past = (xs[0] * eta[0] + xs[1] * eta[1]) * -q;
        out.value += terms.iter().sum::<C>() + past;
        out.slope += own;
        let turned = q.abs() + r.abs();
        let size =
            length(xi) * length(ys) + length(xs) * (length(ys) * (modulus(z - q) + r.abs()) + length(eta) * turned);
        let pole = mode.pole_error * (1.0 + r.abs()) + 2.0 * f64::EPSILON * modulus(z);
        out.value_error += 2.0 * a * length(ys)
            + 4.0 * c * length(xs) * turned
            + length(xs) * (length(ys) + length(eta)) * pole
            + 6.0 * f64::EPSILON * size;
        out.slope_error += 4.0 * f64::EPSILON * length(xs) * length(ys);
        size
    }

    /// What a mode with a double pole adds.
    fn add_double_pole(&self, z: C, k: usize, [xi, eta]: [[C; 2]; 2], (a, c): (f64, f64), out: &mut Product) {
        let mode = &self.equations.kernel().modes()[k];
        let coordinates = mode.coordinates;
        let resolvent = coordinates.resolvent(mode.period, z);
        let past = coordinates.product(mode.period.complex(), resolvent);
        let inside = self.equations.is_inside(z);
        let sum = if inside { Turned { even: resolvent.even * z, odd: resolvent.odd * z } } else { past };
        let slope = coordinates.product(past, resolvent);
        let pair = |by: Turned<C>| {
            // Of a double pole J² = 0.
            by.even * (xi[0] * eta[0] + xi[1] * eta[1]) + by.odd * (xi[0] * eta[1])
        };
        let size = |by: Turned<C>| modulus(by.even) + modulus(by.odd);
        let length = |v: [C; 2]| modulus(v[0]) + modulus(v[1]);
        let (x, y) = (length(xi), length(eta));
        let error = a * y + c * x + a * c + 8.0 * f64::EPSILON * x * y;
        out.value += pair(sum);
        out.slope -= pair(slope);
        // Either sum changes with R by z(z−R)⁻².
        let moved = modulus(z) * size(coordinates.product(resolvent, resolvent)) * mode.pole_error;
        out.value_error += size(sum) * error + moved * x * y;
        out.slope_error += size(slope) * error;
    }
}

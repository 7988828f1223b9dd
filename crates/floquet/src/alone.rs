//! A mass without coupling: its monodromy matrix is 2 × 2, and its multipliers are those of trace and determinant,
//!
//! ```text
//! M = Π R(τ_i)S_i,   μ² − tr M μ + e^{2n} = 0,   |μ| = e^n where |½ tr M| < e^n,   |½ tr M| + √(¼ tr² M − e^{2n}) beyond.
//! ```
//!
//! The determinant is exact, so that all that can be wrong is one number. With N_i the product of all factors but S_i, begun after it,
//! tr M = tr S_iN_i has the derivatives ∂/∂κ_i = (N_i)_uv and ∂/∂t_i = κ_i((N_i)_vv − (N_i)_uu): errors of one origin keep their signs.

use nalgebra::Complex;
use vibrochain_breather::{Condition, Finder, Orbit};
use vibrochain_lattice::sine_over;

use crate::error::FloquetError;
use crate::saltation::{Saltation, saltations};
use crate::verdict::{Method, Tolerance, Verdict};

type Matrix = [[f64; 2]; 2];

/// Closer to the border than this a sweep, too, asks for the errors of the orbit's data.
const NEAR: f64 = 1e-6;

/// Verdict and, if `thorough`, the non-trivial multipliers of the mass that is hit.
pub(crate) fn verdict(
    orbit: &Orbit,
    finder: &mut Finder,
    tolerance: Tolerance,
    thorough: bool,
) -> Result<(Verdict, Vec<Complex<f64>>), FloquetError> {
    let method = Method::Dense(None);
    let hits: Vec<Saltation> = saltations(orbit)?.collect();
    if orbit.model().is_conservative() {
        // Its only pair is the trivial one.
        return Ok((Verdict { method, ..Verdict::on_circle(None) }, Vec::new()));
    }
    let careful = thorough || finder.is_delicate(orbit)?;
    let condition = if careful { Some(finder.condition(orbit)?) } else { None };
    let mut pair = Pair::of(orbit, &hits, condition.as_ref());
    if condition.is_none() && (pair.growth() - tolerance.allowed()).abs() < NEAR.max(4.0 * pair.growth_error()) {
        pair = Pair::of(orbit, &hits, Some(&finder.condition(orbit)?));
    }
    let multipliers = if thorough { pair.multipliers().to_vec() } else { Vec::new() };
    Ok((Verdict { method, ..pair.verdict(tolerance) }, multipliers))
}

/// The two multipliers, by their half trace.
struct Pair {
    half: f64,
    error: f64,
    /// e^n, the root of the determinant.
    modulus: f64,
}

impl Pair {
    fn of(orbit: &Orbit, hits: &[Saltation], condition: Option<&Condition>) -> Self {
        let (e, rate) = (orbit.model().restitution(), orbit.model().chain().gamma1().sqrt());
        let n = hits.len();
        let flights: Vec<f64> = (0..n)
            .map(|i| hits.get(i + 1).map_or(hits[0].time + orbit.period(), |next| next.time) - hits[i].time)
            .collect();
        let flow = |time: f64| {
            let cos = (rate * time).cos();
            [[cos, sine_over(rate, time)], [-rate * (rate * time).sin(), cos]]
        };
        let saltation = |hit: &Saltation| [[-e, 0.0], [hit.kappa, -e]];
        // All factors but S_i, from just after it.
        let rest = |i: usize, each: fn(Matrix) -> Matrix| {
            (1..n).fold(each(flow(flights[i])), |product, step| {
                let j = (i + step) % n;
                times(each(flow(flights[j])), times(each(saltation(&hits[j])), product))
            })
        };
        let products: Vec<Matrix> = (0..n).map(|i| rest(i, |m| m)).collect();
        let trace = |product: Matrix| product[0][0] + product[1][1];
        let whole = trace(times(products[0], saltation(&hits[0])));
        let sizes = trace(times(rest(0, moduli), moduli(saltation(&hits[0]))));
        let mut error = 4.0 * f64::EPSILON * n as f64 * sizes;
        for (i, product) in products.iter().enumerate() {
            // Each κ is rounded, and each angle.
            error += 4.0 * f64::EPSILON * (hits[i].kappa * product[0][1]).abs();
            let generator = [[0.0, 1.0], [-rate * rate, 0.0]];
            // N_i ends with the flight to impact i.
            let turned = trace(times(generator, times(*product, saltation(&hits[i]))));
            error += 4.0 * f64::EPSILON * flights[(i + n - 1) % n] * turned.abs();
        }
        for origin in condition.iter().flat_map(|condition| &condition.origins) {
            let moved =
                origin.iter().zip(hits).zip(orbit.impacts()).zip(&products).map(|(((known, hit), impact), product)| {
                    let kappa = (1.0 + e) * known.acceleration / impact.velocity_before
                        - hit.kappa * known.impulse / impact.impulse;
                    kappa * product[0][1] + known.time * hit.kappa * (product[1][1] - product[0][0])
                });
            error += moved.sum::<f64>().abs();
        }
        Self { half: 0.5 * whole, error: 0.5 * error, modulus: e.powi(n as i32) }
    }

    /// Modulus of the larger one for a half trace of this size.
    fn modulus_at(&self, half: f64) -> f64 {
        let root = ((half - self.modulus) * (half + self.modulus)).max(0.0).sqrt();
        half.max(self.modulus) + root
    }

    fn growth(&self) -> f64 {
        self.modulus_at(self.half.abs()) - 1.0
    }

    fn growth_error(&self) -> f64 {
        let half = self.half.abs();
        let here = self.modulus_at(half);
        let [above, below] = [half + self.error, half - self.error].map(|half| (self.modulus_at(half) - here).abs());
        // Not a number is no bound.
        let reach = if self.error.is_finite() { above.max(below) } else { f64::INFINITY };
        // The growth is rounded, too, where little is left of the modulus.
        reach + 4.0 * f64::EPSILON * here + f64::EPSILON * (here - 1.0).abs()
    }

    /// The larger one first.
    fn multipliers(&self) -> [Complex<f64>; 2] {
        let (half, modulus) = (self.half, self.modulus);
        if half.abs() < modulus {
            let im = ((modulus - half) * (modulus + half)).sqrt();
            return [Complex::new(half, im), Complex::new(half, -im)];
        }
        let large = self.modulus_at(half.abs()).copysign(half);
        [Complex::new(large, 0.0), Complex::new(modulus / large * modulus, 0.0)]
    }

    fn verdict(&self, tolerance: Tolerance) -> Verdict {
        let (growth, error, leading) = (self.growth(), self.growth_error(), self.multipliers()[0]);
        if self.modulus < 1.0 || self.half.abs() - self.error > 1.0 {
            Verdict::of_growth(leading, growth, error, tolerance)
        } else if self.half.abs() + self.error < 1.0 {
            Verdict::on_circle(Some(leading))
        } else {
            Verdict::unsettled(leading, growth, error, tolerance)
        }
    }
}

fn times(a: Matrix, b: Matrix) -> Matrix {
    [0, 1].map(|i| [0, 1].map(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

fn moduli(matrix: Matrix) -> Matrix {
    matrix.map(|row| row.map(f64::abs))
}

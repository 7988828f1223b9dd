//! [`super::forced`] for large rings: residues in O(M), and f as two real sums for everything that comes after.
//!
//! With 2a = φ the cotangents are one over a difference of d = cos φ,
//!
//! ```text
//! ½(cot(a_k−a_l) + cot(a_k+a_l)) = sin φ_k/(d_l−d_k),      ½(cot(a_k−a_l) − cot(a_k+a_l)) = sin φ_l/(d_l−d_k),
//! ```
//!
//! so that all K̂(p_k) are Cauchy sums with real charges: three for the impacts themselves, six for each two of them. And f,
//! its poles taken in conjugate pairs, is
//!
//! ```text
//! f(z) = 1 + A(ν) − B(ν)/z,   A = Σ Re ρ/(ν−d),  B = Σ Re(ρp̄)/(ν−d),   ν = ½(z+1/z) = cos θ,  z = e^{iθ}.
//! ```

use nalgebra::Complex;
use vibrochain_lattice::ImpulseResponse;

use super::cauchy::Tree;
use super::circle::{CircleForm, CirclePole};
use super::doubt::Doubt;
use super::forced_roots::CircleRoots;

type C = Complex<f64>;

/// Number of modes from which Cauchy sums are faster than pairs.
pub(crate) const LARGE: usize = 192;

/// Residues and multipliers of a large ring; also the work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct ForcedLarge {
    form: CircleForm,
    pub(crate) roots: CircleRoots,
}

/// A mode by rising d.
struct Sorted {
    mode: usize,
    d: f64,
    cos: f64,
    sin: f64,
}

/// Sums Σ_{l≠k} q_l/(d_l−d_k) for all k in the order of `sorted`, and for each k the smallest |d_l−d_k|.
fn sums<const CHANNELS: usize>(
    sorted: &[Sorted],
    tree: &Tree,
    points: &[f64],
    charges: &[[f64; CHANNELS]],
) -> Result<Vec<[f64; CHANNELS]>, Doubt> {
    let mut out = vec![[0.0; CHANNELS]; sorted.len()];
    for field in tree.fields(points, charges, tree) {
        for k in field.targets.clone() {
            let own = &sorted[k];
            // The kernel of the field is 1/(d_k−d_l).
            let mut sum = field.at(points[k]).map(|far| -far);
            for l in field.near.iter().flat_map(Clone::clone).filter(|&l| l != k) {
                let other = &sorted[l];
                let difference = if own.d < 0.0 {
                    2.0 * (other.cos - own.cos) * (other.cos + own.cos)
                } else {
                    2.0 * (own.sin - other.sin) * (own.sin + other.sin)
                };
                if difference == 0.0 {
                    return Err(Doubt::Coincident { mode: own.mode });
                }
                let inverse = 1.0 / difference;
                sum.iter_mut().zip(&charges[l]).for_each(|(sum, charge)| *sum += charge * inverse);
            }
            out[k] = sum;
        }
    }
    Ok(out)
}

impl ForcedLarge {
    /// Residues of impacts at `times`, saltations `kappas`, into `residues` by mode; returns their errors.
    pub(crate) fn set(
        &mut self,
        (times, kappas): (&[f64], &[f64]),
        (e, q): (f64, f64),
        response: &ImpulseResponse,
        residues: &mut Vec<C>,
    ) -> Result<Vec<f64>, Doubt> {
        let (frequencies, weights, omega) = (response.frequencies(), response.weights(), response.omega());
        let (cos, sin) = (response.cos_half(), response.sin_half());
        let count = frequencies.len();
        let mut sorted: Vec<Sorted> = (0..count)
            .map(|k| {
                let (c, s) = (cos[k], sin[k]);
                Sorted { mode: k, d: (c - s) * (c + s), cos: c.abs(), sin: s.abs() }
            })
            .collect();
        sorted.sort_unstable_by(|a, b| a.d.total_cmp(&b.d).then(b.sin.total_cmp(&a.sin)).then(a.cos.total_cmp(&b.cos)));
        let points: Vec<f64> = sorted.iter().map(|mode| mode.d).collect();
        let tree = Tree::new(&points, false);
        let n = times.len();
        let size = 2 * n;
        let border = size + 1;
        // [mode by rising d][row][column]
        let mut matrices = vec![C::default(); count * border * border];
        let sine = |mode: usize| 2.0 * sin[mode] * cos[mode];
        let charges: Vec<[f64; 3]> = sorted
            .iter()
            .map(|mode| {
                let (w, f) = (weights[mode.mode], frequencies[mode.mode]);
                let v = w * sine(mode.mode);
                [w, v * omega / f, v * f / omega]
            })
            .collect();
        for (place, sum) in sums(&sorted, &tree, &points, &charges)?.into_iter().enumerate() {
            let mode = sorted[place].mode;
            // The mode's own part: cot φ_k alone.
            let own = 0.5 * points[place] / sine(mode);
            let [w, up, down] = charges[place].map(|charge| charge * own);
            let u = sine(mode) * sum[0] + w;
            let (up, down) = (sum[1] - up / sine(mode), sum[2] - down / sine(mode));
            let matrix = &mut matrices[place * border * border..][..border * border];
            for i in 0..n {
                let at = 2 * i * border + 2 * i;
                matrix[at] = C::new(0.5 * q, -0.5 * u);
                matrix[at + border + 1] = C::new(0.5 * q, -0.5 * u);
                matrix[at + 1] = C::new(-0.5 * up, 0.0);
                matrix[at + border] = C::new(kappas[i] / omega + 0.5 * down, 0.0);
            }
        }
        for i in 1..n {
            for j in 0..i {
                add_pair(&sorted, &tree, &points, response, times[i] - times[j], (i, j, border), &mut matrices)?;
            }
        }
        let scale = (1.0 + e).powi(size as i32);
        residues.clear();
        residues.resize(count, C::default());
        let mut errors = vec![0.0; count];
        let (mut total, mut total_error, mut product) = (0.0, 0.0, 0.0);
        self.form.poles.clear();
        for (place, own) in sorted.iter().enumerate() {
            let k = own.mode;
            let (f, matrix) = (frequencies[k], &mut matrices[place * border * border..][..border * border]);
            for i in 0..n {
                let turn = C::from_polar(1.0, f * (times[i] - times[0]));
                matrix[2 * i * border + size] = turn;
                matrix[(2 * i + 1) * border + size] = turn * C::new(0.0, f / omega);
                matrix[size * border + 2 * i] = turn.conj() * 0.5;
                matrix[size * border + 2 * i + 1] = turn.conj() * C::new(0.0, -0.5 * omega / f);
            }
            let pole = C::new(own.d, sine(k));
            let residue = -super::linear::determinant(matrix, border) * pole * (scale * weights[k]);
            let mut nearest = 2.0 * own.sin * own.cos;
            for other in [place.checked_sub(1), Some(place + 1)].into_iter().flatten().filter_map(|l| sorted.get(l)) {
                nearest = nearest.min((own.sin * other.cos - own.cos * other.sin).abs());
            }
            let phase = f * response.period();
            let modulus = residue.norm();
            let error = modulus * f64::EPSILON * (16.0 + 2.0 * phase / nearest);
            total += modulus;
            total_error += error;
            product += 2.0 * (residue * pole.conj()).re;
            residues[k] = residue;
            errors[k] = error;
            let shift = f64::EPSILON * (2.0 + 2.0 * phase);
            self.form.poles.push(CirclePole::new(own.cos, own.sin, pole.im, residue, error, shift));
        }
        // f(0) = e^{2n}
        let defect = (1.0 - product - e.powi(size as i32)).abs();
        let allowed = 16.0 * (total_error + 16.0 * f64::EPSILON * (1.0 + total));
        // Not a number is a doubt, too.
        let sound = defect <= allowed && allowed < 1.0 + total;
        if !sound {
            return Err(Doubt::Certificate { defect, allowed });
        }
        self.form.divide();
        Ok(errors)
    }

    /// How far each multiplier is from a zero of another function with the same poles, to first order.
    pub(crate) fn moved(&self, other: &Self) -> Vec<f64> {
        self.roots.moved(&self.form, &other.form)
    }

    /// All multipliers, the first `trivial` of them 1.
    pub(crate) fn solve(&mut self, trivial: usize) -> Result<(), Doubt> {
        self.roots.solve(&self.form, trivial)
    }
}

/// Adds what impact j makes of impact i and the other way round to K̂ of all modes.
fn add_pair(
    sorted: &[Sorted],
    tree: &Tree,
    points: &[f64],
    response: &ImpulseResponse,
    elapsed: f64,
    (i, j, border): (usize, usize, usize),
    matrices: &mut [C],
) -> Result<(), Doubt> {
    let (frequencies, weights, omega) = (response.frequencies(), response.weights(), response.omega());
    let sine = |mode: usize| 2.0 * response.sin_half()[mode] * response.cos_half()[mode];
    let mut free = [0.0; 3];
    let charges: Vec<[f64; 6]> = sorted
        .iter()
        .map(|mode| {
            let (w, f) = (weights[mode.mode], frequencies[mode.mode]);
            let (sin, cos) = (f * elapsed).sin_cos();
            let (inverse, ratio, v) = (omega / f, f / omega, sine(mode.mode));
            free[0] += 0.5 * w * cos;
            free[1] += 0.5 * w * sin * inverse;
            free[2] -= 0.5 * w * sin * ratio;
            let (c, s) = (w * cos, w * sin);
            [c, v * s, v * c * inverse, v * c * ratio, s * inverse, s * ratio]
        })
        .collect();
    for (place, sum) in sums(sorted, tree, points, &charges)?.into_iter().enumerate() {
        let sine = sine(sorted[place].mode);
        let own = 0.5 * points[place] / sine;
        let mut terms = sum;
        // U-sums take sin φ_k as a factor, V-sums have it in their charges; the mode's own U and V are ±½cot φ_k.
        for channel in [0, 4, 5] {
            terms[channel] = sine * sum[channel] + own * charges[place][channel];
        }
        for channel in [1, 2, 3] {
            terms[channel] = sum[channel] - own * charges[place][channel] / sine;
        }
        let [u_c, v_s, v_c_inverse, v_c_ratio, u_s_inverse, u_s_ratio] = terms.map(|term| 0.5 * term);
        let matrix = &mut matrices[place * border * border..][..border * border];
        for (row, column, sign) in [(i, j, 1.0), (j, i, -1.0)] {
            let at = 2 * row * border + 2 * column;
            // −(i/2)(U cos + iV sin) and −½(V cos + iU sin) × (1/Ω, −Ω); R₀(−τ) comes with the opposite sign.
            let even = C::new(sign * (v_s + free[0]), -u_c);
            matrix[at] += even;
            matrix[at + border + 1] += even;
            matrix[at + 1] += C::new(free[1] - v_c_inverse, -sign * u_s_inverse);
            matrix[at + border] += C::new(free[2] + v_c_ratio, sign * u_s_ratio);
        }
    }
    Ok(())
}

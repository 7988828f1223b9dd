//! [`crate::map_paths::one_contact::multipliers`] for large rings: residues in O(M), and f as two real sums for everything that comes after.
//!
//! With 2a = φ the cotangents are one over a difference of d = cos φ,
//!
//! ```text
//! ½(cot(a_k−a_l) + cot(a_k+a_l)) = sin φ_k/(d_l−d_k),      ½(cot(a_k−a_l) − cot(a_k+a_l)) = sin φ_l/(d_l−d_k),
//! ```
//!
//! so that the sums of [`crate::map_paths::one_contact::other_modes`] are Cauchy sums with real charges: three for the impacts themselves, six for each two of them. And f,
//! its poles taken in conjugate pairs, is
//!
//! ```text
//! f(z) = 1 + A(ν) − B(ν)/z,   A = Σ Re ρ/(ν−d),  B = Σ Re(ρp̄)/(ν−d),   ν = ½(z+1/z) = cos θ,  z = e^{iθ}.
//! ```

use nalgebra::Complex;
use smallvec::smallvec;

use crate::map_paths::fast_sums::large_roots::CircleRoots;
use crate::map_paths::fast_sums::multipole::Tree;
use crate::map_paths::fast_sums::near_circle::{CircleForm, CirclePole};
use crate::map_paths::modes::Modes;
use crate::map_paths::one_contact::other_modes::{OtherModes, PoleSums, pairs};
use crate::map_paths::reversible::pole::Angle;
use crate::zeros::SecularError;

type C = Complex<f64>;

/// Residues and multipliers of a large ring; also the work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct ForcedLarge {
    form: CircleForm,
    pub(crate) roots: CircleRoots,
}

/// A mode by rising d.
struct Sorted {
    mode: usize,
    at: Angle,
    /// sin φ with its sign.
    sine: f64,
}

fn sorted(modes: &Modes) -> Vec<Sorted> {
    let halves = modes.list().iter().map(|mode| (mode.cos, mode.sin)).enumerate();
    let mode = |(mode, (c, s)): (usize, (f64, f64))| Sorted { mode, at: Angle::new(c, s), sine: 2.0 * s * c };
    let mut sorted: Vec<Sorted> = halves.map(mode).collect();
    sorted.sort_unstable_by(|a, b| a.at.order(&b.at));
    sorted
}

/// Σ_{l≠k} q_l/(d_l−d_k) for all k in the order of `sorted`.
fn cauchy<const CHANNELS: usize>(
    sorted: &[Sorted],
    tree: &Tree,
    points: &[f64],
    charges: &[[f64; CHANNELS]],
) -> Result<Vec<[f64; CHANNELS]>, SecularError> {
    let mut out = vec![[0.0; CHANNELS]; sorted.len()];
    for field in tree.fields(points, |l| charges[l], tree) {
        for k in field.targets.clone() {
            let own = &sorted[k];
            // The kernel of the field is 1/(d_k−d_l).
            let mut sum = field.at(points[k]).map(|far| -far);
            for l in field.near().filter(|&l| l != k) {
                let difference = -own.at.distance(&sorted[l].at);
                if difference == 0.0 {
                    return Err(SecularError::Coincident { mode: own.mode });
                }
                let inverse = 1.0 / difference;
                sum.iter_mut().zip(&charges[l]).for_each(|(sum, charge)| *sum += charge * inverse);
            }
            out[k] = sum;
        }
    }
    Ok(out)
}

/// What all K̂(p_k) of `n` impacts need of the other modes, in the order of the modes.
pub(crate) fn sums(felt: &Modes, omega: f64, modes: &OtherModes, n: usize) -> Result<Vec<PoleSums>, SecularError> {
    let sorted = sorted(felt);
    let of = |mode: usize| (felt.mode(mode).weight, felt.mode(mode).frequency);
    let points: Vec<f64> = sorted.iter().map(|mode| mode.at.d).collect();
    let tree = Tree::new(&points, false);
    let mut all = vec![PoleSums { pairs: smallvec![[0.0; 6]; n * (n - 1) / 2], ..PoleSums::default() }; sorted.len()];
    let charges: Vec<[f64; 3]> = sorted
        .iter()
        .map(|mode| {
            let (w, f) = of(mode.mode);
            let v = w * mode.sine;
            [w, v * omega / f, v * f / omega]
        })
        .collect();
    for (place, sum) in cauchy(&sorted, &tree, &points, &charges)?.into_iter().enumerate() {
        let own = &sorted[place];
        // The mode's own part: cot φ_k alone.
        let [w, up, down] = charges[place].map(|charge| charge * 0.5 * own.at.d / own.sine);
        let sums = &mut all[own.mode];
        sums.own = [own.sine * sum[0] + w, sum[1] - up / own.sine, sum[2] - down / own.sine].map(|sum| 0.5 * sum);
        sums.nearest = 2.0 * own.at.sin * own.at.cos;
        for other in [place.checked_sub(1), Some(place + 1)].into_iter().flatten().filter_map(|l| sorted.get(l)) {
            sums.nearest = sums.nearest.min((own.at.sin * other.at.cos - own.at.cos * other.at.sin).abs());
        }
    }
    for (_, _, pair) in pairs(n) {
        let (cos, sin) = modes.turns(pair);
        let charges: Vec<[f64; 6]> = sorted
            .iter()
            .map(|mode| {
                let (w, f) = of(mode.mode);
                let (inverse, ratio, v) = (omega / f, f / omega, mode.sine);
                let (c, s) = (w * cos[mode.mode], w * sin[mode.mode]);
                [c, v * s, v * c * inverse, s * inverse, v * c * ratio, s * ratio]
            })
            .collect();
        for (place, mut sum) in cauchy(&sorted, &tree, &points, &charges)?.into_iter().enumerate() {
            let Sorted { mode, at, sine } = sorted[place];
            let own = charges[place].map(|charge| charge * 0.5 * at.d / sine);
            // U-sums take sin φ_k as a factor, V-sums have it in their charges; the mode's own U and V are ±½cot φ_k.
            for channel in [0, 3, 5] {
                sum[channel] = sine * sum[channel] + own[channel];
            }
            for channel in [1, 2, 4] {
                sum[channel] -= own[channel] / sine;
            }
            all[mode].pairs[pair] = sum.map(|sum| 0.5 * sum);
        }
    }
    Ok(all)
}

impl ForcedLarge {
    /// Takes over residues and their errors, by modes.
    pub(crate) fn set(&mut self, modes: &Modes, period: f64, residues: &[C], errors: &[f64]) {
        self.form.poles.clear();
        self.form.poles.extend(sorted(modes).iter().map(|own| {
            let shift = f64::EPSILON * (2.0 + 2.0 * modes.mode(own.mode).frequency * period);
            CirclePole::new(own.at, own.sine, residues[own.mode], errors[own.mode], shift)
        }));
        self.form.divide();
    }

    /// How far each multiplier is from a zero of another function with the same poles, to first order.
    pub(crate) fn moved(&self, other: &Self) -> Vec<f64> {
        self.roots.moved(&self.form, &other.form)
    }

    /// All multipliers, the first `trivial` of them 1.
    pub(crate) fn solve(&mut self, trivial: usize) -> Result<(), SecularError> {
        self.roots.solve(&self.form, trivial)
    }
}

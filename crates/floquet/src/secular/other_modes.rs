//! K̂ at a pole p_k of a mode, the mode's own dyad left out: real sums over the other modes.
//!
//! At z = p_k the factors ½(z+p)/(z−p) of [`super::impact_matrix`] are −(i/2)cot(a_k∓a_l), a = ΩT/2. With
//! U, V = ½(cot(a_k−a_l) ± cot(a_k+a_l)) and τ = t_i − t_j the block of impacts i and j is
//!
//! ```text
//! Σ b² { −(i/2)(U cos Ωτ + iV sin Ωτ) 1  −  ½(V cos Ωτ + iU sin Ωτ) [[0, 1/Ω], [−Ω, 0]] }.
//! ```
//!
//! A fast path: on 21 sites it takes at most 1700 instructions where the complex sums of [`super::impact_matrix`] take 4400 (callgrind, a
//! sweep of forced orbits), and K̂ is worked out so for every mode of every orbit, which would be 65 % more for the residues. The tests of
//! `impact_matrix` hold it against those sums.

use nalgebra::Complex;
use smallvec::SmallVec;
use vibrochain_breather::lanes::{Lane, ONE, ZERO, all, fill, four, total};
use wide::f64x4;

use super::error::SecularError;
use super::modes::Modes;

type C = Complex<f64>;

/// What the sums need of every mode.
#[derive(Debug, Clone, Default)]
pub(super) struct OtherModes {
    half_weight: Vec<Lane>,
    cos: Vec<Lane>,
    sin: Vec<Lane>,
    /// Ω/ω and its inverse.
    ratio: Vec<Lane>,
    inverse: Vec<Lane>,
    /// cos, sin of Ω(t_i−t_j) for i > j: [pair][group of modes]
    turn_cos: Vec<Lane>,
    turn_sin: Vec<Lane>,
    scratch: Vec<[f64x4; 6]>,
}

/// The sums at one pole, velocities in units of ω.
#[derive(Debug, Clone, Default)]
pub(super) struct PoleSums {
    /// ½Σb²U, ½Σb²V/Ω, ½Σb²VΩ
    pub(super) own: [f64; 3],
    /// The same with cos, sin of Ω(t_i−t_j) for all pairs i > j: U cos, V sin, V cos/Ω, U sin/Ω, ΩV cos, ΩU sin.
    pub(super) pairs: SmallVec<[[f64; 6]; 1]>,
    /// The smallest |sin(a_k±a_l)|.
    pub(super) nearest: f64,
}

/// Pairs i > j of impacts and their numbers.
pub(super) fn pairs(n: usize) -> impl Iterator<Item = (usize, usize, usize)> {
    (1..n).flat_map(|i| (0..i).map(move |j| (i, j, i * (i - 1) / 2 + j)))
}

impl PoleSums {
    /// Adds them to K̂ of `n` impacts, whose rows are `width` long.
    pub(super) fn add_to(&self, matrix: &mut [C], n: usize, width: usize) {
        let mut add = |i: usize, j: usize, [even, up, down]: [C; 3]| {
            let at = 2 * i * width + 2 * j;
            matrix[at] += even;
            matrix[at + width + 1] += even;
            matrix[at + 1] += up;
            matrix[at + width] += down;
        };
        let [u, up, down] = self.own;
        for i in 0..n {
            add(i, i, [C::new(0.0, -u), C::new(-up, 0.0), C::new(down, 0.0)]);
        }
        for (i, j, pair) in pairs(n) {
            let [uc, vs, vc_up, us_up, vc_down, us_down] = self.pairs[pair];
            for (i, j, sign) in [(i, j, 1.0), (j, i, -1.0)] {
                let even = C::new(sign * vs, -uc);
                add(i, j, [even, C::new(-vc_up, -sign * us_up), C::new(vc_down, sign * us_down)]);
            }
        }
    }
}

impl OtherModes {
    /// Takes over modes and the times of impacts.
    pub(super) fn set(&mut self, modes: &Modes, omega: f64, times: &[f64]) {
        let modes = modes.list();
        fill(&mut self.half_weight, modes.iter().map(|mode| 0.5 * mode.weight), 0.0);
        // A mode that is none: no pole meets it.
        fill(&mut self.cos, modes.iter().map(|mode| mode.cos), 2.0);
        fill(&mut self.sin, modes.iter().map(|mode| mode.sin), 0.0);
        fill(&mut self.ratio, modes.iter().map(|mode| mode.frequency / omega), 0.0);
        fill(&mut self.inverse, modes.iter().map(|mode| omega / mode.frequency), 0.0);
        let groups = self.cos.len();
        self.turn_cos.clear();
        self.turn_sin.clear();
        for (i, j, pair) in pairs(times.len()) {
            self.turn_cos.resize((pair + 1) * groups, [0.0; 4]);
            self.turn_sin.resize((pair + 1) * groups, [0.0; 4]);
            let elapsed = times[i] - times[j];
            for (l, mode) in modes.iter().enumerate() {
                let (sin, cos) = (mode.frequency * elapsed).sin_cos();
                self.turn_cos.as_flattened_mut()[4 * pair * groups + l] = cos;
                self.turn_sin.as_flattened_mut()[4 * pair * groups + l] = sin;
            }
        }
    }

    /// cos, sin Ω(t_i−t_j) of all modes for one pair.
    pub(super) fn turns(&self, pair: usize) -> (&[f64], &[f64]) {
        let groups = self.cos.len();
        let range = pair * groups..(pair + 1) * groups;
        (self.turn_cos[range.clone()].as_flattened(), self.turn_sin[range].as_flattened())
    }

    /// What K̂ has at all poles alike: propagators ±½R₀(t_i−t_j) over the times between impacts, losses, saltations κ'.
    pub(super) fn shared(&self, q: f64, kappas: &[f64], (modes, omega): (&Modes, f64), shared: &mut Vec<f64>) {
        let n = kappas.len();
        let size = 2 * n;
        shared.clear();
        shared.resize(size * size, 0.0);
        for i in 0..n {
            shared[2 * i * size + 2 * i] = 0.5 * q;
            shared[(2 * i + 1) * size + 2 * i + 1] = 0.5 * q;
            shared[(2 * i + 1) * size + 2 * i] = kappas[i] / omega;
        }
        for (i, j, pair) in pairs(n) {
            let (cos, sin) = self.turns(pair);
            let (mut c, mut up, mut down) = (0.0, 0.0, 0.0);
            for (l, mode) in modes.list().iter().enumerate() {
                let (w, f, turn) = (0.5 * mode.weight, mode.frequency, sin[l]);
                c += w * cos[l];
                up += w * turn / f * omega;
                down -= w * turn * f / omega;
            }
            // R₀(−τ) comes with the opposite sign.
            for (row, column, sign) in [(i, j, 1.0), (j, i, -1.0)] {
                let at = 2 * row * size + 2 * column;
                (shared[at], shared[at + size + 1]) = (sign * c, sign * c);
                (shared[at + 1], shared[at + size]) = (up, down);
            }
        }
    }

    /// The sums at the pole of mode k, which has these cos, sin(Ω_kT/2), of `count` pairs of impacts.
    #[inline]
    pub(super) fn sums(
        &mut self,
        k: usize,
        (ck, sk): (f64, f64),
        count: usize,
        sums: &mut PoleSums,
    ) -> Result<(), SecularError> {
        let Self { half_weight, cos, sin, ratio, inverse, turn_cos, turn_sin, scratch } = self;
        let groups = cos.len();
        let (ck, sk) = (all(ck), all(sk));
        let mut own = [ZERO; 3];
        scratch.clear();
        scratch.resize(count, [ZERO; 6]);
        let (mut coincident, mut nearest) = (ZERO, ONE);
        for g in 0..groups {
            let (c, s) = (four(cos[g]), four(sin[g]));
            let (a, b) = (sk * c, ck * s);
            let (minus, plus) = (a - b, a + b);
            let same = minus.simd_eq(ZERO);
            coincident += same.select(ONE, ZERO);
            nearest = nearest.min(same.select(ONE, minus.abs())).min(plus.abs());
            let (cc, ss) = (ck * c, sk * s);
            let cot_minus = same.select(ZERO, (cc + ss) / same.select(ONE, minus));
            let cot_plus = (cc - ss) / plus;
            let w = four(half_weight[g]);
            let (u, v) = (w * (cot_minus + cot_plus), w * (cot_minus - cot_plus));
            let (up, down) = (four(inverse[g]), four(ratio[g]));
            own[0] += u;
            own[1] += v * up;
            own[2] += v * down;
            for (pair, sums) in scratch.iter_mut().enumerate() {
                let (c, s) = (four(turn_cos[pair * groups + g]), four(turn_sin[pair * groups + g]));
                let (uc, us, vc, vs) = (u * c, u * s, v * c, v * s);
                for (sum, term) in sums.iter_mut().zip([uc, vs, vc * up, us * up, vc * down, us * down]) {
                    *sum += term;
                }
            }
        }
        sums.nearest = nearest.to_array().into_iter().fold(f64::INFINITY, f64::min);
        // It meets itself once.
        if total(coincident) != 1.0 || sums.nearest == 0.0 {
            return Err(SecularError::Coincident { mode: k });
        }
        sums.own = own.map(|sum| 0.5 * total(sum));
        sums.pairs.clear();
        sums.pairs.extend(scratch.iter().map(|pair| pair.map(|sum| 0.5 * total(sum))));
        Ok(())
    }
}

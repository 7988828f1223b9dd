//! K̂ at a pole p_k of a mode, the mode's own dyad left out: real sums over the other modes.
//!
//! At z = p_k the factors ½(z+p)/(z−p) of K̂ ([`crate::map_paths::one_contact::multipliers`]) are −(i/2)cot(a_k∓a_l), a = ΩT/2. With
//! U, V = ½(cot(a_k−a_l) ± cot(a_k+a_l)) and τ = t_i − t_j the block of impacts i and j is
//!
//! ```text
//! Σ b² { −(i/2)(U cos Ωτ + iV sin Ωτ) 1  −  ½(V cos Ωτ + iU sin Ωτ) [[0, 1/Ω], [−Ω, 0]] }.
//! ```
//!
//! Four poles at a time, each with all other modes. A fast path: the complex sums of J(z) take many times as long, and
//! K̂ is worked out so for every mode of every orbit. `map_paths/tests/determinants.rs` holds it against those sums.

use nalgebra::Complex;
use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::simd::lanes::{HALF, LANES, Lane, ONE, ZERO, all, fill, four};
use wide::f64x4;

use crate::map_paths::modes::{Mode, Modes};
use crate::zeros::SecularError;

type C = Complex<f64>;

/// What the sums need of every mode.
#[derive(Debug, Clone, Default)]
pub(crate) struct OtherModes {
    half_weight: Vec<Lane>,
    cos: Vec<Lane>,
    sin: Vec<Lane>,
    /// Ω/ω and its inverse.
    ratio: Vec<Lane>,
    inverse: Vec<Lane>,
    /// cos, sin of Ω(t_i−t_j) for i > j: [pair][group of modes]
    turn_cos: Vec<Lane>,
    turn_sin: Vec<Lane>,
    count: usize,
}

/// The sums at one pole, velocities in units of ω.
#[derive(Debug, Clone, Default)]
pub(crate) struct PoleSums {
    /// ½Σb²U, ½Σb²V/Ω, ½Σb²VΩ
    pub(crate) own: [f64; 3],
    /// The same with cos, sin of Ω(t_i−t_j) for all pairs i > j: U cos, V sin, V cos/Ω, U sin/Ω, ΩV cos, ΩU sin.
    pub(crate) pairs: SmallVec<[[f64; 6]; 1]>,
    /// The smallest |sin(a_k±a_l)|.
    pub(crate) nearest: f64,
}

/// The same at four poles.
#[derive(Debug, Clone)]
pub(crate) struct FourSums {
    pub(crate) own: [f64x4; 3],
    pub(crate) pairs: SmallVec<[[f64x4; 6]; 1]>,
    pub(crate) nearest: f64x4,
    /// How many poles are where each of these is, itself among them.
    met: f64x4,
}

impl FourSums {
    /// Those at one of the poles, that of mode `k`.
    pub(crate) fn one(&self, k: usize) -> Result<PoleSums, SecularError> {
        let lane = k % LANES;
        let of = |four: f64x4| four.to_array()[lane];
        let nearest = of(self.nearest);
        if of(self.met) != 1.0 || nearest == 0.0 {
            return Err(SecularError::Coincident { mode: k });
        }
        let pairs = self.pairs.iter().map(|pair| pair.map(of)).collect();
        Ok(PoleSums { own: self.own.map(of), pairs, nearest })
    }
}

/// Pairs i > j of impacts and their numbers.
pub(crate) fn pairs(n: usize) -> impl Iterator<Item = (usize, usize, usize)> {
    (1..n).flat_map(|i| (0..i).map(move |j| (i, j, i * (i - 1) / 2 + j)))
}

impl PoleSums {
    /// Adds them to K̂ of `n` impacts, whose rows are `width` long.
    pub(crate) fn add_to(&self, matrix: &mut [C], n: usize, width: usize) {
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
    pub(crate) fn set(&mut self, modes: &Modes, omega: f64, times: &[f64]) {
        let modes = modes.list();
        self.count = modes.len();
        fill(&mut self.half_weight, modes.iter().map(|mode| 0.5 * mode.weight), 0.0);
        fill(&mut self.cos, modes.iter().map(|mode| mode.cos), 0.0);
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
    pub(crate) fn turns(&self, pair: usize) -> (&[f64], &[f64]) {
        let groups = self.cos.len();
        let range = pair * groups..(pair + 1) * groups;
        (self.turn_cos[range.clone()].as_flattened(), self.turn_sin[range].as_flattened())
    }

    /// The same of four modes, of the one pair of two impacts.
    pub(crate) fn turn(&self, group: usize) -> Option<[f64x4; 2]> {
        (self.turn_cos.len() == self.cos.len()).then(|| [four(self.turn_cos[group]), four(self.turn_sin[group])])
    }

    /// What K̂ has at all poles alike: propagators ±½R₀(t_i−t_j) over the times between impacts, losses, saltations κ'.
    pub(crate) fn shared(&self, q: f64, kappas: &[f64], (modes, omega): (&Modes, f64), shared: &mut Vec<f64>) {
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

    /// The sums at the poles of four modes, over pairs of `impacts`.
    #[inline]
    pub(crate) fn sums(&self, poles: &Mode<f64x4>, impacts: usize) -> FourSums {
        let (ck, sk) = (poles.cos, poles.sin);
        let groups = self.cos.len();
        let mut own = [ZERO; 3];
        let mut scratch: SmallVec<[[f64x4; 6]; 1]> = smallvec![[ZERO; 6]; impacts * (impacts - 1) / 2];
        let (mut met, mut nearest) = (ZERO, ONE);
        let of = |list: &[Lane], l: usize| all(list.as_flattened()[l]);
        for l in 0..self.count {
            let (c, s) = (of(&self.cos, l), of(&self.sin, l));
            let (a, b) = (sk * c, ck * s);
            let (minus, plus) = (a - b, a + b);
            let same = minus.simd_eq(ZERO);
            met += same.select(ONE, ZERO);
            nearest = nearest.fast_min(same.select(ONE, minus.abs())).fast_min(plus.abs());
            let (cc, ss) = (ck * c, sk * s);
            let cot_minus = same.select(ZERO, (cc + ss) / same.select(ONE, minus));
            let cot_plus = (cc - ss) / plus;
            let w = of(&self.half_weight, l);
            let (u, v) = (w * (cot_minus + cot_plus), w * (cot_minus - cot_plus));
            let (up, down) = (of(&self.inverse, l), of(&self.ratio, l));
            own[0] += u;
            own[1] += v * up;
            own[2] += v * down;
            for (pair, sums) in scratch.iter_mut().enumerate() {
                let (c, s) = (of(&self.turn_cos[pair * groups..], l), of(&self.turn_sin[pair * groups..], l));
                let (uc, us, vc, vs) = (u * c, u * s, v * c, v * s);
                for (sum, term) in sums.iter_mut().zip([uc, vs, vc * up, us * up, vc * down, us * down]) {
                    *sum += term;
                }
            }
        }
        scratch.iter_mut().flatten().chain(&mut own).for_each(|sum| *sum *= HALF);
        FourSums { own, pairs: scratch, nearest, met }
    }
}

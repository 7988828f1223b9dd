//! The periodic impulse response K_n(t): displacement of site n when site 0 receives a unit impulse at every
//! t = 0, ±T, ±2T, ….
//!
//! ```text
//! K_n(t) = Σ_k b_k² cos(2πkn/M) · cos(Ω_k(t−T/2)) / (2Ω_k sin(Ω_kT/2)),      0 ≤ t ≤ T          (docs/guide/model.md)
//! ```
//!
//! exact, at the cost of one sine a mode, where the paper sums a Fourier series that converges like 1/J.
//!
//! Each mode's term is split as static + dynamic,
//!
//! ```text
//! 1/(Ω_k²T)   +   [ cos x/(2Ω_k sin y) − 1/(Ω_k²T) ],      y = Ω_kT/2,  x = Ω_k(t−T/2),
//! ```
//!
//! the answer to the mean force and to the rest. For soft modes or short periods (y → 0) the static part grows
//! like 1/y² while breathers hang on the dynamic part, which stays finite even for a rigid mode (Ω = 0); added
//! together they would lose 2·log₁₀(1/y) digits. Callers that know the net impulse use the parts; `value` adds them.

use std::f64::consts::PI;

use rustfft::num_complex::Complex;
use wide::f64x4;

use crate::error::RESONANCE_TOLERANCE;
use crate::error::Resonance;
use crate::model::chain::Chain;
use crate::modes::shapes::Shapes;
use crate::modes::spectrum::Spectrum;
use crate::simd::sines::{MOST, sin_cos, soft, soft_defect};
use crate::simd::small::{BLOCK, cubic_defect, long_sum, products_in_order, sinc};

/// Modes in a group.
const LANES: usize = 4;

/// Modes up to here are added up plainly, four at a time.
const FEW: usize = 64;

/// The impulse response at one time, and its first three derivatives in t.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct KernelJet {
    /// The dynamic part of K₀(t).
    pub value: f64,
    /// dK₀/dt.
    pub slope: f64,
    /// d²K₀/dt², without the impulse itself.
    pub curvature: f64,
    /// d³K₀/dt³.
    pub third: f64,
}

/// Closed form of the periodic impulse response for one spectrum and one period.
///
/// ```
/// use vibrochain_lattice::{Chain, ImpulseResponse, Spectrum};
/// // One mass on a spring: K(t) = cos(Ω(t−T/2)) / (2Ω sin(ΩT/2)).
/// let response = ImpulseResponse::new(&Spectrum::new(Chain::new(1, 1.0, 0.0)?), 3.0)?;
/// let t = 0.7_f64;
/// let half = std::f64::consts::PI / 3.0;
/// assert!((response.value(0, t) - (t - half).cos() / (2.0 * half.sin())).abs() < 1e-15);
/// # Ok::<(), vibrochain_lattice::LatticeError>(())
/// ```
#[derive(Debug, Clone)]
pub struct ImpulseResponse {
    chain: Chain,
    /// The site that answers where none is named, and of its modes φ_k² over the weight; 1 on a ring, and not listed.
    home: usize,
    squares: Vec<f64>,
    /// The products of the two, b_k² of home; not listed on a ring.
    own: Vec<f64>,
    omega: f64,
    period: f64,
    shapes: Shapes,
    /// How many there are; the lists below are filled up to whole groups of four.
    modes: usize,
    frequencies: Vec<f64>,
    weights: Vec<f64>,
    /// y, sin y and cos y, the last two with the nearest multiple of π taken out of y exactly.
    half_phase: Vec<f64>,
    sin_half: Vec<f64>,
    cos_half: Vec<f64>,
    /// 1/(Ω²T), 0 for a rigid mode.
    statics: Vec<f64>,
    /// Dynamic response of the modes at the impulse and half a period after it, and the sums that orbits start from.
    at_impulse: Vec<f64>,
    at_half: Vec<f64>,
    dynamic_at_impulse: f64,
    dynamic_at_half: f64,
    static_stiffness: f64,
    /// What every time needs of a mode: b²/sinc y and (y − sin y)/y³ for y < 1, b²/(2 sin y) and sin y/y otherwise.
    scales: Vec<f64>,
    offsets: Vec<f64>,
    condition: f64,
    /// The highest frequency.
    top: f64,
}

impl ImpulseResponse {
    /// The response of `spectrum` to impulses repeated with frequency `omega`.
    ///
    /// # Errors
    /// [`Resonance`] when a harmonic of `omega` meets a mode to within rounding
    /// ([`RESONANCE_TOLERANCE`], relative).
    pub fn new(spectrum: &Spectrum, omega: f64) -> Result<Self, Resonance> {
        let mut response = Self::vacant(spectrum.chain());
        response.reset(spectrum, omega)?;
        Ok(response)
    }

    /// Room for the masses of a chain, to be filled by [`ImpulseResponse::reset`].
    pub fn vacant(chain: &Chain) -> Self {
        Self {
            chain: *chain,
            home: 0,
            squares: Vec::new(),
            own: Vec::new(),
            omega: 1.0,
            period: std::f64::consts::TAU,
            shapes: Shapes::new(chain),
            modes: 0,
            frequencies: Vec::new(),
            weights: Vec::new(),
            half_phase: Vec::new(),
            sin_half: Vec::new(),
            cos_half: Vec::new(),
            statics: Vec::new(),
            at_impulse: Vec::new(),
            at_half: Vec::new(),
            dynamic_at_impulse: 0.0,
            dynamic_at_half: 0.0,
            static_stiffness: 0.0,
            scales: Vec::new(),
            offsets: Vec::new(),
            condition: 1.0,
            top: 0.0,
        }
    }

    /// Takes over another spectrum or frequency; allocates only if there are other masses or other ends.
    ///
    /// # Errors
    /// As [`ImpulseResponse::new`]; the response must then be reset before it is used.
    pub fn reset(&mut self, spectrum: &Spectrum, omega: f64) -> Result<(), Resonance> {
        self.reset_at(spectrum, omega, 0)
    }

    /// The same, with another site in place of site 0: what no site is named for is the answer of `home` to its own impulses.
    ///
    /// # Errors
    /// As [`ImpulseResponse::reset`].
    pub fn reset_at(&mut self, spectrum: &Spectrum, omega: f64, home: usize) -> Result<(), Resonance> {
        let chain = spectrum.chain();
        if chain.lines() != self.chain.lines() {
            *self = Self::vacant(chain);
        }
        self.omega = omega;
        self.period = std::f64::consts::TAU / omega;
        let modes = spectrum.frequencies().len();
        if self.modes == 0 || (self.chain, self.home) != (*chain, home) {
            (self.chain, self.home, self.modes) = (*chain, home, modes);
            self.reset_lattice(spectrum);
        }
        // What fills up the last group of four swings a quarter as fast as the impulses come, and weighs nothing.
        self.frequencies[modes..].fill(0.25 * omega);
        self.reset_modes()?;
        let own = self.own_weights();
        // Of rigid modes nothing is held up.
        let lists = [&self.at_impulse, &self.at_half, &self.statics];
        let [at_impulse, at_half, still] = match modes <= BLOCK {
            true => products_in_order(own, lists),
            false => long_sum(modes, |k| lists.map(|list| own[k] * list[k])),
        };
        (self.dynamic_at_impulse, self.dynamic_at_half) = (at_impulse, at_half);
        self.static_stiffness = if chain.is_adrift() { 0.0 } else { 1.0 / still };
        Ok(())
    }

    /// What does not depend on the frequency of the impulses, in whole groups of four.
    fn reset_lattice(&mut self, spectrum: &Spectrum) {
        self.squares.clear();
        if !self.chain.is_ring() {
            self.squares.extend(self.shapes.evens(self.home, self.home));
        }
        let groups = self.modes.next_multiple_of(LANES);
        let filled = [(&mut self.frequencies, spectrum.frequencies()), (&mut self.weights, spectrum.weights())];
        for (list, values) in filled {
            list.clear();
            list.reserve_exact(groups);
            list.extend_from_slice(values);
            list.resize(groups, 0.0);
        }
        // On a ring all modes are 1 at the site that they are even about.
        self.own.clear();
        self.own.extend(self.weights.iter().zip(&self.squares).map(|(weight, square)| weight * square));
        if !self.own.is_empty() {
            self.own.resize(groups, 0.0);
        }
    }

    /// Gives back the room of all modes; the response must be reset before it is used.
    pub fn give_back(&mut self) {
        let Self { squares, own, frequencies, weights, half_phase, sin_half, cos_half, .. } = self;
        let Self { statics, at_impulse, at_half, scales, offsets, .. } = self;
        let about_home = [squares, own, frequencies, weights, half_phase, sin_half, cos_half];
        about_home
            .into_iter()
            .chain([statics, at_impulse, at_half, scales, offsets])
            .for_each(|list| *list = Vec::new());
        self.modes = 0;
    }

    /// What depends on each mode's frequency and weight, four modes at a time.
    fn reset_modes(&mut self) -> Result<(), Resonance> {
        let (omega, period) = (self.omega, self.period);
        let lists = [
            &mut self.half_phase,
            &mut self.sin_half,
            &mut self.cos_half,
            &mut self.statics,
            &mut self.at_impulse,
            &mut self.at_half,
            &mut self.scales,
            &mut self.offsets,
        ];
        let mut lists = lists.map(|list| {
            if list.len() != self.frequencies.len() {
                list.resize(self.frequencies.len(), 0.0);
            }
            list.as_chunks_mut::<LANES>().0.iter_mut()
        });
        let [zero, one, half, all_period] = [0.0, 1.0, 0.5, period].map(f64x4::splat);
        // How many times larger than the rounding of Ω_k/ω its effect on sin y can be, for the worst mode.
        // Of each lane the phase and its distance from a harmonic whose quotient that is: one division for all.
        let (mut meets, mut top, mut worst) = (false, zero, [one; 2]);
        for (frequency, weight) in self.frequencies.as_chunks().0.iter().zip(self.weights.as_chunks().0) {
            let (frequency, weight) = (f64x4::from(*frequency), f64x4::from(*weight));
            top = top.fast_max(frequency);
            let turns = frequency / f64x4::splat(omega);
            let harmonic = (turns + half).floor();
            let detuning = turns - harmonic;
            let near = harmonic.simd_ge(one) & detuning.abs().simd_le(turns * f64x4::splat(RESONANCE_TOLERANCE));
            meets |= near.any();
            let distance = detuning.abs();
            let worse = harmonic.simd_ge(one) & (turns * worst[1]).simd_gt(worst[0] * distance);
            worst = [worse.select(turns, worst[0]), worse.select(distance, worst[1])];
            let [sin, cos] = sin_cos(detuning * f64x4::splat(PI));
            let even = (half * harmonic).floor() * f64x4::splat(2.0);
            let odd = even.simd_ne(harmonic);
            let (sin, cos) = (odd.select(-sin, sin), odd.select(-cos, cos));
            let y = turns * f64x4::splat(PI);
            let square = frequency * frequency * all_period;
            let statics = square.simd_gt(zero).select(one / square, zero);
            let is_soft = y.simd_lt(one);
            // As [`ImpulseResponse::mode_dynamic`] at any other time, from the sine and cosine at hand.
            let over_y = one / y;
            let mut parts = [zero; 4];
            if !is_soft.all() {
                let over_sin = one / sin;
                // 1/(2Ω)
                let size = f64x4::splat(0.25 * period) * over_y;
                parts = [
                    size * (cos * over_sin - over_y),
                    size * (over_sin - over_y),
                    half * weight * over_sin,
                    sin * over_y,
                ];
            }
            if is_soft.any() {
                let y = is_soft.select(y, zero);
                let [sinc, defect] = soft_defect(y);
                let over_sinc = one / sinc;
                let quarter = f64x4::splat(0.25 * period) * over_sinc;
                // 2ξ² sinc²(y/2) with ξ = ½ is sinc²y/(1 + cos y).
                let soft =
                    [quarter * (defect - sinc * sinc / (one + cos)), quarter * defect, weight * over_sinc, defect];
                for (part, soft) in parts.iter_mut().zip(soft) {
                    *part = is_soft.select(soft, *part);
                }
            }
            let [at_impulse, at_half, scale, offset] = parts;
            for (list, value) in lists.iter_mut().zip([y, sin, cos, statics, at_impulse, at_half, scale, offset]) {
                if let Some(slot) = list.next() {
                    *slot = value.to_array();
                }
            }
        }
        self.condition = (worst[0] / worst[1]).to_array().into_iter().fold(1.0, f64::max);
        self.top = top.to_array().into_iter().fold(0.0, f64::max);
        if meets { Err(self.resonance()) } else { Ok(()) }
    }

    /// The first mode that meets a harmonic.
    #[cold]
    fn resonance(&self) -> Resonance {
        let omega = self.omega;
        let far = |k: &usize| {
            let turns = self.frequencies[*k] / omega;
            let harmonic = turns.round();
            !(harmonic >= 1.0 && (turns - harmonic).abs() <= RESONANCE_TOLERANCE * turns)
        };
        let mode = (0..self.modes).take_while(far).count().min(self.modes.saturating_sub(1));
        let frequency = self.frequencies[mode];
        let harmonic = (frequency / omega).round();
        let distance = (-harmonic).mul_add(omega, frequency);
        Resonance { harmonic: harmonic as u64, mode, frequency, omega, distance }
    }

    /// b_k² of home.
    fn own_weights(&self) -> &[f64] {
        if self.own.is_empty() { &self.weights } else { &self.own }
    }

    /// The lattice.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// Number of masses.
    pub fn sites(&self) -> usize {
        self.chain.sites()
    }

    /// Number of modes even about site 0.
    pub fn modes(&self) -> usize {
        self.modes
    }

    /// Base frequency of the impulses.
    pub fn omega(&self) -> f64 {
        self.omega
    }

    /// Period T of the impulses.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Ω_k of the even modes.
    pub fn frequencies(&self) -> &[f64] {
        &self.frequencies[..self.modes]
    }

    /// Weights of the modes ([`Spectrum::weights`]): on a ring b_k².
    pub fn weights(&self) -> &[f64] {
        &self.weights[..self.modes]
    }

    /// sin(Ω_kT/2) of the even modes.
    pub fn sin_half(&self) -> &[f64] {
        &self.sin_half[..self.modes]
    }

    /// cos(Ω_kT/2) of the even modes.
    pub fn cos_half(&self) -> &[f64] {
        &self.cos_half[..self.modes]
    }

    /// Shapes of the modes.
    pub fn shapes(&self) -> &Shapes {
        &self.shapes
    }

    /// max_k Ω_k/|Ω_k − jω| over harmonics j ≥ 1: a relative error δ in a frequency moves the response by about
    /// this times δ. 1 where no harmonic comes near a mode.
    pub fn condition(&self) -> f64 {
        self.condition
    }

    /// 1/(γ₁MT): the uniform displacement that one unit of net impulse a period holds up; between walls, where no mode is
    /// uniform, 1/(Ω₀²MT). `None` where nothing holds the lattice as a whole and a
    /// periodic motion needs a net impulse of zero ([`Chain::is_adrift`]).
    pub fn uniform_static(&self) -> Option<f64> {
        if self.chain.is_adrift() {
            None
        } else if self.chain.has_walls() {
            // Any measure of what a net impulse holds up will do, if it is the same for all sites.
            let lowest = self.frequencies.first().copied().unwrap_or(1.0);
            Some(1.0 / (lowest * lowest * self.sites() as f64 * self.period))
        } else {
            Some(1.0 / (self.chain.gamma1() * self.sites() as f64 * self.period))
        }
    }

    /// Static response of mode `k`, 1/(Ω_k²T), without its weight; 0 for a rigid mode.
    pub fn mode_static(&self, k: usize) -> f64 {
        self.statics[k]
    }

    /// Static responses of all modes, see [`ImpulseResponse::mode_static`].
    pub fn statics(&self) -> &[f64] {
        &self.statics[..self.modes]
    }

    /// 1/S₀ with S₀ = Σ b_k²/(Ω_k²T), the static stiffness at home times T; 0 where nothing holds the lattice.
    pub fn static_stiffness(&self) -> f64 {
        self.static_stiffness
    }

    /// Share of [`ImpulseResponse::uniform_static`] in the static response at home: (1/γ₁MT)/S₀, 1 where nothing holds the lattice.
    #[inline]
    pub fn uniform_share(&self) -> f64 {
        self.uniform_static().map_or(1.0, |uniform| uniform * self.static_stiffness())
    }

    /// What states at an impact and half a period after it are made of, four modes at a time: weights, static responses, dynamic ones at
    /// the impulse and half a period after it. What fills up the last group weighs nothing.
    #[doc(hidden)]
    pub fn in_fours(&self) -> impl Iterator<Item = [[f64; LANES]; 4]> + '_ {
        fours([&self.weights, &self.statics, &self.at_impulse, &self.at_half])
    }

    /// Four modes at a time in the same way: frequencies, weights, cosines and sines of ΩT/2.
    #[doc(hidden)]
    pub fn swings_in_fours(&self) -> impl Iterator<Item = [[f64; LANES]; 4]> + '_ {
        fours([&self.frequencies, &self.weights, &self.cos_half, &self.sin_half])
    }

    /// Dynamic responses of all modes, without their weights, at the impulse.
    pub fn at_impulse(&self) -> &[f64] {
        &self.at_impulse[..self.modes]
    }

    /// Dynamic responses of all modes, without their weights, half a period after the impulse.
    pub fn at_half(&self) -> &[f64] {
        &self.at_half[..self.modes]
    }

    /// Dynamic response of mode `k`, without its weight, at 0 ≤ `t` ≤ T.
    pub fn mode_dynamic(&self, k: usize, t: f64) -> f64 {
        // At the impulse and half-way it is known, and known better.
        if t == 0.0 || t == self.period {
            return self.at_impulse[k];
        }
        if t == 0.5 * self.period {
            return self.at_half[k];
        }
        let (frequency, y) = (self.frequencies[k], self.half_phase[k]);
        let offset = t - 0.5 * self.period;
        if y < 1.0 {
            // T [(y − sin y)/y³ − 2ξ² sinc²(x/2)] / (4 sinc y): the 1/y² of the static part is gone term by term.
            let xi = offset / self.period;
            let s = xi * sinc(0.5 * frequency * offset);
            self.period * (cubic_defect(y) - 2.0 * s * s) / (4.0 * sinc(y))
        } else {
            ((frequency * offset).cos() / self.sin_half[k] - 1.0 / y) / (2.0 * frequency)
        }
    }

    /// Velocity response of mode `k`, without its weight, at 0 < `t` < T; at the impulse itself the mean of both
    /// sides, 0.
    pub fn mode_slope(&self, k: usize, t: f64) -> f64 {
        if t <= 0.0 || t >= self.period {
            return 0.0;
        }
        let (frequency, y) = (self.frequencies[k], self.half_phase[k]);
        let offset = t - 0.5 * self.period;
        if offset == 0.0 {
            0.0
        } else if y < 1.0 {
            -offset / self.period * sinc(frequency * offset) / sinc(y)
        } else {
            -(frequency * offset).sin() / (2.0 * self.sin_half[k])
        }
    }

    /// Dynamic part of K₀ at the impulse, t = 0: Σ b_k² [cot y/(2Ω) − 1/(Ω²T)].
    pub fn dynamic_at_impulse(&self) -> f64 {
        self.dynamic_at_impulse
    }

    /// Dynamic part of K₀ half a period after the impulse: Σ b_k² [1/(2Ω sin y) − 1/(Ω²T)].
    pub fn dynamic_at_half(&self) -> f64 {
        self.dynamic_at_half
    }

    /// Bounds over the open period on |K₀′|, |K₀″|, |K₀‴| and |K₀⁗|, from the modes' amplitudes.
    pub fn derivative_bounds(&self) -> [f64; 4] {
        self.derivative_bounds_of(&self.squares)
    }

    /// The same of the kernel whose modes have these shapes, see [`ImpulseResponse::jet_of`].
    pub fn derivative_bounds_of(&self, shapes: &[f64]) -> [f64; 4] {
        let mut bounds = [0.0; 4];
        for k in 0..self.modes() {
            let own = self.weights[k] * shapes.get(k).map_or(1.0, |shape| shape.abs());
            let (frequency, y) = (self.frequencies[k], self.half_phase[k]);
            let sine = if y < 1.0 { y * sinc(y) } else { self.sin_half[k].abs() };
            // K′ of a mode is sin x/(2 sin y) with |x| ≤ y: a soft mode does not reach the crest of its sine.
            let soft = if y < 1.0 { 0.5 } else { 0.5 / sine };
            let curvature = if y < 1.0 { 1.0 / (self.period * sinc(y)) } else { 0.5 * frequency / sine };
            let square = frequency * frequency;
            for (bound, term) in bounds.iter_mut().zip([soft, curvature, soft * square, curvature * square]) {
                *bound += own * term;
            }
        }
        bounds
    }

    /// Dynamic part of K₀, K₀′, K₀″ and K₀‴ at the time T/2 + `offset`, −T/2 < `offset` < T/2. Measured from the middle
    /// of the period because K₀′ vanishes there: it keeps its relative accuracy.
    pub fn jet_from_half(&self, offset: f64) -> KernelJet {
        self.jet_of(&self.squares, offset)
    }

    /// The same of any sum of kernels between sites, given by what each mode has of it beside its weight: Σ φ_k(i)φ_k(j) as
    /// [`Shapes::evens`] tells it. With no shapes at all each mode has 1.
    pub fn jet_of(&self, shapes: &[f64], offset: f64) -> KernelJet {
        let by_fours = self.modes <= FEW && self.top * offset.abs() <= MOST;
        if by_fours { self.jet_by_fours(shapes, offset) } else { self.jet_one_by_one(shapes, offset) }
    }

    /// The same, mode by mode: of long lattices, whose sums are kept compensated.
    fn jet_one_by_one(&self, shapes: &[f64], offset: f64) -> KernelJet {
        let jet = |k: usize, scale: f64| self.mode_jet(k, offset, scale, self.half_phase[k] < 1.0);
        let [value, slope, curvature, third] = if shapes.is_empty() {
            long_sum(self.modes(), |k| jet(k, self.scales[k]))
        } else {
            long_sum(self.modes(), |k| jet(k, self.scales[k] * shapes[k]))
        };
        KernelJet { value, slope, curvature, third }
    }

    /// The same, four modes at a time.
    fn jet_by_fours(&self, shapes: &[f64], offset: f64) -> KernelJet {
        let zero = f64x4::ZERO;
        let fours =
            |list: &'_ [f64], i: usize| list.as_chunks::<LANES>().0.get(i).map_or(zero, |four| f64x4::from(*four));
        let mut sums = [zero; 4];
        for i in 0..self.frequencies.len() / LANES {
            let scale = fours(&self.scales, i);
            let scale = if shapes.is_empty() { scale } else { scale * group_of(shapes, i) };
            let mode = [fours(&self.frequencies, i), scale, fours(&self.offsets, i), fours(&self.half_phase, i)];
            let terms = self.terms(mode, f64x4::splat(offset));
            (0..4).for_each(|i| sums[i] += terms[i]);
        }
        let [a, b, c, d] = f64x4::transpose(sums);
        let [value, slope, curvature, third] = ((a + c) + (b + d)).to_array();
        KernelJet { value, slope, curvature, third }
    }

    /// As [`ImpulseResponse::jet_from_half`] at four times at once: four values, slopes, curvatures and third derivatives.
    pub fn jets_from_half(&self, offsets: [f64; 4]) -> [[f64; 4]; 4] {
        self.jets_of(&self.squares, offsets)
    }

    /// As [`ImpulseResponse::jet_of`] at four times at once.
    pub fn jets_of(&self, shapes: &[f64], offsets: [f64; 4]) -> [[f64; 4]; 4] {
        let farthest = offsets.iter().fold(0.0, |most: f64, offset| most.max(offset.abs()));
        if self.modes > FEW || self.top * farthest > MOST {
            let jets = offsets.map(|offset| self.jet_of(shapes, offset));
            let of = |part: fn(&KernelJet) -> f64| std::array::from_fn(|i| part(&jets[i]));
            return [of(|jet| jet.value), of(|jet| jet.slope), of(|jet| jet.curvature), of(|jet| jet.third)];
        }
        let mut sums = [f64x4::ZERO; 4];
        for k in 0..self.modes {
            let scale = self.scales[k] * shapes.get(k).copied().unwrap_or(1.0);
            let mode = [self.frequencies[k], scale, self.offsets[k], self.half_phase[k]].map(f64x4::splat);
            let terms = self.terms(mode, f64x4::from(offsets));
            (0..4).for_each(|i| sums[i] += terms[i]);
        }
        sums.map(f64x4::to_array)
    }

    /// Four terms of the dynamic part and its derivatives, of modes with these frequencies, scales, offsets and half phases.
    #[inline(always)]
    fn terms(&self, [frequency, scale, defect, y]: [f64x4; 4], time: f64x4) -> [f64x4; 4] {
        let (zero, one) = (f64x4::ZERO, f64x4::ONE);
        let (x, is_soft) = (frequency * time, y.simd_lt(one));
        let mut terms = [zero; 4];
        if !is_soft.all() {
            let [sin, cos] = sin_cos(x);
            let (swing, bend) = (scale * sin, scale * frequency);
            terms = [scale * (cos - defect) / frequency, -swing, -bend * cos, bend * frequency * sin];
        }
        if is_soft.any() {
            let x = is_soft.select(x, zero);
            // 2s² of the modes one by one is 4ξ² (1 − cos x)/x².
            let [sinc, rest] = soft(x);
            let turns = time / f64x4::splat(self.period);
            let slope = scale * turns * sinc;
            let value = scale * f64x4::splat(0.25 * self.period) * (defect - f64x4::splat(4.0) * turns * turns * rest);
            let curvature = scale * (one - x * x * rest) * f64x4::splat(-1.0 / self.period);
            let soft = [value, -slope, curvature, frequency * frequency * slope];
            for (term, soft) in terms.iter_mut().zip(soft) {
                *term = is_soft.select(soft, *term);
            }
        }
        terms
    }

    /// As [`ImpulseResponse::jet_from_half`], of site `to` where site `from` receives the impulses. What the mean force holds
    /// up less at `to` than at home under impulses there, on a ring Σ b_k² [1 − cos(2πk(to−from)/M)]/(Ω_k²T), is taken from the
    /// value: then for any sites, and adrift, displacement = (net impulse)·S₀ + Σ impulse·value.
    pub fn jet_between(&self, to: usize, from: usize, offset: f64) -> KernelJet {
        if self.is_home(to, from) {
            return self.jet_from_half(offset);
        }
        let [value, slope, curvature, third] = long_sum(self.modes(), |k| {
            let scale = self.scales[k] * self.shapes.even(k, to, from);
            let mut jet = self.mode_jet(k, offset, scale, self.half_phase[k] < 1.0);
            jet[0] -= self.static_drop(k, to, from);
            jet
        });
        KernelJet { value, slope, curvature, third }
    }

    /// As [`ImpulseResponse::jet_between`], its value alone at the impulse itself and half a period after it.
    pub fn dynamics_between(&self, to: usize, from: usize) -> [f64; 2] {
        if self.is_home(to, from) {
            return [self.dynamic_at_impulse, self.dynamic_at_half];
        }
        let mut modes = (self.shapes.evens(to, from))
            .zip(self.shapes.drops(to, from, self.home))
            .zip(self.weights.iter().zip(&self.statics))
            .zip(self.at_impulse.iter().zip(&self.at_half));
        long_sum(self.modes(), |_| {
            let Some((((shape, drop), (weight, still)), (first, second))) = modes.next() else { return [0.0; 2] };
            let lost = weight * still * drop;
            [weight * first * shape - lost, weight * second * shape - lost]
        })
    }

    /// What home hears of its own impulses; on a ring every site does.
    pub(crate) fn is_home(&self, to: usize, from: usize) -> bool {
        to == from && (to == self.home || self.squares.is_empty())
    }

    /// What mode `k` lacks, between two sites, of its static response between home and itself; weight included.
    pub(crate) fn static_drop(&self, k: usize, to: usize, from: usize) -> f64 {
        self.weights[k] * self.mode_static(k) * self.shapes.drop(k, to, from, self.home)
    }

    /// The term of mode `k` in the dynamic part and its derivatives, `scale` in place of its own; `soft` for y < 1.
    #[inline(always)]
    fn mode_jet(&self, k: usize, offset: f64, scale: f64, soft: bool) -> [f64; 4] {
        let (frequency, defect) = (self.frequencies[k], self.offsets[k]);
        if soft {
            let xi = offset / self.period;
            let x = frequency * offset;
            let (s, c) = (xi * sinc(0.5 * x), x.cos());
            let slope = scale * xi * sinc(x);
            let value = scale * self.period * (defect - 2.0 * s * s) * 0.25;
            [value, -slope, -scale * c / self.period, frequency * frequency * slope]
        } else {
            let (sin, cos) = (frequency * offset).sin_cos();
            let value = scale * (cos - defect) / frequency;
            [value, -scale * sin, -scale * frequency * cos, scale * frequency * frequency * sin]
        }
    }

    /// Σ weight·shape/(Ω_k² − w²) for each list of shapes ([`Shapes::evens`] of site n about site i) and w of `frequencies`: how far a
    /// force cos wt at site i makes site n swing. Infinite where w meets a mode.
    pub fn driven<const N: usize, const J: usize>(
        &self,
        mut shapes: [impl Iterator<Item = f64>; N],
        frequencies: [f64; J],
    ) -> [[f64; J]; N] {
        let mut sums = [[0.0; J]; N];
        for (mode, weight) in self.frequencies().iter().zip(self.weights()) {
            let terms = frequencies.map(|w| weight / ((mode - w) * (mode + w)));
            for (sum, shape) in sums.iter_mut().zip(&mut shapes) {
                let shape = shape.next().unwrap_or_default();
                sum.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term * shape);
            }
        }
        sums
    }

    /// K_n(t) for 0 ≤ `t` ≤ T (other times are folded into the period).
    ///
    /// For γ₁ = 0 the uniform mode's static part is infinite and left out: K_n is then defined up to a constant
    /// common to all sites, which cancels wherever the net impulse is zero.
    pub fn value(&self, site: usize, t: f64) -> f64 {
        let t = self.fold(t);
        let shape = |k| self.weights[k] * self.shapes.even(k, site, 0);
        long_sum(self.modes(), |k| [shape(k) * (self.mode_static(k) + self.mode_dynamic(k, t))])[0]
    }

    /// dK_n/dt; at the impulse itself (t = 0) the mean of both sides, 0.
    pub fn derivative(&self, site: usize, t: f64) -> f64 {
        let t = self.fold(t);
        long_sum(self.modes(), |k| [self.weights[k] * self.shapes.even(k, site, 0) * self.mode_slope(k, t)])[0]
    }

    /// K_n(t) at all sites n, of a ring at n = 0 … ⌊M/2⌋ (it is symmetric about site 0), written to `out`; one sine a mode
    /// for all of them, O(M log M) for a large ring. Entries of `out` beyond are left alone.
    pub fn profile(&self, t: f64, out: &mut [f64]) {
        let t = self.fold(t);
        let amplitude = |k: usize| Complex::new(self.weights[k] * (self.mode_static(k) + self.mode_dynamic(k, t)), 0.0);
        let amplitudes: Vec<_> = (0..self.modes()).map(amplitude).collect();
        let mut all = vec![Complex::default(); self.sites()];
        self.shapes.clone().add_all(0, amplitudes.into_iter(), &mut all);
        let distinct = if self.chain.is_ring() { self.modes() } else { self.sites() };
        out.iter_mut().take(distinct).zip(all).for_each(|(out, value)| *out = value.re);
    }

    pub(crate) fn fold(&self, t: f64) -> f64 {
        if (0.0..=self.period).contains(&t) { t } else { t.rem_euclid(self.period) }
    }
}

/// What four modes have of a kernel; 0 where the last group is not full.
fn group_of(shapes: &[f64], group: usize) -> f64x4 {
    let mut four = [0.0; LANES];
    four.iter_mut().zip(shapes.iter().skip(group * LANES)).for_each(|(slot, shape)| *slot = *shape);
    f64x4::from(four)
}

/// Groups of four lists side by side.
fn fours(lists: [&Vec<f64>; 4]) -> impl Iterator<Item = [[f64; LANES]; 4]> + '_ {
    let [a, b, c, d] = lists.map(|list| list.as_chunks().0.iter());
    a.zip(b).zip(c.zip(d)).map(|((a, b), (c, d))| [*a, *b, *c, *d])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn response(sites: usize, g1: f64, g2: f64, omega: f64) -> ImpulseResponse {
        ImpulseResponse::new(&Spectrum::new(Chain::new(sites, g1, g2).unwrap()), omega).unwrap()
    }

    /// Fourier series of the same, the way the paper sums it (with its static term), for J harmonics.
    fn series(r: &ImpulseResponse, n: usize, t: f64, terms: u32) -> f64 {
        let per_mode = |k: usize| {
            let square = r.frequencies[k].powi(2);
            let sum: f64 = (1..=terms)
                .map(|j| {
                    let w = f64::from(j) * r.omega;
                    2.0 * (w * t).cos() / (square - w * w)
                })
                .sum();
            (1.0 / square + sum) / r.period
        };
        (0..r.modes()).map(|k| r.weights[k] * r.shapes.even(k, n, 0) * per_mode(k)).sum()
    }

    #[test]
    fn closed_form_is_the_limit_of_the_series() {
        for (sites, g1, g2, omega) in
            [(1, 0.2, 0.1, 1.5), (2, 0.2, 0.1, 0.31), (5, 0.2, 0.1, 0.9), (6, 0.01, 3.0, 0.4), (21, 1e-3, 1e-3, 2.0)]
        {
            let r = response(sites, g1, g2, omega);
            for n in [0, 1, sites / 2] {
                for fraction in [0.07, 0.3, 0.5, 0.81] {
                    let t = fraction * r.period;
                    let expected = series(&r, n, t, 20_000);
                    assert!((r.value(n, t) - expected).abs() < 2e-8 * r.period, "{sites} {n} {fraction}");
                }
            }
        }
    }

    #[test]
    fn equation_of_motion_holds_between_impulses_and_the_velocity_jumps_by_one() {
        for sites in [1, 2, 3, 8, 21] {
            let (g1, g2, omega) = (0.2, 0.1, 0.83);
            let r = response(sites, g1, g2, omega);
            let (t, h) = (0.37 * r.period, 1e-3);
            for n in 0..sites {
                let k = |n: usize, t: f64| r.value(n % sites, t);
                let second = (k(n, t + h) - 2.0 * k(n, t) + k(n, t - h)) / (h * h);
                let force = -g1 * k(n, t) - g2 * (2.0 * k(n, t) - k(n + 1, t) - k(n + sites - 1, t));
                assert!((second - force).abs() < 1e-6, "{sites} {n}");
                let slope = (k(n, t + h) - k(n, t - h)) / (2.0 * h);
                assert!((slope - r.derivative(n, t)).abs() < 1e-6);
                let jump = r.derivative(n, 1e-13) - r.derivative(n, r.period - 1e-13);
                assert!((jump - f64::from(u8::from(n == 0))).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn jet_and_shortcuts_agree_with_the_plain_sum() {
        for omega in [0.21, 1.5, 60.0] {
            let r = response(9, 0.2, 0.1, omega);
            let s: f64 = (0..r.modes()).map(|k| r.weights[k] * r.mode_static(k)).sum();
            assert!((r.static_stiffness() * s - 1.0).abs() < 1e-14);
            assert!((r.dynamic_at_impulse() + s - r.value(0, 0.0)).abs() < 1e-13 * s);
            assert!((r.dynamic_at_half() + s - r.value(0, 0.5 * r.period)).abs() < 1e-13 * s);
            for fraction in [-0.41, -0.1, 0.0, 0.3] {
                let (offset, h) = (fraction * r.period, 1e-4 * r.period);
                let jet = r.jet_from_half(offset);
                let t = 0.5 * r.period + offset;
                assert!((jet.value + s - r.value(0, t)).abs() < 1e-13 * s);
                assert!((jet.slope - r.derivative(0, t)).abs() < 1e-14);
                let curvature = (r.derivative(0, t + h) - r.derivative(0, t - h)) / (2.0 * h);
                assert!((jet.curvature - curvature).abs() < 1e-5 * omega, "{omega} {fraction}");
                let step = |o: f64| r.jet_from_half(offset + o).curvature;
                assert!((jet.third - (step(h) - step(-h)) / (2.0 * h)).abs() < 1e-5 * omega.max(1.0).powi(2));
                let bounds = r.derivative_bounds();
                for (value, bound) in [jet.slope, jet.curvature, jet.third].iter().zip(bounds) {
                    assert!(value.abs() <= bound * (1.0 + 1e-14), "{omega} {fraction}");
                }
            }
        }
    }

    #[test]
    fn modes_four_at_a_time_are_as_one_by_one() {
        let mut compared = 0;
        for (sites, g1) in [(1, 0.2), (2, 0.0), (5, 1e-4), (9, 0.2), (21, 0.0), (40, 3.0), (126, 0.2)] {
            for omega in [0.021, 0.21, 0.83, 1.5, 3.0, 60.0] {
                let r = response(sites, g1, 0.1, omega);
                for part in -40..=40 {
                    let offset = f64::from(part) / 80.0 * r.period;
                    // Modes or times by fours.
                    let jets = r.jets_from_half([0.0, offset, -offset, 0.3 * offset]);
                    let [value, slope, curvature, third] = jets.map(|jets| jets[1]);
                    let of_times = KernelJet { value, slope, curvature, third };
                    let (fours, ones) = (r.jet_by_fours(&r.squares, offset), r.jet_one_by_one(&r.squares, offset));
                    let own = r.own_weights();
                    let size = |power: i32| -> f64 {
                        let term = |k: usize| {
                            let sine = r.sin_half[k].abs().min(0.5 * r.frequencies[k] * r.period);
                            let scale = if sine > 0.0 { r.frequencies[k] / sine } else { 1.0 / r.period };
                            own[k] * scale * (1.0 + r.frequencies[k].powi(power))
                        };
                        (0..r.modes()).map(term).sum()
                    };
                    // Terms of K itself are larger by their static part.
                    let static_part =
                        r.period * r.at_half().iter().chain(r.at_impulse()).fold(1.0, |m: f64, x| m.max(x.abs()));
                    for fours in [fours, of_times] {
                        let pairs = [
                            (fours.value, ones.value, static_part * (1.0 + size(0))),
                            (fours.slope, ones.slope, (1.0 + r.period) * size(0)),
                            (fours.curvature, ones.curvature, size(0)),
                            (fours.third, ones.third, (1.0 + r.period) * size(2)),
                        ];
                        for (four, one, size) in pairs {
                            assert!(
                                (four - one).abs() <= 1e-15 * size,
                                "{sites} {omega} {offset}: {four} {one} {size}"
                            );
                            compared += 1;
                        }
                    }
                }
            }
        }
        assert_eq!(compared, 7 * 6 * 81 * 8);
    }

    #[test]
    fn jets_between_sites_are_the_kernel_but_for_what_the_net_impulse_holds_up() {
        for (sites, omega) in [(2, 0.6), (9, 1.5), (8, 0.21), (5, 40.0)] {
            let r = response(sites, 0.2, 0.1, omega);
            let still: f64 = (0..r.modes()).map(|k| r.weights[k] * r.mode_static(k)).sum();
            for (to, from) in [(1, 0), (0, sites - 1), (sites / 2, 0)] {
                for fraction in [-0.5, -0.3, 0.0, 0.21] {
                    let offset = fraction * r.period;
                    let (jet, t) = (r.jet_between(to, from, offset), 0.5 * r.period + offset);
                    let distance = to.abs_diff(from);
                    assert!((jet.value + still - r.value(distance, t)).abs() < 1e-13 * still, "{sites} {to} {from}");
                    assert!((jet.slope - r.derivative(distance, t)).abs() < 1e-14);
                    let h = 1e-4 * r.period;
                    let step = |o: f64| r.jet_between(to, from, offset + o);
                    assert!(
                        (jet.curvature - (step(h).slope - step(-h).slope) / (2.0 * h)).abs() < 1e-5 * omega.max(1.0)
                    );
                }
            }
        }
        // A ring that nothing holds: the mean displacement apart, finite.
        let spectrum = Spectrum::new(Chain::new(5, 0.0, 0.1).unwrap());
        let free = ImpulseResponse::new(&spectrum, 1.5).unwrap();
        let held = response(5, 1e-9, 0.1, 1.5);
        for offset in [-0.3, 0.1] {
            let (free, held) = (free.jet_between(2, 0, offset), held.jet_between(2, 0, offset));
            assert!((free.value - held.value).abs() < 1e-7, "{free:?} {held:?}");
        }
    }

    #[test]
    fn many_sites_are_as_one() {
        for sites in [1, 2, 3, 8, 21] {
            let r = response(sites, 0.2, 0.1, 0.83);
            let times = [0.0, 0.3, 0.5 * r.period, r.period + 0.1, -0.4];
            let mut profile = vec![f64::NAN; sites / 2 + 1];
            for t in times {
                r.profile(t, &mut profile);
                for (n, value) in profile.iter().enumerate() {
                    assert!((value - r.value(n, t)).abs() < 1e-14, "{sites} {n} {t}");
                    assert!((value - r.value(sites - n, t)).abs() < 1e-14, "the ring is symmetric about site 0");
                }
            }
            // Times are folded into the period.
            assert!((r.value(1, times[3]) - r.value(1, 0.1)).abs() < 1e-14);
        }
    }

    #[test]
    fn soft_and_stiff_forms_meet_where_they_change_over() {
        // y crosses 1 at omega = π Ω for one mass.
        let omega = std::f64::consts::PI * 0.7;
        let above = response(1, 0.49, 0.0, omega * (1.0 - 1e-12));
        let below = response(1, 0.49, 0.0, omega * (1.0 + 1e-12));
        assert!(above.half_phase[0] >= 1.0 && below.half_phase[0] < 1.0);
        for fraction in [0.0, 0.2, 0.5, 0.9] {
            let t = fraction * above.period;
            assert!((above.mode_dynamic(0, t) - below.mode_dynamic(0, t)).abs() < 1e-11);
            assert!((above.mode_slope(0, t) - below.mode_slope(0, t)).abs() < 1e-11);
        }
    }

    #[test]
    fn rigid_mode_moves_in_straight_lines_between_impulses() {
        // γ₁ = 0, one free mass: the dynamic part is the Bernoulli parabola T/24 − (t−T/2)²/(2T).
        let spectrum = Spectrum::new(Chain::new(1, 0.0, 1.0).unwrap());
        let r = ImpulseResponse::new(&spectrum, 2.0).unwrap();
        assert_eq!(r.static_stiffness(), 0.0);
        assert!(r.uniform_static().is_none());
        for fraction in [0.0, 0.25, 0.6] {
            let offset = (fraction - 0.5) * r.period;
            let expected = r.period / 24.0 - offset * offset / (2.0 * r.period);
            assert!((r.mode_dynamic(0, fraction * r.period) - expected).abs() < 1e-15);
        }
        assert!((r.mode_slope(0, 0.25 * r.period) - 0.25).abs() < 1e-16);
    }

    #[test]
    fn resonance_names_harmonic_mode_and_distance() {
        let spectrum = Spectrum::new(Chain::new(3, 0.25, 0.1).unwrap());
        let error = ImpulseResponse::new(&spectrum, 0.125).unwrap_err();
        assert_eq!((error.harmonic, error.mode, error.distance), (4, 0, 0.0));
        let near = ImpulseResponse::new(&spectrum, 0.125 * (1.0 + 1e-9)).unwrap();
        assert!(near.condition() > 0.9e9);
    }
}

//! What the modes have at a frequency of the impulses.

use std::f64::consts::PI;

use wide::f64x4;

use super::ImpulseResponse;
use crate::error::{RESONANCE_TOLERANCE, Resonance};
use crate::model::chain::Chain;
use crate::modes::shapes::Shapes;
use crate::modes::spectrum::Spectrum;
use crate::simd::lanes::LANES;
use crate::simd::sines::{sin_cos, soft_defect};
use crate::simd::small::{BLOCK, long_sum, products_in_order};

impl ImpulseResponse {
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
    pub(super) fn own_weights(&self) -> &[f64] {
        if self.own.is_empty() { &self.weights } else { &self.own }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resonance_names_harmonic_mode_and_distance() {
        let spectrum = Spectrum::new(Chain::new(3, 0.25, 0.1).unwrap());
        let error = ImpulseResponse::new(&spectrum, 0.125).unwrap_err();
        assert_eq!((error.harmonic, error.mode, error.distance), (4, 0, 0.0));
        let near = ImpulseResponse::new(&spectrum, 0.125 * (1.0 + 1e-9)).unwrap();
        assert!(near.condition() > 0.9e9);
    }
}

//! K₀ and its first three derivatives, without the static part, about the middle of the period: of few modes four at a time.

use wide::f64x4;

use super::ImpulseResponse;
use crate::simd::lanes::LANES;
use crate::simd::sines::{MOST, sin_cos, soft};
use crate::simd::small::{long_sum, sinc};

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

impl ImpulseResponse {
    /// Dynamic part of K₀, K₀′, K₀″ and K₀‴ at the time T/2 + `offset`, −T/2 < `offset` < T/2. Measured from the middle
    /// of the period because K₀′ vanishes there: it keeps its relative accuracy.
    pub fn jet_from_half(&self, offset: f64) -> KernelJet {
        self.jet_of(&self.squares, offset)
    }

    /// The same of any sum of kernels between sites, given by what each mode has of it beside its weight: Σ φ_k(i)φ_k(j) as
    /// [`Shapes::evens`](crate::Shapes::evens) tells it. With no shapes at all each mode has 1.
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

    /// As [`ImpulseResponse::jet_of`] at four times at once: four values, slopes, curvatures and third derivatives.
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

    /// Bounds over the open period on |K′|, |K″|, |K‴| and |K⁗| of the kernel whose modes have these shapes, see [`ImpulseResponse::jet_of`], from the
    /// modes' amplitudes.
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
}

/// What four modes have of a kernel; 0 where the last group is not full.
fn group_of(shapes: &[f64], group: usize) -> f64x4 {
    let mut four = [0.0; LANES];
    four.iter_mut().zip(shapes.iter().skip(group * LANES)).for_each(|(slot, shape)| *slot = *shape);
    f64x4::from(four)
}

#[cfg(test)]
mod tests;

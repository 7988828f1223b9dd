//! What the secular functions need of every mode that the impacts feel.

use nalgebra::Complex;
use vibrochain_breather::Prepared;
use vibrochain_lattice::{ImpulseResponse, sine_over};
use wide::f64x4;

use vibrochain_breather::lanes::{Lane, four};

/// One mode of the even subspace; four of them as `Mode<Lane>` or `Mode<f64x4>`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mode<T = f64> {
    /// b², Ω
    pub(crate) weight: T,
    pub(crate) frequency: T,
    /// c, s = cos, sin(ΩT/2)
    pub(crate) cos: T,
    pub(crate) sin: T,
    /// x = s/Ω, which a rigid mode has too, and its inverse; y = sΩ.
    pub(crate) sin_over: T,
    pub(crate) inverse: T,
    pub(crate) sin_times: T,
    /// Relative error of x and error of d = c² − s², from that of the phase, in units of ε.
    pub(crate) relative: T,
    pub(crate) shift: T,
}

/// A mode without weight, far from what a formula could stumble over.
const PAD: Mode = Mode {
    weight: 0.0,
    frequency: 0.0,
    cos: 0.6,
    sin: 0.8,
    sin_over: 1.0,
    inverse: 1.0,
    sin_times: 0.0,
    relative: 1.0,
    shift: 1.0,
};

/// A part of its own weight below this is rounding: on a ring of 10⁷ masses the least that is none is 5e-14.
const SPARED: f64 = 16.0 * f64::EPSILON;

/// Frequencies this close are equal: each is worked out to 2ε.
const EQUAL: f64 = 4.0 * f64::EPSILON;

/// Number of modes from which Cauchy sums are faster than pairs.
pub(super) const LARGE: usize = 256;

/// The even subspace, mode by mode and in groups of four, the last one padded.
#[derive(Debug, Clone, Default)]
pub(crate) struct Modes {
    list: Vec<Mode>,
    /// Their numbers in the set they were weighed from, if these are others than their places.
    numbers: Vec<u32>,
    /// Relative errors of their weights, if these are no ring's.
    blurs: Vec<f64>,
    squares: Vec<f64>,
    order: Vec<u32>,
    /// Four at a time; none where [`Modes::group_few`] leaves them out.
    groups: Vec<Mode<Lane>>,
}

impl Modes {
    /// Takes over the modes of an impulse response.
    pub(crate) fn set(&mut self, response: &ImpulseResponse) {
        let half = 0.5 * response.period();
        let modes = response.frequencies().iter().zip(response.weights());
        let phases = response.cos_half().iter().zip(response.sin_half());
        self.clear();
        self.list.extend(modes.zip(phases).map(|((f, weight), (cos, sin))| Mode::new(*f, *weight, (*cos, *sin), half)));
        self.group_few();
    }

    /// Takes over what the impacts at an orbit's one site feel: on a ring all modes that are even about it, on other lattices those
    /// without a node there, of weights φ². Of several modes with one frequency one combination is felt, with the sum of their weights.
    pub(crate) fn set_felt(&mut self, prepared: Prepared<'_>) {
        let (orbit, response) = (prepared.orbit(), prepared.response());
        let Some(site) = orbit.impact_site().filter(|_| !orbit.model().chain().is_ring()) else {
            return self.set(response);
        };
        let (frequencies, weights) = (response.frequencies(), response.weights());
        let (cos, sin, half) = (response.cos_half(), response.sin_half(), 0.5 * response.period());
        let Self { squares, order, .. } = self;
        squares.clear();
        squares.extend(response.shapes().evens(site, site).take(frequencies.len()));
        sort_felt(frequencies, squares, order);
        self.clear();
        for alike in by_frequency(frequencies, &self.order) {
            let [first, ..] = *alike else { continue };
            let k = first as usize;
            let weight: f64 = alike.iter().map(|&k| weights[k as usize] * self.squares[k as usize]).sum();
            let full: f64 = alike.iter().map(|&k| weights[k as usize]).sum();
            self.list.push(Mode::new(frequencies[k], weight, (cos[k], sin[k]), half));
            self.numbers.push(first);
            self.blurs.push(4.0 * f64::EPSILON * full / weight);
        }
        self.group_few();
    }

    fn clear(&mut self) {
        self.list.clear();
        self.numbers.clear();
        self.blurs.clear();
    }

    /// Takes over some modes of another set.
    pub(crate) fn gather(&mut self, all: &Self, chosen: &[usize]) {
        self.clear();
        self.list.extend(chosen.iter().map(|&k| all.list[k]));
        self.group();
    }

    /// Takes over the modes of another set, each with `part(k)` of its weight; those that are spared are left out.
    pub(crate) fn weigh(&mut self, all: &Self, part: impl Fn(usize) -> f64) {
        let parts = all.list.iter().enumerate().map(|(k, mode)| (k, part(k), mode));
        let felt = parts.filter(|(_, part, _)| !Self::is_spared(*part));
        self.collect(felt.map(|(k, part, mode)| (k, Mode { weight: part * mode.weight, ..*mode })));
    }

    /// Takes over modes, each with its number in the set that it comes from.
    pub(crate) fn collect(&mut self, modes: impl Iterator<Item = (usize, Mode)>) {
        self.clear();
        for (k, mode) in modes {
            self.list.push(mode);
            self.numbers.push(k as u32);
        }
        self.group();
    }

    /// The number of a mode in the set that these were weighed from.
    pub(crate) fn number(&self, k: usize) -> usize {
        self.numbers.get(k).map_or(k, |&number| number as usize)
    }

    /// Relative error of a weight, 0 of a ring's.
    pub(crate) fn blur(&self, k: usize) -> f64 {
        self.blurs.get(k).copied().unwrap_or_default()
    }

    /// A mode with this part of its weight has a node where the impacts are.
    pub(crate) fn is_spared(part: f64) -> bool {
        part < SPARED
    }

    /// Of more than [`LARGE`] modes only parts are taken four at a time, see [`Modes::gather`]: groups of all of them would be as many
    /// bytes again.
    fn group_few(&mut self) {
        self.groups.clear();
        if self.list.len() <= LARGE {
            self.group();
        }
    }

    fn group(&mut self) {
        self.groups.clear();
        let (fours, rest) = self.list.as_chunks();
        self.groups.extend(fours.iter().map(Mode::group));
        if !rest.is_empty() {
            let mut four = [PAD; 4];
            four[..rest.len()].copy_from_slice(rest);
            self.groups.push(Mode::group(&four));
        }
    }

    /// Number of modes.
    pub(crate) fn count(&self) -> usize {
        self.list.len()
    }

    /// All of them.
    pub(crate) fn list(&self) -> &[Mode] {
        &self.list
    }

    /// One of them.
    #[inline(always)]
    pub(crate) fn mode(&self, k: usize) -> Mode {
        self.list[k]
    }

    /// All of them, four at a time; of a whole lattice none if there are more than [`LARGE`].
    #[inline(always)]
    pub(crate) fn groups(&self) -> &[Mode<Lane>] {
        debug_assert_eq!(self.groups.len(), self.list.len().div_ceil(4), "modes that were left out of the groups");
        &self.groups
    }
}

impl Mode {
    /// A mode from its cos, sin(ΩT/2), `half` being T/2.
    #[inline(always)]
    fn new(frequency: f64, weight: f64, (cos, sin): (f64, f64), half: f64) -> Self {
        // ΩT
        let y = 2.0 * frequency * half;
        // sin(ΩT/2)/Ω, which a soft mode needs from its series.
        let sin_over = if frequency * half > 1e-3 { sin / frequency } else { sine_over(frequency, half) };
        // A phase y carries a relative error of about 2ε, so that δx/x = y cot y and δd = 2y sin 2y.
        let relative = 4.0 + if y > 1e-3 { (y * cos / sin).abs() } else { 1.0 };
        let shift = 2.0 * (y * cos * sin).abs() + 4.0 * (cos * cos).min(sin * sin);
        let (inverse, sin_times) = (1.0 / sin_over, frequency * sin);
        Self { weight, frequency, cos, sin, sin_over, inverse, sin_times, relative, shift }
    }

    /// e^{iΩT}
    #[inline(always)]
    pub(crate) fn pole(&self) -> Complex<f64> {
        Complex::new((self.cos - self.sin) * (self.cos + self.sin), 2.0 * self.sin * self.cos)
    }
}

/// Numbers of the modes that have no node where all impacts are, by rising frequency; `squares` are φ² there, weights left out.
pub(crate) fn sort_felt(frequencies: &[f64], squares: &[f64], order: &mut Vec<u32>) {
    order.clear();
    order.extend((0..frequencies.len()).filter(|&k| !Modes::is_spared(squares[k])).map(|k| k as u32));
    order.sort_unstable_by(|&a, &b| frequencies[a as usize].total_cmp(&frequencies[b as usize]).then(a.cmp(&b)));
}

/// Those of equal frequency together.
pub(crate) fn by_frequency<'a>(frequencies: &'a [f64], order: &'a [u32]) -> impl Iterator<Item = &'a [u32]> + 'a {
    order.chunk_by(|&low, &high| {
        let (low, high) = (frequencies[low as usize], frequencies[high as usize]);
        high - low <= EQUAL * high
    })
}

impl Mode<Lane> {
    #[inline(always)]
    fn group([a, b, c, d]: &[Mode; 4]) -> Self {
        Self {
            weight: [a.weight, b.weight, c.weight, d.weight],
            frequency: [a.frequency, b.frequency, c.frequency, d.frequency],
            cos: [a.cos, b.cos, c.cos, d.cos],
            sin: [a.sin, b.sin, c.sin, d.sin],
            sin_over: [a.sin_over, b.sin_over, c.sin_over, d.sin_over],
            inverse: [a.inverse, b.inverse, c.inverse, d.inverse],
            sin_times: [a.sin_times, b.sin_times, c.sin_times, d.sin_times],
            relative: [a.relative, b.relative, c.relative, d.relative],
            shift: [a.shift, b.shift, c.shift, d.shift],
        }
    }

    /// As operands.
    #[inline(always)]
    pub(crate) fn four(&self) -> Mode<f64x4> {
        Mode {
            weight: four(self.weight),
            frequency: four(self.frequency),
            cos: four(self.cos),
            sin: four(self.sin),
            sin_over: four(self.sin_over),
            inverse: four(self.inverse),
            sin_times: four(self.sin_times),
            relative: four(self.relative),
            shift: four(self.shift),
        }
    }
}

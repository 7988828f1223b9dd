//! What the secular functions need of every even mode.

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

/// The even subspace, mode by mode and in groups of four, the last one padded.
#[derive(Debug, Clone, Default)]
pub(crate) struct Modes {
    list: Vec<Mode>,
    /// Their numbers in the set they were weighed from, if these are others than their places.
    numbers: Vec<u32>,
    groups: Vec<Mode<Lane>>,
}

impl Modes {
    /// Takes over the modes of an impulse response.
    pub(crate) fn set(&mut self, response: &ImpulseResponse) {
        let half = 0.5 * response.period();
        let modes = response.frequencies().iter().zip(response.weights());
        let phases = response.cos_half().iter().zip(response.sin_half());
        self.list.clear();
        self.numbers.clear();
        self.list.extend(modes.zip(phases).map(|((&frequency, &weight), (&cos, &sin))| {
            // ΩT
            let y = 2.0 * frequency * half;
            // sin(ΩT/2)/Ω, which a soft mode needs from its series.
            let sin_over = if frequency * half > 1e-3 { sin / frequency } else { sine_over(frequency, half) };
            // A phase y carries a relative error of about 2ε, so that δx/x = y cot y and δd = 2y sin 2y.
            let relative = 4.0 + if y > 1e-3 { (y * cos / sin).abs() } else { 1.0 };
            let shift = 2.0 * (y * cos * sin).abs() + 4.0 * (cos * cos).min(sin * sin);
            let (inverse, sin_times) = (1.0 / sin_over, frequency * sin);
            Mode { weight, frequency, cos, sin, sin_over, inverse, sin_times, relative, shift }
        }));
        self.group();
    }

    /// Takes over some modes of another set.
    pub(crate) fn gather(&mut self, all: &Self, chosen: &[usize]) {
        self.list.clear();
        self.list.extend(chosen.iter().map(|&k| all.list[k]));
        self.group();
    }

    /// Takes over the modes of another set, each with `part(k)` of its weight; those that are spared are left out.
    pub(crate) fn weigh(&mut self, all: &Self, part: impl Fn(usize) -> f64) {
        self.list.clear();
        self.numbers.clear();
        for (k, mode) in all.list.iter().enumerate() {
            let part = part(k);
            if !Self::is_spared(part) {
                self.list.push(Mode { weight: part * mode.weight, ..*mode });
                self.numbers.push(k as u32);
            }
        }
        self.group();
    }

    /// The number of a mode in the set that these were weighed from.
    pub(crate) fn number(&self, k: usize) -> usize {
        self.numbers.get(k).map_or(k, |&number| number as usize)
    }

    /// A mode with this part of its weight has a node where the impacts are.
    pub(crate) fn is_spared(part: f64) -> bool {
        part < SPARED
    }

    fn group(&mut self) {
        self.groups.clear();
        self.groups.extend(self.list.chunks(4).map(|chunk| {
            let mut four = [PAD; 4];
            four[..chunk.len()].copy_from_slice(chunk);
            let pick = |part: fn(&Mode) -> f64| [part(&four[0]), part(&four[1]), part(&four[2]), part(&four[3])];
            Mode {
                weight: pick(|mode| mode.weight),
                frequency: pick(|mode| mode.frequency),
                cos: pick(|mode| mode.cos),
                sin: pick(|mode| mode.sin),
                sin_over: pick(|mode| mode.sin_over),
                inverse: pick(|mode| mode.inverse),
                sin_times: pick(|mode| mode.sin_times),
                relative: pick(|mode| mode.relative),
                shift: pick(|mode| mode.shift),
            }
        }));
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

    /// All of them, four at a time.
    #[inline(always)]
    pub(crate) fn groups(&self) -> &[Mode<Lane>] {
        &self.groups
    }
}

impl Mode<Lane> {
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

//! What the secular functions need of every even mode.

use vibrochain_lattice::{ImpulseResponse, sine_over};
use wide::f64x4;

use super::lanes::{Lane, fill, four};

/// Modes of the even subspace, padded to groups of four by modes without weight.
#[derive(Debug, Clone, Default)]
pub(crate) struct Modes {
    pub(crate) count: usize,
    /// b², Ω
    pub(crate) weight: Vec<Lane>,
    pub(crate) frequency: Vec<Lane>,
    /// c, s = cos, sin(ΩT/2)
    pub(crate) cos: Vec<Lane>,
    pub(crate) sin: Vec<Lane>,
    /// x = s/Ω, which a rigid mode has too, and its inverse; y = sΩ.
    pub(crate) sin_over: Vec<Lane>,
    pub(crate) inverse: Vec<Lane>,
    pub(crate) sin_times: Vec<Lane>,
    /// Relative error of x and error of d = c² − s², from that of the phase, in units of ε.
    pub(crate) relative: Vec<Lane>,
    pub(crate) shift: Vec<Lane>,
    list: Vec<Mode>,
}

impl Modes {
    /// Takes over the modes of an impulse response.
    pub(crate) fn set(&mut self, response: &ImpulseResponse) {
        let (frequencies, cos, sin) = (response.frequencies(), response.cos_half(), response.sin_half());
        let half = 0.5 * response.period();
        self.count = frequencies.len();
        // sin(ΩT/2)/Ω, which a soft mode needs from its series.
        let over = |(f, s): (&f64, &f64)| if f * half > 1e-3 { s / f } else { sine_over(*f, half) };
        fill(&mut self.weight, response.weights().iter().copied(), 0.0);
        fill(&mut self.frequency, frequencies.iter().copied(), 0.0);
        fill(&mut self.cos, cos.iter().copied(), 0.6);
        fill(&mut self.sin, sin.iter().copied(), 0.8);
        fill(&mut self.sin_over, frequencies.iter().zip(sin).map(over), 1.0);
        fill(&mut self.inverse, self.sin_over.as_flattened()[..self.count].iter().map(|x| 1.0 / x), 1.0);
        fill(&mut self.sin_times, frequencies.iter().zip(sin).map(|(f, s)| f * s), 0.0);
        let phases = || frequencies.iter().zip(cos).zip(sin).map(|((f, c), s)| (2.0 * f * half, *c, *s));
        // A phase y carries a relative error of about 2ε, so that δx/x = y cot y and δd = 2y sin 2y.
        fill(&mut self.relative, phases().map(|(y, c, s)| 4.0 + if y > 1e-3 { (y * c / s).abs() } else { 1.0 }), 1.0);
        fill(&mut self.shift, phases().map(|(y, c, s)| 2.0 * (y * c * s).abs() + 4.0 * (c * c).min(s * s)), 1.0);
        self.enlist();
    }

    /// Takes over some modes of another set.
    pub(crate) fn gather(&mut self, all: &Self, chosen: &[usize]) {
        self.count = chosen.len();
        let lists = [
            (&mut self.weight, &all.weight, 0.0),
            (&mut self.frequency, &all.frequency, 0.0),
            (&mut self.cos, &all.cos, 0.6),
            (&mut self.sin, &all.sin, 0.8),
            (&mut self.sin_over, &all.sin_over, 1.0),
            (&mut self.inverse, &all.inverse, 1.0),
            (&mut self.sin_times, &all.sin_times, 0.0),
            (&mut self.relative, &all.relative, 1.0),
            (&mut self.shift, &all.shift, 1.0),
        ];
        for (own, all, pad) in lists {
            fill(own, chosen.iter().map(|&k| all.as_flattened()[k]), pad);
        }
        self.enlist();
    }

    /// One mode.
    #[inline(always)]
    pub(crate) fn mode(&self, k: usize) -> Mode {
        self.list[k]
    }

    /// Four neighbouring modes.
    #[inline(always)]
    pub(crate) fn group(&self, i: usize) -> Mode<f64x4> {
        Mode {
            weight: four(self.weight[i]),
            frequency: four(self.frequency[i]),
            cos: four(self.cos[i]),
            sin: four(self.sin[i]),
            sin_over: four(self.sin_over[i]),
            inverse: four(self.inverse[i]),
            sin_times: four(self.sin_times[i]),
            relative: four(self.relative[i]),
            shift: four(self.shift[i]),
        }
    }

    /// The same numbers mode by mode.
    fn enlist(&mut self) {
        let lists = [
            &self.weight,
            &self.frequency,
            &self.cos,
            &self.sin,
            &self.sin_over,
            &self.inverse,
            &self.sin_times,
            &self.relative,
            &self.shift,
        ];
        let lists = lists.map(|lanes| &lanes.as_flattened()[..self.count]);
        self.list.clear();
        self.list.extend((0..self.count).map(|k| {
            let [weight, frequency, cos, sin, sin_over, inverse, sin_times, relative, shift] =
                lists.map(|list| list[k]);
            Mode { weight, frequency, cos, sin, sin_over, inverse, sin_times, relative, shift }
        }));
    }
}

/// The entries of [`Modes`] for one mode, or for four.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mode<T = f64> {
    pub(crate) weight: T,
    pub(crate) frequency: T,
    pub(crate) cos: T,
    pub(crate) sin: T,
    pub(crate) sin_over: T,
    pub(crate) inverse: T,
    pub(crate) sin_times: T,
    pub(crate) relative: T,
    pub(crate) shift: T,
}

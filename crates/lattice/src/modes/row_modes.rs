//! Frequencies and shapes of the modes of one row, in twice the digits: real and orthonormal.

use crate::modes::quarter_wave::QuarterWave;
use crate::modes::row::{Ends, Line, RowEnds};
use crate::simd::twofold::{FINE, Twofold};

/// What a number may be off, as a part of itself.
pub(crate) const FAINT: f64 = 64.0 * FINE;

/// One mode of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct RowMode {
    /// Its number on the row of images.
    k: usize,
    /// Of a pair of a ring the one with a node at site 0.
    is_odd: bool,
}

/// The modes of a row.
#[derive(Debug, Clone)]
pub(crate) struct RowModes {
    /// A row with a wall and a free end moves as a walled one of twice as many masses does evenly about its middle: in every other mode of
    /// that one.
    line: Line,
    is_half: bool,
    wave: QuarterWave,
}

impl RowModes {
    pub(crate) fn new(masses: usize, ends: RowEnds) -> Self {
        let (line, is_half) = match ends {
            RowEnds::Alike(ends) => (Line { masses, ends }, false),
            RowEnds::FixedFree => (Line { masses: 2 * masses, ends: Ends::Fixed }, true),
        };
        let circle = line.circle();
        let wave = QuarterWave::new(if line.ends == Ends::Closed { circle } else { circle / 2 });
        Self { line, is_half, wave }
    }

    /// All of them, as many as masses, by rising [`RowModes::stiffness`].
    pub(crate) fn all(&self) -> impl Iterator<Item = RowMode> + '_ {
        let numbers = (0..self.line.modes()).step_by(if self.is_half { 2 } else { 1 });
        numbers.flat_map(|k| (0..self.line.multiplicity(k)).map(move |which| RowMode { k, is_odd: which == 1 }))
    }

    /// Ω²/γ₂ of springs between neighbours alone.
    pub(crate) fn stiffness(&self, mode: RowMode) -> Twofold {
        let wave = (mode.k + self.line.lowest()) as u64;
        let half_turns = if self.line.ends == Ends::Closed { 2 * wave } else { wave };
        let sine = self.wave.sine(half_turns);
        sine * sine * Twofold::from(4.0)
    }

    /// What its shape has for a factor.
    pub(crate) fn scale(&self, mode: RowMode) -> Twofold {
        let (part, of) = self.line.share(mode.k);
        let part = if self.is_half { 2 * part } else { part };
        Twofold::from(part as f64).over(of as f64).root()
    }

    /// Its shape at mass `n` without that.
    pub(crate) fn wave(&self, mode: RowMode, n: usize) -> Twofold {
        let (k, n) = (mode.k as u64, n as u64);
        match self.line.ends {
            Ends::Closed if mode.is_odd => self.wave.sine(4 * k * n),
            Ends::Closed => self.wave.cosine(4 * k * n),
            Ends::Free => self.wave.cosine(k * (2 * n + 1)),
            Ends::Fixed => self.wave.sine(2 * (k + 1) * (n + 1)),
        }
    }
}

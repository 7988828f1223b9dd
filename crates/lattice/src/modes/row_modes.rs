//! Frequencies and shapes of the modes of one row, and of rows side by side, in twice the digits: real and orthonormal.

use crate::modes::quarter_wave::QuarterWave;
use crate::modes::row::{Ends, Line, RowEnds};
use crate::simd::twofold::{FINE, Twofold};

/// What a number may be off, as a part of itself.
pub(crate) const FAINT: f64 = 64.0 * FINE;

/// One mode of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct RowMode {
    /// Its number on the row of images.
    k: usize,
    /// Of a pair of a ring the one with a node at site 0.
    is_odd: bool,
}

/// The modes of a row.
#[derive(Debug, Clone)]
struct RowModes {
    /// A row with a wall and a free end moves as a walled one of twice as many masses does evenly about its middle: in every other mode of
    /// that one.
    line: Line,
    is_half: bool,
    wave: QuarterWave,
}

impl RowModes {
    fn new(masses: usize, ends: RowEnds) -> Self {
        let (line, is_half) = match ends {
            RowEnds::Alike(ends) => (Line { masses, ends }, false),
            RowEnds::FixedFree => (Line { masses: 2 * masses, ends: Ends::Fixed }, true),
        };
        let circle = line.circle();
        let wave = QuarterWave::new(if line.ends == Ends::Closed { circle } else { circle / 2 });
        Self { line, is_half, wave }
    }

    /// All of them, as many as masses, by rising [`RowModes::stiffness`].
    fn all(&self) -> impl Iterator<Item = RowMode> + '_ {
        let numbers = (0..self.line.modes()).step_by(if self.is_half { 2 } else { 1 });
        numbers.flat_map(|k| (0..self.line.multiplicity(k)).map(move |which| RowMode { k, is_odd: which == 1 }))
    }

    /// Ω²/γ₂ of springs between neighbours alone.
    fn stiffness(&self, mode: RowMode) -> Twofold {
        let wave = (mode.k + self.line.lowest()) as u64;
        let half_turns = if self.line.ends == Ends::Closed { 2 * wave } else { wave };
        let sine = self.wave.sine(half_turns);
        sine * sine * Twofold::from(4.0)
    }

    /// Whether all masses together stay where they are: there are no walls, and it is not the mode in which they move alike.
    fn is_balanced(&self, mode: RowMode) -> bool {
        self.line.ends != Ends::Fixed && mode.k > 0
    }

    /// What its shape has for a factor.
    fn scale(&self, mode: RowMode) -> Twofold {
        let (part, of) = self.line.share(mode.k);
        let part = if self.is_half { 2 * part } else { part };
        Twofold::from(part as f64).over(of as f64).root()
    }

    /// Its shape at mass `n` without that.
    fn wave(&self, mode: RowMode, n: usize) -> Twofold {
        let (k, n) = (mode.k as u64, n as u64);
        match self.line.ends {
            Ends::Closed if mode.is_odd => self.wave.sine(4 * k * n),
            Ends::Closed => self.wave.cosine(4 * k * n),
            Ends::Free => self.wave.cosine(k * (2 * n + 1)),
            Ends::Fixed => self.wave.sine(2 * (k + 1) * (n + 1)),
        }
    }
}

/// One mode of rows side by side: along them and across.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct LayeredMode {
    along: RowMode,
    across: RowMode,
}

/// The modes of rows side by side: shapes are products of those along them and across.
#[derive(Debug, Clone)]
pub(crate) struct LayerModes {
    along: RowModes,
    across: RowModes,
    /// Masses of a row.
    length: usize,
}

impl LayerModes {
    /// Of so many masses a row, and so many rows.
    pub(crate) fn new((masses, ends): (usize, RowEnds), (layers, layer_ends): (usize, Ends)) -> Self {
        // One row has no neighbours whatever its ends.
        let beside = RowEnds::Alike(if layers == 1 { Ends::Free } else { layer_ends });
        Self { along: RowModes::new(masses, ends), across: RowModes::new(layers, beside), length: masses }
    }

    /// All of them, as many as masses.
    pub(crate) fn all(&self) -> impl Iterator<Item = LayeredMode> + '_ {
        self.across.all().flat_map(|across| self.along.all().map(move |along| LayeredMode { along, across }))
    }

    /// Ω² of springs of stiffness 1 between neighbours along the rows alone, and of those across alone.
    pub(crate) fn stiffnesses(&self, mode: LayeredMode) -> [Twofold; 2] {
        [self.along.stiffness(mode.along), self.across.stiffness(mode.across)]
    }

    /// Its shape, as a function of the number of a mass.
    pub(crate) fn shape(&self, mode: LayeredMode) -> impl Fn(usize) -> Twofold + '_ {
        let (along, across) = (self.along.scale(mode.along), self.across.scale(mode.across));
        let is_row = self.across.line.masses == 1;
        move |n| {
            let own = along * self.along.wave(mode.along, n % self.length);
            if is_row { own } else { own * (across * self.across.wave(mode.across, n / self.length)) }
        }
    }

    /// Whether a mass is at a node of the mode.
    pub(crate) fn is_node(&self, mode: LayeredMode, n: usize) -> bool {
        let along = self.along.wave(mode.along, n % self.length);
        along.high == 0.0 || self.across.wave(mode.across, n / self.length).high == 0.0
    }

    /// Whether the displacements of all masses add up to 0, as a load that is the same on all of them sees it.
    pub(crate) fn is_balanced(&self, mode: LayeredMode) -> bool {
        self.along.is_balanced(mode.along) || self.across.is_balanced(mode.across)
    }
}

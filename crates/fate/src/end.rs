//! How a run ends, in one word.

use vibrochain_breather::Word;

/// What has become of a perturbed breather.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum End {
    /// The breather it started on: its impacts, within the tolerance.
    Breather,
    /// Another motion whose impacts repeat, and its word.
    Periodic(Word),
    /// No impact any more.
    Quiet,
    /// The largest Lyapunov exponent is clearly positive.
    Chaos,
    /// Impacts that do not repeat, while neighbours part no faster than by a power of time: quasi-periodic, or so slow to settle
    /// that the run does not tell it from that.
    QuasiPeriodic,
    /// None of these: still on its way, or periodic with more impacts than a word has, or with rests.
    Unclassified,
    /// The run could not be completed: a cascade that does not end, a mass behind its barrier at the start, the limit of work.
    Incomplete,
}

impl End {
    /// Names of the kinds, in the order of tables.
    pub const NAMES: [&'static str; 7] =
        ["breather", "periodic", "quiet", "chaos", "quasi-periodic", "unclassified", "incomplete"];

    /// Number of its kind in [`End::NAMES`].
    #[must_use]
    pub fn kind(&self) -> usize {
        match self {
            Self::Breather => 0,
            Self::Periodic(_) => 1,
            Self::Quiet => 2,
            Self::Chaos => 3,
            Self::QuasiPeriodic => 4,
            Self::Unclassified => 5,
            Self::Incomplete => 6,
        }
    }

    /// The name of its kind.
    #[must_use]
    pub fn name(&self) -> &'static str {
        Self::NAMES[self.kind()]
    }
}

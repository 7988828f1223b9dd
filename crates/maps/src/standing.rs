//! Which of its physical orbits gives a cell its class.

use std::cmp::Ordering;

use vibrochain_floquet::{Tolerance, Verdict};

/// What decides between two orbits of a cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Standing {
    /// The place of its word, or family, among those that the scene asks for.
    pub(crate) word: usize,
    /// Whether it is stable, where that is asked and known.
    pub(crate) verdict: Option<Verdict>,
}

impl Standing {
    /// 0 for a stable orbit, 1 for one that may be.
    fn doubt(&self) -> u8 {
        self.verdict.map_or(2, |verdict| if verdict.stable { 0 } else { 2 - u8::from(verdict.undecided) })
    }

    /// A stable orbit wins, then one that may be, then one of the word that is asked for first, then that of the smaller spectral radius, by more
    /// than both may be off; of equal ones the one that is listed first. Between two words the borders of a class are so where something happens
    /// to an orbit, not where two radii are equal.
    pub(crate) fn beats(&self, other: &Self) -> bool {
        match (self.doubt(), self.word).cmp(&(other.doubt(), other.word)) {
            Ordering::Less => true,
            Ordering::Greater => false,
            Ordering::Equal => self.verdict.zip(other.verdict).is_some_and(|(own, best)| {
                own.spectral_radius + own.resolution < best.spectral_radius - best.resolution
            }),
        }
    }

    /// Whether an orbit of the word at `word` cannot beat this one, so that it needs no verdict; `exceeds` tells whether its spectral radius is surely
    /// beyond a number.
    pub(crate) fn keeps_its_place(
        &self,
        (word, is_conservative): (usize, bool),
        tolerance: Tolerance,
        exceeds: impl FnOnce(f64) -> bool,
    ) -> bool {
        // Without losses the radii of all stable orbits are 1 and do not decide.
        let is_settled = self.doubt() == 0 && (self.word < word || self.word == word && is_conservative);
        is_settled || self.reach(word, tolerance).is_some_and(exceeds)
    }

    /// From which spectral radius on an orbit of the word at `word` is surely no better, if there is one: it is unstable then, by more than
    /// `tolerance`.
    fn reach(&self, word: usize, tolerance: Tolerance) -> Option<f64> {
        let least = unstable_beyond(tolerance);
        let unstable = Self { word, verdict: None };
        match (self.doubt(), self.word).cmp(&(unstable.doubt(), unstable.word)) {
            Ordering::Less => Some(least),
            Ordering::Equal => Some(self.verdict.map_or(least, |verdict| least.max(verdict.spectral_radius))),
            Ordering::Greater => None,
        }
    }
}

/// The spectral radius beyond which an orbit counts as unstable.
pub(crate) fn unstable_beyond(tolerance: Tolerance) -> f64 {
    1.0 + Option::from(tolerance).unwrap_or(0.0)
}

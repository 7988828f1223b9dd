//! What an orbit is called.

use vibrochain_lattice::Layout;

use crate::orbit::{Family, Impact, Orbit, SIMULTANEOUS};
use crate::word::{Letter, Word};

impl Word {
    /// The word of an orbit.
    pub fn of(orbit: &Orbit) -> Self {
        // Contacts of a structure stand in one row.
        let layout = orbit.model().map_or(Layout::ONE_ROW, |model| model.chain().layout());
        let letter = |impact: &Impact| {
            let (site, layer) = layout.place(impact.site);
            Letter { site, layer, barrier: impact.barrier }
        };
        let mut instants: Vec<Vec<Letter>> =
            orbit.instants().map(|impacts| impacts.iter().map(letter).collect()).collect();
        // Just before the period is at its beginning.
        let left = orbit.impacts().last().map_or(orbit.period(), |impact| orbit.period() - impact.time);
        if instants.len() > 1 && left <= SIMULTANEOUS * orbit.period() {
            let end = instants.pop().unwrap_or_default();
            instants[0].extend(end);
        }
        instants.iter_mut().for_each(|letters| letters.sort_unstable());
        Self { instants }
    }
}

impl Orbit {
    /// What it is called: the name of its family, or its word.
    #[must_use]
    pub fn name(&self) -> String {
        self.word().unwrap_or_else(|| self.family().name().to_owned())
    }

    /// The same, with the periods of the force where these are several: `0+,0+/2`, as scenes have it.
    #[must_use]
    pub fn full_name(&self) -> String {
        let name = self.name();
        if self.force_periods() == 1 { name } else { format!("{name}/{}", self.force_periods()) }
    }

    /// Its word, if it is of no family.
    #[must_use]
    pub fn word(&self) -> Option<String> {
        (self.family() == Family::Word).then(|| Word::of(self).to_string())
    }
}

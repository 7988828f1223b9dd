//! Impact words: which mass meets which barrier, in which order, in one period of an orbit.
//!
//! `0+3+,0-3-` are two masses on their upper barriers at one instant and on their lower ones at another. Instants are
//! separated by commas or spaces; an impact is a site and `+` (upper) or `-` (lower barrier). `2:1+` is site 2 of layer 1.
//!
//! Words that a shift in time turns into each other are one word, and so are those that a symmetry of the chain does:
//! rotations and reflections of a ring, reflections of a row with ends, the same across layers; reversal of time, where impacts are elastic and no force acts; and exchange of the
//! barriers where they are centred (half a period later, under a force). [`Word::canonical`] is the smallest of them.

pub(crate) mod enumeration;
mod symmetry;
mod text;

use std::borrow::Cow;

use thiserror::Error;
use vibrochain_lattice::{Barrier, Layout};

use crate::orbit::Family;

/// The most impacts of a word: their equations are solved densely.
pub const MAX_IMPACTS: usize = 64;

/// What cannot be an impact word, or not one of this chain.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum WordError {
    /// No impact at all, or an instant without one.
    #[error("instant {instant} of the word has no impact: give sites and barriers, as in 0+3+,0-3-")]
    Empty {
        /// Number of the instant, from 1.
        instant: usize,
    },
    /// Not a site followed by + or -.
    #[error("`{text}` is not an impact: give a site and + (upper barrier) or - (lower), as in 0+3+,0-3-")]
    Unreadable {
        /// What was read.
        text: String,
    },
    /// A layer that the lattice does not have.
    #[error("layer {layer} does not exist: this lattice has the layers 0 to {last}")]
    NoSuchLayer {
        /// The layer.
        layer: usize,
        /// The last one there is.
        last: usize,
    },
    /// One mass on both barriers at one instant.
    #[error("site {site} cannot be on both barriers at one instant: put a comma between the two")]
    BothBarriers {
        /// The mass.
        site: usize,
    },
    /// The same impact twice at one instant.
    #[error("site {site} is named twice at one instant: two impacts of one mass on one barrier need two instants")]
    Twice {
        /// The mass.
        site: usize,
    },
    /// Too long.
    #[error("{impacts} impacts are too many: a word has at most {MAX_IMPACTS}")]
    TooMany {
        /// How many were given.
        impacts: usize,
    },
    /// A site that the chain does not have.
    #[error("site {site} does not exist: this chain has the sites 0 to {last}")]
    NoSuchSite {
        /// The site.
        site: usize,
        /// The last one there is.
        last: usize,
    },
}

/// One impact of a word. They are ordered by layer and site, the upper barrier first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Letter {
    /// The mass that hits, in its layer.
    pub site: usize,
    /// Its layer.
    pub layer: usize,
    /// The barrier it hits.
    pub barrier: Barrier,
}

impl Letter {
    /// An impact in the first layer.
    pub fn new(site: usize, barrier: Barrier) -> Self {
        Self { site, layer: 0, barrier }
    }

    fn place(self) -> (usize, usize) {
        (self.layer, self.site)
    }

    fn key(self) -> ((usize, usize), bool) {
        (self.place(), self.barrier == Barrier::Lower)
    }
}

impl PartialOrd for Letter {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Letter {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.key().cmp(&other.key())
    }
}

/// An impact word. Impacts of one instant are in order of site.
///
/// ```
/// use vibrochain_breather::{Family, Word};
/// use vibrochain_lattice::{Chain, Model};
/// let word: Word = "3- 0-, 0+3+".parse()?;
/// assert_eq!(word.to_string(), "3-,0-,0+3+");
/// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 1.5, 0.2)?;
/// let word: Word = "5-8-,5+8+".parse()?;
/// assert_eq!(word.canonical(&model).to_string(), "0+3+,0-3-");
/// assert_eq!("7-,7+".parse::<Word>()?.family(), Some(Family::DoubleSided));
/// assert!("0+0-".parse::<Word>().is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Word {
    pub(crate) instants: Vec<Vec<Letter>>,
}

impl Word {
    /// The word of these instants.
    ///
    /// # Errors
    /// [`WordError`].
    pub fn new(mut instants: Vec<Vec<Letter>>) -> Result<Self, WordError> {
        let impacts = instants.iter().map(Vec::len).sum();
        if impacts > MAX_IMPACTS {
            return Err(WordError::TooMany { impacts });
        }
        if instants.is_empty() {
            return Err(WordError::Empty { instant: 1 });
        }
        for (i, letters) in instants.iter_mut().enumerate() {
            if letters.is_empty() {
                return Err(WordError::Empty { instant: i + 1 });
            }
            letters.sort_unstable();
            if let Some(pair) = letters.windows(2).find(|pair| pair[0].place() == pair[1].place()) {
                let site = pair[0].site;
                return Err(if pair[0] == pair[1] {
                    WordError::Twice { site }
                } else {
                    WordError::BothBarriers { site }
                });
            }
        }
        Ok(Self { instants })
    }

    /// The word of a family at site 0.
    pub fn of_family(family: Family) -> Option<Self> {
        let at = |barrier| vec![Letter::new(0, barrier)];
        let instants = match family {
            Family::SingleSided => vec![at(Barrier::Lower)],
            Family::PeriodDoubled => vec![at(Barrier::Lower), at(Barrier::Lower)],
            Family::DoubleSided => vec![at(Barrier::Upper), at(Barrier::Lower)],
            Family::Word => return None,
        };
        Some(Self { instants })
    }

    /// The instants, each with its impacts in order of site.
    pub fn instants(&self) -> &[Vec<Letter>] {
        &self.instants
    }

    /// All impacts in order of time.
    pub fn letters(&self) -> impl Iterator<Item = Letter> + '_ {
        self.instants.iter().flatten().copied()
    }

    /// The masses that are hit, as layers and sites, rising.
    pub fn places(&self) -> Vec<(usize, usize)> {
        let mut places: Vec<_> = self.letters().map(Letter::place).collect();
        places.sort_unstable();
        places.dedup();
        places
    }

    /// Whether all its sites exist on a lattice.
    ///
    /// # Errors
    /// [`WordError::NoSuchSite`], [`WordError::NoSuchLayer`].
    pub fn check(&self, layout: &Layout) -> Result<(), WordError> {
        for Letter { site, layer, .. } in self.letters() {
            if layer >= layout.layers {
                return Err(WordError::NoSuchLayer { layer, last: layout.layers.saturating_sub(1) });
            }
            if site >= layout.length {
                return Err(WordError::NoSuchSite { site, last: layout.length.saturating_sub(1) });
            }
        }
        Ok(())
    }

    /// The same word with all layers of the lattice as one row, numbered as [`vibrochain_lattice::Chain`] numbers masses.
    pub(crate) fn in_one_row(&self, layout: &Layout) -> Cow<'_, Self> {
        if layout.layers == 1 {
            return Cow::Borrowed(self);
        }
        let of = |letter: &Letter| Letter::new(letter.site + letter.layer * layout.length, letter.barrier);
        let instants = self.instants.iter().map(|letters| letters.iter().map(of).collect()).collect();
        Cow::Owned(Self { instants })
    }

    /// All impacts are on one side.
    pub(crate) fn is_one_sided(&self) -> bool {
        let first = self.letters().next();
        self.letters().all(|letter| first.is_some_and(|first| first.barrier == letter.barrier))
    }

    /// The family of which it is the name, at whatever site: `0+,0-`, `0-`, and `0-,0-` of two periods of the force.
    pub fn family(&self) -> Option<Family> {
        let mut letters = self.letters();
        let (first, second) = (letters.next()?, letters.next());
        if letters.next().is_some() || second.is_some_and(|second| second.place() != first.place()) {
            return None;
        }
        match (first.barrier, second.map(|second| second.barrier)) {
            (Barrier::Lower, None) => Some(Family::SingleSided),
            (Barrier::Lower, Some(Barrier::Lower)) => Some(Family::PeriodDoubled),
            (first, Some(second)) if first != second => Some(Family::DoubleSided),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn word(text: &str) -> Word {
        text.parse().unwrap()
    }

    #[test]
    fn words_are_read_and_written() {
        for (text, written) in [
            ("0+,0-", "0+,0-"),
            ("  0+3+   0-3- ", "0+3+,0-3-"),
            ("3+0+ ,0-", "0+3+,0-"),
            ("0:0+,0-", "0+,0-"),
            ("2:1+0+,1-", "0:0+2:1+,1:0-"),
            ("single-sided", "0-"),
        ] {
            assert_eq!(word(text).to_string(), written);
            assert_eq!(word(written), word(text));
        }
        for (text, part) in [
            ("", "instant 1"),
            ("0+,,0-", "instant 2"),
            ("0+,", "instant 2"),
            ("0", "`0` is not"),
            ("a+", "`a+` is not"),
            ("-1+", "`-` is not"),
            ("99999999999999999999+", "is not an impact"),
            ("0+0-", "both barriers"),
            ("0+0+", "twice"),
            ("0:+", "`0:+` is not"),
            ("2:1+2:1-", "both barriers"),
        ] {
            let error = text.parse::<Word>().unwrap_err().to_string();
            assert!(error.contains(part), "{text}: {error}");
        }
        let long = vec!["0+"; MAX_IMPACTS + 1].join(",");
        assert_eq!(long.parse::<Word>(), Err(WordError::TooMany { impacts: MAX_IMPACTS + 1 }));
        let layout = Layout { layers: 2, ..Layout::ring(21) };
        assert_eq!(word("0+25-").check(&layout), Err(WordError::NoSuchSite { site: 25, last: 20 }));
        assert_eq!(word("0+20:2-").check(&layout), Err(WordError::NoSuchLayer { layer: 2, last: 1 }));
        assert_eq!(word("0+20:1-").check(&layout), Ok(()));
    }

    #[test]
    fn families_are_words() {
        for (text, family) in [
            ("4+,4-", Some(Family::DoubleSided)),
            ("4-,4+", Some(Family::DoubleSided)),
            ("4-", Some(Family::SingleSided)),
            ("4-,4-", Some(Family::PeriodDoubled)),
            ("4+", None),
            ("4+,4+", None),
            ("0+,4-", None),
            ("0+,0-,0+", None),
        ] {
            assert_eq!(word(text).family(), family, "{text}");
        }
    }
}

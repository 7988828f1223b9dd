//! Words as they are written and read: `0+3+,0-3-`, `2:1+`, or the name of a family.

use std::fmt;
use std::str::FromStr;

use vibrochain_lattice::Barrier;

use super::{Letter, MAX_IMPACTS, Word, WordError};
use crate::orbit::Family;

impl fmt::Display for Word {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let layered = self.letters().any(|letter| letter.layer > 0);
        for (i, letters) in self.instants.iter().enumerate() {
            if i > 0 {
                f.write_str(",")?;
            }
            for Letter { site, layer, barrier } in letters {
                let barrier = if *barrier == Barrier::Upper { '+' } else { '-' };
                if layered {
                    write!(f, "{site}:{layer}{barrier}")?;
                } else {
                    write!(f, "{site}{barrier}")?;
                }
            }
        }
        Ok(())
    }
}

impl FromStr for Word {
    type Err = WordError;

    /// Reads `0+3+,0-3-`; spaces may stand in place of a comma, or around one. The names of families are words, too.
    fn from_str(text: &str) -> Result<Self, WordError> {
        let families = [Family::DoubleSided, Family::SingleSided, Family::PeriodDoubled];
        if let Some(family) = families.into_iter().find(|family| family.name() == text.trim())
            && let Some(word) = Self::of_family(family)
        {
            return Ok(word);
        }
        let mut instants = Vec::new();
        let mut impacts = 0;
        for part in text.split(',') {
            let mut groups = part.split_whitespace().peekable();
            if groups.peek().is_none() {
                return Err(WordError::Empty { instant: instants.len() + 1 });
            }
            for group in groups {
                let letters = letters_of(group)?;
                impacts += letters.len();
                if impacts > MAX_IMPACTS {
                    let impacts = text.matches(['+', '-']).count();
                    return Err(WordError::TooMany { impacts });
                }
                instants.push(letters);
            }
        }
        Self::new(instants)
    }
}

fn letters_of(group: &str) -> Result<Vec<Letter>, WordError> {
    let mut letters = Vec::new();
    for impact in group.split_inclusive(['+', '-']) {
        let unreadable = || WordError::Unreadable { text: impact.chars().take(40).collect() };
        let (place, barrier) = if let Some(place) = impact.strip_suffix('+') {
            (place, Barrier::Upper)
        } else {
            (impact.strip_suffix('-').ok_or_else(unreadable)?, Barrier::Lower)
        };
        let number = |text: &str| {
            let digits = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
            if digits { text.parse::<usize>().map_err(|_| unreadable()) } else { Err(unreadable()) }
        };
        let (site, layer) = match place.split_once(':') {
            None => (number(place)?, 0),
            Some((site, layer)) => (number(site)?, number(layer)?),
        };
        letters.push(Letter { site, layer, barrier });
    }
    Ok(letters)
}

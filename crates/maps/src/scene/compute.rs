//! `[compute]` of a scene file: what to find at each point.

use std::ops::Range;

use serde::Deserialize;
use toml::Spanned;
use vibrochain_breather::{Family, Word};
use vibrochain_floquet::Tolerance;
use vibrochain_lattice::{Model, Short};

use crate::cell::{SYMMETRIC, Task};
use crate::error::MapError;
use crate::scene::source::Source;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ComputeTable {
    pub(super) families: Spanned<Vec<Spanned<String>>>,
    #[serde(default)]
    pub(super) stability: bool,
    pub(super) threshold: Option<Spanned<f64>>,
    pub(super) collisions: Option<Spanned<bool>>,
    #[serde(default)]
    pub(super) impulse: bool,
}

impl Source<'_> {
    /// A word of this chain, in its canonical form.
    fn word(&self, text: &str, span: Range<usize>, model: &Model) -> Result<Word, MapError> {
        if !text.contains(['+', '-']) || text.contains(|c: char| c.is_alphabetic()) {
            let message = format!(
                "`{text}` is not a family: give \"double-sided\" (or \"{SYMMETRIC}\"), \"single-sided\" or both, or impact words as \"0+3+,0-3-\""
            );
            return Err(self.error(span, message));
        }
        let word: Word = text.parse().map_err(|error| self.error(span.clone(), error))?;
        word.check(&model.chain().layout()).map_err(|error| self.error(span.clone(), error))?;
        if model.is_conservative() && word.instants().len() > 2 {
            let message = format!(
                "the word {word} cannot be searched for: without force and losses only words of one or two instants determine their times"
            );
            return Err(self.error(span, message));
        }
        Ok(word.canonical(model))
    }

    pub(super) fn task(&self, table: &ComputeTable, model: &Model) -> Result<Task, MapError> {
        let (mut families, mut words, mut symmetric) = (Vec::new(), Vec::new(), false);
        for name in table.families.get_ref() {
            let family = match name.get_ref().as_str() {
                "double-sided" => Family::DoubleSided,
                SYMMETRIC => {
                    symmetric = true;
                    Family::DoubleSided
                }
                "single-sided" => Family::SingleSided,
                "period-doubled" => Family::PeriodDoubled,
                other => {
                    let word = self.word(other, name.span(), model)?;
                    // On a ring all sites are alike; elsewhere a family is the word at site 0.
                    let of_family = |family: &Family| {
                        model.chain().is_ring()
                            || Word::of_family(*family).is_some_and(|own| own.canonical(model) == word)
                    };
                    match word.family().filter(of_family) {
                        Some(family) => family,
                        None if words.contains(&word) => {
                            return Err(self.error(name.span(), format!("the word {word} is given twice: remove one")));
                        }
                        None => {
                            words.push(word);
                            continue;
                        }
                    }
                }
            };
            if family == Family::PeriodDoubled {
                let message = "period-doubled orbits have no class on a map: leave them out here and look at single points with `mapgen orbit --family period-doubled`";
                return Err(self.error(name.span(), message));
            }
            if families.contains(&family) {
                return Err(self.error(name.span(), format!("{} is given twice: remove one", family.name())));
            }
            families.push(family);
        }
        if families.is_empty() && words.is_empty() {
            let message = "families is empty: give \"double-sided\", \"single-sided\" or both, or impact words";
            return Err(self.error(table.families.span(), message));
        }
        words.sort();
        // A fixed order, so that equal scenes give equal tables.
        families.sort_by_key(|family| *family == Family::SingleSided);
        let tolerance = match &table.threshold {
            None => Tolerance::Rounding,
            Some(threshold) => {
                let span = threshold.span();
                if !table.stability {
                    return Err(self.error(span, "threshold needs stability = true: it decides what counts as stable"));
                }
                tolerance_from(*threshold.get_ref()).map_err(|message| self.error(span, message))?
            }
        };
        let asked = table.collisions.as_ref().filter(|collisions| *collisions.get_ref());
        if let Some(span) = asked.filter(|_| !table.stability).map(Spanned::span) {
            return Err(self.error(span, "collisions need stability = true: unstable orbits come from them"));
        }
        let (stability, impulse) = (table.stability, table.impulse);
        Ok(Task { families, words, symmetric, stability, tolerance, collisions: asked.is_some(), impulse })
    }
}

/// The tolerance of a threshold given by the user, or what is wrong with it.
pub fn tolerance_from(threshold: f64) -> Result<Tolerance, String> {
    if threshold.is_finite() && threshold >= 0.0 {
        Ok(Tolerance::Excess(threshold))
    } else {
        Err(format!("threshold = {} is out of range: give a finite excess per period of 0 or more", Short(threshold)))
    }
}

//! Orbits of a word under a force, followed from masses without coupling.
//!
//! Without coupling each mass that is hit swings on its own, and the families have all its orbits; the force tells when each hits. Every
//! combination of them that hits in the order of the word is a start.

use vibrochain_lattice::{Barrier, Model};

use crate::alone::{self, Alone, Beat};
use crate::completeness::Completeness;
use crate::enumeration::combinations;
use crate::error::{BreatherError, NoBreather, Unsearched};
use crate::finder::{Finder, Found};
use crate::followed::{follow, with_part};
use crate::side_by_side::{list, orbit_of, side_by_side};
use crate::word::Word;

/// The most starts that are followed; each takes some milliseconds.
pub(crate) const MOST_STARTS: usize = 1024;

/// The sites of a word of one row that are hit, each with the barriers it meets, in turn.
pub(crate) fn parts(word: &Word) -> Vec<(usize, Vec<Barrier>)> {
    let barriers = |site| word.letters().filter(|letter| letter.site == site).map(|letter| letter.barrier).collect();
    word.places().into_iter().map(|(_, site)| (site, barriers(site))).collect()
}

/// The same motion begun in another period of the force is the same orbit; whether this beginning is the one that is listed. One that
/// repeats sooner is an orbit of fewer periods.
fn is_first(chosen: &[&Alone], periods: u32) -> bool {
    let later = |by: u32| chosen.iter().map(move |alone| (alone.later + by) % (periods / alone.repeats));
    (1..periods).all(|by| later(0).lt(later(by)))
}

/// All orbits of `word`, of one row, in so many periods of the force, that can be followed to the model's coupling.
pub(crate) fn find(
    finder: &mut Finder,
    model: &Model,
    (word, periods): (&Word, u32),
    found: &mut Found,
) -> Result<(), BreatherError> {
    // A point where no motion is defined has no answer, whatever leads there.
    let _ = model.steady()?;
    finder.prepare(model, model.omega() / f64::from(periods))?;
    if model.chain().gamma1() == 0.0 {
        let reason = NoBreather::NotSearched(Unsearched::Unheld);
        found.completeness = Completeness::not_reached(reason);
        return Ok(());
    }
    let parts = parts(word);
    let mut solutions = Vec::new();
    for (_, barriers) in &parts {
        match alone::under_force(model, barriers, periods)? {
            Ok(list) => solutions.push(list),
            Err(reason) => {
                found.completeness = Completeness::not_reached(reason);
                return Ok(());
            }
        }
    }
    let uncoupled = with_part(model, 0.0)?;
    let product = solutions.iter().try_fold(1_usize, |product, list| product.checked_mul(list.len()));
    let all = product.unwrap_or(usize::MAX);
    let mut starts = 0;
    for choice in combinations(solutions.iter().map(Vec::len).collect()).take(MOST_STARTS) {
        let chosen: Vec<&Alone> = choice.iter().zip(&solutions).map(|(&i, list)| &list[i]).collect();
        if !is_first(&chosen, periods) {
            continue;
        }
        let masses: Vec<(usize, Vec<Beat>)> =
            parts.iter().zip(&chosen).map(|((site, _), alone)| (*site, alone.beats.clone())).collect();
        let Some((first, hits)) = side_by_side(word, &masses) else { continue };
        let psi = first * f64::from(periods) * model.period();
        if let Some(start) = orbit_of(&uncoupled, periods, psi, hits)? {
            starts += 1;
            list(follow(&start, model, &finder.stop)?, found);
        }
    }
    found.completeness = Completeness::followed(found.orbits.len(), starts, all.saturating_sub(MOST_STARTS));
    Ok(())
}

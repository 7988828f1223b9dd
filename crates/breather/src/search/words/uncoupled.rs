//! Orbits of a word under a force, followed from masses without coupling.
//!
//! Without coupling each mass that is hit swings on its own, and the families have all its orbits; the force tells when each hits. Every
//! combination of them that hits in the order of the word is a start.

use vibrochain_lattice::{Barrier, Model};

use crate::error::{BreatherError, NoBreather, Unsearched};
use crate::search::finder::Finder;
use crate::search::orbit_list::OrbitList;
use crate::search::words::coupling_continuation::{Effort, follow, with_part};
use crate::search::words::isolated_mass::{self, Alone, Beat};
use crate::search::words::superpose::{list, orbit_of, superpose};
use crate::word::Word;
use crate::word::enumeration::combinations;

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

/// Adds the orbits of `word`, of one row, in so many periods of the force, that can be followed to the model's coupling: how many starts were
/// followed, and how many are left; or why there is nothing to follow. `finder` is prepared for these periods.
pub(crate) fn find(
    finder: &Finder,
    model: &Model,
    (word, periods): (&Word, u32),
    found: &mut OrbitList,
) -> Result<Result<(usize, usize), NoBreather>, BreatherError> {
    if model.chain().gamma1() == 0.0 {
        return Ok(Err(NoBreather::NotSearched(Unsearched::Unheld)));
    }
    let parts = parts(word);
    let (mut solutions, mut missing) = (Vec::new(), 0);
    for (_, barriers) in &parts {
        match isolated_mass::under_force(model, barriers, periods, &finder.stop)? {
            Ok((list, open)) => {
                solutions.push(list);
                missing += open;
            }
            Err(reason) => return Ok(Err(reason)),
        }
    }
    let uncoupled = with_part(model, 0.0)?;
    let product = solutions.iter().try_fold(1_usize, |product, list| product.checked_mul(list.len()));
    let (mut starts, mut left) = (0, product.unwrap_or(usize::MAX));
    let mut effort = Effort::until(&finder.stop);
    for choice in combinations(solutions.iter().map(Vec::len).collect()).take(MOST_STARTS) {
        if effort.is_spent() {
            break;
        }
        left -= 1;
        let chosen: Vec<&Alone> = choice.iter().zip(&solutions).map(|(&i, list)| &list[i]).collect();
        if !is_first(&chosen, periods) {
            continue;
        }
        let masses: Vec<(usize, Vec<Beat>)> =
            parts.iter().zip(&chosen).map(|((site, _), alone)| (*site, alone.beats.clone())).collect();
        let Some((first, hits)) = superpose(word, &masses) else { continue };
        let psi = first * f64::from(periods) * model.period();
        if let Some(start) = orbit_of(&uncoupled, periods, psi, hits)? {
            starts += 1;
            list(follow(&start, model, &mut effort)?, found);
        }
    }
    Ok(Ok((starts, unfinished(found, left.saturating_add(missing)))))
}

/// So many starts were left, and with them branches that were lost, or left for want of work: they may lead here.
pub(crate) fn unfinished(found: &OrbitList, left: usize) -> usize {
    let lost = found.ended.iter().filter(|ended| !ended.by.is_known()).count();
    left.saturating_add(lost)
}

#[cfg(test)]
mod tests {
    use vibrochain_lattice::{Point, Stop};

    use super::*;
    use crate::search::completeness::Completeness;
    use crate::search::finder::Scope;
    use crate::search::words::ended::End;

    #[test]
    fn a_branch_that_is_left_for_want_of_work_leaves_the_list_open() {
        let ring = Point::ring(4).gamma1(0.14).omega(0.91).asymmetry(0.24).amplitude(0.75).restitution(0.9);
        let model = |gamma2: f64| ring.gamma2(gamma2).model().unwrap();
        let (mut finder, mut found) = (Finder::new(4), OrbitList::default());
        finder.find_word(&model(1e-3), &"0-2-".parse().unwrap(), Scope::All, &mut found).unwrap();
        let start = found.orbits.pop().unwrap();
        found = OrbitList::default();
        // Enough for some steps.
        let mut effort = Effort::until(&Stop::default());
        effort.left = 16 * 100;
        list(follow(&start, &model(0.08), &mut effort).unwrap(), &mut found);
        assert!(effort.is_spent() && found.orbits.is_empty() && found.ended[0].by == End::Unfinished, "{found:?}");
        let open = Completeness::followed(0, 1, unfinished(&found, 0));
        assert_eq!(open, Completeness::Followed { starts: 1, left: 1 });
        assert!(open.reason().is_none() && !open.is_established() && open.open() == (0, 1));
    }
}

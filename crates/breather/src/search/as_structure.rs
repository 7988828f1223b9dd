//! Words of a lattice asked of it as a structure, whose contacts are the masses that are hit.

use smallvec::SmallVec;
use vibrochain_lattice::{Barrier, ImpulseResponse, Model, Stop};

use crate::error::BreatherError;
use crate::orbit::{Draft, Family, Hit};
use crate::search::completeness::Searched;
use crate::search::finder::Scope;
use crate::structures::model::StructureModel;
use crate::structures::orbit::StructureOrbit;
use crate::structures::search::Listed;
use crate::word::{Letter, Word};

/// The orbits of a word, of contacts, of the lattice with contacts at these lists of masses. `None` where it cannot be asked for.
pub(crate) fn among(
    model: &Model,
    contacts: &[Vec<usize>],
    (word, periods): (&Word, u32),
    wanted: Scope,
    stop: &Stop,
) -> Result<Option<Listed>, BreatherError> {
    let listed = |structure: StructureModel| structure.listed(word, periods, wanted);
    match StructureModel::of_lattice(model, contacts, stop).and_then(listed) {
        Ok(searched) => Ok(Some(searched)),
        Err(stopped @ BreatherError::Stopped(_)) => Err(stopped),
        Err(_) => Ok(None),
    }
}

/// The orbits of one mass, number `home`, that hits these barriers in turn in so many periods of the force, and what is known of their list.
/// `response` is that of the orbits' period; drafts are of mass 0.
pub(crate) fn of_one_mass(
    (model, response, home): (&Model, &ImpulseResponse, usize),
    (family, barriers, periods): (Family, &[Barrier], u32),
    wanted: Scope,
    stop: &Stop,
) -> Result<(Vec<Draft>, Searched), BreatherError> {
    let word = Word::new(barriers.iter().map(|barrier| vec![Letter::new(0, *barrier)]).collect())?;
    let cut_short = Searched { exhausted: 1, ..Searched::default() };
    let Some(Listed { orbits, searched, .. }) = among(model, &[vec![home]], (&word, periods), wanted, stop)? else {
        return Ok((Vec::new(), cut_short));
    };
    let searched = if searched.partial.is_some() { cut_short } else { searched };
    let steady = model.steady()?.at(home);
    let half = 0.5 * response.period();
    let draft = |orbit: &StructureOrbit| {
        let impacts = orbit.impacts();
        // A doubled orbit begins with the longer flight.
        let turned = periods == 2 && orbit.phi().is_some_and(|phi| phi < half);
        let (start, count) = (usize::from(turned), impacts.len());
        let since = |time: f64| (time - impacts[start].time).rem_euclid(orbit.period());
        let hit = |i: usize| {
            let one = &impacts[(start + i) % count];
            Hit::new(0, one.barrier, since(one.time), one.impulse)
        };
        let hits: SmallVec<[Hit; 2]> = (0..count).map(hit).collect();
        let repeat = model.period() / f64::from(model.force().repetitions());
        let psi = (orbit.psi().unwrap_or(0.0) + impacts[start].time).rem_euclid(repeat);
        let felt = |hit: &Hit| hit.impulse * response.jet_from_half(hit.time - half).value;
        // Where the first impact is, less what moves there.
        let moved = steady.jet(psi)[0] + hits.iter().map(felt).sum::<f64>();
        let held = model.barrier(hits[0].barrier) - moved;
        Draft::new(response, (family, periods), psi, hits, held)
    };
    Ok((orbits.iter().map(draft).collect(), searched))
}

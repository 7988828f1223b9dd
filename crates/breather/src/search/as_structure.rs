//! Words of a lattice asked of it as a structure, whose contacts are the masses that are hit.

use smallvec::SmallVec;
use vibrochain_lattice::{Barrier, ImpulseResponse, Model, Stop};

use crate::error::BreatherError;
use crate::orbit::{Draft, Family, Hit};
use crate::search::completeness::Searched;
use crate::search::finder::Scope;
use crate::structures::error::StructureOrbitError;
use crate::structures::model::StructureModel;
use crate::structures::orbit::StructureOrbit;
use crate::structures::search::{StructureFound, StructureSearch};
use crate::word::{Letter, Word};

impl Searched {
    /// What the search for a structure's orbits has done; or how many starts it took, where others may exist.
    pub(crate) fn by(search: StructureSearch) -> Result<Self, usize> {
        match search {
            StructureSearch::ClosedForm { unresolved } => Ok(Self { unresolved, ..Self::default() }),
            StructureSearch::Enclosures { intervals, unresolved } => {
                Ok(Self { intervals, unresolved, ..Self::default() })
            }
            StructureSearch::BranchAndPrune { boxes, unresolved } => Ok(Self { boxes, unresolved, ..Self::default() }),
            StructureSearch::HalfPeriod => Ok(Self { unresolved: 1, ..Self::default() }),
            StructureSearch::Scan { places: starts } | StructureSearch::Starts { starts } => Err(starts),
        }
    }
}

/// The orbits of a word, of contacts, of the lattice with contacts at these lists of masses. `None` where it cannot be asked for.
pub(crate) fn among(
    model: &Model,
    contacts: &[Vec<usize>],
    (word, periods): (&Word, u32),
    wanted: Scope,
    stop: &Stop,
) -> Result<Option<StructureFound>, BreatherError> {
    let all = if wanted.candidates() { StructureModel::candidates } else { StructureModel::orbits };
    match StructureModel::of_lattice(model, contacts, stop).and_then(|structure| all(&structure, word, periods)) {
        Ok(searched) => Ok(Some(searched)),
        Err(StructureOrbitError::Stopped(stopped)) => Err(stopped.into()),
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
    let Some(StructureFound { orbits, search, .. }) = among(model, &[vec![home]], (&word, periods), wanted, stop)?
    else {
        return Ok((Vec::new(), Searched { exhausted: 1, ..Searched::default() }));
    };
    let searched = Searched::by(search).unwrap_or(Searched { exhausted: 1, ..Searched::default() });
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

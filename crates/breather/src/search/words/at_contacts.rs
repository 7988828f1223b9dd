//! Orbits of a word under a force: those of the lattice as a structure whose contacts are the masses that are hit.
//!
//! Of one impact, of two and of three at as many instants these lists are proved complete; of longer words they are what starts lead to.

use std::sync::Arc;

use vibrochain_lattice::{ModalStructure, Model};

use crate::equations::newton::{STEPS, polish};
use crate::error::{BreatherError, NoBreather};
use crate::orbit::{Hit, Orbit};
use crate::search::completeness::Searched;
use crate::search::finder::{Finder, OrbitList, Scope};
use crate::search::words::superpose::list;
use crate::structures::error::StructureOrbitError;
use crate::structures::model::StructureModel;
use crate::structures::orbit::StructureOrbit;
use crate::structures::search::{StructureFound, StructureSearch, structure_candidates, structure_orbits};
use crate::word::{Letter, Word};

/// What a search among a structure's orbits tells of its list.
pub(crate) enum Outcome {
    /// The list holds all orbits, but for what is told.
    Proved(Searched),
    /// It holds those that so many starts have led to.
    Started(usize),
}

/// Lists the orbits of `word`, of one row, in so many periods of the force. `finder` is prepared for these.
pub(crate) fn find(
    finder: &mut Finder,
    model: &Model,
    (word, periods): (&Word, u32),
    wanted: Scope,
    found: &mut OrbitList,
) -> Result<Outcome, BreatherError> {
    // Impacts at one instant have more conditions than unknowns.
    if word.instants().iter().any(|letters| letters.len() > 1) {
        return Ok(Outcome::Started(0));
    }
    let masses: Vec<usize> = word.places().into_iter().map(|(_, site)| site).collect();
    let all = if wanted.candidates() { structure_candidates } else { structure_orbits };
    let searched = match structure(model, &masses, finder) {
        Ok(structure) => all(&structure, &at_contacts(word, &masses)?, periods),
        Err(error) => Err(error),
    };
    let StructureFound { orbits, search, .. } = match searched {
        Ok(searched) => searched,
        Err(StructureOrbitError::Stopped(stopped)) => return Err(stopped.into()),
        Err(_) => return Ok(Outcome::Started(0)),
    };
    let mut lost = 0;
    for orbit in &orbits {
        match orbit_of(finder, model, (&masses, periods), orbit)? {
            Some(orbit) => list(Ok(orbit), found),
            None => lost += 1,
        }
    }
    let reason = found.orbits.is_empty().then_some(NoBreather::NothingPushes);
    let proved = Searched { listed: found.orbits.len(), lost, reason, ..Searched::default() };
    Ok(match search {
        StructureSearch::ClosedForm { unresolved } => Outcome::Proved(Searched { unresolved, ..proved }),
        StructureSearch::Enclosures { intervals, unresolved } => {
            Outcome::Proved(Searched { intervals, unresolved, ..proved })
        }
        StructureSearch::BranchAndPrune { boxes, unresolved } => {
            Outcome::Proved(Searched { boxes, unresolved, ..proved })
        }
        StructureSearch::HalfPeriod => Outcome::Proved(Searched { unresolved: 1, ..proved }),
        StructureSearch::Scan { places: starts } | StructureSearch::Starts { starts } => Outcome::Started(starts),
    })
}

/// The lattice with contacts at these masses.
fn structure(model: &Model, masses: &[usize], finder: &Finder) -> Result<StructureModel, StructureOrbitError> {
    let structure: ModalStructure = model.structure(masses)?;
    Ok(StructureModel::new(Arc::new(structure), model.omega())?.until(&finder.stop))
}

/// The word with numbers of contacts in place of masses.
fn at_contacts(word: &Word, masses: &[usize]) -> Result<Word, BreatherError> {
    let of = |letter: &Letter| Letter::new(masses.partition_point(|&mass| mass < letter.site), letter.barrier);
    Ok(Word::new(word.instants().iter().map(|letters| letters.iter().map(of).collect()).collect())?)
}

/// The chain's orbit of these impacts, if rounding has left one.
fn orbit_of(
    finder: &mut Finder,
    model: &Model,
    (masses, periods): (&[usize], u32),
    orbit: &StructureOrbit,
) -> Result<Option<Orbit>, BreatherError> {
    let hits: Vec<Hit> =
        orbit.impacts().iter().map(|one| Hit::new(masses[one.contact], one.barrier, one.time, one.impulse)).collect();
    let mut orbit = Orbit::from_impulses(model, periods, orbit.psi().unwrap_or(0.0), &hits)?;
    polish(&mut orbit, STEPS, &finder.response, &mut finder.motion);
    Ok(Some(orbit).filter(Orbit::is_sound))
}

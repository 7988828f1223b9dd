//! Orbits of a word under a force: those of the lattice as a structure whose contacts are the masses that are hit.
//!
//! Of one impact, of two and of three at as many instants these lists are proved complete; of longer words they are what starts lead to.

use vibrochain_lattice::Model;

use crate::equations::newton::{STEPS, polish};
use crate::error::{BreatherError, NoBreather};
use crate::orbit::{Hit, Orbit};
use crate::search::as_structure::among;
use crate::search::completeness::Searched;
use crate::search::finder::{Finder, OrbitList, Scope};
use crate::search::words::superpose::list;
use crate::structures::orbit::StructureOrbit;
use crate::structures::search::StructureFound;
use crate::word::Word;

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
    let Some(StructureFound { orbits, search, .. }) = among(model, &masses, (word, periods), wanted, &finder.stop)?
    else {
        return Ok(Outcome::Started(0));
    };
    let searched = Searched::by(search);
    let mut lost = 0;
    for orbit in &orbits {
        match orbit_of(finder, model, (&masses, periods), orbit)? {
            Some(orbit) => list(Ok(orbit), found),
            None => lost += 1,
        }
    }
    Ok(match searched {
        Ok(searched) => {
            let reason = found.orbits.is_empty().then_some(NoBreather::NothingPushes);
            Outcome::Proved(Searched { listed: found.orbits.len(), lost, reason, ..searched })
        }
        Err(starts) => Outcome::Started(starts),
    })
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

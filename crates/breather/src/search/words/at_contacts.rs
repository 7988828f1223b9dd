//! Orbits of a word under a force: those of the lattice as a structure whose contacts are the masses that are hit.
//!
//! Of one instant, of two and of three these lists are proved complete; of longer words they are what starts lead to. Masses that a symmetry of the
//! lattice and the word has hit at one instant are one contact. Where their impulses follow from the times nothing but symmetric orbits has these
//! instants; impacts at one instant that no symmetry makes alike have more conditions than unknowns.

use vibrochain_lattice::{Model, Stop};

use crate::error::{BreatherError, NoBreather};
use crate::orbit::{Hit, Impact, Orbit};
use crate::search::as_structure::among;
use crate::search::completeness::{Partial, Searched};
use crate::search::finder::{Finder, Scope};
use crate::search::orbit_list::OrbitList;
use crate::search::words::superpose::list;
use crate::structures::orbit::ContactOrbit;
use crate::structures::search::Listed;
use crate::word::{Letter, Word};

/// Equations whose reciprocal condition is below this are singular to rounding.
const SINGULAR: f64 = 1e-12;

/// What a search among a structure's orbits tells of its list.
pub(crate) enum Outcome {
    /// The list holds all orbits, but for what is told.
    Proved(Searched),
    /// It holds those that so many starts have led to.
    Started(usize),
}

/// Lists the orbits of `word`, which is `row` if all is counted in one row, in so many periods of the force. `finder` is prepared for these.
pub(crate) fn find(
    finder: &mut Finder,
    model: &Model,
    (word, row, periods): (&Word, &Word, u32),
    wanted: Scope,
    found: &mut OrbitList,
) -> Result<Outcome, BreatherError> {
    let Some(together) = Together::of(model, word, row) else { return Ok(Outcome::Started(0)) };
    let asked = (&together.word()?, periods);
    let Some(Listed { orbits, searched, .. }) = among(model, &together.contacts, asked, wanted, &finder.stop)? else {
        return Ok(Outcome::Started(0));
    };
    let (mut lost, mut unresolved) = (0, 0);
    for orbit in &orbits {
        let orbit = together.orbit(model, periods, orbit)?;
        let Some(orbit) = orbit else {
            lost += 1;
            continue;
        };
        unresolved += usize::from(!(together.is_in_sequence() || is_alone(&orbit, &finder.stop)?));
        list(Ok(orbit), found);
    }
    Ok(match searched.partial {
        None => {
            let (listed, unresolved) = (found.orbits.len(), searched.unresolved + unresolved);
            // What pulls is no orbit of the word: that none pushes is why there is none.
            let reason = (listed == 0).then_some(NoBreather::NothingPushes);
            Outcome::Proved(Searched { listed, refused: 0, lost, unresolved, reason, ..searched })
        }
        Some(Partial::Places(starts) | Partial::Starts(starts)) => Outcome::Started(starts),
        Some(Partial::HalfPeriod) => Outcome::Started(1),
    })
}

/// Whether its impulses follow from its times: another orbit of these would have others, and need not be symmetric.
fn is_alone(orbit: &Orbit, stop: &Stop) -> Result<bool, BreatherError> {
    Ok(orbit.at_contacts(stop)?.condition()?.fold > SINGULAR)
}

/// The masses of an instant, in the order of its letters.
fn masses_of(letters: &[Letter]) -> Vec<usize> {
    letters.iter().map(|letter| letter.site).collect()
}

/// A word whose impacts at one instant are all alike: one impact of masses that move together.
struct Together<'a> {
    row: &'a Word,
    /// The masses of each contact, in the order of their letters.
    contacts: Vec<Vec<usize>>,
}

impl<'a> Together<'a> {
    /// `None` where no symmetry of the lattice makes the impacts of an instant alike: they have more conditions than unknowns.
    fn of(model: &Model, word: &Word, row: &'a Word) -> Option<Self> {
        let at_once = row.instants().iter().any(|letters| letters.len() > 1);
        let on_one_side = |letters: &Vec<Letter>| letters.iter().all(|letter| letter.barrier == letters[0].barrier);
        if at_once && !(row.instants().iter().all(on_one_side) && word.is_alike(model)) {
            return None;
        }
        let mut contacts: Vec<Vec<usize>> = row.instants().iter().map(|letters| masses_of(letters)).collect();
        contacts.sort_unstable();
        contacts.dedup();
        Some(Self { row, contacts })
    }

    fn is_in_sequence(&self) -> bool {
        self.contacts.iter().all(|masses| masses.len() == 1)
    }

    /// The word with a contact in place of the masses of each instant.
    fn word(&self) -> Result<Word, BreatherError> {
        let contact = |letters: &Vec<Letter>| {
            let own = masses_of(letters);
            self.contacts.partition_point(|masses| *masses < own)
        };
        let instant = |letters: &Vec<Letter>| vec![Letter::new(contact(letters), letters[0].barrier)];
        Ok(Word::new(self.row.instants().iter().map(instant).collect())?)
    }

    /// The chain's orbit of these impacts, if rounding has left one.
    fn orbit(&self, model: &Model, periods: u32, orbit: &ContactOrbit) -> Result<Option<Orbit>, BreatherError> {
        let hits = |one: &Impact| {
            let (masses, Impact { barrier, time, impulse, .. }) = (&self.contacts[one.site], *one);
            let each = impulse / (masses.len() as f64).sqrt();
            masses.iter().map(move |&mass| Hit::new(mass, barrier, time, each)).collect::<Vec<_>>()
        };
        let hits: Vec<Hit> = orbit.impacts().iter().flat_map(hits).collect();
        let orbit = Orbit::from_impulses(model, periods, orbit.psi().unwrap_or(0.0), &hits)?;
        Ok(Some(orbit).filter(Orbit::is_sound))
    }
}

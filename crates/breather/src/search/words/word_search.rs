//! All orbits of an impact word.
//!
//! A word that is a family's name is searched for as the family, and so are two impacts of one mass under a force on one barrier. One of
//! one or two instants without force and losses has impacts at 0 and T/2, where K′ vanishes and Newton's law holds by itself: one linear
//! system (`positions`), as the closed forms of one site are; `two_instants` and `overdetermined` find those with other times.
//! All others are sought among the orbits of the lattice as a structure (`at_contacts`). Where that list is not proved, masses without coupling
//! (`uncoupled`), or with hardly any where no force tells when each hits (`phase_rule`), are followed as well.

use vibrochain_lattice::{Barrier, ImpulseResponse, Model};

use crate::error::{BreatherError, NoBreather, Unsearched};
use crate::orbit::{Draft, Family, Orbit};
use crate::search::at_point::{Sought, at_rest};
use crate::search::completeness::{Completeness, Searched};
use crate::search::families::overdetermined;
use crate::search::families::positions::Positions;
use crate::search::families::two_instants;
use crate::search::finder::{Finder, Scope};
use crate::search::orbit_list::OrbitList;
use crate::search::screens::radiation::Radiation;
use crate::search::words::at_contacts::{self, Outcome};
use crate::search::words::phase_rule;
use crate::search::words::superpose::repeats_sooner;
use crate::search::words::uncoupled;
use crate::word::Word;

/// Residuals beyond this are improved: a sound orbit stays below.
const IMPROVED: f64 = 1e-14;

/// Violations up to this are those of an orbit whose terms lose a few digits, as next to a fold.
const CONVERGED: f64 = 1e-12;

impl Finder {
    /// All orbits of a word at a point, into `found`; under a force or with losses those that [`Completeness`] speaks of. Times
    /// count from the first instant of the word. `wanted` is as for families; of a family's name the impacts are at site 0.
    ///
    /// # Errors
    /// [`BreatherError::Word`] for a site that does not exist; [`BreatherError::Resonance`].
    ///
    /// ```
    /// use vibrochain_breather::{Finder, OrbitList, Scope};
    /// use vibrochain_lattice::{Chain, Model};
    /// let model = Model::conservative(Chain::new(21, 0.2, 0.05)?, 1.5, 0.2)?;
    /// let (mut finder, mut found) = (Finder::new(21), OrbitList::default());
    /// finder.find_word(&model, &"0+1+,0-1-".parse()?, Scope::All, &mut found)?;
    /// // Neighbours in phase hit alike.
    /// let impacts = found.orbits[0].impacts();
    /// assert!((impacts[0].impulse - impacts[1].impulse).abs() < 1e-14 && impacts[0].impulse < 0.0);
    /// assert!(finder.admissibility(&found.orbits[0])?.is_physical());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn find_word(
        &mut self,
        model: &Model,
        word: &Word,
        wanted: Scope,
        found: &mut OrbitList,
    ) -> Result<(), BreatherError> {
        let doubled = !model.is_conservative() && word.family() == Some(Family::PeriodDoubled);
        self.find_in(model, word, if doubled { 2 } else { 1 }, wanted, found)
    }

    fn find_in(
        &mut self,
        model: &Model,
        word: &Word,
        force_periods: u32,
        wanted: Scope,
        found: &mut OrbitList,
    ) -> Result<(), BreatherError> {
        let layout = model.chain().layout();
        word.check(&layout)?;
        let row = &*word.in_one_row(&layout);
        let family = word.family().filter(|family| *family != Family::PeriodDoubled && model.chain().is_ring());
        let sought = match (model.is_conservative(), family) {
            (true, family) => family.map(Sought::from),
            (false, _) => sought(row, force_periods),
        };
        if let Some(sought) = sought {
            // Of a family's name on a ring the site does not matter.
            let home = if model.chain().is_ring() && word.family().is_some() { 0 } else { row.places()[0].1 };
            return self.search_at(model, sought, home, wanted, found);
        }
        *found = OrbitList { orbits: std::mem::take(&mut found.orbits), ..OrbitList::default() };
        found.orbits.clear();
        if let Some(reason) = at_rest(model).filter(|_| model.is_damped()) {
            found.completeness = reason;
        } else if !model.is_conservative() && model.amplitude() == 0.0 {
            found.completeness = Completeness::none(NoBreather::LossWithoutForce);
        } else if !model.is_conservative() {
            found.completeness = self.of_structure(model, (word, row, force_periods), wanted, found)?;
        } else if row.instants().len() > 2 && model.chain().is_uncoupled() {
            found.completeness = Completeness::not_reached(NoBreather::NotSearched(Unsearched::Uncoupled));
        } else if row.instants().len() > 2 {
            found.completeness = self.of_structure(model, (word, row, 1), wanted, found)?;
        } else {
            found.completeness = Completeness::of(&self.unforced(model, (word, row), wanted, found)?);
        }
        found.sort();
        Ok(())
    }

    /// All orbits of a word whose period is that of so many periods of the force, into `found`. `0-,0-` in two is the doubled family.
    /// Masses may repeat what they do within the word, as one that keeps the period of the force beside one that has doubled it.
    ///
    /// # Errors
    /// As [`Finder::find_word`].
    ///
    /// ```
    /// use vibrochain_breather::{Finder, OrbitList};
    /// use vibrochain_lattice::{Chain, Model, Point};
    /// // Either site may have doubled its period, or both.
    /// let point = Point::ring(9).gamma1(0.2).gamma2(0.01);
    /// let model = point.omega(1.07).asymmetry(0.6).amplitude(0.3).restitution(0.9).model()?;
    /// let mut found = OrbitList::default();
    /// Finder::new(9).find_word_over(&model, &"0-,3-,0-,3-".parse()?, 2, &mut found)?;
    /// let orbit = &found.orbits[0];
    /// assert!(orbit.force_periods() == 2 && orbit.residual() < 1e-13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn find_word_over(
        &mut self,
        model: &Model,
        word: &Word,
        force_periods: u32,
        found: &mut OrbitList,
    ) -> Result<(), BreatherError> {
        if force_periods > 1 && model.is_conservative() {
            word.check(&model.chain().layout())?;
            *found =
                OrbitList { completeness: Completeness::not_reached(NoBreather::NeedsForce), ..OrbitList::default() };
            return Ok(());
        }
        self.find_in(model, word, force_periods.max(1), Scope::All, found)
    }

    /// The orbits of a word among those of the lattice as a structure. Where that list is not proved, those that branches from masses without
    /// coupling, or with hardly any, lead to are in it, too: in two periods of the force they lead to physical ones that no start does.
    fn of_structure(
        &mut self,
        model: &Model,
        word: (&Word, &Word, u32),
        wanted: Scope,
        found: &mut OrbitList,
    ) -> Result<Completeness, BreatherError> {
        // A point where no motion is defined has no answer, whatever leads there.
        let _ = model.steady()?;
        if !model.is_damped() {
            self.prepare(model, model.omega() / f64::from(word.2))?;
        }
        let at_point = if model.chain().is_kept() || model.is_damped() {
            at_contacts::find(self, model, word, wanted, found)?
        } else {
            Outcome::Started(0)
        };
        if let Outcome::Proved(searched) = &at_point
            && searched.unresolved + searched.lost == 0
        {
            return Ok(Completeness::of(searched));
        }
        let followed = match model.is_conservative() {
            // Coupling by springs alone is followed.
            _ if model.is_damped() => Ok((0, 0)),
            true => phase_rule::find(self, model, word.1, found)?,
            false => uncoupled::find(self, model, (word.1, word.2), found)?,
        };
        let reached = found.orbits.len();
        found.orbits.retain(|orbit| !repeats_sooner(orbit));
        let listed = found.orbits.len();
        Ok(match (at_point, followed) {
            (Outcome::Started(_), _) if listed == 0 && reached > 0 => {
                Completeness::not_reached(NoBreather::RepeatsSooner)
            }
            (Outcome::Proved(searched), _) => Completeness::of(&Searched { listed, ..searched }),
            (_, Err(reason)) if listed == 0 => Completeness::not_reached(reason),
            (_, Ok((starts, left))) if listed == 0 => Completeness::followed(0, starts, left),
            (Outcome::Started(here), followed) => {
                let (starts, left) = followed.unwrap_or_default();
                Completeness::followed(listed, here + starts, left)
            }
        })
    }

    /// All orbits of a word of one or two instants without force, and what the search has done: first the one with impacts at 0 and T/2,
    /// as far as it does not repeat sooner, then those with other times.
    fn unforced(
        &mut self,
        model: &Model,
        (word, row): (&Word, &Word),
        wanted: Scope,
        found: &mut OrbitList,
    ) -> Result<Searched, BreatherError> {
        self.prepare(model, model.omega())?;
        self.zeros.clear();
        let Self { response, motion, zeros, stop, .. } = self;
        let response = &*response;
        let mut searched = Searched::default();
        let positions = match Positions::new(model, response, row) {
            Ok(positions) => positions,
            Err(reason) => return Ok(Searched { reason: Some(reason), ..searched }),
        };
        let mut assemble = |draft: Draft| -> Result<Orbit, BreatherError> {
            let orbit = Orbit::assemble(model, Some(response), motion, draft)?;
            if orbit.residual() <= IMPROVED {
                return Ok(orbit);
            }
            let refined = orbit.clone().refined_if_better(stop);
            // Where a fold or a singular matrix is near, rounding may split an instant.
            Ok(if is_in_step(&refined, row) { refined } else { orbit })
        };
        let repeats = matches!(row.instants(), [first, second] if first == second);
        match positions.draft(0.0) {
            _ if repeats => searched.reason = Some(NoBreather::RepeatsSooner),
            Ok(draft) if wanted.candidates() && !draft.is_right_signed() => searched.refused += 1,
            Ok(draft) => match assemble(draft)? {
                orbit if orbit.is_sound() => found.orbits.push(orbit),
                _ => searched.reason = Some(NoBreather::Singular),
            },
            Err(reason) => searched.reason = Some(reason),
        }
        searched.listed = found.orbits.len();
        let same = positions.same_masses();
        if row.instants().len() == 1 || wanted == Scope::Symmetric || same && two_instants::all_slower(response) {
            return Ok(searched);
        }
        let (mut radiation, alike) = (None, word.is_alike(model));
        if alike {
            let shapes = block(response, row);
            two_instants::times(response, &shapes, same, zeros);
            if wanted.candidates() && same {
                radiation = Radiation::heard(response, [shapes.iter().copied()]);
            }
        } else {
            overdetermined::search(&positions, &word.classes(model, true), wanted.candidates(), zeros);
        }
        stop.heard()?;
        searched.intervals = zeros.intervals;
        searched.exhausted = zeros.exhausted;
        // The mirror image in time of one with both instants alike is itself, begun at the other.
        let signs = if repeats { &[-1.0][..] } else { &[-1.0, 1.0] };
        let known = zeros.simple.iter().map(|delta| (delta, true));
        let places = known.chain(zeros.unresolved.iter().map(|delta| (delta, false)));
        for (delta, simple) in places.flat_map(|(delta, simple)| signs.iter().map(move |sign| (sign * delta, simple))) {
            let draft = match positions.draft(delta) {
                // Where two zeros may have merged, nothing is known of orbits.
                Ok(draft) if simple || !alike => draft,
                _ => {
                    (searched.lost, searched.unresolved) =
                        (searched.lost + usize::from(simple), searched.unresolved + usize::from(!simple));
                    continue;
                }
            };
            let radiates = || radiation.is_some_and(|radiation| !radiation.allows(of_one_mass(&draft)));
            if wanted.candidates() && (!draft.is_right_signed() || radiates()) {
                searched.refused += 1;
            } else if wanted == Scope::SymmetricCandidates {
                searched.left_out += 1;
            } else {
                match (assemble(draft)?, simple) {
                    (orbit, true) if orbit.is_sound() => found.orbits.push(orbit),
                    (orbit, false) if orbit.residual() <= CONVERGED => found.orbits.push(orbit),
                    (_, true) => searched.lost += 1,
                    // Nearly an orbit.
                    (_, false) => searched.unresolved += 1,
                }
            }
        }
        searched.listed = found.orbits.len();
        Ok(searched)
    }
}

/// One mass under a force that hits once or twice.
fn sought(row: &Word, force_periods: u32) -> Option<Sought> {
    let barriers: Vec<Barrier> = row.letters().map(|letter| letter.barrier).collect();
    if row.places().len() > 1 { None } else { Sought::of(&barriers, force_periods) }
}

/// The impacts of each instant of a word are at one time, in its order.
fn is_in_step(orbit: &Orbit, row: &Word) -> bool {
    let mut impacts = orbit.impacts().iter();
    row.instants().iter().all(|letters| {
        let at_once: Vec<_> = impacts.by_ref().take(letters.len()).collect();
        at_once.iter().zip(letters).all(|(impact, letter)| impact.site == letter.site && impact.time == at_once[0].time)
    })
}

/// What each mode has of Σ_j σ_j K_0j, 0 being the first impact of the first instant and j those of the last, all alike.
fn block(response: &ImpulseResponse, row: &Word) -> Vec<f64> {
    let (first, last) = (row.instants()[0][0], &row.instants()[row.instants().len() - 1]);
    let mut shapes = vec![0.0; response.modes()];
    for letter in last {
        let sign = if letter.barrier == last[0].barrier { 1.0 } else { -1.0 };
        let modes = response.shapes().evens(first.site, letter.site);
        shapes.iter_mut().zip(modes).for_each(|(sum, shape)| *sum += sign * shape);
    }
    shapes
}

/// Times and impulses of the mass that hits first.
fn of_one_mass(draft: &Draft) -> impl Iterator<Item = (f64, f64)> + Clone + '_ {
    let site = draft.impacts[0].site;
    draft.impacts.iter().filter(move |hit| hit.site == site).map(|hit| (hit.time, hit.impulse))
}

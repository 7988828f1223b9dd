//! All orbits of a family at a point: which closed form or enclosure finds them, and what is told of them.

use vibrochain_lattice::{Barrier, Model, Wave};

use crate::error::{BreatherError, NoBreather, Unsearched};
use crate::orbit::{Draft, Family, Impact, Orbit};
use crate::search::as_structure::{self, of_masses};
use crate::search::completeness::{Completeness, Searched};
use crate::search::families::{conservative, two_instants};
use crate::search::finder::{Finder, Scope};
use crate::search::orbit_list::OrbitList;
use crate::search::screens::forced_places;
use crate::search::screens::radiation::Radiation;
use crate::structures::search::Request;
use crate::word::{Letter, Word};

/// A residual above this is more than rounding.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// What is sought of one mass: orbits of a family, or of a word of mass 0 that no family names, in so many periods of the force.
#[derive(Debug, Clone)]
pub(crate) struct Sought {
    family: Family,
    word: Option<Word>,
    periods: u32,
}

impl From<Family> for Sought {
    fn from(family: Family) -> Self {
        let periods = if family == Family::PeriodDoubled { 2 } else { 1 };
        Self { family, word: None, periods }
    }
}

impl Sought {
    /// Under a force: one impact in any number of its periods, two on both barriers in one of them, two on one barrier in up to two.
    pub(crate) fn of(barriers: &[Barrier], periods: u32) -> Option<Self> {
        let word = Word::new(barriers.iter().map(|barrier| vec![Letter::new(0, *barrier)]).collect()).ok()?;
        let named = word.family().map(Self::from);
        match (barriers, named) {
            (_, Some(named)) if named.periods == periods => Some(named),
            ([one, other], _) if one != other || periods > 2 => None,
            ([_] | [_, _], _) => Some(Self { family: Family::Word, word: Some(word), periods }),
            _ => None,
        }
    }
}

impl Finder {
    /// As [`Finder::search`], with the impacts at another site, where sites are not alike.
    pub(crate) fn search_at(
        &mut self,
        model: &Model,
        Sought { family, word, periods }: Sought,
        home: usize,
        wanted: Scope,
        found: &mut OrbitList,
    ) -> Result<(), BreatherError> {
        found.orbits.clear();
        found.ended.clear();
        found.completeness = Completeness::default();
        self.stop.heard()?;
        self.zeros.clear();
        self.kernel_grid.clear();
        if model.is_damped() {
            return self.search_damped(model, Sought { family, word, periods }, home, wanted, found);
        }
        let conservative = model.is_conservative();
        let out_of_question = match (conservative, family) {
            (true, Family::PeriodDoubled) => Some(NoBreather::NeedsForce),
            (false, _) if model.amplitude() == 0.0 => Some(NoBreather::LossWithoutForce),
            _ => None,
        };
        if let Some(reason) = out_of_question {
            found.completeness = Completeness::none(reason);
            return Ok(());
        }
        // The closed forms without force know that sites are alike; elsewhere words have one of their own.
        if conservative && !model.chain().is_ring() {
            let Some(word) = Word::of_family(family) else {
                found.completeness = Completeness::none(NoBreather::NotSearched(Unsearched::Unnamed));
                return Ok(());
            };
            return self.find_word(model, &word, wanted, found);
        }
        let steady = match model.chain().has_walls() {
            _ if conservative => None,
            true => Some(model.steady()?.at(home)),
            false => Some(model.steady_response()?),
        };
        // A plain cosine tells in which places a map need look.
        let cosine = steady.as_ref().filter(|_| model.force().cosine_amplitude().is_some()).map(Wave::reach);
        self.prepare_at(model, model.omega() / f64::from(periods), home)?;
        let (response, motion, earlier) = (&self.response, &mut self.motion, &mut self.earlier);
        let (zeros, kernel_grid, contact, stop) =
            (&mut self.zeros, &mut self.kernel_grid, &mut self.contact, &self.stop);
        let judged = wanted.candidates() && conservative;
        let radiation = if judged { *self.radiation.get_or_insert_with(|| Radiation::of(response)) } else { None };
        let (mut failure, mut lost, mut refused) = (None, 0, 0);
        let mut add = |mut draft: Draft| {
            if home > 0 {
                draft.impacts.iter_mut().for_each(|hit| hit.site = home);
                draft.sources.iter_mut().for_each(|source| source.site = home);
            }
            let impulses = || draft.impacts.iter().map(|hit| (hit.time, hit.impulse));
            let radiates = || radiation.is_some_and(|radiation| !radiation.allows(impulses()));
            let crosses = || match (draft.impacts.as_slice(), draft.sources.as_slice()) {
                ([_], [source]) => judged && conservative::crosses(model, response, source.net_impulse),
                _ => false,
            };
            if wanted.candidates() && (!draft.is_right_signed() || radiates() || crosses()) {
                refused += 1;
                return;
            }
            std::mem::swap(motion, earlier);
            let mut assembled = Orbit::assemble(model, Some(response), motion, draft.clone());
            if let (Ok(orbit), Some(steady)) = (&mut assembled, &steady)
                && orbit.residual() > ROUNDING
                && let Some(draft) = as_structure::at_places(&draft, (model, response), steady)
                && let Ok(other) = Orbit::assemble(model, Some(response), motion, draft)
                && other.residual() < orbit.residual()
            {
                *orbit = other;
            }
            match assembled {
                Ok(mut orbit) => {
                    // Forced ones are refined already.
                    if conservative && orbit.residual() > ROUNDING && !orbit.is_reversible() {
                        orbit = orbit.refined_if_better(stop);
                    }
                    // Subnormal parameters, or a resonance nearby, can leave a solution that violates its own equations.
                    if orbit.is_sound() {
                        found.orbits.push(orbit);
                    } else {
                        lost += 1;
                    }
                }
                Err(error) => failure = Some(error),
            }
        };
        let mut searched = Searched::default();
        let word = if conservative { None } else { word.or_else(|| Word::of_family(family)) };
        let outcome = match (conservative, family, &word) {
            (true, Family::DoubleSided, _) => conservative::double_sided(model, response).map(|draft| {
                add(draft);
                if let Some(radiation) = &radiation {
                    kernel_grid.set(model, response, radiation);
                }
                match wanted {
                    Scope::All => two_instants::all(model, response, zeros, &mut add),
                    Scope::Candidates => two_instants::candidates(model, response, kernel_grid, zeros, &mut add),
                    Scope::Symmetric | Scope::SymmetricCandidates => {}
                }
            }),
            (true, Family::SingleSided, _) => conservative::single_sided(model, response).map(&mut add),
            (false, _, Some(word)) if response.static_stiffness() == 0.0 && word.is_one_sided() => {
                Err(NoBreather::NetImpulse)
            }
            (false, _, Some(word)) => {
                let narrowed = wanted.candidates() && family == Family::DoubleSided && model.chain().is_ring();
                let cosine = cosine.filter(|_| narrowed);
                let places =
                    cosine.and_then(|force| forced_places::places(kernel_grid, response, (force, model.loss())));
                zeros.intervals += places.as_ref().map_or(0, |(_, intervals)| *intervals);
                let within = places.as_ref().map(|(places, _)| &places[..]);
                let request = Request::new(word, periods, wanted).within(within);
                let at_home = (model, response, home);
                let drafts;
                (drafts, searched) = as_structure::of_one_mass(at_home, family, request, (contact, &self.stop))?;
                let none = drafts.is_empty() && searched.is_complete();
                drafts.into_iter().for_each(&mut add);
                if none { Err(searched.reason.unwrap_or(NoBreather::NoPhase)) } else { Ok(()) }
            }
            _ => Err(NoBreather::NotSearched(Unsearched::Unnamed)),
        };
        if let Some(error) = failure {
            return Err(error);
        }
        self.stop.heard()?;
        let left_out =
            if conservative && wanted == Scope::SymmetricCandidates { self.kernel_grid.places().len() } else { 0 };
        let listed = found.orbits.len();
        // A zero without an orbit.
        let zeros = self.zeros.simple.len();
        found.completeness = Completeness::of(&Searched {
            listed,
            refused: refused + searched.refused,
            lost: lost.max(zeros.saturating_sub(listed + refused)),
            intervals: self.zeros.intervals + searched.intervals,
            unresolved: self.zeros.unresolved.len() + searched.unresolved,
            exhausted: self.zeros.exhausted + searched.exhausted,
            left_out,
            reason: outcome.err(),
            ..searched
        });
        found.sort();
        Ok(())
    }

    /// The same of a lattice with dashpots: its structure's orbits, for no closed form knows of these.
    fn search_damped(
        &mut self,
        model: &Model,
        Sought { family, word, periods }: Sought,
        home: usize,
        wanted: Scope,
        found: &mut OrbitList,
    ) -> Result<(), BreatherError> {
        let Some(word) = word.or_else(|| Word::of_family(family)) else {
            found.completeness = Completeness::none(NoBreather::NotSearched(Unsearched::Unnamed));
            return Ok(());
        };
        if let Some(reason) = at_rest(model) {
            found.completeness = reason;
            return Ok(());
        }
        if model.chain().is_adrift() && word.is_one_sided() {
            found.completeness = Completeness::none(NoBreather::NetImpulse);
            return Ok(());
        }
        let request = Request::new(&word, periods, wanted);
        let (orbits, searched) = of_masses((model, &[home]), request, (&mut self.contact, &self.stop))?;
        let (mut refused, mut lost) = (searched.refused, searched.lost);
        for orbit in orbits {
            if wanted.candidates() && !orbit.impacts().iter().all(Impact::is_right_signed) {
                refused += 1;
                continue;
            }
            std::mem::swap(&mut self.motion, &mut self.earlier);
            self.motion.take_modes(&mut self.earlier);
            let orbit = orbit.into_orbit_in(Some(&mut self.motion), family)?;
            if orbit.is_sound() {
                found.orbits.push(orbit);
            } else {
                lost += 1;
            }
        }
        let listed = found.orbits.len();
        found.completeness = Completeness::of(&Searched { listed, refused, lost, ..searched });
        found.sort();
        Ok(())
    }
}

/// Why a lattice with dashpots has no orbits without a force.
pub(crate) fn at_rest(model: &Model) -> Option<Completeness> {
    if model.amplitude() > 0.0 {
        None
    } else if model.dashpots().iter().any(|dashpot| *dashpot < 0.0) {
        Some(Completeness::not_reached(NoBreather::NotSearched(Unsearched::OwnPeriod)))
    } else {
        Some(Completeness::none(NoBreather::LossWithoutForce))
    }
}

//! All orbits of a family at a point: which closed form or enclosure finds them, and what is told of them.

use vibrochain_lattice::{Barrier, ImpulseResponse, Model, Stop, Wave};

use crate::equations::newton::{STEPS, polish};
use crate::error::{BreatherError, NoBreather, Unsearched};
use crate::orbit::{Draft, Family, Orbit};
use crate::roots::interval::Zeros;
use crate::search::as_structure;
use crate::search::completeness::{Completeness, Searched};
use crate::search::families::forced_double::{self, Forced};
use crate::search::families::pattern::Pattern;
use crate::search::families::{conservative, forced_single, two_instants};
use crate::search::finder::{Finder, Scope};
use crate::search::orbit_list::OrbitList;
use crate::search::screens::forced_places;
use crate::search::screens::radiation::Radiation;
use crate::word::Word;

/// Orbits of one mass: of a family, or of two impacts that are none's.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sought {
    family: Family,
    /// Of two impacts.
    pattern: Option<Pattern>,
}

impl From<Family> for Sought {
    fn from(family: Family) -> Self {
        let pattern = match family {
            Family::DoubleSided => Some(Pattern::DOUBLE_SIDED),
            Family::PeriodDoubled => Some(Pattern::DOUBLED),
            Family::SingleSided | Family::Word => None,
        };
        Self { family, pattern }
    }
}

impl From<Pattern> for Sought {
    fn from(pattern: Pattern) -> Self {
        Self { family: pattern.family(), pattern: Some(pattern) }
    }
}

impl Finder {
    /// As [`Finder::search`], with the impacts at another site, where sites are not alike.
    pub(crate) fn search_at(
        &mut self,
        model: &Model,
        Sought { family, pattern }: Sought,
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
        // A plain cosine lets the phase be eliminated.
        let cosine = steady.as_ref().filter(|_| model.force().cosine_amplitude().is_some()).map(Wave::reach);
        self.prepare_at(model, model.omega() / f64::from(pattern.map_or(1, Pattern::periods)), home)?;
        let (response, motion, earlier) = (&self.response, &mut self.motion, &mut self.earlier);
        let (zeros, kernel_grid, stop) = (&mut self.zeros, &mut self.kernel_grid, &self.stop);
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
            match Orbit::assemble(model, response, motion, draft) {
                Ok(orbit) => {
                    found.orbits.push(orbit);
                    // Mirror-symmetric orbits come from closed forms that leave nothing to improve.
                    if let Some(orbit) = found.orbits.last_mut().filter(|orbit| !orbit.is_reversible()) {
                        polish(orbit, STEPS, response, motion);
                    }
                    // Subnormal parameters, or a resonance nearby, can leave a solution that violates its own equations.
                    if found.orbits.pop_if(|orbit| !orbit.is_sound()).is_some() {
                        lost += 1;
                    }
                }
                Err(error) => failure = Some(error),
            }
        };
        let outcome = match (family, pattern, &steady, cosine) {
            (Family::DoubleSided, _, None, _) => Some(conservative::double_sided(model, response).map(|draft| {
                add(draft);
                if let Some(radiation) = &radiation {
                    kernel_grid.set(model, response, radiation);
                }
                match wanted {
                    Scope::All => two_instants::all(model, response, zeros, &mut add),
                    Scope::Candidates => two_instants::candidates(model, response, kernel_grid, zeros, &mut add),
                    Scope::Symmetric | Scope::SymmetricCandidates => {}
                }
            })),
            (Family::SingleSided, _, None, _) => Some(conservative::single_sided(model, response).map(&mut add)),
            (Family::DoubleSided, _, Some(_), Some(force)) => {
                let narrowed = wanted.candidates() && model.chain().is_ring();
                let places =
                    if narrowed { forced_places::places(kernel_grid, response, (force, model.loss())) } else { None };
                zeros.intervals += places.map_or(0, |(_, intervals)| intervals);
                let places = places.map(|(places, _)| places);
                forced_double::double_sided(&Forced { model, response, force, is_last: false }, zeros, places, &mut add)
            }
            (Family::SingleSided, _, Some(_), Some(force)) => Some(
                forced_single::single_sided(model, response, force, Barrier::Lower)
                    .map(|drafts| drafts.into_iter().for_each(&mut add)),
            ),
            (_, Some(pattern), Some(_), Some(force)) => {
                forced_double::alike(pattern, &Forced { model, response, force, is_last: false }, zeros, &mut add)
            }
            (Family::SingleSided, ..) | (_, Some(_), ..) => None,
            _ => Some(Err(NoBreather::NotSearched(Unsearched::Unnamed))),
        };
        let (mut searched, lower) = (Searched::default(), [Barrier::Lower]);
        let barriers = pattern.as_ref().map_or(&lower[..], |pattern| pattern.barriers());
        let outcome = match outcome {
            Some(outcome) => outcome,
            None if response.static_stiffness() == 0.0 && barriers.iter().all(|barrier| *barrier == barriers[0]) => {
                Err(NoBreather::NetImpulse)
            }
            // Several harmonics, and places that E leaves open.
            None => {
                zeros.forget();
                let asked = (family, pattern, barriers);
                let (drafts, how) = among_contacts((model, response, home), asked, cosine, wanted, (zeros, stop))?;
                searched = how;
                let open = how.unresolved + how.exhausted + zeros.unresolved.len() + zeros.exhausted;
                let outcome = forced_double::outcome(drafts.len(), open);
                drafts.into_iter().for_each(&mut add);
                outcome
            }
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
            refused,
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
}

/// The orbits of one mass, number `home`, among those of the lattice as a structure, and what is known of their list. Where that leaves places open
/// under a cosine, E's list is taken if it is as long: next to a pitchfork its orbits are better, and next to a resonance of a mass without coupling
/// the flights' equations know more; what is open of theirs stays in `zeros`.
#[cold]
fn among_contacts(
    at_home: (&Model, &ImpulseResponse, usize),
    (family, pattern, barriers): (Family, Option<Pattern>, &[Barrier]),
    cosine: Option<f64>,
    wanted: Scope,
    (zeros, stop): (&mut Zeros, &Stop),
) -> Result<(Vec<Draft>, Searched), BreatherError> {
    let (model, response, _) = at_home;
    let periods = pattern.map_or(1, Pattern::periods);
    let (drafts, how) = as_structure::of_one_mass(at_home, (family, barriers, periods), wanted, stop)?;
    let (Some(force), Some(pattern)) = (cosine, pattern) else { return Ok((drafts, how)) };
    let forced = Forced { model, response, force, is_last: true };
    if how.unresolved + how.exhausted > 0 {
        let mut own = Vec::new();
        let found = |draft| own.push(draft);
        let _ = if pattern.is_alike() {
            forced_double::alike(pattern, &forced, zeros, found)
        } else {
            forced_double::double_sided(&forced, zeros, None, found)
        };
        let knows_more = how.exhausted > 0 && zeros.exhausted == 0;
        if !knows_more {
            zeros.forget();
        }
        if knows_more || own.len() >= drafts.len() {
            return Ok((own, if knows_more { Searched::default() } else { how }));
        }
    }
    // With impulses of the chain's own kernels.
    Ok((drafts.into_iter().map(|draft| forced_double::with_times_of(draft, pattern, &forced)).collect(), how))
}

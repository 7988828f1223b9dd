//! Words of a lattice asked of it as a structure, whose contacts are the masses that are hit.

use std::sync::Arc;

use smallvec::SmallVec;
use vibrochain_lattice::{ImpulseResponse, Model, Parameter, Stop, Wave};

use crate::error::{BreatherError, NoBreather};
use crate::orbit::{Draft, Family, Hit, Impact};
use crate::search::completeness::Searched;
use crate::search::finder::Scope;
use crate::structures::model::LoadedStructure;
use crate::structures::orbit::ContactOrbit;
use crate::structures::search::{Listed, Request};
use crate::word::Word;

/// The orbits of a word, of contacts, of the lattice with contacts at these lists of masses. `None` where it cannot be asked for.
pub(crate) fn among(
    model: &Model,
    contacts: &[Vec<usize>],
    (word, periods): (&Word, u32),
    wanted: Scope,
    stop: &Stop,
) -> Result<Option<Listed>, BreatherError> {
    let listed = |structure: LoadedStructure| structure.listed(Request::new(word, periods, wanted));
    unless_stopped(LoadedStructure::of_lattice(model, contacts, stop).and_then(listed))
}

/// `None` of a list that cannot be asked for.
fn unless_stopped(listed: Result<Listed, BreatherError>) -> Result<Option<Listed>, BreatherError> {
    match listed {
        Ok(listed) => Ok(Some(listed)),
        Err(stopped @ BreatherError::Stopped(_)) => Err(stopped),
        Err(_) => Ok(None),
    }
}

/// The orbits of a lattice with dashpots, among contacts at the masses that hit, which `known` is left with; and what is known of their list.
pub(crate) fn of_masses(
    (model, sites): (&Model, &[usize]),
    request: Request<'_>,
    (known, stop): (&mut Option<Box<LoadedStructure>>, &Stop),
) -> Result<(Vec<ContactOrbit>, Searched), BreatherError> {
    let structure = LoadedStructure::of_masses_from(known.as_deref(), model, sites, stop)?;
    let structure = &**known.insert(Box::new(structure));
    let Listed { orbits, mut searched, .. } = structure.listed(request)?;
    if let Some(times) = searched.too_weak {
        searched.reason = Some(NoBreather::ForceTooWeak { threshold: times * model.amplitude() });
    }
    Ok((orbits, searched))
}

/// The orbits of one mass, number `home`, that are requested of mass 0, and what is known of their list. `known` is the lattice as a structure with a
/// contact at that mass, here or elsewhere. `response` is that of the orbits' period; drafts are of mass 0.
pub(crate) fn of_one_mass(
    (model, response, home): (&Model, &ImpulseResponse, usize),
    family: Family,
    request: Request<'_>,
    (known, stop): (&mut Option<Box<LoadedStructure>>, &Stop),
) -> Result<(Vec<Draft>, Searched), BreatherError> {
    let structure = LoadedStructure::of_masses_from(known.as_deref(), &felt(model, request), &[home], stop)?;
    let structure = &**known.insert(Box::new(structure));
    let cut_short = || Searched { exhausted: 1, ..Searched::default() };
    let Some(Listed { orbits, searched, .. }) = unless_stopped(structure.listed(request))? else {
        return Ok((Vec::new(), cut_short()));
    };
    let mut searched = if searched.partial.is_some() { cut_short() } else { searched };
    if let Some(times) = searched.too_weak {
        searched.reason = Some(NoBreather::ForceTooWeak { threshold: times * model.amplitude() });
    }
    let steady = model.steady()?.at(home);
    let (half, periods) = (0.5 * response.period(), request.force_periods);
    let draft = |orbit: ContactOrbit| -> Result<Draft, BreatherError> {
        // A doubled orbit begins with the longer flight.
        let turned = periods == 2 && orbit.phi().is_some_and(|phi| phi < half);
        let orbit = if turned { orbit.begun_with(1)? } else { orbit };
        let hit = |one: &Impact| Hit::new(0, one.barrier, one.time, one.impulse);
        let hits: SmallVec<[Hit; 2]> = orbit.impacts().iter().map(hit).collect();
        let repeat = model.period() / f64::from(model.force().repetitions());
        let psi = orbit.psi().unwrap_or(0.0).rem_euclid(repeat);
        let felt = |hit: &Hit| hit.impulse * response.jet_from_half(hit.time - half).value;
        // Where the first impact is, less what moves there.
        let moved = steady.jet(psi)[0] + hits.iter().map(felt).sum::<f64>();
        let held = model.barrier(hits[0].barrier) - moved;
        Ok(Draft { at_contacts: Some(Arc::new(orbit)), ..Draft::new(response, (family, periods), psi, hits, held) })
    };
    Ok((orbits.into_iter().map(draft).collect::<Result<_, _>>()?, searched))
}

/// A stiffness below this part of ω² moves impulses, times and phases by less than rounding, as long as impulses balance.
const UNFELT: f64 = 1e-20;

/// The model without springs that are not felt: a mode that hardly turns in a period would take all digits of the equations.
fn felt(model: &Model, request: Request<'_>) -> Model {
    if request.word.is_one_sided() {
        return *model;
    }
    let most = UNFELT * model.omega() * model.omega();
    let is_unfelt = |spring: &Parameter| model.get(*spring) > 0.0 && model.get(*spring) < most;
    let unfelt = [Parameter::Gamma1, Parameter::Gamma2, Parameter::Gamma3].into_iter().filter(is_unfelt);
    unfelt.fold(*model, |model, spring| model.with(spring, 0.0).unwrap_or(model))
}

/// The impulses with which one impact of mass 0, or two, are at their barriers at their times, in kernels that keep the static part aside: of soft lattices,
/// and next to a resonance, more digits are left so. `None` of more impacts.
pub(crate) fn at_places(draft: &Draft, (model, response): (&Model, &ImpulseResponse), steady: &Wave) -> Option<Draft> {
    let (own, stiffness) = (response.dynamic_at_impulse(), response.static_stiffness());
    let left = |hit: &Hit| model.barrier(hit.barrier) - steady.jet(draft.psi + hit.time)[0];
    let mut hits = draft.impacts.clone();
    let held = match &mut hits[..] {
        [hit] => {
            let held = left(hit) / (1.0 + stiffness * own);
            hit.impulse = stiffness * held;
            held
        }
        [first, second] => {
            let other = response.jet_from_half(second.time - 0.5 * response.period()).value;
            let (one, two) = (left(first), left(second));
            let held = (one + two) / (2.0 + stiffness * (own + other));
            let apart = (one - two) / (own - other);
            first.impulse = 0.5 * (stiffness * held + apart);
            second.impulse = 0.5 * (stiffness * held - apart);
            held
        }
        _ => return None,
    };
    hits.iter()
        .all(|hit| hit.impulse.is_finite())
        .then(|| Draft::new(response, (draft.family, draft.force_periods), draft.psi, hits, held))
}

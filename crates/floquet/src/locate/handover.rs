//! The orbits that branch off at a period doubling or a pitchfork, a small step away on the side where they exist.
//!
//! They are found anew among all orbits of their family: near the bifurcation the ones nearest to the orbit that loses
//! stability, with a distance δ from half the period that shrinks like the root of the distance in the parameter. Orbits
//! that were there anyway do not.

use vibrochain_breather::{Family, Finder, Found, Orbit};
use vibrochain_lattice::Model;

use super::{Event, Search};
use crate::analyser::Analyser;
use crate::verdict::{Tolerance, Verdict};

/// An orbit that branches off.
#[derive(Debug, Clone, PartialEq)]
pub struct HandedOver {
    /// The orbit.
    pub orbit: Orbit,
    /// Whether it is physical there; `None` where that cannot be told.
    pub physical: Option<bool>,
    /// Its stability, where it can be judged.
    pub verdict: Option<Verdict>,
}

/// The orbits that branch off, at one value of the parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Handover {
    /// The value, a small step from the bifurcation.
    pub value: f64,
    /// They exist for larger values (otherwise for smaller ones).
    pub above: bool,
    /// The doubled orbit, or the asymmetric pair.
    pub orbits: Vec<HandedOver>,
}

/// δ at a quarter of the distance, over δ: a half, less what the next order does.
const ROOT: std::ops::Range<f64> = 0.4..0.6;

/// The orbits that branch off, if the family is known and one side has them.
pub(super) fn hand_over(
    orbit: &Orbit,
    search: Search,
    distance: f64,
    analyser: &mut Analyser,
    finder: &mut Finder,
) -> Option<Handover> {
    let family = match (search.event, orbit.family()) {
        (Event::PeriodDoubling, Family::SingleSided) => Family::PeriodDoubled,
        (Event::Pitchfork, Family::DoubleSided) => Family::DoubleSided,
        _ => return None,
    };
    let at = orbit.model().get(search.free);
    [1.0, -1.0].into_iter().find_map(|sign| {
        let mut branched = |distance: f64| {
            let model = orbit.model().with(search.free, at + sign * distance).ok()?;
            branched_off(orbit, &model, family, finder).filter(|orbits| !orbits.is_empty())
        };
        let (far, near) = (branched(distance)?, branched(0.25 * distance)?);
        let (far_offset, near_offset) = (offset(far.first()?), offset(near.first()?));
        if !ROOT.contains(&(near_offset / far_offset)) {
            return None;
        }
        let orbits = far.into_iter().map(|orbit| {
            let physical = finder.admissibility(&orbit).ok().map(|answer| answer.is_physical());
            let verdict = analyser.stability(&orbit, finder, Tolerance::Rounding).ok().map(|answer| answer.verdict);
            HandedOver { orbit, physical, verdict }
        });
        Some(Handover { value: at + sign * distance, above: sign > 0.0, orbits: orbits.collect() })
    })
}

/// |φ − T/2|, with the orbit's own period.
fn offset(orbit: &Orbit) -> f64 {
    orbit.phi().map_or(0.0, |phi| (phi - 0.5 * orbit.period()).abs())
}

/// The orbits of `family` with φ next to, but not at, half their period, and the impulses of `orbit`.
fn branched_off(orbit: &Orbit, model: &Model, family: Family, finder: &mut Finder) -> Option<Vec<Orbit>> {
    let mut found = Found::default();
    finder.find(model, family, &mut found).ok()?;
    let first = orbit.impacts().first()?;
    // Several families of asymmetric orbits may be near half the period; impulses tell which one it is.
    let unlike = |candidate: &Orbit| {
        let impulse = candidate.impacts().first().map_or(0.0, |impact| impact.impulse);
        (impulse / first.impulse - 1.0).abs()
    };
    let mut candidates: Vec<Orbit> =
        found.orbits.into_iter().filter(|orbit| offset(orbit) > 1e-9 * orbit.period()).collect();
    let score = |orbit: &Orbit| offset(orbit) / orbit.period() + unlike(orbit);
    let nearest = candidates.iter().map(score).min_by(f64::total_cmp)?;
    // The pair at a pitchfork are each other's mirror images: their δ agree, their impulses nearly.
    let limit = if family == Family::DoubleSided { 2.5 * nearest } else { nearest };
    let best = candidates.iter().min_by(|a, b| score(a).total_cmp(&score(b))).map(offset)?;
    candidates.retain(|orbit| score(orbit) <= limit && (offset(orbit) / best - 1.0).abs() < 1e-3);
    candidates.sort_by(|a, b| a.phi().unwrap_or(0.0).total_cmp(&b.phi().unwrap_or(0.0)));
    Some(candidates)
}

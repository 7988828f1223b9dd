//! Orbits of a word under a force, followed from masses without coupling: in γ₂ and, where there are layers, then in γ₃.
//!
//! Without coupling each mass that is hit swings on its own, and the families have all its orbits; the force tells when each hits. Every
//! combination of them that hits in the order of the word is a start.

use vibrochain_lattice::{Barrier, Chain, Model, Parameter};

use crate::branch::{Branch, BranchPoint};
use crate::completeness::Completeness;
use crate::ended::{End, Ended};
use crate::enumeration::combinations;
use crate::error::BranchError;
use crate::error::{BreatherError, NoBreather, Unsearched};
use crate::finder::{Finder, Found, Wanted};
use crate::forced_single;
use crate::orbit::{Family, Hit, Orbit, SIMULTANEOUS};
use crate::stop::Stop;
use crate::word::Word;

/// The most starts that are followed; each takes some milliseconds.
const MOST_STARTS: usize = 1024;

/// What couples masses, in the order in which it is raised from 0.
const COUPLINGS: [Parameter; 2] = [Parameter::Gamma2, Parameter::Gamma3];

/// The longest and the shortest step, where 1 is a change of coupling as large as that asked for or of the orbit of order 1.
const LONGEST: f64 = 0.1;
const SHORTEST: f64 = 1e-7;

/// Steps over a branch point, and how near an event must be to be what ended a branch.
const OVER: [f64; 3] = [1e-4, 1e-3, 1e-2];
const NEAR: f64 = 1e-3;

/// Orbits whose impulses and times differ by less are one.
const SAME: f64 = 1e-8;

/// One orbit of a mass alone: its hits by the clock of the force, in periods.
struct Alone {
    hits: Vec<(Barrier, f64, f64)>,
}

/// All orbits of one mass with impacts on these barriers a period.
fn alone(model: &Model, barriers: &[Barrier]) -> Result<Result<Vec<Alone>, NoBreather>, BreatherError> {
    let family = match barriers {
        [Barrier::Lower] => Some(Family::SingleSided),
        [Barrier::Upper] => None,
        [first, second] if first != second => Some(Family::DoubleSided),
        _ => {
            return Ok(Err(NoBreather::NotSearched(Unsearched::ManyImpacts)));
        }
    };
    let chain = Chain::new(1, model.chain().gamma1(), 0.0)?;
    let model = Model::with_force(chain, model.omega(), model.asymmetry(), model.force(), model.restitution())?;
    let mut finder = Finder::new(1);
    let mut found = Found::default();
    let in_turns = |time: f64| (time / model.period()).rem_euclid(1.0);
    if let Some(family) = family {
        finder.search(&model, family, Wanted::All, &mut found)?;
        if let Some(none) = found.completeness.reason() {
            return Ok(Err(none));
        }
        let of = |orbit: &Orbit| Alone {
            hits: (orbit.impacts().iter())
                .map(|impact| (impact.barrier, in_turns(impact.time + orbit.psi_or_zero()), impact.impulse))
                .collect(),
        };
        return Ok(Ok(found.orbits.iter().map(of).collect()));
    }
    if model.force().cosine_amplitude().is_none() {
        return Ok(Err(NoBreather::NotSearched(Unsearched::UpperHarmonics)));
    }
    finder.prepare(&model, model.omega())?;
    let force = model.force_response()?;
    Ok(forced_single::single_sided(&model, &finder.response, force, Barrier::Upper).map(|drafts| {
        let of = |draft: &crate::orbit::Draft| Alone {
            hits: draft.impacts.iter().map(|hit| (hit.barrier, in_turns(draft.psi), hit.impulse)).collect(),
        };
        drafts.iter().map(of).collect()
    }))
}

/// All orbits of `word`, of one row, that can be followed to the model's coupling.
pub(crate) fn find(finder: &mut Finder, model: &Model, word: &Word, found: &mut Found) -> Result<(), BreatherError> {
    // A point where no motion is defined has no answer, whatever leads there.
    let _ = model.steady()?;
    finder.prepare(model, model.omega())?;
    if model.chain().gamma1() == 0.0 {
        let reason = NoBreather::NotSearched(Unsearched::Unheld);
        found.completeness = Completeness::None { reason, by: None };
        return Ok(());
    }
    let sites: Vec<usize> = word.places().into_iter().map(|(_, site)| site).collect();
    let mut solutions = Vec::new();
    for &site in &sites {
        let barriers: Vec<_> =
            word.letters().filter(|letter| letter.site == site).map(|letter| letter.barrier).collect();
        match alone(model, &barriers)? {
            Ok(list) => solutions.push(list),
            Err(reason) => {
                found.completeness = Completeness::None { reason, by: None };
                return Ok(());
            }
        }
    }
    let product = solutions.iter().try_fold(1_usize, |product, list| product.checked_mul(list.len()));
    let all = product.unwrap_or(usize::MAX);
    let mut starts = 0;
    for choice in combinations(solutions.iter().map(Vec::len).collect()).take(MOST_STARTS) {
        let chosen: Vec<&Alone> = choice.iter().zip(&solutions).map(|(&i, list)| &list[i]).collect();
        if let Some(start) = together(model, word, &sites, &chosen)? {
            starts += 1;
            match follow(&start, model, &finder.stop)? {
                Ok(orbit) => {
                    if !found.orbits.iter().any(|other| is_same(other, &orbit)) {
                        found.orbits.push(orbit);
                    }
                }
                Err(ended) => found.ended.push(ended),
            }
        }
    }
    found.completeness = if found.orbits.is_empty() {
        let reason = if starts == 0 { NoBreather::NoStart } else { NoBreather::BranchesEnded };
        Completeness::None { reason, by: None }
    } else {
        Completeness::Followed { starts, left: all.saturating_sub(MOST_STARTS) }
    };
    Ok(())
}

/// The orbits of the masses alone as one orbit without coupling, if they hit in the order of the word.
fn together(model: &Model, word: &Word, sites: &[usize], chosen: &[&Alone]) -> Result<Option<Orbit>, BreatherError> {
    // A mass hits each barrier at most once.
    let at = |site: usize, barrier: Barrier| -> Option<(f64, f64)> {
        let place = sites.iter().position(|&other| other == site)?;
        chosen[place].hits.iter().find(|hit| hit.0 == barrier).map(|hit| (hit.1, hit.2))
    };
    let mut hits = Vec::new();
    let mut first = None;
    let mut last = 0.0;
    for (i, letters) in word.instants().iter().enumerate() {
        for (j, letter) in letters.iter().enumerate() {
            let Some((clock, impulse)) = at(letter.site, letter.barrier) else { return Ok(None) };
            let start = *first.get_or_insert(clock);
            let mut turn = (clock - start).rem_euclid(1.0);
            if turn > 1.0 - SIMULTANEOUS {
                turn = 0.0;
            }
            let together = (turn - last).abs() <= SIMULTANEOUS;
            let fits = if j > 0 { together } else { i == 0 || turn > last + SIMULTANEOUS };
            if !fits {
                return Ok(None);
            }
            if j > 0 {
                turn = last;
            }
            last = turn;
            hits.push(Hit::new(letter.site, letter.barrier, turn * model.period(), impulse));
        }
    }
    let uncoupled = COUPLINGS.iter().try_fold(*model, |model, &coupling| model.with(coupling, 0.0))?;
    let psi = first.unwrap_or(0.0) * model.period();
    let orbit = Orbit::from_impulses(&uncoupled, 1, psi, &hits)?;
    Ok(orbit.impacts().iter().all(crate::orbit::Impact::is_right_signed).then_some(orbit))
}

/// Follows an orbit without coupling to the model's.
fn follow(start: &Orbit, model: &Model, stop: &Stop) -> Result<Result<Orbit, Ended>, BreatherError> {
    let mut orbit = start.clone();
    for coupling in COUPLINGS {
        match follow_in(&orbit, coupling, model.get(coupling), stop)? {
            Ok(there) => orbit = there,
            ended => return Ok(ended),
        }
    }
    Ok(Ok(orbit))
}

/// Follows an orbit in one coupling, from 0 to `target`.
fn follow_in(
    start: &Orbit,
    coupling: Parameter,
    target: f64,
    stop: &Stop,
) -> Result<Result<Orbit, Ended>, BreatherError> {
    if target == 0.0 {
        return Ok(Ok(start.clone()));
    }
    let ended = |value: f64, by: End| Ok(Err(Ended { coupling, value, by }));
    let branch = |error: BranchError| match error {
        BranchError::Breather(error) => Err(error),
        _ => ended(0.0, End::Lost),
    };
    let mut along = match Branch::through(start, coupling, target) {
        Ok(along) => along,
        Err(error) => return branch(error),
    };
    let mut point = match along.start() {
        Ok(point) => point,
        Err(error) => return branch(error),
    };
    let mut step = LONGEST;
    loop {
        stop.heard()?;
        let left = (target - point.value()) / target;
        let there = left <= step * point.heading();
        let mut next = if there { along.at(&point, target) } else { along.step(&point, step) };
        if next.is_err() && step >= SHORTEST {
            step *= 0.5;
            continue;
        }
        if next.is_err() {
            // A word with a symmetry passes points where others branch off that lack it.
            let over = OVER.iter().find_map(|&length| along.step_over(&point, length).ok());
            next = over.filter(|next| next.value() < target).ok_or(BranchError::NoConvergence);
            step = OVER[0];
        }
        let Ok(next) = next else {
            let here = point.value();
            let near = along.resonance_within(&point, here + NEAR * target);
            return ended(here, near.map_or(End::Lost, |(_, resonance)| End::Resonance(resonance)));
        };
        if next.heading() <= 0.0 {
            let near = |fold: &BranchPoint| (fold.value() - point.value()).abs() < LONGEST * target;
            let there = along.fold(&next).ok().filter(near).map_or(point.value(), |fold| fold.value());
            return ended(there, End::Fold);
        }
        if let Some(site) = grazing(&next) {
            let there = grazing_value(&mut along, &point, &next);
            // Where a harmonic meets a mode all impulses vanish.
            let reach = NEAR * there;
            let resonance = along.resonance_within(&point, there + reach);
            let resonance = resonance.filter(|(value, _)| (value - there).abs() <= reach);
            let by = resonance.map_or(End::Grazing { site }, |(_, resonance)| End::Resonance(resonance));
            return ended(there, by);
        }
        if there && next.value() == target {
            return Ok(Ok(next.orbit().clone()));
        }
        point = next;
        step = (1.5 * step).min(LONGEST);
    }
}

/// The mass whose impact has lost its velocity.
fn grazing(point: &BranchPoint) -> Option<usize> {
    point.orbit().impacts().iter().find(|impact| !impact.is_right_signed()).map(|impact| impact.site)
}

/// The coupling between the two points where an impact loses its velocity.
fn grazing_value(along: &mut Branch, from: &BranchPoint, to: &BranchPoint) -> f64 {
    let (mut low, mut high) = (from.clone(), to.value());
    // Bisection: each halves what is left of a step of a tenth.
    for _ in 0..44 {
        let middle = 0.5 * (low.value() + high);
        match along.at(&low, middle) {
            Ok(point) if grazing(&point).is_none() => low = point,
            _ => high = middle,
        }
    }
    0.5 * (low.value() + high)
}

fn is_same(one: &Orbit, other: &Orbit) -> bool {
    let period = one.period();
    let close = |x: f64, y: f64| (x - y).abs() <= SAME;
    let apart = |x: f64, y: f64| (x - y).abs().min(period - (x - y).abs());
    apart(one.psi_or_zero(), other.psi_or_zero()) <= SAME * period
        && one.impacts().iter().zip(other.impacts()).all(|(one, other)| {
            one.site == other.site && close(one.impulse, other.impulse) && apart(one.time, other.time) <= SAME * period
        })
}

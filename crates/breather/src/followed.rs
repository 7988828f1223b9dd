//! A branch of a word, followed in the coupling from where it is weak or none to the model's: in γ₂ and, where there are layers, then in
//! γ₃, until there or the event that ends it.

use vibrochain_lattice::{Model, Parameter};

use crate::branch::{Branch, BranchPoint};
use crate::ended::{End, Ended};
use crate::error::{BranchError, BreatherError};
use crate::orbit::{Hit, Orbit};
use crate::stop::Stop;

/// What couples masses, in the order in which it is raised.
const COUPLINGS: [Parameter; 2] = [Parameter::Gamma2, Parameter::Gamma3];

/// The longest and the shortest step, where 1 is a change of coupling as large as that asked for or of the orbit of order 1.
const LONGEST: f64 = 0.1;
const SHORTEST: f64 = 1e-7;

/// Steps over a branch point, and how near an event must be to be what ended a branch.
const OVER: [f64; 3] = [1e-4, 1e-3, 1e-2];
const NEAR: f64 = 1e-3;

/// How far an orbit may be from where it is looked for, in units of its branch: of masses that are put side by side, and of one that
/// is followed without a tangent. The shortest of such steps, of the coupling.
const ASIDE: f64 = 0.3;
const AHEAD: f64 = 0.1;
const FINE: f64 = 1e-5;

/// A model with this part of all couplings.
pub(crate) fn with_part(model: &Model, part: f64) -> Result<Model, BreatherError> {
    let weaker = |model: Model, &coupling: &Parameter| model.with(coupling, part * model.get(coupling));
    Ok(COUPLINGS.iter().try_fold(*model, weaker)?)
}

/// Follows masses put side by side, coupled by this part of the model's, to the model. Two couplings are raised in proportion: without a
/// force there are orbits that need their ratio.
pub(crate) fn follow_from(
    rough: &Orbit,
    part: f64,
    model: &Model,
    stop: &Stop,
) -> Result<Result<Orbit, Ended>, BreatherError> {
    let both = COUPLINGS.iter().all(|&coupling| model.get(coupling) > 0.0);
    let coupling = COUPLINGS.into_iter().find(|&coupling| model.get(coupling) > 0.0).unwrap_or(Parameter::Gamma2);
    let ended = |part: f64, by: End| Ok(Err(Ended { coupling, value: part * model.get(coupling), by }));
    let near = |orbit: &Orbit, part: f64, reach: f64| -> Result<Option<Orbit>, BreatherError> {
        let model = with_part(model, part)?;
        let hits: Vec<Hit> = orbit.impacts().iter().map(Hit::from).collect();
        // What is in the way of one step is none for a shorter one.
        let Ok(rough) = Orbit::from_impulses(&model, 1, 0.0, &hits) else { return Ok(None) };
        let branch = Branch::of_symmetric(&rough, coupling, model.get(coupling));
        Ok(branch.and_then(|mut branch| branch.nearby(reach)).ok())
    };
    let Some(mut orbit) = near(rough, part, ASIDE)? else { return ended(part, End::Lost) };
    if !both {
        return follow(&orbit, model, stop);
    }
    let (mut part, mut step) = (part, LONGEST);
    while part < 1.0 {
        stop.heard()?;
        let next = (part + step).min(1.0);
        let there = near(&orbit, next, AHEAD)?;
        let turned = there.as_ref().and_then(outward);
        match (there, turned) {
            (Some(there), None) => (orbit, part, step) = (there, next, (1.5 * step).min(LONGEST)),
            _ if step > FINE => step *= 0.5,
            (_, Some(site)) => return ended(part, End::Grazing { site }),
            (None, None) => return ended(part, End::Lost),
        }
    }
    Ok(Ok(orbit))
}

/// Follows an orbit of weaker coupling to the model's.
pub(crate) fn follow(start: &Orbit, model: &Model, stop: &Stop) -> Result<Result<Orbit, Ended>, BreatherError> {
    let mut orbit = start.clone();
    for coupling in COUPLINGS {
        match follow_in(&orbit, coupling, model.get(coupling), stop)? {
            Ok(there) => orbit = there,
            ended => return Ok(ended),
        }
    }
    Ok(Ok(orbit))
}

/// Follows an orbit in one coupling, from its own to `target`.
fn follow_in(
    start: &Orbit,
    coupling: Parameter,
    target: f64,
    stop: &Stop,
) -> Result<Result<Orbit, Ended>, BreatherError> {
    if target == start.model().get(coupling) {
        return Ok(Ok(start.clone()));
    }
    let ended = |value: f64, by: End| Ok(Err(Ended { coupling, value, by }));
    let branch = |error: BranchError| match error {
        BranchError::Breather(error) => Err(error),
        _ => ended(0.0, End::Lost),
    };
    let mut along = match Branch::of_symmetric(start, coupling, target) {
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
fn outward(orbit: &Orbit) -> Option<usize> {
    orbit.impacts().iter().find(|impact| !impact.is_right_signed()).map(|impact| impact.site)
}

fn grazing(point: &BranchPoint) -> Option<usize> {
    outward(point.orbit())
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

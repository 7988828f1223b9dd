//! A branch of a word, followed in the coupling from where it is weak or none to the model's: in γ₂ and, where there are layers, in γ₃,
//! until there or the event that ends it.

use vibrochain_lattice::{Model, Parameter, Stop};

use crate::branch::{Branch, BranchPoint};
use crate::branch_error::BranchError;
use crate::error::BreatherError;
use crate::orbit::{Hit, Orbit};
use crate::search::words::ended::{End, Ended};
use crate::tracer::pace::Pace;
use crate::tracer::walk::{Stride, Walk, walk};

/// What couples masses, in the order in which it is raised.
const COUPLINGS: [Parameter; 2] = [Parameter::Gamma2, Parameter::Gamma3];

/// Steps over a branch point, and how near an event must be to be what ended a branch.
const OVER: [f64; 3] = [1e-4, 1e-3, 1e-2];
const NEAR: f64 = 1e-3;

/// How far an orbit may be from masses that are put side by side, in units of its branch.
const ASIDE: f64 = 0.3;

/// Impulses so many times those at the start grow without bound: beyond, rounding of the kernels, so many times as large, hides the
/// small sum of them that is left. With e < 1 they stay below some 2/(1 − e) times those at the start, so that a branch is followed
/// through such a place up to e = 1 − 1e-6.
const UNBOUNDED: f64 = 1e7;

/// Impulses are measured anew once they have changed by this factor.
const RESCALED: f64 = 2.0;

/// Terms of kernels that one search may sum up, of each pair of impacts and each mass for every orbit that is assembled: some ten seconds. A
/// branch of four impacts on a ring of 21 masses takes 2e5.
const MOST_WORK: u64 = 1_000_000_000;

/// What following may cost in one search, and what ends it early.
#[derive(Debug)]
pub(crate) struct Effort {
    stop: Stop,
    pub(crate) left: u64,
}

impl Effort {
    pub(crate) fn until(stop: &Stop) -> Self {
        Self { stop: stop.clone(), left: MOST_WORK }
    }

    pub(crate) fn is_spent(&self) -> bool {
        self.left == 0
    }

    /// Takes what orbits such as this one have cost.
    fn pay(&mut self, evaluations: usize, orbit: &Orbit) {
        let (impacts, sites) = (orbit.impacts().len() as u64, orbit.model().chain().sites() as u64);
        self.left = self.left.saturating_sub(evaluations as u64 * impacts * impacts * sites);
    }
}

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
    effort: &mut Effort,
) -> Result<Result<Orbit, Ended>, BreatherError> {
    effort.stop.heard()?;
    let hits: Vec<Hit> = rough.impacts().iter().map(Hit::from).collect();
    let weak = with_part(model, part)?;
    let mut raised = COUPLINGS.into_iter().filter(|&coupling| model.get(coupling) > 0.0);
    let (coupling, other) = (raised.next().unwrap_or(Parameter::Gamma2), raised.next());
    let target = model.get(coupling);
    let branch = Orbit::from_impulses(&weak, 1, 0.0, &hits).ok();
    let mut branch = branch.and_then(|rough| Branch::of_symmetric(&rough, coupling, target).ok());
    let orbit = branch.as_mut().and_then(|branch| branch.nearby(ASIDE).ok());
    effort.pay(branch.map_or(0, |branch| branch.evaluations()), rough);
    let tied = other.map(|other| (other, model.get(other) / target));
    match orbit {
        Some(orbit) => follow_in(&orbit, (coupling, tied), target, effort),
        None => Ok(Err(Ended { coupling, value: part * target, by: End::Lost })),
    }
}

/// Follows an orbit of weaker coupling to the model's.
pub(crate) fn follow(start: &Orbit, model: &Model, effort: &mut Effort) -> Result<Result<Orbit, Ended>, BreatherError> {
    let mut orbit = start.clone();
    for coupling in COUPLINGS {
        match follow_in(&orbit, (coupling, None), model.get(coupling), effort)? {
            Ok(there) => orbit = there,
            ended => return Ok(ended),
        }
    }
    Ok(Ok(orbit))
}

/// Follows an orbit in one coupling, from its own to `target`; another one may be tied to it by their ratio.
fn follow_in(
    start: &Orbit,
    (coupling, tied): (Parameter, Option<(Parameter, f64)>),
    target: f64,
    effort: &mut Effort,
) -> Result<Result<Orbit, Ended>, BreatherError> {
    if target == start.model().get(coupling) {
        return Ok(Ok(start.clone()));
    }
    let lost = |error: BranchError| match error {
        BranchError::Breather(error) => Err(error),
        _ => Ok(Err(Ended { coupling, value: 0.0, by: End::Lost })),
    };
    let mut along = match Branch::of_symmetric(start, coupling, target) {
        Ok(along) => along.until(&effort.stop),
        Err(error) => return lost(error),
    };
    along.equations.tied = tied;
    let point = match along.start() {
        Ok(point) => point,
        Err(error) => return lost(error),
    };
    let unit = start.strength();
    let mut raising = Raising { coupling, target, effort, start, along, point, unit, paid: 0 };
    walk(&mut raising, Pace::LONGEST_TO_AN_END)
}

/// One coupling on its way to the model's.
struct Raising<'a> {
    coupling: Parameter,
    target: f64,
    effort: &'a mut Effort,
    start: &'a Orbit,
    along: Branch,
    point: BranchPoint,
    /// The impulse by which impulses are measured.
    unit: f64,
    /// Orbits that are paid for.
    paid: usize,
}

/// How a step ends, if the way does.
type Raised = Result<Stride<Result<Orbit, Ended>>, BreatherError>;

impl Raising<'_> {
    fn ended(&self, value: f64, by: End) -> Stride<Result<Orbit, Ended>> {
        Stride::Ended(Err(Ended { coupling: self.coupling, value, by }))
    }

    /// Goes on to the next point, unless something has ended the branch before.
    fn reach(&mut self, next: BranchPoint) -> Stride<Result<Orbit, Ended>> {
        let (along, point, first) = (&mut self.along, &self.point, self.start.strength());
        if next.heading() <= 0.0 {
            let there = last_value(along, point, &next, |there| there.heading() > 0.0);
            return self.ended(there, End::Fold);
        }
        if let Some(site) = grazing(&next) {
            let there = last_value(along, point, &next, |there| grazing(there).is_none());
            // Where a harmonic meets a mode all impulses vanish.
            let reach = NEAR * there;
            let resonance = along.resonance_within(point, there + reach);
            let resonance = resonance.filter(|(value, _)| (value - there).abs() <= reach);
            let by = resonance.map_or(End::Grazing { site }, |(_, resonance)| End::Resonance(resonance));
            return self.ended(there, by);
        }
        let strength = next.orbit().strength();
        if strength > UNBOUNDED * first {
            // With losses they are bounded, and the branch goes on where rounding hides it.
            let elastic = self.start.model().loss() == 0.0;
            return self.ended(pole(point, &next), if elastic { End::Unbounded } else { End::Lost });
        }
        if next.value() == self.target {
            return Stride::Ended(Ok(next.orbit().clone()));
        }
        self.point = next;
        if !(self.unit / RESCALED..=self.unit * RESCALED).contains(&strength) {
            (self.point, self.unit) = (self.along.rescaled(self.point.clone()), strength);
        }
        Stride::Made { wanted: f64::INFINITY, longest: Pace::LONGEST_TO_AN_END }
    }
}

impl Walk for Raising<'_> {
    type End = Result<Orbit, Ended>;
    type Error = BreatherError;

    fn step(&mut self, length: f64) -> Raised {
        self.effort.pay(self.along.evaluations() - self.paid, self.start);
        self.paid = self.along.evaluations();
        if self.effort.is_spent() {
            return Ok(self.ended(self.point.value(), End::Unfinished));
        }
        let left = (self.target - self.point.value()) / self.target;
        let next = if left <= length * self.point.heading() {
            self.along.at(&self.point, self.target)
        } else {
            self.along.step(&self.point, length)
        };
        self.effort.stop.heard()?;
        Ok(next.map_or(Stride::Failed, |next| self.reach(next)))
    }

    /// Orbits of a symmetric word pass points at which orbits without that symmetry branch off: such a point is stepped over.
    fn leap(&mut self) -> Result<(f64, Stride<Self::End>), BreatherError> {
        let over = OVER.iter().find_map(|&length| self.along.leap(&self.point, length).ok());
        let over = over.filter(|next| next.value() < self.target);
        Ok((OVER[0], over.map_or(Stride::Failed, |next| self.reach(next))))
    }

    fn lost(&mut self) -> Result<Self::End, BreatherError> {
        let here = self.point.value();
        let near = self.along.resonance_within(&self.point, here + NEAR * self.target);
        let by = near.map_or(End::Lost, |(_, resonance)| End::Resonance(resonance));
        Ok(Err(Ended { coupling: self.coupling, value: here, by }))
    }
}

/// Where impulses are infinite that grow between the two points as near a simple pole.
fn pole(from: &BranchPoint, to: &BranchPoint) -> f64 {
    let (before, now) = (from.orbit().strength(), to.orbit().strength());
    to.value() + (to.value() - from.value()) * before / (now - before)
}

/// The mass whose impact has lost its velocity.
fn grazing(point: &BranchPoint) -> Option<usize> {
    point.orbit().impacts().iter().find(|impact| !impact.is_right_signed()).map(|impact| impact.site)
}

/// The coupling between two points up to which something holds that does at the first.
fn last_value(along: &mut Branch, from: &BranchPoint, to: &BranchPoint, holds: impl Fn(&BranchPoint) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, along.length_between(from, to));
    let mut value = from.value();
    // Bisection: each halves what is left of a step of a tenth.
    for _ in 0..44 {
        let middle = 0.5 * (low + high);
        match along.step(from, middle) {
            Ok(point) if holds(&point) => (low, value) = (middle, point.value()),
            _ => high = middle,
        }
    }
    value
}

#[cfg(test)]
mod tests;

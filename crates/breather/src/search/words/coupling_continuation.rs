//! A branch of a word, followed in the coupling from where it is weak or none to the model's: in γ₂ and, where there are layers, in γ₃,
//! until there or the event that ends it.

use std::convert::Infallible;

use vibrochain_lattice::{Model, Parameter, ParameterError, Stop};

use crate::branch_error::BranchError;
use crate::error::BreatherError;
use crate::orbit::symmetries::symmetries;
use crate::orbit::{Impact, LatticeOrbit, Orbit};
use crate::roots::bracket::zero;
use crate::search::words::ended::{End, Ended};
use crate::structures::branch::continuation::{Branch, BranchPoint};
use crate::structures::of_orbit::remembering;
use crate::structures::orbit::ContactOrbit;
use crate::tracer::pace::Pace;
use crate::tracer::solution_curve::SolutionPoint;
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

/// Impulses are measured anew once they have changed by this factor; by no less than those at the start, as they vanish where impacts graze.
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
    fn pay(&mut self, evaluations: usize, orbit: LatticeOrbit<'_>) {
        let (impacts, sites) = (orbit.impacts().len() as u64, orbit.model().chain().sites() as u64);
        self.left = self.left.saturating_sub(evaluations as u64 * impacts * impacts * sites);
    }
}

/// A model with this part of all couplings.
pub(crate) fn with_part(model: &Model, part: f64) -> Result<Model, BreatherError> {
    let weaker = |model: Model, &coupling: &Parameter| model.with(coupling, part * model.get(coupling));
    Ok(COUPLINGS.iter().try_fold(*model, weaker)?)
}

/// Follows masses put side by side, coupled by a part of the model's couplings, to the model. Two couplings are raised in proportion: without a
/// force there are orbits that need their ratio.
pub(crate) fn follow_from(
    rough: &Orbit,
    model: &Model,
    effort: &mut Effort,
) -> Result<Result<Orbit, Ended>, BreatherError> {
    effort.stop.heard()?;
    let rough = rough.lattice()?;
    let mut raised = COUPLINGS.into_iter().filter(|&coupling| model.get(coupling) > 0.0);
    let (coupling, other) = (raised.next().unwrap_or(Parameter::Gamma2), raised.next());
    let target = model.get(coupling);
    let tied = other.map(|other| (other, model.get(other) / target));
    let way = Way { coupling, tied, target };
    let settled = way.through(rough, &effort.stop).and_then(|mut branch| {
        let settled = branch.system().settle(ASIDE);
        effort.pay(branch.evaluations(), rough);
        settled.map(|()| branch)
    });
    way.raised(rough, settled, effort)
}

/// Follows an orbit of weaker coupling to the model's.
pub(crate) fn follow(start: &Orbit, model: &Model, effort: &mut Effort) -> Result<Result<Orbit, Ended>, BreatherError> {
    let mut orbit = start.clone();
    for coupling in COUPLINGS {
        let way = Way { coupling, tied: None, target: model.get(coupling) };
        let from = orbit.lattice()?;
        if way.target == from.model().get(coupling) {
            continue;
        }
        match way.raised(from, way.through(from, &effort.stop), effort)? {
            Ok(there) => orbit = there,
            ended => return Ok(ended),
        }
    }
    Ok(Ok(orbit))
}

/// One coupling, as it is raised to a value.
#[derive(Debug, Clone, Copy)]
struct Way {
    coupling: Parameter,
    /// Another one, and its ratio to this, which it keeps.
    tied: Option<(Parameter, f64)>,
    target: f64,
}

impl Way {
    /// The model at a value.
    fn model(self, of: &Model, value: f64) -> Result<Model, ParameterError> {
        let tied = self.tied.map(|(other, ratio)| (other, ratio * value));
        let set = |model: Model, (coupling, value)| model.with(coupling, value);
        std::iter::once((self.coupling, value)).chain(tied).try_fold(*of, set)
    }

    /// The branch through an orbit. Its orbits keep every symmetry that the impacts of this one have.
    fn through(self, orbit: LatticeOrbit<'_>, stop: &Stop) -> Result<Branch, BranchError> {
        let of = *orbit.model();
        let lattice = move |values: &[f64]| self.model(&of, values[0]).map_err(|error| error.to_string());
        let family = remembering(lattice, orbit.hit_sites(), stop);
        let start = ContactOrbit::of_orbit(&orbit, stop)?;
        Branch::among_symmetric(&start, &symmetries(orbit), family, (of.get(self.coupling), self.target), stop)
    }

    /// Where a branch comes to that begins with an orbit.
    fn raised(
        self,
        start: LatticeOrbit<'_>,
        branch: Result<Branch, BranchError>,
        effort: &mut Effort,
    ) -> Result<Result<Orbit, Ended>, BreatherError> {
        let begun = branch.and_then(|mut along| Ok((along.evaluations(), along.start()?, along)));
        let (paid, point, along) = match begun {
            Ok(begun) => begun,
            Err(BranchError::Breather(error)) => return Err(error),
            Err(_) => {
                let value = start.model().get(self.coupling);
                return Ok(Err(Ended { coupling: self.coupling, value, by: End::Lost }));
            }
        };
        let unit = start.strength();
        walk(&mut Raising { way: self, effort, start, along, point, unit, paid }, Pace::LONGEST_TO_AN_END)
    }
}

/// One coupling on its way to the model's.
struct Raising<'a> {
    way: Way,
    effort: &'a mut Effort,
    start: LatticeOrbit<'a>,
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
        Stride::Ended(Err(Ended { coupling: self.way.coupling, value, by }))
    }

    /// Goes on to the next point, unless something has ended the branch before.
    fn reach(&mut self, next: BranchPoint) -> Stride<Result<Orbit, Ended>> {
        let (along, point, first) = (&mut self.along, &self.point, self.start.strength());
        if next.heading() <= 0.0 {
            let there = last_value(along, point, &next, SolutionPoint::heading);
            return self.ended(there, End::Fold);
        }
        if let (..=0.0, site) = slowest(&next) {
            let there = last_value(along, point, &next, |there| slowest(there).0);
            // Where a harmonic meets a mode all impulses vanish.
            let reach = NEAR * there;
            let resonance = along.resonance_within(point, there + reach);
            let resonance = resonance.filter(|(value, _)| (value - there).abs() <= reach);
            let by = resonance.map_or(End::Grazing { site }, |(_, resonance)| End::Resonance(resonance));
            return self.ended(there, by);
        }
        let strength = strength(&next);
        if strength > UNBOUNDED * first {
            // With losses they are bounded, and the branch goes on where rounding hides it.
            let elastic = self.start.model().loss() == 0.0;
            return self.ended(pole(point, &next), if elastic { End::Unbounded } else { End::Lost });
        }
        if next.value() == self.way.target {
            return match next.orbit().of_all_masses() {
                Some(Ok(orbit)) => Stride::Ended(Ok(orbit)),
                _ => self.ended(next.value(), End::Lost),
            };
        }
        self.point = next;
        let strength = strength.max(first);
        if !(self.unit / RESCALED..=self.unit * RESCALED).contains(&strength) {
            self.point = self.along.rescaled(self.point.clone(), strength / self.unit);
            self.unit = strength;
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
        let left = (self.way.target - self.point.value()) / self.way.target;
        let next = if left <= length * self.point.heading() {
            self.along.at(&self.point, self.way.target)
        } else {
            self.along.step(&self.point, length)
        };
        self.effort.stop.heard()?;
        Ok(next.map_or(Stride::Failed, |next| self.reach(next)))
    }

    /// Orbits of a symmetric word pass points at which orbits without that symmetry branch off: such a point is stepped over.
    fn leap(&mut self) -> Result<(f64, Stride<Self::End>), BreatherError> {
        let over = OVER.iter().find_map(|&length| self.along.leap(&self.point, length).ok());
        let over = over.filter(|next| next.value() < self.way.target);
        Ok((OVER[0], over.map_or(Stride::Failed, |next| self.reach(next))))
    }

    fn lost(&mut self) -> Result<Self::End, BreatherError> {
        let here = self.point.value();
        let near = self.along.resonance_within(&self.point, here + NEAR * self.way.target);
        let by = near.map_or(End::Lost, |(_, resonance)| End::Resonance(resonance));
        Ok(Err(Ended { coupling: self.way.coupling, value: here, by }))
    }
}

/// Where impulses are infinite that grow between the two points as near a simple pole.
fn pole(from: &BranchPoint, to: &BranchPoint) -> f64 {
    let (before, now) = (strength(from), strength(to));
    to.value() + (to.value() - from.value()) * before / (now - before)
}

/// The velocity of the slowest impact, towards its barrier, and the mass that has it.
fn slowest(point: &BranchPoint) -> (f64, usize) {
    let own = |impact: &Impact| (impact.velocity_before * impact.barrier.sign(), impact.site);
    let all = point.orbit().impacts().iter().map(own);
    let (velocity, contact) = all.min_by(|one, other| one.0.total_cmp(&other.0)).unwrap_or((f64::INFINITY, 0));
    (velocity, point.orbit().model().site(contact))
}

/// The size of the largest impulse.
fn strength(point: &BranchPoint) -> f64 {
    point.orbit().impacts().iter().map(|impact| impact.impulse.abs()).fold(0.0, f64::max)
}

/// The coupling between two points up to which a number is positive that is so at the first and not at the second.
fn last_value(along: &mut Branch, from: &BranchPoint, to: &BranchPoint, number: impl Fn(&BranchPoint) -> f64) -> f64 {
    let ends = [(0.0, number(from)), (along.length_between(from, to), number(to))];
    let mut last = (0.0, from.value());
    let at = |length: f64| {
        let there = along.step(from, length).ok();
        // Where Newton's method finds no orbit, the branch has come to its end, too.
        let number = there.as_ref().map_or(ends[1].1, &number);
        if number >= 0.0 && length > last.0 {
            last = (length, there.map_or(last.1, |there| there.value()));
        }
        Ok::<f64, Infallible>(number)
    };
    if ends[0].1 > 0.0 {
        let Ok(_) = zero(ends[0], ends[1], 1.0, at);
    }
    last.1
}

#[cfg(test)]
mod tests;

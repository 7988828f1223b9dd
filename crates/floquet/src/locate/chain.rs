//! Branches of a chain's orbits: what stands at their ends and beside them; and the search for one event along one.

use vibrochain_breather::{Branch, BranchError, BranchPoint, BreatherError, Continuation, Departure, Orbit, OrbitList};
use vibrochain_lattice::{Parameter, Resonance, Stop};

use super::answer::{Answer, End, Event, LocateError, Located, Search};
use super::course::Station;
use super::follower::follow::upwards;
use super::follower::{Ended, Ends, Follower, Stretch};
use crate::bracket::zero;
use crate::events::OfChains;
use crate::verdict::Tolerance;

/// A branch that is lost this near to a resonance, as a part of the range, ends there.
const NEAR: f64 = 1e-3;

/// Impulses this much smaller than at the start, or than a mass of the ring's own speed would have, are about to vanish.
const FAINT: f64 = 1e-2;

/// Newton's steps for a peak that is nearly met.
const PEAK_STEPS: usize = 6;

/// The shortest range, as a part of the start: a fiftieth of it, and a thousandth of that, are more than rounding.
const LEAST: f64 = 1e-9;

/// Follows the branch of `orbit` both ways, to the ends of the range or to a fold or another end of the branch, and collects all events.
///
/// # Errors
/// [`LocateError`].
///
/// ```
/// use vibrochain_breather::{Family, breathers};
/// use vibrochain_floquet::{Event, Search, locate};
/// use vibrochain_lattice::{Parameter, Point};
/// let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
/// let model = ring.omega(1.07).asymmetry(0.8).amplitude(0.165).restitution(0.25).model()?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let search = Search::new(orbit, Event::PeriodDoubling, Parameter::Amplitude);
/// let answer = locate(orbit, &search)?;
/// assert!((answer.located[0].value - 0.158908086).abs() < 1e-9);
/// assert!(answer.located[0].branching.as_ref().is_some_and(|doubled| doubled.orbits.len() == 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn locate(orbit: &Orbit, search: &Search) -> Result<Answer, LocateError> {
    locate_until(orbit, search, &Stop::default())
}

/// The same, until `stop` is raised, which is looked at before every orbit and every spectrum.
///
/// # Errors
/// As [`locate`]; [`LocateError::Stopped`].
pub fn locate_until(orbit: &Orbit, search: &Search, stop: &Stop) -> Result<Answer, LocateError> {
    let Search { event, free, from, to } = *search;
    check(orbit, free, (from, to))?;
    if event != Event::Grazing && !has_moving_multipliers(orbit) {
        return Err(LocateError::NoMultiplier);
    }
    let start = orbit.model().get(free);
    let stretch = Stretch { from, to, events: vec![event], tolerance: Tolerance::Rounding, whole: false };
    let mut follower = following(Branch::through(orbit, free, to - from)?, stretch, stop);
    let up = upwards::<OfChain>(follower.branch.start()?);
    let seen = follower.look(&up)?;
    let ends = [follower.follow(&up.reversed(), seen.clone())?, follower.follow(&up, seen)?];
    // On the way a failure may be an end.
    stop.heard()?;
    let (evaluations, spectra) = (follower.evaluations(), follower.spectra());
    let event = |station: Station| match station {
        Station::Event(located) => Some(located),
        Station::Point(_) => None,
    };
    let mut located: Vec<Located> = follower.passed.into_iter().filter_map(event).collect();
    located.sort_by(|a, b| (a.value - start).abs().total_cmp(&(b.value - start).abs()));
    // A start right on the event is found from both sides.
    located.dedup_by(|b, a| (a.value - b.value).abs() <= a.error + b.error);
    Ok(Answer { located, unresolved: follower.unresolved, ends, evaluations, spectra })
}

/// Whether the branch of `orbit` can be followed over a range.
pub(super) fn check(orbit: &Orbit, free: Parameter, (from, to): (f64, f64)) -> Result<(), LocateError> {
    let start = orbit.model().get(free);
    if !(from <= start && start <= to && from < to) {
        return Err(LocateError::Range { free, start, from, to });
    }
    if to - from < LEAST * start.abs() {
        return Err(LocateError::Short { free, from, to });
    }
    for end in [from, to] {
        orbit.model().with(free, end).map_err(BreatherError::from)?;
    }
    if orbit.model().is_conservative() && matches!(free, Parameter::Amplitude | Parameter::Restitution) {
        return Err(LocateError::NoForce { free });
    }
    Ok(())
}

/// A single mass without force keeps its trivial pair alone.
pub(super) fn has_moving_multipliers(orbit: &Orbit) -> bool {
    orbit.model().chain().sites() > 1 || !orbit.model().is_conservative()
}

/// Who follows a branch.
pub(super) fn following(branch: Branch, stretch: Stretch, stop: &Stop) -> Follower<OfChain> {
    let sites = branch.sites();
    let ends = OfChain::new(sites, branch.free(), [stretch.from, stretch.to], stop);
    Follower::new(branch.until(stop), OfChains::new(sites, stop), ends, stretch, stop)
}

/// Branches of a chain's orbits.
pub(super) struct OfChain {
    free: Parameter,
    range: [f64; 2],
    /// Who looks at orbits beside the branch.
    others: OfChains,
    /// Orbits and spectra worked out beside it.
    counts: [usize; 2],
}

impl OfChain {
    pub(super) fn new(sites: usize, free: Parameter, range: [f64; 2], stop: &Stop) -> Self {
        Self { free, range, others: OfChains::new(sites, stop), counts: [0; 2] }
    }

    fn length(&self) -> f64 {
        self.range[1] - self.range[0]
    }

    fn stop(&self) -> &Stop {
        self.others.finder.stop()
    }
}

impl Ends for OfChain {
    type Watcher = OfChains;
    type System = Continuation;
    const VANISHED: f64 = 0.0;

    fn resonance_between(branch: &Branch, from: &BranchPoint, to: &BranchPoint) -> Option<(f64, Resonance)> {
        branch.resonance_within(from, to.value())
    }

    fn resonance_ahead(&self, branch: &Branch, point: &BranchPoint) -> Option<(f64, Resonance)> {
        let near = (NEAR * self.length()).copysign(point.heading());
        branch.resonance_within(point, point.value() + near)
    }

    /// Where, right ahead, the motion that the force drives alone touches the barrier of orbits with hardly any impulse left: there the impulses
    /// vanish together, the impacts merge, and the equations have no other orbit next to them.
    fn simpler_ahead(&mut self, point: &BranchPoint, first: f64) -> Option<Ended<Orbit>> {
        let (orbit, free) = (point.orbit(), self.free);
        let (impact, psi) = (orbit.impacts().first()?, orbit.psi()?);
        if orbit.strength() > FAINT * first.max(orbit.model().omega()) {
            return None;
        }
        let touch = |value: f64| {
            let model = orbit.model().with(free, value).ok()?;
            let motion = model.steady().ok()?.at(impact.site);
            // The peak, where the impact is, but for little.
            let mut t = (impact.time + psi) * model.period() / orbit.model().period();
            for _ in 0..PEAK_STEPS {
                let [_, velocity, acceleration, _] = motion.jet(t);
                t -= velocity / acceleration;
            }
            Some(impact.barrier.sign() * (motion.value(t) - model.barrier(impact.barrier)))
        };
        let from = point.value();
        let to = (from + (NEAR * self.length()).copysign(point.heading())).clamp(self.range[0], self.range[1]);
        let (low, high) = (touch(from)?, touch(to)?);
        let value = ((low > 0.0) != (high > 0.0))
            .then(|| zero((from, low), (to, high), to.abs(), |value| touch(value).ok_or(())).ok())??;
        Some(Ended { value, end: End::ImpulsesVanish, event: None })
    }

    /// The pitchfork on the symmetric branch that asymmetric orbits meet.
    fn meeting(
        &mut self,
        [point, next]: [&BranchPoint; 2],
        length: f64,
        _value: f64,
    ) -> Result<Option<Located>, LocateError> {
        let orbit = next.orbit();
        let mut found = OrbitList::default();
        self.others.finder.find(orbit.model(), orbit.family(), &mut found)?;
        let impulse = |orbit: &Orbit| orbit.impacts().first().map_or(0.0, |impact| impact.impulse);
        let half = 0.5 * orbit.period();
        let symmetric = found.orbits.iter().filter(|one| one.phi().is_some_and(|phi| (phi - half).abs() < 1e-9 * half));
        let unlike = |one: &Orbit| (impulse(one) - impulse(orbit)).abs();
        let Some(nearest) = symmetric.min_by(|a, b| unlike(a).total_cmp(&unlike(b))) else { return Ok(None) };
        // The parabola's vertex lies between the two points, and the parameter has no steeper way to it than from either.
        let steepest = point.heading().abs() + next.heading().abs();
        let scale = self.length().max(next.value().abs());
        let reach = length.abs() * steepest * scale + 1e-6 * self.length();
        let reach = reach.max(4.0 * LEAST * next.value().abs());
        let (from, to) = ((next.value() - reach).max(self.range[0]), (next.value() + reach).min(self.range[1]));
        let search = Search { event: Event::Pitchfork, free: self.free, from, to };
        let mut answer = locate_until(nearest, &search, self.stop())?;
        self.counts[0] += answer.evaluations;
        self.counts[1] += answer.spectra;
        answer.located.truncate(1);
        Ok(answer.located.pop())
    }

    fn leaving(
        &self,
        (orbit, value): (&Orbit, f64),
        departure: &Departure,
    ) -> Result<(Branch, BranchPoint), BranchError> {
        // The orbit sets the scale, however short the range is.
        let (branch, start) = Branch::leaving(orbit, departure, self.free, value.abs().max(self.length()))?;
        Ok((branch.until(self.stop()), start))
    }

    fn others(&mut self) -> &mut OfChains {
        &mut self.others
    }

    fn evaluations(&self) -> usize {
        self.counts[0]
    }

    fn spectra(&self) -> usize {
        self.counts[1]
    }
}

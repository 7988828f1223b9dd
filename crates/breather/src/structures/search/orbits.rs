//! All orbits of up to three impacts, and those of longer words that starts lead to.
//!
//! Under a load of one harmonic, (c, s) = (cos, sin) of jωψ: impulses, offsets, c and s obey linear equations once the times are given, and
//! c² + s² = 1 is left. Of one impact that is a quadratic equation; of two the zeros of one analytic function of the time between them,
//!
//! ```text
//! F(φ) = Δ²(c² + s² − 1),      Δ the determinant of the linear equations.
//! ```
//!
//! Without loads the positions give the impulses, and one of Newton's laws is left: the zeros of K₂₁′, of one contact half a period apart, and others. Of three impacts two functions of two times
//! are left.

use smallvec::SmallVec;
use vibrochain_lattice::Barrier;

use super::at_times::{Impacts, Line, Start, all_places};
use super::elimination::MOST;
use super::three_impacts::ThreeImpacts;
use super::two_impacts::Function;
use crate::error::{BreatherError, NoBreather};
use crate::orbit::{Family, Hit, Orbit, order, time_between};
use crate::search::completeness::{Completeness, Partial, Searched};
use crate::search::finder::Scope;
use crate::search::orbit_list::OrbitList;
use crate::structures::equations::Equations;
use crate::structures::model::LoadedStructure;
use crate::structures::orbit::ContactOrbit;
use crate::structures::point::Point;
use crate::word::Word;

/// Half a period apart, to this part of it, two impacts may be those that a symmetry makes alike.
const HALF: f64 = 1e-7;

/// States of modes with |1 − R| below this are unknowns where F leaves a place open. Farther away kernels are no more than a hundred times as large as
/// without the resonance; each mode more makes rectangles twice as dear.
const OPEN: f64 = 0.01;

/// Orbits of a word as a search has them.
pub(crate) struct Listed {
    /// In order of φ, those of one φ by ψ.
    pub(crate) orbits: Vec<ContactOrbit>,
    pub(crate) searched: Searched,
    periods: Option<[f64; 2]>,
}

impl Listed {
    fn told(self) -> Result<OrbitList, BreatherError> {
        let Self { orbits, searched, periods } = self;
        let completeness = Completeness::of(&Searched { listed: orbits.len(), ..searched });
        let orbits = orbits.into_iter().map(|orbit| orbit.into_orbit(Family::Word)).collect::<Result<_, _>>()?;
        Ok(OrbitList { orbits, completeness, periods, ..OrbitList::default() })
    }
}

impl LoadedStructure {
    /// All orbits of a word that are found: contacts stand in place of sites. Those of one impact or two are listed with their signs as they are,
    /// pulled or not; of longer words only those whose barriers push. An orbit is listed once, whichever impact it begins with, and not where it
    /// repeats itself sooner. Of three impacts a list takes some hundredths of a second, and up to two seconds.
    ///
    /// What is proved of two impacts does not cover those closer than 1e-4 of the period, on one barrier under a load or of two contacts without
    /// loads; of three, those of one contact that are as close.
    ///
    /// # Errors
    /// [`BreatherError`].
    pub fn orbits(&self, word: &Word, force_periods: u32) -> Result<OrbitList, BreatherError> {
        self.listed(Request::new(word, force_periods, Scope::All))?.told()
    }

    /// The same without those whose barriers pull: what a map asks for.
    ///
    /// # Errors
    /// As [`LoadedStructure::orbits`].
    pub fn candidates(&self, word: &Word, force_periods: u32) -> Result<OrbitList, BreatherError> {
        self.listed(Request::new(word, force_periods, Scope::Candidates))?.told()
    }

    /// The orbit that Newton's method leads to from impacts nearby, as [`ContactOrbit::near`] has it.
    ///
    /// # Errors
    /// As [`ContactOrbit::near`].
    pub fn orbit_near(&self, force_periods: u32, psi: f64, impacts: &[Hit]) -> Result<Orbit, BreatherError> {
        ContactOrbit::near(self, force_periods, psi, impacts)?.into_orbit(Family::Word)
    }

    /// As [`LoadedStructure::orbits`] or [`LoadedStructure::candidates`], with what the search has done.
    pub(crate) fn listed(&self, request: Request<'_>) -> Result<Listed, BreatherError> {
        let Request { word, force_periods, scope, .. } = request;
        let mut letters: SmallVec<[(usize, Barrier); 4]> = SmallVec::new();
        for letter in word.letters() {
            self.barrier(letter.site, letter.barrier)?;
            letters.push((letter.site, letter.barrier));
        }
        let equations = Equations::new(self, force_periods, letters.iter().map(|(contact, _)| *contact))?;
        if equations.forced
            && letters.iter().all(|&(contact, _)| equations.swings(contact).all(|(_, swing)| swing.norm() == 0.0))
        {
            return Err(BreatherError::Unfelt);
        }
        if letters.len() > word.instants().len() && (equations.has_time() || word.instants().len() > 2) {
            return Err(BreatherError::AtOnce);
        }
        let impacts = Impacts { equations: &equations, letters };
        if equations.self_excited && !impacts.are_excited() {
            return Err(BreatherError::LossWithoutLoad);
        }
        let periods = equations.self_excited.then(|| impacts.periods());
        if let Some(periods) = periods {
            let list = impacts.list(request, impacts.of_own_period(periods)?)?;
            let searched = |orbit: &ContactOrbit| (periods[0]..=periods[1]).contains(&orbit.period());
            return Ok(Listed {
                orbits: list.orbits.into_iter().filter(searched).collect(),
                periods: Some(periods),
                ..list
            });
        }
        let contacts: SmallVec<[usize; 4]> = impacts.letters.iter().map(|(contact, _)| *contact).collect();
        equations.off_resonance(&contacts)?;
        if letters_at_once(word) {
            return impacts.list(request, impacts.reversible(word)?);
        }
        match (impacts.letters.len(), equations.forced) {
            (2, true) => return impacts.of_two(request),
            (3, true) => {
                if let Some(opened) = equations.opened_within(OPEN, (MOST - 6) / 2) {
                    let impacts = Impacts { equations: &opened, letters: impacts.letters.clone() };
                    if let Some(starts) = impacts.proved_in_the_plane(boxes(scope)) {
                        return impacts.list(request, starts?);
                    }
                }
            }
            _ => {}
        }
        impacts.list(request, impacts.begin(scope)?)
    }
}

/// Rectangles on which three impacts may be sought, a few microseconds each: as long as starts take for a map, and a second or two for one list.
pub(super) fn boxes(scope: Scope) -> usize {
    if scope.candidates() { 40_000 } else { 400_000 }
}

/// Puts a list in order of φ, orbits of one φ by ψ.
fn sort(orbits: &mut [ContactOrbit]) {
    order::sort(orbits, |orbit| (orbit.period(), orbit.psi()), ContactOrbit::impacts, |impact| impact.time);
}

/// What is asked of a list.
#[derive(Clone, Copy)]
pub(crate) struct Request<'a> {
    pub(crate) word: &'a Word,
    pub(crate) force_periods: u32,
    scope: Scope,
    /// Where the time between two impacts may be: everywhere, or in these intervals of it, which rise.
    within: Option<&'a [[f64; 2]]>,
}

impl<'a> Request<'a> {
    pub(crate) fn new(word: &'a Word, force_periods: u32, scope: Scope) -> Self {
        Self { word, force_periods, scope, within: None }
    }

    pub(crate) fn within(self, within: Option<&'a [[f64; 2]]>) -> Self {
        Self { within, ..self }
    }
}

impl Impacts<'_> {
    /// Two impacts under a load: by F where there is one and it leaves no place open, else in the plane of φ and ψ. Next to a resonance the states of
    /// modes are among the unknowns there, and what is proved is proved however close the resonance is.
    fn of_two(&self, request: Request<'_>) -> Result<Listed, BreatherError> {
        let single = self.equations.single().is_some();
        let by_time = if single { self.proved(request.within).transpose()? } else { None };
        let by_time = by_time.map(|starts| self.list(request, starts)).transpose()?;
        let by_time = match by_time {
            Some(list) if list.searched.is_complete() => return Ok(list),
            by_time => by_time,
        };
        let room = (MOST - 4).saturating_sub(self.equations.rigid.len()) / 2;
        let opened = self.equations.opened_within(OPEN, room);
        let impacts = Impacts { equations: opened.as_ref().unwrap_or(self.equations), letters: self.letters.clone() };
        let in_plane = impacts.proved_in_the_phase_plane(request.scope).transpose()?;
        let in_plane = in_plane.map(|starts| impacts.list(request, starts)).transpose()?;
        let (mut best, other) = match (in_plane, by_time) {
            (None, None) => return self.list(request, if single { self.scan() } else { self.starts() }?),
            (Some(list), None) | (None, Some(list)) => return Ok(list),
            // Open modes tell orbits apart that are one by the errors of the others.
            (Some(in_plane), Some(by_time)) => {
                let plane_first = opened.is_some() || in_plane.searched.left_open() < by_time.searched.left_open();
                if plane_first { (in_plane, by_time) } else { (by_time, in_plane) }
            }
        };
        if !best.searched.is_complete() {
            // What one search leaves open the other one may have found.
            for orbit in other.orbits {
                if best.orbits.iter().all(|known| known.begun_at(&orbit).is_none()) {
                    best.orbits.push(orbit);
                }
            }
            sort(&mut best.orbits);
        }
        Ok(best)
    }

    /// The orbits that starts lead to.
    fn list(
        &self,
        Request { word, force_periods, scope, .. }: Request<'_>,
        (starts, mut searched): (Vec<Start>, Searched),
    ) -> Result<Listed, BreatherError> {
        let (equations, model) = (self.equations, self.equations.model);
        let pushing = self.letters.len() > 2;
        let pulls =
            |orbit: &ContactOrbit| orbit.impacts().iter().any(|impact| impact.barrier.sign() * impact.impulse >= 0.0);
        let (mut solutions, mut lost): (Vec<Solution>, usize) = (Vec::new(), 0);
        for Start { point, is_zero } in starts {
            model.heard()?;
            if scope.candidates() && point.pulls() {
                searched.refused += 1;
                continue;
            }
            // The phase as the orbit will tell it: whoever makes the orbit again from its data finds the same to the last bit.
            let point = Point { psi: model.phase(point.psi), ..point };
            let begin = point.clone();
            let solved = if is_zero { equations.solve_exact(point) } else { equations.solve(point) };
            let orbit = solved.and_then(|solved| ContactOrbit::new(equations, force_periods, solved));
            // A zero whose orbit is not reached, or is none as far as its errors tell, is told, not dropped.
            let is_whole =
                |orbit: &ContactOrbit| (letters_at_once(word) || orbit.has_its_instants()) && orbit.has_impulses();
            let sound = orbit.ok().filter(|orbit| is_whole(orbit) || is_zero && orbit.is_singular());
            let Some(orbit) = sound else {
                lost += usize::from(is_zero);
                continue;
            };
            let moved = farthest(&begin, &orbit);
            let known = solutions.iter_mut().find_map(|known| {
                let turn = known.orbit.begun_at(&orbit)?;
                // Two zeros that are proved to be apart, and have stayed where they were, are two orbits however large their errors.
                let apart = farthest(&begin, &known.orbit);
                let is_other =
                    is_zero && turn == 0 && known.zeros.contains(&0) && apart > STAYED * moved.max(known.moved);
                (!is_other).then_some((turn, known))
            });
            let Some((turn, known)) = known else {
                solutions.push(Solution { zeros: if is_zero { vec![0] } else { vec![] }, orbit, moved });
                continue;
            };
            // Two zeros have led to the same orbit, begun at the same impact: the orbit of one of them is missing.
            lost += usize::from(is_zero && known.zeros.contains(&turn));
            let is_as_sure = is_zero || known.zeros.is_empty();
            known.zeros.extend(is_zero.then_some(turn));
            if turn == 0 && is_as_sure && orbit.error() < known.orbit.error() {
                known.orbit = orbit;
            }
        }
        // Where Newton's method was stopped, too.
        model.heard()?;
        searched.unresolved += lost;
        let (repeating, orbits): (Vec<_>, Vec<_>) =
            solutions.into_iter().map(|solution| solution.orbit).partition(ContactOrbit::repeats_sooner);
        let (pulled, mut orbits): (Vec<_>, Vec<_>) = orbits.into_iter().partition(|orbit| pushing && pulls(orbit));
        searched.refused += pulled.len();
        searched.reason = searched.reason.or(Some(match (repeating.is_empty(), equations.forced) {
            (false, _) => NoBreather::RepeatsSooner,
            (true, true) => NoBreather::NoPhase,
            (true, false) => NoBreather::NoTimes,
        }));
        sort(&mut orbits);
        Ok(Listed { orbits, searched, periods: None })
    }
}

/// An orbit, and at which of its impacts those begin that zeros have led to.
struct Solution {
    orbit: ContactOrbit,
    zeros: Vec<usize>,
    /// How far it is from its start.
    moved: f64,
}

/// A start that is so many times farther from another orbit than from its own belongs to its own alone.
const STAYED: f64 = 1e3;

/// How far times of impacts and the phase of the load are from those of an orbit at most; 8 roundings of the period at least.
fn farthest(point: &Point, orbit: &ContactOrbit) -> f64 {
    let repeat = orbit.model().loads_repeat();
    let of_phase = orbit.psi().map_or(0.0, |psi| time_between(point.psi, psi, repeat));
    let apart = point.strikes.iter().zip(orbit.impacts()).map(|(strike, impact)| (strike.time - impact.time).abs());
    apart.fold(of_phase.max(8.0 * f64::EPSILON * orbit.period()), f64::max)
}

/// Whether several contacts are hit at one instant.
fn letters_at_once(word: &Word) -> bool {
    word.letters().count() > word.instants().len()
}

/// A barrier pulls where its impulse has the wrong sign by more than this part of the largest one.
const PULLS: f64 = 1e-6;

impl Point {
    /// Whether a barrier surely pulls: no such orbit is physical.
    pub(super) fn pulls(&self) -> bool {
        let largest = self.strikes.iter().map(|strike| strike.impulse.abs()).fold(0.0, f64::max);
        self.strikes.iter().any(|strike| strike.barrier.sign() * strike.impulse > PULLS * largest)
    }
}

/// Where Newton's method begins, and what is known of the list that it leads to.
pub(super) type Starts = Result<(Vec<Start>, Searched), BreatherError>;

impl Impacts<'_> {
    fn begin(&self, scope: Scope) -> Starts {
        let single = self.equations.single().is_some();
        match (self.letters.len(), self.equations.forced) {
            (1, true) if single => {
                let line = self.line(&[0.0])?;
                let unresolved = usize::from(line.as_ref().is_none_or(|line| !line.is_sharp()));
                let too_weak = line.as_ref().and_then(Line::too_weak);
                let points = line.map_or_else(Vec::new, |line| self.starts_on(&line, &[0.0]));
                Ok((points, Searched { unresolved, too_weak, ..Searched::default() }))
            }
            (1, false) => {
                let x = self.linear(&[0.0])?.solve().ok_or(BreatherError::Singular)?;
                Ok((vec![Start::zero(self.point(&[0.0], &x))], Searched::default()))
            }
            (1, true) => self.proved_of_one().unwrap_or_else(|| self.starts()),
            (2, false) => self.proved_of_both_sides().or_else(|| self.proved(None)).unwrap_or_else(|| self.scan()),
            (3, _) => self.proved_in_the_plane(boxes(scope)).unwrap_or_else(|| self.starts()),
            _ => self.starts(),
        }
    }

    /// Without loads, instants half a period apart: by reversal of time Newton's laws hold, and positions give the impulses.
    fn reversible(&self, word: &Word) -> Starts {
        let period = self.equations.period();
        let times: Vec<f64> = (word.instants().iter().enumerate())
            .flat_map(|(number, instant)| instant.iter().map(move |_| 0.5 * period * number as f64))
            .collect();
        let x = self.linear(&times)?.solve().ok_or(BreatherError::Singular)?;
        let partial = (word.instants().len() > 1).then_some(Partial::HalfPeriod);
        Ok((vec![Start::zero(self.point(&times, &x))], Searched { partial, ..Searched::default() }))
    }

    /// Zeros of the function of the time between two impacts, all of them, or all in some intervals; `None` where it cannot be enclosed, or takes too
    /// long.
    fn proved(&self, within: Option<&[[f64; 2]]>) -> Option<Starts> {
        let own = match self.proved_of_one_contact(within) {
            Some(Ok((starts, searched))) if !searched.is_complete() => Some((starts, searched)),
            Some(known) => return Some(known),
            None => None,
        };
        let any = self.proved_of_any(within);
        match (own, any) {
            // Where both leave places open, as next to a pitchfork, the one that is accurate about half a period finds more of the orbits.
            (Some(own), None) => Some(Ok(own)),
            (Some(own), Some(Ok((_, searched)))) if !searched.is_complete() => Some(Ok(own)),
            (_, any) => any,
        }
    }

    /// The same of any two contacts.
    fn proved_of_any(&self, within: Option<&[[f64; 2]]>) -> Option<Starts> {
        let contacts = [self.letters[0].0, self.letters[1].0];
        let places = self.places()?;
        let function = Function::new(self.equations, contacts, [places[0], places[1]])?;
        let mut zeros = function.zeros(within);
        if zeros.exhausted > 0 {
            return None;
        }
        let mut starts: Vec<Start> = Vec::new();
        let half = 0.5 * self.equations.period();
        let is_half = |phi: &&f64| (*phi - half).abs() <= HALF * half;
        let forced = self.equations.forced;
        if forced
            && !function.is_homogeneous()
            && let Err(error) = self.take_merged(&function, &mut zeros, &mut starts)
        {
            return Some(Err(error));
        }
        // A structure that is its own mirror image has a double zero there, one of the places that may be one.
        let open_half = forced && zeros.unresolved.iter().any(|phi| is_half(&phi));
        let line = match if open_half { self.line(&[0.0, half]) } else { Ok(None) } {
            Ok(line) => line.filter(Line::holds),
            Err(error) => return Some(Err(error)),
        };
        let mirrored = line.is_some();
        let mut unresolved = function.apart(zeros.unresolved.iter().filter(|phi| !(mirrored && is_half(phi))).copied());
        let mut add = || -> Result<(), BreatherError> {
            if forced && zeros.simple.iter().chain(&zeros.unresolved).any(|phi| is_half(&phi)) {
                starts.extend(self.on_a_line(&[0.0, half])?);
            }
            // Those next to half a period apart come first.
            let mut simple = zeros.simple.clone();
            // Of one orbit begun at either impact the shorter time.
            let apart = |phi: &f64| ((phi - half).abs() / (HALF * half)).round();
            simple.sort_by(|a, b| apart(a).total_cmp(&apart(b)));
            for phi in &simple {
                let here = if forced && function.is_homogeneous() {
                    self.on_a_line(&[0.0, *phi])?.into_iter().map(|start| start.point).collect()
                } else {
                    let x = self.linear(&[0.0, *phi])?.solve();
                    x.map(|x| self.point(&[0.0, *phi], &x)).into_iter().collect::<Vec<_>>()
                };
                unresolved += usize::from(here.is_empty());
                starts.extend(here.into_iter().map(Start::zero));
            }
            for phi in &zeros.unresolved {
                if forced {
                    starts.extend(self.on_a_line(&[0.0, *phi])?.into_iter().map(|start| Start::from(start.point)));
                }
                starts.extend(self.linear(&[0.0, *phi])?.solve().map(|x| self.point(&[0.0, *phi], &x).into()));
            }
            Ok(())
        };
        let found = add();
        let too_weak = line.as_ref().and_then(Line::too_weak).filter(|_| starts.is_empty());
        let searched = Searched { intervals: zeros.intervals, unresolved, too_weak, ..Searched::default() };
        Some(found.map(|()| (starts, searched)))
    }

    /// Zeros of the two functions of the times between three impacts; `None` where they cannot be enclosed, or that takes too long.
    fn proved_in_the_plane(&self, boxes: usize) -> Option<Starts> {
        let functions = ThreeImpacts::new(self, boxes)?;
        let zeros = functions.zeros();
        if zeros.exhausted > 0 {
            return None;
        }
        let (mut starts, mut open): (Vec<Start>, usize) = (Vec::new(), zeros.unresolved.len());
        let times = |[x, y]: [f64; 2]| [0.0, x, x + y];
        if functions.double {
            match self.on_a_line(&times([self.equations.period() / 3.0; 2])) {
                Ok(points) => starts.extend(points),
                Err(error) => return Some(Err(error)),
            }
        }
        for (at, is_zero) in all_places(&zeros.simple, &zeros.unresolved) {
            match functions.numbers(at) {
                Some(numbers) => starts.push(Start::new(self.point(&times(at), &numbers), is_zero)),
                None => open += usize::from(is_zero),
            }
        }
        Some(Ok((starts, Searched { boxes: zeros.boxes, unresolved: open, ..Searched::default() })))
    }
}

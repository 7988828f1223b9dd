//! All orbits of up to three impacts, and those of longer words that starts lead to.
//!
//! Under a load of one harmonic, (c, s) = (cos, sin) of jωψ: impulses, offsets, c and s obey linear equations once the times are given, and
//! c² + s² = 1 is left. Of one impact that is a quadratic equation; of two the zeros of one analytic function of the time between them,
//!
//! ```text
//! F(φ) = Δ²(c² + s² − 1),      Δ the determinant of the linear equations.
//! ```
//!
//! Without loads the positions give the impulses, and one of Newton's laws is left: the zeros of K₂₁′. Of three impacts two functions of two times
//! are left.

use smallvec::SmallVec;
use vibrochain_lattice::Barrier;

use super::at_times::Impacts;
use super::equations::{Equations, Point};
use super::error::StructureOrbitError;
use super::model::StructureModel;
use super::orbit::StructureOrbit;
use super::three_impacts::ThreeImpacts;
use super::two_impacts::Function;
use crate::orbit::time_between;
use crate::word::Word;

/// Two orbits whose times agree to this part of the period, and impulses to this part of themselves, are one.
const SAME: f64 = 1e-7;

/// What is known of a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(tag = "by", rename_all = "kebab-case"))]
pub enum StructureSearch {
    /// Closed form: the list is complete.
    ClosedForm,
    /// Closed form of instants half a period apart, without loads: others are not looked for.
    HalfPeriod,
    /// Enclosures of a function of one variable show on intervals where it has no zero and that each one found is alone: the list is complete
    /// but for impacts of one contact, or without loads of any two, closer than 1e-4 of the period, and for so many places where two may have
    /// merged.
    Enclosures {
        /// Intervals enclosed.
        intervals: usize,
        /// Places left open.
        unresolved: usize,
    },
    /// Enclosures of two functions of two times show on rectangles where they have no common zero and that each one found is alone: the list is
    /// complete but for the same.
    BranchAndPrune {
        /// Rectangles enclosed.
        boxes: usize,
        /// Places left open.
        unresolved: usize,
    },
    /// A function of one variable has been looked at in so many places: what lies between two of them may be missed.
    Scan {
        /// How many.
        places: usize,
    },
    /// Newton's method from so many starts: the list is not complete.
    Starts {
        /// How many.
        starts: usize,
    },
}

impl StructureSearch {
    /// Whether the list holds all that there are: where it is empty there is none.
    pub fn is_complete(self) -> bool {
        match self {
            Self::ClosedForm => true,
            Self::Enclosures { unresolved, .. } | Self::BranchAndPrune { unresolved, .. } => unresolved == 0,
            Self::HalfPeriod | Self::Scan { .. } | Self::Starts { .. } => false,
        }
    }
}

/// Orbits of a word.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureFound {
    /// The orbits, physical or not.
    pub orbits: Vec<StructureOrbit>,
    /// How they were sought.
    pub search: StructureSearch,
}

/// All orbits of a word that are found: contacts stand in place of sites. Those of one impact or two are listed with their signs as they are,
/// pulled or not; of longer words only those whose barriers push. An orbit is listed once, whichever impact it begins with, and not where it
/// repeats itself sooner. Of three impacts a list takes some hundredths of a second, and up to two seconds.
///
/// # Errors
/// [`StructureOrbitError`].
pub fn structure_orbits(
    model: &StructureModel,
    word: &Word,
    force_periods: u32,
) -> Result<StructureFound, StructureOrbitError> {
    found(model, word, force_periods, Wanted::All)
}

/// The same without those whose barriers pull: what a map asks for.
///
/// # Errors
/// As [`structure_orbits`].
pub fn structure_candidates(
    model: &StructureModel,
    word: &Word,
    force_periods: u32,
) -> Result<StructureFound, StructureOrbitError> {
    found(model, word, force_periods, Wanted::Pushing)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Wanted {
    All,
    Pushing,
}

impl Wanted {
    /// Rectangles on which three impacts may be sought, a few microseconds each: as long as starts take for a map, and a second or two for one list.
    fn boxes(self) -> usize {
        match self {
            Self::All => 400_000,
            Self::Pushing => 40_000,
        }
    }
}

fn found(
    model: &StructureModel,
    word: &Word,
    force_periods: u32,
    wanted: Wanted,
) -> Result<StructureFound, StructureOrbitError> {
    let mut letters: SmallVec<[(usize, Barrier); 4]> = SmallVec::new();
    for letter in word.letters() {
        model.barrier(letter.site, letter.barrier)?;
        letters.push((letter.site, letter.barrier));
    }
    let equations = Equations::new(model, force_periods, letters.iter().map(|(contact, _)| *contact))?;
    if equations.forced
        && letters.iter().all(|&(contact, _)| equations.swings(contact).all(|(_, swing)| swing.norm() == 0.0))
    {
        return Err(StructureOrbitError::Unfelt);
    }
    if letters.len() > word.instants().len() && (equations.forced || word.instants().len() > 2) {
        return Err(StructureOrbitError::AtOnce);
    }
    if !equations.forced && !model.structure().is_lossless() {
        return Err(StructureOrbitError::LossWithoutLoad);
    }
    let contacts: SmallVec<[usize; 4]> = letters.iter().map(|(contact, _)| *contact).collect();
    equations.off_resonance(&contacts)?;
    let impacts = Impacts { equations: &equations, letters };
    let (starts, mut search) = if letters_at_once(word) { impacts.reversible(word)? } else { impacts.begin(wanted)? };
    let mut orbits: Vec<StructureOrbit> = Vec::new();
    for Start { point, is_zero } in starts {
        model.heard()?;
        if wanted == Wanted::Pushing && point.pulls() {
            continue;
        }
        let Ok(solved) = equations.solve(point) else {
            // A zero whose orbit is not reached is told, not dropped.
            if let StructureSearch::Enclosures { unresolved, .. } | StructureSearch::BranchAndPrune { unresolved, .. } =
                &mut search
            {
                *unresolved += usize::from(is_zero);
            }
            continue;
        };
        let Ok(orbit) = StructureOrbit::new(&equations, force_periods, solved) else { continue };
        let pulls = orbit.impacts().iter().any(|impact| impact.barrier.sign() * impact.impulse >= 0.0);
        let in_order = letters_at_once(word) || orbit.impacts().windows(2).all(|pair| pair[1].time > pair[0].time);
        let sound = in_order
            && orbit.impacts().last().is_some_and(|last| last.time < orbit.period())
            && !(pulls && matches!(search, StructureSearch::Starts { .. } | StructureSearch::BranchAndPrune { .. }));
        // An impulse below its own error is none.
        let hits = orbit.impacts().iter().all(|impact| impact.impulse.abs() > impact.impulse_error);
        let new = || !orbits.iter().any(|other| (0..word.letters().count()).any(|turn| is_same(other, &orbit, turn)));
        if sound && hits && !repeats_sooner(&orbit) && new() {
            orbits.push(orbit);
        }
    }
    // Where Newton's method was stopped, too.
    model.heard()?;
    Ok(StructureFound { orbits, search })
}

/// Whether several contacts are hit at one instant.
fn letters_at_once(word: &Word) -> bool {
    word.letters().count() > word.instants().len()
}

/// Whether the second orbit, begun at its impact number `turn`, is the first one.
fn is_same(a: &StructureOrbit, b: &StructureOrbit, turn: usize) -> bool {
    let (period, n) = (a.period(), b.impacts().len());
    let begins = b.impacts()[turn].time;
    let psi = match (a.psi(), b.psi()) {
        (Some(a_psi), Some(b_psi)) => time_between(a_psi, b_psi + begins, a.model().period()) < SAME * period,
        _ => true,
    };
    psi && (0..n).all(|i| {
        let (own, other) = (&a.impacts()[i], &b.impacts()[(i + turn) % n]);
        let close = (own.impulse - other.impulse).abs() < SAME * own.impulse.abs().max(other.impulse.abs());
        own.contact == other.contact
            && own.barrier == other.barrier
            && time_between(own.time, other.time - begins, period) < SAME * period
            && close
    })
}

/// Whether an orbit is one of fewer periods, gone through several times.
fn repeats_sooner(orbit: &StructureOrbit) -> bool {
    let (n, periods) = (orbit.impacts().len(), orbit.force_periods() as usize);
    // Without loads any part of the period may be one.
    let parts = |part: usize| n.is_multiple_of(part) && (orbit.psi().is_none() || periods.is_multiple_of(part));
    (2..=n).filter(|&part| parts(part)).any(|part| {
        let shift = n / part;
        let lapse = orbit.period() / part as f64;
        (0..n).all(|i| {
            let (own, other) = (&orbit.impacts()[i], &orbit.impacts()[(i + shift) % n]);
            let later = other.time + if i + shift >= n { orbit.period() } else { 0.0 };
            own.contact == other.contact
                && own.barrier == other.barrier
                && (later - own.time - lapse).abs() < SAME * orbit.period()
                && (own.impulse - other.impulse).abs() < SAME * own.impulse.abs()
        })
    })
}

/// A barrier pulls where its impulse has the wrong sign by more than this part of the largest one.
const PULLS: f64 = 1e-6;

impl Point {
    /// Whether a barrier surely pulls: no such orbit is physical.
    fn pulls(&self) -> bool {
        let largest = self.strikes.iter().map(|strike| strike.impulse.abs()).fold(0.0, f64::max);
        self.strikes.iter().any(|strike| strike.barrier.sign() * strike.impulse > PULLS * largest)
    }
}

/// Where Newton's method begins.
pub(super) struct Start {
    pub(super) point: Point,
    /// It belongs to a zero that is known to be there.
    pub(super) is_zero: bool,
}

impl From<Point> for Start {
    fn from(point: Point) -> Self {
        Self { point, is_zero: false }
    }
}

pub(super) type Starts = Result<(Vec<Start>, StructureSearch), StructureOrbitError>;

impl Impacts<'_> {
    fn begin(&self, wanted: Wanted) -> Starts {
        let single = self.equations.single().is_some();
        match (self.letters.len(), self.equations.forced) {
            (1, true) if single => {
                let points = self.on_a_line(&[0.0])?;
                Ok((points.into_iter().map(Start::from).collect(), StructureSearch::ClosedForm))
            }
            (1, false) => {
                let x = self.linear(&[0.0])?.solve().ok_or(StructureOrbitError::Singular)?;
                Ok((vec![self.point(&[0.0], &x).into()], StructureSearch::ClosedForm))
            }
            (2, forced) if single || !forced => self.proved().unwrap_or_else(|| self.scan()),
            (3, _) => self.proved_in_the_plane(wanted.boxes()).unwrap_or_else(|| self.starts()),
            _ => self.starts(),
        }
    }

    /// Without loads, instants half a period apart: by reversal of time Newton's laws hold, and positions give the impulses.
    fn reversible(&self, word: &Word) -> Starts {
        let period = self.equations.period();
        let times: Vec<f64> = (word.instants().iter().enumerate())
            .flat_map(|(number, instant)| instant.iter().map(move |_| 0.5 * period * number as f64))
            .collect();
        let x = self.linear(&times)?.solve().ok_or(StructureOrbitError::Singular)?;
        let search = if word.instants().len() == 1 { StructureSearch::ClosedForm } else { StructureSearch::HalfPeriod };
        Ok((vec![self.point(&times, &x).into()], search))
    }

    /// Zeros of the function of the time between two impacts, all of them; `None` where it cannot be enclosed, or takes too long.
    fn proved(&self) -> Option<Starts> {
        let contacts = [self.letters[0].0, self.letters[1].0];
        let places = self.places()?;
        let function = Function::new(self.equations, contacts, [places[0], places[1]])?;
        let zeros = function.zeros();
        if zeros.exhausted > 0 {
            return None;
        }
        let half = 0.5 * self.equations.period();
        let is_half = |phi: &&f64| (*phi - half).abs() <= SAME * half;
        let forced = self.equations.forced;
        let mut unresolved = zeros.unresolved.iter().filter(|phi| !(forced && is_half(phi))).count();
        let mut starts = || -> Result<Vec<Start>, StructureOrbitError> {
            let mut starts: Vec<Start> = Vec::new();
            // A structure that is its own mirror image has a double zero there, one of the places that may be one.
            if forced && zeros.simple.iter().chain(&zeros.unresolved).any(|phi| is_half(&phi)) {
                starts.extend(self.on_a_line(&[0.0, half])?.into_iter().map(Start::from));
            }
            // Those next to half a period apart come first.
            let mut simple = zeros.simple.clone();
            // Of one orbit begun at either impact the shorter time.
            let apart = |phi: &f64| ((phi - half).abs() / (SAME * half)).round();
            simple.sort_by(|a, b| apart(a).total_cmp(&apart(b)));
            for phi in &simple {
                let here = if forced && function.is_homogeneous() {
                    self.on_a_line(&[0.0, *phi])?
                } else {
                    self.linear(&[0.0, *phi])?.solve().map(|x| self.point(&[0.0, *phi], &x)).into_iter().collect()
                };
                unresolved += usize::from(here.is_empty());
                starts.extend(here.into_iter().map(|point| Start { point, is_zero: true }));
            }
            for phi in &zeros.unresolved {
                if forced {
                    starts.extend(self.on_a_line(&[0.0, *phi])?.into_iter().map(Start::from));
                }
                starts.extend(self.linear(&[0.0, *phi])?.solve().map(|x| self.point(&[0.0, *phi], &x).into()));
            }
            Ok(starts)
        };
        let found = starts();
        let search = StructureSearch::Enclosures { intervals: zeros.intervals, unresolved };
        Some(found.map(|starts| (starts, search)))
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
                Ok(points) => starts.extend(points.into_iter().map(Start::from)),
                Err(error) => return Some(Err(error)),
            }
        }
        for (at, is_zero) in
            zeros.simple.iter().map(|at| (at, true)).chain(zeros.unresolved.iter().map(|at| (at, false)))
        {
            match functions.numbers(*at) {
                Some(numbers) => starts.push(Start { point: self.point(&times(*at), &numbers), is_zero }),
                None => open += usize::from(is_zero),
            }
        }
        Some(Ok((starts, StructureSearch::BranchAndPrune { boxes: zeros.boxes, unresolved: open })))
    }
}

//! What a map asks of an orbit without loads and losses, all of whose impacts are of one contact: one a period, or two half a period apart on both
//! barriers. Is it physical, by what margin, with which impulses?
//!
//! A fast path: a cell of a map of such orbits takes a quarter of the time. The general one is [`StructureModel::candidates`] and
//! [`StructureOrbit::first_obstruction`](super::orbit::StructureOrbit::first_obstruction); what needs more than closed forms is left to it
//! ([`MapSearch::Open`]). With frequencies Ω and shapes φ of the modes, φ₀ at the contact that is hit, contact c does after impulses P, Q at 0, T/2
//!
//! ```text
//! Σ φ_c φ₀ [P cos Ω(t−T/2) + Q cos Ωt] / (2Ω sin ΩT/2),      0 ≤ t ≤ T/2.
//! ```

mod flight;
mod modes;

use std::sync::Arc;

use smallvec::SmallVec;
use vibrochain_lattice::{Barrier, Contact};

use super::model::StructureModel;
use super::response::FixedPart;
use super::reversible::ReversibleOrbit;
use super::search::half_period::other_lapses;
use crate::admissible::answer::Obstruction;
use crate::admissible::map_breather::MapSearch;
use crate::word::Word;
use modes::{Impulses, Modes};

/// Of impulses that errors move by more than this part of them signs may be rounding.
const DELICATE: f64 = 1e-6;

/// An impulse below this part of the other one is next to grazing.
const GRAZING: f64 = 1e-5;

/// Positions miss their barriers by no more than this part of their terms: rounding.
const ROUNDED: f64 = 64.0 * f64::EPSILON;

/// Whether a barrier pulls by more than this part of the larger impulse: no such orbit is a candidate.
fn surely_pulls(barriers: [Option<Barrier>; 2], impulses: [f64; 2]) -> bool {
    let most = impulses[0].abs().max(impulses[1].abs());
    let pull =
        |(barrier, impulse): (Option<Barrier>, f64)| barrier.is_some_and(|own| own.sign() * impulse > GRAZING * most);
    barriers.into_iter().zip(impulses).any(pull)
}

/// An orbit whose impacts, of one contact, are half a period apart, or the only one.
///
/// ```
/// use std::sync::Arc;
/// use vibrochain_breather::{MapSearch, StructureModel};
/// use vibrochain_lattice::{Contact, LinearMode, ModalStructure, ModeShape};
/// let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: 0.0 };
/// let mode = LinearMode::oscillator(0.0, 1.0, &shape, &[]);
/// let stop = Contact { lower: Some(-1.0), upper: Some(0.7), restitution: 1.0 };
/// let structure = Arc::new(ModalStructure::new(vec![stop], vec![], vec![mode])?);
/// let model = StructureModel::new(structure, 1.5)?;
/// let word = "0+,0-".parse()?;
/// let MapSearch::One(orbit) = model.map_orbit(&word, 1) else { panic!() };
/// let impulse = model.orbits(&word, 1)?.orbits[0].impacts()[0].impulse;
/// assert!((orbit.impulses()[0] - impulse).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct MapOrbit {
    fixed: Arc<FixedPart>,
    period: f64,
    impulses: [f64; 2],
    /// Of two impulses the bound of the relative error of their ratio.
    ratio_error: Option<f64>,
    margin: Option<f64>,
    crossing: Option<Obstruction>,
    residual: f64,
}

impl MapOrbit {
    /// Momenta that the barriers give, signed: at 0 and T/2, or the one.
    pub fn impulses(&self) -> &[f64] {
        &self.impulses[..if self.ratio_error.is_some() { 2 } else { 1 }]
    }

    /// Times of the impacts: 0, and T/2 if they are two.
    pub fn times(&self) -> impl Iterator<Item = f64> + Clone {
        [0.0, 0.5 * self.period].into_iter().take(self.impulses().len())
    }

    /// The orbit's period.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// What is in the way; `None` of a physical orbit.
    pub fn obstruction(&self) -> Option<Obstruction> {
        self.crossing
    }

    /// The least distance at a turning point; `None` where no contact turns before a barrier.
    pub fn margin(&self) -> Option<f64> {
        self.margin
    }

    /// How far contacts are from their barriers at impacts, as a part of the terms of their places.
    pub fn residual(&self) -> f64 {
        self.residual
    }

    /// What its multipliers depend on.
    pub fn reversible(&self) -> ReversibleOrbit<'_> {
        let [first, second] = self.impulses;
        ReversibleOrbit {
            modes: self.fixed.felt.of_one.as_deref().unwrap_or_default(),
            period: self.period,
            ratio: self.ratio_error.map(|error| (second / first, error)),
        }
    }
}

impl StructureModel {
    /// What lives here of a word of one impact, or of two of one contact on both barriers, where closed forms tell it: without loads and losses, away
    /// from resonances, and where no other orbit of the word may be.
    pub fn map_orbit(&self, word: &Word, force_periods: u32) -> MapSearch<MapOrbit> {
        self.found_in_closed_form(word, force_periods).unwrap_or(MapSearch::Open)
    }

    fn found_in_closed_form(&self, word: &Word, force_periods: u32) -> Option<MapSearch<MapOrbit>> {
        let mut letters = word.letters();
        let (first, second) = (letters.next()?, letters.next());
        let is_opposite = second.is_none_or(|other| other.site == first.site && other.barrier != first.barrier);
        let is_simple = word.instants().len() == 1 + usize::from(second.is_some()) && letters.next().is_none();
        if !is_opposite || !is_simple || force_periods != 1 || self.heard().is_err() {
            return None;
        }
        let contacts = self.structure().contacts();
        let stops = contacts.get(first.site)?;
        let fixed = self.fixed(&[first.site]);
        if fixed.forced || fixed.self_excited || !fixed.is_held || self.masses().is_some() {
            return None;
        }
        let watched = fixed.view(contacts);
        let (order, view) = (&watched.0, watched.1.as_ref()?);
        let half = 0.5 * self.period();
        let modes = Modes::at_half(&fixed, first.site, half)?;
        // Barriers from where the contact is still.
        let still = fixed.still(first.site);
        let place = |barrier: Barrier| Some(stops.barrier(barrier)? - still);
        let barriers = [Some(first.barrier), second.map(|letter| letter.barrier)];
        let places = [place(first.barrier)?, second.map_or(Some(0.0), |letter| place(letter.barrier))?];
        let Impulses { impulses, errors, residual } = modes.impulses(places, second.is_some())?;
        let least =
            impulses.iter().take(1 + usize::from(second.is_some())).fold(f64::INFINITY, |least, p| least.min(p.abs()));
        let most = impulses[0].abs().max(impulses[1].abs());
        let is_sharp = errors.iter().all(|error| *error <= DELICATE) && residual <= ROUNDED;
        if !is_sharp || least < GRAZING * most {
            return None;
        }
        let flight = modes.flight(impulses, (half, view.fastest))?;
        if second.is_some() && !flight.is_alone() {
            let others = other_lapses(fixed.felt.of_one.as_deref()?, self.period(), self.stop())?;
            let pull = |s: f64| modes.aside(s, places).is_some_and(|impulses| surely_pulls(barriers, impulses));
            if !others.into_iter().all(pull) {
                return None;
            }
        }
        if surely_pulls(barriers, impulses) {
            return Some(MapSearch::None);
        }
        let list: SmallVec<[Contact; 16]> = order.iter().map(|&contact| contacts[contact]).collect();
        let closest = flight.closest(view, &list, barriers);
        let crossing = closest.filter(|closest| closest.distance <= 0.0).map(|closest| {
            let (site, barrier, time) = (order[closest.place], closest.barrier, closest.time);
            Obstruction::Crossing { site, barrier, time, excess: -closest.distance }
        });
        let margin = closest.map(|closest| closest.distance);
        let ratio_error = second.map(|_| errors.iter().sum::<f64>() + 4.0 * f64::EPSILON);
        let period = self.period();
        Some(MapSearch::One(MapOrbit { fixed, period, impulses, ratio_error, margin, crossing, residual }))
    }
}

#[cfg(test)]
mod tests;

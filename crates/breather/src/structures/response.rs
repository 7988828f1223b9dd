//! What contacts of a structure do after impacts at some of them, and under its loads, at one frequency.

use std::sync::{Arc, OnceLock};

use smallvec::SmallVec;
use vibrochain_lattice::simd::lanes::LANES;
use vibrochain_lattice::{
    Complex, Contact, LinearMode, ModalStructure, ParticipatingModes, SparseOperator, StructureError,
};

use super::periodic_kernel::{PeriodicKernel, UNIT, length};
use crate::admissible::grid::diagonals::Diagonals;
use crate::motion::modal::view::View;

type C = Complex<f64>;

/// Motions of two contacts that differ by no more than this part of them are one.
const ALIKE: f64 = 1e-13;

fn are_near(a: C, b: C) -> bool {
    (a - b).norm_sqr() <= ALIKE * ALIKE * a.norm_sqr()
}

/// What contacts do after impacts at some of them, under the loads, and under the static one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Response {
    pub(super) kernel: PeriodicKernel,
    /// ĝ of each harmonic, at each contact; bounds of the errors.
    swings: Vec<(f64, Vec<C>)>,
    swing_errors: Vec<Vec<f64>>,
    pub(super) fixed: Arc<FixedPart>,
}

/// What of it no frequency changes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FixedPart {
    /// The modes as the contacts that are hit feel them.
    pub(super) felt: Arc<ParticipatingModes>,
    /// g⁰; bounds of the errors.
    still: Vec<f64>,
    still_errors: Vec<f64>,
    /// 1/m of the contacts that are hit, with bounds of the errors.
    mobilities: Vec<(usize, [f64; 2])>,
    /// Whether loads change, and whether the period is the motion's own.
    pub(super) forced: bool,
    pub(super) self_excited: bool,
    /// Whether something holds every mode.
    pub(super) is_held: bool,
    /// What contacts see of flights without loads, and these contacts, once they are asked for.
    view: OnceLock<Arc<(Vec<usize>, Option<View>)>>,
    /// How these contacts pull at each other, if that is all that pulls at them.
    pulls: OnceLock<Option<Diagonals>>,
}

impl FixedPart {
    /// Of a structure some of whose contacts are hit.
    pub(super) fn new(structure: &ModalStructure, hit: &[usize]) -> Self {
        let resting = structure.still();
        let moved: Vec<_> = structure.modes().iter().zip(&resting).filter(|(_, xi)| **xi != [0.0; 2]).collect();
        let at_rest = |contact: usize| {
            let terms = moved.iter().map(|(mode, xi)| {
                let row = mode.rows[contact];
                row[0] * xi[0] + row[1] * xi[1]
            });
            terms.sum()
        };
        let still = (0..structure.contacts().len()).map(at_rest).collect();
        let mobility =
            |contact: usize| [structure.mobility(contact, contact), structure.mobility_error(contact, contact)];
        let mobilities = hit.iter().map(|&contact| (contact, mobility(contact))).collect();
        let felt = Arc::new(structure.participating_modes(hit));
        let (forced, self_excited) = (structure.is_forced(), structure.has_own_period());
        let (still_errors, view, pulls) = (structure.still_errors(), OnceLock::new(), OnceLock::new());
        let is_held = !structure.modes().iter().any(LinearMode::is_rigid);
        Self { felt, still, still_errors, mobilities, forced, self_excited, is_held, view, pulls }
    }

    /// g⁰ of a contact.
    pub(super) fn still(&self, contact: usize) -> f64 {
        self.still[contact]
    }

    /// [`Response::view`] without loads where all modes are held.
    pub(super) fn view(&self, contacts: &[Contact]) -> Arc<(Vec<usize>, Option<View>)> {
        let made = || {
            let order = self.watched(contacts, &[]);
            let view = self.view_of(&order, self.felt.modes.iter(), &[]);
            Arc::new((order, view))
        };
        self.view.get_or_init(made).clone()
    }

    /// M⁻¹K of the contacts that are looked at, where no spring leads elsewhere.
    pub(super) fn pulls(&self, structure: &ModalStructure) -> Option<&Diagonals> {
        let made = || {
            let order = &self.view(structure.contacts()).0;
            Diagonals::new(order.len().div_ceil(LANES), self.entries(structure.operator()?, order)?.into_iter())
        };
        self.pulls.get_or_init(made).as_ref()
    }

    /// Its entries, by places in the list of contacts.
    fn entries(&self, operator: &SparseOperator, order: &[usize]) -> Option<Vec<(usize, usize, f64)>> {
        let coordinate = |contact: usize| match operator.contacts[contact][..] {
            [(coordinate, 1.0)] => Some(coordinate),
            _ => None,
        };
        let mut places = vec![None; operator.contacts.len()];
        order.iter().enumerate().for_each(|(place, contact)| places[*contact] = Some(place));
        // Of each coordinate the place of its contact, or of the one that does the same.
        let mut at = vec![None; operator.masses.len()];
        for contact in 0..places.len() {
            if let Some(coordinate) = coordinate(contact) {
                at[coordinate] = places[contact].or(places[self.felt.twins[contact]]);
            }
        }
        let mut entries = Vec::new();
        for (place, contact) in order.iter().enumerate() {
            for (_, column, entry) in &operator.entries(Some(coordinate(*contact)?))[0] {
                entries.push((place, at[*column]?, *entry));
            }
        }
        Some(entries)
    }

    /// What contacts see of some modes and of motions under loads.
    fn view_of<'a>(
        &'a self,
        order: &[usize],
        modes: impl Iterator<Item = &'a LinearMode>,
        swings: &[(f64, Vec<C>)],
    ) -> Option<View> {
        let modes: SmallVec<[_; 16]> = modes.collect();
        View::new(&modes, swings, (order, |contact| self.still(contact)))
    }

    /// Whether loads move contacts alike that are mirror images of each other.
    fn are_twins_alike(&self, swings: &[(f64, Vec<C>)]) -> bool {
        let twins = || self.felt.twins.iter().enumerate().filter(|(contact, first)| contact != *first);
        swings.iter().all(|(_, swing)| twins().all(|(contact, &first)| are_near(swing[first], swing[contact])))
    }

    /// Contacts with a barrier, those that are hit first: the others are seldom nearer. Of those that do the same, as mirror images of each
    /// other have it, between barriers at the same places one.
    fn watched(&self, contacts: &[Contact], swings: &[(f64, Vec<C>)]) -> Vec<usize> {
        let is_hit = |contact: usize| self.mobilities.iter().any(|(hit, _)| *hit == contact);
        let stops = |contact: usize| (contacts[contact].lower, contacts[contact].upper);
        let real = |contact: usize| C::new(self.still[contact], 0.0);
        let are_alike = |one: usize, other: usize| {
            stops(one) == stops(other)
                && are_near(real(one), real(other))
                && swings.iter().all(|(_, swing)| are_near(swing[one], swing[other]))
        };
        let is_first = |contact: &usize| {
            let first = self.felt.twins[*contact];
            first == *contact || is_hit(first) || is_hit(*contact) || !are_alike(first, *contact)
        };
        let mut order: Vec<usize> =
            (0..contacts.len()).filter(|&c| stops(c) != (None, None)).filter(is_first).collect();
        order.sort_by_key(|&contact| !is_hit(contact));
        order
    }
}

/// A harmonic whose motion and acceleration are below this part of another's is none: what it does is less than that one's rounding.
const NONE: f64 = 1e-20;

/// The error of a mode that a load drives this close to its frequency, relative to that, is carried as one number.
pub(super) const NEAR: f64 = 1e-3;

impl Response {
    /// Of a structure at a frequency of its loads, with impacts at the contacts `hit`.
    ///
    /// # Errors
    /// [`StructureError::Resonance`] where a load meets a mode that nothing damps.
    pub(super) fn new(
        structure: &ModalStructure,
        (omega, period): (f64, f64),
        fixed: Arc<FixedPart>,
        hit: &[usize],
    ) -> Result<Self, StructureError> {
        let kernel = PeriodicKernel::new(structure.modes(), fixed.felt.clone(), hit, period);
        let (mut swings, mut swing_errors) = (Vec::new(), Vec::new());
        let harmonics = if fixed.forced { structure.harmonics() } else { &[] };
        let all: Vec<(f64, Vec<C>)> = (harmonics.iter().enumerate())
            .map(|(place, harmonic)| Ok((f64::from(*harmonic) * omega, structure.steady_at(place, omega)?)))
            .collect::<Result<_, StructureError>>()?;
        let size = |(rate, swing): &(f64, Vec<C>)| {
            swing.iter().map(|swing| length([swing.re, swing.im])).fold(0.0, f64::max) * (1.0 + rate.powi(2))
        };
        let largest = all.iter().map(size).fold(0.0, f64::max);
        for (place, one) in all.into_iter().enumerate() {
            if size(&one) > NONE * largest {
                swings.push(one);
                swing_errors.push(structure.steady_errors_at(place, omega, NEAR));
            }
        }
        Ok(Self { kernel, swings, swing_errors, fixed })
    }

    /// The same with another kernel, and without what some harmonics do to modes next to them.
    pub(super) fn without(
        &self,
        kernel: PeriodicKernel,
        structure: &ModalStructure,
        omega: f64,
        taken: &[(usize, usize)],
    ) -> Self {
        let mut response = Self { kernel, ..self.clone() };
        if taken.is_empty() {
            return response;
        }
        let all = 0..structure.harmonics().len();
        let swing = |place: usize| {
            let left_out = |mode: usize| taken.contains(&(mode, place));
            (f64::from(structure.harmonics()[place]) * omega, structure.steady_but(place, omega, left_out))
        };
        response.swings = all.clone().map(swing).collect();
        response.swing_errors = all.map(|place| structure.steady_errors_at(place, omega, NEAR)).collect();
        response
    }

    /// Frequency of the only harmonic and ĝ of every contact; `None` of several or none.
    pub(super) fn single(&self) -> Option<(f64, &[C])> {
        match &self.swings[..] {
            [(rate, swing)] => Some((*rate, swing)),
            _ => None,
        }
    }

    /// The contacts that may come to a barrier, and what they see of flights; without loads both are the same at all frequencies.
    pub(super) fn view(&self, contacts: &[Contact]) -> Arc<(Vec<usize>, Option<View>)> {
        let fixed = &self.fixed;
        let made = || {
            let order = fixed.watched(contacts, &self.swings);
            let view = self.view_of(&order);
            Arc::new((order, view))
        };
        if !self.kernel.is_whole() {
            return made();
        }
        if !fixed.is_held || !fixed.are_twins_alike(&self.swings) {
            let is_fixed = !fixed.forced && !fixed.self_excited;
            return if is_fixed { fixed.view.get_or_init(made).clone() } else { made() };
        }
        let unforced = fixed.view(contacts);
        if self.swings.is_empty() {
            return unforced;
        }
        let (order, view) = &*unforced;
        Arc::new((order.clone(), view.as_ref().map(|view| view.under(&self.swings, order))))
    }

    /// What these contacts see of flights.
    pub(super) fn view_of(&self, order: &[usize]) -> Option<View> {
        let modes = self.kernel.regular().map(|(mode, _)| mode).chain(self.kernel.rigid());
        self.fixed.view_of(order, modes, &self.swings)
    }

    /// 1/m of a contact that is hit.
    pub(super) fn mobility(&self, contact: usize) -> Option<f64> {
        self.fixed.mobilities.iter().find(|(hit, _)| *hit == contact).map(|(_, [mobility, _])| *mobility)
    }

    /// A bound of its error; 0 of one that is not hit.
    pub(super) fn mobility_error(&self, contact: usize) -> f64 {
        self.fixed.mobilities.iter().find(|(hit, _)| *hit == contact).map_or(0.0, |(_, [_, error])| *error)
    }

    /// g⁰ of a contact.
    pub(super) fn still(&self, contact: usize) -> f64 {
        self.fixed.still(contact)
    }

    /// Frequencies and ĝ of a contact.
    pub(super) fn swings(&self, contact: usize) -> impl Iterator<Item = (f64, C)> + '_ {
        self.swings.iter().map(move |(rate, swing)| (*rate, swing[contact]))
    }

    /// G of a contact, and its first three derivatives, at t + ψ.
    pub(super) fn load(&self, contact: usize, t: f64) -> [f64; 4] {
        let mut jet = [0.0; 4];
        for (rate, swing) in self.swings(contact) {
            let mut value = swing * C::from_polar(1.0, rate * t);
            for entry in &mut jet {
                *entry += value.re;
                value *= C::new(0.0, rate);
            }
        }
        jet
    }

    /// Sizes of the terms of g⁰ + G and two derivatives at t + ψ, with what rounding of that time makes of them and what errors of ĝ do: where
    /// one of them vanishes, as the velocity does at a grazing, its own size says nothing of its error.
    pub(super) fn load_sizes(&self, contact: usize, t: f64) -> [f64; 3] {
        let mut sizes = [self.fixed.still[contact].abs() + self.fixed.still_errors[contact] / UNIT, 0.0, 0.0];
        for ((rate, swing), errors) in self.swings(contact).zip(&self.swing_errors) {
            let mut value = swing * C::from_polar(1.0, rate * t);
            let mut length = swing.norm() + errors[contact] / UNIT;
            for size in &mut sizes {
                value *= C::new(0.0, rate);
                *size += length + (value.re * t).abs();
                length *= rate;
            }
        }
        sizes
    }
}

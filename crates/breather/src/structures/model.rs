//! A structure and the frequency of its loads.

use std::f64::consts::TAU;
use std::sync::{Arc, Mutex, PoisonError};

use vibrochain_lattice::{
    Barrier, Complex, Contact, MAX_MAGNITUDE, ModalStructure, Model, Resonance, Spectrum, Stop, Stopped, StructureError,
};

use super::masses::Masses;
use super::point::Strike;
use super::response::{FixedPart, Response};
use crate::error::BreatherError;
use crate::orbit::Hit;

/// A linear structure with stops under loads of frequency ω; of an orbit without them, ω is its own.
#[derive(Debug, Clone)]
pub struct LoadedStructure {
    structure: Arc<ModalStructure>,
    omega: f64,
    fixed: Arc<Mutex<KnownParts>>,
    responses: Arc<Mutex<Responses>>,
    stop: Stop,
    /// The lattice around the contacts, if they are masses of one.
    masses: Option<Arc<Masses>>,
}

/// What no frequency changes, of each list of contacts that has been asked for.
type KnownParts = Vec<(Vec<usize>, Arc<FixedPart>)>;

/// What contacts do after impacts at some of them, for each list of these and number of periods: words of one contact share it.
type Responses = Vec<((Vec<usize>, u32), Arc<Response>)>;

impl PartialEq for LoadedStructure {
    fn eq(&self, other: &Self) -> bool {
        (&self.structure, self.omega) == (&other.structure, other.omega)
    }
}

impl LoadedStructure {
    /// The structure at a frequency, in units of the user's.
    ///
    /// # Errors
    /// [`BreatherError::Omega`].
    pub fn new(structure: Arc<ModalStructure>, omega: f64) -> Result<Self, BreatherError> {
        let (fixed, responses, stop) = (Arc::default(), Arc::default(), Stop::default());
        Self { structure, omega, fixed, responses, stop, masses: None }.at(omega)
    }

    /// A lattice with contacts at these lists of masses, as [`Model::felt_structure`] has them.
    ///
    /// # Errors
    /// [`BreatherError`]: no such mass, or a frequency out of range.
    pub(crate) fn of_lattice(model: &Model, contacts: &[Vec<usize>], stop: &Stop) -> Result<Self, BreatherError> {
        Ok(Self::new(Arc::new(model.felt_structure(contacts)?), model.omega())?.until(stop))
    }

    /// The same, whose orbits, and all that is asked of them, are worked out no longer than until the request to stop is raised.
    pub fn until(self, stop: &Stop) -> Self {
        Self { stop: stop.clone(), ..self }
    }

    /// The request to stop.
    pub fn stop(&self) -> &Stop {
        &self.stop
    }

    /// For loops: a look costs nanoseconds.
    pub(super) fn heard(&self) -> Result<(), Stopped> {
        self.stop.heard()
    }

    /// The same structure at another frequency. What does not depend on it is worked out once for all of them.
    ///
    /// # Errors
    /// [`BreatherError::Omega`].
    pub fn at(&self, omega: f64) -> Result<Self, BreatherError> {
        if (1.0 / MAX_MAGNITUDE..=MAX_MAGNITUDE).contains(&omega) {
            let masses = match &self.masses {
                Some(masses) => Some(Arc::new(masses.at(omega).ok_or(BreatherError::Omega { omega })?)),
                None => None,
            };
            let (structure, fixed, stop) = (self.structure.clone(), self.fixed.clone(), self.stop.clone());
            Ok(Self { structure, omega, fixed, responses: Arc::default(), stop, masses })
        } else {
            Err(BreatherError::Omega { omega })
        }
    }

    /// The same structure under the periodic loads of another one, whose modes are the same, times a factor, and all its contacts between these
    /// barriers: what impacts do is the same.
    pub(super) fn with_loads_and_stops(
        &self,
        unit: &ModalStructure,
        factor: f64,
        stop: Contact,
    ) -> Result<Self, BreatherError> {
        let contacts = vec![stop; unit.contacts().len()];
        let structure = unit.with_loads_times(factor, 1.0).with_contacts(contacts)?;
        Ok(Self { structure: Arc::new(structure), ..self.clone() })
    }

    /// The same as a part of a lattice.
    pub(super) fn among(self, masses: Masses) -> Self {
        Self { masses: Some(Arc::new(masses)), ..self }
    }

    /// The lattice around the contacts.
    pub(super) fn masses(&self) -> Option<&Masses> {
        self.masses.as_deref()
    }

    /// A resonance, in a lattice its mode by its wave.
    pub fn by_wave(&self, resonance: Resonance) -> Resonance {
        let wave = self.masses().map(|masses| Spectrum::new(*masses.lattice.chain()).nearest(resonance.frequency));
        Resonance { mode: wave.unwrap_or(resonance.mode), ..resonance }
    }

    /// The number of the mass that a contact of a lattice is; in any other structure, the contact's own number.
    pub fn site(&self, contact: usize) -> usize {
        self.masses().and_then(|masses| masses.sites.get(contact).copied()).unwrap_or(contact)
    }

    /// The contact at a mass of the lattice, if impacts there are felt; of any other structure the number itself.
    pub(super) fn contact_at(&self, site: usize) -> Option<usize> {
        match self.masses() {
            Some(masses) => masses.sites.iter().position(|&own| own == site),
            None => Some(site),
        }
    }

    /// An impact as the equations know it.
    pub(super) fn strike(&self, hit: &Hit) -> Result<Strike, BreatherError> {
        let Hit { site, barrier, time, impulse } = *hit;
        let last = self.structure.contacts().len() - 1;
        let contact = self.contact_at(site).ok_or(BreatherError::NoSuchContact { contact: site, last })?;
        Ok(Strike { contact, barrier, time, impulse })
    }

    /// What no frequency changes, of impacts at these contacts.
    pub(super) fn fixed(&self, hit: &[usize]) -> Arc<FixedPart> {
        let mut known = self.fixed.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, fixed)) = known.iter().find(|(contacts, _)| contacts == hit) {
            return fixed.clone();
        }
        let fixed = Arc::new(FixedPart::new(&self.structure, hit));
        known.push((hit.to_vec(), fixed.clone()));
        fixed
    }

    /// What contacts do after impacts at these, in an orbit of so many periods of the loads.
    pub(super) fn response(&self, hit: &[usize], force_periods: u32) -> Result<Arc<Response>, StructureError> {
        let mut known = self.responses.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, response)) = known.iter().find(|((of, periods), _)| of == hit && *periods == force_periods) {
            return Ok(response.clone());
        }
        let period = self.period() * f64::from(force_periods);
        let response = Arc::new(Response::new(&self.structure, (self.omega, period), self.fixed(hit), hit)?);
        known.push(((hit.to_vec(), force_periods), response.clone()));
        Ok(response)
    }

    /// Place, velocity, acceleration and jerk of a contact in the motion that its loads drive alone, at a time t + ψ of these.
    ///
    /// # Errors
    /// [`BreatherError`] at a resonance, or where there is no such contact.
    pub fn driven(&self, contact: usize, t: f64) -> Result<[f64; 4], BreatherError> {
        let last = self.structure.contacts().len() - 1;
        if contact > last {
            return Err(BreatherError::NoSuchContact { contact, last });
        }
        let response = self.response(&[contact], 1)?;
        let mut jet = response.load(contact, t);
        jet[0] += response.still(contact);
        Ok(jet)
    }

    /// The structure.
    pub fn structure(&self) -> &Arc<ModalStructure> {
        &self.structure
    }

    /// ω
    pub fn omega(&self) -> f64 {
        self.omega
    }

    /// 2π/ω
    pub fn period(&self) -> f64 {
        TAU / self.omega
    }

    /// After which time all loads are the same again.
    pub(super) fn loads_repeat(&self) -> f64 {
        let structure = self.structure();
        let is_there = |place: usize| structure.modes().iter().any(|mode| mode.loads[place] != [Complex::default(); 2]);
        let harmonics = structure.harmonics().iter().enumerate().filter(|(place, _)| is_there(*place));
        let common = harmonics.fold(0, |common, (_, &harmonic)| greatest_divisor(common, harmonic));
        self.period() / f64::from(common.max(1))
    }

    /// A phase of the loads from 0 on, before they are the same again.
    pub(super) fn phase(&self, psi: f64) -> f64 {
        let repeat = self.loads_repeat();
        let psi = psi.rem_euclid(repeat);
        // Of a little less than 0 rounding makes all of it.
        if psi < repeat { psi } else { 0.0 }
    }

    /// Where a barrier of a contact is.
    ///
    /// # Errors
    /// [`BreatherError`]: there is no such contact, or it has no such barrier.
    pub fn barrier(&self, contact: usize, barrier: Barrier) -> Result<f64, BreatherError> {
        let contacts = self.structure.contacts();
        let last = contacts.len() - 1;
        let found = contacts.get(contact).ok_or(BreatherError::NoSuchContact { contact, last })?;
        found.barrier(barrier).ok_or(BreatherError::NoBarrier { contact, barrier })
    }

    /// Where a mass of a lattice has a barrier, as all its masses have; or, of any other structure, a contact.
    ///
    /// # Errors
    /// As [`LoadedStructure::barrier`].
    pub fn barrier_at(&self, site: usize, barrier: Barrier) -> Result<f64, BreatherError> {
        match self.masses() {
            Some(masses) if site < masses.lattice.chain().sites() => Ok(masses.lattice.barrier(barrier)),
            _ => self.barrier(site, barrier),
        }
    }
}

/// The greatest common divisor of two numbers, 0 being a multiple of all.
fn greatest_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { greatest_divisor(b, a % b) }
}

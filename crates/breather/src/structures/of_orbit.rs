//! An orbit of a lattice as one of the lattice as a structure, with contacts at the masses that hit, and back.

use std::sync::{Arc, Mutex, PoisonError};

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::{FeltShapes, Model, Parameter, ParameterError, Stop};

use super::branch::continuation::Branch;
use super::branch::family::{FreeNumbers, ModelFamily};
use super::masses::Masses;
use super::model::LoadedStructure;
use super::orbit::ContactOrbit;
use super::point::Strike;
use crate::branch_error::BranchError;
use crate::error::BreatherError;
use crate::motion::Motion;
use crate::orbit::{Family, Hit, Impact, LatticeOrbit, Of, Orbit};

/// An impact is half a period after the first one where it misses that by no more than this part of it: rounding of what was solved for.
const HALF: f64 = 1e-13;

impl LoadedStructure {
    /// A lattice with contacts at these masses, and all others about them, between the same barriers.
    ///
    /// # Errors
    /// [`BreatherError`]
    pub fn of_masses(lattice: &Model, sites: &[usize], stop: &Stop) -> Result<Self, BreatherError> {
        let contacts: Vec<Vec<usize>> = sites.iter().map(|&site| vec![site]).collect();
        // Loads are those of amplitude 1, times the amplitude: to the bit the same whichever lattice came before.
        let unit = if lattice.amplitude() == 0.0 { *lattice } else { lattice.with(Parameter::Amplitude, 1.0)? };
        let shapes = Arc::new(FeltShapes::of(&unit, &contacts)?);
        Self::of_shapes(&shapes, (lattice, sites), stop)
    }

    /// The same, from another one that is known where that is quicker.
    pub(crate) fn of_masses_from(
        known: Option<&Self>,
        lattice: &Model,
        sites: &[usize],
        stop: &Stop,
    ) -> Result<Self, BreatherError> {
        let has_these = |known: &&Self| known.masses().is_some_and(|masses| masses.sites == sites);
        let moved = known.filter(has_these).and_then(|known| known.moved_to(lattice));
        moved.unwrap_or_else(|| Self::of_masses(lattice, sites, stop))
    }

    fn of_shapes(
        shapes: &Arc<FeltShapes>,
        (lattice, sites): (&Model, &[usize]),
        stop: &Stop,
    ) -> Result<Self, BreatherError> {
        let unit = Arc::new(shapes.structure(lattice.springs(), lattice.dashpots())?);
        let model = Self::new(unit.clone(), lattice.omega())?.until(stop);
        let masses = Masses { lattice: *lattice, sites: sites.to_vec(), shapes: shapes.clone(), unit };
        Ok(model.loaded_as(&masses, lattice)?.among(masses))
    }

    /// Under the loads and between the barriers of a lattice.
    fn loaded_as(&self, masses: &Masses, lattice: &Model) -> Result<Self, BreatherError> {
        let factor = if lattice.amplitude() == 0.0 { 1.0 } else { lattice.amplitude() };
        self.with_loads_and_stops(&masses.unit, factor, lattice.stop())
    }

    /// Models of `family` with contacts at the masses where this model has them, which those at `values` may not have; of any other structure the same.
    #[must_use]
    pub fn like(&self, family: &ModelFamily, values: &[f64]) -> ModelFamily {
        let Some(Masses { sites, .. }) = self.masses() else { return family.clone() };
        let is_like = |model: LoadedStructure| model.masses().is_some_and(|masses| masses.sites == *sites);
        if family(values).is_ok_and(is_like) {
            return family.clone();
        }
        let other = family.clone();
        let lattice = move |values: &[f64]| {
            let model = other(values)?;
            model.masses().map(|masses| masses.lattice).ok_or_else(|| "the structure is no lattice here".to_owned())
        };
        remembering(lattice, sites.clone(), self.stop())
    }

    /// The structure of one lattice as that of another one of which only ω differs, or loads and stops besides, or springs and dashpots besides; `None` of others.
    fn moved_to(&self, at: &Model) -> Option<Result<Self, BreatherError>> {
        let masses = self.masses()?;
        let base = masses.lattice;
        if base == *at {
            return Some(Ok(self.clone()));
        }
        let differ: SmallVec<[Parameter; 2]> = base.differs_in(at)?.collect();
        let moved = |parameters: &[Parameter]| differ.iter().all(|parameter| parameters.contains(parameter));
        if moved(&[Parameter::Omega]) {
            return Some(self.at(at.omega()));
        }
        let mut others: SmallVec<[Parameter; 12]> = smallvec![Parameter::Omega];
        if (base.amplitude() == 0.0) == (at.amplitude() == 0.0) {
            others.extend([Parameter::Amplitude, Parameter::Asymmetry, Parameter::Restitution]);
        }
        if moved(&others) {
            let structure = self.loaded_as(masses, at).and_then(|structure| structure.at(at.omega()));
            return Some(structure.map(|structure| structure.among(masses.of(*at))));
        }
        others.extend([Parameter::Gamma1, Parameter::Gamma2, Parameter::Gamma3]);
        others.extend([Parameter::Damping, Parameter::CouplingDamping]);
        moved(&others).then(|| Self::of_shapes(&masses.shapes, (at, &masses.sites), self.stop()))
    }
}

/// Structures of lattices with contacts at these masses; from the last one, where that is quicker.
pub(crate) fn remembering(
    lattice: impl Fn(&[f64]) -> Result<Model, String> + Send + Sync + 'static,
    sites: Vec<usize>,
    stop: &Stop,
) -> ModelFamily {
    let (stop, last) = (stop.clone(), Mutex::new(None::<LoadedStructure>));
    Arc::new(move |values: &[f64]| {
        let at = lattice(values)?;
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        let new =
            LoadedStructure::of_masses_from(last.as_ref(), &at, &sites, &stop).map_err(|error| error.to_string())?;
        // The first one stays: what is known of it serves all others.
        last.get_or_insert_with(|| new.clone());
        Ok(new)
    })
}

impl Branch {
    /// The branch of a lattice's orbit as one of its parameters varies; a length of `unit` along it counts like a change of order 1 of the orbit.
    ///
    /// # Errors
    /// [`BranchError`] at a resonance, which an orbit that exists has already passed.
    ///
    /// ```
    /// use vibrochain_breather::{Branch, Family, breathers};
    /// use vibrochain_lattice::{Parameter, Point};
    /// let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
    /// let model = ring.omega(1.07).asymmetry(0.8).amplitude(0.165).restitution(0.25).model()?;
    /// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
    /// let mut branch = Branch::of_orbit(orbit, Parameter::Amplitude, 0.1)?;
    /// // Downwards the branch turns back at a fold, 0.157927…
    /// let mut point = branch.start()?.reversed();
    /// let mut least = point.value();
    /// while point.heading() < 0.0 {
    ///     point = branch.step(&point, 0.02)?;
    ///     least = least.min(point.value());
    /// }
    /// assert!((least - 0.15793).abs() < 1e-4 && point.heading() > 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of_orbit(orbit: &Orbit, free: Parameter, unit: f64) -> Result<Self, BranchError> {
        let (stop, lattice) = (Stop::default(), orbit.lattice()?);
        let family = lattice.models(&[free], &stop);
        Self::through(&*orbit.followed(&stop)?, family, lattice.model().get(free), unit, &stop)
    }
}

impl Orbit {
    /// The orbit that Newton's method leads to from here. Times that symmetry fixes stay where they are.
    pub(crate) fn refined(&self, stop: &Stop) -> Result<Self, BreatherError> {
        let (lattice, hits) = (self.lattice()?.model(), self.hits());
        let model = LoadedStructure::of_masses(lattice, &self.hit_sites(), stop)?;
        let near = ContactOrbit::near(&model, self.force_periods(), self.psi_or_zero(), &hits)?;
        near.to_lattice_orbit(lattice, self.family(), None)
    }

    /// That one, where less is left of its equations.
    pub(crate) fn refined_if_better(self, stop: &Stop) -> Self {
        let better = self.refined(stop).ok().filter(|refined| refined.residual() < self.residual());
        better.unwrap_or(self)
    }
}

impl LatticeOrbit<'_> {
    /// Its lattice with contacts at the masses that hit as these parameters vary. What a parameter does not change is worked out once for all its values.
    pub fn models(self, free: &[Parameter], stop: &Stop) -> ModelFamily {
        let (free, lattice) = (free.to_vec(), *self.model());
        let set = |lattice: Model, (free, value): (&Parameter, &f64)| lattice.with(*free, *value);
        let at = move |values: &[f64]| {
            free.iter().zip(values).try_fold(lattice, set).map_err(|error: ParameterError| error.to_string())
        };
        remembering(at, self.hit_sites(), stop)
    }

    /// These parameters as numbers that vary, from where the orbit has them.
    pub fn numbers(self, free: &[Parameter], stop: &Stop) -> FreeNumbers {
        FreeNumbers {
            models: self.models(free, stop),
            start: free.iter().map(|parameter| self.model().get(*parameter)).collect(),
            names: free.iter().map(|parameter| parameter.name().to_owned()).collect(),
            coupling: free.iter().position(|parameter| *parameter == Parameter::Gamma2),
        }
    }
}

impl ContactOrbit {
    /// A lattice's orbit as one of the lattice with contacts at the masses that hit.
    ///
    /// # Errors
    /// [`BreatherError`]
    pub fn of_orbit(orbit: &Orbit, stop: &Stop) -> Result<Self, BreatherError> {
        let orbit = orbit.lattice()?;
        Self::of_orbit_in(&LoadedStructure::of_masses(orbit.model(), &orbit.hit_sites(), stop)?, orbit)
    }

    /// The same, of the lattice as a structure whose contacts are the masses that hit, rising.
    pub(crate) fn of_orbit_in(model: &LoadedStructure, orbit: LatticeOrbit<'_>) -> Result<Self, BreatherError> {
        let (sites, impacts) = (orbit.hit_sites(), orbit.impacts());
        let first = impacts.first().map_or(0.0, |impact| impact.time);
        let strike = |impact: &Impact| Strike {
            contact: sites.partition_point(|site| *site < impact.site),
            barrier: impact.barrier,
            time: impact.time - first,
            impulse: impact.impulse,
        };
        let since = (orbit.force_periods(), orbit.psi_or_zero() + first);
        Self::given(model, since, impacts.iter().map(strike).collect())
    }

    /// The same among contacts at more masses of the lattice, each where one of these hits is; of any other structure as it is.
    pub(super) fn with_contacts_at(&self, hits: &[Hit]) -> Result<Self, BreatherError> {
        let Some(Masses { lattice, sites, .. }) = self.model().masses() else { return Ok(self.clone()) };
        let mut sites = sites.clone();
        for hit in hits {
            if !sites.contains(&hit.site) {
                sites.push(hit.site);
            }
        }
        let model = LoadedStructure::of_masses(lattice, &sites, self.model().stop())?;
        // Contacts that were there keep their numbers.
        Self::given(&model, (self.force_periods(), self.psi().unwrap_or(0.0)), self.strikes().collect())
    }

    /// The same orbit with all masses of the lattice, those too that hit nothing; `None` where the structure is no lattice.
    pub fn of_all_masses(&self) -> Option<Result<Orbit, BreatherError>> {
        let Masses { lattice, .. } = self.model().masses()?;
        let known = self.has_bounds().then(|| Arc::new(self.clone()));
        Some(self.in_lattice(lattice, None).map(|orbit| orbit.known_as(known)))
    }

    /// As an orbit of a lattice, given by its impacts, half a period after the first one where they are but for rounding.
    fn in_lattice(&self, lattice: &Model, room: Option<&mut Motion>) -> Result<Orbit, BreatherError> {
        let (mut hits, half) = (self.hits(), 0.5 * self.period());
        let near = |hit: &&mut Hit| (hit.time - half).abs() <= HALF * half;
        hits.iter_mut().filter(near).for_each(|hit| hit.time = half);
        Orbit::from_impulses_in(room, lattice, self.force_periods(), self.psi().unwrap_or(0.0), &hits)
    }

    /// The number of the impact that an orbit of this family begins with: of a doubled orbit of the paper, the impact before the longer flight.
    ///
    /// ```
    /// use vibrochain_breather::{Family, ContactOrbit, breathers};
    /// use vibrochain_lattice::{Point, Stop};
    /// let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
    /// let model = ring.omega(1.07).asymmetry(0.8).amplitude(0.1582).restitution(0.25).model()?;
    /// let found = breathers(&model, Family::PeriodDoubled)?;
    /// let doubled = ContactOrbit::of_orbit(&found.orbits[0], &Stop::default())?;
    /// assert_eq!(doubled.first_of(Family::PeriodDoubled), 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn first_of(&self, family: Family) -> usize {
        let is_shorter = self.phi().is_some_and(|phi| phi < 0.5 * self.period());
        let is_doubled = matches!(family, Family::SingleSided | Family::PeriodDoubled) && self.force_periods() == 2;
        usize::from(is_doubled && is_shorter)
    }

    /// What it is told as: of a lattice around the contacts with all its masses, of this family as long as its impacts are those of the family; of
    /// any other structure as it is.
    ///
    /// # Errors
    /// [`BreatherError`] at a resonance.
    pub fn to_orbit(&self, family: Family) -> Result<Orbit, BreatherError> {
        match self.model().masses() {
            Some(Masses { lattice, .. }) => self.to_lattice_orbit(lattice, family, None),
            None => Ok(Orbit::of_structure(Arc::new(self.clone()))),
        }
    }

    /// The same, which keeps what contacts know of it.
    ///
    /// # Errors
    /// As [`ContactOrbit::to_orbit`].
    pub fn into_orbit(self, family: Family) -> Result<Orbit, BreatherError> {
        self.into_orbit_in(None, family)
    }

    /// The same in the room of a motion, which is left holding an orbit of a lattice.
    pub(crate) fn into_orbit_in(self, room: Option<&mut Motion>, family: Family) -> Result<Orbit, BreatherError> {
        match self.model().masses() {
            Some(Masses { lattice, .. }) => match self.first_of(family) {
                0 => Ok(self.to_lattice_orbit(lattice, family, room)?.known_as(Some(Arc::new(self)))),
                first => self.begun_with(first)?.into_orbit_in(room, family),
            },
            None => Ok(Orbit::of_structure(Arc::new(self))),
        }
    }

    /// The same as an orbit of a lattice, of this family as long as its impacts are those of the family.
    fn to_lattice_orbit(
        &self,
        lattice: &Model,
        family: Family,
        room: Option<&mut Motion>,
    ) -> Result<Orbit, BreatherError> {
        let mut orbit = match self.first_of(family) {
            0 => self.in_lattice(lattice, room)?,
            first => self.begun_with(first)?.in_lattice(lattice, room)?,
        };
        orbit.family = match (family, orbit.impacts().len(), self.force_periods(), orbit.impact_site()) {
            (_, _, _, None) => Family::Word,
            (Family::SingleSided, 2, 2, _) => Family::PeriodDoubled,
            (Family::PeriodDoubled, 1, 1, _) => Family::SingleSided,
            (Family::SingleSided, 1, 1, _) | (Family::DoubleSided, 2, 1, _) | (Family::PeriodDoubled, 2, 2, _) => {
                family
            }
            _ => Family::Word,
        };
        Ok(orbit)
    }
}

impl Orbit {
    /// The orbit of a structure that contacts know.
    pub(crate) fn of_structure(at_contacts: Arc<ContactOrbit>) -> Self {
        Self {
            family: Family::Word,
            force_periods: at_contacts.force_periods(),
            psi: at_contacts.psi().unwrap_or(0.0),
            impacts: at_contacts.impacts().into(),
            residual: at_contacts.violation(),
            of: Of::Structure(at_contacts),
        }
    }

    /// The orbit as one that a branch or a curve begins with.
    ///
    /// # Errors
    /// [`BreatherError`] at a resonance.
    pub fn followed(&self, stop: &Stop) -> Result<Arc<ContactOrbit>, BreatherError> {
        match self.model() {
            // Among contacts at masses, so that what is told of it is told of all masses.
            Some(_) => Ok(Arc::new(ContactOrbit::of_orbit(self, stop)?)),
            None => self.at_contacts(stop),
        }
    }
}

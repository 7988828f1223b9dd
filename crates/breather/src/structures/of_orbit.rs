//! An orbit of a lattice as one of the lattice as a structure, with contacts at the masses that hit, and back.

use std::sync::{Arc, Mutex, PoisonError};

use vibrochain_lattice::{FeltShapes, Model, Parameter, ParameterError, Stop};

use super::branch::continuation::Branch;
use super::branch::family::ModelFamily;
use super::masses::Masses;
use super::model::StructureModel;
use super::orbit::StructureOrbit;
use super::point::Strike;
use crate::branch_error::BranchError;
use crate::error::BreatherError;
use crate::orbit::{Family, Hit, Impact, Orbit};

/// An impact is half a period after the first one where it misses that by no more than this part of it: rounding of what was solved for.
const HALF: f64 = 1e-13;

impl StructureModel {
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
        let chain = lattice.chain();
        let unit = Arc::new(shapes.structure([chain.gamma1(), chain.gamma2(), chain.gamma3()])?);
        let model = Self::new(unit.clone(), lattice.omega())?.until(stop);
        let masses = Masses { lattice: *lattice, sites: sites.to_vec(), shapes: shapes.clone(), unit };
        Ok(model.loaded_as(&masses, lattice)?.among(masses))
    }

    /// Under the loads and between the barriers of a lattice.
    fn loaded_as(&self, masses: &Masses, lattice: &Model) -> Result<Self, BreatherError> {
        let factor = if lattice.amplitude() == 0.0 { 1.0 } else { lattice.amplitude() };
        self.with_loads_and_stops(&masses.unit, factor, lattice.stop())
    }

    /// These of a lattice as some of its parameters vary. What a parameter does not change is worked out once for all its values.
    pub fn family(lattice: Model, free: &[Parameter], sites: &[usize], stop: &Stop) -> ModelFamily {
        let free = free.to_vec();
        let set = |lattice: Model, (free, value): (&Parameter, &f64)| lattice.with(*free, *value);
        let at = move |values: &[f64]| {
            free.iter().zip(values).try_fold(lattice, set).map_err(|error: ParameterError| error.to_string())
        };
        remembering(at, sites.to_vec(), stop)
    }

    /// Models of `family` with contacts at the masses where this model has them, which those at `values` may not have; of any other structure the same.
    #[must_use]
    pub fn like(&self, family: &ModelFamily, values: &[f64]) -> ModelFamily {
        let Some(Masses { sites, .. }) = self.masses() else { return family.clone() };
        let is_like = |model: StructureModel| model.masses().is_some_and(|masses| masses.sites == *sites);
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

    /// The structure of one lattice as that of another one of which only ω differs, or springs besides, or loads and stops besides; `None` of others.
    fn moved_to(&self, at: &Model) -> Option<Result<Self, BreatherError>> {
        let masses = self.masses()?;
        let base = masses.lattice;
        if base == *at {
            return Some(Ok(self.clone()));
        }
        let differs = |parameter: &Parameter| base.get(*parameter) != at.get(*parameter);
        let moved = |parameters: &[Parameter]| {
            let with = |model: Model, parameter: &Parameter| model.with(*parameter, at.get(*parameter)).ok();
            let moved = parameters.iter().filter(|parameter| differs(parameter)).try_fold(base, with);
            moved.is_some_and(|moved| moved == *at)
        };
        if moved(&[Parameter::Omega]) {
            return Some(self.at(at.omega()));
        }
        let mut others = vec![Parameter::Omega];
        if (base.amplitude() == 0.0) == (at.amplitude() == 0.0) {
            others.extend([Parameter::Amplitude, Parameter::Asymmetry, Parameter::Restitution]);
        }
        if moved(&others) {
            let structure = self.loaded_as(masses, at).and_then(|structure| structure.at(at.omega()));
            return Some(structure.map(|structure| structure.among(masses.of(*at))));
        }
        others.extend([Parameter::Gamma1, Parameter::Gamma2, Parameter::Gamma3]);
        moved(&others).then(|| Self::of_shapes(&masses.shapes, (at, &masses.sites), self.stop()))
    }
}

/// Structures of lattices with contacts at these masses; from the last one, where that is quicker.
pub(crate) fn remembering(
    lattice: impl Fn(&[f64]) -> Result<Model, String> + Send + Sync + 'static,
    sites: Vec<usize>,
    stop: &Stop,
) -> ModelFamily {
    let (stop, last) = (stop.clone(), Mutex::new(None::<StructureModel>));
    Arc::new(move |values: &[f64]| {
        let at = lattice(values)?;
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        let new =
            StructureModel::of_masses_from(last.as_ref(), &at, &sites, &stop).map_err(|error| error.to_string())?;
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
        let stop = Stop::default();
        let (start, family, values) = StructureOrbit::along(orbit, &[free], &stop)?;
        Self::through(&start, family, values[0], unit, &stop)
    }
}

impl Orbit {
    /// The same orbit as contacts at the masses that hit know it, with its errors; what is asked of it is worked out until `stop` is raised.
    ///
    /// # Errors
    /// [`BreatherError`], where the lattice has no kernel: exactly at a resonance.
    pub fn at_contacts(&self, stop: &Stop) -> Result<Arc<StructureOrbit>, BreatherError> {
        self.at_contacts_from(&mut None, stop)
    }

    /// The same from a structure with contacts at the masses of another lattice's orbit, which it replaces.
    pub(crate) fn at_contacts_from(
        &self,
        known: &mut Option<Box<StructureModel>>,
        stop: &Stop,
    ) -> Result<Arc<StructureOrbit>, BreatherError> {
        let memo = &self.at_contacts.0;
        let mut worked_out = || {
            let model = StructureModel::of_masses_from(known.as_deref(), self.model(), &self.hit_sites(), stop)?;
            StructureOrbit::of_orbit_in(known.insert(Box::new(model)), self).map(Arc::new)
        };
        match memo.get() {
            Some(Ok(known)) if !known.model().stop().is_same(stop) => Ok(Arc::new(known.as_ref().clone().until(stop))),
            Some(known) => known.clone(),
            // The modes of a large lattice are not kept, and its structure is made for these springs alone.
            None if !self.model().chain().is_kept() => {
                let contacts: Vec<Vec<usize>> = self.hit_sites().into_iter().map(|site| vec![site]).collect();
                let model = StructureModel::of_lattice(self.model(), &contacts, stop)?;
                StructureOrbit::of_orbit_in(&model, self).map(Arc::new)
            }
            None => match worked_out() {
                Err(stopped @ BreatherError::Stopped(_)) => Err(stopped),
                known => memo.get_or_init(|| known).clone(),
            },
        }
    }

    /// The orbit that Newton's method leads to from here. Times that symmetry fixes stay where they are.
    pub(crate) fn refined(&self, stop: &Stop) -> Result<Self, BreatherError> {
        let model = StructureModel::of_masses(self.model(), &self.hit_sites(), stop)?;
        let hits: Vec<Hit> = self.impacts().iter().map(Hit::from).collect();
        let near = StructureOrbit::near(&model, self.force_periods(), self.psi_or_zero(), &hits)?;
        near.to_orbit(self.model(), self.family())
    }

    /// That one, where less is left of its equations.
    pub(crate) fn refined_if_better(self, stop: &Stop) -> Self {
        let better = self.refined(stop).ok().filter(|refined| refined.residual() < self.residual());
        better.unwrap_or(self)
    }
}

impl StructureOrbit {
    /// A lattice's orbit as one of the lattice with contacts at the masses that hit.
    ///
    /// # Errors
    /// [`BreatherError`]
    pub fn of_orbit(orbit: &Orbit, stop: &Stop) -> Result<Self, BreatherError> {
        Self::of_orbit_in(&StructureModel::of_masses(orbit.model(), &orbit.hit_sites(), stop)?, orbit)
    }

    /// The same, of the lattice as a structure whose contacts are the masses that hit, rising.
    fn of_orbit_in(model: &StructureModel, orbit: &Orbit) -> Result<Self, BreatherError> {
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

    /// The same, its models as these parameters of the lattice vary, and their values here: where a branch or a curve begins.
    ///
    /// # Errors
    /// As [`StructureOrbit::of_orbit`].
    pub fn along(
        orbit: &Orbit,
        free: &[Parameter],
        stop: &Stop,
    ) -> Result<(Self, ModelFamily, Vec<f64>), BreatherError> {
        let family = StructureModel::family(*orbit.model(), free, &orbit.hit_sites(), stop);
        let values = free.iter().map(|parameter| orbit.model().get(*parameter)).collect();
        Ok((Self::of_orbit(orbit, stop)?, family, values))
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
        let model = StructureModel::of_masses(lattice, &sites, self.model().stop())?;
        // Contacts that were there keep their numbers.
        Self::given(&model, (self.force_periods(), self.psi().unwrap_or(0.0)), self.strikes().collect())
    }

    /// The same orbit with all masses of the lattice, those too that hit nothing; `None` where the structure is no lattice.
    pub fn of_all_masses(&self) -> Option<Result<Orbit, BreatherError>> {
        let Masses { lattice, .. } = self.model().masses()?;
        let hits = self.hits_by_halves();
        let orbit = Orbit::from_impulses(lattice, self.force_periods(), self.psi().unwrap_or(0.0), &hits);
        let known = self.has_bounds().then(|| Arc::new(self.clone()));
        Some(orbit.map(|orbit| Orbit { at_contacts: known.into(), ..orbit }))
    }

    /// The impacts, half a period after the first one where they are but for rounding.
    fn hits_by_halves(&self) -> Vec<Hit> {
        let (mut hits, half) = (self.hits(), 0.5 * self.period());
        let near = |hit: &&mut Hit| (hit.time - half).abs() <= HALF * half;
        hits.iter_mut().filter(near).for_each(|hit| hit.time = half);
        hits
    }

    /// The same as an orbit of a lattice, of this family as long as its impacts are those of the family; a doubled one begins with the longer flight.
    ///
    /// # Errors
    /// [`BreatherError`] at a resonance.
    pub fn to_orbit(&self, model: &Model, family: Family) -> Result<Orbit, BreatherError> {
        let turned = matches!(family, Family::SingleSided | Family::PeriodDoubled)
            && self.force_periods() == 2
            && self.phi().is_some_and(|phi| phi < 0.5 * self.period());
        let begun = if turned { &self.begun_with(1)? } else { self };
        let (hits, psi) = (begun.hits_by_halves(), begun.psi().unwrap_or(0.0));
        let mut orbit = Orbit::from_impulses(model, self.force_periods(), psi, &hits)?;
        let alone = hits.iter().all(|hit| hit.site == hits[0].site);
        orbit.family = match (family, hits.len(), self.force_periods()) {
            (Family::SingleSided, 2, 2) if alone => Family::PeriodDoubled,
            (Family::PeriodDoubled, 1, 1) => Family::SingleSided,
            (Family::SingleSided, 1, 1) | (Family::DoubleSided, 2, 1) | (Family::PeriodDoubled, 2, 2) if alone => {
                family
            }
            _ => Family::Word,
        };
        Ok(orbit)
    }
}

//! The one type for all periodic orbits: a lattice or any other structure, a force, a period and a list of impacts.
//!
//! ```text
//! v_n(t) = Σ_i P_i K_{n−n_i}(t−t_i) + G(t+ψ),          G(t) = Ã cos ωt, or Σ Ã_j cos(jωt+θ_j)   (superposition)
//! velocity before/after impact i:  w_i ∓ P_i/2,         w_i = Σ_{j≠i} P_j K′(t_i−t_j) + Ġ(t_i+ψ)
//! Newton's law:  w_i = −q P_i/2,   q = (1−e)/(1+e);     position:  v(t_i) = a ± 1         (docs/guide/orbits.md)
//! ```

pub(crate) mod assembly;
pub(crate) mod delicate;
pub(crate) mod display;
mod draft;
mod family;
pub(crate) mod impact;
mod in_lattice;
mod named;
pub(crate) mod order;
#[cfg(feature = "serde")]
pub(crate) mod serde_impl;
pub(crate) mod symmetries;

use std::sync::Arc;

use smallvec::SmallVec;
use vibrochain_lattice::{Model, Stop};

pub(crate) use draft::{Draft, Source, WRONG_SIGN, sources};
pub use family::Family;
pub(crate) use impact::SIMULTANEOUS;
pub use impact::{Hit, Impact, time_between};
#[cfg(feature = "serde")]
pub(crate) use in_lattice::AtContacts;
pub use in_lattice::LatticeOrbit;
pub(crate) use in_lattice::{LatticePart, Reflection};

use crate::error::BreatherError;
use crate::structures::model::LoadedStructure;
use crate::structures::orbit::ContactOrbit;

/// A solution that violates its equations by more than this is not listed: rounding has left nothing of it.
pub(crate) const MOST_RESIDUAL: f64 = 0.1;

/// A periodic orbit with impacts, of a lattice or of any other structure with stops.
#[derive(Debug, Clone, PartialEq)]
pub struct Orbit {
    pub(crate) family: Family,
    pub(crate) force_periods: u32,
    pub(crate) psi: f64,
    pub(crate) impacts: SmallVec<[Impact; 2]>,
    pub(crate) residual: f64,
    pub(crate) of: Of,
}

/// What moves.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "in a box each of a map's orbits would take an allocation more")]
pub(crate) enum Of {
    /// A lattice all masses of which have barriers.
    Lattice(LatticePart),
    /// Any other structure, by what its contacts know.
    Structure(Arc<ContactOrbit>),
}

impl Orbit {
    /// The lattice that moves; `None` of any other structure.
    pub fn model(&self) -> Option<&Model> {
        match &self.of {
            Of::Lattice(part) => Some(&part.model),
            Of::Structure(_) => None,
        }
    }

    /// The orbit in terms of contacts, if it is one of a structure; `None` for a lattice, where [`Orbit::at_contacts`] works that out.
    pub fn contacts(&self) -> Option<&Arc<ContactOrbit>> {
        match &self.of {
            Of::Lattice(_) => None,
            Of::Structure(at_contacts) => Some(at_contacts),
        }
    }

    /// With what only orbits of lattices have.
    ///
    /// # Errors
    /// [`BreatherError::NoLattice`].
    pub fn lattice(&self) -> Result<LatticeOrbit<'_>, BreatherError> {
        match &self.of {
            Of::Lattice(part) => Ok(LatticeOrbit::new(self, part)),
            Of::Structure(_) => Err(BreatherError::NoLattice),
        }
    }

    /// The same orbit as contacts know it, with its errors: those of the structure, or of a lattice contacts at the masses that hit. What is
    /// asked of it is worked out until `stop` is raised.
    ///
    /// # Errors
    /// [`BreatherError`], where a lattice has no kernel: exactly at a resonance.
    pub fn at_contacts(&self, stop: &Stop) -> Result<Arc<ContactOrbit>, BreatherError> {
        self.at_contacts_from(&mut None, stop)
    }

    /// The same; of a lattice from a structure with contacts at the masses of another orbit, which it replaces.
    pub(crate) fn at_contacts_from(
        &self,
        known: &mut Option<Box<LoadedStructure>>,
        stop: &Stop,
    ) -> Result<Arc<ContactOrbit>, BreatherError> {
        match &self.of {
            Of::Lattice(part) => LatticeOrbit::new(self, part).at_contacts_from(known, stop),
            Of::Structure(known) => ContactOrbit::until(known, stop).bounded(),
        }
    }

    /// The family.
    pub fn family(&self) -> Family {
        self.family
    }

    /// Periods of the force in one period of the orbit: 1, or 2 for a doubled orbit.
    pub fn force_periods(&self) -> u32 {
        self.force_periods
    }

    /// Period of the orbit.
    pub fn period(&self) -> f64 {
        self.force_period() * f64::from(self.force_periods)
    }

    /// Period of the force; of an orbit without one, its own.
    pub fn force_period(&self) -> f64 {
        match &self.of {
            Of::Lattice(part) => part.model.period(),
            Of::Structure(at_contacts) => at_contacts.model().period(),
        }
    }

    /// Frequency ω of the force; of an orbit without one, its own.
    pub fn omega(&self) -> f64 {
        match &self.of {
            Of::Lattice(part) => part.model.omega(),
            Of::Structure(at_contacts) => at_contacts.model().omega(),
        }
    }

    /// Base frequency of the orbit, 2π/period.
    pub fn frequency(&self) -> f64 {
        self.omega() / f64::from(self.force_periods)
    }

    /// Whether it has a force, or loads that change.
    pub fn is_forced(&self) -> bool {
        match &self.of {
            Of::Lattice(part) => part.model.amplitude() > 0.0,
            Of::Structure(at_contacts) => at_contacts.psi().is_some(),
        }
    }

    /// Whether it has neither a force nor losses: it may begin at any time.
    pub fn is_conservative(&self) -> bool {
        match &self.of {
            Of::Lattice(part) => part.model.is_conservative(),
            Of::Structure(at_contacts) => at_contacts.is_conservative(),
        }
    }

    /// Whether no load acts on it, but losses that a dashpot of negative damping makes up for: it has a period of its own, and may begin at any time.
    pub fn is_self_excited(&self) -> bool {
        self.contacts().is_some_and(|contacts| contacts.is_self_excited())
    }

    /// The error of the period: 0 where a frequency gives it.
    pub fn period_error(&self) -> f64 {
        self.contacts().map_or(0.0, |contacts| contacts.period_error())
    }

    /// Whether barriers on either side are as far from 0, so that an orbit may have a mirror image that hits the others.
    pub fn is_centred(&self) -> bool {
        match &self.of {
            Of::Lattice(part) => part.model.asymmetry() == 0.0,
            Of::Structure(at_contacts) => at_contacts.is_centred(),
        }
    }

    /// A time before 0 when every mass has room: the middle of the last flight.
    pub fn time_in_last_flight(&self) -> f64 {
        let last = self.impacts.last().map_or(0.0, |impact| impact.time);
        0.5 * (last - self.period())
    }

    /// Phase ψ of the force at t = 0, as a time, 0 ≤ ψ < T. `None` without force.
    pub fn psi(&self) -> Option<f64> {
        // No −0.
        self.is_forced().then_some(self.psi + 0.0)
    }

    /// Time φ of the second impact of two, of a lattice's if their family has two. `None` for the others.
    pub fn phi(&self) -> Option<f64> {
        match (&self.of, self.family, self.impacts.as_slice()) {
            (Of::Structure(_), _, [_, second]) | (_, Family::DoubleSided | Family::PeriodDoubled, [_, second]) => {
                Some(second.time)
            }
            _ => None,
        }
    }

    /// The impacts in order of time.
    pub fn impacts(&self) -> &[Impact] {
        &self.impacts
    }

    /// The impulses of its impacts, in the same order.
    pub fn impulses(&self) -> Vec<f64> {
        self.impacts.iter().map(|impact| impact.impulse).collect()
    }

    /// The largest impulse, as it is signed; none without impacts.
    pub fn strongest_impulse(&self) -> Option<f64> {
        self.impacts.iter().map(|impact| impact.impulse).max_by(|a, b| a.abs().total_cmp(&b.abs()))
    }

    /// The size of the largest impulse; 0 without impacts.
    pub fn strength(&self) -> f64 {
        self.strongest_impulse().map_or(0.0, f64::abs)
    }

    /// The impacts as they are given.
    pub fn hits(&self) -> Vec<Hit> {
        self.impacts.iter().map(Hit::from).collect()
    }

    /// The site that takes all impacts, if there is only one; of a structure the contact.
    pub fn impact_site(&self) -> Option<usize> {
        let (first, others) = self.impacts.split_first()?;
        others.iter().all(|impact| impact.site == first.site).then_some(first.site)
    }

    /// The sites that are hit, rising; of a structure the contacts.
    pub fn hit_sites(&self) -> Vec<usize> {
        let mut sites: Vec<usize> = self.impacts.iter().map(|impact| impact.site).collect();
        sites.sort_unstable();
        sites.dedup();
        sites
    }

    /// The impacts by instants, in order of time.
    pub fn instants(&self) -> impl Iterator<Item = &[Impact]> {
        let close = SIMULTANEOUS * self.period();
        self.impacts.chunk_by(move |earlier, later| later.time - earlier.time <= close)
    }

    /// The orbit is its own mirror image in time about t = 0 (conservative, all impacts at 0 and half a period,
    /// at any sites): half a period tells all.
    pub fn is_reversible(&self) -> bool {
        matches!(&self.of, Of::Lattice(LatticePart { fixed_times: true, .. }))
    }

    /// Largest violation of the defining equations, evaluated by superposition from the impulses: |v(t_i) − (a±1)| over the
    /// larger of 1 and |Ã| (or Σ|Ã_j|), and |w_i + qP_i/2| over the largest of |P_j| and ω|Ã| (or Σ jω|Ã_j|). Rounding level
    /// for a sound orbit.
    pub fn residual(&self) -> f64 {
        self.residual
    }

    /// It meets its own equations well enough to be called an orbit. Next to a resonance, where impulses grow without bound, rounding can
    /// prevent that.
    pub(crate) fn is_sound(&self) -> bool {
        self.residual <= MOST_RESIDUAL
    }

    pub(crate) fn psi_or_zero(&self) -> f64 {
        self.psi
    }
}

//! What an orbit of a lattice has beside its impacts: the uniform motion under the force, symmetries of the ring, and what contacts at the
//! masses that hit know of it, once that is asked for.

use std::fmt;
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use smallvec::SmallVec;
use vibrochain_lattice::{Model, Steady, Stop};

use crate::error::BreatherError;
use crate::orbit::{Impact, Of, Orbit, Source};
use crate::structures::model::LoadedStructure;
use crate::structures::orbit::ContactOrbit;

/// What only an orbit of a lattice has.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LatticePart {
    pub(crate) model: Model,
    pub(crate) steady: Steady,
    pub(crate) sources: SmallVec<[Source; 1]>,
    pub(crate) uniform_offset: f64,
    pub(crate) fixed_times: bool,
    /// The same orbit as contacts at the masses that hit know it.
    pub(crate) at_contacts: AtContacts,
}

/// Worked out when it is first asked for; an error where the lattice has no kernel, exactly at a resonance.
#[derive(Clone, Default)]
pub(crate) struct AtContacts(OnceLock<Result<Arc<ContactOrbit>, BreatherError>>);

impl From<Option<Arc<ContactOrbit>>> for AtContacts {
    fn from(known: Option<Arc<ContactOrbit>>) -> Self {
        Self(known.map_or_else(OnceLock::new, |known| OnceLock::from(Ok(known))))
    }
}

/// Pages of modes would tell nobody more.
impl fmt::Debug for AtContacts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AtContacts").finish_non_exhaustive()
    }
}

/// What follows from all else of an orbit makes no difference.
impl PartialEq for AtContacts {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Impulses and times of an orbit that differ by this part of the largest one, or of the period, are the same but for rounding.
const ALIKE: f64 = 32.0 * f64::EPSILON;

/// A reflection of a ring: site n comes to `mirror` − n, and what happens there half a period later if it is `delayed`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Reflection {
    pub(crate) mirror: usize,
    pub(crate) delayed: bool,
}

impl Reflection {
    /// Where a site of a ring of `sites` masses comes to.
    pub(crate) fn image(self, site: usize, sites: usize) -> usize {
        (self.mirror + sites - site) % sites
    }
}

/// An [`Orbit`] of a lattice, with what only these have.
///
/// ```
/// use vibrochain_breather::{Family, breathers};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4)?;
/// let found = breathers(&model, Family::DoubleSided)?;
/// let orbit = found.orbits[0].lattice()?;
/// assert_eq!((orbit.model().chain().sites(), orbit.centre(), orbit.impacts().len()), (21, Some(0), 2));
/// # Ok::<(), vibrochain_breather::BreatherError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct LatticeOrbit<'a> {
    orbit: &'a Orbit,
    part: &'a LatticePart,
}

impl Deref for LatticeOrbit<'_> {
    type Target = Orbit;

    fn deref(&self) -> &Orbit {
        self.orbit
    }
}

impl Orbit {
    /// This orbit, with its description in terms of contacts, where that has been worked out already.
    pub(crate) fn known_as(mut self, known: Option<Arc<ContactOrbit>>) -> Self {
        if let Of::Lattice(part) = &mut self.of {
            part.at_contacts = known.into();
        }
        self
    }
}

impl<'a> LatticeOrbit<'a> {
    pub(super) fn new(orbit: &'a Orbit, part: &'a LatticePart) -> Self {
        Self { orbit, part }
    }

    /// The orbit.
    pub fn orbit(self) -> &'a Orbit {
        self.orbit
    }

    /// The parameters.
    pub fn model(self) -> &'a Model {
        &self.part.model
    }

    /// The largest length in the conditions of position: half the gap, or the swing of the force.
    pub(crate) fn length_scale(self) -> f64 {
        self.part.steady.bound(0).max(1.0)
    }

    /// The largest velocity in Newton's law at the impacts.
    pub(crate) fn velocity_scale(self) -> f64 {
        let force = self.part.steady.bound(1);
        self.impacts().iter().map(|impact| impact.impulse.abs()).fold(force.max(f64::MIN_POSITIVE), f64::max)
    }

    /// Ã = A/(γ₁−ω²), 0 without force; of a force of several harmonics the bound Σ|A_j/(γ₁−j²ω²)|.
    pub fn force_response(self) -> f64 {
        self.part.steady.reach()
    }

    /// G, the uniform motion driven by the force, as a function of t+ψ.
    pub fn steady(self) -> &'a Steady {
        &self.part.steady
    }

    /// The site about which the motion of a ring is symmetric, because it takes all impacts: modes odd about it stay at rest, and
    /// half of the masses tell all. `None` where several sites are hit, and on other lattices.
    pub fn centre(self) -> Option<usize> {
        self.impact_site().filter(|_| self.model().chain().is_ring())
    }

    /// The site that takes all impacts, if there is only one.
    pub fn impact_site(self) -> Option<usize> {
        match self.sources() {
            [source] => Some(source.site),
            _ => None,
        }
    }

    /// The reflection of a ring that leaves the motion as it is, or is half a period away from doing so.
    pub(crate) fn reflection(self) -> Option<Reflection> {
        let sources = self.sources();
        let first = sources.first().filter(|_| self.model().chain().is_ring())?;
        if sources.len() == 1 {
            return Some(Reflection { mirror: 2 * first.site, delayed: false });
        }
        let (sites, period) = (self.model().chain().sites(), self.period());
        let strongest = self.impacts().iter().fold(0.0, |most: f64, impact| most.max(impact.impulse.abs()));
        let is_image = |reflection: Reflection, impact: &Impact| {
            let (site, delay) =
                (reflection.image(impact.site, sites), if reflection.delayed { 0.5 * period } else { 0.0 });
            self.impacts().iter().any(|other| {
                let apart = (impact.time - other.time).abs() - delay;
                let differ = (impact.impulse - other.impulse).abs();
                other.site == site
                    && other.barrier == impact.barrier
                    && apart.abs() <= ALIKE * period
                    && differ <= ALIKE * strongest
            })
        };
        let candidates = sources
            .iter()
            .flat_map(|source| [false, true].map(|delayed| Reflection { mirror: first.site + source.site, delayed }));
        candidates.into_iter().find(|&reflection| self.impacts().iter().all(|impact| is_image(reflection, impact)))
    }

    pub(crate) fn sources(self) -> &'a [Source] {
        &self.part.sources
    }

    pub(crate) fn uniform_offset(self) -> f64 {
        self.part.uniform_offset
    }

    /// As [`Orbit::at_contacts_from`].
    pub(crate) fn at_contacts_from(
        self,
        known: &mut Option<Box<LoadedStructure>>,
        stop: &Stop,
    ) -> Result<Arc<ContactOrbit>, BreatherError> {
        let memo = &self.part.at_contacts.0;
        let mut worked_out = || {
            let model = LoadedStructure::of_masses_from(known.as_deref(), self.model(), &self.hit_sites(), stop)?;
            ContactOrbit::of_orbit_in(known.insert(Box::new(model)), self).map(Arc::new)
        };
        match memo.get() {
            Some(Ok(known)) => ContactOrbit::until(known, stop).bounded(),
            Some(failed) => failed.clone(),
            // The modes of a large lattice are not kept, and its structure is made for these springs alone.
            None if !self.model().chain().is_kept() => {
                let contacts: Vec<Vec<usize>> = self.hit_sites().into_iter().map(|site| vec![site]).collect();
                let model = LoadedStructure::of_lattice(self.model(), &contacts, stop)?;
                ContactOrbit::of_orbit_in(&model, self).map(Arc::new)
            }
            None => match worked_out() {
                Err(stopped @ BreatherError::Stopped(_)) => Err(stopped),
                known => memo.get_or_init(|| known).clone(),
            },
        }
    }
}

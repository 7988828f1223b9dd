//! The one type for all periodic orbits: a chain, a force, a period and a list of impacts.
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
mod named;
pub(crate) mod order;
#[cfg(feature = "serde")]
pub(crate) mod serde_impl;
pub(crate) mod symmetries;

use std::fmt;
use std::sync::{Arc, OnceLock};

use smallvec::SmallVec;
use vibrochain_lattice::{Model, Steady};

pub(crate) use draft::{Draft, Source, WRONG_SIGN, sources};
pub use family::Family;
pub(crate) use impact::SIMULTANEOUS;
pub use impact::{Hit, Impact, time_between};

use crate::error::BreatherError;
use crate::structures::orbit::StructureOrbit;

/// A solution that violates its equations by more than this is not listed: rounding has left nothing of it.
pub(crate) const MOST_RESIDUAL: f64 = 0.1;

/// A periodic orbit with impacts.
#[derive(Debug, Clone, PartialEq)]
pub struct Orbit {
    pub(crate) model: Model,
    pub(crate) family: Family,
    pub(crate) force_periods: u32,
    pub(crate) psi: f64,
    pub(crate) steady: Steady,
    pub(crate) impacts: SmallVec<[Impact; 2]>,
    pub(crate) sources: SmallVec<[Source; 1]>,
    pub(crate) uniform_offset: f64,
    pub(crate) fixed_times: bool,
    pub(crate) residual: f64,
    /// The same orbit as contacts at the masses that hit know it.
    pub(crate) at_contacts: AtContacts,
}

/// Worked out when it is first asked for; an error where the lattice has no kernel, exactly at a resonance.
#[derive(Clone, Default)]
pub(crate) struct AtContacts(pub(crate) OnceLock<Result<Arc<StructureOrbit>, BreatherError>>);

impl From<Option<Arc<StructureOrbit>>> for AtContacts {
    fn from(known: Option<Arc<StructureOrbit>>) -> Self {
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

impl Orbit {
    /// The largest length in the conditions of position: half the gap, or the swing of the force.
    pub(crate) fn length_scale(&self) -> f64 {
        self.steady.bound(0).max(1.0)
    }

    /// The largest velocity in Newton's law at the impacts.
    pub(crate) fn velocity_scale(&self) -> f64 {
        let force = self.steady.bound(1);
        self.impacts.iter().map(|impact| impact.impulse.abs()).fold(force.max(f64::MIN_POSITIVE), f64::max)
    }

    /// The parameters.
    pub fn model(&self) -> &Model {
        &self.model
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
        self.model.period() * f64::from(self.force_periods)
    }

    /// Base frequency of the orbit, 2π/period.
    pub fn frequency(&self) -> f64 {
        self.model.omega() / f64::from(self.force_periods)
    }

    /// A time before 0 when every mass has room: the middle of the last flight.
    pub fn time_in_last_flight(&self) -> f64 {
        let last = self.impacts.last().map_or(0.0, |impact| impact.time);
        0.5 * (last - self.period())
    }

    /// Phase ψ of the force at t = 0, as a time, 0 ≤ ψ < T. `None` without force.
    pub fn psi(&self) -> Option<f64> {
        // No −0.
        (self.model.amplitude() > 0.0).then_some(self.psi + 0.0)
    }

    /// Time φ of the second impact of a family with two. `None` for the others.
    pub fn phi(&self) -> Option<f64> {
        match (self.family, self.impacts.as_slice()) {
            (Family::DoubleSided | Family::PeriodDoubled, [_, second]) => Some(second.time),
            _ => None,
        }
    }

    /// Ã = A/(γ₁−ω²), 0 without force; of a force of several harmonics the bound Σ|A_j/(γ₁−j²ω²)|.
    pub fn force_response(&self) -> f64 {
        self.steady.reach()
    }

    /// G, the uniform motion driven by the force, as a function of t+ψ.
    pub fn steady(&self) -> &Steady {
        &self.steady
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

    /// The site that takes all impacts, if there is only one.
    pub fn impact_site(&self) -> Option<usize> {
        match self.sources.as_slice() {
            [source] => Some(source.site),
            _ => None,
        }
    }

    /// The sites that are hit, rising.
    pub fn hit_sites(&self) -> Vec<usize> {
        let mut sites: Vec<usize> = self.sources.iter().map(|source| source.site).collect();
        sites.sort_unstable();
        sites
    }

    /// The site about which the motion of a ring is symmetric, because it takes all impacts: modes odd about it stay at rest, and
    /// half of the masses tell all. `None` where several sites are hit, and on other lattices.
    pub fn centre(&self) -> Option<usize> {
        self.impact_site().filter(|_| self.model.chain().is_ring())
    }

    /// The reflection of a ring that leaves the motion as it is, or is half a period away from doing so.
    pub(crate) fn reflection(&self) -> Option<Reflection> {
        let sources = self.sources.as_slice();
        let first = sources.first().filter(|_| self.model.chain().is_ring())?;
        if sources.len() == 1 {
            return Some(Reflection { mirror: 2 * first.site, delayed: false });
        }
        let (sites, period) = (self.model.chain().sites(), self.period());
        let strongest = self.impacts.iter().fold(0.0, |most: f64, impact| most.max(impact.impulse.abs()));
        let is_image = |reflection: Reflection, impact: &Impact| {
            let (site, delay) =
                (reflection.image(impact.site, sites), if reflection.delayed { 0.5 * period } else { 0.0 });
            self.impacts.iter().any(|other| {
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
        candidates.into_iter().find(|&reflection| self.impacts.iter().all(|impact| is_image(reflection, impact)))
    }

    /// The impacts by instants, in order of time.
    pub fn instants(&self) -> impl Iterator<Item = &[Impact]> {
        let close = SIMULTANEOUS * self.period();
        self.impacts.chunk_by(move |earlier, later| later.time - earlier.time <= close)
    }

    /// The orbit is its own mirror image in time about t = 0 (conservative, all impacts at 0 and half a period,
    /// at any sites): half a period tells all.
    pub fn is_reversible(&self) -> bool {
        self.fixed_times
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

    pub(crate) fn sources(&self) -> &[Source] {
        &self.sources
    }

    pub(crate) fn uniform_offset(&self) -> f64 {
        self.uniform_offset
    }
}

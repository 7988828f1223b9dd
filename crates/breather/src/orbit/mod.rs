//! The one type for all periodic orbits: a chain, a force, a period and a list of impacts.
//!
//! ```text
//! v_n(t) = Σ_i P_i K_{n−n_i}(t−t_i) + G(t+ψ),          G(t) = Ã cos ωt, or Σ Ã_j cos(jωt+θ_j)   (superposition)
//! velocity before/after impact i:  w_i ∓ P_i/2,         w_i = Σ_{j≠i} P_j K′(t_i−t_j) + Ġ(t_i+ψ)
//! Newton's law:  w_i = −q P_i/2,   q = (1−e)/(1+e);     position:  v(t_i) = a ± 1         (docs/guide/orbits.md)
//! ```

pub(crate) mod assembly;
pub(crate) mod display;
pub(crate) mod order;
#[cfg(feature = "serde")]
pub(crate) mod serde_impl;
pub(crate) mod symmetries;

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::{Barrier, ImpulseResponse, Model, Steady};

/// Impacts closer than this part of the period are at one instant: farther apart than rounding of their times, nearer than anything
/// that happens between two of them.
pub(crate) const SIMULTANEOUS: f64 = 1e-9;

/// A solution that violates its equations by more than this is not listed: rounding has left nothing of it.
pub(crate) const MOST_RESIDUAL: f64 = 0.1;

/// The time between two instants of an orbit that repeats itself: half a period at most, in the unit of the arguments.
///
/// ```
/// assert!((vibrochain_breather::time_between(0.5, 5.75, 6.0) - 0.75).abs() < 1e-15);
/// ```
pub fn time_between(one: f64, other: f64, period: f64) -> f64 {
    let ahead = (one - other).rem_euclid(period);
    ahead.min(period - ahead)
}

/// The families of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Family {
    /// One impact on each barrier a period.
    DoubleSided,
    /// One impact a period, on the nearer (lower) barrier.
    SingleSided,
    /// Two different impacts on the nearer barrier in two periods of the force.
    PeriodDoubled,
    /// An orbit given by its impacts, see [`Orbit::from_impulses`].
    Word,
}

vibrochain_lattice::names!(Family {
    DoubleSided "double-sided", SingleSided "single-sided", PeriodDoubled "period-doubled", Word "word",
});

/// One impact of an orbit: of a lattice dimensionless, of any other structure in units of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Impact {
    /// The mass that hits; of a structure the number of the contact.
    pub site: usize,
    /// The barrier it hits.
    pub barrier: Barrier,
    /// Time within the orbit's period, 0 ≤ t < period.
    pub time: f64,
    /// Momentum P the barrier gives to the mass, signed (the paper's 2p₁, −2p₂).
    pub impulse: f64,
    /// Velocity just before, −P/(m(1+e)), with m = 1 of a mass of a lattice.
    pub velocity_before: f64,
    /// Velocity just after, eP/(m(1+e)).
    pub velocity_after: f64,
    /// Acceleration just before, force included. Where nothing damps the motion, the impact does not change it.
    pub acceleration: f64,
}

impl Impact {
    /// An impact is right-signed if the mass moves outward, towards its barrier, before it.
    pub fn is_right_signed(&self) -> bool {
        self.velocity_before * self.barrier.sign() > 0.0
    }
}

/// An impact as it is given: the rest of [`Impact`] follows.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
pub struct Hit {
    /// The mass that hits.
    pub site: usize,
    /// The barrier it hits.
    pub barrier: Barrier,
    /// Time within the orbit's period.
    pub time: f64,
    /// Momentum that the barrier gives to the mass, signed.
    pub impulse: f64,
}

impl Hit {
    /// An impact of mass `site` on `barrier`.
    pub fn new(site: usize, barrier: Barrier, time: f64, impulse: f64) -> Self {
        Self { site, barrier, time, impulse }
    }
}

impl From<&Impact> for Hit {
    fn from(impact: &Impact) -> Self {
        Self::new(impact.site, impact.barrier, impact.time, impact.impulse)
    }
}

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
}

/// A site that receives impulses, and their sum over a period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Source {
    pub(crate) site: usize,
    pub(crate) net_impulse: f64,
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

/// An impulse that points out of the gap by no more than this part of the largest one could be turned round by polishing the orbit.
pub(crate) const WRONG_SIGN: f64 = 1e-3;

/// What a family knows of an orbit before velocities, accelerations and residual are worked out.
#[derive(Debug, Clone)]
pub(crate) struct Draft {
    pub(crate) family: Family,
    pub(crate) force_periods: u32,
    pub(crate) psi: f64,
    pub(crate) impacts: SmallVec<[Hit; 2]>,
    /// Net impulse of each site that is hit. Given, not summed: it may be far smaller than its terms.
    pub(crate) sources: SmallVec<[Source; 1]>,
    /// Mean displacement of the ring, Σ net impulse/(γ₁MT); for γ₁ = 0 its limit.
    pub(crate) uniform_offset: f64,
}

impl Draft {
    /// From impacts in order of time and what their net impulse holds up at a site that is hit.
    pub(crate) fn new(
        response: &ImpulseResponse,
        (family, force_periods): (Family, u32),
        psi: f64,
        impacts: SmallVec<[Hit; 2]>,
        static_displacement: f64,
    ) -> Self {
        let sources = match impacts.first() {
            Some(&Hit { site, .. }) if impacts.iter().all(|hit| hit.site == site) => {
                smallvec![Source { site, net_impulse: static_displacement * response.static_stiffness() }]
            }
            _ => sources(&impacts),
        };
        let uniform_offset = static_displacement * response.uniform_share();
        Self { family, force_periods, psi, impacts, sources, uniform_offset }
    }

    /// No impulse points out of the gap by more than polishing an orbit could turn round.
    pub(crate) fn is_right_signed(&self) -> bool {
        let largest = self.impacts.iter().map(|impact| impact.impulse.abs()).fold(0.0, f64::max);
        self.impacts.iter().all(|hit| -hit.impulse * hit.barrier.sign() > -WRONG_SIGN * largest)
    }
}

/// The sites that are hit, each with the sum of its impulses.
pub(crate) fn sources(impacts: &[Hit]) -> SmallVec<[Source; 1]> {
    let mut sources: SmallVec<[Source; 1]> = SmallVec::new();
    for &Hit { site, impulse, .. } in impacts {
        match sources.iter_mut().find(|source| source.site == site) {
            Some(source) => source.net_impulse += impulse,
            None => sources.push(Source { site, net_impulse: impulse }),
        }
    }
    sources
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

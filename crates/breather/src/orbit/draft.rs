//! What is known of an orbit before velocities, accelerations and residual are worked out.

use std::sync::Arc;

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::ImpulseResponse;

use crate::orbit::{Family, Hit};
use crate::structures::orbit::ContactOrbit;

/// A site that receives impulses, and their sum over a period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Source {
    pub(crate) site: usize,
    pub(crate) net_impulse: f64,
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
    /// The orbit as contacts know it, where it was found so.
    pub(crate) at_contacts: Option<Arc<ContactOrbit>>,
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
        Self { family, force_periods, psi, impacts, sources, uniform_offset, at_contacts: None }
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

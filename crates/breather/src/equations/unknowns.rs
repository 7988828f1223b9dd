//! The unknowns of an orbit of any impact word, and the orbit that they make.
//!
//! They stand as P_1 … P_n, s, then t_2 … t_n and ψ where these are free; the first impact's time is where the orbit begins.
//! The equations stand as n positions, the net impulse, and Newton's law at the impacts where it is asked for.

use smallvec::SmallVec;
use vibrochain_lattice::{ImpulseResponse, Model};

use crate::equations::linear::{Vector, zeros};
use crate::orbit::{Draft, Family, Hit, Orbit};

/// Times that differ by no more than these roundings of the period are one.
const SAME_INSTANT: f64 = 8.0 * f64::EPSILON;

/// Which unknowns there are, and where they stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Unknowns {
    /// Number of impulses; also the place of s.
    pub(crate) impacts: usize,
    times: bool,
    phase: bool,
    /// The impact where Newton's law is not asked for: without a force Σ P_i·(Newton's law at i) vanishes by itself, because K′ is
    /// odd. The strongest, which says least of the others.
    spared: usize,
}

impl Unknowns {
    /// Those of an orbit: times that symmetry fixes are none.
    pub(crate) fn of(orbit: &Orbit) -> Self {
        Self { times: !orbit.is_reversible(), ..Self::free(orbit) }
    }

    /// Those of an orbit whose times are free whatever its symmetry.
    pub(crate) fn free(orbit: &Orbit) -> Self {
        let impacts = orbit.impacts();
        let stronger = |&i: &usize, &j: &usize| impacts[i].impulse.abs().total_cmp(&impacts[j].impulse.abs());
        let spared = (0..impacts.len()).max_by(stronger).unwrap_or(0);
        Self { impacts: impacts.len(), times: true, phase: !orbit.model().is_conservative(), spared }
    }

    pub(crate) fn size(&self) -> usize {
        let n = self.impacts;
        n + 1 + if self.times { n - 1 } else { 0 } + usize::from(self.phase)
    }

    /// Place of the time of impact `i`.
    pub(crate) fn time(&self, i: usize) -> Option<usize> {
        (self.times && i > 0).then_some(self.impacts + i)
    }

    /// Place of ψ.
    pub(crate) fn psi(&self) -> Option<usize> {
        self.phase.then(|| self.size() - 1)
    }

    /// All times that are free.
    pub(crate) fn times(&self) -> impl Iterator<Item = usize> + use<> {
        let (n, times) = (self.impacts, self.times);
        (n + 1..2 * n).filter(move |_| times)
    }

    /// Place of Newton's law at impact `i` among the equations.
    pub(crate) fn newton(&self, i: usize) -> Option<usize> {
        let n = self.impacts;
        if self.phase {
            Some(n + 1 + i)
        } else if !self.times || i == self.spared {
            None
        } else {
            Some(n + 1 + i - usize::from(i > self.spared))
        }
    }

    /// The unknowns of `orbit`.
    pub(crate) fn read(&self, orbit: &Orbit, response: &ImpulseResponse) -> Vector {
        let mut x = zeros(self.size());
        for (i, impact) in orbit.impacts().iter().enumerate() {
            x[i] = impact.impulse;
            if let Some(place) = self.time(i) {
                x[place] = impact.time;
            }
        }
        x[self.impacts] = static_displacement(orbit, response);
        if let Some(place) = self.psi() {
            x[place] = orbit.psi_or_zero();
        }
        x
    }

    /// Sizes of the unknowns to which their changes are compared; `impulse` is that of the impulses.
    pub(crate) fn units(&self, orbit: &Orbit, response: &ImpulseResponse, impulse: f64) -> Vector {
        let mut units = zeros(self.size());
        units[..self.impacts].fill(impulse);
        // In units of half the gap.
        units[self.impacts] = static_displacement(orbit, response).abs().max(1.0);
        self.times().for_each(|place| units[place] = response.period());
        if let Some(place) = self.psi() {
            units[place] = orbit.model().period();
        }
        units
    }
}

/// What the net impulse holds up at a site that is hit, of which the orbit carries the uniform mode's share.
pub(crate) fn static_displacement(orbit: &Orbit, response: &ImpulseResponse) -> f64 {
    orbit.uniform_offset() / response.uniform_share()
}

/// An impact word: what the unknowns are the unknowns of.
#[derive(Debug, Clone)]
pub(crate) struct Template {
    family: Family,
    force_periods: u32,
    /// Sites and barriers, with the times that are not unknown, and the phase.
    hits: SmallVec<[Hit; 2]>,
    psi: f64,
}

impl Template {
    pub(crate) fn of(orbit: &Orbit) -> Self {
        Self {
            family: orbit.family(),
            force_periods: orbit.force_periods(),
            hits: orbit.impacts().iter().map(Hit::from).collect(),
            psi: orbit.psi_or_zero(),
        }
    }

    /// The orbit that the unknowns make. `None` where an impact of one mass would overtake another.
    pub(crate) fn draft(
        &self,
        unknowns: &Unknowns,
        x: &[f64],
        model: &Model,
        response: &ImpulseResponse,
    ) -> Option<Draft> {
        let period = response.period();
        let mut hits = self.hits.clone();
        for (i, hit) in hits.iter_mut().enumerate() {
            hit.impulse = x[i];
            hit.time = unknowns.time(i).map_or(hit.time, |place| x[place]);
        }
        for (i, hit) in hits.iter().enumerate() {
            let later = hits[i + 1..].iter().filter(|other| other.site == hit.site);
            for other in later {
                let flight = other.time - hit.time;
                if !(flight > 0.0 && flight < period) {
                    return None;
                }
            }
        }
        // Those of different masses may: simultaneous ones always do, by rounding.
        hits.iter_mut().filter(|hit| !(0.0..period).contains(&hit.time)).for_each(|hit| {
            hit.time = hit.time.rem_euclid(period);
            // Just before 0, by rounding, is the first instant.
            hit.time = if period - hit.time > SAME_INSTANT * period { hit.time } else { 0.0 };
        });
        hits.sort_by(|one, other| one.time.total_cmp(&other.time));
        // Of one instant but for rounding: what lies between would be no flight.
        for i in 1..hits.len() {
            if hits[i].time - hits[i - 1].time <= SAME_INSTANT * period {
                hits[i].time = hits[i - 1].time;
            }
        }
        let psi = unknowns.psi().map_or(self.psi, |place| x[place]).rem_euclid(model.period());
        Some(Draft::new(response, (self.family, self.force_periods), psi, hits, x[unknowns.impacts]))
    }
}

//! What a map asks of a conservative breather of one site of a ring, without its orbit: is it physical, by what margin, with which
//! impulses.
//!
//! A fast path: a cell of a map of such breathers takes half the time. The general one is [`Finder::search`] for
//! [`crate::Scope::Candidates`] and [`Finder::quick_admissibility`], whose formulas these are, without lists of impacts and sources,
//! without an [`Orbit`](crate::Orbit) and its [`Motion`](crate::Motion). What needs more is left to it ([`MapSearch::Open`]); where
//! there is an answer it is the general one, margin and impulses to the bit, the residual but for the order of its sums.

use vibrochain_lattice::{ImpulseResponse, Model};

use crate::admissible::conservative_modes::TwoImpulses;
use crate::error::NoBreather;
use crate::orbit::delicate::delicate;
use crate::orbit::{Family, MOST_RESIDUAL};
use crate::search::families::conservative::{crosses, impulse, impulses};
use crate::search::finder::Finder;
use crate::search::screens::radiation::Radiation;

/// A physical breather of site 0, with the impulse response it was made from.
///
/// ```
/// use vibrochain_breather::{Family, Finder, MapSearch, breathers};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4)?;
/// let mut finder = Finder::new(21);
/// let MapSearch::One(breather) = finder.map_breather(&model, Family::DoubleSided) else { panic!() };
/// let orbit = &breathers(&model, Family::DoubleSided)?.orbits[0];
/// assert_eq!(breather.impulses(), [orbit.impacts()[0].impulse, orbit.impacts()[1].impulse]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy)]
#[must_use]
pub struct MapBreather<'a> {
    response: &'a ImpulseResponse,
    impulses: [f64; 2],
    one: bool,
    margin: f64,
    residual: f64,
}

/// What lives at a point, of one family.
#[derive(Debug, Clone, Copy)]
#[must_use]
pub enum MapSearch<T> {
    /// None that could be physical.
    None,
    /// One, which is physical unless it tells what is in the way.
    One(T),
    /// Only a search for orbits can tell.
    Open,
}

impl Finder {
    /// What lives at a point of one family, double-sided with φ = T/2 or single-sided, of conservative breathers on a coupled ring, where
    /// that can be told without their orbits.
    pub fn map_breather(&mut self, model: &Model, family: Family) -> MapSearch<MapBreather<'_>> {
        self.find_map_breather(model, family).unwrap_or(MapSearch::Open)
    }

    fn find_map_breather(&mut self, model: &Model, family: Family) -> Option<MapSearch<MapBreather<'_>>> {
        let chain = model.chain();
        if !model.is_conservative() || !chain.is_ring() || chain.is_uncoupled() || self.stop.heard().is_err() {
            return None;
        }
        self.prepare(model, model.omega()).ok()?;
        let response = &self.response;
        let radiation = *self.radiation.get_or_insert_with(|| Radiation::of(response));
        let two = match family {
            Family::DoubleSided => {
                self.kernel_grid.clear();
                if let Some(radiation) = &radiation {
                    self.kernel_grid.set(model, response, radiation);
                }
                // There may be others, with φ ≠ T/2.
                if !self.kernel_grid.places().is_empty() {
                    return None;
                }
                let ((p1, p2), static_displacement) = impulses(model, response, response.dynamic_at_half())?;
                TwoImpulses { impulses: [-2.0 * p2, 2.0 * p1], one: false, static_displacement }
            }
            Family::SingleSided => match impulse(model, response) {
                Ok((p, static_displacement)) => {
                    TwoImpulses { impulses: [2.0 * p, 0.0], one: true, static_displacement }
                }
                Err(NoBreather::NetImpulse) => return Some(MapSearch::None),
                Err(_) => return None,
            },
            Family::PeriodDoubled | Family::Word => return None,
        };
        let half = 0.5 * response.period();
        let net_impulse = two.static_displacement * response.static_stiffness();
        if !two.is_right_signed()
            || radiation.is_some_and(|radiation| !radiation.allows_at_halves(two.impulses))
            || two.one && crosses(model, response, net_impulse)
        {
            return Some(MapSearch::None);
        }
        let residual = self.conservative_modes.take(model, response, &two).filter(|off| *off <= MOST_RESIDUAL)?;
        let flight = self.conservative_modes.flight(response);
        let margin = self.watch.margin(model, flight, half, two.one)?;
        let TwoImpulses { impulses, one, .. } = two;
        let found = MapBreather { response, impulses, one, margin, residual };
        Some(if margin > 0.0 { MapSearch::One(found) } else { MapSearch::None })
    }
}

impl<'a> MapBreather<'a> {
    /// The impulse response of its chain and frequency.
    pub fn response(&self) -> &'a ImpulseResponse {
        self.response
    }

    /// Momenta that the barriers give to the mass, signed: at 0 and T/2, or the one.
    pub fn impulses(&self) -> &[f64] {
        &self.impulses[..if self.one { 1 } else { 2 }]
    }

    /// The smallest distance left to a barrier at a turning point.
    pub fn margin(&self) -> f64 {
        self.margin
    }

    /// Largest violation of the defining equations, see [`crate::Orbit::residual`].
    pub fn residual(&self) -> f64 {
        self.residual
    }

    /// The largest impulse, as it is signed.
    pub fn strongest_impulse(&self) -> f64 {
        let [first, second] = self.impulses;
        if first.abs() > second.abs() { first } else { second }
    }

    /// Whether errors could matter to its verdict, see [`Finder::is_delicate`].
    pub fn is_delicate(&self) -> bool {
        let sizes = || self.impulses().iter().map(|impulse| impulse.abs());
        let (least, most) = (sizes().fold(f64::INFINITY, f64::min), sizes().fold(f64::MIN_POSITIVE, f64::max));
        delicate(self.response, self.response.omega(), (0.5 * least, most))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::finder::Scope;
    use crate::search::orbit_list::OrbitList;
    use vibrochain_lattice::Chain;

    /// Soft and stiff chains, next to resonance, with and without coupling, symmetric or not, small and large.
    #[test]
    fn a_map_breather_is_what_the_orbit_says() {
        let mut random = fastrand::Rng::with_seed(19);
        let (mut quick, mut finder, mut found) = (Finder::new(1), Finder::new(1), OrbitList::default());
        // No breather, one, left open; by family.
        let mut seen = [[0; 3]; 2];
        for _ in 0..6000 {
            let sites = [1, 2, 3, 4, 5, 6, 11, 21, 40, 64, 120][random.usize(0..11)];
            let gamma1 = [0.0, 1e-3, 0.2, 0.2, 0.2, 40.0][random.usize(0..6)];
            let gamma2 = [0.0, 1e-9, 0.1, 0.3, 5.0][random.usize(0..5)] * random.f64();
            let Ok(chain) = Chain::new(sites, gamma1, gamma2) else { continue };
            let a = if random.u8(0..4) == 0 { 0.0 } else { 0.9 * random.f64() };
            let model = Model::conservative(chain, 0.2 + 3.0 * random.f64(), a).unwrap();
            for (i, family) in [Family::DoubleSided, Family::SingleSided].into_iter().enumerate() {
                let searched = quick.map_breather(&model, family);
                let Ok(()) = finder.search(&model, family, Scope::Candidates, &mut found) else {
                    assert!(matches!(searched, MapSearch::Open), "{model:?}");
                    continue;
                };
                let physical = |orbit: &crate::Orbit| {
                    let answer = finder.quick_admissibility(orbit).unwrap();
                    answer.margin.filter(|_| answer.is_physical()).map(|margin| (orbit.clone(), margin))
                };
                let physical: Vec<_> = found.orbits.iter().filter_map(physical).collect();
                match searched {
                    MapSearch::Open => seen[i][2] += 1,
                    MapSearch::None => {
                        assert!(physical.is_empty() && found.completeness.open() == (0, 0), "{model:?} {family:?}");
                        seen[i][0] += 1;
                    }
                    MapSearch::One(breather) => {
                        let [(orbit, margin)] = physical.as_slice() else { panic!("{model:?} {family:?}") };
                        let impulses: Vec<f64> = orbit.impacts().iter().map(|impact| impact.impulse).collect();
                        assert_eq!(
                            (breather.impulses(), breather.margin()),
                            (impulses.as_slice(), *margin),
                            "{model:?}"
                        );
                        assert_eq!(Some(breather.strongest_impulse()), orbit.strongest_impulse());
                        let rounding = 64.0 * f64::EPSILON * breather.response().condition();
                        assert!((breather.residual() - orbit.residual()).abs() < rounding, "{model:?}");
                        assert_eq!(breather.is_delicate(), finder.is_delicate(orbit).unwrap(), "{model:?}");
                        seen[i][1] += 1;
                    }
                }
            }
        }
        assert!(seen.iter().all(|[none, one, open]| *none > 300 && *one > 100 && *open > 300), "{seen:?}");
    }
}

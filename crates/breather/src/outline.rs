//! What a map asks of a conservative breather of one site of a ring, without its orbit: is it physical, by what margin, with which
//! impulses.
//!
//! A fast path: a cell of a map of such breathers takes half the time. The general one is [`Finder::search`] for
//! [`crate::Wanted::Candidates`] and [`Finder::quick_admissibility`], whose formulas these are, without lists of impacts and sources,
//! without an [`Orbit`](crate::Orbit) and its [`Motion`](crate::Motion). What needs more is left to it ([`Outlined::Open`]); where
//! there is an answer it is the general one, margin and impulses to the bit, the residual but for the order of its sums.

use vibrochain_lattice::{Barrier, ImpulseResponse, Model, Shapes};
use wide::f64x4;

use crate::condition::delicate;
use crate::conservative::{crosses, impulse, impulses};
use crate::error::NoBreather;
use crate::finder::Finder;
use crate::grid::{Flight, MOST_MODES, stiffnesses};
use crate::lanes::{LANES, Lane, all, four, groups, total};
use crate::orbit::Family;
use crate::radiation::Radiation;
use crate::watch::Impacts;
use crate::worst::worse;

/// A physical breather of site 0, with the impulse response it was made from.
///
/// ```
/// use vibrochain_breather::{Family, Finder, Outlined, breathers};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4)?;
/// let mut finder = Finder::new(21);
/// let Outlined::One(outline) = finder.outline(&model, Family::DoubleSided) else { panic!() };
/// let orbit = &breathers(&model, Family::DoubleSided)?.orbits[0];
/// assert_eq!(outline.impulses(), [orbit.impacts()[0].impulse, orbit.impacts()[1].impulse]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy)]
#[must_use]
pub struct Outline<'a> {
    response: &'a ImpulseResponse,
    impulses: [f64; 2],
    one: bool,
    margin: f64,
    residual: f64,
}

/// What lives at a point, of one family.
#[derive(Debug, Clone, Copy)]
#[must_use]
pub enum Outlined<'a> {
    /// No physical breather.
    None,
    /// One.
    One(Outline<'a>),
    /// Only [`Finder::search`] can tell.
    Open,
}

/// Work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct Sketch {
    /// cos(2πkn/M) of the half ring of so many masses, [mode][mass] in whole groups.
    sites: usize,
    shapes: Vec<Lane>,
    /// Displacements and velocities of the modes just after the first impact.
    start: [Vec<Lane>; 2],
}

/// Impulses at 0 and T/2, the latter 0 if there is none, and what their sum holds up at the site that is hit.
#[derive(Debug, Clone, Copy)]
struct Draft {
    impulses: [f64; 2],
    one: bool,
    static_displacement: f64,
}

impl Finder {
    /// What lives at a point of one family, double-sided with φ = T/2 or single-sided, of conservative breathers on a coupled ring, where
    /// that can be told without their orbits.
    pub fn outline(&mut self, model: &Model, family: Family) -> Outlined<'_> {
        self.outlined(model, family).unwrap_or(Outlined::Open)
    }

    fn outlined(&mut self, model: &Model, family: Family) -> Option<Outlined<'_>> {
        let chain = model.chain();
        if !model.is_conservative() || !chain.is_ring() || chain.is_uncoupled() || self.stop.heard().is_err() {
            return None;
        }
        self.prepare(model, model.omega()).ok()?;
        let response = &self.response;
        let radiation = *self.radiation.get_or_insert_with(|| Radiation::of(response));
        let draft = match family {
            Family::DoubleSided => {
                self.rises.clear();
                if let Some(radiation) = &radiation {
                    self.rises.set(model, response, radiation);
                }
                // There may be others, with φ ≠ T/2.
                if !self.rises.places().is_empty() {
                    return None;
                }
                let ((p1, p2), static_displacement) = impulses(model, response, response.dynamic_at_half())?;
                Draft { impulses: [-2.0 * p2, 2.0 * p1], one: false, static_displacement }
            }
            Family::SingleSided => match impulse(model, response) {
                Ok((p, static_displacement)) => Draft { impulses: [2.0 * p, 0.0], one: true, static_displacement },
                Err(NoBreather::NetImpulse) => return Some(Outlined::None),
                Err(_) => return None,
            },
            Family::PeriodDoubled | Family::Word => return None,
        };
        let half = 0.5 * response.period();
        let times = [0.0, half].into_iter().zip(draft.impulses).take(if draft.one { 1 } else { 2 });
        let net_impulse = draft.static_displacement * response.static_stiffness();
        if !draft.is_right_signed()
            || radiation.is_some_and(|radiation| !radiation.allows(times))
            || draft.one && crosses(model, response, net_impulse)
        {
            return Some(Outlined::None);
        }
        let residual = self.sketch.take(model, response, &draft)?;
        let flight = self.sketch.flight(model, response);
        let impacts = Impacts { asymmetry: model.asymmetry(), one: draft.one };
        let margin = self.watch.margin(chain, flight, half, impacts)?;
        let Draft { impulses, one, .. } = draft;
        let found = Outline { response, impulses, one, margin, residual };
        Some(if margin > 0.0 { Outlined::One(found) } else { Outlined::None })
    }
}

impl Draft {
    fn barriers(&self) -> [Barrier; 2] {
        [if self.one { Barrier::Lower } else { Barrier::Upper }, Barrier::Lower]
    }

    /// Every mass moves outward before its impact.
    fn is_right_signed(&self) -> bool {
        let outward = |(impulse, barrier): (f64, Barrier)| -0.5 * impulse * barrier.sign() > 0.0;
        self.impulses.into_iter().zip(self.barriers()).take(if self.one { 1 } else { 2 }).all(outward)
    }
}

impl Sketch {
    /// Takes over the motion of a breather; its residual, `None` where that is no number or the ring is too large.
    fn take(&mut self, model: &Model, response: &ImpulseResponse, draft: &Draft) -> Option<f64> {
        if response.modes() > MOST_MODES {
            return None;
        }
        self.set_shapes(response.shapes(), response.modes());
        let [first, second] = draft.impulses;
        let net = draft.static_displacement * response.static_stiffness();
        let held = draft.static_displacement * response.uniform_share();
        let [displacements, velocities] = &mut self.start;
        displacements.clear();
        velocities.clear();
        // Displacements of the site that is hit at both impacts, and the weights.
        let mut sums = [f64x4::ZERO; 3];
        for (group, [weight, still, at_impulse, at_half]) in response.in_fours().enumerate() {
            let mut still = (four(still) * all(net)).to_array();
            if group == 0 {
                // Of the uniform mode it is known to its last digits.
                still[0] = held / weight[0];
            }
            let [weight, still, at_impulse, at_half] = [weight, still, at_impulse, at_half].map(four);
            let start = weight * (still + all(first) * at_impulse + all(second) * at_half);
            let end = weight * (still + all(first) * at_half + all(second) * at_impulse);
            displacements.push(start.to_array());
            // Just after the impact the velocity is half the jump above its mean.
            velocities.push((weight * all(0.5 * first)).to_array());
            sums = [sums[0] + start, sums[1] + end, sums[2] + weight];
        }
        let [start, end, weight] = sums.map(total);
        let scale = first.abs().max(second.abs());
        let mut residual = 0.0;
        for (i, (place, barrier)) in [start, end].into_iter().zip(draft.barriers()).enumerate() {
            if i == 1 && draft.one {
                continue;
            }
            // v(t_i) − (a±1) and w_i, half the jump below the velocity after the impact, over the largest terms.
            let mean = 0.5 * draft.impulses[i] * weight - 0.5 * draft.impulses[i];
            residual = worse(worse(residual, (place - model.barrier(barrier)).abs()), (mean / scale).abs());
        }
        residual.is_finite().then_some(residual)
    }

    fn set_shapes(&mut self, shapes: &Shapes, modes: usize) {
        if self.sites == shapes.sites() && !self.shapes.is_empty() {
            return;
        }
        self.sites = shapes.sites();
        let groups = groups(modes);
        self.shapes.clear();
        self.shapes.resize(modes * groups, [0.0; LANES]);
        for (k, row) in self.shapes.chunks_exact_mut(groups).enumerate() {
            let masses = row.as_flattened_mut().iter_mut().enumerate().take(modes);
            masses.for_each(|(n, shape)| *shape = shapes.even(k, n, 0));
        }
    }

    fn flight<'a>(&'a self, model: &Model, response: &'a ImpulseResponse) -> Flight<'a> {
        let [displacements, velocities] = &self.start;
        Flight {
            frequencies: response.frequencies(),
            shapes: &self.shapes,
            start: [displacements, velocities],
            stiffnesses: stiffnesses(model.chain()),
        }
    }
}

impl<'a> Outline<'a> {
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
    use crate::finder::{Found, Wanted};
    use vibrochain_lattice::Chain;

    /// Soft and stiff chains, next to resonance, with and without coupling, symmetric or not, small and large.
    #[test]
    fn an_outline_is_what_the_orbit_says() {
        let mut random = fastrand::Rng::with_seed(19);
        let (mut quick, mut finder, mut found) = (Finder::new(1), Finder::new(1), Found::default());
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
                let outlined = quick.outline(&model, family);
                let Ok(()) = finder.search(&model, family, Wanted::Candidates, &mut found) else {
                    assert!(matches!(outlined, Outlined::Open), "{model:?}");
                    continue;
                };
                let physical = |orbit: &crate::Orbit| {
                    let answer = finder.quick_admissibility(orbit).unwrap();
                    answer.margin.filter(|_| answer.is_physical()).map(|margin| (orbit.clone(), margin))
                };
                let physical: Vec<_> = found.orbits.iter().filter_map(physical).collect();
                match outlined {
                    Outlined::Open => seen[i][2] += 1,
                    Outlined::None => {
                        assert!(physical.is_empty() && found.completeness.open() == (0, 0), "{model:?} {family:?}");
                        seen[i][0] += 1;
                    }
                    Outlined::One(outline) => {
                        let [(orbit, margin)] = physical.as_slice() else { panic!("{model:?} {family:?}") };
                        let impulses: Vec<f64> = orbit.impacts().iter().map(|impact| impact.impulse).collect();
                        assert_eq!((outline.impulses(), outline.margin()), (impulses.as_slice(), *margin), "{model:?}");
                        assert_eq!(Some(outline.strongest_impulse()), orbit.strongest_impulse());
                        let rounding = 64.0 * f64::EPSILON * outline.response().condition();
                        assert!((outline.residual() - orbit.residual()).abs() < rounding, "{model:?}");
                        assert_eq!(outline.is_delicate(), finder.is_delicate(orbit).unwrap(), "{model:?}");
                        seen[i][1] += 1;
                    }
                }
            }
        }
        assert!(seen.iter().all(|[none, one, open]| *none > 300 && *one > 100 && *open > 300), "{seen:?}");
    }
}

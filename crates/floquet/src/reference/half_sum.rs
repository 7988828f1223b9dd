//! Conservative orbits that are their own mirror image in time, mass by mass: half the dimension.
//!
//! Impacts are at 0 and half a period later. The reversal of time Q = diag(1, −1)·S₀, S₀ the saltations at 0, turns M into M⁻¹.
//! N = ½(M + M⁻¹) keeps the space Qx = x; its coordinates are displacements of the masses that S₀ spares and velocities of the
//! masses that it hits. Its eigenvalues are ν = ½(μ + 1/μ), each pair of multipliers once.
//!
//! The trivial pair μ = 1, a defective double eigenvalue of M that dense solvers split by 1e-7, is the simple eigenvalue ν = 1 of N. The
//! orbit's own flow gives its left eigenvector: −v̈ of each spared mass, v⁻ of each one that is hit.
//!
//! The reflection of a ring about the one site that is hit leaves the even part of N.

use nalgebra::DMatrix;
use vibrochain_breather::{Finder, LatticeOrbit, Orbit};
use vibrochain_lattice::{Propagator, Spectrum};

use crate::error::FloquetError;
use crate::saltation::saltations;

/// (displacement, velocity) of one mass from those of another.
type Block = [[f64; 2]; 2];

fn flown([[a, b], [c, d]]: Block, [u, v]: [f64; 2]) -> [f64; 2] {
    [a * u + b * v, c * u + d * v]
}

/// An impact half a period after 0.
#[derive(Debug)]
struct Later {
    kappa: f64,
    /// The flight there from every mass, which is that back from it.
    flights: Vec<Block>,
}

/// Masses that move together, with their shares, for each vector of an orthonormal basis.
#[derive(Debug)]
pub(crate) struct Basis(Vec<Vec<(usize, f64)>>);

impl Basis {
    /// Each mass by itself.
    pub(crate) fn of_masses(sites: usize) -> Self {
        Self((0..sites).map(|n| vec![(n, 1.0)]).collect())
    }

    /// What is even about one site of a ring.
    pub(crate) fn even_about(site: usize, sites: usize) -> Self {
        let image = |n: usize| (2 * site + sites - n) % sites;
        let share = 1.0 / 2f64.sqrt();
        let vector = |n: usize| if image(n) == n { vec![(n, 1.0)] } else { vec![(n, share), (image(n), share)] };
        Self((0..sites).filter(|n| image(*n) >= *n).map(vector).collect())
    }
}

/// What N of an orbit is made of.
#[derive(Debug)]
pub(crate) struct HalfSum {
    omega: f64,
    whole: Propagator,
    /// κ of each mass that is hit at 0.
    kappas: Vec<Option<f64>>,
    later: Vec<Later>,
}

impl HalfSum {
    /// Takes over an orbit; `kept` is the spectrum of the last orbit's chain, in most sweeps that of this one.
    pub(crate) fn new(orbit: LatticeOrbit<'_>, kept: &mut Option<Spectrum>) -> Result<Self, FloquetError> {
        let (chain, period) = (orbit.model().chain(), orbit.period());
        let kept_one = kept.take().filter(|spectrum| spectrum.chain() == chain);
        let spectrum = kept.insert(kept_one.unwrap_or_else(|| Spectrum::new(*chain)));
        let half = Propagator::new(spectrum, 0.5 * period);
        let (mut kappas, mut later) = (vec![None; chain.sites()], Vec::new());
        for hit in saltations(&orbit)? {
            if hit.time == 0.0 {
                kappas[hit.site] = Some(hit.kappa);
            } else {
                let flights = (0..chain.sites()).map(|n| half.block(n, hit.site)).collect();
                later.push(Later { kappa: hit.kappa, flights });
            }
        }
        Ok(Self { omega: orbit.frequency(), whole: Propagator::new(spectrum, period), kappas, later })
    }

    /// N on the space of a basis.
    pub(crate) fn on(&self, Basis(vectors): &Basis) -> DMatrix<f64> {
        let size = vectors.len();
        let mut matrix = DMatrix::zeros(size, size);
        for (j, vector) in vectors.iter().enumerate() {
            let kick = |later: &Later| {
                let [u, v] = self.carried(vector, |m| later.flights[m]);
                [-2.0 * u, later.kappa * u - 2.0 * v]
            };
            let kicks: Vec<_> = self.later.iter().map(kick).collect();
            for (i, image) in vectors.iter().enumerate() {
                // What a vector of the space has at the first mass of another, it has of that as a whole.
                let (n, share) = image[0];
                let [mut u, mut v] = self.carried(vector, |m| self.whole.block(n, m));
                for (kick, later) in kicks.iter().zip(&self.later) {
                    let [du, dv] = flown(later.flights[n], *kick);
                    (u, v) = (u + du, v + dv);
                }
                matrix[(i, j)] = self.kappas[n].map_or(u, |kappa| (v - 0.5 * kappa * u) / self.omega) / share;
            }
        }
        matrix
    }

    /// What flights from its masses make of a vector, just after the impacts at 0.
    fn carried(&self, vector: &[(usize, f64)], flight: impl Fn(usize) -> Block) -> [f64; 2] {
        vector.iter().fold([0.0; 2], |[u, v], &(m, share)| {
            // A displacement stays, a velocity, in units of ω, turns round.
            let start = if self.kappas[m].is_some() { [0.0, -self.omega * share] } else { [share, 0.0] };
            let [du, dv] = flown(flight(m), start);
            [u + du, v + dv]
        })
    }

    /// The left eigenvector of ν = 1 in the coordinates of a basis, which the orbit's own motion must lie in.
    pub(crate) fn set_flow(
        orbit: &Orbit,
        Basis(vectors): &Basis,
        finder: &mut Finder,
        left: &mut Vec<f64>,
    ) -> Result<(), FloquetError> {
        let motion = finder.motion(orbit)?;
        motion.at(0, 0.0);
        left.clear();
        left.extend(vectors.iter().map(|vector| {
            let (n, share) = vector[0];
            let hit = orbit.impacts().iter().find(|impact| impact.time == 0.0 && impact.site == n);
            let flow =
                hit.map_or_else(|| -motion.site(n).acceleration, |impact| impact.velocity_before * orbit.frequency());
            flow / share
        }));
        Ok(())
    }
}

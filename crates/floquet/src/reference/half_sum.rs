//! Conservative orbits that are their own mirror image in time, mass by mass: half the dimension, and Krein's form.
//!
//! Impacts are at 0 and half a period later. The reversal of time Q = diag(1, −1)·S₀, S₀ the saltations at 0, turns M into M⁻¹.
//! N = ½(M + M⁻¹) keeps the space Qx = x; its coordinates are displacements of the masses that S₀ spares and velocities of the
//! masses that it hits. Its eigenvalues are ν = ½(μ + 1/μ), each pair of multipliers once. An eigenvector N x = x cos θ belongs to the
//! multiplier e^{iθ} with x + y, y = −i(M − M⁻¹)x/(2 sin θ), and Krein's form is xᵀGx/sin θ there. The rows of G are the rows of M that
//! N leaves over: −(velocity) of a spared mass, displacement of a hit one.
//!
//! The orbit's own flow gives the left eigenvector of ν = 1: −v̈ of each spared mass, v⁻ of each one that is hit.

use nalgebra::DMatrix;
use vibrochain_breather::{Finder, Orbit};
use vibrochain_lattice::{Propagator, Spectrum};

use crate::error::FloquetError;
use crate::saltation::{Saltation, saltations};

/// N and G; also the work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct HalfSum {
    pub(crate) matrix: DMatrix<f64>,
    pub(crate) form: DMatrix<f64>,
    /// The masses that are hit, at either instant.
    pub(crate) hit: Vec<usize>,
    /// Of each impact half a period after 0, the flight there from every mass, which is that back from it.
    flights: Vec<[[f64; 2]; 2]>,
    kicks: Vec<[f64; 2]>,
    /// Of the last orbit's chain: that of the next one in most sweeps.
    spectrum: Option<Spectrum>,
}

impl HalfSum {
    /// Takes over an orbit.
    pub(crate) fn set(&mut self, orbit: &Orbit) -> Result<(), FloquetError> {
        let (chain, period, omega) = (orbit.model().chain(), orbit.period(), orbit.frequency());
        let sites = chain.sites();
        let hits: Vec<Saltation> = saltations(orbit)?.collect();
        let spectrum = match self.spectrum.take() {
            Some(spectrum) if spectrum.chain() == chain => spectrum,
            _ => Spectrum::new(*chain),
        };
        let (half, whole) = (Propagator::new(&spectrum, 0.5 * period), Propagator::new(&spectrum, period));
        self.spectrum = Some(spectrum);
        let mut kappas = vec![None; sites];
        hits.iter().filter(|hit| hit.time == 0.0).for_each(|hit| kappas[hit.site] = Some(hit.kappa));
        let later = || hits.iter().filter(|hit| hit.time != 0.0);
        self.flights.clear();
        self.flights.extend(later().flat_map(|hit| (0..sites).map(|n| half.block(n, hit.site)).collect::<Vec<_>>()));
        let Self { matrix, form, flights, kicks, .. } = self;
        (*matrix, *form) = (DMatrix::zeros(sites, sites), DMatrix::zeros(sites, sites));
        for m in 0..sites {
            // What S₀ makes of the coordinate: a displacement stays, a velocity, in units of ω, turns round.
            let start = if kappas[m].is_some() { [0.0, -omega] } else { [1.0, 0.0] };
            let flown = |[[a, b], [c, d]]: [[f64; 2]; 2], [u, v]: [f64; 2]| [a * u + b * v, c * u + d * v];
            kicks.clear();
            kicks.extend(later().zip(flights.chunks_exact(sites)).map(|(hit, flights)| {
                let [u, v] = flown(flights[m], start);
                [-2.0 * u, hit.kappa * u - 2.0 * v]
            }));
            for n in 0..sites {
                let [mut u, mut v] = flown(whole.block(n, m), start);
                for (kick, flights) in kicks.iter().zip(flights.chunks_exact(sites)) {
                    let [du, dv] = flown(flights[n], *kick);
                    (u, v) = (u + du, v + dv);
                }
                (matrix[(n, m)], form[(n, m)]) = match kappas[n] {
                    Some(kappa) => ((v - 0.5 * kappa * u) / omega, u * omega),
                    None => (u, -v),
                };
            }
        }
        self.hit.clear();
        self.hit.extend(hits.iter().map(|hit| hit.site));
        self.hit.sort_unstable();
        self.hit.dedup();
        Ok(())
    }

    /// The left eigenvector of ν = 1 of the orbit taken over.
    pub(crate) fn set_flow(orbit: &Orbit, finder: &mut Finder, left: &mut Vec<f64>) -> Result<(), FloquetError> {
        let motion = finder.motion(orbit)?;
        motion.at(0, 0.0);
        left.clear();
        left.extend((0..orbit.model().chain().sites()).map(|n| -motion.site(n).acceleration));
        for impact in orbit.impacts().iter().filter(|impact| impact.time == 0.0) {
            left[impact.site] = impact.velocity_before * orbit.frequency();
        }
        Ok(())
    }
}

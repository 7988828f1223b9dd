//! The monodromy matrix: what one period does to a small perturbation, from just before the first impact,
//!
//! ```text
//! M = L(T−φ) S_φ L(φ) S_0            (in order of time; `errata` for the paper's order)
//! ```
//!
//! with free flights L and saltations S. Two forms:
//! - [`full_monodromy`]: all displacements and velocities, for impacts at any sites;
//! - [`even_monodromy`]: the modes even about the one site that is hit, 2(⌊M/2⌋+1) of 2M dimensions. The odd modes
//!   have a node there and never feel an impact: without dashpots their multipliers are e^{±iΩ_kT}, see [`crate::odd_multipliers`].

use nalgebra::DMatrix;
use vibrochain_breather::{BreatherError, Finder, Orbit};
use vibrochain_lattice::{Propagator, Spectrum, Stop, oscillator_flight};

use crate::error::FloquetError;
use crate::saltation::saltations;

/// The largest dense matrix that is analysed: minutes. One of 2000 took 14 s of a busy processor, 8 for the matrix and 6 for its eigenvalues,
/// and 101 MB; time grows by its cube, memory by its square, to some 7 minutes and 0.9 GB here, five days and 90 GB at ten times this size.
pub const MAX_DIMENSION: usize = 6000;

/// Coordinates of the even subspace: X_k = Ω̃_k x_k and Y_k = ẋ_k of the normalised modes (u_site = Σ b_k x_k), with
/// Ω̃_k = max(Ω_k, ω): flights are then rotations, and stiff rings stay balanced.
#[derive(Debug, Clone, Default)]
pub(crate) struct EvenCoordinates {
    pub(crate) frequencies: Vec<f64>,
    /// b_k
    pub(crate) amplitudes: Vec<f64>,
    /// Ω̃_k
    pub(crate) scales: Vec<f64>,
    /// δ_k; of none they are 0.
    pub(crate) decays: Vec<f64>,
}

impl EvenCoordinates {
    /// Takes over modes, their frequencies and weights.
    pub(crate) fn set(&mut self, modes: impl Iterator<Item = (f64, f64)> + Clone, omega: f64) {
        self.frequencies.clear();
        self.decays.clear();
        self.frequencies.extend(modes.clone().map(|(f, _)| f));
        self.amplitudes.clear();
        self.amplitudes.extend(modes.clone().map(|(_, weight)| weight.sqrt()));
        self.scales.clear();
        self.scales.extend(modes.map(|(f, _)| f.max(omega)));
    }

    fn modes(&self) -> usize {
        self.frequencies.len()
    }

    /// Multiplies from the left by the flight over `time`.
    fn fly(&self, matrix: &mut DMatrix<f64>, time: f64) {
        let decay = |k: usize| self.decays.get(k).copied().unwrap_or(0.0);
        let turn = |(k, (&f, &scale)): (usize, (&f64, &f64))| {
            let [[a, b], [c, d]] = oscillator_flight(f, decay(k), time);
            [a, scale * b, c / scale, d]
        };
        let turns: Vec<[f64; 4]> = self.frequencies.iter().zip(&self.scales).enumerate().map(turn).collect();
        for mut column in matrix.column_iter_mut() {
            let (x, y) = column.as_mut_slice().split_at_mut(turns.len());
            for ((x, y), [a, b, c, d]) in x.iter_mut().zip(y).zip(&turns) {
                (*x, *y) = (a * *x + b * *y, c * *x + d * *y);
            }
        }
    }

    /// Multiplies from the left by a saltation at the site.
    fn hit(&self, matrix: &mut DMatrix<f64>, e: f64, kappa: f64) {
        let modes = self.modes();
        let (amplitudes, scales) = (&self.amplitudes, &self.scales);
        for mut column in matrix.column_iter_mut() {
            let (x, y) = column.as_mut_slice().split_at_mut(modes);
            // Displacement and velocity of the site.
            let (mut u, mut v) = (0.0, 0.0);
            for k in 0..modes {
                u += amplitudes[k] / scales[k] * x[k];
                v += amplitudes[k] * y[k];
            }
            for k in 0..modes {
                x[k] -= (1.0 + e) * amplitudes[k] * scales[k] * u;
                y[k] += amplitudes[k] * (kappa * u - (1.0 + e) * v);
            }
        }
    }

    /// The monodromy matrix of an orbit whose impacts are all at one site.
    pub(crate) fn monodromy(&self, orbit: &Orbit) -> Result<DMatrix<f64>, FloquetError> {
        let mut matrix = DMatrix::identity(2 * self.modes(), 2 * self.modes());
        let mut hits = saltations(orbit)?.peekable();
        let first = hits.peek().map_or(0.0, |hit| hit.time);
        while let Some(hit) = hits.next() {
            self.hit(&mut matrix, hit.restitution, hit.kappa);
            let next = hits.peek().map_or(first + orbit.period(), |hit| hit.time);
            self.fly(&mut matrix, next - hit.time);
        }
        Ok(matrix)
    }
}

/// The monodromy matrix on the modes even about the site that is hit, from just before the first impact. Coordinates:
/// first X_k = max(Ω_k, ω)·x_k, then Y_k = ẋ_k, k = 0 … ⌊M/2⌋, of the normalised modes, u_site = Σ_k b_k x_k.
///
/// # Errors
/// [`FloquetError::Grazing`], [`FloquetError::TooLarge`]; [`FloquetError::Breather`] if the impacts are at several
/// sites.
///
/// ```
/// use vibrochain_breather::{Family, breathers};
/// use vibrochain_floquet::even_monodromy;
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4)?;
/// let orbit = &breathers(&model, Family::DoubleSided)?.orbits[0];
/// assert_eq!(even_monodromy(orbit)?.nrows(), 22);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn even_monodromy(orbit: &Orbit) -> Result<DMatrix<f64>, FloquetError> {
    let lattice = orbit.lattice()?;
    if lattice.centre().is_none() {
        let what = "the even subspace needs all impacts at one site";
        return Err(BreatherError::Impact { index: 1, what }.into());
    }
    let (chain, dashpots) = (lattice.model().chain(), lattice.model().dashpots());
    check_dimension(2 * chain.even_modes())?;
    let spectrum = Spectrum::new(*chain);
    let mut coordinates = EvenCoordinates::default();
    let modes = spectrum.frequencies().iter().copied().zip(spectrum.weights().iter().copied());
    coordinates.set(modes, orbit.frequency());
    coordinates.decays.extend(spectrum.decays(dashpots));
    coordinates.monodromy(orbit)
}

/// The monodromy matrix of the whole ring, from just before the first impact; coordinates u_0 … u_{M−1}, then
/// u̇_0 … u̇_{M−1}.
///
/// # Errors
/// [`FloquetError::Grazing`], [`FloquetError::TooLarge`].
pub fn full_monodromy(orbit: &Orbit) -> Result<DMatrix<f64>, FloquetError> {
    full_monodromy_until(orbit, &Stop::default())
}

/// The same, until `stop` is raised.
pub(crate) fn full_monodromy_until(orbit: &Orbit, stop: &Stop) -> Result<DMatrix<f64>, FloquetError> {
    let model = orbit.lattice()?.model();
    let (chain, dashpots) = (model.chain(), model.dashpots());
    let sites = chain.sites();
    check_dimension(2 * sites)?;
    let spectrum = Spectrum::new(*chain);
    let mut matrix = DMatrix::identity(2 * sites, 2 * sites);
    let first = orbit.impacts().first().map_or(0.0, |impact| impact.time);
    let mut hits = saltations(orbit)?.peekable();
    while let Some(hit) = hits.next() {
        for mut column in matrix.column_iter_mut() {
            let (u, v) = (column[hit.site], column[hit.site + sites]);
            column[hit.site] = -hit.restitution * u;
            column[hit.site + sites] = hit.kappa * u - hit.restitution * v;
        }
        let until = hits.peek().map_or(first + orbit.period(), |hit| hit.time);
        if until == hit.time {
            continue;
        }
        let flow = Propagator::with_dashpots(&spectrum, dashpots, until - hit.time);
        let mut next = DMatrix::zeros(2 * sites, 2 * sites);
        for n in 0..sites {
            stop.heard().map_err(BreatherError::from)?;
            let blocks: Vec<_> = (0..sites).map(|m| flow.block(n, m)).collect();
            for (column, mut image) in matrix.column_iter().zip(next.column_iter_mut()) {
                let (u, v) = column.as_slice().split_at(sites);
                let mut moved = [0.0; 2];
                for ((u, v), block) in u.iter().zip(v).zip(&blocks) {
                    moved = [0, 1].map(|half| moved[half] + (block[half][0] * u + block[half][1] * v));
                }
                (image[n], image[n + sites]) = (moved[0], moved[1]);
            }
        }
        matrix = next;
    }
    Ok(matrix)
}

pub(crate) fn check_dimension(dimension: usize) -> Result<(), FloquetError> {
    if dimension <= MAX_DIMENSION { Ok(()) } else { Err(FloquetError::TooLarge { dimension, limit: MAX_DIMENSION }) }
}

/// The flow direction (v̇, v̈) just before the first impact, in even coordinates: the right eigenvector of a conservative
/// orbit's trivial multiplier.
pub(crate) fn flow_before_first_impact(
    orbit: &Orbit,
    finder: &mut Finder,
    coordinates: &EvenCoordinates,
    flow: &mut Vec<f64>,
) -> Result<(), FloquetError> {
    let motion = finder.motion(orbit)?;
    motion.seek(0, 0.0);
    // A Motion starts just after the impact; before it the site is slower by the impulse, spread over the modes.
    let impulse = orbit.impacts().first().map_or(0.0, |impact| impact.impulse);
    flow.clear();
    for half in 0..2 {
        for (k, mode) in motion.modes().iter().enumerate() {
            let (b, scale) = (coordinates.amplitudes[k], coordinates.scales[k]);
            flow.push(if half == 0 { scale * (mode[1] / b - impulse * b) } else { mode[2] / b });
        }
    }
    Ok(())
}

//! The secular function against dense eigenvalues of the reversible block, which shares no formula with it beyond the
//! impulse response.

mod determinants;
mod forced;
mod large;
mod reversible;

use nalgebra::Complex;
use vibrochain_breather::{Family, Finder, Orbit};
use vibrochain_lattice::{Chain, Model};
pub(in crate::map_paths) use vibrochain_testkit::Random;

use crate::reference::dense::Dense;
use crate::zeros::Nu;

/// ν of the dense block and its norm.
pub(crate) fn dense(orbit: &Orbit, finder: &mut Finder) -> (Vec<Complex<f64>>, f64) {
    let mut dense = Dense::default();
    let norm = dense.solve(orbit.lattice().unwrap(), finder).unwrap();
    (dense.values, norm)
}

/// Largest distance from any of `some` to the nearest of `all`.
pub(crate) fn farthest(some: &[Complex<f64>], all: &[Complex<f64>]) -> f64 {
    let nearest = |z: &Complex<f64>| all.iter().map(|w| (z - w).norm()).fold(f64::INFINITY, f64::min);
    some.iter().map(nearest).fold(0.0, f64::max)
}

pub(crate) fn excess(nu: Complex<f64>) -> f64 {
    Nu::of(nu).excess()
}

pub(crate) fn excess_error(nu: Complex<f64>, excess: f64, error: f64) -> f64 {
    Nu::of(nu).excess_error(excess, error)
}

/// Error of ν that the dense solver is granted.
pub(crate) fn dense_error(norm: f64, condition: f64) -> f64 {
    1e-14 * norm * (norm + condition)
}

pub(crate) fn model(sites: usize, g1: f64, g2: f64, omega: f64, a: f64) -> Option<Model> {
    Model::conservative(Chain::new(sites, g1, g2).ok()?, omega, a).ok()
}

pub(crate) const BOTH: [Family; 2] = [Family::SingleSided, Family::DoubleSided];

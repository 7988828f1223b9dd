//! What captions say of models and orbits.

use vibrochain_breather::{Impact, LatticeOrbit, Orbit};
use vibrochain_lattice::Model;
use vibrochain_lattice::{Short, Spectrum, far_motion};
use vibrochain_maps::caption::describe;

use crate::args::{Direction, SimulateArgs};

/// What a run is of: the breather it starts on, and how it is perturbed.
pub(crate) fn describe_run(args: &SimulateArgs, model: &Model, orbit: Option<&Orbit>) -> String {
    let whose = orbit.map_or("from a state".to_owned(), |orbit| format!("{} breather", orbit.name()));
    format!("{whose}: {}{}", describe(model), perturbed(args))
}

/// How a run is perturbed, if it is.
pub(crate) fn perturbed(args: &SimulateArgs) -> String {
    args.perturb.map_or(String::new(), |size| {
        let direction = match args.direction {
            Direction::Random => format!("at random (seed {})", args.seed),
            Direction::Unstable => "along its unstable direction".to_owned(),
        };
        format!(", perturbed by {} {direction}", Short(size))
    })
}

/// Harmonics of a far field that are added at most; the nearest neighbours need the most of them.
const MAX_TERMS: u64 = 1_000_000;

/// By how much a mass `n` ≥ 1 sites from the one that takes all impacts differs from the uniform motion, in full relative accuracy:
/// by harmonics, of which every one falls from site to site by its own factor.
pub fn beside(orbit: LatticeOrbit<'_>, spectrum: &Spectrum, n: usize, time: f64) -> f64 {
    let since = |impact: &Impact| (time - impact.time).rem_euclid(orbit.period());
    let impulses: Vec<_> = orbit.impacts().iter().map(|impact| (since(impact), impact.impulse)).collect();
    far_motion(spectrum, orbit.frequency(), n, &impulses, MAX_TERMS).0
}

//! What captions say of models and orbits.

use vibrochain_breather::{Impact, Orbit};
use vibrochain_lattice::{Model, Parameter, Part, Short, Spectrum, far_motion};

use crate::args::{Direction, SimulateArgs};

/// "21 masses (N = 20), γ₁ = 0.2, …": all that is fixed.
pub fn describe(model: &Model) -> String {
    in_common(&[model])
}

/// The name of an event in the words of a legend.
pub(crate) fn in_words(name: &str) -> String {
    match name {
        "neimark-sacker" => "Neimark–Sacker".to_owned(),
        // A ratio alone says nothing to who has not read of it.
        ratio if ratio.starts_with("1:") => format!("resonance {ratio}"),
        name => name.replace('-', " "),
    }
}

/// What a run is of: the breather it starts on, and how it is perturbed.
#[cfg(feature = "plot")]
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

/// All that is fixed while a parameter varies.
pub fn describe_without(model: &Model, free: Parameter) -> String {
    let value = model.get(free);
    let other = [value * 0.5 + 0.125, value * 0.5 + 0.0625].into_iter().find_map(|other| model.with(free, other).ok());
    other.map_or_else(|| describe(model), |other| in_common(&[model, &other]))
}

/// What several points of a figure have in common; what differs is told by its curves.
pub fn in_common(models: &[&Model]) -> String {
    let parts = |model: &Model| {
        let point = model.point();
        let said = |parameter: Parameter| match (&point.force, parameter.row().part) {
            (_, Part::Driving) if model.is_conservative() => None,
            (Some(force), _) if parameter == Parameter::Amplitude => Some(format!("force {force}")),
            _ if point.tells(parameter) => Some(format!("{} = {}", parameter.symbol(), point.get(parameter))),
            _ => None,
        };
        std::iter::once(point.layout.to_string()).chain(Parameter::told().filter_map(said)).collect::<Vec<_>>()
    };
    let all: Vec<Vec<String>> = models.iter().map(|model| parts(model)).collect();
    let common = |part: &&String| all.iter().all(|parts| parts.contains(part));
    all.first().into_iter().flatten().filter(common).cloned().collect::<Vec<_>>().join(", ")
}

/// Harmonics of a far field that are added at most; the nearest neighbours need the most of them.
const MAX_TERMS: u64 = 1_000_000;

/// By how much a mass `n` ≥ 1 sites from the one that takes all impacts differs from the uniform motion, in full relative accuracy:
/// by harmonics, of which every one falls from site to site by its own factor.
pub fn beside(orbit: &Orbit, spectrum: &Spectrum, n: usize, time: f64) -> f64 {
    let since = |impact: &Impact| (time - impact.time).rem_euclid(orbit.period());
    let impulses: Vec<_> = orbit.impacts().iter().map(|impact| (since(impact), impact.impulse)).collect();
    far_motion(spectrum, orbit.frequency(), n, &impulses, MAX_TERMS).0
}

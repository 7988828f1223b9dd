//! What is said of a name that is not known: the one that was meant, or how people's words for a vibro-impact model are said here.

use crate::text::closest;

/// Words for what has another name here, and that name; or for what cannot be said.
const WORDS: [(&[&str], &str); 8] = [
    (
        &["gravity", "weight", "preload", "bias", "static_load"],
        "a weight or preload is a constant load, `static = [...]` in [force], a force on each coordinate; of a chain `static_force` in [model]",
    ),
    (
        &["gap", "clearance", "backlash", "stop", "barrier", "wall"],
        "a gap is where its barriers are, `lower` and `upper` of [[contact]]; of a chain `asymmetry`, or `lower` and `upper`, in [model]",
    ),
    (
        &["base", "base_motion", "base_acceleration", "ground", "shaker"],
        "a base that shakes is a load on coordinates that are measured from it, `load = [...]` in [force]: minus each mass times the amplitude \
         of the base's acceleration",
    ),
    (
        &["frequency", "freq", "forcing_frequency"],
        "the frequency of a load is `omega`, in radians a unit of time: before the first table of a scene with [structure], in [model] of a chain's; \
         those of modes are `frequencies` of [structure]",
    ),
    (
        &["zeta", "xi", "damping_ratio", "damping_ratios"],
        "damping ratios are `ratios` beside `frequencies` of [structure]; matrices have C, `damping`, of one mass 2 zeta sqrt(k m); a chain has \
         `damping` in [model], the dashpot of each mass",
    ),
    (
        &["friction", "coulomb", "dry_friction"],
        "friction cannot be said: between impacts all is linear (docs/limits.md)",
    ),
    (
        &["contact_stiffness", "stop_stiffness", "contact_damping", "hertz"],
        "a stop that gives way cannot be said: impacts take no time and have a `restitution` (docs/limits.md)",
    ),
    (
        &["noise", "random", "stochastic"],
        "noise cannot be said: a load has harmonics of `omega` (docs/limits.md); runs from perturbed starts are `mapgen fate`",
    ),
];

/// How what this word means is said here, or that it cannot be.
///
/// ```
/// use vibrochain_maps::hints::said;
/// assert!(said("clearance").is_some_and(|said| said.contains("`lower` and `upper`")));
/// assert!(said("dry-friction") == said("friction") && said("restitution").is_none());
/// ```
#[must_use]
pub fn said(word: &str) -> Option<&'static str> {
    let word = word.to_ascii_lowercase().replace('-', "_");
    WORDS.iter().find(|(words, _)| words.contains(&word.as_str())).map(|(_, said)| *said)
}

/// The one of some names that a word was meant to be, as a question, or else how it is said; nothing if neither is known. What follows it goes on
/// after a space.
///
/// ```
/// use vibrochain_maps::hints::meant;
/// assert_eq!(meant("gama1", ["gamma1", "gamma2"]), "did you mean `gamma1`? ");
/// assert!(meant("noise", ["gamma1"]).starts_with("noise cannot be said"));
/// assert_eq!(meant("q", ["gamma1"]), "");
/// ```
#[must_use]
pub fn meant<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    match (closest(word, names), said(word)) {
        (Some(name), _) => format!("did you mean `{name}`? "),
        (None, Some(said)) => format!("{said}; "),
        (None, None) => String::new(),
    }
}

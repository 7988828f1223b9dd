//! Orbits followed as numbers of their model vary: what `locate`, `branch` and `curve` take from a chain or from a structure.

mod chain;
mod outputs;
mod structure;

use serde_json::{Map, Value, json};
use vibrochain_breather::{FreeNumbers, Orbit};
use vibrochain_floquet::{BranchRequest, Diagram, End, Event, EventCurve, Evidence, Located, Tolerance, Unresolved};
use vibrochain_lattice::{Short, Stop};
use vibrochain_maps::followed::place;
use vibrochain_maps::numbers::Number;
use vibrochain_maps::structure::along;

use crate::args::{AlongArgs, Free};
use crate::common::console::Console;
use crate::common::error::CliError;
use vibrochain_maps::manifest::object;

pub(crate) use chain::{ChainAlong, labels};
pub(crate) use outputs::{Outputs, Wanted};
pub(crate) use structure::StructureAlong;

/// The orbit to start from, its number among all solutions, and theirs.
pub(crate) struct Start {
    pub(crate) orbit: Orbit,
    pub(crate) number: usize,
    pub(crate) count: usize,
}

/// Events between two ends.
pub(crate) struct Events {
    pub(crate) located: Vec<Located>,
    pub(crate) unresolved: Vec<Unresolved>,
    pub(crate) ends: Vec<(f64, End)>,
    /// Orbits assembled, and eigenvalue problems solved.
    pub(crate) counts: [usize; 2],
}

/// A chain or a structure, with an orbit of it to start from.
pub(crate) trait Along: Sized {
    /// What can vary.
    type Free: Copy + PartialEq;
    /// What it is read from, besides flags.
    type Scene;
    /// Its answers are those of chains: they count what was computed, and their tables have manifests.
    const OF_CHAINS: bool;

    /// What a flag names.
    fn free(flag: &Free) -> Result<Self::Free, CliError>;
    /// The name in scenes, flags and tables.
    fn name(free: Self::Free) -> String;
    /// What stands at its axis in a picture.
    fn label(&self, free: Self::Free) -> String;
    /// Finds where to start.
    fn begin(args: &AlongArgs, scene: Self::Scene, stop: &Stop, console: &mut Console<'_>) -> Result<Self, CliError>;
    fn start(&self) -> &Start;
    /// Where it starts.
    fn value(&self, free: Self::Free) -> Result<f64, CliError>;
    /// Whether it can be this, or why not.
    fn allows(&self, free: Self::Free, value: f64) -> Result<(), String>;
    /// From where to where it varies: as flags have it, or else as the scene sweeps it, or as is usual.
    fn range(&self, free: Self::Free, flags: [Option<f64>; 2]) -> Result<[f64; 2], CliError>;
    /// What counts as stable.
    fn tolerance(&self, threshold: Option<f64>) -> Result<Tolerance, CliError>;
    /// Which orbits of what, for people, and what is fixed while this varies.
    fn fixed(&self, free: Self::Free) -> String;
    /// The same above a picture of branches.
    fn over_branches(&self, free: Self::Free, tolerance: Tolerance) -> String;
    /// The same above a picture of curves of an event, if there are any.
    fn over_curves(&self, free: [Self::Free; 2], curves: &[EventCurve]) -> String;
    /// The start, as JSON has it.
    fn head(&self) -> Map<String, Value>;
    fn diagram(&self, free: Self::Free, course: &BranchRequest, stop: &Stop) -> Result<Diagram, CliError>;
    fn located(&self, event: Event, free: Self::Free, range: [f64; 2], stop: &Stop) -> Result<Events, CliError>;
    /// The two numbers that vary along a curve, and where they start.
    fn numbers(&self, free: [Self::Free; 2], stop: &Stop) -> Result<FreeNumbers, CliError>;

    /// Which orbits, what is fixed, and where the number that varies begins.
    fn heading(&self, free: Self::Free) -> Result<String, CliError> {
        let (Start { number, count, .. }, value) = (self.start(), Number(self.value(free)?));
        let (fixed, free) = (self.fixed(free), Self::name(free));
        Ok(format!("{fixed}; from solution {number} of {count} at {free} = {value}"))
    }
}

/// What kind of orbit it is, as JSON has it.
pub(crate) fn kind(orbit: &Orbit) -> Map<String, Value> {
    let family = orbit.model().map(|_| ("family".to_owned(), json!(orbit.family())));
    family.into_iter().chain(orbit.word().map(|word| ("word".to_owned(), json!(word)))).collect()
}

/// An event, as JSON has it.
pub(crate) fn event(found: &Located) -> Value {
    if found.orbit.model().is_some() { json!(found) } else { along::event(found) }
}

/// The solution asked for, physical or not; otherwise the first physical one.
pub(crate) fn picked(
    (orbits, of): (Vec<Orbit>, &str),
    solution: Option<usize>,
    mut is_physical: impl FnMut(&Orbit) -> Result<bool, CliError>,
) -> Result<Start, CliError> {
    let count = orbits.len();
    if let Some(number) = solution.filter(|&number| number == 0 || number > count) {
        refuse!("--solution {number} is out of range: there are {count}, give 1 to {count}");
    }
    for (orbit, number) in orbits.into_iter().zip(1..) {
        if solution.map_or_else(|| is_physical(&orbit), |wanted| Ok(wanted == number))? {
            return Ok(Start { orbit, number, count });
        }
    }
    Err(CliError::IllPosed(format!("none of the {count} orbits{of} is physical")))
}

/// [`picked`], with how to start from others.
fn begun(
    orbits: (Vec<Orbit>, &str),
    args: &AlongArgs,
    is_physical: impl FnMut(&Orbit) -> Result<bool, CliError>,
) -> Result<Start, CliError> {
    picked(orbits, args.solution, is_physical).map_err(|error| match error {
        CliError::IllPosed(none) => {
            CliError::IllPosed(format!("{none}; --solution K starts from one that is not, `mapgen orbit` lists them"))
        }
        error => error,
    })
}

/// The range that is searched must hold the start; what does not is told by its flag.
fn around(flags: [&str; 2], name: &str, start: f64, range: [Option<f64>; 2]) -> Result<(), CliError> {
    let here = format!("{name} = {}, where the search starts", Short(start));
    let [low, high] = flags;
    let message = match range.into() {
        (Some(from), Some(to)) if from >= to => {
            format!("{low} {} is not below {high} {}: give a range around {here}", Short(from), Short(to))
        }
        (Some(from), _) if from > start => format!("{low} {} is above {here}: give at most that", Short(from)),
        (_, Some(to)) if to < start => format!("{high} {} is below {here}: give at least that", Short(to)),
        _ => return Ok(()),
    };
    Err(CliError::Request(message))
}

/// The flags of the range of what varies first, and second.
pub(crate) const FIRST: [&str; 2] = ["--from", "--to"];
pub(crate) const SECOND: [&str; 2] = ["--and-from", "--and-to"];

/// The range of a number, which must hold the start.
pub(crate) fn checked_range<A: Along>(
    along: &A,
    free: A::Free,
    flags: [&str; 2],
    values: [Option<f64>; 2],
) -> Result<[f64; 2], CliError> {
    for (flag, value) in flags.into_iter().zip(values) {
        let allowed = value.map_or(Ok(()), |value| along.allows(free, value));
        allowed.map_err(|why| CliError::Request(format!("{flag}: {why}")))?;
    }
    let range = along.range(free, values)?;
    around(flags, &A::name(free), along.value(free)?, range.map(Some))?;
    Ok(range)
}

/// The JSON of a way: what its answers of all commands begin with.
pub(crate) fn answer<A: Along>(along: &A, schema: &str, free: Value) -> Map<String, Value> {
    let mut answer = object([("schema", json!(schema)), ("free", free)]);
    answer.extend(along.head());
    answer
}

/// Where and how a way ended.
pub(crate) fn ends(free: &str, ends: &[(f64, End)]) -> Value {
    let answer = |(value, end): &(f64, End)| json!({ "value": value, "reason": end.name(), "message": ending(free, *value, end) });
    ends.iter().map(answer).collect()
}

/// How the way in one direction ended, as a sentence.
pub(crate) fn ending(free: &str, value: f64, end: &End) -> String {
    let here = format!("{free} = {}", Number(value));
    match end {
        End::Range => format!("searched to {here}"),
        End::Fold { error } => format!("the branch ends in a fold at {here} ± {error:.0e}"),
        End::Closed => format!("the branch is back at its start, {here}"),
        End::PeriodDoubling => format!("the branch ends at {here}, on orbits of half its period"),
        End::Pitchfork => format!("the branch ends at {here}, where it meets its own mirror image"),
        End::Resonance(resonance) => {
            format!("resonance at {here}: harmonic {} meets mode {}", resonance.harmonic, resonance.mode)
        }
        End::Unbounded => format!("the impulses grow without bound towards {here}"),
        End::ImpulsesVanish => {
            format!("the impulses vanish at {here}: the breather ends on the motion that the force drives alone")
        }
        End::Grazing => {
            format!("two impacts vanish together at {here}: the branch ends at a grazing of the orbits without them")
        }
        End::Lost(error) => format!("the branch was lost at {here}: {error}"),
        End::Unwatched(error) => format!("stopped at {here}: {error}"),
    }
}

/// Where an event is, with its error.
pub(crate) fn value_text(free: &str, found: &Located) -> String {
    let error = if found.error.is_finite() { format!("± {:.0e}", found.error) } else { "(error unknown)".to_owned() };
    format!("{free} = {} {error}", Number(found.value))
}

/// What shows an event.
pub(crate) fn evidence_text(found: &Located) -> String {
    match found.evidence {
        Evidence::Multiplier(mu) if mu.im == 0.0 => format!("multiplier {}", mu.re),
        Evidence::Multiplier(mu) => format!("multiplier {} ± {}i", mu.re, mu.im.abs()),
        Evidence::Touch(touch) => {
            let place = place(&found.orbit, touch.site);
            format!("{place} touches the {} barrier at t = {}", touch.barrier, Number(touch.time))
        }
        Evidence::Impact(impact) if found.event == Event::Sticking => {
            format!("after impact {impact} the contact begins to rest")
        }
        Evidence::Impact(impact) => format!("impact {impact} has no velocity left"),
    }
}

//! Structures as their numbers vary: what `branch`, `locate` and `curve` of a structure have in common, and what they print.

pub(crate) mod branch;
pub(crate) mod curve;

use std::fmt::Write as _;

use vibrochain_breather::{StructureOrbit, structure_is_physical};
use vibrochain_floquet::{Evidence, Located, StructureCourse, Unresolved};
use vibrochain_lattice::Short;
use vibrochain_maps::numbers::Number;
use vibrochain_maps::structure::{Setting, StructureScene};

use super::orbit::found;
use crate::args::AlongArgs;
use crate::common::error::CliError;

/// The orbit to start from, its number among all solutions, theirs, and the number of the structure that varies.
pub(crate) struct Start<'a> {
    pub(super) scene: &'a StructureScene,
    pub(super) orbit: StructureOrbit,
    pub(super) word: String,
    pub(super) solution: usize,
    pub(super) count: usize,
    pub(super) free: Setting,
    pub(super) value: f64,
}

/// The solution asked for, physical or not; otherwise the first physical one.
pub(super) fn start<'a>(args: &AlongArgs, scene: &'a StructureScene) -> Result<Start<'a>, CliError> {
    let free = args.free.setting()?;
    let value = value_of(scene, free)?;
    for (flag, end) in [("--from", args.from), ("--to", args.to)] {
        let Some(end) = end else { continue };
        // In the range of the number, told before any work.
        scene.clone().set(free, end).map_err(|why| CliError::Request(format!("{flag}: {why}")))?;
    }
    let model = scene.model().map_err(CliError::Request)?;
    let (found, word, _) = found(&args.which, scene, &model)?;
    let count = found.orbits.len();
    if let Some(number) = args.solution.filter(|&number| number == 0 || number > count) {
        let message = format!("--solution {number} is out of range: there are {count}, give 1 to {count}");
        return Err(CliError::Request(message));
    }
    for (i, orbit) in found.orbits.into_iter().enumerate() {
        let wanted = match args.solution {
            Some(number) => number == i + 1,
            None => structure_is_physical(&orbit)?.is_physical(),
        };
        if wanted {
            return Ok(Start { scene, orbit, word, solution: i + 1, count, free, value });
        }
    }
    Err(CliError::IllPosed(match count {
        0 => format!("no orbit of {word} was found to start from"),
        _ => format!(
            "none of the {count} orbits of {word} is physical; --solution K starts from one that is not, `mapgen orbit` lists them"
        ),
    }))
}

/// Where a number of the structure is.
pub(super) fn value_of(scene: &StructureScene, setting: Setting) -> Result<f64, CliError> {
    scene.get(setting).ok_or_else(|| {
        CliError::Request(format!(
            "{setting}: this structure has no such number, or it is not given: nothing to start from"
        ))
    })
}

/// From where to where a number is varied: as flags have it, or else as the scene sweeps it, or from half its value to twice.
pub(super) fn range(
    scene: &StructureScene,
    setting: Setting,
    [from, to]: [Option<f64>; 2],
) -> Result<[f64; 2], CliError> {
    let value = value_of(scene, setting)?;
    let axis = scene.axes.iter().find(|axis| axis.parameter == setting);
    let usual = match setting {
        Setting::RestitutionOfAll | Setting::Restitution(_) => [0.05, 1.0],
        _ if value == 0.0 => [0.0, 1.0],
        _ if value < 0.0 => [2.0 * value, 0.5 * value],
        _ => [0.5 * value, 2.0 * value],
    };
    let [low, high] = axis.map_or(usual, |axis| axis.limits());
    let [low, high] = [from.unwrap_or(low.min(value)), to.unwrap_or(high.max(value))];
    if low <= value && value <= high && low < high {
        return Ok([low, high]);
    }
    let (low, high) = (Short(low), Short(high));
    let message = format!(
        "{setting} = {}, where the search starts, is not in the range from {low} to {high}: give one around it",
        Short(value)
    );
    Err(CliError::Request(message))
}

impl Start<'_> {
    /// Which orbits of what, and what is fixed as these numbers vary.
    pub(super) fn fixed(&self, varied: &[Setting]) -> String {
        self.scene.fixed_but(&self.orbit.name(), varied)
    }

    /// Which orbits, what is fixed, and where the number that varies begins.
    pub(super) fn heading(&self) -> String {
        format!(
            "{}; from solution {} of {} at {} = {}",
            self.fixed(&[self.free]),
            self.solution,
            self.count,
            self.free,
            Number(self.value)
        )
    }
}

/// What shows an event, for people.
pub(super) fn evidence_text(evidence: Evidence) -> String {
    match evidence {
        Evidence::Multiplier(mu) if mu.im == 0.0 => format!("multiplier {}", mu.re),
        Evidence::Multiplier(mu) => format!("multiplier {} ± {}i", mu.re, mu.im.abs()),
        Evidence::Touch(touch) => {
            format!("contact {} touches the {} barrier at t = {}", touch.site, touch.barrier, Number(touch.time))
        }
        Evidence::Impact(impact) => format!("impact {impact} has no velocity left"),
    }
}

/// Events, ends and what rounding hides, for people.
pub(super) fn events_text<'a>(
    out: &mut String,
    free: Setting,
    events: impl Iterator<Item = (&'a Located<StructureOrbit>, bool)>,
    unresolved: &[Unresolved],
    ends: &[String],
) {
    for (found, physical) in events {
        let aside = if physical { "" } else { "; not physical" };
        // Writing to a String cannot fail.
        let _ = writeln!(
            out,
            "  {free} = {} ± {:.0e}  {}: {}{aside}",
            Number(found.value),
            found.error,
            found.event,
            evidence_text(found.evidence)
        );
    }
    for place in unresolved {
        let (from, to) = (Number(place.from), Number(place.to));
        let _ = writeln!(out, "  between {free} = {from} and {to} a sign of more that is not resolved");
    }
    for end in ends {
        let _ = writeln!(out, "  end: {end}");
    }
}

/// What is looked for along the way of a start.
pub(super) fn course(
    start: &Start<'_>,
    [from, to]: [f64; 2],
    events: Vec<vibrochain_floquet::Event>,
    threshold: Option<f64>,
) -> Result<StructureCourse, CliError> {
    let tolerance = threshold.map_or(Ok(start.scene.tolerance), vibrochain_maps::scene::tolerance_from);
    Ok(StructureCourse { from, to, events, generations: 0, tolerance: tolerance.map_err(CliError::Request)? })
}

//! `mapgen locate`: where a breather bifurcates or grazes as one parameter varies.

use std::fmt::Write as _;

use serde::Serialize;
use vibrochain_breather::{Finder, Orbit};
use vibrochain_floquet::{
    Answer, BranchedOrbit, End, Event, Evidence, Followed, Located, Search, Unresolved, Verdict, locate_until,
};
use vibrochain_lattice::{Model, Parameter, Short, Stop};

use crate::args::{AlongArgs, LocateArgs};
use crate::common::answer::{EndAnswer, StartAnswer, printed};
use crate::common::console::{Console, nothing_else};
use crate::common::error::CliError;
use crate::common::model::{Chosen, chosen};
use crate::common::schemas::LOCATE;
use crate::common::which;
use crate::structures;
use crate::sweep::report::counted;
use vibrochain_maps::files::{CsvFile, distinct};
use vibrochain_maps::numbers::Number;

/// The orbit to start from, its number among all solutions, and theirs.
pub(crate) struct Start {
    pub(crate) orbit: Orbit,
    pub(crate) number: usize,
    pub(crate) count: usize,
    /// Where its model comes from.
    pub(crate) chosen: Chosen,
}

/// The range of a parameter: as flags have it, or else as the scene sweeps it.
pub(crate) fn range(chosen: &Chosen, parameter: Parameter, flags: [Option<f64>; 2]) -> [Option<f64>; 2] {
    let axis = chosen.scene.as_ref().and_then(|scene| scene.axis(parameter));
    let [least, most] = axis.map_or([None; 2], |axis| axis.limits().map(Some));
    [flags[0].or(least), flags[1].or(most)]
}

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`]; that there is no event is an answer.
pub fn run(args: &LocateArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    if let Some(scene) = structures::asked(&args.along.model)? {
        return structures::along::branch::locate(args, &scene, console);
    }
    let taken = distinct(&args.along.reads(), &[("--out", args.out.as_deref())])?;
    nothing_else(args.json, taken)?;
    let free = args.along.free.parameter()?;
    let header = header(free.name());
    let stop = (console.interrupt)()?;
    let table = args.out.as_deref().map(|path| CsvFile::create("--out", path, header)).transpose()?;
    let start = start(&args.along, &stop, console)?;
    let mut search = Search::new(&start.orbit, args.event, free);
    let [from, to] = range(&start.chosen, search.free, [args.along.from, args.along.to]);
    (search.from, search.to) = (from.unwrap_or(search.from), to.unwrap_or(search.to));
    let mut answer = locate_until(&start.orbit, &search, &stop)?;
    answer.located.sort_by(|one, other| one.value.total_cmp(&other.value));
    let text = if args.json {
        printed(&LocateAnswer::new(&start, &search, &answer))?
    } else {
        as_text(&start, &search, &answer)
    };
    console.answer(&text, args.json, taken)?;
    let Some(mut table) = table else { return Ok(()) };
    answer.located.iter().try_for_each(|found| table.record(&fields(found)))?;
    Ok(table.finish()?)
}

/// Stands in the header for the parameter that varies.
const FREE: &str = "value";

const HEADER: [&str; 9] = ["event", FREE, "error", "impulses", "phi", "psi", "period", "physical", "multiplier"];

/// The names of the columns where this varies.
pub(crate) fn header(free: &str) -> [&str; 9] {
    HEADER.map(|name| if name == FREE { free } else { name })
}

/// A row of the table.
pub(crate) fn fields<O: Followed>(found: &Located<O>) -> impl Serialize + use<O> {
    let (orbit, multiplier) = (
        &found.orbit,
        match found.evidence {
            Evidence::Multiplier(mu) => Some([mu.re, mu.im]),
            Evidence::Touch(_) | Evidence::Impact(_) => None,
        },
    );
    let (phi, psi, period) = (orbit.phi(), orbit.psi(), orbit.period());
    (found.event, found.value, found.error, orbit.impulses(), phi, psi, period, found.physical, multiplier)
}

/// The range that is searched must hold the start; what does not is told by its flag.
fn around(free: Parameter, range: [Option<f64>; 2], model: &Model) -> Result<(), CliError> {
    let start = model.get(free);
    let here = format!("{} = {}, where the search starts", free.name(), Short(start));
    let message = match range.into() {
        (Some(from), Some(to)) if from >= to => {
            format!("--from {} is not below --to {}: give a range around {here}", Short(from), Short(to))
        }
        (Some(from), _) if from > start => format!("--from {} is above {here}: give at most that", Short(from)),
        (_, Some(to)) if to < start => format!("--to {} is below {here}: give at least that", Short(to)),
        _ => return Ok(()),
    };
    Err(CliError::Request(message))
}

/// The solution asked for, physical or not; otherwise the first physical one.
pub(crate) fn start(args: &AlongArgs, stop: &Stop, console: &mut Console<'_>) -> Result<Start, CliError> {
    let chosen = chosen(&args.model, console)?;
    let which = which::wanted(&args.which, chosen.scene.as_ref())?;
    let (model, free) = (&chosen.model, args.free.parameter()?);
    for (flag, value) in [("--from", args.from), ("--to", args.to)] {
        let Some(value) = value else { continue };
        // In the range of the parameter, told before any work.
        model.with(free, value).map_err(|error| CliError::Request(format!("{flag}: {error}")))?;
    }
    around(free, range(&chosen, free, [args.from, args.to]), model)?;
    let mut finder = Finder::new(model.chain().sites()).until(stop);
    let (_, found) = which::find(&which, model, &mut finder, None)?;
    let count = found.orbits.len();
    if let Some(reason) = found.completeness.reason() {
        return Err(CliError::IllPosed(format!("no orbit to start from: {reason}")));
    }
    if let Some(number) = args.solution.filter(|&number| number == 0 || number > count) {
        let message = format!("--solution {number} is out of range: there are {count}, give 1 to {count}");
        return Err(CliError::Request(message));
    }
    for (i, orbit) in found.orbits.into_iter().enumerate() {
        let wanted = match args.solution {
            Some(number) => number == i + 1,
            None => finder.quick_admissibility(&orbit)?.is_physical(),
        };
        if wanted {
            return Ok(Start { orbit, number: i + 1, count, chosen });
        }
    }
    if count == 0 {
        let message = format!("no orbit was found to start from, and the list is {}", found.completeness);
        return Err(CliError::IllPosed(message));
    }
    Err(CliError::IllPosed(format!(
        "none of the {count} orbits is physical; --solution K starts from one that is not, `mapgen orbit` lists them"
    )))
}

/// The answer as JSON.
#[derive(Serialize)]
struct LocateAnswer<'a> {
    schema: &'static str,
    event: Event,
    free: Parameter,
    #[serde(flatten)]
    start: StartAnswer<'a>,
    range: [f64; 2],
    points: &'a [Located],
    unresolved: &'a [Unresolved],
    ends: Vec<EndAnswer>,
    evaluations: usize,
    spectra: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    word: Option<String>,
}

impl<'a> LocateAnswer<'a> {
    fn new(start: &'a Start, &Search { event, free, from, to }: &Search, answer: &'a Answer) -> Self {
        Self {
            schema: LOCATE,
            event,
            free,
            start: start.answer(),
            range: [from, to],
            points: &answer.located,
            unresolved: &answer.unresolved,
            ends: EndAnswer::of(&answer.ends, |value, end| message(free, value, end)),
            evaluations: answer.evaluations,
            spectra: answer.spectra,
            word: start.orbit.word(),
        }
    }
}

/// How the way in one direction ended, as a sentence.
pub(crate) fn message(free: Parameter, value: f64, end: &End) -> String {
    ending(free.name(), value, end)
}

/// The same by the name of what varies.
pub(crate) fn ending(free: &str, value: f64, end: &End) -> String {
    let here = format!("{free} = {}", Number(value));
    match end {
        End::Range => format!("searched to {here}"),
        End::Fold { error } => format!("the branch ends in a fold at {here} ± {error:.0e}"),
        End::Closed => format!("the branch is back at its start, {here}"),
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

impl Start {
    pub(crate) fn answer(&self) -> StartAnswer<'_> {
        StartAnswer { parameters: self.orbit.model(), family: self.orbit.family(), solution: self.number }
    }

    /// Which breathers, where all but the free parameter stand, and where that one starts.
    pub(crate) fn heading(&self, free: Parameter) -> String {
        let model = self.orbit.model();
        format!(
            "{} breathers, {}, {}; from solution {} of {} at {} = {}",
            self.orbit.name(),
            model.chain().layout(),
            fixed(model, free),
            self.number,
            self.count,
            free.name(),
            Number(model.get(free))
        )
    }
}

/// All parameters but the free one.
fn fixed(model: &Model, free: Parameter) -> String {
    let said = |parameter: Parameter| match parameter {
        Parameter::Amplitude if model.force().cosine_amplitude().is_none() => {
            Some(format!("force = {}", model.force()))
        }
        parameter if parameter == free => None,
        parameter => Some(format!("{} = {}", parameter.name(), Number(model.get(parameter)))),
    };
    let said: Vec<String> = Parameter::of(model.chain().layers()).iter().copied().filter_map(said).collect();
    said.join(", ")
}

/// The answer for people. Writing to a String cannot fail.
fn as_text(start: &Start, search: &Search, answer: &Answer) -> String {
    let mut out = String::new();
    let name = search.free.name();
    let _ = writeln!(out, "{} of {}", search.event.name(), start.heading(search.free));
    let count = answer.located.len();
    if count > 0 {
        let _ = writeln!(out, "{}{}", counted(count, "event"), if count > 1 { ", along the parameter" } else { "" });
    }
    for found in &answer.located {
        located_text(&mut out, name, found);
    }
    for place in &answer.unresolved {
        let (from, to) = (Number(place.from), Number(place.to));
        let _ =
            writeln!(out, "\na sign of one between {name} = {from} and {to}: rounding hides where, none is claimed");
    }
    if answer.located.is_empty() && answer.unresolved.is_empty() {
        let [(down, _), (up, _)] = &answer.ends;
        let _ = writeln!(out, "\nno {} between {name} = {} and {}", search.event.name(), Number(*down), Number(*up));
    }
    let _ = writeln!(out);
    for (direction, (value, end)) in ["down", "up"].into_iter().zip(&answer.ends) {
        let _ = writeln!(out, "{direction}: {}", message(search.free, *value, end));
    }
    let _ = writeln!(out, "{} orbits assembled, {} eigenvalue problems", answer.evaluations, answer.spectra);
    out
}

pub(crate) fn error_text(found: &Located) -> String {
    if found.error.is_finite() { format!("± {:.0e}", found.error) } else { "(error unknown)".to_owned() }
}

/// What shows an event.
pub(crate) fn evidence_text(found: &Located) -> String {
    match found.evidence {
        Evidence::Multiplier(mu) if mu.im == 0.0 => format!("multiplier {}", mu.re),
        Evidence::Multiplier(mu) => format!("multiplier {} ± {}i", mu.re, mu.im.abs()),
        Evidence::Touch(touch) => {
            let (site, barrier) = (found.orbit.model().chain().layout().name(touch.site), touch.barrier);
            format!("site {site} touches the {barrier} barrier at t = {}", Number(touch.time))
        }
        Evidence::Impact(impact) => format!("impact {impact} has no velocity left"),
    }
}

fn located_text(out: &mut String, name: &str, found: &Located) {
    let _ = writeln!(out, "\n{name} = {} {}", Number(found.value), error_text(found));
    let _ = writeln!(out, "  {}", evidence_text(found));
    let _ = writeln!(out, "  {}", found.orbit);
    if found.physical == Some(false) && matches!(found.evidence, Evidence::Multiplier(_)) {
        let _ = writeln!(out, "  not physical there");
    }
    for (value, verdict) in &found.verdicts {
        let _ = writeln!(out, "  at {name} = {}: {verdict}", Number(*value));
    }
    if let Some(branching) = &found.branching {
        let which = if branching.orbits.len() == 1 { "the doubled orbit" } else { "the asymmetric pair" };
        let side = if branching.above { "above" } else { "below" };
        let _ = writeln!(out, "  {which} exists {side} it; at {name} = {}:", Number(branching.value));
        branching.orbits.iter().for_each(|branched| branched_text(out, branched));
    }
}

fn branched_text(out: &mut String, branched: &BranchedOrbit) {
    let _ = writeln!(out, "    {}", branched.orbit);
    let physical = match branched.physical {
        Some(true) => "physical",
        Some(false) => "not physical",
        None => "not checked",
    };
    let stability = branched.verdict.as_ref().map_or("stability unknown".to_owned(), Verdict::to_string);
    let _ = writeln!(out, "    {physical}, {stability}");
}

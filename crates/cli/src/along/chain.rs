//! Breathers of a chain as its parameters vary.

use serde_json::{Map, Value, json};
use vibrochain_breather::{Finder, FreeNumbers, Orbit};
use vibrochain_floquet::{
    BranchRequest, Course, Diagram, Event, EventCurve, Search, Tolerance, diagram_until, locate_until,
};
use vibrochain_lattice::{Model, Parameter, Part, Stop};
use vibrochain_maps::caption::{describe_without, in_common, in_words};
use vibrochain_maps::numbers::Number;
use vibrochain_maps::scene::criterion;

use super::{Along, Events, FIRST, Start, around, begun, kind};
use crate::args::{AlongArgs, Free};
use crate::common::console::Console;
use crate::common::error::CliError;
use crate::common::model::{Chosen, chosen};
use crate::common::which;
use vibrochain_maps::manifest::object;

/// A breather, and where its model comes from.
pub(crate) struct ChainAlong {
    start: Start,
    /// Its model.
    model: Model,
    chosen: Chosen,
}

/// The range of a parameter: as flags have it, or else as the scene sweeps it.
fn asked(chosen: &Chosen, parameter: Parameter, flags: [Option<f64>; 2]) -> [Option<f64>; 2] {
    let axis = chosen.scene.as_ref().and_then(|scene| scene.axis(parameter));
    let [least, most] = axis.map_or([None; 2], |axis| axis.limits().map(Some));
    [flags[0].or(least), flags[1].or(most)]
}

/// What stands at the axes of a window.
pub(crate) fn labels(parameters: [Parameter; 2]) -> [String; 2] {
    parameters.map(|parameter| format!("{} {}", parameter.meaning(), parameter.symbol()))
}

/// All parameters but the free one.
fn fixed(model: &Model, free: Parameter) -> String {
    let said = |parameter: Parameter| match parameter {
        Parameter::Amplitude if model.force().cosine_amplitude().is_none() => {
            Some(format!("force = {}", model.force()))
        }
        parameter if parameter == free => None,
        parameter if parameter.row().part == Part::Dashpots && model.get(parameter) == 0.0 => None,
        parameter => Some(format!("{} = {}", parameter.name(), Number(model.get(parameter)))),
    };
    let said: Vec<String> = Parameter::of(model.chain().layers()).iter().copied().filter_map(said).collect();
    said.join(", ")
}

impl Along for ChainAlong {
    type Free = Parameter;
    type Scene = ();
    const OF_CHAINS: bool = true;

    fn free(flag: &Free) -> Result<Parameter, CliError> {
        flag.parameter()
    }

    fn name(free: Parameter) -> String {
        free.name().to_owned()
    }

    fn label(&self, free: Parameter) -> String {
        labels([free; 2])[0].clone()
    }

    fn begin(args: &AlongArgs, (): (), stop: &Stop, console: &mut Console<'_>) -> Result<Self, CliError> {
        let chosen = chosen(&args.model, console)?;
        let which = which::wanted(&args.which, chosen.scene.as_ref())?;
        let (model, free) = (&chosen.model, args.free.parameter()?);
        for (flag, value) in FIRST.into_iter().zip([args.from, args.to]) {
            let Some(value) = value else { continue };
            // In the range of the parameter, told before any work.
            model.with(free, value).map_err(|error| CliError::Request(format!("{flag}: {error}")))?;
        }
        around(FIRST, free.name(), model.get(free), asked(&chosen, free, [args.from, args.to]))?;
        let mut finder = Finder::new(model.chain().sites()).until(stop);
        let (_, found) = which::find(&which, model, &mut finder, None)?;
        let orbits = which::some(found)?;
        let is_physical = |orbit: &Orbit| Ok(finder.quick_admissibility(orbit)?.is_physical());
        let start = begun((orbits, ""), args, is_physical)?;
        Ok(Self { start, model: chosen.model, chosen })
    }

    fn start(&self) -> &Start {
        &self.start
    }

    fn value(&self, free: Parameter) -> Result<f64, CliError> {
        Ok(self.model.get(free))
    }

    fn allows(&self, free: Parameter, value: f64) -> Result<(), String> {
        self.model.with(free, value).map(drop).map_err(|error| error.to_string())
    }

    fn range(&self, free: Parameter, flags: [Option<f64>; 2]) -> Result<[f64; 2], CliError> {
        let Search { from, to, .. } = Search::new(&self.start.orbit, Event::Fold, free);
        let [least, most] = asked(&self.chosen, free, flags);
        Ok([least.unwrap_or(from), most.unwrap_or(to)])
    }

    fn tolerance(&self, threshold: Option<f64>) -> Result<Tolerance, CliError> {
        self.chosen.tolerance(threshold)
    }

    fn fixed(&self, free: Parameter) -> String {
        let (name, layout) = (self.start.orbit.name(), self.model.chain().layout());
        format!("{name} breathers, {layout}, {}", fixed(&self.model, free))
    }

    fn over_branches(&self, free: Parameter, tolerance: Tolerance) -> String {
        let fixed = describe_without(&self.model, free);
        format!("branches of breathers, {fixed}, {}", criterion(tolerance))
    }

    fn over_curves(&self, _: [Parameter; 2], curves: &[EventCurve]) -> String {
        let event = curves.first().map_or(String::new(), |curve| {
            format!("{} of {} breathers, ", in_words(curve.event.name()), self.start.orbit.name())
        });
        let ends = curves.iter().flat_map(|curve| [curve.points.first(), curve.points.last()]).flatten();
        let mut models: Vec<_> = ends.filter_map(|point| point.orbit.model()).collect();
        models.push(&self.model);
        format!("{event}{}", in_common(&models))
    }

    fn head(&self) -> Map<String, Value> {
        let Start { orbit, number, .. } = &self.start;
        let mut head = object([("parameters", json!(self.model)), ("solution", json!(number))]);
        head.extend(kind(orbit));
        head
    }

    fn diagram(&self, free: Parameter, course: &BranchRequest, stop: &Stop) -> Result<Diagram, CliError> {
        let BranchRequest { from, to, events, generations, tolerance } = course.clone();
        Ok(diagram_until(&self.start.orbit, &Course { free, from, to, events, generations, tolerance }, stop)?)
    }

    fn located(&self, event: Event, free: Parameter, [from, to]: [f64; 2], stop: &Stop) -> Result<Events, CliError> {
        let found = locate_until(&self.start.orbit, &Search { event, free, from, to }, stop)?;
        let counts = [found.evaluations, found.spectra];
        Ok(Events { located: found.located, unresolved: found.unresolved, ends: found.ends.into(), counts })
    }

    fn numbers(&self, free: [Parameter; 2], stop: &Stop) -> Result<FreeNumbers, CliError> {
        Ok(self.start.orbit.lattice()?.numbers(&free, stop))
    }
}

//! Orbits of a structure as its numbers vary.

use serde_json::{Map, Value, json};
use vibrochain_breather::{Finder, FreeNumbers, LoadedStructure, Orbit};
use vibrochain_floquet::{BranchRequest, Diagram, Event, EventCurve, Tolerance, branches};
use vibrochain_lattice::Stop;
use vibrochain_maps::caption::in_words;
use vibrochain_maps::scene::tolerance_from;
use vibrochain_maps::structure::along::{family, numbers, value};
use vibrochain_maps::structure::answer::structure;
use vibrochain_maps::structure::{Setting, StructureScene};

use super::{Along, Events, FIRST, Start, begun, checked_range};
use crate::args::{AlongArgs, Free};
use crate::common::console::Console;
use crate::common::error::CliError;
use crate::structures::orbit::{OfWord, found};
use vibrochain_maps::manifest::object;

/// An orbit of a scene's structure.
pub(crate) struct StructureAlong {
    scene: StructureScene,
    model: LoadedStructure,
    start: Start,
    word: String,
}

impl Along for StructureAlong {
    type Free = Setting;
    type Scene = StructureScene;
    const OF_CHAINS: bool = false;

    fn free(flag: &Free) -> Result<Setting, CliError> {
        flag.setting()
    }

    fn name(free: Setting) -> String {
        free.to_string()
    }

    fn label(&self, free: Setting) -> String {
        self.scene.label(free)
    }

    fn begin(args: &AlongArgs, scene: StructureScene, _: &Stop, _: &mut Console<'_>) -> Result<Self, CliError> {
        let free = args.free.setting()?;
        value(&scene, free)?;
        for (flag, end) in FIRST.into_iter().zip([args.from, args.to]) {
            let Some(end) = end else { continue };
            // In the range of the number, told before any work.
            scene.clone().set(free, end).map_err(|why| CliError::Request(format!("{flag}: {why}")))?;
        }
        let model = scene.model()?;
        let OfWord { found, word, .. } = found(&args.which, &scene, &model)?;
        ensure!(!found.orbits.is_empty(), CliError::IllPosed(format!("no orbit of {word} was found to start from")));
        let mut finder = Finder::default();
        let is_physical = |orbit: &Orbit| Ok(finder.quick_admissibility(orbit)?.is_physical());
        let start = begun((found.orbits, &format!(" of {word}")), args, is_physical)?;
        let along = Self { scene, model, start, word };
        checked_range(&along, free, FIRST, [args.from, args.to])?;
        Ok(along)
    }

    fn start(&self) -> &Start {
        &self.start
    }

    fn value(&self, free: Setting) -> Result<f64, CliError> {
        Ok(value(&self.scene, free)?)
    }

    fn allows(&self, free: Setting, value: f64) -> Result<(), String> {
        self.scene.clone().set(free, value)
    }

    fn range(&self, free: Setting, [from, to]: [Option<f64>; 2]) -> Result<[f64; 2], CliError> {
        let value = self.value(free)?;
        let axis = self.scene.axes.iter().find(|axis| axis.parameter == free);
        let usual = match free {
            Setting::RestitutionOfAll | Setting::Restitution(_) => [0.05, 1.0],
            _ if value == 0.0 => [0.0, 1.0],
            _ if value < 0.0 => [2.0 * value, 0.5 * value],
            _ => [0.5 * value, 2.0 * value],
        };
        let [low, high] = axis.map_or(usual, |axis| axis.limits());
        Ok([from.unwrap_or(low.min(value)), to.unwrap_or(high.max(value))])
    }

    fn tolerance(&self, threshold: Option<f64>) -> Result<Tolerance, CliError> {
        threshold.map_or(Ok(self.scene.tolerance), tolerance_from).map_err(CliError::Request)
    }

    fn fixed(&self, free: Setting) -> String {
        self.scene.fixed_but(&self.start.orbit.full_name(), &[free])
    }

    fn over_branches(&self, free: Setting, _: Tolerance) -> String {
        self.fixed(free)
    }

    fn over_curves(&self, free: [Setting; 2], found: &[EventCurve]) -> String {
        let event = found.first().map_or(String::new(), |curve| format!("{}, ", in_words(curve.event.name())));
        format!("{event}{}", self.scene.fixed_but(&self.start.orbit.full_name(), &free))
    }

    fn head(&self) -> Map<String, Value> {
        let number = self.start.number;
        let structure = structure(&self.scene, &self.model);
        object([("structure", structure), ("word", json!(self.word)), ("solution", json!(number))])
    }

    fn diagram(&self, free: Setting, course: &BranchRequest, stop: &Stop) -> Result<Diagram, CliError> {
        Ok(branches(&self.start.orbit, &family(&self.scene, &[free]), self.value(free)?, course, stop)?)
    }

    fn located(&self, event: Event, free: Setting, [from, to]: [f64; 2], stop: &Stop) -> Result<Events, CliError> {
        let (events, tolerance) = (vec![event], self.scene.tolerance);
        let course = BranchRequest { from, to, events, generations: 0, tolerance };
        let mut found = self.diagram(free, &course, stop)?;
        let (branch, counts) = (found.branches.swap_remove(0), [found.evaluations, found.spectra]);
        let located = branch.events().cloned().collect();
        Ok(Events { located, unresolved: branch.unresolved, ends: branch.ends, counts })
    }

    fn numbers(&self, free: [Setting; 2], _: &Stop) -> Result<FreeNumbers, CliError> {
        Ok(numbers(&self.scene, &free)?)
    }
}

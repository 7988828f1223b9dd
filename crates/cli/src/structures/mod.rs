//! Any linear structure with stops: what `orbit`, `sweep` and others do for a scene with `[structure]`, and for a chain with stops of its own.

pub(crate) mod answer;
pub(crate) mod orbit;
mod pictures;
mod run_answer;
mod run_plot;
pub(crate) mod simulate;

use std::path::Path;

use serde_json::json;
use vibrochain_lattice::{DampedParameter, Ends, Parameter, RowEnds};
use vibrochain_maps::scene::Given;
use vibrochain_maps::structure::{Setting, StructureScene};

use crate::args::ModelArgs;
use crate::common::console::{ctrl_c, interruptible};
use crate::common::error::CliError;
use vibrochain_maps::manifest::object;

/// The structure that is asked about: a scene's, or a chain with what flags add to it; `None` of a plain chain.
///
/// # Errors
/// [`CliError::Request`] for flags that do not go together, and for what is wrong in the scene.
pub(crate) fn asked(args: &ModelArgs) -> Result<Option<StructureScene>, CliError> {
    let scene = args.scene.as_deref().map(read).transpose()?.flatten();
    let mut scene = match scene {
        Some(scene) => {
            let of_chain = Parameter::ALL.into_iter().filter(|one| *one != Parameter::Omega);
            let flag = of_chain.filter(|one| args.values.get(*one).is_some()).map(Parameter::flag).next();
            let flag = flag.or_else(|| args.sites.map(|_| "sites".to_owned()));
            if let Some(flag) = flag.or_else(|| args.of_structures()) {
                refuse!(
                    "--{flag} is of chains, and the scene holds a structure: change its numbers by --set NAME=VALUE"
                );
            }
            scene
        }
        None if args.of_structures().is_some() => chain(args)?,
        None if !args.structure.set.is_empty() => match &args.scene {
            Some(path) => refuse!(
                "--set changes the numbers of a structure, and {} holds a chain: change its parameters by their flags, as --gamma1",
                Given::read(path)?.path.display()
            ),
            None => refuse!("--set changes the numbers of a structure: give --scene with [structure]"),
        },
        None => return Ok(None),
    };
    if let Some(omega) = args.values.get(Parameter::Omega) {
        scene.set(Setting::Omega, omega)?;
    }
    for text in &args.structure.set {
        let (name, value) =
            text.split_once('=').ok_or_else(|| CliError::Request(format!("--set {text}: give NAME=VALUE")))?;
        let value = value.parse().map_err(|_| CliError::Request(format!("--set {text}: {value} is not a number")))?;
        name.parse()
            .and_then(|setting| scene.set(setting, value))
            .map_err(|why| CliError::Request(format!("--set: {why}")))?;
    }
    Ok(Some(scene))
}

/// The scene of a file if it is one of a structure: it, and all that it is asked, ends early by a signal.
///
/// # Errors
/// [`CliError::Request`] with what is wrong in the scene.
pub(crate) fn read(scene: &Path) -> Result<Option<StructureScene>, CliError> {
    let path = scene.to_owned();
    let scene = interruptible(move || StructureScene::read(&path))??;
    let stop = ctrl_c()?;
    Ok(scene.map(|scene| scene.until(&stop)))
}

/// Refuses what only lattices can be asked.
///
/// # Errors
/// [`CliError::Request`] with the commands that answer.
pub(crate) fn refuse(args: &ModelArgs) -> Result<(), CliError> {
    match asked(args)? {
        Some(_) => Err(refusal()),
        None => Ok(()),
    }
}

/// The same of a scene that a command reads as one of a chain.
///
/// # Errors
/// [`CliError::Request`] with the commands that answer, or what is wrong in the scene.
pub(crate) fn refuse_scene(scene: &Path) -> Result<(), CliError> {
    match read(scene)? {
        Some(_) => Err(refusal()),
        None => Ok(()),
    }
}

fn refusal() -> CliError {
    let message = "structures, and chains with a static force, stops of their own, ends fixed-free or dashpots without a force, are asked by orbit, branch, \
                   locate, curve, simulate, fate, sweep and explore: this command takes chains without any of these";
    CliError::Request(message.to_owned())
}

/// A chain with a static force, or stops of its own, or dashpots and no force.
fn chain(args: &ModelArgs) -> Result<StructureScene, CliError> {
    if let Some(path) = &args.scene {
        // A file that is missing or broken says so itself.
        Given::read(path)?;
        refuse!(
            "a scene's chain takes no static force and no stops of its own: write it as [structure] with chain = {{ … }}, or give all by flags"
        );
    }
    if args.layers.is_some_and(|layers| layers != 1) || args.force.is_some() {
        let message = "static forces, stops of their own and dashpots without a force are of one row under a plain force: leave --layers and --force away";
        return Err(CliError::Request(message.to_owned()));
    }
    let sites = args.sites.ok_or_else(|| CliError::Request("sites is missing: give --sites".to_owned()))?;
    ensure!(sites >= 1, "sites = {sites} is out of range: give a whole number from 1");
    let mut model = object([
        ("sites", json!(sites)),
        ("ends", json!(args.ends.unwrap_or(RowEnds::Alike(Ends::Closed)).name())),
        ("stops", json!(args.structure.stops)),
    ]);
    let plain = Parameter::of(1).iter().copied().filter(|one| *one != Parameter::Omega);
    for (parameter, value) in plain.filter_map(|one| Some((one, args.values.get(one)?))) {
        parameter.check(value)?;
        model.insert(parameter.name().to_owned(), json!(value));
    }
    for (parameter, value) in DampedParameter::ALL.into_iter().filter_map(|one| Some((one, args.values.own(one)?))) {
        parameter.check(value)?;
        model.insert(parameter.name().to_owned(), json!(value));
    }
    if args.values.get(Parameter::Amplitude).is_none_or(|amplitude| amplitude == 0.0) {
        model.entry(Parameter::Restitution.name()).or_insert(json!(1.0));
    }
    Ok(StructureScene::of_model(model)?)
}

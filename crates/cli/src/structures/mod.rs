//! Any linear structure with stops: what `orbit`, `sweep` and others do for a scene with `[structure]`, and for a chain with dashpots.

pub(crate) mod answer;
pub(crate) mod orbit;
mod pictures;
mod run_answer;
mod run_plot;
pub(crate) mod simulate;

use std::path::Path;

use vibrochain_lattice::{Contact, Ends, Parameter};
use vibrochain_maps::structure::{ChainTable, MOST_MASSES, Setting, StructureScene};

use crate::args::{ModelArgs, RowEnds};
use crate::common::error::CliError;

/// The structure that is asked about: a scene's, or a chain with what flags add to it; `None` of a plain chain.
///
/// # Errors
/// [`CliError::Request`] for flags that do not go together, and for what is wrong in the scene.
pub(crate) fn asked(args: &ModelArgs) -> Result<Option<StructureScene>, CliError> {
    let scene = args.scene.as_deref().map(StructureScene::read).transpose()?.flatten();
    let mut scene = match scene {
        Some(scene) => {
            let of_chain = Parameter::ALL.into_iter().filter(|one| *one != Parameter::Omega);
            let flag = of_chain.filter(|one| args.values.get(*one).is_some()).map(Parameter::flag).next();
            let flag = flag.or_else(|| args.sites.map(|_| "sites".to_owned()));
            if let Some(flag) = flag.or_else(|| args.of_structures().map(str::to_owned)) {
                let message = format!(
                    "--{flag} is of chains, and the scene holds a structure: change its numbers by --set NAME=VALUE"
                );
                return Err(CliError::Request(message));
            }
            scene
        }
        None if args.of_structures().is_some() => chain(args)?,
        None if !args.structure.set.is_empty() => {
            return Err(CliError::Request(
                "--set changes the numbers of a structure: give --scene with [structure]".to_owned(),
            ));
        }
        None => return Ok(None),
    };
    if let Some(omega) = args.values.get(Parameter::Omega) {
        scene.set(Setting::Omega, omega).map_err(CliError::Request)?;
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

/// Refuses what only chains without dashpots can be asked.
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
    match StructureScene::read(scene)? {
        Some(_) => Err(refusal()),
        None => Ok(()),
    }
}

fn refusal() -> CliError {
    let message = "structures, and chains with dashpots, a static force, stops of their own or ends fixed-free, are asked by orbit, branch, \
                   locate, curve, simulate, fate, sweep and explore: this command takes chains without any of these";
    CliError::Request(message.to_owned())
}

/// A chain with dashpots, a static force, or stops of its own.
fn chain(args: &ModelArgs) -> Result<StructureScene, CliError> {
    let extra = &args.structure;
    let missing = |name: &str| CliError::Request(format!("{name} is missing: give --{name}"));
    if args.scene.is_some() {
        let message =
            "a scene's chain takes no dashpots: write it as [structure] with chain = { … }, or give all by flags";
        return Err(CliError::Request(message.to_owned()));
    }
    if args.layers.is_some_and(|layers| layers != 1) || args.force.is_some() {
        let message = "dashpots, static forces and stops of their own are of one row under a plain force: leave --layers and --force away";
        return Err(CliError::Request(message.to_owned()));
    }
    let value = |parameter: Parameter| -> Result<Option<f64>, CliError> {
        let given = args.values.get(parameter);
        given.map(|value| parameter.check(value).map(|()| value)).transpose().map_err(CliError::from)
    };
    let sites = args.sites.ok_or_else(|| missing("sites"))?;
    let sites = usize::try_from(sites)
        .map_err(|_| CliError::Request(format!("sites = {sites} is out of range: give a whole number from 1")))?;
    if !(1..=MOST_MASSES).contains(&sites) {
        let message = format!(
            "sites = {sites} is out of range: with dashpots or stops of its own a chain has 1 to {MOST_MASSES} masses"
        );
        return Err(CliError::Request(message));
    }
    let asymmetry = value(Parameter::Asymmetry)?;
    let by = |own: Option<f64>, side: f64| own.or_else(|| asymmetry.map(|a| a + side));
    let (lower, upper) = (by(extra.lower, -1.0), by(extra.upper, 1.0));
    let amplitude = value(Parameter::Amplitude)?.unwrap_or(0.0);
    let restitution = value(Parameter::Restitution)?;
    let restitution = match restitution {
        Some(restitution) => restitution,
        None if amplitude == 0.0 => 1.0,
        None => return Err(missing("restitution")),
    };
    if let Some(stop) = extra.stops.iter().find(|stop| **stop >= sites) {
        return Err(CliError::Request(format!(
            "--stops: site {stop} does not exist: this chain has the sites 0 to {}",
            sites.saturating_sub(1)
        )));
    }
    let contact = |site: usize| {
        let stopped = extra.stops.is_empty() || extra.stops.contains(&site);
        if stopped { Contact { lower, upper, restitution } } else { Contact { lower: None, upper: None, restitution } }
    };
    let table = ChainTable {
        sites,
        gamma1: value(Parameter::Gamma1)?.ok_or_else(|| missing("gamma1"))?,
        gamma2: value(Parameter::Gamma2)?.ok_or_else(|| missing("gamma2"))?,
        ends: args.ends.unwrap_or(RowEnds::Alike(Ends::Closed)).name().to_owned(),
        damping: extra.damping.unwrap_or(0.0),
        coupling_damping: extra.coupling_damping.unwrap_or(0.0),
    };
    let contacts = (0..sites).map(contact).collect();
    StructureScene::of_chain(table, contacts, amplitude, extra.static_force.unwrap_or(0.0)).map_err(CliError::Request)
}

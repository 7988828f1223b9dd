//! Scenes of chains with a static force or stops of their own, and of others that no model of a lattice has: self-excited, plastic, or with
//! springs or barriers out of its range.

use std::path::Path;

use serde::Deserialize;
use serde_json::{Map, Value};
use vibrochain_lattice::DampedParameter::{Lower, StaticForce, Upper};
use vibrochain_lattice::Parameter::{
    Amplitude, Asymmetry, CouplingDamping, Damping, Gamma1, Gamma2, Omega, Restitution,
};
use vibrochain_lattice::{Contact, DampedParameter, Parameter, Range, RowEnds};

use super::scene::StructureScene;
use super::setting::Setting;
use super::sizes::check_size;
use super::tables::{ChainTable, ComputeTable, SweepTable};
use crate::error::MapError;
use crate::scene::{ModelTable, Source, damped_keys};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    title: Option<String>,
    model: ModelTable<true>,
    sweep: Option<SweepTable>,
    compute: Option<ComputeTable>,
}

/// Refuses by its own key what a chain hands on to matrices, loads and contacts, which have other names.
fn check(model: &ModelTable<true>) -> Result<(), String> {
    let plain = Parameter::ALL.map(|parameter| (parameter.name(), model.value(parameter)));
    let own = DampedParameter::ALL.map(|parameter| (parameter.name(), model.own(parameter)));
    let beyond = |value: &f64| !Range::REAL.contains(*value);
    match plain.into_iter().chain(own).find_map(|(name, value)| Some((name, value.filter(beyond)?))) {
        Some((name, value)) => Err(format!("{name} = {value} is out of range: give {}", Range::REAL.told)),
        None => Ok(()),
    }
}

/// Whether a scene is one of these.
pub(super) fn is_one(scene: &Value) -> bool {
    let (model, sweep) = (&scene["model"], &scene["sweep"]);
    let in_model = model["ends"] == RowEnds::FixedFree.name() || damped_keys().any(|key| model.get(key).is_some());
    let swept = |key: &str| ["x", "y"].iter().any(|axis| sweep[axis]["parameter"] == key);
    in_model || model.is_object() && (damped_keys().any(swept) || is_beyond(model, &swept))
}

/// Whether `[model]` names dashpots, and no lattice has the rest: without a force a period of its own, or values out of range.
fn is_beyond(model: &Value, swept: &impl Fn(&str) -> bool) -> bool {
    let value = |parameter: Parameter| {
        [&model[parameter.name()], &model["forcing"][parameter.name()]].into_iter().find_map(Value::as_f64)
    };
    let is_there = |parameter: Parameter| value(parameter).is_some() || swept(parameter.name());
    let is_forced = is_there(Amplitude) || swept("load") || model.get("force").is_some();
    let is_out = |parameter: Parameter| value(parameter).is_some_and(|value| !parameter.row().range.contains(value));
    [Damping, CouplingDamping].into_iter().any(is_there)
        && (!is_forced || Parameter::ALL.into_iter().any(is_out))
        && model.get("layers").is_none()
}

impl StructureScene {
    /// The scene of what `[model]` has in one of these.
    ///
    /// # Errors
    /// [`MapError::Request`] with what is wrong in it.
    pub fn of_model(model: Map<String, Value>) -> Result<Self, MapError> {
        let told = Map::from_iter([("model".to_owned(), model.into())]);
        let file = Source { path: Path::new("model"), text: "" }.tables(&told.clone().into(), None)?;
        Ok(read((file, told))?)
    }
}

/// The scene of a file's tables, and of all that they say.
pub(super) fn read((file, told): (File, Map<String, Value>)) -> Result<StructureScene, String> {
    let File { title, model, sweep, compute } = file;
    check(&model)?;
    // What varies may be left out: it begins anywhere.
    let varies = |names: &[&str]| sweep.as_ref().is_some_and(|sweep| sweep.varies(names));
    let given = |parameter: Parameter| match model.value(parameter) {
        Some(value) => Ok(value),
        None if varies(&[parameter.name()]) => Ok(0.5),
        None => Err(format!("{parameter} is missing: give it in [model], or by --{}", parameter.flag())),
    };
    let forced = model.value(Amplitude).is_some() || varies(&["amplitude", "load"]);
    let restitution = match model.value(Restitution) {
        Some(restitution) => restitution,
        None if varies(&["restitution"]) || !forced => 1.0,
        None => return Err("restitution is missing: a force needs it in [model], or by --restitution".to_owned()),
    };
    let asymmetry = model.value(Asymmetry).or(varies(&["asymmetry"]).then_some(0.0));
    let by = |own: DampedParameter, side: f64| model.own(own).or_else(|| asymmetry.map(|a| a + side));
    let (lower, upper) = (by(Lower, -1.0), by(Upper, 1.0));
    if lower.is_none() && upper.is_none() {
        return Err("nothing stops the masses: give asymmetry, lower or upper in [model]".to_owned());
    }
    let count = *model.sites.get_ref();
    let sites = usize::try_from(count).ok().filter(|sites| *sites > 0);
    let sites = sites.ok_or_else(|| format!("sites = {count} is out of range: give a whole number from 1"))?;
    check_size("sites", sites)?;
    if let Some(stop) = model.stops.iter().find(|stop| **stop >= sites) {
        return Err(format!("stops: site {stop} does not exist: this chain has the sites 0 to {}", sites - 1));
    }
    let contact = |site: usize| {
        let stopped = model.stops.is_empty() || model.stops.contains(&site);
        let [lower, upper] = [lower, upper].map(|barrier| barrier.filter(|_| stopped));
        Contact { lower, upper, restitution }
    };
    let chain = ChainTable {
        sites,
        gamma1: given(Gamma1)?,
        gamma2: given(Gamma2)?,
        ends: model.ends.as_ref().map_or("closed", |ends| ends.get_ref()).to_owned(),
        damping: model.value(Damping).unwrap_or(0.0),
        coupling_damping: model.value(CouplingDamping).unwrap_or(0.0),
    };
    let mut scene = StructureScene::of_chain(&chain, (0..sites).map(contact).collect(), 0.0, 0.0)?;
    scene.title = title;
    let numbers = [
        (Setting::Omega, model.value(Omega)),
        (Setting::Load, model.value(Amplitude)),
        (Setting::Static, model.own(StaticForce)),
    ];
    for (setting, value) in numbers {
        value.map_or(Ok(()), |value| scene.set(setting, value))?;
    }
    scene.with_map(told, sweep.as_ref(), compute.as_ref())
}

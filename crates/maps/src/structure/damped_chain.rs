//! Scenes of chains with dashpots, a static force or stops of their own: `[model]` with keys that plain chains do not have.

use std::path::Path;

use serde::Deserialize;
use serde_json::{Map, Value};
use vibrochain_lattice::{Contact, MAX_MAGNITUDE};

use super::definition::MOST_MASSES;
use super::scene::StructureScene;
use super::setting::Setting;
use super::tables::{ChainTable, ComputeTable, SweepTable};
use crate::error::MapError;
use crate::scene::Source;

/// Keys, and parameters of axes, that make a chain one of these.
const KEYS: [&str; 6] = ["damping", "coupling_damping", "static_force", "stops", "lower", "upper"];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    title: Option<String>,
    model: Model,
    sweep: Option<SweepTable>,
    compute: Option<ComputeTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Model {
    sites: usize,
    #[serde(default = "ring")]
    ends: String,
    gamma1: Option<f64>,
    gamma2: Option<f64>,
    omega: Option<f64>,
    asymmetry: Option<f64>,
    amplitude: Option<f64>,
    restitution: Option<f64>,
    #[serde(default)]
    forcing: Forcing,
    damping: Option<f64>,
    coupling_damping: Option<f64>,
    static_force: Option<f64>,
    #[serde(default)]
    stops: Vec<usize>,
    lower: Option<f64>,
    upper: Option<f64>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Forcing {
    amplitude: Option<f64>,
    restitution: Option<f64>,
}

impl Model {
    /// Refuses by its own key what a chain hands on to matrices, loads and contacts, which have other names.
    fn check(&self) -> Result<(), String> {
        let numbers = [
            ("gamma1", self.gamma1),
            ("gamma2", self.gamma2),
            ("omega", self.omega),
            ("asymmetry", self.asymmetry),
            ("amplitude", self.amplitude.or(self.forcing.amplitude)),
            ("restitution", self.restitution.or(self.forcing.restitution)),
            ("damping", self.damping),
            ("coupling_damping", self.coupling_damping),
            ("static_force", self.static_force),
            ("lower", self.lower),
            ("upper", self.upper),
        ];
        let beyond = |value: &f64| value.is_nan() || value.abs() > MAX_MAGNITUDE;
        match numbers.into_iter().find_map(|(name, value)| Some((name, value.filter(beyond)?))) {
            Some((name, value)) => {
                Err(format!("{name} = {value} is out of range: give a number between -1e100 and 1e100"))
            }
            None => Ok(()),
        }
    }
}

fn ring() -> String {
    "closed".to_owned()
}

/// Whether a scene is one of these.
pub(super) fn is_one(scene: &Value) -> bool {
    let (model, sweep) = (&scene["model"], &scene["sweep"]);
    let in_model = model["ends"] == "fixed-free" || KEYS.iter().any(|key| model.get(key).is_some());
    let swept = |axis: &&str| sweep[axis]["parameter"].as_str().is_some_and(|name| KEYS.contains(&name));
    in_model || model.is_object() && ["x", "y"].iter().any(swept)
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
    model.check()?;
    // What varies may be left out: it begins anywhere.
    let varies = |names: &[&str]| sweep.as_ref().is_some_and(|sweep| sweep.varies(names));
    let given = |name: &str, value: Option<f64>| match value {
        Some(value) => Ok(value),
        None if varies(&[name]) => Ok(0.5),
        None => Err(format!("{name} is missing: give it in [model], or by --{name}")),
    };
    let amplitude = model.amplitude.or(model.forcing.amplitude);
    let forced = amplitude.is_some() || varies(&["amplitude", "load"]);
    let restitution = model.restitution.or(model.forcing.restitution);
    let restitution = match restitution {
        Some(restitution) => restitution,
        None if varies(&["restitution"]) || !forced => 1.0,
        None => return Err("restitution is missing: a force needs it in [model], or by --restitution".to_owned()),
    };
    let asymmetry = if varies(&["asymmetry"]) { Some(model.asymmetry.unwrap_or(0.0)) } else { model.asymmetry };
    let by = |own: Option<f64>, side: f64| own.or_else(|| asymmetry.map(|a| a + side));
    let (lower, upper) = (by(model.lower, -1.0), by(model.upper, 1.0));
    if lower.is_none() && upper.is_none() {
        return Err("nothing stops the masses: give asymmetry, lower or upper in [model]".to_owned());
    }
    if !(1..=MOST_MASSES).contains(&model.sites) {
        return Err(format!("sites = {} is out of range: give a whole number from 1 to {MOST_MASSES}", model.sites));
    }
    if let Some(stop) = model.stops.iter().find(|stop| **stop >= model.sites) {
        return Err(format!(
            "stops: site {stop} does not exist: this chain has the sites 0 to {}",
            model.sites.saturating_sub(1)
        ));
    }
    let contact = |site: usize| {
        let stopped = model.stops.is_empty() || model.stops.contains(&site);
        let [lower, upper] = [lower, upper].map(|barrier| barrier.filter(|_| stopped));
        Contact { lower, upper, restitution }
    };
    let chain = ChainTable {
        sites: model.sites,
        gamma1: given("gamma1", model.gamma1)?,
        gamma2: given("gamma2", model.gamma2)?,
        ends: model.ends.clone(),
        damping: model.damping.unwrap_or(0.0),
        coupling_damping: model.coupling_damping.unwrap_or(0.0),
    };
    let contacts = (0..model.sites).map(contact).collect();
    let mut scene = StructureScene::of_chain(chain, contacts, 0.0, 0.0)?;
    scene.title = title;
    let numbers = [(Setting::Omega, model.omega), (Setting::Load, amplitude), (Setting::Static, model.static_force)];
    for (setting, value) in numbers {
        value.map_or(Ok(()), |value| scene.set(setting, value))?;
    }
    scene.with_map(told, sweep.as_ref(), compute.as_ref())
}

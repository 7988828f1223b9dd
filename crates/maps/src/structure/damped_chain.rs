//! Scenes of chains with dashpots, a static force or stops of their own: `[model]` with keys that plain chains do not have.

use serde::Deserialize;
use serde_json::{Map, Value};
use vibrochain_lattice::Contact;

use super::definition::MOST_MASSES;
use super::scene::StructureScene;
use super::setting::Setting;
use super::tables::{ChainTable, ComputeTable, SweepTable};

/// Keys, and parameters of axes, that make a chain one of these.
const KEYS: [&str; 6] = ["damping", "coupling_damping", "static_force", "stops", "lower", "upper"];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
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

fn ring() -> String {
    "closed".to_owned()
}

/// Whether a scene is one of these.
pub(super) fn is_one(scene: &Map<String, Value>) -> bool {
    let model = scene.get("model").and_then(Value::as_object);
    let fixed_free = |model: &Map<String, Value>| model.get("ends").and_then(Value::as_str) == Some("fixed-free");
    let in_model = model.is_some_and(|model| KEYS.iter().any(|key| model.contains_key(*key)) || fixed_free(model));
    let sweep = scene.get("sweep").and_then(Value::as_object);
    let axes = sweep.into_iter().flat_map(|sweep| ["x", "y"].map(|axis| sweep.get(axis)));
    let swept = axes.flatten().filter_map(|axis| axis.get("parameter")?.as_str()).any(|name| KEYS.contains(&name));
    in_model || model.is_some() && swept
}

impl StructureScene {
    /// The scene of what `[model]` has in one of these.
    ///
    /// # Errors
    /// What is wrong in it.
    pub fn of_model(model: Map<String, Value>) -> Result<Self, String> {
        read([("model".to_owned(), model.into())].into_iter().collect())
    }
}

/// The scene of all that a file says.
pub(super) fn read(told: Map<String, Value>) -> Result<StructureScene, String> {
    let File { title, model, sweep, compute } =
        serde_json::from_value(told.clone().into()).map_err(|error| error.to_string())?;
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
    let mut scene =
        StructureScene::of_chain(chain, contacts, amplitude.unwrap_or(0.0), model.static_force.unwrap_or(0.0))?;
    scene.title = title;
    if let Some(omega) = model.omega {
        scene.set(Setting::Omega, omega)?;
    }
    scene.with_map(told, sweep.as_ref(), compute.as_ref())
}

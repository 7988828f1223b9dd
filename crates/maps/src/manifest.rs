//! The JSON file beside a table: everything needed to know where the table came from and to make it again.

use serde_json::{Map, Value, json};
use vibrochain_floquet::Tolerance;
use vibrochain_lattice::{Parameter, PointPart};

use crate::cell::{Class, Status};
use crate::scene::{Axis, Refine, Scene, Values};
use crate::summary::Summary;

/// The program's version.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The form of manifests, as `mapgen schema manifest` prints it.
pub const SCHEMA: &str = "urn:vibrochain:manifest:1";

/// The git revision it was built from, if known.
pub const REVISION: Option<&str> = option_env!("VIBROCHAIN_REVISION");

/// The instructions it was built for: without fused multiply-add the last digits may differ.
pub fn target() -> String {
    format!("{}{}", std::env::consts::ARCH, if cfg!(target_feature = "fma") { "+fma" } else { "" })
}

/// What a manifest tells of a run.
#[derive(Debug)]
pub struct Run<'a> {
    /// The scene file's name as given.
    pub scene_file: &'a str,
    /// The scene.
    pub scene: &'a Scene,
    /// The version of the program that computed the cells.
    pub version: &'a str,
    /// The git revision it was built from, if known.
    pub revision: Option<&'a str>,
    /// The result.
    pub summary: &'a Summary,
    /// How the cells were computed; unknown of a table merged from the chunks of many runs.
    pub effort: Option<Effort>,
}

/// What one run took.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Threads used.
    pub threads: usize,
    /// Cells computed, less than all where a run was resumed.
    pub computed_cells: u64,
    /// Wall time, in seconds.
    pub wall_seconds: f64,
}

fn axis(axis: &Axis) -> Value {
    let parameter = axis.parameter.name();
    match &axis.values {
        Values::Linear { from, to, points } => {
            json!({ "parameter": parameter, "from": from, "to": to, "points": points })
        }
        Values::Logarithmic { from, to, points } => {
            json!({ "parameter": parameter, "from": from, "to": to, "points": points, "spacing": "log" })
        }
        Values::List(values) => json!({ "parameter": parameter, "values": values }),
    }
}

/// Everything of a scene that decides what its table holds: `model`, `sweep`, `compute`.
pub fn scene_parts(scene: &Scene) -> Map<String, Value> {
    let is_fixed = |parameter: &Parameter| !scene.sweeps(*parameter);
    let fixed = Parameter::of(scene.base.layout.layers).iter().copied().filter(is_fixed).collect();
    let model = PointPart { point: &scene.base, parameters: [Vec::new(), fixed] };
    let mut sweep = Map::new();
    for (name, each) in ["x", "y"].iter().zip(&scene.axes) {
        sweep.insert((*name).to_owned(), axis(each));
    }
    if scene.axes.len() > 2 {
        sweep.insert("axes".to_owned(), scene.axes.iter().skip(2).map(axis).collect());
    }
    if let Some(Refine { depth }) = scene.refine {
        sweep.insert("refine".to_owned(), json!({ "depth": depth }));
    }
    let threshold = match scene.task.tolerance {
        Tolerance::Rounding => Value::Null,
        Tolerance::Growth(growth) => growth.into(),
    };
    let families: Vec<String> = scene.task.family_names().collect();
    let mut compute = json!({ "families": families, "stability": scene.task.stability, "threshold": threshold });
    if scene.task.collisions {
        compute["collisions"] = true.into();
    }
    if scene.task.impulse {
        compute["impulse"] = true.into();
    }
    [("model", json!(model)), ("sweep", sweep.into()), ("compute", compute)]
        .map(|(name, value): (_, Value)| (name.to_owned(), value))
        .into_iter()
        .collect()
}

/// The manifest as a JSON value.
pub fn manifest(run: &Run<'_>) -> Value {
    let counts = |names: &mut dyn Iterator<Item = (&'static str, u64)>| -> Value {
        names
            .filter(|(_, count)| *count > 0)
            .map(|(name, count)| (name.to_owned(), count.into()))
            .collect::<Map<_, _>>()
            .into()
    };
    let mut all = Map::new();
    let mut add = |name: &str, value: Value| drop(all.insert(name.to_owned(), value));
    add("schema", SCHEMA.into());
    add("program", "mapgen".into());
    add("version", run.version.into());
    add("revision", run.revision.into());
    add("scene", run.scene_file.into());
    add("title", run.scene.title.clone().into());
    for (name, part) in scene_parts(run.scene) {
        add(&name, part);
    }
    add("cells", (run.scene.cells() * run.scene.cells_within()).into());
    if let Some(may_miss) = run.scene.may_miss() {
        let grid: Vec<usize> = run.scene.finest().axes.iter().map(Axis::points).collect();
        add("refinement", json!({ "grid": grid, "leaves": run.summary.computed, "may_miss": may_miss }));
    }
    add("classes", counts(&mut Class::ALL.iter().map(|c| c.name()).zip(run.summary.classes)));
    add("statuses", counts(&mut Status::ALL.iter().map(|s| s.name()).zip(run.summary.statuses)));
    add("worst_residual", run.summary.worst_residual.into());
    if let Some(effort) = run.effort {
        add("threads", effort.threads.into());
        add("computed_cells", effort.computed_cells.into());
        add("wall_seconds", effort.wall_seconds.into());
    }
    all.into()
}

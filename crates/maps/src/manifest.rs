//! The JSON file beside a table: everything needed to know where the table came from and to make it again.

use serde::Serialize;
use serde_json::{Map, Value, json};
use vibrochain_lattice::{Parameter, PointPart};

use crate::absence::Absence;
use crate::cell::Status;
use crate::grid::Grid;
use crate::obstructions::Obstructed;
use crate::scene::Scene;
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
pub struct Run<'a, S = Scene> {
    /// The scene file's name as given.
    pub scene_file: &'a str,
    /// The scene.
    pub scene: &'a S,
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
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Effort {
    /// Threads used.
    pub threads: usize,
    /// Cells computed, less than all where a run was resumed.
    pub computed_cells: u64,
    /// Wall time, in seconds.
    pub wall_seconds: f64,
}

/// Keys with values, in this order.
#[must_use]
pub fn object<const N: usize>(keys: [(&str, Value); N]) -> Map<String, Value> {
    keys.map(|(key, value)| (key.to_owned(), value)).into_iter().collect()
}

/// The same without those that are null.
fn given<const N: usize>(keys: [(&str, Value); N]) -> Map<String, Value> {
    object(keys).into_iter().filter(|(_, value)| !value.is_null()).collect()
}

/// Everything of a scene that decides what its table holds: `model`, `sweep`, `compute`.
pub fn scene_parts(scene: &Scene) -> Map<String, Value> {
    let is_fixed = |parameter: &Parameter| !scene.sweeps(*parameter);
    let fixed = Parameter::of(scene.base.layout.layers).iter().copied().filter(is_fixed).collect();
    let model = PointPart { point: &scene.base, parameters: [Vec::new(), fixed] };
    let (axes, task) = (&scene.axes, &scene.task);
    let rest = axes.get(2..).unwrap_or_default();
    let rest = (!rest.is_empty()).then_some(rest);
    let [x, y] = [axes.first(), axes.get(1)].map(|axis| json!(axis));
    let sweep = given([("x", x), ("y", y), ("axes", json!(rest))]);
    let mut compute = object([
        ("families", task.family_names().collect()),
        ("stability", json!(task.stability)),
        ("threshold", json!(task.tolerance)),
    ]);
    let asked = [("collisions", task.collisions), ("impulse", task.impulse)];
    compute.extend(asked.into_iter().filter(|(_, asked)| *asked).map(|(key, _)| (key.to_owned(), json!(true))));
    object([("model", json!(model)), ("sweep", sweep.into()), ("compute", compute.into())])
}

/// Cells without a physical orbit by the reason, and by the contact and the impact where a contact is in the way.
fn absences(summary: &Summary) -> Vec<Map<String, Value>> {
    let obstructions = summary.obstructions.all();
    let counts = Absence::ALL.into_iter().zip(summary.absences);
    let of = |(absence, count): (Absence, u64)| {
        let own = || obstructions.iter().filter(move |one| one.absence == absence);
        let rest = count.saturating_sub(own().map(|one| one.cells).sum());
        let entry = |one: &Obstructed| {
            let reason = json!(absence.name());
            let [from, to] = one.after.map(|after| json!(after));
            let [contact, impact] = [one.contact, one.impact].map(|number| json!(number));
            object([
                ("reason", reason),
                ("cells", json!(one.cells)),
                ("contact", contact),
                ("impact", impact),
                ("from", from),
                ("to", to),
            ])
        };
        let all: Vec<_> = own().map(entry).collect();
        let others = (rest > 0).then(|| object([("reason", json!(absence.name())), ("cells", json!(rest))]));
        all.into_iter().chain(others)
    };
    counts.flat_map(of).collect()
}

/// The manifest as a JSON value.
pub fn manifest<S: Grid>(run: &Run<'_, S>) -> Value {
    let (scene, summary) = (run.scene, run.summary);
    let count = |(name, count): (&str, u64)| (count > 0).then(|| (name.to_owned(), Value::from(count)));
    let classes: Map<_, _> = summary.by_name(S::class_name).into_iter().filter_map(count).collect();
    let statuses = Status::ALL.iter().map(|status| status.name()).zip(summary.statuses);
    let mut told = object([
        ("schema", json!(SCHEMA)),
        ("program", json!("mapgen")),
        ("version", json!(run.version)),
        ("revision", json!(run.revision)),
        ("scene", json!(run.scene_file)),
        ("title", json!(scene.title())),
    ]);
    told.extend(scene.parts());
    told.extend(object([
        ("cells", json!(scene.cells())),
        ("classes", classes.into()),
        ("statuses", statuses.filter_map(count).collect()),
        ("worst_residual", json!(summary.worst_residual)),
    ]));
    let absences: Vec<Value> = absences(summary).into_iter().map(Value::from).collect();
    if !absences.is_empty() {
        told.extend(object([("absences", absences.into())]));
    }
    told.extend(scene.explained().0);
    if let Value::Object(effort) = json!(run.effort) {
        told.extend(effort);
    }
    told.into()
}

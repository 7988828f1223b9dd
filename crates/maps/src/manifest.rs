//! The JSON file beside a table: everything needed to know where the table came from and to make it again.

use std::ops::Not;

use serde::Serialize;
use serde_json::{Map, Value, json};
use vibrochain_floquet::Tolerance;
use vibrochain_lattice::{Parameter, PointPart};

use crate::cell::Status;
use crate::grid::{Grid, Refined};
use crate::scene::{Axis, Refine, Scene};
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

#[derive(Serialize)]
struct Sweep<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    x: Option<&'a Axis>,
    #[serde(skip_serializing_if = "Option::is_none")]
    y: Option<&'a Axis>,
    #[serde(skip_serializing_if = "<[Axis]>::is_empty")]
    axes: &'a [Axis],
    #[serde(skip_serializing_if = "Option::is_none")]
    refine: Option<Refine>,
}

#[derive(Serialize)]
struct Compute {
    families: Vec<String>,
    stability: bool,
    threshold: Tolerance,
    #[serde(skip_serializing_if = "Not::not")]
    collisions: bool,
    #[serde(skip_serializing_if = "Not::not")]
    impulse: bool,
}

/// Everything of a scene that decides what its table holds: `model`, `sweep`, `compute`.
pub fn scene_parts(scene: &Scene) -> Map<String, Value> {
    let is_fixed = |parameter: &Parameter| !scene.sweeps(*parameter);
    let fixed = Parameter::of(scene.base.layout.layers).iter().copied().filter(is_fixed).collect();
    let model = PointPart { point: &scene.base, parameters: [Vec::new(), fixed] };
    let (axes, task) = (&scene.axes, &scene.task);
    let rest = axes.get(2..).unwrap_or_default();
    let sweep = Sweep { x: axes.first(), y: axes.get(1), axes: rest, refine: scene.refine };
    let compute = Compute {
        families: task.family_names().collect(),
        stability: task.stability,
        threshold: task.tolerance,
        collisions: task.collisions,
        impulse: task.impulse,
    };
    let parts = [("model", json!(model)), ("sweep", json!(sweep)), ("compute", json!(compute))];
    parts.into_iter().map(|(name, part)| (name.to_owned(), part)).collect()
}

#[derive(Serialize)]
struct Manifest<'a> {
    schema: &'a str,
    program: &'a str,
    version: &'a str,
    revision: Option<&'a str>,
    scene: &'a str,
    title: Option<&'a str>,
    #[serde(flatten)]
    parts: Map<String, Value>,
    cells: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    refinement: Option<Refinement>,
    classes: Map<String, Value>,
    statuses: Map<String, Value>,
    worst_residual: f64,
    #[serde(flatten)]
    effort: Option<Effort>,
}

/// What a grid that is refined has become.
#[derive(Serialize)]
struct Refinement {
    grid: Vec<usize>,
    leaves: u64,
    may_miss: String,
}

/// The manifest as a JSON value.
pub fn manifest<S: Grid>(run: &Run<'_, S>) -> Value {
    let (scene, summary) = (run.scene, run.summary);
    let refinement = |Refined { grid, may_miss }| Refinement { grid, leaves: summary.computed, may_miss };
    let count = |(name, count): (&str, u64)| (count > 0).then(|| (name.to_owned(), count.into()));
    json!(Manifest {
        schema: SCHEMA,
        program: "mapgen",
        version: run.version,
        revision: run.revision,
        scene: run.scene_file,
        title: scene.title(),
        parts: scene.parts(),
        cells: scene.cells() * scene.cells_within(),
        refinement: scene.refined().map(refinement),
        classes: summary.by_name(S::class_name).into_iter().filter_map(count).collect(),
        statuses: Status::ALL.iter().map(|status| status.name()).zip(summary.statuses).filter_map(count).collect(),
        worst_residual: summary.worst_residual,
        effort: run.effort,
    })
}

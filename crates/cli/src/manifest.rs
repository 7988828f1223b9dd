//! The JSON file beside a table: everything needed to know where the table came from and to make it again.

use serde_json::{Map, Value, json};
use vibrochain_floquet::Tolerance;

use crate::cell::{Class, Status};
use crate::force;
use crate::parameter::Parameter;
use crate::scene::{Axis, Scene};
use crate::sweep::Summary;

/// The program's version.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The git revision it was built from, if known.
pub const REVISION: Option<&str> = option_env!("VIBROCHAIN_REVISION");

/// What a manifest tells of a run.
#[derive(Debug)]
pub struct Run<'a> {
    /// The scene file's name as given.
    pub scene_file: &'a str,
    /// The scene.
    pub scene: &'a Scene,
    /// Its result.
    pub summary: &'a Summary,
    /// Threads used.
    pub threads: usize,
    /// Wall time of the sweep, in seconds.
    pub wall_seconds: f64,
}

/// The manifest as a JSON value.
pub fn manifest(run: &Run<'_>) -> Value {
    let scene = run.scene;
    let axis = |axis: &Axis| json!({ "parameter": axis.parameter.name(), "from": axis.from, "to": axis.to, "points": axis.points });
    let mut model = Map::new();
    model.insert("sites".into(), scene.base.sites.into());
    for parameter in Parameter::ALL {
        match &scene.base.force {
            Some(force) if parameter == Parameter::Amplitude => {
                model.insert("force".into(), force::value(force));
            }
            _ if parameter != scene.x.parameter && parameter != scene.y.parameter => {
                model.insert(parameter.name().into(), scene.base.get(parameter).into());
            }
            _ => {}
        }
    }
    let threshold = match scene.task.tolerance {
        Tolerance::Rounding => Value::Null,
        Tolerance::Growth(growth) => growth.into(),
    };
    let counts = |names: &mut dyn Iterator<Item = (&'static str, u64)>| -> Value {
        names
            .filter(|(_, count)| *count > 0)
            .map(|(name, count)| (name.to_owned(), count.into()))
            .collect::<Map<_, _>>()
            .into()
    };
    let families: Vec<&str> = scene.task.families.iter().map(|family| family.name()).collect();
    json!({
        "program": "mapgen",
        "version": VERSION,
        "revision": REVISION,
        "scene": run.scene_file,
        "title": scene.title,
        "model": model,
        "sweep": { "x": axis(&scene.x), "y": axis(&scene.y) },
        "compute": { "families": families, "stability": scene.task.stability, "threshold": threshold },
        "cells": scene.cells(),
        "classes": counts(&mut Class::ALL.iter().map(|c| c.name()).zip(run.summary.classes)),
        "statuses": counts(&mut Status::ALL.iter().map(|s| s.name()).zip(run.summary.statuses)),
        "worst_residual": run.summary.worst_residual,
        "threads": run.threads,
        "wall_seconds": run.wall_seconds,
    })
}

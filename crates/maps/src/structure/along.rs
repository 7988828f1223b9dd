//! A structure as its numbers vary: its models, the events of a branch as JSON has them, and the curves of all of these.

use std::sync::Arc;

use serde_json::{Value, json};
use vibrochain_breather::{FreeNumbers, ModelFamily, Orbit};
use vibrochain_floquet::{BranchedOrbit, Evidence, Located};

use super::scene::StructureScene;
use super::setting::Setting;
use crate::manifest::object;

/// Where a number of a scene is, from which it varies.
///
/// # Errors
/// A sentence: the structure has no such number, or it changes nothing.
pub fn value(scene: &StructureScene, free: Setting) -> Result<f64, String> {
    scene.has_effect(free)?;
    let none = || format!("{free}: this structure has no such number, or it is not given: nothing to start from");
    scene.get(free).ok_or_else(none)
}

/// The models of a scene as these numbers vary.
#[must_use]
pub fn family(scene: &StructureScene, settings: &[Setting]) -> ModelFamily {
    let (scene, settings) = (scene.clone(), settings.to_vec());
    Arc::new(move |values: &[f64]| {
        let mut scene = scene.clone();
        settings.iter().zip(values).try_for_each(|(setting, value)| scene.set(*setting, *value))?;
        scene.model()
    })
}

/// An event as JSON has it.
#[must_use]
pub fn event(found: &Located) -> Value {
    let evidence = match found.evidence {
        Evidence::Multiplier(mu) => json!({ "multiplier": [mu.re, mu.im] }),
        Evidence::Touch(touch) => {
            json!({ "contact": touch.site, "barrier": touch.barrier.name(), "time": touch.time })
        }
        Evidence::Impact(impact) => json!({ "impact": impact }),
    };
    let orbit = |orbit: &Orbit| {
        let times = orbit.impacts().iter().map(|impact| json!(impact.time)).collect();
        let (period, psi) = (json!(orbit.period()), json!(orbit.psi()));
        object([("period", period), ("psi", psi), ("times", times), ("impulses", json!(orbit.impulses()))])
    };
    let branched = |of: &BranchedOrbit| {
        let mut told = orbit(&of.orbit);
        told.extend(object([("physical", json!(of.physical)), ("stability", json!(of.verdict))]));
        Value::from(told)
    };
    let branching = found.branching.as_ref().map(|of| {
        let side = if of.above { "above" } else { "below" };
        json!({ "value": of.value, "side": side, "orbits": of.orbits.iter().map(branched).collect::<Value>() })
    });
    let mut told = object([
        ("event", json!(found.event.name())),
        ("value", json!(found.value)),
        ("error", json!(found.error)),
        ("evidence", evidence),
        ("physical", json!(found.physical)),
    ]);
    told.extend(orbit(&found.orbit));
    told.extend(object([("sides", json!(found.sides)), ("branching", json!(branching))]));
    told.into()
}

/// These settings as numbers that vary, from where the scene has them.
///
/// # Errors
/// As [`value`].
pub fn numbers(scene: &StructureScene, settings: &[Setting]) -> Result<FreeNumbers, String> {
    Ok(FreeNumbers {
        models: family(scene, settings),
        start: settings.iter().map(|setting| value(scene, *setting)).collect::<Result<_, _>>()?,
        names: settings.iter().map(ToString::to_string).collect(),
        coupling: None,
    })
}

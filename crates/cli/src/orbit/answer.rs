//! The answer as JSON.

use serde_json::{Map, Value, json};
use vibrochain_breather::{Obstruction, OrbitList};
use vibrochain_floquet::Multipliers;
use vibrochain_lattice::{Layout, Model};

use crate::common::answer::joined;
use crate::common::schemas::ORBIT;
use crate::common::solution::Solution;
use crate::orbit::modes::OrbitModes;
use vibrochain_maps::manifest::object;
use vibrochain_maps::structure::answer::{MOST_LISTED, completeness, stability as verdict_of};

/// All breathers at a point.
pub(super) fn answer(model: &Model, solutions: &[Solution], found: &OrbitList) -> Map<String, Value> {
    let layout = model.chain().layout();
    let mut told = object([
        ("schema", json!(ORBIT)),
        ("parameters", json!(model)),
        ("solutions", solutions.iter().map(|one| solution(one, &layout)).collect()),
    ]);
    told.extend(completeness(found.completeness));
    // Where a branch from masses without coupling ended: the coupling, and why.
    let ended = found.ended.iter();
    let ended: Vec<Value> =
        ended.map(|one| json!({ one.coupling.name(): one.value, "message": one.told(&layout) })).collect();
    told.extend((!ended.is_empty()).then(|| ("ended".to_owned(), json!(ended))));
    told
}

/// A breather with all that is said about it.
fn solution(solution: &Solution, layout: &Layout) -> Value {
    let Solution { orbit, admissibility, condition, multipliers, modes, phases } = solution;
    // Masses by their sites, and by their layers where there are several.
    let placed = |mass: usize, mut told: Value| {
        let (site, layer) = layout.site_and_layer(mass);
        told["site"] = json!(site);
        joined(told, layer.map_or(Value::Null, |layer| json!({ "layer": layer })))
    };
    let obstruction = |obstruction: &Obstruction| {
        placed(obstruction.site(), joined(json!(obstruction), json!({ "message": obstruction.told(layout) })))
    };
    let errors = json!({ "impulse_error": condition.impulse_error(), "time_error": condition.time_error() });
    let mut told = json!({
        "condition": joined(json!(condition), errors),
        "physical": admissibility.is_physical(),
        "margin": admissibility.margin,
        "obstruction": admissibility.obstruction.as_ref().map(obstruction),
        "stability": multipliers.as_ref().ok().map(stability),
        "modes": modes.as_ref().map(|modes| &modes.modes),
        "internal_mode": modes.as_ref().and_then(OrbitModes::internal),
        "collision": modes.as_ref().and_then(|modes| modes.collision),
    });
    if let Err(error) = multipliers {
        told["stability_error"] = json!(error.to_string());
    }
    if let Some(phases) = phases {
        told["phases"] = phases.iter().map(|(mass, ahead)| placed(*mass, json!({ "ahead": ahead }))).collect();
    }
    joined(json!(orbit), told)
}

fn stability(all: &Multipliers) -> Value {
    let verdict = all.verdict;
    let listed = all.len() <= MOST_LISTED;
    let of_multipliers = json!({
        "method": verdict.method.name(),
        "multipliers": listed.then(|| all.sorted().map(|mu| [mu.re, mu.im]).collect::<Vec<_>>()),
    });
    let mut told = joined(verdict_of(&verdict).into(), of_multipliers);
    if !listed {
        told["multipliers_note"] = json!(format!("{} of them: --multipliers FILE writes them as CSV", all.len()));
    }
    told
}

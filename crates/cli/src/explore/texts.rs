//! What a view leads on to: its scene, and the lines that make it again.

use std::fmt::Write as _;

use serde_json::{Map, Value, json};

use super::line::{Line, VIEW};
use vibrochain_explore::{Refusal, View};
use vibrochain_lattice::Parameter;
use vibrochain_maps::numbers::Number;

/// A scene as the text of a file.
pub(super) fn toml_of(view: &View) -> Result<String, Refusal> {
    let mut value = view.value();
    // TOML has no null.
    for part in value.as_object_mut().into_iter().flat_map(Map::values_mut).filter_map(Value::as_object_mut) {
        part.retain(|_, value| !value.is_null());
    }
    toml::to_string(&value).map_err(|error| Refusal::new(500, error.to_string()))
}

/// Scene, command and Python of a map.
pub(super) fn of_map(view: &View) -> Result<Value, Refusal> {
    let scene = toml_of(view)?;
    let command = Line::of_view("sweep", scene.clone()).output("out", "map.csv").output("plot", "map.png").shown();
    let python = format!("import vibrochain as vc\n\ntable = vc.sweep(\"{VIEW}\")\ntable.plot()\n");
    Ok(json!({ "scene": scene, "command": command, "python": python }))
}

/// Python of solution `number`, from 0, of `which` at a point, whose values have been checked by the program's answer about it.
pub(super) fn of_point(model: &Map<String, Value>, which: &str, number: usize) -> String {
    let value = |key: &str| model.get(key);
    let text = |key: &str| match value(key) {
        Some(Value::Number(number)) if number.is_u64() => number.to_string(),
        Some(Value::Number(number)) => number.as_f64().map_or_else(String::new, |value| Number(value).to_string()),
        Some(Value::String(text)) => format!("{text:?}"),
        _ => "0".to_owned(),
    };
    let named = |keys: &[&str]| {
        keys.iter().filter(|key| value(key).is_some()).fold(String::new(), |mut out, key| {
            // Writing to a String cannot fail.
            let _ = write!(out, ", {key}={}", text(key));
            out
        })
    };
    // What has no default stands in its place, without a name.
    let named_of = |lattice: bool| {
        let own = |one: &Parameter| one.is_of_lattice() == lattice && one.row().default.is_some();
        named(&Parameter::told().filter(own).map(Parameter::name).collect::<Vec<_>>())
    };
    let lattice = [named(&["ends", "layers"]), named_of(true), named(&["layer_ends"])].concat();
    let driven = match value("force") {
        Some(Value::Array(harmonics)) => {
            let part = |one: &Value, key: &str| one.get(key).and_then(Value::as_f64).unwrap_or(0.0);
            let one = |one: &Value| {
                let number = one.get("harmonic").and_then(Value::as_u64).unwrap_or(1);
                format!("({number}, {}, {})", Number(part(one, "amplitude")), Number(part(one, "phase")))
            };
            let list: Vec<String> = harmonics.iter().map(one).collect();
            format!(", force=vc.Force([{}]){}", list.join(", "), named_of(false))
        }
        _ => named_of(false),
    };
    let [sites, gamma1, gamma2, omega, asymmetry] = ["sites", "gamma1", "gamma2", "omega", "asymmetry"].map(text);
    format!(
        "import numpy as np\nimport vibrochain as vc\n\n\
         chain = vc.Chain({sites}, {gamma1}, {gamma2}{lattice})\n\
         model = vc.Model(chain, {omega}, {asymmetry}{driven})\n\
         orbit = model.breathers({which:?}).orbits[{number}]\n\
         u = orbit.displacement(np.linspace(0, orbit.period, 200))\n\
         print(orbit.stability().spectral_radius)\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn python_has_every_part_of_a_model() {
        let plain = json!({ "sites": 21, "gamma1": 0.2, "gamma2": 0.1, "omega": 1.5, "asymmetry": 0.4, "amplitude": 0.1, "restitution": 0.9 });
        let text = of_point(plain.as_object().unwrap(), "double-sided", 1);
        for line in [
            "chain = vc.Chain(21, 0.2, 0.1)",
            "model = vc.Model(chain, 1.5, 0.4, amplitude=0.1, restitution=0.9)",
            "orbit = model.breathers(\"double-sided\").orbits[1]",
        ] {
            assert!(text.lines().any(|own| own == line), "{text}");
        }
        let layered = json!({
            "sites": 6, "layers": 2, "ends": "free", "gamma1": 0.2, "gamma2": 0.05, "gamma3": 0.1, "omega": 2, "asymmetry": 0.2,
            "force": [{ "harmonic": 1, "amplitude": 0.1 }, { "harmonic": 3, "amplitude": -0.03, "phase": 0.5 }], "restitution": 0.8,
        });
        let text = of_point(layered.as_object().unwrap(), "0:0+0:1+,0:0-0:1-", 0);
        for line in [
            "chain = vc.Chain(6, 0.2, 0.05, ends=\"free\", layers=2, gamma3=0.1)",
            "model = vc.Model(chain, 2, 0.2, force=vc.Force([(1, 0.1, 0), (3, -0.03, 0.5)]), restitution=0.8)",
        ] {
            assert!(text.lines().any(|own| own == line), "{text}");
        }
    }
}

//! What several tests ask of the program.

use std::path::Path;

use serde_json::Value;
use vibrochain_testkit::{TestDir, mapgen, written};

pub(crate) const SCENE: &str = r#"
[model]
sites = 11
gamma1 = 0.2
asymmetry = 0.4
[sweep]
x = { parameter = "omega", from = 0.4, to = 3.0, points = 40 }
y = { parameter = "gamma2", from = 0.0, to = 0.3, points = 30 }
[compute]
families = ["double-sided", "single-sided"]
stability = true
"#;

pub(crate) fn sweep(dir: &TestDir, scene: &Path, flags: &[&str]) -> assert_cmd::assert::Assert {
    mapgen(&["sweep"]).arg(scene).arg("--out").arg(dir.path("map.csv")).args(flags).assert()
}

/// The scene with the paper's force.
pub(crate) fn forced() -> String {
    SCENE.replace("sites = 11", "sites = 11\nforcing = { amplitude = 0.1, restitution = 0.9 }")
}

pub(crate) const POINT: [&str; 10] =
    ["--sites", "21", "--gamma1", ".2", "--gamma2", ".1", "--omega", "1.5", "--asymmetry", ".4"];

pub(crate) fn orbit_json(family: &str, flags: &[&str]) -> Value {
    let output = mapgen(&[]).args(["orbit", "--json", "--family", family]).args(flags).assert().success();
    written(&output.get_output().stdout)
}

pub(crate) const SMALL: [&str; 10] =
    ["--sites", "5", "--gamma1", ".2", "--gamma2", ".1", "--omega", ".4", "--asymmetry", ".4"];

/// Rows of a CSV file.
pub(crate) fn rows(path: &Path) -> Vec<csv::StringRecord> {
    csv::Reader::from_path(path).unwrap().records().map(Result::unwrap).collect()
}

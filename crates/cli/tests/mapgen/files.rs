//! Files and commands that cannot be.

use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use vibrochain_testkit::{TestDir, mapgen};

use crate::asked::{POINT, SCENE, sweep};

#[test]
fn studies_are_named_where_they_went() {
    for line in ["figures --out figures", "errata", "accuracy --quick", "validate --help"] {
        let words = contains("are studies").and(contains("cargo run --locked --release -p vibrochain-studies"));
        mapgen(&line.split(' ').collect::<Vec<_>>()).assert().code(2).stdout("").stderr(words);
    }
}

#[test]
fn no_file_may_have_two_uses() {
    let dir = TestDir::new();
    let scene = dir.scene(SCENE);
    let same = dir.path("map.csv");
    sweep(&dir, &scene, &["--png", same.to_str().unwrap()])
        .code(2)
        .stderr(contains("--out and --png are the same file"));
    let manifest = dir.path("map.manifest.json");
    sweep(&dir, &scene, &["--svg", manifest.to_str().unwrap()])
        .code(2)
        .stderr(contains("the manifest of --out and --svg"));
    let onto = mapgen(&[]).arg("sweep").arg(&scene).arg("--out").arg(&scene).assert();
    onto.code(2).stderr(contains("the scene and --out are the same file"));
    assert_eq!(dir.names("."), ["scene.toml"]);
    let table = dir.path("table.csv");
    let mut command = mapgen(&[]);
    command
        .args(["simulate", "--family", "double-sided"])
        .args(POINT)
        .arg("--impacts")
        .arg(&table)
        .arg("--trajectory")
        .arg(&table);
    command.assert().code(2).stderr(contains("--impacts and --trajectory are the same file"));
}

#[test]
fn nothing_to_plot_does_not_hide_the_answer() {
    let dir = TestDir::new();
    let plot = dir.path("orbit.png");
    let run =
        mapgen(&[]).args(["orbit", "--family", "period-doubled", "--json", "--plot"]).arg(&plot).args(POINT).assert();
    run.success().stdout(contains("\"solutions\": []")).stderr(contains("nothing to plot"));
    assert!(dir.names(".").is_empty());
}

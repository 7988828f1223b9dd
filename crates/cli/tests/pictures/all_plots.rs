//! `mapgen orbit --all-plots`: its files, and what is on them.

use std::fs;
use std::path::Path;

use tempfile::TempDir;
use vibrochain_testkit::mapgen;

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

const SQUARE: &str = "1:0.1:0,3:-0.03:0.5,5:0.01:0";
const POINT: [&str; 10] = ["--sites", "21", "--gamma1", ".2", "--gamma2", ".1", "--omega", "1.5", "--asymmetry", ".4"];

#[test]
fn all_plots_are_seven_of_each_solution() {
    let dir = TempDir::new().unwrap();
    let seven = ["decay", "eigenvector", "multipliers", "phase", "profile", "spacetime", "trace"];
    let expected = |count: usize, ending: &str| -> Vec<String> {
        (1..=count).flat_map(|k| seven.map(|name| format!("solution-{k}-{name}.{ending}"))).collect()
    };
    for (folder, extra, count, ending) in [
        ("forced", &["--family", "double-sided", "--amplitude", ".1", "--restitution", ".9", "--svg"][..], 2, "svg"),
        ("conservative", &["--family", "double-sided"][..], 1, "png"),
        ("square", &["--family", "single-sided", "--force", SQUARE, "--restitution", "1", "--svg"][..], 2, "svg"),
    ] {
        let folder = dir.path().join(folder);
        mapgen(&["orbit"]).args(POINT).args(extra).arg("--all-plots").arg(&folder).assert().success();
        assert_eq!(names(&folder), expected(count, ending));
    }
    let svg = |name: &str| fs::read_to_string(dir.path().join(format!("forced/solution-1-{name}.svg"))).unwrap();
    assert!(svg("multipliers").contains("unit circle") && svg("multipliers").contains("1.001629024"));
    // γ₂(λ + 1/λ) = γ₁ + 2γ₂ for the static part: λ = 2 − √3.
    assert!(svg("decay").contains("factor 0.267949"), "{}", svg("decay"));
    assert!(svg("eigenvector").contains("imaginary part") && svg("phase").contains("impact"));
    assert!(svg("eigenvector").contains("velocity δu\u{307}ₙ"));
    // All that is fixed is on all of them.
    for name in seven {
        for fixed in ["N = 20", "γ₁ = 0.2", "γ₂ = 0.1", "ω = 1.5", "a = 0.4", "A = 0.1", "e = 0.9"] {
            assert!(svg(name).contains(fixed), "{name}: {fixed}");
        }
        let square = fs::read_to_string(dir.path().join(format!("square/solution-1-{name}.svg"))).unwrap();
        assert!(square.contains(&format!("force {SQUARE}")) && square.contains("e = 1"), "{name}");
    }
    // A real multiplier has no imaginary part.
    let real = dir.path().join("real");
    let point =
        "orbit --family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega .8 --asymmetry .4 --svg --all-plots";
    mapgen(&point.split(' ').collect::<Vec<_>>()).arg(&real).assert().success();
    let text = fs::read_to_string(real.join("solution-1-multipliers.svg")).unwrap();
    let texts = vibrochain_testkit::svg::texts(&text);
    let caption = texts.iter().find(|(_, line)| line.contains("leading μ = ")).unwrap();
    assert_eq!(caption.1, "unstable, through +1; |μ| = 2.797574412, leading μ = 2.797574");

    // Layers stand upon each other; the decay is that of one site on a ring.
    let layered = dir.path().join("layered");
    let point = "orbit --word 0:0+3:1+,0:0-3:1- --sites 7 --ends free --gamma1 .2 --gamma2 .05 --layers 2 --gamma3 .03 --omega 1.5 \
                 --asymmetry .2 --svg --all-plots";
    mapgen(&point.split(' ').filter(|part| !part.is_empty()).collect::<Vec<_>>()).arg(&layered).assert().success();
    let drawn = seven.iter().filter(|name| **name != "decay").map(|name| format!("solution-1-{name}.svg"));
    assert_eq!(names(&layered), drawn.collect::<Vec<_>>());
    let text = |name: &str| fs::read_to_string(layered.join(format!("solution-1-{name}.svg"))).unwrap();
    assert!(text("spacetime").contains("site, layer upon layer") && text("spacetime").contains("7 masses × 2 layers"));
    assert!(text("profile").contains("layer 1") && text("eigenvector").contains("site, layer after layer"));

    // None: an answer, an empty folder. A file in its place: a wrong request.
    let none = dir.path().join("none");
    mapgen(&["orbit", "--family", "period-doubled"]).args(POINT).arg("--all-plots").arg(&none).assert().success();
    assert!(names(&none).is_empty());
    let file = dir.path().join("file");
    fs::write(&file, "").unwrap();
    mapgen(&["orbit", "--family", "double-sided"]).args(POINT).arg("--all-plots").arg(&file).assert().code(2);
    mapgen(&["orbit", "--family", "double-sided", "--svg"]).args(POINT).assert().code(2);
}

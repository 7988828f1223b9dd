//! Answers that must not change unless on purpose: the paper's maps, orbits at checked and at random points, a simulated run.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::fs;
use std::path::Path;

use serde_json::Value;
use vibrochain_breather::Family;
use vibrochain_lattice::{Chain, Model};
use vibrochain_testkit::{Net, Random, TestDir, reference, written};

const FAMILIES: [Family; 3] = [Family::DoubleSided, Family::SingleSided, Family::PeriodDoubled];

fn kept() -> Net {
    Net::open(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/net.json"))
}

/// The command that lists the orbits of a model.
fn command(model: &Model, family: Family) -> String {
    let chain = model.chain();
    let mut line = format!(
        "orbit --json --family {} --sites {} --gamma1 {:?} --gamma2 {:?} --omega {:?} --asymmetry {:?}",
        family.name(),
        chain.sites(),
        chain.gamma1(),
        chain.gamma2(),
        model.omega(),
        model.asymmetry()
    );
    if !model.is_conservative() {
        line += &format!(" --amplitude {:?} --restitution {:?}", model.amplitude(), model.restitution());
    }
    line
}

/// What does not hang on rounding: no errors, nor the number of the schema; of the multipliers, whose order does, their power sums.
fn lasting(value: &mut Value) {
    match value {
        Value::Array(all) => all.iter_mut().for_each(lasting),
        Value::Object(all) => {
            // The others stay in their order.
            all.shift_remove("schema");
            for name in ["residual", "resolution", "impulse_error", "time_error", "error"] {
                all.remove(name);
            }
            if let Some(multipliers) = all.get_mut("multipliers") {
                *multipliers = power_sums(multipliers).into();
            }
            all.values_mut().for_each(lasting);
        }
        _ => {}
    }
}

/// Σ Re μᵏ for k = 1 … 4.
fn power_sums(multipliers: &Value) -> Vec<f64> {
    let all = multipliers.as_array().map_or(&[][..], Vec::as_slice);
    let mut sums = vec![0.0; 4];
    for pair in all {
        let [re, im] = [0, 1].map(|i| pair[i].as_f64().unwrap());
        let (mut x, mut y) = (re, im);
        for sum in &mut sums {
            *sum += x;
            (x, y) = (x * re - y * im, x * im + y * re);
        }
    }
    sums
}

fn random_model(random: &mut Random) -> Model {
    let chain = Chain::new(1 + random.below(30), random.log(0.05, 1.0), random.log(1e-3, 0.4)).unwrap();
    let (omega, asymmetry) = (random.between(0.5, 3.0), random.between(-0.3, 0.9).max(0.0));
    if random.chance(0.5) {
        let restitution = if random.chance(0.2) { 1.0 } else { random.between(0.2, 0.99) };
        let point = chain.point().omega(omega).asymmetry(asymmetry);
        point.amplitude(random.log(0.05, 2.0)).restitution(restitution).model().unwrap()
    } else {
        Model::conservative(chain, omega, asymmetry).unwrap()
    }
}

#[test]
fn answers_are_those_of_before() {
    let mut net = kept();
    let dir = TestDir::new();

    for name in ["conservative-n5", "conservative-n10", "conservative-n20", "conservative-n40", "forced-n20"] {
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenes/{name}.toml"));
        fs::copy(scene, dir.path("scene.toml")).unwrap();
        dir.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
        net.take(&format!("map {name}"), &fs::read_to_string(dir.path("map.csv")).unwrap());
    }

    let mut solutions = 0;
    let mut list = |name: &str, model: &Model, family: Family| {
        let ran = dir.run(&command(model, family));
        // A point without an answer has words.
        let text = if ran.code == Some(0) {
            let mut answer = written(&ran.out);
            solutions += answer["solutions"].as_array().unwrap().len();
            lasting(&mut answer);
            answer.to_string()
        } else {
            format!("{:?} {}", ran.code, ran.err)
        };
        net.take(name, &text);
    };
    for case in reference() {
        list(&format!("orbit {}", case.name), &case.model, case.family);
    }
    let mut random = Random(14);
    for i in 0..200 {
        let model = random_model(&mut random);
        let families = if model.is_conservative() { 2 } else { 3 };
        list(&format!("orbit {i:03}"), &model, FAMILIES[i % families]);
    }
    assert!(solutions > 200, "{solutions}");

    dir.run(
        "simulate --family double-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --amplitude .1 \
         --restitution .9 --periods 20 --impacts run.csv",
    )
    .with(0, &[]);
    net.take("simulated run", &fs::read_to_string(dir.path("run.csv")).unwrap());

    net.finish();
}

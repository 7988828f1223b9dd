//! What a map of a structure says of its empty points, and of modes that are left out.

use std::fs;

use serde_json::Value;
use vibrochain_testkit::{TestDir, written};

use super::commands::number;

/// A heavy mass with a light tip at the stop, which rings after each impact.
const TIP: &str = "omega = 1\nword = \"0+\"\n[structure]\nmasses = [1, 0.02]\nstiffness = [[9, -8], [-8, 8]]\n\
    damping = [[0.05, 0], [0, 0.001]]\nMODES\n[[contact]]\nat = 1\nupper = 0.3\nrestitution = 0.7\n\
    [[contact]]\nat = 0\nlower = -0.25\n[force]\nload = [0.2, 0]\n\
    [sweep]\nx = { parameter = \"omega\", from = 0.3, to = 3, points = 40 }\n\
    y = { parameter = \"load\", from = 0.2, to = 4, points = 6 }\n[compute]\nfamilies = [\"0+,0+\", \"0+\"]\n";

/// The summary and the manifest count what the rows say, from chunks as from one run.
#[test]
fn summaries_tell_which_contact_is_in_the_way_after_which_impact() {
    let dir = TestDir::with_scene(&TIP.replace("MODES\n", ""));
    let told = dir.run("sweep scene.toml --out map.csv").with(0, &["none in", "contact 0 at impact 1, 0."]).err;
    let manifest = dir.json("map.manifest.json");
    let text = String::from_utf8(dir.read("map.csv")).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    // The word may hold a comma: counted from the end.
    let place = |name: &str| names.len() - names.iter().position(|known| *known == name).unwrap();
    let [absence, contact, impact, after] =
        ["absence", "obstruction_contact", "obstruction_impact", "obstruction_after"].map(place);
    let mut rows: Vec<(String, u64, u64, f64)> = Vec::new();
    for line in lines {
        let fields: Vec<&str> = line.split(',').collect();
        let field = |place: usize| fields[fields.len() - place];
        if !field(contact).is_empty() {
            let after = field(after).parse().unwrap();
            rows.push((field(absence).into(), field(contact).parse().unwrap(), field(impact).parse().unwrap(), after));
        }
    }
    let told_of = |manifest: &Value| -> Vec<Value> { manifest["absences"].as_array().unwrap().clone() };
    let absences = told_of(&manifest);
    let all: Vec<&Value> = absences.iter().filter(|one| one["contact"] != Value::Null).collect();
    let mut counted = 0;
    for one in &all {
        let own = rows.iter().filter(|(absence, contact, impact, _)| {
            (one["reason"] == **absence, one["contact"] == *contact, one["impact"] == *impact) == (true, true, true)
        });
        let after: Vec<f64> = own.map(|row| row.3).collect();
        assert_eq!(after.len() as u64, one["cells"].as_u64().unwrap(), "{one}");
        let range = [after.iter().copied().fold(1.0, f64::min), after.iter().copied().fold(0.0, f64::max)];
        assert_eq!([number(&one["from"]), number(&one["to"])], range, "{one}");
        counted += after.len();
    }
    assert!(counted == rows.len() && counted > 80 && all.len() >= 2, "{counted} {} {}", rows.len(), all.len());
    let none: u64 = absences.iter().map(|one| one["cells"].as_u64().unwrap()).sum();
    assert_eq!(Some(none), manifest["classes"]["none"].as_u64());
    let first = format!(": {}\n", all[0]["cells"]);
    assert!(told.contains(&first) && manifest["contacts"] == Value::Null, "{told}");
    // The same from chunks of two machines.
    for shard in [0, 1] {
        dir.run(&format!("sweep scene.toml --out chunks --shard {shard}/2")).with(0, &[]);
    }
    dir.run("merge chunks --out merged.csv").with(0, &["contact 0 at impact 1, 0."]);
    let merged = dir.json("merged.manifest.json");
    assert_eq!(told_of(&merged), absences);
}

/// With modes left out each contact's masses are those that `orbit` tells, which are w/M of the modes by hand.
#[test]
fn a_map_tells_the_masses_that_contacts_feel() {
    let dir = TestDir::with_scene(&TIP.replace("MODES", "modes = 1"));
    let ran = dir.run("sweep scene.toml --out map.csv").with(0, &["contact 0 feels a mass of", "contact 1 feels"]);
    let manifest = dir.json("map.manifest.json");
    let orbit = written(&dir.run("orbit --scene scene.toml --json").out);
    let masses = manifest["contacts"].as_array().unwrap();
    assert_eq!(masses.len(), 2);
    for (told, contact) in masses.iter().zip(orbit["structure"]["contacts"].as_array().unwrap()) {
        for key in ["effective_mass", "effective_mass_of_all_modes"] {
            assert_eq!(told[key], contact[key]);
        }
        assert!(ran.err.contains(&format!("feels a mass of {}", told["effective_mass"])), "{}", ran.err);
    }
    // Of the slower mode (1, x): (9 − 8x) = λ, (8x − 8) = 0.02λx.
    let (mut low, mut high) = (1.0, 1.1);
    for _ in 0..80 {
        let x: f64 = 0.5 * (low + high);
        *(if 8.0 * x - 8.0 > 0.02 * (9.0 - 8.0 * x) * x { &mut high } else { &mut low }) = x;
    }
    let whole = 1.0 + 0.02 * low * low;
    assert!((number(&masses[0]["effective_mass"]) - whole / (low * low)).abs() < 1e-12);
    assert!(
        (number(&masses[1]["effective_mass"]) - whole).abs() < 1e-12
            && number(&masses[0]["effective_mass_of_all_modes"]) == 0.02
    );
    // The manifest is a scene.
    fs::copy(dir.path("map.manifest.json"), dir.path("other.json")).unwrap();
    dir.run("sweep other.json --out again.csv").with(0, &["contact 0 feels a mass of"]);
    assert_eq!(dir.read("again.csv"), dir.read("map.csv"));
}

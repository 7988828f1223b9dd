//! Multipliers of orbits as CSV.

use serde_json::Value;
use vibrochain_testkit::{mapgen, written};

fn orbit(sites: &str, file: &std::path::Path, more: &[&str]) -> Value {
    let point = ["--gamma1", ".2", "--gamma2", ".1", "--omega", ".8", "--asymmetry", ".4", "--family", "single-sided"];
    let output = mapgen(&["orbit", "--json", "--sites", sites, "--multipliers"])
        .arg(file)
        .args(point)
        .args(more)
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    written(&output.stdout)
}

fn rows(file: &std::path::Path) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(file).unwrap();
    let header = reader.headers().unwrap().iter().collect::<Vec<_>>().join(",");
    assert_eq!(header, "solution,real,imaginary,modulus,argument,mode");
    reader.records().map(|row| row.unwrap().iter().map(str::to_owned).collect()).collect()
}

#[test]
fn small_rings_are_listed_in_both_places() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("multipliers.csv");
    let value = orbit("21", &file, &[]);
    let listed = value["solutions"][0]["stability"]["multipliers"].as_array().unwrap();
    let rows = rows(&file);
    assert_eq!((rows.len(), listed.len()), (42, 42));
    for (row, pair) in rows.iter().zip(listed) {
        let [re, im] = [1, 2].map(|i| row[i].parse::<f64>().unwrap());
        // Reading JSON may round once more.
        assert!((pair[0].as_f64().unwrap() - re).abs() + (pair[1].as_f64().unwrap() - im).abs() < 1e-14);
        assert!((row[3].parse::<f64>().unwrap() - re.hypot(im)).abs() < 1e-14);
        assert!((row[4].parse::<f64>().unwrap() - im.atan2(re)).abs() < 1e-14);
    }
    // The leading pair is off the circle, the trivial pair belongs to no mode, each odd mode is named twice.
    assert!(rows[0][0] == "1" && rows[0][3].parse::<f64>().unwrap() > 2.79);
    assert_eq!(rows.iter().filter(|row| row[5].is_empty()).count(), 2);
    assert!((1..=10).all(|mode| rows.iter().filter(|row| row[5] == mode.to_string()).count() >= 2));
}

#[test]
fn large_rings_are_listed_in_the_file_alone() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("multipliers.csv");
    let value = orbit("3001", &file, &[]);
    let stability = &value["solutions"][0]["stability"];
    assert_eq!(stability["multipliers"], Value::Null);
    assert!(stability["multipliers_note"].as_str().unwrap().contains("--multipliers"));
    assert_eq!(rows(&file).len(), 6002);
}

#[test]
fn forced_multipliers_have_a_mode_each() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("multipliers.csv");
    let value = orbit("21", &file, &["--amplitude", ".1", "--restitution", ".9"]);
    let rows = rows(&file);
    assert_eq!(rows.len(), 42 * value["solutions"].as_array().unwrap().len());
    assert!(rows.iter().all(|row| !row[5].is_empty()));
}

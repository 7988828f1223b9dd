//! `studies accuracy --quick`: its files, and errors where they must fall. Times are never looked at.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use predicates::str::contains;

/// One row of a suite's table.
struct Row {
    case: String,
    method: String,
    setting: String,
    error: f64,
    note: String,
}

fn accuracy(folder: &Path, flags: &[&str]) -> assert_cmd::assert::Assert {
    vibrochain_testkit::studies(&[]).args(["accuracy", "--quick", "--out"]).arg(folder).args(flags).assert()
}

/// Runs one suite, checks what all suites share and returns its rows.
fn suite(name: &str) -> Vec<Row> {
    let folder = tempfile::tempdir().unwrap();
    accuracy(folder.path(), &["--suite", name]).success().stdout("").stderr("");
    let files_folder = folder.path().join("accuracy");
    let mut files: Vec<_> =
        fs::read_dir(&files_folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    files.sort();
    let mut expected = vec![format!("{name}.csv")];
    expected.extend(["png", "svg"].map(|ending| format!("{name}.{ending}")));
    assert!(fs::read(files_folder.join(format!("{name}.png"))).unwrap().starts_with(b"\x89PNG"));
    let svg = fs::read_to_string(files_folder.join(format!("{name}.svg"))).unwrap();
    assert!(svg.contains("time of one evaluation, seconds") && svg.contains("10⁻"));
    assert_eq!(files, expected);

    let mut table = csv::Reader::from_path(files_folder.join(format!("{name}.csv"))).unwrap();
    assert_eq!(table.headers().unwrap(), vec!["case", "method", "setting", "seconds", "error", "note"]);
    let rows: Vec<_> = table.records().map(Result::unwrap).collect();
    assert!(rows.iter().all(|row| row[3].parse::<f64>().unwrap() > 0.0));

    let text = fs::read_to_string(folder.path().join("accuracy.md")).unwrap();
    for word in ["# Error against run time", env!("CARGO_PKG_VERSION"), "one thread", "--quick"] {
        assert!(text.contains(word), "{word}");
    }
    assert!(text.contains(&format!("](accuracy/{name}.png)")));
    assert_eq!(text.lines().filter(|line| line.starts_with("## ")).count(), 1);
    // Every method is in the document.
    let lines = text.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| method")).count();
    let methods: BTreeSet<_> = rows.iter().map(|row| &row[1]).collect();
    assert_eq!(lines, methods.len());

    let row = |row: &csv::StringRecord| Row {
        case: row[0].to_owned(),
        method: row[1].to_owned(),
        setting: row[2].to_owned(),
        error: row[4].parse().unwrap(),
        note: row[5].to_owned(),
    };
    rows.iter().map(row).collect()
}

/// Errors of a method, in the order of its settings; at least one.
fn errors(rows: &[Row], case: &str, method: &str) -> Vec<f64> {
    let chosen = rows.iter().filter(|row| row.case.contains(case) && row.method == method);
    let errors: Vec<f64> = chosen.map(|row| row.error).collect();
    assert!(!errors.is_empty(), "{case} {method}");
    errors
}

fn falls(errors: &[f64]) -> bool {
    errors.windows(2).all(|pair| pair[1] < pair[0])
}

#[test]
fn the_series_falls_behind_like_its_tail_and_the_closed_form_has_all_digits() {
    let rows = suite("kernels");
    let at = |terms: &str| {
        let found =
            rows.iter().find(|row| row.case == "χ₂, defaults" && row.method == "series" && row.setting == terms);
        found.unwrap().error
    };
    // The paper's 2000 harmonics: about 2e-4, and 1/J.
    assert!((at("J = 2000") - 2.1e-4).abs() < 1e-5, "{}", at("J = 2000"));
    assert!((at("J = 100") / at("J = 2000") - 20.0).abs() < 0.5);
    for case in ["defaults", "stiff coupling", "low frequency"] {
        for kernel in ["χ₁", "χ₂", "χ₃"] {
            let case = format!("{kernel}, {case}");
            assert!(errors(&rows, &case, "closed form")[0] < 1e-12, "{case}");
            for method in ["series", "series, leading tail summed", "harmonics, four tails summed"] {
                assert!(falls(&errors(&rows, &case, method)), "{case} {method}");
            }
        }
    }
    let four = errors(&rows, "χ₂, defaults", "harmonics, four tails summed");
    assert!(four[0] < 1e-12, "{four:?}");
}

#[test]
fn the_series_error_goes_into_the_orbits_and_the_program_has_none() {
    let rows = suite("orbits");
    for case in ["conservative double-sided", "conservative single-sided", "forced double-sided"] {
        let series = errors(&rows, case, "series");
        assert!(falls(&series) && series[series.len() - 1] > 1e-3, "{case} {series:?}");
        assert!(errors(&rows, case, "closed-form kernels")[0] < 1e-13, "{case}");
        assert!(errors(&rows, case, "enclosures")[0] < 1e-14, "{case}");
    }
    assert!(
        rows.iter().all(|row| row.note == if row.case.starts_with("forced") { "2 solutions" } else { "1 solution" })
    );
}

#[test]
fn all_ways_find_the_leading_multiplier_and_only_two_the_trivial_pair() {
    let rows = suite("spectrum");
    for row in &rows {
        assert!(row.error < 1e-12, "{} {} {}", row.case, row.method, row.error);
        let structured = row.method == "reversible block" || row.method == "secular function";
        let conservative = row.case.starts_with("conservative");
        assert_eq!(row.note == "trivial pair taken out beforehand", structured && conservative);
        assert_eq!(row.note.is_empty(), row.case.starts_with("forced"));
    }
    assert_eq!(errors(&rows, "conservative", "reversible block").len(), 2);
    assert_eq!(errors(&rows, "", "general exponential").len(), 3);
    assert_eq!(errors(&rows, "", "secular function").len(), 3);
}

#[test]
fn exact_flight_stays_at_rounding_and_the_others_converge() {
    let rows = suite("simulation");
    assert!(errors(&rows, "periods", "exact flight")[0] < 1e-12);
    let (dop, rk4) = (errors(&rows, "periods", "DOP853"), errors(&rows, "periods", "Runge–Kutta 4"));
    assert!(dop.iter().all(|error| *error < 1e-6), "{dop:?}");
    assert!(falls(&rk4) && rk4[rk4.len() - 1] < 1e-5, "{rk4:?}");
    let stepping = errors(&rows, "periods", "time stepping");
    assert!(stepping.iter().all(|error| *error > 1e-4), "{stepping:?}");
    assert!(rows.iter().all(|row| row.method == "time stepping" || row.note.is_empty()));
}

#[test]
fn a_short_series_gets_cells_wrong_that_the_closed_form_gets_right() {
    let rows = suite("map");
    let wrong = |method: &str| errors(&rows, "stability", method);
    let series = wrong("series and general exponential");
    assert!(falls(&series) && series[0] > 0.01, "{series:?}");
    assert!(wrong("closed form and general exponential")[0] < 0.05);
    assert_eq!(wrong("closed form"), [0.0]);
    let existence: Vec<_> = rows.iter().filter(|row| row.case == "existence" && row.setting.starts_with('J')).collect();
    assert!(existence[0].error > existence[1].error && existence[0].note.ends_with("of 150 cells"));
}

#[test]
fn shooting_buys_digits_with_steps_and_the_closed_form_has_them() {
    let rows = suite("shooting");
    for case in ["one stop", "two stops"] {
        let shooting = errors(&rows, case, "shooting");
        assert!(falls(&shooting) && shooting[0] > 1e-9 && shooting[1] > 1e-14, "{case} {shooting:?}");
        for method in ["closed form", "closed form, all orbits"] {
            let row = rows.iter().find(|row| row.case == case && row.method == method).unwrap();
            let bound: f64 = row.note.rsplit_once("bound ").unwrap().1.parse().unwrap();
            // Both are written in four digits.
            assert!(row.error <= 1.001 * bound && bound < 1e-11, "{case} {method}: {:e} {bound:e}", row.error);
        }
        // What is right is rounded to the nearest numbers.
        let digits = errors(&rows, case, "many digits");
        assert!(digits.iter().all(|error| *error <= 0.5 * f64::EPSILON), "{case} {digits:?}");
    }
}

#[test]
fn extremes_keep_their_promises_and_say_what_they_refuse() {
    let folder = tempfile::tempdir().unwrap();
    accuracy(folder.path(), &["--suite", "extremes"]).success();
    let mut table = csv::Reader::from_path(folder.path().join("accuracy/extremes.csv")).unwrap();
    let rows: Vec<_> = table.records().map(Result::unwrap).collect();
    assert!(rows.len() > 300 && rows.iter().all(|row| &row[6] == "yes"));
    // Next to a resonance digits go, on it there is no answer.
    let kernels = |case: &str| rows.iter().find(|row| &row[1] == case && &row[2] == "kernels").unwrap();
    assert!(kernels("2ω at 1e-11 from mode 5")[3].parse::<f64>().unwrap() > 1e-6);
    assert!(kernels("2ω at 1e-15 from mode 5")[5].starts_with("resonance: harmonic 2"));
    let text = fs::read_to_string(folder.path().join("accuracy.md")).unwrap();
    assert!(text.contains("| grazing | ") && text.contains("**random points**"));
}

#[test]
fn a_run_of_all_suites_makes_one_document_in_a_new_folder() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/accuracy");
    accuracy(&out, &["--suite", "simulation", "--suite", "spectrum"]).success();
    let text = fs::read_to_string(out.join("accuracy.md")).unwrap();
    // The document's order, whatever that of the flags.
    let titles: Vec<_> = text.lines().filter_map(|line| line.strip_prefix("## ")).collect();
    assert_eq!(titles, ["Floquet multipliers", "Simulation of a breather"]);
}

#[test]
fn a_wrong_request_is_told_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("taken");
    fs::write(&file, "mine").unwrap();
    accuracy(&file, &[]).code(2).stderr(contains("is a file"));
    accuracy(folder.path(), &["--suite", "nonsense"]).code(2);
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
    fs::create_dir_all(folder.path().join("accuracy/map.csv")).unwrap();
    accuracy(folder.path(), &["--suite", "map"]).code(2).stderr(contains("map.csv"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

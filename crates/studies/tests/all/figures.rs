//! `studies figures` and `studies errata`: their files, and the numbers in them.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use predicates::str::contains;
use serde_json::Value;
use tempfile::TempDir;
use vibrochain_cli::common::console::{Console, ctrl_c};
use vibrochain_lattice::Stop;
use vibrochain_studies::program;
use vibrochain_testkit::studies;

fn figures(folder: &Path, flags: &[&str]) -> assert_cmd::assert::Assert {
    studies(&["figures", "--out"]).arg(folder).args(flags).assert()
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Rows of a table, by column.
fn table(path: &Path) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_path(path).unwrap().deserialize().map(Result::unwrap).collect()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} of {row:?}"))
}

/// The case of the table of checked numbers of that name.
fn reference(name: &str) -> Value {
    let case = vibrochain_testkit::reference().into_iter().find(|case| case.name.starts_with(name));
    case.unwrap().values
}

#[test]
fn every_line_figure_writes_its_three_files_and_nothing_else() {
    let dir = TempDir::new().unwrap();
    let lines = "1,2,3,4,5,6,7,8";
    figures(dir.path(), &["--only", lines]).success().stdout("").stderr(contains("figures 1, 2, 3, 4, 5, 6, 7, 8 "));
    let expected: Vec<_> =
        (1..=8).flat_map(|id| ["csv", "png", "svg"].map(|ending| format!("figure-{id}.{ending}"))).collect();
    assert_eq!(names(dir.path()), expected);
    for id in 1..=8 {
        assert!(fs::read(dir.path().join(format!("figure-{id}.png"))).unwrap().starts_with(b"\x89PNG"));
        let svg = fs::read_to_string(dir.path().join(format!("figure-{id}.svg"))).unwrap();
        assert!(svg.contains("<svg") && (svg.contains("displacement uₙ") || svg.contains("impacting mass u₀")));
        // What its curves have in common is in the title.
        let fixed = if id <= 4 { ["γ₁ = 0.2", "γ₂ = 0.1", "ω = "] } else { ["γ₁ = 0.2", "A = 0", "e = 0.9"] };
        assert!(fixed.iter().all(|part| svg.contains(part)), "figure {id}");
    }
    // Figure 4: the reference's single-sided orbit is on its barrier at the impact, and its impulse is its velocity's jump.
    let profile = table(&dir.path().join("figure-4.csv"));
    assert_eq!(profile.len(), 2 * 21);
    let home: Vec<_> = profile.iter().filter(|row| row["offset"] == "0").collect();
    assert!((number(home[0], "displacement") - (0.4 - 1.0)).abs() < 1e-14 && number(home[1], "displacement") < 1.4);
    // Figure 2: the masses mirror each other about the breather.
    for row in table(&dir.path().join("figure-2.csv")) {
        let twin = -number(&row, "offset");
        let other = table(&dir.path().join("figure-2.csv"))
            .into_iter()
            .find(|r| r["curve"] == row["curve"] && r["instant"] == row["instant"] && number(r, "offset") == twin);
        assert!((number(&other.unwrap(), "displacement") - number(&row, "displacement")).abs() < 1e-15);
    }
}

#[test]
fn the_farthest_mass_of_a_long_ring_is_no_rounding() {
    let dir = TempDir::new().unwrap();
    let document = dir.path().join("figures.md");
    figures(&dir.path().join("out"), &["--only", "1", "--document", document.to_str().unwrap()]).success();
    let document = fs::read_to_string(document).unwrap();
    let mut seen = 0;
    for (curve, sites) in [("N = 10", 11), ("N = 100", 101)] {
        let row = document.lines().find(|line| line.starts_with(&format!("| {curve} |"))).unwrap();
        let fields: Vec<_> = row.split('|').map(str::trim).collect();
        let (impulses, told): (Vec<f64>, f64) =
            (fields[4].split(", ").map(|p| p.parse().unwrap()).collect(), fields[8].parse().unwrap());
        // The same equations once more: a chain under the harmonics of its impulses, each by elimination along the ring.
        let (omega, n) = (1.5_f64, sites / 2);
        let harmonic = |j: u32| {
            let stiffness = 0.4 - (f64::from(j) * omega).powi(2);
            // Static and above the band: u_n ∝ λ^n + λ^(M−n), γ₂(λ + 1/λ) = stiffness.
            let half = 0.5 * stiffness / 0.1;
            let lambda = half - half.signum() * (half * half - 1.0).sqrt();
            let power = |n: i32| lambda.powi(n);
            let own = stiffness * (1.0 + power(sites)) - 0.2 * (power(1) + power(sites - 1));
            (power(n) + power(sites - n)) / own
        };
        // The second impact is half a period after the first.
        let excited = |j: u32| impulses[0] + if j.is_multiple_of(2) { impulses[1] } else { -impulses[1] };
        let sum: f64 = (1..200).map(|j| 2.0 * excited(j) * harmonic(j)).sum::<f64>() + excited(0) * harmonic(0);
        let expected = sum * omega / std::f64::consts::TAU;
        assert!((told / expected - 1.0).abs() < 1e-3, "{curve}: {told:e} {expected:e}");
        seen += usize::from(expected.abs() < 1e-28);
    }
    assert_eq!(seen, 1);
}

#[test]
fn traces_meet_the_barriers_at_the_times_of_the_reference() {
    let dir = TempDir::new().unwrap();
    figures(dir.path(), &["--only", "7,3"]).success();
    for (curve, name) in [
        ("a = 0.2", "forced double-sided, A=0.9 a=0.2 branch +"),
        ("a = 0.5", "forced double-sided, A=0.9 a=0.5 branch +"),
    ] {
        let case = reference(name);
        let (phi, a) = (case["phi"].as_f64().unwrap(), case["parameters"]["asymmetry"].as_f64().unwrap());
        let trace = table(&dir.path().join("figure-7.csv"));
        let near = |row: &&BTreeMap<String, String>| row["curve"] == curve && (number(row, "time") - phi).abs() < 1e-9;
        let hit = trace.iter().find(near).unwrap();
        assert!((number(hit, "displacement") - (a - 1.0)).abs() < 1e-13);
        // Just after the impact: e 2p₁/(1+e).
        let after = 0.9 * 2.0 * case["p1"].as_f64().unwrap() / 1.9;
        assert!((number(hit, "velocity") - after).abs() < 1e-12, "{} {after}", number(hit, "velocity"));
        let start = trace.iter().find(|row| row["curve"] == curve && number(row, "time") == 0.0).unwrap();
        assert!((number(start, "displacement") - (a + 1.0)).abs() < 1e-13);
    }
}

#[test]
fn figure_nine_has_all_four_solutions_and_the_pitchfork() {
    let dir = TempDir::new().unwrap();
    let document = dir.path().join("figures.md");
    let out = dir.path().join("pictures");
    figures(&out, &["--only", "9", "--document", document.to_str().unwrap()]).success();
    let files = ["figure-9-asymmetry.csv", "figure-9-branches.csv", "figure-9.csv", "figure-9.png", "figure-9.svg"];
    assert_eq!(names(&out), files);
    let expected: Vec<Value> = ["0.4209 branch +", "0.5000 branch +", "0.5000 branch -", "0.5791 branch +"]
        .iter()
        .map(|name| reference(&format!("figure 9 with e=0.6, phi/T={name}")))
        .collect();
    let branches = table(&out.join("figure-9-branches.csv"));
    let here: Vec<_> = branches.iter().filter(|row| row["restitution"] == "0.6").collect();
    assert_eq!(here.len(), 4);
    for case in &expected {
        let (phi, radius) = (case["phi"].as_f64().unwrap(), case["spectral_radius"].as_f64().unwrap());
        let meets = |row: &&&BTreeMap<String, String>| {
            (number(row, "phi") - phi).abs() < 1e-9 && (number(row, "spectral_radius") / radius - 1.0).abs() < 1e-9
        };
        assert_eq!(here.iter().filter(meets).count(), 1, "{phi}");
    }
    assert_eq!(branches.iter().filter(|row| row["restitution"] == "0.5").count(), 2);
    // a(φ) changes its sign next to every solution, and nowhere else by a continuous curve.
    let curve = table(&out.join("figure-9-asymmetry.csv"));
    let mut zeros = Vec::new();
    for pair in curve.windows(2).filter(|pair| pair[0]["branch"] == pair[1]["branch"]) {
        let (Ok(x), Ok(y)) = (pair[0]["asymmetry"].parse::<f64>(), pair[1]["asymmetry"].parse::<f64>()) else {
            continue;
        };
        if x * y < 0.0 && (x - y).abs() < 1.0 {
            zeros.push(0.5 * (number(&pair[0], "phi") + number(&pair[1], "phi")));
        }
    }
    let period = 2.0 * std::f64::consts::PI / 1.33;
    for case in &expected {
        let phi = case["phi"].as_f64().unwrap();
        // At T/2 a sample may be the zero itself.
        let near = zeros.iter().any(|zero| (zero - phi).abs() < period / 1200.0);
        assert!(near || (phi / period - 0.5).abs() < 1e-9, "{phi} {zeros:?}");
    }
    let text = fs::read_to_string(document).unwrap();
    assert!(text.contains("](pictures/figure-9.png)") && text.contains("from 2 to 4 at e = 0.52458531"), "{text}");
    assert!(text.contains("*The paper:*") && text.contains("*Here:*"));
}

#[test]
fn simulations_part_from_unstable_orbits_and_return_to_a_stable_one() {
    let dir = TempDir::new().unwrap();
    figures(dir.path(), &["--only", "11,12,13"]).success();
    for (id, name) in [
        (11, "single-sided across Neimark-Sacker, unstable gamma2=.12"),
        (12, "forced double-sided, A=0.9 a=0.4 branch +"),
        (13, "period-doubled"),
    ] {
        let rows = table(&dir.path().join(format!("figure-{id}.csv")));
        let distances: Vec<(f64, f64)> = rows
            .iter()
            .map(|row| (number(row, "time"), number(row, "distance")))
            .filter(|row| row.0.fract() == 0.0)
            .collect();
        let radius = reference(name)["spectral_radius"].as_f64().unwrap();
        // The largest of a few turns, early and late in the linear range.
        let largest = |from: f64| {
            distances.iter().filter(|row| (from..from + 40.0).contains(&row.0)).map(|row| row.1).fold(0.0, f64::max)
        };
        let (from, to) = if id == 13 { (0.0, 3900.0) } else { (10.0, 170.0) };
        let rate = (largest(to) / largest(from)).powf(1.0 / (to - from));
        let expected = if id == 13 { radius.sqrt() } else { radius };
        assert!((rate - expected).abs() < if id == 13 { 2e-5 } else { 2e-3 }, "figure {id}: {rate} {expected}");
        let last = rows.last().unwrap();
        if id == 13 {
            assert!((number(last, "simulated") - number(last, "analytic")).abs() < 1e-3);
        } else {
            assert!(number(last, "distance") > 0.1);
        }
    }
}

/// A map of the folder's scene with fewer cells, so that a test can afford it.
#[test]
fn scenes_of_a_folder_take_the_place_of_those_built_in() {
    let dir = TempDir::new().unwrap();
    let scenes = dir.path().join("scenes");
    fs::create_dir(&scenes).unwrap();
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/figures"));
    for id in ["10", "15a"] {
        let text = fs::read_to_string(folder.join(format!("figure-{id}.toml"))).unwrap();
        let text = text.replace("points = 400", "points = 20").replace("points = 300", "points = 15");
        fs::write(scenes.join(format!("figure-{id}.toml")), text).unwrap();
    }
    let (out, document) = (dir.path().join("out"), dir.path().join("out/figures.md"));
    let flags = ["--scenes", scenes.to_str().unwrap(), "--document", document.to_str().unwrap()];
    figures(&out, &flags).success().stderr(contains("figures 10, 15a written"));
    let map = table(&out.join("figure-15a.csv"));
    assert_eq!(map.len(), 300);
    // The same cells as by `mapgen sweep`.
    let swept = dir.path().join("map.csv");
    let scene = scenes.join("figure-15a.toml");
    swept_by(&format!("--quiet {} --out {}", scene.display(), swept.display()));
    assert_eq!(fs::read(swept).unwrap(), fs::read(out.join("figure-15a.csv")).unwrap());
    // The heading of each map names the excess above which an orbit counts as unstable.
    let heading = |svg: &Path| {
        let text = fs::read_to_string(svg).unwrap();
        text.lines().find(|line| line.contains("stable: excess")).map(|line| line.trim().to_owned())
    };
    assert!(heading(&out.join("figure-10.svg")).unwrap().contains("below 0.01 a period"));
    assert_eq!(heading(&out.join("figure-15a.svg")), None);
    let picture = dir.path().join("map.svg");
    let again = dir.path().join("again.csv");
    let files = format!("{} --svg {} --out {}", scene.display(), picture.display(), again.display());
    swept_by(&format!("--quiet --threshold 0.5 {files}"));
    assert!(heading(&picture).unwrap().contains("below 0.5 a period"));
    let text = fs::read_to_string(document).unwrap();
    let count = |class: &str| map.iter().filter(|row| row["class"] == class).count();
    assert!(text.contains(&format!("| stable-double | {} (", count("stable-double"))), "{text}");
    assert!(text.contains("](figure-15a.png)") && text.contains("have a multiplier outside the circle"));
}

#[test]
fn wrong_requests_are_answered_with_exit_code_two() {
    let dir = TempDir::new().unwrap();
    let path = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    for only in ["14", "3,99", "x", ",", "-3"] {
        figures(&dir.path().join("out"), &["--only", only]).code(2).stderr(contains("no such figure"));
    }
    figures(&dir.path().join("out"), &["--scenes", &path("nowhere")]).code(2).stderr(contains("cannot read scenes"));
    figures(&dir.path().join("out"), &["--scenes", &path("")]).code(2).stderr(contains("has no file figure-NUMBER"));
    fs::write(dir.path().join("figure-1.toml"), "[figure]\nkind = \"pie\"\n").unwrap();
    figures(&dir.path().join("out"), &["--scenes", &path("")]).code(2).stderr(contains("figure-1.toml:"));
    fs::write(dir.path().join("file"), "").unwrap();
    figures(&dir.path().join("file"), &["--only", "3"]).code(2).stderr(contains("name a folder"));
    assert!(!dir.path().join("out").exists());
}

/// `mapgen sweep`, in this process.
fn swept_by(flags: &str) {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let mut console = Console::new(&mut out, &mut err, &ctrl_c);
    vibrochain_cli::program::run(format!("mapgen sweep {flags}").split(' ').map(Into::into), &mut console).unwrap();
}

/// Runs the program in this process, told to stop before it begins.
fn stopped(line: &str) -> (u8, String) {
    let interrupt = move || Ok(Stop::when(|| true));
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let mut console = Console::new(&mut out, &mut err, &interrupt);
    match program::run(line.split(' ').map(Into::into), &mut console) {
        Ok(()) => (0, String::new()),
        Err(error) => (error.exit_code(), error.to_string()),
    }
}

#[test]
fn ctrl_c_leaves_no_file_behind() {
    let dir = TempDir::new().unwrap();
    for only in ["3", "10", "9,12"] {
        let (code, message) = stopped(&format!("studies figures --out {} --only {only}", dir.path().display()));
        assert_eq!((code, message.as_str()), (130, "interrupted: nothing was written"));
        assert!(names(dir.path()).is_empty());
    }
}

#[test]
fn damaged_scenes_are_refused_or_drawn_and_nothing_else() {
    let dir = TempDir::new().unwrap();
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/figures"));
    let mut random = fastrand::Rng::with_seed(5);
    let (mut refused, mut sound) = (0, 0);
    for name in names(folder) {
        let text = fs::read_to_string(folder.join(&name)).unwrap();
        let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
        for _ in 0..60 {
            let mut damaged = lines.clone();
            let i = random.usize(..damaged.len());
            let values = ["nan", "-1", "0", "inf", "1e300", "99999999999999999999", "\"x\"", "[]", "{}", ""];
            let line = match (random.u8(..4), damaged[i].split_once('=')) {
                (0, _) => String::new(),
                (1, _) => damaged[random.usize(..damaged.len())].to_owned(),
                (_, Some((key, _))) => format!("{key} = {}", values[random.usize(..values.len())]),
                (_, None) => damaged[i].chars().rev().collect(),
            };
            damaged[i] = &line;
            fs::write(dir.path().join(&name), damaged.join("\n")).unwrap();
            // Told to stop at once: a scene that passes for sound is not drawn.
            let (scenes, out) = (dir.path().display(), dir.path().join("out"));
            let (code, message) = stopped(&format!("studies figures --scenes {scenes} --out {}", out.display()));
            match code {
                2 => {
                    refused += 1;
                    assert!(message.contains(&name), "{message}");
                }
                130 => sound += 1,
                _ => panic!("{code}: {message}\n{}", damaged.join("\n")),
            }
        }
        fs::remove_file(dir.path().join(&name)).unwrap();
    }
    assert!(refused > 300 && sound > 100, "{refused} {sound}");
}

#[test]
fn corrections_have_their_digits() {
    let dir = TempDir::new().unwrap();
    let file = dir.path().join("errata.md");
    studies(&["errata", "--out"]).arg(&file).assert().success().stdout("");
    let text = fs::read_to_string(&file).unwrap();
    for digits in [
        "omega = 0.930442841807",
        "upper barrier at t = 3.452175",
        "restitution = 0.52458531444792",
        "gamma2 = 0.0883473879710",
        "amplitude = 0.1589080864892",
        "amplitude = 0.157927457266",
        "1.148774814",
        "-1.0045372",
        "2.79757441",
        "1.0030770",
        "1.0016290",
        "1.0004810",
        "phi 2.11560278",
        "4 solutions, 4 physical",
        "2 solutions, 2 physical",
    ] {
        assert!(text.contains(digits), "{digits} is missing in\n{text}");
    }
    // Every printed formula fails and every mended one holds.
    let rows: Vec<Vec<&str>> = text
        .lines()
        .skip_while(|line| !line.starts_with("| where"))
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    assert_eq!(rows.len(), 11);
    for row in rows {
        let (printed, mended): (f64, f64) = (row[4].parse().unwrap(), row[5].parse().unwrap());
        let rounding = if row[3].contains("harmonics") {
            1e-6
        } else if row[3].contains("differences") {
            1e-9
        } else {
            1e-13
        };
        assert!(printed > 1e-2 && mended < rounding, "{row:?}");
    }
    // The document in the repository tells the same, up to the last digits of errors.
    let kept = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/errata.md")).unwrap();
    let commands = |text: &str| -> Vec<String> {
        text.lines().filter(|line| line.starts_with("mapgen ") || line.starts_with("##")).map(str::to_owned).collect()
    };
    assert_eq!(
        commands(&kept),
        commands(&text),
        "docs/errata.md: make it again by `studies errata --out docs/errata.md`"
    );
}

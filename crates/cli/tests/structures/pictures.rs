//! Pictures and tables of structures: orbits, runs, maps and fates.

use std::fs;

use serde_json::Value;
use vibrochain_testkit::svg::texts;
use vibrochain_testkit::{TestDir, written};

const TWO: &str = "title = \"Two masses\"\nomega = 1.05\nword = \"0+,0-\"\n[structure]\nmass = [[1, 0], [0, 1.4]]\n\
    stiffness = [[1, -0.3], [-0.3, 0.8]]\ndamping = [[0.02, 0], [0, 0.02]]\n[[contact]]\nat = 1\nlower = -0.7\nupper = 1.3\n\
    restitution = 0.8\n[force]\nload = [0.5, 0]\n";

const SWEEP: &str = "[sweep]\nx = { parameter = \"omega\", from = 0.6, to = 1.4, points = 12 }\n\
    y = { parameter = \"contact.0.upper\", from = 0.5, to = 1.3, points = 8 }\n[compute]\nfamilies = [\"0+\", \"0+,0-\", \"0-\"]\n";

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Rows of a table of numbers, the header first.
fn table(dir: &TestDir, name: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut reader = csv::Reader::from_path(dir.path(name)).unwrap();
    let header = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let rows = reader.records().map(|row| row.unwrap().iter().map(|text| text.parse().unwrap_or(f64::NAN)).collect());
    (header, rows.collect())
}

fn words(dir: &TestDir, name: &str) -> Vec<String> {
    let svg = String::from_utf8(dir.read(name)).unwrap();
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
    texts(&svg).into_iter().map(|(_, words)| words).collect()
}

#[track_caller]
fn has(words: &[String], wanted: &[&str]) {
    for one in wanted {
        assert!(words.iter().any(|words| words.contains(one)), "{one}: {words:?}");
    }
}

#[test]
fn an_orbit_is_drawn_with_its_contacts_barriers_and_multipliers() {
    let dir = TestDir::with_scene(TWO);
    let line = "orbit --scene scene.toml --json --plot o.svg --all-plots all --format svg --trajectory t.csv --samples 200 --multipliers m.csv";
    let answer = written(&dir.run(line).with(0, &[]).out);
    let drawn = words(&dir, "o.svg");
    has(&drawn, &["Two masses, 0+,0- solution 1: 2 modes, 1 contact, e = 0.8, ω = 1.05", "stable", "not physical"]);
    has(&drawn, &["g of contact 0", "velocity g′", "flight", "before", "after", "time, in periods of the orbit"]);
    for (name, wanted) in [("trace", "g of contact 0"), ("phase", "velocity g′"), ("multipliers", "unit circle")] {
        has(&words(&dir, &format!("all/solution-1-{name}.svg")), &[wanted]);
    }
    let solutions = answer["solutions"].as_array().unwrap();
    let (header, rows) = table(&dir, "m.csv");
    assert_eq!(header, ["solution", "real", "imaginary", "modulus", "argument", "mode"]);
    let told = solutions.iter().flat_map(|solution| solution["stability"]["multipliers"].as_array().unwrap());
    let told: Vec<[f64; 2]> = told.map(|pair| [number(&pair[0]), number(&pair[1])]).collect();
    assert_eq!(told, rows.iter().map(|row| [row[1], row[2]]).collect::<Vec<_>>());
    // The contact is mass 1; it begins on its barrier and comes back to it, as fast as the impacts say.
    let (header, rows) = table(&dir, "t.csv");
    let wanted = [
        "solution",
        "time",
        "contact_0",
        "contact_velocity_0",
        "displacement_0",
        "displacement_1",
        "velocity_0",
        "velocity_1",
    ];
    assert_eq!(header, wanted);
    assert_eq!(rows.len(), 201 * solutions.len());
    for (solution, rows) in solutions.iter().zip(rows.chunks(201)) {
        let impact = &solution["impacts"][0];
        let (first, last) = (&rows[0], &rows[200]);
        assert!((first[2] - 1.3).abs() < 1e-12 && (last[2] - 1.3).abs() < 1e-12, "{first:?} {last:?}");
        assert!((first[3] - number(&impact["velocity_after"])).abs() < 1e-12);
        assert!((last[3] - number(&impact["velocity_before"])).abs() < 1e-12);
        assert!((last[1] - number(&solution["period"])).abs() < 1e-12);
        assert!(rows.iter().all(|row| (row[2] - row[5]).abs() < 1e-12 && (row[3] - row[7]).abs() < 1e-12));
        // Velocities are the slopes of places, by Simpson's rule, but across impacts.
        let step = last[1] / 200.0;
        let rises = rows.windows(3).step_by(2).filter(|three| {
            let rise = step / 3.0 * (three[0][6] + 4.0 * three[1][6] + three[2][6]);
            (three[2][4] - three[0][4] - rise).abs() < 1e-7
        });
        assert!(rises.count() >= 98);
    }
}

/// Contacts between other barriers have panels of their own; those between the same share one.
#[test]
fn contacts_with_other_barriers_have_other_panels() {
    let structure = "omega = 1.5\n[structure]\nchain = { sites = 3, gamma1 = 0.2, gamma2 = 0.1 }\n";
    let contact = |at: usize, lower: f64| format!("[[contact]]\nat = {at}\nlower = {lower}\nupper = 1.4\n");
    let same = TestDir::with_scene(&format!("{structure}{}{}{}", contact(0, -0.6), contact(1, -0.6), contact(2, -0.6)));
    let line = "orbit --scene scene.toml --word 0+1+2+,0-1-2- --plot o.svg";
    same.run(line).with(0, &[]);
    has(&words(&same, "o.svg"), &["g of the contacts", "contact 0", "contact 2"]);
    let first = "[[contact]]\nat = 0\nupper = 0.5\nrestitution = 0.8\n[force]";
    let other = TestDir::with_scene(&TWO.replace("lower = -0.7\nupper = 1.3", "upper = 0.7").replace("[force]", first));
    other.run("orbit --scene scene.toml --word 1+,0+ --plot o.svg").with(0, &[]);
    has(&words(&other, "o.svg"), &["g of contact 0", "g of contact 1"]);
}

#[test]
fn a_run_is_drawn_over_its_orbit_and_cut_by_sections() {
    let dir = TestDir::with_scene(TWO);
    let answer = written(&dir.run("orbit --scene scene.toml --json").with(0, &[]).out);
    let orbit = answer["solutions"].as_array().unwrap().iter().find(|solution| solution["physical"] == true).unwrap();
    let line = "simulate --scene scene.toml --periods 10 --plot r.svg --trajectory t.csv --samples 16 --section s.csv --section-phase 0.25";
    dir.run(line).with(0, &[]);
    has(
        &words(&dir, "r.svg"),
        &["from the orbit 0+,0-", "analytic orbit", "simulation", "velocity g′ before impacts", "g of contact 0"],
    );
    // Both panels end with the run, however many samples it has.
    dir.run("simulate --scene scene.toml --periods 10 --plot fine.svg --samples 4000").with(0, &[]);
    assert_eq!(words(&dir, "fine.svg").iter().filter(|words| *words == "10").count(), 2);
    let (header, rows) = table(&dir, "t.csv");
    assert_eq!((header.len(), rows.len()), (7, 161));
    let period = number(&orbit["period"]);
    assert!((rows[160][0] - 10.0 * period).abs() < 1e-11);
    // A stable orbit: it comes back, sample by sample.
    assert!(rows[..144].iter().zip(&rows[16..]).all(|(a, b)| (1..7).all(|i| (a[i] - b[i]).abs() < 1e-11)));
    let (header, rows) = table(&dir, "s.csv");
    assert_eq!(header, ["time", "period", "phase", "contact_0", "contact_velocity_0"]);
    assert_eq!(rows.len(), 10);
    assert!(rows.iter().all(|row| (row[2] - 0.25).abs() < 1e-12 && (row[3] - rows[0][3]).abs() < 1e-11), "{rows:?}");
    dir.run("simulate --scene scene.toml --periods 10 --section i.csv --section-at impact --skip 5").with(0, &[]);
    let (header, rows) = table(&dir, "i.csv");
    assert_eq!(header, ["time", "period", "phase", "contact", "barrier", "velocity_before", "velocity_after"]);
    let told: Vec<f64> =
        orbit["impacts"].as_array().unwrap().iter().map(|impact| number(&impact["velocity_before"])).collect();
    assert_eq!(rows.len(), 10);
    assert!(rows.iter().all(|row| told.iter().any(|velocity| (velocity - row[5]).abs() < 1e-11)), "{rows:?} {told:?}");
    for (flags, told) in [("--perturb 1e-3", "--perturb is of lattices"), ("--samples 0", "out of range")] {
        let ran = dir.run(&format!("simulate --scene scene.toml --periods 1 --trajectory t.csv {flags}"));
        assert!(ran.code == Some(2) && ran.err.contains(told), "{flags}: {}", ran.err);
    }
}

#[test]
fn maps_are_drawn_with_the_names_of_their_words_and_axes() {
    let dir = TestDir::with_scene(&format!("{TWO}{SWEEP}"));
    dir.run("sweep scene.toml --out map.csv --plot map.svg").with(0, &["96 cells"]);
    let drawn = words(&dir, "map.svg");
    has(
        &drawn,
        &[
            "Two masses",
            "frequency ω",
            "upper barrier of contact 0",
            "stable 0+,0-",
            "unstable 0+,0-",
            "2 modes, 1 contact, e = 0.8",
        ],
    );
    assert!(drawn.iter().all(|words| !words.contains("breather")), "{drawn:?}");
    // What the legend has is what the table has.
    let text = String::from_utf8(dir.read("map.csv")).unwrap();
    for (class, word) in [("stable", "0+"), ("unstable", "0+"), ("stable", "0-"), ("unstable", "0-")] {
        let there = text.contains(&format!(",{class},{word},"));
        assert_eq!(drawn.iter().any(|words| *words == format!("{class} {word}")), there, "{class} {word}");
    }
    dir.run("sweep scene.toml --out map.csv --plot margin.svg --show margin").with(0, &[]);
    has(&words(&dir, "margin.svg"), &["margin: distance to a barrier"]);
    let one = format!(
        "{TWO}{}",
        SWEEP.replace("y = { parameter = \"contact.0.upper\", from = 0.5, to = 1.3, points = 8 }\n", "")
    );
    fs::write(dir.path("one.toml"), one).unwrap();
    dir.run("sweep one.toml --out one.csv --plot one.svg").with(0, &["12 cells"]);
    has(&words(&dir, "one.svg"), &["largest |μ|", "margin, the smallest distance to a barrier", "frequency ω"]);
    for (flags, told) in [("--curves", "--curves"), ("--show impulse", "impulse"), ("--slice omega=1", "--slice")] {
        let ran = dir.run(&format!("sweep scene.toml --out map.csv --plot map.svg {flags}"));
        assert!(ran.code == Some(2) && ran.err.contains(told), "{flags}: {}", ran.err);
    }
}

#[test]
fn fates_of_structures_are_counted_and_drawn() {
    let dir = TestDir::with_scene(&format!(
        "{TWO}{}",
        SWEEP.replace("points = 12", "points = 4").replace("points = 8", "points = 3")
    ));
    let line = "fate scene.toml --starts 2 --periods 200 --breathers every --out f.csv --plot f.svg --json";
    let answer = written(&dir.run(line).with(0, &[]).out);
    assert_eq!(answer["axes"], serde_json::json!(["omega", "contact.0.upper"]));
    assert_eq!(number(&answer["cells"]), 12.0);
    let (breathers, compared) = (number(&answer["breathers"]), number(&answer["exponents_compared"]));
    assert!(breathers > 8.0 && compared > 0.8 * breathers && number(&answer["exponent_difference"]) < 1e-6, "{answer}");
    let text = String::from_utf8(dir.read("f.csv")).unwrap();
    assert!(text.starts_with("omega,contact.0.upper,solutions,status,number,breather,spectral_radius,"), "{text}");
    has(&words(&dir, "f.svg"), &["stays on the orbit", "upper barrier of contact 0"]);
    // From rest, by the words that it settles on; the same for any number of threads.
    let line = "fate scene.toml --starts 2 --periods 200 --breathers rest --perturb 0.1 --plot w.svg";
    let told = dir.run(&format!("{line} --out r.csv")).with(0, &[]).out;
    dir.run(&format!("{line} --out one.csv --threads 1")).with(0, &[]);
    assert_eq!(dir.read("r.csv"), dir.read("one.csv"));
    assert!(told.contains("impact words of `periodic`") && told.contains("0+,0-"), "{told}");
    assert!(told.contains("), from rest, 24 runs of 200 periods") && !told.contains("breather"), "{told}");
    has(&words(&dir, "w.svg"), &["0+,0-", "from rest"]);
    for (flags, told) in [("--diagram d.csv", "needs a scene with one axis"), ("--periods 5", "--periods 5")] {
        let ran = dir.run(&format!("fate scene.toml {flags}"));
        assert!(ran.code == Some(2) && ran.err.contains(told), "{flags}: {}", ran.err);
    }
}

#[test]
fn an_axis_keeps_the_name_that_the_scene_gives_it() {
    let scene = "[model]\nsites = 3\ngamma1 = 0.2\ngamma2 = 0.1\nomega = 1.5\nasymmetry = 0.4\nrestitution = 0.9\ndamping = 0.01\nstatic_force = 0\n\
        [sweep]\nx = { parameter = \"amplitude\", from = 0.1, to = 0.2, points = 3 }\n[compute]\nfamilies = [\"double-sided\"]\n";
    let dir = TestDir::with_scene(scene);
    dir.run("sweep scene.toml --out map.csv --plot map.svg").with(0, &["3 cells"]);
    assert!(String::from_utf8(dir.read("map.csv")).unwrap().starts_with("amplitude,class,"));
    has(&words(&dir, "map.svg"), &["3 masses (N = 2)", "c = 0.01", "A"]);
}

/// Values one by one, equal ratios and a third axis, as a lattice has them: each row is the point that it names.
#[test]
fn axes_are_those_of_chains() {
    let model = "sites = 3\ngamma1 = 0.2\ngamma2 = 0.1\nasymmetry = 0.4\nrestitution = 0.9\namplitude = 0.1\nstatic_force = 0\n";
    let sweep = |axes: &str| {
        format!("[model]\n{model}[sweep]\n{axes}[compute]\nfamilies = [\"double-sided\", \"single-sided\"]\n")
    };
    let log = "{ parameter = \"damping\", from = 0.001, to = 0.1, points = 3, spacing = \"log\" }";
    let list = "{ parameter = \"omega\", values = [1.7, 1.2] }";
    let third = "{ parameter = \"restitution\", values = [0.9, 0.8] }";
    let model_without = model.replace("restitution = 0.9\n", "");
    let scene = sweep(&format!("x = {list}\ny = {log}\naxes = [{third}]\n")).replace(model, &model_without);
    let dir = TestDir::with_scene(&scene);
    dir.run("sweep scene.toml --out all.csv").with(0, &["12 cells"]);
    let all = String::from_utf8(dir.read("all.csv")).unwrap();
    let rows: Vec<Vec<&str>> = all.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert!(all.starts_with("omega,damping,restitution,class,") && rows.len() == 12, "{all}");
    let mut found = 0;
    for row in &rows {
        let [omega, damping, restitution] = [row[0], row[1], row[2]];
        let one = model.replace("restitution = 0.9", &format!("restitution = {restitution}\ndamping = {damping}"));
        let alone = sweep(&format!("x = {{ parameter = \"omega\", values = [{omega}] }}\n")).replace(model, &one);
        fs::write(dir.path("one.toml"), alone).unwrap();
        dir.run("sweep one.toml --out one.csv").with(0, &[]);
        let told = String::from_utf8(dir.read("one.csv")).unwrap();
        assert_eq!(told.lines().nth(1).unwrap(), format!("{omega},{}", row[3..].join(",")));
        found += usize::from(row[3] != "none");
    }
    assert!(found >= 5, "{all}");
    for (axes, told) in [
        (format!("x = {}\n", log.replace("log", "cubic")), "`cubic` is not a spacing"),
        (format!("x = {log}\ny = {log}\n"), "damping is swept twice"),
        ("x = { parameter = \"damping\", values = [0.1, 0.1] }\n".to_owned(), "listed twice"),
        ("x = { parameter = \"damping\", from = 0 }\n".to_owned(), "damping has no values yet"),
    ] {
        fs::write(dir.path("wrong.toml"), sweep(&axes)).unwrap();
        let ran = dir.run("sweep wrong.toml --out wrong.csv");
        assert!(ran.code == Some(2) && ran.err.contains(told), "{axes}: {}", ran.err);
    }
}

/// Entries of matrices and loads are numbers like others; a chain on a wall is one with dashpots, or asked so.
#[test]
fn entries_and_ends_are_those_of_the_scene_that_says_so() {
    let dir = TestDir::with_scene(TWO);
    let other = TWO
        .replace("[[1, -0.3], [-0.3, 0.8]]", "[[1, -0.31], [-0.31, 0.8]]")
        .replace("[[1, 0], [0, 1.4]]", "[[1, 0], [0, 1.45]]")
        .replace("[[0.02, 0], [0, 0.02]]", "[[0.03, 0], [0, 0.02]]")
        .replace("load = [0.5, 0]", "load = [0.52, 0]\nstatic = [0, 0.01]");
    fs::write(dir.path("other.toml"), other).unwrap();
    let set =
        "--set stiffness.0.1=-0.31 --set masses.1=1.45 --set damping.0.0=0.03 --set load.0=0.52 --set static.1=0.01";
    let one = written(&dir.run(&format!("orbit --scene scene.toml --json {set}")).with(0, &[]).out);
    let two = written(&dir.run("orbit --scene other.toml --json").with(0, &[]).out);
    assert_eq!(one["solutions"], two["solutions"]);
    let sweep = "[sweep]\nx = { parameter = \"stiffness.0.1\", from = -0.32, to = -0.3, points = 3 }\n[compute]\nfamilies = [\"0+,0-\"]\n";
    fs::write(dir.path("k.toml"), format!("{TWO}{sweep}")).unwrap();
    dir.run("sweep k.toml --out k.csv").with(0, &[]);
    let (header, rows) = table(&dir, "k.csv");
    assert_eq!((header[0].as_str(), rows[1][0]), ("stiffness.0.1", -0.31));
    for (flags, told) in [
        ("--set mass.0.2=1", "the structure has the coordinates 0 to 1"),
        ("--set stiffness.0.1=9", "indefinite"),
        ("--set mass.0.0=-1", "not positive definite"),
    ] {
        let ran = dir.run(&format!("orbit --scene scene.toml {flags}"));
        assert!(ran.code == Some(2) && ran.err.contains(told), "{flags}: {}", ran.err);
    }
    let chain = "--sites 2 --gamma1 0 --gamma2 1 --omega .7 --upper 1 --stops 1 --word 1+ --json";
    let flags = written(&dir.run(&format!("orbit --ends fixed-free {chain}")).with(0, &[]).out);
    let scene = written(
        &dir.run(&format!(
            "orbit --json --scene {}/../../scenes/structures/clamped-chain.toml",
            env!("CARGO_MANIFEST_DIR")
        ))
        .with(0, &[])
        .out,
    );
    let impulse = |answer: &Value| number(&answer["solutions"][0]["impacts"][0]["impulse"]);
    assert!((impulse(&flags) - impulse(&scene)).abs() < 1e-13);
    let ran = dir.run(
        "words --sites 3 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --ends fixed-free --sites-used 1 --reach 0",
    );
    assert!(
        ran.code == Some(2) && ran.err.contains("orbit, branch, locate, curve, simulate, fate, sweep and explore"),
        "{}",
        ran.err
    );
}

/// What no command of chains can answer is told with those that can.
#[test]
fn commands_of_chains_say_who_answers() {
    let dir = TestDir::with_scene(&format!("{TWO}{SWEEP}"));
    for line in ["curves scene.toml --out c.csv", "stripes scene.toml --out s.csv"] {
        let ran = dir.run(line);
        assert!(
            ran.code == Some(2) && ran.err.contains("orbit, branch, locate, curve, simulate, fate, sweep and explore"),
            "{line}: {}",
            ran.err
        );
    }
}

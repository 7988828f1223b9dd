//! Long runs of structures: a map, or the fates of runs, in shares or killed at any moment, end in the same bytes as one undisturbed.

use std::fs;
use std::time::{Duration, Instant};

use serde_json::Value;
use vibrochain_testkit::{TestDir, written};

/// Two masses, of which one has stops; the other's spring comes from a file.
const SCENE: &str = "omega = 0.9\n[structure]\nmass = [[1, 0], [0, 1.4]]\nstiffness = \"k.mtx\"\n\
    damping = [[0.02, 0], [0, 0.02]]\n[[contact]]\nat = 1\nlower = -0.7\nupper = 1.3\nrestitution = 0.8\n[force]\nload = [0.5, 0]\n\
    [sweep]\nx = { parameter = \"omega\", from = 0.4, to = 2.0, points = 80 }\n\
    y = { parameter = \"contact.0.upper\", from = 0.2, to = 1.4, points = 60 }\n\
    [compute]\nfamilies = [\"0+\", \"0+,0-\"]\n";

const MATRIX: &str = "%%MatrixMarket matrix coordinate real symmetric\n2 2 3\n1 1 1\n2 2 0.8\n2 1 -0.3\n";

/// One mass with one stop.
const ONE: &str = "omega = 2.3\n[structure]\nmasses = [1]\nstiffness = [[1]]\ndamping = [[0.1]]\n[[contact]]\nat = 0\nupper = 0.1\n\
    restitution = 0.8\n[force]\nload = [1]\n[sweep]\nx = { parameter = \"omega\", from = 2.25, to = 2.4, points = 4 }\n\
    [compute]\nfamilies = [\"0+\"]\n";

fn dir(scene: &str) -> TestDir {
    let dir = TestDir::with_scene(scene);
    fs::write(dir.path("k.mtx"), MATRIX).unwrap();
    dir
}

/// A coarser grid.
fn coarse(points: [u32; 2]) -> String {
    let scene = SCENE.replace("points = 80", &format!("points = {}", points[0]));
    scene.replace("points = 60", &format!("points = {}", points[1]))
}

/// What a run took is its own.
fn manifest(dir: &TestDir, name: &str) -> Value {
    let mut manifest = dir.json(name);
    ["threads", "computed_cells", "wall_seconds"].iter().for_each(|key| {
        manifest.as_object_mut().unwrap().remove(*key);
    });
    manifest
}

#[test]
fn shares_of_a_map_are_one_table_wherever_they_are_merged() {
    let dir = dir(SCENE);
    dir.run("sweep scene.toml --out map.csv --plot map.svg --threads 1").with(0, &["4800 cells (80 × 60)"]);
    for (shares, threads) in [(3, 2), (1, 1)] {
        let folder = format!("parts-{shares}");
        for share in (0..shares).rev() {
            let line = format!("sweep scene.toml --out {folder} --shard {share}/{shares} --threads {threads}");
            dir.run(&line).with(0, &[&format!("shard {share}/{shares}: ")]);
        }
        assert!(dir.chunks(&folder) >= 5, "{}", dir.chunks(&folder));
    }
    drop(dir.json("parts-3/plan.json"));
    // A merge needs neither the scene nor what it names.
    ["scene.toml", "k.mtx"]
        .iter()
        .for_each(|name| fs::rename(dir.path(name), dir.path(&format!("{name}.old"))).unwrap());
    dir.run("merge parts-3 --out merged.csv --plot merged.svg").with(0, &["4800 cells (80 × 60)"]);
    for end in ["csv", "svg"] {
        assert!(dir.read(&format!("map.{end}")) == dir.read(&format!("merged.{end}")), "{end}");
    }
    assert_eq!(manifest(&dir, "merged.manifest.json"), manifest(&dir, "map.manifest.json"));
    // The manifest is a scene: the picture is drawn from the table, and the table made anew, beside the file that it names.
    fs::rename(dir.path("k.mtx.old"), dir.path("k.mtx")).unwrap();
    dir.run("draw map.csv --plot drawn.svg").with(0, &[]);
    assert!(dir.read("drawn.svg") == dir.read("map.svg"));
    dir.run("sweep map.manifest.json --out again.csv --quiet").with(0, &[]);
    assert!(dir.read("again.csv") == dir.read("map.csv"));
    fs::remove_file(dir.path("parts-1/000001.chunk")).unwrap();
    let told = dir.run("merge parts-1 --out other.csv").with(1, &["1 of 5 chunks are missing in parts-1: 1"]);
    assert!(
        told.err.contains("make them with: mapgen sweep scene.toml --out parts-1 --shard 0/1 --resume"),
        "{told:?}"
    );
}

/// Kills a resumed run at random moments of its life until it has been met with finished chunks.
fn killed(dir: &TestDir, line: &str, outputs: &[&str], seed: u64) {
    let started = Instant::now();
    dir.run(&format!("{line} --threads 1")).with(0, &[]);
    let life = started.elapsed();
    let expected: Vec<Vec<u8>> = outputs.iter().map(|name| dir.read(name)).collect();
    let names = dir.names(".");
    outputs.iter().for_each(|name| fs::remove_file(dir.path(name)).unwrap());
    let (mut rng, mut met, mut kills) = (fastrand::Rng::with_seed(seed), 0, 0);
    while met < 3 {
        let mut child = dir.start(&format!("{line} --threads {} --resume", rng.u8(1..3)));
        std::thread::sleep(life.mul_f64(rng.f64()).max(Duration::from_millis(1)));
        let ended = child.try_wait().unwrap().is_some();
        child.kill().ok();
        child.wait().unwrap();
        kills += u32::from(!ended);
        met += u32::from(!ended && dir.chunks(&format!("{}.parts", outputs[0])) > 0);
        // A table that is there is whole, whenever the process died.
        if dir.path(outputs[0]).exists() {
            assert!(dir.read(outputs[0]) == expected[0]);
            outputs.iter().for_each(|name| drop(fs::remove_file(dir.path(name))));
        }
        assert!(kills < 200, "{met} of {kills}");
    }
    dir.run(&format!("{line} --resume")).with(0, &[]);
    for (name, expected) in outputs.iter().zip(&expected) {
        assert!(dir.read(name) == *expected, "{name}");
    }
    assert_eq!(dir.names("."), names);
}

#[test]
fn a_map_killed_at_random_moments_ends_in_the_same_bytes() {
    killed(&dir(SCENE), "sweep scene.toml --out map.csv --png map.png --quiet", &["map.csv", "map.png"], 5);
}

#[test]
fn fates_killed_at_random_moments_end_in_the_same_bytes() {
    let dir = TestDir::with_scene(&ONE.replace("points = 4", "points = 25"));
    killed(
        &dir,
        "fate scene.toml --starts 2 --periods 4000 --out fates.csv --plot fates.svg --quiet",
        &["fates.csv", "fates.svg"],
        6,
    );
}

#[test]
fn shares_of_fates_are_one_table() {
    let dir = dir(&coarse([8, 6]));
    let asked = "--breathers rest --starts 1 --periods 600";
    let whole = dir.run(&format!("fate scene.toml {asked} --out whole.csv --plot whole.svg")).with(0, &[]).out;
    for share in [1, 0] {
        dir.run(&format!("fate scene.toml {asked} --out parts --shard {share}/2"))
            .with(0, &[&format!("shard {share}/2: ")]);
    }
    let merged = dir.run("merge parts --out merged.csv --plot merged.svg").with(0, &[]).out;
    assert_eq!(merged, whole);
    for end in ["csv", "svg", "manifest.json"] {
        assert!(dir.read(&format!("whole.{end}")) == dir.read(&format!("merged.{end}")), "{end}");
    }
    dir.run("draw whole.csv --plot drawn.svg").with(0, &[]);
    assert!(dir.read("whole.svg") == dir.read("drawn.svg"));
    let words = String::from_utf8(dir.read("whole.csv")).unwrap().matches(",periodic,").count();
    assert!(words > 10, "{words}");
    let json = written(&dir.run("merge parts --out json.csv --json").with(0, &[]).out);
    assert_eq!(json["axes"], serde_json::json!(["omega", "contact.0.upper"]));
}

/// Where a list may leave orbits out, or could not be made, `none found` is not `none`: the table of runs says so as the map does.
#[test]
fn runs_tell_of_their_lists_what_the_map_tells() {
    // Without its load nothing is told of a lossy oscillator.
    let swept = ONE.replace("\"omega\", from = 2.25, to = 2.4, points = 4", "\"load\", values = [0, 0.01, 1]");
    let long = swept.replace("[\"0+\"]", "[\"0+\", \"0+,0+,0+,0+\"]");
    let mut told = Vec::new();
    for scene in [swept, long] {
        let dir = TestDir::with_scene(&scene);
        dir.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
        dir.run("fate scene.toml --starts 1 --periods 20 --out fates.csv --quiet").with(0, &[]);
        let [map, fates] = ["map.csv", "fates.csv"].map(|name| {
            let mut table = csv::Reader::from_path(dir.path(name)).unwrap();
            let header = table.headers().unwrap().clone();
            let [load, solutions, status] =
                ["load", "solutions", "status"].map(|name| header.iter().position(|known| known == name).unwrap());
            let row = |row: csv::StringRecord| [&row[load], &row[solutions], &row[status]].join(" ");
            table.records().map(|record| row(record.unwrap())).collect::<Vec<_>>()
        });
        assert_eq!(map, fates);
        told.extend(fates);
    }
    let expected =
        ["0 0 ill-conditioned", "0.01 0 ok", "1 1 ok", "0 0 ill-conditioned", "0.01 0 incomplete", "1 1 incomplete"];
    assert_eq!(told, expected);
}

#[test]
fn another_scene_is_told_by_what_differs() {
    let scene = coarse([30, 40]);
    let dir = dir(&scene);
    dir.run("sweep scene.toml --out parts --shard 0/2 --quiet").with(0, &[]);
    let shard = "sweep scene.toml --out parts --shard 1/2";
    for (change, to, told) in [
        ("upper = 1.3", "upper = 1.2", "contact.0.upper is 1.3 there, 1.2 here"),
        ("from = 0.4", "from = 0.5", "sweep.x.from is 0.4 there, 0.5 here"),
        ("\"0+\", ", "", "compute.families is [\"0+\",\"0+,0-\"] there, [\"0+,0-\"] here"),
    ] {
        dir.scene(&scene.replace(change, to));
        dir.run(shard).with(2, &["parts belongs to another scene: ", told, "name another --out"]);
    }
    dir.scene(&scene);
    dir.run(&format!("{shard} --threshold 0.1")).with(2, &["compute.threshold is absent there, 0.1 here"]);
    fs::write(dir.path("k.mtx"), MATRIX.replace("0.8", "0.81")).unwrap();
    dir.run(shard).with(2, &["files.k.mtx is \"xxh3 "]);
    fs::write(dir.path("k.mtx"), MATRIX).unwrap();
    dir.scene(
        "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\nx = { parameter = \"omega\", values = [0.5] }\n\
        y = { parameter = \"gamma2\", values = [0.1] }\n[compute]\nfamilies = [\"double-sided\"]\n",
    );
    dir.run(shard).with(2, &["it is of another kind of scene", "name another --out"]);
    // What is there is left as it was, and a title, a remark or the same in other words is no other scene.
    let other =
        scene.replace("omega = 0.9", "omega = 9e-1").replace("mass = [[1, 0], [0, 1.4]]", "masses = [1.0, 1.4]");
    let other = other.replace("lower = -0.7\nupper = 1.3\n", "upper = 1.30\nlower = -7e-1\n");
    assert!(["9e-1", "masses", "1.30"].iter().all(|word| other.contains(word)));
    dir.scene(&format!("# a remark\ntitle = \"A title\"\n{other}"));
    dir.run(shard).with(0, &[]);
    dir.run("merge parts --out map.csv --quiet").with(0, &[]);
}

#[test]
fn every_way_out_has_the_same_rows() {
    let dir = dir(&coarse([12, 10]));
    let json = dir.run("sweep scene.toml --out map.csv --json").with(0, &[]).out;
    assert_eq!(written(&json), dir.json("map.manifest.json"));
    let table = dir.read("map.csv");
    assert_eq!(dir.run("sweep scene.toml --out - --quiet").with(0, &[]).out.as_bytes(), table);
    assert!(dir.run("sweep scene.toml --dry-run").with(0, &[]).out.contains("120 (12 × 10)"));
    dir.run("sweep scene.toml --out map.csv.gz --quiet").with(0, &[]);
    let unpacked = dir.shell("gzip -dc map.csv.gz").with(0, &[]).out;
    assert_eq!(unpacked.as_bytes(), table);
    dir.run("sweep scene.toml --out other.csv --threshold 1e9 --quiet").with(0, &[]);
    assert!(!String::from_utf8(dir.read("other.csv")).unwrap().contains(",unstable,"));
    assert!(String::from_utf8(table).unwrap().contains(",unstable,"));
    dir.run("sweep scene.toml --out map.csv --curves --plot map.svg").with(2, &["of maps of lattices"]);
}

/// Where a stable orbit of one impact lives the section is its one point: the place of the contact as the load is greatest.
#[test]
fn a_diagram_is_the_orbit_where_one_is_settled_on() {
    let dir = TestDir::with_scene(ONE);
    let line = "fate scene.toml --periods 400 --points 5";
    dir.run(&format!("{line} --diagram from.csv --plot from.svg")).with(0, &[]);
    dir.run(&format!("{line} --diagram carried.csv --carry")).with(0, &[]);
    dir.run("draw from.csv --plot drawn.svg").with(0, &[]);
    assert!(dir.read("from.svg") == dir.read("drawn.svg"));
    let (unnamed, _) = ONE.split_once("[compute]").unwrap();
    fs::write(dir.path("rest.toml"), unnamed).unwrap();
    dir.run("fate rest.toml --periods 400 --points 5 --diagram rest.csv").with(0, &[]);
    let mut compared = 0;
    for table in ["from.csv", "carried.csv", "rest.csv"] {
        let mut rows = csv::Reader::from_path(dir.path(table)).unwrap();
        assert_eq!(rows.headers().unwrap(), vec!["omega", "period", "displacement_0", "velocity_0"]);
        for row in rows.records() {
            let row: Vec<f64> = row.unwrap().iter().map(|field| field.parse().unwrap()).collect();
            let [omega, _, place, velocity] = row[..] else { panic!("{row:?}") };
            let orbit = written(
                &dir.run(&format!("orbit --scene scene.toml --word 0+ --omega {omega} --json")).with(0, &[]).out,
            );
            let physical = orbit["solutions"].as_array().unwrap().iter().find(|one| one["physical"] == true).unwrap();
            // The free flight from the impact to that instant, by hand.
            let (period, psi) = (physical["period"].as_f64().unwrap(), physical["psi"].as_f64().unwrap());
            let lapse = (-psi).rem_euclid(period);
            let after = physical["impacts"][0]["velocity_after"].as_f64().unwrap();
            let size = ((1.0 - omega * omega).powi(2) + (0.1 * omega).powi(2)).sqrt();
            let lag = (0.1 * omega).atan2(1.0 - omega * omega);
            let driven = |t: f64| {
                let (sine, cosine) = (omega * (t + psi) - lag).sin_cos();
                (cosine / size, -omega * sine / size)
            };
            let swing = (1.0f64 - 0.0025).sqrt();
            let (u, v) = (0.1 - driven(0.0).0, after - driven(0.0).1);
            let (sine, cosine) = (swing * lapse).sin_cos();
            let decay = (-0.05 * lapse).exp();
            let free = decay * (u * cosine + (v + 0.05 * u) / swing * sine);
            let rise = decay * (v * cosine - (u + 0.05 * v) / swing * sine);
            let by_hand = (free + driven(lapse).0, rise + driven(lapse).1);
            assert!(
                (place - by_hand.0).abs() < 1e-8 && (velocity - by_hand.1).abs() < 1e-8,
                "{table} {row:?} {by_hand:?}"
            );
            compared += 1;
        }
    }
    assert_eq!(compared, 3 * 4 * 5);
    let damped = ONE.replace("\"omega\", from = 2.25, to = 2.4", "\"damping\", from = 0.5, to = 1");
    fs::write(dir.path("other.toml"), damped).unwrap();
    dir.run("fate other.toml --diagram d.csv --carry").with(2, &["the modes change with damping"]);
}

//! Structures and damped chains on the command line: scenes, flags, JSON, maps, and what is wrong with a request.

use std::fs;
use std::path::Path;

use serde_json::Value;
use vibrochain_testkit::{TestDir, written};

pub(crate) const TWO: &str = "omega = 0.9\nword = \"0+\"\n[structure]\nmass = [[1, 0], [0, 1.4]]\nstiffness = [[1, -0.3], [-0.3, 0.8]]\n\
    damping = [[0.02, 0], [0, 0.02]]\n[[contact]]\nat = 1\nlower = -0.7\nupper = 1.3\nrestitution = 0.8\n[force]\nload = [0.5, 0]\n";

pub(crate) fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// x″ + c x′ + kx = A cos ω(t+ψ), one impact a period on the upper stop, by the free motion between impacts alone: the state just after an
/// impact that the linear flow and the load bring back to the stop.
fn one_impact(c: f64, omega: f64, stop: f64, e: f64) -> Vec<[f64; 2]> {
    let period = std::f64::consts::TAU / omega;
    let (swing, dying) = ((1.0 - 0.25 * c * c).sqrt(), 0.5 * c);
    let (sin, cos, decay) = ((swing * period).sin(), (swing * period).cos(), (-dying * period).exp());
    // u(T), u′(T) from u(0), u′(0).
    let flow = [
        [decay * (cos + dying / swing * sin), decay * sin / swing],
        [-decay * sin / swing, decay * (cos - dying / swing * sin)],
    ];
    let size = ((1.0 - omega * omega).powi(2) + (c * omega).powi(2)).sqrt();
    let lag = (c * omega).atan2(1.0 - omega * omega);
    // With the phase x: load motion G = cos x/size, its slope −ω sin x/size; u = x − G is free. v⁺ = −e v⁻.
    let left = |x: f64| {
        let (g, slope) = (x.cos() / size, -omega * x.sin() / size);
        // v⁻ by the displacement that has to come back.
        let u = stop - g;
        let after = (u - flow[0][0] * u) / flow[0][1];
        let before = flow[1][0] * u + flow[1][1] * after;
        let (after, before) = (after + slope, before + slope);
        (after + e * before, before)
    };
    let places = 20_000;
    let mut found = Vec::new();
    for i in 0..places {
        let [mut a, mut b] = [i, i + 1].map(|i| std::f64::consts::TAU * f64::from(i) / f64::from(places));
        if left(a).0 * left(b).0 < 0.0 {
            for _ in 0..80 {
                let middle = 0.5 * (a + b);
                if left(a).0 * left(middle).0 <= 0.0 { b = middle } else { a = middle }
            }
            found.push([((a + lag) / omega).rem_euclid(period), left(a).1]);
        }
    }
    found
}

/// Eight damped oscillators of reports in the open: both orbits of one impact a period, from flags.
#[test]
fn damped_oscillators_have_the_orbits_of_their_free_motion() {
    let dir = TestDir::new();
    let mut checked = 0;
    for (c, omega, stop, e) in [
        (0.1, 2.325, 0.1, 0.8),
        (0.15, 2.2, 0.05, 0.7),
        (0.02, 2.7, 0.0, 0.8),
        (0.3, 0.9, 0.5, 0.5),
        (1.0, 2.6, -0.1, 0.9),
        (0.05, 1.9, 0.2, 0.95),
        (-0.02, 2.4, 0.1, 0.6),
        (0.5, 3.1, -0.3, 0.3),
    ] {
        let flags = "--sites 1 --gamma1 1 --gamma2 0 --amplitude 1 --word 0+ --json";
        let answer = written(
            &dir.run(&format!("orbit {flags} --damping {c} --omega {omega} --upper={stop} --restitution {e}"))
                .with(0, &[])
                .out,
        );
        let truth = one_impact(c, omega, stop, e);
        let solutions = answer["solutions"].as_array().unwrap();
        assert_eq!(solutions.len(), truth.len(), "{c} {omega}");
        for solution in solutions {
            let (psi, velocity) = (number(&solution["psi"]), number(&solution["impacts"][0]["velocity_before"]));
            let period = number(&solution["period"]);
            let off = |truth: &[f64; 2]| {
                let apart = (truth[0] - psi).rem_euclid(period);
                apart.min(period - apart).max((truth[1] - velocity).abs())
            };
            assert!(truth.iter().map(off).fold(f64::INFINITY, f64::min) < 1e-10, "{c} {omega}: {solution} {truth:?}");
            checked += 1;
        }
    }
    assert!(checked >= 14, "{checked}");
}

/// As dashpots go to nothing the answer is that of the chain without them.
#[test]
fn weak_dashpots_go_over_into_none() {
    let dir = TestDir::new();
    let flags = "--sites 6 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --amplitude .1 --restitution .9";
    let without = written(&dir.run(&format!("orbit --family double-sided {flags} --json")).with(0, &[]).out);
    let impulses = |answer: &Value| {
        let mut all: Vec<(f64, f64)> = (answer["solutions"].as_array().unwrap().iter())
            .map(|solution| {
                (number(&solution["impacts"][0]["impulse"]), number(&solution["stability"]["spectral_radius"]))
            })
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all
    };
    let expected = impulses(&without);
    assert!(expected.len() >= 2);
    for c in [1e-3, 1e-6, 1e-9, 1e-12, 1e-14, 0.0] {
        let with =
            written(&dir.run(&format!("orbit --family double-sided {flags} --damping {c} --json")).with(0, &[]).out);
        let told = impulses(&with);
        assert_eq!(told.len(), expected.len(), "{c}");
        for (told, expected) in told.iter().zip(&expected) {
            assert!(
                (told.0 - expected.0).abs() < 20.0 * c + 1e-12 && (told.1 - expected.1).abs() < 200.0 * c + 1e-11,
                "{c} {told:?}"
            );
        }
    }
}

/// Matrices, a file of them, a chain and its modes are one structure.
#[test]
fn the_forms_of_a_structure_are_one() {
    let dir = TestDir::new();
    let tail = "[[contact]]\nat = 0\nupper = 0.5\nrestitution = 0.8\n[force]\nload = [0.3, 0.3]\n";
    let contact = tail.replace("at = 0\n", "");
    let (contact, _) = contact.split_once("[force]").unwrap();
    let root = 0.5_f64.sqrt();
    fs::write(
        dir.path("k.mtx"),
        "%%MatrixMarket matrix coordinate real symmetric\n2 2 3\n1 1 1.2\n2 2 1.2\n2 1 -0.2\n",
    )
    .unwrap();
    fs::write(
        dir.path("modes.csv"),
        format!(
            "frequency, ratio, load, contact0\n1, 0.01, {}, {root}\n{}, {}, 0, {root}\n",
            0.6 * root,
            1.4_f64.sqrt(),
            0.01 / 1.4_f64.sqrt()
        ),
    )
    .unwrap();
    let forms = [
        format!(
            "[structure]\nmasses = [1, 1]\nstiffness = [[1.2, -0.2], [-0.2, 1.2]]\ndamping = [[0.02, 0], [0, 0.02]]\n{tail}"
        ),
        format!(
            "[structure]\nmass = [[1, 0], [0, 1]]\nstiffness = \"k.mtx\"\ndamping = [[0.02, 0], [0, 0.02]]\n{tail}"
        ),
        format!(
            "[structure]\nchain = {{ sites = 2, gamma1 = 1, gamma2 = 0.2, ends = \"free\", damping = 0.02 }}\n{tail}"
        ),
        format!(
            "[structure]\nfrequencies = [1, {}]\nratios = [0.01, {}]\ncontact_shapes = [[{root}, {root}]]\nload_shapes = [{}, 0]\n{contact}",
            1.4_f64.sqrt(),
            0.01 / 1.4_f64.sqrt(),
            0.6 * root
        ),
        format!("[structure]\nmodes = \"modes.csv\"\n{contact}"),
    ];
    let mut told = Vec::new();
    for form in &forms {
        fs::write(dir.path("scene.toml"), format!("omega = 1.7\nword = \"0+\"\n{form}")).unwrap();
        let answer = written(&dir.run("orbit --scene scene.toml --json").with(0, &[]).out);
        told.push((
            number(&answer["solutions"][1]["impacts"][0]["impulse"]),
            number(&answer["solutions"][1]["stability"]["spectral_radius"]),
        ));
    }
    for one in &told {
        assert!((one.0 - told[0].0).abs() < 1e-12 && (one.1 - told[0].1).abs() < 1e-12, "{told:?}");
    }
}

#[test]
fn an_orbit_leads_to_itself_and_to_its_neighbours() {
    let dir = TestDir::with_scene(TWO);
    let first = written(&dir.run("orbit --scene scene.toml --word 0+,0- --json").with(0, &[]).out);
    fs::write(dir.path("near.json"), first.to_string()).unwrap();
    let again = written(&dir.run("orbit --scene scene.toml --near near.json --json").with(0, &[]).out);
    let impulse = |answer: &Value| number(&answer["solutions"][0]["impacts"][1]["impulse"]);
    assert!((impulse(&first) - impulse(&again)).abs() < 1e-12);
    let beside = written(
        &dir.run("orbit --scene scene.toml --near near.json --set contact.0.upper=1.31 --json").with(0, &[]).out,
    );
    let apart = (impulse(&beside) - impulse(&first)).abs();
    assert!(apart > 1e-6 && apart < 0.1, "{apart}");
}

#[test]
fn a_map_is_a_row_a_point() {
    let sweep = "[sweep]\nx = { parameter = \"omega\", from = 0.6, to = 1.4, points = 9 }\n\
        y = { parameter = \"contact.0.upper\", from = 0.5, to = 0.8, points = 4 }\n[compute]\nfamilies = [\"0+\", \"0+,0-\", \"0+/2\"]\n";
    let dir = TestDir::with_scene(&format!("{TWO}{sweep}"));
    dir.run("sweep scene.toml --out map.csv").with(0, &["36 cells"]);
    let text = String::from_utf8(dir.read("map.csv")).unwrap();
    let rows: Vec<&str> = text.lines().collect();
    let known = "omega,contact.0.upper,class,word,mechanism,spectral_radius,margin,solutions,status,trouble";
    assert_eq!(rows[0], format!("{known},absence,obstruction_contact,obstruction_impact,obstruction_after"));
    assert_eq!(rows.len(), 37);
    assert!(rows[1].starts_with("0.6,0.5,") && rows[36].starts_with("1.4,0.8,"), "{} {}", rows[1], rows[36]);
    let (empty, physical): (Vec<&str>, Vec<&str>) = rows[1..].iter().partition(|row| row.contains(",none,"));
    assert!(physical.len() > 5 && physical.iter().all(|row| row.ends_with(",,,,")), "{text}");
    // None has trouble, all say why they are empty.
    assert!(empty.len() >= 3 && empty.iter().all(|row| row.contains(",ok,,") && !row.ends_with(",,,,")), "{text}");
    // Each is what `orbit` says of the point.
    let stable = rows[1..].iter().find(|row| row.contains(",stable,\"0+,0-\",")).unwrap();
    let parts: Vec<&str> = stable.split(',').collect();
    let told =
        dir.run(&format!("orbit --scene scene.toml --omega {} --set contact.0.upper={} --word 0+", parts[0], parts[1]));
    assert!(told.with(0, &[]).out.contains(&format!("stable: spectral radius {}", parts[5])), "{stable}");
}

/// Where a list is not known to be complete, a map says so at each point and in all.
#[test]
fn a_map_tells_where_its_lists_are_complete() {
    let sweep = "[sweep]\nx = { parameter = \"omega\", from = 0.6, to = 1.4, points = 5 }\n[compute]\nfamilies = ";
    let dir = TestDir::with_scene(&format!("{TWO}{sweep}[\"0+\", \"0+,0-\"]\n"));
    let four = ["0+,0-", "0+,0-,0+,0-"]
        .map(|word| dir.run(&format!("orbit --scene scene.toml --word {word}")).with(0, &[]).out);
    assert!(four[0].contains("the list is complete") && !four[1].contains("the list is complete"), "{four:?}");
    assert!(!dir.run("sweep scene.toml --out map.csv").with(0, &[]).err.contains("status"));
    assert_eq!(dir.json("map.manifest.json")["statuses"], serde_json::json!({ "ok": 5 }));
    dir.scene(&format!("{TWO}{sweep}[\"0+\", \"0+,0-,0+,0-\"]\n"));
    dir.run("sweep scene.toml --out map.csv").with(0, &["status incomplete               5"]);
    assert_eq!(dir.json("map.manifest.json")["statuses"], serde_json::json!({ "incomplete": 5 }));
    let table = String::from_utf8(dir.read("map.csv")).unwrap();
    assert_eq!(table.matches(",incomplete,").count(), 5, "{table}");
}

#[test]
fn what_is_wrong_is_told() {
    let dir = TestDir::with_scene(TWO);
    let scene = |change: &str, to: &str| fs::write(dir.path("other.toml"), TWO.replace(change, to)).unwrap();
    for (change, to, told) in [
        ("mass = [[1, 0], [0, 1.4]]", "mass = [[1, 0], [0, -1.4]]", "not positive definite"),
        ("stiffness = [[1, -0.3], [-0.3, 0.8]]", "stiffness = [[1, -3], [-3, 0.8]]", "indefinite"),
        ("stiffness = [[1, -0.3], [-0.3, 0.8]]", "stiffness = [[1, -0.3], [0.3, 0.8]]", "not symmetric"),
        ("stiffness = [[1, -0.3], [-0.3, 0.8]]", "stiffness = [[1]]", "has 1 entries where the structure needs 2"),
        ("stiffness = [[1, -0.3], [-0.3, 0.8]]", "stiffness = \"none.mtx\"", "none.mtx"),
        ("damping = [[0.02, 0], [0, 0.02]]", "damping = [[0.02, 0.01], [0, 0.02]]", "damping matrix is not symmetric"),
        ("mass = [[1, 0], [0, 1.4]]", "mass = []", "mass is empty"),
        ("at = 1", "at = 2", "the structure has 0 to 1"),
        ("at = 1", "weights = [0, 0]", "has no weight"),
        ("lower = -0.7\nupper = 1.3\n", "", "has no barrier"),
        ("lower = -0.7", "lower = 1.4", "give lower < upper"),
        ("restitution = 0.8", "restitution = 1.8", "from 0 to 1"),
        ("load = [0.5, 0]", "load = [0.5]", "has 1 entries"),
        ("omega = 0.9\n", "", "omega is missing"),
        ("damping = ", "dampin = ", "other.toml:6:1: unknown key `dampin`: did you mean `damping`?"),
        (
            "at = 1",
            "at = 1.5",
            "other.toml:8:6: floating point `1.5` is not a whole number from 0\n8 | at = 1.5\n  |      ^",
        ),
        ("at = 1", "between = [0, 1, 1]", "other.toml:8:11: "),
    ] {
        scene(change, to);
        let ran = dir.run("orbit --scene other.toml");
        assert!(ran.code == Some(2) && ran.err.contains(told), "{to}: {:?} {}", ran.code, ran.err);
    }
    for (line, code, told) in [
        ("orbit --scene scene.toml --word 1+", 2, "contact 1 does not exist"),
        ("orbit --scene scene.toml --set contact.0.gap=1", 2, "contact.N.upper"),
        ("orbit --scene scene.toml --gamma1 .2", 2, "of chains"),
        ("orbit --scene scene.toml --set load=0", 3, "losses end the motion: no load changes"),
        ("locate --scene scene.toml --word 0+ --event fold --free omega", 3, "none of the 2 orbits of 0+ is physical"),
        ("sweep scene.toml --out map.csv", 2, "sweeps nothing"),
        (
            "orbit --sites 3 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --amplitude .1 --damping .1 --family single-sided",
            2,
            "restitution is missing",
        ),
        (
            "orbit --sites 3 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --stops 3 --family single-sided",
            2,
            "sites 0 to 2",
        ),
        (
            "orbit --sites 3 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --stops 1 --family single-sided",
            2,
            "contact 0 has no lower barrier",
        ),
        (
            "orbit --sites 1 --gamma1 4 --gamma2 0 --omega 2 --upper .5 --amplitude .1 --restitution .8 --static-force .1 --word 0+",
            3,
            "resonance",
        ),
    ] {
        let ran = dir.run(line);
        assert!(ran.code == Some(code) && ran.err.contains(told), "{line}: {:?} {}", ran.code, ran.err);
    }
}

/// A chain's scene is told by its own keys, not by the matrices and loads that are made of it.
#[test]
fn numbers_of_chains_are_told_by_their_keys() {
    let dir = TestDir::new();
    let mut refused = 0;
    for key in
        ["gamma1", "gamma2", "omega", "asymmetry", "amplitude", "restitution", "damping", "static_force", "upper"]
    {
        for value in ["nan", "inf", "-1e101"] {
            let given = ["gamma1", "gamma2", "omega", "asymmetry", "amplitude", "restitution", "damping"]
                .map(|known| if known == key { String::new() } else { format!("{known} = 0.2\n") });
            let scene = format!("[model]\nsites = 2\nends = \"fixed-free\"\n{}{key} = {value}\n", given.concat());
            fs::write(dir.path("chain.toml"), scene).unwrap();
            let ran = dir.run("orbit --scene chain.toml --family single-sided");
            assert!(ran.code == Some(2) && ran.err.contains(&format!("{key} = ")), "{key}: {:?} {}", ran.code, ran.err);
            refused += 1;
        }
    }
    assert_eq!(refused, 27);
}

/// Scenes that come with the program are read, and their orbits found.
#[test]
fn scenes_of_structures_have_orbits() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/structures");
    let dir = TestDir::new();
    let mut read = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|kind| kind != "toml") {
            continue;
        }
        if !fs::read_to_string(&path).unwrap().contains("\nword = ") {
            continue;
        }
        let answer = written(&dir.run(&format!("orbit --json --scene {}", path.display())).with(0, &[]).out);
        assert!(
            answer["solutions"].as_array().unwrap().iter().any(|solution| solution["physical"] == true),
            "{}",
            path.display()
        );
        read += 1;
    }
    assert!(read >= 1, "{read}");
}

/// What no impact feels does not decide: a free motion of the whole beside a distance, and modes with a node at the contact.
#[test]
fn what_impacts_do_not_feel_is_left_out() {
    let dir = TestDir::new();
    let tail = "upper = 0.1\nrestitution = 0.8\n[force]\n";
    // Two free masses that meet, and their distance alone: half the mass, the same load on it. Nothing brings them back together, whether
    // dashpots hold the whole or not.
    for [between, ground] in [[0.0, 0.0], [0.1, 0.0], [0.0, 0.1], [0.1, 0.1]] {
        let (own, cross, one) = (between + ground, -between, between + 0.5 * ground);
        let two = format!(
            "[structure]\nmasses = [1, 1]\nstiffness = [[1, -1], [-1, 1]]\ndamping = [[{own}, {cross}], [{cross}, {own}]]\n\
             [[contact]]\nbetween = [0, 1]\n{tail}load = [1, -1]\n"
        );
        let one = format!(
            "[structure]\nmasses = [0.5]\nstiffness = [[1]]\ndamping = [[{one}]]\n[[contact]]\nat = 0\n{tail}load = [1]\n"
        );
        let told = [&two, &one].map(|scene| {
            fs::write(dir.path("scene.toml"), format!("omega = 2.4\nword = \"0+\"\n{scene}")).unwrap();
            let answer = written(&dir.run("orbit --scene scene.toml --json").with(0, &[]).out);
            let told = |one: &Value| {
                let (impact, stability) = (&one["impacts"][0], &one["stability"]);
                assert_eq!(stability["undecided"], false, "{stability}");
                [number(&impact["impulse"]), number(&impact["velocity_after"]), number(&stability["spectral_radius"])]
            };
            let mut all: Vec<[f64; 3]> = answer["solutions"].as_array().unwrap().iter().map(told).collect();
            all.sort_by(|a, b| a[0].total_cmp(&b[0]));
            all
        });
        let alike = |(a, b): (&[f64; 3], &[f64; 3])| {
            // The motion of the whole dies at its own rate.
            let whole = if ground > 0.0 { (-ground * std::f64::consts::TAU / 2.4).exp() } else { 0.0 };
            (a[0] - b[0]).abs() < 1e-12 && (a[2] - b[2].max(whole)).abs() < 1e-12
        };
        assert!(told[0].len() == 2 && told[0].iter().zip(&told[1]).all(alike), "{told:?}");
        // As a run has it, on its way or not.
        let Some(&[impulse, after, _]) = told[1].iter().find(|one| one[0] < 0.0) else { panic!("{told:?}") };
        fs::write(dir.path("two.toml"), two).unwrap();
        let [left, right] = [0.7 + 0.5 * after, 0.7 - 0.5 * after];
        let state = format!("{{\"displacement\": [5.1, 5.0], \"velocity\": [{left}, {right}], \"psi\": 0}}");
        fs::write(dir.path("state.json"), state).unwrap();
        let ran =
            dir.run("simulate --scene two.toml --omega 2.4 --state state.json --periods 900 --json").with(0, &[]).out;
        let repeats = &written(&ran)["repeats"];
        assert!(
            repeats["stable"] == true && (number(&repeats["impacts"][0]["impulse"]) - impulse).abs() < 1e-6,
            "{repeats}"
        );
    }
    // A middle mass between two alike, dashpots that are not proportional: the modes against each other are not felt.
    let three = "[structure]\nmasses = [1, 1, 1]\nstiffness = [[1.3, -0.3, 0], [-0.3, 1.6, -0.3], [0, -0.3, 1.3]]\n\
        damping = [[0.2, 0, 0], [0, 0.01, 0], [0, 0, 0.2]]\n[[contact]]\nat = 1\n";
    fs::write(dir.path("scene.toml"), format!("omega = 2.6\nword = \"0+\"\n{three}{tail}load = [0, 1, 0]\n")).unwrap();
    let answer = written(&dir.run("orbit --scene scene.toml --json").with(0, &[]).out);
    for solution in answer["solutions"].as_array().unwrap() {
        assert_eq!(solution["stability"]["multipliers"].as_array().unwrap().len(), 6);
    }
    // Without dashpots they are on the circle, and the verdict is that of the rest, as a plain chain's is.
    let flags = "--family single-sided --sites 3 --gamma1 1 --gamma2 .1 --omega 2.4 --asymmetry .9 --amplitude .5 --restitution .8 --json";
    let plain = written(&dir.run(&format!("orbit {flags}")).with(0, &[]).out);
    let structure = written(&dir.run(&format!("orbit {flags} --static-force 0")).with(0, &[]).out);
    let stable = |answer: &Value| {
        let mut all: Vec<(i64, bool)> = (answer["solutions"].as_array().unwrap().iter())
            .map(|solution| {
                (
                    (1e9 * number(&solution["impacts"][0]["impulse"])).round() as i64,
                    solution["stability"]["stable"] == true,
                )
            })
            .collect();
        all.sort_unstable();
        all
    };
    assert!(!stable(&plain).is_empty());
    assert_eq!(stable(&plain), stable(&structure));
}

/// Orbits of one word in one period of the load and in two are told apart.
#[test]
fn words_are_told_with_their_periods() {
    let dir = TestDir::new();
    let scene = "omega = 2.46\n[structure]\nmasses = [1]\nstiffness = [[1]]\ndamping = [[0.1]]\n[[contact]]\nat = 0\nupper = 0.1\n\
        restitution = 0.8\n[force]\nload = [1]\n[sweep]\nx = { parameter = \"omega\", from = 2.3, to = 2.47, points = 2 }\n\
        [compute]\nfamilies = [\"0+,0+\", \"0+\", \"0+,0+/2\"]\n";
    fs::write(dir.path("scene.toml"), scene).unwrap();
    dir.run("sweep scene.toml --out map.csv").with(0, &[]);
    let table = fs::read_to_string(dir.path("map.csv")).unwrap();
    let stable: Vec<&str> = table.lines().skip(1).map(|row| row.split(",stable,").nth(1).unwrap_or(row)).collect();
    assert!(stable[0].starts_with("0+,") && stable[1].starts_with("\"0+,0+/2\","), "{table}");
    dir.run("fate scene.toml --breathers every --starts 1 --periods 40 --out fates.csv").with(0, &[]);
    assert!(fs::read_to_string(dir.path("fates.csv")).unwrap().contains("\"0+,0+/2\""));
}

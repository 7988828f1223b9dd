//! Commands at a point that take their model from a file.

use std::fs;

use serde_json::Value;
use vibrochain_testkit::{Random, TestDir, written};

const SCENE: &str = r#"
[model]
sites = 11
gamma1 = 0.2
asymmetry = 0.4
[sweep]
x = { parameter = "omega", from = 0.9, to = 2.5, points = 3 }
y = { parameter = "gamma2", from = 0.0, to = 0.3, points = 3 }
[compute]
families = ["double-sided", "single-sided"]
stability = true
threshold = 0.5
"#;

/// A point of any kind of lattice and force: as flags, and as a file's `[model]`.
fn random_point(random: &mut Random) -> (String, String) {
    let sites = 2 + random.below(7);
    let mut flags = format!("--sites {sites}");
    let mut model = format!("[model]\nsites = {sites}\n");
    let mut give = |name: &str, value: f64| {
        flags += &format!(" --{name} {value}");
        model += &format!("{name} = {value:?}\n");
    };
    give("gamma1", random.between(0.1, 0.5));
    give("gamma2", random.between(0.0, 0.1));
    give("omega", random.between(1.4, 2.5));
    give("asymmetry", random.between(0.0, 0.5));
    let forced = random.chance(0.5);
    if forced {
        give("restitution", random.between(0.7, 1.0));
    }
    let layered = random.chance(0.3);
    if layered {
        give("gamma3", random.between(0.0, 0.1));
    }
    if forced && random.chance(0.5) {
        let (first, third) = (random.between(0.05, 0.1), random.between(-0.02, 0.02));
        flags += &format!(" --force 1:{first}:0,3:{third}:0.5");
        model += &format!(
            "force = [{{ harmonic = 1, amplitude = {first:?} }}, {{ harmonic = 3, amplitude = {third:?}, phase = 0.5 }}]\n"
        );
    } else if forced {
        let amplitude = random.between(0.05, 0.1);
        flags += &format!(" --amplitude {amplitude}");
        model += &format!("amplitude = {amplitude:?}\n");
    }
    if layered {
        flags += " --layers 2 --layer-ends closed";
        model += "layers = 2\nlayer_ends = \"closed\"\n";
    }
    let ends = ["closed", "free", "fixed"][random.below(3)];
    (format!("{flags} --ends {ends}"), format!("{model}ends = \"{ends}\"\n"))
}

#[test]
fn a_file_gives_the_answer_that_flags_give() {
    let (dir, mut random) = (TestDir::new(), Random(5));
    let (mut orbits, mut again) = (0, 0);
    for _ in 0..25 {
        let (flags, model) = random_point(&mut random);
        let by_flags = dir.run(&format!("orbit --family double-sided --json {flags}"));
        fs::write(dir.path("model.toml"), &model).unwrap();
        let by_file = dir.run("orbit --family double-sided --json --scene model.toml");
        assert_eq!((by_flags.code, &by_flags.out), (by_file.code, &by_file.out), "{model}");
        if by_flags.code != Some(0) {
            continue;
        }
        // What was printed is a file of that kind, too, and its first orbit the one to start near.
        fs::write(dir.path("orbit.json"), &by_flags.out).unwrap();
        let by_answer = dir.run("orbit --family double-sided --json --scene orbit.json").with(0, &[]);
        assert_eq!(by_answer.out, by_flags.out, "{model}");
        let solutions = &written(&by_flags.out)["solutions"];
        let Some(first) = solutions.get(0) else { continue };
        orbits += 1;
        let near = dir.run("orbit --json --scene orbit.json");
        if near.code != Some(0) {
            // At an orbit that is all but degenerate Newton's method says so.
            assert!(near.err.contains("--near"), "{near:?}");
            continue;
        }
        let near = &written(&near.out)["solutions"][0];
        for (one, other) in first["impacts"].as_array().unwrap().iter().zip(near["impacts"].as_array().unwrap()) {
            let [one, other] = [one, other].map(|impact| impact["impulse"].as_f64().unwrap());
            let error = first["condition"]["impulse_error"].as_f64().unwrap();
            assert!((one - other).abs() <= 1e-12_f64.max(4.0 * error), "{one} {other}: {model}");
            again += 1;
        }
    }
    assert!(orbits >= 12 && again >= 20, "{orbits} {again}");
}

#[test]
fn flags_change_a_scene_and_give_what_it_sweeps() {
    let dir = TestDir::with_scene(SCENE);
    let point = "--omega 1.5 --gamma2 .1 --family double-sided";
    let scene = dir.run(&format!("orbit --scene scene.toml {point} --json")).with(0, &[]);
    assert_eq!(scene.err, "");
    let flags = format!("orbit --sites 11 --gamma1 .2 --asymmetry .4 {point} --threshold 0.5 --json");
    assert_eq!(scene.out, dir.run(&flags).out);

    let changed = dir.run(&format!("orbit --scene scene.toml {point} --sites 7 --asymmetry .4 --gamma1 .25 --json"));
    assert_eq!(changed.err, "scene.toml with sites = 7 (there 11), gamma1 = 0.25 (there 0.2)\n");
    let flags = format!("orbit --sites 7 --gamma1 .25 --asymmetry .4 {point} --threshold 0.5 --json");
    assert_eq!(changed.out, dir.run(&flags).out);
    let quiet = dir.run(&format!("--quiet orbit --scene scene.toml {point} --sites 7 --json"));
    assert_eq!((quiet.code, quiet.err.as_str()), (Some(0), ""));

    for (flags, told) in [
        ("--omega 1.5 --family double-sided", "gamma2 is swept by scene.toml, from 0 to 0.3: give --gamma2"),
        ("--omega 1.5 --gamma2 .1", "scene.toml has double-sided, single-sided: say which by --family"),
        ("--omega 1.5 --gamma2 .1 --family double-sided --amplitude .1", "restitution is missing"),
        ("--omega 1.5 --gamma2 .1 --family double-sided --gamma3 .1", "--gamma3 couples layers"),
        ("--omega 1.5 --gamma2 .1 --family double-sided --layers 2", "gamma3 is missing"),
        ("--omega -.5 --gamma2 .1 --family double-sided", "omega = -0.5 is out of range"),
        (
            "--omega 1.5 --gamma2 .1 --family double-sided --layers 2000000 --gamma3 .1",
            "layers = 2000000 is out of range",
        ),
    ] {
        let ran = dir.run(&format!("orbit --scene scene.toml {flags}")).with(2, &[told]);
        assert_eq!(ran.out, "");
    }
    dir.run("orbit --scene no.toml --omega 1.5").with(2, &["cannot read scene no.toml"]);
    dir.run("orbit --family double-sided").with(2, &["--sites <M>", "--scene <FILE>"]);
    // One that is written where it is read from.
    let line = format!("orbit --scene scene.toml {point} --multipliers scene.toml");
    dir.run(&line).with(2, &["--scene and --multipliers"]);
}

#[test]
fn a_scene_says_which_breathers_and_how_far() {
    let dir = TestDir::with_scene(&SCENE.replace(r#"["double-sided", "single-sided"]"#, r#"["0+2-,0-2+"]"#));
    let word = dir.run("orbit --scene scene.toml --omega 1.5 --gamma2 .05 --json").with(0, &[]);
    assert_eq!(written(&word.out)["solutions"][0]["word"], "0+2-,0-2+");

    let dir = TestDir::with_scene(&SCENE.replace(r#", "single-sided"]"#, "]"));
    let start = "--scene scene.toml --omega 1.5 --gamma2 .1";
    let found = dir.run(&format!("locate --event grazing --free omega {start} --json")).with(0, &[]);
    assert_eq!(written(&found.out)["range"], serde_json::json!([0.9, 2.5]));
    let found = dir.run(&format!("locate --event grazing --free omega --to 2 {start} --json")).with(0, &[]);
    assert_eq!(written(&found.out)["range"], serde_json::json!([0.9, 2.0]));
    let curve = dir.run(&format!("curve --event grazing --free omega --and gamma2 {start} --tolerance 1e-3 --json"));
    let curve = written(&curve.with(0, &[]).out);
    assert_eq!((&curve["from"], &curve["to"]), (&serde_json::json!([0.9, 0.0]), &serde_json::json!([2.5, 0.3])));
    // A manifest is as good as its scene.
    dir.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
    let line = |file: &str| {
        dir.run(&format!("branch --scene {file} --omega 1.5 --gamma2 .1 --free omega --events grazing,fold --json"))
    };
    let [scene, manifest] = ["scene.toml", "map.manifest.json"].map(line);
    assert_eq!((scene.code, &scene.out), (Some(0), &manifest.out));
    dir.run("sweep map.json --out map.csv").with(2, &["map.json"]);
}

#[test]
fn a_point_without_a_breather_is_exit_code_three() {
    let dir = TestDir::new();
    // A cosine that does not pay for the losses.
    let model = "--family double-sided --sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --amplitude 0 --restitution .5";
    for line in ["simulate", "locate --event fold --free omega", "branch --free omega"] {
        dir.run(&format!("{line} {model}")).with(3, &["no orbit to start from"]);
    }
    // That there is none is what `orbit` was asked.
    let none = dir.run(&format!("orbit --json {model}")).with(0, &[]);
    assert!(written(&none.out)["solutions"].as_array().unwrap().is_empty());
}

/// A file that is data has no lines that anybody has seen: what is wrong is told by its key.
#[test]
fn what_is_wrong_in_json_is_told_by_its_key() {
    let dir = TestDir::new();
    let with = |key: &str, value: &str| {
        format!(r#"{{"model":{{"sites":5,"gamma1":0.2,"gamma2":0.1,"omega":1.5,"asymmetry":0.4,"{key}":{value}}}}}"#)
    };
    for (key, value, told) in [
        ("gamma1", r#""x""#, "model.json: gamma1 = \"x\" is not a number: give one such as 0.2 or 1e-3"),
        ("sites", "5.5", "model.json: sites = 5.5 is not a whole number"),
        ("ends", "3", "model.json: ends = 3 is not a text in quotes"),
        ("force", "[{\"harmonic\":1.5,\"amplitude\":1}]", "model.json: harmonic = 1.5 is not a whole number"),
        ("gama1", "1", "model.json: unknown key `gama1`: did you mean `gamma1`?"),
        ("layers", "-1", "model.json: layers = -1 is out of range"),
    ] {
        fs::write(dir.path("model.json"), with(key, value)).unwrap();
        dir.run("orbit --family double-sided --scene model.json").with(2, &[told]);
    }
    // What is null is not given.
    fs::write(dir.path("model.json"), with("restitution", "null")).unwrap();
    let ran = dir.run("orbit --family double-sided --scene model.json").with(0, &[]);
    assert!(ran.out.contains("restitution = 1\n"), "{}", ran.out);
}

/// A name that is nearly that of a file, or of one in a folder beside; and a file that is of another program.
#[test]
fn the_file_that_was_meant_is_named() {
    let dir = TestDir::with_scene(SCENE);
    fs::create_dir(dir.path("scenes")).unwrap();
    fs::write(dir.path("scenes/ring.toml"), SCENE).unwrap();
    let other = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/figures/figure-1.toml")).unwrap();
    fs::write(dir.path("figure-1.toml"), other).unwrap();
    for (line, told) in [
        ("orbit --scene scne.toml", "did you mean scene.toml?"),
        ("sweep scene/ring.tml --out map.csv", "did you mean scenes/ring.toml?"),
        ("orbit --scene ring.toml", "did you mean scenes/ring.toml?"),
        ("fate figure-1.toml --out fates.csv", "figure-1.toml: it sets a figure of the paper, which `studies figures"),
    ] {
        dir.run(line).with(2, &[told]);
    }
    let told = dir.run("orbit --scene nothing.toml").with(2, &["cannot read"]).err.clone();
    assert!(!told.contains("did you mean"), "{told}");
}

/// docs/figures.md says so of each: the model of a figure's scene is as good as any, whatever else the scene holds.
#[test]
fn the_breather_of_every_figure_of_the_paper_is_found_by_its_scene() {
    let dir = TestDir::new();
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/figures");
    let mut counts = [0; 2];
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let (name, text) = (path.file_name().unwrap().to_str().unwrap(), fs::read_to_string(&path).unwrap());
        fs::copy(&path, dir.path(name)).unwrap();
        let of_map = text.contains("[sweep]");
        let which = if of_map { " --family double-sided --omega 1.5 --gamma2 .1" } else { "" };
        let ran = dir.run(&format!("orbit --scene {name}{which} --json")).with(0, &[]);
        let found = written(&ran.out);
        let physical = |orbit: &Value| orbit["physical"] == true;
        assert!(found["solutions"].as_array().unwrap().iter().any(physical), "{name}");
        if !of_map {
            let family = text.split("family = \"").nth(1).unwrap().split('"').next().unwrap();
            let told = dir.run(&format!("orbit --scene {name}")).out;
            assert!(told.starts_with(family), "{name}: {told}");
            dir.run(&format!("simulate --scene {name} --periods 2")).with(0, &[]);
        }
        counts[usize::from(of_map)] += 1;
    }
    assert!(counts[0] >= 12 && counts[1] >= 6, "{counts:?}");
    let branch = "branch --scene figure-4.toml --free omega --from .9 --to .93 --events fold";
    dir.run(branch).with(0, &[]);
    // What else is wrong in it is told as of any scene.
    fs::write(dir.path("other.toml"), "gama1 = 1\n[figure]\nfamily = \"double-sided\"\n[model]\nsites = 3\n").unwrap();
    dir.run("orbit --scene other.toml").with(2, &["other.toml:1:1: unknown key `gama1`"]);
}

/// What people call it: the key that says it, or that it cannot be said, whether it is a key, a flag or a number that varies.
#[test]
fn people_s_words_are_answered_by_how_that_is_said() {
    let structure = "omega = 1\nword = \"0+\"\nTOP\n[structure]\nmasses = [1]\nstiffness = [[1]]\nSTRUCTURE\n[[contact]]\nat = 0\nupper = 1\nCONTACT\n";
    let dir = TestDir::new();
    let words = [
        ("gravity", "`static = [...]` in [force]"),
        ("weight", "`static = [...]` in [force]"),
        ("preload", "`static = [...]` in [force]"),
        ("gap", "`lower` and `upper` of [[contact]]"),
        ("clearance", "`lower` and `upper` of [[contact]]"),
        ("base", "minus each mass times the amplitude"),
        ("frequency", "is `omega`"),
        ("zeta", "`ratios` beside `frequencies`"),
        ("friction", "friction cannot be said"),
        ("noise", "noise cannot be said"),
    ];
    let mut answered = 0;
    for (word, said) in words {
        for place in ["TOP", "STRUCTURE", "CONTACT"] {
            let text = structure.replace(place, &format!("{word} = 1"));
            let text = ["TOP", "STRUCTURE", "CONTACT"].iter().fold(text, |text, other| text.replace(other, ""));
            fs::write(dir.path("scene.toml"), text).unwrap();
            let ran =
                dir.run("orbit --scene scene.toml").with(2, &[&format!("unknown key `{word}`"), "known here are"]);
            // One of these is a slip for a key that is there.
            assert!(ran.err.contains(said) || (word, place) == ("weight", "CONTACT"), "{place}: {ran:?}");
            answered += 1;
        }
        let model = format!("[model]\nsites = 3\ngamma1 = .2\ngamma2 = .1\nomega = 1.5\nasymmetry = .4\n{word} = 1\n");
        fs::write(dir.path("chain.toml"), model.replace(" .", " 0.")).unwrap();
        dir.run("orbit --family double-sided --scene chain.toml").with(2, &[&format!("unknown key `{word}`"), said]);
        dir.run(&format!("orbit --family double-sided --{word} 1")).with(2, &[said]);
        fs::write(dir.path("scene.toml"), structure.replace("TOP", "").replace("STRUCTURE", "").replace("CONTACT", ""))
            .unwrap();
        for line in [
            format!("branch --scene scene.toml --free {word} --from 0 --to 1"),
            format!("orbit --scene scene.toml --set {word}=1"),
            format!(
                "branch --family double-sided --sites 3 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --free {word}"
            ),
        ] {
            let told = dir.run(&line).with(2, &[&format!("`{word}` is no "), said]).err.clone();
            // Numbers of the model that is asked about.
            assert_eq!(told.contains("contact.N.upper"), line.contains("scene.toml"), "{told}");
        }
    }
    assert_eq!(answered, 30);
    let limits = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/limits.md")).unwrap();
    for named in ["friction", "gives way", "noise", "rests on a stop", "Every coordinate has a mass", "symmetric"] {
        assert!(limits.contains(named), "{named}");
    }
}

/// --set beside a scene that is none: what is wrong with the file is told, not that there is none.
#[test]
fn numbers_that_are_set_do_not_hide_what_is_wrong_with_the_scene() {
    let dir = TestDir::with_scene(SCENE);
    fs::write(dir.path("broken.toml"), "omega = 1\n[structure]\nmasses = [1\n").unwrap();
    for flags in ["--set load=2", "--damping .1"] {
        dir.run(&format!("orbit --word 0+ --scene none.toml {flags}")).with(2, &["cannot read scene none.toml"]);
        let told =
            dir.run(&format!("orbit --word 0+ --scene broken.toml {flags}")).with(2, &["broken.toml:"]).err.clone();
        assert!(!told.contains("[structure]"), "{told}");
    }
    dir.run("orbit --word 0+ --scene scene.toml --set load=2").with(2, &["scene.toml holds a chain", "--gamma1"]);
    dir.run("orbit --word 0+ --sites 1 --gamma1 1 --gamma2 0 --omega 1 --asymmetry 0 --set load=2")
        .with(2, &["give --scene with [structure]"]);
}

//! Impact words on the command line and in scenes.

use std::fs;

use serde_json::Value;
use vibrochain_breather::{Finder, OrbitList, Scope, Word};
use vibrochain_floquet::{Tolerance, stability};
use vibrochain_maps::scene::Scene;
use vibrochain_testkit::{TestDir, words, written};

const MODEL: &str = "--sites 21 --gamma1 0.2 --gamma2 0.05 --omega 1.5 --asymmetry 0.2";
const FORCED: &str = "--sites 13 --gamma1 0.2 --omega 1.5 --asymmetry 0.1 --amplitude 0.3 --restitution 0.9";

fn orbit(dir: &TestDir, line: &str) -> Value {
    written(&dir.run(&format!("orbit {line} --json")).with(0, &[]).out)
}

#[test]
fn checked_words_are_printed_with_their_numbers() {
    let dir = TestDir::new();
    let (mut checked, mut lattices) = (0, 0);
    for case in words() {
        let (model, word) = (&case.model, case.word.parse::<Word>().unwrap());
        let (chain, layout) = (model.chain(), model.chain().layout());
        // In other families' names and places the numbers are the same, but not the list of impacts.
        let family = chain.is_ring() && word.family().is_some();
        if family || word.canonical(model) != word || !model.is_conservative() {
            continue;
        }
        let mut flags = format!(
            "--sites {} --gamma1 {} --gamma2 {} --omega {} --asymmetry {}",
            chain.length(),
            chain.gamma1(),
            chain.gamma2(),
            model.omega(),
            model.asymmetry()
        );
        if !chain.is_ring() {
            flags += &format!(" --ends {}", chain.ends());
            lattices += 1;
        }
        if chain.layers() > 1 {
            let (layers, gamma3, ends) = (chain.layers(), chain.gamma3(), chain.layer_ends());
            flags += &format!(" --layers {layers} --gamma3 {gamma3} --layer-ends {ends}");
        }
        let answer = orbit(&dir, &format!("--word {word} {flags}"));
        let solution = &answer["solutions"][0];
        assert_eq!(solution["word"], case.word);
        let proof = answer["completeness"]["by"].as_str().unwrap();
        assert!(answer["completeness"]["established"] == true && ["closed-form", "enclosures"].contains(&proof));
        assert_eq!(solution["physical"], case.physical.unwrap(), "{word}");
        for impact in solution["impacts"].as_array().unwrap() {
            let same = |hit: &&vibrochain_breather::Hit| {
                let (site, layer) = layout.place(hit.site);
                let of_layer = chain.layers() == 1 && impact["layer"].is_null() || impact["layer"] == layer;
                impact["site"] == site && of_layer && impact["barrier"] == hit.barrier.name()
            };
            let impulse = case.hits.iter().find(same).unwrap().impulse;
            assert!((impact["impulse"].as_f64().unwrap() - impulse).abs() < 1e-12, "{word}");
        }
        let radius = solution["stability"]["spectral_radius"].as_f64().unwrap();
        assert!((radius - case.spectral_radius).abs() < 1e-6 * radius, "{word}: {radius}");
        checked += 1;
    }
    assert!(checked >= 40 && lattices >= 19, "{checked} {lattices}");
}

#[test]
fn the_breathers_that_drift_apart_are_named() {
    let dir = TestDir::new();
    let told = dir.run(&format!("orbit --word 0+2+4+,0-2-4- {MODEL}")).with(0, &[]).out;
    assert!(
        told.contains("the breathers drift apart: ahead are site 0 by -0.499, site 2 by 1.000, site 4 by -0.499"),
        "{told}"
    );
    let ahead = &orbit(&dir, &format!("--word 0+2+4+,0-2-4- {MODEL}"))["solutions"][0]["phases"];
    assert_eq!((&ahead[1]["site"], &ahead[1]["ahead"], &ahead[1]["layer"]), (&2.into(), &1.0.into(), &Value::Null));
    assert!(orbit(&dir, &format!("--word 0+3+,0-3- {MODEL}"))["solutions"][0]["phases"].is_null());
}

#[test]
fn words_are_shown_as_their_canonical_selves_and_families_by_any_name() {
    let dir = TestDir::new();
    let mirrored = dir.run(&format!("orbit --word 5-8-,5+8+ {MODEL}")).with(0, &["5-8-,5+8+ is the word 0+3+,0-3-"]);
    assert_eq!(mirrored.out, dir.run(&format!("orbit --word 0+3+,0-3- {MODEL}")).with(0, &[]).out);
    let (family, word) = ("orbit --family double-sided", "orbit --word 7-,7+");
    let family = dir.run(&format!("{family} {MODEL}")).with(0, &[]).out;
    let word = dir.run(&format!("{word} {MODEL}")).with(0, &["7-,7+ is the word 0+,0-"]).out;
    assert_eq!(family.lines().skip(1).collect::<Vec<_>>(), word.lines().skip(1).collect::<Vec<_>>());
    let spaced = dir.command(&format!("orbit {MODEL} --word")).arg("0+3+ 0-3-").output().unwrap();
    assert!(spaced.status.success());
}

#[test]
fn words_that_cannot_be_are_refused_by_name() {
    let dir = TestDir::new();
    let long = "0+,".repeat(64) + "0-";
    for (word, part) in [
        ("0+25-", "site 25 does not exist: this chain has the sites 0 to 20"),
        ("0+0-", "site 0 cannot be on both barriers at one instant"),
        ("0+,,0-", "instant 2 of the word has no impact"),
        ("up", "`up` is not an impact"),
        ("0:1+", "layer 1 does not exist: this lattice has the layers 0 to 0"),
        (&long, "65 impacts are too many"),
    ] {
        for command in ["orbit", "simulate", "locate --event fold --free omega"] {
            let _ = dir.run(&format!("{command} --word {word} {MODEL}")).with(2, &[part]);
        }
    }
    let _ = dir.run(&format!("orbit {MODEL}")).with(2, &["--word"]);
    let _ = dir.run(&format!("orbit --word 0+3+ --family single-sided {MODEL}")).with(2, &["cannot be used with"]);
}

/// Where no matrix fits multipliers are counted; where that would take too long, too, the ring is too large.
#[test]
fn words_on_large_rings_have_a_verdict_or_say_why_not() {
    let dir = TestDir::new();
    let model = "--gamma1 0.2 --gamma2 0.05 --omega 1.5 --asymmetry 0.2";
    let small = orbit(&dir, &format!("--sites 101 {model} --word 0+2+3+,0-2-3-"));
    let large = orbit(&dir, &format!("--sites 801 {model} --word 0+2+3+,0-2-3-"));
    let [small, large] = [small, large].map(|answer| answer["solutions"][0]["stability"].clone());
    assert_eq!((&large["stable"], &large["mechanism"]), (&small["stable"], &small["mechanism"]));
    let radius = |stability: &Value| stability["spectral_radius"].as_f64().unwrap();
    assert!((radius(&large) - radius(&small)).abs() < 1e-9 && radius(&large) > 1.1, "{large}");
    assert!(large["multipliers"].as_array().unwrap().len() == 1602 && large["method"] == "secular", "{large}");
    assert_eq!(small["multipliers"].as_array().unwrap().len(), 202);
    let line = format!("orbit --sites 100001 {model} --word 0+2+3+,0-2-3-");
    dir.run(&line).with(1, &["6 impacts a period", "up to 2000 masses", "this one has 100001"]);
}

#[test]
fn an_orbit_of_a_file_is_found_again_elsewhere() {
    let dir = TestDir::new();
    let first = dir.run(&format!("orbit --word 0+4+,0-4- --gamma2 0.02 {FORCED} --json")).with(0, &[]).out;
    fs::write(dir.path("orbit.json"), first).unwrap();
    let near = orbit(&dir, &format!("--near orbit.json --gamma2 0.021 {FORCED}"));
    let direct = orbit(&dir, &format!("--word 0+4+,0-4- --gamma2 0.021 {FORCED}"));
    assert_eq!(near["completeness"]["established"], false);
    assert_eq!(near["solutions"].as_array().unwrap().len(), 1);
    for key in ["impulse", "velocity_before"] {
        let value = |answer: &Value| answer["solutions"][0]["impacts"][2][key].as_f64().unwrap();
        assert!((value(&near) - value(&direct)).abs() < 1e-12);
    }
    // A simulation from it stays on it; no other parameter leads astray unnoticed.
    let run = dir.run(&format!("simulate --near orbit.json --gamma2 0.02 {FORCED} --periods 5")).with(0, &[]);
    let distance = run.out.lines().find(|line| line.starts_with("largest distance")).unwrap();
    assert!(distance.rsplit(' ').next().unwrap().parse::<f64>().unwrap() < 1e-11, "{distance}");
    // The table of a run of one orbit leads to it.
    dir.run(&format!("simulate --near orbit.json --gamma2 0.02 {FORCED} --periods 5 --impacts run.csv")).with(0, &[]);
    let table = orbit(&dir, &format!("--near run.csv --gamma2 0.021 {FORCED}"));
    let sum = |answer: &Value| {
        let impacts = answer["solutions"][0]["impacts"].as_array().unwrap();
        impacts.iter().map(|impact| impact["impulse"].as_f64().unwrap().abs()).sum::<f64>()
    };
    assert!((sum(&table) - sum(&direct)).abs() < 1e-11, "{table}");
    // Losses that no force makes good: nothing is near.
    let lossy = FORCED.replace(" --amplitude 0.3", "");
    let _ = dir.run(&format!("orbit --near orbit.json --gamma2 0.02 {lossy}")).with(1, &["--near", "no orbit found"]);
    fs::write(dir.path("bad.json"), "{\"impacts\":[{\"site\":0,\"barrier\":\"top\",\"time\":0,\"impulse\":1}]}")
        .unwrap();
    let _ = dir.run(&format!("orbit --near bad.json --gamma2 0.02 {FORCED}")).with(2, &["`top` is no barrier"]);
}

const SCENE: &str = "[model]\nsites = 9\ngamma1 = 0.2\nasymmetry = 0.2\n[sweep]\n\
    x = { parameter = \"omega\", from = 0.7, to = 1.9, points = 25 }\n\
    y = { parameter = \"gamma2\", from = 0.01, to = 0.3, points = 12 }\n\
    [compute]\nfamilies = [\"4-1-,4+1+\", \"0+3-,0-3+\"]\nstability = true\n";

/// Every cell is what the library says of the words one by one.
#[test]
fn words_are_families_of_a_scene() {
    let dir = TestDir::with_scene(SCENE);
    let _ = dir.run("sweep scene.toml --out map.csv --png map.png -q").with(0, &[]);
    let table = fs::read_to_string(dir.path("map.csv")).unwrap();
    let scene = Scene::read(&dir.path("scene.toml")).unwrap();
    assert_eq!(scene.task.family_names().collect::<Vec<_>>(), ["0+3+,0-3-", "0+3-,0-3+"]);
    let (mut finder, mut found) = (Finder::new(9), OrbitList::default());
    let mut seen = std::collections::BTreeMap::new();
    for (cell, line) in table.lines().skip(1).enumerate() {
        let model = scene.point(cell as u64).model().unwrap();
        let fields: Vec<&str> = line.split(',').collect();
        let mut verdicts = Vec::new();
        for word in &scene.task.words {
            if finder.find_word(&model, word, Scope::All, &mut found).is_err() {
                continue;
            }
            for orbit in &found.orbits {
                if finder.admissibility(orbit).unwrap().is_physical() {
                    verdicts.push(stability(orbit, Tolerance::Rounding).unwrap().verdict);
                }
            }
        }
        let class = match verdicts.iter().map(|verdict| verdict.stable).max() {
            None => "none",
            Some(true) => "stable-word",
            Some(false) => "unstable-word",
        };
        if verdicts.iter().all(|verdict| !verdict.undecided) {
            assert_eq!((fields[2], fields[6]), (class, verdicts.len().to_string().as_str()), "{line}");
            *seen.entry(class).or_insert(0) += 1;
        }
    }
    assert!(seen.len() == 3 && seen.values().all(|&count| count >= 10), "{seen:?}");
    // A manifest is a scene, with words as well.
    let _ = dir.run("sweep map.manifest.json --out again.csv -q").with(0, &[]);
    assert_eq!(fs::read_to_string(dir.path("again.csv")).unwrap(), table);
}

#[test]
fn wrong_words_of_a_scene_are_pointed_at() {
    let dir = TestDir::new();
    for (families, parts) in [
        ("\"0+9+\"", ["scene.toml:9:", "site 9 does not exist"]),
        ("\"0+3+\", \"3+0+\"", ["scene.toml:9:", "given twice"]),
        ("\"0+,3+,5+\"", ["scene.toml:9:", "one or two instants"]),
        ("\"0-,0-\"", ["scene.toml:9:", "period-doubled orbits have no class"]),
        ("\"single\"", ["scene.toml:9:", "`single` is not a family"]),
    ] {
        dir.scene(&SCENE.replace("\"4-1-,4+1+\", \"0+3-,0-3+\"", families));
        let _ = dir.run("sweep scene.toml --out map.csv").with(2, &parts);
    }
}

#[test]
fn all_words_of_a_few_sites_are_listed_with_their_fate() {
    let dir = TestDir::new();
    let pairs = dir.run(&format!("words --sites-used 2 --reach 4 {MODEL} --csv pairs.csv")).with(0, &[]);
    assert!(pairs.out.contains("24 words up to symmetry: 24 orbits, 8 physical, 4 stable"), "{}", pairs.out);
    // Here those of both barriers are not physical, and others are: a list of "every word" holds both.
    let low = "words --sites-used 2 --reach 6 --sites 12 --gamma1 .2 --gamma2 .03 --omega .7 --asymmetry .4";
    let told = |families: &str| dir.run(&format!("{low}{families}")).with(0, &[]).out;
    assert!(told("").contains(" 12 physical, 6 stable") && told("") == told(" --families either"));
    assert!(told(" --families double-sided").contains(" 0 physical, 0 stable"));
    let table = fs::read_to_string(dir.path("pairs.csv")).unwrap();
    let mut checked = 0;
    for case in words() {
        let model = &case.model;
        let same = model.chain().gamma2() == 0.05 && model.omega() == 1.5 && model.asymmetry() == 0.2;
        let line = table.lines().find(|line| line.starts_with(&format!("\"{}\",", case.word)));
        let (true, Some(line)) = (same, line) else { continue };
        let fields: Vec<&str> = line.rsplit(',').collect();
        let radius: f64 = fields[1].parse().unwrap();
        assert!((radius - case.spectral_radius).abs() < 1e-6 * radius, "{line}");
        checked += 1;
    }
    assert!(checked >= 4, "{checked}");
    // Neighbours in the field of a breather follow the sign of its tail, which alternates above the band.
    for distance in 1..=4 {
        let (stable, unstable) = if distance % 2 == 1 { ('+', '-') } else { ('-', '+') };
        for (sign, fate) in [(stable, "stable"), (unstable, "unstable")] {
            let line = pairs.out.lines().find(|line| line.starts_with(&format!("0+{distance}{sign},"))).unwrap();
            assert!(line.contains(&format!(", {fate}")), "{line}");
        }
    }
    for (line, part) in [
        ("--sites-used 2 --reach 21", "--reach 21 is out of range"),
        ("--sites-used 6 --reach 4", "--sites-used 6 is out of range"),
        ("--sites-used 0 --reach 4", "--sites-used 0 is out of range"),
        ("--sites-used 9 --reach 20", "more than 100000 words"),
    ] {
        let _ = dir.run(&format!("words {line} {MODEL}")).with(2, &[part]);
    }
    let all = dir.run(&format!("words --sites-used 2 --reach 2 --families single-sided --all {MODEL}")).with(0, &[]);
    assert!(all.out.contains("not physical: ") && all.out.contains("0-,1-"), "{}", all.out);
}

/// Where a word stops being physical: just below it is, just above it is not, and the message is that of the orbit there.
#[test]
fn words_are_followed_from_masses_without_coupling_to_their_end() {
    let dir = TestDir::new();
    let line = "words --sites-used 2 --reach 2 --families double-sided,single-sided --from-zero --sites 9 --gamma1 0.2 \
        --gamma2 0.4 --omega 1.1 --asymmetry 0.4";
    let out = dir.run(&line.split_whitespace().collect::<Vec<_>>().join(" ")).with(0, &[]).out;
    let mut checked = 0;
    for line in out.lines().filter(|line| line.contains("physical up to gamma2 = 0.") && line.contains(':')) {
        let word: Word = line.split_whitespace().next().unwrap().parse().unwrap();
        let end: f64 = line.split("gamma2 = ").nth(1).unwrap().split(':').next().unwrap().parse().unwrap();
        let physical = |gamma2: f64| {
            let chain = vibrochain_lattice::Chain::new(9, 0.2, gamma2).unwrap();
            let model = vibrochain_lattice::Model::conservative(chain, 1.1, 0.4).unwrap();
            let (mut finder, mut found) = (Finder::new(9), OrbitList::default());
            finder.find_word(&model, &word, Scope::All, &mut found).unwrap();
            finder.admissibility(&found.orbits[0]).unwrap().is_physical()
        };
        assert!(physical(end * (1.0 - 1e-9)) && !physical(end * (1.0 + 1e-9)), "{line}");
        checked += 1;
    }
    assert!(checked >= 4, "{out}");
    let _ = dir
        .run(&format!("words --sites-used 2 --reach 2 --gamma2 0.02 {FORCED} --from-zero"))
        .with(2, &["--from-zero"]);
}

/// Words that masses of other frequencies, or of other periods of the force, make.
#[test]
fn words_of_many_instants_and_of_several_periods_of_the_force() {
    let dir = TestDir::new();
    let told = orbit(&dir, &format!("--word 0+3+,3-,0-3+,3- {MODEL}"));
    assert_eq!((&told["completeness"]["by"], &told["completeness"]["starts"]), (&"followed".into(), &1.into()));
    let solution = &told["solutions"][0];
    assert_eq!(
        (&solution["word"], &solution["physical"], solution["impacts"].as_array().unwrap().len()),
        (&"0+3+,0-,0+3-,0-".into(), &true.into(), 6)
    );
    assert!(solution["residual"].as_f64().unwrap() < 1e-13);
    // What it prints is an orbit to start near.
    let printed = dir.run(&format!("orbit --word 0+3+,3-,0-3+,3- {MODEL} --json")).with(0, &[]).out;
    fs::write(dir.path("two.json"), printed).unwrap();
    let near = orbit(&dir, &format!("--near two.json {MODEL}"));
    assert_eq!(near["solutions"][0]["word"], solution["word"]);
    let forced = "--sites 9 --gamma1 0.2 --gamma2 0.01 --omega 1.07 --asymmetry 0.6 --amplitude 0.3 --restitution 0.9";
    let doubled = orbit(&dir, &format!("--word 0-,3-,0-,3- --force-periods 2 {forced}"));
    let solutions = doubled["solutions"].as_array().unwrap();
    assert!(solutions.len() >= 2, "{doubled}");
    let period = 2.0 * std::f64::consts::TAU / 1.07;
    for solution in solutions {
        assert!((solution["period"].as_f64().unwrap() - period).abs() < 1e-12);
        assert_eq!(solution["physical"], true);
    }
    // The doubled family by its own name.
    let family = dir.run(&format!("orbit --word 0-,0- --force-periods 2 {forced}")).with(0, &[]).out;
    let word = dir.run(&format!("orbit --word 0-,0- {forced}")).with(0, &[]).out;
    assert_eq!(family.lines().skip(1).collect::<Vec<_>>(), word.lines().skip(1).collect::<Vec<_>>());
    let _ = dir.run(&format!("orbit --word 0-,3- --force-periods 2 {MODEL}")).with(2, &["--force-periods", "omega/N"]);
    for count in ["0", "65", "-1", "two"] {
        let _ = dir.run(&format!("orbit --word 0-,3- --force-periods {count} {forced}")).with(2, &["--force-periods"]);
    }
    let _ = dir.run(&format!("orbit --family single-sided --force-periods 2 {forced}")).with(2, &["--word"]);
    // What nothing determines is said, with what to do.
    let centred = MODEL.replace("--asymmetry 0.2", "--asymmetry 0");
    let none = dir.run(&format!("orbit --word 0+3+,3-,0-3+,3- {centred}")).with(3, &["is not known"]).out;
    assert!(none.contains("share no harmonic") && none.contains("nearby"), "{none}");
    let uncoupled = MODEL.replace("--gamma2 0.05", "--gamma2 0");
    let none = dir.run(&format!("orbit --word 0+,3+,0-,3- {uncoupled}")).with(3, &["is not known"]).out;
    assert!(none.contains("whenever they like"), "{none}");
}

/// Two impacts on one barrier: without a force a word of one period like others, which `--near` finds again; under one in a period of it,
/// if it is asked for, or doubled.
#[test]
fn two_impacts_on_one_barrier_are_found_and_found_again() {
    let dir = TestDir::new();
    let free = "--sites 5 --gamma1 .4 --gamma2 .42 --omega .343 --asymmetry .2";
    let listed = orbit(&dir, &format!("--word 0-,0- {free}"));
    assert_eq!(listed["completeness"]["established"], true);
    let solutions = listed["solutions"].as_array().unwrap();
    let physical = solutions.iter().find(|solution| solution["physical"] == true).unwrap();
    fs::write(dir.path("alike.json"), physical.to_string()).unwrap();
    let near = orbit(&dir, &format!("--near alike.json {free}"));
    for solution in [physical, &near["solutions"][0]] {
        assert!(solution["physical"] == true && solution["stability"]["stable"] == true, "{solution}");
        let second = &solution["impacts"][1];
        assert!((second["time"].as_f64().unwrap() - 6.801_142_509_463_48).abs() < 1e-12);
        assert!((second["impulse"].as_f64().unwrap() - 0.631_175_282_223_376_5).abs() < 1e-12);
    }
    let _ = dir.run(&format!("orbit --word 0-,0- --force-periods 2 {free}")).with(2, &["omega/N"]);
    let forced = "--sites 1 --gamma1 1 --gamma2 0 --omega .7 --asymmetry .95 --amplitude .1 --restitution .8";
    let one = orbit(&dir, &format!("--word 0-,0- --force-periods 1 {forced}"));
    let is_known =
        |solution: &&serde_json::Value| solution["physical"] == true && solution["stability"]["stable"] == true;
    let known = one["solutions"].as_array().unwrap().iter().find(is_known).unwrap();
    assert!((known["stability"]["spectral_radius"].as_f64().unwrap() - 0.784_290_4).abs() < 1e-6, "{known}");
    let period = |answer: &serde_json::Value| answer["solutions"][0]["period"].as_f64().unwrap();
    let doubled = orbit(&dir, &format!("--word 0-,0- {forced}"));
    assert!((period(&doubled) - 2.0 * period(&one)).abs() < 1e-12);
}

/// At a resonance with a mode that a word does not push the limit is told; one that it does push takes its impulses away.
#[test]
fn at_a_resonance_the_limit_is_told() {
    let dir = TestDir::new();
    // ω = 2Ω of the mode of a row of three that has a node in the middle: Ω² = 0.2 + 0.05.
    let row = "--sites 3 --ends free --gamma1 0.2 --gamma2 0.05 --asymmetry 0.2";
    let told =
        dir.run(&format!("orbit --word 1+,1- {row} --omega 0.5")).with(3, &["meets mode 1", "never push that mode"]);
    let limit: f64 = told.err.split("impulses ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    let beside = orbit(&dir, &format!("--word 1+,1- {row} --omega 0.5000000001"));
    let impulse = beside["solutions"][0]["impacts"][0]["impulse"].as_f64().unwrap();
    assert!((limit - impulse).abs() < 1e-6 && limit.abs() > 0.1, "{limit} {impulse}");
    // At the end of the row it is pushed.
    let pushed = dir.run(&format!("orbit --word 0+,0- {row} --omega 0.5")).with(3, &["meets mode 1"]);
    assert!(!pushed.err.contains("never push"), "{}", pushed.err);
}

#[test]
fn either_family_is_each_of_them() {
    let dir = TestDir::new();
    let words = |families: &str| {
        dir.run(&format!("words --sites-used 2 --reach 1 --families {families} {MODEL} --all")).with(0, &[]).out
    };
    assert_eq!(words("either"), words("double-sided,single-sided"));
    assert_ne!(words("either"), words("double-sided"));
}

#[test]
fn what_was_not_searched_is_not_none() {
    let dir = TestDir::new();
    // Three hits of one mass in a period of the force: no way is known to find them.
    let line = "orbit --word 0-,0-,0+,3- --sites 9 --gamma1 .2 --gamma2 .1 --omega .9 --asymmetry .2 --amplitude .3 --restitution .9";
    let ran = dir.run(line).with(3, &["this word cannot be searched for"]);
    assert!(ran.out.contains("not searched: ") && !ran.out.contains("none"), "{ran:?}");
    let answer = written(&dir.run(&format!("{line} --json")).with(3, &[]).out);
    assert_eq!(answer["completeness"]["established"], false);
    assert!(answer["solutions"].as_array().unwrap().is_empty());
}

#[test]
fn masses_of_layers_are_called_as_words_call_them() {
    let dir = TestDir::new();
    let line = "--word 0:0+0:1+,0:0-0:1- --sites 6 --layers 2 --gamma3 .05 --gamma1 .2 --gamma2 .05 --omega 1.5 --asymmetry .2";
    let text = dir.run(&format!("orbit {line}")).with(0, &[]).out;
    for site in ["0:0", "0:1"] {
        assert!(text.contains(&format!("impact of site {site} on the upper barrier at t = 0")), "{text}");
    }
    assert!(!text.contains("site 6"), "{text}");
    let blocked = line.replace("gamma2 .05", "gamma2 .6");
    let text = dir.run(&format!("orbit {blocked}")).with(0, &[]).out;
    assert!(!text.contains("site 6") && !text.contains("site 7"), "{text}");
}

#[test]
fn an_orbit_of_several_periods_needs_its_period() {
    let dir = TestDir::new();
    let near = |time: f64| {
        format!(
            r#"{{"impacts":[{{"site":0,"barrier":"upper","time":0,"impulse":-1.5}},{{"site":0,"barrier":"lower","time":{time},"impulse":1.5}}],"psi":0}}"#
        )
    };
    fs::write(dir.path("near.json"), near(6.3)).unwrap();
    dir.run(&format!("orbit --near near.json --gamma2 .02 {FORCED}"))
        .with(2, &["the key `period` is missing", "\"period\""]);
}

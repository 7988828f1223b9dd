//! Runs, and what is said of wrong, endless and interrupted ones.

use std::fs;
use std::path::Path;

use clap::CommandFactory;
use tempfile::TempDir;
use vibrochain_cli::args::{Cli, read};
use vibrochain_cli::common::console::Console;
use vibrochain_cli::program;
use vibrochain_lattice::Stop;

/// Exit code, standard output and standard error of a line, run in this process; `stopped` as if Ctrl-C had been pressed.
fn told(line: &str, stopped: bool) -> (u8, String, String) {
    let interrupt = move || Ok(Stop::when(move || stopped));
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let mut console = Console::new(&mut out, &mut err, &interrupt);
    let result = program::run(line.split_whitespace().map(Into::into), &mut console);
    let (code, message) = result.map_or_else(|error| (error.exit_code(), error.to_string()), |()| (0, String::new()));
    (code, String::from_utf8(out).unwrap(), String::from_utf8(err).unwrap() + &message)
}

fn run(line: &str) -> (u8, String, String) {
    told(line, false)
}

/// A folder with a state file.
fn dir(state: &str) -> (TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state.json");
    fs::write(&path, state).unwrap();
    (folder, path.display().to_string())
}

fn rows(path: &Path) -> Vec<Vec<String>> {
    let records = csv::Reader::from_path(path).unwrap().into_records();
    records.map(|record| record.unwrap().iter().map(str::to_owned).collect()).collect()
}

const POINT: &str = "--sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4";
const FIVE: &str = r#"{"displacement":[0.1,0,0,0,0],"velocity":[0.5,0,0,0,0]}"#;

#[test]
fn numbers_may_begin_with_a_point() {
    let (_folder, state) = dir(FIVE);
    let forced = format!("mapgen simulate --state {state} {POINT} --amplitude .3 --restitution .9 --psi");
    let (short, long) = (run(&format!("{forced} -.5")), run(&format!("{forced} -0.5")));
    assert!(short.0 == 0 && short == long && short != run(&format!("{forced} .5")), "{short:?}");
    let (code, _, message) =
        run("mapgen orbit --family double-sided --sites 5 --gamma1 -.25e1 --gamma2 .1 --omega 1 --asymmetry 0");
    assert!(code == 2 && message.contains("gamma1 = -2.5 is out of range"), "{message}");
}

/// Every flag that takes a number, of every command: what is wrong is said in words, with the flag and the value.
#[test]
fn no_wrong_number_is_answered_in_the_words_of_a_programming_language() {
    let mut checked = 0;
    for command in Cli::command().get_subcommands() {
        for argument in command.get_arguments().filter(|argument| argument.is_allow_negative_numbers_set()) {
            let flag = format!("--{}", argument.get_long().unwrap());
            for wrong in ["two", "1,5", "0x10", ""] {
                let line = ["mapgen", command.get_name(), &flag, wrong].map(Into::into);
                let message = read::<Cli>(line).unwrap_err().to_string();
                assert!(message.contains(&flag), "{message}");
                let rust = ["literal", "digit found", "i64", "u64", "f64", "usize"]
                    .iter()
                    .find(|word| message.contains(**word));
                assert!(rust.is_none(), "{flag} {wrong}: {message}");
                if !wrong.is_empty() {
                    assert!(message.contains("number: give one such as") && message.contains(wrong), "{message}");
                }
                checked += 1;
            }
        }
    }
    assert!(checked >= 4 * 30, "{checked}");
    let (_folder, state) = dir(r#"{"displacement":[0,"x",0,0,0],"velocity":[0,0,0,0,0]}"#);
    let (code, _, message) = run(&format!("mapgen simulate --state {state} {POINT}"));
    assert!(code == 2 && message.contains("string \"x\" is not a number at line 1 column"), "{message}");
}

/// clap wraps lines; a break of its own in the text is seen as a broken sentence.
#[test]
fn help_has_no_breaks_within_a_sentence() {
    let mut checked = 0;
    for command in Cli::command().get_subcommands().chain([&Cli::command()]) {
        for text in [command.get_after_help(), command.get_long_about()].into_iter().flatten() {
            let text = text.to_string();
            let broken = text.lines().rev().skip(1).find(|line| !line.is_empty() && !line.ends_with('.'));
            assert!(broken.is_none(), "{}: {broken:?}", command.get_name());
            checked += 1;
        }
    }
    assert!(checked >= 4, "{checked}");
}

#[test]
fn without_a_start_all_ways_to_give_one_are_named() {
    let (code, _, message) = run(&format!("mapgen simulate {POINT}"));
    assert!(code == 2 && message.contains("--family <FAMILY>|--word <WORD>|--near <FILE>|--state <FILE>"), "{message}");
    let (code, _, message) = run(&format!("mapgen simulate {POINT} --family double-sided --state x.json"));
    assert!(code == 2 && message.contains("cannot be used with"), "{message}");
}

/// u = 2 sin t between barriers at ±1, e = 1/2: after the k-th impact v² is a quarter of before, and the spring gives it back
/// whole, so that v⁻ = √3/2^{k−1} on alternating sides.
#[test]
fn a_ring_without_force_may_lose_energy() {
    let (folder, state) = dir(r#"{"displacement":[0],"velocity":[2]}"#);
    let table = folder.path().join("impacts.csv");
    let line = format!(
        "mapgen simulate --state {state} --sites 1 --gamma1 1 --gamma2 0 --omega 1 --asymmetry 0 --restitution .5 --max-impacts 12 --impacts {}",
        table.display()
    );
    let (code, out, message) = run(&line);
    assert!(code == 0 && out.contains("number of impacts reached"), "{out}{message}");
    let events = rows(&table);
    assert_eq!(events.len(), 12);
    for (k, event) in events.iter().enumerate() {
        let (before, after): (f64, f64) = (event[3].parse().unwrap(), event[4].parse().unwrap());
        let expected = 3f64.sqrt() * 0.5f64.powi(k as i32) * if k % 2 == 0 { 1.0 } else { -1.0 };
        assert!((before / expected - 1.0).abs() < 1e-9 && after == -0.5 * before, "{k} {event:?}");
    }
    // Loss without a force leaves no breather: an answer, and no start.
    let lossy = format!("{POINT} --restitution .5");
    let (code, out, _) = run(&format!("mapgen orbit --family double-sided {lossy}"));
    assert!(code == 0 && out.contains("impacts lose energy"), "{out}");
    let (code, _, message) = run(&format!("mapgen simulate --family double-sided {lossy}"));
    assert!(code == 3 && message.contains("no orbit to start from: impacts lose energy"), "{message}");
}

#[test]
fn a_restitution_of_one_is_the_same_as_none() {
    for command in [
        "orbit --json --family double-sided",
        "orbit --family single-sided",
        "simulate --family double-sided --periods 3",
        "locate --family double-sided --event grazing --free omega --from 1.4 --to 1.6",
    ] {
        let (with, without) =
            (run(&format!("mapgen {command} {POINT} --restitution 1")), run(&format!("mapgen {command} {POINT}")));
        assert!(with.0 == 0 && with == without, "{command}: {with:?} {without:?}");
    }
    let folder = tempfile::tempdir().unwrap();
    let scene = |forcing: &str| {
        let text = format!(
            "[model]\nsites = 5\ngamma1 = 0.2\ngamma2 = 0.1\nasymmetry = 0.4\n{forcing}\n[sweep]\nx = {{ parameter = \"omega\", from = 0.8, to = 2.0, points = 7 }}\n[compute]\nfamilies = [\"double-sided\", \"single-sided\"]\nstability = true\n"
        );
        let (path, table) = (folder.path().join("scene.toml"), folder.path().join("map.csv"));
        fs::write(&path, text).unwrap();
        let (code, _, message) = run(&format!("mapgen sweep --quiet {} --out {}", path.display(), table.display()));
        (code, message, fs::read_to_string(table).unwrap_or_default())
    };
    let plain = scene("");
    assert!(plain.0 == 0 && plain.2.lines().count() == 8, "{plain:?}");
    assert_eq!(scene("forcing = { restitution = 1 }"), plain);
    assert!(scene("forcing = { restitution = 0.9 }").1.contains("amplitude is missing"));
}

/// A run that ends within a period ends there, to the bit where a longer one passes.
#[test]
fn periods_need_not_be_whole() {
    let (folder, state) = dir(FIVE);
    let table = |periods: &str, samples: u32| {
        let path = folder.path().join("trajectory.csv");
        let flags = format!("--restitution .7 --periods {periods} --samples {samples} --trajectory {}", path.display());
        let (code, out, message) = run(&format!("mapgen simulate --state {state} {POINT} {flags}"));
        assert!(code == 0, "{message}");
        (out, rows(&path))
    };
    let (_, whole) = table("3", 4);
    let (out, part) = table("2.5", 4);
    assert!(out.contains("\n2.500000 periods, "), "{out}");
    assert_eq!((whole.len(), part.len()), (13, 11));
    assert_eq!(whole[..11], part);
    // The end is a sample of its own if it is between two.
    let (_, odd) = table("0.3", 4);
    let period = std::f64::consts::TAU / 1.5;
    let times: Vec<f64> = odd.iter().map(|row| row[0].parse::<f64>().unwrap() / period).collect();
    assert!(times.len() == 3 && times.iter().zip([0.0, 0.25, 0.3]).all(|(t, at)| (t - at).abs() < 1e-15), "{times:?}");
    assert_eq!(table("0", 4).1.len(), 1);
    for wrong in ["-1", "nan", "inf", "1e300"] {
        let (code, _, message) = run(&format!("mapgen simulate --state {state} {POINT} --periods {wrong}"));
        assert!(code == 2 && message.contains("--periods") && message.contains("give"), "{wrong}: {message}");
    }
}

/// A point without an answer has an exit code of its own, whatever is asked about it.
#[test]
fn a_resonance_is_exit_code_three() {
    // 2ω on the uniform mode.
    let point = "--sites 5 --gamma1 .25 --gamma2 .1 --omega .25 --asymmetry .4 --family single-sided";
    for command in [
        format!("orbit {point}"),
        format!("orbit --json {point}"),
        format!("simulate {point}"),
        format!("locate --event fold --free gamma2 {point}"),
    ] {
        let (code, out, message) = run(&format!("mapgen {command}"));
        assert!(code == 3 && out.is_empty(), "{command}: {code} {out}{message}");
        assert!(message.contains("harmonic 2 of omega = 0.25 meets mode 0"), "{command}: {message}");
    }
}

#[test]
fn a_range_that_is_none_is_told_by_its_flags() {
    let line = format!("mapgen locate --event fold --free omega --family double-sided {POINT}");
    for (flags, expected) in [
        ("--from 1.2 --to 1.0", "--from 1.2 is not below --to 1: give a range around omega = 1.5"),
        ("--from 1.2 --to 1.2", "--from 1.2 is not below --to 1.2"),
        ("--from 1.6", "--from 1.6 is above omega = 1.5"),
        ("--to 1.4", "--to 1.4 is below omega = 1.5"),
        ("--from -.5", "--from: omega = -0.5 is out of range"),
    ] {
        let (code, _, message) = run(&format!("{line} {flags}"));
        assert!(code == 2 && message.contains(expected), "{flags}: {message}");
    }
}

/// More flights than a lifetime has are refused, with what would do; that much is then begun.
#[test]
fn a_run_without_end_is_refused_or_asked_for_by_impacts() {
    let (_folder, state) = dir(FIVE);
    for (gamma1, omega) in [("0.2", "1e-100"), ("1e30", "1.5"), ("1e100", "1e-100"), ("0", "1e-40")] {
        let line = format!(
            "mapgen simulate --state {state} --sites 5 --gamma1 {gamma1} --gamma2 .1 --omega {omega} --asymmetry .4"
        );
        let (code, out, message) = run(&line);
        assert!(code == 2 && out.is_empty() && message.contains("windows of flight"), "{code} {message}");
        let most = message.split("give at most ").nth(1).unwrap().split(',').next().unwrap();
        assert_eq!(told(&format!("{line} --periods {most}"), true).0, 130, "{message}");
        assert_eq!(told(&format!("{line} --max-impacts 5"), true).0, 130, "{message}");
    }
}

#[test]
fn an_interrupted_run_speaks_of_the_files_it_has() {
    let (folder, state) = dir(FIVE);
    let line = format!("mapgen simulate --state {state} {POINT}");
    let (code, _, message) = told(&line, true);
    assert!(code == 130 && message.contains("of 20 periods; no file was asked for"), "{message}");
    let names = ["impacts.csv", "trajectory.csv"].map(|name| folder.path().join(name));
    let [impacts, trajectory] = names.each_ref().map(|path| path.display().to_string());
    let (code, _, message) = told(&format!("{line} --impacts {impacts} --trajectory {trajectory}"), true);
    assert!(code == 130 && message.contains(&format!("{impacts}, {trajectory} hold the run up to there")), "{message}");
    assert!(names.iter().all(|path| path.is_file()));
    // Of a structure, too.
    names.iter().for_each(|path| fs::remove_file(path).unwrap());
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/structures/pounding.toml");
    let line = format!("mapgen simulate --scene {scene} --periods 9 --impacts {impacts} --trajectory {trajectory}");
    let (code, _, message) = told(&line, true);
    assert!(code == 130 && message.contains(&format!("{impacts}, {trajectory} hold the run up to there")), "{message}");
    assert!(names.iter().all(|path| path.is_file()));
}

/// A mass a thousand million times faster than usual: an honest day of work, which is announced and can be ended.
#[cfg(unix)]
#[test]
fn long_work_says_how_long_it_takes_and_stops_when_told_to() {
    use std::io::{BufRead, BufReader, Read};
    let (_folder, state) = dir(r#"{"displacement":[0,0,0,0,0],"velocity":[1e9,0,0,0,0]}"#);
    let mut command = std::process::Command::new(assert_cmd::cargo::cargo_bin("mapgen"));
    command.args(["simulate", "--state", &state]).args(POINT.split(' '));
    let mut child = command.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::piped()).spawn().unwrap();
    let mut errors = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    errors.read_line(&mut line).unwrap();
    assert!(line.contains("of 20 periods") && line.contains(" impacts, about ") && line.contains(" left; "), "{line}");
    assert!(std::process::Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let mut rest = String::new();
    errors.read_to_string(&mut rest).unwrap();
    assert!(rest.contains("error: interrupted: the run ends after"), "{rest}");
}

#[test]
fn a_long_run_is_drawn_by_amplitudes_and_a_short_one_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("run.svg");
    for (periods, expected) in [("20", "displacement u"), ("150.5", "in each period"), ("2000", "in 3 periods")] {
        let line = format!(
            "mapgen simulate --family double-sided {POINT} --periods {periods} --samples 16 --plot {}",
            picture.display()
        );
        let (code, _, message) = run(&line);
        assert!(code == 0, "{message}");
        assert!(fs::read_to_string(&picture).unwrap().contains(expected), "{periods}");
    }
}

#[test]
fn a_run_tells_what_it_is_of_and_what_has_become_of_it() {
    let forced = format!(
        "mapgen simulate --family double-sided {} --amplitude .1 --restitution .9",
        POINT.replace("sites 5", "sites 21")
    );
    let (code, stays, _) = run(&format!("{forced} --periods 100"));
    assert_eq!(code, 0);
    assert!(stays.starts_with("double-sided breather, solution 1 of 2; 21 masses (N = 20), gamma1 = 0.2"), "{stays}");
    assert!(stays.contains("\n100.000000 periods, 200 impacts\noutcome: it stays on the breather\n"), "{stays}");
    assert!(!stays.contains("windows"), "{stays}");
    // A saddle with the multiplier 2.7 is left within some ten periods.
    let pushed = format!("{forced} --solution 2 --perturb 1e-3 --direction unstable --periods 60");
    let (_, left, _) = run(&format!("{pushed} --verbose"));
    assert!(
        left.contains("solution 2 of 2, perturbed by ") && left.contains(" along its unstable direction; 21 masses"),
        "{left}"
    );
    assert!(left.contains("outcome: it left the breather after ") && left.contains("windows of flight "), "{left}");
    let json = vibrochain_testkit::written(&run(&format!("{pushed} --json")).1);
    assert!((3.0..15.0).contains(&json["left"].as_f64().unwrap()) && json["solution"] == 2, "{json}");
    // Without a force losses end all impacts.
    let (_folder, state) = dir(FIVE);
    let (_, quiet, _) = run(&format!("mapgen simulate --state {state} {POINT} --restitution .5 --periods 400"));
    assert!(
        quiet.starts_with("from a state; 5 masses")
            && quiet.contains("outcome: there is no impact in its last 64 periods\n"),
        "{quiet}"
    );
    // One mass between its barriers repeats from the first impact on: a few periods cannot tell, more do.
    let (_folder, state) = dir(r#"{"displacement":[0.3],"velocity":[0.9],"psi":0}"#);
    let alone = format!("mapgen simulate --state {state} --sites 1 --gamma1 .2 --gamma2 0 --omega 1.5 --asymmetry .4");
    for (periods, told) in [(3, "it is too short to tell"), (5, "it is too short to tell"), (20, "repeat as 0-,0+")] {
        let (_, text, _) = run(&format!("{alone} --periods {periods}"));
        assert!(text.contains(told), "{periods}: {text}");
    }
}

#[test]
fn a_run_from_a_breather_begins_with_an_impact_at_zero() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("impacts.csv");
    let mut seen = 0;
    for omega in (0..12).map(|i| 1.3 + 0.037 * f64::from(i)) {
        let line = format!(
            "mapgen simulate --family double-sided --sites 5 --gamma1 .2 --gamma2 .1 --omega {omega} --asymmetry .4"
        );
        let (code, ..) = run(&format!("{line} --periods 3 --impacts {}", table.display()));
        if code == 0 {
            assert_eq!(rows(&table)[0][0], "0", "{omega}");
            seen += 1;
        }
    }
    assert!(seen >= 6, "{seen}");
}

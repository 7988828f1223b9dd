//! Runs of structures and damped chains: what they repeat, settle on, and when they end.

use std::fs;

use serde_json::Value;
use vibrochain_testkit::{TestDir, written};

use super::commands::{TWO, number};

/// A run that begins on a stable orbit repeats it; one from rest settles on it, and what it has settled on leads `orbit` there.
#[test]
fn runs_repeat_orbits_and_settle_on_them() {
    let dir = TestDir::with_scene(&TWO.replace("omega = 0.9", "omega = 0.6").replace("upper = 1.3", "upper = 0.6"));
    let orbit = written(&dir.run("orbit --scene scene.toml --json").with(0, &[]).out);
    let solutions = orbit["solutions"].as_array().unwrap();
    let physical = solutions.iter().find(|solution| solution["physical"] == true).unwrap();
    let ran =
        written(&dir.run("simulate --scene scene.toml --periods 40 --impacts impacts.csv --json").with(0, &[]).out);
    assert_eq!(ran["outcome"], "time-reached");
    let impulse = |value: &Value| number(&value["impacts"][0]["impulse"]);
    if physical["stability"]["stable"] == true {
        assert_eq!(ran["impacts"], 40);
        assert_eq!(ran["repeats"]["word"], "0+");
        assert!((impulse(&ran["repeats"]) - impulse(physical)).abs() < 1e-9);
    }
    let rows = String::from_utf8(dir.read("impacts.csv")).unwrap();
    assert_eq!(rows.lines().next().unwrap(), "time,contact,barrier,velocity_before,velocity_after,impulse,kind");
    // From rest, where no word is named.
    let unnamed = TWO.replace("word = \"0+\"\n", "");
    fs::write(dir.path("other.toml"), unnamed).unwrap();
    let settled = dir.run("simulate --scene other.toml --periods 4000 --impacts run.csv --json").with(0, &[]).out;
    let settled = written(&settled);
    let word = settled["repeats"]["word"].as_str().unwrap().to_owned();
    fs::write(dir.path("run.json"), settled.to_string()).unwrap();
    let near = written(&dir.run("orbit --scene other.toml --near run.json --json").with(0, &[]).out);
    let (found, told) = (&near["solutions"][0], &settled["repeats"]);
    assert_eq!(found["word"], word.as_str());
    assert!(found["physical"] == true && found["stability"]["stable"] == true);
    assert!((impulse(found) - impulse(told)).abs() < 1e-5 * impulse(told).abs());
    // The table of its impacts leads there as well, to an orbit begun at any of its impacts; one cut short says what it lacks.
    let table = written(&dir.run("orbit --scene other.toml --near run.csv --json").with(0, &[]).out);
    let sum = |solution: &Value| {
        let impacts = solution["impacts"].as_array().unwrap();
        impacts.iter().map(|impact| number(&impact["impulse"]).abs()).sum::<f64>()
    };
    let by_table = &table["solutions"][0];
    assert!(by_table["physical"] == true && (sum(by_table) - sum(found)).abs() < 1e-10 * sum(found), "{by_table}");
    fs::write(dir.path("cut.csv"), "time,contact,barrier\n0.5,0,upper\n").unwrap();
    dir.run("orbit --scene other.toml --near cut.csv").with(2, &["cut.csv", "missing field `velocity_before`"]);
    // A state, and what is wrong with one.
    fs::write(dir.path("state.json"), "{\"displacement\": [0.1, 0.2], \"velocity\": [0, 1]}").unwrap();
    dir.run("simulate --scene scene.toml --state state.json --periods 3").with(0, &[]);
    fs::write(dir.path("state.json"), "{\"displacement\": [0.1, 0.9], \"velocity\": [0, 1]}").unwrap();
    dir.run("simulate --scene scene.toml --state state.json").with(2, &["beyond"]);
    fs::write(dir.path("state.json"), "{\"displacement\": [0.1], \"velocity\": [0]}").unwrap();
    dir.run("simulate --scene scene.toml --state state.json").with(2, &["needs 2"]);
    dir.run("simulate --scene scene.toml --animate a.gif").with(2, &["--animate is of lattices"]);
}

/// Next to a doubling of its period a run settles slowly, to and fro: impacts two periods apart are alike long before it has settled. And
/// impacts at the very end of a period are of one period each.
#[test]
fn a_run_that_still_settles_is_not_told_to_repeat() {
    let dir = TestDir::new();
    let scene = "omega = 1.1825\nword = \"0+\"\n[structure]\nmasses = [1]\nstiffness = [[1]]\ndamping = [[0.1]]\n\
        [[contact]]\nat = 0\nupper = 0.1\nrestitution = 0.8\n[force]\nload = [1]\n";
    fs::write(dir.path("scene.toml"), scene).unwrap();
    fs::write(dir.path("rest.toml"), scene.replace("word = \"0+\"\n", "")).unwrap();
    let found = written(&dir.run("orbit --scene scene.toml --json").with(0, &[]).out);
    let orbit = found["solutions"].as_array().unwrap().iter().find(|solution| solution["physical"] == true).unwrap();
    let radius = number(&orbit["stability"]["spectral_radius"]);
    assert!(radius > 0.995 && radius < 1.0, "{radius}");
    let velocity = 1.001 * number(&orbit["impacts"][0]["velocity_after"]);
    let state = format!("{{\"displacement\": [0.1], \"velocity\": [{velocity}], \"psi\": {}}}", orbit["psi"]);
    fs::write(dir.path("state.json"), state).unwrap();
    let told = |periods: u32| {
        let run = dir.run(&format!("simulate --scene rest.toml --state state.json --periods {periods}"));
        run.with(0, &[]).out
    };
    for periods in [200, 500, 1000, 1500] {
        assert!(told(periods).contains("it has not settled yet: its impacts are still moving by"), "{}", told(periods));
    }
    assert!(told(10_000).contains("it repeats 0+ every 1 period of the load"), "{}", told(10_000));
}

/// About a neutral orbit a run goes round a torus, whatever looks alike for a while. An unstable orbit is followed for a while, and that is told
/// as far as rounding differs, too.
#[test]
fn what_repeats_is_no_matter_of_luck() {
    let elastic =
        "[structure]\nmasses = [1]\nstiffness = [[1]]\n[[contact]]\nat = 0\nupper = 0.1\n[force]\nload = [1]\n";
    let dir = TestDir::with_scene(elastic);
    fs::write(dir.path("on.toml"), format!("word = \"0+\"\n{elastic}")).unwrap();
    let mut moving = 0;
    for omega in ["1.8", "2.1", "2.2"] {
        let ran = dir.run(&format!("simulate --scene on.toml --omega {omega} --periods 177")).with(0, &[]).out;
        assert!(ran.ends_with("it repeats 0+ every 1 period of the load\n"), "{ran}");
        let found = written(&dir.run(&format!("orbit --scene on.toml --omega {omega} --json")).with(0, &[]).out);
        let orbit = found["solutions"].as_array().unwrap().iter().find(|one| one["physical"] == true).unwrap();
        for beside in [1e-6, 1e-8] {
            let velocity = (1.0 + beside) * number(&orbit["impacts"][0]["velocity_after"]);
            let state = format!("{{\"displacement\": [0.1], \"velocity\": [{velocity}], \"psi\": {}}}", orbit["psi"]);
            fs::write(dir.path("state.json"), state).unwrap();
            for periods in [50, 100, 130, 177, 250] {
                let line =
                    format!("simulate --scene scene.toml --omega {omega} --state state.json --periods {periods}");
                let ran = dir.run(&line).with(0, &[]).out;
                moving += usize::from(ran.contains("it has not settled yet"));
            }
        }
    }
    assert_eq!(moving, 3 * 2 * 5);
    let pair = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/structures/impact-pair.toml");
    for omega in ["2.463637451552706", "2.4636374515527004"] {
        for periods in [10, 20, 24] {
            let line = format!("simulate --scene {pair} --omega {omega} --solution 2 --periods {periods}");
            let told = dir.run(&line).with(0, &[]).out;
            assert!(told.ends_with("1 period of the load: an unstable orbit, which it will leave\n"), "{told}");
            let repeats = &written(&dir.run(&format!("{line} --json")).with(0, &[]).out)["repeats"];
            assert!(repeats["stable"] == false && repeats["word"] == "0-,0+", "{repeats}");
        }
    }
}

/// Another contact rests all the time: what the first one repeats is no word of the structure.
#[test]
fn a_run_with_a_contact_at_rest_has_no_word() {
    let dir = TestDir::new();
    let scene = "omega = 0.9\n[structure]\nmass = [[1, 0], [0, 1]]\nstiffness = [[1, 0], [0, 1]]\ndamping = [[0.2, 0], [0, 0.2]]\n\
        [[contact]]\nat = 0\nupper = 0.5\nrestitution = 0.5\n[[contact]]\nat = 1\nupper = 0.1\nrestitution = 0.3\n\
        [force]\nload = [1, 0]\nstatic = [0, 1]\n";
    fs::write(dir.path("scene.toml"), scene).unwrap();
    fs::write(dir.path("state.json"), "{\"displacement\": [0, 0], \"velocity\": [0, 0]}").unwrap();
    let line = "simulate --scene scene.toml --state state.json --periods 200";
    dir.run(&format!("{line} --max-impacts 100000")).with(0, &[]);
    let told = dir.run(line).with(0, &[]).out;
    assert!(told.contains("1 sticks, 0 releases") && told.contains("a contact rests on its barrier"), "{told}");
    let ran = written(&dir.run(&format!("{line} --json")).with(0, &[]).out);
    assert_eq!(ran["repeats"], Value::Null);
}

/// Runs that would go on for ever end, with what was simulated: modes that feed themselves beyond what stops can hold, and a contact that
/// is pressed and loses nothing. What impacts bound goes on.
#[test]
fn runs_without_an_end_are_told() {
    let dir = TestDir::new();
    let scene = |damping: f64, e: f64, load: &str| {
        format!(
            "omega = 0.9\n[structure]\nmass = [[1, 0], [0, 1.4]]\nstiffness = [[1, -0.3], [-0.3, 0.8]]\n\
             damping = [[{damping}, 0], [0, {damping}]]\n[[contact]]\nat = 1\nlower = 0.0\nupper = 1.3\nrestitution = {e}\n\
             [force]\n{load}\n"
        )
    };
    fs::write(dir.path("state.json"), "{\"displacement\": [0, 1e-9], \"velocity\": [0, 0]}").unwrap();
    let run = |text: String| {
        fs::write(dir.path("scene.toml"), text).unwrap();
        let line = "simulate --scene scene.toml --state state.json --periods 100000 --impacts impacts.csv";
        let told = dir.run(line).with(0, &[]).out;
        (told, dir.read("impacts.csv").iter().filter(|byte| **byte == b'\n').count())
    };
    let (told, rows) = run(scene(-0.02, 0.8, "load = [0.5, 0]"));
    assert!(told.contains("grows without bound") && rows > 1000, "{told}");
    let (told, rows) = run(scene(0.02, 1.0, "load = [0.1, 0]\nstatic = [0, -5]"));
    assert!(told.contains("contact 0 has hit its lower barrier 100000 times in a cascade"), "{told}");
    assert!(told.contains("give it a restitution below 1") && rows > 100_000, "{told}");
    let chain = "simulate --sites 5 --gamma1 1 --gamma2 .1 --omega 1.6 --asymmetry 0 --amplitude .2 --restitution .9 --damping -.02 \
        --coupling-damping .05 --word 2+,2- --periods 3000 --json";
    assert_eq!(written(&dir.run(chain).with(0, &[]).out)["outcome"], "time-reached");
}

/// A damped chain from flags: its run on a stable orbit is that orbit.
#[test]
fn a_damped_chain_runs_on_its_orbit() {
    let dir = TestDir::new();
    let flags = "--family double-sided --sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --amplitude .1 --restitution .9 --damping .02";
    let ran = written(&dir.run(&format!("simulate {flags} --periods 100 --json")).with(0, &[]).out);
    assert_eq!((&ran["impacts"], &ran["end"]), (&200.into(), &"breather".into()));
    let as_structure = format!("simulate {flags} --static-force 0 --periods 100 --json");
    let ran = written(&dir.run(&as_structure).with(0, &[]).out);
    assert_eq!((&ran["impacts"], &ran["repeats"]["word"]), (&200.into(), &"0+,0-".into()));
}

/// With --verbose a run tells where its energy has gone, whatever its dashpots are.
#[test]
fn a_run_accounts_for_its_energy() {
    let even = TWO.replace("word = \"0+\"\n", "").replace("lower = -0.7", "lower = -0.2");
    let uneven = even.replace("[[0.02, 0], [0, 0.02]]", "[[0.02, 0], [0, 0.3]]");
    let mut checked = 0;
    for (text, options) in [(&even, ""), (&uneven, ""), (&uneven, " --set load=1.4")] {
        let dir = TestDir::with_scene(text);
        let quiet = dir.run(&format!("simulate --scene scene.toml{options} --periods 40")).with(0, &[]).out;
        assert!(!quiet.contains("energy"), "{quiet}");
        let told = dir.run(&format!("simulate --scene scene.toml{options} --periods 40 --verbose")).with(0, &[]).out;
        let line = told.lines().find_map(|line| line.strip_prefix("energy ")).unwrap();
        let numbers: Vec<f64> = line.split([' ', ':', ',', ';']).filter_map(|word| word.parse().ok()).collect();
        let [before, after, work, dashpots, impacts, missing] = numbers[..] else { panic!("{line}") };
        assert!(dashpots > 0.0 && impacts > 0.0, "{line}");
        assert!(
            (after - before - (work - dashpots - impacts)).abs() < 1e-12 * work && missing.abs() < 1e-12 * work,
            "{line}"
        );
        checked += 1;
    }
    assert_eq!(checked, 3);
}

/// With --verbose it says how it flies: a ring by local series, two masses with a stiff spring and one contact by modes.
#[test]
fn a_run_says_how_it_flies() {
    let flags = "--family double-sided --sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --amplitude .1 --restitution .9 --damping .02 --static-force 0";
    let stiff = TWO.replace("word = \"0+\"\n", "").replace("[[1, -0.3]", "[[1e12, -0.3]");
    assert!(stiff.contains("1e12"), "{stiff}");
    let dir = TestDir::with_scene(&stiff);
    for (which, flight) in [(flags, "flight by local series: "), ("--scene scene.toml", "flight by modes: ")] {
        let told = dir.run(&format!("simulate {which} --periods 3 -v")).with(0, &[flight, "multiplications"]).err;
        let numbers: Vec<f64> = told.split([' ', '\n']).filter_map(|word| word.parse().ok()).collect();
        assert!(numbers[0] < numbers[1], "{told}");
        assert!(!dir.run(&format!("simulate {which} --periods 3")).with(0, &[]).err.contains("flight by"));
    }
}

/// The answer of a run is the state of another one, which goes on where the first has ended.
#[test]
fn a_run_goes_on_from_its_own_answer() {
    let dir = TestDir::with_scene(TWO);
    fs::write(dir.path("state.json"), "{\"displacement\": [0.1, 0.2], \"velocity\": [0, 1], \"psi\": 0.3}").unwrap();
    let run = |state: &str, periods: f64, answer: &str| {
        let ran =
            dir.run(&format!("simulate --scene scene.toml --state {state} --periods {periods} --json")).with(0, &[]);
        fs::write(dir.path(answer), &ran.out).unwrap();
        written(&ran.out)
    };
    let whole = run("state.json", 7.25, "whole.json");
    let _ = run("state.json", 2.75, "first.json");
    let second = run("first.json", 4.5, "second.json");
    for key in ["displacement", "velocity"] {
        let of = |answer: &serde_json::Value, i: usize| answer["state"][key][i].as_f64().unwrap();
        for i in 0..2 {
            assert!((of(&whole, i) - of(&second, i)).abs() < 1e-9, "{key} {i}: {whole} {second}");
        }
    }
    assert!((whole["state"]["psi"].as_f64().unwrap() - second["state"]["psi"].as_f64().unwrap()).abs() < 1e-9);
    // A chain's run is none of these.
    let chain = "--sites 1 --gamma1 1 --gamma2 0 --omega 1.5 --asymmetry .2 --amplitude .1 --restitution .8";
    dir.run(&format!("simulate {chain} --state first.json"))
        .with(2, &["structure-run:1, wanted is urn:vibrochain:simulate:1"]);
}

/// Two balls run into one between them at one instant: a run ends there unless a flag, or the scene, says that contacts hit by their numbers.
#[test]
fn contacts_that_hit_at_one_instant_do_so_in_sequence_on_request() {
    let balls = "[structure]\nmasses = [1, 1, 1]\nstiffness = [[0, 0, 0], [0, 0, 0], [0, 0, 0]]\n\
        [[contact]]\nbetween = [0, 1]\nupper = 0.5\n[[contact]]\nbetween = [1, 2]\nupper = 0.5\n";
    let dir = TestDir::with_scene(balls);
    fs::write(dir.path("sequence.toml"), balls.replace("[structure]", "[structure]\nin_sequence = true")).unwrap();
    fs::write(dir.path("state.json"), r#"{"displacement":[0,0,0],"velocity":[1,0,-1]}"#).unwrap();
    let run = |scene: &str| {
        let line = format!("simulate --scene {scene} --state state.json --time 2 --json");
        written(&dir.run(&line).with(0, &[]).out)
    };
    let told = run("scene.toml");
    assert!(told["outcome"] == "simultaneous" && told["impacts"] == 0, "{told}");
    assert!((number(&told["time"]) - 0.5).abs() < 1e-15);
    let words = dir.run("simulate --scene scene.toml --state state.json --time 2").with(0, &[]).out;
    assert!(words.contains("--in-sequence lets them hit"), "{words}");
    // Velocities are exchanged: (1, 0, -1), (0, 1, -1), (0, -1, 1), (-1, 0, 1).
    let flagged = run("scene.toml --in-sequence");
    assert!(flagged["outcome"] == "time-reached" && flagged["impacts"] == 3, "{flagged}");
    for (v, expected) in flagged["state"]["velocity"].as_array().unwrap().iter().zip([-1.0, 0.0, 1.0]) {
        assert!((number(v) - expected).abs() < 1e-14, "{flagged}");
    }
    assert_eq!(run("sequence.toml")["state"], flagged["state"]);
    // Masses of a chain share no coordinate.
    let chain = "--sites 2 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4";
    dir.run(&format!("simulate {chain} --family double-sided --in-sequence"))
        .with(2, &["--in-sequence is of structures"]);
}
/// Nothing here has a period: a ball that is dropped, and a mass on a spring far from its stop. States by a file, as words and through a pipe.
#[test]
fn a_run_without_a_load_needs_no_frequency_and_lasts_as_long_as_it_is_told() {
    let ball = "[structure]\nmasses = [1]\nstiffness = [[0]]\n[[contact]]\nat = 0\nlower = 0\nrestitution = 0.8\n[force]\nstatic = [-1]\n";
    let dir = TestDir::with_scene(ball);
    let state = r#"{"displacement":[0.5],"velocity":[0]}"#;
    fs::write(dir.path("state.json"), state).unwrap();
    let ask = "simulate --scene scene.toml --time 12";
    let all = "--impacts impacts.csv --trajectory run.csv --plot run.svg --json";
    let by_file = dir.run(&format!("{ask} --state state.json {all}")).with(0, &[]).out;
    let told = written(&by_file);
    assert!(told["structure"]["omega"].is_null() && told["repeats"].is_null() && told["sticks"] == 1);
    assert!((number(&told["time"]) - 12.0).abs() < 1e-13);
    // It comes to rest at 1 + 2e/(1 − e) = 9, and its n-th bounce is at 1 + 2(e + … + eⁿ⁻¹).
    let rows = String::from_utf8(dir.read("impacts.csv")).unwrap();
    let times: Vec<f64> = rows.lines().skip(1).map(|row| row.split(',').next().unwrap().parse().unwrap()).collect();
    for (n, time) in times.iter().take(8).enumerate() {
        let exact = 1.0 + 2.0 * (0.8 - 0.8_f64.powi(n as i32 + 1)) / 0.2;
        assert!((time - exact).abs() < 1e-12, "{n}: {time} {exact}");
    }
    assert!((times.last().unwrap() - 9.0).abs() < 1e-12);
    assert!(String::from_utf8(dir.read("run.csv")).unwrap().lines().count() > 500);
    let svg = String::from_utf8(dir.read("run.svg")).unwrap();
    assert!(svg.contains("\"time\"") && !svg.contains("in periods"), "the axis is time");
    let mut inline = dir.command(ask);
    inline.args(["--state", state, "--json"]);
    assert_eq!(written(inline.output().unwrap().stdout), told);
    let piped = dir.shell(&format!("mapgen {ask} --state - --json < state.json"));
    assert_eq!(written(&piped.out), told);
    let words = dir.run(&format!("{ask} --state state.json")).with(0, &[]).out;
    assert!(words.contains("no load") && words.contains("rests on its barrier at the end"), "{words}");
    for (line, code, why) in [
        ("simulate --scene scene.toml --state state.json", 2, "give --time, the length of the run"),
        (
            "simulate --scene scene.toml --state state.json --time -1",
            2,
            "--time -1 is out of range: give a number from 0",
        ),
        ("simulate --scene scene.toml --time 1 --section s.csv", 2, "--section takes phases of a load"),
        ("simulate --scene scene.toml --time 1 --state {}", 2, "--state: the key `displacement` is missing"),
        ("simulate --scene scene.toml --time 1 --periods 2", 2, "cannot be used with"),
        ("simulate --scene scene.toml --time 1 --state none.json", 2, "cannot read state none.json"),
        ("orbit --scene scene.toml --word 0-", 3, "losses end the motion"),
    ] {
        dir.run(line).with(code, &[why]);
    }
    // A spring: x = cos 2t.
    fs::write(
        dir.path("spring.toml"),
        ball.replace("[[0]]", "[[4]]").replace("[-1]", "[0]").replace("lower = 0", "lower = -2"),
    )
    .unwrap();
    fs::write(dir.path("state.json"), r#"{"displacement":[1],"velocity":[0]}"#).unwrap();
    let ran = dir.run("simulate --scene spring.toml --time 1.7 --state state.json --json").with(0, &[]).out;
    let end = number(&written(&ran)["state"]["displacement"][0]);
    assert!((end - 3.4_f64.cos()).abs() < 1e-14, "{end}");
    // With a load --time is --periods in other units.
    let under = |length: &str| {
        let line = format!("simulate --scene two.toml --json {length}");
        written(&dir.run(&line).with(0, &[]).out)["state"]["velocity"][0].as_f64().unwrap()
    };
    fs::write(dir.path("two.toml"), TWO.replace("word = \"0+\"\n", "")).unwrap();
    let period = std::f64::consts::TAU / 0.9;
    assert!((under("--periods 3.25") - under(&format!("--time {}", 3.25 * period))).abs() < 1e-9);
}

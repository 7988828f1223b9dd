//! `branch`, `locate` and `curve` of structures and damped chains: answers, tables, pictures, and what is wrong with a request.

use std::fs;

use serde_json::Value;
use vibrochain_testkit::{TestDir, written};

/// x″ + 0.1x′ + x = A cos ωt with a stop at 0.1.
const OSCILLATOR: &str = "title = \"oscillator\"\nomega = 2.325\nword = \"0+\"\n[structure]\nmasses = [1]\nstiffness = [[1]]\n\
    damping = [[0.1]]\n[[contact]]\nat = 0\nupper = 0.1\nrestitution = 0.8\n[force]\nload = [1]\n";

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn dir() -> TestDir {
    let dir = TestDir::new();
    fs::write(dir.path("scene.toml"), OSCILLATOR).unwrap();
    dir
}

/// At a doubling that was located the orbit there has the multiplier −1, by `orbit` itself; and stands at it, stable on one side alone.
#[test]
fn a_doubling_that_is_located_is_one() {
    let dir = dir();
    let answer =
        written(&dir.run("locate --scene scene.toml --event period-doubling --free load --json").with(0, &[]).out);
    let events = answer["events"].as_array().unwrap();
    assert_eq!(events.len(), 1);
    let load = number(&events[0]["value"]);
    let found = written(&dir.run(&format!("orbit --scene scene.toml --set load={load} --json")).with(0, &[]).out);
    let nearest = (found["solutions"].as_array().unwrap().iter())
        .flat_map(|solution| solution["stability"]["multipliers"].as_array().unwrap())
        .map(|mu| (number(&mu[0]) + 1.0).hypot(number(&mu[1])))
        .fold(f64::INFINITY, f64::min);
    assert!(nearest < 1e-12, "{nearest}");
    let sides = events[0]["sides"].as_array().unwrap();
    let stable: Vec<bool> = sides.iter().map(|side| side["stability"]["stable"] == true).collect();
    assert!(stable.len() == 2 && stable[0] != stable[1], "{stable:?}");
    // The same by the flags of a damped chain of one mass.
    let flags = "--sites 1 --gamma1 1 --gamma2 0 --omega 2.325 --damping .1 --upper .1 --restitution .8 --amplitude 1 --word 0+";
    let chain =
        written(&dir.run(&format!("locate {flags} --event period-doubling --free amplitude --json")).with(0, &[]).out);
    assert!((number(&chain["events"][0]["value"]) - load).abs() < 1e-12);
}

/// The grazing curve is A = d√((1−ω²)² + c²ω²), in the table as in JSON.
#[test]
fn a_curve_is_written_as_it_is_told() {
    let dir = dir();
    let ask = "curve --scene scene.toml --event grazing --free load --and omega --and-from 1.7 --and-to 2.6 --from 0.05 --to 2 --tolerance 1e-4";
    let told = written(&dir.run(&format!("{ask} --json --out curve.csv --plot curve.svg")).with(0, &[]).out);
    let by_hand = |omega: f64| 0.1 * ((1.0 - omega * omega).powi(2) + 0.01 * omega * omega).sqrt();
    let curves = told["curves"].as_array().unwrap();
    let of_it: Vec<&Value> = curves
        .iter()
        .flat_map(|curve| curve["points"].as_array().unwrap())
        .filter(|point| number(&point["impulses"][0]).abs() < 1e-9)
        .collect();
    assert!(of_it.len() > 20);
    for point in &of_it {
        let [load, omega] = [number(&point["values"][0]), number(&point["values"][1])];
        assert!((load - by_hand(omega)).abs() < 1e-10, "{load} {omega}");
    }
    let table = fs::read_to_string(dir.path("curve.csv")).unwrap();
    assert!(table.starts_with("curve,event,load,omega,error,special,special_error,angle,physical,impulses,phi,psi\n"));
    let points: usize = curves.iter().map(|curve| curve["points"].as_array().unwrap().len()).sum();
    assert_eq!(table.lines().count(), points + 1);
    let svg = fs::read_to_string(dir.path("curve.svg")).unwrap();
    assert!(svg.contains("factor of the load"));
    // Which contact meets which barrier.
    let words = dir.run(ask).with(0, &[]).out;
    for told in [svg, words] {
        assert!(told.contains("curve 1: the impact of contact 0 on the upper barrier vanishes"), "{told}");
    }
}

#[test]
fn a_branch_has_a_table_and_a_picture() {
    let dir = dir();
    let ask = "branch --scene scene.toml --free omega --from 1 --to 3 --out branch.csv --plot branch.svg --json";
    let told = written(&dir.run(ask).with(0, &[]).out);
    let table = fs::read_to_string(dir.path("branch.csv")).unwrap();
    let rows = told["points"].as_array().unwrap().len() + told["events"].as_array().unwrap().len();
    assert_eq!(table.lines().count(), rows + 1);
    assert!(
        table
            .starts_with("branch,generation,event,value,error,impulse,impulses,phi,psi,period,margin,physical,stable,")
    );
    let picture = fs::read_to_string(dir.path("branch.svg")).unwrap();
    assert!(picture.contains("oscillator") && picture.contains("period doubling"));
    let text = dir.run("branch --scene scene.toml --free omega").with(0, &[]).out;
    assert!(text.contains("period-doubling: multiplier -"), "{text}");
    dir.run("locate --scene scene.toml --free omega --event grazing --out located.csv").with(0, &[]);
    assert!(fs::read_to_string(dir.path("located.csv")).unwrap().starts_with("event,omega,error,impulses,"));
}

/// A ball between the walls of a shaken box: its orbits lose their symmetry.
const PAIR: &str = "title = \"pair\"\nomega = 1\nword = \"0+,0-\"\n[structure]\nmasses = [1]\nstiffness = [[0]]\n\
    [[contact]]\nat = 0\nlower = -1\nupper = 1\nrestitution = 0.6\n[force]\nload = [1]\n";

/// What branches off at an event is what a run from rest, which knows of no orbit, comes to: twice the period after a doubling, other impulses
/// on either side where symmetry is lost.
#[test]
fn what_branches_off_is_what_runs_come_to() {
    let dir = dir();
    fs::write(dir.path("pair.toml"), PAIR).unwrap();
    let cases = [
        ("scene.toml", "omega", "--from 2.3 --to 2.7", "period-doubling", ("0+,0+", 2)),
        ("pair.toml", "restitution", "--from 0.1 --to 0.7", "pitchfork", ("0+,0-", 1)),
    ];
    for (scene, free, range, event, (word, periods)) in cases {
        // Of the ball the symmetric orbit, the second one.
        let which = if scene == "pair.toml" { 2 } else { 1 };
        let ask = format!("branch --scene {scene} --free {free} {range} --solution {which} --switch");
        let told = written(&dir.run(&format!("{ask} --json --out branch.csv --plot branch.svg")).with(0, &[]).out);
        let of_event = |branch: &&Value| branch["origin"]["event"] == event;
        let branches = told["branches"].as_array().unwrap();
        let branch = branches.iter().find(of_event).unwrap();
        assert_eq!((&branch["word"], &branch["force_periods"]), (&word.into(), &periods.into()));
        let stable: Vec<&Value> = (branch["points"].as_array().unwrap().iter())
            .filter(|point| point["physical"] == true && point["stability"]["stable"] == true)
            .collect();
        let point = stable[stable.len() / 3];
        // The same scene without a word: from rest.
        let text = fs::read_to_string(dir.path(scene)).unwrap();
        fs::write(dir.path("rest.toml"), text.replace(&format!("word = \"{}\"\n", told["word"].as_str().unwrap()), ""))
            .unwrap();
        let value = number(&point["value"]);
        let run = format!("simulate --scene rest.toml --set {free}={value} --periods 4000 --json");
        let repeats = &written(&dir.run(&run).with(0, &[]).out)["repeats"];
        // The shorter of the two flights, and both impulses, whichever impact comes first.
        let told_of = |phi: f64, period: f64, impulses: [f64; 2]| {
            let [a, b] = impulses.map(f64::abs);
            [phi.min(period - phi) / period, a.min(b), a.max(b)]
        };
        let impacts = repeats["impacts"].as_array().unwrap();
        assert_eq!(impacts.len(), 2, "{repeats}");
        let of_run = |key: &str| [0, 1].map(|i: usize| number(&impacts[i][key]));
        let [first, second] = of_run("time");
        let run = told_of(second - first, number(&repeats["period"]), of_run("impulse"));
        let impulses = [0, 1].map(|i: usize| number(&point["impulses"][i]));
        let own = told_of(number(&point["phi"]), number(&point["period"]), impulses);
        assert!((own[0] - 0.5).abs() > 1e-3, "{own:?}");
        for (a, b) in run.iter().zip(&own) {
            assert!((a - b).abs() < 1e-7 * b, "{scene}: {run:?} {own:?}");
        }
        let rows: usize = fs::read_to_string(dir.path("branch.csv")).unwrap().lines().count();
        let stations = |branch: &Value| {
            ["points", "events"].map(|key| branch[key].as_array().unwrap().len()).iter().sum::<usize>()
        };
        assert_eq!(rows, 1 + stations(&told) + branches.iter().map(stations).sum::<usize>());
        let text = dir.run(&ask).with(0, &[]).out;
        assert!(text.contains(&format!("leaves branch 1 at {free} = ")) && text.contains(event), "{text}");
    }
}

/// Those that are mirror images of each other end on the symmetric ones, which go on from there.
#[test]
fn both_of_a_pair_end_on_the_symmetric_orbits() {
    let dir = dir();
    fs::write(dir.path("pair.toml"), PAIR).unwrap();
    let mut followed = 0;
    for which in [1, 3] {
        let ask = "branch --scene pair.toml --free restitution --from 0.1 --to 0.7 --switch --json";
        let told = written(&dir.run(&format!("{ask} --solution {which}")).with(0, &[]).out);
        assert!(told["points"].as_array().unwrap().len() > 50);
        let of_pitchfork = |list: &str, event: &dyn Fn(&Value) -> Value| {
            told[list].as_array().unwrap().iter().filter(|one| event(one) == "pitchfork").cloned().collect::<Vec<_>>()
        };
        let branches = of_pitchfork("branches", &|one| one["origin"]["event"].clone());
        let left = of_pitchfork("dead_ends", &|one| one["event"].clone());
        assert_eq!(branches.len() + left.len(), 1, "{told}");
        for symmetric in branches {
            let points = symmetric["points"].as_array().unwrap();
            let half = |point: &Value| (number(&point["phi"]) - 0.5 * number(&point["period"])).abs() < 1e-9;
            assert!(points.len() > 50 && points.iter().all(half), "{symmetric}");
            followed += 1;
        }
    }
    assert_eq!(followed, 2);
}

#[test]
fn what_is_wrong_is_told() {
    let dir = dir();
    let cases = [
        ("branch --scene scene.toml --free contact.3.upper", "no such number"),
        ("branch --scene scene.toml --free gamma1", "no such number"),
        ("branch --scene scene.toml --free omega --generations 2", "--switch"),
        ("branch --scene scene.toml --free omega --from 3", "is above omega"),
        ("locate --scene scene.toml --free omega --event fold --solution 9", "--solution 9 is out of range"),
        ("curve --scene scene.toml --free omega --and omega --event fold", "--free and --and are both omega"),
        ("curve --scene scene.toml --free omega --and load --event fold --tolerance 1", "tolerance"),
    ];
    for (ask, message) in cases {
        let ran = dir.run(ask);
        assert!(ran.code != Some(0) && ran.err.contains(message), "{ask}: {ran:?}");
    }
    let chain = "--family single-sided --sites 5 --gamma1 1 --gamma2 .1 --omega 1.5 --asymmetry .4";
    dir.run(&format!("branch {chain} --free contact.0.upper")).with(2, &["is a number of structures"]);
    dir.run(&format!("branch {chain} --free omga")).with(2, &["omega"]);
}

/// Two masses and a bar between them: each impact of the first turns the second contact round, too.
const BAR: &str = "omega = 1.3\nword = \"0+\"\n[structure]\nmasses = [1, 1]\nstiffness = [[1.2, -0.2], [-0.2, 1.2]]\n\
    damping = [[0.05, 0], [0, 0.05]]\n[[contact]]\nat = 0\nupper = 0.5\nrestitution = 0.8\n[[contact]]\nbetween = [0, 1]\nupper = 1.0\n\
    restitution = 0.8\n[force]\nload = [0.5, 0.1]\n";

/// Where a contact comes closest to its barrier at another one's impact it touches at a corner of its motion: on one side of that place the
/// simulation has impacts of it, on the other it has none.
#[test]
fn a_contact_that_another_ones_impact_turns_round_touches_too() {
    let dir = TestDir::new();
    fs::write(dir.path("bar.toml"), BAR).unwrap();
    let told = written(
        &dir.run("branch --scene bar.toml --solution 1 --free contact.1.upper --from 0.5 --to 2 --json")
            .with(0, &[])
            .out,
    );
    let touches: Vec<&Value> = (told["events"].as_array().unwrap().iter())
        .filter(|event| event["event"] == "grazing" && event["evidence"]["contact"] == 1)
        .collect();
    assert!(touches.len() == 1 && touches[0]["evidence"]["time"] == 0.0, "{told:#}");
    let stop = number(&touches[0]["value"]);
    // In another unit of length it is the same place.
    let small = BAR.replace("0.5, 0.1]", "5e-7, 1e-7]").replace("upper = 0.5", "upper = 5e-7");
    fs::write(dir.path("small.toml"), small.replace("upper = 1.0", "upper = 1e-6")).unwrap();
    let line = "branch --scene small.toml --solution 1 --free contact.1.upper --from 5e-7 --to 2e-6 --json";
    let small = written(&dir.run(line).with(0, &[]).out);
    assert!((number(&small["events"][0]["value"]) * 1e6 - stop).abs() < 1e-12 * stop, "{small:#}");
    let hits = |stop: f64| {
        let line = format!(
            "simulate --scene bar.toml --solution 1 --set contact.1.upper={stop} --periods 2 --impacts hits.csv"
        );
        dir.run(&line).with(0, &[]);
        let table = String::from_utf8(dir.read("hits.csv")).unwrap();
        table.lines().skip(1).filter(|row| row.split(',').nth(1) == Some("1")).count()
    };
    // Its place there does not depend on its own barrier.
    assert_eq!([hits(stop - 1e-9), hits(stop + 1e-9)].map(|count| count > 0), [true, false], "{stop}");
    let ask = "--scene bar.toml --solution 1 --event grazing --free contact.1.upper --from 0.9 --to 1 --json";
    let located = written(&dir.run(&format!("locate {ask}")).with(0, &[]).out);
    assert!((number(&located["events"][0]["value"]) - stop).abs() < 1e-12);
    let curve = format!("curve {ask} --and omega --and-from 1.25 --and-to 1.3");
    let curves = written(&dir.run(&curve).with(0, &[]).out);
    let points = curves["curves"][0]["points"].as_array().unwrap();
    let last = [&points[0], &points[points.len() - 1]].map(|point| [0, 1].map(|i| number(&point["values"][i])));
    assert!(points.len() > 4 && last.iter().any(|[at, omega]| (at - stop).abs() < 1e-10 && *omega == 1.3), "{last:?}");
}

/// A curve has the same special points in every window. Here a pair of multipliers crosses the circle and becomes real at −1 within one step;
/// the curve of Neimark–Sacker points has both places, too.
#[test]
fn special_points_do_not_depend_on_the_window() {
    let dir = TestDir::new();
    fs::write(dir.path("bar.toml"), BAR.replace("at = 0\n", "at = 1\n")).unwrap();
    let special = |event: &str, [from, to, low, high]: [f64; 4]| {
        let line = format!(
            "curve --json --event {event} --scene bar.toml --free omega --from {from} --to {to} --and contact.0.upper --and-from {low} --and-to {high}"
        );
        let told = written(&dir.run(&line).with(0, &[]).out);
        let points: Vec<Value> = (told["curves"].as_array().unwrap().iter())
            .flat_map(|curve| curve["special"].as_array().unwrap().clone())
            .collect();
        points
    };
    let find = |points: &[Value], kind: &str, goal: [f64; 2]| {
        points.iter().any(|point| {
            let apart = [0, 1].map(|i| (number(&point["values"][i]) - goal[i]).abs());
            point["special"] == kind && apart.iter().all(|apart| *apart < 1e-8)
        })
    };
    let other = special("neimark-sacker", [0.7, 1.6, 0.1, 1.0]);
    let at = |kind: &str| {
        let one = other.iter().find(|one| one["special"] == kind && number(&one["values"][0]) < 0.7321);
        [0, 1].map(|i| number(&one.unwrap()["values"][i]))
    };
    let (meeting, crossing) = (at("1:2"), at("period-doubling"));
    for window in [
        [0.7, 1.6, 0.1, 1.0],
        [0.71, 1.6, 0.1, 1.0],
        [0.727, 1.582, 0.136, 0.973],
        [0.731, 1.6, 0.41, 1.0],
        [0.73, 1.6, 0.1, 1.0],
    ] {
        let points = special("period-doubling", window);
        assert!(find(&points, "1:2", meeting) && find(&points, "neimark-sacker", crossing), "{window:?}: {points:?}");
    }
}

/// A branch that ends at a resonance says where that is, not where its last orbit was: of two undamped masses at the root of the larger
/// eigenvalue of M⁻¹K over the harmonic.
#[test]
fn a_resonance_is_told_where_it_is() {
    let dir = TestDir::new();
    let scene = "omega = 0.8425950187080721\nword = \"0+\"\n[structure]\nmasses = [1.5, 1.75]\n\
        stiffness = [[13.5, -0.75], [-0.75, 0.4]]\n[[contact]]\nweights = [0.058, 0.824]\nupper = 1.13666191367244\nrestitution = 0.9\n\
        [force]\nload = [0.48, 0.6]\nstatic = [-0.15, 0.3]\n";
    fs::write(dir.path("undamped.toml"), scene).unwrap();
    let (mean, half, coupling) =
        (0.5 * (13.5 / 1.5 + 0.4 / 1.75), 0.5 * (13.5 / 1.5 - 0.4 / 1.75), 0.75 * 0.75 / (1.5 * 1.75));
    let exact = (mean + f64::sqrt(half * half + coupling)).sqrt() / 4.0;
    let told = written(
        &dir.run("branch --scene undamped.toml --free omega --from 0.4 --to 0.9 --all --json").with(0, &[]).out,
    );
    let ends: Vec<&Value> =
        told["ends"].as_array().unwrap().iter().filter(|end| end["reason"] == "resonance").collect();
    assert!(!ends.is_empty(), "{:?}", told["ends"]);
    for end in ends {
        assert!((number(&end["value"]) - exact).abs() < 1e-14, "{end} {exact}");
    }
}

/// Where the spring is gone the mass drifts, and its orbits have one unknown more: the branch ends there, it does not panic.
#[test]
fn a_branch_ends_where_a_spring_vanishes() {
    let dir = dir();
    let mut ended = 0;
    for (event, to) in [("pitchfork", "2"), ("grazing", "2"), ("period-doubling", "1.5")] {
        let line = format!("locate --scene scene.toml --event {event} --free stiffness.0.0 --from 0 --to {to} --json");
        let answer = written(&dir.run(&line).with(0, &[]).out);
        ended += answer["ends"].as_array().unwrap().len();
    }
    assert_eq!(ended, 6);
    // A stiffness that is all but singular among far masses: rounding decides how many motions nothing holds.
    let scene = "omega = 2.2\nword = \"0-\"\n[structure]\nmasses = [1, 1e9]\nstiffness = [[1, -1], [-1, 1.0000001]]\n\
                 [[contact]]\nweights = [1, 1e9]\nlower = -1e-9\nrestitution = 0.5\n[force]\nload = [1, 1]\n";
    fs::write(dir.path("far.toml"), scene).unwrap();
    let ran = dir.run("locate --scene far.toml --event pitchfork --free stiffness.0.0 --json");
    assert!(ran.code.is_some_and(|code| code != 101) && !ran.err.contains("panicked"), "{ran:?}");
}

/// On either side of a grazing the orbit is physical on one side alone: "stable" by itself would say that it lives on both.
#[test]
fn the_sides_of_an_event_say_whether_they_are_physical() {
    let dir = dir();
    let told = dir.run("locate --scene scene.toml --event grazing --free omega --from 0.5 --to 3").with(0, &[]).out;
    let answer =
        dir.run("locate --scene scene.toml --event grazing --free omega --from 0.5 --to 3 --json").with(0, &[]);
    let events = written(&answer.out)["events"].as_array().unwrap().clone();
    let touches = events.iter().filter(|event| event["evidence"].get("barrier").is_some());
    let (mut checked, mut beyond) = (0, 0);
    for event in touches {
        let sides = event["sides"].as_array().unwrap();
        let physical: Vec<bool> = sides.iter().map(|side| side["physical"].as_bool().unwrap()).collect();
        assert!(physical.len() < 2 || physical[0] != physical[1], "{event}");
        for side in sides {
            let omega = number(&side["value"]);
            let found = dir.run(&format!("orbit --scene scene.toml --omega {omega} --json")).with(0, &[]);
            let impulse = number(&event["impulses"][0]);
            let found = written(&found.out);
            let apart = |one: &Value| (number(&one["impacts"][0]["impulse"]) - impulse).abs();
            let solutions = found["solutions"].as_array().unwrap();
            let nearest = solutions.iter().min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap();
            assert_eq!(nearest["physical"], side["physical"], "{side}");
            beyond += usize::from(side["physical"] == false);
            checked += 1;
        }
    }
    assert!(checked >= 2 && beyond >= 1, "{checked} {beyond}");
    assert_eq!(told.matches(": not physical, ").count(), beyond, "{told}");
}

/// Two masses, one of which a dashpot feeds; no load.
const SELF_EXCITED: &str = "word = \"0-\"\n[structure]\nmasses = [1, 2.8]\nstiffness = [[2.5, -1.5], [-1.5, 4.38]]\n\
    damping = [[-0.34, 0], [0, 0.24]]\n[[contact]]\nat = 0\nlower = -1\nrestitution = 0.71\n";

#[test]
fn doubled_self_excited_orbits_end_on_those_of_half_their_period() {
    let dir = TestDir::with_scene(SELF_EXCITED);
    let ask = "branch --scene scene.toml --free contact.0.restitution --from 0.05 --to 0.999 --switch";
    let told = written(&dir.run(&format!("{ask} --json")).with(0, &[]).out);
    let doubled = told["branches"].as_array().unwrap().iter().find(|branch| branch["word"] == "0-,0-").unwrap();
    let end = &doubled["ends"][0];
    assert!(
        end["reason"] == "period-doubling"
            && end["message"].as_str().unwrap().ends_with("on orbits of half its period"),
        "{end}"
    );
    // At the end an orbit of half the period doubles: it has the multiplier -1.
    let place = number(&end["value"]);
    let there = written(
        &dir.run(&format!("orbit --scene scene.toml --set contact.0.restitution={place} --json")).with(0, &[]).out,
    );
    let flips = |solution: &&Value| {
        solution["stability"]["multipliers"]
            .as_array()
            .unwrap()
            .iter()
            .any(|mu| (number(&mu[0]) + 1.0).abs() < 1e-9 && number(&mu[1]) == 0.0)
    };
    assert_eq!(there["solutions"].as_array().unwrap().iter().filter(flips).count(), 1, "{there:#}");
}

#[test]
fn a_number_that_changes_nothing_is_refused_before_any_work() {
    let dir = TestDir::with_scene(SELF_EXCITED);
    let map = "[sweep]\nx = { parameter = \"omega\", from = 1, to = 2, points = 3 }\n[compute]\nfamilies = [\"0-\"]\n";
    fs::write(dir.path("map.toml"), format!("{SELF_EXCITED}{map}")).unwrap();
    let omega = "omega changes nothing here: no load has it";
    for (ask, message) in [
        ("sweep map.toml --out map.csv", omega),
        ("fate map.toml --out fates.csv", omega),
        ("branch --scene scene.toml --free omega", omega),
        ("branch --scene scene.toml --omega 1 --free omega", omega),
        ("locate --scene scene.toml --omega 1 --free omega --event fold", omega),
        ("curve --scene scene.toml --omega 1 --free contact.0.restitution --and omega --event fold", omega),
        ("branch --scene scene.toml --free load", "load changes nothing here: no load changes with time"),
        ("branch --scene scene.toml --free static", "static changes nothing here: there is no static load"),
        ("branch --scene scene.toml --free asymmetry", "asymmetry changes nothing here: no contact has both barriers"),
    ] {
        dir.run(ask).with(2, &[message]);
    }
}

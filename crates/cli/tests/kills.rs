//! Killed at any moment, and told any error by the system at any call: what is there is right, and a resumed run ends in the
//! same bytes as one that was left alone, with nothing besides.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::fs;
use std::process::Command;
use std::time::Instant;

use vibrochain_testkit::{CHUNKS, Desk, Ran, SCENE, undisturbed};

const SWEEP: &str = "sweep scene.toml --out map.csv --quiet --threads 1 --resume";

/// Three chunks in some hundredths of a second.
const SMALL: &str = r#"
[model]
sites = 1
gamma1 = 0.2
asymmetry = 0.4
[sweep]
x = { parameter = "omega", from = 0.5, to = 3.0, points = 36000 }
y = { parameter = "gamma2", values = [0.1, 0.2] }
[compute]
families = ["double-sided"]
"#;

/// Kills a resumed sweep so many times at random moments of its life, and now and then lets it end.
fn killed_at_random(kills: u32, seed: u64) {
    let expected = undisturbed(SCENE);
    let desk = Desk::with_scene(SCENE);
    let mut rng = fastrand::Rng::with_seed(seed);
    // How long it lives undisturbed depends on what else the machine does.
    let started = Instant::now();
    desk.run("sweep scene.toml --out map.csv --quiet --threads 1").with(0, &[]);
    let life = started.elapsed();
    ["map.csv", "map.manifest.json"].iter().for_each(|name| fs::remove_file(desk.path(name)).unwrap());
    let (mut killed, mut met, mut whole) = (0, [false; 2], 0);
    while killed < kills {
        let threads = rng.u8(1..3);
        let mut child = desk.start(&format!("sweep scene.toml --out map.csv --quiet --threads {threads} --resume"));
        std::thread::sleep(life.mul_f64(rng.f64()));
        // What is killed may have ended by itself; then the next run starts afresh.
        if child.try_wait().unwrap().is_none() {
            killed += 1;
            met[0] |= (1..CHUNKS as usize).contains(&desk.chunks("map.csv.parts"));
            met[1] |= desk.names(".").len() > 1;
            child.kill().unwrap();
        }
        let ended = child.wait_with_output().unwrap();
        if ended.status.success() {
            assert_eq!(desk.names("."), ["map.csv", "map.manifest.json", "scene.toml"]);
            whole += 1;
        }
        // A table that is there is whole, whenever the process died.
        if desk.path("map.csv").exists() {
            assert!(desk.read("map.csv") == expected);
            fs::remove_file(desk.path("map.csv")).unwrap();
        }
    }
    assert!(met == [true; 2], "{met:?} {whole}");
    desk.run("sweep scene.toml --out map.csv --quiet --resume").with(0, &[]);
    assert!(desk.read("map.csv") == expected);
    assert_eq!(desk.names("."), ["map.csv", "map.manifest.json", "scene.toml"]);
}

#[test]
fn killed_at_thirty_random_moments_it_ends_in_the_same_bytes() {
    killed_at_random(30, 7);
}

#[test]
#[ignore = "minutes: cargo test -p vibrochain-cli --test kills thousand -- --ignored"]
fn killed_at_a_thousand_random_moments_it_ends_in_the_same_bytes() {
    killed_at_random(1000, 11);
}

/// Runs with a fault at the `number`-th call of this name that a thread makes, where the machine lets us do so: nothing
/// otherwise.
fn faulty(desk: &Desk, line: &str, call: &str, fault: &str, number: usize) -> Option<Ran> {
    let injection = format!("inject=?{call}:{fault}:when={number}");
    let trace = ["-f", "-qqq", "-o", "/dev/null", "-e", &format!("trace=?{call}"), "-e", &injection];
    let program = assert_cmd::cargo::cargo_bin("mapgen");
    let ran =
        Command::new("strace").args(trace).arg(program).args(line.split(' ')).current_dir(desk.path(".")).output();
    let ran: Ran = match ran {
        Ok(output) => output.into(),
        Err(error) => {
            eprintln!("skipped: strace cannot be had ({error})");
            return None;
        }
    };
    if ran.err.contains("strace:") {
        eprintln!("skipped: strace may not trace here ({})", ran.err.trim());
        return None;
    }
    Some(ran)
}

/// Calls that change what others see of files. Systems differ in which of them they rename by.
const CALLS: [&str; 10] =
    ["openat", "flock", "write", "fsync", "rename", "renameat", "renameat2", "unlink", "rmdir", "mkdir"];

/// The calls of one name that are tried: the first ones each, and some of the others.
fn numbers(fault: &str) -> impl Iterator<Item = usize> {
    // Where an error does no harm, nothing tells that there was no such call any more.
    let most = if fault.starts_with("signal") { 60 } else { 8 };
    (1..=8).chain((11..60).step_by(3)).take_while(move |&number| number <= most)
}

/// Runs `line` on a fresh desk with a fault at every call in turn, then undisturbed, and demands that `names` are left and
/// the table is right.
fn at_every_call(fault: &str, calls: &[&str], line: &str, prepare: impl Fn(&Desk), names: &[&str]) {
    let expected = undisturbed(SMALL);
    let (mut met, mut kept) = (0, 0);
    for call in calls {
        for number in numbers(fault) {
            let desk = Desk::with_scene(SMALL);
            prepare(&desk);
            let Some(ran) = faulty(&desk, line, call, fault, number) else { return };
            let place = format!("{fault} at {call} {number}: {ran:?}");
            assert!(matches!(ran.code, None | Some(0..=2)) && !ran.err.contains("panicked"), "{place}");
            let undisturbed = ran.code == Some(0);
            if desk.path("map.csv").exists() {
                assert!(desk.read("map.csv") == expected, "{place}");
            }
            if !undisturbed || desk.names(".") != names {
                kept += desk.chunks("map.csv.parts");
                desk.run(line).with(0, &[]);
            }
            assert!(desk.read("map.csv") == expected, "{place}");
            assert_eq!(desk.names("."), names, "{place}");
            if undisturbed && fault.starts_with("signal") {
                break;
            }
            met += usize::from(!undisturbed);
        }
    }
    println!("{fault}: {met} times, {kept} chunks kept");
    assert!(met >= 10, "{met}");
}

#[test]
fn a_sweep_killed_at_any_system_call_ends_in_the_same_bytes() {
    at_every_call("signal=KILL", &CALLS, SWEEP, |_| {}, &["map.csv", "map.manifest.json", "scene.toml"]);
}

#[test]
fn a_sweep_that_is_told_an_error_ends_in_the_same_bytes() {
    // The loader of the program opens files, too.
    at_every_call("error=EIO", &CALLS[1..], SWEEP, |_| {}, &["map.csv", "map.manifest.json", "scene.toml"]);
}

#[test]
fn a_merge_killed_at_any_system_call_leaves_nothing_that_the_next_one_does_not_remove() {
    let chunks = |desk: &Desk| {
        desk.run("sweep scene.toml --out parts --shard 0/1 --quiet --threads 1").with(0, &[]);
    };
    let names = ["map.csv", "map.manifest.json", "parts", "scene.toml"];
    at_every_call("signal=KILL", &CALLS, "merge parts --out map.csv --quiet", chunks, &names);
}

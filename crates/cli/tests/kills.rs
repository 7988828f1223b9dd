//! Killed at any moment, and told any error by the system at any call: what is there is right, and a resumed run ends in the
//! same bytes as one that was left alone, with nothing besides.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::fmt::Display;
use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use vibrochain_testkit::{CHUNKS, Ran, SCENE, TestDir, interrupts_are_ignored, signal, undisturbed};

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
    let dir = TestDir::with_scene(SCENE);
    let mut rng = fastrand::Rng::with_seed(seed);
    // How long it lives undisturbed depends on what else the machine does.
    let started = Instant::now();
    dir.run("sweep scene.toml --out map.csv --quiet --threads 1").with(0, &[]);
    let life = started.elapsed();
    ["map.csv", "map.manifest.json"].iter().for_each(|name| fs::remove_file(dir.path(name)).unwrap());
    let (mut killed, mut met, mut whole) = (0, [false; 2], 0);
    while killed < kills {
        let threads = rng.u8(1..3);
        let mut child = dir.start(&format!("sweep scene.toml --out map.csv --quiet --threads {threads} --resume"));
        std::thread::sleep(life.mul_f64(rng.f64()));
        // What is killed may have ended by itself; then the next run starts afresh.
        if child.try_wait().unwrap().is_none() {
            killed += 1;
            met[0] |= (1..CHUNKS as usize).contains(&dir.chunks("map.csv.parts"));
            met[1] |= dir.names(".").len() > 1;
            child.kill().unwrap();
        }
        let ended = child.wait_with_output().unwrap();
        if ended.status.success() {
            assert_eq!(dir.names("."), ["map.csv", "map.manifest.json", "scene.toml"]);
            whole += 1;
        }
        // A table that is there is whole, whenever the process died.
        if dir.path("map.csv").exists() {
            assert!(dir.read("map.csv") == expected);
            fs::remove_file(dir.path("map.csv")).unwrap();
        }
    }
    assert!(met == [true; 2], "{met:?} {whole}");
    dir.run("sweep scene.toml --out map.csv --quiet --resume").with(0, &[]);
    assert!(dir.read("map.csv") == expected);
    assert_eq!(dir.names("."), ["map.csv", "map.manifest.json", "scene.toml"]);
}

#[test]
fn killed_at_six_random_moments_it_ends_in_the_same_bytes() {
    killed_at_random(6, 7);
}

#[test]
#[ignore = "a minute: cargo test --workspace --test kills -- --ignored slow"]
fn slow_killed_at_forty_random_moments_it_ends_in_the_same_bytes() {
    killed_at_random(40, 7);
}

#[test]
#[ignore = "minutes: cargo test --workspace --test kills -- --ignored thousand"]
fn slow_killed_at_a_thousand_random_moments_it_ends_in_the_same_bytes() {
    killed_at_random(1000, 11);
}

/// Runs with a fault at calls of this name, by the number that they have for a thread (`3`, or `3+` for all from there on), where the
/// machine lets us do so: nothing otherwise. A run that does not end within half a minute fails the test.
fn faulty(dir: &TestDir, line: &str, call: &str, fault: &str, number: impl Display) -> Option<Ran> {
    let injection = format!("inject=?{call}:{fault}:when={number}");
    let trace = ["-f", "-qqq", "-o", "/dev/null", "-e", &format!("trace=?{call}"), "-e", &injection];
    let program = assert_cmd::cargo::cargo_bin("mapgen");
    let mut command = Command::new("timeout");
    command.args(["-k", "5", "30", "strace"]).args(trace).arg(program).args(line.split(' '));
    let ran = command.current_dir(dir.path(".")).output();
    let ran: Ran = match ran {
        Ok(output) => output.into(),
        Err(error) => {
            eprintln!("skipped: strace cannot be had ({error})");
            return None;
        }
    };
    if ran.err.contains("strace:") || ran.err.contains("timeout:") {
        eprintln!("skipped: strace may not trace here ({})", ran.err.trim());
        return None;
    }
    // Of `timeout` itself: a program that ended by a signal has no code, or 128 and more.
    assert!(ran.code != Some(124), "it does not end: {line} with {fault} at {call} {number}: {ran:?}");
    Some(ran)
}

/// Calls that change what others see of files. Systems differ in which of them they rename by.
const CALLS: [&str; 10] =
    ["openat", "flock", "write", "fsync", "rename", "renameat", "renameat2", "unlink", "rmdir", "mkdir"];

/// The calls of one name that are tried.
#[derive(Debug, Clone, Copy)]
enum Numbers {
    /// The first ones.
    Few,
    /// More of them, and every third of the others.
    Many,
}

impl Numbers {
    fn tried(self, fault: &str) -> impl Iterator<Item = usize> {
        // Where an error does no harm, nothing tells that there was no such call any more.
        let most = match self {
            Self::Few => 4,
            Self::Many if fault.starts_with("signal") => 60,
            Self::Many => 8,
        };
        (1..=8).chain((11..60).step_by(3)).take_while(move |&number| number <= most)
    }
}

/// Runs `line` in a fresh folder with a fault at every call in turn, then undisturbed, and demands that `names` are left and
/// the table is right.
fn at_calls(numbers: Numbers, fault: &str, calls: &[&str], line: &str, prepare: impl Fn(&TestDir), names: &[&str]) {
    let expected = undisturbed(SMALL);
    let (mut met, mut kept) = (0, 0);
    for call in calls {
        for number in numbers.tried(fault) {
            let dir = TestDir::with_scene(SMALL);
            prepare(&dir);
            let Some(ran) = faulty(&dir, line, call, fault, number) else { return };
            let place = format!("{fault} at {call} {number}: {ran:?}");
            assert!(matches!(ran.code, None | Some(0..=2)) && !ran.err.contains("panicked"), "{place}");
            let undisturbed = ran.code == Some(0);
            if dir.path("map.csv").exists() {
                assert!(dir.read("map.csv") == expected, "{place}");
            }
            if !undisturbed || dir.names(".") != names {
                kept += dir.chunks("map.csv.parts");
                dir.run(line).with(0, &[]);
            }
            assert!(dir.read("map.csv") == expected, "{place}");
            assert_eq!(dir.names("."), names, "{place}");
            if undisturbed && fault.starts_with("signal") {
                break;
            }
            met += usize::from(!undisturbed);
        }
    }
    println!("{fault}: {met} times, {kept} chunks kept");
    // A sweep that ended early keeps what it has finished; a merge has no chunks of its own.
    assert!(met >= 10 && (kept > 0 || !line.starts_with("sweep")), "{met} {kept}");
}

const SWEPT: [&str; 3] = ["map.csv", "map.manifest.json", "scene.toml"];

fn sweep_killed(numbers: Numbers) {
    at_calls(numbers, "signal=KILL", &CALLS, SWEEP, |_| {}, &SWEPT);
}

fn sweep_told_an_error(numbers: Numbers) {
    // The loader of the program opens files, too.
    at_calls(numbers, "error=EIO", &CALLS[1..], SWEEP, |_| {}, &SWEPT);
}

fn merge_killed(numbers: Numbers) {
    let chunks = |dir: &TestDir| {
        dir.run("sweep scene.toml --out parts --shard 0/1 --quiet --threads 1").with(0, &[]);
    };
    let names = ["map.csv", "map.manifest.json", "parts", "scene.toml"];
    at_calls(numbers, "signal=KILL", &CALLS, "merge parts --out map.csv --quiet", chunks, &names);
}

#[test]
fn a_sweep_killed_at_a_system_call_ends_in_the_same_bytes() {
    sweep_killed(Numbers::Few);
}

#[test]
#[ignore = "half a minute: cargo test --workspace --test kills -- --ignored slow"]
fn slow_a_sweep_killed_at_any_system_call_ends_in_the_same_bytes() {
    sweep_killed(Numbers::Many);
}

#[test]
fn a_sweep_that_is_told_an_error_ends_in_the_same_bytes() {
    sweep_told_an_error(Numbers::Few);
}

#[test]
#[ignore = "half a minute: cargo test --workspace --test kills -- --ignored slow"]
fn slow_a_sweep_that_is_told_any_error_ends_in_the_same_bytes() {
    sweep_told_an_error(Numbers::Many);
}

/// What the loader of the program is told comes first: it may not begin at all.
#[test]
fn a_folder_that_cannot_be_closed_is_no_panic() {
    let mut done = 0;
    for number in 3..=30 {
        let dir = TestDir::with_scene(SMALL);
        let Some(ran) = faulty(&dir, SWEEP, "close", "error=EIO", number) else { return };
        let loader = ran.code == Some(127);
        assert!(loader || matches!(ran.code, Some(0..=2)) && !ran.err.contains("panicked"), "{number}: {ran:?}");
        done += u32::from(ran.code == Some(0));
    }
    assert!(done > 10, "{done}");
}

/// A stale mount tells nothing of any file, for as long as the program asks.
#[test]
fn a_file_system_that_tells_nothing_is_an_error_and_no_loop() {
    let mut told = 0;
    for number in 1..=24 {
        let dir = TestDir::with_scene(SMALL);
        let Some(ran) = faulty(&dir, SWEEP, "statx", "error=ESTALE", format!("{number}+")) else { return };
        assert!(matches!(ran.code, Some(0..=2)) && !ran.err.contains("panicked"), "{number}: {ran:?}");
        told += u32::from(ran.code != Some(0));
    }
    assert!(told > 3, "{told}");
}

#[test]
fn a_merge_killed_at_a_system_call_leaves_nothing_that_the_next_one_does_not_remove() {
    merge_killed(Numbers::Few);
}

#[test]
#[ignore = "half a minute: cargo test --workspace --test kills -- --ignored slow"]
fn slow_a_merge_killed_at_any_system_call_leaves_nothing_that_the_next_one_does_not_remove() {
    merge_killed(Numbers::Many);
}

#[test]
fn a_merge_that_is_interrupted_while_it_checks_chunks_ends_at_once() {
    let dir = TestDir::with_scene(SCENE);
    dir.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    let merge = |dir: &TestDir, slow: &str| {
        let mut command = Command::new("strace");
        // The tracer is not the parent (-D): a signal to the child reaches the program.
        command.args(["-D", "-f", "-qqq", "-o", "trace", "-e", "trace=read", "-e", &format!("inject=read:{slow}")]);
        for chunk in dir.names("parts").iter().filter(|name| name.ends_with(".chunk")) {
            command.arg("-P").arg(dir.path(&format!("parts/{chunk}")));
        }
        command.arg(assert_cmd::cargo::cargo_bin("mapgen")).args("merge parts --out map.csv --quiet".split(' '));
        command.current_dir(dir.path(".")).stdout(Stdio::null()).stderr(Stdio::piped()).spawn()
    };
    let Ok(whole) = merge(&dir, "delay_enter=0") else {
        eprintln!("skipped: strace cannot be had");
        return;
    };
    let whole = Ran::from(whole.wait_with_output().unwrap());
    if whole.err.contains("strace:") {
        eprintln!("skipped: strace may not trace here ({})", whole.err.trim());
        return;
    }
    whole.with(0, &[]);
    let reads = || fs::read_to_string(dir.path("trace")).unwrap_or_default().lines().count();
    let all = reads();
    ["map.csv", "map.manifest.json", "trace"].iter().for_each(|name| fs::remove_file(dir.path(name)).unwrap());

    if interrupts_are_ignored() {
        eprintln!("skipped: interrupts are ignored here");
        return;
    }
    // A slow disk: a tenth of a second for each read. The tracer writes its lines by the hundred.
    let mut child = merge(&dir, "delay_enter=100000").unwrap();
    let begun = Instant::now();
    while reads() == 0 && child.try_wait().unwrap().is_none() {
        assert!(begun.elapsed() < Duration::from_secs(60), "no chunk is read");
        std::thread::sleep(Duration::from_millis(10));
    }
    let ran = signal(child, "INT");
    println!("{} of {all} reads of chunks, {ran:?}", reads());
    ran.with(130, &["interrupted"]);
    assert!(reads() < all / 4, "{} of {all}", reads());
    assert_eq!(dir.names("."), ["parts", "scene.toml", "trace"]);
}

//! Every command that computes for long is told to stop at a random moment: it ends soon, with 130 and a word, and leaves nothing behind.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::fs;
use std::process::Child;
use std::thread::sleep;
use std::time::{Duration, Instant};

use fastrand::Rng;
use vibrochain_testkit::{TestDir, signal};

/// A ring on which every command has minutes to do.
const RING: &str = "--sites 301 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4";

/// Scenes of as much work.
const SCENES: [(&str, &str); 3] = [
    (
        "large.toml",
        "[model]\nsites = 301\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
         x = { parameter = \"omega\", from = 0.9, to = 2.2, points = 40 }\n\
         y = { parameter = \"gamma2\", from = 0.02, to = 0.2, points = 30 }\n\
         [compute]\nfamilies = [\"double-sided\", \"single-sided\"]\nstability = true\n",
    ),
    (
        "fine.toml",
        "[model]\nsites = 101\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
         x = { parameter = \"omega\", from = 0.9, to = 2.2, points = 3000 }\n\
         y = { parameter = \"gamma2\", from = 0.02, to = 0.2, points = 3000 }\n\
         [compute]\nfamilies = [\"double-sided\", \"single-sided\"]\nstability = true\n",
    ),
    (
        "word.toml",
        "[model]\nsites = 7\ngamma1 = 0.2\nasymmetry = 0.2\nforcing = { amplitude = 0.3, restitution = 0.8 }\n[sweep]\n\
         x = { parameter = \"omega\", from = 0.9, to = 2.2, points = 300 }\n\
         y = { parameter = \"gamma2\", from = 0.01, to = 0.2, points = 300 }\n\
         [compute]\nfamilies = [\"0+1+,0-1-\"]\nstability = true\n",
    ),
];

/// Lines of every command that may take long, each with files to write; `RING` stands for the ring.
const LINES: [&str; 14] = [
    "sweep fine.toml --out a.csv --png a.png",
    "sweep fine.toml --out - --png a.png",
    "curves large.toml --places 0 --csv a.csv --points b.csv --plot a.png",
    "curves word.toml --csv a.csv --plot a.svg",
    "stripes fine.toml --plot a.png --csv a.csv --widths b.csv",
    "stripes large.toml --plot a.png --csv a.csv --widths b.csv",
    "locate RING --family double-sided --event neimark-sacker --free omega --from .8 --to 2.2 --csv a.csv",
    "branch RING --family double-sided --free omega --from .8 --to 2.2 --csv a.csv --plot a.png",
    "curve RING --family double-sided --event neimark-sacker --free omega --and gamma2 --csv a.csv --plot a.png",
    "orbit --sites 999 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .2 --amplitude .3 --restitution .8 --word 0+4+,0-4- --multipliers a.csv",
    "words RING --sites-used 3 --reach 6 --csv a.csv",
    "simulate RING --family double-sided --periods 1e6 --impacts a.csv --plot a.png",
    "simulate --sites 999 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .2 --amplitude .3 --restitution .8 --word 0+4+,0-4- --periods 1e7 --impacts a.csv",
    "fate large.toml --starts 10 --periods 1000 --csv a.csv --plot a.png",
];

/// What may wait for a program that ends soon, on a machine that does much else.
const PATIENCE: Duration = Duration::from_secs(60);

/// Waits until the program listens to the signal: before, whoever starts it has it end as any other.
fn listens(child: &mut Child) -> bool {
    let begun = Instant::now();
    let status = format!("/proc/{}/status", child.id());
    while child.try_wait().unwrap().is_none() {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let caught = text.lines().find_map(|line| line.strip_prefix("SigCgt:"));
        // SIGTERM is number 15.
        if caught.is_some_and(|mask| u64::from_str_radix(mask.trim(), 16).unwrap() >> 14 & 1 == 1) {
            return true;
        }
        assert!(begun.elapsed() < PATIENCE, "no handler of signals is installed");
        sleep(Duration::from_millis(1));
    }
    false
}

/// Sends the signal to each line after a random time, up to so many seconds, so many times. How many were at work then.
fn at_random(lines: &[&str], times: u32, most: f64, seed: u64) -> u32 {
    let (mut random, mut stopped) = (Rng::with_seed(seed), 0);
    for line in lines {
        for _ in 0..times {
            let dir = TestDir::new();
            for (name, text) in SCENES {
                fs::write(dir.path(name), text).unwrap();
            }
            let inputs = dir.names(".");
            let line = line.replace("RING", RING);
            let mut child = dir.start(&format!("{line} --threads 1"));
            let at_work = listens(&mut child);
            // Short times as often as long ones.
            sleep(Duration::from_secs_f64(most * random.f64().powi(2)));
            if !at_work || child.try_wait().unwrap().is_some() {
                let ended = child.wait_with_output().unwrap();
                assert!(ended.status.success(), "{line}: {ended:?}");
                continue;
            }
            let begun = Instant::now();
            let ran = signal(child, "TERM");
            println!("{:.2} s  {line}", begun.elapsed().as_secs_f64());
            // It may have been done just then.
            if ran.code == Some(0) {
                continue;
            }
            assert!(begun.elapsed() < PATIENCE, "{line}");
            ran.with(130, &["interrupted"]);
            stopped += 1;
            // A table in chunks goes on by --resume, a run is kept as far as it came.
            let kept = |name: &String| name == "a.csv.parts" || line.starts_with("simulate");
            let left: Vec<String> = dir.names(".").into_iter().filter(|name| !inputs.contains(name)).collect();
            assert!(left.iter().all(|name| !name.starts_with('.') && kept(name)), "{line}: {left:?}");
        }
    }
    stopped
}

#[test]
fn every_command_hears_a_signal_at_a_random_moment() {
    let stopped = at_random(&LINES, 1, 0.5, 5);
    assert!(stopped as usize >= LINES.len() - 3, "{stopped}");
}

#[test]
#[ignore = "minutes: cargo test --workspace --test signals -- --ignored slow"]
fn slow_every_command_hears_a_signal_at_many_random_moments() {
    let stopped = at_random(&LINES, 12, 8.0, 17);
    assert!(stopped as usize >= 8 * LINES.len(), "{stopped}");
}

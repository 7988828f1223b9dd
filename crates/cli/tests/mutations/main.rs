//! Damaged scenes, states and command lines, each run in this process: whatever is asked, the program ends with exit code
//! 0, 1, 2 or 3, says why, and never tells a number that is none. Every input follows from the seed and its own number.
//! Some of them, of all commands, are run by the real program under a limit of memory and of time.
//!
//! Two thousand are tried always, fifty thousand by the test `slow_…`. `MUTATIONS` (how many), `MUTATIONS_LIMITED` (how
//! many under limits), `MUTATIONS_SEED` and `MUTATIONS_WORK` (0: nothing is computed) make longer campaigns:
//!
//! ```sh
//! MUTATIONS=1000000 MUTATIONS_SEED=7 MUTATIONS_WORK=0 cargo test --workspace --test mutations -- --ignored fifty
//! ```
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod inputs;
mod judge;
mod limits;
mod mutate;
mod plan;
mod run;

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use inputs::Input;
use judge::{complaints, file_complaints};
use plan::{Plan, WORK, plan};
use run::{TestDir, mapgen};

const COUNT: u64 = 50_000;
/// Of these, what there is always time for.
const FEW: u64 = 2_000;
const SEED: u64 = 20_240_229;

fn setting(name: &str, default: u64) -> u64 {
    std::env::var(name).map_or(default, |value| value.parse().unwrap())
}

#[test]
fn thousands_of_damaged_requests() {
    damaged_requests(FEW);
}

#[test]
#[ignore = "a minute: cargo test --workspace --test mutations -- --ignored slow"]
fn slow_fifty_thousand_damaged_requests() {
    damaged_requests(setting("MUTATIONS", COUNT));
}

fn damaged_requests(count: u64) {
    let seed = setting("MUTATIONS_SEED", SEED);
    let work = setting("MUTATIONS_WORK", WORK as u64) as f64;
    let dir = TestDir::new();
    let outputs = ["map.csv", "map.manifest.json", "impacts.csv", "trajectory.csv"];
    // Runs by subcommand and exit code.
    let mut ran = [[0_u64; 4]; 4];
    let (mut planned, mut wrong, mut slowest) = ([0_u64; 3], Vec::new(), (0.0, 0));
    // One input alone, to look at it closely.
    let only = std::env::var("MUTATIONS_ONLY").ok().map(|number| number.parse::<u64>().unwrap());
    for number in only.map_or(0..count, |number| number..number + 1) {
        let input = Input::new(seed, number);
        if only.is_some() {
            println!("{}", input.tell());
        }
        dir.lay_out(&input);
        let plan = plan(&input.line, work);
        planned[plan as usize] += 1;
        if plan == Plan::Parameters {
            continue;
        }
        let started = std::time::Instant::now();
        let stopped = plan == Plan::Stopped;
        let mut complaint = match catch_unwind(AssertUnwindSafe(|| mapgen(&input.line, stopped))) {
            Ok(outcome) => {
                let commands = ["sweep", "orbit", "simulate", "merge"];
                let command = input.line.get(1).and_then(|word| commands.iter().position(|name| word == name));
                if let (Some(command), 0..4) = (command, outcome.code) {
                    ran[command][usize::from(outcome.code)] += 1;
                }
                let complaint = complaints(&outcome, stopped);
                if complaint.is_empty() { complaint } else { format!("{complaint}{outcome:?}\n") }
            }
            Err(_) => "panicked\n".to_owned(),
        };
        for name in outputs {
            if !Path::new(name).exists() {
                continue;
            }
            complaint.push_str(&file_complaints(Path::new(name)));
            // What is judged once need not be judged again.
            let _ = fs::remove_file(name);
        }
        let took = started.elapsed().as_secs_f64();
        if took > slowest.0 {
            slowest = (took, number);
        }
        if !complaint.is_empty() {
            wrong.push(format!("input {number}: {complaint}{}", input.tell()));
        }
    }
    println!("{count} inputs of seed {seed}: run, stopped, parameters only {planned:?}");
    println!("exit codes 0 to 3 of sweep, orbit, simulate, merge: {ran:?}; slowest {slowest:?}");
    let shown: Vec<_> = wrong.iter().take(12).cloned().collect();
    assert!(wrong.is_empty(), "{} inputs went wrong:\n{}", wrong.len(), shown.join("\n=====\n"));
    // The damage is not so heavy that nothing would be computed, nor so light that nothing would be refused.
    if work == WORK && only.is_none() {
        // Of a hundred thousand, and in proportion.
        let least = [[1000, 0, 1000, 0], [1000, 0, 1000, 1], [1000, 0, 1000, 100], [10, 100, 100, 0]];
        for (ran, least) in ran.iter().flatten().zip(least.iter().flatten()) {
            assert!(*ran >= least * count / 100_000, "{ran} of {least}");
        }
    }
}

#[test]
fn the_real_program_says_the_same() {
    let dir = TestDir::new();
    let program = assert_cmd::cargo::cargo_bin("mapgen");
    let mut compared = 0;
    for number in 0.. {
        let input = Input::new(SEED + 1, number);
        dir.lay_out(&input);
        if plan(&input.line, WORK) != Plan::Whole {
            continue;
        }
        let real = std::process::Command::new(&program).args(&input.line[1..]).output().unwrap();
        dir.lay_out(&input);
        let outcome = mapgen(&input.line, false);
        assert_eq!(real.status.code(), Some(i32::from(outcome.code)), "{}", input.tell());
        // Help is an answer, and clap prints it as one. What a sweep took is not the same twice.
        let told = String::from_utf8(real.stdout).unwrap() + &String::from_utf8(real.stderr).unwrap();
        if !told.contains(" per cell and core") {
            assert_eq!(told, outcome.out + &outcome.message, "{}", input.tell());
        }
        compared += 1;
        if compared == 60 {
            break;
        }
    }
}

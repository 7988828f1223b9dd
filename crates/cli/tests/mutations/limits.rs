//! Requests that the real program answers within limits of memory and time.
#![cfg(unix)]

use std::ffi::OsString;
use std::fs;

use crate::inputs::Input;
use crate::judge::{Outcome, complaints};
use crate::plan::{Plan, WORK, plan};
use crate::run::TestDir;
use crate::{SEED, setting};

/// Requests that are run under limits.
const LIMITED: u64 = 120;

/// Of these, what there is always time for: every one that is cut short takes a second.
const LIMITED_FEW: u64 = 40;

/// Address space of a run, in KiB: a gigabyte and a half, threads and all.
const MEMORY: u64 = 3 << 19;

/// Processor time of a run, in seconds: much more than any takes that can be told to be short, and a moment of the others.
const SECONDS: [u64; 2] = [30, 1];

/// How the real program ended within these limits; nothing if its time was up.
fn limited(line: &[OsString], seconds: u64) -> Result<Option<Outcome>, String> {
    use std::os::unix::process::ExitStatusExt;
    let ran = std::process::Command::new("sh")
        .args(["-c", &format!("ulimit -v {MEMORY}; ulimit -t {seconds}; exec \"$0\" \"$@\"")])
        .arg(assert_cmd::cargo::cargo_bin("mapgen"))
        .args(&line[1..])
        .stdin(std::process::Stdio::null())
        .output()
        .map_err(|error| error.to_string())?;
    let told = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    // SIGKILL and SIGXCPU: whose time is up gets either.
    match (ran.status.code(), ran.status.signal()) {
        (_, Some(9 | 24)) => Ok(None),
        (Some(code), _) if told(&ran.stderr).contains("panicked at") => Err(format!("{code}: {}", told(&ran.stderr))),
        (Some(code @ (0..=3 | 130)), _) => {
            Ok(Some(Outcome { code: code as u8, out: told(&ran.stdout), message: told(&ran.stderr) }))
        }
        _ => Err(format!("{}: {}", ran.status, told(&ran.stderr))),
    }
}

#[test]
fn requests_of_all_commands_keep_within_memory_and_time() {
    requests_under_limits(LIMITED_FEW);
}

#[test]
#[ignore = "a minute: cargo test --workspace --test mutations -- --ignored slow"]
fn slow_a_hundred_requests_of_all_commands_keep_within_memory_and_time() {
    requests_under_limits(setting("MUTATIONS_LIMITED", LIMITED));
}

fn requests_under_limits(count: u64) {
    let seed = setting("MUTATIONS_SEED", SEED);
    let dir = TestDir::new();
    let (mut ended, mut cut, mut wrong) = ([0_u64; 4], 0, Vec::new());
    for number in 0..count {
        for entry in fs::read_dir(dir.folder.path()).unwrap().flatten() {
            if entry.file_type().unwrap().is_file() {
                fs::remove_file(entry.path()).unwrap();
            }
        }
        let input = Input::of_all_commands(seed, number);
        dir.lay_out(&input);
        let short = plan(&input.line, WORK) == Plan::Whole;
        match limited(&input.line, SECONDS[usize::from(!short)]) {
            Ok(Some(outcome)) => {
                if let Some(count) = ended.get_mut(usize::from(outcome.code)) {
                    *count += 1;
                }
                let complaint = complaints(&outcome, false);
                if !complaint.is_empty() {
                    wrong.push(format!("input {number}: {complaint}{outcome:?}\n{}", input.tell()));
                }
            }
            Ok(None) if short => wrong.push(format!("input {number}: out of time\n{}", input.tell())),
            Ok(None) => cut += 1,
            Err(how) => wrong.push(format!("input {number}: {how}\n{}", input.tell())),
        }
    }
    println!("{count} requests of seed {seed}: exit codes 0 to 3 {ended:?}, {cut} cut short");
    let shown: Vec<_> = wrong.iter().take(6).cloned().collect();
    assert!(wrong.is_empty(), "{} requests went wrong:\n{}", wrong.len(), shown.join("\n=====\n"));
    // Of 120, and in proportion.
    let least = |most: u64| most * count / LIMITED;
    let enough = [ended[0] > least(10), ended[1] + ended[3] > least(1), ended[2] > least(30)];
    assert!(enough == [true; 3], "{ended:?} {cut}");
}

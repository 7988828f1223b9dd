//! What the program does when its reader goes away, when a signal comes while nobody reads, and with names that a shell would split.
#![cfg(unix)]

use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use vibrochain_testkit::{SCENE, TestDir, signal};

use super::destinations::{POINT, is_pipe, large, make_pipe, small};

#[test]
fn a_reader_that_goes_away_ends_the_work() {
    let dir = TestDir::with_scene(&large());
    // Of standard output it has seen enough.
    let begun = Instant::now();
    let ran = dir.shell("{ mapgen sweep scene.toml --out -; echo code $? >&2; } | head -n 1").with(0, &["code 0\n"]);
    assert_eq!(ran.out, "gamma2,omega,class,mechanism,spectral_radius,margin,solutions,status\n");
    assert_eq!(ran.err, "code 0\n");
    // Of a pipe with a name somebody wanted all.
    make_pipe(&dir, "pipe");
    let line = "head -n 1 pipe > got & mapgen sweep scene.toml --out pipe --quiet";
    dir.shell(line).with(1, &["error: could not write pipe: Broken pipe"]);
    assert!(is_pipe(&dir, "pipe") && begun.elapsed() < Duration::from_secs(120));
    let state = r#"{"displacement":[0,0,0,0,0,0],"velocity":[0.5,0,0,0,0,0]}"#;
    fs::write(dir.path("state.json"), state).unwrap();
    let simulate = format!("mapgen simulate --state state.json {POINT} --periods 1000000 --trajectory -");
    let ran = dir.shell(&format!("{{ {simulate}; echo code $? >&2; }} | head -n 2")).with(0, &["code 0\n"]);
    assert_eq!((ran.out.lines().count(), ran.err.as_str()), (2, "code 0\n"));
    assert_eq!(dir.names("."), ["got", "pipe", "scene.toml", "state.json"]);
}

#[test]
fn a_signal_is_heard_while_nobody_reads() {
    let dir = TestDir::with_scene(&large());
    make_pipe(&dir, "pipe");
    let wait = |child: std::process::Child| {
        std::thread::sleep(Duration::from_millis(1500));
        signal(child, "TERM")
    };
    // Nobody has come.
    wait(dir.start("sweep scene.toml --out pipe --quiet")).with(130, &["interrupted"]);
    // Somebody has, and does not read.
    let mut reader = Command::new("sh");
    reader.current_dir(dir.path(".")).args(["-c", "exec sleep 100 < pipe"]);
    let mut reader = reader.spawn().unwrap();
    let ran = wait(dir.start("sweep scene.toml --out pipe --quiet"));
    reader.kill().unwrap();
    reader.wait().unwrap();
    ran.with(130, &["interrupted"]);
    // The same for standard output.
    let mut command = dir.command("sweep scene.toml --out - --quiet");
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let unread = child.stdout.take();
    wait(child).with(130, &["interrupted"]);
    drop(unread);
    assert_eq!(dir.names("."), ["pipe", "scene.toml"]);
    assert!(is_pipe(&dir, "pipe"));
}

/// As under `nohup`, and as in the background of a script.
#[cfg(target_os = "linux")]
#[test]
fn a_signal_that_is_ignored_at_the_start_stays_so() {
    for (name, line) in [
        ("HUP", "sweep scene.toml --out map.csv --quiet"),
        ("INT", "sweep scene.toml --out map.csv --quiet"),
        ("HUP", "sweep scene.toml --out map.csv.parts --shard 0/1 --quiet"),
    ] {
        let dir = TestDir::with_scene(&large());
        let program = assert_cmd::cargo::cargo_bin("mapgen");
        let mut command = Command::new("sh");
        let script = format!("trap '' {name}; exec {} {line}", program.display());
        command.current_dir(dir.path(".")).args(["-c", &script]).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        dir.await_chunks(&mut child, "map.csv.parts", 2);
        let (id, seen) = (child.id().to_string(), dir.chunks("map.csv.parts"));
        assert!(Command::new("kill").args([&format!("-{name}"), &id]).status().unwrap().success());
        dir.await_chunks(&mut child, "map.csv.parts", seen + 3);
        assert!(child.try_wait().unwrap().is_none(), "{name} ended it");
        signal(child, "TERM").with(130, &["interrupted"]);
    }
}

#[test]
fn numbers_out_of_range_are_told_in_few_digits() {
    let dir = TestDir::with_scene(SCENE);
    let point = |from: &str, to: &str| format!("orbit --family double-sided {}", POINT.replacen(from, to, 1));
    let forced = format!("{POINT} --restitution .9");
    let mut lines = vec![
        point("--gamma1 .2", "--gamma1 1e300"),
        point("--gamma1 .2", "--gamma1=-1e300"),
        point("--gamma2 .1", "--gamma2=-1e-300"),
        point("--omega 1.5", "--omega 1e300"),
        point("--asymmetry .4", "--asymmetry=-1e-300"),
        format!("orbit --family double-sided {forced} --force 1:-1e300"),
        format!("orbit --family double-sided {forced} --amplitude=-1e300"),
        format!("orbit --family double-sided {POINT} --threshold=-1e300"),
        format!("locate --event fold --free gamma2 --family double-sided {POINT} --from 1e-300 --to 2e-300"),
    ];
    let scenes = [
        ("gamma1 = 0.2", "gamma1 = -1e300"),
        ("from = 0.4, to = 3.0", "from = 1e300, to = 3.0"),
        ("from = 0.0, to = 0.3, points = 300", "values = [1e300, 1e300]"),
        ("[compute]", "[compute]\nstability = true\nthreshold = -1e300"),
    ];
    for (i, (from, to)) in scenes.into_iter().enumerate() {
        assert!(SCENE.contains(from));
        fs::write(dir.path(&format!("{i}.toml")), SCENE.replacen(from, to, 1)).unwrap();
        lines.push(format!("sweep {i}.toml --out map.csv"));
    }
    for line in lines {
        let ran = dir.run(&line).with(2, &[]);
        assert!(ran.err.contains("e300") || ran.err.contains("e-300"), "{ran:?}");
        assert!(!ran.err.contains(&"0".repeat(30)), "{ran:?}");
    }
}

/// The script that submits a sweep to Slurm, with a scheduler of its own that runs everything at once.
#[test]
fn names_with_blanks_and_quotes_reach_the_tasks_of_a_job_array() {
    let (scene, map) = ("a 'scene', $HOME.toml", "bob's \"map\" \\ $(x).csv");
    let dir = small();
    fs::rename(dir.path("scene.toml"), dir.path(scene)).unwrap();
    let scheduler = r#"#!/bin/sh
for word; do
    case $word in
        --wrap=*) sh -c "${word#--wrap=}" >> "$LOG" 2>&1 || exit 1; echo 2; exit 0 ;;
        --array=0-1) array=yes ;;
    esac
done
[ "$array" = yes ] || exit 1
while [ "${1#-}" != "$1" ]; do shift; done
for task in 0 1; do
    SLURM_ARRAY_TASK_ID=$task SLURM_ARRAY_TASK_MIN=0 SLURM_ARRAY_TASK_MAX=1 bash "$@" >> "$LOG" 2>&1 || exit 1
done
echo 1
"#;
    fs::create_dir(dir.path("bin")).unwrap();
    fs::write(dir.path("bin/sbatch"), scheduler).unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scripts/slurm-sweep.sbatch");
    fs::copy(script, dir.path("submit")).unwrap();
    let quoted = |name: &str| format!("'{}'", name.replace('\'', r"'\''"));
    let line = format!(
        "chmod +x bin/sbatch; export LOG=\"$PWD/log\" PATH=\"$PWD/bin:$PATH\"; bash submit {} {} 2 --time=1",
        quoted(scene),
        quoted(map)
    );
    let ran = dir.shell(&line);
    let log = fs::read_to_string(dir.path("log")).unwrap_or_default();
    assert!(ran.code == Some(0) && ran.out.ends_with("array 1 of 2 tasks, merge 2\n"), "{ran:?} {log}");
    dir.run("merge parts --out expected.csv --quiet").with(0, &[]);
    assert!(dir.read(map) == dir.read("expected.csv"), "{log}");
}

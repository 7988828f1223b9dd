//! What a request may cost before it is looked at, and what of it is shown, is bounded: lines and files of any length, any
//! number of threads or tasks, names that a terminal would obey.

use std::fmt::Write as _;
use std::fs;

use vibrochain_testkit::{Ran, SCENE, TestDir};

#[test]
fn an_error_anywhere_in_a_line_of_any_length_shows_its_place() {
    let line = "x = { parameter = \"omega\", from = 0.4, to = 3.0, points = 1600 }";
    for before in [0, 100, 65_500, 65_600, 3_000_000] {
        let values = "1.5,".repeat(before / 4);
        let dir = TestDir::with_scene(&SCENE.replace(line, &format!("x = {{ values = [{values} \"here\"] }}")));
        let ran = dir.run("sweep scene.toml --dry-run").with(2, &["scene.toml:7:", "\"here\"", "^"]);
        let lines: Vec<Vec<char>> = ran.err.lines().map(|line| line.chars().collect()).collect();
        let shown = lines.iter().position(|line| line.ends_with(&['^'])).unwrap();
        let place = lines[shown].len() - 1;
        assert_eq!(lines[shown - 1][place..place + 6].iter().collect::<String>(), "\"here\"");
        assert!(lines.iter().all(|line| line.len() < 120), "{ran:?}");
    }
    // A word of any length.
    let dir = TestDir::with_scene(&SCENE.replace("omega", &"é".repeat(1_000_000)));
    let ran = dir.run("sweep scene.toml --dry-run").with(2, &["cannot be swept", "scene.toml:7:"]);
    assert!(ran.err.len() < 4000, "{}", ran.err.len());
}

#[test]
fn a_scene_is_read_no_further_than_it_may_be_long() {
    let mut values = String::new();
    for i in 0..10_000_000 {
        let _ = write!(values, "{}.5,", 1_000_000 + i);
    }
    let line = "x = { parameter = \"omega\", from = 0.4, to = 3.0, points = 1600 }";
    let long = SCENE.replace(line, &format!("x = {{ parameter = \"omega\", values = [{values}] }}"));
    let told = "scene scene.toml has more than the 8388608 bytes that it may have";
    for text in [&long, &format!("# {}\n{SCENE}", "-".repeat(8 << 20))] {
        let dir = TestDir::with_scene(text);
        dir.run("sweep scene.toml --out map.csv").with(2, &[told]);
        // In as little memory as any other run, where the shell can limit it.
        if cfg!(target_os = "linux") {
            dir.shell("ulimit -v 400000; exec mapgen sweep scene.toml --dry-run --threads 1").with(2, &[told]);
        }
    }
}

/// Four million numbers of one digit take the most memory for their length: 0.8 GB, where the shell can limit it.
#[test]
#[cfg(target_os = "linux")]
fn the_longest_scene_of_a_structure_is_read_in_a_gigabyte() {
    let head = "omega = 1\nword = \"0+\"\n[structure]\nmasses = [1]\nstiffness = [[";
    let tail = "1]]\n[[contact]]\nat = 0\nupper = 1\n";
    let numbers = "1,".repeat(((8 << 20) - head.len() - tail.len()) / 2);
    let dir = TestDir::with_scene(&format!("{head}{numbers}{tail}"));
    let told = "the stiffness matrix has 4194258 entries where the structure needs 1";
    dir.shell("ulimit -v 1000000; exec mapgen orbit --scene scene.toml").with(2, &[told]);
}

#[test]
fn values_that_differ_are_named_and_not_listed() {
    let list = |first: f64| -> String {
        let values: Vec<String> = (0..20_000).map(|i| (first + f64::from(i)).to_string()).collect();
        SCENE.replace("from = 0.0, to = 0.3, points = 300", &format!("values = [{}]", values.join(",")))
    };
    let dir = TestDir::with_scene(&list(0.25));
    dir.run("sweep scene.toml --out parts --shard 100000/100001 --quiet").with(0, &[]);
    fs::write(dir.path("scene.toml"), list(0.75)).unwrap();
    let ran = dir.run("sweep scene.toml --out parts --shard 100000/100001 --resume");
    let ran = ran.with(2, &["sweep.y.values is [0.25,1.25,", "19999.25] there, [0.75,1.75,"]);
    assert!(ran.err.len() < 500, "{ran:?}");
}

#[test]
fn threads_are_limited_whoever_asks_for_them() {
    let dir = TestDir::with_scene(SCENE);
    dir.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    for line in ["sweep scene.toml --out map.csv", "sweep scene.toml --dry-run", "merge parts --out map.csv"] {
        let ran: Ran = dir.command(line).env("RAYON_NUM_THREADS", "100000").output().unwrap().into();
        ran.with(2, &["RAYON_NUM_THREADS 100000 is out of range: give a whole number from 1 to 1024"]);
        assert!(!dir.path("map.csv").exists());
    }
    let ran: Ran = dir.command("sweep scene.toml --out map.csv").env("RAYON_NUM_THREADS", "1").output().unwrap().into();
    ran.with(0, &[" s on 1 thread,"]);
}

#[test]
fn an_array_of_more_tasks_than_can_be_counted_is_refused() {
    let dir = TestDir::with_scene(SCENE);
    let mut command = dir.command("sweep scene.toml --out parts --shard slurm");
    for (name, value) in [("ID", "5"), ("MIN", "0"), ("MAX", "18446744073709551615")] {
        command.env(format!("SLURM_ARRAY_TASK_{name}"), value);
    }
    Ran::from(command.output().unwrap()).with(2, &["the job array has gaps"]);
}

#[test]
fn names_from_files_of_others_reach_no_terminal_raw() {
    let dir = TestDir::with_scene(SCENE);
    dir.run("sweep scene.toml --out parts --shard 0/2 --quiet").with(0, &[]);
    let plan = fs::read_to_string(dir.path("parts/plan.json")).unwrap();
    let forge = |from: &str, to: &str| {
        assert!(plan.contains(from));
        fs::write(dir.path("parts/plan.json"), plan.replace(from, to)).unwrap();
        let ran = dir.run("merge parts --out map.csv");
        assert!(!ran.err.chars().any(|c| c.is_control() && c != '\n' || c == '\u{202e}'), "{ran:?}");
        ran
    };
    forge("\"scene.toml\"", r#""\u001b]0;title\u0007\u001b[2Jit's\u202e.toml""#)
        .with(1, &[r"mapgen sweep $'\033]0;title\007\033[2Jit\'s\342\200\256.toml' --out parts"]);
    forge("\"format\"", r#""form\u001b[31mat""#).with(2, &["it is damaged ("]);
    forge("gamma1 = 0.2", r"gamma1 = \u001b[31m").with(2, &["its scene cannot be read by this version"]);
    forge("families =", r"famil\u001b[31mies =").with(2, &["its scene cannot be read by this version"]);
}

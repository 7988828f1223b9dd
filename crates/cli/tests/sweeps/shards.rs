//! A sweep shared by many processes is one table.

use std::fs;

use serde_json::Value;
use vibrochain_testkit::{CHUNKS, Ran, SCENE, TestDir, undisturbed};

#[test]
fn shards_and_threads_do_not_change_a_byte() {
    shared_among(&[(1, 2), (7, 1)]);
}

#[test]
#[ignore = "half a minute: cargo test --workspace --test sweeps -- --ignored shards::slow"]
fn slow_all_shards_and_threads_do_not_change_a_byte() {
    shared_among(&[(1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (3, 2), (7, 1), (7, 2)]);
}

/// Shards and threads of each.
fn shared_among(ways: &[(u64, u64)]) {
    let dir = TestDir::with_scene(SCENE);
    dir.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
    // What a run took is its own.
    let manifest = |name: &str| -> Value {
        let mut manifest = dir.json(name);
        for key in ["threads", "computed_cells", "wall_seconds"] {
            manifest.as_object_mut().unwrap().remove(key);
        }
        manifest
    };
    for &(shards, threads) in ways {
        let folder = format!("parts-{shards}-{threads}");
        // The last first: order is of no account.
        for shard in (0..shards).rev() {
            let line = format!("sweep scene.toml --out {folder} --shard {shard}/{shards} --threads {threads}");
            let chunks = (CHUNKS - shard).div_ceil(shards);
            dir.run(&line).with(0, &[&format!("shard {shard}/{shards}: {chunks} of 15 chunks in {folder}")]);
        }
        dir.run(&format!("merge {folder} --out {folder}.csv")).with(0, &["480000 cells (1600 × 300)"]);
        assert!(dir.read(&format!("{folder}.csv")) == dir.read("map.csv"), "{folder}");
        assert_eq!(manifest(&format!("{folder}.manifest.json")), manifest("map.manifest.json"));
        // The chunks are left to whoever asked for them.
        assert_eq!(dir.chunks(&folder) as u64, CHUNKS);
    }
}

#[test]
fn more_shards_than_chunks_leave_some_with_nothing_to_do() {
    let scene = SCENE.replace("points = 300", "points = 3");
    let dir = TestDir::with_scene(&scene);
    for shard in [1, 6, 0] {
        dir.run(&format!("sweep scene.toml --out parts --shard {shard}/7 --quiet")).with(0, &[]);
        let ran = dir.run("merge parts --out map.csv --quiet");
        ran.with(i32::from(shard != 0), if shard == 0 { &[] } else { &["1 of 1 chunks are missing in parts: 0"] });
    }
    assert!(dir.read("map.csv") == undisturbed(&scene));
}

#[test]
fn what_is_missing_is_named_with_the_command_that_makes_it() {
    let dir = TestDir::with_scene(&SCENE.replace("families", "stability = true\nfamilies"));
    let words = "--threshold 0.01 --threads 2";
    dir.run(&format!("sweep scene.toml --out my_parts --shard 1/4 {words}")).with(0, &[]);
    let told = "11 of 15 chunks are missing in my_parts: 0, 2–4, 6–8, 10–12, 14";
    let ran = dir.run("merge my_parts --out map.csv --png map.png").with(1, &[told]);
    assert_eq!(dir.names("."), ["my_parts", "scene.toml"]);
    let line = ran.err.lines().find_map(|line| line.strip_prefix("make them with: ")).unwrap();
    assert_eq!(line, "mapgen sweep scene.toml --out my_parts --threshold 0.01 --shard 0/1 --resume");
    dir.shell(line).with(0, &[]);
    dir.run("merge my_parts --out map.csv --quiet").with(0, &[]);
    dir.run(&format!("sweep scene.toml --out whole.csv --quiet {words}")).with(0, &[]);
    assert!(dir.read("map.csv") == dir.read("whole.csv"));
    assert_eq!(dir.json("map.manifest.json")["compute"]["threshold"], 0.01);
}

#[test]
fn pictures_of_merged_tables_are_the_same_as_well() {
    let dir = TestDir::with_scene(SCENE);
    dir.run("sweep scene.toml --out map.csv --png map.png --svg map.svg --quiet").with(0, &[]);
    dir.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    dir.run("merge parts --out table.csv --png table.png --svg table.svg --quiet").with(0, &[]);
    for end in ["csv", "png", "svg"] {
        assert!(dir.read(&format!("map.{end}")) == dir.read(&format!("table.{end}")), "{end}");
    }
    dir.run("sweep scene.toml --out parts --shard 0/1 --png map.png").with(2, &["cannot be used with"]);
}

/// The task of a job array.
fn task(dir: &TestDir, line: &str, variables: &[(&str, &str)]) -> Ran {
    let mut command = dir.command(line);
    command.envs(variables.iter().map(|(name, value)| (format!("SLURM_{name}"), value)));
    command.output().unwrap().into()
}

#[test]
fn tasks_of_a_job_array_share_a_sweep() {
    let expected = undisturbed(SCENE);
    let sweep = "sweep scene.toml --out parts --shard slurm --resume";
    for (ids, step) in [(vec!["0", "1", "2"], "1"), (vec!["1", "2"], "1"), (vec!["1", "4", "7"], "3"), (vec!["5"], "1")]
    {
        let dir = TestDir::with_scene(SCENE);
        let count = ids.len().to_string();
        for (index, id) in ids.iter().enumerate() {
            let variables = [
                ("ARRAY_TASK_ID", *id),
                ("ARRAY_TASK_MIN", ids[0]),
                ("ARRAY_TASK_MAX", ids[ids.len() - 1]),
                ("ARRAY_TASK_STEP", step),
                ("ARRAY_TASK_COUNT", &count),
                ("CPUS_PER_TASK", "1"),
            ];
            task(&dir, sweep, &variables).with(0, &[&format!("shard {index}/{count}: "), " s on 1 thread,"]);
        }
        dir.run("merge parts --out map.csv").with(0, &[]);
        assert!(dir.read("map.csv") == expected, "{ids:?}");
    }
    let dir = TestDir::with_scene(SCENE);
    let gaps = [("ARRAY_TASK_ID", "4"), ("ARRAY_TASK_MIN", "1"), ("ARRAY_TASK_MAX", "9"), ("ARRAY_TASK_COUNT", "4")];
    task(&dir, sweep, &gaps).with(2, &["the job array has gaps (task 4; 4 of them, from 1 to 9", "--array=0-7"]);
    task(&dir, sweep, &gaps[..1]).with(2, &["--shard slurm needs SLURM_ARRAY_TASK_MIN, which is not set"]);
    task(&dir, sweep, &[("ARRAY_TASK_ID", "four")]).with(2, &["SLURM_ARRAY_TASK_ID = four is no whole number"]);
    let threads = [&gaps[..3], &[("CPUS_PER_TASK", "0")]].concat();
    task(&dir, sweep, &threads).with(2, &["--threads 0 is out of range"]);
    assert_eq!(dir.names("."), ["scene.toml"]);
}

#[test]
fn wrong_shards_and_folders() {
    let dir = TestDir::with_scene(SCENE);
    for (line, told) in [
        ("sweep scene.toml --out parts --shard 3/3", "there is no shard 3 of 3: give 0 to 2; shards count from 0"),
        ("sweep scene.toml --out parts --shard 0/0", "give at least one shard"),
        ("sweep scene.toml --out parts --shard -1/2", "give i/n, shard i of n counted from 0"),
        ("sweep scene.toml --out parts --shard half", "or slurm, in a job array"),
        ("sweep scene.toml --out scene.toml --shard 0/1", "the scene and --out are the same file"),
        ("sweep scene.toml", "--out <FILE>"),
        ("merge parts --out map.csv", "parts is no folder of chunks: cannot read plan.json"),
        ("merge . --out map.csv", ". is no folder of chunks"),
        ("merge parts", "--out <FILE>"),
    ] {
        dir.run(line).with(2, &[told]);
        assert_eq!(dir.names("."), ["scene.toml"], "{line}");
    }
    fs::write(dir.path("parts"), "").unwrap();
    dir.run("sweep scene.toml --out parts --shard 0/1")
        .with(2, &["parts is a file, where a folder of chunks would be"]);
}

/// A table is in the way of a folder: nobody is told to remove it.
#[test]
fn a_result_is_never_to_be_removed() {
    let dir = TestDir::with_scene(SCENE);
    fs::write(dir.path("a.csv"), "a result").unwrap();
    fs::write(dir.path("a"), "another").unwrap();
    for out in ["a.csv", "a"] {
        let ran = dir.run(&format!("sweep scene.toml --out {out} --shard 1/4")).with(2, &[]);
        assert!(!ran.err.contains("remove") && ran.err.contains("name"), "{ran:?}");
    }
    dir.run("init scene.toml").with(2, &["is left as it is: give another name"]);
    assert_eq!((dir.read("a.csv"), dir.read("a")), (b"a result".to_vec(), b"another".to_vec()));
}

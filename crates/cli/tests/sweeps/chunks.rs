//! Sweeps that are interrupted, killed and damaged end in the same bytes as one that is left alone.

use std::fs;
use std::sync::OnceLock;
use std::time::Duration;

use vibrochain_testkit::{BESIDE, CHUNK_CELLS, CHUNKS, Ran, SCENE, TestDir, interrupts_are_ignored, undisturbed};

const SWEEP: &str = "sweep scene.toml --out map.csv --quiet";

/// All chunks as shard 0 of 1, in the folder where an undivided sweep keeps its own.
fn with_all_chunks() -> TestDir {
    static COMPUTED: OnceLock<TestDir> = OnceLock::new();
    let computed = COMPUTED.get_or_init(|| {
        let dir = TestDir::with_scene(SCENE);
        dir.run("sweep scene.toml --out map.csv.parts --shard 0/1 --quiet").with(0, &[]);
        assert_eq!(dir.chunks("map.csv.parts") as u64, CHUNKS);
        dir
    });
    let dir = TestDir::with_scene(SCENE);
    fs::create_dir(dir.path("map.csv.parts")).unwrap();
    for name in computed.names("map.csv.parts") {
        let name = format!("map.csv.parts/{name}");
        fs::copy(computed.path(&name), dir.path(&name)).unwrap();
    }
    dir
}

/// What stands in the place of a chunk or of the plan and is no file is told at once: nothing waits for a FIFO, or counts a
/// folder as a chunk.
#[cfg(unix)]
#[test]
fn what_is_no_file_is_neither_read_nor_counted_nor_replaced() {
    let dir = with_all_chunks();
    for name in ["000003.chunk", "plan.json", "lock"] {
        let place = dir.path(&format!("map.csv.parts/{name}"));
        let aside = dir.path("aside");
        fs::rename(&place, &aside).unwrap();
        for kind in ["mkfifo", "mkdir"] {
            dir.shell(&format!("{kind} map.csv.parts/{name}")).with(0, &[]);
            let is_lock = name == "lock";
            let (code, told) = match name {
                "lock" => (0, ""),
                "plan.json" => (2, "map.csv.parts is no folder of chunks: cannot read plan.json: it is no plain file"),
                _ => (1, "map.csv.parts/000003.chunk: it cannot be read: it is no plain file"),
            };
            dir.shell("timeout 60 mapgen merge map.csv.parts --out other.csv").with(code, &[told]);
            for line in ["--out map.csv --resume", "--out map.csv", "--out map.csv.parts --shard 0/2 --resume"] {
                let told = format!("{name}{}", if is_lock { ": it is no plain file" } else { "" });
                let unasked = line == "--out map.csv" && name == "plan.json";
                let told = if unasked { "map.csv.parts holds 15 chunks of an unfinished sweep" } else { &told };
                let told = if name == "plan.json" && !unasked { "plan.json: it is no plain file" } else { told };
                dir.shell(&format!("timeout 60 mapgen sweep scene.toml {line}")).with(2, &[told]);
            }
            dir.shell(&format!("rm -r map.csv.parts/{name}")).with(0, &[]);
        }
        fs::rename(&aside, &place).unwrap();
        assert_eq!(dir.names("map.csv.parts").len(), CHUNKS as usize + BESIDE);
    }
    dir.run(&format!("{SWEEP} --resume")).with(0, &[]);
    assert_eq!(dir.json("map.manifest.json")["computed_cells"], 0);
}

/// Files of others behind a link are not a sweep's to remove.
#[cfg(unix)]
#[test]
fn a_link_in_the_place_of_the_folder_is_refused() {
    let dir = with_all_chunks();
    fs::rename(dir.path("map.csv.parts"), dir.path("kept")).unwrap();
    std::os::unix::fs::symlink("kept", dir.path("map.csv.parts")).unwrap();
    for line in [SWEEP.to_owned(), format!("{SWEEP} --resume")] {
        dir.run(&line).with(2, &["map.csv.parts is a link, where a sweep makes a folder", "name another --out"]);
        assert_eq!(dir.names("kept").len(), CHUNKS as usize + BESIDE);
    }
    fs::rename(dir.path("kept"), dir.path("elsewhere")).unwrap();
    dir.run(SWEEP).with(2, &["map.csv.parts is a link"]);
    fs::rename(dir.path("elsewhere"), dir.path("kept")).unwrap();
    // Shares are nobody's to remove, wherever they are kept.
    dir.run("sweep scene.toml --out map.csv.parts --shard 0/1 --resume").with(0, &[]);
    assert_eq!(dir.names("."), ["kept", "map.csv.parts", "scene.toml"]);
}

/// Cells of a chunk.
fn cells(chunk: u64) -> u64 {
    CHUNK_CELLS.min(480_000 - chunk * CHUNK_CELLS)
}

#[test]
fn chunks_do_not_depend_on_threads() {
    let dir = TestDir::with_scene(SCENE);
    for threads in ["1", "2", "3"] {
        dir.run(&format!("sweep scene.toml --out {threads} --shard 0/1 --quiet --threads {threads}")).with(0, &[]);
        assert_eq!(dir.names(threads), dir.names("1"));
        assert!(
            dir.names("1").iter().all(|name| dir.read(&format!("1/{name}")) == dir.read(&format!("{threads}/{name}")))
        );
    }
}

#[test]
fn damaged_chunks_and_no_others_are_computed_again() {
    let expected = undisturbed(SCENE);
    let whole = fs::read(with_all_chunks().path("map.csv.parts/000003.chunk")).unwrap();
    let mut flipped = whole.clone();
    flipped[whole.len() / 3] ^= 4;
    for (damaged, told) in [
        (vec![], "it is empty"),
        (whole[..whole.len() - 1].to_vec(), "it is damaged"),
        (whole[..whole.len() / 2].to_vec(), "it is damaged"),
        (flipped, "its checksum is wrong"),
        ([&whole[..], b"0,0.4,none,,,,0,ok\n"].concat(), "it is damaged"),
    ] {
        let dir = with_all_chunks();
        fs::write(dir.path("map.csv.parts/000003.chunk"), damaged).unwrap();
        // One that is missing, one under the number of another, and what a killed process leaves.
        fs::remove_file(dir.path("map.csv.parts/000007.chunk")).unwrap();
        fs::copy(dir.path("map.csv.parts/000001.chunk"), dir.path("map.csv.parts/000009.chunk")).unwrap();
        fs::write(dir.path("map.csv.parts/.000007.chunk.Xy12aB.part"), "half").unwrap();
        let refused = dir.run("merge map.csv.parts --out other.csv");
        let misplaced = "000009.chunk: it is chunk 1 of this sweep under another's name";
        let missing = "1 of 15 chunks are missing in map.csv.parts: 7";
        refused.with(1, &[missing, "2 of 15", "000003.chunk", told, misplaced]);
        assert!(!dir.path("other.csv").exists());

        let again = ["000003.chunk", told, "computing it again", misplaced];
        let ran = dir.run(&format!("{SWEEP} --resume")).with(0, &again);
        assert_eq!(ran.err.lines().count(), 2);
        assert!(dir.read("map.csv") == expected);
        assert_eq!(dir.json("map.manifest.json")["computed_cells"], 3 * CHUNK_CELLS);
        assert_eq!(dir.names("."), ["map.csv", "map.manifest.json", "scene.toml"]);
    }
}

#[test]
fn chunks_of_another_scene_are_refused_by_what_differs() {
    let dir = with_all_chunks();
    let change = |from: &str, to: &str| fs::write(dir.path("scene.toml"), SCENE.replace(from, to)).unwrap();
    change("gamma1 = 0.2", "gamma1 = 0.25");
    let told = "map.csv.parts belongs to another scene: model.gamma1 is 0.2 there, 0.25 here";
    dir.run(&format!("{SWEEP} --resume")).with(2, &[told, "name another --out"]);
    dir.run("sweep scene.toml --out map.csv.parts --shard 0/2 --resume").with(2, &[told]);
    change("points = 300", "points = 301");
    dir.run(&format!("{SWEEP} --resume")).with(2, &["sweep.y.points is 300 there, 301 here"]);
    change("families", "stability = true\nfamilies");
    dir.run(&format!("{SWEEP} --resume --threshold 0.01"))
        .with(2, &["compute.stability is false there, true here", "compute.threshold is absent there, 0.01 here"]);
    assert_eq!(dir.chunks("map.csv.parts") as u64, CHUNKS);
    // A foreign chunk, sound in itself.
    let other = TestDir::with_scene(&SCENE.replace("gamma1 = 0.2", "gamma1 = 0.25"));
    other.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    fs::copy(other.path("parts/000002.chunk"), dir.path("map.csv.parts/000002.chunk")).unwrap();
    // What a picture is called does not matter, nor do remarks, the order of keys and how a number is spelled.
    let words = "asymmetry = 4e-1 # a remark\ngamma1 = 2e-1\n[compute]\nfamilies = [\"single-sided\", \"double-sided\"]\n[sweep]";
    fs::write(
        dir.path("scene.toml"),
        format!(
            "title = \"a title\"\n{}",
            SCENE.split("[compute]").next().unwrap().replace("gamma1 = 0.2\nasymmetry = 0.4\n[sweep]", words)
        ),
    )
    .unwrap();
    dir.run(&format!("{SWEEP} --resume")).with(2, &["000002.chunk is a chunk of another scene or version"]);
    fs::remove_file(dir.path("map.csv.parts/000002.chunk")).unwrap();
    dir.run(&format!("{SWEEP} --resume")).with(0, &[]);
    assert_eq!(dir.json("map.manifest.json")["computed_cells"], CHUNK_CELLS);
}

#[test]
fn what_an_interrupted_sweep_left_is_never_overwritten_unasked() {
    let dir = with_all_chunks();
    fs::remove_file(dir.path("map.csv.parts/000000.chunk")).unwrap();
    let told = "map.csv.parts holds 14 chunks of an unfinished sweep: go on with it by --resume, or name another --out";
    dir.run(SWEEP).with(2, &[told]);
    dir.run("sweep scene.toml --out map.csv.parts --shard 1/2").with(2, &["holds chunks of shard 1/2 already"]);
    assert_eq!(dir.names("."), ["map.csv.parts", "scene.toml"]);
    assert_eq!(dir.chunks("map.csv.parts"), 14);
    // Where there is no chunk nothing can be lost, whosever plan it was.
    (1..CHUNKS).for_each(|i| fs::remove_file(dir.path(&format!("map.csv.parts/{i:06}.chunk"))).unwrap());
    fs::write(dir.path("scene.toml"), SCENE.replace("gamma1 = 0.2", "gamma1 = 0.25")).unwrap();
    dir.run(SWEEP).with(0, &[]);
    assert_eq!(dir.names("."), ["map.csv", "map.manifest.json", "scene.toml"]);
}

#[test]
fn resuming_where_there_is_nothing_starts_afresh() {
    let dir = TestDir::with_scene(SCENE);
    dir.run(&format!("{SWEEP} --resume")).with(0, &[]);
    assert!(dir.read("map.csv") == undisturbed(SCENE));
    assert_eq!(dir.json("map.manifest.json")["computed_cells"], 480_000);
}

#[test]
fn resumed_at_some_points_it_ends_in_the_same_bytes() {
    resumed_at([0, 1, 8, CHUNKS, CHUNKS + 1, CHUNKS + 2]);
}

#[test]
#[ignore = "half a minute: cargo test --workspace --test sweeps -- --ignored chunks::slow"]
fn slow_resumed_at_any_point_it_ends_in_the_same_bytes() {
    resumed_at(0..=2 * CHUNKS);
}

fn resumed_at(rounds: impl IntoIterator<Item = u64>) {
    let expected = undisturbed(SCENE);
    let whole = with_all_chunks();
    let mut rng = fastrand::Rng::with_seed(3);
    for round in rounds {
        // The first few of them, as an interruption leaves them; then any, as damage does.
        let kept: Vec<u64> =
            (0..CHUNKS).filter(|&chunk| if round <= CHUNKS { chunk < round } else { rng.bool() }).collect();
        let dir = TestDir::with_scene(SCENE);
        fs::create_dir(dir.path("map.csv.parts")).unwrap();
        for chunk in &kept {
            let name = format!("map.csv.parts/{chunk:06}.chunk");
            fs::copy(whole.path(&name), dir.path(&name)).unwrap();
        }
        dir.run(&format!("{SWEEP} --resume")).with(0, &[]);
        assert!(dir.read("map.csv") == expected, "{kept:?}");
        let left: u64 = (0..CHUNKS).filter(|chunk| !kept.contains(chunk)).map(cells).sum();
        assert_eq!(dir.json("map.manifest.json")["computed_cells"], left);
        assert_eq!(dir.names("."), ["map.csv", "map.manifest.json", "scene.toml"]);
    }
}

#[test]
fn a_plan_that_is_lost_is_made_again_and_one_that_is_damaged_is_told() {
    let dir = with_all_chunks();
    let plan = dir.path("map.csv.parts/plan.json");
    let text = fs::read_to_string(&plan).unwrap();
    fs::write(&plan, text.replace("gamma1 = 0.2", "gamma1 = 0.3")).unwrap();
    dir.run(&format!("{SWEEP} --resume")).with(2, &["plan.json cannot be used: it is damaged", "name another --out"]);
    dir.run("merge map.csv.parts --out other.csv").with(2, &["plan.json cannot be used: it is damaged"]);
    fs::remove_file(&plan).unwrap();
    dir.run("merge map.csv.parts --out other.csv").with(2, &["is no folder of chunks"]);
    dir.run(&format!("{SWEEP} --resume")).with(0, &[]);
    assert_eq!(dir.json("map.manifest.json")["computed_cells"], 0);
    assert!(dir.read("map.csv") == undisturbed(SCENE));
}

#[cfg(unix)]
mod signals {
    use super::*;
    use vibrochain_testkit::signal;

    /// Some seconds of work.
    fn slow() -> String {
        SCENE.replace("points = 300", "points = 6000")
    }

    #[test]
    fn a_signal_keeps_what_is_finished_and_tells_how_to_go_on() {
        for name in ["INT", "TERM"] {
            if name == "INT" && interrupts_are_ignored() {
                eprintln!("skipped: in the background of a script Ctrl-C is for others, and stays so");
                continue;
            }
            let dir = TestDir::with_scene(&slow());
            let mut child = dir.start("sweep scene.toml --out map.csv --png map.png");
            dir.await_chunks(&mut child, "map.csv.parts", 3);
            let told = "--out map.csv --png map.png --resume";
            let ran = signal(child, name).with(130, &["interrupted: ", "chunks are finished, in map.csv.parts", told]);
            let chunks = dir.chunks("map.csv.parts");
            assert!(chunks >= 3 && ran.err.contains(&format!("{chunks} of 293 chunks")), "{ran:?}");
            // Nothing half-written is left, and no table.
            assert_eq!(dir.names("map.csv.parts").len(), chunks + BESIDE);
            assert_eq!(dir.names("."), ["map.csv.parts", "scene.toml"]);
        }
    }

    #[test]
    fn a_signal_within_a_second_leaves_what_can_be_gone_on_with() {
        let expected = undisturbed(SCENE);
        for wait in [0, 20, 60, 120] {
            let dir = TestDir::with_scene(SCENE);
            let mut child = dir.start("sweep scene.toml --out map.csv --threads 1");
            while !dir.path("map.csv.parts/plan.json").exists() && child.try_wait().unwrap().is_none() {
                std::thread::sleep(Duration::from_millis(1));
            }
            std::thread::sleep(Duration::from_millis(wait));
            let ran = if child.try_wait().unwrap().is_none() {
                signal(child, "TERM")
            } else {
                child.wait_with_output().unwrap().into()
            };
            // A fast machine may have been done.
            if ran.code != Some(0) {
                let ran = ran.with(130, &["go on with: "]);
                let command = ran.err.trim().rsplit_once("go on with: ").unwrap().1;
                dir.shell(command).with(0, &[]);
            }
            assert!(dir.read("map.csv") == expected);
            assert_eq!(dir.names("."), ["map.csv", "map.manifest.json", "scene.toml"]);
        }
    }

    /// Starts a sweep, waits until chunk 0 is there and spoils it. Tells whether the sweep was still under way.
    fn spoil(dir: &TestDir, line: &str, number: usize) -> (bool, Ran) {
        let mut child = dir.start(line);
        dir.await_chunks(&mut child, "map.csv.parts", number);
        let growing = dir.names(".").iter().any(|name| name.starts_with(".map.csv."));
        fs::write(dir.path("map.csv.parts/000000.chunk"), "spoilt").unwrap();
        (growing, child.wait_with_output().unwrap().into())
    }

    #[test]
    fn chunks_are_read_back_by_who_goes_on_and_by_nobody_else() {
        let scene = SCENE.replace("points = 300", "points = 800");
        let dir = TestDir::with_scene(&scene);
        let (growing, ran) = spoil(&dir, SWEEP, 2);
        ran.with(0, &[]);
        assert!(growing && dir.read("map.csv") == undisturbed(&scene));

        let dir = TestDir::with_scene(&scene);
        let mut child = dir.start(SWEEP);
        dir.await_chunks(&mut child, "map.csv.parts", 2);
        signal(child, "TERM").with(130, &["go on with"]);
        let finished = dir.chunks("map.csv.parts");
        let (growing, ran) = spoil(&dir, &format!("{SWEEP} --resume"), finished + 2);
        ran.with(1, &["could not read map.csv.parts/000000.chunk: it is damaged: it is cut short", "go on with: "]);
        assert!(!growing);
        dir.run(&format!("{SWEEP} --resume")).with(0, &["000000.chunk", "computing it again"]);
        assert!(dir.read("map.csv") == undisturbed(&scene));
        assert_eq!(dir.json("map.manifest.json")["computed_cells"], CHUNK_CELLS);
    }

    #[test]
    fn one_folder_has_one_undivided_sweep_at_a_time() {
        let dir = TestDir::with_scene(&slow());
        let mut child = dir.start("sweep scene.toml --out map.csv");
        dir.await_chunks(&mut child, "map.csv.parts", 1);
        dir.run(&format!("{SWEEP} --resume")).with(2, &["another mapgen is at work in map.csv.parts"]);
        dir.run("sweep scene.toml --out map.csv.parts --shard 0/3 --resume").with(2, &["another mapgen is at work"]);
        signal(child, "TERM").with(130, &["go on with"]);
    }

    /// A lock needs only to be opened: whoever may not write in the folder may not open it.
    #[test]
    fn who_may_only_read_holds_up_no_sweep() {
        use std::os::unix::fs::PermissionsExt;
        let dir = with_all_chunks();
        let lock = dir.path("map.csv.parts/lock");
        for (folder, file) in [(0o755, 0o600), (0o775, 0o660), (0o777, 0o666)] {
            fs::set_permissions(dir.path("map.csv.parts"), fs::Permissions::from_mode(folder)).unwrap();
            dir.run("sweep scene.toml --out map.csv.parts --shard 0/1 --resume").with(0, &[]);
            assert_eq!(lock.metadata().unwrap().permissions().mode() & 0o777, file);
        }
        // All that others may open.
        let held: Vec<_> = ["plan.json", "000000.chunk", "."]
            .map(|name| fs::File::open(dir.path("map.csv.parts").join(name)).unwrap())
            .into_iter()
            .inspect(|file| file.lock().unwrap())
            .collect();
        dir.run(&format!("{SWEEP} --resume")).with(0, &[]);
        drop(held);
        assert_eq!(dir.names("."), ["map.csv", "map.manifest.json", "scene.toml"]);
    }

    #[test]
    fn of_racing_resumes_each_ends_well_or_is_told_who_is_at_work() {
        let scene = SCENE.replace("points = 300", "points = 45");
        let expected = undisturbed(&scene);
        let dir = TestDir::with_scene(&scene);
        // Each begins again as soon as it has ended, so that ends meet beginnings.
        let race = || {
            let (mut done, mut refused) = (0, 0);
            while done < 8 {
                let ran = dir.run(&format!("{SWEEP} --resume --threads 1"));
                if ran.code == Some(0) {
                    assert_eq!(ran.err, "");
                    done += 1;
                } else {
                    ran.with(2, &["another mapgen is at work in map.csv.parts (it holds map.csv.parts/lock"]);
                    refused += 1;
                }
            }
            refused
        };
        let refused: u32 = std::thread::scope(|scope| {
            let racers = [(); 3].map(|()| scope.spawn(race));
            racers.into_iter().map(|racer| racer.join().unwrap()).sum()
        });
        assert!(refused > 10, "{refused}");
        assert!(dir.read("map.csv") == expected);
        assert_eq!(dir.names("."), ["map.csv", "map.manifest.json", "scene.toml"]);
    }

    #[test]
    fn two_processes_with_the_same_shard_do_each_other_no_harm() {
        let expected = undisturbed(SCENE);
        let dir = TestDir::with_scene(SCENE);
        let start = || dir.start("sweep scene.toml --out parts --shard 0/1 --resume --threads 1 --quiet");
        let children = [start(), start(), start()];
        for child in children {
            Ran::from(child.wait_with_output().unwrap()).with(0, &[]);
        }
        dir.run("merge parts --out map.csv --quiet").with(0, &[]);
        assert!(dir.read("map.csv") == expected);
        assert_eq!(dir.names("parts").len(), CHUNKS as usize + BESIDE);
    }
}

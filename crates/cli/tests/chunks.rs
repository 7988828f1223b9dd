//! Sweeps that are interrupted, killed and damaged end in the same bytes as one that is left alone.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

#[path = "support/desk.rs"]
mod desk;

use std::fs;
use std::time::Duration;

use desk::{CHUNK_CELLS, CHUNKS, Desk, SCENE, undisturbed};

const SWEEP: &str = "sweep scene.toml --out map.csv --quiet";

/// All chunks as shard 0 of 1, in the folder where an undivided sweep keeps its own.
fn with_all_chunks() -> Desk {
    let desk = Desk::with_scene(SCENE);
    desk.run("sweep scene.toml --out map.csv.parts --shard 0/1 --quiet").with(0, &[]);
    assert_eq!(desk.chunks("map.csv.parts") as u64, CHUNKS);
    desk
}

/// Cells of a chunk.
fn cells(chunk: u64) -> u64 {
    CHUNK_CELLS.min(480_000 - chunk * CHUNK_CELLS)
}

#[cfg(unix)]
#[test]
fn killed_at_thirty_random_moments_it_ends_in_the_same_bytes() {
    let expected = undisturbed(SCENE);
    let desk = Desk::with_scene(SCENE);
    let mut rng = fastrand::Rng::with_seed(7);
    let (mut killed, mut met, mut whole) = (0, [false; 2], 0);
    while killed < 30 {
        let mut child = desk.start(&format!("{SWEEP} --threads {} --resume", rng.u8(1..3)));
        std::thread::sleep(Duration::from_micros(rng.u64(1000..150_000)));
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
    desk.run(&format!("{SWEEP} --resume")).with(0, &[]);
    assert!(desk.read("map.csv") == expected);
    assert!(!desk.path("map.csv.parts").exists());
}

#[test]
fn chunks_do_not_depend_on_threads() {
    let desk = Desk::with_scene(SCENE);
    for threads in ["1", "2", "3"] {
        desk.run(&format!("sweep scene.toml --out {threads} --shard 0/1 --quiet --threads {threads}")).with(0, &[]);
        assert_eq!(desk.names(threads), desk.names("1"));
        assert!(
            desk.names("1")
                .iter()
                .all(|name| desk.read(&format!("1/{name}")) == desk.read(&format!("{threads}/{name}")))
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
        let desk = with_all_chunks();
        fs::write(desk.path("map.csv.parts/000003.chunk"), damaged).unwrap();
        // One that is missing, one under the number of another, and what a killed process leaves.
        fs::remove_file(desk.path("map.csv.parts/000007.chunk")).unwrap();
        fs::copy(desk.path("map.csv.parts/000001.chunk"), desk.path("map.csv.parts/000009.chunk")).unwrap();
        fs::write(desk.path("map.csv.parts/.000007.chunk.Xy12.part"), "half").unwrap();
        let refused = desk.run("merge map.csv.parts --out other.csv");
        refused.with(1, &["1 of 15 chunks are missing in map.csv.parts: 7", "2 of 15", "000003.chunk", told]);
        assert!(!desk.path("other.csv").exists());

        fs::remove_file(desk.path("map.csv.parts/000009.chunk")).unwrap();
        let ran = desk.run(&format!("{SWEEP} --resume")).with(0, &["000003.chunk", told, "computing it again"]);
        assert_eq!(ran.err.lines().count(), 1);
        assert!(desk.read("map.csv") == expected);
        assert_eq!(desk.json("map.manifest.json")["computed_cells"], 3 * CHUNK_CELLS);
        assert_eq!(desk.names("."), ["map.csv", "map.manifest.json", "scene.toml"]);
    }
}

#[test]
fn chunks_of_another_scene_are_refused_by_what_differs() {
    let desk = with_all_chunks();
    let change = |from: &str, to: &str| fs::write(desk.path("scene.toml"), SCENE.replace(from, to)).unwrap();
    change("gamma1 = 0.2", "gamma1 = 0.25");
    let told = "map.csv.parts belongs to another scene: model.gamma1 is 0.2 there, 0.25 here";
    desk.run(&format!("{SWEEP} --resume")).with(2, &[told, "name another --out, or remove the folder"]);
    desk.run("sweep scene.toml --out map.csv.parts --shard 0/2 --resume").with(2, &[told]);
    change("points = 300", "points = 301");
    desk.run(&format!("{SWEEP} --resume")).with(2, &["sweep.y.points is 300 there, 301 here"]);
    change("families", "stability = true\nfamilies");
    desk.run(&format!("{SWEEP} --resume --threshold 0.01"))
        .with(2, &["compute.stability is false there, true here", "compute.threshold is absent there, 0.01 here"]);
    assert_eq!(desk.chunks("map.csv.parts") as u64, CHUNKS);
    // A foreign chunk, sound in itself.
    let other = Desk::with_scene(&SCENE.replace("gamma1 = 0.2", "gamma1 = 0.25"));
    other.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    fs::copy(other.path("parts/000002.chunk"), desk.path("map.csv.parts/000002.chunk")).unwrap();
    change("[model]", "title = \"what a picture is called and # remarks do not matter\"\n[model]");
    desk.run(&format!("{SWEEP} --resume")).with(2, &["000002.chunk is a chunk of another scene or version"]);
    fs::remove_file(desk.path("map.csv.parts/000002.chunk")).unwrap();
    desk.run(&format!("{SWEEP} --resume")).with(0, &[]);
    assert_eq!(desk.json("map.manifest.json")["computed_cells"], CHUNK_CELLS);
}

#[test]
fn what_an_interrupted_sweep_left_is_never_overwritten_unasked() {
    let desk = with_all_chunks();
    fs::remove_file(desk.path("map.csv.parts/000000.chunk")).unwrap();
    let told = "map.csv.parts holds 14 chunks of an unfinished sweep: go on with it by --resume, or remove the folder";
    desk.run(SWEEP).with(2, &[told]);
    desk.run("sweep scene.toml --out map.csv.parts --shard 1/2").with(2, &["holds chunks of shard 1/2 already"]);
    assert_eq!(desk.names("."), ["map.csv.parts", "scene.toml"]);
    assert_eq!(desk.chunks("map.csv.parts"), 14);
    // Where there is no chunk nothing can be lost, whosever plan it was.
    (1..CHUNKS).for_each(|i| fs::remove_file(desk.path(&format!("map.csv.parts/{i:06}.chunk"))).unwrap());
    fs::write(desk.path("scene.toml"), SCENE.replace("gamma1 = 0.2", "gamma1 = 0.25")).unwrap();
    desk.run(SWEEP).with(0, &[]);
    assert_eq!(desk.names("."), ["map.csv", "map.manifest.json", "scene.toml"]);
}

#[test]
fn resuming_where_there_is_nothing_starts_afresh() {
    let desk = Desk::with_scene(SCENE);
    desk.run(&format!("{SWEEP} --resume")).with(0, &[]);
    assert!(desk.read("map.csv") == undisturbed(SCENE));
    assert_eq!(desk.json("map.manifest.json")["computed_cells"], 480_000);
}

#[test]
fn resumed_at_any_point_it_ends_in_the_same_bytes() {
    let expected = undisturbed(SCENE);
    let whole = with_all_chunks();
    let mut rng = fastrand::Rng::with_seed(3);
    for round in 0..=2 * CHUNKS {
        // The first few of them, as an interruption leaves them; then any, as damage does.
        let kept: Vec<u64> =
            (0..CHUNKS).filter(|&chunk| if round <= CHUNKS { chunk < round } else { rng.bool() }).collect();
        let desk = Desk::with_scene(SCENE);
        fs::create_dir(desk.path("map.csv.parts")).unwrap();
        for chunk in &kept {
            let name = format!("map.csv.parts/{chunk:06}.chunk");
            fs::copy(whole.path(&name), desk.path(&name)).unwrap();
        }
        desk.run(&format!("{SWEEP} --resume")).with(0, &[]);
        assert!(desk.read("map.csv") == expected, "{kept:?}");
        let left: u64 = (0..CHUNKS).filter(|chunk| !kept.contains(chunk)).map(cells).sum();
        assert_eq!(desk.json("map.manifest.json")["computed_cells"], left);
        assert_eq!(desk.names("."), ["map.csv", "map.manifest.json", "scene.toml"]);
    }
}

#[test]
fn a_plan_that_is_lost_is_made_again_and_one_that_is_damaged_is_told() {
    let desk = with_all_chunks();
    let plan = desk.path("map.csv.parts/plan.json");
    let text = fs::read_to_string(&plan).unwrap();
    fs::write(&plan, text.replace("gamma1 = 0.2", "gamma1 = 0.3")).unwrap();
    desk.run(&format!("{SWEEP} --resume")).with(2, &["plan.json cannot be used: it is damaged", "remove it"]);
    desk.run("merge map.csv.parts --out other.csv").with(2, &["plan.json cannot be used: it is damaged"]);
    fs::remove_file(&plan).unwrap();
    desk.run("merge map.csv.parts --out other.csv").with(2, &["is no folder of chunks"]);
    desk.run(&format!("{SWEEP} --resume")).with(0, &[]);
    assert_eq!(desk.json("map.manifest.json")["computed_cells"], 0);
    assert!(desk.read("map.csv") == undisturbed(SCENE));
}

#[cfg(unix)]
mod signals {
    use super::*;
    use desk::signal;

    /// Some seconds of work.
    fn slow() -> String {
        SCENE.replace("points = 300", "points = 6000")
    }

    #[test]
    fn a_signal_keeps_what_is_finished_and_tells_how_to_go_on() {
        for name in ["INT", "TERM"] {
            if name == "INT" && desk::interrupts_are_ignored() {
                eprintln!("skipped: in the background of a script Ctrl-C is for others, and stays so");
                continue;
            }
            let desk = Desk::with_scene(&slow());
            let mut child = desk.start("sweep scene.toml --out map.csv --png map.png");
            desk.await_chunks(&mut child, "map.csv.parts", 3);
            let told = "--out map.csv --png map.png --resume";
            let ran = signal(child, name).with(130, &["interrupted: ", "chunks are finished, in map.csv.parts", told]);
            let chunks = desk.chunks("map.csv.parts");
            assert!(chunks >= 3 && ran.err.contains(&format!("{chunks} of 293 chunks")), "{ran:?}");
            // Nothing half-written is left, and no table.
            assert_eq!(desk.names("map.csv.parts").len(), chunks + 1);
            assert_eq!(desk.names("."), ["map.csv.parts", "scene.toml"]);
        }
    }

    #[test]
    fn a_signal_within_a_second_leaves_what_can_be_gone_on_with() {
        let expected = undisturbed(SCENE);
        for wait in [0, 20, 60, 120] {
            let desk = Desk::with_scene(SCENE);
            let mut child = desk.start("sweep scene.toml --out map.csv --threads 1");
            while !desk.path("map.csv.parts/plan.json").exists() && child.try_wait().unwrap().is_none() {
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
                desk.shell(command).with(0, &[]);
            }
            assert!(desk.read("map.csv") == expected);
            assert_eq!(desk.names("."), ["map.csv", "map.manifest.json", "scene.toml"]);
        }
    }

    /// Starts a sweep, waits until chunk 0 is there and spoils it. Tells whether the sweep was still under way.
    fn spoil(desk: &Desk, line: &str, number: usize) -> (bool, desk::Ran) {
        let mut child = desk.start(line);
        desk.await_chunks(&mut child, "map.csv.parts", number);
        let growing = desk.names(".").iter().any(|name| name.starts_with(".map.csv."));
        fs::write(desk.path("map.csv.parts/000000.chunk"), "spoilt").unwrap();
        (growing, child.wait_with_output().unwrap().into())
    }

    #[test]
    fn chunks_are_read_back_by_who_goes_on_and_by_nobody_else() {
        let scene = SCENE.replace("points = 300", "points = 2000");
        let desk = Desk::with_scene(&scene);
        let (growing, ran) = spoil(&desk, SWEEP, 2);
        ran.with(0, &[]);
        assert!(growing && desk.read("map.csv") == undisturbed(&scene));

        let desk = Desk::with_scene(&scene);
        let mut child = desk.start(SWEEP);
        desk.await_chunks(&mut child, "map.csv.parts", 2);
        signal(child, "TERM").with(130, &["go on with"]);
        let finished = desk.chunks("map.csv.parts");
        let (growing, ran) = spoil(&desk, &format!("{SWEEP} --resume"), finished + 2);
        ran.with(1, &["could not read map.csv.parts/000000.chunk: it is damaged: it is cut short", "go on with: "]);
        assert!(!growing);
        desk.run(&format!("{SWEEP} --resume")).with(0, &["000000.chunk", "computing it again"]);
        assert!(desk.read("map.csv") == undisturbed(&scene));
        assert_eq!(desk.json("map.manifest.json")["computed_cells"], CHUNK_CELLS);
    }

    #[test]
    fn one_folder_has_one_undivided_sweep_at_a_time() {
        let desk = Desk::with_scene(&slow());
        let mut child = desk.start("sweep scene.toml --out map.csv");
        desk.await_chunks(&mut child, "map.csv.parts", 1);
        desk.run(&format!("{SWEEP} --resume")).with(2, &["another mapgen is at work in map.csv.parts"]);
        desk.run("sweep scene.toml --out map.csv.parts --shard 0/3 --resume").with(2, &["another mapgen is at work"]);
        signal(child, "TERM").with(130, &["go on with"]);
    }

    #[test]
    fn two_processes_with_the_same_shard_do_each_other_no_harm() {
        let expected = undisturbed(SCENE);
        let desk = Desk::with_scene(SCENE);
        let start = || desk.start("sweep scene.toml --out parts --shard 0/1 --resume --threads 1 --quiet");
        let children = [start(), start(), start()];
        for child in children {
            desk::Ran::from(child.wait_with_output().unwrap()).with(0, &[]);
        }
        desk.run("merge parts --out map.csv --quiet").with(0, &[]);
        assert!(desk.read("map.csv") == expected);
        assert_eq!(desk.names("parts").len() as u64, CHUNKS + 1);
    }
}

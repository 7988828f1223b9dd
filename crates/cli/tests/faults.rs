//! Disks that are full, folders that cannot be written or are gone: told at once, and nothing that is finished is lost.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

#[path = "support/desk.rs"]
mod desk;

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::Command;

use desk::{CHUNK_CELLS, CHUNKS, Desk, Ran, SCENE, undisturbed};

const SWEEP: &str = "mapgen sweep scene.toml --out map.csv --quiet --threads 1";

/// Runs with a limit on the size of files, in bytes. What is written beyond it fails as on a full disk, but for its name.
fn limited(desk: &Desk, line: &str, bytes: usize) -> Ran {
    // POSIX counts 512 bytes a block.
    desk.shell(&format!("ulimit -f {}; exec {line}", bytes / 512))
}

#[test]
fn a_table_that_does_not_fit_loses_no_chunk() {
    let expected = undisturbed(SCENE);
    let desk = Desk::with_scene(SCENE);
    // Every chunk fits, the table does not.
    let ran = limited(&desk, SWEEP, expected.len() / 2);
    let told = "15 of 15 chunks are finished, in map.csv.parts; go on with: mapgen sweep scene.toml --out map.csv";
    ran.with(1, &["could not write map.csv: File too large", told]);
    assert_eq!(desk.names("."), ["map.csv.parts", "scene.toml"]);
    assert_eq!(desk.chunks("map.csv.parts") as u64, CHUNKS);
    desk.shell(&format!("{SWEEP} --resume")).with(0, &[]);
    assert!(desk.read("map.csv") == expected);
    assert_eq!(desk.json("map.manifest.json")["computed_cells"], 0);

    desk.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    limited(&desk, "mapgen merge parts --out other.csv", expected.len() / 2).with(1, &["could not write other.csv"]);
    assert_eq!(desk.names("."), ["map.csv", "map.manifest.json", "parts", "scene.toml"]);
}

#[test]
fn a_chunk_that_does_not_fit_is_not_there_and_those_before_it_are() {
    let desk = Desk::with_scene(SCENE);
    desk.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    let sizes: Vec<u64> =
        (0..CHUNKS).map(|i| fs::metadata(desk.path(&format!("parts/{i:06}.chunk"))).unwrap().len()).collect();
    // The first one is smaller than the largest.
    let limit = (sizes[0] as usize).next_multiple_of(512);
    let refused = sizes.iter().position(|&size| size > limit as u64).unwrap();
    limited(&desk, SWEEP, limit).with(1, &["File too large", &format!("{refused} of 15 chunks are finished")]);
    assert_eq!(desk.names("map.csv.parts").len(), refused + 1);
    limited(&desk, &format!("{SWEEP} --resume"), limit).with(1, &[&format!("{refused} of 15 chunks are finished")]);
    desk.shell(&format!("{SWEEP} --resume")).with(0, &[]);
    assert!(desk.read("map.csv") == undisturbed(SCENE));
    assert_eq!(desk.json("map.manifest.json")["computed_cells"], 120_000 - refused as u64 * CHUNK_CELLS);
}

#[test]
fn a_disk_without_room_for_a_plan_is_told_and_nothing_is_left() {
    let desk = Desk::with_scene(SCENE);
    limited(&desk, SWEEP, 512).with(1, &["map.csv.parts/plan.json: File too large"]);
    assert_eq!(desk.names("."), ["scene.toml"]);
}

/// A file system of one megabyte, where the machine lets us make one.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk() {
    let desk = Desk::with_scene(SCENE);
    let disk = desk.path("disk");
    fs::create_dir(&disk).unwrap();
    let made = Command::new("mount").args(["-t", "tmpfs", "-o", "size=1m", "tmpfs"]).arg(&disk).output();
    if !made.is_ok_and(|made| made.status.success()) {
        eprintln!("skipped: no file system may be made here");
        return;
    }
    let sweep = "mapgen sweep scene.toml --out disk/map.csv --quiet --threads 1";
    let ran = desk.shell(sweep);
    let kept = desk.chunks("disk/map.csv.parts");
    let names = desk.names("disk/map.csv.parts");
    let larger = Command::new("mount").args(["-o", "remount,size=64m"]).arg(&disk).status();
    let resumed = desk.shell(&format!("{sweep} --resume"));
    let table = fs::read(disk.join("map.csv"));
    let unmounted = Command::new("umount").arg(&disk).status();
    assert!(larger.unwrap().success() && unmounted.unwrap().success());
    ran.with(1, &["No space left on device", &format!("{kept} of 15 chunks are finished, in disk/map.csv.parts")]);
    assert!(kept > 0 && names.len() == kept + 1, "{names:?}");
    resumed.with(0, &[]);
    assert!(table.unwrap() == undisturbed(SCENE));
}

#[test]
fn folders_that_cannot_be_made_or_written_are_refused_before_anything_is_computed() {
    let desk = Desk::with_scene(SCENE);
    for (line, told) in [
        ("sweep scene.toml --out scene.toml/map.csv", "cannot write scene.toml/map.csv: "),
        ("sweep scene.toml --out /proc/none/map.csv", "cannot write /proc/none/map.csv: "),
        ("sweep scene.toml --out /proc/none/parts --shard 0/2", "cannot make the folder /proc/none/parts: "),
        ("sweep scene.toml --out map.csv --png scene.toml/map.png", "cannot write scene.toml/map.png: "),
    ] {
        desk.run(line).with(2, &[told]);
        assert_eq!(desk.names("."), ["scene.toml"]);
    }
    fs::write(desk.path("map.csv.parts"), "mine").unwrap();
    desk.run("sweep scene.toml --out map.csv").with(2, &["map.csv.parts is a file, where a folder of chunks would be"]);
    assert_eq!(desk.read("map.csv.parts"), b"mine");

    // Permissions bind everybody but the administrator.
    let folder = desk.path("closed");
    fs::create_dir(&folder).unwrap();
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o555)).unwrap();
    if fs::write(folder.join("probe"), "").is_ok() {
        eprintln!("skipped: an administrator may write everywhere");
        return;
    }
    desk.run("sweep scene.toml --out closed/map.csv").with(2, &["cannot write closed/map.csv: Permission denied"]);
    desk.run("sweep scene.toml --out closed --shard 0/1")
        .with(2, &["cannot write closed/plan.json: Permission denied"]);
}

#[test]
fn a_folder_that_vanishes_midway_is_told() {
    let desk = Desk::with_scene(&SCENE.replace("points = 300", "points = 6000"));
    for line in ["sweep scene.toml --out map.csv --resume", "sweep scene.toml --out map.csv.parts --shard 0/1 --resume"]
    {
        let mut child = desk.start(line);
        desk.await_chunks(&mut child, "map.csv.parts", 2);
        fs::rename(desk.path("map.csv.parts"), desk.path("moved")).unwrap();
        let ran = Ran::from(child.wait_with_output().unwrap());
        let told = ["the folder map.csv.parts has vanished", &format!("start again with: mapgen {line}")];
        ran.with(1, &told);
        assert!(!desk.path("map.csv.parts").exists());
        // What was finished is as good as ever, and nothing else is there.
        let chunks = desk.chunks("moved");
        assert!(chunks >= 2);
        fs::rename(desk.path("moved"), desk.path("map.csv.parts")).unwrap();
        let ran = desk.run("merge map.csv.parts --out other.csv").with(1, &[&format!("{} of 293", 293 - chunks)]);
        assert!(!ran.err.contains("not sound"), "{ran:?}");
        fs::remove_dir_all(desk.path("map.csv.parts")).unwrap();
    }
}

//! Disks that are full, folders that cannot be written or are gone: told at once, and nothing that is finished is lost.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::process::Command;

use vibrochain_testkit::{BESIDE, CHUNK_CELLS, CHUNKS, Ran, SCENE, TestDir, undisturbed};

const SWEEP: &str = "mapgen sweep scene.toml --out map.csv --quiet --threads 1";

/// Runs with a limit on the size of files, in bytes. What is written beyond it fails as on a full disk, but for its name.
fn limited(dir: &TestDir, line: &str, bytes: usize) -> Ran {
    // POSIX counts 512 bytes a block.
    dir.shell(&format!("ulimit -f {}; exec {line}", bytes / 512))
}

#[test]
fn a_table_that_does_not_fit_loses_no_chunk() {
    let expected = undisturbed(SCENE);
    let dir = TestDir::with_scene(SCENE);
    // Every chunk fits, the table does not.
    let ran = limited(&dir, SWEEP, expected.len() / 2);
    let told = "15 of 15 chunks are finished, in map.csv.parts; go on with: mapgen sweep scene.toml --out map.csv";
    ran.with(1, &["could not write map.csv: File too large", told]);
    assert_eq!(dir.names("."), ["map.csv.parts", "scene.toml"]);
    assert_eq!(dir.chunks("map.csv.parts") as u64, CHUNKS);
    dir.shell(&format!("{SWEEP} --resume")).with(0, &[]);
    assert!(dir.read("map.csv") == expected);
    assert_eq!(dir.json("map.manifest.json")["computed_cells"], 0);

    dir.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    limited(&dir, "mapgen merge parts --out other.csv", expected.len() / 2).with(1, &["could not write other.csv"]);
    assert_eq!(dir.names("."), ["map.csv", "map.manifest.json", "parts", "scene.toml"]);
}

#[test]
fn a_chunk_that_does_not_fit_is_not_there_and_those_before_it_are() {
    let dir = TestDir::with_scene(SCENE);
    dir.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    let sizes: Vec<u64> =
        (0..CHUNKS).map(|i| fs::metadata(dir.path(&format!("parts/{i:06}.chunk"))).unwrap().len()).collect();
    // The first one is smaller than the largest.
    let limit = (sizes[0] as usize).next_multiple_of(512);
    let refused = sizes.iter().position(|&size| size > limit as u64).unwrap();
    limited(&dir, SWEEP, limit).with(1, &["File too large", &format!("{refused} of 15 chunks are finished")]);
    assert_eq!(dir.names("map.csv.parts").len(), refused + BESIDE);
    limited(&dir, &format!("{SWEEP} --resume"), limit).with(1, &[&format!("{refused} of 15 chunks are finished")]);
    dir.shell(&format!("{SWEEP} --resume")).with(0, &[]);
    assert!(dir.read("map.csv") == undisturbed(SCENE));
    assert_eq!(dir.json("map.manifest.json")["computed_cells"], 480_000 - refused as u64 * CHUNK_CELLS);
}

#[test]
fn a_disk_without_room_for_a_plan_is_told_and_nothing_is_left() {
    let dir = TestDir::with_scene(SCENE);
    limited(&dir, SWEEP, 512).with(1, &["map.csv.parts/plan.json: File too large"]);
    assert_eq!(dir.names("."), ["scene.toml"]);
}

/// A file system of four megabytes, where the machine lets us make one.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk() {
    let dir = TestDir::with_scene(SCENE);
    let disk = dir.path("disk");
    fs::create_dir(&disk).unwrap();
    let made = Command::new("mount").args(["-t", "tmpfs", "-o", "size=4m", "tmpfs"]).arg(&disk).output();
    if !made.is_ok_and(|made| made.status.success()) {
        eprintln!("skipped: no file system may be made here");
        return;
    }
    let sweep = "mapgen sweep scene.toml --out disk/map.csv --quiet --threads 1";
    let ran = dir.shell(sweep);
    let kept = dir.chunks("disk/map.csv.parts");
    let names = dir.names("disk/map.csv.parts");
    let larger = Command::new("mount").args(["-o", "remount,size=256m"]).arg(&disk).status();
    let resumed = dir.shell(&format!("{sweep} --resume"));
    let table = fs::read(disk.join("map.csv"));
    let unmounted = Command::new("umount").arg(&disk).status();
    assert!(larger.unwrap().success() && unmounted.unwrap().success());
    ran.with(1, &["No space left on device", &format!("{kept} of 15 chunks are finished, in disk/map.csv.parts")]);
    assert!(kept > 0 && names.len() == kept + BESIDE, "{names:?}");
    resumed.with(0, &[]);
    assert!(table.unwrap() == undisturbed(SCENE));
}

#[test]
fn folders_that_cannot_be_made_or_written_are_refused_before_anything_is_computed() {
    let dir = TestDir::with_scene(SCENE);
    for (line, told) in [
        ("sweep scene.toml --out scene.toml/map.csv", "cannot write scene.toml/map.csv: "),
        ("sweep scene.toml --out /proc/none/map.csv", "cannot write /proc/none/map.csv: "),
        ("sweep scene.toml --out /proc/none/parts --shard 0/2", "cannot make the folder /proc/none/parts: "),
        ("sweep scene.toml --out map.csv --png scene.toml/map.png", "cannot write scene.toml/map.png: "),
    ] {
        dir.run(line).with(2, &[told]);
        assert_eq!(dir.names("."), ["scene.toml"]);
    }
    fs::write(dir.path("map.csv.parts"), "mine").unwrap();
    dir.run("sweep scene.toml --out map.csv").with(2, &["map.csv.parts is a file, where a folder of chunks would be"]);
    assert_eq!(dir.read("map.csv.parts"), b"mine");
}

/// Somebody whom permissions bind, unlike the administrator: "nobody".
const NOBODY: u32 = 65534;

/// The program in the folder `dir`, run by somebody whom permissions bind. An administrator becomes somebody else, who
/// must be let in there, and to a copy of the program.
fn bound(dir: &TestDir, line: &str) -> Ran {
    let mut command = dir.command(line);
    let probe = dir.path("closed/probe");
    if fs::write(&probe, "").is_err() {
        return command.output().unwrap().into();
    }
    fs::remove_file(probe).unwrap();
    let program = dir.path("mapgen");
    if !program.exists() {
        fs::copy(assert_cmd::cargo::cargo_bin("mapgen"), &program).unwrap();
        fs::set_permissions(dir.path("."), fs::Permissions::from_mode(0o755)).unwrap();
        fs::set_permissions(dir.path("scene.toml"), fs::Permissions::from_mode(0o644)).unwrap();
    }
    command = Command::new(program);
    command.current_dir(dir.path(".")).args(line.split(' ')).uid(NOBODY).gid(NOBODY);
    command.output().unwrap().into()
}

#[test]
fn a_folder_that_may_only_be_read_is_told_and_what_is_in_it_is_left() {
    let dir = TestDir::with_scene(SCENE);
    dir.run("sweep scene.toml --out closed/parts --shard 0/2 --quiet").with(0, &[]);
    let chunks = dir.chunks("closed/parts");
    // The lock is its owner's, until the folder is everybody's.
    for folder in ["closed/parts", "closed"] {
        fs::set_permissions(dir.path(folder), fs::Permissions::from_mode(0o555)).unwrap();
    }
    let share = "sweep scene.toml --out closed/parts --shard 1/2 --resume";
    bound(&dir, share).with(2, &["cannot write closed/parts/lock: Permission denied"]);
    fs::set_permissions(dir.path("closed/parts/lock"), fs::Permissions::from_mode(0o666)).unwrap();
    for (line, code, told) in [
        ("sweep scene.toml --out closed/map.csv", 2, "cannot write closed/map.csv: Permission denied"),
        ("sweep scene.toml --out closed --shard 0/1", 2, "cannot write closed/lock: Permission denied"),
        ("sweep scene.toml --out closed/new --shard 0/1", 2, "cannot make the folder closed/new: Permission denied"),
        (share, 1, "cannot write closed/parts/000001.chunk: Permission denied"),
        ("merge closed/parts --out closed/map.csv", 2, "cannot write closed/map.manifest.json: Permission denied"),
    ] {
        let ran = bound(&dir, line).with(code, &[told]);
        assert!(code == 2 || ran.err.contains("0 of 7 chunks are finished, in closed/parts"), "{ran:?}");
        assert_eq!(dir.names("closed"), ["parts"], "{line}");
        assert_eq!(dir.names("closed/parts").len(), chunks + BESIDE, "{line}");
    }
    // Nor is anything amiss but the permissions.
    for folder in ["closed", "closed/parts"] {
        fs::set_permissions(dir.path(folder), fs::Permissions::from_mode(0o777)).unwrap();
    }
    bound(&dir, "sweep scene.toml --out closed/parts --shard 1/2 --resume --quiet").with(0, &[]);
    bound(&dir, "merge closed/parts --out closed/map.csv --quiet").with(0, &[]);
    assert!(dir.read("closed/map.csv") == undisturbed(SCENE));
}

#[test]
fn a_folder_that_vanishes_midway_is_told() {
    let dir = TestDir::with_scene(&SCENE.replace("points = 300", "points = 6000"));
    for line in ["sweep scene.toml --out map.csv --resume", "sweep scene.toml --out map.csv.parts --shard 0/1 --resume"]
    {
        let mut child = dir.start(line);
        dir.await_chunks(&mut child, "map.csv.parts", 2);
        fs::rename(dir.path("map.csv.parts"), dir.path("moved")).unwrap();
        let ran = Ran::from(child.wait_with_output().unwrap());
        let told = ["the folder map.csv.parts has vanished", &format!("start again with: mapgen {line}")];
        ran.with(1, &told);
        assert!(!dir.path("map.csv.parts").exists());
        // What was finished is as good as ever, and nothing else is there.
        let chunks = dir.chunks("moved");
        assert!(chunks >= 2);
        fs::rename(dir.path("moved"), dir.path("map.csv.parts")).unwrap();
        let ran = dir.run("merge map.csv.parts --out other.csv").with(1, &[&format!("{} of 293", 293 - chunks)]);
        assert!(!ran.err.contains("not sound"), "{ran:?}");
        fs::remove_dir_all(dir.path("map.csv.parts")).unwrap();
    }
}

#[test]
fn what_a_killed_process_left_of_a_file_is_removed_by_who_writes_it_next() {
    let dir = TestDir::with_scene(&SCENE.replace("points = 300", "points = 3"));
    dir.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    let abandoned = [".map.csv.aB3d56.part", ".map.manifest.json.aB3d56.part"];
    let others = [".map.csv.zst.aB3d56.part", ".notes.part", ".map.csv.part"];
    others.iter().for_each(|name| fs::write(dir.path(name), "mine").unwrap());
    for line in ["merge parts --out map.csv --quiet", "sweep scene.toml --out map.csv --quiet"] {
        abandoned.iter().for_each(|name| fs::write(dir.path(name), "half").unwrap());
        // Somebody is writing this one.
        let held = fs::File::create(dir.path(".map.csv.xY7z89.part")).unwrap();
        held.lock().unwrap();
        dir.run(line).with(0, &[]);
        let hidden: Vec<_> = dir.names(".").into_iter().filter(|name| name.starts_with('.')).collect();
        assert_eq!(hidden, [".map.csv.part", ".map.csv.xY7z89.part", ".map.csv.zst.aB3d56.part", ".notes.part"]);
        fs::remove_file(dir.path(".map.csv.xY7z89.part")).unwrap();
    }
}

/// What takes no byte is told before anything is computed; and so is help that nobody gets.
#[cfg(target_os = "linux")]
#[test]
fn a_device_that_is_full_is_an_error_of_every_command() {
    let dir = TestDir::with_scene(&crate::destinations::large());
    for line in [
        "sweep scene.toml --out /dev/full",
        "sweep scene.toml --out map.csv --plot /dev/full",
        "sweep scene.toml --out map.csv --png /dev/full",
    ] {
        dir.run(line).with(2, &["cannot write /dev/full: No space left on device"]);
        assert_eq!(dir.names("."), ["scene.toml"], "{line}");
    }
    dir.shell("mapgen sweep scene.toml --out - > /dev/full").with(2, &["cannot write -: No space left on device"]);
    let orbit = format!("orbit --family double-sided {}", crate::destinations::POINT);
    let lines = ["--help", "--version", "orbit --help", "help sweep", "schema orbit", "completions bash", &orbit];
    for line in lines.iter().map(|line| (*line).to_owned()).chain([format!("{orbit} --json")]) {
        let ran = dir.shell(&format!("mapgen {line} > /dev/full"));
        ran.with(1, &["error: cannot write to standard output: No space left on device"]);
        // Whoever has read enough is no failure.
        assert_eq!(dir.shell(&format!("mapgen {line} | head -c 1 > /dev/null")).code, Some(0), "{line}");
    }
}

/// Stacks larger than any address space: no thread can be started.
#[cfg(all(target_os = "linux", target_pointer_width = "64"))]
#[test]
fn threads_that_cannot_start_are_told() {
    let dir = TestDir::with_scene(SCENE);
    dir.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    for line in ["merge parts --out map.csv", "sweep scene.toml --out map.csv", "sweep scene.toml --dry-run"] {
        let ran = dir.command(line).env("RUST_MIN_STACK", (1_u64 << 47).to_string()).output().unwrap();
        Ran::from(ran).with(1, &["error: cannot start ", " threads: "]);
        assert!(!dir.path("map.csv").exists() && !dir.path("map.csv.parts").exists());
    }
}

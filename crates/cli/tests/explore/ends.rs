//! How the explorer ends, and why it cannot begin.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::json;
use vibrochain_testkit::TestDir;

use crate::points::{MODEL, model};
use crate::served::{Served, scene, until};
use crate::waiting::long_borders;

/// What cannot remove its files any more has them removed: by what it has started, or by the next explorer.
#[cfg(unix)]
#[test]
fn an_explorer_that_is_killed_leaves_nothing_running_and_no_files_for_long() {
    let mut served = Served::new("");
    let asked = served.ask("curves", &long_borders());
    until("borders under way", || served.has_files());
    // Its folder is there before the program that fills it: a kill between the two leaves nobody to remove it but the next explorer.
    std::thread::sleep(std::time::Duration::from_millis(500));
    served.child.kill().unwrap();
    served.child.wait().unwrap();
    let left = |served: &Served| fs::read_dir(served.dir.path("tmp")).unwrap().count();
    // The program that computes them removes them when it ends.
    until("the end of what it has started", || left(&served) == 0);
    drop(asked);
    let mut served = Served::new("");
    served.is_alive();
    served.child.kill().unwrap();
    served.child.wait().unwrap();
    assert_eq!(left(&served), 1);
    let dir = std::mem::replace(&mut served.dir, TestDir::new());
    let next = Served::on(dir, "");
    next.is_alive();
    assert_eq!(left(&next), 1);
    assert!(!next.has_files());
}

/// Folders of the same name that somebody else has made, with whatever is in them.
#[cfg(unix)]
#[test]
fn folders_of_others_are_left_alone() {
    let dir = TestDir::new();
    for name in ["mapgen-explore-results", "mapgen-explore-Ab3xYz"] {
        fs::create_dir_all(dir.path(&format!("tmp/{name}/deep"))).unwrap();
        fs::write(dir.path(&format!("tmp/{name}/deep/map.csv")), "mine").unwrap();
    }
    let private = std::os::unix::fs::PermissionsExt::from_mode(0o700);
    fs::set_permissions(dir.path("tmp/mapgen-explore-Ab3xYz"), private).unwrap();
    let served = Served::on(dir, "");
    served.is_alive();
    let own = served.dir.names("tmp").len();
    assert_eq!(own, 3);
    // Nor is one removed by a program that is told its name.
    let line = "orbit --family double-sided --sites 1 --gamma1 1 --gamma2 0 --omega 2 --asymmetry 0";
    let mut command = served.dir.command(line);
    command.env("MAPGEN_EXPLORE_FOLDER", served.dir.path("tmp/mapgen-explore-Ab3xYz"));
    assert!(command.output().unwrap().status.code().is_some());
    std::thread::sleep(std::time::Duration::from_millis(100));
    for name in ["mapgen-explore-results", "mapgen-explore-Ab3xYz"] {
        assert_eq!(served.dir.read(&format!("tmp/{name}/deep/map.csv")), b"mine");
    }
    served.is_alive();
}

/// Each removes what others have left, and none what another has just made.
#[cfg(unix)]
#[test]
fn explorers_that_start_together_have_each_a_folder() {
    let shared = TestDir::new();
    let point = json!({ "model": model(MODEL), "which": "double-sided", "samples": 4 });
    let together = 24;
    let started: Vec<_> = (0..together)
        .map(|_| {
            let dir = TestDir::new();
            let child = Served::start(dir.command("explore --threads 1"), &shared.path("."));
            (dir, child)
        })
        .collect();
    let all: Vec<Served> = started.into_iter().map(|(dir, child)| Served::begun(dir, child)).collect();
    assert_eq!(shared.names(".").len(), together);
    for served in &all {
        // Which needs a folder.
        assert_eq!(served.post("orbit", &point).code, 200);
    }
    assert_eq!(shared.names(".").len(), together);
}

/// The system cannot close the temporary folder: no reason to end, nor to leave anything.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_cannot_be_closed_ends_no_explorer() {
    let dir = TestDir::new();
    fs::create_dir_all(dir.path("tmp/other")).unwrap();
    let temporary = dir.path("tmp").canonicalize().unwrap();
    let mut command = Command::new("strace");
    command.args(["-D", "-f", "-qqq", "-o"]).arg(dir.path("trace")).args(["-e", "inject=close:error=EIO", "-P"]);
    command.arg(&temporary).arg(assert_cmd::cargo::cargo_bin("mapgen")).arg("explore").current_dir(dir.path("."));
    let traced = Command::new("strace").args(["-o", "/dev/null", "true"]).output();
    if !traced.is_ok_and(|ran| ran.status.success()) {
        eprintln!("skipped: strace cannot be had, or may not trace here");
        return;
    }
    let child = Served::start(command, &temporary);
    let served = Served::begun(dir, child);
    let point = json!({ "model": model(MODEL), "which": "double-sided", "samples": 4 });
    assert_eq!(served.post("orbit", &point).code, 200);
    served.is_alive();
    let trace = String::from_utf8(served.dir.read("trace")).unwrap();
    assert!(trace.contains("EIO") && trace.contains("INJECTED"), "{trace}");
}

#[cfg(unix)]
#[test]
fn it_ends_well_by_ctrl_c_and_says_why_it_cannot_begin() {
    let dir = TestDir::with_scene(
        "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\ngamma2 = 0.1\n[sweep]\n\
        x = { parameter = \"omega\", from = 0.6, to = 2.0, points = 30 }\n[compute]\nfamilies = [\"double-sided\"]\n",
    );
    dir.run("explore scene.toml").with(2, &["scene.toml: a map to fly over has two axes"]);
    dir.run("explore none.toml").with(2, &["none.toml"]);
    dir.run("explore --port 65536").with(2, &["--port", "too large"]);
    // An address that no browser opens as it is printed is not printed.
    dir.run("explore --port 80").with(2, &["--port 80 is that of HTTP itself", "give one from 1024"]);
    dir.run("explore --port 6000").with(2, &["--port 6000 is one that browsers refuse"]);
    let served = Served::new("");
    dir.run(&format!("explore --port {}", served.port)).with(1, &[&format!("cannot serve on port {}", served.port)]);
    if vibrochain_testkit::interrupts_are_ignored() {
        return;
    }
    // With work under way, and a connection that is kept open.
    fs::create_dir(dir.path("tmp")).unwrap();
    let mut command = dir.command("explore --port 0");
    let mut child =
        command.env("TMPDIR", dir.path("tmp")).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut address = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut address).unwrap();
    let rest = address.trim().strip_prefix("http://").unwrap();
    let (host, path) = rest.split_once('/').unwrap();
    let mut stream = TcpStream::connect(host).unwrap();
    let mut slow = scene();
    slow["model"]["sites"] = 1001.into();
    let tile = json!({ "scene": slow, "z": 6, "x": 30, "y": 10 });
    let mut second = TcpStream::connect(host).unwrap();
    for (stream, name, body) in [(&mut stream, "tile", tile), (&mut second, "curves", long_borders())] {
        let body = body.to_string();
        let head = format!("POST /{path}{name} HTTP/1.1\r\nHost: {host}\r\nContent-Length: {}", body.len());
        stream.write_all(format!("{head}\r\n\r\n{body}").as_bytes()).unwrap();
    }
    // One folder of all, in it that of the borders, in that their scene.
    let entries = |folder: &Path| -> Vec<_> { fs::read_dir(folder).unwrap().map(|one| one.unwrap().path()).collect() };
    until("borders under way", || {
        entries(&dir.path("tmp")).iter().any(|own| entries(own).iter().any(|one| one.join("view.toml").exists()))
    });
    vibrochain_testkit::signal(child, "INT").with(0, &["open this address in a browser"]);
    assert_eq!(entries(&dir.path("tmp")).len(), 0);
}

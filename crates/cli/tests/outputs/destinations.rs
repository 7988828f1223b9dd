//! Outputs that are not plain files, names that promise something else, and files that have two uses.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::{FileTypeExt, symlink};
use std::process::{Command, Output};

use vibrochain_testkit::{SCENE, TestDir};

pub(crate) const POINT: &str = "--sites 6 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4";

/// More than a pipe and the program hold together, and seconds of work.
pub(crate) fn large() -> String {
    SCENE.replace("points = 300", "points = 6000")
}

/// 1200 cells with stability, and the same as chunks.
pub(crate) fn small() -> TestDir {
    let scene = SCENE.replace("points = 1600", "points = 40").replace("points = 300", "points = 30");
    let dir = TestDir::with_scene(&scene.replace("families", "stability = true\nfamilies"));
    // A corner of it with a few stripes.
    let thin = [("from = 0.4, to = 3.0", "from = 1.3, to = 1.6"), ("from = 0.0, to = 0.3", "from = 0.02, to = 0.06")];
    let thin = thin.iter().fold(scene, |scene, (whole, part)| scene.replace(whole, part));
    fs::write(dir.path("thin.toml"), thin.replace("families", "stability = true\nfamilies")).unwrap();
    dir.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    fs::create_dir(dir.path("elsewhere")).unwrap();
    dir
}

/// Every option that names a file, as FILE in a line, and an ending that it may have.
fn options() -> Vec<(String, &'static str)> {
    let orbit = format!("orbit --family double-sided {POINT}");
    let simulate = format!("simulate --family double-sided {POINT} --periods 3 --samples 8");
    let mut all = vec![
        ("sweep scene.toml --out FILE --quiet".to_owned(), "csv"),
        ("merge parts --out FILE --quiet".to_owned(), "csv"),
        (format!("{orbit} --multipliers FILE"), "csv"),
        (format!("{simulate} --impacts FILE"), "csv"),
        (format!("{simulate} --trajectory FILE"), "csv"),
    ];
    all.extend([
        ("sweep scene.toml --out elsewhere/map.csv --png FILE --quiet".to_owned(), "png"),
        ("sweep scene.toml --out elsewhere/map.csv --svg FILE --quiet".to_owned(), "svg"),
        ("merge parts --out elsewhere/map.csv --png FILE --quiet".to_owned(), "png"),
        ("sweep scene.toml --out elsewhere/map.csv --pdf FILE --quiet".to_owned(), "pdf"),
        (format!("{orbit} --plot FILE"), "png"),
        (format!("{simulate} --plot FILE"), "png"),
        ("stripes thin.toml --out FILE".to_owned(), "csv"),
    ]);
    if cfg!(feature = "compress") {
        all.push(("sweep scene.toml --out FILE --quiet".to_owned(), "csv.gz"));
    }
    all
}

/// Whether a manifest lies beside the file of a line: beside a table that a picture can be drawn from again.
fn has_manifest(line: &str) -> bool {
    line.contains("--out FILE --quiet")
}

/// What a line writes into a plain file, which is then removed.
fn expected(dir: &TestDir, line: &str, ending: &str) -> Vec<u8> {
    let name = format!("expected.{ending}");
    dir.run(&line.replace("FILE", &name)).with(0, &[]);
    let bytes = dir.read(&name);
    assert!(bytes.len() > 100, "{line}");
    fs::remove_file(dir.path(&name)).unwrap();
    let _ = fs::remove_file(dir.path("expected.manifest.json"));
    bytes
}

fn raw(dir: &TestDir, line: &str) -> Output {
    dir.command(line).output().unwrap()
}

pub(crate) fn make_pipe(dir: &TestDir, name: &str) {
    assert!(Command::new("mkfifo").arg(dir.path(name)).status().unwrap().success());
}

pub(crate) fn is_pipe(dir: &TestDir, name: &str) -> bool {
    fs::symlink_metadata(dir.path(name)).unwrap().file_type().is_fifo()
}

/// A document names itself.
fn same(document: &[u8], expected: &[u8], name: &str, ending: &str) -> bool {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).replace(&format!("--document {name}"), "--document");
    match ending {
        "md" => text(document) == String::from_utf8_lossy(expected).replace("--document expected.md", "--document"),
        _ => document == expected,
    }
}

#[test]
fn standard_output_takes_any_one_file_and_words_go_elsewhere() {
    let dir = small();
    for (line, ending) in options() {
        let expected = expected(&dir, &line, ending);
        let before = dir.names(".");
        // Without an ending a table is plain, and --plot a PNG.
        if ending == "csv.gz" {
            continue;
        }
        let ran = raw(&dir, &line.replace("FILE", "-"));
        assert_eq!(ran.status.code(), Some(0), "{line} {ran:?}");
        assert!(same(&ran.stdout, &expected, "-", ending), "{line}");
        assert_eq!(dir.names("."), before, "{line}");
        // By its other names, and by a link: from there a regular file is not put in its place either.
        for name in ["/proc/self/fd/1", "/dev/fd/1", "link"] {
            let _ = fs::remove_file(dir.path("link"));
            symlink("/proc/self/fd/1", dir.path("link")).unwrap();
            let shown = line.replace("FILE", name);
            let ran = dir.shell(&format!("{{ echo before; mapgen {shown} 2>words; echo after; }} > got"));
            ran.with(0, &[]);
            let got = dir.read("got");
            let inner = got.strip_prefix(b"before\n").and_then(|rest| rest.strip_suffix(b"after\n"));
            assert!(same(inner.unwrap(), &expected, name, ending), "{shown}");
            ["got", "words", "link"].iter().for_each(|name| fs::remove_file(dir.path(name)).unwrap());
            assert_eq!(dir.names("."), before, "{shown}");
        }
    }
}

#[test]
fn pipes_are_written_to_and_stay_pipes() {
    let dir = small();
    for (line, ending) in options() {
        let expected = expected(&dir, &line, ending);
        let name = format!("pipe.{ending}");
        make_pipe(&dir, &name);
        // By a link as well.
        symlink(&name, dir.path(&format!("link.{ending}"))).unwrap();
        let mut before = dir.names(".");
        for name in [name.clone(), format!("link.{ending}")] {
            let line = line.replace("FILE", &name);
            let ran = dir.shell(&format!("timeout 60 cat {name} > got 2>&1 & mapgen {line} && wait")).with(0, &[]);
            assert!(same(&dir.read("got"), &expected, &name, ending), "{line} {ran:?}");
            fs::remove_file(dir.path("got")).unwrap();
            assert_eq!(dir.names("."), before, "{line}");
            assert!(is_pipe(&dir, &format!("pipe.{ending}")));
        }
        // As the shell's `>(…)` has it: an open pipe without a name of its own.
        let numbered = line.replace("FILE", "/dev/fd/3");
        if !ending.ends_with("gz") {
            dir.shell(&format!("{{ mapgen {numbered} 3>&1 >/dev/null 2>&1 | cat > got; }}")).with(0, &[]);
            assert!(same(&dir.read("got"), &expected, "/dev/fd/3", ending), "{numbered}");
            // An open file: what is in it is somebody's.
            dir.shell(&format!("echo first > got; mapgen {numbered} 3>>got >/dev/null 2>&1")).with(0, &[]);
            assert!(same(dir.read("got").strip_prefix(b"first\n").unwrap(), &expected, "/dev/fd/3", ending));
            fs::remove_file(dir.path("got")).unwrap();
        }
        fs::remove_file(dir.path(&name)).unwrap();
        fs::remove_file(dir.path(&format!("link.{ending}"))).unwrap();
        before.retain(|left| *left != name && *left != format!("link.{ending}"));
        assert_eq!(dir.names("."), before);
    }
}

/// Devices of our own in a folder of our own, where the machine lets us make them: nothing may happen to those in /dev.
#[test]
fn devices_are_written_to_and_stay_devices() {
    let dir = small();
    let made = |name: &str, minor: &str| {
        let path = dir.path(name);
        let made = Command::new("mknod").arg(&path).args(["c", "1", minor]).output();
        made.is_ok_and(|made| made.status.success()) && fs::OpenOptions::new().write(true).open(path).is_ok()
    };
    if !(made("null", "3") && made("full", "7")) {
        eprintln!("skipped: no device may be made here");
        return;
    }
    symlink("null", dir.path("link")).unwrap();
    let before = dir.names(".");
    for (line, _) in options() {
        for name in ["null", "link"] {
            dir.run(&line.replace("FILE", name)).with(0, &[]);
        }
        // Before anything is computed.
        dir.run(&line.replace("FILE", "full")).with(2, &["cannot write full: No space left on device"]);
        assert_eq!(dir.names("."), before, "{line}");
        for name in ["null", "full"] {
            assert!(fs::symlink_metadata(dir.path(name)).unwrap().file_type().is_char_device());
        }
        assert!(fs::symlink_metadata(dir.path("link")).unwrap().is_symlink());
    }
    // They take any number of files.
    dir.run("sweep scene.toml --out null --png null --svg link --quiet").with(0, &[]);
}

#[test]
fn links_are_followed_also_to_what_is_yet_to_be_made() {
    let dir = small();
    fs::create_dir(dir.path("target")).unwrap();
    for (line, ending) in options() {
        let expected = expected(&dir, &line, ending);
        // Two links, of which the second is relative to its own folder; the target is old, or missing, folder and all.
        symlink(format!("elsewhere/second.{ending}"), dir.path(&format!("first.{ending}"))).unwrap();
        for target in ["target/old", "target/new", "missing/new"] {
            let target = format!("{target}.{ending}");
            let second = dir.path(&format!("elsewhere/second.{ending}"));
            let _ = fs::remove_file(&second);
            symlink(format!("../{target}"), &second).unwrap();
            if target.contains("old") {
                fs::write(dir.path(&target), "old").unwrap();
            }
            let name = format!("first.{ending}");
            dir.run(&line.replace("FILE", &name)).with(0, &[]);
            assert!(same(&dir.read(&target), &expected, &name, ending), "{line} {target}");
            assert!(dir.path(&name).is_symlink() && second.is_symlink(), "{line} {target}");
            fs::remove_file(dir.path(&target)).unwrap();
        }
        assert!(dir.names("target").is_empty() && dir.names("missing").is_empty(), "{line}");
        // The manifest goes by the name that was given.
        let manifest = fs::remove_file(dir.path("first.manifest.json")).is_ok();
        assert_eq!(manifest, has_manifest(&line), "{line}");
        fs::remove_dir(dir.path("missing")).unwrap();
        // A ring of links leads nowhere.
        let second = dir.path(&format!("elsewhere/second.{ending}"));
        fs::remove_file(&second).unwrap();
        symlink(format!("../first.{ending}"), &second).unwrap();
        dir.run(&line.replace("FILE", &format!("first.{ending}"))).with(2, &["cannot write first."]);
        fs::remove_file(&second).unwrap();
        fs::remove_file(dir.path(&format!("first.{ending}"))).unwrap();
    }
}

#[test]
fn folders_are_refused_before_anything_is_computed() {
    let dir = TestDir::with_scene(&large().replace("families", "stability = true\nfamilies"));
    fs::copy(dir.path("scene.toml"), dir.path("thin.toml")).unwrap();
    dir.run("sweep scene.toml --out parts --shard 46/2000 --quiet").with(0, &[]);
    fs::create_dir(dir.path("elsewhere")).unwrap();
    symlink("elsewhere", dir.path("link")).unwrap();
    let before = dir.names(".");
    let mut asked = 0;
    for (line, _) in options() {
        for name in [".", "..", "/", "elsewhere", "elsewhere/", "link", "newdir/", "newdir/.", "newdir/new/"] {
            dir.run(&line.replace("FILE", name)).with(2, &["cannot write"]);
            assert_eq!(dir.names("."), before, "{line} {name}");
            asked += 1;
        }
    }
    assert!(asked > 50);
}

#[test]
fn endings_that_promise_something_else_are_refused() {
    let dir = small();
    let before = (dir.names("."), dir.names("elsewhere"));
    let mut asked = 0;
    for (line, ending) in options() {
        let others = ["csv", "csv.gz", "png", "svg", "jpg", "md", "json", "h5", "toml", "GIF", "pdf", "5"];
        // A table may be compressed, a picture of --plot has either form.
        let either = |other: &str| match ending {
            _ if other == ending => true,
            "csv" | "csv.gz" if line.contains("--out FILE --quiet") => other.starts_with("csv"),
            "png" if !line.contains("--png") => other == "svg" || other == "pdf",
            _ => false,
        };
        for other in others.into_iter().filter(|other| !either(other)) {
            let name = format!("map.{other}");
            dir.run(&line.replace("FILE", &name)).with(2, &[&name, "end the name in ."]);
            asked += 1;
        }
    }
    let orbit = format!("orbit --family double-sided {POINT} --all-plots");
    let mut folders = vec![
        ("sweep scene.toml --shard 0/1 --out map.csv".to_owned(), "--out map.csv ends as a file does: name a folder"),
        ("sweep scene.toml --shard 0/1 --out -".to_owned(), "--out - is standard output: name a folder"),
        ("sweep scene.toml --shard 0/1 --out scene.toml".to_owned(), "the scene and --out"),
    ];
    folders.extend([
        (format!("{orbit} a.png"), "--all-plots a.png ends as a file does"),
        (format!("{orbit} -"), "--all-plots - is standard output"),
    ]);
    for (line, told) in folders {
        dir.run(&line).with(2, &[told]);
    }
    assert_eq!((dir.names("."), dir.names("elsewhere")), before);
    assert!(asked > 60);
}

#[test]
fn capitals_are_as_good_as_small_letters() {
    let dir = small();
    for (line, ending) in options() {
        let expected = expected(&dir, &line, ending);
        let name = format!("MAP.{}", ending.to_uppercase());
        dir.run(&line.replace("FILE", &name)).with(0, &[]);
        assert!(same(&dir.read(&name), &expected, &name, ending), "{line}");
        let manifest = fs::remove_file(dir.path("MAP.manifest.json")).is_ok();
        assert_eq!(manifest, has_manifest(&line), "{line}");
        fs::remove_file(dir.path(&name)).unwrap();
    }
}

#[test]
fn no_file_has_two_uses_by_whatever_names() {
    let dir = small();
    let state = r#"{"displacement":[0,0,0,0,0,0],"velocity":[0.5,0,0,0,0,0]}"#;
    fs::write(dir.path("state.csv"), state).unwrap();
    fs::copy(dir.path("scene.toml"), dir.path("scene.csv")).unwrap();
    symlink("scene.csv", dir.path("link.csv")).unwrap();
    symlink("elsewhere", dir.path("folder")).unwrap();
    symlink("elsewhere/absent.csv", dir.path("dangling.csv")).unwrap();
    make_pipe(&dir, "pipe.csv");
    let before = (dir.names("."), dir.names("elsewhere"), dir.names("parts"));
    let orbit = format!("orbit --family double-sided {POINT}");
    let simulate = format!("simulate --state state.csv {POINT} --amplitude .1 --restitution .9");
    let mut cases = vec![
        ("sweep scene.csv --out new/../scene.csv".to_owned(), "the scene and --out"),
        ("sweep scene.csv --out link.csv".to_owned(), "the scene and --out"),
        ("sweep scene.toml --out new/../scene.toml".to_owned(), "the scene and --out"),
        ("sweep link.csv --out ./scene.csv".to_owned(), "the scene and --out"),
        ("sweep scene.csv --shard 0/2 --out parts/../scene.csv".to_owned(), "the scene and --out"),
        ("merge parts --out parts/000000.chunk".to_owned(), "--out and a chunk are the same file"),
        (format!("{simulate} --impacts new/../state.csv"), "--state and --impacts"),
        (format!("{simulate} --impacts folder/a.csv --trajectory elsewhere/a.csv"), "--impacts and --trajectory"),
        (format!("{simulate} --impacts dangling.csv --trajectory folder/absent.csv"), "--impacts and --trajectory"),
        (format!("{simulate} --impacts - --trajectory -"), "--impacts and --trajectory"),
        (format!("{simulate} --impacts pipe.csv --trajectory ./pipe.csv"), "--impacts and --trajectory"),
    ];
    cases.extend([
        ("sweep scene.toml --out - --png -".to_owned(), "--out and --png"),
        ("sweep scene.toml --out map.csv --png - --svg /proc/self/fd/1".to_owned(), "--png and --svg"),
        ("sweep scene.toml --out map --png map".to_owned(), "--out and --png"),
        ("sweep scene.toml --out map.csv --png map.csv.parts".to_owned(), "the folder of chunks and --png"),
        ("merge parts --out map --svg new/../map".to_owned(), "--out and --svg"),
        ("stripes scene.csv --out folder/../scene.csv".to_owned(), "the scene and --out"),
        (format!("{orbit} --multipliers - --plot -"), "--multipliers and --plot"),
        (format!("{orbit} --multipliers pipe.csv --plot pipe.csv"), "--multipliers and --plot"),
        (format!("{orbit} --plot pics --all-plots pics"), "--plot and --all-plots"),
        (format!("{orbit} --plot new/../pics/solution-1-trace.png --all-plots pics"), "a name that --all-plots uses"),
    ]);
    for (line, told) in cases {
        dir.run(&line).with(2, &[told]);
        assert_eq!((dir.names("."), dir.names("elsewhere"), dir.names("parts")), before, "{line}");
    }
    assert_eq!(dir.read("state.csv"), state.as_bytes());
    assert!(is_pipe(&dir, "pipe.csv") && dir.read("scene.csv") == dir.read("scene.toml"));
    // A chunk may be reached by a name that promises a table.
    symlink("parts/000000.chunk", dir.path("chunk.csv")).unwrap();
    let chunk = dir.read("parts/000000.chunk");
    dir.run("merge parts --out chunk.csv").with(2, &["--out and a chunk are the same file"]);
    assert!(dir.read("parts/000000.chunk") == chunk);
    // The same names are fine where nothing meets, and so is a table beside the chunks.
    dir.run("merge parts --out parts/map.csv --quiet").with(0, &[]);
}

#[test]
fn a_table_that_goes_elsewhere_keeps_nothing() {
    let dir = small();
    let before = dir.names(".");
    let ran = dir.run("sweep scene.toml --out -").with(0, &["1200 cells (40 × 30)"]);
    assert_eq!(ran.out.lines().count(), 1201);
    let told = "--resume has nothing to go on with: --out - is no plain file";
    dir.run("sweep scene.toml --out - --resume").with(2, &[told]);
    let merged = dir.run("merge parts --out -").with(0, &["1200 cells"]);
    assert!(merged.out == ran.out && dir.names(".") == before);
}

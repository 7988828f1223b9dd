//! A folder to work in, and the program as its users start it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

use crate::schema::written;

/// 480 000 cells of a small ring without stability: fifteen chunks, half a second.
pub const SCENE: &str = r#"
[model]
sites = 6
gamma1 = 0.2
asymmetry = 0.4
[sweep]
x = { parameter = "omega", from = 0.4, to = 3.0, points = 1600 }
y = { parameter = "gamma2", from = 0.0, to = 0.3, points = 300 }
[compute]
families = ["double-sided", "single-sided"]
"#;

/// Its chunks.
pub const CHUNKS: u64 = 15;
/// Cells of each but the last.
pub const CHUNK_CELLS: u64 = 32_768;

/// Files in a folder of chunks that are none: the plan and the lock.
pub const BESIDE: usize = 2;

/// The least of three chunks' worth of work for a slow machine's patience.
const PATIENCE: Duration = Duration::from_secs(60);

/// A folder of one test's own.
#[derive(Debug)]
pub struct TestDir {
    folder: TempDir,
    program: &'static str,
}

/// How a run ended, and what it said.
#[derive(Debug)]
pub struct Ran {
    /// Exit code, unless a signal ended it.
    pub code: Option<i32>,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl From<Output> for Ran {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code(),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

impl Ran {
    /// Demands an exit code and words on standard error.
    #[track_caller]
    #[allow(clippy::must_use_candidate, reason = "mostly for the demand alone")]
    pub fn with(self, code: i32, words: &[&str]) -> Self {
        assert_eq!(self.code, Some(code), "{self:?}");
        for word in words {
            assert!(self.err.contains(word), "no `{word}` in {self:?}");
        }
        assert!(code == 0 || !self.err.contains("panicked"), "{self:?}");
        self
    }
}

impl Default for TestDir {
    fn default() -> Self {
        Self::new()
    }
}

impl TestDir {
    /// An empty folder, for `mapgen`.
    #[must_use]
    pub fn new() -> Self {
        Self::of("mapgen")
    }

    /// An empty folder, for another program.
    #[must_use]
    pub fn of(program: &'static str) -> Self {
        Self { folder: tempfile::tempdir().unwrap(), program }
    }

    /// The path of a file in it.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A folder with `scene.toml`.
    #[must_use]
    pub fn with_scene(text: &str) -> Self {
        let dir = Self::new();
        dir.scene(text);
        dir
    }

    /// Writes `scene.toml`.
    pub fn scene(&self, text: &str) -> PathBuf {
        let path = self.path("scene.toml");
        fs::write(&path, text).unwrap();
        path
    }

    /// The program, in this folder and outside of any job.
    #[must_use]
    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin(self.program));
        command.current_dir(self.folder.path()).args(line.split(' ')).stdin(Stdio::null());
        for variable in ["ID", "MIN", "MAX", "COUNT", "STEP"] {
            command.env_remove(format!("SLURM_ARRAY_TASK_{variable}"));
        }
        command.env_remove("SLURM_CPUS_PER_TASK");
        command
    }

    /// Runs the program to its end. An answer in JSON must have the form that it names.
    #[must_use]
    pub fn run(&self, line: &str) -> Ran {
        let ran = Ran::from(self.command(line).output().unwrap());
        if ran.out.starts_with('{') && !line.starts_with("schema") {
            drop(written(&ran.out));
        }
        ran
    }

    /// A line for the shell in this folder, with `mapgen` on its path.
    #[must_use]
    pub fn shell(&self, line: &str) -> Ran {
        let program = assert_cmd::cargo::cargo_bin("mapgen");
        let path = std::env::var_os("PATH").unwrap_or_default();
        let mut folders = vec![program.parent().unwrap().to_owned()];
        folders.extend(std::env::split_paths(&path));
        let mut command = Command::new("sh");
        command.current_dir(self.folder.path()).arg("-c").arg(line).env("PATH", std::env::join_paths(folders).unwrap());
        command.output().unwrap().into()
    }

    /// Starts the program; standard output is thrown away.
    #[must_use]
    pub fn start(&self, line: &str) -> Child {
        self.command(line).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    }

    /// A file's bytes.
    #[must_use]
    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The value of a file that the program has written; it must have the form that it names.
    #[must_use]
    pub fn json(&self, name: &str) -> Value {
        written(self.read(name))
    }

    /// Names in a folder, hidden ones too.
    #[must_use]
    pub fn names(&self, folder: &str) -> Vec<String> {
        let entries = fs::read_dir(self.path(folder)).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Finished chunks in a folder that may not be there yet.
    #[must_use]
    pub fn chunks(&self, folder: &str) -> usize {
        let Ok(entries) = fs::read_dir(self.path(folder)) else { return 0 };
        entries.flatten().filter(|entry| is_chunk(&entry.path())).count()
    }

    /// Waits until so many chunks are finished, or the process has ended.
    pub fn await_chunks(&self, child: &mut Child, folder: &str, count: usize) {
        let begun = Instant::now();
        while self.chunks(folder) < count && child.try_wait().unwrap().is_none() {
            assert!(begun.elapsed() < PATIENCE, "no {count} chunks in {folder}");
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// A chunk's file, and not one under way.
fn is_chunk(path: &Path) -> bool {
    let hidden = path.file_name().unwrap().to_string_lossy().starts_with('.');
    !hidden && path.extension().is_some_and(|end| end == "chunk")
}

/// Sends a signal and waits for the end.
#[cfg(unix)]
#[must_use]
pub fn signal(child: Child, name: &str) -> Ran {
    let sent = Command::new("kill").args([&format!("-{name}"), &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    child.wait_with_output().unwrap().into()
}

/// Whether SIGINT is ignored here, and so by every program that is started from here.
#[must_use]
pub fn interrupts_are_ignored() -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.is_some_and(|mask| u64::from_str_radix(mask.trim(), 16).unwrap() & 2 != 0)
}

/// The table of a scene as an undisturbed run makes it, on one thread; computed once in a process.
#[must_use]
pub fn undisturbed(scene: &str) -> &'static [u8] {
    static TABLES: Mutex<BTreeMap<String, &'static [u8]>> = Mutex::new(BTreeMap::new());
    let mut tables = TABLES.lock().unwrap_or_else(PoisonError::into_inner);
    tables.entry(scene.to_owned()).or_insert_with(|| {
        let dir = TestDir::with_scene(scene);
        dir.run("sweep scene.toml --out map.csv --threads 1 --quiet").with(0, &[]);
        assert_eq!(dir.names("."), ["map.csv", "map.manifest.json", "scene.toml"]);
        drop(dir.json("map.manifest.json"));
        Box::leak(dir.read("map.csv").into_boxed_slice())
    })
}

/// The program with these arguments, for a test to make demands of.
#[must_use]
pub fn mapgen(arguments: &[&str]) -> assert_cmd::Command {
    program("mapgen", arguments)
}

/// The program `studies` with these arguments.
#[must_use]
pub fn studies(arguments: &[&str]) -> assert_cmd::Command {
    program("studies", arguments)
}

fn program(name: &str, arguments: &[&str]) -> assert_cmd::Command {
    let mut command = assert_cmd::Command::cargo_bin(name).unwrap();
    command.args(arguments);
    command
}

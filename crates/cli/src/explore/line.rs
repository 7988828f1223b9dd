//! A command line of this program, made for a page and run in its place.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Map, Value, json};

use super::folder::{Folder, Scratch};
use crate::common::chunked_run::quoted;
use vibrochain_explore::Refusal;
use vibrochain_lattice::Stop;
use vibrochain_maps::files::{Entry, entries};

/// A command line, and files beside it.
pub(super) struct Line {
    words: Vec<Word>,
    /// A scene that it reads.
    scene: Option<String>,
}

/// A word of a command line.
enum Word {
    Plain(String),
    /// A file in a folder of the answer's own.
    File(&'static str),
}

/// What the scene of a window is called in the commands that are shown.
pub(super) const VIEW: &str = "view.toml";

impl Line {
    pub(super) fn new(command: &str) -> Self {
        Self { words: vec![Word::Plain(command.to_owned())], scene: None }
    }

    /// One about the scene of a window, of which this is the text.
    pub(super) fn of_view(command: &str, scene: String) -> Self {
        Self { scene: Some(scene), ..Self::new(command) }.file(VIEW)
    }

    /// A flag without a value.
    pub(super) fn switch(mut self, name: &str) -> Self {
        self.words.push(Word::Plain(format!("--{name}")));
        self
    }

    /// A flag and its value in one word: no value is ever taken for another flag.
    pub(super) fn flag(self, name: &str, value: impl std::fmt::Display) -> Self {
        self.switch(&format!("{name}={value}"))
    }

    pub(super) fn file(mut self, name: &'static str) -> Self {
        self.words.push(Word::File(name));
        self
    }

    pub(super) fn output(self, flag: &str, name: &'static str) -> Self {
        self.switch(flag).file(name)
    }

    /// As one types it.
    pub(super) fn shown(&self) -> String {
        let word = |word: &Word| match word {
            Word::File(name) => (*name).to_owned(),
            Word::Plain(text) => match text.split_once('=') {
                Some((flag, value)) => format!("{flag} {}", quoted(Path::new(value))),
                None => text.clone(),
            },
        };
        let words: Vec<String> = self.words.iter().map(word).collect();
        format!("mapgen {}", words.join(" "))
    }

    /// Runs the program with it: what it has printed, as JSON where it is that, and the files it has written. It runs as a process of its
    /// own, so that it can be ended at any moment, wherever it computes, and takes its memory along.
    pub(super) fn run(&self, setting: &Setting, limit: Duration, stop: &Stop) -> Result<Value, Refusal> {
        let broken = |error: std::io::Error| Refusal::new(500, format!("no place for files: {error}"));
        // A program takes no such word, and the system says so in words of its own.
        ensure!(
            !self.words.iter().any(|word| matches!(word, Word::Plain(text) if text.contains('\0'))),
            "the request has a text with the character NUL in it"
        );
        let folder = Scratch::within(setting.folder.path(), "line-").map_err(broken)?;
        let path = |name: &str| folder.path().join(name);
        if let Some(scene) = &self.scene {
            fs::write(path(VIEW), scene).map_err(broken)?;
        }
        let word = |word: &Word| match word {
            Word::Plain(text) => OsString::from(text),
            Word::File(name) => path(name).into(),
        };
        // Into files: nobody needs to empty a pipe while it runs. Their names are none that a line has.
        let [out, err] = ["standard-output", "standard-error"].map(path);
        let (into_out, into_err) = (fs::File::create(&out).map_err(broken)?, fs::File::create(&err).map_err(broken)?);
        let mut command = Command::new(&setting.program);
        command.args(self.words.iter().map(word)).stdin(Stdio::piped()).stdout(into_out).stderr(into_err);
        setting.folder.tell(&mut command);
        // --threads is a flag of every command; it would be the program's own otherwise.
        command.args(setting.threads.map(|threads| format!("--threads={threads}")));
        let status = ended(command, folder.path(), limit, stop).map_err(|early| self.refused(early, limit))?;
        let text = |path| fs::read(path).map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).map_err(broken);
        let (text, told) = (text(out)?, clean(&text(err)?, folder.path()));
        // The last words of a program that fails.
        let (remarks, error) = told.rfind("error: ").map_or((told.as_str(), ""), |at| told.split_at(at));
        // What was answered before it failed is an answer: an orbit without stability, a run that ends in a cascade.
        if !status.success() && !text.starts_with('{') {
            let code = match status.code() {
                Some(2) => 400,
                Some(3) => 422,
                Some(130) => 503,
                _ => 500,
            };
            // How the command is called is of no help on a page.
            let message = error.strip_prefix("error: ").unwrap_or(&told);
            let message =
                ["\n\nUsage:", "\n\nFor more"].iter().fold(message, |text, end| text.split(end).next().unwrap_or(text));
            return Err(Refusal::new(code, message.trim_end()));
        }
        let answer = serde_json::from_str(&text).unwrap_or_else(|_| Value::from(clean(&text, folder.path())));
        let mut files = Map::new();
        for name in self.words.iter().filter_map(|word| if let Word::File(name) = word { Some(*name) } else { None }) {
            if !name.ends_with(".png")
                && let Ok(text) = fs::read_to_string(path(name))
            {
                files.insert(name.to_owned(), text.into());
            }
        }
        Ok(json!({ "command": self.shown(), "answer": answer, "files": files, "remarks": remarks }))
    }

    fn refused(&self, early: Early, limit: Duration) -> Refusal {
        let advice = format!("ask for less, or run it in a terminal: {}", self.shown());
        match early {
            Early::Stopped => Refusal::new(503, "nobody waits for this answer any more"),
            Early::Late => Refusal::new(500, format!("not done after {} s: {advice}", limit.as_secs())),
            Early::Large => Refusal::new(500, format!("it writes more than {MOST_BYTES} bytes: {advice}")),
            Early::Failed(error) => Refusal::new(500, format!("the program does not run: {error}")),
        }
    }
}

/// What all lines have in common.
pub(crate) struct Setting {
    /// The program that they are lines of.
    program: PathBuf,
    /// Threads, if their number was asked for.
    threads: Option<usize>,
    /// Where each has a folder of its own.
    folder: Folder,
}

impl Setting {
    /// This program, and a new folder.
    ///
    /// # Errors
    /// Those of the system.
    pub(crate) fn new(threads: Option<usize>) -> std::io::Result<Self> {
        Ok(Self { program: own_program()?, threads, folder: Folder::new()? })
    }
}

/// This program. Linux leads to it even after a new one has been installed in its place.
fn own_program() -> std::io::Result<PathBuf> {
    if cfg!(target_os = "linux") { Ok("/proc/self/exe".into()) } else { std::env::current_exe() }
}

/// Why a program was ended.
enum Early {
    Stopped,
    Late,
    Large,
    Failed(std::io::Error),
}

/// The most bytes that a line may write: five times what the largest table that is asked for has.
const MOST_BYTES: u64 = 64 << 20;

/// How often a program is looked at that runs: at first often, as most answers take milliseconds.
const LOOKS: [Duration; 2] = [Duration::from_micros(500), Duration::from_millis(20)];

/// Runs a program to its end, or ends it: once `stop` is raised, after `limit`, or when what it writes into `folder` is too much.
fn ended(mut command: Command, folder: &Path, limit: Duration, stop: &Stop) -> Result<ExitStatus, Early> {
    let started = Instant::now();
    let mut child = command.spawn().map_err(Early::Failed)?;
    let mut look = LOOKS[0];
    let early = loop {
        // Its standard input stays open as long as this is asked, and the explorer lives.
        match child.try_wait() {
            Ok(Some(status)) => return Ok(status),
            Ok(None) => {}
            Err(error) => break Early::Failed(error),
        }
        if stop.is_raised() {
            break Early::Stopped;
        }
        if started.elapsed() > limit {
            break Early::Late;
        }
        if bytes(folder) > MOST_BYTES {
            break Early::Large;
        }
        std::thread::sleep(look);
        look = (2 * look).min(LOOKS[1]);
    };
    // It may have ended by itself meanwhile.
    let _ = child.kill();
    let _ = child.wait();
    Err(early)
}

/// Bytes of the files in a folder.
fn bytes(folder: &Path) -> u64 {
    let size = |entry: Entry| entry.path().symlink_metadata().map_or(0, |data| data.len());
    entries(folder).map_or(0, |entries| entries.flatten().map(size).sum())
}

/// A text without the folder in it, of which nobody has heard.
fn clean(text: &str, folder: &Path) -> String {
    text.replace(&format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR), "")
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;

    const LONG: Duration = Duration::from_secs(600);

    #[cfg(unix)]
    #[test]
    fn a_line_ends_at_its_limit_when_told_and_when_it_writes_too_much() {
        let told = |program: &str, line: Line, limit: Duration, stop: &Stop| {
            let setting = Setting { program: program.into(), ..Setting::new(None).unwrap() };
            let refusal = line.run(&setting, limit, stop).unwrap_err();
            // Nothing of it is left beside the mark of the folder.
            assert_eq!(fs::read_dir(setting.folder.path()).unwrap().count(), 1);
            refusal
        };
        let never = Stop::default();
        let late = told("sleep", Line::new("1000"), Duration::ZERO, &never);
        assert_eq!(late.message, "not done after 0 s: ask for less, or run it in a terminal: mapgen 1000");
        let large = told("yes", Line::new("a"), LONG, &never);
        assert!(large.message.starts_with("it writes more than 67108864 bytes: ask for less"), "{large}");
        let stop = Arc::new(AtomicBool::new(false));
        let raised = Arc::clone(&stop);
        let raises = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(30));
            raised.store(true, Ordering::Relaxed);
        });
        assert_eq!(told("sleep", Line::new("1000"), LONG, &Stop::from(&stop)).code, 503);
        raises.join().unwrap();
        assert!(told("no such program", Line::new(""), LONG, &never).message.contains("does not run"));
    }
}

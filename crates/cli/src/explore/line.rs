//! A command line of this program, made for a page and run in its place.

use std::ffi::OsString;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde_json::{Map, Value, json};
use tempfile::TempDir;

use crate::console::Console;
use crate::error::CliError;
use vibrochain_explore::Refusal;
use vibrochain_lattice::Stop;

/// A program as a function of its arguments, its own name first.
pub(crate) type Runs = fn(Vec<OsString>, &mut Console<'_>) -> Result<(), CliError>;

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
                Some((flag, value)) => format!("{flag} {}", quoted(value)),
                None => text.clone(),
            },
        };
        let words: Vec<String> = self.words.iter().map(word).collect();
        format!("mapgen {}", words.join(" "))
    }

    /// Runs the program with it: what it has printed, as JSON where it is that, and the files it has written.
    pub(super) fn run(&self, program: Runs, threads: Option<usize>, stop: &Arc<AtomicBool>) -> Result<Value, Refusal> {
        let broken = |error: &std::io::Error| Refusal::new(500, format!("no place for files: {error}"));
        let folder = TempDir::new().map_err(|error| broken(&error))?;
        let path = |name: &str| folder.path().join(name);
        if let Some(scene) = &self.scene {
            fs::write(path(VIEW), scene).map_err(|error| broken(&error))?;
        }
        let word = |word: &Word| match word {
            Word::Plain(text) => OsString::from(text),
            Word::File(name) => path(name).into(),
        };
        let arguments: Vec<OsString> = std::iter::once("mapgen".into()).chain(self.words.iter().map(word)).collect();
        let (mut out, mut err) = (Vec::new(), Vec::new());
        let interrupt = || Ok(Stop::from(stop));
        let mut console = Console { threads, ..Console::new(&mut out, &mut err, &interrupt) };
        // --threads is a flag of every command; it would be the program's own otherwise.
        let threads = threads.map(|threads| OsString::from(format!("--threads={threads}")));
        let told = program(arguments.into_iter().chain(threads).collect(), &mut console);
        let text = String::from_utf8_lossy(&out).into_owned();
        let remarks = clean(&String::from_utf8_lossy(&err), folder.path());
        match told {
            Ok(()) | Err(CliError::Unread) => {}
            // What was answered before it failed is an answer: an orbit without stability, a run that ends in a cascade.
            Err(ref error) if text.starts_with('{') && !matches!(error, CliError::Paused(_)) => {}
            Err(error) => return Err(refusal(&error, folder.path())),
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
}

/// A text without the folder in it, of which nobody has heard.
fn clean(text: &str, folder: &Path) -> String {
    text.replace(&format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR), "")
}

fn refusal(error: &CliError, folder: &Path) -> Refusal {
    let code = match error.exit_code() {
        2 => 400,
        3 => 422,
        130 => 503,
        _ => 500,
    };
    Refusal::new(code, clean(&error.to_string(), folder))
}

/// A word for a shell.
fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "+-.,:_/".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}

//! The program in this process, in a folder of its own.

use std::ffi::OsString;
use std::fs;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::TempDir;
use vibrochain_cli::common::console::Console;
use vibrochain_cli::common::error::CliError;
use vibrochain_cli::program;
use vibrochain_lattice::Stop;

use crate::inputs::Input;
use crate::judge::Outcome;

/// Runs the program in this process.
pub(crate) fn mapgen(line: &[OsString], stopped: bool) -> Outcome {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let interrupt = move || Ok(Stop::when(move || stopped));
    let mut console = Console::new(&mut out, &mut err, &interrupt);
    let result = program::run(line.iter().cloned(), &mut console);
    let (code, message) = match &result {
        Ok(()) => (0, String::new()),
        Err(CliError::Usage(error)) => (error.exit_code() as u8, error.render().to_string()),
        Err(error) => {
            console.remark(&format!("error: {error}"));
            (error.exit_code(), String::new())
        }
    };
    Outcome { code, out: String::from_utf8(out).unwrap(), message: String::from_utf8(err).unwrap() + &message }
}

/// A folder of its own as the present one, while it lives; there is one present folder in a process.
pub(crate) struct TestDir {
    pub(crate) folder: TempDir,
    pub(crate) home: PathBuf,
    pub(crate) _alone: MutexGuard<'static, ()>,
}

impl TestDir {
    pub(crate) fn new() -> Self {
        static ALONE: Mutex<()> = Mutex::new(());
        let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
        // In memory, where there is such a folder: a disk would take minutes to see to it that nothing is ever lost.
        let folder = tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).unwrap();
        let dir = Self { folder, home: std::env::current_dir().unwrap(), _alone: alone };
        std::env::set_current_dir(dir.folder.path()).unwrap();
        dir
    }

    pub(crate) fn lay_out(&self, input: &Input) {
        for (name, content) in [("scene.toml", &input.scene), ("state.json", &input.state)] {
            if input.line.iter().any(|word| word == name) {
                fs::write(self.folder.path().join(name), content).unwrap();
            }
        }
        for entry in fs::read_dir(self.folder.path()).unwrap() {
            let entry = entry.unwrap();
            // Chunks of the run before.
            if entry.file_type().unwrap().is_dir() {
                fs::remove_dir_all(entry.path()).unwrap();
            }
        }
        if input.line.iter().any(|word| word == "merge") {
            let parts = self.folder.path().join("parts");
            fs::create_dir(&parts).unwrap();
            for (name, content) in ["plan.json", "000000.chunk"].iter().zip(&input.parts) {
                fs::write(parts.join(name), content).unwrap();
            }
        }
    }
}

impl Drop for TestDir {
    fn drop(&mut self) {
        // A folder that cannot be left stays behind, that is all.
        let _ = std::env::set_current_dir(&self.home);
    }
}

//! The folder of an explorer, which goes however the explorer ends. An explorer that is killed can remove nothing: a program that it has
//! started sees its standard input close, removes the folder and ends; where none runs the next explorer removes it.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

/// What folders of explorers are called.
const PREFIX: &str = "mapgen-explore-";

/// Names the folder to a program that an explorer has started.
const VARIABLE: &str = "MAPGEN_EXPLORE_FOLDER";

/// A folder that nobody else may look into.
pub(super) struct Folder {
    folder: TempDir,
    /// As long as it is held, an explorer lives. Where folders cannot be opened nothing is left over that could be told apart.
    _held: Option<File>,
}

impl Folder {
    /// A new one; those that explorers before have left are removed.
    pub(super) fn new() -> io::Result<Self> {
        let mut folder = tempfile::Builder::new();
        folder.prefix(PREFIX);
        #[cfg(unix)]
        folder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
        let folder = folder.tempdir()?;
        let held = File::open(folder.path()).ok().filter(|file| file.lock().is_ok());
        if let Some(parent) = folder.path().parent().filter(|_| held.is_some()) {
            remove_left(parent);
        }
        Ok(Self { folder, _held: held })
    }

    pub(super) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Tells a program, which is about to be started with a pipe as its standard input, whose folder it works in.
    pub(super) fn tell(&self, command: &mut Command) {
        command.env(VARIABLE, self.path());
    }
}

fn is_named(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(PREFIX))
}

/// Removes the folders of explorers that live no more.
fn remove_left(parent: &Path) {
    let is_left = |path: &PathBuf| is_named(path) && File::open(path).is_ok_and(|folder| folder.try_lock().is_ok());
    let all = fs::read_dir(parent).into_iter().flatten().map_while(Result::ok).map(|entry| entry.path());
    // Those of other users stay.
    all.filter(is_left).for_each(|path| drop(fs::remove_dir_all(path)));
}

/// In a program that an explorer has started: ends it once the explorer has gone.
pub(crate) fn end_with_explorer() {
    let Some(folder) = std::env::var_os(VARIABLE).map(OsString::into_string).and_then(Result::ok) else { return };
    std::thread::spawn(move || {
        // The explorer writes nothing: a read ends when its end of the pipe is closed.
        let closed = io::stdin().lock().read(&mut [0]);
        if closed.is_ok() {
            if is_named(Path::new(&folder)) {
                let _ = fs::remove_dir_all(folder);
            }
            std::process::exit(1);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn nobody_else_sees_the_folder_and_it_goes() {
        use std::os::unix::fs::PermissionsExt;
        let folder = Folder::new().unwrap();
        let path = folder.path().to_owned();
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o7777, 0o700);
        drop(folder);
        assert!(!path.exists());
    }

    #[cfg(unix)]
    #[test]
    fn what_a_killed_explorer_left_is_removed_and_what_a_living_one_has_is_not() {
        let parent = tempfile::tempdir().unwrap();
        let [left, lives, other] = [format!("{PREFIX}a"), format!("{PREFIX}b"), "mapgen-other".to_owned()]
            .map(|name| parent.path().join(name));
        for path in [&left, &lives, &other] {
            fs::create_dir_all(path.join("of a line")).unwrap();
        }
        let held = File::open(&lives).unwrap();
        held.lock().unwrap();
        remove_left(parent.path());
        assert!(!left.exists() && lives.exists() && other.exists());
    }
}

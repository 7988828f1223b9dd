//! The folder of an explorer, which goes however the explorer ends. An explorer that is killed can remove nothing: a program that it has
//! started sees its standard input close, removes the folder and ends; where none runs the next explorer removes it.
//!
//! The temporary folder is everybody's, and a name proves nothing. A folder is removed only if it is our user's, nobody else may look into it,
//! our mark is in it, and no explorer holds its lock. The mark is written after the lock is taken, so that an explorer which has just begun
//! is never taken for one that has ended.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use vibrochain_maps::files::entries;

/// What folders of explorers are called.
const PREFIX: &str = "mapgen-explore-";

/// The file in a folder that says whose it is, and what is in that file.
const MARK: &str = "mapgen-explore.mark";
const WORDS: &str = "This folder is of a running `mapgen explore`, which removes it with all that is in it.\n";

/// Names the folder to a program that an explorer has started.
const VARIABLE: &str = "MAPGEN_EXPLORE_FOLDER";

/// A folder that goes with all that is in it. The standard library, which `TempDir` removes folders with, panics where one cannot be closed.
pub(super) struct Scratch(PathBuf);

impl Scratch {
    /// A new one in `parent`, which nobody else may look into.
    ///
    /// # Errors
    /// Those of the system.
    pub(super) fn within(parent: &Path, prefix: &str) -> io::Result<Self> {
        let mut folder = tempfile::Builder::new();
        folder.prefix(prefix);
        #[cfg(unix)]
        folder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
        Ok(Self(folder.tempdir_in(parent)?.keep()))
    }

    pub(super) fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = remove(&self.0);
    }
}

/// Removes a folder; the mark goes last, so that what could not be removed is still known as ours.
fn remove(folder: &Path) -> io::Result<()> {
    let mut mark = None;
    for entry in entries(folder)? {
        let entry = entry?;
        let path = entry.path();
        if entry.name() == MARK {
            mark = Some(path.to_owned());
        } else if path.symlink_metadata()?.is_dir() {
            remove(path)?;
        } else {
            fs::remove_file(path)?;
        }
    }
    mark.map_or(Ok(()), fs::remove_file)?;
    fs::remove_dir(folder)
}

/// The folder of an explorer.
pub(super) struct Folder {
    folder: Scratch,
    /// As long as it is held, an explorer lives.
    _held: Option<File>,
}

impl Folder {
    /// A new one; those that explorers before have left are removed.
    pub(super) fn new() -> io::Result<Self> {
        Self::within(&std::env::temp_dir())
    }

    fn within(parent: &Path) -> io::Result<Self> {
        let folder = Scratch::within(parent, PREFIX)?;
        let held = File::open(folder.path()).ok().filter(|file| file.lock().is_ok());
        // Where folders cannot be locked, those that live could not be told apart: none is marked, and none is removed.
        if held.is_some() {
            fs::write(folder.path().join(MARK), WORDS)?;
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

/// The lock of a folder that an explorer has made and left. Nothing if it is another's, or if its explorer lives.
#[cfg(unix)]
fn left(path: &Path) -> Option<File> {
    use std::os::unix::fs::MetadataExt;
    let user = rustix::process::geteuid().as_raw();
    let about = |path: &Path| path.symlink_metadata().ok().filter(|found| found.uid() == user);
    let is_marked = || {
        let mark = path.join(MARK);
        about(&mark).is_some_and(|found| found.is_file() && found.len() == WORDS.len() as u64)
            && fs::read(&mark).is_ok_and(|words| words == WORDS.as_bytes())
    };
    let found = about(path).filter(|found| found.is_dir() && found.mode() & 0o7777 == 0o700)?;
    let is_named = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(PREFIX));
    let lock = File::open(path).ok().filter(|folder| is_named && is_marked() && folder.try_lock().is_ok())?;
    // Another explorer may have removed it meanwhile, and a third may have made one of the same name.
    let locked = lock.metadata().ok()?;
    ((locked.dev(), locked.ino()) == (found.dev(), found.ino()) && is_marked()).then_some(lock)
}

/// Elsewhere a folder cannot be opened as a file, so none is marked.
#[cfg(not(unix))]
fn left(_: &Path) -> Option<File> {
    None
}

/// Removes the folders of explorers that live no more.
fn remove_left(parent: &Path) {
    for entry in entries(parent).into_iter().flatten().map_while(Result::ok) {
        let _ = left(entry.path()).map(|_lock| remove(entry.path()));
    }
}

/// How often, and how long after one another, what is left of a folder is looked at: others that the same explorer had started may write into
/// it until they see its end, too.
const LOOKS: u32 = 50;
const PAUSE: Duration = Duration::from_millis(20);

/// In a program that an explorer has started: ends it once the explorer has gone.
pub(crate) fn end_with_explorer() {
    let Some(folder) = std::env::var_os(VARIABLE).map(PathBuf::from) else { return };
    std::thread::spawn(move || {
        // The explorer writes nothing: a read ends when its end of the pipe is closed.
        let closed = io::stdin().lock().read(&mut [0]);
        if closed.is_ok() {
            for _ in 0..LOOKS {
                if left(&folder).is_some_and(|_lock| remove(&folder).is_ok()) || !folder.exists() {
                    break;
                }
                std::thread::sleep(PAUSE);
            }
            std::process::exit(1);
        }
    });
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::{PermissionsExt, symlink};

    use super::*;

    #[test]
    fn nobody_else_sees_the_folder_and_it_goes() {
        let folder = Folder::new().unwrap();
        let path = folder.path().to_owned();
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o7777, 0o700);
        fs::create_dir_all(path.join("of a line/deeper")).unwrap();
        fs::write(path.join("of a line/deeper/map.csv"), "1").unwrap();
        symlink("/", path.join("of a line/elsewhere")).unwrap();
        drop(folder);
        assert!(!path.exists() && Path::new("/").exists());
    }

    /// A folder as an explorer leaves it that is killed, but for what `change` does.
    #[allow(clippy::unwrap_used, reason = "of a test")]
    fn abandoned(parent: &Path, change: impl FnOnce(&Path)) -> PathBuf {
        let Folder { folder, _held } = Folder::within(parent).unwrap();
        let path = folder.path().to_owned();
        std::mem::forget(folder);
        fs::create_dir(path.join("of a line")).unwrap();
        fs::write(path.join("of a line/map.csv"), "1").unwrap();
        change(&path);
        path
    }

    #[test]
    fn what_a_killed_explorer_left_is_removed_and_nothing_else() {
        let parent = tempfile::tempdir().unwrap();
        let within = |name: &str| parent.path().join(name);
        let lives = Folder::within(parent.path()).unwrap();
        let mode = |path: &Path, mode| fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
        // Each differs in one thing.
        let (unmarked, other_words, link_as_mark, open, other_name) = (
            abandoned(parent.path(), |path| fs::remove_file(path.join(MARK)).unwrap()),
            abandoned(parent.path(), |path| fs::write(path.join(MARK), WORDS.to_uppercase()).unwrap()),
            abandoned(parent.path(), |path| {
                fs::rename(path.join(MARK), path.join("words")).unwrap();
                symlink("words", path.join(MARK)).unwrap();
            }),
            abandoned(parent.path(), |path| mode(path, 0o755)),
            within("mine"),
        );
        fs::rename(abandoned(parent.path(), |_| ()), &other_name).unwrap();
        let link = within("mapgen-explore-link");
        symlink(&other_name, &link).unwrap();
        let file = within("mapgen-explore-file");
        fs::write(&file, "mine").unwrap();
        let plain = within("mapgen-explore-of-somebody");
        fs::create_dir(&plain).unwrap();
        fs::write(plain.join("results.csv"), "mine").unwrap();
        let left = abandoned(parent.path(), |_| ());
        assert!(left.exists());
        remove_left(parent.path());
        assert!(!left.exists());
        for kept in [&unmarked, &other_words, &link_as_mark, &open, &other_name, &link] {
            assert!(kept.join("of a line/map.csv").exists(), "{}", kept.display());
        }
        assert!(file.exists() && plain.join("results.csv").exists() && lives.path().join(MARK).exists());
        // Of another user, where tests may make one.
        let others = abandoned(parent.path(), |_| ());
        if std::os::unix::fs::chown(&others, Some(65534), None).is_ok() {
            remove_left(parent.path());
            assert!(others.exists());
            std::os::unix::fs::chown(&others, Some(rustix::process::geteuid().as_raw()), None).unwrap();
        }
        remove_left(parent.path());
        assert!(!others.exists());
    }

    #[test]
    fn explorers_that_begin_at_once_have_each_a_folder() {
        let parent = tempfile::tempdir().unwrap();
        let (mut rounds, together) = (0, 24);
        for _ in 0..20 {
            let left = abandoned(parent.path(), |_| ());
            let begin = std::sync::Barrier::new(together);
            let own: Vec<Folder> = std::thread::scope(|scope| {
                let all: Vec<_> = (0..together)
                    .map(|_| {
                        scope.spawn(|| {
                            begin.wait();
                            Folder::within(parent.path()).unwrap()
                        })
                    })
                    .collect();
                all.into_iter().map(|one| one.join().unwrap()).collect()
            });
            assert!(own.len() == together && own.iter().all(|folder| folder.path().join(MARK).exists()));
            assert!(!left.exists());
            drop(own);
            assert_eq!(fs::read_dir(parent.path()).unwrap().count(), 0);
            rounds += 1;
        }
        assert_eq!(rounds, 20);
    }
}

//! The folder of chunks: a plan, and a file for each chunk that is finished.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, File, TryLockError};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use vibrochain_lattice::{Stop, Stopped, aside};

use super::chunk::{Fault, Writer, check};
use super::content::Content;
use super::plan::{PLAN_BEGINS, Plan};
use crate::error::MapError;
use crate::files::{self, Output, remove_if_abandoned};
use crate::grid::Grid;
use crate::summary::Summary;
use crate::text::{duration, open_plain};

const PLAN: &str = "plan.json";

const CHUNK: &str = "chunk";

/// The file that is locked. It holds nothing.
const LOCK: &str = "lock";

/// How often a folder that goes away while it is being taken is made again.
const PATIENCE: u32 = 100;

/// The most bytes of a plan of a scene: the longest text, and four files that it names, quoted, where a quotation mark takes two, and a
/// little besides.
const fn most_bytes<S: Grid>() -> u64 {
    2 * (S::MOST_BYTES + 4 * S::MOST_FILE_BYTES) + (1 << 16)
}

/// What a process means to do in the folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Claim {
    /// Start afresh, alone.
    Fresh,
    /// Take up what is there, alone.
    Resume,
    /// Work beside other processes.
    Share,
}

/// A folder of chunks.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    /// The locked file; it is free again when the process ends, however that ends.
    lock: File,
}

impl Store {
    /// Makes the folder, or takes it up if it is that of `plan`.
    ///
    /// # Errors
    /// [`MapError::Request`]: the folder cannot be made, is that of another sweep, holds chunks and the claim is
    /// [`Claim::Fresh`], or another process has it. [`MapError::Computation`] if the plan cannot be written;
    /// [`MapError::Halted`] if `stop` is raised while another plan is read.
    pub fn open<S: Grid>(folder: &Path, plan: &Plan<S>, claim: Claim, stop: &Stop) -> Result<Self, MapError> {
        let place = folder.display();
        ensure!(
            claim == Claim::Share || !folder.is_symlink(),
            "{place} is a link, where a sweep makes a folder of chunks and removes it when it is done: name another --out"
        );
        if folder.exists() && !folder.is_dir() {
            refuse!("{place} is a file, where a folder of chunks would be: name another --out");
        }
        let new = !folder.exists();
        let store = Self::locked(folder, claim)?;
        let taken = store.take(plan, claim, stop);
        // Whoever else has come there in the meantime keeps it.
        if new && taken.is_err() && store.lock.try_lock().is_ok() {
            store.leave();
        }
        taken.map(|()| store)
    }

    /// Makes the folder, if it is not there, and locks it, if the file system can.
    fn locked(folder: &Path, claim: Claim) -> Result<Self, MapError> {
        let path = folder.join(LOCK);
        for _ in 0..PATIENCE {
            fs::create_dir_all(folder).map_err(|error| MapError::file("cannot make the folder", folder, &error))?;
            let lock = match open_lock(folder, &path) {
                // Whoever had the folder has just removed it.
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                opened => opened.map_err(|error| MapError::file("cannot write", &path, &error))?,
            };
            let locked = if claim == Claim::Share { lock.try_lock_shared() } else { lock.try_lock() };
            match locked {
                Err(TryLockError::WouldBlock) => return Err(at_work(folder, &path, &lock)),
                // Without locks two processes there only do the work twice.
                Ok(()) | Err(TryLockError::Error(_)) => {}
            }
            // A file that has been removed since it was opened is no lock: whoever comes next would lock another.
            if is_still_at(&lock, &path) {
                // Its time is there to be told to others, no more.
                let _ = lock.set_modified(SystemTime::now());
                return Ok(Self { folder: folder.to_owned(), lock });
            }
        }
        let place = folder.display();
        Err(MapError::Request(format!("{place} is made and removed by other processes all the time: stop them first")))
    }

    fn take<S: Grid>(&self, plan: &Plan<S>, claim: Claim, stop: &Stop) -> Result<(), MapError> {
        let place = self.folder.display();
        let entries = self.entries()?;
        if let Some((chunk, _)) = entries.iter().find(|(_, plain)| !plain) {
            let path = Self::path(&self.folder, *chunk);
            refuse!("{} is no plain file, where a chunk would be: name another --out", path.display());
        }
        let chunks = entries.len();
        ensure!(
            claim != Claim::Fresh || chunks == 0,
            "{place} holds {chunks} chunks of an unfinished sweep: go on with it by --resume, or name another --out to start afresh"
        );
        let path = self.folder.join(PLAN);
        let new = path.symlink_metadata().is_err_and(|error| error.kind() == io::ErrorKind::NotFound);
        let ours = plan.to_json();
        if new {
            let mut file = Output::beside(&path)?;
            io::Write::write_all(&mut file, ours.as_bytes()).map_err(|error| file.unwritten(&error))?;
            // Another process may have been faster; what counts is what is there now. Whoever is alone need not wait for the
            // disk before there is a chunk.
            if claim == Claim::Share {
                file.commit_new()?
            } else {
                file.place_new()?
            };
        }
        // To read a plan is to work out all modes of a structure: one that is ours to the letter need not be read.
        if Self::plan_text::<S>(&self.folder).is_ok_and(|there| there == ours) {
            return Ok(());
        }
        let folder = self.folder.clone();
        let there = aside(stop, move || Self::plan::<S>(&folder)).map_err(|Stopped| MapError::Halted(path.clone()))?;
        if !new && claim != Claim::Share && chunks == 0 {
            // Nobody's work: the plan of a sweep that got nowhere binds nobody, whether or not it can be read.
            match there {
                Ok(other) if plan.differences(&other).is_none() => return Ok(()),
                Err(error) if !is_of_mapgen(&path) => return Err(error),
                _ => return Output::beside(&path)?.finish_with(ours.as_bytes()),
            }
        }
        match plan.differences(&there?) {
            None => Ok(()),
            Some(told) => {
                let message = format!("{place} belongs to {told}; name another --out");
                Err(MapError::Request(message))
            }
        }
    }

    /// The plan in a folder of chunks.
    ///
    /// # Errors
    /// [`MapError::Request`] for a folder without one, or with another scene's.
    pub fn plan<S: Grid>(folder: &Path) -> Result<Plan<S>, MapError> {
        let path = folder.join(PLAN);
        Plan::from_json(&Self::plan_text::<S>(folder)?).map_err(|why| {
            let place = path.display();
            MapError::Request(format!("{place} cannot be used: {why}; name another --out to start afresh"))
        })
    }

    fn plan_text<S: Grid>(folder: &Path) -> Result<String, MapError> {
        let mut text = String::new();
        let read =
            open_plain(&folder.join(PLAN)).and_then(|file| file.take(most_bytes::<S>()).read_to_string(&mut text));
        read.map(|_| text).map_err(|error| {
            let message = format!("{} is no folder of chunks: cannot read {PLAN}: {error}", folder.display());
            MapError::Request(message)
        })
    }

    /// Whether the chunks in a folder are of a scene of this kind, as far as its plan can be read.
    ///
    /// # Errors
    /// [`MapError::Request`] for a folder without a plan.
    pub fn is_of<S: Grid>(folder: &Path) -> Result<bool, MapError> {
        Ok(Plan::<S>::is_one(&Self::plan_text::<S>(folder)?))
    }

    /// Sees to it that the disk has the plan, where the system can do so: before it has the first chunk. One that is lost
    /// all the same is made again.
    pub fn sync_plan(&self) {
        if let Ok(plan) = File::open(self.folder.join(PLAN)) {
            let _ = plan.sync_all();
        }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Where a chunk is, or will be.
    pub fn path(folder: &Path, chunk: u64) -> PathBuf {
        folder.join(file_name(chunk))
    }

    /// Whether such a folder keeps files of this name.
    pub fn owns(name: &OsStr) -> bool {
        name == PLAN || number(name).is_some()
    }

    /// Starts a chunk.
    pub fn writer<S: Grid>(&self, plan: &Plan<S>, chunk: u64) -> Result<Writer, MapError> {
        Writer::new(&Self::path(&self.folder, chunk), plan, chunk)
    }

    /// The chunks that there are files for, sound or not.
    ///
    /// # Errors
    /// [`MapError::Request`] if the folder cannot be read.
    pub fn present(&self) -> Result<BTreeSet<u64>, MapError> {
        Ok(self.entries()?.into_iter().filter_map(|(chunk, plain)| plain.then_some(chunk)).collect())
    }

    /// What is named like a chunk, and whether it is a file.
    fn entries(&self) -> Result<Vec<(u64, bool)>, MapError> {
        let unreadable = |error: io::Error| MapError::file("cannot read", &self.folder, &error);
        let mut entries = Vec::new();
        // One list for all: on the file systems of clusters each name takes a message.
        for entry in files::entries(&self.folder).map_err(unreadable)? {
            let entry = entry.map_err(unreadable)?;
            let Some(chunk) = number(entry.name()) else { continue };
            entries.push((chunk, entry.leads_to_file().map_err(unreadable)?));
        }
        Ok(entries)
    }

    /// Reads a chunk through and tells whether it can be trusted.
    pub fn check<S: Grid, C: Content<S>>(
        content: &C,
        folder: &Path,
        plan: &Plan<S>,
        chunk: u64,
        stop: &Stop,
    ) -> Result<Summary, Fault> {
        check(content, &Self::path(folder, chunk), plan, chunk, stop)
    }

    /// Removes what sweeps of `plan` have written there, also those that were killed, and the folder unless it holds anything
    /// else. Tells whether it does not.
    pub fn remove<S: Grid>(self, plan: &Plan<S>) -> bool {
        let ours = |name: &OsStr| name == PLAN || number(name).is_some_and(|chunk| chunk < plan.chunks());
        let mut others = false;
        for entry in files::entries(&self.folder).into_iter().flatten().flatten() {
            let name = entry.name();
            let removed = if ours(name) {
                fs::remove_file(entry.path()).is_ok()
            } else {
                name == LOCK || remove_if_abandoned(&entry, |destination| ours(OsStr::new(destination)))
            };
            others |= !removed;
        }
        self.leave();
        !others
    }

    /// Removes the lock and, if that was all, the folder. Whoever waits for it may be faster and have it at once.
    fn leave(&self) {
        let _ = fs::remove_file(self.folder.join(LOCK));
        let _ = fs::remove_dir(&self.folder);
    }
}

/// Opens the file to lock, and makes it if it is not there. Whoever may write in the folder may open it and nobody else: a
/// lock needs no more than that, and somebody who may only read could otherwise hold up a sweep for ever.
fn open_lock(folder: &Path, path: &Path) -> io::Result<File> {
    ensure!(!path.symlink_metadata().is_ok_and(|about| !about.is_file()), io::Error::other("it is no plain file"));
    let mut options = File::options();
    options.read(true).write(true).create(true).truncate(false);
    #[cfg(unix)]
    {
        use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
        let file = options.mode(0o600).open(path)?;
        let writers = folder.metadata()?.permissions().mode() & 0o222;
        // Another user's file keeps the permissions that it has.
        let _ = file.set_permissions(fs::Permissions::from_mode(0o600 | writers | writers << 1));
        Ok(file)
    }
    #[cfg(not(unix))]
    {
        let _ = folder;
        options.open(path)
    }
}

/// Whether a file that was opened still has its name.
fn is_still_at(file: &File, path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let place = |about: fs::Metadata| (about.dev(), about.ino());
        matches!((file.metadata().map(place), path.metadata().map(place)), (Ok(held), Ok(named)) if held == named)
    }
    #[cfg(not(unix))]
    {
        // Where a file that is open cannot be removed.
        let _ = file;
        path.exists()
    }
}

/// Tells that somebody else has the folder.
fn at_work(folder: &Path, path: &Path, lock: &File) -> MapError {
    let taken = lock.metadata().and_then(|about| about.modified()).ok().and_then(|time| time.elapsed().ok());
    let since = taken.map_or_else(String::new, |age| format!(", for {}", duration(age.as_secs_f64())));
    let (place, path) = (folder.display(), path.display());
    let message =
        format!("another mapgen is at work in {place} (it holds {path}{since}): wait for it, or stop it first");
    MapError::Request(message)
}

/// Whether a file that cannot be read as a plan was begun as one: what a crash of the system leaves of it may be empty.
fn is_of_mapgen(path: &Path) -> bool {
    let mut begun = Vec::new();
    let read = open_plain(path).and_then(|file| file.take(PLAN_BEGINS.len() as u64).read_to_end(&mut begun));
    read.is_ok() && PLAN_BEGINS.starts_with(&begun)
}

fn file_name(chunk: u64) -> String {
    format!("{chunk:06}.{CHUNK}")
}

/// The number of the chunk that has this name. What is called otherwise, a copy aside for one, is not ours.
fn number(name: &OsStr) -> Option<u64> {
    let name = name.to_str()?;
    let chunk = name.strip_suffix(CHUNK)?.strip_suffix('.')?.parse().ok()?;
    (file_name(chunk) == name).then_some(chunk)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::sweep::content::Cells;

    const TEXT: &str = "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
        x = { parameter = \"omega\", values = [0.5, 0.7, 1.1] }\ny = { parameter = \"gamma2\", values = [0.1] }\n\
        [compute]\nfamilies = [\"double-sided\"]\n";

    fn open(folder: &Path, plan: &Plan, claim: Claim) -> Result<Store, MapError> {
        Store::open(folder, plan, claim, &Stop::default())
    }

    #[test]
    fn chunks_of_another_version_are_refused_by_name() {
        let dir = tempfile::tempdir().unwrap();
        let (scene, folder) = (dir.path().join("scene.toml"), dir.path().join("parts"));
        fs::write(&scene, TEXT).unwrap();
        let here = Plan::<Scene>::read(&scene, None).unwrap();
        let there = Plan::<Scene>::by_version(&scene, TEXT, "0.0.9");
        drop(open(&folder, &there, Claim::Share).unwrap());
        fs::write(Store::path(&folder, 0), "").unwrap();
        for claim in [Claim::Resume, Claim::Share] {
            let error = open(&folder, &here, claim).unwrap_err();
            let told = error.to_string();
            assert!(
                told.contains("belongs to another version of mapgen: 0.0.9 (") && matches!(error, MapError::Request(_)),
                "{told}"
            );
            assert!(told.contains(&format!(") there, {} (", crate::manifest::VERSION)), "{told}");
        }
        // Chunks that are sound, but of that version: without their plan they are refused one by one.
        open(&folder, &there, Claim::Share).unwrap().writer(&there, 0).unwrap().finish().unwrap();
        assert!(matches!(Store::check(&Cells, &folder, &here, 0, &Stop::default()), Err(Fault::Foreign)));
    }

    #[test]
    fn a_folder_with_other_things_in_it_is_left() {
        let dir = tempfile::tempdir().unwrap();
        let (scene, folder) = (dir.path().join("scene.toml"), dir.path().join("parts"));
        fs::write(&scene, TEXT).unwrap();
        let plan = Plan::<Scene>::read(&scene, None).unwrap();
        fs::create_dir(&folder).unwrap();
        let others = [
            "+00001.chunk",
            ".000001.chunk.aB3d56.part",
            ".film.aB3d56.part",
            ".film.part",
            "0000001.chunk",
            "old.chunk",
        ];
        others.iter().for_each(|name| fs::write(folder.join(name), "mine").unwrap());
        let store = open(&folder, &plan, Claim::Fresh).unwrap();
        // This sweep has one chunk: there is no second.
        fs::write(Store::path(&folder, 1), "mine").unwrap();
        fs::write(Store::path(&folder, 0), "a chunk").unwrap();
        fs::write(folder.join(".000000.chunk.aB3d56.part"), "half a chunk").unwrap();
        assert_eq!(store.present().unwrap(), BTreeSet::from([0, 1]));
        assert!(!store.remove(&plan));
        let mut left: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        left.sort_unstable();
        assert_eq!(left, [&others[..5], &["000001.chunk", "old.chunk"]].concat());
        left.iter().for_each(|name| fs::remove_file(folder.join(name)).unwrap());
        assert!(open(&folder, &plan, Claim::Resume).unwrap().remove(&plan) && !folder.exists());
    }

    #[test]
    fn a_plan_that_is_not_ours_is_left_and_what_a_crash_leaves_of_ours_is_not() {
        let dir = tempfile::tempdir().unwrap();
        let (scene, folder) = (dir.path().join("scene.toml"), dir.path().join("parts"));
        fs::write(&scene, TEXT).unwrap();
        let plan = Plan::<Scene>::read(&scene, None).unwrap();
        fs::create_dir(&folder).unwrap();
        let whole = plan.to_json();
        for (text, is_ours) in [
            ("", true),
            (&whole[..9], true),
            (&whole[..200], true),
            (&whole[..], true),
            ("{}", false),
            ("a plan", false),
        ] {
            fs::write(folder.join(PLAN), text).unwrap();
            for claim in [Claim::Fresh, Claim::Resume] {
                assert_eq!(open(&folder, &plan, claim).is_ok(), is_ours, "{text}");
            }
            let expected = if is_ours { &whole[..] } else { text };
            assert_eq!(fs::read_to_string(folder.join(PLAN)).unwrap(), expected);
        }
    }

    #[test]
    fn a_lock_that_was_removed_is_none() {
        let dir = tempfile::tempdir().unwrap();
        let (scene, folder) = (dir.path().join("scene.toml"), dir.path().join("parts"));
        fs::write(&scene, TEXT).unwrap();
        let plan = Plan::<Scene>::read(&scene, None).unwrap();
        let first = open(&folder, &plan, Claim::Fresh).unwrap();
        let told = open(&folder, &plan, Claim::Share).unwrap_err().to_string();
        assert!(told.contains("another mapgen is at work in ") && told.contains("parts/lock, for 0."), "{told}");
        fs::remove_file(folder.join(LOCK)).unwrap();
        assert!(!is_still_at(&first.lock, &folder.join(LOCK)));
        // Two shares get along, and keep a whole sweep out.
        drop(first);
        let shares = [(); 2].map(|()| open(&folder, &plan, Claim::Share).unwrap());
        assert!(open(&folder, &plan, Claim::Resume).is_err());
        drop(shares);
        assert!(open(&folder, &plan, Claim::Resume).unwrap().remove(&plan) && !folder.exists());
    }
}

//! Files that appear whole or not at all: written beside their destination under a temporary name, flushed to disk,
//! renamed. What is no plain file is written to as it is.

use std::ffi::OsStr;
use std::fs::{self, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use tempfile::NamedTempFile;

use super::destination::{Destination, promises};
use super::folder::{Entry, entries};
use super::stream::{Halted, Stream};
use crate::error::MapError;

/// How names of temporary files end.
const TEMPORARY: &str = ".part";

/// Letters between the name of the destination and that end, drawn at random.
const RANDOM: usize = 6;

/// From which age on a temporary file is nobody's any more where the file system has no locks to tell it by.
const ABANDONED: Duration = Duration::from_secs(24 * 3600);

/// Bytes handed to the system at a time. In whole pieces of this size, at multiples of it, a file costs half the time that it
/// costs in pieces of a few pages: the system caches and flushes it in larger units.
const PIECE: usize = 1 << 17;

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Sees to it that the disk knows the names in the folder of `path`, where the system can do so.
pub fn sync_folder(path: &Path) {
    if let Ok(folder) = fs::File::open(folder_of(path)) {
        let _ = folder.sync_all();
    }
}

/// Where the bytes of an output go.
#[derive(Debug)]
enum Sink {
    /// A temporary file, to be put in its place.
    Temporary {
        file: NamedTempFile,
        place: PathBuf,
        /// Whether anything but a plain file in that place is somebody else's.
        careful: bool,
    },
    Stream(Stream),
}

/// A file under way. Dropped before [`Output::commit`], it leaves nothing behind but what a pipe or a device has got already.
#[derive(Debug)]
pub struct Output {
    sink: Sink,
    /// What the system has not got yet, less than a piece.
    held: Vec<u8>,
    /// As it was named.
    path: PathBuf,
}

impl Output {
    /// Opens the temporary file, so that an impossible destination is known before the work starts. Missing folders are
    /// made, links followed. `-`, pipes and devices are opened with the first byte.
    ///
    /// # Errors
    /// [`MapError::Request`] if the destination cannot be written.
    pub fn create(path: &Path) -> Result<Self, MapError> {
        let cannot = |error: io::Error| MapError::file("cannot write", path, &error);
        let sink = match Destination::of(path)? {
            Destination::Plain(place) => {
                fs::create_dir_all(folder_of(&place)).map_err(cannot)?;
                remove_abandoned(&place);
                return Self::temporary(path, place, true);
            }
            Destination::StandardOutput => Stream::to_standard_output().map_err(cannot)?,
            Destination::Direct(path) => Stream::to(&path).map_err(cannot)?,
        };
        Ok(Self { sink: Sink::Stream(sink), held: Vec::new(), path: path.to_owned() })
    }

    /// As [`Output::create`], for a document in Markdown.
    ///
    /// # Errors
    /// As [`Output::create`]; also for a name that promises something else.
    pub fn document(flag: &str, path: &Path) -> Result<Self, MapError> {
        promises(flag, path, "a document in Markdown", &["md", "markdown", "txt"])?;
        Self::create(path)
    }

    /// As [`Output::create`], in a folder that must be there, and in the place of whatever has this very name.
    ///
    /// # Errors
    /// As [`Output::create`].
    pub fn beside(path: &Path) -> Result<Self, MapError> {
        Self::temporary(path, path.to_owned(), false)
    }

    fn temporary(path: &Path, place: PathBuf, careful: bool) -> Result<Self, MapError> {
        let mut builder = tempfile::Builder::new();
        let prefix = format!(".{}.", place.file_name().unwrap_or_default().to_string_lossy());
        builder.prefix(&prefix).suffix(TEMPORARY).rand_bytes(RANDOM);
        // Temporary files are private by default; results are shared like any file, within the umask.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        loop {
            let file = builder.tempfile_in(folder_of(&place));
            let file = file.map_err(|error| MapError::file("cannot write", path, &error))?;
            if is_kept(&file).map_err(|error| MapError::file("cannot write", path, &error))? {
                return Ok(Self {
                    sink: Sink::Temporary { file, place, careful },
                    held: Vec::new(),
                    path: path.to_owned(),
                });
            }
        }
    }

    /// The error of a write that failed.
    pub fn unwritten(&self, error: &io::Error) -> MapError {
        self.failed("write", error)
    }

    /// What a failure means here: who reads standard output may have seen enough, and who waits for a reader may be told to
    /// stop.
    fn failed(&self, what: &str, error: &io::Error) -> MapError {
        let standard_output = matches!(&self.sink, Sink::Stream(stream) if stream.is_standard_output());
        match error.kind() {
            io::ErrorKind::BrokenPipe if standard_output => MapError::Unread,
            _ if error.get_ref().is_some_and(|inner| inner.is::<Halted>()) => MapError::Halted(self.path.clone()),
            _ if standard_output => MapError::Computation(format!("could not {what} to standard output: {error}")),
            _ => MapError::Computation(format!("could not {what} {}: {error}", self.path.display())),
        }
    }

    /// As [`Output::unwritten`], of a table's row.
    pub fn without_row(&self, error: csv::Error) -> MapError {
        match error.into_kind() {
            csv::ErrorKind::Io(error) => self.unwritten(&error),
            other => MapError::Computation(format!("could not write {}: {other:?}", self.path.display())),
        }
    }

    /// The destination, as it was named.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Flushes to disk and puts the file in its place.
    ///
    /// # Errors
    /// [`MapError::Computation`] if the disk refuses; the destination is then as it was before.
    pub fn commit(mut self) -> Result<(), MapError> {
        match self.sync() {
            // All has been done for a reader who does not want the rest.
            Err(MapError::Unread) => return Ok(()),
            synced => synced?,
        }
        let Self { sink: Sink::Temporary { file, place, careful }, path, .. } = self else { return Ok(()) };
        // It may have become something else since.
        if careful && fs::symlink_metadata(&place).is_ok_and(|found| !found.is_file()) {
            let message = format!("could not finish {}: it is no plain file any more", path.display());
            return Err(MapError::Computation(message));
        }
        file.persist(&place).map(|_| ()).map_err(|error| unfinished(&path, &error.error))
    }

    /// As [`Output::commit`], but leaves a file that is already there as it is, and tells so by `false`.
    ///
    /// # Errors
    /// As [`Output::commit`].
    pub fn commit_new(mut self) -> Result<bool, MapError> {
        self.sync()?;
        self.place_new()
    }

    /// As [`Output::commit_new`], but does not wait for the disk: for a file that can be made again.
    pub fn place_new(mut self) -> Result<bool, MapError> {
        self.branch_off().map_err(|error| self.failed("finish", &error))?;
        let Self { sink: Sink::Temporary { file, place, .. }, path, .. } = self else { return Ok(true) };
        match file.persist_noclobber(&place) {
            Ok(_) => Ok(true),
            Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => Ok(false),
            Err(error) => Err(unfinished(&path, &error.error)),
        }
    }

    /// Flushes to disk all that was written; [`Output::commit`] has then nothing left to wait for.
    ///
    /// # Errors
    /// [`MapError::Computation`] if the disk refuses.
    pub fn sync(&mut self) -> Result<(), MapError> {
        let synced = self.branch_off().and_then(|()| match &mut self.sink {
            Sink::Temporary { file, .. } => file.as_file().sync_all(),
            // Also without a byte: a reader waits for the end.
            Sink::Stream(stream) => stream.flush(),
        });
        synced.map_err(|error| self.failed("finish", &error))
    }

    /// Hands to the system what is held.
    fn branch_off(&mut self) -> io::Result<()> {
        while !self.held.is_empty() {
            let written = match &mut self.sink {
                Sink::Temporary { file, .. } => file.write(&self.held),
                Sink::Stream(stream) => stream.write(&self.held),
            };
            match written {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                // After a failure the rest is still to be written, and no byte of it twice.
                Ok(count) => drop(self.held.drain(..count)),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Writes all of it and commits.
    ///
    /// # Errors
    /// As [`Output::commit`].
    pub fn finish_with(mut self, content: &[u8]) -> Result<(), MapError> {
        match self.write_all(content).map_err(|error| self.unwritten(&error)) {
            // As where it is committed.
            Err(MapError::Unread) => Ok(()),
            written => written.and_then(|()| self.commit()),
        }
    }
}

impl Write for Output {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        if self.held.len() >= PIECE {
            self.branch_off()?;
        }
        let (taken, _) = buffer.split_at(buffer.len().min(PIECE - self.held.len()));
        self.held.extend_from_slice(taken);
        Ok(taken.len())
    }

    /// After a failure all of `buffer` is held, so that who can make room may flush once more.
    fn write_all(&mut self, mut buffer: &[u8]) -> io::Result<()> {
        while !buffer.is_empty() {
            match self.write(buffer) {
                Ok(count) => buffer = buffer.split_at(count).1,
                Err(error) => {
                    self.held.extend_from_slice(buffer);
                    return Err(error);
                }
            }
        }
        Ok(())
    }

    /// A stream keeps its piece: who drops a writer flushes it, and that alone must not wait for a reader.
    fn flush(&mut self) -> io::Result<()> {
        match self.sink {
            Sink::Temporary { .. } => self.branch_off(),
            Sink::Stream(_) => Ok(()),
        }
    }
}

fn unfinished(path: &Path, error: &io::Error) -> MapError {
    MapError::Computation(format!("could not finish {}: {error}", path.display()))
}

/// Locks a temporary file, as a sign that somebody is writing it, for as long as it is open. Tells whether it is still there:
/// who removes abandoned files may have met it in between.
///
/// # Errors
/// Whatever else than that it is gone keeps it from being told: another one would fare no better.
fn is_kept(file: &NamedTempFile) -> io::Result<bool> {
    match file.as_file().try_lock() {
        Ok(()) => file.path().try_exists(),
        Err(TryLockError::WouldBlock) => Ok(false),
        // A file system without locks.
        Err(TryLockError::Error(_)) => Ok(true),
    }
}

/// The name of the file that a temporary one of this name was to become.
fn destination(name: &str) -> Option<&str> {
    let (destination, random) = name.strip_prefix('.')?.strip_suffix(TEMPORARY)?.rsplit_once('.')?;
    let drawn = random.len() == RANDOM && random.bytes().all(|byte| byte.is_ascii_alphanumeric());
    drawn.then_some(destination)
}

/// Whether the process that wrote a temporary file has ended without a word.
fn is_abandoned(entry: &Entry) -> bool {
    // No link, FIFO or folder of such a name is ours.
    if !entry.is_file().unwrap_or(false) {
        return false;
    }
    let Ok(file) = fs::File::options().write(true).open(entry.path()) else { return false };
    match file.try_lock() {
        Ok(()) => true,
        Err(TryLockError::WouldBlock) => false,
        Err(TryLockError::Error(_)) => {
            let age = file.metadata().and_then(|about| about.modified()).ok().and_then(|time| time.elapsed().ok());
            age.is_some_and(|age| age > ABANDONED)
        }
    }
}

/// Removes a temporary file, if it is one, and nobody writes it any more, and `is_ours` knows its destination. Tells whether
/// it did.
pub fn remove_if_abandoned(entry: &Entry, is_ours: impl Fn(&str) -> bool) -> bool {
    destination(&entry.name().to_string_lossy()).is_some_and(is_ours)
        && is_abandoned(entry)
        && fs::remove_file(entry.path()).is_ok()
}

/// Removes the temporary files of a destination that killed processes have left. What cannot be removed does no harm.
fn remove_abandoned(path: &Path) {
    let Some(name) = path.file_name().map(OsStr::to_string_lossy) else { return };
    let Ok(entries) = entries(folder_of(path)) else { return };
    for entry in entries.flatten() {
        remove_if_abandoned(&entry, |destination| destination == name);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_arrive_in_order_whatever_the_pieces() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pieces");
        let text: Vec<u8> = (0..3 * PIECE + 5).map(|i| (i % 251) as u8).collect();
        for size in [7, 1000, 80_000, PIECE - 1, PIECE, PIECE + 1, 2 * PIECE + 3, text.len()] {
            let mut output = Output::create(&path).unwrap();
            for (i, piece) in text.chunks(size).enumerate() {
                output.write_all(piece).unwrap();
                assert!(output.held.len() <= PIECE);
                if i % 5 == 4 {
                    output.flush().unwrap();
                }
            }
            output.commit().unwrap();
            assert!(fs::read(&path).unwrap() == text, "{size}");
        }
    }

    /// Hours may pass between the two.
    #[cfg(unix)]
    #[test]
    fn what_has_become_no_plain_file_since_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let (path, other) = (folder.path().join("map.csv"), folder.path().join("other"));
        fs::write(&other, "other").unwrap();
        let output = Output::create(&path).unwrap();
        std::os::unix::fs::symlink(&other, &path).unwrap();
        let told = output.finish_with(b"table").unwrap_err().to_string();
        assert!(told.ends_with("map.csv: it is no plain file any more"), "{told}");
        assert!(path.is_symlink() && fs::read(&other).unwrap() == b"other");
        // A chunk's place is the program's own.
        Output::beside(&path).unwrap().finish_with(b"chunk").unwrap();
        assert!(!path.is_symlink() && fs::read(&path).unwrap() == b"chunk" && fs::read(&other).unwrap() == b"other");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[test]
    fn what_the_dead_have_left_is_removed_and_nothing_that_anybody_writes_or_owns() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.csv");
        let names = || -> Vec<String> {
            let entries = fs::read_dir(folder.path()).unwrap();
            let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
            names.sort();
            names
        };
        // Another destination's, and what is only named a little like one.
        let others =
            [".map.csv.aB3d5.part", ".map.csv.aB3d567.part", ".map.csv.aB-d56.part", ".map.csv.gz.aB3d56.part"];
        others.iter().for_each(|name| fs::write(folder.path().join(name), "").unwrap());
        fs::create_dir(folder.path().join(".map.csv.folder.part")).unwrap();
        let expected = names();
        fs::write(folder.path().join(".map.csv.aB3d56.part"), "half").unwrap();
        let mut first = Output::create(&path).unwrap();
        assert_eq!(names().len(), expected.len() + 1);
        first.write_all(b"first").unwrap();
        // A second writer does the first no harm.
        Output::create(&path).unwrap().finish_with(b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        first.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"first");
        assert_eq!(names(), [expected, vec!["map.csv".to_owned()]].concat());
    }

    #[test]
    fn nothing_is_left_of_a_dropped_file_and_all_of_a_committed_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/map.csv");
        let mut output = Output::create(&path).unwrap();
        output.write_all(b"half").unwrap();
        drop(output);
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 0);
        Output::create(&path).unwrap().finish_with(b"whole").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        assert!(Output::create(folder.path()).is_err());
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = fs::metadata(&path).unwrap().permissions().mode();
            let plain = folder.path().join("plain");
            fs::write(&plain, b"").unwrap();
            assert_eq!(mode, fs::metadata(&plain).unwrap().permissions().mode());
        }
    }
}

//! What is in a folder. The standard library panics where a folder cannot be closed (a stale mount, an overloaded one); here all that a
//! file system refuses is an error or, where nothing is lost by it, no more than that.

use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};

/// What has a name in a folder.
#[derive(Debug)]
pub struct Entry {
    path: PathBuf,
    /// Whether it is a plain file itself, and whether it is a link; not known of every file system without asking once more.
    kind: Option<(bool, bool)>,
}

impl Entry {
    /// With the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Without it.
    pub fn name(&self) -> &OsStr {
        self.path.file_name().unwrap_or_default()
    }

    /// Whether it is a plain file, and no link to one.
    ///
    /// # Errors
    /// If nothing can be told of it.
    pub fn is_file(&self) -> io::Result<bool> {
        Ok(self.kind()?.0)
    }

    /// Whether it is a plain file or leads to one.
    ///
    /// # Errors
    /// If nothing can be told of it.
    pub fn leads_to_file(&self) -> io::Result<bool> {
        let (file, link) = self.kind()?;
        Ok(file || link && self.path.is_file())
    }

    fn kind(&self) -> io::Result<(bool, bool)> {
        let ask = || {
            let about = self.path.symlink_metadata()?;
            Ok((about.is_file(), about.is_symlink()))
        };
        self.kind.map_or_else(ask, Ok)
    }
}

/// All that is in a folder, in no order.
///
/// # Errors
/// If it cannot be opened; and of each name, if it cannot be read on.
#[cfg(unix)]
pub fn entries(folder: &Path) -> io::Result<impl Iterator<Item = io::Result<Entry>> + use<'_>> {
    use std::os::fd::OwnedFd;
    use std::os::unix::ffi::OsStrExt;

    use rustix::fs::{Dir, FileType};

    let entries = Dir::new(OwnedFd::from(std::fs::File::open(folder)?))?;
    let of = move |entry: rustix::io::Result<rustix::fs::DirEntry>| -> io::Result<Option<Entry>> {
        let entry = entry?;
        let name = entry.file_name().to_bytes();
        // The folder itself, and the one above it.
        if matches!(name, b"." | b"..") {
            return Ok(None);
        }
        let kind = match entry.file_type() {
            FileType::Unknown => None,
            kind => Some((kind.is_file(), kind.is_symlink())),
        };
        Ok(Some(Entry { path: folder.join(OsStr::from_bytes(name)), kind }))
    };
    Ok(entries.filter_map(move |entry| of(entry).transpose()))
}

/// The same from the standard library.
#[cfg(not(unix))]
pub fn entries(folder: &Path) -> io::Result<impl Iterator<Item = io::Result<Entry>> + use<>> {
    let of = |entry: io::Result<std::fs::DirEntry>| {
        let entry = entry?;
        let kind = entry.file_type().ok().map(|kind| (kind.is_file(), kind.is_symlink()));
        Ok(Entry { path: entry.path(), kind })
    };
    Ok(std::fs::read_dir(folder)?.map(of))
}

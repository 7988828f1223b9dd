//! Files that appear whole or not at all: written beside their destination under a temporary name, flushed to disk,
//! renamed.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::CliError;

/// A file under way. Dropped before [`Output::commit`], it leaves nothing behind.
#[derive(Debug)]
pub struct Output {
    writer: BufWriter<NamedTempFile>,
    path: PathBuf,
}

impl Output {
    /// Opens the temporary file, so that an impossible destination is known before the work starts. Missing folders are
    /// made.
    ///
    /// # Errors
    /// [`CliError::Request`] if the destination cannot be written.
    pub fn create(path: &Path) -> Result<Self, CliError> {
        let cannot = |error: &io::Error| CliError::file("cannot write", path, error);
        let Some(name) = path.file_name() else {
            return Err(CliError::Request(format!("cannot write {}: it names no file", path.display())));
        };
        if path.is_dir() {
            return Err(CliError::Request(format!("cannot write {}: it is a folder; name a file", path.display())));
        }
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        fs::create_dir_all(folder).map_err(|error| cannot(&error))?;
        let mut builder = tempfile::Builder::new();
        let prefix = format!(".{}.", name.to_string_lossy());
        builder.prefix(&prefix).suffix(".part");
        // Temporary files are private by default; results are shared like any file, within the umask.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let file = builder.tempfile_in(folder).map_err(|error| cannot(&error))?;
        Ok(Self { writer: BufWriter::new(file), path: path.to_owned() })
    }

    /// The destination.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Flushes to disk and puts the file in its place.
    ///
    /// # Errors
    /// [`CliError::Computation`] if the disk refuses; the destination is then as it was before.
    pub fn commit(self) -> Result<(), CliError> {
        let failed = |error: &dyn std::fmt::Display| {
            CliError::Computation(format!("could not finish {}: {error}", self.path.display()))
        };
        let file = self.writer.into_inner().map_err(|error| failed(error.error()))?;
        file.as_file().sync_all().map_err(|error| failed(&error))?;
        file.persist(&self.path).map_err(|error| failed(&error.error))?;
        Ok(())
    }

    /// Writes all of it and commits.
    ///
    /// # Errors
    /// As [`Output::commit`].
    pub fn finish_with(mut self, content: &[u8]) -> Result<(), CliError> {
        let written = self.write_all(content);
        written.map_err(|error| CliError::Computation(format!("could not write {}: {error}", self.path.display())))?;
        self.commit()
    }
}

impl Write for Output {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        self.writer.write(buffer)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

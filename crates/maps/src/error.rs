//! Why there is no map, or no file.

use std::path::{Path, PathBuf};

use thiserror::Error;

/// A failure of a scene, a sweep or a file.
#[derive(Debug, Error)]
pub enum MapError {
    /// The request is wrong: a scene, a name, a range.
    #[error("{0}")]
    Request(String),
    /// It could not be completed.
    #[error("{0}")]
    Computation(String),
    /// The stop flag was raised while nobody was reading a pipe.
    #[error("interrupted: {} was not read", .0.display())]
    Halted(PathBuf),
    /// Whoever read standard output has seen enough (`| head`), which is no failure.
    #[error("standard output is not read any more")]
    Unread,
}

impl MapError {
    /// A file that cannot be used as asked.
    #[must_use]
    pub fn file(what: &str, path: &Path, error: &std::io::Error) -> Self {
        Self::Request(format!("{what} {}: {error}", path.display()))
    }
}

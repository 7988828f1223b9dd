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
    /// The stop flag was raised while nobody was reading a pipe, or before a plan was read.
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

/// A message alone is about a request: so [`ensure!`](crate::ensure) and [`refuse!`](crate::refuse) have it.
impl From<String> for MapError {
    fn from(message: String) -> Self {
        Self::Request(message)
    }
}

/// Returns a message as the error of its function, as `format!` words it.
#[macro_export]
macro_rules! refuse {
    ($($words:tt)+) => {
        return Err(format!($($words)+).into())
    };
}

/// Returns the error, or a message as [`refuse!`](crate::refuse) does, unless a condition holds.
#[macro_export]
macro_rules! ensure {
    ($holds:expr, $error:literal $($words:tt)*) => {
        let holds: bool = $holds;
        if !holds {
            $crate::refuse!($error $($words)*)
        }
    };
    ($holds:expr, $error:expr) => {
        let holds: bool = $holds;
        if !holds {
            return Err($error);
        }
    };
}

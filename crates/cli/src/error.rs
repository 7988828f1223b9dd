//! What ends a run early, and with which exit code.

use std::path::{Path, PathBuf};

use thiserror::Error;
use vibrochain_lattice::ParameterError;

/// A failed run.
#[derive(Debug, Error)]
pub enum CliError {
    /// The command line is wrong, exit code 2; or it asks for help or the version, exit code 0.
    #[error("{0}")]
    Usage(#[from] clap::Error),
    /// The request is wrong; exit code 2.
    #[error("{0}")]
    Request(String),
    /// The computation could not be completed; exit code 1.
    #[error("{0}")]
    Computation(String),
    /// Stopped by Ctrl-C or SIGTERM; exit code 130.
    #[error("interrupted: nothing was written")]
    Interrupted,
    /// The same, with what was done until then on disk.
    #[error("interrupted: the files hold the run up to here")]
    Stopped,
    /// The same, with what is finished, and how to go on.
    #[error("interrupted: {0}")]
    Paused(String),
    /// The same, while nobody was reading a pipe.
    #[error("interrupted: {} was not read", .0.display())]
    Halted(PathBuf),
    /// Whoever read standard output has seen enough (`| head`), which is no failure.
    #[error("standard output is not read any more")]
    Unread,
}

impl CliError {
    /// 0 done, 1 the computation could not be completed, 2 the request is wrong; 130 interrupted, as shells have it.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(error) => u8::try_from(error.exit_code()).unwrap_or(2),
            Self::Request(_) => 2,
            Self::Computation(_) => 1,
            Self::Interrupted | Self::Stopped | Self::Paused(_) | Self::Halted(_) => 130,
            Self::Unread => 0,
        }
    }

    /// A file that cannot be used as asked.
    pub fn file(what: &str, path: &Path, error: &std::io::Error) -> Self {
        Self::Request(format!("{what} {}: {error}", path.display()))
    }
}

impl From<ParameterError> for CliError {
    fn from(error: ParameterError) -> Self {
        Self::Request(error.to_string())
    }
}

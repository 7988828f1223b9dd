//! What ends a run early, and with which exit code.

use std::path::{Path, PathBuf};

use thiserror::Error;
use vibrochain_breather::{BranchError, BreatherError};
use vibrochain_floquet::{CurveError, FloquetError, LocateError};
use vibrochain_lattice::{ParameterError, Resonance, StructureError};
use vibrochain_maps::error::MapError;

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
    /// The point has no answer: on a resonance no periodic motion is defined, at a grazing impact no stability; exit code 3.
    #[error("{0}")]
    IllPosed(String),
    /// Stopped by Ctrl-C or SIGTERM; exit code 130.
    #[error("interrupted: nothing was written")]
    Interrupted,
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
    /// 0 done, 1 the computation could not be completed, 2 the request is wrong, 3 the point has no answer; 130 interrupted,
    /// as shells have it.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(error) => u8::try_from(error.exit_code()).unwrap_or(2),
            Self::Request(_) => 2,
            Self::Computation(_) => 1,
            Self::IllPosed(_) => 3,
            Self::Interrupted | Self::Paused(_) | Self::Halted(_) => 130,
            Self::Unread => 0,
        }
    }

    /// A file that cannot be used as asked.
    pub fn file(what: &str, path: &Path, error: &std::io::Error) -> Self {
        Self::Request(format!("{what} {}: {error}", path.display()))
    }

    /// A failure of the mathematics with what it was about in front.
    pub fn about(self, what: impl std::fmt::Display) -> Self {
        match self {
            Self::Computation(message) => Self::Computation(format!("{what}: {message}")),
            Self::IllPosed(message) => Self::IllPosed(format!("{what}: {message}")),
            other => other,
        }
    }
}

/// A message alone is about a request.
impl From<String> for CliError {
    fn from(message: String) -> Self {
        Self::Request(message)
    }
}

impl From<MapError> for CliError {
    fn from(error: MapError) -> Self {
        match error {
            MapError::Request(message) => Self::Request(message),
            MapError::Computation(message) => Self::Computation(message),
            MapError::Halted(path) => Self::Halted(path),
            MapError::Unread => Self::Unread,
        }
    }
}

impl From<ParameterError> for CliError {
    fn from(error: ParameterError) -> Self {
        Self::Request(error.to_string())
    }
}

impl From<Resonance> for CliError {
    fn from(error: Resonance) -> Self {
        Self::IllPosed(error.to_string())
    }
}

impl From<BreatherError> for CliError {
    fn from(error: BreatherError) -> Self {
        match error {
            BreatherError::Stopped(_) => Self::Interrupted,
            BreatherError::Resonance(_)
            | BreatherError::Structure(StructureError::Resonance { .. })
            | BreatherError::LossWithoutLoad
            | BreatherError::Unfelt
            | BreatherError::Singular
            | BreatherError::Unbalanced => Self::IllPosed(error.to_string()),
            BreatherError::TooStiff { .. }
            | BreatherError::LongFlight { .. }
            | BreatherError::Impact { .. }
            | BreatherError::NotConverged { .. }
            | BreatherError::OutOfOrder { found: true }
            | BreatherError::OtherUnknowns
            | BreatherError::Undecided { .. }
            | BreatherError::Structure(StructureError::NotConverged) => Self::Computation(error.to_string()),
            _ => Self::Request(error.to_string()),
        }
    }
}

impl From<FloquetError> for CliError {
    fn from(error: FloquetError) -> Self {
        match error {
            FloquetError::Breather(breather) => breather.into(),
            FloquetError::Grazing { .. } => Self::IllPosed(error.to_string()),
            FloquetError::NotConverged { .. }
            | FloquetError::Uncounted(_)
            | FloquetError::TooManyModes { .. }
            | FloquetError::TooLarge { .. } => Self::Computation(error.to_string()),
        }
    }
}

impl From<CurveError> for CliError {
    fn from(error: CurveError) -> Self {
        match error {
            CurveError::Outside { .. }
            | CurveError::Same(_)
            | CurveError::NoLoad(_)
            | CurveError::Numbers(_)
            | CurveError::Tolerance(_) => Self::Request(error.to_string()),
            CurveError::Branch(BranchError::Breather(breather)) => breather.into(),
            CurveError::NotThere(_) | CurveError::Branch(_) => Self::Computation(error.to_string()),
        }
    }
}

impl From<LocateError> for CliError {
    fn from(error: LocateError) -> Self {
        match error {
            LocateError::Range { .. } | LocateError::Short { .. } | LocateError::NoForce { .. } => {
                Self::Request(error.to_string())
            }
            LocateError::Floquet(floquet) => floquet.into(),
            LocateError::Branch(BranchError::Breather(breather)) => breather.into(),
            LocateError::Stopped => Self::Interrupted,
            LocateError::Branch(_) | LocateError::NoMultiplier => Self::Computation(error.to_string()),
        }
    }
}

//! The whole program as a function.

use std::ffi::OsString;

use vibrochain_cli::args::read;
use vibrochain_cli::common::console::Console;
use vibrochain_cli::common::error::CliError;

use crate::args::{Cli, Command};
use crate::{accuracy, errata, figures, loops, stripes, validate};

/// Runs `studies` with `arguments`, the first of which is its own name.
///
/// # Errors
/// [`CliError`]; its [`exit_code`](CliError::exit_code) is the program's.
pub fn run(arguments: impl IntoIterator<Item = OsString>, console: &mut Console<'_>) -> Result<(), CliError> {
    match &read::<Cli>(arguments)?.command {
        Command::Validate(args) => validate::run(args, console),
        Command::Figures(args) => figures::run(args, console),
        Command::Errata(args) => errata::run(args, console),
        Command::Accuracy(args) => accuracy::run(args, console),
        Command::Stripes(args) => stripes::run(args, console),
        Command::Lines(args) => stripes::run_lines(args, console),
        Command::Loop(args) => loops::run(args, console),
    }
}

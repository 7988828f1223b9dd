//! The whole program as a function: arguments in, an answer or the reason why there is none out.

use std::ffi::OsString;

use crate::args::{Cli, Command, STUDIES, read};
use crate::console::Console;
use crate::error::CliError;
use crate::{
    branch_command, curve_command, curves_command, locate_command, merge_command, orbit_command, simulate_command,
    sweep_command, words_command,
};

/// Runs `mapgen` with `arguments`, the first of which is its own name.
///
/// # Errors
/// [`CliError`]; its [`exit_code`](CliError::exit_code) is the program's. A request for help or the version comes back as
/// [`CliError::Usage`] with exit code 0, too: clap prints both.
///
/// ```
/// use vibrochain_cli::console::{Console, ctrl_c};
/// let (mut out, mut err) = (Vec::new(), Vec::new());
/// let mut console = Console { out: &mut out, err: &mut err, progress: false, interrupt: &ctrl_c };
/// let flags = "--sites 21 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4";
/// let line = format!("mapgen orbit --family double-sided {flags}");
/// vibrochain_cli::program::run(line.split(' ').map(Into::into), &mut console)?;
/// assert!(String::from_utf8_lossy(&out).contains("1 solution, 1 physical"));
/// # Ok::<(), vibrochain_cli::error::CliError>(())
/// ```
pub fn run(arguments: impl IntoIterator<Item = OsString>, console: &mut Console<'_>) -> Result<(), CliError> {
    match &read::<Cli>(arguments)?.command {
        Command::Sweep(args) => sweep_command::run(args, console),
        Command::Merge(args) => merge_command::run(args, console),
        Command::Orbit(args) => orbit_command::run(args, console),
        Command::Words(args) => words_command::run(args, console),
        Command::Locate(args) => locate_command::run(args, console),
        Command::Branch(args) => branch_command::run(args, console),
        Command::Curve(args) => curve_command::run(args, console),
        Command::Curves(args) => curves_command::run(args, console),
        Command::Simulate(args) => simulate_command::run(args, console),
        #[cfg(feature = "plot")]
        Command::Stripes(args) => crate::stripes::run(args, console),
        #[cfg(not(feature = "plot"))]
        Command::Stripes(_) => {
            Err(CliError::Request("this build draws nothing: build with the feature `plot`".to_owned()))
        }
        Command::Study(_) => Err(CliError::Request(format!(
            "{} are studies, a program of their own: cargo run --release -p vibrochain-studies -- --help",
            STUDIES.join(", ")
        ))),
    }
}

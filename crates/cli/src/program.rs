//! The whole program as a function: arguments in, an answer or the reason why there is none out.

use std::ffi::OsString;
use std::time::Instant;

use clap::error::ErrorKind;

use crate::args::{Cli, Command, read};
use crate::common::console::Console;
use crate::common::error::CliError;
use crate::common::threads::{cores, number};
use crate::common::version::about;
use crate::{branch, curve, curves, fate, locate, orbit, schema, setup, simulate, sweep, sweep::merge, words};

/// Runs `mapgen` with `arguments`, the first of which is its own name.
///
/// # Errors
/// [`CliError`]; its [`exit_code`](CliError::exit_code) is the program's. A request for help or the version comes back as
/// [`CliError::Usage`] with exit code 0, too: clap prints both.
///
/// ```
/// use vibrochain_cli::common::console::{Console, ctrl_c};
/// let (mut out, mut err) = (Vec::new(), Vec::new());
/// let mut console = Console::new(&mut out, &mut err, &ctrl_c);
/// let flags = "--sites 21 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4";
/// let line = format!("mapgen orbit --family double-sided {flags}");
/// vibrochain_cli::program::run(line.split(' ').map(Into::into), &mut console)?;
/// assert!(String::from_utf8_lossy(&out).contains("1 solution, 1 physical"));
/// # Ok::<(), vibrochain_cli::common::error::CliError>(())
/// ```
pub fn run(arguments: impl IntoIterator<Item = OsString>, console: &mut Console<'_>) -> Result<(), CliError> {
    #[cfg(feature = "explore")]
    crate::explore::end_with_explorer();
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let verbose = arguments.iter().any(|argument| argument == "--verbose" || argument == "-v");
    let cli = match read::<Cli>(arguments) {
        Err(error) if error.kind() == ErrorKind::DisplayVersion && verbose => return console.print(&about()),
        read => read?,
    };
    if cli.common.threads.is_some() {
        number(cli.common.threads)?;
    }
    (console.quiet, console.verbose, console.threads) = (cli.common.quiet, cli.common.verbose, cli.common.threads);
    console.progress &= !cli.common.quiet;
    let started = Instant::now();
    command(&cli.command, console)?;
    if cli.common.verbose {
        let (seconds, threads) = (started.elapsed().as_secs_f64(), number(console.threads)?);
        console.remark(&format!("{seconds:.3} s; at most {threads} threads on {} cores", cores()));
    }
    Ok(())
}

fn command(command: &Command, console: &mut Console<'_>) -> Result<(), CliError> {
    match command {
        Command::Sweep(args) => sweep::run(args, console),
        Command::Merge(args) => merge::run(args, console),
        Command::Draw(args) => crate::sweep::draw::run(args, console),
        Command::Orbit(args) => orbit::run(args, console),
        Command::Words(args) => words::run(args, console),
        Command::Locate(args) => locate::run(args, console),
        Command::Branch(args) => branch::run(args, console),
        Command::Curve(args) => curve::run(args, console),
        Command::Curves(args) => curves::run(args, console),
        Command::Simulate(args) => simulate::run(args, console),
        Command::Schema(args) => schema::run(args, console),
        Command::Fate(args) => fate::run(args, console),
        Command::Stripes(args) => crate::stripes::run(args, console),
        #[cfg(feature = "explore")]
        Command::Explore(args) => crate::explore::run(args, console),
        #[cfg(not(feature = "explore"))]
        Command::Explore(_) => Err(CliError::Request(
            "this build serves no page: build with the feature `explore`, which is on by default".to_owned(),
        )),
        Command::Init(args) => setup::init(args, console),
        Command::Completions(args) => setup::completions(args, console),
        Command::Man(args) => setup::man(args, console),
    }
}

//! `mapgen`: existence and stability maps of breathers in vibro-impact chains.

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use vibrochain_cli::args::{Cli, Command};
use vibrochain_cli::{orbit_command, simulate_command, sweep_command, validate_command};

fn main() -> ExitCode {
    let cli = Cli::parse();
    let result = match &cli.command {
        Command::Sweep(args) => sweep_command::run(args),
        Command::Orbit(args) => orbit_command::run(args),
        Command::Simulate(args) => simulate_command::run(args),
        Command::Validate(args) => validate_command::run(args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // With stderr closed there is nobody left to tell; the exit code remains.
            let _ = writeln!(std::io::stderr(), "error: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}

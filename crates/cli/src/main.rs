//! `mapgen`: existence and stability maps of breathers in vibro-impact chains.

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use vibrochain_cli::args::{Cli, Command};
use vibrochain_cli::{orbit_command, simulate_command, sweep_command, validate_command};

/// Whether this build's instructions exist on this machine; without the check an old one would just say "illegal
/// instruction".
fn processor_will_do() -> bool {
    #[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
    return std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma");
    #[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
    true
}

fn main() -> ExitCode {
    if !processor_will_do() {
        let advice =
            "error: this build needs a processor with AVX2 and FMA; build with RUSTFLAGS=\"-C target-cpu=x86-64\"";
        let _ = writeln!(std::io::stderr(), "{advice}");
        return ExitCode::from(1);
    }
    let cli = Cli::parse();
    let result = match &cli.command {
        Command::Sweep(args) => sweep_command::run(args),
        Command::Orbit(args) => orbit_command::run(args),
        Command::Simulate(args) => simulate_command::run(args),
        Command::Validate(args) => validate_command::run(args),
        #[cfg(feature = "accuracy")]
        Command::Accuracy(args) => vibrochain_cli::accuracy::run(args),
        #[cfg(not(feature = "accuracy"))]
        Command::Accuracy(_) => Err(vibrochain_cli::error::CliError::Request(
            "this build has no accuracy suites: build with the feature `accuracy`".to_owned(),
        )),
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

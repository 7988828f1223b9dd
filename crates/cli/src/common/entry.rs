//! Where a program begins and ends: its console, its last words, its exit code.

use std::ffi::OsString;
use std::io::{IsTerminal, Write, stderr, stdout};
use std::process::ExitCode;

use crate::common::console::{Console, ctrl_c, printed, survive_file_limit};
use crate::common::error::CliError;

/// Whether this build's instructions exist on this machine; without the check an old one would just say "illegal
/// instruction".
fn processor_will_do() -> bool {
    #[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
    return std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma");
    #[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
    true
}

/// Runs a program given as a function of its arguments, its own name first, on the terminal.
pub fn enter(run: fn(Vec<OsString>, &mut Console<'_>) -> Result<(), CliError>) -> ExitCode {
    if !processor_will_do() {
        let advice =
            "error: this build needs a processor with AVX2 and FMA; build with RUSTFLAGS=\"-C target-cpu=x86-64\"";
        let _ = writeln!(stderr(), "{advice}");
        return ExitCode::from(1);
    }
    survive_file_limit();
    let (mut out, mut err, progress) = (stdout(), stderr(), stderr().is_terminal());
    let mut console = Console { progress, ..Console::new(&mut out, &mut err, &ctrl_c) };
    // clap knows where help and complaints go, and whether in colour.
    let result = match run(std::env::args_os().collect(), &mut console) {
        // Help is an answer like any other.
        Err(CliError::Usage(help)) if !help.use_stderr() => printed(help.print().and_then(|()| console.out.flush())),
        result => result,
    };
    match &result {
        Ok(()) | Err(CliError::Unread) => {}
        // With both streams closed there is nobody left to tell; the exit code remains.
        Err(CliError::Usage(error)) => drop(error.print()),
        Err(error) => console.remark(&format!("error: {error}")),
    }
    ExitCode::from(result.map_or_else(|error| error.exit_code(), |()| 0))
}

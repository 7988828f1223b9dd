//! `mapgen`: existence and stability maps of breathers in vibro-impact chains.

use std::process::ExitCode;

use vibrochain_cli::{common::entry, program};

fn main() -> ExitCode {
    entry::enter(program::run)
}

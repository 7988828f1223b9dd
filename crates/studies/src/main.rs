//! `studies`: what vibrochain is checked by.

use std::process::ExitCode;

use vibrochain_cli::common::entry;
use vibrochain_studies::program;

fn main() -> ExitCode {
    entry::enter(program::run)
}

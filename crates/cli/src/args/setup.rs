//! What is done once: `init`, `completions`, `man`, `schema`; and commands that have become studies.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValuesParser;

/// Arguments of `mapgen init`.
#[derive(Debug, Args)]
pub struct InitArgs {
    /// Scene file to write (.toml), or `-`.
    pub file: PathBuf,
}

/// Arguments of `mapgen completions`.
#[derive(Debug, Args)]
#[command(after_help = "For bash: mapgen completions bash > ~/.local/share/bash-completion/completions/mapgen")]
pub struct CompletionsArgs {
    /// The shell.
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

/// Arguments of `mapgen man`.
#[derive(Debug, Args)]
#[command(
    after_help = "man -l DIR/mapgen-sweep.1 reads one; where `man mapgen-sweep` looks for them: ~/.local/share/man/man1"
)]
pub struct ManArgs {
    /// Folder for the pages, one for each command.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
}

/// What is computed by the program `studies`.
pub const STUDIES: [&str; 4] = ["validate", "figures", "errata", "accuracy"];

/// Arguments of `mapgen schema`.
#[derive(Debug, Args)]
pub struct SchemaArgs {
    /// Of what.
    #[arg(value_parser = PossibleValuesParser::new(crate::common::schemas::names()))]
    pub name: Option<String>,
}

/// What was asked of a study.
#[derive(Debug, Args)]
#[command(disable_help_flag = true)]
pub struct StudyArgs {
    /// Its arguments.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, num_args = 0..)]
    pub arguments: Vec<OsString>,
}

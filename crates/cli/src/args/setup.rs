//! What is done once: `init`, `completions`, `man`, `schema`; and commands that have become studies.

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

/// Arguments of `mapgen schema`.
#[derive(Debug, Args)]
pub struct SchemaArgs {
    /// Of what.
    #[arg(value_parser = PossibleValuesParser::new(crate::common::schemas::names()))]
    pub name: Option<String>,
}

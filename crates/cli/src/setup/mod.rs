//! `mapgen init`, `completions` and `man`: what one needs once, to begin.

use std::path::Path;

use clap::{Command, CommandFactory};
use clap_mangen::Man;
use vibrochain_maps::files::{Output, promises, promises_folder};

use crate::args::{Cli, CompletionsArgs, InitArgs, ManArgs};
use crate::common::console::Console;
use crate::common::error::CliError;

/// A scene with all its keys, each explained.
pub(crate) const SCENE: &str = include_str!("new_scene.toml");

/// Writes a scene to begin with. A file that is there already is left as it is.
///
/// # Errors
/// [`CliError::Request`] for a file that is there, or cannot be written.
pub fn init(args: &InitArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let path = &args.file;
    promises("FILE", path, "a scene", &["toml"])?;
    let mut file = Output::create(path)?;
    std::io::Write::write_all(&mut file, SCENE.as_bytes()).map_err(|error| file.unwritten(&error))?;
    let name = path.display();
    ensure!(file.commit_new()?, "{name} is there already, and is left as it is: give another name");
    if path != Path::new("-") {
        console.summary(&format!("next: mapgen sweep {name} --out map.csv --plot map.png"));
    }
    Ok(())
}

/// Prints what completes the program's words in a shell.
///
/// # Errors
/// As [`Console::print`].
pub fn completions(args: &CompletionsArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "mapgen", &mut script);
    console.print(&String::from_utf8_lossy(&script))
}

/// Writes a manual page for the program and for each of its commands.
///
/// # Errors
/// [`CliError`] for a folder that cannot be written.
pub fn man(args: &ManArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    promises_folder("DIR", &args.folder)?;
    let mut program = Cli::command();
    program.build();
    let mut written = 0_u32;
    let mut page = |command: &Command| {
        let name = command.get_display_name().unwrap_or(command.get_name()).to_owned();
        let mut text = Vec::new();
        Man::new(command.clone()).render(&mut text).map_err(|error| CliError::Computation(error.to_string()))?;
        written += 1;
        Output::create(&args.folder.join(format!("{name}.1")))?.finish_with(&text).map_err(CliError::from)
    };
    page(&program)?;
    for command in program.get_subcommands().filter(|command| !command.is_hide_set() && command.get_name() != "help") {
        page(command)?;
    }
    console.summary(&format!("{written} manual pages are in {}", args.folder.display()));
    Ok(())
}

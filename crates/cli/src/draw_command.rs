//! `mapgen draw`: pictures of a table that has been written, without computing it again.

use crate::args::DrawArgs;
use crate::console::{Console, nothing_else};
use crate::error::CliError;
use crate::pictures::Pictures;
use crate::sweep_command::manifest_path;
use crate::table_cells::read;
use crate::threads::threads;
use vibrochain_maps::files::distinct;
use vibrochain_maps::scene::Scene;
use vibrochain_maps::sweep::Watcher;

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &DrawArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let wanted = &args.pictures;
    let outputs =
        [("--png", wanted.png.as_deref()), ("--svg", wanted.svg.as_deref()), ("--pdf", wanted.pdf.as_deref())];
    if outputs.iter().all(|(_, path)| path.is_none()) {
        return Err(CliError::Request("nothing is asked for: give --png, --svg or --pdf".to_owned()));
    }
    let manifest = manifest_path(&args.table);
    let source = args.scene.as_deref().unwrap_or(&manifest);
    let inputs = [("the table", Some(args.table.as_path())), ("the scene", Some(source))];
    nothing_else(false, distinct(&inputs, &outputs)?)?;
    if args.scene.is_none() && !manifest.exists() {
        let message = format!(
            "{} is not there, which says what the table is of: give the scene of the table by --scene",
            manifest.display()
        );
        return Err(CliError::Request(message));
    }
    let scene = Scene::read(source)?;
    let pool = threads(console.threads)?;
    let mut pictures = Pictures::plan(wanted, &scene)?;
    let stop = (console.interrupt)()?;
    pictures.begin();
    read("table", &args.table, &scene, |number, cell| pictures.cell(number, cell))?;
    let told = pictures.find_borders(&pool, &stop, console.progress)?;
    pictures.finish()?;
    console.summary(&format!("{} cells{told}", scene.cells()));
    Ok(())
}

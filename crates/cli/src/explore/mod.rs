//! `mapgen explore`: maps in a browser.
//!
//! | module | holds |
//! |---|---|
//! | `answers` | what the page asks besides tiles |
//! | `folder` | where these have their files, and what ends them with the explorer |
//! | `line` | command lines of this program, each run for it as a process of its own |
//! | `structure` | what the page of a structure's map asks |
//! | `texts` | what it shows leads on to: scene, command, Python |

mod answers;
mod folder;
mod line;
mod structure;
mod texts;

use std::path::Path;
use std::sync::Arc;

use crate::args::ExploreArgs;
use crate::common::console::Console;
use crate::common::error::CliError;
use crate::common::threads::threads;
use crate::explore::answers::Program;
pub(crate) use crate::explore::folder::end_with_explorer;
use crate::explore::line::Setting;
use crate::explore::structure::StructureProgram;
use crate::setup::SCENE;
use crate::structures;
use vibrochain_explore::{Answers, Explorer, View, port_will_do};
use vibrochain_maps::scene::Scene;
use vibrochain_maps::structure::StructureScene;

/// Runs the subcommand: until Ctrl-C, which is how it ends well.
///
/// # Errors
/// [`CliError::Request`] for a scene that cannot be flown over, and a port that no browser opens; [`CliError::Computation`] for a port that is
/// taken.
pub(crate) fn run(args: &ExploreArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    port_will_do(args.port).map_err(|refusal| CliError::Request(refusal.message))?;
    if let Some(path) = &args.scene
        && let Some(scene) = structures::read(path)?
    {
        return of_structure(scene, path, args.port, console);
    }
    let scene = match &args.scene {
        Some(path) => Scene::read(path)?,
        None => Scene::parse(Path::new("scene"), SCENE)?,
    };
    let view = View::of(&scene).map_err(|refusal| {
        let name = args.scene.as_deref().map_or("scene".into(), |path| path.display().to_string());
        CliError::Request(format!("{name}: {refusal}"))
    })?;
    for axis in scene.axes.iter().skip(2) {
        console.summary(&format!("{} stands at {}: the page can change it", axis.parameter.name(), axis.first()));
    }
    let setting = files(console)?;
    serve(Arc::new(Program { view, setting }), args.port, console)
}

/// The map of a structure's scene.
fn of_structure(scene: StructureScene, path: &Path, port: u16, console: &mut Console<'_>) -> Result<(), CliError> {
    let (setting, pool) = (files(console)?, threads(console.threads)?);
    // Each orbit is a process of its own, whose folder is another.
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let program = StructureProgram::new(scene, whole, setting, pool);
    let program = program.map_err(|why| CliError::Request(format!("{}: {why}", path.display())))?;
    serve(Arc::new(program), port, console)
}

fn files(console: &Console<'_>) -> Result<Setting, CliError> {
    Setting::new(console.threads)
        .map_err(|error| CliError::Computation(format!("no folder for temporary files: {error}")))
}

fn serve(program: Arc<dyn Answers>, port: u16, console: &mut Console<'_>) -> Result<(), CliError> {
    let stop = (console.interrupt)()?;
    let pool = threads(console.threads)?;
    let explorer =
        Explorer::open(port).map_err(|error| CliError::Computation(format!("cannot serve on port {port}: {error}")))?;
    console.print(&format!("{}\n", explorer.address()))?;
    console.summary("open this address in a browser on this machine; Ctrl-C ends the explorer");
    explorer.serve(program, pool, &stop);
    Ok(())
}

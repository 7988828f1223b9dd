//! `studies figures`: every figure of the paper as PNG and SVG, with the numbers behind it as CSV, each from a scene of its
//! own; and the document that shows them.
//!
//! | module | holds |
//! |---|---|
//! | `library`, `scene` | the scenes: built in or from a folder; read and checked |
//! | `profile`, `trace`, `solutions`, `comparison`, `map` | the kinds of figures |
//! | `solve`, `drawn` | physical orbits at a point; picture, tables and findings of a figure |
//! | `captions`, `document` | words, and the Markdown they make with the findings |

mod captions;
mod comparison;
mod document;
mod drawn;
mod library;
mod map;
mod profile;
mod scene;
mod solutions;
pub(crate) mod solve;
mod trace;

use std::path::Path;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::args::FiguresArgs;
use crate::figures::document::Document;
use crate::figures::drawn::{Drawn, file_name};
use crate::figures::scene::{FigureScene, Kind};
use vibrochain_cli::common::console::Console;
use vibrochain_cli::common::error::CliError;
use vibrochain_cli::common::threads::threads;
use vibrochain_lattice::Stop;
use vibrochain_maps::files::Output;
use vibrochain_maps::files::{distinct, promises_folder};
use vibrochain_plot::Format;

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &FiguresArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    promises_folder("--out", &args.out)?;
    distinct(&[], &[("--out", Some(&args.out)), ("--document", args.document.as_deref())])?;
    let entries = match &args.scenes {
        Some(folder) => library::folder(folder)?,
        None => library::built_in(),
    };
    let chosen = library::chosen(entries, &args.only)?;
    let scenes = chosen.iter().map(scene::parse).collect::<Result<Vec<_>, _>>()?;
    // Destinations first: an impossible one should not cost a computation.
    let document_file = args.document.as_deref().map(|path| Output::document("--document", path)).transpose()?;
    let files = chosen.iter().map(|entry| Files::open(&args.out, &entry.id)).collect::<Result<Vec<_>, _>>()?;
    let pool = threads(None)?;

    let stop = (console.interrupt)()?;
    let bar = progress(scenes.len(), console.progress);
    let mut document = Document::new(&args.out, args.document.as_deref(), &args.only);
    let mut names = Vec::new();
    for ((entry, scene), files) in chosen.iter().zip(&scenes).zip(files) {
        bar.set_message(format!("figure {}", entry.id));
        if stop.is_raised() {
            return Err(interrupted(&names, &args.out));
        }
        let drawn = compute(scene, &pool, &stop).map_err(|error| match error {
            CliError::Interrupted => interrupted(&names, &args.out),
            other => other.about(format!("figure {}", entry.id)),
        })?;
        document.add(&entry.id, scene, &drawn.findings);
        files.write(&args.out, &entry.id, drawn)?;
        names.push(entry.id.clone());
        bar.inc(1);
    }
    bar.finish_and_clear();
    if let Some(file) = document_file {
        file.finish_with(document.markdown().as_bytes())?;
    }
    console.remark(&format!("figures {} written to {}", names.join(", "), args.out.display()));
    Ok(())
}

/// Figures that are done stay; the one under way is not begun on disk, nor is the document.
fn interrupted(done: &[String], folder: &Path) -> CliError {
    if done.is_empty() {
        return CliError::Interrupted;
    }
    let plural = if done.len() == 1 { "figure" } else { "figures" };
    CliError::Paused(format!("{plural} {} written to {}, no others", done.join(", "), folder.display()))
}

fn compute(scene: &FigureScene, pool: &rayon::ThreadPool, stop: &Stop) -> Result<Drawn, CliError> {
    match scene {
        FigureScene::Map(scene) => map::draw(scene, pool, stop),
        FigureScene::Lines(scene) => match scene.kind {
            Kind::Profile { reach } => profile::draw(scene, reach),
            Kind::Trace => trace::draw(scene),
            Kind::Solutions { over: parameter, from, to, points: count } => {
                solutions::draw(scene, solutions::Over { parameter, from, to, count }, stop)
            }
            Kind::Comparison { perturb, periods, shown, late } => {
                comparison::draw(scene, comparison::Run { perturb, periods, shown, late }, stop)
            }
        },
    }
}

fn progress(figures: usize, shown: bool) -> ProgressBar {
    if !shown {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(Some(figures as u64), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{bar:32} {pos}/{len} figures  {elapsed}  {wide_msg}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// The files of one figure.
struct Files {
    csv: Output,
    pictures: [(Format, Output); 2],
}

impl Files {
    fn open(folder: &Path, id: &str) -> Result<Self, CliError> {
        let open = |ending: &str| Output::create(&folder.join(file_name(id, "", ending)));
        Ok(Self { csv: open("csv")?, pictures: [(Format::Png, open("png")?), (Format::Svg, open("svg")?)] })
    }

    fn write(self, folder: &Path, id: &str, drawn: Drawn) -> Result<(), CliError> {
        self.csv.finish_with(&drawn.table)?;
        for (suffix, bytes) in &drawn.more {
            Output::create(&folder.join(file_name(id, suffix, "csv")))?.finish_with(bytes)?;
        }
        for (format, file) in self.pictures {
            let bytes = drawn.picture.bytes(format).map_err(|error| CliError::Computation(error.to_string()))?;
            file.finish_with(&bytes)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interruption_speaks_of_figures_that_are_there() {
        let told = |done: &[&str]| {
            let names: Vec<String> = done.iter().map(|name| (*name).to_owned()).collect();
            interrupted(&names, Path::new("out")).to_string()
        };
        assert_eq!(told(&[]), "interrupted: nothing was written");
        assert_eq!(told(&["3"]), "interrupted: figure 3 written to out, no others");
        assert_eq!(told(&["3", "9"]), "interrupted: figures 3, 9 written to out, no others");
    }
}

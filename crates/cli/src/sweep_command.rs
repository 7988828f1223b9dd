//! `mapgen sweep`: scene → plan → run → files → summary.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use indicatif::{HumanCount, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use vibrochain_floquet::Tolerance;

use crate::args::SweepArgs;
use crate::cell::{Class, Status};
use crate::console::Console;
use crate::error::CliError;
use crate::manifest::{Run, manifest};
use crate::output::{Output, distinct};
use crate::scene::{Scene, tolerance_from};
use crate::sweep::{Ended, Summary, sweep};
use crate::table::Table;

/// The most threads that may be asked for.
const MAX_THREADS: usize = 1024;

/// Where the manifest of a table goes: map.csv → map.manifest.json, map → map.manifest.json, map.5 → map.5.manifest.json.
fn manifest_path(table: &Path) -> PathBuf {
    let mut name = table.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if let Some(stem) = name.strip_suffix(".csv") {
        name = stem.to_owned();
    }
    table.with_file_name(name + ".manifest.json")
}

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &SweepArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let mut scene = Scene::read(&args.scene)?;
    if let Some(threshold) = args.threshold {
        if scene.task.tolerance != Tolerance::Rounding {
            let message = format!(
                "threshold is given twice, as --threshold {threshold} and in {}: remove one",
                args.scene.display()
            );
            return Err(CliError::Request(message));
        }
        if !scene.task.stability {
            let message = format!(
                "--threshold needs `stability = true` in {}: it decides what counts as stable",
                args.scene.display()
            );
            return Err(CliError::Request(message));
        }
        scene.task.tolerance = tolerance_from(threshold).map_err(CliError::Request)?;
    }
    let pool = threads(args.threads)?;
    let threads = pool.current_num_threads();

    let manifest_file = manifest_path(&args.out);
    distinct(&[
        ("the scene", Some(&args.scene)),
        ("--out", Some(&args.out)),
        ("the manifest of --out", Some(&manifest_file)),
        ("--png", args.png.as_deref()),
        ("--svg", args.svg.as_deref()),
    ])?;
    // Destinations first: an impossible one should not cost a computation.
    let table_file = Output::create(&args.out)?;
    let manifest_file = Output::create(&manifest_file)?;
    let mut pictures = Pictures::open(args)?;

    let stop = (console.interrupt)()?;
    let bar = progress(&scene, console.progress && !args.quiet);
    let started = Instant::now();
    let unwritable = |error: &dyn std::fmt::Display| {
        CliError::Computation(format!("could not write {}: {error}", args.out.display()))
    };
    let mut table = Table::new(&scene, table_file).map_err(|error| unwritable(&error))?;
    let cells_per_row = scene.x.points as u64;
    let ended = sweep(
        &scene,
        &pool,
        &stop,
        || bar.inc(cells_per_row),
        |j, cells| {
            pictures.keep(cells);
            cells.iter().enumerate().try_for_each(|(i, cell)| table.write(&scene.point(i, j), cell))
        },
    );
    bar.finish_and_clear();
    let summary = match ended {
        Ended::Complete(summary) => summary,
        Ended::Stopped => return Err(CliError::Interrupted),
        Ended::Failed(error) => return Err(unwritable(&error)),
    };
    let wall = started.elapsed();
    table.finish().map_err(|error| unwritable(&error))?.commit()?;
    let scene_file = args.scene.display().to_string();
    let about =
        Run { scene_file: &scene_file, scene: &scene, summary: &summary, threads, wall_seconds: wall.as_secs_f64() };
    let mut text = serde_json::to_vec_pretty(&manifest(&about)).map_err(|error| unwritable(&error))?;
    text.push(b'\n');
    manifest_file.finish_with(&text)?;
    pictures.finish(&scene)?;
    if !args.quiet {
        console.remark(&report(&scene, &summary, wall, threads));
    }
    Ok(())
}

fn threads(asked: Option<usize>) -> Result<rayon::ThreadPool, CliError> {
    if let Some(threads) = asked
        && !(1..=MAX_THREADS).contains(&threads)
    {
        let message = format!("--threads {threads} is out of range: give a whole number from 1 to {MAX_THREADS}");
        return Err(CliError::Request(message));
    }
    rayon::ThreadPoolBuilder::new()
        .num_threads(asked.unwrap_or(0))
        .build()
        .map_err(|error| CliError::Computation(format!("cannot start threads: {error}")))
}

fn progress(scene: &Scene, wanted: bool) -> ProgressBar {
    if !wanted {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(Some(scene.cells() as u64), ProgressDrawTarget::stderr());
    let template = "{bar:32} {percent:>3}%  {human_pos}/{human_len} cells  {rate} cells/s  {eta} left";
    if let Ok(style) = ProgressStyle::with_template(template) {
        // A broken line of progress is no reason to stop: the result of writing it is left alone.
        bar.set_style(style.with_key("rate", |state: &ProgressState, line: &mut dyn std::fmt::Write| {
            let _ = write!(line, "{}", HumanCount(state.per_sec() as u64));
        }));
    }
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// The summary.
fn report(scene: &Scene, summary: &Summary, wall: Duration, threads: usize) -> String {
    let cells = scene.cells();
    let mut lines = vec![format!("{cells} cells ({} × {})", scene.x.points, scene.y.points)];
    let share = |count: u64| 100.0 * count as f64 / cells as f64;
    for (class, &count) in Class::ALL.iter().zip(&summary.classes).filter(|(_, count)| **count > 0) {
        lines.push(format!("  {:<16} {count:>9}  {:5.1} %", class.name(), share(count)));
    }
    for (status, &count) in Status::ALL.iter().zip(&summary.statuses).skip(1).filter(|(_, count)| **count > 0) {
        lines.push(format!("  status {:<16} {count:>9}", status.name()));
    }
    let per_cell = wall.as_secs_f64() * 1e6 * threads as f64 / cells as f64;
    lines.push(format!("{:.3} s on {threads} threads, {per_cell:.2} µs per cell and core", wall.as_secs_f64()));
    lines.push(format!("worst residual of an orbit {:.1e}", summary.worst_residual));
    lines.join("\n")
}

#[cfg(feature = "plot")]
use with_pictures::Pictures;
#[cfg(not(feature = "plot"))]
use without_pictures::Pictures;

#[cfg(feature = "plot")]
mod with_pictures {
    use super::{CliError, Output, Scene, SweepArgs};
    use crate::args::PaletteName;
    use crate::cell::Cell;
    use crate::plot::{Format, MapPicture, Palette, Tile, map_picture};

    /// Pictures to draw once the cells are known; a sweep without them keeps no cell.
    pub(super) struct Pictures {
        files: Vec<(Format, Output)>,
        palette: Palette,
        tiles: Vec<Tile>,
    }

    impl Pictures {
        pub(super) fn open(args: &SweepArgs) -> Result<Self, CliError> {
            let mut files = Vec::new();
            for (path, format) in [(&args.png, Format::Png), (&args.svg, Format::Svg)] {
                if let Some(path) = path {
                    files.push((format, Output::create(path)?));
                }
            }
            let palette = match args.palette {
                PaletteName::Colour => Palette::Colour,
                PaletteName::Paper => Palette::Paper,
            };
            Ok(Self { files, palette, tiles: Vec::new() })
        }

        pub(super) fn keep(&mut self, cells: &[Cell]) {
            if !self.files.is_empty() {
                self.tiles.extend(cells.iter().map(Tile::from));
            }
        }

        pub(super) fn finish(self, scene: &Scene) -> Result<(), CliError> {
            let picture = MapPicture { scene, tiles: &self.tiles, palette: self.palette };
            for (format, file) in self.files {
                let bytes = map_picture(&picture, format).map_err(|error| CliError::Computation(error.to_string()))?;
                file.finish_with(&bytes)?;
            }
            Ok(())
        }
    }
}

#[cfg(not(feature = "plot"))]
mod without_pictures {
    use super::{CliError, Scene, SweepArgs};
    use crate::cell::Cell;

    /// This build draws nothing.
    pub(super) struct Pictures;

    impl Pictures {
        pub(super) fn open(args: &SweepArgs) -> Result<Self, CliError> {
            if args.png.is_some() || args.svg.is_some() {
                return Err(CliError::Request("--png and --svg need a build with the feature `plot`".to_owned()));
            }
            Ok(Self)
        }

        pub(super) fn keep(&mut self, _: &[Cell]) {}

        pub(super) fn finish(self, _: &Scene) -> Result<(), CliError> {
            Ok(())
        }
    }
}

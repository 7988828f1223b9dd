//! `studies refinement`: what a map that is refined has wrong, counted against all cells of its finest grid.
//!
//! Both come from the same cells: what is counted is what refinement leaves out, not what a cell has wrong.

use std::fmt::Write as _;
use std::path::Path;

use rayon::ThreadPool;
use vibrochain_floquet::Mechanism;
use vibrochain_maps::cell::{Cell, Class};
use vibrochain_maps::scene::{Refine, Scene, Values};
use vibrochain_maps::sweep::{Ended, Job, refined, sweep};

use crate::args::RefinementArgs;
use vibrochain_cli::common::console::Console;
use vibrochain_cli::common::error::CliError;
use vibrochain_cli::common::threads::threads;
use vibrochain_lattice::Stop;

/// The most cells of a finest grid: six bytes each are kept.
const MOST_CELLS: u64 = 400_000_000;

/// Depths that a scene may have.
const DEPTHS: std::ops::RangeInclusive<u32> = 1..=8;

/// What must be alike, and how large the leaf is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Painted {
    class: Option<Class>,
    mechanism: Option<Mechanism>,
    /// 255 stands for more.
    solutions: u8,
    /// How often it was halved.
    level: u8,
}

impl Painted {
    fn of(cell: &Cell, level: u8) -> Self {
        let solutions = u8::try_from(cell.solutions).unwrap_or(u8::MAX);
        Self { class: cell.class, mechanism: cell.mechanism, solutions, level }
    }
}

/// What was counted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missed {
    /// Cells of the finest grid, and leaves.
    pub cells: u64,
    /// Leaves, by how often they were halved.
    pub leaves: Vec<u64>,
    /// Cells whose class is not that of their leaf, by how often the leaf was halved.
    pub classes: Vec<u64>,
    /// Cells whose class is, and whose mechanism is not.
    pub mechanisms: u64,
    /// Cells of which both are, and the number of solutions is not.
    pub solutions: u64,
}

/// Counts what the map of a scene has wrong.
///
/// # Errors
/// [`CliError::Request`] for a scene that is not refined or whose finest grid is too large; [`CliError::Interrupted`].
pub fn missed(scene: &Scene, pool: &ThreadPool, stop: &Stop) -> Result<Missed, CliError> {
    let Some(Refine { depth }) = scene.refine else {
        return Err(CliError::Request("the scene is not refined: add refine = { depth = 5 } to [sweep]".to_owned()));
    };
    let finest = scene.finest();
    let cells = finest.cells();
    if cells > MOST_CELLS {
        let message =
            format!("the finest grid has {cells} cells, at most {MOST_CELLS} are compared: give --depth or --points");
        return Err(CliError::Request(message));
    }
    let levels = depth as usize + 1;
    let nothing = Painted { class: None, mechanism: None, solutions: 0, level: 0 };
    let mut map = vec![nothing; cells as usize];
    let columns = finest.axes[0].points();
    let (mut leaves, mut painted) = (vec![0; levels], 0);
    let ended = refined(
        &Job { scene, pool, stop },
        std::slice::from_ref(&(0..scene.cells())),
        |_| {},
        |some| {
            for (_, cell) in some {
                let Some(extent) = cell.extent else { continue };
                let level = depth - extent.size.ilog2();
                leaves[level as usize] += 1;
                painted += extent.cells();
                for row in extent.row..extent.row + extent.size {
                    let first = row as usize * columns + extent.column as usize;
                    map[first..first + extent.size as usize].fill(Painted::of(cell, level as u8));
                }
            }
            Ok::<_, CliError>(())
        },
    );
    whole(ended)?;
    if painted != cells {
        return Err(CliError::Computation(format!("the leaves are {painted} cells, the finest grid has {cells}")));
    }
    let mut found = Missed { cells, leaves, classes: vec![0; levels], mechanisms: 0, solutions: 0 };
    let ended = sweep(
        &finest,
        pool,
        stop,
        |_| {},
        |range, cells| {
            for (number, cell) in range.zip(cells) {
                let leaf = map[number as usize];
                let here = Painted::of(cell, leaf.level);
                if here.class != leaf.class {
                    found.classes[usize::from(leaf.level)] += 1;
                } else if here.mechanism != leaf.mechanism {
                    found.mechanisms += 1;
                } else if here.solutions != leaf.solutions {
                    found.solutions += 1;
                }
            }
            Ok::<_, CliError>(())
        },
    );
    whole(ended)?;
    Ok(found)
}

fn whole<T>(ended: Ended<CliError, T>) -> Result<(), CliError> {
    match ended {
        Ended::Complete(_) => Ok(()),
        Ended::Stopped => Err(CliError::Interrupted),
        Ended::Failed(error) => Err(error),
    }
}

/// The scene of a file, with other points and another depth if they are given.
fn scene(args: &RefinementArgs) -> Result<Scene, CliError> {
    let path: &Path = &args.scene;
    let mut scene = Scene::read(path)?;
    if let Some(depth) = args.depth {
        if !DEPTHS.contains(&depth) {
            return Err(CliError::Request(format!("--depth {depth} is out of range: give 1 to 8")));
        }
        scene.refine = Some(Refine { depth });
    }
    if !args.points.is_empty() && args.points.len() != 2 {
        return Err(CliError::Request(
            "--points has one number: give those along x and along y, as in 100,75".to_owned(),
        ));
    }
    let axes = scene.axes.len();
    for (axis, wanted) in scene.axes.iter_mut().zip(&args.points) {
        match &mut axis.values {
            Values::Linear { points, .. } if *wanted >= 2 && axes == 2 => *points = *wanted,
            _ => {
                let message = format!("--points {wanted}: give 2 at least, for a scene of two equally spaced axes");
                return Err(CliError::Request(message));
            }
        }
    }
    Ok(scene)
}

/// Runs the study.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &RefinementArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let scene = scene(args)?;
    let pool = threads(args.threads)?;
    let stop = (console.interrupt)()?;
    let missed = missed(&scene, &pool, &stop)?;
    console.print(&told(&scene, &missed))
}

fn told(scene: &Scene, missed: &Missed) -> String {
    let Missed { cells, leaves, classes, mechanisms, solutions } = missed;
    let grid = |scene: &Scene| scene.axes.iter().map(|axis| axis.points().to_string()).collect::<Vec<_>>().join(" × ");
    let (all, wrong): (u64, u64) = (leaves.iter().sum(), classes.iter().sum());
    let (coarse, fine, depth) = (grid(scene), grid(&scene.finest()), leaves.len() - 1);
    let mut text = format!("{all} leaves for {cells} cells ({fine}: {coarse}, refined {depth} times)\n\n");
    let share = |count: u64| 100.0 * count as f64 / *cells as f64;
    let mut line = |name: &str, count: u64| {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{name:<48} {count:>10}  {:9.5} %", share(count));
    };
    line("cells of another class than their leaf", wrong);
    for (level, (count, leaves)) in classes.iter().zip(leaves).enumerate() {
        line(&format!("  in the {leaves} leaves halved {level} times"), *count);
    }
    line("cells of another mechanism alone", *mechanisms);
    line("cells of another number of solutions alone", *solutions);
    text
}

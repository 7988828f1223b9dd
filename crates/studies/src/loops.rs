//! `studies loop`: one inner loop and little else, for a tool that counts instructions (`scripts/instructions.sh`).
//!
//! What a loop needs is made, and run once, before `measured` is entered; the tool counts from there to its end, so that neither start
//! nor work space counts.

use std::hint::black_box;
use std::path::Path;

use clap::ValueEnum;
use vibrochain_breather::{Family, Motion, breathers};
use vibrochain_cli::common::console::Console;
use vibrochain_cli::common::error::CliError;
use vibrochain_eventsim::{Limits, Simulation, Time};
use vibrochain_lattice::{Chain, Model, Stop};
use vibrochain_maps::cell::{Cell, Worker};
use vibrochain_maps::grid::{Files, Grid};
use vibrochain_maps::scene::Scene;
use vibrochain_maps::structure::StructureScene;
use vibrochain_maps::table::RowWriter;

use crate::args::{LoopArgs, LoopName};

/// Masses, γ₁ and asymmetry of the paper's maps.
const SITES: usize = 21;
const GAMMA1: f64 = 0.2;
const ASYMMETRY: f64 = 0.4;

/// Points of a map over ω and γ₂: every region of the paper's maps has some.
const POINTS: [usize; 2] = [40, 24];

/// Periods of a simulated breather, and of a ring all of whose masses hit.
const PERIODS: u32 = 200;
const HOT_PERIODS: u32 = 20;

/// Runs one inner loop.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &LoopArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let wrong = |error: &dyn std::fmt::Display| CliError::Computation(error.to_string());
    let units = match args.name {
        LoopName::ConservativeCells => cells("")?,
        LoopName::StructureCells => structure_cells()?,
        LoopName::ForcedCells => cells("forcing = { amplitude = 0.1, restitution = 0.9 }")?,
        LoopName::DampedCells => cells("forcing = { amplitude = 0.1, restitution = 0.9 }\ndamping = 0.01")?,
        LoopName::TableRows => rows()?,
        LoopName::SimulatedBreather => {
            let model = model().map_err(|error| wrong(&error))?;
            let start = on_breather(&model).map_err(|error| wrong(&error))?;
            simulated(&model, &start, PERIODS)?
        }
        LoopName::HotRing => {
            let model = model().map_err(|error| wrong(&error))?;
            let wave = |n: usize, k: f64| (n as f64 * k).sin();
            let start = (0..SITES).map(|n| (ASYMMETRY + 0.5 * wave(n, 1.3), 1.2 * wave(n, 2.1))).unzip();
            simulated(&model, &start, HOT_PERIODS)?
        }
    };
    let name = args.name.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default();
    console.print(&format!("{name}: {units}\n"))
}

/// What is counted.
#[inline(never)]
fn measured(work: &mut dyn FnMut()) {
    work();
}

/// Once for the work space, once to be counted.
fn twice(mut work: impl FnMut()) {
    work();
    measured(&mut work);
}

fn text(forcing: &str, families: [&str; 2]) -> String {
    let [x, y] = POINTS;
    format!(
        "[model]\nsites = {SITES}\ngamma1 = {GAMMA1}\nasymmetry = {ASYMMETRY}\n{forcing}\n[sweep]\n\
         x = {{ parameter = \"omega\", from = 0.4, to = 3.0, points = {x} }}\n\
         y = {{ parameter = \"gamma2\", from = 0.0, to = 0.3, points = {y} }}\n\
         [compute]\nfamilies = {families:?}\nstability = true\n"
    )
}

fn map(forcing: &str) -> Result<Scene, CliError> {
    let text = text(forcing, ["double-sided", "single-sided"]);
    Scene::parse(Path::new("loop"), &text).map_err(|error| CliError::Computation(error.to_string()))
}

/// Existence and stability of both families at every point of a map.
fn all_cells(scene: &Scene, worker: &mut Worker) -> Vec<Cell> {
    let mut cells = Vec::new();
    scene.walk_models(0..scene.cells(), |model| {
        cells.push(worker.cell(model, &scene.task));
        true
    });
    cells
}

fn cells(forcing: &str) -> Result<String, CliError> {
    let scene = map(forcing)?;
    let mut worker = Worker::new(SITES);
    twice(|| drop(black_box(all_cells(&scene, &mut worker))));
    Ok(format!("{} cells", scene.cells()))
}

/// Cells of the conservative map's ring with dashpots of 0, which make it a structure.
fn structure_cells() -> Result<String, CliError> {
    let scene =
        <StructureScene as Grid>::parse(Path::new("loop"), &text("damping = 0", ["0+,0-", "0-"]), &Files::new())
            .map_err(|error| CliError::Computation(error.to_string()))?;
    let stop = Stop::default();
    let (mut worker, mut cells) = (scene.worker(&stop), Vec::new());
    twice(|| {
        let _ = black_box(scene.compute(&mut worker, 0..scene.cells(), &stop, &mut cells));
    });
    Ok(format!("{} cells", scene.cells()))
}

fn rows() -> Result<String, CliError> {
    let scene = map("")?;
    let cells = all_cells(&scene, &mut Worker::new(SITES));
    twice(|| drop(black_box(RowWriter::new(&scene, false).rows(0..scene.cells(), &cells))));
    Ok(format!("{} rows", scene.cells()))
}

fn model() -> Result<Model, vibrochain_lattice::LatticeError> {
    Ok(Model::conservative(Chain::new(SITES, GAMMA1, 0.1)?, 1.5, ASYMMETRY)?)
}

/// Displacements and velocities.
type Start = (Vec<f64>, Vec<f64>);

/// The double-sided breather half-way to its first impact.
fn on_breather(model: &Model) -> Result<Start, vibrochain_breather::BreatherError> {
    let found = breathers(model, Family::DoubleSided)?;
    let Some(orbit) = found.orbits.first() else { return Ok((vec![0.0; SITES], vec![0.0; SITES])) };
    Ok(Motion::of(orbit)?.state(-0.25 * orbit.period()))
}

fn simulated(model: &Model, (u, v): &Start, periods: u32) -> Result<String, CliError> {
    let begun = Simulation::new(model, 0.0, u, v);
    let mut simulation = begun.map_err(|error| CliError::Computation(error.to_string()))?;
    let mut period = 0;
    let mut impacts = 0;
    twice(|| {
        impacts = 0;
        for _ in 0..periods {
            period += 1;
            let _ = black_box(simulation.run(&Limits::until(Time::new(model, period, 0.0)), |_| impacts += 1));
        }
    });
    Ok(format!("{periods} periods, {impacts} impacts"))
}

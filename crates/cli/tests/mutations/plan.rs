//! How much of a command is affordable.

use std::ffi::OsString;
use std::fs;
use std::path::Path;

use vibrochain_breather::{Family, Word};
use vibrochain_cli::args::{Cli, Command, PictureArgs, read};
use vibrochain_cli::common::model;
use vibrochain_lattice::Model;
use vibrochain_maps::scene::Scene;

/// Masses × windows of flight that a run may ask for; beyond it, it is told to stop as soon as it listens, or not computed.
pub(crate) const WORK: f64 = 8_000.0;

/// What is to be done with a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Plan {
    /// All of it.
    Whole,
    /// Told to stop as soon as it listens.
    Stopped,
    /// No further than its parameters.
    Parameters,
}

/// Windows of flight in a period of the slowest orbit; their square where all solutions are sought, because both their
/// number and the work on each grow with them. A sweep without force seeks the symmetric one alone.
fn windows(model: &Model, all: bool) -> f64 {
    let top = (model.chain().gamma1() + 4.0 * model.chain().gamma2()).sqrt().max(model.omega());
    let windows = 1.0 + 2.0 * model.period() * top;
    if all || !model.is_conservative() { windows * windows } else { windows }
}

/// How much of a command is affordable. What cannot be parsed is always run whole: it costs nothing.
pub(crate) fn plan(line: &[OsString], work: f64) -> Plan {
    let of = |cost: f64, otherwise: Plan| if cost <= work { Plan::Whole } else { otherwise };
    let cli = read::<Cli>(line.iter().cloned());
    let threads = cli.as_ref().ok().and_then(|cli| cli.common.threads);
    match cli.map(|cli| cli.command) {
        Err(_) => Plan::Whole,
        Ok(Command::Sweep(args)) => {
            let Ok(scene) = Scene::read(&args.scene) else { return Plan::Whole };
            let mut windows_most = 0.0_f64;
            for corner in 0..1_usize << scene.axes.len() {
                let limits = scene.axes.iter().enumerate().map(|(i, axis)| (axis, axis.limits()[corner >> i & 1]));
                let corner = limits.fold(scene.base, |point, (axis, value)| point.with(axis.parameter, value));
                windows_most = windows_most.max(corner.model().map_or(1.0, |model| windows(&model, false)));
            }
            // A picture takes longer than its cells, threads longer than they are worth.
            let PictureArgs { png, svg, pdf, .. } = &args.pictures;
            let pictures =
                [png, svg, pdf].iter().any(|file| file.is_some()) || threads.is_none_or(|threads| threads > 4);
            let cost = scene.cells() as f64 * scene.base.sites() as f64 * windows_most;
            of(if pictures { f64::INFINITY } else { cost }, Plan::Stopped)
        }
        // Every border of a window; hundreds of periods of many runs; a page that is served until it is stopped.
        Ok(Command::Curves(_) | Command::Fate(_) | Command::Explore(_)) => Plan::Stopped,
        // Each word by a dense matrix.
        Ok(Command::Words(args)) => match model::model(&args.model).map(|chosen| chosen.model) {
            Ok(model) => {
                let words = Word::combinations(
                    &model.chain().layout(),
                    args.sites_used,
                    args.reach,
                    &[Family::DoubleSided, Family::SingleSided],
                );
                of(words * (model.chain().sites() as f64).powi(3) * windows(&model, true), Plan::Stopped)
            }
            Err(_) => Plan::Whole,
        },
        Ok(Command::Orbit(args)) => match model::model(&args.model).map(|chosen| chosen.model) {
            Ok(model) if args.plot.is_none() && args.all_plots.is_none() => {
                // Words under a force are followed over many orbits.
                let orbits = if args.which.word.is_some() { 100.0 } else { 1.0 };
                of(orbits * model.chain().sites() as f64 * windows(&model, true), Plan::Parameters)
            }
            Ok(_) => Plan::Parameters,
            Err(_) => Plan::Whole,
        },
        // Hundreds of orbits.
        Ok(Command::Locate(args)) => match model::model(&args.along.model).map(|chosen| chosen.model) {
            Ok(model) => of(100.0 * model.chain().sites() as f64 * windows(&model, true), Plan::Parameters),
            Err(_) => Plan::Whole,
        },
        // Hundreds of spectra of each branch.
        Ok(Command::Branch(args)) => match model::model(&args.along.model).map(|chosen| chosen.model) {
            Ok(_) if args.switch || args.plot.is_some() => Plan::Parameters,
            Ok(model) => {
                let spectra = 1000.0 * (model.chain().sites() as f64).powi(3);
                of(spectra.max(100.0 * model.chain().sites() as f64 * windows(&model, true)), Plan::Parameters)
            }
            Err(_) => Plan::Whole,
        },
        // As many, of each curve.
        Ok(Command::Curve(_)) => Plan::Parameters,
        Ok(Command::Simulate(args)) => {
            let Ok(model) = model::model(&args.model).map(|chosen| chosen.model) else { return Plan::Whole };
            let sites = model.chain().sites() as f64;
            if args.plot.is_some() || sites * windows(&model, true) > work {
                return Plan::Parameters;
            }
            let periods = args.periods;
            let sampled = if args.trajectory.is_some() { args.samples as f64 } else { 1.0 };
            // Impacts of a mass that is thrown from barrier to barrier.
            let fastest = args.state.as_deref().map_or(0.0, fastest).max(model.amplitude() / model.omega());
            let impacts = fastest * model.period();
            of(sites * periods * (windows(&model, true) + sampled + sites * impacts), Plan::Stopped)
        }
        // It reads a table and computes nothing; its picture takes longer.
        Ok(Command::Draw(_)) => Plan::Stopped,
        Ok(Command::Merge(args)) => {
            let PictureArgs { png, svg, pdf, .. } = &args.pictures;
            if [png, svg, pdf].iter().any(|file| file.is_some()) { Plan::Stopped } else { Plan::Whole }
        }
        // Minutes of work, tested elsewhere.
        Ok(Command::Init(_) | Command::Completions(_) | Command::Man(_)) => Plan::Whole,
        Ok(Command::Stripes(_)) => Plan::Parameters,
        Ok(Command::Schema(_)) => Plan::Whole,
    }
}

/// The largest number of a state file.
fn fastest(path: &Path) -> f64 {
    let text = fs::read_to_string(path).unwrap_or_default();
    let value: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    let numbers = value["velocity"].as_array().into_iter().flatten().filter_map(serde_json::Value::as_f64);
    numbers.fold(0.0, |most: f64, x| most.max(x.abs()))
}

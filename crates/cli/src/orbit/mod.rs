//! `mapgen orbit`: all breathers of a family at one point.

mod answer;
pub(crate) mod modes;
pub(crate) mod multiplier_file;
pub(crate) mod pictures;
pub(crate) mod plots;
pub(crate) mod trajectory;

use std::fmt::Write as _;

use vibrochain_breather::{BreatherError, Finder, Motion, NoBreather, Orbit, OrbitList};
use vibrochain_floquet::{Analyser, Complex, Mechanism, Multipliers, Verdict, leading_modes, phases};
use vibrochain_lattice::Model;

use crate::args::OrbitArgs;
use crate::common::answer::{estimate, printed, told_list, told_verdict};
use crate::common::console::Console;
use crate::common::error::CliError;
use crate::common::model::chosen;
use crate::common::solution::Solution;
use crate::common::which;
use crate::orbit::answer::answer;
use crate::orbit::modes::OrbitModes;
use crate::orbit::multiplier_file::MultiplierFile;
use crate::orbit::pictures::{OrbitPictures, apart};
use crate::orbit::trajectory::OrbitTrajectory;
use crate::simulate::recording::trajectory_columns;
use crate::structures;
use vibrochain_maps::numbers::Number;

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`]; that there is no orbit is an answer.
pub fn run(args: &OrbitArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    if let Some(scene) = structures::asked(&args.model)? {
        return structures::orbit::run(args, &scene, console);
    }
    let chosen = chosen(&args.model, console)?;
    let model = chosen.model;
    let which = which::wanted(&args.which, chosen.scene.as_ref())?;
    let tolerance = chosen.tolerance(args.threshold)?;
    let taken = apart(args)?;
    let stop = (console.interrupt)()?;
    let file = args.multipliers.as_deref().map(MultiplierFile::create).transpose()?;
    let trajectory = OrbitTrajectory::open(args, trajectory_columns(model.chain().sites()))?;
    let pictures = OrbitPictures::open(args)?;
    let mut finder = Finder::new(model.chain().sites()).until(&stop);
    let (name, mut found) = which::find(&which, &model, &mut finder, Some(console))?;
    let mut solutions = Vec::new();
    for orbit in std::mem::take(&mut found.orbits) {
        // Of a large lattice the check gives back what the condition needs.
        let condition = finder.condition(&orbit)?;
        let admissibility = finder.admissibility(&orbit)?;
        // Of a large ring its work space holds more than all answers.
        let multipliers = Analyser::default().multipliers(&orbit, &mut finder, tolerance);
        let leading = multipliers.as_ref().ok().map(|all| all.verdict).filter(|v| v.mechanism.is_some());
        let modes = OrbitModes::of(&orbit, &mut finder, leading.map(|verdict| verdict.leading), args.json);
        let phases = drifting(&orbit, &mut finder, leading)?;
        // Stability that was stopped is not told as one that could not be computed.
        stop.heard().map_err(BreatherError::from)?;
        solutions.push(Solution { orbit, admissibility, condition, multipliers, modes, phases });
    }
    let text =
        if args.json { printed(&answer(&model, &solutions, &found))? } else { text(&model, &name, &solutions, &found) };
    console.answer(&text, args.json, taken)?;
    if let Some(file) = file {
        file.of_solutions(&solutions, &mut finder)?;
    }
    if let Some(mut table) = trajectory {
        for (solution, number) in solutions.iter().zip(1..) {
            let mut motion = Motion::of(&solution.orbit)?;
            table.period(number, solution.orbit.period(), |time| {
                let (displacement, velocity) = motion.state(time);
                Ok([displacement, velocity].concat())
            })?;
        }
        table.finish()?;
    }
    pictures.finish(&solutions, console)?;
    if let Some(NoBreather::NotSearched(_)) = found.completeness.reason() {
        let message = "this word cannot be searched for: whether it has orbits here is not known";
        return Err(CliError::IllPosed(message.to_owned()));
    }
    match solutions.iter().find_map(|solution| solution.multipliers.as_ref().err()) {
        Some(error) => Err(CliError::from(error.clone()).about("stability could not be computed")),
        None => Ok(()),
    }
}

/// The most masses whose eigenvectors are worked out beside the verdict: a tenth of a second.
const MOST_MASSES: usize = 100;

/// Which breathers of a word run ahead, and which fall behind, as it loses stability through +1 without force.
fn drifting(
    orbit: &Orbit,
    finder: &mut Finder,
    leading: Option<Verdict>,
) -> Result<Option<Vec<(usize, f64)>>, CliError> {
    let asked = leading.is_some_and(|verdict| verdict.mechanism == Some(Mechanism::PlusOne))
        && orbit.impact_site().is_none()
        && orbit.is_conservative()
        && orbit.model().is_some_and(|model| model.chain().sites() <= MOST_MASSES);
    let mode = if asked { leading_modes(orbit, 1)?.pop() } else { None };
    Ok(mode.map(|mode| phases(orbit, &mode, finder)).transpose()?)
}

fn complex(z: Complex<f64>) -> String {
    if z.im == 0.0 {
        format!("{}", z.re)
    } else {
        format!("{} {} {}i", z.re, if z.im < 0.0 { '-' } else { '+' }, z.im.abs())
    }
}

/// The answer for people.
fn text(model: &Model, name: &str, solutions: &[Solution], found: &OrbitList) -> String {
    let (mut out, layout) = (String::new(), model.chain().layout());
    // Writing to a String cannot fail.
    let _ = writeln!(out, "{name} breathers, {model}");
    if let Some(NoBreather::NotSearched(why)) = found.completeness.reason() {
        let _ = writeln!(out, "not searched: {why}");
        return out;
    }
    let physical = solutions.iter().filter(|solution| solution.admissibility.is_physical()).count();
    out += &told_list(found.completeness, None, [solutions.len(), physical]);
    for ended in &found.ended {
        let _ = writeln!(out, "a branch from masses without coupling ends: {}", ended.told(&layout));
    }
    for (i, solution) in solutions.iter().enumerate() {
        let orbit = &solution.orbit;
        let _ = write!(out, "\nsolution {}: period {}", i + 1, Number(orbit.period()));
        for (name, value) in [("phi", orbit.phi()), ("psi", orbit.psi())] {
            if let Some(value) = value {
                let _ = write!(out, ", {name} {}", Number(value));
            }
        }
        let _ = writeln!(out);
        for impact in orbit.impacts() {
            let _ = writeln!(out, "  impact of {}", impact.told(&layout));
        }
        let _ = writeln!(out, "  {}", solution.admissibility.told(&layout));
        let _ = match &solution.multipliers {
            Ok(Multipliers { verdict, .. }) => {
                writeln!(out, "  {}, leading multiplier {}", told_verdict(verdict), complex(verdict.leading))
            }
            Err(error) => writeln!(out, "  stability unknown: {error}"),
        };
        if let Some(phases) = &solution.phases {
            let ahead: Vec<String> =
                phases.iter().map(|(site, ahead)| format!("site {} by {ahead:.3}", layout.name(*site))).collect();
            let _ = writeln!(out, "  the breathers drift apart: ahead are {}", ahead.join(", "));
        }
        if let Some(modes) = &solution.modes {
            let _ = writeln!(out, "  {modes}");
        }
        let condition = &solution.condition;
        let _ = writeln!(
            out,
            "  residual {:.1e}; errors: impulses {}, times {} of a period",
            orbit.residual(),
            estimate(condition.impulse_error()),
            estimate(condition.time_error())
        );
        let _ = writeln!(out, "  {condition}");
    }
    out
}

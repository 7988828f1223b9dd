//! A simulation from a perturbed orbit beside the orbit (figures 11 to 13), and how fast they part or meet.

use vibrochain_breather::Motion;
use vibrochain_eventsim::{Limits, Outcome, Simulation, Time};

use crate::figures::drawn::{Drawn, Picture, Sheet};
use crate::figures::scene::LineScene;
use crate::figures::solve::{COLUMNS, RULE, computation, leading, row};
use vibrochain_cli::common::error::CliError;
use vibrochain_cli::simulate::recording::orbit_time;
use vibrochain_cli::simulate::start::{Start, leading_mode_at};
use vibrochain_lattice::Stop;
use vibrochain_plot::{Curves, Mark, Pane, Scale, Series, Stroke};

/// Samples a period of the force in the windows shown.
const SAMPLES: u64 = 64;

/// Stretches of time whose largest distances are shown.
const STRETCHES: u64 = 100;

/// The least length of a stretch, in periods: perturbations turn once in about this time or faster.
const TURN: u64 = 8;

/// Distances between which the rate of growth or decay is measured, in parts of the perturbation and of the gap: above
/// the transient of the start, below the reach of the nonlinearity.
const LINEAR: (f64, f64) = (2.0, 1e-3);

/// What the two windows show.
#[derive(Default)]
struct Window {
    simulated: Vec<(f64, f64)>,
    analytic: Vec<(f64, f64)>,
}

/// How a breather is perturbed and for how many periods it is followed; which of them are shown, from the first and from a late one on.
pub(super) struct Run {
    pub(super) perturb: f64,
    pub(super) periods: u64,
    pub(super) shown: u64,
    pub(super) late: u64,
}

/// Computes the figure.
///
/// # Errors
/// [`CliError`].
pub(super) fn draw(scene: &LineScene, run: Run, stop: &Stop) -> Result<Drawn, CliError> {
    let Run { perturb, periods, shown, late: late_from } = run;
    let nothing = || CliError::Request("a comparison needs a point".to_owned());
    let (_, _, model) = scene.curves.first().ok_or_else(nothing)?;
    let solved = leading(model, scene.family)?;
    let orbit = &solved.orbit;
    let home = orbit.impact_site().unwrap_or(0);
    let mut start = Start::on(orbit)?;
    let mode = leading_mode_at(orbit, start.time, stop)?;
    start.perturb_along(model, perturb, &mode);
    let mut simulation =
        Simulation::new(model, start.psi, &start.displacement, &start.velocity).map_err(computation)?;
    let mut motion = Motion::of(orbit)?;

    let mut sheet = Sheet::new(&["time", "simulated", "analytic", "distance"])?;
    let (mut first, mut last, mut distances) = (Window::default(), Window::default(), Vec::new());
    let (mut u, mut v) = (vec![0.0; model.chain().sites()], vec![0.0; model.chain().sites()]);
    // Masses that meet a barrier at the end of the run.
    let mut hit = vec![false; model.chain().sites()];
    let steps = periods * SAMPLES;
    for step in 0..=steps {
        let (whole, part) = (step / SAMPLES, step % SAMPLES);
        let early = step <= shown * SAMPLES;
        let late = (late_from * SAMPLES..=(late_from + shown) * SAMPLES).contains(&step);
        if part > 0 && !early && !late {
            continue;
        }
        let limits = Limits::until(Time::new(model, whole, part as f64 / SAMPLES as f64));
        let ending = step + shown * SAMPLES > steps;
        let report = simulation.run(&limits, |event| {
            if ending {
                hit[event.contact] = true;
            }
        });
        if report.outcome != Outcome::TimeReached {
            return Err(computation(format!("the simulation ended early: {:?}", report.outcome)));
        }
        if stop.is_raised() {
            return Err(CliError::Interrupted);
        }
        simulation.read(&mut u, &mut v);
        motion.at(home, orbit_time(orbit, simulation.time(), start.time));
        let (time, own) = (step as f64 / SAMPLES as f64, motion.site(home).displacement);
        let apart = u.iter().enumerate().map(|(n, u)| (u - motion.site(n).displacement).abs()).fold(0.0, f64::max);
        sheet.row(&[], &[time, u[home], own, apart])?;
        for (wanted, window) in [(early, &mut first), (late, &mut last)] {
            if wanted {
                window.simulated.push((time, u[home]));
                window.analytic.push((time, own));
            }
        }
        if part == 0 {
            distances.push((time, apart));
        }
    }

    let distances = envelope(&distances, periods);
    let radius = solved.stability.verdict.spectral_radius;
    let per_period = radius.powf(1.0 / f64::from(orbit.force_periods()));
    let measured = rate(&distances, perturb);
    let mut findings = vec![format!("| | {COLUMNS}\n|---|{RULE}\n| {} | {}", orbit.family().name(), row(&solved))];
    let over = distances.last().map_or(0.0, |point| point.1);
    findings.push(format!(
        "A push of {perturb:e} along the leading Floquet mode changes by a factor {} a period of the force in the \
         simulation; the multiplier says {per_period:.6}. After {periods} periods the largest distance of a mass from the \
         orbit is {over:.1e}; in the last {shown} periods {} of {} masses meet a barrier.",
        measured.map_or("that could not be measured".to_owned(), |rate| format!("{rate:.6}")),
        hit.iter().filter(|hit| **hit).count(),
        hit.len()
    ));
    let levels = vec![model.asymmetry() - 1.0, model.asymmetry() + 1.0];
    let window = |caption: &str, window: Window| Pane {
        caption: caption.to_owned(),
        x: "time, in periods of the force".to_owned(),
        y: "impacting mass u₀".to_owned(),
        x_range: Some(window.simulated.first().map_or(0.0, |p| p.0)..window.simulated.last().map_or(1.0, |p| p.0)),
        x_log: false,
        scale: Scale::Linear,
        levels: levels.clone(),
        uprights: Vec::new(),
        round: false,
        series: vec![
            line("analytic orbit", 1, Stroke::Solid(6), window.analytic),
            line("simulation", 0, Stroke::Solid(2), window.simulated),
        ],
    };
    let top = distances.iter().map(|point| point.1).fold(perturb, f64::max);
    // From where the distance has settled on its mode, the prediction is a straight line.
    let (from, anchor) = distances.first().copied().unwrap_or((0.0, perturb));
    let by_multiplier = |&(t, _): &(f64, f64)| (t, anchor * per_period.powf(t - from));
    let predicted = distances.iter().map(by_multiplier).take_while(|p| p.1 <= 2.0 * top);
    let growth = Pane {
        caption: "distance from the orbit".to_owned(),
        x: "time, in periods of the force".to_owned(),
        y: "largest distance of a mass".to_owned(),
        x_range: Some(0.0..periods as f64),
        x_log: false,
        scale: Scale::Logarithmic,
        levels: Vec::new(),
        uprights: Vec::new(),
        round: false,
        series: vec![
            line(&format!("by the multiplier, {per_period:.5} a period"), 1, Stroke::Dashed(4), predicted.collect()),
            line("simulation", 0, Stroke::Solid(2), distances),
        ],
    };
    let panes = vec![
        window("the first periods", first),
        window(if late_from + shown == periods { "the last periods" } else { "later" }, last),
        growth,
    ];
    let title = format!("{}; pushed by {perturb:e} along its leading Floquet mode", scene.heading());
    let picture = Curves { title, columns: 3, panes, pane: (480, 440), ..Curves::default() };
    Ok(Drawn { picture: Picture::Curves(Box::new(picture)), table: sheet.bytes()?, more: Vec::new(), findings })
}

fn line(name: &str, colour: usize, stroke: Stroke, points: Vec<(f64, f64)>) -> Series {
    Series { name: name.to_owned(), colour, stroke, mark: Mark::None, points }
}

/// The largest distance in each of about a hundred stretches of time: a complex multiplier turns its perturbation, so that
/// single distances swing.
fn envelope(distances: &[(f64, f64)], periods: u64) -> Vec<(f64, f64)> {
    let stretch = (periods / STRETCHES).max(TURN) as usize;
    let largest = |part: &[(f64, f64)]| part.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
    distances.chunks(stretch).filter(|part| part.len() == stretch).filter_map(largest).collect()
}

/// Factor per period of distances that grow or fall exponentially, by least squares on their logarithms over the part
/// where they are small.
fn rate(distances: &[(f64, f64)], perturb: f64) -> Option<f64> {
    let falls = distances.last()?.1 < perturb;
    let range = if falls { 0.0..f64::INFINITY } else { LINEAR.0 * perturb..LINEAR.1 };
    // By time, not by value: leaving out the low ones among the first would bend the line.
    let linear = distances.iter().skip_while(|p| p.1 <= range.start).take_while(|p| p.1 < range.end);
    let points: Vec<(f64, f64)> = linear.map(|&(t, d)| (t, d.ln())).collect();
    let n = points.len() as f64;
    if points.len() < 3 {
        return None;
    }
    let mean = points.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0 / n, sum.1 + p.1 / n));
    let spread = points.iter().map(|p| (p.0 - mean.0) * (p.0 - mean.0)).sum::<f64>();
    let slope = points.iter().map(|p| (p.0 - mean.0) * (p.1 - mean.1)).sum::<f64>() / spread;
    slope.is_finite().then(|| slope.exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_is_that_of_the_small_distances() {
        let grown: Vec<_> = (0..200).map(|k| (f64::from(k), (1e-6 * 1.1_f64.powi(k)).min(0.5))).collect();
        assert!((rate(&grown, 1e-6).unwrap() - 1.1).abs() < 1e-12);
        let fallen: Vec<_> = (0..200).map(|k| (f64::from(k), 1e-3 * 0.98_f64.powi(k))).collect();
        assert!((rate(&fallen, 1e-3).unwrap() - 0.98).abs() < 1e-12);
        assert_eq!((rate(&grown[..2], 1e-6), rate(&[], 1.0)), (None, None));
    }
}

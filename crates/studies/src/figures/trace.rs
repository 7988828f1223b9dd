//! The impacting mass over one period (figures 3 and 7).

use vibrochain_breather::{Motion, Orbit};

use crate::figures::drawn::{Drawn, Picture, Sheet};
use crate::figures::scene::LineScene;
use crate::figures::solve::{COLUMNS, RULE, leading, row};
use vibrochain_cli::common::error::CliError;
use vibrochain_plot::{Curves, Mark, Pane, Scale, Series, Stroke};

/// Steps of a trace, a few pixels each.
const SAMPLES: usize = 240;

/// Time and displacement, velocity of the impacting mass over one period, the impacts among them (there just after).
pub(super) fn samples(orbit: &Orbit) -> Result<Vec<[f64; 3]>, CliError> {
    let mut motion = Motion::of(orbit)?;
    let home = orbit.impact_site().unwrap_or(0);
    let mut times: Vec<f64> = (0..=SAMPLES).map(|k| k as f64 / SAMPLES as f64 * orbit.period()).collect();
    times.extend(orbit.impacts().iter().map(|impact| impact.time));
    times.sort_by(f64::total_cmp);
    times.dedup();
    let at = |time: f64| {
        let now = motion.at(home, time);
        [time, now.displacement, now.velocity]
    };
    Ok(times.into_iter().map(at).collect())
}

/// Colour and line by curve.
pub(super) const STYLES: [(usize, Stroke); 4] =
    [(0, Stroke::Solid(2)), (1, Stroke::Solid(3)), (2, Stroke::Dashed(3)), (3, Stroke::Dashed(2))];

/// A trace in periods as a series, its second impact marked by `shape`.
pub(super) fn series(orbit: &Orbit, name: &str, index: usize, samples: &[[f64; 3]]) -> Vec<Series> {
    let (colour, stroke) = STYLES[index % STYLES.len()];
    let period = orbit.period();
    let points = samples.iter().map(|[t, v, _]| (t / period, *v)).collect();
    let mut all = vec![Series { name: name.to_owned(), colour, stroke, mark: Mark::None, points }];
    let second = orbit.impacts().get(1).and_then(|impact| samples.iter().find(|sample| sample[0] == impact.time));
    if let Some([t, v, _]) = second {
        let (stroke, mark) = (Stroke::None, Mark::Filled(index));
        all.push(Series { name: String::new(), colour, stroke, mark, points: vec![(t / period, *v)] });
    }
    all
}

/// Computes the figure.
///
/// # Errors
/// [`CliError::Computation`].
pub(super) fn draw(scene: &LineScene) -> Result<Drawn, CliError> {
    let mut sheet = Sheet::new(&["curve", "time", "displacement", "velocity"])?;
    let mut lines = vec![format!("| curve | {COLUMNS} (φ − T/2)/T |\n|---|{RULE}---|")];
    let mut all = Vec::new();
    for (i, (label, _, model)) in scene.curves.iter().enumerate() {
        let solved = leading(model, scene.family)?;
        let samples = samples(&solved.orbit)?;
        for numbers in &samples {
            sheet.row(&[label], numbers)?;
        }
        all.extend(series(&solved.orbit, label, i, &samples));
        let shift = solved.orbit.phi().map(|phi| phi / solved.orbit.period() - 0.5);
        let shift = shift.map_or(String::new(), |shift| format!("{shift:.6}"));
        lines.push(format!("| {label} | {} {shift} |", row(&solved)));
    }
    let pane = Pane {
        caption: String::new(),
        x: "time t/T".to_owned(),
        y: "impacting mass u₀".to_owned(),
        x_range: Some(0.0..1.0),
        x_log: false,
        scale: Scale::Linear,
        levels: Vec::new(),
        uprights: Vec::new(),
        round: false,
        series: all,
    };
    let picture =
        Curves { title: scene.heading(), panes: vec![pane], columns: 1, pane: (900, 480), ..Curves::default() };
    let findings = vec![lines.join("\n")];
    Ok(Drawn { picture: Picture::Curves(Box::new(picture)), table: sheet.bytes()?, more: Vec::new(), findings })
}

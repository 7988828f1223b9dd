//! Displacements of all masses at the impacts (figures 1, 2, 4, 5, 6, 8).

use vibrochain_breather::{LatticeOrbit, Motion, Orbit};
use vibrochain_lattice::Spectrum;

use crate::figures::drawn::{Drawn, Picture, Sheet};
use crate::figures::scene::LineScene;
use crate::figures::solve::{COLUMNS, RULE, leading, row};
use vibrochain_cli::common::caption::beside;
use vibrochain_cli::common::error::CliError;
use vibrochain_plot::{Curves, Mark, Pane, Scale, Series, Stroke};

/// Two instants and their names: the impacts, or the only impact and half a period later.
fn instants(orbit: &Orbit) -> Vec<(String, f64)> {
    let impacts = orbit.impacts();
    let at = |i: usize| (format!("at the impact on the {} barrier", impacts[i].barrier.name()), impacts[i].time);
    match impacts.len() {
        1 => vec![at(0), ("half a period after the impact".to_owned(), 0.5 * orbit.period())],
        many => (0..many).map(at).collect(),
    }
}

/// Computes the figure.
///
/// # Errors
/// [`CliError::Computation`].
pub(super) fn draw(scene: &LineScene, reach: Option<i64>) -> Result<Drawn, CliError> {
    let mut sheet = Sheet::new(&["curve", "instant", "time", "offset", "displacement"])?;
    let mut panes: Vec<Pane> = Vec::new();
    let mut lines = vec![format!("| curve | {COLUMNS} farthest mass |\n|---|{RULE}---|")];
    let mut profiles: Vec<Vec<Vec<f64>>> = Vec::new();
    for (i, (label, _, model)) in scene.curves.iter().enumerate() {
        let solved = leading(model, scene.family)?;
        let mut motion = Motion::of(&solved.orbit)?;
        let sites = motion.sites() as i64;
        let mut of_curve = Vec::new();
        for (k, (instant, time)) in instants(&solved.orbit).into_iter().enumerate() {
            let v = motion.displacements(time);
            let shown = reach.unwrap_or(sites);
            let offsets = (-(sites - 1) / 2..=sites / 2).filter(|n| n.abs() <= shown);
            let points: Vec<(f64, f64)> = offsets.map(|n| (n as f64, v[n.rem_euclid(sites) as usize])).collect();
            for (n, displacement) in &points {
                sheet.row(&[label, &instant], &[time, *n, *displacement])?;
            }
            if panes.len() <= k {
                panes.push(Pane {
                    caption: instant,
                    x: "site n, from the impacting mass".to_owned(),
                    y: "displacement uₙ".to_owned(),
                    x_range: None,
                    x_log: false,
                    scale: Scale::Linear,
                    levels: Vec::new(),
                    uprights: Vec::new(),
                    round: false,
                    series: Vec::new(),
                });
            }
            let pane = &mut panes[k];
            for level in [model.asymmetry() - 1.0, model.asymmetry() + 1.0] {
                if scene.curves.iter().all(|(_, _, other)| other.asymmetry() == model.asymmetry())
                    && !pane.levels.contains(&level)
                {
                    pane.levels.push(level);
                }
            }
            let name = if label.is_empty() { String::new() } else { label.clone() };
            let (stroke, mark) = STYLES[i % STYLES.len()];
            pane.series.push(Series { name, colour: i, stroke, mark, points });
            of_curve.push(v);
        }
        let far = farthest(solved.orbit.lattice()?, of_curve.first().map_or(&[], Vec::as_slice));
        lines.push(format!("| {} | {} {far:.3e} |", if label.is_empty() { "" } else { label }, row(&solved)));
        profiles.push(of_curve);
    }
    let mut findings = vec![lines.join("\n")];
    if let Some(difference) = difference(&profiles) {
        findings.push(difference);
    }
    let picture = Curves { title: scene.heading(), columns: panes.len(), panes, pane: (600, 440), ..Curves::default() };
    Ok(Drawn { picture: Picture::Curves(Box::new(picture)), table: sheet.bytes()?, more: Vec::new(), findings })
}

/// Displacement at the first impact of the mass farthest from the breather, `v` those of all masses: next to nothing where no force
/// moves it, of which only harmonics have digits.
fn farthest(orbit: LatticeOrbit<'_>, v: &[f64]) -> f64 {
    let (n, chain) = (v.len() / 2, orbit.model().chain());
    match orbit.impacts().first() {
        // A ring that nothing holds has a place as well as a motion.
        Some(impact) if n > 0 && chain.gamma1() > 0.0 => {
            let uniform = orbit.steady().at(impact.site).value(impact.time + orbit.psi().unwrap_or(0.0));
            uniform + beside(orbit, &Spectrum::new(*chain), n, impact.time)
        }
        _ => v.get(n).copied().unwrap_or_default(),
    }
}

/// Lines and points by curve: told apart without colour.
const STYLES: [(Stroke, Mark); 3] =
    [(Stroke::Solid(2), Mark::Filled(0)), (Stroke::Dashed(2), Mark::Hollow(3)), (Stroke::Solid(1), Mark::Hollow(1))];

/// How far rings of different lengths are apart, on the sites they share.
fn difference(profiles: &[Vec<Vec<f64>>]) -> Option<String> {
    let (short, long) = (profiles.first()?, profiles.last()?);
    let (m, n) = (short.first()?.len(), long.first()?.len());
    if m == n {
        return None;
    }
    let mut apart = (0.0_f64, 0);
    for (a, b) in short.iter().zip(long) {
        for offset in -(m as i64 / 2)..=m as i64 / 2 {
            let d = (a[offset.rem_euclid(m as i64) as usize] - b[offset.rem_euclid(n as i64) as usize]).abs();
            if d > apart.0 {
                apart = (d, offset.abs());
            }
        }
    }
    Some(format!(
        "Largest difference between the displacements on the two rings at the impacts: {:.2e}, {} sites from the breather.",
        apart.0, apart.1
    ))
}

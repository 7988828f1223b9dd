//! All solutions at one point (figure 9): their traces, the curve a(φ) they are the zeros of, and what becomes of them as
//! one more parameter changes.

use vibrochain_breather::Family;
use vibrochain_lattice::{ImpulseResponse, Model, Parameter, Point, Spectrum, Stop};

use crate::figures::drawn::{Drawn, Picture, Sheet};
use crate::figures::scene::LineScene;
use crate::figures::solve::{COLUMNS, RULE, Solved, physical, row};
use crate::figures::trace;
use crate::forms::{Kernels, Reading, double_sided};
use vibrochain_cli::common::error::CliError;
use vibrochain_plot::{Curves, Mark, Pane, Scale, Series, Stroke};

/// Values of φ at which a(φ) is drawn.
const PHASES: usize = 1200;

/// Asymmetries beyond this have no gap to be centred in.
const ASYMMETRY: f64 = 1.0;

/// Of unstable solutions those at one value of so many are drawn: their marks are larger than the distance of two values.
const SPARSE: usize = 3;

/// Halvings of an interval in which the number of solutions changes; below 1e-11 of it two solutions are one to rounding.
const HALVINGS: u32 = 36;

/// A parameter that varies, between these ends, and its number of values.
#[derive(Clone, Copy)]
pub(super) struct Over {
    pub(super) parameter: Parameter,
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) count: usize,
}

/// Computes the figure.
///
/// # Errors
/// [`CliError`].
pub(super) fn draw(scene: &LineScene, over: Over, stop: &Stop) -> Result<Drawn, CliError> {
    let nothing = || CliError::Request("a figure of solutions needs a point".to_owned());
    let (_, point, model) = scene.curves.first().ok_or_else(nothing)?;
    let solved = physical(model, scene.family)?;
    let mut sheet = Sheet::new(&["solution", "time", "displacement", "velocity"])?;
    let mut lines = vec![format!("| solution | {COLUMNS}\n|---|{RULE}")];
    let mut traces = Vec::new();
    for (i, solved) in solved.iter().enumerate() {
        let number = (i + 1).to_string();
        let samples = trace::samples(&solved.orbit)?;
        for numbers in &samples {
            sheet.row(&[&number], numbers)?;
        }
        let state = if solved.stability.verdict.stable { "stable" } else { "unstable" };
        traces.extend(trace::series(&solved.orbit, &format!("{number}: {state}"), i, &samples));
        lines.push(format!("| {number} | {}", row(solved)));
    }
    let mut findings = vec![lines.join("\n")];
    let whole = Some(0.0..1.0);
    let first = pane("the impacting mass over a period", "time t/T", "impacting mass u₀", Scale::Linear, traces);
    let mut panes = vec![Pane { x_range: whole.clone(), ..first }];
    let mut more = Vec::new();
    if scene.family == Family::DoubleSided {
        let (series, table) = asymmetry(model, &solved)?;
        let scale = Scale::Between(-ASYMMETRY..ASYMMETRY);
        let mut pane = pane("asymmetry that a time φ belongs to", "second impact φ/T", "asymmetry a(φ)", scale, series);
        (pane.levels, pane.x_range) = (vec![model.asymmetry()], whole);
        panes.push(pane);
        more.push(("-asymmetry", table));
    }
    let Branches { series, table, findings: found } = branches(point, scene.family, over, stop)?;
    let name = format!("{} {}", over.parameter.meaning(), over.parameter.symbol());
    panes.push(pane("solutions and their stability", &name, "second impact φ/T", Scale::Linear, series));
    more.push(("-branches", table));
    findings.extend(found);
    let picture = Curves { title: scene.heading(), columns: panes.len(), panes, pane: (480, 460), ..Curves::default() };
    Ok(Drawn { picture: Picture::Curves(Box::new(picture)), table: sheet.bytes()?, more, findings })
}

fn pane(caption: &str, x: &str, y: &str, scale: Scale, series: Vec<Series>) -> Pane {
    let (caption, x, y) = (caption.to_owned(), x.to_owned(), y.to_owned());
    Pane {
        caption,
        x,
        y,
        x_range: None,
        x_log: false,
        scale,
        levels: Vec::new(),
        uprights: Vec::new(),
        round: false,
        series,
    }
}

/// Both branches of a(φ), and the solutions on them.
fn asymmetry(model: &Model, solved: &[Solved]) -> Result<(Vec<Series>, Vec<u8>), CliError> {
    let response = ImpulseResponse::new(&Spectrum::new(*model.chain()), model.omega())?;
    let force = model.force_response()?;
    let mut sheet = Sheet::new(&["branch", "phi", "asymmetry"])?;
    let mut all = Vec::new();
    let branches = [(1.0, "branch +", Stroke::Solid(2)), (-1.0, "branch −", Stroke::Dashed(2))];
    for (index, (sign, name, stroke)) in branches.into_iter().enumerate() {
        let mut points = Vec::new();
        for k in 1..PHASES {
            let part = k as f64 / PHASES as f64;
            let phi = part * model.period();
            let kernels = Kernels::at(&response, phi);
            let form = double_sided(&kernels, model, force, phi, sign, Reading::Mended);
            let a = form.map_or(f64::NAN, |form| form.asymmetry);
            points.push((part, if a.abs() <= ASYMMETRY { a } else { f64::NAN }));
            sheet.row(&[name], &[phi, a])?;
        }
        all.push(Series { name: name.to_owned(), colour: index, stroke, mark: Mark::None, points });
    }
    let marks =
        solved.iter().filter_map(|solved| Some((solved.orbit.phi()? / solved.orbit.period(), model.asymmetry())));
    let (name, stroke, mark) = ("solutions".to_owned(), Stroke::None, Mark::Hollow(0));
    all.push(Series { name, colour: 4, stroke, mark, points: marks.collect() });
    Ok((all, sheet.bytes()?))
}

/// A panel, its table, and what was found.
struct Branches {
    series: Vec<Series>,
    table: Vec<u8>,
    findings: Vec<String>,
}

/// φ of all physical solutions over a parameter.
fn branches(point: &Point, family: Family, over: Over, stop: &Stop) -> Result<Branches, CliError> {
    let Over { parameter, from, to, count } = over;
    let at = |value: f64| -> Result<Vec<Solved>, CliError> {
        physical(&point.with(parameter, value).model().map_err(|error| CliError::Request(error.to_string()))?, family)
    };
    let mut sheet = Sheet::new(&["verdict", parameter.name(), "phi", "spectral_radius"])?;
    let (mut stable, mut unstable, mut findings) = (Vec::new(), Vec::new(), Vec::new());
    let mut previous: Option<(f64, usize)> = None;
    for i in 0..count {
        let value = if i + 1 == count { to } else { from + i as f64 * (to - from) / (count - 1) as f64 };
        if stop.is_raised() {
            return Err(CliError::Interrupted);
        }
        let solved = at(value)?;
        for solved in &solved {
            let verdict = solved.stability.verdict;
            let time = solved.orbit.impacts().last().map_or(0.0, |impact| impact.time);
            let word = verdict.mechanism.map_or(if verdict.stable { "stable" } else { "undecided" }, |m| m.name());
            sheet.row(&[word], &[value, time, verdict.spectral_radius])?;
            let point = (value, time / solved.orbit.period());
            if verdict.stable {
                stable.push(point);
            } else if i.is_multiple_of(SPARSE) {
                unstable.push(point);
            }
        }
        if let Some((earlier, before)) = previous
            && before != solved.len()
        {
            let (mut low, mut high) = (earlier, value);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if at(middle)?.len() == before { low = middle } else { high = middle }
            }
            findings.push(format!(
                "The number of physical solutions changes from {before} to {} at {} = {:.9}.",
                solved.len(),
                parameter.symbol(),
                0.5 * (low + high)
            ));
        }
        previous = Some((value, solved.len()));
    }
    let series = |name: &str, colour, mark, points| {
        let name = name.to_owned();
        Series { name, colour, stroke: Stroke::None, mark, points }
    };
    // What lies on top shows inside of what is hollow: symmetric solutions, stable and unstable ones, have one φ.
    let series = vec![series("unstable", 1, Mark::Hollow(3), unstable), series("stable", 0, Mark::Small(0), stable)];
    Ok(Branches { series, table: sheet.bytes()?, findings })
}

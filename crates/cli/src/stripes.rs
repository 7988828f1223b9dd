//! `mapgen stripes`: where each stripe of instability begins and ends in each row of a conservative map, and how strong it is.

use std::fmt::Write as _;
use std::path::Path;

use rayon::ThreadPool;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use vibrochain_breather::{BreatherError, Family};
use vibrochain_floquet::{NoStripe, Stripe, StripeEnd, StripeFinder, StripeLine, StripeRow};
use vibrochain_lattice::{Parameter, Stop};
use vibrochain_maps::files::{CsvFile, distinct};
use vibrochain_maps::numbers::Number;
use vibrochain_maps::scene::{Axis, Scene, Values};

use crate::args::StripesArgs;
use crate::common::console::Console;
use crate::common::error::CliError;
use crate::common::progress::counter;
use crate::common::threads::threads;
use crate::structures;

const HEADER: &str =
    "family,gamma2,mode1,mode2,harmonic,centre,error,lower,upper,lower_end,upper_end,width,growth,resolved";

/// Points a unit of ω at which a row is looked at, and at least so many in a cell: breathers that are physical over a shorter stretch are
/// not seen.
const DENSITY: f64 = 1500.0;
const IN_A_CELL: usize = 2;

/// Rows computed before they are written, for each thread.
const ROWS: usize = 4;

/// The most pairs of modes that are looked at, at all points together: some nanoseconds each, an hour.
const MOST_PAIRS: u64 = 1_000_000_000_000;

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &StripesArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    structures::refuse_scene(&args.scene)?;
    let rows = StripeRows::read(&args.scene)?;
    rows.afford().map_err(|what| CliError::Request(format!("{}: {what}", args.scene.display())))?;
    let taken = distinct(&[("the scene", Some(&args.scene))], &[("--out", args.out.as_deref())])?;
    let stop = (console.interrupt)()?;
    let table = args.out.as_deref().map(|path| CsvFile::create("--out", path, HEADER.split(','))).transpose()?;
    let text = rows.write(table, &threads(console.threads)?, &stop, console.progress)?;
    console.answer(&text, false, taken)
}

/// Equally spaced values.
#[derive(Debug, Clone, Copy)]
pub struct Steps {
    /// The first value.
    pub first: f64,
    /// From one to the next.
    pub step: f64,
    /// How many there are.
    pub points: usize,
}

impl Steps {
    fn of(axis: &Axis) -> Option<Self> {
        match axis.values {
            Values::Linear { from, to, points } => {
                Some(Self { first: from, step: (to - from) / (points - 1) as f64, points })
            }
            _ => None,
        }
    }

    /// The value at a place between the points, in steps.
    pub fn value(&self, place: f64) -> f64 {
        self.first + place * self.step
    }
}

/// The rows of a conservative scene over ω and γ₂.
#[derive(Debug)]
pub struct StripeRows {
    /// The scene.
    pub scene: Scene,
    /// Its axis x.
    pub omega: Steps,
    /// Its axis y.
    pub gamma2: Steps,
}

impl StripeRows {
    /// Reads a scene.
    ///
    /// # Errors
    /// [`CliError::Request`].
    pub fn read(path: &Path) -> Result<Self, CliError> {
        let scene = Scene::read(path)?;
        let wrong = |what: &str| CliError::Request(format!("{}: {what}", path.display()));
        ensure!(
            scene.is_conservative(),
            wrong("stripes are collisions of modes without loss: give a scene without force and with elastic impacts")
        );
        let axes = scene.plane().filter(|[x, y]| x.parameter == Parameter::Omega && y.parameter == Parameter::Gamma2);
        let Some([x, y]) = axes else {
            return Err(wrong(
                "stripes are told over frequency and coupling: give a scene with x = omega and y = gamma2",
            ));
        };
        let (Some(omega), Some(gamma2)) = (Steps::of(x), Steps::of(y)) else {
            return Err(wrong("stripes are told over equally spaced cells: give both axes by from, to and points"));
        };
        Ok(Self { scene, omega, gamma2 })
    }

    /// Number of a cell.
    pub fn cell(&self, row: usize, column: usize) -> usize {
        row * self.omega.points + column
    }

    /// The range of ω, and how many points of a row are looked at.
    fn looks(&self) -> ((f64, f64), usize) {
        let ends = [0, self.omega.points - 1].map(|column| self.omega.value(column as f64));
        let points = ((ends[1] - ends[0]).abs() * DENSITY) as usize + IN_A_CELL * self.omega.points;
        ((ends[0].min(ends[1]), ends[0].max(ends[1])), points)
    }

    /// Refuses what would take hours.
    fn afford(&self) -> Result<(), String> {
        let model = self.scene.point(0).model().map_err(|error| error.to_string())?;
        let modes = model.chain().even_modes() as u64;
        let looks = (self.gamma2.points as u64).saturating_mul(self.looks().1 as u64);
        // Half of all k, l, of both families.
        if modes.saturating_mul(modes).saturating_mul(looks) <= MOST_PAIRS {
            return Ok(());
        }
        let sites = self.scene.base.sites();
        let most = if self.scene.base.layout.is_ring() { 2 } else { 1 } * (MOST_PAIRS / looks).isqrt();
        let few = if most > 2 { format!("at most {} sites, or ", most - 1) } else { String::new() };
        Err(format!(
            "every pair of the modes of {sites} masses at each of {looks} points is too much: give {few}fewer points or a shorter range"
        ))
    }
}

/// What is told of the stripes of a family.
#[derive(Debug, Clone, Copy)]
struct Summary {
    family: Family,
    rows: usize,
    stripes: usize,
    below_a_cell: usize,
    /// Of those with both edges.
    widths: [f64; 2],
    growth: f64,
    untold: usize,
}

impl Summary {
    fn new(family: Family) -> Self {
        let widths = [f64::INFINITY, 0.0];
        Self { family, rows: 0, stripes: 0, below_a_cell: 0, widths, growth: 0.0, untold: 0 }
    }

    fn add(&mut self, row: &StripeRow, cell: f64) {
        self.rows += usize::from(!row.stripes.is_empty());
        self.stripes += row.stripes.len();
        self.untold += row.unresolved.len();
        for stripe in &row.stripes {
            self.growth = self.growth.max(stripe.growth);
            if stripe.ends == [StripeEnd::Edge; 2] {
                let width = 2.0 * stripe.half_width;
                self.below_a_cell += usize::from(width < cell);
                self.widths = [self.widths[0].min(width), self.widths[1].max(width)];
            }
        }
    }
}

/// The table that is printed.
fn text(all: &[Summary]) -> String {
    let mut text = format!(
        "stripes       {:>12} {:>16} {:>16} {:>16} {:>16} {:>16} {:>16}\n",
        "rows", "in all", "below a cell", "narrowest", "widest", "largest growth", "not told"
    );
    for Summary { family, rows, stripes, below_a_cell, widths: [least, most], growth, untold } in all {
        let told =
            |value: &f64| if value.is_finite() && *value > 0.0 { format!("{value:.2e}") } else { "-".to_owned() };
        let [least, most, growth] = [least, most, growth].map(told);
        let _ = writeln!(
            text,
            "  {:<12}{rows:>12} {stripes:>16} {below_a_cell:>16} {least:>16} {most:>16} {growth:>16} {untold:>16}",
            family.name()
        );
    }
    text
}

impl StripeRows {
    /// Writes the stripes of all rows, row by row, and sums them up.
    ///
    /// # Errors
    /// [`CliError::Interrupted`], and what a full disk makes.
    fn write(
        &self,
        mut table: Option<CsvFile>,
        pool: &ThreadPool,
        stop: &Stop,
        progress: bool,
    ) -> Result<String, CliError> {
        let bar = counter(self.gamma2.points as u64, 0, "rows", progress);
        let mut all: Vec<Summary> = Vec::new();
        let rows: Vec<usize> = (0..self.gamma2.points).collect();
        for some in rows.chunks(ROWS * pool.current_num_threads()) {
            let found: Result<Vec<_>, CliError> = pool.install(|| {
                let one = |row: &usize| self.row(*row, stop).inspect(|_| bar.inc(1));
                some.into_par_iter().map(one).collect()
            });
            for (row, families) in some.iter().zip(found?) {
                for (family, stripes) in families {
                    if !all.iter().any(|summary| summary.family == family) {
                        all.push(Summary::new(family));
                    }
                    let step = self.omega.step.abs();
                    all.iter_mut()
                        .filter(|summary| summary.family == family)
                        .for_each(|summary| summary.add(&stripes, step));
                    if let Some(table) = &mut table {
                        record(table, family.name(), &number(self.gamma2.value(*row as f64)), &stripes)?;
                    }
                }
            }
        }
        bar.finish_and_clear();
        table.map(CsvFile::finish).transpose()?;
        Ok(text(&all))
    }

    fn row(&self, row: usize, stop: &Stop) -> Result<Vec<(Family, StripeRow)>, CliError> {
        let (range, points) = self.looks();
        let Ok(model) = self.scene.point(self.cell(row, 0) as u64).model() else { return Ok(Vec::new()) };
        let mut finder = StripeFinder::until(stop);
        let mut found = Vec::new();
        for family in self.scene.task.families.iter().copied() {
            if !matches!(family, Family::DoubleSided | Family::SingleSided) {
                continue;
            }
            let line = StripeLine { model, family, free: Parameter::Omega };
            match finder.along(&line, range, points) {
                Ok(stripes) => found.push((family, stripes)),
                Err(NoStripe::Breather(BreatherError::Stopped(_))) => return Err(CliError::Interrupted),
                Err(error @ (NoStripe::Parameter(_) | NoStripe::NotConservative)) => {
                    return Err(CliError::Request(error.to_string()));
                }
                Err(error) => return Err(CliError::Computation(error.to_string())),
            }
        }
        Ok(found)
    }
}

/// Writes the stripes of one family in one row.
fn record(table: &mut CsvFile, name: &str, gamma2: &str, row: &StripeRow) -> Result<(), CliError> {
    for Stripe { pair, centre, error, edges, ends, half_width, growth, resolved, .. } in &row.stripes {
        let (k, l, j) = pair.map_or((None, None, None), |((k, l), j)| (Some(k), Some(l), Some(j)));
        let [centre, error, width, growth] = [*centre, *error, 2.0 * half_width, *growth].map(number);
        let ([low, high], [from, to]) = (edges.map(number), ends.map(end));
        table.record(&(name, gamma2, k, l, j, centre, error, low, high, from, to, width, growth, resolved))?;
    }
    for edges in &row.unresolved {
        let [low, high] = edges.map(number);
        table.record(&(name, gamma2, "", "", "", "", "", low, high, "", "", "", "", false))?;
    }
    Ok(())
}

fn number(value: f64) -> String {
    Number(value).to_string()
}

fn end(end: StripeEnd) -> &'static str {
    match end {
        StripeEnd::Edge => "edge",
        StripeEnd::Open => "open",
    }
}

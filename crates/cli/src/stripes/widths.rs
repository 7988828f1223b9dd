//! The table of stripes: where each begins and ends in each row of the map, and how strong it is.

use std::fmt::Write as _;

use indicatif::ProgressBar;
use rayon::ThreadPool;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use vibrochain_breather::{BreatherError, Family};
use vibrochain_floquet::{NoStripe, Stripe, StripeEnd, StripeFinder, StripeLine, StripeRow};
use vibrochain_lattice::{Parameter, Stop};
use vibrochain_maps::files::CsvFile;
use vibrochain_maps::numbers::Number;

use crate::common::error::CliError;
use crate::common::progress::counter;
use crate::stripes::request::Request;

pub(super) const HEADER: &str =
    "family,gamma2,mode1,mode2,harmonic,centre,error,lower,upper,lower_end,upper_end,width,growth,resolved";

/// Points a unit of ω at which a row is looked at, and at least so many in a cell: breathers that are physical over a shorter stretch are
/// not seen.
const DENSITY: f64 = 1500.0;
const IN_A_CELL: usize = 2;

/// Rows computed before they are written, for each thread.
const ROWS: usize = 4;

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
        "\nstripes       {:>12} {:>16} {:>16} {:>16} {:>16} {:>16} {:>16}\n",
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

/// How many rows are done, for people.
pub(super) fn progress(request: &Request, wanted: bool) -> ProgressBar {
    counter(request.gamma2.points as u64, 0, "rows", wanted)
}

/// Writes the stripes of all rows, row by row, and sums them up.
///
/// # Errors
/// [`CliError::Interrupted`], and what a full disk makes.
pub(super) fn write(
    mut table: CsvFile,
    request: &Request,
    pool: &ThreadPool,
    stop: &Stop,
    bar: &ProgressBar,
) -> Result<String, CliError> {
    let mut all: Vec<Summary> = Vec::new();
    let rows: Vec<usize> = (0..request.gamma2.points).collect();
    for some in rows.chunks(ROWS * pool.current_num_threads()) {
        let found: Result<Vec<_>, CliError> = pool.install(|| {
            let one = |row: &usize| of_row(request, *row, stop).inspect(|_| bar.inc(1));
            some.into_par_iter().map(one).collect()
        });
        for (row, families) in some.iter().zip(found?) {
            let gamma2 = number(request.gamma2.value(*row as f64));
            for (family, row) in families {
                if !all.iter().any(|summary| summary.family == family) {
                    let widths = [f64::INFINITY, 0.0];
                    all.push(Summary { family, rows: 0, stripes: 0, below_a_cell: 0, widths, growth: 0.0, untold: 0 });
                }
                all.iter_mut()
                    .filter(|summary| summary.family == family)
                    .for_each(|summary| summary.add(&row, request.omega.step.abs()));
                let name = family.name();
                for Stripe { pair, centre, error, edges, ends, half_width, growth, resolved, .. } in &row.stripes {
                    let (k, l, j) = pair.map_or((None, None, None), |((k, l), j)| (Some(k), Some(l), Some(j)));
                    let [centre, error, width, growth] = [*centre, *error, 2.0 * half_width, *growth].map(number);
                    let ([low, high], [from, to]) = (edges.map(number), ends.map(end));
                    table.record(&(
                        name, &gamma2, k, l, j, centre, error, low, high, from, to, width, growth, resolved,
                    ))?;
                }
                for edges in row.unresolved {
                    let [low, high] = edges.map(number);
                    table.record(&(name, &gamma2, "", "", "", "", "", low, high, "", "", "", "", false))?;
                }
            }
        }
    }
    bar.finish_and_clear();
    table.finish()?;
    Ok(text(&all))
}

fn of_row(request: &Request, row: usize, stop: &Stop) -> Result<Vec<(Family, StripeRow)>, CliError> {
    let ends = [0, request.omega.points - 1].map(|column| request.omega.value(column as f64));
    let points = ((ends[1] - ends[0]).abs() * DENSITY) as usize + IN_A_CELL * request.omega.points;
    let Ok(model) = request.scene.point(request.cell(row, 0) as u64).model() else { return Ok(Vec::new()) };
    let mut finder = StripeFinder::until(stop);
    let mut found = Vec::new();
    for family in request.scene.task.families.iter().copied() {
        if !matches!(family, Family::DoubleSided | Family::SingleSided) {
            continue;
        }
        let line = StripeLine { model, family, free: Parameter::Omega };
        match finder.along(&line, (ends[0].min(ends[1]), ends[0].max(ends[1])), points) {
            Ok(stripes) => found.push((family, stripes)),
            Err(NoStripe::Breather(BreatherError::Stopped)) => return Err(CliError::Interrupted),
            Err(error @ (NoStripe::Parameter(_) | NoStripe::NotConservative)) => {
                return Err(CliError::Request(error.to_string()));
            }
            Err(error) => return Err(CliError::Computation(error.to_string())),
        }
    }
    Ok(found)
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

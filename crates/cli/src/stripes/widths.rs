//! The table of stripes: where each begins and ends in each row of the map, and how strong it is.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::ThreadPool;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use vibrochain_breather::Family;
use vibrochain_floquet::{NoStripe, Stripe, StripeEnd, StripeFinder, StripeLine, StripeRow};
use vibrochain_maps::files::CsvFile;
use vibrochain_maps::point::Parameter;

use crate::error::CliError;
use crate::stripes::request::Request;

pub(super) const HEADER: [&str; 14] = [
    "family",
    "gamma2",
    "mode1",
    "mode2",
    "harmonic",
    "centre",
    "error",
    "lower",
    "upper",
    "lower_end",
    "upper_end",
    "width",
    "growth",
    "resolved",
];

/// Points a unit of ω at which a row is looked at, and at least so many in a cell: breathers that are physical over a shorter stretch are
/// not seen.
const DENSITY: f64 = 1500.0;
const IN_A_CELL: usize = 2;

/// Rows computed before they are written, for each thread.
const ROWS: usize = 4;

/// Writes the stripes of all rows, row by row.
///
/// # Errors
/// [`CliError::Interrupted`], and what a full disk makes.
pub(super) fn write(
    mut table: CsvFile,
    request: &Request,
    pool: &ThreadPool,
    stop: &AtomicBool,
) -> Result<(), CliError> {
    let rows: Vec<usize> = (0..request.gamma2.points).collect();
    for some in rows.chunks(ROWS * pool.current_num_threads()) {
        let found: Result<Vec<_>, CliError> =
            pool.install(|| some.into_par_iter().map(|row| of_row(request, *row, stop)).collect());
        for (row, families) in some.iter().zip(found?) {
            let gamma2 = request.gamma2.value(*row as f64).to_string();
            for (family, StripeRow { stripes, unresolved }) in families {
                for stripe in &stripes {
                    table.row(of_stripe(family, &gamma2, stripe))?;
                }
                for [low, high] in unresolved {
                    let [low, high, empty] = [low.to_string(), high.to_string(), String::new()];
                    let mut fields = vec![family.name().to_owned(), gamma2.clone()];
                    fields.extend(std::iter::repeat_n(empty.clone(), 5).chain([low, high]));
                    fields.extend(std::iter::repeat_n(empty, 4).chain(["false".to_owned()]));
                    table.row(fields)?;
                }
            }
        }
    }
    Ok(table.finish()?)
}

fn of_row(request: &Request, row: usize, stop: &AtomicBool) -> Result<Vec<(Family, StripeRow)>, CliError> {
    let ends = [0, request.omega.points - 1].map(|column| request.omega.value(column as f64));
    let points = ((ends[1] - ends[0]).abs() * DENSITY) as usize + IN_A_CELL * request.omega.points;
    let Ok(model) = request.scene.point(request.cell(row, 0) as u64).model() else { return Ok(Vec::new()) };
    let mut finder = StripeFinder::default();
    let mut found = Vec::new();
    for family in request.scene.task.families.iter().copied() {
        if !matches!(family, Family::DoubleSided | Family::SingleSided) {
            continue;
        }
        let line = StripeLine { model, family, free: Parameter::Omega };
        let going = || !stop.load(Ordering::Relaxed);
        match finder.along_while(&line, (ends[0].min(ends[1]), ends[0].max(ends[1])), points, going) {
            Ok(Some(stripes)) => found.push((family, stripes)),
            Ok(None) => return Err(CliError::Interrupted),
            Err(error @ (NoStripe::Parameter(_) | NoStripe::NotConservative)) => {
                return Err(CliError::Request(error.to_string()));
            }
            Err(error) => return Err(CliError::Computation(error.to_string())),
        }
    }
    Ok(found)
}

fn of_stripe(family: Family, gamma2: &str, stripe: &Stripe) -> Vec<String> {
    let [k, l, j] = match stripe.pair {
        Some(((k, l), j)) => [k, l, j].map(|number| number.to_string()),
        None => [(); 3].map(|()| String::new()),
    };
    let [low, high] = stripe.edges.map(|edge| edge.to_string());
    let [low_end, high_end] = stripe.ends.map(|end| match end {
        StripeEnd::Edge => "edge".to_owned(),
        StripeEnd::Open => "open".to_owned(),
    });
    let (centre, error, width) = (stripe.centre, stripe.error, 2.0 * stripe.half_width);
    let mut fields = vec![family.name().to_owned(), gamma2.to_owned(), k, l, j, centre.to_string(), error.to_string()];
    fields.extend([low, high, low_end, high_end, width.to_string(), stripe.growth.to_string()]);
    fields.push(stripe.resolved.to_string());
    fields
}

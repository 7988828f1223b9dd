//! The extreme corners of the parameters against many digits: every promise kept, every refusal in words.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use vibrochain_cli::accuracy::extremes::cases::{CORNERS, Effort, rows};

#[test]
fn every_corner_keeps_its_promise() {
    let broken: Vec<String> = CORNERS
        .par_iter()
        .flat_map(|corner| {
            let rows = rows(corner, Effort::QUICK).unwrap();
            assert!(!rows.is_empty());
            for row in &rows {
                println!("{:5} {:>9.1e} {:>9.1e}  {} | {} | {}", row.holds(), row.promised.unwrap_or(f64::NAN), row.delivered.unwrap_or(f64::NAN), row.case, row.quantity, row.outcome);
            }
            rows.into_iter().filter(|row| !row.holds()).map(|row| format!("{row:?}")).collect::<Vec<_>>()
        })
        .collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

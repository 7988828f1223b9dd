//! The extreme corners of the parameters, and random points on logarithmic ranges, against many digits: every promise
//! kept, every refusal in words.

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use vibrochain_studies::accuracy::extremes::cases::{CORNERS, Effort, rows};
use vibrochain_studies::accuracy::extremes::draws::check_draws;

#[test]
fn every_corner_keeps_its_promise() {
    let broken: Vec<String> = CORNERS
        .par_iter()
        .flat_map(|corner| {
            let rows = rows(corner, Effort::QUICK).unwrap();
            assert!(!rows.is_empty());
            assert!(rows.iter().any(|row| row.delivered.is_some()), "{}: nothing compared", corner.0);
            rows.into_iter().filter(|row| !row.holds()).map(|row| format!("{row:?}")).collect::<Vec<_>>()
        })
        .collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn random_points_keep_their_promises() {
    keep_their_promises(700);
}

/// `DRAWS` says how many.
#[test]
#[ignore = "a minute: cargo test --workspace --test all -- --ignored slow"]
fn slow_ten_thousand_random_points_keep_their_promises() {
    keep_their_promises(std::env::var("DRAWS").ok().map_or(10_000, |count| count.parse().unwrap()));
}

fn keep_their_promises(count: u64) {
    let tally = check_draws(1, count).unwrap();
    println!("{} draws, {} compared, worst {}", tally.draws, tally.compared, tally.worst);
    for (outcome, count) in &tally.outcomes {
        println!("{count:8} {outcome}");
    }
    let broken: Vec<String> = tally.broken.iter().map(|row| format!("{row:?}")).collect();
    assert!(tally.compared > count, "{} of {count} points", tally.compared);
    assert!(broken.is_empty(), "{} of {count}:\n{}", broken.len(), broken.join("\n"));
}

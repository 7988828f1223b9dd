//! Random structures of each kind against many digits: every bound is one.

use vibrochain_studies::accuracy::structures::draws::Kind;
use vibrochain_studies::accuracy::structures::{KindTally, check_structures};

fn bounds_hold(kind: Kind, count: u64) {
    let KindTally { tally, answered, .. } = check_structures(kind, 0, count);
    println!("{}: {} compared, worst {}", kind.name(), tally.compared, tally.worst);
    for (outcome, count) in &tally.outcomes {
        println!("{count:8} {outcome}");
    }
    let broken: Vec<String> = tally.broken.iter().map(|row| format!("{row:?}")).collect();
    assert!(2 * answered > count && tally.compared > 3 * answered, "{answered} of {count}, {} numbers", tally.compared);
    assert!(broken.is_empty(), "{} of {count}:\n{}", broken.len(), broken.join("\n"));
}

#[test]
fn bounds_hold_next_to_resonances() {
    bounds_hold(Kind::Resonant, 40);
}

/// In the first 1250 draws fifteen bounds were exceeded, by up to 1.43, while the rounding of the period was left out.
#[test]
#[ignore = "two minutes: cargo test -p vibrochain-studies -- --ignored slow"]
fn slow_bounds_hold_next_to_resonances() {
    bounds_hold(Kind::Resonant, 1250);
}

#[test]
fn bounds_hold_from_weak_damping_through_critical_damping_to_strong() {
    bounds_hold(Kind::Critical, 40);
}

#[test]
fn bounds_hold_for_plastic_and_elastic_impacts() {
    bounds_hold(Kind::EndsOfRestitution, 40);
}

#[test]
fn bounds_hold_without_loads_and_losses() {
    bounds_hold(Kind::Conservative, 40);
}

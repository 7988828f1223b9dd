//! The margin of a mass that bounces alone, against its motion by hand.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Family, admissibility, breathers};
use vibrochain_lattice::{Chain, Model};

/// One mass on a spring, hit at a − 1 once a period: u = C cos √γ₁(t − T/2) with C cos(√γ₁ T/2) = a − 1, and its top at C.
#[test]
fn it_is_the_height_of_the_bounce_or_what_is_left_above_whichever_is_less() {
    let mut seen = [0, 0, 0];
    for step in 0..50 {
        for a in [0.4, 0.8, 0.95] {
            let (gamma1, omega): (f64, f64) = (0.2, 0.455 + 0.007 * f64::from(step));
            let model = Model::conservative(Chain::new(1, gamma1, 0.0).unwrap(), omega, a).unwrap();
            let top = (a - 1.0) / (gamma1.sqrt() * std::f64::consts::PI / omega).cos();
            let height = top - (a - 1.0);
            let orbits = breathers(&model, Family::SingleSided).unwrap().orbits;
            assert_eq!(orbits.len(), 1);
            let found = admissibility(&orbits[0]).unwrap();
            let margin = found.margin.unwrap();
            assert!((margin - height.min(2.0 - height)).abs() < 1e-12, "{a} {omega}: {margin} {height}");
            assert_eq!(found.is_physical(), height < 2.0);
            seen[(height as usize).min(2)] += 1;
        }
    }
    assert!(seen[0] >= 40 && seen[1] >= 30 && seen[2] >= 1, "{seen:?}");
}

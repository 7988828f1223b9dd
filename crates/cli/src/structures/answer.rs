//! Orbits of a structure for people.

use std::fmt::Write as _;

use vibrochain_breather::{ImpactError, OrbitList};
use vibrochain_maps::numbers::Number;
use vibrochain_maps::structure::answer::{kept, told};
use vibrochain_maps::structure::{Answered, StructureScene};

use crate::common::answer::{told_list, told_verdict};

/// The answer for people.
pub(crate) fn text(scene: &StructureScene, heading: &str, found: &OrbitList, answered: &[Answered<'_>]) -> String {
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = writeln!(out, "{heading}: {}, {}", scene.heading(), scene.here());
    let _ = write!(out, "{}", kept(scene));
    let physical = answered.iter().filter(|one| one.admissibility.is_physical()).count();
    out += &told_list(found.completeness, found.periods, [answered.len(), physical]);
    for (number, one) in answered.iter().enumerate() {
        let orbit = one.orbit;
        let _ = write!(out, "\nsolution {}: period {}", number + 1, Number(orbit.period()));
        if let Some(psi) = orbit.psi() {
            let _ = write!(out, ", psi {}", Number(psi));
        }
        let _ = writeln!(out);
        for impact in orbit.impacts() {
            let _ = writeln!(
                out,
                "  impact of contact {} on the {} barrier at t = {}: impulse {}, velocity {} -> {}",
                impact.site,
                impact.barrier,
                Number(impact.time),
                Number(impact.impulse),
                Number(impact.velocity_before),
                Number(impact.velocity_after)
            );
        }
        let _ = match (&one.admissibility.obstruction, one.admissibility.margin) {
            (Some(obstruction), _) => writeln!(out, "  not physical: {}", told(obstruction)),
            (None, Some(margin)) => writeln!(out, "  physical, margin {}", Number(margin)),
            (None, None) => writeln!(out, "  physical"),
        };
        let _ = match &one.stability {
            Ok(stability) => writeln!(out, "  {}", told_verdict(&stability.verdict)),
            Err(error) => writeln!(out, "  stability unknown: {error}"),
        };
        // In the user's units no number is large.
        let bound = |error: f64| if error.is_finite() { format!("{error:.0e}") } else { "unknown".to_owned() };
        let errors = orbit.contacts().map_or(&[][..], |contacts| contacts.impact_errors());
        let worst = |of: fn(&ImpactError) -> f64| errors.iter().map(of).fold(0.0, f64::max);
        let _ = writeln!(
            out,
            "  residual {:.1e}; errors: impulses {}, times {}",
            orbit.residual(),
            bound(worst(|error| error.impulse)),
            bound(worst(|error| error.time))
        );
        if orbit.is_self_excited() {
            let _ = writeln!(out, "  the period is its own, to {:.0e}", orbit.period_error());
        }
    }
    out
}

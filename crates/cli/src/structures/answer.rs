//! Orbits of a structure for people.

use std::fmt::Write as _;

use vibrochain_breather::{StructureFound, StructureModel, StructureSearch};
use vibrochain_lattice::Short;
use vibrochain_maps::numbers::Number;
use vibrochain_maps::structure::answer::{kept, told};
use vibrochain_maps::structure::{Answered, StructureScene};

use crate::common::answer::told_verdict;

fn how(search: StructureSearch) -> String {
    match search {
        StructureSearch::ClosedForm { unresolved: 0 } => "complete, by closed form".to_owned(),
        StructureSearch::ClosedForm { unresolved } => {
            format!("complete but for {unresolved} solutions of the closed form that rounding does not tell from none")
        }
        StructureSearch::HalfPeriod => {
            "not complete: instants half a period apart alone, where reversal of time has them".to_owned()
        }
        StructureSearch::Enclosures { intervals, unresolved: 0 } => {
            format!("complete, by enclosures on {intervals} intervals")
        }
        StructureSearch::BranchAndPrune { boxes, unresolved: 0 } => {
            format!("complete, by branch and prune in the plane, {boxes} boxes")
        }
        StructureSearch::Enclosures { unresolved, .. } | StructureSearch::BranchAndPrune { unresolved, .. } => {
            format!("complete but for {unresolved} places where two more may have merged: next to a fold")
        }
        StructureSearch::Scan { places } => {
            format!(
                "what a function of one variable shows in {places} places: two solutions between neighbours may be missed"
            )
        }
        StructureSearch::Starts { starts: 1 } => "one orbit, near the given one".to_owned(),
        StructureSearch::Starts { starts } => format!("not complete: what {starts} starts lead to"),
    }
}

/// The answer for people.
pub(crate) fn text(
    scene: &StructureScene,
    model: &StructureModel,
    heading: &str,
    found: &StructureFound,
    answered: &[Answered<'_>],
) -> String {
    let mut out = String::new();
    let plural = |count: usize| if count == 1 { "" } else { "s" };
    // Writing to a String cannot fail.
    let _ = writeln!(out, "{heading}: {}, {}", scene.heading(), scene.here());
    let _ = write!(out, "{}", kept(scene));
    let physical = answered.iter().filter(|one| one.admissibility.is_physical()).count();
    let none = found.search.is_complete();
    let _ = match (answered.len(), none) {
        (0, true) if model.structure().is_forced() => {
            writeln!(out, "none: no phase of the load meets the conditions at the impacts")
        }
        (0, true) => writeln!(out, "none: the conditions at the impacts have no solution"),
        (0, false) => writeln!(out, "none was found"),
        (count, _) => writeln!(out, "{count} solution{}, {physical} physical", plural(count)),
    };
    let of_periods = found.periods.map_or_else(String::new, |[from, to]| {
        format!("; periods are unknown here, and searched from {} to {}", Short(from), Short(to))
    });
    let _ = writeln!(out, "the list is {}{of_periods}", how(found.search));
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
                impact.contact,
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
        let worst =
            |of: fn(&vibrochain_breather::StructureImpact) -> f64| orbit.impacts().iter().map(of).fold(0.0, f64::max);
        let _ = writeln!(
            out,
            "  residual {:.1e}; errors: impulses {}, times {}",
            orbit.violation(),
            bound(worst(|impact| impact.impulse_error)),
            bound(worst(|impact| impact.time_error))
        );
        if orbit.is_self_excited() {
            let _ = writeln!(out, "  the period is its own, to {:.0e}", orbit.period_error());
        }
    }
    out
}

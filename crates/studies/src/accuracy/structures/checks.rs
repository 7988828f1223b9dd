//! The orbits of a structure, with their errors as told, against many digits.

use std::sync::Arc;

use vibrochain_breather::{LoadedStructure, Orbit};
use vibrochain_floquet::{Tolerance, Verdict, stability};
use vibrochain_truth::{TrueStructureOrbit, TruthError};

use super::draws::StructureDraw;
use crate::accuracy::extremes::{Row, worse};

/// Digits of the truth: a defective multiplier keeps half of them.
const BITS: usize = 128;

/// log₂ of what is no error of a multiplier, then.
const FLOOR: i32 = 8 - BITS as i32 / 2;

/// Orbits of a list that are looked at: a truth takes longer than they do.
const ORBITS: usize = 3;

/// An orbit whose impulses are told to be known so well is one, or the list is wrong.
const KNOWN: f64 = 1e-6;

/// Rows of its orbits, the worst one of each quantity; one row without numbers where there is none.
#[must_use]
pub fn check_structure(case: &str, draw: &StructureDraw) -> Vec<Row> {
    let none = |outcome: String| vec![Row::new(case, "orbits").told(outcome)];
    let model = draw.structure.modal().map_err(|error| error.to_string());
    let model = model.and_then(|modal| LoadedStructure::new(Arc::new(modal), draw.omega).map_err(|e| e.to_string()));
    let found = match (model, draw.word.parse()) {
        (Ok(model), Ok(word)) => model.orbits(&word, draw.force_periods),
        (Err(error), _) => return none(error),
        (_, Err(error)) => return none(error.to_string()),
    };
    let orbits = match found {
        Ok(found) => found.orbits,
        Err(error) => return none(error.to_string()),
    };
    if orbits.is_empty() {
        return none("no orbits".to_owned());
    }
    let mut rows: Vec<Row> = Vec::new();
    for orbit in orbits.iter().take(ORBITS) {
        for row in check_orbit(case, draw, orbit) {
            match rows.iter_mut().find(|old| old.quantity == row.quantity) {
                Some(old) if worse(&row, old) => *old = row,
                Some(_) => {}
                None => rows.push(row),
            }
        }
    }
    rows
}

fn check_orbit(case: &str, draw: &StructureDraw, orbit: &Orbit) -> Vec<Row> {
    let impacts = orbit.impacts();
    let known = orbit.contacts().map_or(&[][..], |contacts| contacts.impact_errors());
    let truth = TrueStructureOrbit::refine(&draw.structure, orbit, BITS);
    let both = truth.and_then(|truth| truth.errors_of(orbit).map(|errors| (truth, errors)));
    let (truth, errors) = match both {
        Ok(both) => both,
        Err(error) => {
            let mut pairs = impacts.iter().zip(known);
            let sure = pairs.all(|(impact, error)| error.impulse <= KNOWN * impact.impulse.abs());
            let wrong = sure && matches!(error, TruthError::NotConverged { .. });
            let row = Row::new(case, "orbits").told(format!("no truth to compare with: {error}"));
            return vec![Row { wrong, ..row }];
        }
    };
    let told = |of: fn(&vibrochain_breather::ImpactError) -> f64| known.iter().map(of).collect::<Vec<f64>>();
    vec![
        bounds(case, "impulses", &told(|error| error.impulse), &errors.impulses),
        bounds(case, "times", &told(|error| error.time), &errors.times),
        bounds(case, "accelerations", &told(|error| error.acceleration), &errors.accelerations),
        match stability(orbit, Tolerance::Rounding).map(|known| known.verdict) {
            Ok(verdict) => radius(case, &verdict, &truth),
            Err(error) => Row::new(case, "spectral radius").told(error.to_string()),
        },
    ]
}

/// Of the numbers of one kind the one that is worst against what was promised.
fn bounds(case: &str, quantity: &str, promised: &[f64], delivered: &[f64]) -> Row {
    // A promise that is not a number is none that was kept.
    let share = |(promised, delivered): &(f64, f64)| match () {
        () if promised.is_nan() || delivered.is_nan() => f64::INFINITY,
        () if *delivered == 0.0 => 0.0,
        () => delivered / promised,
    };
    let pairs = promised.iter().copied().zip(delivered.iter().copied());
    let (promised, delivered) = pairs.max_by(|a, b| share(a).total_cmp(&share(b))).unwrap_or_default();
    let row = Row { slack: 1.0, wrong: promised.is_nan(), ..Row::new(case, quantity) };
    if promised == f64::INFINITY { row.told("no bound is told") } else { row.measured(promised, delivered) }
}

fn radius(case: &str, verdict: &Verdict, truth: &TrueStructureOrbit) -> Row {
    let row = Row { slack: 1.0, floor: 2f64.powi(FLOOR), ..Row::new(case, "spectral radius") };
    let radius = truth.spectral_radius();
    let excess = (&radius - 1.0).to_f64();
    let off = (radius - verdict.spectral_radius).abs().to_f64();
    let said = match verdict.mechanism {
        _ if verdict.undecided => "undecided",
        Some(mechanism) => mechanism.name(),
        None => "stable",
    };
    let contradicts = verdict.stable && excess > row.floor || verdict.mechanism.is_some() && excess < -row.floor;
    let row = Row { wrong: contradicts && !verdict.undecided, ..row };
    let row = row.told(format!("{said}, |μ| = {:.7}, excess {excess:.1e}", verdict.spectral_radius));
    if verdict.resolution == f64::INFINITY {
        row.told("no bound is told")
    } else {
        row.measured(verdict.resolution, off)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_is_broken_by_any_excess_and_one_that_is_not_known_promises_nothing() {
        let row = |promised: &[f64], delivered: &[f64]| bounds("", "times", promised, delivered);
        assert!(row(&[0.0, 1e-12], &[0.0, 1e-12]).holds());
        let broken = row(&[0.0, 1e-12, 1.0], &[0.0, 1.1e-12, 0.5]);
        assert!(!broken.holds() && broken.delivered == Some(1.1e-12), "{broken:?}");
        assert!(!row(&[0.0], &[1e-300]).holds());
        assert!(!row(&[f64::NAN], &[0.0]).holds() && !row(&[1.0], &[f64::NAN]).holds());
        let unknown = row(&[f64::INFINITY, f64::INFINITY], &[0.0, 5.0]);
        assert!(unknown.holds() && unknown.delivered.is_none(), "{unknown:?}");
    }
}

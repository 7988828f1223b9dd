//! Points where orbits change, by bisection of what the program computes at one point.

use vibrochain_breather::{Admissibility, Family, Finder, Found, Orbit};
use vibrochain_floquet::{Analyser, Tolerance};
use vibrochain_lattice::{Chain, ImpulseResponse, Model, Spectrum};

use crate::errata::computation;
use crate::error::CliError;
use crate::forms::{Kernels, Reading, double_sided};

/// Halvings of a bracket; 50 leave less than rounding.
const HALVINGS: u32 = 50;

/// Step of differences in φ/T: what is left of its fourth power, and rounding over it, move the point by less than 1e-12.
const STEP: f64 = 2e-4;

pub(super) const HEADING: &str = "
## Points of change

N = 20. Found by bisection; `mapgen orbit` with the parameters a little to either side shows the change.

| what | parameters | where |
|---|---|---|
";

/// Where `side` changes from that at `low` to that at `high`.
fn bisect(mut low: f64, mut high: f64, side: impl Fn(f64) -> Result<bool, CliError>) -> Result<f64, CliError> {
    let at_low = side(low)?;
    if side(high)? == at_low {
        return Err(computation(format!("nothing changes between {low} and {high}")));
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if side(middle)? == at_low { low = middle } else { high = middle }
    }
    Ok(0.5 * (low + high))
}

/// All orbits, with what the search and the check say.
fn orbits(model: &Model, family: Family) -> Result<Vec<(Orbit, Admissibility)>, CliError> {
    let mut finder = Finder::new(model.chain().sites());
    let mut found = Found::default();
    finder.find(model, family, &mut found).map_err(computation)?;
    let orbits = std::mem::take(&mut found.orbits);
    let check = |orbit: Orbit| {
        let admissibility = finder.admissibility(&orbit).map_err(computation)?;
        Ok((orbit, admissibility))
    };
    orbits.into_iter().map(check).collect()
}

/// The smallest spectral radius among physical orbits; infinite if there is none.
fn radius(model: &Model, family: Family) -> Result<f64, CliError> {
    let mut finder = Finder::new(model.chain().sites());
    let mut least = f64::INFINITY;
    for (orbit, admissibility) in orbits(model, family)? {
        if admissibility.is_physical() {
            let verdict = Analyser::default().verdict(&orbit, &mut finder, Tolerance::Rounding).map_err(computation)?;
            least = least.min(verdict.spectral_radius);
        }
    }
    Ok(least)
}

/// Rows of the table.
pub(super) fn lines() -> Result<Vec<String>, CliError> {
    let chain = |gamma1, gamma2| Chain::new(21, gamma1, gamma2);
    // The single-sided orbit of figure 8 is the one with the larger impulse.
    let single = |omega: f64| -> Result<Option<(Orbit, Admissibility)>, CliError> {
        let impulse = |orbit: &Orbit| orbit.impacts().first().map_or(0.0, |impact| impact.impulse);
        let model = Model::forced(chain(0.2, 0.1)?, omega, 0.4, 0.1, 0.9)?;
        let all = orbits(&model, Family::SingleSided)?;
        Ok(all.into_iter().max_by(|a, b| impulse(&a.0).total_cmp(&impulse(&b.0))))
    };
    let grazing =
        bisect(0.92, 0.94, |omega| Ok(single(omega)?.is_some_and(|(_, admissibility)| admissibility.is_physical())))?;
    let peak = single(grazing)?.map_or(Ok(f64::NAN), |(orbit, _)| peak(&orbit))?;
    let pitchfork = bisect(0.5, 0.6, |e| {
        let model = Model::forced(chain(0.1, 0.05)?, 1.33, 0.0, 1.5, e)?;
        Ok(slope(&model)? < 0.0)
    })?;
    let torus = bisect(0.08, 0.12, |gamma2| {
        let model = Model::forced(chain(0.2, gamma2)?, 0.92, 0.7, 0.05, 0.9)?;
        Ok(radius(&model, Family::SingleSided)? < 1.0)
    })?;
    let soft = |amplitude: f64| -> Result<Model, CliError> {
        Ok(Model::forced(chain(0.2, 0.1)?, 1.07, 0.8, amplitude, 0.25)?)
    };
    let doubling = bisect(0.1582, 0.16, |amplitude| Ok(radius(&soft(amplitude)?, Family::SingleSided)? < 1.0))?;
    let fold = bisect(0.157, 0.1582, |amplitude| Ok(orbits(&soft(amplitude)?, Family::SingleSided)?.is_empty()))?;
    let row = |what: &str, parameters: &str, found: String| format!("| {what} | {parameters} | {found} |\n");
    Ok(vec![
        row(
            "grazing, single-sided: the mass touches the upper barrier; not at T/2",
            "γ₁ = 0.2, γ₂ = 0.1, a = 0.4, A = 0.1, e = 0.9",
            format!("ω = {grazing:.13}, at t = {peak:.5} T"),
        ),
        row(
            "pitchfork, double-sided (figure 9)",
            "γ₁ = 0.1, γ₂ = 0.05, ω = 1.33, a = 0, A = 1.5",
            format!("e = {pitchfork:.11}"),
        ),
        row(
            "Neimark–Sacker, single-sided (figure 11)",
            "γ₁ = 0.2, ω = 0.92, a = 0.7, A = 0.05, e = 0.9",
            format!("γ₂ = {torus:.12}"),
        ),
        row(
            "period doubling, single-sided (figure 13)",
            "γ₁ = 0.2, γ₂ = 0.1, ω = 1.07, a = 0.8, e = 0.25",
            format!("A = {doubling:.9}"),
        ),
        row(
            "fold: below it no single-sided orbit exists",
            "γ₁ = 0.2, γ₂ = 0.1, ω = 1.07, a = 0.8, e = 0.25",
            format!("A = {fold:.12}"),
        ),
    ])
}

/// The slope of a(φ) at φ = T/2, where the curve is odd, times a positive number: at a pitchfork it is 0. By differences
/// free of the third power.
fn slope(model: &Model) -> Result<f64, CliError> {
    let response = ImpulseResponse::new(&Spectrum::new(*model.chain()), model.omega()).map_err(computation)?;
    let force = model.force_response().map_err(computation)?;
    let asymmetry = |step: f64| {
        let phi = (0.5 + step) * model.period();
        let form = double_sided(&Kernels::at(&response, phi), model, force, phi, 1.0, Reading::Mended);
        form.map(|form| form.asymmetry).ok_or_else(|| computation("the branch of the symmetric orbit has ended"))
    };
    Ok(8.0 * asymmetry(STEP)? - asymmetry(2.0 * STEP)?)
}

/// When the impacting mass is farthest from its barrier, in periods.
fn peak(orbit: &Orbit) -> Result<f64, CliError> {
    let mut motion = vibrochain_breather::Motion::of(orbit).map_err(computation)?;
    // Between these parts of the period the velocity changes its sign once.
    let (mut low, mut high) = (0.4, 0.6);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if motion.at(0, middle * orbit.period()).velocity > 0.0 { low = middle } else { high = middle }
    }
    Ok(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bisection_meets_a_change_and_says_where_there_is_none() {
        assert!((bisect(0.0, 2.0, |x| Ok(x * x < 2.0)).unwrap() - 2f64.sqrt()).abs() < 1e-14);
        assert!(bisect(0.0, 1.0, |_| Ok(true)).is_err());
    }
}

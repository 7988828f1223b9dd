//! Orbits of a structure for people and as JSON.

use std::fmt::Write as _;

use serde_json::{Value, json as value};
use vibrochain_breather::{
    Admissibility, Obstruction, StructureFound, StructureModel, StructureOrbit, StructureSearch,
};
use vibrochain_floquet::{FloquetError, Stability};
use vibrochain_lattice::Short;
use vibrochain_maps::numbers::Number;
use vibrochain_maps::structure::{Setting, StructureScene};

use crate::common::schemas::STRUCTURE;

/// The most multipliers of a solution that are listed.
const MOST_LISTED: usize = 4096;

/// An orbit with all that is said about it.
pub(crate) struct Answered<'a> {
    pub(crate) orbit: &'a StructureOrbit,
    pub(crate) admissibility: Admissibility,
    pub(crate) stability: Result<Stability, FloquetError>,
}

/// What is in the way, in words.
fn told(obstruction: &Obstruction) -> String {
    match obstruction {
        Obstruction::WrongSign { impact, site, time, velocity_before } => format!(
            "impact {impact} (contact {site}, t = {time}) has the wrong sign: the contact would leave its barrier at velocity {velocity_before} \
             before being hit"
        ),
        Obstruction::Crossing { site, barrier, time, excess } if *excess <= 0.0 => {
            format!("contact {site} touches the {barrier} barrier at t = {time}")
        }
        Obstruction::Crossing { site, barrier, time, excess } => {
            format!("contact {site} is {excess} beyond the {barrier} barrier at t = {time}")
        }
    }
}

fn how(search: StructureSearch) -> String {
    match search {
        StructureSearch::ClosedForm => "complete: closed form".to_owned(),
        StructureSearch::Enclosures { intervals, unresolved: 0 } => {
            format!("complete: enclosures on {intervals} intervals")
        }
        StructureSearch::Enclosures { unresolved, .. } => {
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
pub(crate) fn text(model: &StructureModel, heading: &str, found: &StructureFound, answered: &[Answered<'_>]) -> String {
    let mut out = String::new();
    let structure = model.structure();
    let (contacts, modes) = (structure.contacts().len(), structure.modes().len());
    let plural = |count: usize| if count == 1 { "" } else { "s" };
    // Writing to a String cannot fail.
    let _ = writeln!(
        out,
        "{heading}, structure of {modes} mode{}, {contacts} contact{}, omega = {}",
        plural(modes),
        plural(contacts),
        Short(model.omega())
    );
    let physical = answered.iter().filter(|one| one.admissibility.is_physical()).count();
    let none = matches!(found.search, StructureSearch::ClosedForm | StructureSearch::Enclosures { unresolved: 0, .. });
    let _ = match (answered.len(), none) {
        (0, true) => writeln!(out, "none: no phase of the load meets the conditions at the impacts"),
        (0, false) => writeln!(out, "none was found"),
        (count, _) => writeln!(out, "{count} solution{}, {physical} physical", plural(count)),
    };
    let _ = writeln!(out, "the list is {}", how(found.search));
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
            Ok(stability) => {
                let verdict = stability.verdict;
                let how = match verdict.mechanism {
                    Some(mechanism) => format!("unstable ({})", mechanism.name()),
                    None if verdict.marginal => "marginal (closer to the border than its own error)".to_owned(),
                    None => "stable".to_owned(),
                };
                let error =
                    if verdict.resolution > 0.0 { format!(" ± {:.0e}", verdict.resolution) } else { String::new() };
                writeln!(out, "  {how}: spectral radius {}{error}", verdict.spectral_radius)
            }
            Err(error) => writeln!(out, "  stability unknown: {error}"),
        };
        let worst =
            |of: fn(&vibrochain_breather::StructureImpact) -> f64| orbit.impacts().iter().map(of).fold(0.0, f64::max);
        let _ = writeln!(
            out,
            "  residual {:.1e}; errors: impulses {:.0e}, times {:.0e}",
            orbit.violation(),
            worst(|impact| impact.impulse_error),
            worst(|impact| impact.time_error)
        );
    }
    out
}

/// The answer as JSON.
pub(crate) fn json(
    scene: &StructureScene,
    model: &StructureModel,
    heading: &str,
    found: &StructureFound,
    answered: &[Answered<'_>],
) -> Value {
    value!({
        "schema": STRUCTURE,
        "structure": structure(scene, model),
        "word": heading,
        "solutions": answered.iter().map(Answered::json).collect::<Vec<_>>(),
        "search": found.search,
    })
}

/// The structure as it was asked about.
pub(crate) fn structure(scene: &StructureScene, model: &StructureModel) -> Value {
    let structure = model.structure();
    let contacts = structure.contacts().iter().enumerate().map(|(number, contact)| {
        value!({
            "lower": contact.lower,
            "upper": contact.upper,
            "restitution": contact.restitution,
            "effective_mass": 1.0 / structure.mobility(number, number),
        })
    });
    value!({
        "title": scene.title,
        "omega": model.omega(),
        "load": scene.get(Setting::Load),
        "static": scene.get(Setting::Static),
        "damping": scene.get(Setting::Damping),
        "modes": structure.modes().len(),
        "contacts": contacts.collect::<Vec<_>>(),
    })
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

impl Answered<'_> {
    pub(crate) fn json(&self) -> Value {
        let orbit = self.orbit;
        let impacts = orbit.impacts().iter().map(|impact| {
            value!({
                "contact": impact.contact,
                "barrier": impact.barrier.name(),
                "time": impact.time,
                "impulse": impact.impulse,
                "velocity_before": impact.velocity_before,
                "velocity_after": impact.velocity_after,
                "acceleration_before": impact.acceleration_before,
                "time_error": finite(impact.time_error),
                "impulse_error": finite(impact.impulse_error),
            })
        });
        let obstruction = self.admissibility.obstruction.map(|obstruction| {
            let message = told(&obstruction);
            match obstruction {
                Obstruction::Crossing { site, barrier, time, excess } => value!({
                    "kind": "crossing", "contact": site, "barrier": barrier.name(), "time": time, "excess": excess, "message": message,
                }),
                Obstruction::WrongSign { impact, site, time, velocity_before } => value!({
                    "kind": "wrong-sign", "impact": impact, "contact": site, "time": time, "velocity_before": velocity_before, "message": message,
                }),
            }
        });
        let mut answer = value!({
            "word": orbit.word(),
            "period": orbit.period(),
            "psi": orbit.psi(),
            "impacts": impacts.collect::<Vec<_>>(),
            "residual": orbit.violation(),
            "physical": self.admissibility.is_physical(),
            "margin": self.admissibility.margin,
            "obstruction": obstruction,
            "stability": null,
        });
        if !orbit.offsets().is_empty() {
            answer["offsets"] = orbit.offsets().into();
        }
        match &self.stability {
            Ok(stability) => {
                let verdict = stability.verdict;
                let listed: Vec<[f64; 2]> =
                    stability.multipliers.iter().take(MOST_LISTED).map(|z| [z.re, z.im]).collect();
                answer["stability"] = value!({
                    "stable": verdict.stable,
                    "marginal": verdict.marginal,
                    "mechanism": verdict.mechanism.map(|mechanism| mechanism.name()),
                    "spectral_radius": verdict.spectral_radius,
                    "growth": verdict.growth(),
                    "resolution": finite(verdict.resolution),
                    "multipliers": listed,
                });
            }
            Err(error) => answer["stability_error"] = error.to_string().into(),
        }
        answer
    }
}

//! Orbits of a structure with all that is said of them, as JSON: what the program prints and Python reads.

use serde_json::{Value, json as value};
use vibrochain_breather::{
    Admissibility, Obstruction, StructureFound, StructureModel, StructureOrbit, StructureOrbitError,
    structure_admissibility,
};
use vibrochain_floquet::{FloquetError, Stability, Tolerance, structure_stability};

use super::scene::StructureScene;
use super::setting::Setting;

/// What the answer names in its first key.
const SCHEMA: &str = "urn:vibrochain:structure:1";

/// The most multipliers of a solution that are listed.
const MOST_LISTED: usize = 4096;

/// An orbit with all that is said about it.
pub struct Answered<'a> {
    /// The orbit.
    pub orbit: &'a StructureOrbit,
    /// Physical, or what is in the way.
    pub admissibility: Admissibility,
    /// Its multipliers, or why there are none.
    pub stability: Result<Stability, FloquetError>,
}

impl<'a> Answered<'a> {
    /// All of it.
    ///
    /// # Errors
    /// [`StructureOrbitError`] at a resonance.
    pub fn new(orbit: &'a StructureOrbit, tolerance: Tolerance) -> Result<Self, StructureOrbitError> {
        Ok(Self {
            orbit,
            admissibility: structure_admissibility(orbit)?,
            stability: structure_stability(orbit, tolerance),
        })
    }
}

/// What is in the way, in words.
#[must_use]
pub fn told(obstruction: &Obstruction) -> String {
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

/// The answer as JSON.
#[must_use]
pub fn json(
    scene: &StructureScene,
    model: &StructureModel,
    heading: &str,
    found: &StructureFound,
    answered: &[Answered<'_>],
) -> Value {
    value!({
        "schema": SCHEMA,
        "structure": structure(scene, model),
        "word": heading,
        "solutions": answered.iter().map(Answered::json).collect::<Vec<_>>(),
        "search": found.search,
    })
}

/// The structure as it was asked about.
#[must_use]
pub fn structure(scene: &StructureScene, model: &StructureModel) -> Value {
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
    fn json(&self) -> Value {
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
                    "undecided": verdict.undecided,
                    "mechanism": verdict.mechanism.map(|mechanism| mechanism.name()),
                    "spectral_radius": verdict.spectral_radius,
                    "excess": verdict.excess(),
                    "resolution": finite(verdict.resolution),
                    "multipliers": listed,
                });
            }
            Err(error) => answer["stability_error"] = error.to_string().into(),
        }
        answer
    }
}

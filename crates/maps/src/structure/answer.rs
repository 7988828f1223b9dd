//! Orbits of a structure with all that is said of them, as JSON: what the program prints and Python reads.

use serde_json::{Map, Value, json as value};
use vibrochain_breather::{
    Admissibility, BreatherError, Completeness, Impact, ImpactError, LoadedStructure, Obstruction, Orbit, OrbitList,
    admissibility,
};
use vibrochain_floquet::{self as floquet, FloquetError, Stability, Tolerance, Verdict};

use super::scene::StructureScene;
use super::setting::Setting;
use crate::manifest::object;
use crate::numbers::Number;

/// What the answer names in its first key.
const SCHEMA: &str = "urn:vibrochain:structure:1";

/// The most multipliers of a solution that are listed.
pub const MOST_LISTED: usize = 4096;

/// An orbit with all that is said about it.
pub struct Answered<'a> {
    /// The orbit.
    pub orbit: &'a Orbit,
    /// Physical, or what is in the way.
    pub admissibility: Admissibility,
    /// Its multipliers, or why there are none.
    pub stability: Result<Stability, FloquetError>,
}

impl<'a> Answered<'a> {
    /// All of it.
    ///
    /// # Errors
    /// [`BreatherError`] at a resonance.
    pub fn new(orbit: &'a Orbit, tolerance: Tolerance) -> Result<Self, BreatherError> {
        Ok(Self { orbit, admissibility: admissibility(orbit)?, stability: floquet::stability(orbit, tolerance) })
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
        Obstruction::Sticking { impact, site, time, acceleration_after } => format!(
            "contact {site} begins to rest on its barrier after impact {impact} (t = {time}): the acceleration {acceleration_after} presses it there"
        ),
    }
}

/// The answer as JSON.
#[must_use]
pub fn json(
    scene: &StructureScene,
    model: &LoadedStructure,
    heading: &str,
    found: &OrbitList,
    answered: &[Answered<'_>],
) -> Value {
    let mut told = object([
        ("schema", value!(SCHEMA)),
        ("structure", structure(scene, model)),
        ("word", value!(heading)),
        ("solutions", answered.iter().map(Answered::json).collect()),
    ]);
    told.extend(completeness(found.completeness));
    told.insert("periods".to_owned(), value!(found.periods));
    told.into()
}

/// What is known of a list, as answers about chains and structures have it: why there is none, by which means all are known and after how much
/// work, and how many places are open.
#[must_use]
pub fn completeness(known: Completeness) -> Map<String, Value> {
    let how = match (known, known.proof()) {
        (_, Some(proof)) => value!(proof),
        (Completeness::Followed { starts, .. }, _) => value!({ "by": known.means(), "starts": starts }),
        (Completeness::Scanned { places }, _) => value!({ "by": known.means(), "intervals": places }),
        _ => value!({ "by": known.means() }),
    };
    let mut keys = object([("established", value!(known.is_established()))]);
    keys.extend(if let Value::Object(how) = how { how } else { Map::new() });
    let (unresolved, exhausted) = known.open();
    object([
        ("reason", value!(known.reason().map(|reason| reason.to_string()))),
        ("completeness", value!(keys)),
        ("unresolved", value!(unresolved)),
        ("exhausted", value!(exhausted)),
    ])
}

/// What each contact feels where only some modes are kept, a line a contact.
#[must_use]
pub fn kept(scene: &StructureScene) -> String {
    let line = |(contact, (own, all)): (usize, (f64, f64))| {
        format!("contact {contact} feels a mass of {}, with all modes {}\n", Number(own), Number(all))
    };
    scene.kept_masses().into_iter().enumerate().map(line).collect()
}

/// The structure as it was asked about.
#[must_use]
pub fn structure(scene: &StructureScene, model: &LoadedStructure) -> Value {
    let structure = model.structure();
    let whole = scene.whole();
    let contacts = structure.contacts().iter().enumerate().map(|(number, contact)| {
        let of_all = whole.as_ref().map(|(_, masses)| masses[number]);
        value!({
            "lower": contact.lower,
            "upper": contact.upper,
            "restitution": contact.restitution,
            "effective_mass": structure.effective_mass(number),
            "effective_mass_of_all_modes": of_all,
        })
    });
    value!({
        "title": scene.title,
        "omega": scene.omega().map(|_| model.omega()),
        "load": scene.get(Setting::Load),
        "static": scene.get(Setting::Static),
        "damping": scene.get(Setting::Damping),
        "modes": structure.modes().len(),
        "all_modes": whole.as_ref().map(|(all, _)| *all),
        "contacts": contacts.collect::<Vec<_>>(),
    })
}

/// Stability, as answers about chains and structures have it; of multipliers, the method and doubts some say more.
#[must_use]
pub fn stability(verdict: &Verdict) -> Map<String, Value> {
    object([
        ("stable", value!(verdict.stable)),
        ("undecided", value!(verdict.undecided)),
        ("mechanism", value!(verdict.mechanism)),
        ("spectral_radius", value!(verdict.spectral_radius)),
        ("excess", value!(verdict.excess())),
        ("resolution", value!(verdict.resolution)),
    ])
}

/// What is in the way: its site is a contact.
fn obstruction(found: &Obstruction) -> Map<String, Value> {
    let keys = if let Value::Object(keys) = value!(found) { keys } else { Map::new() };
    let keys = keys.into_iter().map(|(key, value)| (if key == "site" { "contact".to_owned() } else { key }, value));
    keys.chain([("message".to_owned(), told(found).into())]).collect()
}

impl Answered<'_> {
    fn json(&self) -> Value {
        let orbit = self.orbit;
        let errors = orbit.contacts().map_or(&[][..], |contacts| contacts.impact_errors());
        let impact = |(impact, error): (&Impact, &ImpactError)| {
            value!({
                "contact": impact.site,
                "barrier": impact.barrier,
                "time": impact.time,
                "impulse": impact.impulse,
                "velocity_before": impact.velocity_before,
                "velocity_after": impact.velocity_after,
                "acceleration_before": impact.acceleration,
                "time_error": error.time,
                "impulse_error": error.impulse,
            })
        };
        let mut answer = value!({
            "word": orbit.word(),
            "period": orbit.period(),
            "psi": orbit.psi(),
            "impacts": orbit.impacts().iter().zip(errors).map(impact).collect::<Vec<_>>(),
            "residual": orbit.residual(),
            "physical": self.admissibility.is_physical(),
            "margin": self.admissibility.margin,
            "obstruction": self.admissibility.obstruction.as_ref().map(obstruction),
            "stability": null,
        });
        if orbit.is_self_excited() {
            answer["period_error"] = orbit.period_error().into();
        }
        if let Some(contacts) = orbit.contacts().filter(|contacts| !contacts.offsets().is_empty()) {
            answer["offsets"] = contacts.offsets().into();
        }
        match &self.stability {
            Ok(found) => {
                let mut told = stability(&found.verdict);
                let listed = found.multipliers.iter().take(MOST_LISTED).map(|z| [z.re, z.im]);
                told.insert("multipliers".to_owned(), listed.map(|z| value!(z)).collect());
                answer["stability"] = told.into();
            }
            Err(error) => answer["stability_error"] = error.to_string().into(),
        }
        answer
    }
}

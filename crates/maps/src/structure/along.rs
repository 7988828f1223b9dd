//! A structure as its numbers vary: its models, the events of a branch as JSON has them, and the curves of all of these.

use std::sync::Arc;

use serde::Serialize;
use vibrochain_breather::{StructureFamily, StructureOrbit};
use vibrochain_floquet::{CurveError, Evidence, Located, StructureCurve, StructureWindow, Verdict, structure_curve};
use vibrochain_lattice::Stop;

use super::scene::StructureScene;
use super::setting::Setting;

/// The models of a scene as these numbers vary.
#[must_use]
pub fn family(scene: &StructureScene, settings: &[Setting]) -> StructureFamily {
    let (scene, settings) = (scene.clone(), settings.to_vec());
    Arc::new(move |values: &[f64]| {
        let mut scene = scene.clone();
        settings.iter().zip(values).try_for_each(|(setting, value)| scene.set(*setting, *value))?;
        scene.model()
    })
}

/// What shows an event, as JSON has it.
#[derive(Serialize)]
#[serde(untagged)]
enum EvidenceEntry {
    Multiplier { multiplier: [f64; 2] },
    Touch { contact: usize, barrier: &'static str, time: f64 },
    Impact { impact: usize },
}

impl EvidenceEntry {
    fn of(evidence: Evidence) -> Self {
        match evidence {
            Evidence::Multiplier(mu) => Self::Multiplier { multiplier: [mu.re, mu.im] },
            Evidence::Touch(touch) => {
                Self::Touch { contact: touch.site, barrier: touch.barrier.name(), time: touch.time }
            }
            Evidence::Impact(impact) => Self::Impact { impact },
        }
    }
}

/// A verdict on one side of an event.
#[derive(Serialize)]
struct SideEntry {
    value: f64,
    stability: Verdict,
}

/// An event as JSON has it.
#[derive(Serialize)]
pub struct EventEntry {
    event: &'static str,
    value: f64,
    error: Option<f64>,
    evidence: EvidenceEntry,
    physical: Option<bool>,
    period: f64,
    psi: Option<f64>,
    times: Vec<f64>,
    impulses: Vec<f64>,
    sides: Vec<SideEntry>,
}

impl EventEntry {
    /// Of an event that was located.
    #[must_use]
    pub fn of(found: &Located<StructureOrbit>) -> Self {
        let sides = found.verdicts.iter();
        Self {
            event: found.event.name(),
            value: found.value,
            error: Some(found.error).filter(|error| error.is_finite()),
            evidence: EvidenceEntry::of(found.evidence),
            physical: found.physical,
            period: found.orbit.period(),
            psi: found.orbit.psi(),
            times: found.orbit.impacts().iter().map(|impact| impact.time).collect(),
            impulses: found.orbit.impulses(),
            sides: sides.map(|(value, verdict)| SideEntry { value: *value, stability: *verdict }).collect(),
        }
    }
}

/// The curves of all these events along the first of two numbers, each followed once. `value` is where the second number is.
///
/// # Errors
/// [`CurveError`]
pub fn curves<'a>(
    scene: &StructureScene,
    (settings, value): ([Setting; 2], f64),
    located: impl IntoIterator<Item = &'a Located<StructureOrbit>>,
    (window, tolerance): (StructureWindow, f64),
    stop: &Stop,
) -> Result<Vec<StructureCurve>, CurveError> {
    let models = family(scene, &settings);
    let mut curves: Vec<StructureCurve> = Vec::new();
    for located in located {
        let place = [located.value, value];
        if !curves.iter().any(|curve| curve.passes((place, &located.orbit), tolerance, |values| window.parts(values))) {
            curves.push(structure_curve(located, &models, place, window, tolerance, stop)?);
        }
    }
    Ok(curves)
}

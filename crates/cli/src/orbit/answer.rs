//! The answer as JSON.

use std::collections::BTreeMap;

use serde::Serialize;
use vibrochain_breather::{Completeness, Condition, Ended, Found, Obstruction, Orbit, Proof};
use vibrochain_floquet::{Collision, Mechanism, Multipliers};
use vibrochain_lattice::{Model, Parameter};

use crate::common::schemas::ORBIT;
use crate::common::solution::Solution;
use crate::orbit::modes::{ModeAnswer, OrbitModes, OwnModeAnswer};

/// The most multipliers of a solution that are listed.
const MOST_LISTED: usize = 4096;

/// All breathers at a point.
#[derive(Serialize)]
pub(super) struct OrbitAnswer<'a> {
    schema: &'static str,
    parameters: &'a Model,
    solutions: Vec<SolutionAnswer<'a>>,
    reason: Option<String>,
    completeness: CompletenessAnswer,
    unresolved: usize,
    exhausted: usize,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    ended: Vec<EndedAnswer>,
}

/// By which means the list is known to be complete, and how much work that took.
#[derive(Serialize)]
struct CompletenessAnswer {
    established: bool,
    #[serde(flatten)]
    how: How,
}

#[derive(Serialize)]
#[serde(untagged)]
enum How {
    Proved(Proof),
    Followed { by: &'static str, starts: usize },
    Unknown { by: Option<Proof> },
}

/// Where a branch from masses without coupling ended: the coupling, and why.
#[derive(Serialize)]
struct EndedAnswer {
    #[serde(flatten)]
    at: BTreeMap<Parameter, f64>,
    message: String,
}

/// A breather with all that is said about it.
#[derive(Serialize)]
struct SolutionAnswer<'a> {
    #[serde(flatten)]
    orbit: &'a Orbit,
    condition: ConditionAnswer<'a>,
    physical: bool,
    margin: Option<f64>,
    obstruction: Option<ObstructionAnswer>,
    stability: Option<StabilityAnswer>,
    #[serde(skip_serializing_if = "Option::is_none")]
    stability_error: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    phases: Option<Vec<PhaseAnswer>>,
    modes: Option<&'a [ModeAnswer]>,
    own_mode: Option<OwnModeAnswer>,
    collision: Option<Collision>,
}

#[derive(Serialize)]
struct ConditionAnswer<'a> {
    #[serde(flatten)]
    condition: &'a Condition,
    impulse_error: f64,
    time_error: f64,
}

/// What is in the way, in numbers and in words.
#[derive(Serialize)]
struct ObstructionAnswer {
    #[serde(flatten)]
    obstruction: Obstruction,
    message: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    layer: Option<usize>,
}

#[derive(Serialize)]
struct StabilityAnswer {
    stable: bool,
    marginal: bool,
    mechanism: Option<Mechanism>,
    spectral_radius: f64,
    growth: f64,
    resolution: f64,
    method: &'static str,
    multipliers: Option<Vec<[f64; 2]>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    multipliers_note: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    doubt: Option<String>,
}

/// By how much a breather of a word runs ahead.
#[derive(Serialize)]
struct PhaseAnswer {
    site: usize,
    ahead: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    layer: Option<usize>,
}

impl<'a> OrbitAnswer<'a> {
    pub(super) fn new(model: &'a Model, solutions: &'a [Solution], found: &Found) -> Self {
        let completeness = found.completeness;
        let (unresolved, exhausted) = completeness.open();
        let ended = |ended: &Ended| EndedAnswer {
            at: BTreeMap::from([(ended.coupling, ended.value)]),
            message: ended.told(&model.chain().layout()),
        };
        Self {
            schema: ORBIT,
            parameters: model,
            solutions: solutions.iter().map(SolutionAnswer::from).collect(),
            reason: completeness.reason().map(|reason| reason.to_string()),
            completeness: completeness.into(),
            unresolved,
            exhausted,
            ended: found.ended.iter().map(ended).collect(),
        }
    }
}

impl From<Completeness> for CompletenessAnswer {
    fn from(completeness: Completeness) -> Self {
        let how = match (completeness, completeness.proof()) {
            (Completeness::Followed { starts, .. }, _) => How::Followed { by: "followed", starts },
            (_, Some(proof)) => How::Proved(proof),
            (_, None) => How::Unknown { by: None },
        };
        Self { established: completeness.is_established(), how }
    }
}

impl<'a> From<&'a Solution> for SolutionAnswer<'a> {
    fn from(solution: &'a Solution) -> Self {
        let Solution { orbit, admissibility, condition, multipliers, modes, phases } = solution;
        let layout = orbit.model().chain().layout();
        let obstruction = |mut obstruction: Obstruction| {
            let message = obstruction.told(&layout);
            let (Obstruction::WrongSign { site: mass, .. } | Obstruction::Crossing { site: mass, .. }) =
                &mut obstruction;
            let (site, layer) = layout.site_and_layer(*mass);
            *mass = site;
            ObstructionAnswer { obstruction, message, layer }
        };
        let phase = |&(mass, ahead): &(usize, f64)| {
            let (site, layer) = layout.site_and_layer(mass);
            PhaseAnswer { site, ahead, layer }
        };
        let (impulse_error, time_error) = (condition.impulse_error(orbit), condition.time_error(orbit));
        Self {
            orbit,
            condition: ConditionAnswer { condition, impulse_error, time_error },
            physical: admissibility.is_physical(),
            margin: admissibility.margin,
            obstruction: admissibility.obstruction.map(obstruction),
            stability: multipliers.as_ref().ok().map(StabilityAnswer::from),
            stability_error: multipliers.as_ref().err().map(ToString::to_string),
            phases: phases.as_ref().map(|phases| phases.iter().map(phase).collect()),
            modes: modes.as_ref().map(|modes| &modes.modes[..]),
            own_mode: modes.as_ref().and_then(OrbitModes::own),
            collision: modes.as_ref().and_then(|modes| modes.collision),
        }
    }
}

impl From<&Multipliers> for StabilityAnswer {
    fn from(all: &Multipliers) -> Self {
        let verdict = all.verdict;
        let listed = all.len() <= MOST_LISTED;
        let note = || format!("{} of them: --multipliers FILE writes them as CSV", all.len());
        Self {
            stable: verdict.stable,
            marginal: verdict.marginal,
            mechanism: verdict.mechanism,
            spectral_radius: verdict.spectral_radius,
            growth: verdict.growth(),
            resolution: verdict.resolution,
            method: verdict.method.name(),
            multipliers: listed.then(|| all.sorted().map(|mu| [mu.re, mu.im]).collect()),
            multipliers_note: (!listed).then(note),
            doubt: verdict.method.doubt().map(|doubt| doubt.to_string()),
        }
    }
}

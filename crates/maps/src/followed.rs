//! Branches and curves of events as rows: what tables hold of them and pictures are drawn from.

use serde::{Deserialize, Serialize};
use vibrochain_breather::{Family, Orbit, Word};
use vibrochain_floquet::{CurvePoint, Event, EventCurve, Evidence, SpecialPoint, Station, is_physical_about};

/// What the rows do not say of a branch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BranchName {
    /// The family or word of its orbits.
    pub name: String,
    /// How many branches lie between it and the first.
    pub generation: u32,
    /// Periods of the force in one of its orbits'.
    pub force_periods: u32,
}

/// A point of a branch, or an event on it.
#[derive(Debug, Clone, PartialEq)]
pub struct BranchRow {
    /// Which event; none of a point.
    pub event: Option<Event>,
    /// Of what varies.
    pub value: f64,
    /// Of each impact, signed.
    pub impulses: Vec<f64>,
    /// Time of the second impact, of families with two.
    pub phi: Option<f64>,
    /// Phase of the force at time 0, as a time.
    pub psi: Option<f64>,
    /// Of the orbit.
    pub period: f64,
    /// Smallest distance to a barrier at a turning point; known of points.
    pub margin: Option<f64>,
    /// Where it is known.
    pub physical: Option<bool>,
    /// Where it is known.
    pub stable: Option<bool>,
    /// Largest modulus of a multiplier; known of points.
    pub spectral_radius: Option<f64>,
}

/// The row of a point, or of an event.
#[must_use]
pub fn branch_row(station: &Station) -> BranchRow {
    let (event, value, orbit, point, physical) = match station {
        Station::Point(point) => (None, point.value, &point.orbit, Some(point), point.physical),
        Station::Event(found) => (Some(found.event), found.value, &found.orbit, None, found.physical),
    };
    let verdict = point.and_then(|point| point.verdict);
    BranchRow {
        event,
        value,
        impulses: orbit.impulses(),
        phi: orbit.phi(),
        psi: orbit.psi(),
        period: orbit.period(),
        margin: point.and_then(|point| point.margin),
        physical,
        stable: verdict.filter(|verdict| !verdict.undecided).map(|verdict| verdict.stable),
        spectral_radius: verdict.map(|verdict| verdict.spectral_radius),
    }
}

impl BranchRow {
    /// Whether the orbits about one of these rows are physical.
    #[must_use]
    pub fn is_physical_about(rows: &[Self], at: usize) -> bool {
        is_physical_about(rows, at, |row| (row.event, row.physical))
    }
}

/// A point of a curve.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveRow {
    /// Of both parameters.
    pub values: [f64; 2],
    /// Known to be so.
    pub physical: bool,
    /// What happens there besides, by its names.
    pub special: Vec<String>,
}

/// Where an orbit's impacts are: a site or a contact.
#[must_use]
pub fn place(orbit: &Orbit, number: usize) -> String {
    match orbit.model() {
        Some(model) => format!("site {}", model.chain().layout().name(number)),
        None => format!("contact {number}"),
    }
}

/// What happens besides at a point of a curve.
pub fn special(curve: &EventCurve, at: usize) -> impl Iterator<Item = &SpecialPoint> {
    curve.special.iter().filter(move |one| one.point == at)
}

/// What the orbits of a curve of grazing have at its event, where it was taken up: which site or contact touches which barrier.
/// Empty of other events.
#[must_use]
pub fn touch(curve: &EventCurve) -> String {
    let Some(orbit) = curve.points.first().map(|point| &point.orbit) else { return String::new() };
    match curve.evidence {
        Evidence::Touch(touch) => format!("{} touches the {} barrier", place(orbit, touch.site), touch.barrier),
        Evidence::Impact(number) => orbit.hits().get(number).map_or(String::new(), |hit| {
            format!("the impact of {} on the {} barrier vanishes", place(orbit, hit.site), hit.barrier)
        }),
        Evidence::Multiplier(_) => String::new(),
    }
}

/// The rows of curves.
#[must_use]
pub fn curve_rows(curves: &[EventCurve]) -> Vec<Vec<CurveRow>> {
    let row = |curve: &EventCurve, (k, point): (usize, &CurvePoint)| CurveRow {
        values: point.values,
        physical: point.physical == Some(true),
        special: special(curve, k).map(|one| one.special.to_string()).collect(),
    };
    curves.iter().map(|curve| curve.points.iter().enumerate().map(|one| row(curve, one)).collect()).collect()
}

/// What the orbits of a branch are called, of which this is one.
#[must_use]
pub fn title(orbit: &Orbit) -> String {
    match (orbit.family(), orbit.force_periods()) {
        _ if orbit.contacts().is_some() => orbit.full_name(),
        // A word that has become that of a family.
        (Family::Word, 1) => Word::of(orbit)
            .family()
            .filter(|family| *family != Family::PeriodDoubled)
            .map_or_else(|| orbit.name(), |family| family.name().to_owned()),
        (Family::Word, periods) => over(&orbit.name(), periods),
        _ => orbit.name(),
    }
}

/// The name of a word of so many periods of the force.
#[must_use]
pub fn over(word: &str, periods: u32) -> String {
    if periods == 1 { word.to_owned() } else { format!("{word} in {periods} periods of the force") }
}

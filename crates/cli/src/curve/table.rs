//! The table of curves of an event in the plane of two parameters: what `mapgen curve` writes, and all that its picture is drawn from.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use vibrochain_floquet::{CurvePoint, EventCurve, Window};
use vibrochain_lattice::Parameter;
use vibrochain_maps::fields::Fields;
use vibrochain_maps::files::CsvFile;
use vibrochain_maps::followed::{CurveRow as Row, special};

use crate::common::error::CliError;

/// The names of the columns for two parameters.
pub(crate) fn header(parameters: [&str; 2]) -> [&str; 12] {
    let [x, y] = parameters;
    ["curve", "event", x, y, "error", "special", "special_error", "angle", "physical", "impulses", "phi", "psi"]
}

/// What varies, and from where to where.
#[derive(Serialize, Deserialize)]
pub(crate) struct Plane {
    #[serde(rename = "free")]
    pub(crate) parameters: [Parameter; 2],
    #[serde(flatten)]
    pub(crate) window: Window,
}

/// What the rows do not say.
#[derive(Serialize, Deserialize)]
pub(crate) struct About<W = Plane> {
    /// That was looked at.
    #[serde(flatten)]
    pub(crate) window: W,
    /// All that is fixed, for people; and the start.
    pub(crate) heading: String,
    pub(crate) parameters: Value,
    /// Of each curve, which site touches which barrier.
    #[serde(default)]
    pub(crate) touches: Vec<String>,
}

/// The points of each curve.
pub(crate) type Rows = Vec<Vec<Row>>;

/// Reads a row of a table.
pub(crate) fn take(curves: &mut Rows, fields: &mut Fields<'_, &str>) -> Result<(), String> {
    let count = curves.len();
    // Curves come one after the other.
    let number = fields.read(|text| text.parse().ok().filter(|number| (count.max(1)..=count + 1).contains(number)))?;
    let _event = fields.text();
    let values = [fields.finite()?, fields.finite()?];
    let _error: Option<f64> = fields.number()?;
    let special = fields.text().split(' ').filter(|name| !name.is_empty()).map(str::to_owned).collect();
    let _errors: [Option<f64>; 2] = [fields.number()?, fields.number()?];
    let physical: Option<bool> = fields.number()?;
    curves.resize_with(number, Vec::new);
    if let Some(curve) = curves.last_mut() {
        curve.push(Row { values, physical: physical == Some(true), special });
    }
    Ok(())
}

/// Writes the points of curves.
pub(crate) fn write(mut table: CsvFile, curves: &[EventCurve]) -> Result<(), CliError> {
    for (i, curve) in curves.iter().enumerate() {
        for (k, point) in curve.points.iter().enumerate() {
            let CurvePoint { values: [x, y], error, angle, physical, orbit } = point;
            let names: Vec<String> = special(curve, k).map(|one| one.special.to_string()).collect();
            let special_error = special(curve, k).next().map(|one| one.error);
            let (number, (phi, psi)) = (i + 1, (orbit.phi(), orbit.psi()));
            table.record(&(
                number,
                curve.event,
                x,
                y,
                error,
                names,
                special_error,
                angle,
                physical,
                orbit.impulses(),
                phi,
                psi,
            ))?;
        }
    }
    Ok(table.finish()?)
}

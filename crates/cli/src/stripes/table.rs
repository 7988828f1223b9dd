//! The table of lines, written and read back.

use vibrochain_breather::Family;
use vibrochain_maps::fields::Fields;
use vibrochain_maps::files::CsvFile;
use vibrochain_maps::numbers::Number;

use crate::common::error::CliError;
use crate::stripes::lines::{Line, LinePoint};

/// The names of its columns.
pub(crate) const COLUMNS: [&str; 9] =
    ["family", "mode1", "mode2", "harmonic", "sum", "gamma2", "omega", "signature_product", "line"];

/// Writes the table; its number of rows.
///
/// # Errors
/// [`CliError`] of a file that cannot be written.
pub(super) fn write(mut table: CsvFile, lines: &[Line]) -> Result<u64, CliError> {
    let mut rows = 0;
    for (line, number) in lines.iter().zip(1..) {
        let (family, (k, l), harmonic) = (line.family, line.modes, line.harmonic);
        // On a sum the multipliers that meet are e^{iΩT} of one mode and e^{−iΩT} of the other.
        let product = if line.sum { -1 } else { 1 };
        for point in &line.points {
            let [gamma2, omega] = [point.gamma2, point.omega].map(|value| Number(value).to_string());
            table.record(&(family.name(), k, l, harmonic, line.sum, gamma2, omega, product, number))?;
            rows += 1;
        }
    }
    table.finish()?;
    Ok(rows)
}

/// Reads a row of it.
///
/// # Errors
/// What is wrong with it.
pub(super) fn take(lines: &mut Vec<Line>, fields: &mut Fields<'_, &str>) -> Result<(), String> {
    let families = [Family::DoubleSided, Family::SingleSided];
    let family = fields.read(|text| families.into_iter().find(|family| family.name() == text))?;
    let modes = (fields.value()?, fields.value()?);
    let (harmonic, sum) = (fields.value()?, fields.value()?);
    let (gamma2, omega) = (fields.finite()?, fields.finite()?);
    let _product: f64 = fields.value()?;
    let count = lines.len();
    // Lines come one after the other.
    let number: usize =
        fields.read(|text| text.parse().ok().filter(|number| (count.max(1)..=count + 1).contains(number)))?;
    if number > count {
        lines.push(Line { family, modes, harmonic, sum, points: Vec::new() });
    }
    if let Some(line) = lines.last_mut() {
        if (line.family, line.modes, line.harmonic, line.sum) != (family, modes, harmonic, sum) {
            refuse!("line {number} is of other modes than in the row before");
        }
        line.points.push(LinePoint { omega, gamma2 });
    }
    Ok(())
}

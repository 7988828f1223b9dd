//! The table of lines, written and read back.

use vibrochain_breather::Family;
use vibrochain_maps::fields::Fields;
use vibrochain_maps::numbers::Number;

use crate::common::error::CliError;
use crate::stripes::lines::{Line, LinePoint};

/// The names of its columns.
pub(crate) const COLUMNS: [&str; 9] =
    ["family", "mode1", "mode2", "harmonic", "sum", "gamma2", "omega", "signature_product", "line"];

/// The table, and its number of rows.
///
/// # Errors
/// [`CliError::Computation`].
pub(super) fn table(lines: &[Line]) -> Result<(Vec<u8>, u64), CliError> {
    let failed = |error: &dyn std::fmt::Display| CliError::Computation(format!("could not write the lines: {error}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(COLUMNS).map_err(|error| failed(&error))?;
    let mut rows = 0;
    for (number, line) in lines.iter().enumerate() {
        let (k, l) = line.modes;
        // On a sum the multipliers that meet are e^{iΩT} of one mode and e^{−iΩT} of the other.
        let product = if line.sum { "-1" } else { "1" };
        for point in &line.points {
            let record = [
                line.family.name().to_owned(),
                k.to_string(),
                l.to_string(),
                line.harmonic.to_string(),
                line.sum.to_string(),
                Number(point.gamma2).to_string(),
                Number(point.omega).to_string(),
                product.to_owned(),
                (number + 1).to_string(),
            ];
            writer.write_record(&record).map_err(|error| failed(&error))?;
            rows += 1;
        }
    }
    Ok((writer.into_inner().map_err(|error| failed(&error))?, rows))
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
            return Err(format!("line {number} is of other modes than in the row before"));
        }
        line.points.push(LinePoint { omega, gamma2 });
    }
    Ok(())
}

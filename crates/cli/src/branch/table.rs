//! The table of a bifurcation diagram: what `mapgen branch` writes, and all that its picture is drawn from.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use vibrochain_floquet::{Event, FollowedBranch, Station};
use vibrochain_lattice::Parameter;
use vibrochain_maps::fields::Fields;
use vibrochain_maps::files::CsvFile;
use vibrochain_maps::followed::{BranchName, BranchRow as Row, branch_row as row};

use crate::common::error::CliError;

pub(crate) const HEADER: &str = "branch,generation,event,value,error,impulse,impulses,phi,psi,period,margin,physical,stable,mechanism,spectral_radius";

/// What the rows do not say.
#[derive(Serialize, Deserialize)]
pub(crate) struct About<F = Parameter> {
    /// What varies.
    pub(crate) free: F,
    /// All that is fixed, for people; and the start.
    pub(crate) heading: String,
    pub(crate) parameters: Value,
    pub(crate) branches: Vec<BranchName>,
}

/// A table with what it is of: the rows of each branch in the order of the way.
pub(crate) struct Table {
    pub(crate) about: About,
    pub(crate) branches: Vec<Vec<Row>>,
}

/// A row of a table, and the number of its branch.
fn read(fields: &mut Fields<'_, &str>, about: &About) -> Result<(usize, Row), String> {
    let number: usize = fields.read(|text| {
        let number = text.parse().ok()?;
        (1..=about.branches.len()).contains(&number).then_some(number)
    })?;
    fields.value::<u32>()?;
    let event = fields.read(|text| match text {
        "" => Some(None),
        text => Event::from_name(text).map(Some),
    })?;
    let value = fields.finite()?;
    let _error: Option<f64> = fields.number()?;
    let _strongest: f64 = fields.value()?;
    let impulses = fields.numbers()?;
    let (phi, psi, period, margin) = (fields.number()?, fields.number()?, fields.finite()?, fields.number()?);
    let (physical, stable) = (fields.number()?, fields.number()?);
    let _mechanism = fields.text();
    let spectral_radius = fields.number()?;
    Ok((number, Row { event, value, impulses, phi, psi, period, margin, physical, stable, spectral_radius }))
}

impl Table {
    /// Reads a row of a table.
    pub(crate) fn take(&mut self, fields: &mut Fields<'_, &str>) -> Result<(), String> {
        let (number, row) = read(fields, &self.about)?;
        self.branches[number - 1].push(row);
        Ok(())
    }
}

/// Writes the rows of branches.
pub(crate) fn write(mut table: CsvFile, branches: &[FollowedBranch]) -> Result<(), CliError> {
    for (i, branch) in branches.iter().enumerate() {
        for station in &branch.stations {
            let (error, mechanism) = match station {
                Station::Point(point) => (None, point.verdict.and_then(|verdict| verdict.mechanism)),
                Station::Event(found) => (Some(found.error), None),
            };
            let Row { event, value, impulses, phi, psi, period, margin, physical, stable, spectral_radius } =
                row(station);
            let strongest = impulses.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0);
            let (number, generation) = (i + 1, branch.generation);
            table.record(&(
                number,
                generation,
                event,
                value,
                error,
                strongest,
                impulses,
                phi,
                psi,
                period,
                margin,
                physical,
                stable,
                mechanism,
                spectral_radius,
            ))?;
        }
    }
    Ok(table.finish()?)
}

//! The table of an ensemble: a row a breather, and one for a cell without any.

use vibrochain_maps::error::MapError;
use vibrochain_maps::grid::Grid;
use vibrochain_maps::numbers::Number;
use vibrochain_maps::table::{ColumnType, Kind};

use crate::end::End;
use crate::fates::{BreatherFates, CellFates};

/// What is told of a cell, before the breather's own.
const OF_CELL: [(&str, Kind); 2] = [("solutions", Kind::Count), ("status", Kind::Word)];

/// What is told of a breather before the shares of its runs, and after them.
const BEFORE: [(&str, Kind); 8] = [
    ("number", Kind::Count),
    ("breather", Kind::Word),
    ("spectral_radius", Kind::Number),
    ("predicted_exponent", Kind::Number),
    ("measured_exponent", Kind::Number),
    ("measured_error", Kind::Number),
    ("starts", Kind::Count),
    ("end", Kind::Word),
];
const AFTER: [(&str, Kind); 5] = [
    ("words", Kind::Text),
    ("left", Kind::Count),
    ("leave_time", Kind::Number),
    ("leave_error", Kind::Number),
    ("chaos_exponent", Kind::Number),
];

/// The columns: the point of a cell, what lives there, and what becomes of one of its breathers, if it has any.
pub(crate) fn types<S: Grid>(scene: &S) -> Vec<ColumnType> {
    let column = |optional| move |(name, kind)| ColumnType { name, kind, optional };
    let named = |(name, kind): (&str, Kind)| (name.to_owned(), kind);
    let places = scene.places().into_iter().map(|parameter| (scene.name_of(parameter), Kind::Number));
    let shares = End::NAMES.iter().map(|name| (format!("share_{}", name.replace('-', "_")), Kind::Number));
    let of_breather = BEFORE.into_iter().map(named).chain(shares).chain(AFTER.into_iter().map(named));
    places.chain(OF_CELL.into_iter().map(named)).map(column(false)).chain(of_breather.map(column(true))).collect()
}

/// The names of the columns.
#[must_use]
pub fn header<S: Grid>(scene: &S) -> Vec<String> {
    types(scene).into_iter().map(|column| column.name).collect()
}

/// The rows of a cell, as they stand in the file.
pub(crate) fn text<S: Grid>(scene: &S, cell: &CellFates) -> Result<Vec<u8>, MapError> {
    let unwritten = |error: &dyn std::fmt::Display| MapError::Computation(format!("could not write a row: {error}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows(scene, cell) {
        writer.write_record(row).map_err(|error| unwritten(&error))?;
    }
    writer.into_inner().map_err(|error| unwritten(&error))
}

/// The rows of a cell, each with its point first.
#[must_use]
pub fn rows<S: Grid>(scene: &S, cell: &CellFates) -> Vec<Vec<String>> {
    let place = scene.point(cell.number);
    let value = |parameter| Number(S::value(&place, parameter)).to_string();
    let point: Vec<String> = scene.places().into_iter().map(value).collect();
    let number = |value: Option<f64>| value.map_or(String::new(), |value| Number(value).to_string());
    let found = || [cell.cell.solutions.to_string(), cell.cell.status.name().to_owned()];
    let row = |of: &BreatherFates| {
        let before = [of.number.to_string(), of.name.clone(), number(of.spectral_radius)];
        let exponents = [
            number(of.predicted),
            number(of.measured.map(|(value, _)| value)),
            number(of.measured.map(|(_, error)| error)),
            of.runs().to_string(),
            of.dominant().map_or(String::new(), |kind| End::NAMES[kind].to_owned()),
        ];
        let shares = (0..End::NAMES.len()).map(|kind| Number(of.share(kind)).to_string());
        let after = [
            of.words_text(),
            of.left.to_string(),
            number(of.leave_time.map(|(mean, _)| mean)),
            number(of.leave_time.and_then(|(_, error)| error)),
            number(of.chaos_exponent),
        ];
        point.iter().cloned().chain(found()).chain(before).chain(exponents).chain(shares).chain(after).collect()
    };
    if cell.breathers.is_empty() {
        let empty = vec![String::new(); BEFORE.len() + End::NAMES.len() + AFTER.len()];
        return vec![point.iter().cloned().chain(found()).chain(empty).collect()];
    }
    cell.breathers.iter().map(row).collect()
}

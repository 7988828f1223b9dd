//! All columns of a table of any scene, and the fields of its rows.

use std::borrow::Cow;

use super::columns::{Column, Kind};
use crate::grid::Grid;

/// The columns of a scene's table: the values of parameters, and what was found there.
#[derive(Debug, Clone)]
pub struct Layout<S: Grid> {
    /// The parameters.
    pub places: Vec<S::Parameter>,
    /// What was found.
    pub columns: Vec<Column<S::Cell>>,
}

/// A column as a file by columns needs to know it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnType {
    /// Its name.
    pub name: String,
    /// What its values are.
    pub kind: Kind,
    /// Whether a row may have none.
    pub optional: bool,
}

impl<S: Grid> Layout<S> {
    /// Of a scene.
    #[must_use]
    pub fn new(scene: &S) -> Self {
        Self { places: scene.places(), columns: scene.columns() }
    }

    /// All columns, in their order.
    #[must_use]
    pub fn types(&self, scene: &S) -> Vec<ColumnType> {
        let place = |place: &S::Parameter| (scene.name_of(*place), Kind::Number, false);
        let found = self.columns.iter().map(|column| (column.name.to_owned(), column.kind, column.optional));
        let all = self.places.iter().map(place).chain(found);
        all.map(|(name, kind, optional)| ColumnType { name, kind, optional }).collect()
    }
}

/// Writes a field, in quotes where it needs them.
#[inline]
pub fn push_text(row: &mut Vec<u8>, text: &str) {
    // All four are bytes of their own.
    if !text.bytes().any(|byte| matches!(byte, b',' | b'"' | b'\r' | b'\n')) {
        return row.extend_from_slice(text.as_bytes());
    }
    row.push(b'"');
    // A row is a line.
    row.extend_from_slice(text.replace('"', "\"\"").replace(['\r', '\n'], " ").as_bytes());
    row.push(b'"');
}

/// The fields of a row.
#[derive(Debug, Clone)]
pub struct Split<'a>(Option<&'a str>);

/// The fields of a row, without their quotes.
#[must_use]
pub fn split(row: &str) -> Split<'_> {
    Split(Some(row))
}

impl<'a> Iterator for Split<'a> {
    type Item = Cow<'a, str>;

    fn next(&mut self) -> Option<Cow<'a, str>> {
        let row = self.0?;
        let Some(quoted) = row.strip_prefix('"') else {
            let (field, rest) = row.split_once(',').map_or((row, None), |(field, rest)| (field, Some(rest)));
            self.0 = rest;
            return Some(field.into());
        };
        let mut end = 0;
        // Two quotes are one, which does not end the field.
        while let Some(at) = quoted[end..].find('"') {
            end += at;
            if !quoted[end + 1..].starts_with('"') {
                break;
            }
            end += 2;
        }
        let ended = quoted.get(end..).is_some_and(|rest| rest.starts_with('"'));
        let rest = quoted.get(end + 1..).filter(|rest| ended && (rest.is_empty() || rest.starts_with(',')));
        let Some(rest) = rest else {
            // The program writes no such quotes: the whole rest is handed on as one field, which the reader of the column refuses.
            self.0 = None;
            return Some(row.into());
        };
        self.0 = rest.strip_prefix(',');
        let field = &quoted[..end];
        Some(if field.contains('"') { field.replace("\"\"", "\"").into() } else { field.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the crate that writes and reads CSV elsewhere.
    #[test]
    fn fields_are_those_of_the_standard() {
        let fields = ["", "0+,0-", "a \"b\", c", "\"", "\"\"", "plain", ",", ""];
        let mut row = Vec::new();
        for field in fields {
            push_text(&mut row, field);
            row.push(b',');
        }
        row.pop();
        let mut written = csv::Writer::from_writer(Vec::new());
        written.write_record(fields).unwrap();
        let text = String::from_utf8(row).unwrap();
        assert_eq!(text.clone() + "\n", String::from_utf8(written.into_inner().unwrap()).unwrap());
        assert_eq!(split(&text).collect::<Vec<_>>(), fields);
        assert_eq!(split("").collect::<Vec<_>>(), [""]);
        for odd in ["\"open", "\"a\"b,c"] {
            assert_eq!(split(odd).collect::<Vec<_>>(), [odd]);
        }
    }
}

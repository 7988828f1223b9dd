//! Rows of a suite, and the table, lists and picture they become.

use std::fmt::Write as _;

use vibrochain_cli::common::error::CliError;
use vibrochain_maps::fields::Fields;

/// Columns of the CSV file.
const COLUMNS: [&str; 6] = ["case", "method", "setting", "seconds", "error", "note"];

/// One method at one setting in one case.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Row {
    pub(super) case: String,
    pub(super) method: String,
    pub(super) setting: String,
    /// Time of one evaluation.
    pub(super) seconds: f64,
    /// Against the truth; 0 if no digit is wrong.
    pub(super) error: f64,
    pub(super) note: String,
}

/// All rows of a suite, cases and methods in the order in which they are to be shown.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Table {
    pub(super) rows: Vec<Row>,
}

/// A number in few digits: measurements have no more.
fn short(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.3e}") }
}

/// Values in order of their first appearance.
fn distinct<'a>(values: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut seen = Vec::new();
    for value in values {
        if !seen.contains(&value) {
            seen.push(value);
        }
    }
    seen
}

impl Table {
    /// The rows as CSV.
    pub(super) fn csv(&self) -> Result<Vec<u8>, CliError> {
        let failed = |error: &dyn std::fmt::Display| CliError::Computation(format!("could not write a table: {error}"));
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(COLUMNS).map_err(|error| failed(&error))?;
        for row in &self.rows {
            let (seconds, error) = (short(row.seconds), short(row.error));
            let record = [&row.case, &row.method, &row.setting, &seconds, &error, &row.note];
            writer.write_record(record).map_err(|error| failed(&error))?;
        }
        writer.into_inner().map_err(|error| failed(&error))
    }

    /// The rows of such a file.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(super) fn read(text: &str) -> Result<Self, String> {
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(text.as_bytes());
        let mut records = reader.records();
        let first = records.next().and_then(Result::ok).unwrap_or_default();
        if first != COLUMNS[..] {
            return Err(format!("its columns are not {}", COLUMNS.join(",")));
        }
        let row = |(number, record): (usize, Result<csv::StringRecord, csv::Error>)| {
            let wrong = |what: String| format!("row {}: {what}", number + 1);
            let record = record.map_err(|error| wrong(error.to_string()))?;
            let mut fields = Fields::of(&COLUMNS, &record).map_err(wrong)?;
            let mut text = || fields.text().to_owned();
            let (case, method, setting) = (text(), text(), text());
            let (seconds, error) = (fields.finite().map_err(wrong)?, fields.finite().map_err(wrong)?);
            Ok(Row { case, method, setting, seconds, error, note: fields.text().to_owned() })
        };
        let rows = records.enumerate().map(row).collect::<Result<_, String>>()?;
        Ok(Self { rows })
    }

    fn cases(&self) -> Vec<&str> {
        distinct(self.rows.iter().map(|row| row.case.as_str()))
    }

    /// A Markdown table: each method at its last setting, the finest or the largest, in the case in which it errs most. The CSV file has all.
    pub(super) fn markdown(&self) -> String {
        let notes = self.rows.iter().any(|row| !row.note.is_empty());
        let mut text = "| method | where it errs most | setting | time | error |".to_owned();
        text.push_str(if notes { " note |\n|---|---|---|---|---|---|\n" } else { "\n|---|---|---|---|---|\n" });
        for method in distinct(self.rows.iter().map(|row| row.method.as_str())) {
            let last = |case: &str| self.rows.iter().rfind(|row| row.method == method && row.case == case);
            let rows = self.cases().into_iter().filter_map(last);
            let Some(row) = rows.max_by(|a, b| a.error.total_cmp(&b.error)) else { continue };
            let time = duration(row.seconds);
            let error = if row.error == 0.0 { "0".to_owned() } else { format!("{:.1e}", row.error) };
            // Writing to a String cannot fail.
            let _ = write!(text, "| {method} | {} | {} | {time} | {error} |", row.case, row.setting);
            let _ = if notes { writeln!(text, " {} |", row.note) } else { writeln!(text) };
        }
        text
    }

    /// The rows as panels of a picture, a case each.
    pub(super) fn picture(&self, title: &str, error: &str) -> crate::accuracy::picture::WorkPrecision {
        let methods = distinct(self.rows.iter().map(|row| row.method.as_str()));
        let points = |case: &str, method: &str| {
            let rows = self.rows.iter().filter(|row| row.case == case && row.method == method);
            rows.map(|row| (row.seconds, row.error)).collect()
        };
        let panel = |case: &str| crate::accuracy::picture::WorkPrecisionPanel {
            caption: case.to_owned(),
            series: methods.iter().map(|method| points(case, method)).collect(),
        };
        crate::accuracy::picture::WorkPrecision {
            title: title.to_owned(),
            error: error.to_owned(),
            panels: self.cases().into_iter().map(panel).collect(),
            methods: methods.iter().map(|&method| method.to_owned()).collect(),
        }
    }
}

/// A time with its unit, two digits or three.
fn duration(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s < 1e-6 => (s * 1e9, "ns"),
        s if s < 1e-3 => (s * 1e6, "µs"),
        s if s < 1.0 => (s * 1e3, "ms"),
        s => (s, "s"),
    };
    if value < 10.0 { format!("{value:.1} {unit}") } else { format!("{value:.0} {unit}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(case: &str, method: &str, error: f64) -> Row {
        let note = if error == 0.0 { "by definition" } else { "" };
        let (case, method, note) = (case.to_owned(), method.to_owned(), note.to_owned());
        Row { case, method, setting: "J = 10, 20".to_owned(), seconds: 1.25e-5, error, note }
    }

    #[test]
    fn rows_become_csv_and_a_table_of_worst_cases() {
        let table = Table { rows: vec![row("a", "x", 2e-4), row("b", "x", 0.0), row("a", "y", 1e-15)] };
        let csv = String::from_utf8(table.csv().unwrap()).unwrap();
        let lines: Vec<_> = csv.lines().collect();
        assert_eq!(lines[0], "case,method,setting,seconds,error,note");
        assert_eq!(lines[1], "a,x,\"J = 10, 20\",1.250e-5,2.000e-4,");
        assert_eq!(lines[2], "b,x,\"J = 10, 20\",1.250e-5,0,by definition");
        assert_eq!(Table::read(&csv), Ok(table.clone()));
        for (old, new, told) in [
            ("method", "way", "its columns are not case,method,setting,seconds,error,note"),
            ("2.000e-4", "few", "row 1: its error is `few`"),
            ("1.250e-5,0", "inf,0", "row 2: its seconds is `inf`"),
            (",by definition", "", "row 2: "),
        ] {
            let told_of = Table::read(&csv.replacen(old, new, 1)).unwrap_err();
            assert!(csv.contains(old) && told_of.starts_with(told), "{told_of}");
        }
        let finer = Row { setting: "J = 40".to_owned(), ..row("a", "x", 1e-9) };
        let markdown = Table { rows: [table.rows, vec![finer]].concat() }.markdown();
        let lines: Vec<_> = markdown.lines().skip(2).collect();
        assert_eq!(lines[0], "| x | a | J = 40 | 12 µs | 1.0e-9 |  |");
        assert!(lines[1].starts_with("| y | a | J = 10, 20 |") && lines.len() == 2, "{lines:?}");
    }

    #[test]
    fn times_have_units() {
        let times = [3.4e-8, 1.25e-5, 0.0201, 3.0].map(duration);
        assert_eq!(times, ["34 ns", "12 µs", "20 ms", "3.0 s"]);
    }
}

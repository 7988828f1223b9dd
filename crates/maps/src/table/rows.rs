//! Rows of a table as text: written, and read back.

use std::borrow::Cow;
use std::ops::Range;

use super::columns::{Column, Value};
use super::fields::{Layout, push_text, split};
use crate::cell::Cell;
use crate::grid::Grid;
use crate::lines::Lines;
use crate::numbers::Number;
use crate::scene::Scene;
use crate::summary::Summary;
use crate::text::clipped;

/// Characters shown of a field that is not as it must be.
const MOST_SHOWN: usize = 40;

/// Room for a row: more than most have.
pub(super) const ROW: usize = 112;

/// The header of a scene's table, as it stands in the file.
#[must_use]
pub fn header<S: Grid>(scene: &S) -> String {
    // Names of plain letters need no quotes.
    Layout::new(scene).types(scene).into_iter().map(|column| column.name).collect::<Vec<_>>().join(",") + "\n"
}

/// Cells that follow each other, and the same as text.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows<T = Cell> {
    /// The numbers of the cells.
    pub range: Range<u64>,
    /// The cells, or what else is known of each, by their numbers. None if only the text is wanted.
    pub cells: Vec<(u64, T)>,
    /// Their rows.
    pub text: Vec<u8>,
}

/// The parameters of cells that follow each other, in digits.
#[derive(Debug)]
struct Places<S: Grid> {
    parameters: Vec<S::Parameter>,
    /// The one that the fastest axis varies.
    fastest: Option<S::Parameter>,
    /// The digits that each parameter had last: all but the fastest axis stand still for a row of the map.
    last: Vec<(Option<u64>, Vec<u8>)>,
}

impl<S: Grid> Places<S> {
    fn new(scene: &S) -> Self {
        let parameters = scene.places();
        let fastest = scene.axes().first().map(|axis| axis.parameter);
        Self { last: vec![(None, Vec::new()); parameters.len()], parameters, fastest }
    }

    /// Those of a point, in the order of the columns; of the fastest axis they may be `known`.
    fn of<'a>(&'a mut self, point: &S::Point, known: Option<&'a [u8]>) -> impl Iterator<Item = &'a [u8]> {
        let Self { parameters, fastest, last } = self;
        parameters.iter().zip(last).map(move |(parameter, (last, digits))| {
            if let Some(known) = known.filter(|_| *fastest == Some(*parameter)) {
                return known;
            }
            let value = S::value(point, *parameter);
            if *last != Some(value.to_bits()) {
                *last = Some(value.to_bits());
                digits.clear();
                Number(value).push(digits);
            }
            digits.as_slice()
        })
    }
}

/// Writes rows of cells; no value is ever written as 0 or NaN for want of one, its field is empty.
#[derive(Debug)]
pub struct Table<S: Grid = Scene> {
    places: Places<S>,
    columns: Vec<Column<S::Cell>>,
    /// The rows written.
    pub text: Vec<u8>,
}

impl<S: Grid> Table<S> {
    /// For rows alone, without the header.
    #[must_use]
    pub fn new(scene: &S) -> Self {
        Self { places: Places::new(scene), columns: scene.columns(), text: Vec::new() }
    }

    /// Writes one cell.
    pub fn write(&mut self, point: &S::Point, cell: &S::Cell) {
        self.write_at(point, None, cell);
    }

    /// The same where the digits of the point's value on the fastest axis are known.
    pub(super) fn write_at(&mut self, point: &S::Point, known: Option<&[u8]>, cell: &S::Cell) {
        for digits in self.places.of(point, known) {
            self.text.extend_from_slice(digits);
            self.text.push(b',');
        }
        for column in &self.columns {
            match (column.get)(cell) {
                Some(Value::Word(text) | Value::Text(text)) => push_text(&mut self.text, text),
                Some(Value::Number(number)) => {
                    Number(number).push(&mut self.text);
                }
                Some(Value::Count(count)) => push_count(&mut self.text, count),
                None => {}
            }
            self.text.push(b',');
        }
        // The last comma ends the row instead.
        if let Some(last) = self.text.last_mut() {
            *last = b'\n';
        }
    }
}

/// Writes a count, without room on the heap.
#[inline]
fn push_count(text: &mut Vec<u8>, count: u64) {
    // As numbers of solutions are.
    if count < 10 {
        return text.push(b'0' + count as u8);
    }
    // As many digits as the largest has.
    let mut digits = [0; 20];
    let (mut first, mut rest) = (digits.len(), count);
    loop {
        first -= 1;
        digits[first] = b'0' + (rest % 10) as u8;
        rest /= 10;
        if rest == 0 {
            break;
        }
    }
    text.extend_from_slice(&digits[first..]);
}

/// Reads rows against the cells they must be of, and counts them.
#[derive(Debug)]
pub struct Reader<'a, S: Grid = Scene> {
    scene: &'a S,
    cells: Range<u64>,
    next: u64,
    places: Places<S>,
    columns: Vec<Column<S::Cell>>,
    lines: Lines,
    counts: Summary,
}

impl<'a, S: Grid> Reader<'a, S> {
    /// For the rows of the cells numbered `cells`.
    pub fn new(scene: &'a S, cells: Range<u64>) -> Self {
        let (next, places) = (cells.start, Places::new(scene));
        let columns = scene.columns();
        Self { scene, cells, next, places, columns, lines: Lines::default(), counts: Summary::default() }
    }

    /// Reads the rows in `bytes`, which may end anywhere, and hands each cell with its number to `each`. What a table does not
    /// hold, such as residuals, is not in these cells.
    ///
    /// # Errors
    /// What is wrong with the first row that is not as it must be.
    pub fn take(&mut self, bytes: &[u8], mut each: impl FnMut(u64, &S::Cell)) -> Result<(), String> {
        let Self { scene, cells, next, places, columns, lines, counts } = self;
        lines.take(bytes, |row| {
            let number = counts.computed + 1;
            ensure!(cells.contains(next), "it has more rows than its {} cells", cells.end - cells.start);
            let mut read = || {
                let row = std::str::from_utf8(row).map_err(|_| "it is no text".to_owned())?;
                let mut fields = split(row);
                check_places(&mut fields, places.of(&scene.point(*next), None))?;
                read_cell(fields, columns, S::untold())
            };
            let cell = read().map_err(|wrong| format!("row {number}: {wrong}"))?;
            counts.count(&scene.shown(&cell));
            each(*next, &cell);
            *next += 1;
            Ok(())
        })
    }

    /// The counts of the rows, if that was every row.
    ///
    /// # Errors
    /// What is missing.
    pub fn whole(self) -> Result<Summary, String> {
        let Self { cells, next, lines, counts, .. } = self;
        if next != cells.end || !lines.ended() {
            refuse!("it has {} rows for {} cells", next - cells.start, cells.end - cells.start);
        }
        Ok(counts)
    }

    /// Tells whether that was every row, and as many of each class and status as in `summary`.
    ///
    /// # Errors
    /// What is wrong.
    pub fn finish(self, summary: &Summary) -> Result<(), String> {
        let counts = self.whole()?;
        if (counts.classes, counts.statuses, counts.absences, counts.slow)
            != (summary.classes, summary.statuses, summary.absences, summary.slow)
        {
            refuse!("its counts are not those of its rows");
        }
        Ok(())
    }
}

/// Whether the first fields of a row are `places`, or what is wrong with them.
fn check_places<'a, 'b>(
    fields: &mut impl Iterator<Item = Cow<'a, str>>,
    mut places: impl Iterator<Item = &'b [u8]>,
) -> Result<(), String> {
    places.try_for_each(|digits| match fields.next().ok_or("it ends before its class")? {
        text if text.as_bytes() == digits => Ok(()),
        text => {
            let digits = String::from_utf8_lossy(digits);
            Err(format!("it is of the cell at {} and not at {digits}", clipped(&text, MOST_SHOWN)))
        }
    })
}

/// The cell that the other fields tell of, or what is wrong with them.
fn read_cell<'a, T>(
    mut fields: impl Iterator<Item = Cow<'a, str>>,
    columns: &[Column<T>],
    mut cell: T,
) -> Result<T, String> {
    for column in columns {
        let text = fields.next().ok_or_else(|| format!("it ends before its {}", column.name))?;
        if text.is_empty() && column.optional {
            continue;
        }
        let value = column.kind.value(&text);
        value
            .and_then(|value| (column.set)(&mut cell, value))
            .ok_or_else(|| format!("its {} is `{}`", column.name, clipped(&text, MOST_SHOWN)))?;
    }
    match fields.next() {
        None => Ok(cell),
        Some(more) => Err(format!("it goes on after its last column with `{}`", clipped(&more, MOST_SHOWN))),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::cell::Worker;
    use crate::table::RowWriter;

    const SCENE: &str = r#"
        [model]
        sites = 5
        gamma1 = 0.2
        [sweep]
        axes = [
            { parameter = "omega", from = 0.4, to = 3.0, points = 40 },
            { parameter = "gamma2", from = 0.0, to = 0.3, points = 4 },
            { parameter = "asymmetry", values = [0.4, 0.1] },
        ]
        [compute]
        families = ["double-sided", "single-sided"]
        stability = true
        collisions = true
        impulse = true
    "#;

    /// With digits that are known and without.
    #[test]
    fn rows_are_the_same_whoever_has_the_digits() {
        let scene = Scene::parse(Path::new("scene.toml"), SCENE).unwrap();
        let cells = vec![Cell::EMPTY; scene.cells() as usize];
        for range in [0..scene.cells(), 7..9, 39..121] {
            let mut table = Table::new(&scene);
            range.clone().for_each(|number| table.write(&scene.point(number), &Cell::EMPTY));
            let some = &cells[..(range.end - range.start) as usize];
            for keep in [false, true] {
                let rows = RowWriter::new(&scene, keep).rows(range.clone(), some);
                assert_eq!(rows.text, table.text);
                assert_eq!(rows.cells.len(), if keep { some.len() } else { 0 });
            }
        }
    }

    /// The rows of some cells, and their counts.
    fn rows(scene: &Scene, range: Range<u64>) -> (String, Summary) {
        let mut worker = Worker::new(scene.base.sites());
        let cell = |number| worker.cell(&scene.point(number).model().unwrap(), &scene.task);
        let cells: Vec<Cell> = range.clone().map(cell).collect();
        let rows = RowWriter::new(scene, false).rows(range, &cells);
        (String::from_utf8(rows.text).unwrap(), Summary::of(&cells))
    }

    fn read(scene: &Scene, range: Range<u64>, rows: &str, summary: &Summary) -> Result<(), String> {
        let mut reader = Reader::new(scene, range);
        // In pieces that end anywhere.
        rows.as_bytes().chunks(37).try_for_each(|piece| reader.take(piece, |_, _| {}))?;
        reader.finish(summary)
    }

    #[test]
    fn counts_are_written_as_the_standard_library_does() {
        for count in [0, 1, 9, 10, 11, 99, 100, 12_799, 1 << 32, u64::MAX] {
            let mut text = b"x".to_vec();
            push_count(&mut text, count);
            assert_eq!(text, format!("x{count}").as_bytes());
        }
    }

    #[test]
    fn what_is_written_reads_back_and_every_change_of_a_field_is_seen() {
        let scene = Scene::parse(Path::new("scene.toml"), SCENE).unwrap();
        let range = 30..290;
        let (text, summary) = rows(&scene, range.clone());
        assert_eq!(read(&scene, range.clone(), &text, &summary), Ok(()));
        assert!(read(&scene, 31..291, &text, &summary).unwrap_err().starts_with("row 1: it is of the cell at "));
        assert!(read(&scene, 30..289, &text, &summary).unwrap_err().contains("more rows than its 259 cells"));
        assert_eq!(read(&scene, 30..291, &text, &summary).unwrap_err(), "it has 260 rows for 261 cells");
        assert_eq!(
            read(&scene, range.clone(), text.trim_end(), &summary).unwrap_err(),
            "it has 259 rows for 260 cells"
        );
        let mut other = summary.clone();
        other.classes.rotate_left(1);
        assert_eq!(read(&scene, range.clone(), &text, &other).unwrap_err(), "its counts are not those of its rows");

        let lines: Vec<&str> = text.lines().collect();
        let mut changed = 0;
        for (i, line) in lines.iter().enumerate().step_by(7) {
            let fields: Vec<&str> = line.split(',').collect();
            assert_eq!(fields.len(), header(&scene).split(',').count());
            let with = |line: &str| [&lines[..i], &[line], &lines[i + 1..]].concat().join("\n") + "\n";
            let refused = |line: &str| {
                let wrong = read(&scene, range.clone(), &with(line), &summary);
                assert!(wrong.is_err_and(|wrong| wrong.starts_with(&format!("row {}: ", i + 1))), "{line}");
            };
            for column in 0..fields.len() {
                for value in ["NaN", "inf", "-inf", "1e999", "0x1", "none at all", "\u{1b}"] {
                    let mut fields = fields.clone();
                    fields[column] = value;
                    refused(&fields.join(","));
                    changed += 1;
                }
                // One column fewer; all after it stand under other names.
                refused(&[&fields[..column], &fields[column + 1..]].concat().join(","));
            }
            refused(&format!("{line},"));
            refused("");
        }
        assert!(changed > 2000, "{changed}");
    }
}

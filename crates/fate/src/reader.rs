//! Rows of an ensemble's table, read back.

use std::collections::BTreeMap;
use std::ops::Range;
use std::str::FromStr;
use std::sync::Arc;

use vibrochain_breather::Word;
use vibrochain_maps::cell::{Cell, Status};
use vibrochain_maps::fields::Fields;
use vibrochain_maps::grid::Grid;
use vibrochain_maps::lines::Lines;
use vibrochain_maps::numbers::Number;
use vibrochain_maps::summary::Summary;
use vibrochain_maps::sweep::ReadRows;

use crate::end::End;
use crate::fates::{BreatherFates, CellFates};
use crate::table::header;

/// What a table tells of a cell: no class, no residual.
const UNTOLD: Cell = Cell { class: None, ..Cell::EMPTY };

/// Reads rows against the cells they must be of, and counts these.
#[derive(Debug)]
pub struct Reader<'a, S> {
    rows: Rows<'a, S>,
    lines: Lines,
}

/// What a reader knows besides the line that has begun.
#[derive(Debug)]
struct Rows<'a, S> {
    scene: &'a S,
    cells: Range<u64>,
    starts: u64,
    header: Arc<[String]>,
    /// Rows read.
    row: u64,
    /// The next cell.
    next: u64,
    /// The one before it, which may have more rows.
    current: Option<CellFates>,
    counts: Summary,
}

impl<'a, S: Grid> Reader<'a, S> {
    /// For the rows of the cells numbered `cells`, with `starts` runs from each breather.
    pub(crate) fn new(scene: &'a S, cells: Range<u64>, starts: u64) -> Self {
        let (next, counts) = (cells.start, Summary::default());
        let rows = Rows { scene, cells, starts, header: header(scene).into(), row: 0, next, current: None, counts };
        Self { rows, lines: Lines::default() }
    }
}

impl<S: Grid> ReadRows<CellFates> for Reader<'_, S> {
    fn take(&mut self, bytes: &[u8], each: &mut dyn FnMut(u64, &CellFates)) -> Result<(), String> {
        let Self { rows, lines } = self;
        lines.take(bytes, |line| {
            rows.row += 1;
            rows.take(line, each).map_err(|wrong| format!("row {}: {wrong}", rows.row))
        })
    }

    fn whole(self, each: &mut dyn FnMut(u64, &CellFates)) -> Result<Summary, String> {
        let Self { mut rows, lines } = self;
        rows.hand_on(each);
        let (begin, end) = (rows.cells.start, rows.cells.end);
        ensure!(rows.next == end && lines.ended(), "it has rows of {} cells for {}", rows.next - begin, end - begin);
        Ok(rows.counts)
    }

    /// (A table tells no class of its cells.)
    fn finish(self, summary: &Summary, each: &mut dyn FnMut(u64, &CellFates)) -> Result<(), String> {
        ensure!(self.whole(each)?.statuses == summary.statuses, "its counts are not those of its rows");
        Ok(())
    }
}

impl<S: Grid> Rows<'_, S> {
    fn hand_on(&mut self, each: &mut dyn FnMut(u64, &CellFates)) {
        if let Some(cell) = self.current.take() {
            self.counts.count(&cell.cell);
            each(cell.number, &cell);
        }
    }

    fn take(&mut self, line: &[u8], each: &mut dyn FnMut(u64, &CellFates)) -> Result<(), String> {
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(line);
        let record = reader.records().next().and_then(Result::ok).ok_or("it is no row")?;
        let header = Arc::clone(&self.header);
        let mut fields = Fields::of(&header, &record)?;
        let mut digits = Vec::new();
        for parameter in self.scene.places() {
            digits.push((parameter, fields.text()));
        }
        let scene = self.scene;
        let is_at = |cell: u64| {
            let point = scene.point(cell);
            digits.iter().all(|(parameter, text)| Number(S::value(&point, *parameter)).to_string() == *text)
        };
        let solutions = fields.value()?;
        let status = fields.read(Status::from_name)?;
        let breather = self.breather(&mut fields)?;
        // Breathers of a cell have rising numbers.
        if let (Some(cell), Some(breather)) = (&mut self.current, &breather)
            && is_at(cell.number)
            && cell.breathers.last().is_some_and(|last| last.number < breather.number)
        {
            if (cell.cell.solutions, cell.cell.status) != (solutions, status) {
                refuse!("it tells another status of the cell than the row before");
            }
            cell.breathers.extend([breather.clone()]);
            return Ok(());
        }
        self.hand_on(each);
        ensure!(self.cells.contains(&self.next), "it is of more than its {} cells", self.cells.end - self.cells.start);
        ensure!(is_at(self.next), "it is of another cell");
        let cell = Cell { solutions, status, ..UNTOLD };
        self.current = Some(CellFates { number: self.next, cell, breathers: breather.into_iter().collect() });
        self.next += 1;
        Ok(())
    }

    /// The fields after the status; none of a cell without a breather.
    fn breather(&self, fields: &mut Fields<'_, String>) -> Result<Option<BreatherFates>, String> {
        let Some(number) = fields.number()? else { return Ok(None) };
        let name = fields.text().to_owned();
        let (spectral_radius, predicted) = (fields.number()?, fields.number()?);
        let measured = fields.pair()?;
        let starts: u64 = fields.value()?;
        ensure!(starts == self.starts, "it is of {starts} runs and not of {}", self.starts);
        let dominant = fields.text().to_owned();
        let mut ends = [0; End::NAMES.len()];
        for count in &mut ends {
            let share: f64 = fields.value()?;
            // A share is a count over the starts, to the last digit.
            *count = (share * starts as f64).round() as u32;
        }
        let words = fields.text();
        let words = words.split("; ").filter(|text| !text.is_empty()).map(|text| {
            let (word, count) = text.rsplit_once(' ')?;
            Some((Word::from_str(word).ok()?, count.parse().ok()?))
        });
        let words: Option<BTreeMap<Word, u32>> = words.collect();
        let words = words.ok_or("its words are none")?;
        let left = fields.value()?;
        let (leave, leave_error) = (fields.number()?, fields.number()?);
        let breather = BreatherFates {
            number,
            name,
            spectral_radius,
            predicted,
            measured,
            ends,
            words,
            left,
            leave_time: leave.map(|mean| (mean, leave_error)),
            chaos_exponent: fields.number()?,
        };
        let told = breather.dominant().map_or("", |kind| End::NAMES[kind]);
        ensure!(u64::from(breather.runs()) == starts && told == dominant, "its shares are not those of its runs");
        Ok(Some(breather))
    }
}

//! The legend of a panel: it stands above, where it hides nothing. Lines differ in colour, lightness and dashes, points in shape.

use crate::backend::drawing::{BLACK, Drawing, Place};
use crate::backend::page::Page;
use crate::panels::curves::Series;
use crate::panels::pane::{mark, stroke};
use crate::text::font::width;

/// In em: the height of a row, a line of text with air; the length of a sample, in which two dashes are seen; the air beside it, and
/// between entries, of which the second is plainly wider.
const ROW: f64 = 1.6;
const SAMPLE: f64 = 2.3;
const BESIDE: f64 = 0.5;
const BETWEEN: f64 = 1.5;

/// The entries of a legend, in as many rows as they need.
pub(crate) struct Legend<'a> {
    /// Row, place from the left, and what it tells of.
    entries: Vec<(usize, f64, &'a Series)>,
    rows: usize,
    em: f64,
}

impl<'a> Legend<'a> {
    pub(crate) fn of(series: &[&'a Series], room: f64, em: f64) -> Self {
        let (mut x, mut row, mut entries) = (0.0, 0, Vec::new());
        for entry in series {
            let wide = (SAMPLE + BESIDE + width(&entry.name)) * em;
            if x > 0.0 && x + wide > room {
                (x, row) = (0.0, row + 1);
            }
            entries.push((row, x, *entry));
            x += wide + BETWEEN * em;
        }
        let rows = if entries.is_empty() { 0 } else { row + 1 };
        Self { entries, rows, em }
    }

    pub(crate) fn height(&self) -> f64 {
        ROW * self.em * self.rows as f64
    }

    pub(crate) fn draw(&self, drawing: &mut Drawing, [left, top]: Place, page: &Page) {
        let em = self.em;
        for (row, x, series) in &self.entries {
            let (x, y) = (left + x, top + (*row as f64 + 0.5) * ROW * em);
            if let Some(line) = stroke(series, page) {
                drawing.line(vec![[x, y], [x + SAMPLE * em, y]], line);
            }
            mark(drawing, series, [x + 0.5 * SAMPLE * em, y], page);
            drawing.words(&series.name, [x + (SAMPLE + BESIDE) * em, y], em, BLACK);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::panels::curves::{Mark, Stroke};

    #[test]
    fn a_legend_breaks_into_rows_where_the_panel_ends() {
        let entry = |i: usize| Series {
            name: format!("a name of some length {i}"),
            colour: 1,
            stroke: Stroke::Dashed(2),
            mark: Mark::Hollow(3),
            points: Vec::new(),
        };
        let entries: Vec<_> = (0..5).map(entry).collect();
        let entries: Vec<&Series> = entries.iter().collect();
        let legend = Legend::of(&entries, 500.0, 15.0);
        assert_eq!((legend.entries.len(), legend.rows), (5, 3));
        assert!(legend.entries.iter().all(|(_, x, _)| *x < 500.0) && Legend::of(&[], 600.0, 15.0).rows == 0);
    }
}

//! How much of the instability lies next to a predicted line, beside what chance would give: shares of cells, and of cuts, runs
//! of such cells along a row. A stripe may be wider than three cells, and a cut through it still meets its line, be it where
//! the breather has ceased to be.

use std::fmt::Write as _;

use vibrochain_breather::Family;
use vibrochain_cli::stripes::StripeRows;
use vibrochain_plot::Tile;

use crate::stripes::cuts::{Group, family};
use crate::stripes::lines::{Crossing, Rows};

/// The lines compared.
const KINDS: [&str; 4] = ["sums", "differences", "bare sums", "bare differences"];

/// Cells within one cell of some lines.
fn marked(map: &StripeRows, crossings: &[Crossing], is: impl Fn(&Crossing) -> bool) -> Vec<bool> {
    let (columns, rows) = (map.omega.points, map.gamma2.points);
    let mut near = vec![false; columns * rows];
    for crossing in crossings.iter().filter(|crossing| is(crossing)) {
        let (low, high) = ((crossing.place - 1.0).ceil().max(0.0), (crossing.place + 1.0).floor());
        if high < 0.0 {
            continue;
        }
        for row in crossing.row.saturating_sub(1)..=(crossing.row + 1).min(rows - 1) {
            for column in low as usize..=(high as usize).min(columns - 1) {
                near[map.cell(row, column)] = true;
            }
        }
    }
    near
}

/// Cells with a mark in their own row or in one beside it.
fn widened(map: &StripeRows, marks: &[bool]) -> Vec<bool> {
    let (columns, rows) = (map.omega.points, map.gamma2.points);
    let mut near = vec![false; marks.len()];
    for (cell, _) in marks.iter().enumerate().filter(|(_, mark)| **mark) {
        let (row, column) = (cell / columns, cell % columns);
        (row.saturating_sub(1)..=(row + 1).min(rows - 1)).for_each(|row| near[map.cell(row, column)] = true);
    }
    near
}

/// The table that is printed.
pub(super) fn evidence(map: &StripeRows, tiles: &[Tile], rows: &Rows) -> String {
    let layout = map.scene.base.layout;
    let mut text = format!("{layout}: share of cells within one cell of a line\n");
    let bare = rows.bare.each_ref().map(|marks| widened(map, marks));
    for of in [Family::DoubleSided, Family::SingleSided] {
        let here: Vec<(usize, &Tile)> = tiles.iter().enumerate().filter(|(_, tile)| family(tile) == Some(of)).collect();
        if here.is_empty() {
            continue;
        }
        let double = of == Family::DoubleSided;
        let lines = |sum: bool, beyond: bool| {
            let is = |met: &Crossing| met.key.double == double && met.key.sum == sum && (beyond || !met.beyond);
            marked(map, &rows.crossings, is)
        };
        let [sums, differences] = &bare;
        let near = [&lines(true, false), &lines(false, false), sums, differences];
        let anywhere = lines(true, true);
        // Writing to a String cannot fail.
        let _ = write!(text, "\n{:<16} {:>8}", of.name(), "cells");
        for name in KINDS {
            let _ = write!(text, " {name:>16}");
        }
        let _ = writeln!(text, " {:>8} {:>16} {:>16}", "cuts", "cuts with a sum", "carried on");
        for group in Group::ALL {
            let cells: Vec<usize> = here.iter().filter(|(_, tile)| group.has(tile)).map(|(cell, _)| *cell).collect();
            if cells.is_empty() {
                continue;
            }
            let share = |count: usize, all: usize| 100.0 * count as f64 / all as f64;
            let of_cells = |marks: &[bool]| share(cells.iter().filter(|&&cell| marks[cell]).count(), cells.len());
            let _ = write!(text, "  {:<14} {:>8}", group.name(), cells.len());
            for marks in near {
                let _ = write!(text, " {:>14.1} %", of_cells(marks));
            }
            // Cells side by side in a row are one cut through a stripe.
            let cuts: Vec<_> = rows.cuts.iter().filter(|cut| cut.double == double && cut.group == group).collect();
            let any = |row: usize, (from, to): (usize, usize), marks: &[bool]| {
                marks[map.cell(row, from)..=map.cell(row, to)].contains(&true)
            };
            let met = cuts.iter().filter(|cut| any(cut.row, (cut.first, cut.last), near[0])).count();
            let carried = cuts.iter().filter(|cut| any(cut.row, (cut.from, cut.to), &anywhere)).count();
            let _ = write!(text, " {:>8}", cuts.len());
            for count in [met, carried] {
                let _ = write!(text, " {:>14.1} %", share(count, cuts.len()));
            }
            text.push('\n');
        }
    }
    text
}

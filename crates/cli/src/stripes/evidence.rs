//! How much of the instability lies next to a predicted line, beside what chance would give: shares of cells, and of cuts, runs
//! of such cells along a row. A stripe may be wider than three cells, and a cut through it still meets its line.

use std::fmt::Write as _;

use vibrochain_breather::Family;
use vibrochain_floquet::Mechanism;

use crate::cell::Class;
use crate::plot::Tile;
use crate::stripes::family;
use crate::stripes::lines::{Crossing, Key, Modes};
use crate::stripes::request::Request;

/// The lines compared: name, and which they are.
type Kind = (&'static str, fn(&Key, bool) -> bool);

const KINDS: [Kind; 4] = [
    ("sums", |key, double| key.modes == Modes::Dressed && key.sum && key.double == double),
    ("differences", |key, double| key.modes == Modes::Dressed && !key.sum && key.double == double),
    ("bare sums", |key, _| key.modes == Modes::Bare && key.sum),
    ("bare differences", |key, _| key.modes == Modes::Bare && !key.sum),
];

/// Rows of the table: name, and which cells they count.
type Group = (&'static str, fn(&Tile) -> bool);

const GROUPS: [Group; 4] = [
    ("neimark-sacker", |tile| tile.mechanism == Some(Mechanism::NeimarkSacker)),
    ("period-doubling", |tile| tile.mechanism == Some(Mechanism::PeriodDoubling)),
    ("pitchfork", |tile| tile.mechanism == Some(Mechanism::Pitchfork)),
    ("stable", |tile| matches!(tile.class, Some(Class::StableDouble | Class::StableSingle))),
];

/// Cells within one cell of some lines.
fn marked(request: &Request, crossings: &[Crossing], is: impl Fn(&Key) -> bool) -> Vec<bool> {
    let (columns, rows) = (request.omega.points, request.gamma2.points);
    let mut near = vec![false; columns * rows];
    for crossing in crossings.iter().filter(|crossing| is(&crossing.key)) {
        let (low, high) = ((crossing.place - 1.0).ceil().max(0.0), (crossing.place + 1.0).floor());
        if high < 0.0 {
            continue;
        }
        for row in crossing.row.saturating_sub(1)..=(crossing.row + 1).min(rows - 1) {
            for column in low as usize..=(high as usize).min(columns - 1) {
                near[request.cell(row, column)] = true;
            }
        }
    }
    near
}

/// The table that is printed.
pub(super) fn evidence(request: &Request, tiles: &[Tile], crossings: &[Crossing]) -> String {
    let mut text = format!("N = {}: share of cells within one cell of a line\n", request.scene.base.sites - 1);
    for of in [Family::DoubleSided, Family::SingleSided] {
        let here: Vec<(usize, &Tile)> = tiles.iter().enumerate().filter(|(_, tile)| family(tile) == Some(of)).collect();
        if here.is_empty() {
            continue;
        }
        let near = KINDS.map(|(_, is)| marked(request, crossings, |key| is(key, of == Family::DoubleSided)));
        // Writing to a String cannot fail.
        let _ = write!(text, "\n{:<16} {:>8}", of.name(), "cells");
        for (name, _) in KINDS {
            let _ = write!(text, " {name:>16}");
        }
        let _ = writeln!(text, " {:>8} {:>16}", "cuts", "cuts with a sum");
        for (name, is) in GROUPS {
            let cells: Vec<usize> = here.iter().filter(|(_, tile)| is(tile)).map(|(cell, _)| *cell).collect();
            if cells.is_empty() {
                continue;
            }
            // Cells side by side in a row are one cut through a stripe.
            let columns = request.omega.points;
            let joins = |a: &usize, b: &usize| a + 1 == *b && !b.is_multiple_of(columns);
            let cuts: Vec<&[usize]> = cells.chunk_by(joins).collect();
            let share = |count: usize, all: usize| 100.0 * count as f64 / all as f64;
            let _ = write!(text, "  {name:<14} {:>8}", cells.len());
            for near in &near {
                let _ =
                    write!(text, " {:>14.1} %", share(cells.iter().filter(|&&cell| near[cell]).count(), cells.len()));
            }
            let met = cuts.iter().filter(|cut| cut.iter().any(|&cell| near[0][cell])).count();
            let _ = writeln!(text, " {:>8} {:>14.1} %", cuts.len(), share(met, cuts.len()));
        }
    }
    text
}

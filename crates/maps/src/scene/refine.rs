//! How a scene's grid is refined where its cells differ.

use serde::Serialize;
use toml::Spanned;

use crate::error::MapError;
use crate::scene::axis::{Axis, MAX_POINTS, Values};
use crate::scene::file::RefineTable;
use crate::scene::source::Source;

/// The most halvings: a cell is then 65 536 of the finest grid, and each of its sides 256 of them.
const MAX_DEPTH: u32 = 8;

/// The most cells of the grid that is refined: what is known of each waits in memory for its neighbours, 200 bytes.
const MAX_REFINED: u64 = 1_000_000;

/// How a scene's grid is refined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Refine {
    /// How often a cell may be halved along both axes.
    pub depth: u32,
}

impl Refine {
    /// Sides of a cell that is not refined, in cells of the finest grid.
    #[must_use]
    pub fn size(self) -> u32 {
        1 << self.depth
    }

    pub(super) fn of(
        table: &Spanned<RefineTable>,
        axes: &[Axis],
        (cells, most): (u64, u64),
        source: &Source<'_>,
    ) -> Result<Self, MapError> {
        let given = &table.get_ref().depth;
        let depth = *given.get_ref();
        let Some(depth) = u32::try_from(depth).ok().filter(|depth| (1..=MAX_DEPTH).contains(depth)) else {
            let message = format!(
                "depth = {depth} is out of range: give how often a cell may be halved, 1 to {MAX_DEPTH}; for a grid without \
                 refinement leave refine out"
            );
            return Err(source.error(given.span(), message));
        };
        let [x, y] = axes else {
            let message = format!(
                "refine is of maps over two axes, here {}: leave it out, or fix the others",
                if axes.len() == 1 { "is one".to_owned() } else { format!("are {}", axes.len()) }
            );
            return Err(source.error(table.span(), message));
        };
        for axis in [x, y] {
            let name = axis.parameter.name();
            let Values::Linear { points, .. } = axis.values else {
                let message = format!(
                    "refine halves equally spaced axes, {name} is none: give from, to and points, or leave it out"
                );
                return Err(source.error(table.span(), message));
            };
            if points > MAX_POINTS >> depth {
                let message = format!(
                    "refined {depth} times, {points} points of {name} would be {} on the finest grid, more than {MAX_POINTS}: \
                     give a smaller depth or fewer points",
                    (points as u64) << depth
                );
                return Err(source.error(table.span(), message));
            }
        }
        if cells > MAX_REFINED {
            let message = format!(
                "the grid that is refined has {cells} cells, more than {MAX_REFINED}: give fewer points, and a larger depth instead"
            );
            return Err(source.error(table.span(), message));
        }
        if cells << (2 * depth) > most {
            let message = format!("the finest grid has more than {most} cells: give a smaller depth or fewer points");
            return Err(source.error(table.span(), message));
        }
        Ok(Self { depth })
    }
}

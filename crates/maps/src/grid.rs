//! A scene as sweeps, chunks and tables see it: numbered cells, each at a point, with columns of what is found there.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::ops::Range;
use std::path::Path;

use serde_json::{Map, Value};
use vibrochain_floquet::Tolerance;
use vibrochain_lattice::Stop;

use crate::cell::{Cell, Class};
use crate::error::MapError;
use crate::scene::Axis;
use crate::table::columns::Column;

/// The texts of files that a scene names, by their names in it.
pub type Files = BTreeMap<String, String>;

/// A checked scene over a grid of cells.
pub trait Grid: Clone + Debug + Send + Sync + 'static {
    /// What its axes vary.
    type Parameter: Copy + Debug + PartialEq + Send + Sync;
    /// Where a cell is.
    type Point;
    /// What is found in a cell.
    type Cell: Clone + Debug + Send + Sync;
    /// What one thread computes cells with.
    type Worker;

    /// The most bytes of its text.
    const MOST_BYTES: u64;

    /// The most bytes of a file that it names.
    const MOST_FILE_BYTES: u64 = 0;

    /// Whether a text is a scene of this kind, right or wrong.
    fn is_one(text: &str) -> bool;

    /// Checks a scene's text. Files that it names are those `kept`, or else those beside `path`, which is for messages, too.
    ///
    /// # Errors
    /// [`MapError::Request`].
    fn parse(path: &Path, text: &str, kept: &Files) -> Result<Self, MapError>;

    /// The files that it names.
    fn files(&self) -> Files {
        Files::new()
    }

    /// Its title, if it has one.
    fn title(&self) -> Option<&str>;

    /// All that decides what its table holds, as manifests have it.
    fn parts(&self) -> Map<String, Value>;

    /// What follows from that and explains the table: keys for a manifest, and lines for people.
    fn explained(&self) -> (Map<String, Value>, Vec<String>) {
        (Map::new(), Vec::new())
    }

    /// The same for all scenes that mean the same, whatever words they have for it.
    fn meaning(&self) -> Map<String, Value> {
        self.parts()
    }

    /// The axes, the fastest first.
    fn axes(&self) -> &[Axis<Self::Parameter>];

    /// Number of cells.
    fn cells(&self) -> u64 {
        self.axes().iter().map(|axis| axis.points() as u64).product()
    }

    /// Cells of a chunk: a fraction of a second of work, which an interruption may cost.
    fn chunk_cells(&self) -> u64;

    /// The most cells that a thread takes at a time.
    fn block(&self) -> u64;

    /// Whether a map can be made of it.
    ///
    /// # Errors
    /// What is missing.
    fn is_map(&self) -> Result<(), String> {
        Ok(())
    }

    /// From which excess on an orbit counts as unstable; `None` where stability is not asked for.
    fn tolerance(&self) -> Option<Tolerance>;

    /// Another one, of the command line.
    fn set_tolerance(&mut self, tolerance: Tolerance);

    /// The parameters that have a column, in the order of the table.
    fn places(&self) -> Vec<Self::Parameter>;

    /// The name of such a column.
    fn name_of(&self, parameter: Self::Parameter) -> String;

    /// The value of a parameter at a point.
    fn value(point: &Self::Point, parameter: Self::Parameter) -> f64;

    /// The point of cell number `cell`, counted along the first axis first.
    fn point(&self, cell: u64) -> Self::Point;

    /// Shows the points of some neighbouring cells, in order, as long as it is told to go on.
    fn walk(&self, cells: Range<u64>, mut go_on: impl FnMut(&Self::Point) -> bool) {
        for cell in cells {
            if !go_on(&self.point(cell)) {
                return;
            }
        }
    }

    /// The columns after the parameters.
    fn columns(&self) -> Vec<Column<Self::Cell>>;

    /// A cell of which no column has told yet.
    fn untold() -> Self::Cell;

    /// What counts and pictures have of a cell.
    fn shown(&self, cell: &Self::Cell) -> Cell;

    /// The name of a class in the column `class`.
    fn class_name(class: Class) -> &'static str;

    /// A thread's.
    fn worker(&self, stop: &Stop) -> Self::Worker;

    /// Computes neighbouring cells; `None` if stopped midway.
    fn compute(
        &self,
        worker: &mut Self::Worker,
        range: Range<u64>,
        stop: &Stop,
        cells: &mut Vec<Self::Cell>,
    ) -> Option<()>;
}

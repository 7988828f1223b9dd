//! The scene of a chain as a grid.

use std::ops::Range;
use std::path::Path;

use serde_json::{Map, Value};
use vibrochain_floquet::Tolerance;
use vibrochain_lattice::{Parameter, Point, Stop};

use crate::cell::{Cell, Class, Worker};
use crate::error::MapError;
use crate::grid::{Files, Grid};
use crate::manifest::scene_parts;
use crate::scene::{Axis, MAX_BYTES, Scene};
use crate::structure::StructureScene;
use crate::table::columns::{Column, columns, parameters};

/// Cells of a chunk of the paper's forced maps: a fraction of a second of work, which an interruption may cost, against a
/// millisecond for a file that must reach the disk.
const CHUNK_CELLS: u64 = 8192;

/// How many times more there are in one without force or loss, whose cells are twenty times faster.
const CONSERVATIVE: u64 = 4;

/// The least cells of a chunk.
const LEAST_CELLS: u64 = 16;

/// Masses up to which a cell costs a few microseconds.
const FEW_SITES: usize = 48;

/// The most cells taken at a time: some milliseconds of work, so that taking them, and waking the thread that orders them,
/// costs nothing.
const BLOCK: u64 = 1024;

impl Grid for Scene {
    type Parameter = Parameter;
    type Point = Point;
    type Cell = Cell;
    type Worker = Worker;

    const MOST_BYTES: u64 = MAX_BYTES;

    /// What is of no other kind is told what is wrong with it as a chain's.
    fn is_one(text: &str) -> bool {
        !StructureScene::is_one(text)
    }

    fn parse(path: &Path, text: &str, _: &Files) -> Result<Self, MapError> {
        Self::parse(path, text)
    }

    fn title(&self) -> Option<&str> {
        self.title.as_deref()
    }

    fn parts(&self) -> Map<String, Value> {
        scene_parts(self)
    }

    fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Fewer where cells are slow.
    fn chunk_cells(&self) -> u64 {
        // Existence costs as the masses, stability as their square.
        let slower = (self.base.sites() / FEW_SITES) as u64;
        let slower = if self.task.stability { slower.saturating_mul(slower) } else { slower };
        let most = CHUNK_CELLS * if self.is_conservative() { CONSERVATIVE } else { 1 };
        (most / slower.max(1).next_power_of_two()).max(LEAST_CELLS)
    }

    fn block(&self) -> u64 {
        BLOCK
    }

    fn tolerance(&self) -> Option<Tolerance> {
        self.task.stability.then_some(self.task.tolerance)
    }

    fn set_tolerance(&mut self, tolerance: Tolerance) {
        self.task.tolerance = tolerance;
    }

    fn places(&self) -> Vec<Parameter> {
        parameters(self)
    }

    fn name_of(&self, parameter: Parameter) -> String {
        parameter.name().to_owned()
    }

    fn value(point: &Point, parameter: Parameter) -> f64 {
        point.get(parameter)
    }

    fn point(&self, cell: u64) -> Point {
        Self::point(self, cell)
    }

    fn walk(&self, cells: Range<u64>, go_on: impl FnMut(&Point) -> bool) {
        Self::walk(self, cells, go_on);
    }

    fn columns(&self) -> Vec<Column> {
        columns(self).collect()
    }

    fn untold() -> Cell {
        Cell { class: None, ..Cell::EMPTY }
    }

    fn shown(&self, cell: &Cell) -> Cell {
        *cell
    }

    fn class_name(class: Class) -> &'static str {
        class.name()
    }

    fn worker(&self, stop: &Stop) -> Worker {
        Worker::new(self.base.sites()).until(stop)
    }

    fn compute(&self, worker: &mut Worker, range: Range<u64>, stop: &Stop, cells: &mut Vec<Cell>) -> Option<()> {
        cells.clear();
        let all = (range.end - range.start) as usize;
        // The scene's corners were checked, so that every point between is a valid model.
        self.walk_models(range, |model| {
            cells.push(worker.cell(model, &self.task));
            !stop.is_raised()
        });
        // The last of those that were stopped is none.
        (cells.len() == all && !stop.is_raised()).then_some(())
    }
}

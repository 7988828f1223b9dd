//! What the page of a structure's map asks: cells of tiles, and the orbits at a point.

use std::path::PathBuf;
use std::time::Duration;

use rayon::ThreadPool;
use rayon::prelude::*;
use serde::Deserialize;
use serde_json::{Value, json};

use super::answers::read;
use super::line::{Line, Setting};
use vibrochain_explore::{Answers, Refusal};
use vibrochain_lattice::Stop;
use vibrochain_maps::grid::Grid;
use vibrochain_maps::manifest::VERSION;
use vibrochain_maps::numbers::Number;
use vibrochain_maps::scene::{Axis, Values};
use vibrochain_maps::structure::{self, StructureCell, StructureScene};

/// Cells along a side of a tile. A cell takes up to a millisecond, so that a tile is there within a second.
const CELLS: usize = 32;

/// The deepest tiles, whose cells are still different numbers.
const DEEPEST: u32 = 40;

/// How long the orbits of one word may take at a point.
const LONG: Duration = Duration::from_secs(60);

/// The program, as that page asks it.
pub(super) struct StructureProgram {
    scene: StructureScene,
    path: PathBuf,
    setting: Setting,
    pool: ThreadPool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Tile {
    z: u32,
    x: i64,
    y: i64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Point {
    at: [f64; 2],
}

impl StructureProgram {
    /// Of a scene with two axes and words.
    ///
    /// # Errors
    /// What the scene lacks.
    pub(super) fn new(
        scene: StructureScene,
        path: PathBuf,
        setting: Setting,
        pool: ThreadPool,
    ) -> Result<Self, String> {
        ensure!(scene.axes.len() == 2, "a map to fly over has two axes: give [sweep] with x and y");
        scene.is_map()?;
        Ok(Self { scene, path, setting, pool })
    }

    fn words(&self) -> Vec<String> {
        self.scene.words.iter().map(StructureScene::name_of).collect()
    }

    /// Classes of a tile's cells by rows, the lowest y first, each by its place in the list beside them.
    fn cells(&self, Tile { z, x, y }: &Tile, stop: &Stop) -> Result<Value, Refusal> {
        let side = 1_i64 << (*z).min(DEEPEST);
        if *z > DEEPEST || [x, y].into_iter().any(|number| !(-side..2 * side).contains(number)) {
            refuse!("there is no such tile: z is 0 to 40, x and y from -2^z to 2·2^z − 1");
        }
        let mut scene = self.scene.clone();
        for (axis, number) in scene.axes.iter_mut().zip([x, y]) {
            let [from, to] = ends(axis);
            let step = (to - from) / (CELLS as f64 * side as f64);
            let centre = |cell: usize| from + (*number as f64 * CELLS as f64 + cell as f64 + 0.5) * step;
            axis.values = Values::Linear { from: centre(0), to: centre(CELLS - 1), points: CELLS };
        }
        let row = |row: u64| {
            let (mut worker, mut cells, width) = (scene.worker(stop), Vec::new(), CELLS as u64);
            scene.compute(&mut worker, row * width..(row + 1) * width, stop, &mut cells).map(|()| cells)
        };
        let rows = self.pool.install(|| (0..CELLS as u64).into_par_iter().map(row).collect::<Option<Vec<_>>>());
        let rows = rows.ok_or_else(|| Refusal::new(503, "nobody waits for this tile any more"))?;
        let mut classes: Vec<String> = Vec::new();
        let mut place = |class: String| {
            classes.iter().position(|one| *one == class).unwrap_or_else(|| {
                classes.push(class);
                classes.len() - 1
            })
        };
        let cells: Vec<usize> = rows.iter().flatten().map(|cell| place(told(cell))).collect();
        Ok(json!({ "classes": classes, "cells": cells }))
    }

    /// What `mapgen orbit` prints for each word, with its picture.
    fn orbits(&self, Point { at }: &Point, stop: &Stop) -> Result<Value, Refusal> {
        let one = |(word, periods): &(vibrochain_breather::Word, u32)| {
            let mut line = Line::new("orbit").flag("scene", self.path.display());
            for (name, value) in self.scene.axis_names.iter().zip(at) {
                line = line.flag("set", format!("{name}={}", Number(*value)));
            }
            let line =
                line.flag("word", word).flag("force-periods", periods).output("plot", "orbit.svg").switch("json");
            line.run(&self.setting, LONG, stop)
        };
        self.scene.words.iter().map(one).collect()
    }
}

/// The first and last value of an axis.
fn ends(axis: &Axis<structure::Setting>) -> [f64; 2] {
    [0, axis.points() - 1].map(|place| axis.value(place))
}

/// The class of a cell, with the word behind it.
fn told(cell: &StructureCell) -> String {
    let word = cell.word.iter().map(|word| format!(" {word}"));
    std::iter::once(cell.class.name().to_owned()).chain(word).collect()
}

impl Answers for StructureProgram {
    fn page(&self) -> &'static str {
        "structure.html"
    }

    fn start(&self) -> Value {
        let axes = self.scene.axes.iter().zip(&self.scene.axis_names);
        let axis = |(axis, name): (&Axis<structure::Setting>, &String)| {
            let [from, to] = ends(axis);
            json!({ "name": name, "from": from, "to": to })
        };
        let axes: Value = axes.map(axis).collect();
        json!({
            "heading": self.scene.heading(),
            "fixed": self.scene.fixed(),
            "axes": axes,
            "words": self.words(),
            "side": CELLS,
            "version": VERSION,
        })
    }

    fn is_long(&self, _question: &str) -> bool {
        false
    }

    fn answer(&self, question: &str, asked: &Value, stop: &Stop) -> Result<Value, Refusal> {
        match question {
            "cells" => self.cells(&read(asked)?, stop),
            "orbits" => self.orbits(&read(asked)?, stop),
            _ => Err(Refusal::new(404, "there is no such question")),
        }
    }
}

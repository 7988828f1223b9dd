//! What is flown over: the plane of two parameters that a scene's window begins with, and the scene of each tile of it.

use std::path::Path;

use serde_json::{Map, Value};
use vibrochain_breather::Word;
use vibrochain_maps::manifest::scene_parts;
use vibrochain_maps::scene::{Scene, Values};

use crate::refusal::Refusal;

/// Cells along each side of a tile: some 4000 cells are tens of milliseconds of work, soon enough to see, and not too little to
/// be worth a request.
pub const CELLS: usize = 64;

/// The most masses: a stability analysis then takes milliseconds, a tile seconds.
pub const MOST_SITES: usize = 1001;

/// The deepest tiles: 64·2⁴⁰ cells along a side have numbers that are exact in 53 bits.
const DEEPEST: u32 = 40;

/// The least distance of two cells, in the spacing of numbers about the window's larger end: closer ones would stand for values that are
/// rounded visibly.
const LEAST_STEP: f64 = 64.0 * f64::EPSILON;

/// How many windows there are on either side of the one of the scene.
const BESIDE: i64 = 1;

/// The most with a word that hits at several sites: its multipliers are those of a dense matrix, a quarter of a second for each orbit, in
/// which nothing can be stopped.
pub const MOST_DENSE: usize = 201;

/// The most words: a cell searches for each of them, and is not left before its end.
const MOST_WORDS: usize = 32;

/// Refuses more masses than can be looked at with these words, and more words than that.
///
/// # Errors
/// [`Refusal`] with the most there may be.
pub fn fits(sites: usize, words: &[Word]) -> Result<(), Refusal> {
    ensure!(words.len() <= MOST_WORDS, "{} words are too many to look at: give at most {MOST_WORDS}", words.len());
    let is_dense = |word: &Word| word.letters().any(|letter| word.letters().any(|other| other.site != letter.site));
    let (most, with) =
        if words.iter().any(is_dense) { (MOST_DENSE, ", with a word of several sites,") } else { (MOST_SITES, "") };
    if sites > most {
        let message = format!("sites = {sites} is out of range: give at most {most} to look at{with}");
        return Err(Refusal::wrong(message.trim_end_matches(',')));
    }
    Ok(())
}

/// A scene with two equally spaced axes, and what of it decides a tile.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    scene: Scene,
    limits: [[f64; 2]; 2],
    deepest: u32,
}

impl View {
    /// The view that the page describes: a scene as JSON. How many points its axes have does not matter to its tiles.
    ///
    /// # Errors
    /// [`Refusal`]: what a scene may not have, and what cannot be flown over.
    ///
    /// ```
    /// use vibrochain_explore::View;
    /// let scene = serde_json::json!({
    ///     "model": { "sites": 21, "gamma1": 0.2, "asymmetry": 0.4 },
    ///     "sweep": {
    ///         "x": { "parameter": "omega", "from": 0.5, "to": 2.5, "points": 2 },
    ///         "y": { "parameter": "gamma2", "from": 0.0, "to": 0.25, "points": 2 },
    ///     },
    ///     "compute": { "families": ["double-sided"], "stability": true },
    /// });
    /// let view = View::read(&scene)?;
    /// let tile = view.tile(1, 1, 0)?;
    /// assert_eq!(tile.axes[0].limits(), [1.5 + 0.5 / 64.0, 2.5 - 0.5 / 64.0]);
    /// assert!(view.tile(1, 4, 0).unwrap_err().message.contains("from -2 to 3"));
    /// # Ok::<(), vibrochain_explore::Refusal>(())
    /// ```
    pub fn read(scene: &Value) -> Result<Self, Refusal> {
        ensure!(scene.is_object(), "scene is missing: give an object with model, sweep and compute");
        if let Some(key) = nothing(scene, &mut String::new()) {
            refuse!("{key} is null: give a value");
        }
        let parsed = Scene::of_data(Path::new("scene"), scene);
        Self::of(&parsed.map_err(|error| Refusal::wrong(error.to_string().trim_start_matches("scene: ")))?)
    }

    /// The view of a scene: over its first two axes, others at their first value.
    ///
    /// # Errors
    /// [`Refusal`] for a scene with one axis, with too many masses, or whose window is too narrow for numbers.
    pub fn of(scene: &Scene) -> Result<Self, Refusal> {
        fits(scene.base.sites(), &scene.task.words)?;
        let [x, y, ..] = scene.axes.as_slice() else {
            refuse!("a map to fly over has two axes: give a scene with x and y");
        };
        let (limits, mut scene) = ([x.limits(), y.limits()], scene.clone());
        scene.axes.truncate(2);
        let mut deepest = DEEPEST;
        for (axis, [from, to]) in scene.axes.iter_mut().zip(limits) {
            let finest = LEAST_STEP * from.abs().max(to.abs());
            let halvings = ((to - from) / (CELLS as f64 * finest)).log2().floor();
            if halvings.is_nan() || halvings < 0.0 {
                let name = axis.parameter.name();
                refuse!("{name} from {from} to {to} is too narrow: neighbouring cells would be the same number");
            }
            deepest = deepest.min(halvings as u32);
            axis.values = Values::Linear { from, to, points: axis.points().max(2) };
        }
        Ok(Self { scene, limits, deepest })
    }

    /// The scene, its two axes equally spaced.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The deepest z whose cells are different numbers.
    #[must_use]
    pub fn deepest(&self) -> u32 {
        self.deepest
    }

    /// What the page keeps of it: title, model, sweep and compute, as a manifest has them.
    #[must_use]
    pub fn value(&self) -> Value {
        let mut value = Map::new();
        if let Some(title) = &self.scene.title {
            value.insert("title".to_owned(), title.as_str().into());
        }
        value.extend(scene_parts(&self.scene));
        value.into()
    }

    /// The scene of a tile. What a sweep of it computes is the tile.
    ///
    /// # Errors
    /// [`Refusal`] for a z that is too deep, and for a tile that is farther from the window than the window is wide.
    pub fn tile(&self, z: u32, x: i64, y: i64) -> Result<Scene, Refusal> {
        ensure!(z <= self.deepest, "z = {z} is out of range: give a whole number from 0 to {}", self.deepest);
        let side = 1_i64 << z;
        let mut scene = self.scene.clone();
        let numbers = [("x", x), ("y", y)];
        for ((axis, limits), (name, number)) in scene.axes.iter_mut().zip(self.limits).zip(numbers) {
            let (least, most) = (-BESIDE * side, (1 + BESIDE) * side - 1);
            if !(least..=most).contains(&number) {
                refuse!("{name} = {number} is out of range: give a whole number from {least} to {most} with z = {z}");
            }
            axis.values = part(limits, z, number);
        }
        Ok(scene)
    }
}

/// The centres of the cells of tile `number` along an axis.
fn part([from, to]: [f64; 2], z: u32, number: i64) -> Values {
    let cells = CELLS as f64;
    // A power of two: the division is exact, and cells of one z never overlap.
    let step = (to - from) / (cells * (1_u64 << z) as f64);
    let at = |cell: f64| from + (number as f64 * cells + cell + 0.5) * step;
    Values::Linear { from: at(0.0), to: at(cells - 1.0), points: CELLS }
}

/// The path of a value that is null, which a number becomes in a browser that is none. The threshold may be.
fn nothing(value: &Value, path: &mut String) -> Option<String> {
    let parts: Vec<(String, &Value)> = match value {
        Value::Null if path != "compute.threshold" => return Some(path.clone()),
        Value::Object(parts) => parts.iter().map(|(key, part)| (key.clone(), part)).collect(),
        Value::Array(parts) => parts.iter().enumerate().map(|(i, part)| (i.to_string(), part)).collect(),
        _ => return None,
    };
    parts.iter().find_map(|(key, part)| {
        let before = path.len();
        *path += if before == 0 { "" } else { "." };
        *path += key;
        let found = nothing(part, path);
        path.truncate(before);
        found
    })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn view() -> View {
        View::read(&json!({
            "model": { "sites": 5, "gamma1": 0.2, "asymmetry": 0.4 },
            "sweep": {
                "x": { "parameter": "omega", "from": 0.4, "to": 3.0, "points": 9 },
                "y": { "parameter": "gamma2", "from": 0.0, "to": 0.3, "points": 7 },
            },
            "compute": { "families": ["double-sided"] },
        }))
        .unwrap()
    }

    #[test]
    fn four_tiles_of_the_next_level_are_one_of_this() {
        let view = view();
        for (z, x, y) in [(0, 0, 0), (3, 5, 2), (20, 123_456, 654_321), (30, 7, 1 << 29)] {
            let whole = view.tile(z, x, y).unwrap();
            for axis in 0..2 {
                let side = |scene: &Scene| {
                    let [from, to] = scene.axes[axis].limits();
                    let half = 0.5 * (to - from) / (CELLS - 1) as f64;
                    [from - half, to + half]
                };
                let [first, second] = [0, 1].map(|i| side(&view.tile(z + 1, 2 * x + i, 2 * y + i).unwrap()));
                let [from, to] = side(&whole);
                let near = 4.0 * f64::EPSILON * 3.0;
                assert!((first[0] - from).abs() < near && (second[1] - to).abs() < near, "{z} {axis}");
                assert!((first[1] - second[0]).abs() < near, "{z} {axis}");
            }
        }
    }

    #[test]
    fn neighbouring_cells_are_different_numbers_down_to_the_deepest() {
        let view = view();
        assert!((30..=DEEPEST).contains(&view.deepest()));
        let tile = view.tile(view.deepest(), 3 << (view.deepest() - 2), 1).unwrap();
        for axis in &tile.axes {
            assert!((1..CELLS).all(|i| axis.value(i) > axis.value(i - 1)));
        }
    }

    #[test]
    fn what_is_no_tile_is_refused() {
        let view = view();
        let told = |z, x, y| view.tile(z, x, y).unwrap_err().message;
        assert_eq!(told(99, 0, 0), format!("z = 99 is out of range: give a whole number from 0 to {}", view.deepest()));
        assert_eq!(told(0, 2, 0), "x = 2 is out of range: give a whole number from -1 to 1 with z = 0");
        assert_eq!(
            told(3, 0, i64::MIN),
            format!("y = {} is out of range: give a whole number from -8 to 15 with z = 3", i64::MIN)
        );
    }

    #[test]
    fn what_cannot_be_flown_over_is_refused() {
        let value = view().value();
        assert_eq!(View::read(&value).unwrap().value(), value);
        let with = |pointer: &str, new: Value| {
            let mut value = value.clone();
            *value.pointer_mut(pointer).unwrap() = new;
            View::read(&value).unwrap_err().message
        };
        assert_eq!(with("/model/sites", 1002.into()), "sites = 1002 is out of range: give at most 1001 to look at");
        assert!(with("/model/asymmetry", 1.5.into()).starts_with("asymmetry = 1.5 is out of range"));
        assert!(with("/sweep/x/from", (3.0 - 1e-14).into()).contains("too narrow"));
        // What is typed into a field that wants a number.
        for (pointer, typed, told) in [
            ("/model/asymmetry", json!("abc"), "asymmetry = \"abc\" is not a number: give one such as 0.2 or 1e-3"),
            ("/compute/threshold", json!("1%"), "threshold = \"1%\" is not a number: give one such as 0.2 or 1e-3"),
            ("/sweep/x/from", json!("0,4"), "from = \"0,4\" is not a number: give one such as 0.2 or 1e-3"),
            ("/model/sites", json!(""), "sites = \"\" is not a whole number"),
            ("/model/sites", json!(21.5), "sites = 21.5 is not a whole number"),
            ("/sweep/x/from", Value::Null, "sweep.x.from is null: give a value"),
            ("/model/sites", Value::Null, "model.sites is null: give a value"),
        ] {
            assert_eq!(with(pointer, typed), told);
        }
        let words = vec!["0+,0-".parse::<Word>().unwrap(); 33];
        assert_eq!(fits(5, &words).unwrap_err().message, "33 words are too many to look at: give at most 32");
        assert_eq!(fits(5, &words[1..]), Ok(()));
        assert!(View::read(&Value::Null).unwrap_err().message.contains("scene is missing"));
    }
}

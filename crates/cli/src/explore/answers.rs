//! What the page of `mapgen explore` asks besides tiles: this program is run for it, with flags made of what was asked, and what it prints and
//! writes is handed over as it is.

use std::time::Duration;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};

use super::line::{Line, Setting};
use super::texts::{of_map, of_point, toml_of};
use vibrochain_breather::Word;
use vibrochain_explore::{Answers, Refusal, View, fits};
use vibrochain_lattice::{Harmonic, Parameter, Stop};
use vibrochain_maps::cell::SYMMETRIC;
use vibrochain_maps::manifest::VERSION;
use vibrochain_maps::numbers::{Number, plain};
use vibrochain_maps::scene::Axis;

/// The most numbers of a table that is handed to the page: some ten megabytes.
const MOST_NUMBERS: f64 = 600_000.0;

/// The most cells along a side of a picture or table: as many as a screen has pixels.
const MOST_CELLS: usize = 1200;

/// The most places at which `mapgen curves` looks in the end: what lives between borders is seen on the map.
const MOST_PLACES: u64 = 100_000;

/// The program, as the page asks it.
pub(crate) struct Program {
    /// What the page begins with.
    pub(crate) view: View,
    /// How it is run.
    pub(crate) setting: Setting,
}

/// How long an answer about a point may take, and one about a window.
const LONG: Duration = Duration::from_secs(60);
const LONGEST: Duration = Duration::from_secs(600);

/// A point and its breathers.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Point {
    model: Map<String, Value>,
    /// A family, or a word.
    which: String,
    threshold: Option<f64>,
    /// Samples of a period.
    samples: u64,
}

/// A run from one of them.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Run {
    #[serde(flatten)]
    point: Point,
    solution: u64,
    /// 0 for none.
    perturb: f64,
    direction: String,
    seed: u64,
    periods: f64,
}

/// Lines over a window.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Window {
    scene: Value,
    /// How fine borders are; how many places are looked at in the end.
    tolerance: Option<f64>,
    places: Option<u64>,
    /// Borders over a picture.
    #[serde(default)]
    curves: bool,
    /// What colours it.
    color: Option<String>,
}

impl Answers for Program {
    fn start(&self) -> Value {
        json!({ "scene": self.view.value(), "version": VERSION })
    }

    fn is_long(&self, question: &str) -> bool {
        ["curves", "sweep"].contains(&question)
    }

    fn answer(&self, question: &str, asked: &Value, stop: &Stop) -> Result<Value, Refusal> {
        let line = match question {
            "orbit" => orbit(&read(asked)?)?,
            "simulate" => simulate(&read(asked)?)?,
            "curves" => curves(&read(asked)?)?,
            "sweep" => sweep(&read(asked)?)?,
            "texts" => return of_map(&window(&read(asked)?)?),
            _ => return Err(Refusal::new(404, "there is no such question")),
        };
        let limit = if self.is_long(question) { LONGEST } else { LONG };
        let mut answer = line.run(&self.setting, limit, stop)?;
        if question == "orbit" {
            let Point { model, which, .. } = read(asked)?;
            let count = answer["answer"]["solutions"].as_array().map_or(0, Vec::len);
            answer["python"] = (0..count).map(|number| of_point(&model, name(&which), number)).collect();
        }
        Ok(answer)
    }
}

pub(super) fn read<T: DeserializeOwned>(asked: &Value) -> Result<T, Refusal> {
    T::deserialize(asked).map_err(|error| Refusal::wrong(plain(&error.to_string())))
}

/// Keys of a model whose values are words; others are numbers, and a text in their place would pass by what is asked of numbers here.
const WORDS: [&str; 2] = ["ends", "layer_ends"];

/// The keys of a model, which are its flags, in the order in which people give them.
fn keys() -> Vec<&'static str> {
    let mut keys = vec!["sites", "ends", "layers", "layer_ends"];
    for parameter in Parameter::told() {
        keys.push(parameter.name());
        keys.extend((parameter == Parameter::Amplitude).then_some("force"));
    }
    keys
}

/// The flags of a model.
fn with_model(mut line: Line, model: &Map<String, Value>, words: &[Word]) -> Result<Line, Refusal> {
    let known = keys();
    if let Some(key) = model.keys().find(|key| !known.contains(&key.as_str())) {
        refuse!("model has no {key}: it has {}", known.join(", "));
    }
    fits(masses(model)?, words)?;
    for key in known {
        let flag = key.replace('_', "-");
        line = match model.get(key) {
            None => line,
            Some(Value::Array(harmonics)) if key == "force" => line.flag(&flag, force(harmonics)?),
            Some(Value::Number(number)) if !WORDS.contains(&key) => match (number.as_u64(), number.as_f64()) {
                (Some(whole), _) => line.flag(&flag, whole),
                (None, Some(value)) => line.flag(&flag, Number(value)),
                (None, None) => refuse!("{key} = {number} is out of range"),
            },
            Some(Value::String(text)) if WORDS.contains(&key) => line.flag(&flag, text),
            Some(Value::String(_)) if key != "force" => {
                let text = &model[key];
                refuse!("{key} = {text} is a text: give a number, without quotes");
            }
            Some(other) => refuse!("{key} = {other} is no value of it"),
        };
    }
    Ok(line)
}

fn force(harmonics: &[Value]) -> Result<String, Refusal> {
    let one = |value: &Value| {
        let Harmonic { number, amplitude, phase } = read(value)?;
        Ok(format!("{number}:{}:{}", Number(amplitude), Number(phase)))
    };
    Ok(harmonics.iter().map(one).collect::<Result<Vec<_>, Refusal>>()?.join(","))
}

fn at(command: &str, point: &Point) -> Result<Line, Refusal> {
    let is_word = point.which.contains(['+', '-']) && !point.which.contains(char::is_alphabetic);
    let which = if is_word { "word" } else { "family" };
    // A word that is none is refused by the program.
    let words: Vec<Word> = point.which.parse().into_iter().collect();
    with_model(Line::new(command).flag(which, name(&point.which)), &point.model, &words)
}

/// What a map leaves out is not left out at a point.
fn name(which: &str) -> &str {
    if which == SYMMETRIC { "double-sided" } else { which }
}

/// How many masses a model has, of which the program refuses what is missing.
fn masses(model: &Map<String, Value>) -> Result<usize, Refusal> {
    let mut masses = 1_usize;
    for key in ["sites", "layers"] {
        let Some(given) = model.get(key) else { continue };
        let whole = given.as_u64().and_then(|number| usize::try_from(number).ok());
        let whole =
            whole.ok_or_else(|| Refusal::wrong(format!("{key} = {given} is no whole number: give one from 1")))?;
        masses = masses.saturating_mul(whole);
    }
    Ok(masses)
}

/// Refuses tables that are too long for a page: so many samples in each of so many periods.
fn is_short(point: &Point, periods: f64) -> Result<(), Refusal> {
    let most = (0.5 * MOST_NUMBERS / (masses(&point.model)? as f64 * periods)).floor();
    // Also where there is no limit, as nothing is sampled; periods below 0 are refused by the program.
    if point.samples as f64 <= most || periods < 0.0 {
        return Ok(());
    }
    let samples = point.samples;
    Err(Refusal::wrong(match most {
        most if most >= 1.0 => format!("samples = {samples} is too many for a page: give at most {most}"),
        _ => format!("periods = {periods} is too many for a page, with all masses: give fewer"),
    }))
}

/// Solutions that a point may have: hundreds at very low frequency are cut off by the size of the table alone.
const SOLUTIONS: f64 = 4.0;

fn orbit(point: &Point) -> Result<Line, Refusal> {
    let mut line = at("orbit", point)?;
    is_short(point, SOLUTIONS)?;
    if let Some(threshold) = point.threshold {
        line = line.flag("threshold", Number(threshold));
    }
    Ok(line.output("trajectory", "orbit.csv").flag("samples", point.samples).switch("json"))
}

fn simulate(run: &Run) -> Result<Line, Refusal> {
    let mut line = at("simulate", &run.point)?.flag("solution", run.solution);
    is_short(&run.point, run.periods)?;
    if run.perturb != 0.0 {
        line = line.flag("perturb", Number(run.perturb)).flag("direction", &run.direction).flag("seed", run.seed);
    }
    line = line.flag("periods", Number(run.periods)).flag("samples", run.point.samples);
    Ok(line.output("trajectory", "run.csv").output("impacts", "impacts.csv").switch("json"))
}

/// The scene of a window, checked.
fn window(asked: &Window) -> Result<View, Refusal> {
    let view = View::read(&asked.scene)?;
    let points = view.scene().axes.iter().map(Axis::points).max().unwrap_or(0);
    ensure!(points <= MOST_CELLS, "points = {points} is out of range: give at most {MOST_CELLS} here");
    Ok(view)
}

fn about(command: &str, asked: &Window) -> Result<Line, Refusal> {
    Ok(Line::of_view(command, toml_of(&window(asked)?)?))
}

fn curves(asked: &Window) -> Result<Line, Refusal> {
    let places = asked.places.unwrap_or(0).min(MOST_PLACES);
    let mut line = about("curves", asked)?.flag("places", places);
    if let Some(tolerance) = asked.tolerance {
        line = line.flag("tolerance", Number(tolerance));
    }
    Ok(line.switch("json"))
}

fn sweep(asked: &Window) -> Result<Line, Refusal> {
    let line = about("sweep", asked)?.output("out", "map.csv").output("plot", "map.svg");
    let line = match &asked.color {
        Some(color) => line.flag("color", color),
        None => line,
    };
    Ok(if asked.curves { line.switch("curves") } else { line })
}

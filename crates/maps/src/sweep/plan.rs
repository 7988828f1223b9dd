//! How a sweep is cut into chunks, by its scene alone, and what tells two sweeps apart.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use vibrochain_floquet::Tolerance;
use vibrochain_lattice::Short;
use xxhash_rust::xxh3::xxh3_128;

use crate::error::MapError;
use crate::grid::{Files, Grid};
use crate::manifest::{REVISION, VERSION, target};
use crate::scene::{Scene, tolerance_from};
use crate::text::{clipped, read_text};

/// How the file of every plan begins.
pub(super) const PLAN_BEGINS: &[u8] = b"{\n  \"program\": \"mapgen\"";

/// The form of chunks and of the plan beside them.
pub(super) const FORMAT: u32 = 3;

/// The most chunks: no folder should have to hold more files. Beyond it chunks grow.
const MOST_CHUNKS: u64 = 1 << 17;

/// The program that computes chunks. Other programs may compute other last digits.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Maker {
    pub version: String,
    pub revision: Option<String>,
    pub target: String,
}

impl Maker {
    /// This program.
    pub fn this() -> Self {
        Self { version: VERSION.to_owned(), revision: REVISION.map(str::to_owned), target: target() }
    }

    fn name(&self) -> String {
        format!("{} ({}, {})", self.version, self.revision.as_deref().unwrap_or("no revision"), self.target)
    }
}

/// What besides the scene decides what is computed of a cell, by the names of flags, as text, which reads back exactly.
pub type Settings = BTreeMap<String, String>;

/// A sweep, ready to be computed by any number of processes.
#[derive(Debug, Clone)]
pub struct Plan<S: Grid = Scene> {
    /// The scene, with the threshold of the command line.
    pub scene: S,
    /// Its file, as named on the command line.
    pub scene_file: PathBuf,
    /// Its text.
    pub text: String,
    /// The threshold of the command line.
    pub threshold: Option<f64>,
    /// The settings of an ensemble; none where cells alone are computed.
    pub ensemble: Option<Settings>,
    /// Who computes the chunks.
    pub maker: Maker,
    /// Cells of each chunk but the last.
    pub chunk_cells: u64,
    /// Hash of all that decides what the chunks hold.
    pub identity: u128,
}

/// A plan as a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    program: String,
    format: u32,
    #[serde(flatten)]
    maker: Maker,
    scene_file: String,
    /// As text, which reads back exactly.
    threshold: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ensemble: Option<Settings>,
    cells: u64,
    chunk_cells: u64,
    chunks: u64,
    identity: String,
    scene: String,
    /// The files that it names.
    #[serde(default, skip_serializing_if = "Files::is_empty")]
    files: Files,
}

/// Cells of a chunk that make no more than [`MOST_CHUNKS`] of them.
fn least_cells<S: Grid>(scene: &S) -> u64 {
    scene.cells().div_ceil(MOST_CHUNKS).next_power_of_two()
}

impl<S: Grid> Plan<S> {
    /// Reads a scene; `threshold` is that of the command line.
    ///
    /// # Errors
    /// [`MapError::Request`]: those of [`Grid::parse`]; a scene that is no map; a threshold that is given twice, or that nothing needs.
    pub fn read(scene_file: &Path, threshold: Option<f64>) -> Result<Self, MapError> {
        let text = read_text("scene", scene_file, S::MOST_BYTES)?;
        Self::new(scene_file, text, &Files::new(), threshold, None, Maker::this())
    }

    /// Reads a scene of whose cells more is computed than a sweep finds; `chunk_cells` are to be in a chunk, unless that made
    /// too many.
    ///
    /// # Errors
    /// [`MapError::Request`]: those of [`Grid::parse`].
    pub fn of_ensemble(scene_file: &Path, settings: Settings, chunk_cells: u64) -> Result<Self, MapError> {
        let text = read_text("scene", scene_file, S::MOST_BYTES)?;
        Self::new(scene_file, text, &Files::new(), None, Some((settings, chunk_cells)), Maker::this())
    }

    fn new(
        scene_file: &Path,
        text: String,
        files: &Files,
        threshold: Option<f64>,
        ensemble: Option<(Settings, u64)>,
        maker: Maker,
    ) -> Result<Self, MapError> {
        let mut scene = S::parse(scene_file, &text, files)?;
        if ensemble.is_none() {
            scene.is_map().map_err(|why| MapError::Request(format!("{}: {why}", scene_file.display())))?;
        }
        if let Some(threshold) = threshold {
            let place = scene_file.display();
            match scene.tolerance() {
                Some(Tolerance::Rounding) => {}
                Some(_) => {
                    refuse!("threshold is given twice, as --threshold {} and in {place}: remove one", Short(threshold));
                }
                None => {
                    refuse!("--threshold needs `stability = true` in {place}: it decides what counts as stable");
                }
            }
            scene.set_tolerance(tolerance_from(threshold)?);
        }
        let (ensemble, chunk_cells) = match ensemble {
            Some((settings, cells)) => (Some(settings), cells.max(least_cells(&scene))),
            None => (None, scene.chunk_cells().max(least_cells(&scene))),
        };
        let mut decisive = with_ensemble(scene.meaning(), ensemble.as_ref());
        decisive.insert("format".to_owned(), FORMAT.into());
        decisive.insert("maker".to_owned(), maker.name().into());
        decisive.insert("chunk_cells".to_owned(), chunk_cells.into());
        let identity = xxh3_128(Value::from(decisive).to_string().as_bytes());
        Ok(Self { scene, scene_file: scene_file.to_owned(), text, threshold, ensemble, maker, chunk_cells, identity })
    }

    /// As another version of the program would have made it.
    #[cfg(test)]
    pub fn by_version(scene_file: &Path, text: &str, version: &str) -> Self {
        let maker = Maker { version: version.to_owned(), ..Maker::this() };
        Self::new(scene_file, text.to_owned(), &Files::new(), None, None, maker).unwrap()
    }

    /// Number of cells.
    pub fn cells(&self) -> u64 {
        self.scene.cells()
    }

    /// Number of chunks.
    pub fn chunks(&self) -> u64 {
        self.cells().div_ceil(self.chunk_cells)
    }

    /// The cells of chunk `chunk`.
    pub fn range(&self, chunk: u64) -> Range<u64> {
        let first = chunk * self.chunk_cells;
        first..first.saturating_add(self.chunk_cells).min(self.cells())
    }

    /// The plan as text for a file.
    pub fn to_json(&self) -> String {
        let file = File {
            program: "mapgen".to_owned(),
            format: FORMAT,
            maker: self.maker.clone(),
            scene_file: self.scene_file.display().to_string(),
            threshold: self.threshold.map(|threshold| threshold.to_string()),
            ensemble: self.ensemble.clone(),
            cells: self.cells(),
            chunk_cells: self.chunk_cells,
            chunks: self.chunks(),
            identity: format!("{:032x}", self.identity),
            scene: self.text.clone(),
            files: self.scene.files(),
        };
        // Names, numbers and text: nothing that JSON could not hold.
        serde_json::to_string_pretty(&file).map_or_else(|_| String::new(), |text| text + "\n")
    }

    /// Whether such a file, if it can be read, is of a scene of this kind.
    pub fn is_one(text: &str) -> bool {
        serde_json::from_str(text).is_ok_and(|file: File| S::is_one(&file.scene))
    }

    /// The plan in such a file, or what is wrong with it.
    pub fn from_json(text: &str) -> Result<Self, String> {
        let file: File = serde_json::from_str(text).map_err(|error| format!("it is damaged ({error})"))?;
        ensure!(S::is_one(&file.scene), "it is of another kind of scene");
        ensure!(file.format == FORMAT, "its chunks have format {}, this program reads format {FORMAT}", file.format);
        let threshold = file.threshold.as_deref().map(str::parse).transpose();
        let threshold = threshold.map_err(|error| format!("it is damaged (threshold: {error})"))?;
        let maker = file.maker.clone();
        let ensemble = file.ensemble.map(|settings| (settings, file.chunk_cells));
        let plan = Self::new(Path::new(&file.scene_file), file.scene, &file.files, threshold, ensemble, maker)
            .map_err(|error| format!("its scene cannot be read by this version: {error}"))?;
        if (plan.cells(), plan.chunk_cells) != (file.cells, file.chunk_cells) {
            refuse!("mapgen {} cut it otherwise than this version does", file.maker.name());
        }
        if format!("{:032x}", plan.identity) != file.identity {
            refuse!("it is damaged, or of another version (what it asks for is not what it was made for)");
        }
        Ok(plan)
    }

    /// What this plan and `other`, found in a folder, disagree on; nothing if they are one.
    pub fn differences(&self, other: &Self) -> Option<String> {
        if self.identity == other.identity {
            return None;
        }
        let mut told = String::new();
        if self.maker != other.maker {
            let (here, there) = (self.maker.name(), other.maker.name());
            let _ = write!(told, "another version of mapgen: {there} there, {here} here");
        }
        let [here, there] = [self, other].map(|plan| with_ensemble(plan.scene.parts(), plan.ensemble.as_ref()).into());
        let mut list = Vec::new();
        compare("", &here, &there, &mut list);
        if !list.is_empty() {
            let what = if self.ensemble == other.ensemble { "scene" } else { "ensemble" };
            let and = if told.is_empty() { "" } else { "; and " };
            let more = if list.len() > MOST_TOLD { ", …" } else { "" };
            list.truncate(MOST_TOLD);
            let _ = write!(told, "{and}another {what}: {}{more}", list.join(", "));
        }
        Some(told)
    }
}

/// All that decides what the cells hold.
fn with_ensemble(mut parts: Map<String, Value>, ensemble: Option<&Settings>) -> Map<String, Value> {
    if let Some(settings) = ensemble {
        let settings = settings.iter().map(|(name, value)| (name.clone(), Value::from(value.as_str())));
        parts.insert("ensemble".to_owned(), settings.collect::<Map<_, _>>().into());
    }
    parts
}

/// Characters shown of a value that differs: a list may have a hundred thousand numbers.
const MOST_SHOWN: usize = 80;

/// Values that differ, told at most: all entries of a matrix may.
const MOST_TOLD: usize = 8;

/// Lists the values that differ, by the path of their keys.
fn compare(path: &str, here: &Value, there: &Value, list: &mut Vec<String>) {
    let none = Map::new();
    let whole = || {
        let value = |value: &Value| match value {
            Value::Null => "absent".to_owned(),
            value => clipped(&value.to_string(), MOST_SHOWN).into_owned(),
        };
        format!("{path} is {} there, {} here", value(there), value(here))
    };
    match (here, there) {
        (Value::Object(ours), theirs) => {
            let theirs = theirs.as_object().unwrap_or(&none);
            let more = theirs.keys().filter(|key| !ours.contains_key(*key));
            for key in ours.keys().chain(more) {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                let (here, there) = (ours.get(key), theirs.get(key));
                compare(&path, here.unwrap_or(&Value::Null), there.unwrap_or(&Value::Null), list);
            }
        }
        (Value::Array(ours), Value::Array(theirs)) if ours.len() == theirs.len() => {
            let pairs = ours.iter().zip(theirs).enumerate();
            let mut each = Vec::new();
            pairs.for_each(|(i, (here, there))| compare(&format!("{path}.{i}"), here, there, &mut each));
            // Contacts by their keys, numbers of a list together.
            let named = ours.iter().any(Value::is_object);
            list.extend(if named || each.is_empty() { each } else { vec![whole()] });
        }
        // 1 is 1.0.
        _ if here == there || here.as_f64().is_some_and(|here| there.as_f64() == Some(here)) => {}
        _ => list.push(whole()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"
        [model]
        sites = 6
        gamma1 = 0.2
        asymmetry = 0.4
        [sweep]
        x = { parameter = "omega", from = 0.4, to = 3.0, points = 400 }
        y = { parameter = "gamma2", from = 0.0, to = 0.3, points = 300 }
        [compute]
        families = ["double-sided"]
        stability = true
    "#;

    fn plan(text: &str, threshold: Option<f64>) -> Plan {
        Plan::new(Path::new("map.toml"), text.to_owned(), &Files::new(), threshold, None, Maker::this()).unwrap()
    }

    #[test]
    fn chunks_cover_all_cells_once_whatever_the_scene() {
        for (points, sites, most) in [
            ("400", "6", 32_768),
            ("3", "6", 32_768),
            ("1000000", "6", 32_768),
            ("400", "5001", 16),
            ("1000000", "5001", 4096),
        ] {
            let text = TEXT.replace("points = 400", &format!("points = {points}"));
            let plan = plan(&text.replace("sites = 6", &format!("sites = {sites}")), None);
            assert_eq!(plan.chunk_cells, most);
            assert_eq!((plan.range(0).start, plan.range(plan.chunks() - 1).end), (0, plan.cells()));
            for chunk in 1..plan.chunks().min(100) {
                assert_eq!(plan.range(chunk - 1).end, plan.range(chunk).start);
            }
            assert!(plan.chunks() <= MOST_CHUNKS && !plan.range(plan.chunks() - 1).is_empty());
        }
    }

    #[test]
    fn chunks_of_slow_cells_are_smaller() {
        let forced = TEXT.replace("[sweep]", "forcing = { amplitude = 0.1, restitution = 0.9 }\n[sweep]");
        assert_eq!(plan(&forced, None).chunk_cells, 8192);
    }

    #[test]
    fn a_thousand_million_cells_are_planned_without_being_there() {
        let plan =
            plan(&TEXT.replace("points = 400", "points = 1000000").replace("points = 300", "points = 1000"), None);
        assert_eq!((plan.cells(), plan.chunks()), (1_000_000_000, 30_518));
        let plan = self::plan(
            &TEXT.replace("points = 400", "points = 1000000").replace("points = 300", "points = 1000000"),
            None,
        );
        assert_eq!((plan.cells(), plan.chunk_cells), (1_000_000_000_000, 1 << 23));
    }

    #[test]
    fn a_plan_reads_back_and_damage_to_it_is_seen() {
        let plan = plan(TEXT, Some(0.1 + 0.2));
        let text = plan.to_json();
        let back = Plan::<Scene>::from_json(&text).unwrap();
        assert!(back.identity == plan.identity && back.differences(&plan).is_none());
        assert!(Plan::<Scene>::from_json(&text.replace("0.30000000000000004", "0.3")).is_err());
        assert!(
            Plan::<Scene>::from_json(&text.replace("gamma1 = 0.2", "gamma1 = 0.3")).unwrap_err().contains("damaged")
        );
        assert!(
            Plan::<Scene>::from_json(&text.replace("\"format\": 3", "\"format\": 4")).unwrap_err().contains("format 4")
        );
        assert!(Plan::<Scene>::from_json(&text[..text.len() / 2]).unwrap_err().contains("damaged"));
    }

    #[test]
    fn what_differs_is_named_and_what_does_not_matter_is_not() {
        let here = plan(TEXT, None);
        assert!(here.differences(&plan(&format!("# a remark\ntitle = \"a title\"\n{TEXT}"), None)).is_none());
        let told = here.differences(&plan(&TEXT.replace("gamma1 = 0.2", "gamma1 = 0.3"), Some(0.5))).unwrap();
        let expected =
            "another scene: model.gamma1 is 0.3 there, 0.2 here, compute.threshold is 0.5 there, absent here";
        assert_eq!(told, expected);
        let other = Plan::<Scene>::by_version(Path::new("map.toml"), TEXT, "0.0.9");
        assert!(here.differences(&other).unwrap().starts_with("another version of mapgen: 0.0.9 ("));
    }
}

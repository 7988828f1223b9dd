//! The scene of a text, TOML or JSON, checked.

use std::path::Path;
use std::sync::Arc;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use vibrochain_breather::Word;
use vibrochain_floquet::Tolerance;

use super::StructureScene;
use crate::error::MapError;
use crate::grid::Files;
use crate::scene::{Axis, Places, Source, is_json, tolerance_from};
use crate::structure::definition::Definition;
use crate::structure::named::Named;
use crate::structure::setting::Setting;
use crate::structure::tables::{ComputeTable, ContactTable, ForceTable, StructureTable, SweepTable, axis};

/// The most points of a map.
const MOST_CELLS: u64 = 100_000_000;

/// What a scene may hold; a manifest has more.
const KEYS: [&str; 10] =
    ["title", "omega", "word", "force_periods", "structure", "contact", "force", "model", "sweep", "compute"];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    title: Option<String>,
    omega: Option<f64>,
    word: Option<String>,
    force_periods: Option<u32>,
    structure: StructureTable,
    #[serde(default)]
    contact: Vec<ContactTable>,
    #[serde(default)]
    force: ForceTable,
    sweep: Option<SweepTable>,
    compute: Option<ComputeTable>,
}

/// A scene's text, TOML or JSON, parsed once.
pub(super) struct Parsed<'a> {
    source: Source<'a>,
    /// Of TOML.
    places: Option<Places<'a>>,
    /// All that it says, of a manifest what is the scene's.
    pub(super) told: Value,
}

impl<'a> Parsed<'a> {
    pub(super) fn of(path: &'a Path, text: &'a str) -> Result<Self, MapError> {
        let json = is_json(text);
        let source = Source { path, text: if json { "" } else { text } };
        let (mut told, places) = if json {
            (serde_json::from_str(text).map_err(|error| source.error(0..0, error))?, None)
        } else {
            source.parsed().map(|(told, places)| (told, Some(places)))?
        };
        if let Value::Object(told) = &mut told {
            let whole = !told.contains_key("program");
            // What is null in a manifest is absent in a scene.
            told.retain(|key, value| (whole || KEYS.contains(&key.as_str())) && (places.is_some() || !value.is_null()));
        }
        Ok(Self { source, places, told })
    }

    /// Its tables, and all that they say.
    pub(super) fn tables<T: DeserializeOwned>(self) -> Result<(T, Map<String, Value>), MapError> {
        let tables = self.source.tables(&self.told, self.places.as_ref())?;
        let Value::Object(told) = self.told else { return Ok((tables, Map::new())) };
        Ok((tables, told))
    }
}

impl StructureScene {
    /// The scene of a text, TOML or JSON; files that it names are in `folder`.
    ///
    /// # Errors
    /// [`MapError::Request`] with what is wrong in it.
    pub fn of_text(text: &str, folder: &Path) -> Result<Self, MapError> {
        let file = Parsed::of(Path::new("scene"), text)?.tables()?;
        Ok(Self::of_file(file, &Named::new(folder, &Files::new()))?)
    }

    /// The same of its tables, and of all that they say.
    pub(super) fn of_file((file, told): (File, Map<String, Value>), files: &Named<'_>) -> Result<Self, String> {
        let definition = Definition::new(&file.structure, &file.contact, &file.force, files)?;
        let mut scene = Self::of(definition)?;
        scene.title = file.title;
        scene.word = file
            .word
            .as_deref()
            .map(|text| text.parse::<Word>().map_err(|error| format!("word {text}: {error}")))
            .transpose()?;
        scene.force_periods = file.force_periods.unwrap_or(1);
        scene.omega = file.omega;
        scene.in_sequence = file.structure.in_sequence;
        scene.named = Arc::new(files.read());
        scene.with_map(told, file.sweep.as_ref(), file.compute.as_ref())
    }

    /// The same with axes and words, and with all that its file says.
    pub(in crate::structure) fn with_map(
        mut self,
        told: Map<String, Value>,
        sweep: Option<&SweepTable>,
        compute: Option<&ComputeTable>,
    ) -> Result<Self, String> {
        let word = |text: &str| text.parse::<Word>().map_err(|error| format!("word {text}: {error}"));
        let of_map = |text: &String| -> Result<(Word, u32), String> {
            if text == "period-doubled" {
                return Ok((word(text)?, 2));
            }
            let (name, periods) = text.split_once('/').unwrap_or((text, "1"));
            let periods = periods.parse().ok().filter(|periods| *periods > 0);
            Ok((word(name)?, periods.ok_or_else(|| format!("{text}: give a number of periods after the slash"))?))
        };
        let words = compute.map_or(Ok(Vec::new()), |compute| compute.families.iter().map(of_map).collect())?;
        let tolerance = compute.and_then(|compute| compute.threshold).map(tolerance_from).transpose()?;
        let sweep = || sweep.iter().flat_map(|sweep| sweep.all());
        let axes = sweep().map(axis).collect::<Result<Vec<_>, _>>()?;
        for (i, Axis { parameter, .. }) in axes.iter().enumerate() {
            if axes[..i].iter().any(|earlier| earlier.parameter == *parameter) {
                return Err(format!("{parameter} is swept twice: give different parameters"));
            }
        }
        self.axis_names = sweep().map(|axis| axis.parameter.get_ref().clone()).collect();
        let points = axes.iter().try_fold(1_u64, |points, axis| points.checked_mul(axis.points() as u64));
        let points = points.unwrap_or(u64::MAX);
        if points > MOST_CELLS {
            return Err(format!("the map has {points} points: give at most {MOST_CELLS}"));
        }
        self.names = words.iter().map(|word| Self::name_of(word).into()).collect();
        self.words = words;
        self.told = Arc::new(told);
        self.tolerance = tolerance.unwrap_or(Tolerance::Rounding);
        self.stability = compute.is_none_or(|compute| compute.stability);
        self.axes = axes.clone();
        // Every end of an axis is asked once, so that a map does not begin in vain.
        for axis in &axes {
            for end in axis.limits() {
                self.clone().set(axis.parameter, end)?;
            }
            if axis.parameter == Setting::Omega && self.omega.is_none() {
                self.omega = Some(axis.first());
            }
            self.axis_has_effect(axis.parameter)?;
        }
        Ok(self)
    }
}

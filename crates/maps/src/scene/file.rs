//! The form of a scene file.

use std::fmt;
use std::path::Path;
use std::sync::LazyLock;

use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::{Map, Value};
use toml::Spanned;
use vibrochain_lattice::{DampedParameter, Ends, Force, Harmonic, Layout, MAX_HARMONIC, MAX_SITES, Parameter, Part};

use crate::error::MapError;
use crate::hints::meant;
use crate::scene::axis::{Axis, AxisTable};
use crate::scene::compute::ComputeTable;
use crate::scene::source::{SHOWN, Source, is_json};
use crate::text::clipped;

/// The most bytes of a scene's file. Numbers of one digit take 95 bytes of memory a byte while they are read, all of them 800 MB.
pub const MAX_BYTES: u64 = 8 << 20;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub(super) title: Option<String>,
    pub(super) model: Spanned<ModelTable>,
    pub(super) sweep: Option<Spanned<SweepTable>>,
    pub(super) compute: Option<ComputeTable>,
}

/// `[model]` of a lattice, or of a chain as a structure, which takes other keys.
pub(crate) struct ModelTable<const DAMPED: bool = false> {
    pub(crate) sites: Spanned<i64>,
    pub(crate) ends: Option<Spanned<String>>,
    pub(super) layers: Option<Spanned<i64>>,
    pub(super) layer_ends: Option<Spanned<String>>,
    /// In the order of [`Parameter::ALL`].
    values: Values<Spanned<f64>>,
    /// In the order of [`DampedParameter::ALL`].
    damped: [Option<f64>; DampedParameter::ALL.len()],
    pub(crate) stops: Vec<usize>,
    pub(super) forcing: Option<ForcingTable>,
    pub(super) force: Option<Spanned<Vec<HarmonicTable>>>,
}

/// One for each parameter, if the file has it.
pub(super) type Values<T> = [Option<T>; Parameter::ALL.len()];

/// A key of `[model]`: one of these, or a parameter's name. It is a newtype, so that the error of an unknown key points at that key.
#[derive(Deserialize)]
struct ModelKey<const DAMPED: bool>(#[serde(deserialize_with = "known::<DAMPED, _>")] Name);

type Name = &'static str;

/// Keys of `[model]`, and parameters of axes, that make a chain a structure.
pub fn damped_keys() -> impl Iterator<Item = Name> {
    let of =
        |part: Part| DampedParameter::ALL.into_iter().map(DampedParameter::row).filter(move |row| row.part == part);
    of(Part::Driving).map(|row| row.name).chain(["stops"]).chain(of(Part::Motion).map(|row| row.name))
}

fn known<'de, const DAMPED: bool, D: Deserializer<'de>>(deserializer: D) -> Result<Name, D::Error> {
    static PLAIN: LazyLock<Vec<&str>> = LazyLock::new(|| {
        let layout = ["sites", "ends", "layers", "layer_ends"].into_iter();
        layout.chain(Parameter::ALL.map(Parameter::name)).chain(["forcing", "force"]).collect()
    });
    static OF_DAMPED: LazyLock<Vec<&str>> = LazyLock::new(|| {
        let plain = ["sites", "ends"].into_iter().chain(Parameter::of(1).iter().map(|parameter| parameter.name()));
        plain.chain(["forcing"]).chain(damped_keys()).collect()
    });
    let keys: &[&str] = if DAMPED { &OF_DAMPED } else { &PLAIN };
    let name = String::deserialize(deserializer)?;
    keys.iter().find(|key| **key == name).copied().ok_or_else(|| D::Error::unknown_field(&name, keys))
}

impl<'de, const DAMPED: bool> Deserialize<'de> for ModelTable<DAMPED> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Table<const DAMPED: bool>;

        impl<'de, const DAMPED: bool> Visitor<'de> for Table<DAMPED> {
            type Value = ModelTable<DAMPED>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a map")
            }

            fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Self::Value, M::Error> {
                let mut sites = None;
                let mut table = ModelTable {
                    sites: Spanned::new(0..0, 0),
                    ends: None,
                    layers: None,
                    layer_ends: None,
                    values: Values::default(),
                    damped: Default::default(),
                    stops: Vec::new(),
                    forcing: None,
                    force: None,
                };
                while let Some(ModelKey::<DAMPED>(key)) = map.next_key()? {
                    match key {
                        "sites" => sites = Some(map.next_value()?),
                        "ends" => table.ends = Some(map.next_value()?),
                        "layers" => table.layers = Some(map.next_value()?),
                        "layer_ends" => table.layer_ends = Some(map.next_value()?),
                        "forcing" => table.forcing = Some(map.next_value()?),
                        "force" => table.force = Some(map.next_value()?),
                        "stops" => table.stops = map.next_value()?,
                        name => match (Parameter::from_name(name), DampedParameter::from_name(name)) {
                            (Some(parameter), _) => table.values[parameter as usize] = Some(map.next_value()?),
                            (_, Some(parameter)) => table.damped[parameter as usize] = Some(map.next_value()?),
                            (None, None) => return Err(M::Error::missing_field(key)),
                        },
                    }
                }
                table.sites = sites.ok_or_else(|| M::Error::missing_field("sites"))?;
                Ok(table)
            }
        }

        deserializer.deserialize_map(Table::<DAMPED>)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HarmonicTable {
    pub(super) harmonic: Spanned<i64>,
    pub(super) amplitude: f64,
    #[serde(default)]
    pub(super) phase: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ForcingTable {
    pub(super) amplitude: Option<Spanned<f64>>,
    pub(super) restitution: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SweepTable {
    /// The fastest axis, along a row.
    pub(super) x: Option<Spanned<AxisTable>>,
    /// The next one, from row to row.
    pub(super) y: Option<Spanned<AxisTable>>,
    /// Further ones, each slower than the one before it.
    #[serde(default)]
    pub(super) axes: Vec<Spanned<AxisTable>>,
}

impl SweepTable {
    /// All axes, the fastest first.
    pub(super) fn axes(&self, source: &Source<'_>) -> Result<Vec<&Spanned<AxisTable>>, MapError> {
        if let (None, Some(y)) = (&self.x, &self.y) {
            return Err(source.error(y.span(), "y is given without x: x is the fastest axis, name it first"));
        }
        let axes: Vec<_> = self.x.iter().chain(&self.y).chain(&self.axes).collect();
        Ok(axes)
    }
}

impl ModelTable {
    /// Where the masses stand, `length` in a row.
    pub(super) fn layout(&self, length: usize, source: &Source<'_>) -> Result<Layout, MapError> {
        let ends = |key: &str, given: &Option<Spanned<String>>, known: &[Ends], otherwise: Ends| {
            let Some(given) = given else { return Ok(otherwise) };
            known.iter().find(|ends| ends.name() == given.get_ref()).copied().ok_or_else(|| {
                let names: Vec<_> = known.iter().map(|ends| ends.name()).collect();
                let message =
                    format!("{key} = \"{}\" is unknown: give {}", clipped(given.get_ref(), SHOWN), names.join(" or "));
                source.error(given.span(), message)
            })
        };
        let along = ends("ends", &self.ends, &Ends::ALL, Ends::Closed)?;
        let layer_ends = ends("layer_ends", &self.layer_ends, &[Ends::Closed, Ends::Free], Ends::Free)?;
        let most = (MAX_SITES / length) as i64;
        let layers = match &self.layers {
            None => 1,
            Some(given) => {
                let layers = *given.get_ref();
                if !(1..=most).contains(&layers) {
                    let message = format!("layers = {layers} is out of range: give a whole number from 1 to {most}");
                    return Err(source.error(given.span(), message));
                }
                layers as usize
            }
        };
        Ok(Layout { length, ends: along, layers, layer_ends })
    }

    /// The values of parameters, amplitude and restitution wherever they stand.
    pub(super) fn values(&self, source: &Source<'_>) -> Result<Values<&Spanned<f64>>, MapError> {
        let mut values = self.values.each_ref().map(Option::as_ref);
        let Some(ForcingTable { amplitude, restitution }) = &self.forcing else { return Ok(values) };
        for (parameter, nested) in [(Parameter::Amplitude, amplitude), (Parameter::Restitution, restitution)] {
            let Some(nested) = nested else { continue };
            if values[parameter as usize].replace(nested).is_some() {
                let message = format!("{parameter} is given twice, in [model] and in forcing: remove one of them");
                return Err(source.error(nested.span(), message));
            }
        }
        Ok(values)
    }
}

impl ModelTable<true> {
    /// The value of a parameter, wherever it stands.
    pub(crate) fn value(&self, parameter: Parameter) -> Option<f64> {
        let nested = self.forcing.as_ref().and_then(|forcing| match parameter {
            Parameter::Amplitude => forcing.amplitude.as_ref(),
            Parameter::Restitution => forcing.restitution.as_ref(),
            _ => None,
        });
        self.values[parameter as usize].as_ref().or(nested).map(|value| *value.get_ref())
    }

    /// The value of one that only damped chains have.
    pub(crate) fn own(&self, parameter: DampedParameter) -> Option<f64> {
        self.damped[parameter as usize]
    }
}

/// A file that was read.
pub(super) struct ReadFile<'a> {
    pub(super) file: File,
    pub(super) source: Source<'a>,
    /// It is the answer of a command, with orbits.
    pub(super) has_orbits: bool,
    /// The family of a figure that the file sets beside its model.
    pub(super) family: Option<String>,
}

/// Tables of a file that sets a figure of the paper.
const OF_FIGURES: [&str; 2] = ["figure", "curves"];

impl File {
    /// As [`File::read`], for a command that asks for the model alone: a figure that the file sets beside it is left aside.
    pub(super) fn read_model<'a>(path: &'a Path, text: &'a str) -> Result<ReadFile<'a>, MapError> {
        if is_json(text) {
            return Self::read(path, text);
        }
        let source = Source { path, text };
        let (mut scene, places) = source.parsed()?;
        let family = scene.pointer("/figure/family").and_then(Value::as_str).map(str::to_owned);
        if let Value::Object(scene) = &mut scene
            && scene.contains_key("figure")
        {
            scene.retain(|key, _| !OF_FIGURES.contains(&key.as_str()));
        }
        Ok(ReadFile { file: source.tables(&scene, Some(&places))?, source, has_orbits: false, family })
    }

    /// Reads a scene's text; or the JSON of a manifest, or of the answer of a command, which calls its model `parameters`. A scene file itself never begins with a brace.
    pub(super) fn read<'a>(path: &'a Path, text: &'a str) -> Result<ReadFile<'a>, MapError> {
        if !is_json(text) {
            let source = Source { path, text };
            let (scene, places) = source.parsed()?;
            let file = source.tables(&scene, Some(&places)).map_err(|error| match scene.get("figure") {
                Some(_) => MapError::Request(format!(
                    "{}: it sets a figure of the paper, which `studies figures` draws; give a scene with [model] or [structure] alone, or ask orbit, simulate or branch, which take the model of this one",
                    path.display()
                )),
                None => error,
            })?;
            return Ok(ReadFile { file, source, has_orbits: false, family: None });
        }
        let wrong = |what: &dyn fmt::Display| MapError::Request(format!("manifest {}: {what}", path.display()));
        let mut manifest: Map<String, Value> = serde_json::from_str(text).map_err(|error| wrong(&error))?;
        let first = manifest.get("solutions").and_then(|list| list.get(0));
        let has_orbits = first.is_some_and(|orbit| orbit.get("impacts").is_some());
        // Of a manifest or an answer the rest is not the scene's; of a scene, it is a mistake.
        let whole = !["program", "parameters", "ensemble"].iter().any(|key| manifest.contains_key(*key));
        if let Some(parameters) = manifest.remove("parameters") {
            manifest.entry("model").or_insert(parameters);
        }
        if !manifest.contains_key("model") {
            let schema = manifest.get("schema").and_then(Value::as_str);
            let what = schema.map_or(String::new(), |name| format!(" ({})", clipped(name, SHOWN)));
            return Err(wrong(&format!(
                "it has no model{what}: give a scene, a manifest, or an answer about one point"
            )));
        }
        manifest.retain(|key, _| whole || matches!(key.as_str(), "title" | "model" | "sweep" | "compute"));
        let (file, source) = Self::of_data(path, &manifest.into())?;
        Ok(ReadFile { file, source, has_orbits, family: None })
    }

    /// The same of a scene that is data already.
    pub(super) fn of_data<'a>(path: &'a Path, scene: &Value) -> Result<(Self, Source<'a>), MapError> {
        let source = Source { path, text: "" };
        Ok((source.tables(scene, None)?, source))
    }
}

impl Source<'_> {
    pub(super) fn force(&self, list: &Spanned<Vec<HarmonicTable>>) -> Result<Force, MapError> {
        let harmonic = |table: &HarmonicTable| {
            let number = *table.harmonic.get_ref();
            let number = u32::try_from(number).map_err(|_| {
                let message =
                    format!("harmonic = {number} is out of range: give an odd number from 1 to {MAX_HARMONIC}");
                self.error(table.harmonic.span(), message)
            })?;
            Ok(Harmonic { number, amplitude: table.amplitude, phase: table.phase })
        };
        let harmonics = list.get_ref().iter().map(harmonic).collect::<Result<Vec<_>, MapError>>()?;
        Force::new(&harmonics).map_err(|error| self.error(list.span(), error))
    }

    pub(super) fn axis(&self, table: &Spanned<AxisTable>) -> Result<Axis, MapError> {
        let (span, table) = (table.span(), table.get_ref());
        let name = table.parameter.get_ref();
        let parameter = Parameter::from_name(name).ok_or_else(|| {
            let known = Parameter::ALL.map(Parameter::name);
            let meant = meant(name, known);
            let message = format!("`{name}` cannot be swept: {meant}give one of {}", known.join(", "));
            self.error(table.parameter.span(), message)
        })?;
        let values = table.values().map_err(|(place, message)| self.error(place.unwrap_or(span), message))?;
        Ok(Axis { parameter, values })
    }
}

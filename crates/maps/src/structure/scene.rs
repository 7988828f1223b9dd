//! A scene of a structure: the file, checked, and the model at any values of its numbers.

use std::path::Path;
use std::sync::Arc;

use nalgebra::DVector;
use serde::Deserialize;
use serde_json::{Map, Value};
use vibrochain_breather::{StructureModel, Word};
use vibrochain_floquet::Tolerance;
use vibrochain_lattice::{Complex, Contact, EnergyForm, ModalStructure};

use super::definition::{ChainTable, ContactTable, Definition, ForceTable, Named, StructureTable};
use super::setting::Setting;
use crate::grid::Files;
use crate::scene::{Axis, GivenAxis, tolerance_from};

/// The most bytes of a scene, and of a file that it names.
pub const MOST_BYTES: u64 = 64 << 20;

/// The most points of a map.
const MOST_CELLS: u64 = 100_000_000;

/// What a scene may hold; a manifest has more.
const KEYS: [&str; 10] =
    ["title", "omega", "word", "force_periods", "structure", "contact", "force", "model", "sweep", "compute"];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
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

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SweepTable {
    x: AxisTable,
    y: Option<AxisTable>,
    #[serde(default)]
    axes: Vec<AxisTable>,
}

impl SweepTable {
    /// All axes, the fastest first.
    fn all(&self) -> impl Iterator<Item = &AxisTable> {
        std::iter::once(&self.x).chain(&self.y).chain(&self.axes)
    }

    /// Whether an axis is of one of these names.
    pub(super) fn varies(&self, names: &[&str]) -> bool {
        self.all().any(|axis| names.contains(&axis.parameter.as_str()))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AxisTable {
    parameter: String,
    from: Option<f64>,
    to: Option<f64>,
    points: Option<i64>,
    spacing: Option<String>,
    values: Option<Vec<f64>>,
}

impl AxisTable {
    fn axis(&self) -> Result<Axis<Setting>, String> {
        let Self { parameter, from, to, points, spacing, values } = self;
        let (spacing, values) = (spacing.as_deref(), values.clone());
        let given = GivenAxis { from: *from, to: *to, points: *points, spacing, values };
        let values = given.values(parameter).map_err(|(_, message)| format!("axis {parameter}: {message}"))?;
        Ok(Axis { parameter: parameter.parse()?, values })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ComputeTable {
    families: Vec<String>,
    threshold: Option<f64>,
    #[serde(default = "yes")]
    stability: bool,
}

fn yes() -> bool {
    true
}

/// Whether a text is JSON: no TOML begins so.
fn is_json(text: &str) -> bool {
    text.trim_start().starts_with('{')
}

/// All that a scene's text says, of a manifest what is the scene's.
pub(super) fn told(text: &str) -> Result<Map<String, Value>, String> {
    let mut told: Map<String, Value> = if is_json(text) {
        serde_json::from_str(text).map_err(|error| error.to_string())?
    } else {
        toml::from_str(text).map_err(|error| error.to_string())?
    };
    if told.contains_key("program") {
        told.retain(|key, _| KEYS.contains(&key.as_str()));
    }
    // What is null in a manifest is absent in a scene.
    told.retain(|_, value| !value.is_null());
    Ok(told)
}

/// A structure, what is to be varied and what is asked for.
#[derive(Debug, Clone)]
pub struct StructureScene {
    /// Its title.
    pub title: Option<String>,
    /// The word to look for, if the file says so.
    pub word: Option<Word>,
    /// Periods of the load in one of the word.
    pub force_periods: u32,
    /// Words of a map, with their periods of the load: `0+/2` for two.
    pub words: Vec<(Word, u32)>,
    /// From which growth on an orbit counts as unstable.
    pub tolerance: Tolerance,
    /// Whether a map tells stability.
    pub stability: bool,
    /// Axes of a map, the fastest first.
    pub axes: Vec<Axis<Setting>>,
    /// Their names as the file has them.
    pub axis_names: Vec<String>,
    /// The words as tables have them.
    names: Vec<Arc<str>>,
    /// All that the file says, and the files that it names.
    told: Arc<Map<String, Value>>,
    named: Arc<Files>,
    definition: Arc<Definition>,
    omega: Option<f64>,
    load: f64,
    still: f64,
    damping: f64,
    /// Loads are one force on every mass of a chain.
    uniform: bool,
    contacts: Vec<Contact>,
    /// The modes at the damping there is now, with the contacts and loads of the file.
    modal: Arc<ModalStructure>,
}

impl StructureScene {
    /// The scene of a text, TOML or JSON; files that it names are in `folder`.
    ///
    /// # Errors
    /// What is wrong in it.
    pub fn of_text(text: &str, folder: &Path) -> Result<Self, String> {
        Self::of_given(text, &Named::new(folder, &Files::new()))
    }

    /// The same with the files that it names.
    pub(super) fn of_given(text: &str, files: &Named<'_>) -> Result<Self, String> {
        let file: File = if is_json(text) {
            serde_json::from_value(told(text)?.into()).map_err(|error| error.to_string())?
        } else {
            toml::from_str(text).map_err(|error| error.to_string())?
        };
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
        scene.named = Arc::new(files.read());
        scene.with_map(told(text)?, file.sweep.as_ref(), file.compute.as_ref())
    }

    /// The same with axes and words, and with all that its file says.
    pub(super) fn with_map(
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
        let axes = sweep().map(AxisTable::axis).collect::<Result<Vec<_>, _>>()?;
        for (i, Axis { parameter, .. }) in axes.iter().enumerate() {
            if axes[..i].iter().any(|earlier| earlier.parameter == *parameter) {
                return Err(format!("{parameter} is swept twice: give different parameters"));
            }
        }
        self.axis_names = sweep().map(|axis| axis.parameter.clone()).collect();
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
        }
        Ok(self)
    }

    fn of(definition: Definition) -> Result<Self, String> {
        Ok(Self {
            title: None,
            word: None,
            force_periods: 1,
            words: Vec::new(),
            tolerance: Tolerance::Rounding,
            stability: true,
            axes: Vec::new(),
            axis_names: Vec::new(),
            names: Vec::new(),
            told: Arc::default(),
            named: Arc::default(),
            contacts: definition.contacts(),
            modal: Arc::new(definition.modal(1.0)?),
            definition: Arc::new(definition),
            omega: None,
            load: 1.0,
            still: 1.0,
            damping: 1.0,
            uniform: false,
        })
    }

    /// A chain under the load `amplitude` and the static load `still` on every mass; contact n is mass n, free where it has no barrier.
    ///
    /// # Errors
    /// Numbers out of range, as many contacts as there are masses not given.
    pub fn of_chain(chain: ChainTable, contacts: Vec<Contact>, amplitude: f64, still: f64) -> Result<Self, String> {
        let n = chain.sites;
        if contacts.len() != n {
            return Err(format!("{} contacts where there are {n} masses", contacts.len()));
        }
        let unit = |place: usize| DVector::from_fn(n, |i, _| f64::from(u8::from(i == place)));
        let contacts = contacts.into_iter().enumerate().map(|(place, contact)| (unit(place), contact)).collect();
        let load = DVector::from_element(n, Complex::new(1.0, 0.0));
        let definition = Definition::of_chain(chain, contacts, DVector::from_element(n, 1.0), vec![(1, load)])?;
        Ok(Self { load: amplitude, still, uniform: true, ..Self::of(definition)? })
    }

    /// A word with its periods of the load as scenes have it: `0+`, `0+,0+/2`.
    #[must_use]
    pub fn name_of((word, periods): &(Word, u32)) -> String {
        if *periods == 1 { word.to_string() } else { format!("{word}/{periods}") }
    }

    /// The words of a map as its table has them.
    pub(super) fn names(&self) -> &[Arc<str>] {
        &self.names
    }

    /// All that its file says, as data.
    #[must_use]
    pub fn given(&self) -> &Map<String, Value> {
        &self.told
    }

    /// The files that it names.
    pub(super) fn named(&self) -> &Files {
        &self.named
    }

    /// All that decides what its table holds: what its file says but for the title, and a checksum of each file that it names.
    pub(super) fn parts(&self) -> Map<String, Value> {
        let mut parts = Map::clone(&self.told);
        parts.remove("title");
        if !self.named.is_empty() {
            let sum = |text: &String| format!("xxh3 {:032x}", xxhash_rust::xxh3::xxh3_128(text.as_bytes()));
            let sums: Map<String, Value> =
                self.named.iter().map(|(name, text)| (name.clone(), sum(text).into())).collect();
            parts.insert("files".to_owned(), sums.into());
        }
        parts
    }

    /// A checksum of all that decides what its table holds: of what was read, not of the words that said it.
    pub(super) fn meaning(&self) -> String {
        let Self { definition, contacts, omega, load, still, damping, stability, tolerance, axes, axis_names, .. } =
            self;
        let structure = (definition, contacts, omega, load, still, damping, self.uniform);
        let text = format!("{structure:?} {:?}", (self.asked(), stability, tolerance, axes, axis_names));
        format!("xxh3 {:032x}", xxhash_rust::xxh3::xxh3_128(text.as_bytes()))
    }

    /// The same with another threshold.
    pub(super) fn with_tolerance(&mut self, tolerance: Tolerance) {
        self.tolerance = tolerance;
        if let (Tolerance::Growth(growth), Some(Value::Object(compute))) =
            (tolerance, Arc::make_mut(&mut self.told).get_mut("compute"))
        {
            compute.insert("threshold".to_owned(), growth.into());
        }
    }

    /// The words that are asked for, with their periods of the load: those of a map, or the one of the file.
    #[must_use]
    pub fn asked(&self) -> Vec<(Word, u32)> {
        if self.words.is_empty() {
            return self.word.iter().map(|word| (word.clone(), self.force_periods)).collect();
        }
        self.words.clone()
    }

    /// The frequency, if the file or a flag has given it.
    #[must_use]
    pub fn omega(&self) -> Option<f64> {
        self.omega
    }

    /// The chain, if it is one.
    pub(super) fn chain(&self) -> Option<&ChainTable> {
        self.definition.chain()
    }

    /// Whether it is a chain under one force on every mass, whose size is the load.
    pub(super) fn is_uniform(&self) -> bool {
        self.uniform
    }

    /// Number of modes.
    pub(super) fn modes(&self) -> usize {
        self.modal.modes().len()
    }

    /// The contacts as they are now.
    #[must_use]
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// The value of a number of it.
    #[must_use]
    pub fn get(&self, setting: Setting) -> Option<f64> {
        match setting {
            Setting::Omega => self.omega,
            Setting::Load => Some(self.load),
            Setting::Static => Some(self.still),
            Setting::Damping => Some(self.definition.chain().map_or(self.damping, |chain| chain.damping)),
            Setting::CouplingDamping => Some(self.definition.chain()?.coupling_damping),
            Setting::Gamma1 => Some(self.definition.chain()?.gamma1),
            Setting::Gamma2 => Some(self.definition.chain()?.gamma2),
            Setting::Asymmetry => {
                self.contacts.iter().find_map(|contact| Some(0.5 * (contact.lower? + contact.upper?)))
            }
            Setting::RestitutionOfAll => self.contacts.first().map(|contact| contact.restitution),
            Setting::Lower(contact) => self.contacts.get(contact)?.lower,
            Setting::Upper(contact) => self.contacts.get(contact)?.upper,
            Setting::Restitution(contact) => Some(self.contacts.get(contact)?.restitution),
            Setting::Entry(..) | Setting::LoadOf(_) | Setting::StaticOf(_) => self.definition.entry(setting),
        }
    }

    /// Another value of a number.
    ///
    /// # Errors
    /// A contact that is not there, a value out of its range.
    pub fn set(&mut self, setting: Setting, value: f64) -> Result<(), String> {
        if !value.is_finite() {
            return Err(format!("{setting} = {value} is out of range: give a finite number"));
        }
        let count = self.contacts.len();
        let contacts = &mut self.contacts;
        let mut contact = |number: usize, change: fn(&mut Contact, f64)| {
            let place = contacts.get_mut(number);
            let place = place.ok_or_else(|| format!("{setting}: the structure has the contacts 0 to {}", count - 1))?;
            change(place, value);
            Ok::<(), String>(())
        };
        match setting {
            Setting::Omega if value <= 0.0 => {
                return Err(format!("omega = {value} is out of range: give a positive number"));
            }
            Setting::Omega => self.omega = Some(value),
            Setting::Load => self.load = value,
            Setting::Static => self.still = value,
            Setting::Damping if self.definition.chain().is_none() => {
                self.modal = Arc::new(self.definition.modal(value)?);
                self.damping = value;
            }
            Setting::Damping | Setting::CouplingDamping | Setting::Gamma1 | Setting::Gamma2 => {
                let change = |chain: &mut ChainTable| {
                    let place = match setting {
                        Setting::Damping => &mut chain.damping,
                        Setting::CouplingDamping => &mut chain.coupling_damping,
                        Setting::Gamma1 => &mut chain.gamma1,
                        _ => &mut chain.gamma2,
                    };
                    *place = value;
                };
                let changed = self.definition.with_chain(change);
                let changed =
                    changed.ok_or_else(|| format!("{setting} is of chains: this structure has matrices or modes"))?;
                self.definition = Arc::new(changed?);
                self.modal = Arc::new(self.definition.modal(1.0)?);
            }
            Setting::Entry(..) | Setting::LoadOf(_) | Setting::StaticOf(_) => {
                self.definition = Arc::new(self.definition.with_entry(setting, value)?);
                self.modal = Arc::new(self.definition.modal(self.damping)?);
            }
            Setting::Asymmetry => self.contacts.iter_mut().for_each(|contact| {
                if let (Some(lower), Some(upper)) = (contact.lower, contact.upper) {
                    let half = 0.5 * (upper - lower);
                    (contact.lower, contact.upper) = (Some(value - half), Some(value + half));
                }
            }),
            Setting::RestitutionOfAll => self.contacts.iter_mut().for_each(|contact| contact.restitution = value),
            Setting::Lower(number) => contact(number, |contact, value| contact.lower = Some(value))?,
            Setting::Upper(number) => contact(number, |contact, value| contact.upper = Some(value))?,
            Setting::Restitution(number) => contact(number, |contact, value| contact.restitution = value)?,
        }
        self.structure().map(|_| ())
    }

    /// The structure with its values as they are now.
    ///
    /// # Errors
    /// Barriers out of order, a restitution out of range.
    pub fn structure(&self) -> Result<Arc<ModalStructure>, String> {
        if self.load == 1.0 && self.still == 1.0 && self.modal.contacts() == self.contacts {
            return Ok(self.modal.clone());
        }
        let structure = self.modal.with_loads_times(self.load, self.still).with_contacts(self.contacts.clone());
        structure.map(Arc::new).map_err(|error| error.to_string())
    }

    /// The model with its values as they are now.
    ///
    /// # Errors
    /// As [`StructureScene::structure`]; a frequency that is missing.
    pub fn model(&self) -> Result<StructureModel, String> {
        let omega = self.omega.ok_or("omega is missing: give omega = … in the scene, or --omega")?;
        StructureModel::new(self.structure()?, omega).map_err(|error| error.to_string())
    }

    /// Coordinates ξ of all modes of displacements and velocities of the coordinates.
    ///
    /// # Errors
    /// Lists that are too long or too short; a modal model, which has no coordinates.
    pub fn modes_of(&self, displacement: &[f64], velocity: &[f64]) -> Result<Vec<[f64; 2]>, String> {
        self.definition.project(&self.modal, displacement, velocity, self.damping)
    }

    /// Energies and powers in the coordinates of the modes; `None` of modes of complex shape without matrices.
    ///
    /// # Errors
    /// As [`StructureScene::structure`].
    pub fn energy_form(&self) -> Result<Option<EnergyForm>, String> {
        Ok(self.definition.energy_form(self.structure()?.as_ref(), [self.load, self.still, self.damping]))
    }
}

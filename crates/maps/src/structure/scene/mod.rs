//! A scene of a structure: the file, checked, and the model at any values of its numbers.
//!
//! | module | holds |
//! |---|---|
//! | `text`, `file` | the scene of a text, of a file |
//! | `numbers` | its numbers by name, and the model at their values |
//! | `effect` | whether one of them changes anything |

mod effect;
mod file;
mod numbers;
mod text;

use std::sync::Arc;

use serde_json::{Map, Value};
use vibrochain_breather::Word;
use vibrochain_floquet::Tolerance;
use vibrochain_lattice::{Complex, Contact, DampedChain, ModalStructure, Stop, aside};

use super::definition::Definition;
use super::setting::Setting;
use super::tables::ChainTable;
use crate::grid::Files;
use crate::scene::Axis;

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
    /// From which excess on an orbit counts as unstable.
    pub tolerance: Tolerance,
    /// Whether a map tells stability.
    pub stability: bool,
    /// Whether contacts that share coordinates and hit at one instant do so in sequence, where a run ends otherwise.
    pub in_sequence: bool,
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
    stop: Stop,
}

/// Coordinates from which on modes take longer than it takes to begin a thread.
const MANY: usize = 100;

impl StructureScene {
    fn of(definition: Definition) -> Result<Self, String> {
        Ok(Self {
            title: None,
            word: None,
            force_periods: 1,
            words: Vec::new(),
            tolerance: Tolerance::Rounding,
            stability: true,
            in_sequence: false,
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
            stop: Stop::default(),
        })
    }

    /// The same, whose modes, and whatever is asked of its models, are worked out no longer than until the request to stop is raised.
    #[must_use]
    pub fn until(self, stop: &Stop) -> Self {
        Self { stop: stop.clone(), ..self }
    }

    /// The modes of what it is made of now, with its dashpots times `damping`.
    fn with_modes(&mut self, damping: f64) -> Result<(), String> {
        let modal = if self.modal.coordinates() < MANY {
            self.definition.modal(damping)?
        } else {
            let definition = self.definition.clone();
            aside(&self.stop, move || definition.modal(damping)).map_err(|stopped| stopped.to_string())??
        };
        self.modal = Arc::new(modal);
        Ok(())
    }

    /// A chain under the load `amplitude` and the static load `still` on every mass; contact n is mass n, free where it has no barrier.
    ///
    /// # Errors
    /// Numbers out of range, as many contacts as there are masses not given.
    pub fn of_chain(chain: &ChainTable, contacts: Vec<Contact>, amplitude: f64, still: f64) -> Result<Self, String> {
        let n = chain.sites;
        if contacts.len() != n {
            return Err(format!("{} contacts where there are {n} masses", contacts.len()));
        }
        let contacts = contacts.into_iter().enumerate().map(|(n, contact)| (vec![(n, 1.0)], contact)).collect();
        let load = vec![Complex::new(1.0, 0.0); n];
        let definition = Definition::of_chain(chain, contacts, vec![1.0; n], vec![(1, load)], None)?;
        Ok(Self { load: amplitude, still, uniform: true, ..Self::of(definition)? })
    }

    /// A word with its periods of the load as scenes have it: `0+`, `0+,0+/2`.
    #[must_use]
    pub fn name_of((word, periods): &(Word, u32)) -> String {
        if *periods == 1 { word.to_string() } else { format!("{word}/{periods}") }
    }

    /// The words of a map as its table has them.
    pub(in crate::structure) fn names(&self) -> &[Arc<str>] {
        &self.names
    }

    /// All that its file says, as data.
    #[must_use]
    pub fn given(&self) -> &Map<String, Value> {
        &self.told
    }

    /// The files that it names.
    pub(in crate::structure) fn named(&self) -> &Files {
        &self.named
    }

    /// All that decides what its table holds: what its file says but for the title, and a checksum of each file that it names.
    pub(in crate::structure) fn parts(&self) -> Map<String, Value> {
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
    pub(in crate::structure) fn meaning(&self) -> String {
        let Self { definition, contacts, omega, load, still, damping, stability, tolerance, axes, axis_names, .. } =
            self;
        let structure = (definition, contacts, omega, load, still, damping, self.uniform);
        let text = format!("{structure:?} {:?}", (self.asked(), stability, tolerance, axes, axis_names));
        format!("xxh3 {:032x}", xxhash_rust::xxh3::xxh3_128(text.as_bytes()))
    }

    /// The same with another threshold.
    pub(in crate::structure) fn with_tolerance(&mut self, tolerance: Tolerance) {
        self.tolerance = tolerance;
        if let (Tolerance::Excess(excess), Some(Value::Object(compute))) =
            (tolerance, Arc::make_mut(&mut self.told).get_mut("compute"))
        {
            compute.insert("threshold".to_owned(), excess.into());
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
    pub(in crate::structure) fn chain(&self) -> Option<&DampedChain> {
        self.definition.chain()
    }

    /// Whether it is a chain under one force on every mass, whose size is the load.
    pub(in crate::structure) fn is_uniform(&self) -> bool {
        self.uniform
    }

    /// Number of modes.
    pub(in crate::structure) fn modes(&self) -> usize {
        self.modal.modes().len()
    }

    /// How many modes there are where only some are kept, and the effective mass that all of them give each contact.
    #[must_use]
    pub fn whole(&self) -> Option<(usize, Vec<f64>)> {
        self.definition.whole_masses().map(|masses| (self.modal.coordinates(), masses))
    }

    /// For each contact its effective mass by the modes that are kept, and by all modes. The list is empty where all modes are kept.
    pub(in crate::structure) fn kept_masses(&self) -> Vec<(f64, f64)> {
        let all = self.definition.whole_masses().unwrap_or_default();
        all.into_iter().enumerate().map(|(contact, all)| (self.modal.effective_mass(contact), all)).collect()
    }

    /// How many modes there are where only some are kept.
    pub(in crate::structure) fn all_modes(&self) -> Option<usize> {
        self.definition.keeps_some().then(|| self.modal.coordinates())
    }

    /// The contacts as they are now.
    #[must_use]
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }
}

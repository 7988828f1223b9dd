//! What a structure is made of: matrices, modes or a chain.

use nalgebra::{DMatrix, DVector};
use vibrochain_lattice::{
    Complex, Contact, DampedChain, EnergyForm, LinearMode, ModalStructure, ModeShape, RowEnds, Structure,
};

use super::named::Named;
use super::setting::{Matrix, Setting};
use super::sizes::{check_chain, check_size};
use super::tables::{ChainTable, ContactTable, ForceTable, ModesGiven, StructureTable};

type C = Complex<f64>;

/// The most a mode may be damped, against critical: its slow pole is a difference, of which no four digits are left beyond.
const MOST_RATIO: f64 = 7e5;

/// A structure as it was given.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Definition {
    Matrices(Box<Structure>),
    Chain(Box<DampedChain>),
    Modes(ModalStructure),
}

impl Definition {
    /// Checks sizes as far as they are not the structure's business.
    pub(super) fn new(
        table: &StructureTable,
        contacts: &[ContactTable],
        force: &ForceTable,
        files: &Named<'_>,
    ) -> Result<Self, String> {
        let free = |contact: &ContactTable| contact.lower.is_none() && contact.upper.is_none();
        if let Some(number) = contacts.iter().position(free) {
            return Err(format!("contact {number} has no barrier: give lower, upper or both"));
        }
        check_size("masses", table.masses.as_ref().map_or(0, Vec::len))?;
        check_size("frequencies", table.frequencies.as_ref().map_or(0, Vec::len))?;
        check_size("contacts", contacts.len())?;
        let (kept, file) = match &table.modes {
            Some(ModesGiven::Kept(0)) => return Err("modes = 0 is out of range: give a whole number from 1".to_owned()),
            Some(ModesGiven::Kept(count)) => (Some(*count), None),
            Some(ModesGiven::File(file)) => (None, Some(file)),
            None => (None, None),
        };
        let kinds = [
            ("mass", table.mass.is_some() || table.masses.is_some()),
            ("frequencies", table.frequencies.is_some()),
            ("modes", file.is_some()),
            ("chain", table.chain.is_some()),
        ];
        let given: Vec<&str> = kinds.iter().filter(|(_, given)| *given).map(|(name, _)| *name).collect();
        match given[..] {
            ["mass"] => Self::of_matrices((table, kept), contacts, force, files),
            ["frequencies"] if kept.is_some() => Err(
                "modes keeps some of what matrices or a chain have: give the frequencies that are kept, and no others"
                    .to_owned(),
            ),
            ["frequencies"] => Self::of_modes(table, contacts, force),
            ["modes"] => {
                let table = files.modes(file.map_or("", String::as_str))?;
                Self::of_modes(&table, contacts, force)
            }
            ["chain"] => {
                let chain = table.chain.as_ref().ok_or("chain is missing")?;
                let contacts = contacts.iter().enumerate().map(|(number, given)| given.weighted(number, chain.sites));
                let contacts = contacts.collect::<Result<_, _>>()?;
                let (still, loads) = (force.still.clone().unwrap_or_default(), force.loads(chain.sites)?);
                Self::of_chain(chain, contacts, still, loads, kept)
            }
            [] => Err(
                "[structure] says nothing of masses: give mass or masses with stiffness, frequencies, modes, or chain"
                    .to_owned(),
            ),
            _ => Err(format!("[structure] has {}: give one of them", given.join(" and "))),
        }
    }

    fn of_matrices(
        (table, modes): (&StructureTable, Option<usize>),
        contacts: &[ContactTable],
        force: &ForceTable,
        files: &Named<'_>,
    ) -> Result<Self, String> {
        let mass = match (&table.mass, &table.masses) {
            (Some(mass), None) => files.matrix("mass", mass)?,
            (None, Some(masses)) => DMatrix::from_diagonal(&DVector::from_vec(masses.clone())),
            _ => return Err("mass and masses are given: give one of them".to_owned()),
        };
        let stiffness = table.stiffness.as_ref().ok_or("stiffness is missing")?;
        let damping = table.damping.as_ref().map(|given| files.matrix("damping", given)).transpose()?;
        let n = mass.nrows();
        let structure = Structure {
            stiffness: files.matrix("stiffness", stiffness)?,
            damping: damping.unwrap_or_default(),
            contacts: contacts
                .iter()
                .enumerate()
                .map(|(number, given)| {
                    let (places, contact) = given.weighted(number, n)?;
                    let mut weights = DVector::zeros(n);
                    places.into_iter().for_each(|(place, weight)| weights[place] = weight);
                    Ok((weights, contact))
                })
                .collect::<Result<_, String>>()?,
            static_load: force.still.clone().map(DVector::from_vec).unwrap_or_default(),
            loads: (force.loads(n)?.into_iter()).map(|(number, load)| (number, DVector::from_vec(load))).collect(),
            mass,
            modes: None,
        };
        Self::Matrices(Box::new(structure)).keeping(modes)
    }

    /// The same with its slowest modes alone.
    fn keeping(mut self, modes: Option<usize>) -> Result<Self, String> {
        let (n, kept) = match &mut self {
            Self::Matrices(structure) => (structure.mass.nrows(), &mut structure.modes),
            Self::Chain(chain) => (chain.sites, &mut chain.modes),
            Self::Modes(_) => return Ok(self),
        };
        if let Some(kept) = modes.filter(|kept| *kept > n) {
            return Err(format!("modes = {kept} is out of range: the structure has {n}"));
        }
        *kept = modes;
        Ok(self)
    }

    /// Whether only some modes are kept.
    pub(super) fn keeps_some(&self) -> bool {
        match self {
            Self::Matrices(structure) => structure.modes.is_some(),
            Self::Chain(chain) => chain.modes.is_some(),
            Self::Modes(_) => false,
        }
    }

    /// Of each contact the effective mass that all modes give it, where some are left out.
    pub(super) fn whole_masses(&self) -> Option<Vec<f64>> {
        match self {
            Self::Matrices(structure) if structure.modes.is_some() => structure.effective_masses(),
            Self::Chain(chain) if chain.modes.is_some() => Some(chain.effective_masses()),
            _ => None,
        }
    }

    fn of_modes(table: &StructureTable, contacts: &[ContactTable], force: &ForceTable) -> Result<Self, String> {
        let frequencies = table.frequencies.as_ref().ok_or("frequencies are missing")?;
        let n = frequencies.len();
        let list = |name: &str, given: &Option<Vec<f64>>| match given {
            Some(list) if list.len() != n => {
                Err(format!("{name} has {} entries where there are {n} frequencies", list.len()))
            }
            Some(list) => Ok(list.clone()),
            None => Ok(vec![0.0; n]),
        };
        let (ratios, loads) = (list("ratios", &table.ratios)?, list("load_shapes", &table.load_shapes)?);
        let still = list("static_shapes", &table.static_shapes)?;
        let shapes = table
            .contact_shapes
            .as_ref()
            .ok_or("contact_shapes are missing: a list of one value a mode for each contact")?;
        if shapes.len() != contacts.len() || shapes.iter().any(|shape| shape.len() != n) {
            return Err(format!(
                "contact_shapes are to be {} lists of {n} values, one list for each contact",
                contacts.len()
            ));
        }
        if contacts.iter().any(|contact| contact.weights.is_some() || contact.at.is_some() || contact.between.is_some())
        {
            return Err(
                "contacts of a modal model have their shapes in contact_shapes: they take no weights, at or between"
                    .to_owned(),
            );
        }
        if force.load.is_some() || force.still.is_some() || !force.terms.is_empty() {
            return Err(
                "loads of a modal model are load_shapes and static_shapes of [structure]: [force] has harmonic alone"
                    .to_owned(),
            );
        }
        let harmonic = force.harmonic.unwrap_or(1);
        if let Some(frequency) = frequencies.iter().find(|frequency| !(frequency.is_finite() && **frequency >= 0.0)) {
            return Err(format!("frequencies has {frequency}: give numbers from 0"));
        }
        if let Some(ratio) = ratios.iter().find(|ratio| **ratio > MOST_RATIO) {
            return Err(format!(
                "ratios has {ratio}: give at most {MOST_RATIO}, beyond which slow motions have no digits"
            ));
        }
        let mode = |k: usize| {
            let (frequency, ratio) = (frequencies[k], ratios[k]);
            let shape = ModeShape {
                contacts: shapes.iter().map(|shape| shape[k]).collect(),
                coordinates: Vec::new(),
                still: still[k],
            };
            let square = frequency * frequency * (1.0 - ratio) * (1.0 + ratio);
            LinearMode::oscillator(ratio * frequency, square, &shape, &[C::new(loads[k], 0.0)])
        };
        let contacts = contacts.iter().map(ContactTable::contact).collect();
        let modal = ModalStructure::new(contacts, vec![harmonic], (0..n).map(mode).collect());
        modal.map(Self::Modes).map_err(|error| error.to_string())
    }

    /// A chain under loads.
    pub(super) fn of_chain(
        table: &ChainTable,
        contacts: Vec<(Vec<(usize, f64)>, Contact)>,
        static_load: Vec<f64>,
        loads: Vec<(u32, Vec<C>)>,
        modes: Option<usize>,
    ) -> Result<Self, String> {
        let ChainTable { sites, gamma1, gamma2, damping, coupling_damping, .. } = *table;
        let count = contacts.len();
        if sites == 0 {
            return Err("sites = 0 is out of range: give a whole number from 1".to_owned());
        }
        let ends = RowEnds::from_name(&table.ends)
            .ok_or_else(|| format!("ends = \"{}\" is unknown: give closed, free, fixed or fixed-free", table.ends))?;
        let chain = DampedChain {
            gamma1,
            gamma2,
            damping,
            coupling_damping,
            contacts,
            static_load,
            loads,
            ..DampedChain::new(sites, ends)
        };
        let chain = Self::Chain(Box::new(chain)).keeping(modes)?;
        check_chain(sites, modes.unwrap_or(sites), count)?;
        Ok(chain)
    }

    /// Its modes with all dashpots times `damping`; of a chain they are numbers of its own, as they are.
    pub(super) fn modal(&self, damping: f64) -> Result<ModalStructure, String> {
        let modal = match self {
            Self::Modes(modal) if damping == 1.0 => return Ok(modal.clone()),
            Self::Modes(modal) => {
                let modes = modal.modes().iter().map(|mode| mode.damped_times(damping)).collect();
                ModalStructure::new(modal.contacts().to_vec(), modal.harmonics().to_vec(), modes)
            }
            Self::Matrices(structure) => damped_times(structure, damping).modal(),
            Self::Chain(chain) => chain.modal(),
        };
        modal.map_err(|error| error.to_string())
    }

    /// Whether any dashpot can be multiplied; those of a chain are numbers of their own.
    pub(super) fn has_dashpots(&self) -> bool {
        match self {
            Self::Matrices(structure) => structure.damping.iter().any(|entry| *entry != 0.0),
            Self::Chain(_) => true,
            Self::Modes(modal) => modal.modes().iter().any(|mode| mode.decay != 0.0),
        }
    }

    /// A chain with other numbers; `None` of what is no chain.
    pub(super) fn with_chain(&self, change: impl Fn(&mut DampedChain)) -> Option<Self> {
        let Self::Chain(chain) = self else { return None };
        let mut chain = chain.clone();
        change(&mut chain);
        Some(Self::Chain(chain))
    }

    /// The matrices that are given as such, which can be changed; `None` of modes and of chains.
    fn matrices(&self) -> Option<&Structure> {
        match self {
            Self::Matrices(structure) => Some(structure),
            Self::Chain(_) | Self::Modes(_) => None,
        }
    }

    /// An entry of a matrix or of a load; `None` where there is none.
    pub(super) fn entry(&self, setting: Setting) -> Option<f64> {
        let structure = self.matrices()?;
        match setting {
            Setting::Entry(matrix, i, j) => match matrix {
                Matrix::Mass => structure.mass.get((i, j)).copied(),
                Matrix::Stiffness => structure.stiffness.get((i, j)).copied(),
                // None is no damping.
                Matrix::Damping if structure.damping.is_empty() => structure.mass.get((i, j)).map(|_| 0.0),
                Matrix::Damping => structure.damping.get((i, j)).copied(),
            },
            Setting::LoadOf(i) => {
                let load = structure.loads.first()?.1.get(i)?;
                Some(if load.im == 0.0 { load.re } else { load.norm() })
            }
            Setting::StaticOf(i) if structure.static_load.is_empty() => structure.mass.get((i, i)).map(|_| 0.0),
            Setting::StaticOf(i) => structure.static_load.get(i).copied(),
            _ => None,
        }
    }

    /// The structure with another entry of a matrix or of a load, which keeps its phase.
    pub(super) fn with_entry(&self, setting: Setting, value: f64) -> Result<Self, String> {
        if self.entry(setting).is_none() {
            let what = match (self.matrices(), setting) {
                (None, _) => "is of structures that are given by matrices".to_owned(),
                (Some(structure), Setting::LoadOf(_)) if structure.loads.is_empty() => {
                    "changes a load, and [force] has none".to_owned()
                }
                (Some(structure), _) => {
                    format!(
                        "does not exist: the structure has the coordinates 0 to {}",
                        structure.mass.nrows().saturating_sub(1)
                    )
                }
            };
            return Err(format!("{setting} {what}"));
        }
        let mut changed = self.clone();
        let Self::Matrices(structure) = &mut changed else { return Err(format!("{setting} is of matrices")) };
        let n = structure.mass.nrows();
        match setting {
            Setting::Entry(matrix, i, j) => {
                let matrix = match matrix {
                    Matrix::Mass => &mut structure.mass,
                    Matrix::Stiffness => &mut structure.stiffness,
                    Matrix::Damping => &mut structure.damping,
                };
                if matrix.is_empty() {
                    *matrix = DMatrix::zeros(n, n);
                }
                (matrix[(i, j)], matrix[(j, i)]) = (value, value);
            }
            Setting::LoadOf(i) => {
                if let Some((_, loads)) = structure.loads.first_mut() {
                    let phase = if loads[i].im == 0.0 { C::new(1.0, 0.0) } else { loads[i] / loads[i].norm() };
                    loads[i] = phase * value;
                }
            }
            Setting::StaticOf(i) => {
                if structure.static_load.is_empty() {
                    structure.static_load = DVector::zeros(n);
                }
                structure.static_load[i] = value;
            }
            _ => {}
        }
        Ok(changed)
    }

    /// The chain, if it is one.
    pub(super) fn chain(&self) -> Option<&DampedChain> {
        match self {
            Self::Chain(chain) => Some(chain),
            Self::Matrices(_) | Self::Modes(_) => None,
        }
    }

    /// ξ of a state of the coordinates; a modal model has none.
    pub(super) fn project(
        &self,
        modal: &ModalStructure,
        place: &[f64],
        velocity: &[f64],
        damping: f64,
    ) -> Result<Vec<[f64; 2]>, String> {
        let modes = match self {
            Self::Matrices(structure) => {
                let [place, velocity] = [place, velocity].map(DVector::from_row_slice);
                damped_times(structure, damping).project(modal, &place, &velocity)
            }
            Self::Chain(chain) => chain.project(modal, place, velocity),
            Self::Modes(_) => {
                return Err("a modal model has no coordinates: start on an orbit, or at rest".to_owned());
            }
        };
        modes.map_err(|error| error.to_string())
    }

    /// The energy, and the powers of loads and dashpots scaled by these factors. `None` for a modal model with complex shapes: they do not
    /// determine the energy.
    pub(super) fn energy_form(&self, modal: &ModalStructure, [load, still, damping]: [f64; 3]) -> Option<EnergyForm> {
        if let Some(form) = modal.energy_form() {
            return Some(form);
        }
        let Self::Matrices(given) = self else { return None };
        let loads = given.loads.iter().map(|(harmonic, load_of)| (*harmonic, load_of * C::new(load, 0.0)));
        let static_load = &given.static_load * still;
        let structure = Structure { static_load, loads: loads.collect(), ..damped_times(given, damping) };
        Some(structure.energy_form(modal))
    }

    /// The contacts as they were given.
    pub(super) fn contacts(&self) -> Vec<Contact> {
        match self {
            Self::Modes(modal) => modal.contacts().to_vec(),
            Self::Matrices(structure) => structure.contacts.iter().map(|(_, contact)| *contact).collect(),
            Self::Chain(chain) => chain.contacts.iter().map(|(_, contact)| *contact).collect(),
        }
    }
}

/// With all dashpots times `damping`.
fn damped_times(structure: &Structure, damping: f64) -> Structure {
    Structure { damping: &structure.damping * damping, ..structure.clone() }
}

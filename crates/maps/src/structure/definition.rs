//! What a structure is made of: matrices, modes or a chain.

use nalgebra::{DMatrix, DVector};
use vibrochain_lattice::{Complex, Contact, EnergyForm, LinearMode, ModalStructure, ModeShape, Structure};

use super::named::Named;
use super::setting::{Matrix, Setting};
use super::sizes::check_size;
use super::tables::{ChainTable, ContactTable, ForceTable, ModesGiven, StructureTable};

type C = Complex<f64>;

/// The most a mode may be damped, against critical: its slow pole is a difference, of which no four digits are left beyond.
const MOST_RATIO: f64 = 7e5;

/// A structure as it was given.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Definition {
    /// By matrices, perhaps those of a chain.
    Matrices(Box<Structure>, Option<ChainTable>),
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
                let chain = table.chain.clone().ok_or("chain is missing")?;
                let n = chain.sites;
                let contacts = contacts.iter().enumerate().map(|(number, given)| given.weighted(number, n));
                let contacts = contacts.collect::<Result<_, _>>()?;
                let still = force.still.clone().map(DVector::from_vec).unwrap_or_default();
                Self::of_chain(chain, contacts, still, force.loads(n)?)?.keeping(kept)
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
                .map(|(number, given)| given.weighted(number, n))
                .collect::<Result<_, _>>()?,
            static_load: force.still.clone().map(DVector::from_vec).unwrap_or_default(),
            loads: force.loads(n)?,
            mass,
            modes: None,
        };
        Self::Matrices(Box::new(structure), None).keeping(modes)
    }

    /// The same with its slowest modes alone.
    fn keeping(mut self, modes: Option<usize>) -> Result<Self, String> {
        if let Self::Matrices(structure, _) = &mut self {
            let n = structure.mass.nrows();
            if let Some(kept) = modes.filter(|kept| *kept > n) {
                return Err(format!("modes = {kept} is out of range: the structure has {n}"));
            }
            structure.modes = modes;
        }
        Ok(self)
    }

    /// Whether only some modes are kept.
    pub(super) fn keeps_some(&self) -> bool {
        matches!(self, Self::Matrices(structure, _) if structure.modes.is_some())
    }

    /// Of each contact the effective mass that all modes give it, where some are left out.
    pub(super) fn whole_masses(&self) -> Option<Vec<f64>> {
        let Self::Matrices(structure, _) = self else { return None };
        structure.modes?;
        structure.effective_masses()
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

    /// The matrices of a chain.
    pub(super) fn of_chain(
        chain: ChainTable,
        contacts: Vec<(DVector<f64>, Contact)>,
        static_load: DVector<f64>,
        loads: Vec<(u32, DVector<C>)>,
    ) -> Result<Self, String> {
        let n = chain.sites;
        if n == 0 {
            return Err("sites = 0 is out of range: give a whole number from 1".to_owned());
        }
        check_size("sites", n)?;
        let (left, right) = match chain.ends.as_str() {
            "closed" => (None, None),
            "free" => (Some(0.0), Some(0.0)),
            "fixed" => (Some(1.0), Some(1.0)),
            "fixed-free" => (Some(1.0), Some(0.0)),
            other => return Err(format!("ends = \"{other}\" is unknown: give closed, free, fixed or fixed-free")),
        };
        // Springs between neighbours, by which stiffness and dashpots alike are made.
        let mut coupling = DMatrix::zeros(n, n);
        let mut spring = |i: usize, j: usize| {
            coupling[(i, i)] += 1.0;
            coupling[(j, j)] += 1.0;
            coupling[(i, j)] -= 1.0;
            coupling[(j, i)] -= 1.0;
        };
        (1..n).for_each(|i| spring(i - 1, i));
        if left.is_none() && n > 1 {
            spring(n - 1, 0);
        }
        coupling[(0, 0)] += left.unwrap_or(0.0);
        coupling[(n - 1, n - 1)] += right.unwrap_or(0.0);
        let unit = DMatrix::<f64>::identity(n, n);
        let damped = chain.damping != 0.0 || chain.coupling_damping != 0.0;
        let structure = Structure {
            mass: unit.clone(),
            stiffness: &unit * chain.gamma1 + &coupling * chain.gamma2,
            damping: if damped {
                &unit * chain.damping + &coupling * chain.coupling_damping
            } else {
                DMatrix::default()
            },
            contacts,
            static_load,
            loads,
            modes: None,
        };
        Ok(Self::Matrices(Box::new(structure), Some(chain)))
    }

    /// Its modes with all dashpots times `damping`.
    pub(super) fn modal(&self, damping: f64) -> Result<ModalStructure, String> {
        let modal = match self {
            Self::Modes(modal) if damping == 1.0 => return Ok(modal.clone()),
            Self::Modes(modal) => {
                let modes = modal.modes().iter().map(|mode| mode.damped_times(damping)).collect();
                ModalStructure::new(modal.contacts().to_vec(), modal.harmonics().to_vec(), modes)
            }
            Self::Matrices(structure, _) => damped_times(structure, damping).modal(),
        };
        modal.map_err(|error| error.to_string())
    }

    /// Whether any dashpot can be multiplied; those of a chain are numbers of their own.
    pub(super) fn has_dashpots(&self) -> bool {
        match self {
            Self::Matrices(structure, chain) => chain.is_some() || structure.damping.iter().any(|entry| *entry != 0.0),
            Self::Modes(modal) => modal.modes().iter().any(|mode| mode.decay != 0.0),
        }
    }

    /// A chain with other numbers; `None` of what is no chain.
    pub(super) fn with_chain(&self, change: impl Fn(&mut ChainTable)) -> Option<Result<Self, String>> {
        let Self::Matrices(structure, Some(chain)) = self else { return None };
        let mut chain = chain.clone();
        change(&mut chain);
        let Structure { contacts, static_load, loads, modes, .. } = Structure::clone(structure);
        Some(Self::of_chain(chain, contacts, static_load, loads).and_then(|changed| changed.keeping(modes)))
    }

    /// The matrices that are given as such, which can be changed; `None` of modes and of chains.
    fn matrices(&self) -> Option<&Structure> {
        match self {
            Self::Matrices(structure, None) => Some(structure),
            Self::Matrices(_, Some(_)) | Self::Modes(_) => None,
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
        let Self::Matrices(structure, None) = &mut changed else { return Err(format!("{setting} is of matrices")) };
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
    pub(super) fn chain(&self) -> Option<&ChainTable> {
        match self {
            Self::Matrices(_, chain) => chain.as_ref(),
            Self::Modes(_) => None,
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
        let Self::Matrices(structure, _) = self else {
            return Err("a modal model has no coordinates: start on an orbit, or at rest".to_owned());
        };
        let [place, velocity] = [place, velocity].map(DVector::from_row_slice);
        damped_times(structure, damping).project(modal, &place, &velocity).map_err(|error| error.to_string())
    }

    /// The energy, and the powers of loads and dashpots scaled by these factors. `None` for a modal model with complex shapes: they do not
    /// determine the energy.
    pub(super) fn energy_form(&self, modal: &ModalStructure, [load, still, damping]: [f64; 3]) -> Option<EnergyForm> {
        if let Some(form) = modal.energy_form() {
            return Some(form);
        }
        let Self::Matrices(given, _) = self else { return None };
        let loads = given.loads.iter().map(|(harmonic, load_of)| (*harmonic, load_of * C::new(load, 0.0)));
        let static_load = &given.static_load * still;
        let structure = Structure { static_load, loads: loads.collect(), ..damped_times(given, damping) };
        Some(structure.energy_form(modal))
    }

    /// The contacts as they were given.
    pub(super) fn contacts(&self) -> Vec<Contact> {
        match self {
            Self::Modes(modal) => modal.contacts().to_vec(),
            Self::Matrices(structure, _) => structure.contacts.iter().map(|(_, contact)| *contact).collect(),
        }
    }
}

/// With all dashpots times `damping`; those of a chain, which are its own numbers, times 1.
fn damped_times(structure: &Structure, damping: f64) -> Structure {
    Structure { damping: &structure.damping * damping, ..structure.clone() }
}

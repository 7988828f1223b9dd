//! What the tables of a scene may hold: `[structure]`, `[[contact]]`, `[force]`, `[sweep]`, `[compute]`.

use serde::Deserialize;
use vibrochain_lattice::{Complex, Contact, StructureError};

use super::setting::Setting;
use crate::scene::{Axis, AxisTable};

type C = Complex<f64>;

/// Rows, or the file that has them.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged, expecting = "give rows of numbers, [[…], […]], or the name of a Matrix Market file")]
pub(super) enum MatrixGiven {
    Rows(Vec<Vec<f64>>),
    File(String),
}

/// How many modes are kept, or the file that has them.
#[derive(Debug, Clone, Deserialize)]
#[serde(
    untagged,
    expecting = "give how many modes are kept, a whole number from 1, or the name of a CSV file of modes"
)]
pub(super) enum ModesGiven {
    Kept(usize),
    File(String),
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StructureTable {
    pub(super) mass: Option<MatrixGiven>,
    pub(super) masses: Option<Vec<f64>>,
    pub(super) stiffness: Option<MatrixGiven>,
    pub(super) damping: Option<MatrixGiven>,
    pub(super) frequencies: Option<Vec<f64>>,
    pub(super) ratios: Option<Vec<f64>>,
    pub(super) contact_shapes: Option<Vec<Vec<f64>>>,
    pub(super) load_shapes: Option<Vec<f64>>,
    pub(super) static_shapes: Option<Vec<f64>>,
    pub(super) modes: Option<ModesGiven>,
    pub(super) chain: Option<ChainTable>,
    #[serde(default)]
    pub(super) in_sequence: bool,
}

/// Unit masses, each on a spring γ₁ and a dashpot, with springs γ₂ and dashpots between neighbours.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChainTable {
    /// Number of masses.
    pub sites: usize,
    /// γ₁
    pub gamma1: f64,
    /// γ₂
    pub gamma2: f64,
    /// `closed`, `free`, `fixed` or `fixed-free`.
    #[serde(default = "closed")]
    pub ends: String,
    /// c of each mass.
    #[serde(default)]
    pub damping: f64,
    /// c₂ of each spring between neighbours.
    #[serde(default)]
    pub coupling_damping: f64,
}

fn closed() -> String {
    "closed".to_owned()
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ContactTable {
    pub(super) weights: Option<Vec<f64>>,
    pub(super) at: Option<usize>,
    pub(super) between: Option<[usize; 2]>,
    pub(super) lower: Option<f64>,
    pub(super) upper: Option<f64>,
    #[serde(default = "elastic")]
    pub(super) restitution: f64,
}

impl ContactTable {
    pub(super) fn contact(&self) -> Contact {
        Contact { lower: self.lower, upper: self.upper, restitution: self.restitution }
    }

    /// The coordinates that it sees, each once, with their weights, and the barriers; of a structure of `n` coordinates.
    pub(super) fn weighted(&self, number: usize, n: usize) -> Result<(Vec<(usize, f64)>, Contact), String> {
        let one = |coordinate: usize| {
            if coordinate < n {
                Ok(coordinate)
            } else {
                Err(format!(
                    "contact {number} is at coordinate {coordinate}: the structure has 0 to {}",
                    n.saturating_sub(1)
                ))
            }
        };
        let weights = match (&self.weights, self.at, self.between) {
            (Some(list), None, None) if list.len() != n => {
                let what = format!("the weights of contact {number}");
                return Err(StructureError::Size { what, given: list.len(), wanted: n }.to_string());
            }
            (Some(list), None, None) => list.iter().copied().enumerate().filter(|(_, weight)| *weight != 0.0).collect(),
            (None, Some(at), None) => vec![(one(at)?, 1.0)],
            (None, None, Some([from, to])) if from == to => vec![(one(from)?, 0.0)],
            (None, None, Some([from, to])) => vec![(one(from)?, 1.0), (one(to)?, -1.0)],
            (None, None, None) => return Err(format!("contact {number} is nowhere: give weights, at or between")),
            _ => return Err(format!("contact {number} is given twice: give one of weights, at and between")),
        };
        Ok((weights, self.contact()))
    }
}

fn elastic() -> f64 {
    1.0
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ForceTable {
    pub(super) load: Option<Vec<f64>>,
    pub(super) harmonic: Option<u32>,
    pub(super) phases: Option<Vec<f64>>,
    #[serde(rename = "static")]
    pub(super) still: Option<Vec<f64>>,
    #[serde(default)]
    pub(super) terms: Vec<TermTable>,
}

impl ForceTable {
    /// Number and load of each harmonic.
    pub(super) fn loads(&self, n: usize) -> Result<Vec<(u32, Vec<C>)>, String> {
        let complex = |load: &[f64], phases: &Option<Vec<f64>>| -> Vec<C> {
            let phase = |i: usize| phases.as_ref().and_then(|list| list.get(i)).copied().unwrap_or(0.0);
            load.iter().enumerate().map(|(i, f)| C::from_polar(1.0, phase(i)) * *f).collect()
        };
        let sized = |phases: &Option<Vec<f64>>| match phases {
            Some(list) if list.len() != n => {
                Err(format!("phases has {} entries where there are {n} coordinates", list.len()))
            }
            _ => Ok(()),
        };
        let mut loads = Vec::new();
        if let Some(load) = &self.load {
            sized(&self.phases)?;
            loads.push((self.harmonic.unwrap_or(1), complex(load, &self.phases)));
        } else if self.harmonic.is_some() || self.phases.is_some() {
            return Err("[force] has no load: give load = [..], one number for each coordinate".to_owned());
        }
        for term in &self.terms {
            sized(&term.phases)?;
            loads.push((term.harmonic, complex(&term.load, &term.phases)));
        }
        loads.sort_by_key(|(number, _)| *number);
        match loads.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            Some(pair) => Err(format!("harmonic {} of the load is given twice", pair[0].0)),
            None => Ok(loads),
        }
    }
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TermTable {
    harmonic: u32,
    load: Vec<f64>,
    phases: Option<Vec<f64>>,
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
    pub(super) fn all(&self) -> impl Iterator<Item = &AxisTable> {
        std::iter::once(&self.x).chain(&self.y).chain(&self.axes)
    }

    /// Whether an axis is of one of these names.
    pub(super) fn varies(&self, names: &[&str]) -> bool {
        self.all().any(|axis| names.contains(&axis.parameter.get_ref().as_str()))
    }
}

/// An axis over a number of a structure.
pub(super) fn axis(table: &AxisTable) -> Result<Axis<Setting>, String> {
    let name = table.parameter.get_ref();
    let values = table.values().map_err(|(_, message)| format!("axis {name}: {message}"))?;
    Ok(Axis { parameter: name.parse()?, values })
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ComputeTable {
    pub(super) families: Vec<String>,
    pub(super) threshold: Option<f64>,
    #[serde(default = "yes")]
    pub(super) stability: bool,
}

fn yes() -> bool {
    true
}

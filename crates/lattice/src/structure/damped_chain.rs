//! A chain, or rows of one side by side, with dashpots or without, as a structure: its modes in closed form, without matrices.
//!
//! Stiffness and dashpots are made of the same L along the rows and L′ across them, those of springs between neighbours. Shapes are those of the
//! chain without dashpots, and of eigenvalues κ of L and κ′ of L′
//!
//! ```text
//! Ω² = γ₁ + γ₂κ + γ₃κ′,   2δ = c + c₂κ .
//! ```

pub(crate) mod felt_shapes;

use std::cmp::Ordering;

use rustfft::num_complex::Complex;
use smallvec::SmallVec;

use super::contact::Contact;
use super::error::{StructureError, check_loads, finite};
use super::linear_mode::LinearMode;
use super::modal::ModalStructure;
use super::operator::{Layering, SparseOperator};
use super::oscillator::{Bounded, SeenShape, without_rounding};
use crate::error::MAX_MAGNITUDE;
use crate::model::chain::MAX_SITES;
use crate::modes::row::{Ends, RowEnds};
use crate::modes::row_modes::{FAINT, LayerModes, LayeredMode};
use crate::simd::twofold::{FINE, Twofold};

type C = Complex<f64>;

/// Squares below this part of their terms are 0: rounding of γ₁ and γ₂ could have made them.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Unit masses in a row, each on a spring γ₁ and a dashpot c, with springs γ₂ and dashpots c₂ between neighbours; contacts, a static load and
/// periodic loads as a structure has them.
///
/// ```
/// use vibrochain_lattice::{Contact, DampedChain, RowEnds};
/// let stop = Contact { lower: None, upper: Some(0.7), restitution: 0.8 };
/// let chain = DampedChain {
///     gamma1: 0.2,
///     gamma2: 0.1,
///     damping: 0.01,
///     contacts: vec![(vec![(0, 1.0)], stop)],
///     ..DampedChain::new(21, RowEnds::FixedFree)
/// };
/// let modal = chain.modal()?;
/// assert_eq!(modal.modes().len(), 21);
/// assert!((modal.mobility(0, 0) - 1.0).abs() < 1e-14);
/// # Ok::<(), vibrochain_lattice::StructureError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct DampedChain {
    /// Number of masses of a row.
    pub sites: usize,
    /// What stands at its ends.
    pub ends: RowEnds,
    /// Number of rows; mass n of row l is mass n + l·`sites`.
    pub layers: usize,
    /// What stands beside the first and the last row.
    pub layer_ends: Ends,
    /// γ₁
    pub gamma1: f64,
    /// γ₂
    pub gamma2: f64,
    /// γ₃, of springs from row to row.
    pub gamma3: f64,
    /// c of each mass.
    pub damping: f64,
    /// c₂ of each spring between neighbours.
    pub coupling_damping: f64,
    /// Of each contact the masses that it sees, with their weights; and where it is stopped.
    pub contacts: Vec<(Vec<(usize, f64)>, Contact)>,
    /// The static load of each mass; without entries: none.
    pub static_load: Vec<f64>,
    /// Number j and f of each harmonic, complex: |f|cos(jω(t+ψ) + arg f).
    pub loads: Vec<(u32, Vec<C>)>,
    /// Only so many of its modes count, the slowest; `None`: all do.
    pub modes: Option<usize>,
    /// Whether the motion of every mass is asked for, and not that of contacts alone.
    pub all_masses: bool,
}

/// A mode with its κ and Ω².
pub(super) struct Frequency {
    mode: LayeredMode,
    coupling: Twofold,
    pub(super) square: Bounded,
}

impl Frequency {
    /// The slower one first.
    pub(super) fn order(&self, other: &Self) -> Ordering {
        let [a, b] = [self, other].map(|one| one.square.sum);
        a.high.total_cmp(&b.high).then(a.low.total_cmp(&b.low))
    }

    /// # Errors
    /// [`StructureError::Unstable`]
    fn check(&self) -> Result<(), StructureError> {
        let square = self.square.sum;
        if square.high < 0.0 { Err(StructureError::Unstable { square: square.value() }) } else { Ok(()) }
    }
}

impl DampedChain {
    /// Masses without springs, dashpots, contacts and loads, to begin with.
    pub fn new(sites: usize, ends: RowEnds) -> Self {
        Self {
            sites,
            ends,
            layers: 1,
            layer_ends: Ends::Free,
            gamma1: 0.0,
            gamma2: 0.0,
            gamma3: 0.0,
            damping: 0.0,
            coupling_damping: 0.0,
            contacts: Vec::new(),
            static_load: Vec::new(),
            loads: Vec::new(),
            modes: None,
            all_masses: true,
        }
    }

    /// Its modes, the slowest first. Of a ring's pairs one has a node at mass 0. Numbers are right to the last digit or two
    /// ([`LinearMode::errors`]).
    ///
    /// # Errors
    /// [`StructureError`]: numbers out of range, sizes that do not fit, springs that let the chain fall over, too much damping. Of a contact that
    /// none of the modes which are kept moves, [`StructureError::Unmoved`].
    pub fn modal(&self) -> Result<ModalStructure, StructureError> {
        self.modal_of(|_, _| true)
    }

    /// The same of the modes that move a mass which a contact sees.
    pub(super) fn felt(&self) -> Result<ModalStructure, StructureError> {
        self.modal_of(|row, mode| self.is_felt(row, mode))
    }

    /// Whether a mode moves a mass that a contact sees.
    fn is_felt(&self, row: &LayerModes, mode: LayeredMode) -> bool {
        let mut masses = self.contacts.iter().flat_map(|(weights, _)| weights.iter().map(|(n, _)| *n));
        masses.any(|n| !row.is_node(mode, n))
    }

    fn modal_of(&self, is_wanted: impl Fn(&LayerModes, LayeredMode) -> bool) -> Result<ModalStructure, StructureError> {
        self.check()?;
        let row = self.row();
        let (is_uniform, reaches) = (self.are_uniform(), self.reaches());
        let slowest = self.slowest(&row, is_wanted)?;
        // Room for exactly as many: of a large lattice they are most of what it takes.
        let mut modes = Vec::with_capacity(slowest.len());
        for (k, frequency) in slowest.iter().enumerate() {
            modes.push(self.linear_mode(k, frequency, self.seen(&row, frequency.mode, &is_uniform), &reaches)?);
        }
        drop(slowest);
        Ok(self.of_modes(modes)?.with_operator(self.operator()))
    }

    /// The shapes of its modes, whatever its springs are.
    fn row(&self) -> LayerModes {
        LayerModes::new((self.sites, self.ends), (self.layers, self.layer_ends))
    }

    /// Whether each load is the same on all masses.
    fn are_uniform(&self) -> Vec<bool> {
        self.loads.iter().map(|(_, load)| load.windows(2).all(|pair| pair[0] == pair[1])).collect()
    }

    /// What each contact may see of a mode at most.
    fn reaches(&self) -> Vec<f64> {
        let reach = |weights: &[(usize, f64)]| weights.iter().map(|(_, weight)| weight * weight).sum::<f64>().sqrt();
        self.contacts.iter().map(|(weights, _)| reach(weights)).collect()
    }

    /// Mode number `k` of what is seen of its shape.
    fn linear_mode(
        &self,
        k: usize,
        &Frequency { coupling, square, .. }: &Frequency,
        shape: SeenShape,
        reaches: &[f64],
    ) -> Result<LinearMode, StructureError> {
        let (own, between) = (Twofold::from(self.damping), Twofold::from(self.coupling_damping) * coupling);
        let half = Twofold::from(0.5);
        let error = 0.5 * FAINT * (own.high.abs() + between.high.abs());
        let decay = Bounded { sum: (own + between) * half, error: if coupling.high == 0.0 { 0.0 } else { error } };
        Ok(without_rounding(shape.oscillator(k, square, decay)?, reaches.iter().copied()))
    }

    /// The structure of its modes.
    fn of_modes(&self, modes: Vec<LinearMode>) -> Result<ModalStructure, StructureError> {
        let contacts = self.contacts.iter().map(|(_, contact)| *contact).collect();
        let harmonics = self.loads.iter().map(|(number, _)| *number).collect();
        ModalStructure::keeping(self.modes, contacts, harmonics, modes)
    }

    /// Of all masses and modes, if they are asked for.
    fn operator(&self) -> Option<SparseOperator> {
        let whole = self.all_masses && self.modes.unwrap_or(self.masses()) >= self.masses();
        whole.then(|| self.by_masses())
    }

    /// How its masses pull at each other.
    pub(super) fn by_masses(&self) -> SparseOperator {
        let contacts = self.contacts.iter().map(|(weights, _)| weights.clone()).collect();
        let loads = self.loads.iter().map(|load| load.1.clone()).collect();
        let by = ([self.gamma1, self.gamma2], [self.damping, self.coupling_damping]);
        let layering = Layering { layers: self.layers, ends: self.layer_ends, stiffness: self.gamma3 };
        SparseOperator::rows((self.sites, self.ends), layering, by, contacts, loads)
    }

    /// The mass that an impact of each contact feels if all modes are kept.
    pub fn effective_masses(&self) -> Vec<f64> {
        let mass = |weights: &[(usize, f64)]| 1.0 / weights.iter().map(|(_, weight)| weight * weight).sum::<f64>();
        self.contacts.iter().map(|(weights, _)| mass(weights)).collect()
    }

    /// Coordinates ξ of all modes of a state (q, q′); `modal` is what [`DampedChain::modal`] made of it.
    ///
    /// # Errors
    /// [`StructureError::Size`] where `place` or `velocity` has not one number a mass.
    pub fn project(
        &self,
        modal: &ModalStructure,
        place: &[f64],
        velocity: &[f64],
    ) -> Result<Vec<[f64; 2]>, StructureError> {
        StructureError::sized("the place", place.len(), self.masses())?;
        StructureError::sized("the velocity", velocity.len(), self.masses())?;
        let row = self.row();
        let of_mode = |(frequency, mode): (Frequency, &LinearMode)| {
            let shape: Vec<f64> = (0..self.masses()).map(row.shape(frequency.mode)).map(Twofold::value).collect();
            let dot = |list: &[f64]| shape.iter().zip(list).map(|(shape, x)| shape * x).sum::<f64>();
            mode.amplitudes(dot(place), dot(velocity))
        };
        Ok(self.slowest(&row, |_, _| true)?.into_iter().zip(modal.modes()).map(of_mode).collect())
    }

    /// The modes that are kept, by rising frequency: of those that are wanted.
    fn slowest(
        &self,
        row: &LayerModes,
        is_wanted: impl Fn(&LayerModes, LayeredMode) -> bool,
    ) -> Result<Vec<Frequency>, StructureError> {
        let frequency = |mode: LayeredMode| self.frequency(mode, row.stiffnesses(mode));
        let wanted = || row.all().filter(|mode| is_wanted(row, *mode));
        let mut all = Vec::with_capacity(wanted().count());
        all.extend(wanted().map(frequency));
        all.sort_by(Frequency::order);
        if let Some(lowest) = all.first() {
            lowest.check()?;
        }
        all.truncate(self.modes.unwrap_or(all.len()));
        Ok(all)
    }

    /// Ω² of a mode, and its κ and κ′.
    fn frequency(&self, mode: LayeredMode, [coupling, across]: [Twofold; 2]) -> Frequency {
        let own = Twofold::from(self.gamma1);
        let (between, beside) = (Twofold::from(self.gamma2) * coupling, Twofold::from(self.gamma3) * across);
        let size = own.high.abs() + between.high.abs() + beside.high.abs();
        let sum = own + between + beside;
        let square = if sum.high.abs() <= ROUNDING * size {
            Bounded::default()
        } else {
            Bounded { sum, error: if between.high == 0.0 && beside.high == 0.0 { 0.0 } else { FAINT * size } }
        };
        Frequency { mode, coupling, square }
    }

    /// Number of masses of all rows.
    fn masses(&self) -> usize {
        self.sites * self.layers
    }

    /// What contacts, loads and, if they are asked for, masses see of a mode; and whether each load is the same on all masses.
    fn seen(&self, row: &LayerModes, mode: LayeredMode, are_uniform: &[bool]) -> SeenShape {
        let shape = row.shape(mode);
        let all: Vec<Twofold> = if self.all_masses { (0..self.masses()).map(&shape).collect() } else { Vec::new() };
        let at = |n: usize| all.get(n).copied().unwrap_or_else(|| shape(n));
        let seen = |places: &mut dyn Iterator<Item = (usize, f64)>| {
            let places: SmallVec<[(f64, Twofold); 4]> =
                places.filter(|(_, weight)| *weight != 0.0).map(|(n, weight)| (weight, at(n))).collect();
            let (count, size) =
                (places.len() as f64, places.iter().map(|(weight, shape)| (weight * shape.high).abs()).sum::<f64>());
            let high = Twofold::dot(places.iter().map(|(weight, shape)| (*weight, shape.high)));
            let low = places.iter().map(|(weight, shape)| weight * shape.low).sum::<f64>();
            (Bounded { sum: high + Twofold::from(low), error: (FAINT + count * (count + 1.0) * FINE) * size }, size)
        };
        let balanced = row.is_balanced(mode);
        let loaded = |load: &mut (dyn Iterator<Item = f64> + '_), is_uniform: bool| {
            if balanced && is_uniform {
                return Bounded::default();
            }
            let (seen, size) = seen(&mut load.enumerate());
            seen.unless_rounding(size)
        };
        let of_load = |((_, load), &is_uniform): (&(u32, Vec<C>), &bool)| {
            [loaded(&mut load.iter().map(|f| f.re), is_uniform), loaded(&mut load.iter().map(|f| f.im), is_uniform)]
        };
        let still_is_uniform = self.static_load.windows(2).all(|pair| pair[0] == pair[1]);
        let of_contact = |(weights, _): &(Vec<(usize, f64)>, Contact)| match weights[..] {
            // A mass itself: no sum.
            [(n, 1.0)] => {
                let sum = at(n);
                Bounded { sum, error: (FAINT + 2.0 * FINE) * sum.high.abs() }
            }
            _ => seen(&mut weights.iter().copied()).0,
        };
        SeenShape {
            contacts: self.contacts.iter().map(of_contact).collect(),
            coordinates: all.iter().map(|shape| shape.value()).collect(),
            still: loaded(&mut self.static_load.iter().copied(), still_is_uniform),
            loads: self.loads.iter().zip(are_uniform).map(of_load).collect(),
        }
    }

    fn check(&self) -> Result<(), StructureError> {
        let range =
            |what: &str, value: f64, requirement| StructureError::Range { what: what.to_owned(), value, requirement };
        if !(1..=MAX_SITES).contains(&self.sites) {
            return Err(range("sites", self.sites as f64, "a whole number from 1 to 10000000"));
        }
        if self.layers == 0 || self.sites.checked_mul(self.layers).is_none_or(|masses| masses > MAX_SITES) {
            return Err(range("layers", self.layers as f64, "at least 1, and at most 10000000 masses in all"));
        }
        if self.modes == Some(0) {
            return Err(range("modes", 0.0, "a number from 1"));
        }
        let numbers = [
            ("gamma1", self.gamma1),
            ("gamma2", self.gamma2),
            ("gamma3", self.gamma3),
            ("damping", self.damping),
            ("coupling_damping", self.coupling_damping),
        ];
        if let Some((what, value)) =
            numbers.into_iter().find(|(_, value)| value.is_nan() || value.abs() > MAX_MAGNITUDE)
        {
            return Err(range(what, value, "a number between -1e100 and 1e100"));
        }
        let loads = self.loads.iter().map(|(number, load)| (*number, load.as_slice()));
        check_loads(self.masses(), &self.static_load, loads)?;
        for (number, (weights, _)) in self.contacts.iter().enumerate() {
            if let Some((place, _)) = weights.iter().find(|(place, _)| *place >= self.masses()) {
                return Err(range(&format!("a mass of contact {number}"), *place as f64, "one that the chain has"));
            }
            if weights.iter().all(|(_, weight)| *weight == 0.0) {
                return Err(StructureError::NoWeight { contact: number });
            }
        }
        finite("the weights of contacts", self.contacts.iter().flat_map(|(weights, _)| weights.iter().map(|(_, w)| *w)))
    }
}

#[cfg(test)]
mod tests;

//! Modes and contacts: a structure as everything above sees it.

use std::sync::Arc;

use rustfft::num_complex::Complex;

use super::contact::Contact;
use super::contact_modes::{ContactMode, of_contact};
use super::error::StructureError;
use super::linear_mode::{ALIKE, LinearMode, ModeErrors};
use super::operator::SparseOperator;
use crate::kernel::bloch::BlochKernel;
use crate::kernel::turn::Turn;

type C = Complex<f64>;

/// A square of a shape at contacts below this part of the largest is rounding of the eigenvectors.
const SPARED: f64 = 1e-24;

/// The slower pole of an overdamped mode is a difference, δ − κ, about δ/2ζ²: of larger damping ratios ζ no four digits are left of it.
pub(super) const MOST_DAMPING: f64 = 7e5;

/// Shapes of two contacts that differ by no more than this part of the largest are one: those of masses that a mirror exchanges differ by the
/// rounding of eigenvectors.
const TWINS: f64 = 1e-12;

/// A square of a shape below this part of the largest of its kind is rounding of their products.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// A linear structure by its modes, with contacts, static load and periodic loads.
///
/// ```
/// use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape};
/// // q″ + 0.1 q′ + q = cos ωt, a stop at 0.1.
/// let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: 0.0 };
/// let mode = LinearMode::oscillator(0.05, 1.0 - 0.05 * 0.05, &shape, &[Complex::new(1.0, 0.0)]);
/// let stop = Contact { lower: None, upper: Some(0.1), restitution: 0.8 };
/// let structure = ModalStructure::new(vec![stop], vec![1], vec![mode])?;
/// let swing = structure.steady_at(0, 2.0)?[0];
/// let exact = Complex::new(1.0 - 4.0, 0.2).inv();
/// assert!((swing - exact).norm() < 1e-15 && (structure.mobility(0, 0) - 1.0).abs() < 1e-15);
/// # Ok::<(), vibrochain_lattice::StructureError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ModalStructure {
    contacts: Vec<Contact>,
    harmonics: Vec<u32>,
    modes: Vec<LinearMode>,
    operator: Option<Arc<SparseOperator>>,
}

/// Modes as impacts at some contacts feel them ([`ModalStructure::participating_modes`]).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ParticipatingModes {
    /// What all contacts see of them, what those that are hit give to them; without loads and coordinates.
    pub modes: Vec<LinearMode>,
    /// The number in the structure of the first mode behind each.
    pub numbers: Vec<usize>,
    /// For each contact the first one that sees the same of all of these modes, to rounding: itself, or as a mirror image has it.
    pub twins: Vec<usize>,
    /// The pairs of poles λ of modes that none of the hit contacts feels.
    pub spared: Vec<[Complex<f64>; 2]>,
    /// The modes as the one contact that is hit feels them; `None` of several contacts, and where a mode is damped.
    pub of_one: Option<Vec<ContactMode>>,
}

/// Modes by rising rate: those alike are neighbours.
struct ByRate {
    order: Vec<usize>,
    /// Where each mode is in that order.
    places: Vec<usize>,
}

impl ByRate {
    fn of(modes: &[LinearMode]) -> Self {
        let mut order: Vec<usize> = (0..modes.len()).collect();
        order.sort_by(|&a, &b| modes[a].rate.total_cmp(&modes[b].rate));
        let mut places = vec![0; modes.len()];
        order.iter().enumerate().for_each(|(place, &mode)| places[mode] = place);
        Self { order, places }
    }

    /// Numbers of the modes whose rates are next to that of mode `k`, rising; itself among them.
    fn around(&self, modes: &[LinearMode], k: usize) -> Vec<usize> {
        let (place, mode) = (self.places[k], &modes[k]);
        let near = |&&other: &&usize| (modes[other].rate - mode.rate).abs() <= ALIKE * (mode.decay.abs() + mode.rate);
        let mut around: Vec<usize> = self.order[..place].iter().rev().take_while(near).copied().collect();
        around.extend(self.order[place..].iter().take_while(near));
        around.sort_unstable();
        around
    }
}

impl ParticipatingModes {
    fn push(&mut self, number: usize, like: &LinearMode, [rows, columns]: [Vec<[f64; 2]>; 2], errors: ModeErrors) {
        let LinearMode { turn, decay, rate, is_real, .. } = *like;
        let (coordinates, still, loads) = (Vec::new(), [0.0; 2], Vec::new());
        self.modes.push(LinearMode { turn, decay, rate, is_real, rows, columns, coordinates, still, loads, errors });
        self.numbers.push(number);
    }

    /// For each contact the first one that sees what it does.
    fn firsts(&self, contacts: usize) -> Vec<usize> {
        let largest = |mode: &LinearMode| mode.rows.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        let rooms: Vec<f64> = self.modes.iter().map(|mode| TWINS * largest(mode)).collect();
        let alike = |one: usize, other: usize| {
            let near = |(mode, room): (&LinearMode, &f64)| {
                mode.rows[one].iter().zip(mode.rows[other]).all(|(a, b)| (a - b).abs() <= *room)
            };
            self.modes.iter().zip(&rooms).all(near)
        };
        (0..contacts).map(|contact| (0..contact).find(|other| alike(*other, contact)).unwrap_or(contact)).collect()
    }

    /// The kernel K^z between the contacts that are hit, for a period.
    pub fn kernel(&self, period: f64, hit: &[usize]) -> BlochKernel {
        BlochKernel::of_modes(&self.modes, period, hit)
    }
}

impl ModalStructure {
    /// A structure of contacts, harmonics of the loads and modes.
    ///
    /// # Errors
    /// [`StructureError`] where a mode does not have the shapes of all contacts or the loads of all harmonics, or is so
    /// overdamped that numbers do not hold its slow motion, where a contact has no barrier, or nothing can hit it.
    pub fn new(contacts: Vec<Contact>, harmonics: Vec<u32>, modes: Vec<LinearMode>) -> Result<Self, StructureError> {
        if contacts.is_empty() {
            return Err(StructureError::NoContact);
        }
        for (number, contact) in contacts.iter().enumerate() {
            contact.check(number)?;
        }
        for (k, mode) in modes.iter().enumerate() {
            // That of a rigid mode with a dashpot is 0.
            let slow = (mode.decay - mode.rate).abs();
            if mode.turn == Turn::Hyperbolic && slow > 0.0 && mode.decay > 2.0 * MOST_DAMPING * MOST_DAMPING * slow {
                return Err(StructureError::Overdamped { mode: k, ratio: (0.5 * mode.decay / slow).sqrt() });
            }
            let sizes = [
                ("the shape at contacts", mode.rows.len(), contacts.len()),
                ("the shape at contacts", mode.columns.len(), contacts.len()),
                ("the load", mode.loads.len(), harmonics.len()),
                ("the shape", mode.coordinates.len(), modes[0].coordinates.len()),
            ];
            for (what, given, wanted) in sizes {
                if given != wanted {
                    return Err(StructureError::Size { what: format!("{what} of mode {k}"), given, wanted });
                }
            }
            let own = [mode.still, [mode.decay, mode.rate]];
            let real = mode.rows.iter().chain(&mode.columns).chain(&own).flatten().copied();
            let complex = mode.loads.iter().flatten().flat_map(|load| [load.re, load.im]);
            if let Some(value) = real.chain(complex).find(|value| !value.is_finite()) {
                let what = format!("mode {k}");
                return Err(StructureError::Range { what, value, requirement: "finite numbers" });
            }
        }
        let structure = Self { contacts, harmonics, modes, operator: None };
        for contact in 0..structure.contacts.len() {
            let mobility = structure.mobility(contact, contact);
            let sound = mobility > 0.0;
            if !sound {
                return Err(StructureError::NoWeight { contact });
            }
        }
        Ok(structure)
    }

    /// The same of the `kept` slowest modes, if not of all: a contact may move in none of these.
    pub(super) fn keeping(
        kept: Option<usize>,
        contacts: Vec<Contact>,
        harmonics: Vec<u32>,
        modes: Vec<LinearMode>,
    ) -> Result<Self, StructureError> {
        Self::new(contacts, harmonics, modes).map_err(|error| match (error, kept) {
            (StructureError::NoWeight { contact }, Some(modes)) => StructureError::Unmoved { contact, modes },
            (error, _) => error,
        })
    }

    pub(super) fn with_operator(self, operator: Option<SparseOperator>) -> Self {
        Self { operator: operator.map(Arc::new), ..self }
    }

    /// The equations of motion by coordinates, with what pulls at each. `None` where only modes are given, where some modes are left out, and where the
    /// mass matrix is not diagonal.
    pub fn operator(&self) -> Option<&Arc<SparseOperator>> {
        self.operator.as_ref()
    }

    /// The contacts.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// The modes.
    pub fn modes(&self) -> &[LinearMode] {
        &self.modes
    }

    /// Numbers j of the harmonics of the loads.
    pub fn harmonics(&self) -> &[u32] {
        &self.harmonics
    }

    /// How many coordinates can be looked at.
    pub fn coordinates(&self) -> usize {
        self.modes.first().map_or(0, |mode| mode.coordinates.len())
    }

    /// Other barriers and restitutions of the same contacts.
    ///
    /// # Errors
    /// As [`ModalStructure::new`].
    pub fn with_contacts(self, contacts: Vec<Contact>) -> Result<Self, StructureError> {
        let (given, wanted) = (contacts.len(), self.contacts.len());
        if given != wanted {
            return Err(StructureError::Size { what: "the list of contacts".to_owned(), given, wanted });
        }
        for (number, contact) in contacts.iter().enumerate() {
            contact.check(number)?;
        }
        Ok(Self { contacts, ..self })
    }

    /// All periodic loads times `factor`, the static one times `still`.
    pub fn with_loads_times(&self, factor: f64, still: f64) -> Self {
        let mut structure = self.clone();
        for mode in &mut structure.modes {
            mode.loads.iter_mut().flatten().for_each(|load| *load *= factor);
            mode.still.iter_mut().for_each(|load| *load *= still);
            mode.errors.loads.iter_mut().for_each(|error| *error *= factor.abs());
            mode.errors.still *= still.abs();
        }
        if let Some(operator) = structure.operator.as_mut().map(Arc::make_mut) {
            operator.loads.iter_mut().flatten().for_each(|load| *load *= factor);
        }
        structure
    }

    /// Whether a periodic load drives it.
    pub fn is_forced(&self) -> bool {
        self.modes.iter().any(|mode| mode.loads.iter().flatten().any(|load| *load != C::default()))
    }

    /// Whether neither dashpots nor impacts take energy, nor give any.
    pub fn is_lossless(&self) -> bool {
        self.modes.iter().all(|mode| mode.decay == 0.0)
            && self.contacts.iter().all(|contact| contact.restitution == 1.0)
    }

    /// Whether a periodic motion has a period of its own: no load gives it one, and losses leave no family of periods.
    pub fn has_own_period(&self) -> bool {
        !self.is_forced() && !self.is_lossless()
    }

    /// w_iᵀM⁻¹w_j: the velocity that a unit impulse at one contact gives to another.
    pub fn mobility(&self, to: usize, from: usize) -> f64 {
        self.modes.iter().map(|mode| mode.turn.pair(mode.rows[to], mode.generator(), mode.columns[from])).sum()
    }

    /// The mass that an impact of a contact feels, 1/(wᵀM⁻¹w): that of the modes there are.
    pub fn effective_mass(&self, contact: usize) -> f64 {
        1.0 / self.mobility(contact, contact)
    }

    /// A bound of the error of [`ModalStructure::mobility`] by those of the modes.
    pub fn mobility_error(&self, to: usize, from: usize) -> f64 {
        self.modes.iter().map(|mode| mode.errors_between(to, from) * mode.decay.hypot(mode.rate)).sum()
    }

    /// The modes as impacts at some of its contacts feel them: every contact is seen, those alone are hit. Oscillators of one frequency and
    /// damping are merged: the products of their shapes are one matrix, of which pivoted Cholesky factors are as many modes as the hit
    /// contacts can feel.
    pub fn participating_modes(&self, hit: &[usize]) -> ParticipatingModes {
        let contacts = self.contacts.len();
        let mut felt = ParticipatingModes::default();
        let mut done = vec![false; self.modes.len()];
        let largest = |list: &[[f64; 2]]| list.iter().flatten().map(|x| x * x).fold(0.0, f64::max);
        // Of each contact on its own: a light one sees far more of every mode than a heavy one.
        let most =
            |contact: usize| self.modes.iter().map(|mode| largest(&mode.rows[contact..=contact])).fold(0.0, f64::max);
        let most_given = |contact: usize| {
            self.modes.iter().map(|mode| largest(&mode.columns[contact..=contact])).fold(0.0, f64::max)
        };
        let (seen, given): (Vec<f64>, Vec<f64>) =
            hit.iter().map(|&contact| (most(contact), most_given(contact))).unzip();
        // Of all contacts with each that is hit: [hit contact][contact].
        let mut products = vec![0.0; contacts * hit.len()];
        let by_rate = ByRate::of(&self.modes);
        for (k, mode) in self.modes.iter().enumerate() {
            if std::mem::replace(&mut done[k], true) {
                continue;
            }
            if !mode.is_real {
                let is_felt = |list: &[[f64; 2]], all: &[f64]| {
                    hit.iter().zip(all).any(|(&i, all)| largest(&list[i..=i]) > SPARED * all)
                };
                if is_felt(&mode.rows, &seen) && is_felt(&mode.columns, &given) {
                    let mut columns = vec![[0.0; 2]; contacts];
                    hit.iter().for_each(|&i| columns[i] = mode.columns[i]);
                    felt.push(k, mode, [mode.rows.clone(), columns], mode.errors.clone());
                } else {
                    felt.spared.push(mode.rates());
                }
                continue;
            }
            products.fill(0.0);
            let mut errors =
                ModeErrors { rows: vec![0.0; contacts], columns: vec![0.0; contacts], ..ModeErrors::default() };
            let mut count = 0;
            for other in by_rate.around(&self.modes, k) {
                let alike = &self.modes[other];
                if other == k || !done[other] && mode.is_alike(alike) {
                    done[other] = true;
                    count += 1;
                    let off = (mode.decay - alike.decay).abs() + (mode.rate - alike.rate).abs();
                    errors.poles = errors.poles.max(alike.errors.poles + off);
                    add(&mut errors.rows, &alike.errors.rows);
                    add(&mut errors.columns, &alike.errors.columns);
                    for (row, &from) in products.chunks_exact_mut(contacts).zip(hit) {
                        let by = alike.rows[from][0];
                        row.iter_mut().zip(&alike.rows).for_each(|(entry, shape)| *entry += by * shape[0]);
                    }
                }
            }
            if count == 1 && hit.iter().zip(&seen).any(|(&i, all)| mode.rows[i][0].powi(2) > SPARED * all) {
                let mut columns = vec![[0.0; 2]; contacts];
                hit.iter().for_each(|&i| columns[i] = mode.columns[i]);
                felt.push(k, mode, [mode.rows.clone(), columns], errors);
                continue;
            }
            // What a contact that is hit has left, as a part of what it may have: rounding of the products below 1.
            let first: Vec<f64> = hit.iter().enumerate().map(|(j, &i)| products[j * contacts + i]).collect();
            let least = |j: usize| (SPARED * seen[j]).max(ROUNDING * first[j]);
            let pivots = |products: &[f64]| {
                let left = hit.iter().enumerate().map(|(j, &i)| (j, products[j * contacts + i]));
                let left = left.filter(|&(j, square)| square > least(j));
                left.max_by(|a, b| (a.1 / seen[a.0]).total_cmp(&(b.1 / seen[b.0])))
            };
            let mut taken = Vec::with_capacity(hit.len());
            while let Some((pivot, square)) = pivots(&products).filter(|_| count > 0) {
                let scale = square.sqrt().recip();
                let row = &products[pivot * contacts..(pivot + 1) * contacts];
                let mut shape: Vec<f64> = row.iter().map(|entry| entry * scale).collect();
                // What earlier ones have taken whole is left as rounding.
                taken.iter().for_each(|&contact: &usize| shape[contact] = 0.0);
                taken.push(hit[pivot]);
                for (row, &from) in products.chunks_exact_mut(contacts).zip(hit) {
                    row.iter_mut().zip(&shape).for_each(|(entry, own)| *entry -= own * shape[from]);
                }
                let mut columns = vec![[0.0; 2]; contacts];
                hit.iter().for_each(|&i| columns[i] = [0.0, shape[i] / mode.rate]);
                // Of products and their roots.
                let mut own = errors.clone();
                let rounded = shape.iter().map(|shape| 8.0 * f64::EPSILON * shape.abs());
                own.rows.iter_mut().zip(rounded.clone()).for_each(|(error, by)| *error += by);
                own.columns.iter_mut().zip(rounded).for_each(|(error, by)| *error += by / mode.rate);
                felt.push(k, mode, [shape.into_iter().map(|own| [own, 0.0]).collect(), columns], own);
                count -= 1;
            }
            felt.spared.extend(std::iter::repeat_n(mode.rates(), count));
        }
        felt.twins = felt.firsts(contacts);
        felt.of_one = match *hit {
            [contact] => of_contact(&felt.modes, contact),
            _ => None,
        };
        felt
    }
}

/// A list added to one that may be longer.
fn add(sums: &mut [f64], list: &[f64]) {
    sums.iter_mut().zip(list).for_each(|(sum, error)| *sum += error);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::linear_mode::ModeShape;

    /// Of ζ = 10⁶ the slow pole −1/2ζ is below rounding of δ; a mass on a dashpot alone has it at 0, exactly.
    #[test]
    fn overdamped_modes_without_digits_are_refused() {
        let stop = Contact { lower: None, upper: Some(1.0), restitution: 0.9 };
        let shape = ModeShape { contacts: vec![1.0], coordinates: Vec::new(), still: 0.0 };
        let with = |decay: f64, square: f64| {
            let mode = LinearMode::oscillator(decay, square - decay * decay, &shape, &[]);
            ModalStructure::new(vec![stop], Vec::new(), vec![mode])
        };
        for damping in [0.0, 0.5, 1.0, 30.0, 1e4, 1e5] {
            assert!(with(damping, 1.0).is_ok(), "{damping}");
        }
        let error = with(1e6, 1.0).unwrap_err();
        assert!(matches!(error, StructureError::Overdamped { mode: 0, .. }), "{error}");
        assert!(with(1e8, 0.0).is_ok());
    }

    /// A mode of complex shape that a contact sees by rounding of its shape alone is spared, as one of real shape is.
    #[test]
    fn modes_that_are_seen_by_rounding_are_spared() {
        let stop = Contact { lower: None, upper: Some(1.0), restitution: 0.9 };
        let pole = |im: f64, seen: C| {
            let shape = ModeShape { contacts: vec![seen], coordinates: Vec::new(), still: C::default() };
            LinearMode::pole(C::new(-0.1, im), &shape, &[])
        };
        let modes = vec![pole(1.0, C::new(0.7, -0.1)), pole(2.0, C::new(1e-17, 3e-17))];
        let structure = ModalStructure::new(vec![stop], Vec::new(), modes).unwrap();
        let felt = structure.participating_modes(&[0]);
        assert_eq!((felt.modes.len(), felt.spared.len()), (1, 1));
    }

    /// Three oscillators of one frequency and another one: two of the three are left where two contacts are hit, and what these and a third
    /// contact see is what all modes have.
    #[test]
    fn modes_alike_are_merged() {
        let shapes = [[1.0, 0.3, -0.7], [0.2, -0.8, 0.4], [0.5, 0.1, 0.9], [-0.6, 0.7, 0.2]];
        let mode = |k: usize| {
            let shape = ModeShape { contacts: shapes[k].to_vec(), coordinates: Vec::new(), still: 0.0 };
            LinearMode::oscillator(0.1, if k == 1 { 2.0 } else { 5.0 }, &shape, &[])
        };
        let contacts = vec![Contact { lower: None, upper: Some(1.0), restitution: 0.9 }; 3];
        let structure = ModalStructure::new(contacts, Vec::new(), (0..4).map(mode).collect()).unwrap();
        let felt = structure.participating_modes(&[0, 2]);
        assert_eq!((felt.modes.len(), felt.spared.len(), &felt.numbers[..]), (3, 1, &[0, 0, 1][..]));
        let answer = |modes: &[LinearMode], to: usize, from: usize, t: f64| -> f64 {
            modes.iter().map(|mode| mode.turn.pair(mode.rows[to], mode.flight(t), mode.columns[from])).sum()
        };
        for (to, from) in [(0, 0), (1, 0), (2, 0), (0, 2), (1, 2), (2, 2)] {
            for t in [0.4, 1.7] {
                let off = answer(&felt.modes, to, from, t) - answer(structure.modes(), to, from, t);
                assert!(off.abs() < 1e-15, "{to} {from} {off:e}");
            }
        }
    }
}

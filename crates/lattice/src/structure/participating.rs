//! Modes as impacts at some contacts feel them.

use std::sync::Arc;

use rustfft::num_complex::Complex;
use smallvec::{SmallVec, smallvec};

use super::contact_modes::{ContactMode, of_contact};
use super::linear_mode::{ALIKE, LinearMode, ModeErrors};
use super::modal::ModalStructure;
use crate::kernel::bloch::BlochKernel;

type C = Complex<f64>;

/// A square of a shape at contacts below this part of the largest is rounding of the eigenvectors.
const SPARED: f64 = 1e-24;

/// Shapes of two contacts that differ by no more than this part of the largest are one: those of masses that a mirror exchanges differ by the
/// rounding of eigenvectors.
const TWINS: f64 = 1e-12;

/// Squares of shapes are sums of products. One below this part of the largest at the same contact is their rounding.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Modes as impacts at some contacts feel them ([`ModalStructure::participating_modes`]).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ParticipatingModes {
    /// What all contacts see of them, what those that are hit give to them; loads and coordinates do not count. Where every mode is one of these as
    /// it is, the structure's own list.
    pub modes: Arc<Vec<LinearMode>>,
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

/// Whether the rate of another mode is next to that of one.
fn near(mode: &LinearMode, other: &LinearMode) -> bool {
    (other.rate - mode.rate).abs() <= ALIKE * (mode.decay.abs() + mode.rate)
}

impl ByRate {
    fn of(modes: &[LinearMode]) -> Self {
        let mut order: Vec<usize> = (0..modes.len()).collect();
        order.sort_by(|&a, &b| modes[a].rate.total_cmp(&modes[b].rate));
        let mut places = vec![0; modes.len()];
        order.iter().enumerate().for_each(|(place, &mode)| places[mode] = place);
        Self { order, places }
    }

    /// Whether no other mode has the rate of mode `k`.
    fn is_alone(&self, modes: &[LinearMode], k: usize) -> bool {
        let place = self.places[k];
        let beside = [place.checked_sub(1), Some(place + 1)].into_iter().flatten();
        beside.filter_map(|place| self.order.get(place)).all(|&other| !near(&modes[k], &modes[other]))
    }

    /// Numbers, rising, of the modes whose rates are next to that of mode `k`; `k` is among them.
    fn around(&self, modes: &[LinearMode], k: usize) -> Vec<usize> {
        let (place, mode) = (self.places[k], &modes[k]);
        let near = |other: &&usize| near(mode, &modes[**other]);
        let mut around: Vec<usize> = self.order[..place].iter().rev().take_while(near).copied().collect();
        around.extend(self.order[place..].iter().take_while(near));
        around.sort_unstable();
        around
    }
}

/// What contacts see of a mode, or give to it.
type AtContacts = SmallVec<[[f64; 2]; 1]>;

/// Those that are felt, one by one, and the number of each.
#[derive(Default)]
struct Felt {
    modes: Vec<LinearMode>,
    numbers: Vec<usize>,
}

impl Felt {
    fn push(&mut self, number: usize, like: &LinearMode, [rows, columns]: [AtContacts; 2], errors: ModeErrors) {
        let LinearMode { turn, decay, rate, is_real, .. } = *like;
        let (coordinates, still, loads) = (Vec::new(), [0.0; 2], Vec::new());
        self.modes.push(LinearMode { turn, decay, rate, is_real, rows, columns, coordinates, still, loads, errors });
        self.numbers.push(number);
    }
}

impl ParticipatingModes {
    /// With what follows from the modes themselves.
    fn of(
        modes: Arc<Vec<LinearMode>>,
        numbers: Vec<usize>,
        spared: Vec<[C; 2]>,
        contacts: usize,
        hit: &[usize],
    ) -> Self {
        let of_one = match *hit {
            [contact] => of_contact(&modes, contact),
            _ => None,
        };
        let mut felt = Self { modes, numbers, twins: Vec::new(), spared, of_one };
        felt.twins = felt.firsts(contacts);
        felt
    }

    /// For each contact the first one that sees what it does.
    fn firsts(&self, contacts: usize) -> Vec<usize> {
        let largest = |mode: &LinearMode| mode.rows.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        if contacts == 1 {
            return vec![0];
        }
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
    /// The modes as impacts at some of its contacts feel them: every contact is seen, those alone are hit. Oscillators of one frequency and
    /// damping are merged: the products of their shapes are one matrix, of which pivoted Cholesky factors are as many modes as the hit
    /// contacts can feel.
    pub fn participating_modes(&self, hit: &[usize]) -> ParticipatingModes {
        let contacts = self.contacts().len();
        let (mut felt, mut spared) = (Felt::default(), Vec::new());
        let mut done = vec![false; self.modes().len()];
        let largest = |list: &[[f64; 2]]| list.iter().flatten().map(|x| x * x).fold(0.0, f64::max);
        // Of each contact on its own: a light one sees far more of every mode than a heavy one.
        let most =
            |contact: usize| self.modes.iter().map(|mode| largest(&mode.rows[contact..=contact])).fold(0.0, f64::max);
        let most_given = |contact: usize| {
            self.modes.iter().map(|mode| largest(&mode.columns[contact..=contact])).fold(0.0, f64::max)
        };
        let (seen, given): (Vec<f64>, Vec<f64>) =
            hit.iter().map(|&contact| (most(contact), most_given(contact))).unzip();
        let by_rate = ByRate::of(&self.modes);
        let is_seen = |mode: &LinearMode| hit.iter().zip(&seen).any(|(&i, all)| mode.rows[i][0].powi(2) > SPARED * all);
        // A mode that is felt and has no other of its rate is taken as it is: if all are, where all contacts are hit, no list is made.
        let as_it_is =
            |(k, mode): (usize, &LinearMode)| mode.is_real && by_rate.is_alone(&self.modes, k) && is_seen(mode);
        if hit.len() == contacts && self.modes.iter().enumerate().all(as_it_is) {
            return ParticipatingModes::of(self.modes.clone(), (0..done.len()).collect(), spared, contacts, hit);
        }
        // Of all contacts with each that is hit: [hit contact][contact].
        let mut products = vec![0.0; contacts * hit.len()];
        for (k, mode) in self.modes.iter().enumerate() {
            if std::mem::replace(&mut done[k], true) {
                continue;
            }
            if !mode.is_real {
                let is_felt = |list: &[[f64; 2]], all: &[f64]| {
                    hit.iter().zip(all).any(|(&i, all)| largest(&list[i..=i]) > SPARED * all)
                };
                if is_felt(&mode.rows, &seen) && is_felt(&mode.columns, &given) {
                    let mut columns: AtContacts = smallvec![[0.0; 2]; contacts];
                    hit.iter().for_each(|&i| columns[i] = mode.columns[i]);
                    felt.push(k, mode, [mode.rows.clone(), columns], mode.errors.clone());
                } else {
                    spared.push(mode.rates());
                }
                continue;
            }
            products.fill(0.0);
            let mut errors = ModeErrors {
                rows: smallvec![0.0; contacts],
                columns: smallvec![0.0; contacts],
                ..ModeErrors::default()
            };
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
            if count == 1 && is_seen(mode) {
                let mut columns: AtContacts = smallvec![[0.0; 2]; contacts];
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
                let mut columns: AtContacts = smallvec![[0.0; 2]; contacts];
                hit.iter().for_each(|&i| columns[i] = [0.0, shape[i] / mode.rate]);
                // Of products and their roots.
                let mut own = errors.clone();
                let rounded = shape.iter().map(|shape| 8.0 * f64::EPSILON * shape.abs());
                own.rows.iter_mut().zip(rounded.clone()).for_each(|(error, by)| *error += by);
                own.columns.iter_mut().zip(rounded).for_each(|(error, by)| *error += by / mode.rate);
                felt.push(k, mode, [shape.into_iter().map(|own| [own, 0.0]).collect(), columns], own);
                count -= 1;
            }
            spared.extend(std::iter::repeat_n(mode.rates(), count));
        }
        ParticipatingModes::of(Arc::new(felt.modes), felt.numbers, spared, contacts, hit)
    }
}

/// A list added to one that may be longer.
fn add(sums: &mut [f64], list: &[f64]) {
    sums.iter_mut().zip(list).for_each(|(sum, error)| *sum += error);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::contact::Contact;
    use crate::structure::linear_mode::ModeShape;

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

//! Modes of a structure of matrices, from its shapes without damping and the poles that dashpots make of them.

use nalgebra::{DMatrix, DVector};
use rustfft::num_complex::Complex;
use smallvec::SmallVec;

use super::basis::Basis;
use super::error::StructureError;
use super::linear_mode::{LinearMode, ModeErrors, ModeShape};
use super::matrices::Structure;
use super::oscillator::{Bounded, SeenShape, without_rounding};
use super::poles::{Pencil, Pole};
use crate::simd::twofold::Twofold;

type C = Complex<f64>;

/// Entries of D below this part of their terms are rounding: off the diagonal, and on it of a rigid mode. With a dashpot of 1e-17 that would
/// have coordinates of 1e17, and the force on a contact at rest no digits.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Modes at most that dashpots couple. Their state matrix is twice as large, and its triangular form takes twenty times as long as modes without
/// dashpots do: 300 take as long as 1000 of these.
const MOST_COUPLED: usize = 300;

/// Modes that are being made of matrices.
pub(super) struct Assembly<'a> {
    structure: &'a Structure,
    basis: &'a Basis,
    /// M = LLᵀ
    lower: &'a DMatrix<f64>,
    /// |L⁻¹w|: what each contact may see of a mode of length 1.
    reaches: Vec<f64>,
    /// What is seen of each mode without damping: by contacts, by the static load, by both parts of each load.
    contacts: Vec<Vec<Bounded>>,
    still: Vec<Bounded>,
    loads: Vec<[Vec<Bounded>; 2]>,
}

impl<'a> Assembly<'a> {
    pub(super) fn new(structure: &'a Structure, basis: &'a Basis, lower: &'a DMatrix<f64>, reaches: Vec<f64>) -> Self {
        let contacts = structure.contacts.iter().map(|(weights, _)| basis.seen(weights)).collect();
        let loaded = |load: &DVector<f64>| {
            let seen = basis.seen(load);
            let size = |k: usize| load.iter().zip(&basis.shapes.column(k)).map(|(f, x)| (f * x).abs()).sum();
            (0..seen.len()).map(|k| seen[k].unless_rounding(size(k))).collect()
        };
        let n = basis.squares.len();
        let still =
            if structure.static_load.is_empty() { vec![Bounded::default(); n] } else { loaded(&structure.static_load) };
        let loads = structure.loads.iter().map(|(_, load)| [loaded(&load.map(|f| f.re)), loaded(&load.map(|f| f.im))]);
        Self { structure, basis, lower, reaches, contacts, still, loads: loads.collect() }
    }

    /// All of them.
    ///
    /// # Errors
    /// [`StructureError`]: too much damping, or damping that makes two poles of one shape coincide.
    pub(super) fn modes(&self) -> Result<Vec<LinearMode>, StructureError> {
        let (structure, n) = (self.structure, self.basis.squares.len());
        let modes = if structure.damping.is_empty() {
            (0..n).map(|k| self.oscillator(k, Bounded::default())).collect::<Result<Vec<_>, _>>()?
        } else {
            let (mut damping, sizes) = self.basis.form(&structure.damping);
            let is_rounding = |i: usize, j: usize, entry: Bounded| {
                entry.sum.high.abs() <= ROUNDING * n as f64 * sizes[(i, j)] + entry.error
            };
            for (k, row) in damping.iter_mut().enumerate() {
                if self.basis.squares[k].high == 0.0 && is_rounding(k, k, row[k]) {
                    row[k] = Bounded::default();
                }
            }
            let (own, coupled): (Vec<usize>, Vec<usize>) =
                (0..n).partition(|&k| (0..n).all(|j| j == k || is_rounding(k, j, damping[k][j])));
            if coupled.iter().any(|&k| self.basis.squares[k].high == 0.0) {
                return Err(StructureError::RigidDamped);
            }
            if coupled.len() > MOST_COUPLED {
                return Err(StructureError::Coupled { modes: coupled.len(), most: MOST_COUPLED });
            }
            let decays = as_one(own.iter().map(|&k| {
                let Bounded { sum, error } = damping[k][k];
                Bounded { sum: sum * Twofold::from(0.5), error: 0.5 * error }
            }));
            let alone = own.iter().zip(decays).map(|(&k, decay)| {
                let mut mode = self.oscillator(k, decay)?;
                self.neglect(&mut mode, k, &damping);
                Ok(mode)
            });
            let mut modes = alone.collect::<Result<Vec<_>, _>>()?;
            if !coupled.is_empty() {
                modes.extend(self.coupled(&coupled, &damping)?);
                modes.sort_by(|a, b| a.rates()[0].norm().total_cmp(&b.rates()[0].norm()));
            }
            modes
        };
        Ok(modes.into_iter().map(|mode| self.without_rounding(mode)).collect())
    }

    /// An oscillator of real shape.
    fn oscillator(&self, k: usize, decay: Bounded) -> Result<LinearMode, StructureError> {
        let shape = SeenShape {
            contacts: self.contacts.iter().map(|list| list[k]).collect(),
            coordinates: self.basis.coordinates(k),
            still: self.still[k],
            loads: self.loads.iter().map(|[re, im]| [re[k], im[k]]).collect(),
        };
        shape.oscillator(k, Bounded { sum: self.basis.squares[k], error: self.basis.square_errors[k] }, decay)
    }

    /// Entries of D beside the diagonal that are left out couple a mode to others.
    fn neglect(&self, mode: &mut LinearMode, k: usize, damping: &[Vec<Bounded>]) {
        let frequency = |i: usize| self.basis.squares[i].value().max(0.0).sqrt();
        for j in (0..damping.len()).filter(|j| *j != k) {
            let entry = damping[k][j].sum.high.abs() + damping[k][j].error;
            let along = entry * frequency(k) / (frequency(j).powi(2) - frequency(k).powi(2)).abs();
            if along <= 1e-3 {
                let other = |list: &Vec<Bounded>| 2.0 * along * list[j].sum.high.abs();
                for (place, list) in self.contacts.iter().enumerate() {
                    mode.errors.rows[place] += other(list);
                    mode.errors.columns[place] += other(list) / mode.rate;
                }
                mode.errors.still += other(&self.still) / mode.rate;
                for (error, [re, im]) in mode.errors.loads.iter_mut().zip(&self.loads) {
                    *error += (other(re) + other(im)) / mode.rate;
                }
                mode.errors.poles += entry * along;
            } else if entry > 0.0 {
                mode.errors.poles += entry;
            }
        }
    }

    /// Poles of modes that dashpots couple.
    fn coupled(&self, coupled: &[usize], damping: &[Vec<Bounded>]) -> Result<Vec<LinearMode>, StructureError> {
        let square = |k: &usize| Bounded { sum: self.basis.squares[*k], error: self.basis.square_errors[*k] };
        let squares: Vec<Bounded> = coupled.iter().map(square).collect();
        let inner: Vec<Vec<Bounded>> =
            coupled.iter().map(|&i| coupled.iter().map(|&j| damping[i][j]).collect()).collect();
        let poles = Pencil { squares: &squares, damping: &inner }.poles()?;
        let (mut real, complex): (Vec<&Pole>, Vec<&Pole>) = poles.iter().partition(|pole| pole.rate().im == 0.0);
        let seen = |pole: &Pole, list: &[Bounded]| {
            let picked: Vec<Bounded> = coupled.iter().map(|&k| list[k]).collect();
            let (value, error) = pole.seen(&picked);
            (value, error + 0.5 * f64::EPSILON * value.norm())
        };
        let mut modes: Vec<LinearMode> = Vec::with_capacity(coupled.len());
        let all = |pole: &Pole, lists: &[Vec<Bounded>]| lists.iter().map(|list| seen(pole, list)).unzip();
        for pole in complex {
            let (contacts, rows): (Vec<C>, SmallVec<[f64; 2]>) = all(pole, &self.contacts);
            let (still, still_error) = seen(pole, &self.still);
            let parts = |[re, im]: &[Vec<Bounded>; 2]| [seen(pole, re), seen(pole, im)];
            let loads: Vec<[(C, f64); 2]> = self.loads.iter().map(parts).collect();
            // φᵀf by the real and by the imaginary part of φ.
            let of_shape = |[(re, _), (im, _)]: &[(C, f64); 2]| [C::new(re.re, im.re), C::new(re.im, im.im)];
            let shape = ModeShape { contacts, coordinates: self.coordinates(pole, coupled), still };
            let mut mode = LinearMode::pole(pole.rate(), &shape, &loads.iter().map(of_shape).collect::<Vec<_>>());
            mode.errors = ModeErrors {
                poles: pole.error + f64::EPSILON * pole.rate().norm(),
                columns: rows.clone(),
                rows: rows.iter().map(|error| 2.0 * error).collect(),
                still: still_error,
                loads: loads.iter().map(|[(_, re), (_, im)]| re + im).collect(),
            };
            modes.push(mode);
        }
        real.sort_by(|a, b| b.rate().re.total_cmp(&a.rate().re));
        for pair in real.chunks(2) {
            let [first, second] = *pair else {
                return Err(StructureError::NotConverged);
            };
            let both = [first, second];
            // y is real where yᵀ(2λ + D)y is above 0, imaginary else.
            let signs = both.map(|pole| if pole.shape().iter().any(|y| y.im != 0.0) { -1.0 } else { 1.0 });
            let straight = |which: usize, z: C| if signs[which] > 0.0 { z.re } else { z.im };
            let shape = |which: usize| {
                let number = |list: &Vec<Bounded>| straight(which, seen(both[which], list).0);
                let coordinates = self.coordinates(both[which], coupled);
                ModeShape {
                    contacts: self.contacts.iter().map(number).collect(),
                    coordinates: coordinates.into_iter().map(|z| straight(which, z)).collect(),
                    still: number(&self.still),
                }
            };
            let load = |[re, im]: &[Vec<Bounded>; 2]| {
                [0, 1].map(|which| {
                    C::new(straight(which, seen(both[which], re).0), straight(which, seen(both[which], im).0))
                })
            };
            let loads: Vec<[C; 2]> = self.loads.iter().map(load).collect();
            let mut mode =
                LinearMode::real_poles(both.map(|pole| pole.rate().re), signs, [&shape(0), &shape(1)], &loads);
            let error = |list: &Vec<Bounded>| both.iter().map(|pole| seen(pole, list).1).sum::<f64>();
            let rows: SmallVec<[f64; 2]> = self.contacts.iter().map(error).collect();
            mode.errors = ModeErrors {
                poles: both.iter().map(|pole| pole.error + f64::EPSILON * pole.rate().norm()).sum(),
                columns: rows.clone(),
                rows,
                still: error(&self.still),
                loads: self.loads.iter().map(|[re, im]| error(re) + error(im)).collect(),
            };
            modes.push(mode);
        }
        Ok(modes)
    }

    fn coordinates(&self, pole: &Pole, coupled: &[usize]) -> Vec<C> {
        let shape = pole.shape();
        let n = self.basis.shapes.nrows();
        (0..n).map(|i| coupled.iter().zip(&shape).map(|(&k, y)| y * self.basis.shapes[(i, k)]).sum()).collect()
    }

    /// Without what contacts see by rounding alone.
    fn without_rounding(&self, mode: LinearMode) -> LinearMode {
        let part = |i: usize| DVector::from_iterator(mode.coordinates.len(), mode.coordinates.iter().map(|row| row[i]));
        let size = [0, 1].map(|i| self.lower.tr_mul(&part(i)).norm_squared()).iter().sum::<f64>().sqrt();
        without_rounding(mode, self.reaches.iter().map(|reach| reach * size))
    }
}

/// Rates that differ by rounding alone as one number: what depends on a rate alone is worked out once for all modes that have it.
fn as_one(rates: impl Iterator<Item = Bounded>) -> Vec<Bounded> {
    let mut list: Vec<Bounded> = Vec::new();
    for rate in rates {
        let off = |other: &Bounded| (other.sum - rate.sum).value().abs();
        let known = list.iter().find(|other| off(other) <= ROUNDING * rate.sum.high.abs());
        list.push(known.map_or(rate, |known| Bounded { error: rate.error + off(known), ..*known }));
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::contact::Contact;

    fn structure(mass: &[f64], damping: &[f64], stiffness: &[f64]) -> Structure {
        let n = mass.len().isqrt();
        let matrix = |entries: &[f64]| DMatrix::from_row_slice(n, n, entries);
        let stop = Contact { lower: None, upper: Some(1.0), restitution: 0.9 };
        let at = |i: usize| (DVector::from_fn(n, |j, _| if i == j { 1.0 } else { 0.0 }), stop);
        let damping = if damping.is_empty() { DMatrix::zeros(0, 0) } else { matrix(damping) };
        let contacts = (0..n).map(at).collect();
        Structure { mass: matrix(mass), damping, stiffness: matrix(stiffness), contacts, ..Structure::default() }
    }

    /// A mass of 1e-6 beside one of 0.8; a stiffness of 3e8 beside 2.
    fn light(damping: &[f64]) -> Structure {
        let k = 0.17664671411875127;
        let stiffness = [0.15077203872810108, k, k, 0.986281286800948];
        structure(&[0.8321261042548943, 0.0, 0.0, 1.0207179965074112e-06], damping, &stiffness)
    }

    fn stiff(damping: &[f64]) -> Structure {
        let stiffness = [2.0, -0.7, 1e3, -0.7, 1.3, 250.0, 1e3, 250.0, 3e8];
        structure(&[1.0, 0.1, 0.0, 0.1, 2.0, 0.3, 0.0, 0.3, 1.5], damping, &stiffness)
    }

    /// Off by no more than told, and by rounding alone.
    fn hold(what: &str, value: f64, told: f64, right: f64) {
        assert!((value - right).abs() <= told, "{what}: {value} {right} told {told:e}");
        assert!(told <= 8.0 * f64::EPSILON * right.abs(), "{what}: {told:e} of {right}");
    }

    /// Frequencies and moduli of shapes by mpmath in 50 digits (`eig` of M⁻¹K).
    #[test]
    fn modes_of_stiff_and_light_coordinates_are_right_to_rounding() {
        let light = (
            light(&[]),
            vec![
                (0.3783756469998012, vec![1.0962394285149653, 0.19634066286991322]),
                (982.9864223466082, vec![0.0002174545833000389, 989.7992159667881]),
            ],
        );
        let stiff = (
            stiff(&[]),
            vec![
                (0.6835242794961727, vec![0.31974749174526224, 0.6541892312502016, 1.6106770281872324e-06]),
                (1.5043573660112202, vec![0.9501508129634533, 0.273036789050519, 2.940256659396176e-06]),
                (14360.278044606523, vec![0.012502851585196324, 0.12498830572161297, 0.829091101904045]),
            ],
        );
        let mut checked = 0;
        for (structure, right) in [light, stiff] {
            let modal = structure.modal().unwrap();
            for (mode, (frequency, shape)) in modal.modes().iter().zip(&right) {
                hold("frequency", mode.rate, mode.errors.poles, *frequency);
                for (i, x) in shape.iter().enumerate() {
                    hold("shape", mode.rows[i][0].abs(), mode.errors.rows[i], *x);
                    hold("impulse", mode.columns[i][1].abs(), mode.errors.columns[i], x / frequency);
                    checked += 1;
                }
            }
        }
        assert_eq!(checked, 13);
    }

    /// Poles and residues that dashpots couple, by mpmath in 50 digits (`eig` of the state matrix): of a mode the residue of two contacts is
    /// what one sees of what the other gives.
    #[test]
    fn poles_of_stiff_and_light_coordinates_are_right_to_rounding() {
        let d = 0.0012563601665956737;
        let light = light(&[0.0019192542466609707, d, d, 0.00565162585570932]).modal().unwrap();
        let stiff = stiff(&[0.3, 0.01, 2.0, 0.01, 0.2, 1.0, 2.0, 1.0, 1e5]).modal().unwrap();
        let complex = [
            (
                &light,
                0,
                (-0.0009917428970530678, 0.37837436103101535),
                [(-3.1539917106715154e-10, -1.5880317162989028), (5.327749338255251e-05, -0.05094112321748464)],
            ),
            (
                &stiff,
                0,
                (-0.06030361601158107, 0.6815706414270585),
                [(-0.010410364258875874, -0.0751226179625344), (0.0060724738996417215, -0.3145812722104568)],
            ),
            (
                &stiff,
                1,
                (-0.1401925891801615, 1.4962453404783511),
                [(0.010410364175274925, -0.30218494758561395), (-0.006072473717955042, -0.024302054812350753)],
            ),
        ];
        for (modal, k, (re, im), residues) in complex {
            let mode = &modal.modes()[k];
            let off = (mode.rates()[0] - C::new(re, im)).norm();
            assert!(off <= mode.errors.poles && mode.errors.poles < 4e-16, "{k} {off:e} {:e}", mode.errors.poles);
            for (contact, (re, im)) in residues.into_iter().enumerate() {
                let ([a, b], [c, d]) = (mode.rows[contact], mode.columns[contact]);
                // Re of 2φ² e^{λt} for φ² = (a + ib)(c − id)/2.
                let found = C::new(a, b) * C::new(c, -d) * 0.5;
                let told = mode.errors_between(contact, contact);
                let off = (found - C::new(re, im)).norm();
                assert!(off <= told && told < 2e-15, "{k} {contact}: {off:e} {told:e}");
            }
        }
        for (modal, rates, residue) in [
            (&light, [-180.38983600467148, -5356.522616503434], [189.27294926734888, -189.27305582233564]),
            (&stiff, [-3143.7881326771094, -65595.2547436517], [1.100682001634468e-05, -1.1006820054651078e-05]),
        ] {
            let mode = modal.modes().last().unwrap();
            let contact = mode.rows.len() - 1;
            for (k, right) in rates.into_iter().enumerate() {
                let off = (mode.rates()[k].re - right).abs();
                assert!(off <= mode.errors.poles && mode.errors.poles < 1e-15 * rates[1].abs(), "{off:e}");
            }
            // row·e^{At}·column at small t, of both poles.
            for t in [0.0, 1e-4, 1e-3] {
                let found = mode.turn.pair(mode.rows[contact], mode.flight(t), mode.columns[contact]);
                let right = residue[0] * (rates[0] * t).exp() + residue[1] * (rates[1] * t).exp();
                let told = mode.errors_between(contact, contact) + 1e-15 * residue[0].abs();
                assert!(
                    (found - right).abs() <= told && told < 1e-14 * residue[0].abs(),
                    "{t}: {found} {right} {told:e}"
                );
            }
        }
    }

    /// What a contact sees of a mode as a difference of large entries has an error of its own, and what it sees by rounding alone is not seen
    /// but told as an error; so is what is left out of dashpots that nearly couple nothing.
    #[test]
    fn what_is_left_out_is_told() {
        let mut left_out = 0;
        for round in 0..20 {
            let part = f64::from(round) / 20.0;
            let (a, b) = (1.0 + part, 0.9 - 0.8 * part);
            let small = 10f64.powf(-15.0 - 3.0 * part);
            let mut twins = structure(&[1.0, 0.0, 0.0, 1.0], &[0.1, small, small, 0.1], &[a, -b, -b, a]);
            twins.stiffness[(1, 1)] = a * (1.0 + f64::from(round % 4) * f64::EPSILON);
            twins.contacts[0].0 = DVector::from_vec(vec![1.0, 1.0]);
            let modal = twins.modal().unwrap();
            // The antisymmetric mode, of which the sum of both sees the difference of the stiffnesses over 4b at most.
            let mode = &modal.modes()[1];
            let seen = (twins.stiffness[(1, 1)] - a).abs() / (4.0 * b) * 2f64.sqrt();
            let told = mode.rows[0][0].abs() + mode.errors.rows[0];
            assert!(told >= 0.9 * seen, "{told:e} {seen:e}");
            left_out += usize::from(mode.rows[0][0] == 0.0 && seen > 0.0);
            assert!(modal.modes().iter().all(|mode| mode.errors.poles < 1e-14));
        }
        assert!(left_out > 5, "{left_out}");
    }
}

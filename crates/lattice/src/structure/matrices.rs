//! Mass, damping and stiffness: from full matrices to modes.
//!
//! Φ with ΦᵀMΦ = 1, ΦᵀKΦ = Ω² first. Where ΦᵀCΦ is diagonal the modes are oscillators of real shape; otherwise the poles of
//! λ² + λD + Ω² are eigenvalues of the state matrix [[0, Ω], [−Ω, −D]] of (Ωy, y′), and its triangular form has their shapes. (With 1 and
//! Ω² in it instead, digits would depend on the unit of time.)

use nalgebra::{Cholesky, DMatrix, DVector};
use rustfft::num_complex::Complex;

use super::contact::Contact;
use super::energy::{Block, EnergyForm};
use super::error::StructureError;
use super::linear_mode::{LinearMode, ModeShape};
use super::modal::{MOST_DAMPING, ModalStructure};
use super::state_matrix::{SWEEPS, eigen};
use crate::kernel::turn::Turn;

type C = Complex<f64>;

/// Entries of D below this part of the largest are rounding: off the diagonal, and on it of a rigid mode. With a dashpot of 1e-17 that would
/// have coordinates of 1e17, and the force on a contact at rest no digits.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// What a contact sees of a mode below this part of what it may see is rounding of the eigenvectors.
const UNFELT: f64 = 16.0 * f64::EPSILON;

/// Modes at most that dashpots couple. Their state matrix is twice as large, and its triangular form takes twenty times as long as modes without
/// dashpots do: 300 take as long as 1000 of these.
const MOST_COUPLED: usize = 300;

/// Poles of one shape closer than this part of their size are as good as one.
const COINCIDENT: f64 = 1e-7;

/// M q″ + C q′ + K q = s + Σ_j f_j cos jω(t+ψ), with contacts g = wᵀq. Units are the user's.
///
/// ```
/// use nalgebra::{DMatrix, DVector};
/// use vibrochain_lattice::{Contact, Structure};
/// let structure = Structure {
///     mass: DMatrix::identity(2, 2),
///     damping: DMatrix::from_row_slice(2, 2, &[0.02, 0.0, 0.0, 0.1]),
///     stiffness: DMatrix::from_row_slice(2, 2, &[1.0, -0.3, -0.3, 0.8]),
///     contacts: vec![(DVector::from_vec(vec![0.0, 1.0]), Contact { lower: None, upper: Some(0.7), restitution: 0.8 })],
///     ..Structure::default()
/// };
/// let modal = structure.modal()?;
/// assert_eq!(modal.modes().len(), 2);
/// assert!((modal.mobility(0, 0) - 1.0).abs() < 1e-14);
/// # Ok::<(), vibrochain_lattice::StructureError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Structure {
    /// M, symmetric and positive.
    pub mass: DMatrix<f64>,
    /// C, symmetric; without rows: none.
    pub damping: DMatrix<f64>,
    /// K, symmetric, without negative eigenvalues.
    pub stiffness: DMatrix<f64>,
    /// w of each contact, and where it is stopped.
    pub contacts: Vec<(DVector<f64>, Contact)>,
    /// s; without entries: none.
    pub static_load: DVector<f64>,
    /// Number j and f of each harmonic, complex: |f|cos(jω(t+ψ) + arg f).
    pub loads: Vec<(u32, DVector<C>)>,
    /// Only so many of its modes count, the slowest; `None`: all do. What loads, dashpots and contacts do to the others is left out.
    pub modes: Option<usize>,
}

impl Structure {
    /// Its modes.
    ///
    /// # Errors
    /// [`StructureError`]: sizes that do not fit, numbers that are not finite, a mass that is not positive, a stiffness that is not
    /// symmetric or has a negative eigenvalue, damping that makes two poles of one shape coincide. Of a contact that none of the modes which are
    /// kept moves, [`StructureError::Unmoved`].
    pub fn modal(&self) -> Result<ModalStructure, StructureError> {
        let n = self.mass.nrows();
        self.check()?;
        let mass = Cholesky::new(self.mass.clone()).ok_or(StructureError::Massless)?;
        let lower = mass.l();
        // L⁻¹KL⁻ᵀ
        let half = lower.solve_lower_triangular(&self.stiffness).ok_or(StructureError::Massless)?;
        let even = lower.solve_lower_triangular(&half.transpose()).ok_or(StructureError::Massless)?;
        let eigen = (&even + even.transpose()).scale(0.5).try_symmetric_eigen(f64::EPSILON, SWEEPS * n);
        let eigen = eigen.ok_or(StructureError::NotConverged)?;
        let largest = eigen.eigenvalues.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let floor = 8.0 * n as f64 * f64::EPSILON * largest;
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
        let mut squares = Vec::with_capacity(n);
        for &k in &order {
            let square = eigen.eigenvalues[k];
            if square < -floor {
                return Err(StructureError::Unstable { square });
            }
            squares.push(if square <= floor { 0.0 } else { square });
        }
        // From here on of the modes that are kept.
        let kept = self.modes.map_or(n, |modes| modes.min(n));
        squares.truncate(kept);
        let sorted = DMatrix::from_fn(n, kept, |i, k| eigen.eigenvectors[(i, order[k])]);
        let shapes = lower.tr_solve_lower_triangular(&sorted).ok_or(StructureError::Massless)?;
        let modes = if self.damping.is_empty() {
            self.oscillators(&shapes, &squares, &vec![0.0; kept])?
        } else {
            let mut damping = shapes.transpose() * &self.damping * &shapes;
            let size = damping.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
            for k in (0..kept).filter(|&k| squares[k] == 0.0) {
                if damping[(k, k)].abs() <= ROUNDING * n as f64 * size {
                    damping[(k, k)] = 0.0;
                }
            }
            let off = |i: usize, j: usize| i != j && damping[(i, j)].abs() > ROUNDING * n as f64 * size;
            if (0..kept).all(|i| (0..kept).all(|j| !off(i, j))) {
                let decays = as_one((0..kept).map(|k| 0.5 * damping[(k, k)]));
                self.oscillators(&shapes, &squares, &decays)?
            } else {
                self.poles(&shapes, &squares, &damping)?
            }
        };
        // How much each contact may see.
        let reach = |weights: &DVector<f64>| lower.solve_lower_triangular(weights).map_or(0.0, |seen| seen.norm());
        let reaches: Vec<f64> = self.contacts.iter().map(|(weights, _)| reach(weights)).collect();
        let modes = modes.into_iter().map(|mode| without_rounding(&lower, &reaches, mode)).collect();
        let contacts = self.contacts.iter().map(|(_, contact)| *contact).collect();
        let harmonics = self.loads.iter().map(|(number, _)| *number).collect();
        ModalStructure::new(contacts, harmonics, modes).map_err(|error| match (error, self.modes) {
            (StructureError::NoWeight { contact }, Some(modes)) => StructureError::Unmoved { contact, modes },
            (error, _) => error,
        })
    }

    /// 1/(wᵀM⁻¹w) of each contact: the mass that an impact there feels, whether all modes are kept or not. `None` of a mass that is not
    /// positive definite.
    pub fn effective_masses(&self) -> Option<Vec<f64>> {
        let mass = Cholesky::new(self.mass.clone())?;
        Some(self.contacts.iter().map(|(weights, _)| 1.0 / weights.dot(&mass.solve(weights))).collect())
    }

    /// Coordinates ξ of all modes of a state (q, q′); `modal` is what [`Structure::modal`] made of it.
    ///
    /// # Errors
    /// [`StructureError::Size`] where `place` or `velocity` has not one number a coordinate.
    pub fn project(
        &self,
        modal: &ModalStructure,
        place: &DVector<f64>,
        velocity: &DVector<f64>,
    ) -> Result<Vec<[f64; 2]>, StructureError> {
        let n = self.mass.nrows();
        for (what, given) in [("the place", place.len()), ("the velocity", velocity.len())] {
            if given != n {
                return Err(StructureError::Size { what: what.to_owned(), given, wanted: n });
            }
        }
        let (weight, momentum) = (&self.mass * place, &self.mass * velocity);
        let damped = if self.damping.is_empty() { DVector::zeros(n) } else { &self.damping * place };
        // A pole λ has the amplitude φᵀ(λMq + Mq′ + Cq), the shape as a list of numbers.
        let dot = |shape: &[C], vector: &DVector<f64>| shape.iter().zip(vector).map(|(s, x)| s * *x).sum::<C>();
        let amplitude = |rate: C, shape: &[C]| rate * dot(shape, &weight) + dot(shape, &momentum) + dot(shape, &damped);
        let of_mode = |mode: &LinearMode| {
            let shape = |turn: &dyn Fn(&[f64; 2]) -> C| mode.coordinates.iter().map(turn).collect::<Vec<C>>();
            if mode.is_real {
                let shape = shape(&|row| C::new(row[0], 0.0));
                let (at, moving) = (dot(&shape, &weight).re, dot(&shape, &momentum).re);
                return [at, (moving + mode.decay * at) / mode.rate];
            }
            let [first, second] = mode.rates();
            if mode.turn == Turn::Circular {
                let amplitude = amplitude(first, &shape(&|row| C::new(0.5 * row[0], 0.5 * row[1])));
                return [amplitude.re, -amplitude.im];
            }
            let root = 0.5f64.sqrt();
            let [a, b] = [(first, 1.0), (second, -1.0)].map(|(rate, sign)| {
                let shape = shape(&|row| C::new((row[0] + sign * row[1]) * root, 0.0));
                let vector = DVector::from_iterator(n, shape.iter().map(|x| x.re));
                let residue = vector.dot(&(&self.mass * &vector * (2.0 * rate.re) + &self.damping * &vector));
                amplitude(rate, &shape).re * residue.signum()
            });
            [(a + b) * root, (a - b) * root]
        };
        Ok(modal.modes().iter().map(of_mode).collect())
    }

    /// Energies ½q′ᵀMq′ + ½qᵀKq, q′ᵀCq′ and powers of the loads, in the modes that [`Structure::modal`] made.
    pub fn energy_form(&self, modal: &ModalStructure) -> EnergyForm {
        let n = self.mass.nrows();
        let modes = modal.modes();
        // q and q′ of a unit of each coordinate ξ.
        let place = DMatrix::from_fn(n, 2 * modes.len(), |i, at| modes[at / 2].coordinates[i][at % 2]);
        let velocity = DMatrix::from_fn(n, 2 * modes.len(), |i, at| {
            let (mode, mut unit) = (&modes[at / 2], [0.0; 2]);
            unit[at % 2] = 1.0;
            let rise = mode.turn.act(mode.generator(), unit);
            mode.coordinates[i][0] * rise[0] + mode.coordinates[i][1] * rise[1]
        });
        let blocks = |form: DMatrix<f64>| {
            let block = |first: usize, second: usize| {
                let at = |i: usize, j: usize| form[(2 * first + i, 2 * second + j)];
                Block { first, second, form: [[at(0, 0), at(0, 1)], [at(1, 0), at(1, 1)]] }
            };
            (0..modes.len()).flat_map(|i| (0..modes.len()).map(move |j| (i, j))).map(|(i, j)| block(i, j)).collect()
        };
        let energy = velocity.transpose() * &self.mass * &velocity + place.transpose() * &self.stiffness * &place;
        let dissipation =
            if self.damping.is_empty() { Vec::new() } else { blocks(velocity.transpose() * &self.damping * &velocity) };
        let power = |load: &DVector<C>, k: usize| {
            [0, 1].map(|i| load.iter().zip(&velocity.column(2 * k + i)).map(|(f, v)| f * *v).sum())
        };
        let still = if self.static_load.is_empty() { DVector::zeros(n) } else { self.static_load.clone() };
        let still = velocity.transpose() * still;
        EnergyForm {
            energy: blocks(energy),
            dissipation,
            still: (0..modes.len()).map(|k| [still[2 * k], still[2 * k + 1]]).collect(),
            loads: (0..modes.len()).map(|k| self.loads.iter().map(|(_, load)| power(load, k)).collect()).collect(),
        }
    }

    fn check(&self) -> Result<(), StructureError> {
        let n = self.mass.nrows();
        let size = |what: &str, given: usize, wanted: usize| {
            if given == wanted { Ok(()) } else { Err(StructureError::Size { what: what.to_owned(), given, wanted }) }
        };
        if n == 0 {
            return Err(StructureError::Size { what: "the mass matrix".to_owned(), given: 0, wanted: 1 });
        }
        if self.modes == Some(0) {
            return Err(StructureError::Range { what: "modes".to_owned(), value: 0.0, requirement: "a number from 1" });
        }
        size("the mass matrix", self.mass.ncols(), n)?;
        for (what, matrix) in [("the stiffness matrix", &self.stiffness), ("the damping matrix", &self.damping)] {
            if !(what == "the damping matrix" && matrix.is_empty()) {
                size(what, matrix.nrows(), n)?;
                size(what, matrix.ncols(), n)?;
            }
        }
        let symmetric = [
            ("the mass matrix", &self.mass),
            ("the stiffness matrix", &self.stiffness),
            ("the damping matrix", &self.damping),
        ];
        for (what, matrix) in symmetric.into_iter().filter(|(_, matrix)| !matrix.is_empty()) {
            let largest = matrix.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
            for row in 0..n {
                for column in 0..row {
                    if (matrix[(row, column)] - matrix[(column, row)]).abs() > 1e-12 * largest {
                        return Err(StructureError::Asymmetric { what, row, column });
                    }
                }
            }
        }
        if !self.static_load.is_empty() {
            size("the static load", self.static_load.len(), n)?;
        }
        for (number, load) in &self.loads {
            size("the load", load.len(), n)?;
            if *number == 0 {
                let (what, requirement) =
                    ("harmonic of the load".to_owned(), "a number from 1; the static load has its own key");
                return Err(StructureError::Range { what, value: 0.0, requirement });
            }
        }
        for (number, (weights, _)) in self.contacts.iter().enumerate() {
            size(&format!("the weights of contact {number}"), weights.len(), n)?;
            if weights.iter().all(|weight| *weight == 0.0) {
                return Err(StructureError::NoWeight { contact: number });
            }
        }
        let of_contacts = self.contacts.iter().flat_map(|(weights, _)| weights.iter().copied());
        let of_loads = self.loads.iter().flat_map(|(_, load)| load.iter().flat_map(|f| [f.re, f.im]));
        finite("the mass matrix", self.mass.iter().copied())?;
        finite("the stiffness matrix", self.stiffness.iter().copied())?;
        finite("the damping matrix", self.damping.iter().copied())?;
        finite("the static load", self.static_load.iter().copied())?;
        finite("the weights of contacts", of_contacts)?;
        finite("the load", of_loads)
    }

    /// What a real shape is at contacts and under the static load.
    fn shape(&self, shape: &DVector<f64>) -> ModeShape<f64> {
        ModeShape {
            contacts: self.contacts.iter().map(|(weights, _)| weights.dot(shape)).collect(),
            coordinates: shape.iter().copied().collect(),
            still: unless_rounding(self.static_load.iter().zip(shape).map(|(s, shape)| C::new(s * shape, 0.0))).re,
        }
    }

    /// φᵀf of each harmonic; none where it is rounding of its terms.
    fn loads(&self, shape: &DVector<f64>) -> Vec<C> {
        let of = |load: &DVector<C>| unless_rounding(load.iter().zip(shape).map(|(f, shape)| f * *shape));
        self.loads.iter().map(|(_, load)| of(load)).collect()
    }

    fn oscillators(
        &self,
        shapes: &DMatrix<f64>,
        squares: &[f64],
        decays: &[f64],
    ) -> Result<Vec<LinearMode>, StructureError> {
        let of_mode = |mode: usize| {
            let (square, decay) = (squares[mode], decays[mode]);
            // ν² = Ω² − δ² would be that of a rigid mode in the end.
            if square > 0.0 && decay > MOST_DAMPING * square.sqrt() {
                return Err(StructureError::Overdamped { mode, ratio: decay / square.sqrt() });
            }
            let shape = shapes.column(mode).clone_owned();
            Ok(LinearMode::oscillator(decay, square - decay * decay, &self.shape(&shape), &self.loads(&shape)))
        };
        (0..squares.len()).map(of_mode).collect()
    }

    /// Poles of λ² + λD + Ω², where D couples the modes; rigid ones that it leaves alone stay oscillators.
    fn poles(
        &self,
        shapes: &DMatrix<f64>,
        squares: &[f64],
        damping: &DMatrix<f64>,
    ) -> Result<Vec<LinearMode>, StructureError> {
        let n = squares.len();
        let size = damping.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
        let alone = |k: usize| {
            (0..n).all(|j| j == k || damping[(j, k)].abs().max(damping[(k, j)].abs()) <= ROUNDING * n as f64 * size)
        };
        let (own, coupled): (Vec<usize>, Vec<usize>) = (0..n).partition(|&k| alone(k));
        if coupled.iter().any(|&k| squares[k] == 0.0) {
            return Err(StructureError::RigidDamped);
        }
        if coupled.len() > MOST_COUPLED {
            return Err(StructureError::Coupled { modes: coupled.len(), most: MOST_COUPLED });
        }
        let pick = |list: &[usize]| DMatrix::from_fn(shapes.nrows(), list.len(), |i, k| shapes[(i, list[k])]);
        let picked = |list: &[usize]| list.iter().map(|&k| squares[k]).collect::<Vec<_>>();
        let decays = as_one(own.iter().map(|&k| 0.5 * damping[(k, k)]));
        let mut modes = self.oscillators(&pick(&own), &picked(&own), &decays)?;
        let m = coupled.len();
        let inner = DMatrix::from_fn(m, m, |i, j| damping[(coupled[i], coupled[j])]);
        let (found, vectors) = eigen(&picked(&coupled), &inner)?;
        let basis = pick(&coupled).map(|x| C::new(x, 0.0));
        let complex_inner = inner.map(|x| C::new(x, 0.0));
        let mut real: Vec<RealPole> = Vec::new();
        for (rate, vector) in found.iter().zip(&vectors) {
            // φᵀ(2λ + D)φ, of a symmetric D; of others both sides would count.
            let square = vector.dot(&(vector * (rate * 2.0) + &complex_inner * vector));
            let length = vector.iter().map(|x| x.norm_sqr()).sum::<f64>();
            if square.norm() <= COINCIDENT * length * (rate.norm() + size) {
                return Err(StructureError::Defective { re: rate.re, im: rate.im });
            }
            if rate.im == 0.0 {
                // Its phase is any: along its largest entry it is real.
                let largest = vector.iter().copied().max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or_default();
                let straight = vector.map(|x| (x / largest).re);
                let square = straight.dot(&(&straight * (2.0 * rate.re) + &inner * &straight));
                let shape = pick(&coupled) * straight / square.abs().sqrt();
                real.push(RealPole { rate: rate.re, sign: square.signum(), shape });
            } else if rate.im > 0.0 {
                let shape = &basis * vector / square.sqrt();
                let dot = |weights: &DVector<f64>| weights.iter().zip(&shape).map(|(w, x)| x * *w).sum::<C>();
                let of_shape = ModeShape {
                    contacts: self.contacts.iter().map(|(weights, _)| dot(weights)).collect(),
                    coordinates: shape.iter().copied().collect(),
                    still: if self.static_load.is_empty() { C::default() } else { dot(&self.static_load) },
                };
                let parts = [shape.map(|x| x.re), shape.map(|x| x.im)].map(|part| self.loads(&part));
                let loads: Vec<[C; 2]> = parts[0].iter().zip(&parts[1]).map(|(a, b)| [*a, *b]).collect();
                modes.push(LinearMode::pole(*rate, &of_shape, &loads));
            }
        }
        real.sort_by(|a, b| b.rate.total_cmp(&a.rate));
        for pair in real.chunks(2) {
            let [first, second] = pair else {
                return Err(StructureError::NotConverged);
            };
            let loads: Vec<[C; 2]> =
                self.loads(&first.shape).into_iter().zip(self.loads(&second.shape)).map(|(a, b)| [a, b]).collect();
            let both = [&self.shape(&first.shape), &self.shape(&second.shape)];
            modes.push(LinearMode::real_poles([first.rate, second.rate], [first.sign, second.sign], both, &loads));
        }
        modes.sort_by(|a, b| a.rates()[0].norm().total_cmp(&b.rates()[0].norm()));
        Ok(modes)
    }
}

/// A pole on the real axis: a motion that decays without turning.
struct RealPole {
    rate: f64,
    /// Of φᵀ(2λ + D)φ.
    sign: f64,
    shape: DVector<f64>,
}

/// A mode that a contact sees by rounding of its shape alone is not seen: one that grows would be felt in the end. M = LLᵀ, and a contact
/// may see |L⁻¹w| of a mode of length 1.
fn without_rounding(lower: &DMatrix<f64>, reaches: &[f64], mut mode: LinearMode) -> LinearMode {
    let part = |i: usize| DVector::from_iterator(mode.coordinates.len(), mode.coordinates.iter().map(|row| row[i]));
    let size = [0, 1].map(|i| lower.tr_mul(&part(i)).norm_squared()).iter().sum::<f64>().sqrt();
    for (number, reach) in reaches.iter().enumerate() {
        let [first, second] = mode.rows[number];
        if first.hypot(second) <= UNFELT * reach * size {
            (mode.rows[number], mode.columns[number]) = ([0.0; 2], [0.0; 2]);
        }
    }
    mode
}

/// A sum; 0 where it is rounding of its terms: a rigid mode would be pushed by it for ever.
fn unless_rounding(terms: impl Iterator<Item = C>) -> C {
    let (sum, size) = terms.fold((C::default(), 0.0), |(sum, size), term| (sum + term, size + term.norm()));
    if sum.norm() > 4.0 * f64::EPSILON * size { sum } else { C::default() }
}

fn finite(what: &str, mut values: impl Iterator<Item = f64>) -> Result<(), StructureError> {
    match values.find(|value| !value.is_finite()) {
        Some(value) => Err(StructureError::Range { what: what.to_owned(), value, requirement: "finite numbers" }),
        None => Ok(()),
    }
}

/// Rates that differ by rounding alone as one number: what depends on a rate alone is worked out once for all modes that have it.
fn as_one(rates: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut list: Vec<f64> = Vec::new();
    for rate in rates {
        let known = list.iter().find(|other| (**other - rate).abs() <= ROUNDING * rate.abs());
        list.push(known.copied().unwrap_or(rate));
    }
    list
}

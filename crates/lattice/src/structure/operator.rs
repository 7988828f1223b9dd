//! How coordinates pull at each other, where each has a mass of its own: q″ = −M⁻¹(Kq + Cq′) + M⁻¹f, by neighbours instead of by modes.

use rustfft::num_complex::Complex;

use super::linear_mode::LinearMode;
use crate::kernel::turn::Turn;
use crate::modes::row::{Ends, RowEnds};

type C = Complex<f64>;

/// A diagonal with at least one entry in so many rows is kept whole.
#[cfg(feature = "matrices")]
const SPARSE: usize = 4;

/// A matrix by its diagonals.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bands {
    /// Column less row, and an entry a row; 0 where there is no such column.
    pub diagonals: Vec<(isize, Vec<f64>)>,
    /// Row, column and value of entries on diagonals that have few.
    pub entries: Vec<(usize, usize, f64)>,
}

impl Bands {
    /// Of rows that may be asked for entry by entry.
    #[cfg(feature = "matrices")]
    pub(super) fn new(size: usize, at: impl Fn(usize, usize) -> f64) -> Self {
        let n = size as isize;
        let mut bands = Self::default();
        for off in 1 - n..n {
            let column = |row: usize| row.checked_add_signed(off).filter(|column| *column < size);
            let entry = |row: usize| column(row).map_or(0.0, |column| at(row, column));
            let diagonal: Vec<f64> = (0..size).map(entry).collect();
            let count = diagonal.iter().filter(|entry| **entry != 0.0).count();
            if count * SPARSE >= size {
                bands.diagonals.push((off, diagonal));
            } else if count > 0 {
                let few = diagonal.iter().enumerate().filter(|(_, entry)| **entry != 0.0);
                bands.entries.extend(few.filter_map(|(row, entry)| Some((row, column(row)?, *entry))));
            }
        }
        bands
    }

    /// The same times `factor`.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        let mut bands = self.clone();
        bands.diagonals.iter_mut().flat_map(|(_, diagonal)| diagonal).for_each(|entry| *entry *= factor);
        bands.entries.iter_mut().for_each(|(_, _, entry)| *entry *= factor);
        bands
    }

    /// Entries that are multiplied.
    pub fn count(&self) -> usize {
        self.diagonals.iter().map(|(_, diagonal)| diagonal.len()).sum::<usize>() + self.entries.len()
    }

    /// Row, column and value of all entries of a row, or of all rows.
    pub fn row(&self, only: Option<usize>) -> impl Iterator<Item = (usize, usize, f64)> {
        let along = self.diagonals.iter().flat_map(move |(off, diagonal)| {
            let rows = only.map_or(0..diagonal.len(), |row| row..row + 1);
            rows.filter_map(move |row| {
                let column = row.checked_add_signed(*off).filter(|column| *column < diagonal.len())?;
                Some((row, column, diagonal[row]))
            })
        });
        along.chain(self.entries.iter().copied().filter(move |(row, _, _)| only.is_none_or(|only| only == *row)))
    }
}

/// Rows beside each other, mass n of row l being mass n + l·length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layering {
    /// How many rows.
    pub layers: usize,
    /// What stands beside the first and the last.
    pub ends: Ends,
    /// γ₃, of springs from row to row.
    pub stiffness: f64,
}

/// What pulls at coordinates, over their masses.
#[derive(Debug, Clone, PartialEq)]
pub enum Pulls {
    /// γ₁ and c to the ground, γ₂ and c₂ to the neighbours in a row, γ₃ to those in the rows beside it, alike for all.
    Alike {
        /// What stands before the first and behind the last of a row.
        ends: [Ends; 2],
        /// γ₁ and γ₂
        stiffness: [f64; 2],
        /// c and c₂
        damping: [f64; 2],
        /// The rows.
        layering: Layering,
    },
    /// M⁻¹K and M⁻¹C.
    Bands {
        /// M⁻¹K
        stiffness: Bands,
        /// M⁻¹C
        damping: Bands,
    },
}

/// The motion of a structure's coordinates by what pulls at each, exact beside its modes ([`ModalStructure::operator`](crate::ModalStructure::operator)).
#[derive(Debug, Clone, PartialEq)]
pub struct SparseOperator {
    /// The mass of each coordinate.
    pub masses: Vec<f64>,
    /// What pulls at them.
    pub pulls: Pulls,
    /// Coordinates and weights of each contact.
    pub contacts: Vec<Vec<(usize, f64)>>,
    /// M⁻¹f of each harmonic, complex.
    pub loads: Vec<Vec<C>>,
}

impl SparseOperator {
    pub(super) fn rows(
        (sites, ends): (usize, RowEnds),
        layering: Layering,
        (stiffness, damping): ([f64; 2], [f64; 2]),
        contacts: Vec<Vec<(usize, f64)>>,
        loads: Vec<Vec<C>>,
    ) -> Self {
        let ends = match ends {
            RowEnds::Alike(ends) => [ends; 2],
            RowEnds::FixedFree => [Ends::Fixed, Ends::Free],
        };
        // In a row of one mass without walls the coupling cancels.
        let alone =
            |[own, between]: [f64; 2]| [own, if sites == 1 && !ends.contains(&Ends::Fixed) { 0.0 } else { between }];
        let pulls = Pulls::Alike { ends, stiffness: alone(stiffness), damping: alone(damping), layering };
        Self { masses: vec![1.0; sites * layering.layers], pulls, contacts, loads }
    }

    /// Entries of M⁻¹K and M⁻¹C: row, column, value. Of one row, or of all.
    pub fn entries(&self, only: Option<usize>) -> [Vec<(usize, usize, f64)>; 2] {
        let rows = only.map_or(0..self.masses.len(), |row| row..row + 1);
        [false, true].map(|is_damping| {
            let mut entries = Vec::new();
            rows.clone().for_each(|row| self.each(row, is_damping, |column, entry| entries.push((row, column, entry))));
            entries
        })
    }

    /// Columns and values of the entries of a row of M⁻¹K, or with `is_damping` of M⁻¹C.
    fn each(&self, row: usize, is_damping: bool, mut found: impl FnMut(usize, f64)) {
        match &self.pulls {
            Pulls::Bands { stiffness, damping } => {
                let bands = if is_damping { damping } else { stiffness };
                bands.row(Some(row)).for_each(|(_, column, entry)| found(column, entry));
            }
            Pulls::Alike { stiffness, damping, layering, .. } => {
                let ([own, between], across) =
                    if is_damping { (*damping, 0.0) } else { (*stiffness, layering.stiffness) };
                let [left, right, below, above] = self.neighbours(row);
                let across = if layering.layers > 1 { across } else { 0.0 };
                found(row, own + 2.0 * between + 2.0 * across);
                let mut beside = |sides: [Option<usize>; 2], by: f64| {
                    if by != 0.0 {
                        sides.into_iter().flatten().for_each(|other| found(other, -by));
                    }
                };
                beside([left, right], between);
                beside([below, above], across);
            }
        }
    }

    /// The masses before and behind one in its row, and those in the rows below and above, of masses alike: beside a free end and in rows of
    /// one it stands itself, with no spring, and beside a fixed one nobody.
    pub fn neighbours(&self, row: usize) -> [Option<usize>; 4] {
        let Pulls::Alike { ends, layering: Layering { layers, ends: beside, .. }, .. } = self.pulls else {
            return [Some(row); 4];
        };
        let length = self.masses.len() / layers;
        let (n, layer) = (row % length, row / length);
        let [left, right] = sides(n, length, ends).map(|side| side.map(|n| n + layer * length));
        let [below, above] = sides(layer, layers, [beside; 2]).map(|side| side.map(|layer| n + layer * length));
        [left, right, below, above]
    }

    /// Σ of a row of M⁻¹K, or with `is_damping` of M⁻¹C, times what is known `of` each coordinate.
    pub fn pull(&self, row: usize, is_damping: bool, of: impl Fn(usize) -> f64) -> f64 {
        match &self.pulls {
            Pulls::Bands { .. } => {
                let mut sum = 0.0;
                self.each(row, is_damping, |column, entry| sum += entry * of(column));
                sum
            }
            Pulls::Alike { stiffness, damping, layering, .. } => {
                let [own, between] = if is_damping { *damping } else { *stiffness };
                let [left, right, below, above] = self.neighbours(row).map(|side| side.map_or(0.0, &of));
                let here = of(row);
                let along = own * here - between * ((left + right) - 2.0 * here);
                let is_row = is_damping || layering.layers == 1;
                if is_row { along } else { along - layering.stiffness * ((below + above) - 2.0 * here) }
            }
        }
    }

    /// ½q′ᵀMq′ + ½qᵀKq. Alike coordinates have the sum over springs, which is 0 to the last digit where nothing is stretched.
    pub fn energy(&self, place: &[f64], velocity: &[f64]) -> f64 {
        let of = |n: usize| {
            let (mass, own, v) = (self.masses[n], place[n], velocity[n]);
            let Pulls::Alike { stiffness: [ground, between], layering, .. } = &self.pulls else {
                return 0.5 * mass * (v * v + own * self.pull(n, false, |m| place[m]));
            };
            let spring = |gamma: f64, side: Option<usize>| {
                let stretch = side.map_or(0.0, |m| place[m]) - own;
                gamma * stretch * stretch
            };
            // Each spring once: from the mass before it, or from the one that has a wall before it.
            let wall = |gamma: f64, side: Option<usize>| if side.is_none() { spring(gamma, None) } else { 0.0 };
            let across = if layering.layers > 1 { layering.stiffness } else { 0.0 };
            let [left, right, below, above] = self.neighbours(n);
            let row = v * v + ground * own * own + spring(*between, right) + wall(*between, left);
            0.5 * (row + spring(across, above) + wall(across, below))
        };
        (0..self.masses.len()).map(of).sum()
    }

    /// The same of the sizes of all entries.
    pub fn size(&self, row: usize, is_damping: bool, of: impl Fn(usize) -> f64) -> f64 {
        let mut sum = 0.0;
        self.each(row, is_damping, |column, entry| sum += entry.abs() * of(column));
        sum
    }

    /// A coordinate and those whose velocities pull at it.
    pub fn beside(&self, row: usize) -> Vec<usize> {
        let mut columns = vec![row];
        self.each(row, true, |column, entry| columns.extend((entry != 0.0 && column != row).then_some(column)));
        columns
    }

    /// The largest sums of the sizes of a row of M⁻¹K and of M⁻¹C.
    pub fn largest_rows(&self) -> [f64; 2] {
        [false, true].map(|is_damping| {
            let of_row = |row: usize| {
                let (mut own, mut others) = (0.0f64, 0.0f64);
                self.each(
                    row,
                    is_damping,
                    |column, entry| {
                        if column == row { own += entry } else { others += entry.abs() }
                    },
                );
                own.abs() + others
            };
            (0..self.masses.len()).map(of_row).fold(0.0, f64::max)
        })
    }

    /// Whether velocities pull at anything.
    pub fn is_damped(&self) -> bool {
        match &self.pulls {
            Pulls::Alike { damping, .. } => *damping != [0.0; 2],
            Pulls::Bands { damping, .. } => damping.count() > 0,
        }
    }

    /// Whether the velocity of a coordinate changes the acceleration of another.
    pub fn couples_velocities(&self) -> bool {
        match &self.pulls {
            Pulls::Alike { damping, .. } => damping[1] != 0.0,
            Pulls::Bands { damping, .. } => damping.row(None).any(|(row, column, entry)| row != column && entry != 0.0),
        }
    }

    /// Multiplications of one derivative of all coordinates.
    pub fn operations(&self) -> usize {
        let n = self.masses.len();
        let pulls = match &self.pulls {
            Pulls::Alike { damping, layering, .. } => {
                let own = if *damping == [0.0; 2] { 2 * n } else { 4 * n };
                // Neighbours are looked up.
                if layering.layers == 1 { own } else { 4 * own }
            }
            Pulls::Bands { stiffness, damping } => stiffness.count() + damping.count(),
        };
        pulls + 2 * n * self.loads.len()
    }

    /// w_iᵀM⁻¹w_j of two contacts.
    pub fn mobility(&self, to: usize, from: usize) -> f64 {
        let of = |(place, weight): &(usize, f64)| {
            let seen = self.contacts[to].iter().filter(|(other, _)| other == place);
            seen.map(|(_, other)| other * weight / self.masses[*place]).sum::<f64>()
        };
        self.contacts[from].iter().map(of).sum()
    }

    /// Coordinates ξ of all modes of a state (q, q′).
    pub fn project(&self, modes: &[LinearMode], place: &[f64], velocity: &[f64]) -> Vec<[f64; 2]> {
        let mass = |x: &[f64]| x.iter().zip(&self.masses).map(|(x, mass)| x * mass).collect();
        let [_, damping] = self.entries(None);
        let damped = |x: &[f64]| {
            let mut sum = vec![0.0; x.len()];
            damping.iter().for_each(|(row, column, entry)| sum[*row] += self.masses[*row] * entry * x[*column]);
            sum
        };
        projected(modes, mass, damped, place, velocity)
    }
}

/// Neighbours of a mass in a row; beside a free end it stands itself, with no spring, and beside a fixed one nobody.
fn sides(row: usize, masses: usize, ends: [Ends; 2]) -> [Option<usize>; 2] {
    let side = |inside: Option<usize>, end: Ends, far: usize| match (inside, end) {
        (Some(other), _) => Some(other),
        (None, Ends::Closed) => Some(far),
        (None, Ends::Free) => Some(row),
        (None, Ends::Fixed) => None,
    };
    [side(row.checked_sub(1), ends[0], masses - 1), side(Some(row + 1).filter(|above| *above < masses), ends[1], 0)]
}

/// ξ of modes of a state (q, q′), where M and C are told by what they make of a list.
pub(super) fn projected(
    modes: &[LinearMode],
    mass: impl Fn(&[f64]) -> Vec<f64>,
    damping: impl Fn(&[f64]) -> Vec<f64>,
    place: &[f64],
    velocity: &[f64],
) -> Vec<[f64; 2]> {
    let (weight, momentum, damped) = (mass(place), mass(velocity), damping(place));
    let real = |list: &[f64], vector: &[f64]| list.iter().zip(vector).map(|(a, b)| a * b).sum::<f64>();
    // A pole λ has the amplitude φᵀ(λMq + Mq′ + Cq), the shape as a list of numbers.
    let dot = |shape: &[C], vector: &[f64]| shape.iter().zip(vector).map(|(s, x)| s * *x).sum::<C>();
    let amplitude = |rate: C, shape: &[C]| rate * dot(shape, &weight) + dot(shape, &momentum) + dot(shape, &damped);
    let of_mode = |mode: &LinearMode| {
        let shape = |turn: &dyn Fn(&[f64; 2]) -> C| mode.coordinates.iter().map(turn).collect::<Vec<C>>();
        if mode.is_real {
            let shape: Vec<f64> = mode.coordinates.iter().map(|row| row[0]).collect();
            return mode.amplitudes(real(&shape, &weight), real(&shape, &momentum));
        }
        let [first, second] = mode.rates();
        if mode.turn == Turn::Circular {
            let amplitude = amplitude(first, &shape(&|row| C::new(0.5 * row[0], 0.5 * row[1])));
            return [amplitude.re, -amplitude.im];
        }
        let root = 0.5f64.sqrt();
        let [a, b] = [(first, 1.0), (second, -1.0)].map(|(rate, sign)| {
            let shape = shape(&|row| C::new((row[0] + sign * row[1]) * root, 0.0));
            let vector: Vec<f64> = shape.iter().map(|x| x.re).collect();
            let residue = 2.0 * rate.re * real(&vector, &mass(&vector)) + real(&vector, &damping(&vector));
            amplitude(rate, &shape).re * residue.signum()
        });
        [(a + b) * root, (a - b) * root]
    };
    modes.iter().map(of_mode).collect()
}

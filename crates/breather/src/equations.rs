//! The equations of an orbit with all impacts at one site, linearised about it.
//!
//! The unknowns are the impulses P_i, the static displacement s they hold up and, where the family leaves them open, the
//! time t_1 and the phase ψ. With K̂ the dynamic part of K₀:
//!
//! ```text
//! position  s + Σ_j P_j K̂(t_i−t_j) + G(t_i+ψ) − (a±1) = 0          net impulse   Σ P_j − g s = 0
//! Newton    Σ_{j≠i} P_j K′(t_i−t_j) + Ġ(t_i+ψ) + qP_i/2 = 0
//! ```
//!
//! Their Jacobian J is singular at a fold or pitchfork of the family. It serves twice: errors of the terms pass through
//! its inverse (`condition`), and so does what is left of a residual (`polish`).

use vibrochain_lattice::{ImpulseResponse, KernelJet};

use crate::orbit::{Family, Orbit};
use crate::worst::worse;

/// Most unknowns: two impulses, s, t_1, ψ.
pub(crate) const MOST: usize = 5;

/// A vector of rows or unknowns; entries beyond the size of the system are 0.
pub(crate) type Column = [f64; MOST];

/// What the rows of the equations are made of.
pub(crate) struct Terms<'a> {
    pub(crate) orbit: &'a Orbit,
    pub(crate) response: &'a ImpulseResponse,
}

/// Where the unknowns stand.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layout {
    /// Number of impulses; also the place of s.
    pub(crate) impacts: usize,
    /// Place of t_1.
    pub(crate) time: Option<usize>,
    /// Place of ψ.
    pub(crate) psi: Option<usize>,
    pub(crate) size: usize,
}

/// The Jacobian and its inverse.
pub(crate) struct System {
    pub(crate) layout: Layout,
    pub(crate) matrix: [Column; MOST],
    inverse: [Column; MOST],
    /// Natural sizes of the unknowns.
    units: Column,
    /// Reciprocal condition number of J, rows and columns scaled.
    pub(crate) reciprocal_condition: f64,
}

impl<'a> Terms<'a> {
    pub(crate) fn new(orbit: &'a Orbit, response: &'a ImpulseResponse) -> Self {
        Self { orbit, response }
    }

    pub(crate) fn impulse(&self, j: usize) -> f64 {
        self.orbit.impacts()[j].impulse
    }

    /// t_i − t_j folded into the period.
    pub(crate) fn elapsed(&self, i: usize, j: usize) -> f64 {
        let elapsed = self.orbit.impacts()[i].time - self.orbit.impacts()[j].time;
        if elapsed < 0.0 { elapsed + self.response.period() } else { elapsed }
    }

    pub(crate) fn jet(&self, i: usize, j: usize) -> KernelJet {
        self.response.jet_from_half(self.elapsed(i, j) - 0.5 * self.response.period())
    }

    /// G and its first three derivatives at impact `i`.
    pub(crate) fn force(&self, i: usize) -> [f64; 4] {
        self.orbit.steady().jet(self.orbit.impacts()[i].time + self.orbit.psi_or_zero())
    }

    /// Static displacement of site 0, of which the orbit carries the uniform mode's share.
    pub(crate) fn static_displacement(&self) -> f64 {
        self.orbit.uniform_offset() / self.response.uniform_share()
    }

    /// Newton's law stands in row n+1+i. Without a force one of the two is a consequence of the other, and both are of
    /// mirror symmetry.
    pub(crate) fn has_newton_row(layout: Layout, i: usize) -> bool {
        layout.psi.is_some() || layout.time.is_some() && i == 0
    }

    /// Which unknowns there are; `None` for an orbit that was given, not solved for.
    pub(crate) fn layout(&self) -> Option<Layout> {
        let orbit = self.orbit;
        let impacts = orbit.impacts().len();
        if orbit.family() == Family::Word || orbit.impact_site().is_none() || impacts > 2 {
            return None;
        }
        let mut size = impacts + 1;
        let mut place = |there: bool| {
            there.then(|| {
                size += 1;
                size - 1
            })
        };
        let time = place(impacts == 2 && !orbit.is_reversible());
        let psi = place(!orbit.model().is_conservative());
        Some(Layout { impacts, time, psi, size })
    }

    /// What is left of position and Newton's law at impact `i`.
    pub(crate) fn violation(&self, i: usize) -> [f64; 2] {
        self.balance(i).map(|(left, _)| left)
    }

    /// Largest violation, each over the sizes of its terms.
    pub(crate) fn worst_violation(&self) -> f64 {
        let share = |(left, size): (f64, f64)| (left / size).abs();
        let worst = |i: usize| self.balance(i).map(share).into_iter().fold(0.0, worse);
        (0..self.orbit.impacts().len()).map(worst).fold(0.0, worse)
    }

    /// Position and Newton's law at impact `i`: what is left, and the sum of the terms' sizes.
    fn balance(&self, i: usize) -> [(f64, f64); 2] {
        let (impact, steady, loss) = (&self.orbit.impacts()[i], self.orbit.steady(), self.orbit.model().loss());
        let force = self.force(i);
        let mut position = self.static_displacement() + force[0] - self.orbit.model().barrier(impact.barrier);
        let mut newton = force[1] + 0.5 * loss * impact.impulse;
        let (mut length, mut velocity) = (steady.bound(0).max(1.0), steady.bound(1));
        for j in 0..self.orbit.impacts().len() {
            let (jet, impulse) = (self.jet(i, j), self.impulse(j));
            position += impulse * jet.value;
            length += (impulse * jet.value).abs();
            if j == i {
                velocity += (0.5 * loss * impulse).abs();
            } else {
                newton += impulse * jet.slope;
                velocity += (impulse * jet.slope).abs();
            }
        }
        [(position, length), (newton, velocity.max(f64::MIN_POSITIVE))]
    }

    /// The linearised equations.
    pub(crate) fn system(&self) -> Option<System> {
        Some(self.system_of(self.layout()?))
    }

    /// The linearised equations of the given unknowns.
    pub(crate) fn system_of(&self, layout: Layout) -> System {
        let (orbit, n) = (self.orbit, layout.impacts);
        let mut matrix = [[0.0; MOST]; MOST];
        let q = orbit.model().loss();
        for i in 0..n {
            let force = self.force(i);
            let (mut velocity, mut acceleration) = (force[1], force[2]);
            for j in 0..n {
                let jet = self.jet(i, j);
                matrix[i][j] = jet.value;
                if j == i {
                    continue;
                }
                let impulse = self.impulse(j);
                (velocity, acceleration) = (velocity + impulse * jet.slope, acceleration + impulse * jet.curvature);
                if Self::has_newton_row(layout, i) {
                    matrix[n + 1 + i][j] = jet.slope;
                }
                if let Some(time) = layout.time.filter(|_| j == 1) {
                    matrix[i][time] -= impulse * jet.slope;
                    if Self::has_newton_row(layout, i) {
                        matrix[n + 1 + i][time] -= impulse * jet.curvature;
                    }
                }
            }
            matrix[i][n] = 1.0;
            for (place, moves) in [(layout.time, i == 1), (layout.psi, true)] {
                let Some(place) = place.filter(|_| moves) else { continue };
                let of_psi = Some(place) == layout.psi;
                matrix[i][place] += if of_psi { force[1] } else { velocity };
                if Self::has_newton_row(layout, i) {
                    matrix[n + 1 + i][place] += if of_psi { force[2] } else { acceleration };
                }
            }
            if Self::has_newton_row(layout, i) {
                matrix[n + 1 + i][i] = 0.5 * q;
            }
        }
        matrix[n][..n].fill(1.0);
        matrix[n][n] = -self.response.static_stiffness();
        let mut units = [1.0; MOST];
        units[..n].fill((0..n).map(|j| self.impulse(j).abs()).fold(f64::MIN_POSITIVE, f64::max));
        // In units of half the gap.
        units[n] = self.static_displacement().abs().max(1.0);
        if let Some(time) = layout.time {
            units[time] = self.response.period();
        }
        if let Some(psi) = layout.psi {
            units[psi] = orbit.model().period();
        }
        System::new(layout, matrix, units)
    }
}

impl System {
    pub(crate) fn new(layout: Layout, matrix: [Column; MOST], units: Column) -> Self {
        let n = layout.size;
        let mut left = [[0.0; MOST]; MOST];
        let mut right = [[0.0; MOST]; MOST];
        for i in 0..n {
            let row: Column = std::array::from_fn(|j| matrix[i][j] * units[j]);
            let size = row[..n].iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            let size = if size > 0.0 { size } else { 1.0 };
            left[i] = row.map(|x| x / size);
            right[i][i] = 1.0 / size;
        }
        let scaled_inverse = |right: &[Column; MOST], rows: &[Column; MOST]| {
            // Undo the scaling of the rows, to speak of the scaled matrix alone.
            let sizes: Column = std::array::from_fn(|i| if i < n { rows[i][i] } else { 1.0 });
            (0..n).map(|i| (0..n).map(|j| (right[i][j] / sizes[j]).abs()).sum::<f64>()).fold(0.0, f64::max)
        };
        let norm = (0..n).map(|i| left[i][..n].iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
        let rows = right;
        // Gauss–Jordan with row exchanges: `right` becomes the inverse.
        for column in 0..n {
            let pivot = (column..n).max_by(|&i, &j| left[i][column].abs().total_cmp(&left[j][column].abs()));
            let pivot = pivot.unwrap_or(column);
            left.swap(column, pivot);
            right.swap(column, pivot);
            let head = left[column][column];
            if head == 0.0 || !head.is_finite() {
                let inverse = [[f64::INFINITY; MOST]; MOST];
                return Self { layout, matrix, inverse, units, reciprocal_condition: 0.0 };
            }
            left[column] = left[column].map(|x| x / head);
            right[column] = right[column].map(|x| x / head);
            for i in (0..n).filter(|i| *i != column) {
                let factor = left[i][column];
                for j in 0..n {
                    left[i][j] -= factor * left[column][j];
                    right[i][j] -= factor * right[column][j];
                }
            }
        }
        let reciprocal_condition = (1.0 / (norm * scaled_inverse(&right, &rows))).min(1.0);
        let inverse = std::array::from_fn(|i| right[i].map(|x| x * units[i]));
        Self { layout, matrix, inverse, units, reciprocal_condition }
    }

    /// J⁻¹ r
    pub(crate) fn solve(&self, rows: &Column) -> Column {
        let n = self.layout.size;
        std::array::from_fn(|i| if i < n { (0..n).map(|j| self.inverse[i][j] * rows[j]).sum() } else { 0.0 })
    }

    /// |J⁻¹| r for r ≥ 0; an error of 0 stays 0 next to a singular J.
    pub(crate) fn spread(&self, rows: &Column) -> Column {
        let n = self.layout.size;
        let term = |i: usize, j: usize| if rows[j] == 0.0 { 0.0 } else { self.inverse[i][j].abs() * rows[j] };
        std::array::from_fn(|i| if i < n { (0..n).map(|j| term(i, j)).sum() } else { 0.0 })
    }

    /// |g J⁻¹| r for r ≥ 0.
    pub(crate) fn through(&self, gradient: &Column, rows: &Column) -> f64 {
        let n = self.layout.size;
        let carried = |j: usize| (0..n).map(|i| gradient[i] * self.inverse[i][j]).sum::<f64>();
        (0..n).map(|j| if rows[j] == 0.0 { 0.0 } else { carried(j).abs() * rows[j] }).sum()
    }

    /// What rounding of the open time and phase, each by `unit` of its period, does to impulses worked out from them by
    /// the conditions of position alone.
    pub(crate) fn impulse_rounding(&self, unit: f64) -> Column {
        let n = self.layout.impacts;
        let mut errors = [0.0; MOST];
        let Some(time) = self.layout.time else { return errors };
        let positions = System::new(Layout { size: n + 1, ..self.layout }, self.matrix, self.units);
        for place in [Some(time), self.layout.psi].into_iter().flatten() {
            let rows: Column = std::array::from_fn(|i| if i < n { self.matrix[i][place] } else { 0.0 });
            let moved = positions.solve(&rows);
            for (error, moved) in errors.iter_mut().zip(moved).take(n) {
                *error += unit * (self.units[place] * moved).abs();
            }
        }
        errors
    }
}

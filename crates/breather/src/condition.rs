//! How far an orbit can be trusted: its distance to the places where its equations lose their grip, and the errors of
//! its impulses, times and accelerations that follow from there.
//!
//! The unknowns of an orbit with all impacts at one site are the impulses P_i, the static displacement s they hold up
//! and, where the family leaves them open, the times t_i (i ≥ 1) and the phase ψ. With K̂ the dynamic part of K₀:
//!
//! ```text
//! position  s + Σ_j P_j K̂(t_i−t_j) + G(t_i+ψ) − (a±1) = 0          net impulse   Σ P_j − g s = 0
//! Newton    Σ_{j≠i} P_j K′(t_i−t_j) + Ġ(t_i+ψ) + qP_i/2 = 0
//! ```
//!
//! The errors δF of their terms, from the kernels' own sensitivity, pass through the inverse of the Jacobian,
//! |δx| ≤ |J⁻¹| δF. J is singular at a fold or pitchfork of the family.

use smallvec::SmallVec;
use vibrochain_lattice::{ImpulseResponse, KernelJet};

use crate::motion::Motion;
use crate::orbit::{Family, Orbit};

/// Estimated absolute errors of an impact. Dimensionless, like what they are errors of.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ImpactError {
    /// Of its time.
    pub time: f64,
    /// Of its impulse.
    pub impulse: f64,
    /// Of the acceleration there.
    pub acceleration: f64,
}

/// Distances of an orbit to where it ceases to be determined, and the errors that follow. Dimensionless.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Condition {
    /// Distance to resonance: the smallest |Ω_k − jω|/Ω_k over modes and harmonics j ≥ 1, at most 1; ω is the orbit's base
    /// frequency. So many digits of the kernels are lost as this has zeros.
    pub resonance: f64,
    /// Distance to grazing: the smallest velocity before an impact, in units of ω times half the gap. Saltation grows
    /// like its inverse.
    pub grazing: f64,
    /// Distance to a fold or pitchfork: reciprocal condition number of the orbit's equations, rows and columns scaled, at
    /// most 1. `None` for an orbit given by its impacts.
    pub fold: Option<f64>,
    /// Estimated error of the force's phase ψ, as a time; 0 without force.
    pub psi_error: f64,
    /// Estimated errors of the impacts.
    pub impacts: SmallVec<[ImpactError; 2]>,
}

impl Condition {
    /// Largest error of an impulse, relative to the largest impulse.
    pub fn impulse_error(&self, orbit: &Orbit) -> f64 {
        let largest = orbit.impacts().iter().map(|impact| impact.impulse.abs()).fold(f64::MIN_POSITIVE, f64::max);
        self.impacts.iter().map(|error| error.impulse).fold(0.0, f64::max) / largest
    }

    /// Largest error of a time or of the phase, relative to the period of the orbit.
    pub fn time_error(&self, orbit: &Orbit) -> f64 {
        self.impacts.iter().map(|error| error.time).fold(self.psi_error, f64::max) / orbit.period()
    }

    pub(crate) fn of(orbit: &Orbit, response: &ImpulseResponse, motion: &mut Motion) -> Self {
        let omega = orbit.model().omega();
        let grazing = orbit.impacts().iter().map(|impact| impact.velocity_before.abs()).fold(f64::INFINITY, f64::min);
        let mut condition = Self {
            resonance: 1.0 / response.condition(),
            grazing: grazing / omega,
            fold: None,
            psi_error: 0.0,
            impacts: orbit.impacts().iter().map(|_| ImpactError::default()).collect(),
        };
        let terms = Terms::new(orbit, response);
        let equations = terms.equations();
        if let Some(equations) = &equations {
            let (errors, reciprocal) = equations.solve();
            condition.fold = Some(reciprocal);
            terms.spread(&errors, &mut condition);
        }
        for i in 0..orbit.impacts().len() {
            let rounding = terms.acceleration_rounding(i, motion);
            let carried = terms.acceleration_carried(i, &condition);
            condition.impacts[i].acceleration = rounding + carried;
        }
        condition
    }
}

/// Rounding of one operation, with room for the few that a term takes.
const UNIT: f64 = 2.0 * f64::EPSILON;

/// Most unknowns: two impulses, s, φ, ψ.
const MOST: usize = 5;

/// Everything the equations are made of.
struct Terms<'a> {
    orbit: &'a Orbit,
    response: &'a ImpulseResponse,
}

/// A small linear system with the errors of its right-hand side.
struct Equations {
    size: usize,
    matrix: [[f64; MOST]; MOST],
    errors: [f64; MOST],
    /// Natural sizes of the unknowns.
    units: [f64; MOST],
}

impl<'a> Terms<'a> {
    fn new(orbit: &'a Orbit, response: &'a ImpulseResponse) -> Self {
        Self { orbit, response }
    }

    fn impulse(&self, j: usize) -> f64 {
        self.orbit.impacts()[j].impulse
    }

    /// t_i − t_j folded into the period.
    fn elapsed(&self, i: usize, j: usize) -> f64 {
        let elapsed = self.orbit.impacts()[i].time - self.orbit.impacts()[j].time;
        if elapsed < 0.0 { elapsed + self.response.period() } else { elapsed }
    }

    fn jet(&self, i: usize, j: usize) -> KernelJet {
        self.response.jet_from_half(self.elapsed(i, j) - 0.5 * self.response.period())
    }

    /// G and its first three derivatives at impact `i`.
    fn force(&self, i: usize) -> [f64; 4] {
        let w = self.orbit.model().omega();
        let g = self.orbit.force_response();
        let (sin, cos) = (w * (self.orbit.impacts()[i].time + self.orbit.psi_or_zero())).sin_cos();
        [g * cos, -g * w * sin, -g * w * w * cos, g * w * w * w * sin]
    }

    /// Error of a term of the force whose value and rate of change are given.
    fn force_rounding(&self, i: usize, value: f64, rate: f64) -> f64 {
        let t = self.orbit.impacts()[i].time + self.orbit.psi_or_zero();
        UNIT * (value.abs() + (t * rate).abs())
    }

    /// Static displacement of site 0.
    fn static_displacement(&self) -> f64 {
        // The uniform mode's share of it is what the orbit carries.
        self.orbit.uniform_offset() / self.response.uniform_share()
    }

    /// The linearised equations; `None` for an orbit that was given, not solved for.
    fn equations(&self) -> Option<Equations> {
        let orbit = self.orbit;
        let n = orbit.impacts().len();
        let forced = !orbit.model().is_conservative();
        if orbit.family() == Family::Word || orbit.impact_site().is_none() || n > 2 {
            return None;
        }
        let free_time = n == 2 && !orbit.is_reversible();
        let size = n + 1 + usize::from(free_time) + usize::from(forced);
        // Columns: P_0 … P_{n−1}, s, t_1, ψ.
        let (s, time, psi) = (n, n + 1, n + 1 + usize::from(free_time));
        let largest = (0..n).map(|j| self.impulse(j).abs()).fold(f64::MIN_POSITIVE, f64::max);
        let displacement = self.static_displacement();
        let mut units = [1.0; MOST];
        units[..n].fill(largest);
        units[s] = displacement.abs().max(1e-3);
        if free_time {
            units[time] = self.response.period();
        }
        if forced {
            units[psi] = orbit.model().period();
        }
        let mut equations = Equations { size, matrix: [[0.0; MOST]; MOST], errors: [0.0; MOST], units };
        let q = orbit.model().loss();
        for i in 0..n {
            let force = self.force(i);
            let impact = &orbit.impacts()[i];
            // Position.
            let row = &mut equations.matrix[i];
            row[s] = 1.0;
            let mut error = UNIT * (displacement.abs() + orbit.model().barrier(impact.barrier).abs());
            error += self.force_rounding(i, force[0], force[1]);
            let mut velocity = force[1];
            for j in 0..n {
                let jet = self.jet(i, j);
                row[j] = jet.value;
                error += UNIT * self.impulse(j).abs() * self.response.sensitivity(self.elapsed(i, j)).value;
                if j != i {
                    velocity += self.impulse(j) * jet.slope;
                    if free_time && j == 1 {
                        row[time] -= self.impulse(j) * jet.slope;
                    }
                }
            }
            if free_time && i == 1 {
                row[time] += velocity;
            }
            if forced {
                row[psi] = force[1];
            }
            equations.errors[i] = error;
            // Newton's law: one equation without a force is a consequence of the other.
            if !(forced || free_time && i == 0) {
                continue;
            }
            let row = &mut equations.matrix[n + 1 + i];
            row[i] = 0.5 * q;
            let mut error = UNIT * (0.5 * q * impact.impulse).abs() + self.force_rounding(i, force[1], force[2]);
            let mut curvature = force[2];
            for j in (0..n).filter(|&j| j != i) {
                let jet = self.jet(i, j);
                row[j] = jet.slope;
                error += UNIT * self.impulse(j).abs() * self.response.sensitivity(self.elapsed(i, j)).slope;
                curvature += self.impulse(j) * jet.curvature;
                if free_time && j == 1 {
                    row[time] -= self.impulse(j) * jet.curvature;
                }
            }
            if free_time && i == 1 {
                row[time] += curvature;
            }
            if forced {
                row[psi] = force[2];
            }
            equations.errors[n + 1 + i] = error;
        }
        let stiffness = self.response.static_stiffness();
        equations.matrix[n][..n].fill(1.0);
        equations.matrix[n][s] = -stiffness;
        equations.errors[n] = 2.0 * UNIT * (stiffness * displacement).abs();
        Some(equations)
    }

    /// Hands the errors of the unknowns to the impacts and the phase.
    fn spread(&self, errors: &[f64; MOST], condition: &mut Condition) {
        let n = condition.impacts.len();
        let forced = !self.orbit.model().is_conservative();
        let free_time = n == 2 && !self.orbit.is_reversible();
        for (j, impact) in condition.impacts.iter_mut().enumerate() {
            impact.impulse = errors[j] + UNIT * self.impulse(j).abs();
        }
        if free_time {
            condition.impacts[1].time = errors[n + 1] + UNIT * self.response.period();
        }
        if forced {
            condition.psi_error = errors[n + 1 + usize::from(free_time)] + UNIT * self.orbit.model().period();
        }
    }

    /// Error of the sum −γ₁v − γ₂(2v − v_l − v_r) + F at impact `i`, for exact impulses and times.
    fn acceleration_rounding(&self, i: usize, motion: &mut Motion) -> f64 {
        let orbit = self.orbit;
        let chain = orbit.model().chain();
        let impact = &orbit.impacts()[i];
        motion.seek(i, 0.0);
        let ring = motion.sites();
        let force = self.force(i);
        // What rounding does to the displacement of the mass itself and of a neighbour.
        let displacement_error = |site: usize| {
            let mut error = self.force_rounding(i, force[0], force[1]);
            for (j, other) in orbit.impacts().iter().enumerate() {
                let distance = site.abs_diff(other.site) % ring;
                error += UNIT * other.impulse.abs() * self.response.sensitivity_at(distance, self.elapsed(i, j)).value;
            }
            error + UNIT * (orbit.uniform_offset().abs() + motion.site(site % ring).displacement.abs())
        };
        let (own, next) = (motion.site(impact.site).displacement, motion.site((impact.site + 1) % ring).displacement);
        let amplitude = orbit.model().amplitude();
        let phase = orbit.model().omega() * (impact.time + orbit.psi_or_zero());
        chain.gamma1() * (displacement_error(impact.site) + UNIT * own.abs())
            + 2.0 * chain.gamma2() * (displacement_error(impact.site) + displacement_error(impact.site + 1))
            + UNIT * (2.0 * chain.gamma2() * (own.abs() + next.abs()) + amplitude * (1.0 + phase.abs()))
    }

    /// What the errors of impulses, times and phase do to the acceleration Σ_j P_j K″(t_i−t_j) + G̈(t_i+ψ).
    fn acceleration_carried(&self, i: usize, condition: &Condition) -> f64 {
        let jerk_of_force = self.force(i)[3];
        let mut jerk = jerk_of_force;
        let mut error = (jerk_of_force * condition.psi_error).abs();
        let site = self.orbit.impacts()[i].site;
        for (j, other) in self.orbit.impacts().iter().enumerate().filter(|(_, other)| other.site == site) {
            let jet = self.jet(i, j);
            error += (jet.curvature * condition.impacts[j].impulse).abs();
            if j != i {
                jerk += other.impulse * jet.third;
                error += (other.impulse * jet.third * condition.impacts[j].time).abs();
            }
        }
        error + (jerk * condition.impacts[i].time).abs()
    }
}

impl Equations {
    /// |J⁻¹| δF, and the reciprocal condition number of J scaled by rows and columns.
    fn solve(&self) -> ([f64; MOST], f64) {
        let n = self.size;
        let mut a = [[0.0; 2 * MOST]; MOST];
        let mut rows = [0.0_f64; MOST];
        for i in 0..n {
            for j in 0..n {
                a[i][j] = self.matrix[i][j] * self.units[j];
                rows[i] = rows[i].max(a[i][j].abs());
            }
            rows[i] = if rows[i] > 0.0 { rows[i] } else { 1.0 };
            for j in 0..n {
                a[i][j] /= rows[i];
            }
            a[i][n + i] = 1.0;
        }
        let norm = |a: &[[f64; 2 * MOST]; MOST], from: usize| {
            (0..n).map(|i| a[i][from..from + n].iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max)
        };
        let size = norm(&a, 0);
        // Gauss–Jordan with row exchanges: the right half becomes the inverse.
        for column in 0..n {
            let pivot = (column..n).max_by(|&i, &j| a[i][column].abs().total_cmp(&a[j][column].abs()));
            a.swap(column, pivot.unwrap_or(column));
            let head = a[column][column];
            if head == 0.0 || !head.is_finite() {
                return ([f64::INFINITY; MOST], 0.0);
            }
            a[column].iter_mut().for_each(|x| *x /= head);
            let pivot_row = a[column];
            for (_, row) in a.iter_mut().enumerate().take(n).filter(|(i, _)| *i != column) {
                let factor = row[column];
                row.iter_mut().zip(&pivot_row).for_each(|(x, p)| *x -= factor * p);
            }
        }
        let mut errors = [0.0; MOST];
        for i in 0..n {
            let sum: f64 = (0..n).map(|j| a[i][n + j].abs() * self.errors[j] / rows[j]).sum();
            errors[i] = self.units[i] * sum;
        }
        (errors, (1.0 / (size * norm(&a, n))).min(1.0))
    }
}

//! Every contact of an orbit at any time: exact flight of the modes from impact to impact, the motion under the loads on top.

use vibrochain_lattice::{Complex, LinearMode, ModalStructure, Turn, Turned};

use super::equations::Equations;
use super::error::StructureOrbitError;
use super::orbit::StructureOrbit;
use crate::motion::polynomial::{ORDER, Polynomial};

type C = Complex<f64>;

/// The motion of an orbit. Times are since an impact, given by its number.
#[derive(Debug, Clone)]
pub struct StructureMotion<'a> {
    orbit: &'a StructureOrbit,
    equations: Equations<'a>,
    /// ξ of each regular mode just after each impact, without loads: [impact][mode].
    states: Vec<Vec<[f64; 2]>>,
}

impl<'a> StructureMotion<'a> {
    /// The motion of an orbit.
    ///
    /// # Errors
    /// [`StructureOrbitError::Structure`] at a resonance.
    pub fn new(orbit: &'a StructureOrbit) -> Result<Self, StructureOrbitError> {
        let equations =
            Equations::new(orbit.model(), orbit.force_periods(), orbit.impacts().iter().map(|impact| impact.contact))?;
        let modes = orbit.model().structure().modes();
        let (impacts, period) = (orbit.impacts(), orbit.period());
        let mut states = vec![vec![[0.0; 2]; modes.len()]; impacts.len()];
        for (k, mode) in modes.iter().enumerate() {
            let Some(sum) = equations.kernel.sum(k) else { continue };
            // Just after each impact: its own impulse, and all others since, over all periods.
            for (i, impact) in impacts.iter().enumerate() {
                for (j, other) in impacts.iter().enumerate() {
                    let past = if impact.time > other.time || i == j {
                        impact.time - other.time
                    } else if impact.time == other.time {
                        // Of impacts at one instant, those earlier in the list have happened.
                        if j < i { 0.0 } else { period }
                    } else {
                        impact.time - other.time + period
                    };
                    let by = mode.turn.product(mode.flight(past), sum);
                    let column = mode.columns[other.contact].map(|x| x * other.impulse);
                    let given = mode.turn.act(by, column);
                    states[i][k][0] += given[0];
                    states[i][k][1] += given[1];
                }
            }
        }
        Ok(Self { orbit, equations, states })
    }

    fn structure(&self) -> &ModalStructure {
        self.orbit.model().structure()
    }

    /// Time from impact `i` to the next one.
    pub fn until_next(&self, i: usize) -> f64 {
        let impacts = self.orbit.impacts();
        impacts.get(i + 1).map_or(self.orbit.period() + impacts[0].time, |next| next.time) - impacts[i].time
    }

    /// Place, velocity and acceleration of a contact at `s` after impact `i`, before the next one.
    pub fn contact(&self, contact: usize, i: usize, s: f64) -> [f64; 3] {
        let at = self.orbit.impacts()[i].time + s;
        let [place, velocity, acceleration, _] = self.equations.load(contact, at + self.orbit.psi().unwrap_or(0.0));
        let mut sums = [place + self.equations.still(contact), velocity, acceleration];
        self.add(i, s, |mode| mode.rows[contact], &mut sums);
        sums
    }

    /// Displacements and velocities of all coordinates there, where the structure has them.
    pub fn coordinates(&self, i: usize, s: f64) -> Result<Vec<[f64; 2]>, StructureOrbitError> {
        let structure = self.structure();
        let t = self.orbit.impacts()[i].time + s + self.orbit.psi().unwrap_or(0.0);
        let mut under_loads = structure.still();
        for (place, harmonic) in structure.harmonics().iter().enumerate() {
            let turn = C::from_polar(1.0, f64::from(*harmonic) * self.orbit.model().omega() * t);
            let swing = structure.steady(place, self.orbit.model().omega())?;
            for (sum, swing) in under_loads.iter_mut().zip(&swing) {
                (0..2).for_each(|n| sum[n] += (swing[n] * turn).re);
            }
        }
        let mut rates = vec![[0.0; 2]; under_loads.len()];
        for (place, harmonic) in structure.harmonics().iter().enumerate() {
            let w = f64::from(*harmonic) * self.orbit.model().omega();
            let turn = C::from_polar(1.0, w * t) * C::new(0.0, w);
            let swing = structure.steady(place, self.orbit.model().omega())?;
            for (sum, swing) in rates.iter_mut().zip(&swing) {
                (0..2).for_each(|n| sum[n] += (swing[n] * turn).re);
            }
        }
        let of = |coordinate: usize| {
            let mut sums = [0.0; 3];
            for ((mode, xi), rate) in structure.modes().iter().zip(&under_loads).zip(&rates) {
                let row = mode.coordinates[coordinate];
                sums[0] += row[0] * xi[0] + row[1] * xi[1];
                sums[1] += row[0] * rate[0] + row[1] * rate[1];
            }
            self.add(i, s, |mode| mode.coordinates[coordinate], &mut sums);
            [sums[0], sums[1]]
        };
        Ok((0..structure.coordinates()).map(of).collect())
    }

    /// Coordinates ξ of all modes there, loads and rigid modes included: where a simulation may begin.
    ///
    /// # Errors
    /// [`StructureOrbitError::Structure`] at a resonance.
    pub fn modes(&self, i: usize, s: f64) -> Result<Vec<[f64; 2]>, StructureOrbitError> {
        let structure = self.structure();
        let omega = self.orbit.model().omega();
        let t = self.orbit.impacts()[i].time + s + self.orbit.psi().unwrap_or(0.0);
        let mut all = structure.still();
        for (place, harmonic) in structure.harmonics().iter().enumerate() {
            let turn = C::from_polar(1.0, f64::from(*harmonic) * omega * t);
            for (sum, swing) in all.iter_mut().zip(structure.steady(place, omega)?) {
                (0..2).for_each(|n| sum[n] += (swing[n] * turn).re);
            }
        }
        let mut rigid = 0;
        for (k, (mode, sum)) in structure.modes().iter().zip(&mut all).enumerate() {
            let own = if self.equations.kernel.sum(k).is_none() {
                let [place, velocity, _] = self.rigid(mode, i, s);
                let place = place + self.orbit.offsets()[rigid];
                rigid += 1;
                [place, (velocity + mode.decay * place) / mode.rate]
            } else {
                let flight = mode.flight(s);
                mode.turn.act(flight, self.states[i][k])
            };
            (0..2).for_each(|n| sum[n] += own[n]);
        }
        Ok(all)
    }

    /// Adds what impacts do.
    fn add(&self, i: usize, s: f64, row: impl Fn(&LinearMode) -> [f64; 2], sums: &mut [f64; 3]) {
        let mut rigid = 0;
        for (k, mode) in self.structure().modes().iter().enumerate() {
            let row = row(mode);
            if self.equations.kernel.sum(k).is_none() {
                sums[0] += row[0] * self.orbit.offsets()[rigid];
                rigid += 1;
                for (order, value) in self.rigid(mode, i, s).into_iter().enumerate() {
                    sums[order] += row[0] * value;
                }
                continue;
            }
            if row == [0.0; 2] {
                continue;
            }
            let flight = mode.flight(s);
            let mut xi = mode.turn.act(flight, self.states[i][k]);
            for sum in sums.iter_mut() {
                *sum += row[0] * xi[0] + row[1] * xi[1];
                xi = mode.turn.act(mode.generator(), xi);
            }
        }
    }

    /// A rigid mode's own coordinate without its offset.
    fn rigid(&self, mode: &LinearMode, i: usize, s: f64) -> [f64; 3] {
        let impacts = self.orbit.impacts();
        let mut sums = [0.0; 3];
        for (j, other) in impacts.iter().enumerate() {
            let lapse = impacts[i].time - other.time + if j > i { self.orbit.period() } else { 0.0 } + s;
            let jet = super::periodic_kernel::rigid_jet(mode, self.orbit.period(), lapse);
            (0..3).for_each(|order| sums[order] += Equations::shape(mode, other.contact) * other.impulse * jet[order]);
        }
        sums
    }

    /// A bound of how far a contact may be from where it is still, after impact `i`; none of a structure with rigid modes.
    pub(super) fn most_excursion(&self, contact: usize, i: usize) -> f64 {
        if self.equations.kernel.rigid().next().is_some() {
            return f64::INFINITY;
        }
        self.most(contact, i, 0.0, self.until_next(i), 0)
    }

    /// Where a contact is under the static load alone.
    pub(super) fn still(&self, contact: usize) -> f64 {
        self.equations.still(contact)
    }

    /// A bound of |acceleration| of a contact from `s` to `end` after impact `i`.
    pub(super) fn most_acceleration(&self, contact: usize, i: usize, s: f64, end: f64) -> f64 {
        self.most(contact, i, s, end, 2)
    }

    /// A bound of a derivative, of the order 0 or 2, without what is still.
    fn most(&self, contact: usize, i: usize, s: f64, end: f64, order: i32) -> f64 {
        let mut most: f64 = self.equations.swings(contact).map(|(rate, swing)| swing.norm() * rate.powi(order)).sum();
        for (k, mode) in self.structure().modes().iter().enumerate() {
            let row = mode.rows[contact];
            if self.equations.kernel.sum(k).is_none() {
                // Between impacts nothing but its load and its dashpot turn it.
                let [first, last] = [s, end].map(|t| self.rigid(mode, i, t)[2].abs());
                most += row[0].abs() * first.max(last);
                continue;
            }
            if row == [0.0; 2] {
                continue;
            }
            let flight = mode.flight(s);
            let mut bend = mode.turn.act(flight, self.states[i][k]);
            for _ in 0..order {
                bend = mode.turn.act(mode.generator(), bend);
            }
            let left = end - s;
            let dying = (-mode.decay * left).exp().max(1.0);
            let (rows, size) = (row[0].hypot(row[1]), bend[0].hypot(bend[1]));
            most += match mode.turn {
                Turn::Circular => rows * size * dying,
                // Along either pole.
                Turn::Hyperbolic => {
                    rows * size * ((mode.rate - mode.decay) * left).exp().max(1.0) * std::f64::consts::SQRT_2
                }
                Turn::Parabolic => rows * size * dying * (1.0 + mode.rate * left),
            };
        }
        most
    }
}

/// One flight in windows of at most a radian of its fastest part, on which every contact is a polynomial to rounding.
pub(super) struct Windows<'m, 'a> {
    motion: &'m StructureMotion<'a>,
    /// Length of a window, and how many there are.
    pub(super) length: f64,
    pub(super) count: usize,
    number: usize,
    i: usize,
    /// ξ of each mode at the window's start, what a window turns it by, and its derivatives over factorials: [order][mode].
    states: Vec<[f64; 2]>,
    steps: Vec<Turned>,
    derivatives: Vec<[f64; 2]>,
}

/// More windows than this in a flight are not laid: modes far above all others are bounded instead.
const MOST_WINDOWS: f64 = 600.0;

/// Windows after which states are set anew, so that rounding cannot add up.
const REFRESH: usize = 32;

impl<'m, 'a> Windows<'m, 'a> {
    /// `None` where there would be too many, or a rigid mode is no part of the modes' flight.
    pub(super) fn new(motion: &'m StructureMotion<'a>, i: usize) -> Option<Self> {
        if motion.equations.kernel.rigid().next().is_some() {
            return None;
        }
        let modes = motion.structure().modes();
        let fastest = modes.iter().map(|mode| mode.rate.hypot(mode.decay)).fold(0.0, f64::max);
        let fastest = motion.equations.swings(0).map(|(rate, _)| rate).fold(fastest, f64::max);
        let (whole, windows) = (motion.until_next(i), (motion.until_next(i) * fastest).ceil().max(1.0));
        if windows > MOST_WINDOWS {
            return None;
        }
        let length = whole / windows;
        let steps = modes.iter().map(|mode| mode.flight(length)).collect();
        let mut all = Self {
            motion,
            length,
            count: windows as usize,
            number: 0,
            i,
            states: motion.states[i].clone(),
            steps,
            derivatives: vec![[0.0; 2]; modes.len() * ORDER],
        };
        all.derive();
        Some(all)
    }

    /// Since the impact.
    pub(super) fn start(&self) -> f64 {
        self.number as f64 * self.length
    }

    /// Goes on to the next window, if there is one.
    pub(super) fn advance(&mut self) -> bool {
        self.number += 1;
        if self.number == self.count {
            return false;
        }
        let modes = self.motion.structure().modes();
        if self.number.is_multiple_of(REFRESH) {
            let at = self.start();
            for (k, mode) in modes.iter().enumerate() {
                let by = mode.flight(at);
                self.states[k] = mode.turn.act(by, self.motion.states[self.i][k]);
            }
        } else {
            for ((mode, state), step) in modes.iter().zip(&mut self.states).zip(&self.steps) {
                *state = mode.turn.act(*step, *state);
            }
        }
        self.derive();
        true
    }

    fn derive(&mut self) {
        let modes = self.motion.structure().modes();
        for (k, mode) in modes.iter().enumerate() {
            let mut xi = self.states[k];
            for order in 0..ORDER {
                self.derivatives[order * modes.len() + k] = xi;
                let by = 1.0 / (order + 1) as f64;
                xi = mode.turn.act(Turned { even: -mode.decay * by, odd: mode.rate * by }, xi);
            }
        }
    }

    /// The contact on this window, from its start on.
    pub(super) fn polynomial(&self, contact: usize) -> Polynomial {
        let modes = self.motion.structure().modes();
        let mut coefficients = [0.0; ORDER];
        for (coefficient, derivatives) in coefficients.iter_mut().zip(self.derivatives.chunks_exact(modes.len().max(1)))
        {
            let terms = modes.iter().zip(derivatives).map(|(mode, xi)| {
                let row = mode.rows[contact];
                row[0] * xi[0] + row[1] * xi[1]
            });
            *coefficient = terms.sum();
        }
        coefficients[0] += self.motion.equations.still(contact);
        let orbit = self.motion.orbit;
        let t = orbit.impacts()[self.i].time + self.start() + orbit.psi().unwrap_or(0.0);
        for (rate, swing) in self.motion.equations.swings(contact) {
            let mut value = swing * C::from_polar(1.0, rate * t);
            for (order, coefficient) in coefficients.iter_mut().enumerate() {
                *coefficient += value.re;
                value *= C::new(0.0, rate / (order + 1) as f64);
            }
        }
        Polynomial { coefficients }
    }
}

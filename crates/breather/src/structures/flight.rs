//! Every contact of an orbit at any time: exact flight of the modes from impact to impact, the motion under the loads on top.

use std::sync::{Arc, OnceLock};

use smallvec::SmallVec;
use vibrochain_lattice::{Complex, LinearMode, ModalStructure, ParticipatingModes, Stopped, Turn, Turned};

use super::equations::Equations;
use super::orbit::ContactOrbit;
use super::periodic_kernel::{EITHER_WAY, PeriodicKernel, length, rigid_jet};
use super::response::Response;
use crate::error::BreatherError;
use crate::motion::Motion;
use crate::motion::modal::view::{View, reach};
use crate::orbit::Impact;

type C = Complex<f64>;

/// The motion of an orbit. Times are since an impact, given by its number.
#[derive(Debug, Clone)]
pub struct ContactMotion<'a> {
    orbit: &'a ContactOrbit,
    /// ξ of each regular mode that is felt just after each impact, without loads, once it is asked for: [impact][mode].
    states: SmallVec<[OnceLock<Vec<[f64; 2]>>; 2]>,
}

impl<'a> ContactMotion<'a> {
    /// The motion of an orbit.
    ///
    /// # Errors
    /// [`BreatherError::Structure`] at a resonance.
    pub fn new(orbit: &'a ContactOrbit) -> Result<Self, BreatherError> {
        Ok(Self { orbit, states: orbit.impacts().iter().map(|_| OnceLock::new()).collect() })
    }

    fn structure(&self) -> &ModalStructure {
        self.orbit.model().structure()
    }

    /// Whether the model's request to stop is raised.
    pub(super) fn heard(&self) -> Result<(), Stopped> {
        self.orbit.model().heard()
    }

    pub(super) fn response(&self) -> &'a Response {
        self.orbit.response()
    }

    /// The regular modes that are felt, with their state just after an impact.
    pub(super) fn felt(&self, i: usize) -> impl Iterator<Item = (&LinearMode, [f64; 2])> + Clone {
        let modes = self.response().kernel.regular().map(|(mode, _)| mode);
        modes.zip(self.after(i).iter().copied())
    }

    fn after(&self, i: usize) -> &[[f64; 2]] {
        self.states[i].get_or_init(|| after_impact(self.orbit, &self.response().kernel, i))
    }

    /// The state of one of these modes, or of a rigid one, which come after them, just after an impact.
    pub(super) fn state(&self, i: usize, number: usize) -> [f64; 2] {
        let (states, rigid) = (self.after(i), self.response().kernel.rigid());
        states.get(number).copied().unwrap_or_else(|| {
            let place = number - states.len();
            self.rigid_state(&rigid[place], i, 0.0, self.orbit.offsets()[place])
        })
    }

    /// First and second coordinates of what contacts see at the start of the flight after impact `i`.
    pub(super) fn begin(&self, view: &View, i: usize, [x, y]: [&mut [f64]; 2]) {
        for (k, &number) in view.numbers.iter().enumerate() {
            [x[k], y[k]] = self.state(i, number);
        }
        view.begin_swings(self.load_time(i, 0.0), [x, y]);
    }

    /// ξ of a rigid mode.
    fn rigid_state(&self, mode: &LinearMode, i: usize, s: f64, offset: f64) -> [f64; 2] {
        let [place, velocity, ..] = self.rigid(mode, i, s);
        let place = place + offset;
        [place, (velocity + mode.decay * place) / mode.rate]
    }

    /// Time from impact `i` to the next one.
    pub fn until_next(&self, i: usize) -> f64 {
        let impacts = self.orbit.impacts();
        impacts.get(i + 1).map_or(self.orbit.period() + impacts[0].time, |next| next.time) - impacts[i].time
    }

    /// The time of the loads, t + ψ.
    pub(super) fn load_time(&self, i: usize, s: f64) -> f64 {
        self.orbit.impacts()[i].time + s + self.orbit.psi().unwrap_or(0.0)
    }

    /// Place, velocity and acceleration of a contact at `s` after impact `i`, before the next one.
    pub fn contact(&self, contact: usize, i: usize, s: f64) -> [f64; 3] {
        let [place, velocity, acceleration, _] = self.jet(contact, i, s);
        [place, velocity, acceleration]
    }

    /// The same with the jerk.
    pub(super) fn jet(&self, contact: usize, i: usize, s: f64) -> [f64; 4] {
        let response = self.response();
        let mut sums = response.load(contact, self.load_time(i, s));
        sums[0] += response.still(contact);
        for (mode, state) in self.felt(i) {
            let row = mode.rows[contact];
            if row == [0.0; 2] {
                continue;
            }
            let mut xi = mode.turn.act(mode.flight(s), state);
            for sum in &mut sums {
                *sum += row[0] * xi[0] + row[1] * xi[1];
                xi = mode.turn.act(mode.generator(), xi);
            }
        }
        for (mode, offset) in response.kernel.rigid().iter().zip(self.orbit.offsets()) {
            let row = mode.rows[contact];
            sums[0] += row[0] * offset;
            for (sum, value) in sums.iter_mut().zip(self.rigid(mode, i, s)) {
                *sum += row[0] * value;
            }
        }
        sums
    }

    /// Displacements and velocities of all coordinates there, where the structure has them.
    ///
    /// # Errors
    /// [`BreatherError::Structure`] at a resonance.
    pub fn coordinates(&self, i: usize, s: f64) -> Result<Vec<[f64; 2]>, BreatherError> {
        let (structure, omega) = (self.structure(), self.orbit.model().omega());
        let all = self.modes(i, s)?;
        let mut rates: Vec<[f64; 2]> =
            structure.modes().iter().zip(&all).map(|(mode, xi)| mode.turn.act(mode.generator(), *xi)).collect();
        for (mode, rate) in structure.modes().iter().zip(&mut rates) {
            (0..2).for_each(|n| rate[n] += mode.still[n]);
            for (harmonic, load) in structure.harmonics().iter().zip(&mode.loads) {
                let turn = C::from_polar(1.0, f64::from(*harmonic) * omega * self.load_time(i, s));
                (0..2).for_each(|n| rate[n] += (load[n] * turn).re);
            }
        }
        let of = |coordinate: usize| {
            let mut sums = [0.0; 2];
            for (mode, parts) in structure.modes().iter().zip(all.iter().zip(&rates)) {
                let row = mode.coordinates[coordinate];
                sums[0] += row[0] * parts.0[0] + row[1] * parts.0[1];
                sums[1] += row[0] * parts.1[0] + row[1] * parts.1[1];
            }
            sums
        };
        Ok((0..structure.coordinates()).map(of).collect())
    }

    /// Coordinates ξ of all modes there, loads and rigid modes included: where a simulation may begin.
    ///
    /// # Errors
    /// [`BreatherError::Structure`] at a resonance.
    pub fn modes(&self, i: usize, s: f64) -> Result<Vec<[f64; 2]>, BreatherError> {
        let structure = self.structure();
        let omega = self.orbit.model().omega();
        let mut all = structure.still();
        for (place, harmonic) in structure.harmonics().iter().enumerate() {
            let turn = C::from_polar(1.0, f64::from(*harmonic) * omega * self.load_time(i, s));
            for (sum, swing) in all.iter_mut().zip(structure.steady(place, omega)?) {
                (0..2).for_each(|n| sum[n] += (swing[n] * turn).re);
            }
        }
        // Every mode by itself, felt or not.
        let felt = ParticipatingModes { modes: structure.modes().to_vec().into(), ..ParticipatingModes::default() };
        let kernel = PeriodicKernel::new(structure.modes(), Arc::new(felt), &[], self.orbit.period());
        let mut states = after_impact(self.orbit, &kernel, i).into_iter();
        let mut offsets = self.orbit.offsets().iter();
        for (mode, sum) in structure.modes().iter().zip(&mut all) {
            let own = if mode.is_rigid() {
                self.rigid_state(mode, i, s, offsets.next().copied().unwrap_or_default())
            } else {
                mode.turn.act(mode.flight(s), states.next().unwrap_or_default())
            };
            (0..2).for_each(|n| sum[n] += own[n]);
        }
        Ok(all)
    }

    /// A rigid mode's own coordinate without its offset.
    fn rigid(&self, mode: &LinearMode, i: usize, s: f64) -> [f64; 4] {
        let impacts = self.orbit.impacts();
        let mut sums = [0.0; 4];
        for (j, other) in impacts.iter().enumerate() {
            let lapse = impacts[i].time - other.time + if j > i { self.orbit.period() } else { 0.0 } + s;
            let jet = rigid_jet(mode.decay, self.orbit.period(), lapse);
            (0..4).for_each(|order| sums[order] += Equations::shape(mode, other.site) * other.impulse * jet[order]);
        }
        sums
    }

    /// A bound of the error of a contact's derivative of some order up to the third, just after impact `i`: what errors of impulses and times, of
    /// the phase, and rounding make of its terms.
    pub(super) fn error(&self, contact: usize, order: usize, i: usize) -> f64 {
        let (orbit, response, kernel) = (self.orbit, self.response(), &self.response().kernel);
        let (impacts, rounding) = (orbit.impacts(), 8.0 * f64::EPSILON);
        let fastest = self.felt(i).map(|(mode, _)| length([mode.decay, mode.rate])).fold(0.0, f64::max);
        let of = |(place, other): (usize, &Impact)| {
            let lapse = impacts[i].time - other.time;
            let (_, sizes) = kernel.jet(contact, other.site, lapse);
            // What it has given at this instant itself, beside earlier periods.
            let now = if lapse == 0.0 {
                self.structure().mobility(contact, other.site).abs() * fastest.powi(order as i32 - 1)
            } else {
                0.0
            };
            let known = orbit.estimate(place);
            let part = known.impulse + other.impulse.abs() * (fastest * known.time + rounding);
            (sizes[order] + now) * part
        };
        let late = self.load_time(i, 0.0).abs();
        let of_loads = response.swings(contact).map(|(rate, swing)| {
            let time = rate * (orbit.psi_estimate() + orbit.estimate(i).time + f64::EPSILON * late);
            swing.norm() * rate.powi(order as i32) * (time + rounding)
        });
        // Next to a resonance, what the error of the frequency makes of all terms at once.
        let both = kernel.nearly_resonant().flat_map(|of| EITHER_WAY.map(|by| (of, by)));
        let of_sums = both.map(|((place, doubt), by)| {
            let term = |other: &Impact| {
                let lapse = impacts[i].time - other.time;
                other.impulse * kernel.jet_of_mode(place, by, (contact, other.site), lapse)[order]
            };
            doubt * impacts.iter().map(term).sum::<f64>().abs()
        });
        impacts.iter().enumerate().map(of).chain(of_loads).chain(of_sums).sum()
    }

    /// A bound of a contact's derivative of second order or a higher one, from `s` to `end` after impact `i`.
    pub(super) fn bound(&self, contact: usize, order: u32, i: usize, [s, end]: [f64; 2]) -> f64 {
        let swings = self.response().swings(contact);
        let mut most: f64 = swings.map(|(rate, swing)| swing.norm() * rate.powi(order as i32)).sum();
        for (mode, state) in self.felt(i).filter(|(mode, _)| mode.rows[contact] != [0.0; 2]) {
            let there = mode.turn.act(mode.flight(s), state);
            most += length(mode.rows[contact]) * reach(mode.flow(), there, end - s, order);
        }
        for mode in self.response().kernel.rigid() {
            // Between impacts nothing but its load and its dashpot turn it: from the jerk on derivatives fall by 2δ.
            let of = |jet: [f64; 4]| match order {
                2 => jet[2].abs(),
                _ => jet[3].abs() * (2.0 * mode.decay).powi(order as i32 - 3),
            };
            let [first, last] = [s, end].map(|t| of(self.rigid(mode, i, t)));
            most += mode.rows[contact][0].abs() * first.max(last);
        }
        most
    }
}

/// ξ of each regular mode of a kernel just after an impact: its own impulse, and all others since, over all periods.
fn after_impact(orbit: &ContactOrbit, kernel: &PeriodicKernel, i: usize) -> Vec<[f64; 2]> {
    let (impacts, period) = (orbit.impacts(), orbit.period());
    let modes: SmallVec<[(&LinearMode, Turned); 16]> = kernel.regular().collect();
    let mut states = vec![[0.0; 2]; modes.len()];
    for (j, other) in impacts.iter().enumerate() {
        let past = if impacts[i].time > other.time || i == j {
            impacts[i].time - other.time
        } else if impacts[i].time == other.time {
            // Of impacts at one instant, those earlier in the list have happened.
            if j < i { 0.0 } else { period }
        } else {
            impacts[i].time - other.time + period
        };
        let give = |state: &mut [f64; 2], mode: &LinearMode, by: Turned| {
            let given = mode.turn.act(by, mode.columns[other.site].map(|x| x * other.impulse));
            *state = [state[0] + given[0], state[1] + given[1]];
        };
        if past == 0.0 {
            states.iter_mut().zip(&modes).for_each(|(state, (mode, sum))| give(state, mode, *sum));
            continue;
        }
        let flights = Turn::flights(modes.iter().map(|(mode, _)| mode.flow()), past);
        for ((state, (mode, sum)), flight) in states.iter_mut().zip(&modes).zip(flights) {
            give(state, mode, mode.turn.product(flight, *sum));
        }
    }
    states
}

impl ContactOrbit {
    /// Place and velocity of a contact at a time, of a lattice those of a mass.
    ///
    /// # Errors
    /// [`BreatherError`] at a resonance.
    pub fn state(&self, site: usize, time: f64) -> Result<[f64; 2], BreatherError> {
        if let Some(orbit) = self.of_all_masses() {
            let mass = Motion::of(&orbit?)?.at(site, time);
            return Ok([mass.displacement, mass.velocity]);
        }
        let (motion, (last, since)) = (ContactMotion::new(self)?, self.flight_at(time));
        let [place, velocity, _] = motion.contact(site, last, since);
        Ok([place, velocity])
    }

    /// Those of all contacts, of a lattice of all its masses.
    ///
    /// # Errors
    /// [`BreatherError`] at a resonance.
    pub fn states(&self, time: f64) -> Result<Vec<[f64; 2]>, BreatherError> {
        if let Some(orbit) = self.of_all_masses() {
            let mut motion = Motion::of(&orbit?)?;
            let _ = motion.at(0, time);
            let of = (0..motion.sites()).map(|site| motion.site(site));
            return Ok(of.map(|mass| [mass.displacement, mass.velocity]).collect());
        }
        let (motion, (last, since)) = (ContactMotion::new(self)?, self.flight_at(time));
        let contacts = 0..self.model().structure().contacts().len();
        let of = contacts.map(|contact| motion.contact(contact, last, since));
        Ok(of.map(|[place, velocity, _]| [place, velocity]).collect())
    }

    /// The impact before a time, and how long ago it was.
    fn flight_at(&self, time: f64) -> (usize, f64) {
        let impacts = self.impacts();
        let time = time.rem_euclid(self.period());
        let last = impacts.iter().rposition(|impact| impact.time <= time).unwrap_or(impacts.len() - 1);
        (last, (time - impacts[last].time).rem_euclid(self.period()))
    }
}

//! Position and Newton's law at every impact, the balance of rigid modes, and their derivatives.
//!
//! The state is that just before each impact: of the kernel past impulses alone count, the own of earlier periods included.

use std::f64::consts::TAU;
use std::sync::Arc;

use smallvec::SmallVec;
use vibrochain_lattice::{Complex, LinearMode, ModalStructure, StructureError};

use super::model::LoadedStructure;
use super::open_mode::OpenMode;
use super::periodic_kernel::{PeriodicKernel, UNIT};
use super::point::Point;
use super::response::Response;
use crate::equations::linear::{Matrix, Vector, dot, zeros};
use crate::equations::slopes::Slopes;
use crate::error::BreatherError;

type C = Complex<f64>;

/// Parts of a vector below this are rounding of the shapes it is made of.
const SAME: f64 = 1e-12;

/// A time is half a period to this part of it: a few roundings.
const HALF: f64 = 8.0 * f64::EPSILON;

/// One impact of the equations: what its contact does just before.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Arrival {
    pub(super) place: f64,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
    /// g‴
    pub(super) jerk: f64,
    /// Sizes of the terms of place, velocity and acceleration.
    pub(super) sizes: [f64; 3],
}

/// A motion that nothing holds and contacts of the orbit feel: of several rigid modes, as two free bodies have them, a combination. There are as
/// many as these contacts tell apart: what they do not see has no offset.
#[derive(Debug, Clone)]
pub(super) struct Drift {
    /// What of each rigid mode is in it.
    parts: Vector,
    /// Of each contact.
    pub(super) shapes: Vec<f64>,
    /// What the static load does to it.
    pub(super) push: f64,
}

impl Drift {
    /// Those that `contacts` tell apart.
    ///
    /// # Errors
    /// [`BreatherError::Unbalanced`] where a static load pushes what none of them feels.
    fn felt(structure: &ModalStructure, contacts: &[usize]) -> Result<Vec<Self>, BreatherError> {
        let modes: Vec<&LinearMode> = structure.modes().iter().filter(|mode| mode.is_rigid()).collect();
        let without = |mut vector: Vector, basis: &[Vector]| {
            for own in basis {
                let part = dot(own, &vector);
                vector.iter_mut().zip(own).for_each(|(entry, own)| *entry -= part * own);
            }
            vector
        };
        let mut basis: Vec<Vector> = Vec::new();
        for &contact in contacts {
            let seen: Vector = modes.iter().map(|mode| Equations::shape(mode, contact)).collect();
            let size = dot(&seen, &seen).sqrt();
            let left = without(without(seen, &basis), &basis);
            let length = dot(&left, &left).sqrt();
            if length > SAME * size {
                basis.push(left.iter().map(|entry| entry / length).collect());
            }
        }
        let felt = |mode: &LinearMode| contacts.iter().any(|contact| Equations::shape(mode, *contact) != 0.0);
        let own: Vec<usize> = (0..modes.len()).filter(|&k| felt(modes[k])).collect();
        if own.len() == basis.len() {
            let unit = |&k: &usize| (0..modes.len()).map(|l| if l == k { 1.0 } else { 0.0 }).collect();
            basis = own.iter().map(unit).collect();
        }
        // What nothing holds and nothing hits must not be pushed.
        let push: Vector = modes.iter().map(|mode| Equations::push(mode)).collect();
        let most = push.iter().fold(0.0, |most: f64, push| most.max(push.abs()));
        if without(push.clone(), &basis).iter().any(|left| left.abs() > SAME * most) {
            return Err(BreatherError::Unbalanced);
        }
        let of = |parts: Vector| {
            let whole =
                |of: &dyn Fn(&LinearMode) -> f64| parts.iter().zip(&modes).map(|(part, mode)| part * of(mode)).sum();
            let all = 0..structure.contacts().len();
            let shapes = all.map(|contact| whole(&|mode| Equations::shape(mode, contact))).collect();
            let push = whole(&Equations::push);
            Self { parts, shapes, push }
        };
        Ok(basis.into_iter().map(of).collect())
    }
}

/// The equations of a model's orbits of one period.
#[derive(Debug, Clone)]
pub(super) struct Equations<'a> {
    pub(super) model: &'a LoadedStructure,
    pub(super) response: Arc<Response>,
    pub(super) rigid: Vec<Drift>,
    pub(super) forced: bool,
    /// No load, but losses that negative dashpots make up for: the period is an unknown.
    pub(super) self_excited: bool,
    /// The contacts that are hit.
    pub(super) hit: SmallVec<[usize; 4]>,
    /// Without loads and losses one of Newton's laws follows from the others: that of this impact, which must not lose its impulse.
    pub(super) left_out: usize,
    /// The orbit is its own mirror image in time: impacts are at 0 and half a period, and Newton's laws hold by themselves.
    pub(super) is_mirrored: bool,
    /// Modes next to a resonance whose states are unknowns, and the loads that drive them: numbers of modes of the structure and of harmonics.
    pub(super) open: Vec<OpenMode>,
    pub(super) driven: Vec<(usize, usize)>,
}

/// The rows that are to vanish, their derivatives, and what is made of them on the way.
#[derive(Debug, Clone)]
pub(super) struct System {
    pub(super) rows: Vector,
    /// Sizes of their terms, [`UNIT`] of which bounds their errors.
    ///
    /// [`UNIT`]: super::periodic_kernel::UNIT
    pub(super) sizes: Vector,
    pub(super) jacobian: Matrix,
    pub(super) arrivals: SmallVec<[Arrival; 4]>,
    /// Derivatives of the accelerations by the unknowns.
    pub(super) gradients: SmallVec<[Vector; 2]>,
}

impl<'a> Equations<'a> {
    /// Those of impacts at the contacts `hit`.
    pub(super) fn new(
        model: &'a LoadedStructure,
        force_periods: u32,
        hit: impl Iterator<Item = usize>,
    ) -> Result<Self, BreatherError> {
        if force_periods == 0 {
            return Err(BreatherError::Periods);
        }
        let structure = model.structure();
        let mut contacts: SmallVec<[usize; 4]> = hit.collect();
        contacts.sort_unstable();
        contacts.dedup();
        let response = model.response(&contacts, force_periods)?;
        let rigid = Drift::felt(structure, &contacts)?;
        let (forced, self_excited) = (response.fixed.forced, response.fixed.self_excited);
        if self_excited && force_periods > 1 {
            return Err(BreatherError::OwnPeriod { force_periods });
        }
        Ok(Self {
            model,
            response,
            rigid,
            forced,
            self_excited,
            hit: contacts,
            left_out: 0,
            is_mirrored: false,
            open: Vec::new(),
            driven: Vec::new(),
        })
    }

    /// What the same equations of another period answer.
    pub(super) fn at_period<T>(
        &self,
        period: f64,
        ask: impl FnOnce(&Equations<'_>) -> Result<T, BreatherError>,
    ) -> Result<T, BreatherError> {
        let model = self.model.at(TAU / period)?;
        let (response, rigid, hit) = (model.response(&self.hit, 1)?, self.rigid.clone(), self.hit.clone());
        ask(&Equations { model: &model, response, rigid, hit, ..self.clone() })
    }

    /// The periodic kernel.
    pub(super) fn kernel(&self) -> &PeriodicKernel {
        &self.response.kernel
    }

    /// Refuses impacts of `contacts` where the period is a whole number of that of a mode which they drive and nothing damps.
    pub(super) fn off_resonance(&self, contacts: &[usize]) -> Result<(), BreatherError> {
        let Some(mode) = self.kernel().resonant(contacts) else { return Ok(()) };
        let (frequency, omega) = (self.model.structure().modes()[mode].rate, TAU / self.period());
        let harmonic = (frequency / omega).round() as u32;
        Err(StructureError::Resonance { harmonic, mode, frequency, omega }.into())
    }

    pub(super) fn period(&self) -> f64 {
        self.kernel().period
    }

    /// 1/m of a contact.
    pub(super) fn mobility(&self, contact: usize) -> f64 {
        self.response.mobility(contact).unwrap_or_else(|| self.model.structure().mobility(contact, contact))
    }

    /// What a contact does to itself a period later: K, and 1/m + (1+e)K′.
    pub(super) fn own(&self, contact: usize) -> [f64; 2] {
        let (jet, _) = self.kernel().jet(contact, contact, 0.0);
        [jet[0], self.mobility(contact) + (1.0 + self.restitution(contact)) * jet[1]]
    }

    pub(super) fn restitution(&self, contact: usize) -> f64 {
        self.model.structure().contacts()[contact].restitution
    }

    /// g⁰ of a contact.
    pub(super) fn still(&self, contact: usize) -> f64 {
        self.response.still(contact)
    }

    /// Frequency of the only harmonic and ĝ of every contact; `None` of several or none.
    pub(super) fn single(&self) -> Option<(f64, &[C])> {
        self.response.single().filter(|_| self.forced)
    }

    /// Frequencies and ĝ of a contact.
    pub(super) fn swings(&self, contact: usize) -> impl Iterator<Item = (f64, C)> + '_ {
        self.response.swings(contact)
    }

    /// G of a contact, and its first three derivatives, at t + ψ.
    pub(super) fn load(&self, contact: usize, t: f64) -> [f64; 4] {
        self.response.load(contact, t)
    }

    /// The equations of orbits that are mirror images of themselves in time, with the point, if it is one: without loads and losses, all impacts at
    /// 0 and half a period. They stay regular where other orbits branch off.
    pub(super) fn of_mirrored(&self, point: &Point) -> Option<(Self, Point)> {
        let halves = self.are_halves(point.strikes.iter().map(|strike| strike.time))?;
        let (mut point, half) = (point.clone(), 0.5 * self.period());
        let times = halves.into_iter().map(|later| if later { half } else { 0.0 });
        point.strikes.iter_mut().zip(times).for_each(|(strike, time)| strike.time = time);
        Some((Self { is_mirrored: true, ..self.clone() }, point))
    }

    /// Of impacts without loads and losses that are all at 0 or half a period later, which are later; `None` of others.
    pub(super) fn are_halves(&self, times: impl Iterator<Item = f64>) -> Option<Vec<bool>> {
        let half = 0.5 * self.period();
        let later = |time: f64| {
            let centred = (time - half).abs() <= HALF * half;
            (centred || time.abs() <= HALF * half).then_some(centred)
        };
        if self.has_time() || !self.model.structure().is_lossless() { None } else { times.map(later).collect() }
    }

    /// Numbers of unknowns: impulses, times but the first, ψ if there is a load, the period if nothing gives it, offsets.
    pub(super) fn unknowns(&self, impacts: usize) -> usize {
        impacts + self.laws(impacts) + self.rigid.len() + 2 * self.open.len()
    }

    /// Number of Newton's laws that are asked for: as many as there are unknown times, phase and period among them.
    fn laws(&self, impacts: usize) -> usize {
        if self.is_mirrored { 0 } else { impacts - 1 + usize::from(self.has_time()) }
    }

    /// Place of the time of an impact among the unknowns of `impacts`.
    pub(super) fn time(&self, impacts: usize, i: usize) -> Option<usize> {
        (i > 0 && !self.is_mirrored).then(|| impacts + i - 1)
    }

    /// Place of ψ.
    pub(super) fn psi(&self, impacts: usize) -> Option<usize> {
        self.forced.then(|| 2 * impacts - 1)
    }

    /// Places of times, and of the phase or the period.
    pub(super) fn times(&self, impacts: usize) -> std::ops::Range<usize> {
        impacts..impacts + self.laws(impacts)
    }

    /// Whether ψ or the period is an unknown, behind the times; then no law follows from the others.
    pub(super) fn has_time(&self) -> bool {
        self.forced || self.self_excited
    }

    /// The row of Newton's law of an impact among `impacts`; `None` of the one that follows from the others.
    pub(super) fn row_of_law(&self, impacts: usize, i: usize) -> Option<usize> {
        let above = usize::from(!self.has_time() && i > self.left_out);
        let follows = self.is_mirrored || !self.has_time() && i == self.left_out;
        (!follows).then(|| impacts + i - above)
    }

    /// Offsets of all rigid modes.
    pub(super) fn all_offsets(&self, felt: &[f64]) -> SmallVec<[f64; 1]> {
        let count = self.model.structure().modes().iter().filter(|mode| mode.is_rigid()).count();
        let of = |mode: usize| self.rigid.iter().zip(felt).map(|(drift, offset)| drift.parts[mode] * offset).sum();
        (0..count).map(of).collect()
    }

    /// Of the offsets of all rigid modes what contacts of the orbit feel.
    pub(super) fn felt_offsets(&self, all: &[f64]) -> SmallVec<[f64; 1]> {
        let of = |drift: &Drift| drift.parts.iter().zip(all).map(|(part, offset)| part * offset).sum();
        self.rigid.iter().map(of).collect()
    }

    /// φ of a rigid mode at a contact.
    pub(super) fn shape(mode: &LinearMode, contact: usize) -> f64 {
        mode.rows[contact][0]
    }

    /// φᵀs of a rigid mode.
    pub(super) fn push(mode: &LinearMode) -> f64 {
        mode.still[1] * mode.rate
    }

    /// All of it at a point.
    pub(super) fn system(&self, point: &Point) -> Result<System, BreatherError> {
        if self.self_excited {
            self.at_period(point.period, |equations| equations.assembled(point))
        } else {
            self.assembled(point)
        }
    }

    /// The same where the period is that of the equations.
    fn assembled(&self, point: &Point) -> Result<System, BreatherError> {
        let (n, offsets) = (point.strikes.len(), self.rigid.len() + 2 * self.open.len());
        let size = self.unknowns(n);
        let mut system = System {
            rows: zeros(size),
            sizes: zeros(size),
            jacobian: Matrix::zeros(size),
            arrivals: SmallVec::new(),
            gradients: SmallVec::with_capacity(n),
        };
        let first_offset = size - offsets;
        let (time, psi) = (|i: usize| self.time(n, i), self.psi(n));
        let impulses: SmallVec<[f64; 4]> = point.strikes.iter().map(|strike| strike.impulse).collect();
        for (i, strike) in point.strikes.iter().enumerate() {
            self.model.heard()?;
            let stop = self.model.barrier(strike.contact, strike.barrier)?;
            let load = self.load(strike.contact, strike.time + point.psi);
            let mut sums = load;
            sums[0] += self.still(strike.contact);
            let mut sizes = self.response.load_sizes(strike.contact, strike.time + point.psi);
            sizes[0] += stop.abs();
            let mut jets: SmallVec<[[f64; 4]; 4]> = SmallVec::with_capacity(n);
            let mut by_period = [0.0; 3];
            for (j, other) in point.strikes.iter().enumerate() {
                let lapse = if i == j { 0.0 } else { strike.time - other.time };
                let (jet, terms) = self.kernel().jet(strike.contact, other.contact, lapse);
                sums.iter_mut().zip(jet).for_each(|(sum, derivative)| *sum += other.impulse * derivative);
                sizes.iter_mut().zip(terms).for_each(|(size, term)| *size += (other.impulse * term).abs());
                jets.push(jet);
                if self.self_excited {
                    let slopes = self.kernel().by_period(strike.contact, other.contact, lapse);
                    by_period.iter_mut().zip(slopes).for_each(|(sum, slope)| *sum += other.impulse * slope);
                }
            }
            // By unknown, of place, velocity and acceleration.
            let slopes = Slopes { impact: i, impulses: &impulses, jets: &jets, load: &load };
            let mut gradient = [0, 1, 2].map(|order| {
                let mut row = zeros(size);
                slopes.add(order, time, psi, &mut row);
                if self.self_excited {
                    row[2 * n - 1] = by_period[order];
                }
                row
            });
            for (place, drift) in self.rigid.iter().enumerate() {
                let shape = drift.shapes[strike.contact];
                sums[0] += shape * point.offsets[place];
                sizes[0] += (shape * point.offsets[place]).abs();
                gradient[0][first_offset + place] += shape;
            }
            self.add_open(point, i, (&mut sums, &mut sizes), &mut gradient);
            let [of_place, of_velocity, of_acceleration] = gradient;
            system.rows[i] = sums[0] - stop;
            system.sizes[i] = sizes[0];
            system.jacobian.row_mut(i).copy_from_slice(&of_place);
            let weight = 1.0 + self.restitution(strike.contact);
            if let Some(row) = self.row_of_law(n, i) {
                let mobility = self.mobility(strike.contact);
                system.rows[row] = strike.impulse * mobility + weight * sums[1];
                let doubt = self.response.mobility_error(strike.contact) / UNIT;
                system.sizes[row] = strike.impulse.abs() * (mobility + doubt) + weight * sizes[1];
                let line = system.jacobian.row_mut(row);
                line.iter_mut().zip(&of_velocity).for_each(|(entry, slope)| *entry = weight * slope);
                line[i] += mobility;
            }
            system.gradients.push(of_acceleration);
            system.arrivals.push(Arrival {
                place: sums[0],
                velocity: sums[1],
                acceleration: sums[2],
                jerk: sums[3],
                sizes,
            });
        }
        for (place, drift) in self.rigid.iter().enumerate() {
            let row = first_offset + place;
            let push = drift.push * self.period();
            system.rows[row] = push;
            system.sizes[row] = push.abs();
            if self.self_excited {
                system.jacobian[(row, 2 * n - 1)] = drift.push;
            }
            for (j, strike) in point.strikes.iter().enumerate() {
                let shape = drift.shapes[strike.contact];
                system.rows[row] += shape * strike.impulse;
                system.sizes[row] += (shape * strike.impulse).abs();
                system.jacobian[(row, j)] = shape;
            }
        }
        self.close_open(point, &mut system);
        Ok(system)
    }
}

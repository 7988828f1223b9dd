//! Tangent vectors of a structure's run: what becomes of small perturbations of its modes, to first order.
//!
//! **Flight** is linear: δξ flies as ξ does without loads, with contacts at rest held where they are.
//!
//! **Impact.** A contact that is off by δg arrives earlier by δg/g′⁻. Its impulse P moves the modes by bP and, through the dashpots, changes
//! their acceleration, so that with the state just before (m the effective mass, b the column of the contact)
//!
//! ```text
//! δξ⁺ = δξ⁻ − (1+e) m b δg′⁻ + [(1+e) m g″⁻ b + P A b] δg⁻/g′⁻ .
//! ```
//!
//! A b P is M⁻¹wP in the places, which makes δg⁺ = −e δg⁻, and −M⁻¹CM⁻¹wP in the velocities: the jump of the acceleration. Contacts that hit
//! at one instant keep this form each if neither sees the other's impulse; otherwise there is no linear map, as at a graze.
//!
//! An impact that takes another contact off its rest ends the force λ on it, too: −λ b δg/g′⁻ with the column of that one.
//!
//! **Rest.** A contact at rest has no perturbation: δg = δg′ = 0 from the event `stick` on. The instants of that and of its release count to
//! second order only, as for a chain ([`crate::Tangents`]).

use std::sync::Arc;

use super::flight::Flight;
use super::local_flight::LocalFlight;
use super::modal_flight::ModalFlight;
use super::motion::Motion;
use super::places::{Place, Places};
use super::series::Series;
use super::system::System;
use crate::cascade::Change;
use crate::directions::Directions;
use crate::error::TangentError;
use crate::event::EventKind;
use crate::watch::Contact;
use vibrochain_lattice::{Barrier, LinearMode, ModalStructure};

/// An impulse that another contact sees by less than this part of its terms is rounding.
const UNSEEN: f64 = 1e-12;

/// Small perturbations of a structure's run, carried along by [`StructureSimulation::run_with`](crate::StructureSimulation::run_with).
///
/// Lengths are Euclidean over the coordinates ξ of all modes; exponents do not depend on that.
///
/// ```
/// use vibrochain_eventsim::{Growth, Limits, StructureSimulation, StructureTangents};
/// use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape};
/// // q″ + 0.1 q′ + q = cos 2.325t with a stop at 0.1: its stable orbit has |μ|² = e² e^{−0.1 T}.
/// let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: 0.0 };
/// let mode = LinearMode::oscillator(0.05, 1.0 - 0.05 * 0.05, &shape, &[Complex::new(1.0, 0.0)]);
/// let stop = Contact { lower: None, upper: Some(0.1), restitution: 0.8 };
/// let structure = ModalStructure::new(vec![stop], vec![1], vec![mode])?;
/// let mut simulation = StructureSimulation::new(structure, 2.325, 0.0, &[[0.0, 0.0]])?;
/// let mut tangents = StructureTangents::random(simulation.structure(), 2, 7)?;
/// simulation.run(&Limits::until(simulation.time_of(100, 0.0)), |_| {});
/// simulation.run_with(&mut tangents, &Limits::until(simulation.time_of(140, 0.0)), |_| {})?;
/// let area: f64 = tangents.orthonormalise().iter().sum();
/// let period = std::f64::consts::TAU / 2.325;
/// assert!((area / 40.0 - 2.0 * 0.8f64.ln() + 0.1 * period).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct StructureTangents {
    inner: TangentVectors,
}

/// Tangent vectors of a system without loads.
#[derive(Debug, Clone)]
pub(crate) struct TangentVectors {
    /// Both coordinates of all modes of each vector; of a system known by its coordinates these and their velocities, in internal time.
    pub(crate) directions: Directions,
    system: System,
    /// What carries coordinates.
    flight: Option<Box<LocalFlight>>,
}

impl StructureTangents {
    /// `count` orthonormal vectors in random directions; the same seed gives the same ones.
    ///
    /// # Errors
    /// [`TangentError::Count`] if there are none, more than 4096 or more than two a mode.
    pub fn random(structure: &ModalStructure, count: usize, seed: u64) -> Result<Self, TangentError> {
        Ok(Self::with(structure, Directions::random(count, structure.modes().len(), seed)?))
    }

    /// Of given perturbations of the coordinates of all modes.
    ///
    /// # Errors
    /// [`TangentError::Count`], [`TangentError::Entries`].
    pub fn of(structure: &ModalStructure, vectors: &[Vec<[f64; 2]>]) -> Result<Self, TangentError> {
        let own = vectors.iter().map(|given| [0, 1].map(|i| given.iter().map(|xi| xi[i]).collect()));
        Ok(Self::with(structure, Directions::of(own.collect(), structure.modes().len())?))
    }

    fn with(structure: &ModalStructure, directions: Directions) -> Self {
        // The clock is the run's own: without loads any frequency will do.
        let system = System::new(Arc::new(structure.with_loads_times(0.0, 0.0)), 1.0, 0.0);
        Self { inner: TangentVectors { directions, system, flight: None } }
    }

    /// Number of vectors.
    pub fn count(&self) -> usize {
        self.inner.directions.vectors.len()
    }

    /// Vector `i` as it is now, if there are so many: as the flow has left it since it was given, or made orthonormal.
    pub fn vector(&self, i: usize) -> Option<Vec<[f64; 2]>> {
        let [first, second] = self.inner.directions.vectors.get(i)?;
        Some(first.iter().zip(second).map(|(a, b)| [*a, *b]).collect())
    }

    /// Whether the run has grazed a barrier, or contacts that see each other have hit at one instant: no linear map goes through that, and
    /// growth and vectors mean nothing.
    pub fn has_grazed(&self) -> bool {
        self.inner.directions.grazed
    }

    /// What [`StructureTangents::orthonormalise`] has told last.
    pub fn growth(&self) -> &[f64] {
        &self.inner.directions.logs
    }

    /// As [`Tangents::orthonormalise`](crate::Tangents::orthonormalise).
    pub fn orthonormalise(&mut self) -> &[f64] {
        self.inner.directions.orthonormalise()
    }

    /// The vectors on a run that is at `now` since its base.
    pub(crate) fn mount(&mut self, motion: &Motion, now: f64) -> Result<Riders<'_>, TangentError> {
        let is_alike = |(a, b): (&LinearMode, &LinearMode)| {
            (a.decay, a.rate, a.turn) == (b.decay, b.rate, b.turn) && a.rows == b.rows
        };
        let (own, other) = (&self.inner.system.structure, &motion.system.structure);
        let alike = own.as_ref().zip(other.as_ref()).is_some_and(|(own, other)| {
            own.contacts() == other.contacts()
                && own.modes().len() == other.modes().len()
                && own.modes().iter().zip(other.modes()).all(is_alike)
        });
        ensure_alike(alike)?;
        Ok(self.inner.mount(motion, now))
    }
}

fn ensure_alike(alike: bool) -> Result<(), TangentError> {
    if alike { Ok(()) } else { Err(TangentError::OtherModel) }
}

impl TangentVectors {
    /// Perturbations of coordinates that are given by their operator, without modes.
    pub(crate) fn of_system(system: System, directions: Directions) -> Self {
        let still = || vec![0.0; system.contacts()];
        let local = system.local.clone();
        let flight = local.map(|local| {
            let turned = system.loads.turned(0.0);
            Box::new(LocalFlight::new(&system, local, [still(), still()], turned))
        });
        Self { directions, system, flight }
    }

    /// Internal time over time.
    pub(crate) fn scale(&self) -> f64 {
        self.flight.as_ref().map_or(1.0, |flight| flight.local.scale)
    }

    /// The vectors on a run that is at `now` since its base.
    pub(crate) fn mount(&mut self, motion: &Motion, now: f64) -> Riders<'_> {
        let (at, resting) = (motion.clock.after(now), motion.places.resting().to_vec());
        let mut riders = Riders { tangents: self, at, resting, before: Vec::new(), forces: Vec::new() };
        riders.hold();
        riders
    }

    fn each(&mut self, mut change: impl FnMut(&System, &mut ModalFlight)) {
        let Self { directions, system, .. } = self;
        for [first, second] in &mut directions.vectors {
            let xi = first.iter().zip(&*second).map(|(a, b)| [*a, *b]).collect();
            let mut flight = ModalFlight::new(system, xi, 0.0);
            change(system, &mut flight);
            for (xi, (a, b)) in flight.xi.iter().zip(first.iter_mut().zip(second)) {
                [*a, *b] = *xi;
            }
        }
    }
}

/// Who is told of events while a run is under way.
pub(crate) trait Company {
    /// The run stands just before impacts at `now` since its base.
    fn arrive(&mut self, motion: &Motion, now: f64);

    /// They have been applied.
    fn meet(&mut self, motion: &Motion, changes: &[Change]);
}

/// Nobody.
pub(crate) struct Alone;

impl Company for Alone {
    fn arrive(&mut self, _: &Motion, _: f64) {}

    fn meet(&mut self, _: &Motion, _: &[Change]) {}
}

/// Tangent vectors on a run.
pub(crate) struct Riders<'a> {
    tangents: &'a mut TangentVectors,
    /// The clock at the instant of the vectors.
    at: (u64, f64),
    /// Contacts at rest since then.
    resting: Vec<usize>,
    /// Accelerations of the contacts that are due, and forces on all that rest, before their impacts.
    before: Vec<(usize, f64)>,
    forces: Vec<f64>,
}

impl Riders<'_> {
    /// Carries the vectors to `now` since the base.
    pub(crate) fn fly_to(&mut self, motion: &Motion, now: f64) {
        let left = now - motion.clock.until(self.at.0, self.at.1);
        self.at = motion.clock.after(now);
        if left <= 0.0 {
            return;
        }
        if let TangentVectors { flight: Some(flight), directions, .. } = &mut *self.tangents {
            for [place, velocity] in &mut directions.vectors {
                flight.drift([place, velocity], left, &self.resting);
            }
            return;
        }
        let held = |contact: usize| {
            let is_resting = self.resting.contains(&contact);
            // Which of its barriers says nothing of a motion without loads.
            let touch = if is_resting { Contact::Resting(Barrier::Upper) } else { Contact::Free };
            Place { touch, ..Place::free(0.0) }
        };
        let places = Places::of((0..motion.places.len()).map(held));
        let is_held = !self.resting.is_empty();
        self.tangents.each(|system, flight| {
            if !is_held {
                flight.xi = flight.all_at(system, left);
                return;
            }
            let mut rest = left;
            while rest > 0.0 {
                let series = Series::window(system, flight, &places);
                let step = rest.min(series.length);
                let xi = (0..flight.xi.len()).map(|k| series.mode(k, step / series.length)).collect();
                *flight = ModalFlight::new(system, xi, 0.0);
                rest -= step;
            }
        });
        self.hold();
    }

    /// Contacts at rest have no perturbation: what rounding leaves of one is taken off.
    fn hold(&mut self) {
        if self.resting.is_empty() {
            return;
        }
        if self.tangents.flight.is_some() {
            for part in self.tangents.directions.vectors.iter_mut().flatten() {
                self.resting.iter().for_each(|contact| part[*contact] = 0.0);
            }
            return;
        }
        let resting = std::mem::take(&mut self.resting);
        self.tangents.each(|system, flight| {
            let off = |of: &dyn Fn(usize) -> f64| resting.iter().map(|&contact| -of(contact)).collect::<Vec<_>>();
            let places = system.impulses(&resting, &off(&|contact| flight.place(system, contact)));
            for (&contact, amount) in resting.iter().zip(places) {
                flight.shift(system, contact, amount);
            }
            let velocities = system.impulses(&resting, &off(&|contact| flight.velocity(system, contact)));
            for (&contact, impulse) in resting.iter().zip(velocities) {
                flight.strike(system, contact, impulse);
            }
        });
        self.resting = resting;
    }

    /// Whether the place, the velocity or the acceleration of one contact changes with an impulse at another.
    fn sees(&self, to: usize, from: usize) -> bool {
        if let Some(flight) = &self.tangents.flight {
            return to == from || flight.local.operator.beside(to).contains(&from);
        }
        let (mut sums, mut sizes) = ([0.0; 2], [0.0; 2]);
        for mode in self.tangents.system.modes() {
            let (row, a) = (mode.rows[to], mode.generator());
            let once = mode.turn.act(a, mode.columns[from]);
            for (i, given) in [once, mode.turn.act(a, once)].into_iter().enumerate() {
                let terms = [row[0] * given[0], row[1] * given[1]];
                sums[i] += terms[0] + terms[1];
                sizes[i] += terms[0].abs() + terms[1].abs();
            }
        }
        (0..2).any(|i| sums[i].abs() > UNSEEN * sizes[i])
    }
}

impl Company for Riders<'_> {
    fn arrive(&mut self, motion: &Motion, now: f64) {
        self.fly_to(motion, now);
        self.before.clear();
        let due = motion.due.iter().filter(|due| !due.release);
        if motion.system.is_direct() || matches!(motion.flight, Flight::Local(_)) && motion.places.resting().is_empty()
        {
            self.before.extend(due.map(|due| (due.contact, motion.bends(due.contact)[0])));
            return;
        }
        self.forces = vec![0.0; motion.places.len()];
        // One that comes back to where it was let go is not leaving any more: its acceleration is what it is.
        let arrived = |place: &Place| match place.touch {
            Contact::Resting(_) => *place,
            _ => Place { touch: Contact::Free, ..*place },
        };
        let tendencies = motion.flight.tendencies(&motion.system, &Places::of(motion.places.iter().map(arrived)));
        self.before.extend(due.map(|due| (due.contact, tendencies.bends(due.contact)[0])));
        let resting = motion.places.resting().iter();
        resting.for_each(|contact| self.forces[*contact] = tendencies.force(*contact));
    }

    fn meet(&mut self, motion: &Motion, changes: &[Change]) {
        let hits: Vec<&Change> = changes.iter().filter(|change| change.kind == EventKind::Impact).collect();
        let released = changes.iter().filter(|change| change.kind == EventKind::Release);
        let released: Vec<usize> = released.map(|change| change.site).collect();
        // Of several impacts nobody says which one has released it.
        if hits.len() > 1 && !released.is_empty() {
            self.tangents.directions.grazed = true;
        }
        for (i, hit) in hits.iter().enumerate() {
            let together = hits[..i].iter().any(|other| {
                other.site == hit.site || self.sees(hit.site, other.site) || self.sees(other.site, hit.site)
            });
            if hit.before == 0.0 || together {
                self.tangents.directions.grazed = true;
                continue;
            }
            let before = self.before.iter().find(|(contact, _)| *contact == hit.site);
            let acceleration = before.map_or(0.0, |(_, acceleration)| *acceleration);
            let restitution = motion.system.restitution(hit.site);
            if let TangentVectors { flight: Some(flight), directions, .. } = &mut *self.tangents {
                let kick = (1.0 + restitution) * acceleration / (hit.before * flight.local.scale);
                let operator = &flight.local.operator;
                let felt = if operator.is_damped() { operator.beside(hit.site) } else { Vec::new() };
                for [place, velocity] in &mut directions.vectors {
                    let given = hit.force * place[hit.site] / (hit.before * operator.masses[hit.site]);
                    velocity[hit.site] = kick * place[hit.site] - restitution * velocity[hit.site];
                    place[hit.site] *= -restitution;
                    for &n in &felt {
                        let jump = operator.pull(n, true, |m| if m == hit.site { given } else { 0.0 });
                        velocity[n] -= jump / flight.local.scale;
                    }
                }
                continue;
            }
            let forces = &self.forces;
            self.tangents.each(|system, flight| {
                let (place, velocity) = (flight.place(system, hit.site), flight.velocity(system, hit.site));
                let earlier = place / hit.before;
                let change = (1.0 + restitution) * (acceleration * earlier - velocity);
                flight.strike(system, hit.site, system.impulse(hit.site, change));
                flight.shift(system, hit.site, hit.force * earlier);
                for &contact in &released {
                    flight.strike(system, contact, -forces[contact] * earlier);
                }
            });
        }
        self.resting.clear();
        self.resting.extend_from_slice(motion.places.resting());
        self.hold();
        self.tangents.directions.keep_apart();
    }
}

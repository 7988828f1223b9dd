//! What runs start from and what carries them: a breather of a chain with its simulation, or an orbit of a structure with its own.

use vibrochain_breather::{
    BreatherError, Orbit, StructureModel, StructureMotion, StructureOrbit, StructureOrbitError, Word,
};
use vibrochain_eventsim::{
    ContactEvent, Event, Limits, Outcome, Simulation, StructureOutcome, StructureSimulation, StructureTangents,
    Tangents, Time, Work,
};
use vibrochain_lattice::{Barrier, ModalStructure, Stop};

use crate::follow::{Expected, Track};
use crate::repeat::{Hit, word_of};
use crate::section::Strobe;
use crate::start::Start;

/// Lattices on which all directions at once are no work.
const FEW_MASSES: usize = 128;

/// How a run ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reached {
    /// At the time asked for.
    Time,
    /// Where it was told to stop.
    Stopped,
    /// Unresolved.
    Unresolved,
}

/// A run under way.
pub trait Run: Sized {
    /// What rides along.
    type Tangents: Riding;

    /// Now.
    fn time(&self) -> Time;

    /// Lets contacts that share coordinates and hit at one instant do so in sequence; masses of a chain share none.
    fn in_sequence(self) -> Self {
        self
    }

    /// So many periods of the force after the start.
    fn time_of(&self, periods: u64) -> Time;

    /// Goes on to its limits, with tangent vectors of its own model or without.
    fn advance(
        &mut self,
        tangents: Option<&mut Self::Tangents>,
        limits: &Limits,
        observe: &mut dyn FnMut(&Event),
    ) -> Option<(Reached, Work)>;
}

/// Small perturbations of a run.
pub trait Riding {
    /// Vector `i`, all numbers in a row.
    fn vector(&self, i: usize) -> Option<Vec<f64>>;

    /// Makes them orthonormal and tells the logarithms of their growth.
    fn orthonormalise(&mut self) -> &[f64];

    /// What that has told last.
    fn growth(&self) -> &[f64];

    /// Whether there is no linear map any more.
    fn has_grazed(&self) -> bool;
}

/// Whence runs start.
pub trait Origin: Clone + Send + Sync {
    /// What carries them.
    type Run: Run;

    /// The impacts of the orbit; none where runs start on no orbit.
    fn track(&self) -> Track;

    /// The time of the start on the orbit's clock, 0 or negative.
    fn time(&self) -> f64;

    /// A run that heeds `stop`, from a perturbation of a size drawn from a seed; `None`: nothing can start there.
    fn run(&self, perturbed: Option<(f64, u64)>, stop: &Stop) -> Option<Self::Run>;

    /// A tangent vector drawn from a seed.
    fn tangent(&self, seed: u64) -> Option<<Self::Run as Run>::Tangents>;

    /// Tangent vectors along every direction, and how many; `None` of too many.
    fn directions(&self) -> Option<(<Self::Run as Run>::Tangents, usize)>;

    /// The word of impacts that repeat, the same whichever of them comes first.
    fn word(&self, instants: Vec<Vec<Hit>>) -> Option<Word>;
}

/// A breather of a chain.
#[derive(Debug, Clone)]
pub struct Breather {
    pub(crate) orbit: Orbit,
    pub(crate) start: Start,
}

impl Breather {
    pub(crate) fn new(orbit: &Orbit) -> Result<Self, BreatherError> {
        Ok(Self { start: Start::on(orbit)?, orbit: orbit.clone() })
    }
}

impl Origin for Breather {
    type Run = Simulation;

    fn track(&self) -> Track {
        Track::of(&self.orbit)
    }

    fn time(&self) -> f64 {
        self.start.time
    }

    fn run(&self, perturbed: Option<(f64, u64)>, stop: &Stop) -> Option<Simulation> {
        let model = self.orbit.model();
        let mut start = self.start.clone();
        if let Some((size, seed)) = perturbed {
            start.perturb_at_random(model, size, seed);
        }
        let mut run = start.simulation(model).ok()?;
        run.heed(stop);
        Some(run)
    }

    fn tangent(&self, seed: u64) -> Option<Tangents> {
        Tangents::random(self.orbit.model(), 1, seed).ok()
    }

    fn directions(&self) -> Option<(Tangents, usize)> {
        let sites = self.orbit.model().chain().sites();
        if sites > FEW_MASSES {
            return None;
        }
        let unit = |i: usize| (0..sites).map(|n| f64::from(u8::from(n == i))).collect::<Vec<_>>();
        let units: Vec<_> = (0..2 * sites).map(|i| (unit(i), unit(i.wrapping_sub(sites)))).collect();
        Some((Tangents::of(self.orbit.model(), &units).ok()?, 2 * sites))
    }

    fn word(&self, instants: Vec<Vec<Hit>>) -> Option<Word> {
        let model = self.orbit.model();
        let layout = model.chain().layout();
        Some(word_of(instants, |site| layout.place(site))?.canonical(model))
    }
}

impl Run for Simulation {
    type Tangents = Tangents;

    fn time(&self) -> Time {
        Self::time(self)
    }

    fn time_of(&self, periods: u64) -> Time {
        Time::new(self.model(), periods, 0.0)
    }

    fn advance(
        &mut self,
        tangents: Option<&mut Tangents>,
        limits: &Limits,
        observe: &mut dyn FnMut(&Event),
    ) -> Option<(Reached, Work)> {
        let report = match tangents {
            Some(tangents) => self.run_with(tangents, limits, observe).ok()?,
            None => Self::run(self, limits, observe),
        };
        let ended = match report.outcome {
            Outcome::TimeReached => Reached::Time,
            Outcome::Stopped => Reached::Stopped,
            Outcome::ImpactsReached | Outcome::Cascade { .. } | Outcome::WorkLimit => Reached::Unresolved,
        };
        Some((ended, report.work))
    }
}

macro_rules! riding {
    ($tangents:ty, $joined:expr) => {
        impl Riding for $tangents {
            fn vector(&self, i: usize) -> Option<Vec<f64>> {
                Self::vector(self, i).map($joined)
            }

            fn orthonormalise(&mut self) -> &[f64] {
                Self::orthonormalise(self)
            }

            fn growth(&self) -> &[f64] {
                Self::growth(self)
            }

            fn has_grazed(&self) -> bool {
                Self::has_grazed(self)
            }
        }
    };
}

riding!(Tangents, |(u, v)| [u, v].concat());
riding!(StructureTangents, |modes| modes.into_iter().flatten().collect());

/// An orbit of a structure, or its rest under the static load.
#[derive(Debug, Clone)]
pub struct OfStructure {
    model: StructureModel,
    orbit: Option<StructureOrbit>,
    modes: Vec<[f64; 2]>,
    psi: f64,
    time: f64,
    in_sequence: bool,
}

impl OfStructure {
    /// Whether contacts that share coordinates and hit at one instant do so in sequence.
    pub(crate) fn in_sequence(self, in_sequence: bool) -> Self {
        Self { in_sequence, ..self }
    }

    pub(crate) fn on(orbit: &StructureOrbit) -> Result<Self, StructureOrbitError> {
        // In the middle of the flight before the first impact.
        let motion = StructureMotion::new(orbit)?;
        let last = orbit.impacts().len().saturating_sub(1);
        let lapse = 0.5 * motion.until_next(last);
        let time = orbit.impacts().get(last).map_or(0.0, |impact| impact.time) + lapse;
        let (psi, modes) = (orbit.psi().unwrap_or(0.0) + time, motion.modes(last, lapse)?);
        let model = orbit.model().clone();
        Ok(Self { model, modes, psi, time: time - orbit.period(), orbit: Some(orbit.clone()), in_sequence: false })
    }

    pub(crate) fn at_rest(model: &StructureModel) -> Self {
        Self::at(model, model.structure().still())
    }

    /// In any state, on no orbit, brought between the barriers.
    pub(crate) fn at(model: &StructureModel, modes: Vec<[f64; 2]>) -> Self {
        Self { model: model.clone(), orbit: None, modes, psi: 0.0, time: 0.0, in_sequence: false }
    }

    /// The instants at which the load is greatest, of a run.
    pub(crate) fn strobe(&self) -> Strobe {
        Strobe::of_period(self.model.period(), self.psi, 0.0)
    }
}

impl Origin for OfStructure {
    type Run = StructureSimulation;

    fn track(&self) -> Track {
        Track::of_structure(&self.model, self.orbit.as_ref())
    }

    fn time(&self) -> f64 {
        self.time
    }

    /// The size is the largest change of a contact's g, or of g′ over ω.
    fn run(&self, perturbed: Option<(f64, u64)>, stop: &Stop) -> Option<StructureSimulation> {
        let (structure, omega) = (&**self.model.structure(), self.model.omega());
        let mut modes = self.modes.clone();
        if let Some((size, seed)) = perturbed {
            let mut random = fastrand::Rng::with_seed(seed);
            let mut entries: Vec<[f64; 2]> = modes.iter().map(|_| [(); 2].map(|()| 2.0 * random.f64() - 1.0)).collect();
            let moved = |contact: usize| {
                let mut sums = [0.0; 2];
                for (mode, xi) in structure.modes().iter().zip(&entries) {
                    let rise = mode.turn.act(mode.generator(), *xi);
                    let row = mode.rows[contact];
                    sums[0] += row[0] * xi[0] + row[1] * xi[1];
                    sums[1] += (row[0] * rise[0] + row[1] * rise[1]) / omega;
                }
                sums[0].abs().max(sums[1].abs())
            };
            let largest = (0..structure.contacts().len()).map(moved).fold(f64::MIN_POSITIVE, f64::max);
            entries.iter_mut().flatten().for_each(|entry| *entry *= size / largest);
            modes.iter_mut().flatten().zip(entries.iter().flatten()).for_each(|(xi, entry)| *xi += entry);
        }
        if self.orbit.is_none() {
            move_inside(structure, &mut modes);
        }
        let mut run = StructureSimulation::new(structure.clone(), omega, self.psi, &modes).ok()?;
        run.heed(stop);
        Some(if self.in_sequence { run.in_sequence() } else { run })
    }

    fn tangent(&self, seed: u64) -> Option<StructureTangents> {
        StructureTangents::random(self.model.structure(), 1, seed).ok()
    }

    fn directions(&self) -> Option<(StructureTangents, usize)> {
        let modes = self.model.structure().modes().len();
        if modes > FEW_MASSES {
            return None;
        }
        let unit = |i: usize| {
            let entry = |k: usize, j: usize| f64::from(u8::from(2 * k + j == i));
            (0..modes).map(|k| [entry(k, 0), entry(k, 1)]).collect::<Vec<_>>()
        };
        let units: Vec<_> = (0..2 * modes).map(unit).collect();
        Some((StructureTangents::of(self.model.structure(), &units).ok()?, 2 * modes))
    }

    fn word(&self, instants: Vec<Vec<Hit>>) -> Option<Word> {
        let rotated = |by: usize| {
            let mut instants = instants.clone();
            instants.rotate_left(by);
            word_of(instants, |contact| (contact, 0))
        };
        (0..instants.len()).filter_map(rotated).min()
    }
}

impl Run for StructureSimulation {
    type Tangents = StructureTangents;

    fn time(&self) -> Time {
        Self::time(self)
    }

    fn in_sequence(self) -> Self {
        Self::in_sequence(self)
    }

    fn time_of(&self, periods: u64) -> Time {
        Self::time_of(self, periods, 0.0)
    }

    fn advance(
        &mut self,
        tangents: Option<&mut StructureTangents>,
        limits: &Limits,
        observe: &mut dyn FnMut(&Event),
    ) -> Option<(Reached, Work)> {
        let observe = |event: &ContactEvent| observe(&as_event(event));
        let report = match tangents {
            Some(tangents) => self.run_with(tangents, limits, observe).ok()?,
            None => Self::run(self, limits, observe),
        };
        let ended = match report.outcome {
            StructureOutcome::TimeReached => Reached::Time,
            StructureOutcome::Stopped => Reached::Stopped,
            _ => Reached::Unresolved,
        };
        Some((ended, report.work))
    }
}

/// Rounds in which contacts that are beyond a barrier are put onto it: those that share coordinates move each other.
const ROUNDS: usize = 100;

/// Moves modes as impulses would until no contact is beyond its barriers: where the structure at rest presses against stops it is held by them.
fn move_inside(structure: &ModalStructure, modes: &mut [[f64; 2]]) {
    for _ in 0..ROUNDS {
        let mut is_inside = true;
        for (number, contact) in structure.contacts().iter().enumerate() {
            let rows = structure.modes().iter().map(|mode| mode.rows[number]);
            let place: f64 = rows.zip(&*modes).map(|(row, xi)| row[0] * xi[0] + row[1] * xi[1]).sum();
            let (low, high) = (contact.lower.unwrap_or(f64::NEG_INFINITY), contact.upper.unwrap_or(f64::INFINITY));
            let off = place.clamp(low, high) - place;
            if off == 0.0 {
                continue;
            }
            is_inside = false;
            // A hair inside, or rounding would put it beyond.
            let amount = off * (1.0 + 1e-9) / structure.mobility(number, number);
            for (mode, xi) in structure.modes().iter().zip(&mut *modes) {
                let given = mode.turn.act(mode.generator(), mode.columns[number]);
                (0..2).for_each(|i| xi[i] += given[i] * amount);
            }
        }
        if is_inside {
            return;
        }
    }
}

/// An event of a contact as one of a site with its number.
fn as_event(event: &ContactEvent) -> Event {
    let &ContactEvent { time, contact: site, barrier, velocity_before, velocity_after, kind, .. } = event;
    Event { time, site, barrier, velocity_before, velocity_after, kind }
}

impl Track {
    /// Of an orbit of a structure; without one no impact is expected.
    pub(crate) fn of_structure(model: &StructureModel, orbit: Option<&StructureOrbit>) -> Self {
        let mut instants: Vec<Vec<Expected>> = Vec::new();
        for impact in orbit.iter().flat_map(|orbit| orbit.impacts()) {
            let (time, velocity, barrier): (f64, f64, Barrier) = (impact.time, impact.velocity_before, impact.barrier);
            let expected = Expected { site: impact.contact, barrier, time, velocity };
            match instants.last_mut().filter(|instant| instant.iter().all(|other| other.time == time)) {
                Some(instant) => instant.push(expected),
                None => instants.push(vec![expected]),
            }
        }
        let fastest = instants.iter().flatten().fold(0.0, |most: f64, one| most.max(one.velocity.abs()));
        let span = orbit.map_or(1, StructureOrbit::force_periods);
        Self {
            instants,
            fastest,
            period: model.period() * f64::from(span),
            unit: model.period(),
            span: span.into(),
            forced: model.structure().is_forced(),
        }
    }
}

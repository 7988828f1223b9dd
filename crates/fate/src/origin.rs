//! What runs start from: a breather of a chain, or an orbit of a structure, or its rest.

use vibrochain_breather::{BreatherError, ContactMotion, LoadedStructure, Orbit, Word};
use vibrochain_eventsim::{Simulation, Tangents};
use vibrochain_lattice::{Barrier, ModalStructure, Model, Stop};

use crate::follow::Track;
use crate::repeat::{Hit, word_of};
use crate::section::Strobe;
use crate::start::Start;

/// Masses, or modes, of which all directions at once are no work.
const FEW: usize = 128;

/// Whence runs start.
#[derive(Debug, Clone)]
pub struct Origin {
    state: State,
    /// Phase of the force at the start, as a time.
    psi: f64,
    /// The time of the start on the orbit's clock, 0 or negative.
    pub(crate) time: f64,
    in_sequence: bool,
}

/// A state of a model, and the orbit it is on.
#[derive(Debug, Clone)]
enum State {
    Masses { model: Box<Model>, orbit: Option<Box<Orbit>>, start: Start },
    Modes { model: LoadedStructure, orbit: Option<Box<Orbit>>, modes: Vec<[f64; 2]> },
}

impl Origin {
    /// On an orbit, in the middle of the flight before the first impact.
    pub(crate) fn on(orbit: &Orbit) -> Result<Self, BreatherError> {
        let known = Some(Box::new(orbit.clone()));
        let (state, psi, time) = match orbit.contacts() {
            None => {
                let start = Start::on(orbit)?;
                let (psi, time) = (start.psi, start.time);
                let model = Box::new(*orbit.lattice()?.model());
                (State::Masses { model, orbit: known, start }, psi, time)
            }
            Some(contacts) => {
                let motion = ContactMotion::new(contacts)?;
                let last = orbit.impacts().len().saturating_sub(1);
                let lapse = 0.5 * motion.until_next(last);
                let time = orbit.impacts().get(last).map_or(0.0, |impact| impact.time) + lapse;
                let (psi, modes) = (orbit.psi().unwrap_or(0.0) + time, motion.modes(last, lapse)?);
                (State::Modes { model: contacts.model().clone(), orbit: known, modes }, psi, time - orbit.period())
            }
        };
        Ok(Self { state, psi, time, in_sequence: false })
    }

    /// A chain in any state, on no orbit, at phase 0 of the force; brought between the barriers.
    pub(crate) fn of_masses(model: &Model, mut displacement: Vec<f64>, velocity: Vec<f64>) -> Self {
        let [low, high] = [Barrier::Lower, Barrier::Upper].map(|barrier| model.barrier(barrier));
        displacement.iter_mut().for_each(|u| *u = u.clamp(low, high));
        let start = Start { displacement, velocity, psi: 0.0, time: 0.0 };
        Self {
            state: State::Masses { model: Box::new(*model), orbit: None, start },
            psi: 0.0,
            time: 0.0,
            in_sequence: false,
        }
    }

    /// A structure at rest under its static load.
    pub(crate) fn at_rest(model: &LoadedStructure) -> Self {
        Self::at(model, model.structure().still())
    }

    /// A structure in any state, on no orbit, brought between the barriers.
    pub(crate) fn at(model: &LoadedStructure, modes: Vec<[f64; 2]>) -> Self {
        let state = State::Modes { model: model.clone(), orbit: None, modes };
        Self { state, psi: 0.0, time: 0.0, in_sequence: false }
    }

    /// Whether contacts that share coordinates and hit at one instant do so in sequence; masses of a chain share none.
    pub(crate) fn in_sequence(self, in_sequence: bool) -> Self {
        Self { in_sequence, ..self }
    }

    /// The impacts of the orbit; none where runs start on no orbit.
    pub(crate) fn track(&self) -> Track {
        match &self.state {
            State::Masses { orbit: Some(orbit), .. } | State::Modes { orbit: Some(orbit), .. } => Track::of(orbit),
            State::Masses { model, orbit: None, .. } => Track::none(model.period(), model.amplitude() > 0.0),
            State::Modes { model, orbit: None, .. } => Track::none(model.period(), model.structure().is_forced()),
        }
    }

    /// The instants at which the load is greatest, of a run.
    pub(crate) fn strobe(&self) -> Strobe {
        let period = match &self.state {
            State::Masses { model, .. } => model.period(),
            State::Modes { model, .. } => model.period(),
        };
        Strobe::of_period(period, self.psi, 0.0)
    }

    /// A run that heeds `stop`, from a perturbation of a size drawn from a seed; `None`: nothing can start there. Of a structure the size is
    /// the largest change of a contact's g, or of g′ over ω.
    pub(crate) fn run(&self, perturbed: Option<(f64, u64)>, stop: &Stop) -> Option<Simulation> {
        let run = match &self.state {
            State::Masses { model, start, .. } => {
                let mut start = start.clone();
                if let Some((size, seed)) = perturbed {
                    start.perturb_at_random(model, size, seed);
                }
                start.simulation(model)
            }
            State::Modes { model, orbit, modes } => {
                let (structure, omega) = (model.structure(), model.omega());
                let mut modes = modes.clone();
                if let Some((size, seed)) = perturbed {
                    perturb_modes(structure, omega, &mut modes, (size, seed));
                }
                if orbit.is_none() {
                    move_inside(structure, &mut modes);
                }
                Simulation::of_modes(structure.clone(), omega, self.psi, &modes)
            }
        };
        let mut run = run.ok()?;
        run.heed(stop);
        Some(if self.in_sequence { run.in_sequence() } else { run })
    }

    /// The word of impacts that repeat, the same whichever of them comes first.
    pub(crate) fn word(&self, instants: Vec<Vec<Hit>>) -> Option<Word> {
        if let State::Masses { model, .. } = &self.state {
            let layout = model.chain().layout();
            return Some(word_of(instants, |site| layout.place(site))?.canonical(model));
        }
        let rotated = |by: usize| {
            let mut instants = instants.clone();
            instants.rotate_left(by);
            word_of(instants, |contact| (contact, 0))
        };
        (0..instants.len()).filter_map(rotated).min()
    }
}

/// Tangent vectors along every direction of a run, and how many; `None` of too many.
pub(crate) fn directions(run: &Simulation) -> Option<(Tangents, usize)> {
    let state = run.state();
    let size = if state.modes.is_empty() { state.displacement.len() } else { state.modes.len() };
    if size > FEW {
        return None;
    }
    let unit = |i: usize| (0..size).map(|n| f64::from(u8::from(n == i))).collect::<Vec<_>>();
    let units: Vec<_> = (0..2 * size).map(|i| [unit(i), unit(i.wrapping_sub(size))]).collect();
    Some((run.tangents_along(&units).ok()?, 2 * size))
}

/// Adds a perturbation whose largest change of a contact's g, or of g′ over ω, is `size`.
fn perturb_modes(structure: &ModalStructure, omega: f64, modes: &mut [[f64; 2]], (size, seed): (f64, u64)) {
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

//! Tangent vectors: what becomes of small perturbations of a run, to first order and without a step size.
//!
//! **Flight** is linear, so that a perturbation flies as the structure does without loads, with contacts at rest held where they are: a lattice
//! by its series ([`crate::series`]), in steps as long as their remainder allows, other structures by their modes.
//!
//! **Impact.** A contact that is off by δg arrives earlier by δg/g′⁻. Its impulse P moves the coordinates, or modes, by bP and, through the
//! dashpots, changes their acceleration, so that with the state just before (m the effective mass, b the column of the contact)
//!
//! ```text
//! δξ⁺ = δξ⁻ − (1+e) m b δg′⁻ + [(1+e) m g″⁻ b + P A b] δg⁻/g′⁻ .
//! ```
//!
//! A b P is M⁻¹wP in the places, which makes δg⁺ = −e δg⁻, and −M⁻¹CM⁻¹wP in the velocities: the jump of the acceleration. Of a mass of its own
//! with the acceleration α, without dashpots,
//!
//! ```text
//! δu⁺ = −e δu⁻ ,      δv⁺ = −e δv⁻ + (1+e) (α/v⁻) δu⁻ .
//! ```
//!
//! Contacts that hit at one instant keep this form each if neither sees the other's impulse; otherwise there is no linear map, as at a graze,
//! g′⁻ = 0, and the vectors say so from then on. An impact that takes another contact off its rest ends the force λ on it, too: −λ b δg/g′⁻
//! with the column of that one.
//!
//! **Rest.** A contact at rest is where its barrier is and has no velocity, whatever is done to the others: δg = δg′ = 0 from the event
//! `stick` on. The instants of that and of its release move with the perturbation, but velocity (and at the release acceleration, too)
//! vanishes there, so that they count to second order only.

use std::sync::Arc;

use crate::directions::Directions;
use crate::error::TangentError;
use crate::flight::local_flight::LocalFlight;
use crate::flight::modal_flight::ModalFlight;
use crate::flight::system::System;

/// Tangent vectors of a run: small perturbations of its state, carried along by [`Simulation::run_with`](crate::Simulation::run_with).
///
/// [`Simulation::tangents`](crate::Simulation::tangents) makes them. They belong to a model, not to a simulation: taken off one that has ended
/// they ride on with the next, from the state in which it is. A vector is two lists: displacements and velocities of all masses of a chain, or
/// the first and the second of the coordinates ξ of all modes of a structure. Lengths are Euclidean over both, velocities in internal units (of
/// a rate between half of the lattice's fastest and that); exponents do not depend on that.
///
/// ```
/// use vibrochain_eventsim::{Growth, Limits, Simulation};
/// use vibrochain_lattice::{Chain, Model};
///
/// // A hot ring is chaotic.
/// let model = Model::conservative(Chain::new(5, 0.2, 0.1)?, 1.5, 0.4)?;
/// let mut simulation = Simulation::new(&model, 0.0, &[0.0; 5], &[2.0, -1.0, 1.5, 0.5, -0.5])?;
/// let mut tangents = simulation.tangents(1, 7)?;
/// let mut growth = Growth::default();
/// for period in 1..=200 {
///     simulation.run_with(&mut tangents, &Limits::until(simulation.time_of(period, 0.0)), |_| {})?;
///     growth.reach(simulation.time().to_f64(), tangents.orthonormalise()[0]);
/// }
/// let exponent = growth.exponent().ok_or("no exponent")?;
/// assert!(exponent.value > 5.0 * exponent.error, "{exponent:?}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// ```
/// use vibrochain_eventsim::{Limits, Simulation};
/// use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape};
/// // q″ + 0.1 q′ + q = cos 2.325t with a stop at 0.1: its stable orbit has |μ|² = e² e^{−0.1 T}.
/// let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: 0.0 };
/// let mode = LinearMode::oscillator(0.05, 1.0 - 0.05 * 0.05, &shape, &[Complex::new(1.0, 0.0)]);
/// let stop = Contact { lower: None, upper: Some(0.1), restitution: 0.8 };
/// let structure = ModalStructure::new(vec![stop], vec![1], vec![mode])?;
/// let mut simulation = Simulation::of_modes(structure, 2.325, 0.0, &[[0.0, 0.0]])?;
/// let mut tangents = simulation.tangents(2, 7)?;
/// simulation.run(&Limits::until(simulation.time_of(100, 0.0)), |_| {});
/// simulation.run_with(&mut tangents, &Limits::until(simulation.time_of(140, 0.0)), |_| {})?;
/// let area: f64 = tangents.orthonormalise().iter().sum();
/// let period = std::f64::consts::TAU / 2.325;
/// assert!((area / 40.0 - 2.0 * 0.8f64.ln() + 0.1 * period).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Tangents {
    /// Coordinates and their velocities in internal time; of a system with modes both coordinates of each.
    pub(crate) directions: Directions,
    /// Without loads, or flying without them.
    pub(crate) system: System,
    /// What carries coordinates.
    pub(crate) flight: Option<Box<LocalFlight>>,
}

impl Tangents {
    /// Random directions of a run of `system`.
    pub(crate) fn random(system: &System, count: usize, seed: u64) -> Result<Self, TangentError> {
        Ok(Self::with(system, Directions::random(count, system.size(), seed)?))
    }

    /// Given directions.
    pub(crate) fn along(system: &System, vectors: &[[Vec<f64>; 2]]) -> Result<Self, TangentError> {
        let mut tangents = Self::with(system, Directions::of(vectors.to_vec(), system.size())?);
        let scale = tangents.scale();
        let velocities = tangents.directions.vectors.iter_mut().flat_map(|[_, v]| v);
        velocities.for_each(|v| *v /= scale);
        Ok(tangents)
    }

    fn with(system: &System, directions: Directions) -> Self {
        if let Some(structure) = &system.structure {
            // The clock is the run's own: without loads any frequency will do.
            let system = System::new(Arc::new(structure.with_loads_times(0.0, 0.0)), 1.0, 0.0);
            return Self { directions, system, flight: None };
        }
        let system = system.clone();
        let still = || vec![0.0; system.size()];
        let flight = system.local.clone().map(|local| {
            let turned = system.loads.turned(0.0);
            Box::new(LocalFlight::new(&system, local, [still(), still()], turned))
        });
        Self { directions, system, flight }
    }

    /// Internal time over time.
    fn scale(&self) -> f64 {
        self.flight.as_ref().map_or(1.0, |flight| flight.local.scale)
    }

    /// Number of vectors.
    pub fn count(&self) -> usize {
        self.directions.vectors.len()
    }

    /// Both lists of vector `i` as it is now, if there are so many: as the flow has left it since it was given, or made orthonormal.
    pub fn vector(&self, i: usize) -> Option<[Vec<f64>; 2]> {
        let [first, second] = self.directions.vectors.get(i)?;
        Some([first.clone(), second.iter().map(|v| v * self.scale()).collect()])
    }

    /// Whether the run has grazed a barrier, or contacts that see each other have hit at one instant: no linear map goes through that, and
    /// growth and vectors mean nothing.
    pub fn has_grazed(&self) -> bool {
        self.directions.grazed
    }

    /// What [`Tangents::orthonormalise`] has told last; zeros if the vectors have not been made orthonormal yet, by that or on the way.
    pub fn growth(&self) -> &[f64] {
        &self.directions.logs
    }

    /// Makes the vectors orthonormal, in their order, and tells the logarithm of what each direction has grown since the
    /// beginning: of the first the length, of the first two the area, and so on, are their sums. −∞ where rest has taken all
    /// of a direction.
    ///
    /// A vector that outgrows the others 10⁸ times is seen to on the way.
    pub fn orthonormalise(&mut self) -> &[f64] {
        self.directions.orthonormalise()
    }

    /// Changes all vectors as flights by modes.
    pub(crate) fn each(&mut self, mut change: impl FnMut(&System, &mut ModalFlight)) {
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

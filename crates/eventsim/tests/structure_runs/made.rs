//! Structures and runs that several tests make.

use nalgebra::{DMatrix, DVector};
use vibrochain_eventsim::{Limits, Simulation};
use vibrochain_lattice::{Complex, Contact, Structure};

pub(crate) fn harmonic(load: &DVector<f64>) -> Vec<(u32, DVector<Complex<f64>>)> {
    if load.iter().all(|f| *f == 0.0) { vec![] } else { vec![(1, load.map(|f| Complex::new(f, 0.0)))] }
}

/// The energy, of modes of real shape.
pub(crate) fn energy(simulation: &Simulation) -> f64 {
    simulation.structure().unwrap().energy_form().unwrap().energy(&simulation.state().modes)
}

pub(crate) fn balanced(simulation: Simulation) -> Simulation {
    simulation.with_balance(None)
}

/// A simulation from q, q′.
pub(crate) fn started(structure: &Structure, omega: f64, psi: f64, q: &DVector<f64>, v: &DVector<f64>) -> Simulation {
    let modal = structure.modal().unwrap();
    let xi = structure.project(&modal, q, v).unwrap();
    Simulation::of_modes(modal, omega, psi, &xi).unwrap()
}

pub(crate) fn until(simulation: &Simulation, periods: u64, part: f64) -> Limits {
    Limits { until: Some(simulation.time_of(periods, part)), ..Limits::default() }
}

pub(crate) fn contact(
    weights: &[f64],
    lower: Option<f64>,
    upper: Option<f64>,
    restitution: f64,
) -> (DVector<f64>, Contact) {
    (DVector::from_column_slice(weights), Contact { lower, upper, restitution })
}

/// A light damped structure, pressed and driven, with contacts that chatter, rest and let go.
pub(crate) fn pressed() -> Structure {
    Structure {
        mass: DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 2.0, 0.5])),
        damping: DMatrix::from_row_slice(3, 3, &[0.2, -0.02, 0.0, -0.02, 0.04, -0.02, 0.0, -0.02, 0.04]),
        stiffness: DMatrix::from_row_slice(3, 3, &[2.0, -1.0, 0.0, -1.0, 3.0, -1.0, 0.0, -1.0, 2.0]),
        contacts: vec![
            contact(&[1.0, 0.0, 0.0], Some(-0.4), Some(0.3), 0.5),
            contact(&[0.0, 0.0, 1.0], None, Some(0.1), 0.2),
        ],
        static_load: DVector::from_vec(vec![0.0, 0.0, 0.6]),
        loads: harmonic(&DVector::from_vec(vec![1.0, 0.4, -0.7])),
        modes: None,
    }
}

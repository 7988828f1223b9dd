//! Bifurcation points against simulations that know nothing of them: multipliers by finite differences of a return map,
//! impacts counted by the event-driven simulation.

use vibrochain::breather::{Family, Motion, Orbit, breathers};
use vibrochain::eventsim::{Limits, Simulation, Time};
use vibrochain::floquet::{Complex, Event, Evidence, Located, Search, locate};
use vibrochain::lattice::{Model, Parameter, Point};
use vibrochain_testkit::ReturnMap;

fn model(gamma: (f64, f64), omega: f64, asymmetry: f64, force: (f64, f64)) -> Model {
    let ring = Point::ring(21).gamma1(gamma.0).gamma2(gamma.1);
    ring.omega(omega).asymmetry(asymmetry).amplitude(force.0).restitution(force.1).model().unwrap()
}

fn first(model: &Model, family: Family, event: Event, free: Parameter, range: (f64, f64)) -> Located {
    let orbit = &breathers(model, family).unwrap().orbits[0];
    let search = Search { event, free, from: range.0, to: range.1 };
    locate(orbit, &search).unwrap().located.swap_remove(0)
}

/// The eigenvalue of the return map's Jacobian nearest to `goal`.
fn simulated(orbit: &Orbit, goal: Complex<f64>) -> Complex<f64> {
    let values = ReturnMap::new(orbit).jacobian().complex_eigenvalues();
    let nearest = values.iter().min_by(|a, b| (*a - goal).norm().total_cmp(&(*b - goal).norm()));
    *nearest.unwrap()
}

#[test]
fn multipliers_of_a_simulated_return_map_meet_the_circle() {
    let doubling = first(
        &model((0.2, 0.1), 1.07, 0.8, (0.165, 0.25)),
        Family::SingleSided,
        Event::PeriodDoubling,
        Parameter::Amplitude,
        (0.15, 0.2),
    );
    let minus = Complex::new(-1.0, 0.0);
    assert!((simulated(&doubling.orbit, minus) - minus).norm() < 1e-7);

    let pitchfork = first(
        &model((0.1, 0.05), 1.33, 0.0, (1.5, 0.5)),
        Family::DoubleSided,
        Event::Pitchfork,
        Parameter::Restitution,
        (0.4, 0.7),
    );
    let plus = Complex::new(1.0, 0.0);
    assert!((simulated(&pitchfork.orbit, plus) - plus).norm() < 1e-6);

    let circle = first(
        &model((0.2, 0.085), 0.92, 0.7, (0.05, 0.9)),
        Family::SingleSided,
        Event::NeimarkSacker,
        Parameter::Gamma2,
        (0.08, 0.09),
    );
    let Evidence::Multiplier(multiplier) = circle.evidence else { panic!("{:?}", circle.evidence) };
    let found = simulated(&circle.orbit, multiplier);
    assert!((found.norm() - 1.0).abs() < 1e-7 && (found - multiplier).norm() < 1e-6, "{found} {multiplier}");
}

/// Impacts in three periods of a simulation that starts on the orbit.
fn impacts(orbit: &Orbit) -> usize {
    let start = 0.5 * (orbit.impacts().last().unwrap().time - orbit.period());
    let mut motion = Motion::of(orbit).unwrap();
    motion.at(0, start);
    let masses: Vec<_> = (0..motion.sites()).map(|n| motion.site(n)).collect();
    let displacement: Vec<f64> = masses.iter().map(|mass| mass.displacement).collect();
    let velocity: Vec<f64> = masses.iter().map(|mass| mass.velocity).collect();
    let psi = orbit.psi().unwrap() + start;
    let mut simulation = Simulation::new(orbit.model().unwrap(), psi, &displacement, &velocity).unwrap();
    simulation.collect(&Limits::until(Time::new(orbit.model().unwrap(), 3, 0.0))).1.len()
}

#[test]
fn a_simulation_hits_the_far_barrier_beyond_grazing_only() {
    let start = model((0.2, 0.1), 0.92, 0.4, (0.1, 0.9));
    let grazing = first(&start, Family::SingleSided, Event::Grazing, Parameter::Omega, (0.9, 0.95));
    let at = |omega: f64| breathers(&start.with(Parameter::Omega, omega).unwrap(), Family::SingleSided).unwrap();
    // The excess beyond the barrier is about 7 times the distance in ω; impacts are seen down to rounding.
    for distance in [1e-6, 1e-9, 1e-11] {
        assert_eq!(impacts(&at(grazing.value - distance).orbits[0]), 3, "{distance}");
        assert!(impacts(&at(grazing.value + distance).orbits[0]) > 3, "{distance}");
    }
}

//! Breathers under forces of several harmonics against the event-driven simulation: closure, impacts, multipliers.

use nalgebra::{DMatrix, DVector};
use vibrochain::breather::{Family, Motion, Orbit, admissibility, breathers};
use vibrochain::eventsim::{EventKind, Limits, Outcome, Simulation, Time};
use vibrochain::floquet::{full_monodromy, leading_modes};
use vibrochain::lattice::{Force, Harmonic, Model, Point};
use vibrochain_testkit::ReturnMap;

fn force(terms: &[(u32, f64, f64)]) -> Force {
    let harmonic = |&(number, amplitude, phase): &(u32, f64, f64)| Harmonic { number, amplitude, phase };
    Force::new(&terms.iter().map(harmonic).collect::<Vec<_>>()).unwrap()
}

/// The first three harmonics of a square wave, A, −A/3, A/5.
fn square(amplitude: f64) -> Force {
    force(&[(1, amplitude, 0.0), (3, -amplitude / 3.0, 0.0), (5, amplitude / 5.0, 0.0)])
}

fn models() -> Vec<(Model, Family)> {
    let model = |sites, omega, a, force: &Force, e| {
        let ring = Point::ring(sites).gamma1(0.2).gamma2(0.1);
        ring.omega(omega).asymmetry(a).under(force).restitution(e).model().unwrap()
    };
    // All three families, elastic and not, symmetric and not; phases; a force without the first harmonic.
    let skew = force(&[(1, 0.1, 0.6), (3, 0.05, -2.0), (7, 0.2, 1.0)]);
    vec![
        (model(21, 1.5, 0.4, &square(0.1), 0.9), Family::DoubleSided),
        (model(5, 1.5, 0.4, &square(0.9), 1.0), Family::DoubleSided),
        (model(8, 1.33, 0.0, &square(1.5), 0.6), Family::DoubleSided),
        (model(5, 1.5, 0.4, &skew, 0.9), Family::DoubleSided),
        (model(5, 0.5, 0.2, &force(&[(3, 1.5, 0.4)]), 0.95), Family::DoubleSided),
        (model(21, 0.92, 0.4, &square(0.1), 0.9), Family::SingleSided),
        (model(6, 0.92, 0.4, &square(0.1), 1.0), Family::SingleSided),
        (model(5, 0.92, 0.4, &skew, 0.9), Family::SingleSided),
        (
            model(21, 1.07, 0.8, &force(&[(1, 0.1582, 0.0), (3, -0.002, 0.0), (5, 0.001, 0.0)]), 0.25),
            Family::PeriodDoubled,
        ),
    ]
}

/// Sees every physical orbit of the models; returns how many of each family there were.
fn each_physical(mut see: impl FnMut(&Orbit, &str)) -> [usize; 3] {
    let mut families = [0; 3];
    for (i, (model, family)) in models().into_iter().enumerate() {
        let found = breathers(&model, family).unwrap();
        assert_eq!(found.completeness.open(), (0, 0), "model {i}");
        for (k, orbit) in found.orbits.iter().enumerate() {
            assert!(orbit.residual() < 1e-13, "model {i}: {}", orbit.residual());
            if admissibility(orbit).unwrap().is_physical() {
                families[family as usize] += 1;
                see(orbit, &format!("model {i} orbit {k}"));
            }
        }
    }
    families
}

fn state(motion: &mut Motion, t: f64) -> DVector<f64> {
    motion.at(0, t);
    let m = motion.sites();
    let entries = (0..m).map(|n| motion.site(n).displacement).chain((0..m).map(|n| motion.site(n).velocity));
    DVector::from_iterator(2 * m, entries)
}

/// From the middle of the orbit's last flight over one of its periods.
fn simulate(orbit: &Orbit, point: &DVector<f64>, see: impl FnMut(f64, usize, f64)) -> DVector<f64> {
    let start = 0.5 * (orbit.impacts().last().unwrap().time - orbit.period());
    let (u, v) = point.as_slice().split_at(point.len() / 2);
    let mut simulation = Simulation::new(orbit.model().unwrap(), orbit.psi().unwrap() + start, u, v).unwrap();
    let mut see = see;
    let until = Time::new(orbit.model().unwrap(), u64::from(orbit.force_periods()), 0.0);
    let report = simulation.run(&Limits::until(until), |event| {
        assert_eq!(event.kind, EventKind::Impact);
        see(event.time.to_f64() + start, event.contact, event.velocity_before);
    });
    assert_eq!(report.outcome, Outcome::TimeReached);
    let end = simulation.state();
    DVector::from_iterator(point.len(), end.displacement.iter().chain(&end.velocity).copied())
}

#[test]
fn every_physical_orbit_closes_with_its_own_impacts_and_no_others() {
    let families = each_physical(|orbit, name| {
        let start = 0.5 * (orbit.impacts().last().unwrap().time - orbit.period());
        let point = state(&mut Motion::of(orbit).unwrap(), start);
        let growth = leading_modes(orbit, 1).unwrap()[0].multiplier.norm().max(1.0);
        let mut hits = Vec::new();
        let end = simulate(orbit, &point, |time, site, before| hits.push((time, site, before)));
        assert_eq!(hits.len(), orbit.impacts().len(), "{name}");
        for ((time, site, before), impact) in hits.iter().zip(orbit.impacts()) {
            assert_eq!(*site, impact.site, "{name}");
            assert!((time - impact.time).abs() < 1e-12 * growth, "{name}: {time} {}", impact.time);
            assert!((before - impact.velocity_before).abs() < 1e-12 * growth, "{name}");
        }
        let closure = (end - point).amax();
        assert!(closure < 1e-11, "{name}: closes to {closure:e}");
    });
    assert!(families.iter().all(|&count| count > 0) && families[0] >= 4, "{families:?}");
}

#[test]
fn multipliers_are_those_of_the_simulated_return_map() {
    let mut compared = 0;
    each_physical(|orbit, name| {
        let slowest = orbit.impacts().iter().map(|impact| impact.velocity_before.abs()).fold(1.0, f64::min);
        // Differences of a map next to grazing lose their digits before they see its slope.
        if orbit.model().unwrap().chain().sites() > 8 || slowest < 0.02 {
            return;
        }
        compared += 1;
        let start = 0.5 * (orbit.impacts().last().unwrap().time - orbit.period());
        let point = state(&mut Motion::of(orbit).unwrap(), start);
        let (n, h) = (point.len(), 1e-4 * slowest * slowest);
        let mut jacobian = DMatrix::zeros(n, n);
        for j in 0..n {
            let slope = |h: f64| {
                let (mut plus, mut minus) = (point.clone(), point.clone());
                plus[j] += h;
                minus[j] -= h;
                (simulate(orbit, &plus, |_, _, _| {}) - simulate(orbit, &minus, |_, _, _| {})) / (2.0 * h)
            };
            jacobian.set_column(j, &((4.0 * slope(0.5 * h) - slope(h)) / 3.0));
        }
        let matrix = full_monodromy(orbit).unwrap();
        let found = jacobian.complex_eigenvalues();
        for mu in matrix.complex_eigenvalues().iter() {
            let nearest = found.iter().map(|other| (mu - other).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-6 * mu.norm().max(1.0), "{name}: {mu} {nearest:e}");
        }
    });
    assert!(compared >= 4, "{compared}");
}

#[test]
fn monodromy_matrices_are_those_of_a_return_map_that_shares_nothing() {
    let mut compared = 0;
    // Not only the physical ones: the map follows the orbit's own impacts.
    for (i, (model, family)) in models().into_iter().enumerate() {
        for orbit in &breathers(&model, family).unwrap().orbits {
            let map = ReturnMap::new(orbit);
            if map.slowest_impact() < 0.02 {
                continue;
            }
            compared += 1;
            let point = map.fixed_point();
            let closure = (map.apply(&point) - &point).amax();
            assert!(closure < 1e-11, "model {i}: closes to {closure:e}");
            let lead = map.ring.flow(-map.start);
            let matrix = full_monodromy(orbit).unwrap();
            let difference = (&matrix * &lead - &lead * map.jacobian()).amax();
            assert!(difference < 1e-7 * matrix.amax().max(1.0), "model {i}: {difference:e}");
        }
    }
    assert!(compared >= 12, "{compared}");
}

#[test]
fn margins_are_those_of_a_dense_sample() {
    let mut crossings = 0;
    for (i, (model, family)) in models().into_iter().enumerate() {
        for orbit in &breathers(&model, family).unwrap().orbits {
            let admissibility = admissibility(orbit).unwrap();
            let Some(margin) = admissibility.margin else { continue };
            crossings += usize::from(!admissibility.is_physical());
            let mut motion = Motion::of(orbit).unwrap();
            let (samples, home) = (4000, orbit.impacts()[0].site);
            let mut smallest = f64::INFINITY;
            let mut previous: Vec<[f64; 2]> = Vec::new();
            for k in 0..=samples {
                motion.at(0, orbit.period() * f64::from(k) / f64::from(samples));
                let now: Vec<[f64; 2]> =
                    (0..motion.sites()).map(|n| motion.site(n)).map(|m| [m.displacement, m.velocity]).collect();
                for (n, (last, this)) in previous.iter().zip(&now).enumerate() {
                    // Turning points; an impact turns the mass that is hit, too.
                    let jump = n == home && (this[1] - last[1]).abs() > 0.05 * motion_scale(orbit);
                    if last[1] * this[1] <= 0.0 && !jump {
                        smallest = smallest.min(1.0 - (this[0] - model.asymmetry()).abs());
                    }
                }
                previous = now;
            }
            assert!((smallest - margin).abs() < 2e-3, "model {i}: {smallest} {margin}");
        }
    }
    assert!(crossings > 0, "{crossings}");
}

/// The smallest jump of velocity at an impact.
fn motion_scale(orbit: &Orbit) -> f64 {
    orbit.impacts().iter().map(|impact| impact.impulse.abs()).fold(f64::INFINITY, f64::min)
}

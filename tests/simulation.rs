//! The closed forms against the event-driven simulation, which knows nothing of them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use nalgebra::{DMatrix, DVector};
use vibrochain::breather::{Family, Motion, Orbit, admissibility, breathers};
use vibrochain::eventsim::{EventKind, Limits, Outcome, Simulation, Time};
use vibrochain::floquet::{Complex, full_monodromy, leading_modes};
use vibrochain::lattice::{Chain, Model, Propagator, Spectrum};
use vibrochain_testkit::{dense, reference};

/// An orbit's return map by simulation, from the middle of its last flight (a negative time).
struct Return {
    orbit: Orbit,
    start: f64,
    point: DVector<f64>,
}

impl Return {
    fn new(orbit: &Orbit) -> Self {
        let start = 0.5 * (orbit.impacts().last().unwrap().time - orbit.period());
        let mut motion = Motion::of(orbit).unwrap();
        motion.at(0, start);
        let m = motion.sites();
        let state = (0..m).map(|n| motion.site(n).displacement).chain((0..m).map(|n| motion.site(n).velocity));
        Self { orbit: orbit.clone(), start, point: DVector::from_iterator(2 * m, state) }
    }

    fn simulation(&self, state: &DVector<f64>) -> Simulation {
        let m = state.len() / 2;
        let psi = self.orbit.psi().unwrap_or(0.0) + self.start;
        Simulation::new(self.orbit.model(), psi, &state.as_slice()[..m], &state.as_slice()[m..]).unwrap()
    }

    /// Runs to the end of `periods` periods of the orbit since the simulation began.
    fn run(&self, simulation: &mut Simulation, periods: u64) -> DVector<f64> {
        let force = u64::from(self.orbit.force_periods());
        let report = simulation.run(&Limits::until(Time::new(self.orbit.model(), periods * force, 0.0)), |_| {});
        assert_eq!(report.outcome, Outcome::TimeReached);
        let state = simulation.state();
        DVector::from_iterator(self.point.len(), state.displacement.iter().chain(&state.velocity).copied())
    }

    fn apply(&self, state: &DVector<f64>) -> DVector<f64> {
        self.run(&mut self.simulation(state), 1)
    }

    /// Central differences at two steps, extrapolated.
    fn jacobian(&self) -> DMatrix<f64> {
        let slowest = self.orbit.impacts().iter().map(|impact| impact.velocity_before.abs()).fold(1.0, f64::min);
        let (n, h) = (self.point.len(), 1e-4 * slowest * slowest);
        let mut jacobian = DMatrix::zeros(n, n);
        for j in 0..n {
            let slope = |h: f64| {
                let (mut plus, mut minus) = (self.point.clone(), self.point.clone());
                plus[j] += h;
                minus[j] -= h;
                (self.apply(&plus) - self.apply(&minus)) / (2.0 * h)
            };
            jacobian.set_column(j, &((4.0 * slope(0.5 * h) - slope(h)) / 3.0));
        }
        jacobian
    }

    /// Free flight (negative times too) of a perturbation.
    fn flow(&self, time: f64) -> DMatrix<f64> {
        let m = self.point.len() / 2;
        let flow = Propagator::new(&Spectrum::new(*self.orbit.model().chain()), time);
        DMatrix::from_fn(2 * m, 2 * m, |i, j| flow.block(i % m, j % m)[i / m][j / m])
    }
}

/// All physical orbits at the points of the table of checked numbers.
fn table() -> Vec<Orbit> {
    let mut orbits: Vec<Orbit> = Vec::new();
    for model in reference().iter().map(|case| case.model) {
        for family in [Family::DoubleSided, Family::SingleSided, Family::PeriodDoubled] {
            for orbit in breathers(&model, family).unwrap().orbits {
                if admissibility(&orbit).unwrap().is_physical() && !orbits.contains(&orbit) {
                    orbits.push(orbit);
                }
            }
        }
    }
    orbits
}

#[test]
fn every_physical_orbit_closes_after_one_period_with_its_own_impacts_and_no_others() {
    let orbits = table();
    assert!(orbits.len() >= 26, "{}", orbits.len());
    for orbit in &orbits {
        let map = Return::new(orbit);
        let mut simulation = map.simulation(&map.point);
        let time = Time::new(orbit.model(), u64::from(orbit.force_periods()), 0.0);
        let (report, events) = simulation.collect(&Limits::until(time));
        assert_eq!(report.outcome, Outcome::TimeReached);
        assert_eq!(events.len(), orbit.impacts().len(), "{orbit:?}");
        // Errors grow by the multipliers on the way: the most unstable orbit of the table has one of 2745.
        let growth = leading_modes(orbit, 1).unwrap()[0].multiplier.norm().max(1.0);
        for (event, impact) in events.iter().zip(orbit.impacts()) {
            assert_eq!((event.kind, event.site, event.barrier), (EventKind::Impact, impact.site, impact.barrier));
            assert!((event.time.to_f64() + map.start - impact.time).abs() < 1e-12 * growth);
            assert!((event.velocity_before - impact.velocity_before).abs() < 1e-12 * growth);
        }
        let end = map.run(&mut simulation, 1);
        assert!((end - &map.point).amax() < 1e-11, "{orbit:?}");
    }
}

#[test]
fn multipliers_of_the_simulated_return_map_are_those_of_the_monodromy_matrix() {
    let chain = Chain::new(5, 0.2, 0.1).unwrap();
    let mut compared = 0;
    for (model, family) in [
        (Model::conservative(chain, 1.5, 0.4).unwrap(), Family::DoubleSided),
        (Model::conservative(chain, 0.85, 0.4).unwrap(), Family::SingleSided),
        (Model::forced(chain, 1.5, 0.4, 0.1, 0.9).unwrap(), Family::DoubleSided),
        (Model::forced(chain, 0.92, 0.4, 0.1, 0.9).unwrap(), Family::SingleSided),
        (Model::forced(Chain::new(21, 0.2, 0.1).unwrap(), 1.07, 0.8, 0.1582, 0.25).unwrap(), Family::PeriodDoubled),
    ] {
        for orbit in breathers(&model, family).unwrap().orbits {
            if !admissibility(&orbit).unwrap().is_physical() {
                continue;
            }
            compared += 1;
            let map = Return::new(&orbit);
            let lead = map.flow(-map.start);
            let matrix = dense(&full_monodromy(&orbit).unwrap());
            let difference = (&matrix * &lead - &lead * map.jacobian()).amax();
            assert!(difference < 1e-7 * matrix.amax().max(1.0), "{family:?}: {difference:e}");
            // The multipliers themselves; next to 1 a conservative orbit has its defective pair.
            let found = map.jacobian().complex_eigenvalues();
            for mu in matrix.complex_eigenvalues().iter().filter(|mu| (*mu - Complex::new(1.0, 0.0)).norm() > 1e-3) {
                let nearest = found.iter().map(|other| (mu - other).norm()).fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-7 * mu.norm().max(1.0), "{family:?}: {mu} {nearest:e}");
            }
        }
    }
    assert!(compared >= 7, "{compared}");
}

/// Amplitude of a complex mode in a real perturbation: d = Re(c w), least squares for c.
fn amplitude(d: &DVector<f64>, w: &DVector<Complex<f64>>) -> f64 {
    let (re, im) = (w.map(|z| z.re), w.map(|z| z.im));
    let (a, b, c) = (re.dot(&re), re.dot(&im), im.dot(&im));
    let (r, s) = (d.dot(&re), d.dot(&im));
    let det = a * c - b * b;
    ((c * r - b * s) / det).hypot((a * s - b * r) / det)
}

#[test]
fn a_weakly_unstable_breather_leaves_at_the_rate_of_its_leading_multiplier() {
    let model = Model::forced(Chain::new(5, 0.2, 0.1).unwrap(), 1.5, 0.4, 0.1, 0.9).unwrap();
    let orbit = &breathers(&model, Family::DoubleSided).unwrap().orbits[0];
    let mode = &leading_modes(orbit, 1).unwrap()[0];
    assert!((mode.multiplier.norm() - 1.00690).abs() < 1e-5, "{}", mode.multiplier.norm());
    let map = Return::new(orbit);
    let entries = mode.displacement.iter().chain(&mode.velocity).copied();
    let before_impact = DVector::from_iterator(10, entries);
    let w = map.flow(map.start).map(|x| Complex::new(x, 0.0)) * before_impact;
    let mut simulation = map.simulation(&(&map.point + 1e-7 * w.map(|z| z.re)));
    let at = |simulation: &mut Simulation, periods| amplitude(&(map.run(simulation, periods) - &map.point), &w);
    let (first, periods) = (at(&mut simulation, 50), 1000);
    let rate = (at(&mut simulation, 50 + periods) / first).powf(1.0 / periods as f64);
    assert!((rate - mode.multiplier.norm()).abs() < 2e-6, "{rate} {}", mode.multiplier.norm());
}

#[test]
fn the_single_sided_breather_unstable_to_period_doubling_becomes_the_doubled_one() {
    let model = Model::forced(Chain::new(21, 0.2, 0.1).unwrap(), 1.07, 0.8, 0.1582, 0.25).unwrap();
    let physical = |family| {
        let orbits = breathers(&model, family).unwrap().orbits;
        orbits.into_iter().filter(|orbit| admissibility(orbit).unwrap().is_physical()).collect::<Vec<_>>()
    };
    let doubled = &physical(Family::PeriodDoubled)[0];
    let single = physical(Family::SingleSided);
    let single = single.iter().find(|orbit| leading_modes(orbit, 1).unwrap()[0].multiplier.re < -1.0).unwrap();
    let map = Return::new(single);
    let mut start = map.point.clone();
    start[0] += 1e-4;
    let mut simulation = map.simulation(&start);
    map.run(&mut simulation, 12_000);
    // Odd modes never decay; this perturbation is even. The last impacts alternate between the doubled orbit's two.
    let until = Time::new(&model, 12_004, 0.0);
    let (_, events) = simulation.collect(&Limits::until(until));
    let mut speeds: Vec<f64> = events.iter().map(|event| -event.velocity_before).collect();
    assert_eq!(speeds.len(), 4);
    speeds.sort_by(f64::total_cmp);
    let mut expected: Vec<f64> = doubled.impacts().iter().map(|impact| -impact.velocity_before).collect();
    expected.sort_by(f64::total_cmp);
    for (speed, expected) in speeds.iter().zip([expected[0], expected[0], expected[1], expected[1]]) {
        assert!((speed - expected).abs() < 1e-6, "{speeds:?} {expected}");
    }
}

/// Conservative orbits with φ ≠ T/2, physical at low frequency on short rings; the second pair is stable, too.
#[test]
fn asymmetric_conservative_breathers_last() {
    let points =
        [(3, 0.14, 0.25, 0.55), (6, 0.279_046_501_654_373_4, 0.136_065_696_159_375_17, 0.345_635_975_461_777_1)];
    let mut checked = 0;
    for (sites, gamma1, gamma2, omega) in points {
        let model = Model::conservative(Chain::new(sites, gamma1, gamma2).unwrap(), omega, 0.0).unwrap();
        for orbit in &breathers(&model, Family::DoubleSided).unwrap().orbits {
            if orbit.phi() == Some(0.5 * orbit.period()) || !admissibility(orbit).unwrap().is_physical() {
                continue;
            }
            let map = Return::new(orbit);
            let end = map.run(&mut map.simulation(&map.point), 50);
            assert!((&end - &map.point).amax() < 1e-10, "{sites} {:e}", (&end - &map.point).amax());
            checked += 1;
        }
    }
    assert!(checked >= 4, "{checked}");
}

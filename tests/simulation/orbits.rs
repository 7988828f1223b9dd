//! The closed forms against the event-driven simulation, which knows nothing of them.

use std::collections::HashMap;

use nalgebra::{DMatrix, DVector};
use vibrochain::breather::{Family, Finder, Motion, Orbit, admissibility, breathers};
use vibrochain::eventsim::{Event, EventKind, Limits, Outcome, Simulation, Time};
use vibrochain::floquet::{Complex, full_monodromy, leading_modes};
use vibrochain::lattice::{Barrier, Chain, Ends, Harmonic, Model, Point, Propagator, Spectrum};
use vibrochain_testkit::{Random, Ranges, ReturnMap, Values, reference, stiffness, words};

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
        Simulation::new(self.orbit.model().unwrap(), psi, &state.as_slice()[..m], &state.as_slice()[m..]).unwrap()
    }

    /// Runs to the end of `periods` periods of the orbit since the simulation began.
    fn run(&self, simulation: &mut Simulation, periods: u64) -> DVector<f64> {
        let force = u64::from(self.orbit.force_periods());
        let report =
            simulation.run(&Limits::until(Time::new(self.orbit.model().unwrap(), periods * force, 0.0)), |_| {});
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
        let flow = Propagator::new(&Spectrum::new(*self.orbit.model().unwrap().chain()), time);
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
        let time = Time::new(orbit.model().unwrap(), u64::from(orbit.force_periods()), 0.0);
        let (report, events) = simulation.collect(&Limits::until(time));
        assert_eq!(report.outcome, Outcome::TimeReached);
        assert_eq!(events.len(), orbit.impacts().len(), "{orbit:?}");
        // Errors grow by the multipliers on the way: the most unstable orbit of the table has one of 2745.
        let growth = leading_modes(orbit, 1).unwrap()[0].multiplier.norm().max(1.0);
        for (event, impact) in events.iter().zip(orbit.impacts()) {
            assert_eq!((event.kind, event.contact, event.barrier), (EventKind::Impact, impact.site, impact.barrier));
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
    let forced = chain.point().asymmetry(0.4).amplitude(0.1).restitution(0.9);
    let doubled =
        Point::ring(21).gamma1(0.2).gamma2(0.1).omega(1.07).asymmetry(0.8).amplitude(0.1582).restitution(0.25);
    let mut compared = 0;
    for (model, family) in [
        (Model::conservative(chain, 1.5, 0.4).unwrap(), Family::DoubleSided),
        (Model::conservative(chain, 0.85, 0.4).unwrap(), Family::SingleSided),
        (forced.omega(1.5).model().unwrap(), Family::DoubleSided),
        (forced.omega(0.92).model().unwrap(), Family::SingleSided),
        (doubled.model().unwrap(), Family::PeriodDoubled),
    ] {
        for orbit in breathers(&model, family).unwrap().orbits {
            if !admissibility(&orbit).unwrap().is_physical() {
                continue;
            }
            compared += 1;
            let map = Return::new(&orbit);
            let lead = map.flow(-map.start);
            let matrix = full_monodromy(&orbit).unwrap();
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
    let ring = Point::ring(5).gamma1(0.2).gamma2(0.1);
    let model = ring.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model().unwrap();
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
    let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
    let model = ring.omega(1.07).asymmetry(0.8).amplitude(0.1582).restitution(0.25).model().unwrap();
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

/// A simulated run once more in small steps of the equations of motion: every event must be where the simulation says, and no mass
/// beyond a barrier in between. Shares nothing but the times of the events, and goes on from its own states.
struct Replay<'a> {
    model: &'a Model,
    stiffness: DMatrix<f64>,
    psi: f64,
    time: f64,
    u: DVector<f64>,
    v: DVector<f64>,
    resting: Vec<Option<Barrier>>,
}

impl Replay<'_> {
    /// Accelerations, as if no mass were at rest.
    fn free(&self, t: f64, u: &DVector<f64>) -> DVector<f64> {
        let wave = |harmonic: &Harmonic| {
            let rate = f64::from(harmonic.number) * self.model.omega();
            harmonic.amplitude * (rate * (t + self.psi) + harmonic.phase).cos()
        };
        (-&self.stiffness * u).add_scalar(self.model.force().harmonics().iter().map(wave).sum())
    }

    fn acceleration(&self, t: f64, u: &DVector<f64>) -> DVector<f64> {
        let free = self.free(t, u);
        DVector::from_fn(u.len(), |n, _| if self.resting[n].is_some() { 0.0 } else { free[n] })
    }

    /// Looks at the state: how far beyond its barrier is a mass, or how strongly is one at rest pulled off?
    fn violation(&self) -> f64 {
        let (a, free) = (self.model.asymmetry(), self.free(self.time, &self.u));
        let of = |n: usize| match self.resting[n] {
            None => (self.u[n] - a).abs() - 1.0,
            Some(barrier) => -barrier.sign() * free[n],
        };
        (0..self.u.len()).map(of).fold(f64::NEG_INFINITY, f64::max)
    }

    fn run(&mut self, until: f64) {
        // In units of the fastest oscillation: errors of 1e-11 over some periods.
        let longest = 4e-3 / self.stiffness.amax().sqrt().max(1.0);
        let steps = ((until - self.time) / longest).ceil().max(1.0) as u32;
        let h = (until - self.time) / f64::from(steps);
        for _ in 0..steps {
            let (t, u, v) = (self.time, &self.u, &self.v);
            let k1 = self.acceleration(t, u);
            let k2 = self.acceleration(t + 0.5 * h, &(u + 0.5 * h * v + 0.125 * h * h * &k1));
            let k3 = self.acceleration(t + h, &(u + h * v + 0.5 * h * h * &k2));
            // Nyström's method of fourth order.
            (self.u, self.v) = (u + h * v + h * h / 6.0 * (&k1 + 2.0 * &k2), v + h / 6.0 * (&k1 + 4.0 * &k2 + &k3));
            self.time += h;
            assert!(self.violation() < 1e-8, "{:e} at {}: {:?}", self.violation(), self.time, self.model);
        }
    }

    fn take(&mut self, event: &Event) {
        self.run(event.time.to_f64());
        let &Event { contact: site, barrier, kind, .. } = event;
        assert!(
            (self.u[site] - self.model.barrier(barrier)).abs() < 1e-8,
            "{event:?} {}: {:?}",
            self.u[site],
            self.model
        );
        match kind {
            EventKind::Impact => {
                assert!(
                    (self.v[site] - event.velocity_before).abs() < 1e-7,
                    "{event:?} {}: {:?}",
                    self.v[site],
                    self.model
                );
                self.v[site] *= -self.model.restitution();
            }
            EventKind::Stick => {
                assert!(self.v[site].abs() < 1e-6, "{event:?} {}", self.v[site]);
                self.v[site] = 0.0;
                self.resting[site] = Some(barrier);
            }
            EventKind::Release => {
                assert!(self.free(self.time, &self.u)[site].abs() < 1e-7, "{event:?}");
                self.resting[site] = None;
            }
        }
    }
}

/// Runs both; counts of impacts, rests and restarts in parts.
fn replayed(model: &Model, psi: f64, speed: f64, periods: f64, random: &mut Random) -> [u64; 3] {
    let sites = model.chain().sites();
    let u: Vec<f64> = (0..sites).map(|_| model.asymmetry() + random.between(-0.9, 0.9)).collect();
    let v: Vec<f64> = (0..sites).map(|_| random.between(-speed, speed)).collect();
    let mut simulation = Simulation::new(model, psi, &u, &v).unwrap();
    let start = simulation.energy().unwrap();
    let (report, events) = simulation.collect(&Limits::until(Time::new(model, 0, periods)));
    assert_eq!(report.outcome, Outcome::TimeReached);
    let stiffness = stiffness(model.chain());
    let (u, v) = (DVector::from_vec(u), DVector::from_vec(v));
    let energy = |u: &DVector<f64>, v: &DVector<f64>| 0.5 * (v.dot(v) + u.dot(&(&stiffness * u)));
    assert!((start - energy(&u, &v)).abs() < 1e-12 * start, "{model:?}");
    let resting = vec![None; sites];
    let mut replay = Replay { model, stiffness: stiffness.clone(), psi, time: 0.0, u, v, resting };
    events.iter().for_each(|event| replay.take(event));
    replay.run(report.time.to_f64());
    let state = simulation.state();
    let off = |found: &[f64], own: &DVector<f64>| found.iter().zip(own).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let difference = off(&state.displacement, &replay.u).max(off(&state.velocity, &replay.v));
    assert!(difference < 1e-7, "{difference:e} {model:?}");
    if model.is_conservative() {
        assert!((simulation.energy().unwrap() - start).abs() < 1e-12 * start, "{model:?}");
    }
    [report.work.impacts, report.work.sticks, report.work.restarts]
}

#[test]
fn simulations_of_random_lattices_obey_the_equations_of_motion() {
    let mut random = Random(15);
    let restitution = Values::Either(0.4, &Values::Is(1.0), &Values::Even(0.1, 0.9));
    let ranges = Ranges { sites: [1, 7], amplitude: Values::Log(0.2, 4.0), restitution, ..Ranges::FORCED };
    let (mut impacts, mut sticks, mut kinds) = (0, 0, HashMap::new());
    for _ in 0..150 {
        let (chain, model) = (random.lattice(&ranges), random.model(&ranges));
        let model = model.point().on(&chain).model().unwrap();
        let [hit, rested, _] = replayed(&model, random.unit(), 2.0, 1.5, &mut random);
        (impacts, sticks) = (impacts + hit, sticks + rested);
        *kinds.entry((chain.ends(), chain.layers() > 1, chain.layer_ends())).or_insert(0) += 1;
    }
    assert!(kinds.len() == 9 && kinds.values().all(|&count| count >= 3), "{kinds:?}");
    assert!(impacts > 1500 && sticks > 30, "{impacts} {sticks}");
}

#[test]
fn simulations_of_stiff_and_of_long_lattices_obey_the_equations_of_motion() {
    let row = |sites, gamma2, ends| Chain::new(sites, 0.2, gamma2).unwrap().with_ends(ends);
    let layers = |chain: Chain, layers, gamma3, ends| chain.with_layers(layers, gamma3, ends).unwrap();
    let mut random = Random(4);
    for (chain, in_parts) in [
        (row(1, 30.0, Ends::Fixed), false),
        (row(2, 30.0, Ends::Fixed), false),
        (layers(row(1, 0.0, Ends::Closed), 2, 40.0, Ends::Closed), false),
        (layers(row(1, 7.0, Ends::Free), 1, 0.0, Ends::Closed), false),
        (layers(row(3, 9.0, Ends::Free), 3, 12.0, Ends::Closed), false),
        (layers(row(2, 9.0, Ends::Fixed), 4, 12.0, Ends::Fixed), false),
        (layers(row(20, 0.1, Ends::Free), 3, 0.2, Ends::Free), false),
        (row(60, 0.02, Ends::Free), true),
        (row(60, 0.02, Ends::Fixed), true),
        (row(60, 0.02, Ends::Closed), true),
    ] {
        for restitution in [1.0, 0.5] {
            // Beside walls of layers a force is not worked out.
            let forced = restitution < 1.0 && chain.layer_ends() != Ends::Fixed;
            let amplitude = if forced { 0.4 } else { 0.0 };
            let model =
                chain.point().omega(1.5).asymmetry(0.4).amplitude(amplitude).restitution(restitution).model().unwrap();
            let speed = 3.0 * stiffness(&chain).amax().sqrt().max(1.0);
            let [impacts, _, restarts] = replayed(&model, 0.3, speed, 1.0, &mut random);
            assert!(impacts > 0 && in_parts == (restarts > 20), "{impacts} {restarts} {chain}");
        }
    }
}

/// A state that a mirror image leaves as it is stays so, to the bit: parts at the two ends are restarted alike.
#[test]
fn a_mirror_symmetric_row_with_ends_stays_so_to_the_bit() {
    let mut random = Random(6);
    for (length, ends, layers) in
        [(9, Ends::Free, 1), (12, Ends::Fixed, 3), (101, Ends::Free, 1), (100, Ends::Fixed, 1)]
    {
        let chain = Chain::new(length, 0.2, 0.1).unwrap().with_ends(ends);
        let chain = chain.with_layers(layers, if layers > 1 { 0.05 } else { 0.0 }, Ends::Free).unwrap();
        let model = Model::conservative(chain, 1.5, 0.3).unwrap();
        let mirrored = |n: usize| n - n % length + (length - 1 - n % length);
        let mut draw = |limit: f64| {
            let own: Vec<f64> = (0..chain.sites()).map(|_| random.between(-limit, limit)).collect();
            (0..chain.sites()).map(|n| own[n.min(mirrored(n))]).collect::<Vec<f64>>()
        };
        let (u, v) = (draw(0.6), draw(2.0));
        let mut simulation = Simulation::new(&model, 0.0, &u, &v).unwrap();
        let work = simulation.run(&Limits::until(Time::new(&model, 40, 0.37)), |_| {}).work;
        assert!(work.impacts > 400 && (work.restarts > 400) == (length >= 100), "{work:?}");
        let state = simulation.state();
        for n in 0..chain.sites() {
            assert_eq!(state.displacement[n].to_bits(), state.displacement[mirrored(n)].to_bits(), "{chain} {n}");
            assert_eq!(state.velocity[n].to_bits(), state.velocity[mirrored(n)].to_bits(), "{chain} {n}");
        }
    }
}

/// The orbits of the table of checked words, simulated for ten periods, and the differences of their return maps.
#[test]
fn checked_words_repeat_ten_times_and_have_the_multipliers_of_their_simulation() {
    let (mut finder, mut closed, mut compared) = (Finder::new(21), 0, 0);
    for case in words() {
        let guess = Orbit::from_impulses(&case.model, 1, case.psi, &case.hits).unwrap();
        let orbit = finder.polish(&guess).unwrap();
        if !finder.admissibility(&orbit).unwrap().is_physical() {
            assert_ne!(case.physical, Some(true), "{}", case.word);
            continue;
        }
        // Ten periods, or as many as the growth of rounding allows.
        let periods = (1e4_f64.ln() / case.spectral_radius.ln()).clamp(1.0, 10.0) as u64;
        let map = Return::new(&orbit);
        let mut simulation = map.simulation(&map.point);
        let (report, events) = simulation.collect(&Limits::until(Time::new(orbit.model().unwrap(), periods, 0.0)));
        let expected = periods as usize * orbit.impacts().len();
        assert_eq!((report.outcome, events.len()), (Outcome::TimeReached, expected), "{}", case.word);
        let state = simulation.state();
        let end = DVector::from_iterator(map.point.len(), state.displacement.into_iter().chain(state.velocity));
        let off = (end - &map.point).amax();
        assert!(off <= 1e-10, "{} {}: {off:e}", case.word, orbit.model().unwrap().chain());
        closed += usize::from(periods == 10);
        let map = ReturnMap::new(&orbit);
        let (lead, jacobian) = (map.ring.flow(-map.start), map.jacobian());
        let matrix = full_monodromy(&orbit).unwrap();
        let difference = (&matrix * &lead - &lead * &jacobian).amax();
        assert!(difference < 1e-7 * matrix.amax().max(1.0), "{}: {difference:e}", case.word);
        // On the circle multipliers meet, and are no better known than the root of what the matrix is.
        let found = jacobian.complex_eigenvalues();
        for mu in matrix.complex_eigenvalues().iter().filter(|mu| mu.norm() > 1.01) {
            let nearest = found.iter().map(|other| (mu - other).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-7 * mu.norm(), "{}: {mu} {nearest:e}", case.word);
            compared += 1;
        }
    }
    assert!(closed >= 38 && compared >= 15, "{closed} {compared}");
}

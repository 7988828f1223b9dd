//! Tangent vectors against neighbouring runs, and against what is known by hand.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod support;

use support::{Random, breather};
use vibrochain_eventsim::{Event, EventKind, Growth, Limits, Outcome, Simulation, TangentError, Time};
use vibrochain_lattice::{Chain, Ends, Model};

fn ring(sites: usize) -> Chain {
    Chain::new(sites, 0.2, 0.1).unwrap()
}

/// Rings, a row, walls, layers; with and without force and loss.
fn models() -> Vec<Model> {
    let chains = [
        ring(1),
        ring(5),
        ring(70),
        ring(6).with_ends(Ends::Free),
        ring(6).with_ends(Ends::Fixed),
        ring(4).with_layers(3, 0.05, Ends::Free).unwrap(),
    ];
    let drives = [(0.0, 1.0), (0.1, 0.9), (0.7, 0.4)];
    let driven = |chain: Chain, omega, (amplitude, e)| {
        chain.point().omega(omega).asymmetry(0.4).amplitude(amplitude).restitution(e).model().unwrap()
    };
    // The slow strong force at the end presses masses to their barriers.
    let of = |chain| {
        let pressed = driven(chain, 0.4, (1.5, 0.3));
        drives.map(|drive| driven(chain, 1.5, drive)).into_iter().chain([pressed])
    };
    chains.into_iter().flat_map(of).collect()
}

#[test]
fn a_run_with_tangents_is_the_same_to_the_bit() {
    let mut seen = [0; 3];
    for (number, model) in models().iter().enumerate() {
        let (u, v) = Random(number as u64 + 1).state(model, 2.0);
        let mut alone = Simulation::new(model, 0.3, &u, &v).unwrap();
        let mut ridden = alone.clone();
        let limits = Limits::until(Time::new(model, 30, 0.37));
        let (report, events) = alone.collect(&limits);
        let mut tangents = alone.tangents(2, 5).unwrap();
        let mut same: Vec<Event> = Vec::new();
        assert_eq!(ridden.run_with(&mut tangents, &limits, |event| same.push(*event)).unwrap(), report);
        assert_eq!((same, ridden.state()), (events.clone(), alone.state()));
        for event in events {
            seen[event.kind as usize] += 1;
        }
    }
    // Of impacts, rests and releases there were some.
    assert!(seen[0] > 1000 && seen[1] > 10 && seen[2] > 10, "{seen:?}");
}

/// Displacements and velocities after `time`, and the sequence of events.
fn after(model: &Model, (u, v): (&[f64], &[f64]), time: Time) -> (Vec<f64>, Vec<(usize, bool, EventKind)>) {
    let mut simulation = Simulation::new(model, 0.3, u, v).unwrap();
    let (report, events) = simulation.collect(&Limits::until(time));
    assert_eq!(report.outcome, Outcome::TimeReached);
    let state = simulation.state();
    let upper = |event: &Event| event.velocity_before > 0.0;
    let events = events.iter().map(|event| (event.contact, upper(event), event.kind)).collect();
    (state.displacement.into_iter().chain(state.velocity).collect(), events)
}

#[test]
fn tangents_are_the_difference_of_neighbouring_runs() {
    let (mut compared, mut rested, mut worst) = (0, 0, 0.0_f64);
    for (number, model) in models().iter().enumerate() {
        let sites = model.chain().sites();
        for periods in [1, 2] {
            let time = Time::new(model, periods, 0.2);
            let mut random = Random(100 + number as u64);
            let (u, v) = random.state(model, 0.8);
            let direction = [random.state(model, 1.0).1, random.state(model, 1.0).1];
            let (own, events) = after(model, (&u, &v), time);
            let shifted = |h: f64| {
                let add = |x: &[f64], d: &[f64]| -> Vec<f64> { x.iter().zip(d).map(|(x, d)| x + h * d).collect() };
                after(model, (&add(&u, &direction[0]), &add(&v, &direction[1])), time)
            };
            let difference = |h: f64| -> Option<Vec<f64>> {
                let ((one, before), (other, behind)) = (shifted(-h), shifted(h));
                // Where neighbours have other events, as beside a graze, their difference is none.
                let same = before == events && behind == events;
                same.then(|| one.iter().zip(&other).map(|(one, other)| (other - one) / (2.0 * h)).collect())
            };
            let h = 1e-5;
            let (Some(fine), Some(coarse)) = (difference(h), difference(2.0 * h)) else { continue };
            let mut simulation = Simulation::new(model, 0.3, &u, &v).unwrap();
            let mut tangents = simulation.tangents_along(std::slice::from_ref(&direction)).unwrap();
            let report = simulation.run_with(&mut tangents, &Limits::until(time), |_| {}).unwrap();
            assert_eq!(report.outcome, Outcome::TimeReached);
            assert!(!tangents.has_grazed());
            let [du, dv] = tangents.vector(0).unwrap();
            let size = du.iter().chain(&dv).fold(0.1, |most: f64, x| most.max(x.abs()));
            for (i, exact) in du.iter().chain(&dv).enumerate() {
                // By the error of the step, extrapolated, and the rounding of states that have grown as the difference has.
                let expected = (4.0 * fine[i] - coarse[i]) / 3.0;
                let allowed = 0.1 * (fine[i] - coarse[i]).abs() + 1e-9 * size;
                worst = worst.max((exact - expected).abs() / size);
                assert!((exact - expected).abs() <= allowed, "{model:?} {i}: {exact} {expected} {allowed:e}");
            }
            assert_eq!(own.len(), 2 * sites);
            compared += 1;
            rested += usize::from(report.work.sticks > 0);
        }
    }
    println!("{compared} runs, {rested} with rests, {worst:e}");
    assert!(compared >= 36 && rested >= 6, "{compared} {rested}");
}

#[test]
fn motions_that_are_integrable_grow_no_faster_than_time() {
    // Flight alone: the growth is bounded.
    let model = Model::conservative(ring(9), 1.5, 0.4).unwrap();
    let (u, v) = (vec![0.1; 9], vec![0.0; 9]);
    let mut simulation = Simulation::new(&model, 0.0, &u, &v).unwrap();
    let mut tangents = simulation.tangents(3, 1).unwrap();
    let until = Limits::until(Time::new(&model, 2000, 0.0));
    let report = simulation.run_with(&mut tangents, &until, |_| {}).unwrap();
    assert_eq!(report.work.impacts, 0);
    assert!(tangents.orthonormalise().iter().all(|log| log.abs() < 2.0));
    // One mass between its barriers: neighbours run ahead in proportion to time, and areas stay.
    let model = Model::conservative(ring(1), 1.5, 0.4).unwrap();
    let mut simulation = Simulation::new(&model, 0.0, &[0.2], &[1.7]).unwrap();
    let mut tangents = simulation.tangents(2, 1).unwrap();
    let mut growth = Growth::default();
    let mut logs = Vec::new();
    for period in 1..=20_000 {
        simulation.run_with(&mut tangents, &Limits::until(Time::new(&model, period, 0.0)), |_| {}).unwrap();
        let [first, second] = *tangents.orthonormalise() else { panic!() };
        assert!((first + second).abs() < 1e-9, "{period}: {first} {second}");
        growth.reach(simulation.time().to_f64(), first);
        logs.push(first);
    }
    assert!(simulation.work().impacts > 20_000);
    // ln t + c.
    assert!((logs[19_999] - logs[1999] - 10f64.ln()).abs() < 0.05);
    assert!(growth.exponent().unwrap().value < 2e-4);
}

#[test]
fn areas_in_phase_space_shrink_by_the_square_of_the_restitution() {
    // The determinant of a saltation is e², flight keeps volumes. (Directions that have come apart by 10⁸ cost digits.)
    for e in [1.0, 0.9, 0.5] {
        let model = ring(3).point().omega(1.5).asymmetry(0.4).amplitude(0.3).restitution(e).model().unwrap();
        let mut simulation = Simulation::new(&model, 0.0, &[0.0; 3], &[1.5, -0.4, 0.9]).unwrap();
        let mut tangents = simulation.tangents(6, 3).unwrap();
        let until = Limits::until(Time::new(&model, 12, 0.0));
        let report = simulation.run_with(&mut tangents, &until, |_| {}).unwrap();
        assert!(report.work.impacts > 3 && report.work.sticks == 0, "{report:?}");
        let volume: f64 = tangents.orthonormalise().iter().sum();
        let expected = 2.0 * report.work.impacts as f64 * f64::ln(e);
        assert!((volume - expected).abs() < 1e-7, "{volume} {expected}");
    }
}

#[test]
fn neighbours_on_a_breather_stay_for_its_own_growth_alone() {
    // A stable breather: growth in proportion to time, along its family, and no more.
    let model = Model::conservative(ring(21), 1.5, 0.4).unwrap();
    let (u, v) = breather(&model);
    let mut simulation = Simulation::new(&model, 0.0, &u, &v).unwrap();
    let mut tangents = simulation.tangents(1, 1).unwrap();
    let mut log = |periods| {
        simulation.run_with(&mut tangents, &Limits::until(Time::new(&model, periods, 0.0)), |_| {}).unwrap();
        tangents.orthonormalise()[0]
    };
    let (early, late) = (log(100), log(1000));
    assert!((late - early - 10f64.ln()).abs() < 0.3, "{early} {late}");
}

#[test]
fn rest_takes_a_direction_and_a_graze_takes_the_meaning() {
    // One mass, pressed against its barrier by a strong force: all of its perturbations end there.
    let model = ring(1).point().omega(0.4).asymmetry(0.4).amplitude(1.5).restitution(0.3).model().unwrap();
    let mut simulation = Simulation::new(&model, 0.0, &[0.0], &[0.5]).unwrap();
    let mut tangents = simulation.tangents(1, 1).unwrap();
    let report = simulation.run_with(&mut tangents, &Limits::until(Time::new(&model, 2, 0.0)), |_| {}).unwrap();
    assert!(report.work.sticks > 0 && report.work.releases > 0);
    assert_eq!(tangents.orthonormalise(), [f64::NEG_INFINITY]);
    assert_eq!(tangents.vector(0).unwrap(), [vec![0.0], vec![0.0]]);
    // Rest at the start, too.
    let mut simulation = Simulation::new(&model, 0.0, &[1.4], &[0.0]).unwrap();
    let mut tangents = simulation.tangents(1, 1).unwrap();
    simulation.run_with(&mut tangents, &Limits::until(Time::new(&model, 0, 0.01)), |_| {}).unwrap();
    assert_eq!(tangents.vector(0).unwrap(), [vec![0.0], vec![0.0]]);
    // u = 1.4 sin t is tangent to the upper barrier, to rounding.
    let model = Model::conservative(Chain::new(1, 1.0, 0.0).unwrap(), 1.0, 0.4).unwrap();
    let mut grazes = 0;
    for ulps in -8..=8 {
        let speed = 1.4 * (1.0 + f64::from(ulps) * f64::EPSILON);
        let mut simulation = Simulation::new(&model, 0.0, &[0.0], &[speed]).unwrap();
        let mut tangents = simulation.tangents(1, 1).unwrap();
        let mut still = false;
        let until = Limits::until(Time::new(&model, 0, 0.45));
        let report = simulation.run_with(&mut tangents, &until, |event| still |= event.velocity_before == 0.0);
        assert_eq!(tangents.has_grazed(), still, "{report:?}");
        grazes += usize::from(still);
        assert!(tangents.orthonormalise()[0].is_finite());
    }
    assert!(grazes > 0);
}

#[test]
fn what_is_no_tangent_vector_is_told() {
    let (model, other) = (models()[1], models()[4]);
    let told = |error: TangentError| error.to_string();
    let own = Simulation::new(&model, 0.0, &[0.0], &[0.0]).unwrap();
    assert_eq!(told(own.tangents(0, 1).unwrap_err()), "0 tangent vectors: give 1 to 2");
    assert_eq!(told(own.tangents(3, 1).unwrap_err()), "3 tangent vectors: give 1 to 2");
    let of = |u: &[f64], v: &[f64]| own.tangents_along(&[[u.to_vec(), v.to_vec()]]).map(drop);
    for (u, v) in [(&[1.0, 0.0][..], &[0.0][..]), (&[0.0], &[0.0]), (&[f64::NAN], &[0.0]), (&[1.0], &[f64::INFINITY])] {
        assert_eq!(of(u, v), Err(TangentError::Entries { vector: 0, size: 1 }));
    }
    let mut simulation = Simulation::new(&other, 0.0, &[0.0; 5], &[0.0; 5]).unwrap();
    let mut tangents = own.tangents(1, 1).unwrap();
    let refused = simulation.run_with(&mut tangents, &Limits::impacts(1), |_| {});
    assert_eq!(refused, Err(TangentError::OtherModel));
}

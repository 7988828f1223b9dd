//! Flight by local series against flight by modes and against what shares no code.

use nalgebra::{DMatrix, DVector};
use vibrochain_eventsim::{Event, EventKind, Limits, Outcome, Simulation};
use vibrochain_lattice::{Complex, Contact, DampedChain, Ends, ModalStructure, RowEnds, Structure};
use vibrochain_testkit::Random;

use crate::dense::Dense;
use crate::made::until;

type C = Complex<f64>;

/// The same structure that knows its modes alone, and flies by them.
fn of_modes(structure: &ModalStructure) -> ModalStructure {
    let (contacts, harmonics) = (structure.contacts().to_vec(), structure.harmonics().to_vec());
    ModalStructure::new(contacts, harmonics, structure.modes().to_vec()).unwrap()
}

fn stop(random: &mut Random) -> Contact {
    let (lower, upper) = (random.between(-1.0, -0.3), random.between(0.2, 1.0));
    let lower = random.chance(0.7).then_some(lower);
    Contact { lower, upper: Some(upper), restitution: random.of(&[0.0, 0.5, 0.9, 1.0]) }
}

/// A chain of any ends, soft and stiff, whose contacts see one or several masses, under static loads and two harmonics.
fn chain(random: &mut Random) -> DampedChain {
    let sites = 1 + random.below(12);
    let ends = RowEnds::ALL[random.below(4)];
    let gamma2 = random.between(-0.05, 0.6);
    let gamma1 = random.between(0.0, 0.8) + 4.0 * (-gamma2).max(0.0);
    let mut contacts = vec![(vec![(random.below(sites), 1.0)], stop(random))];
    if random.chance(0.5) {
        let (first, second) = (random.below(sites), random.below(sites));
        contacts.push((vec![(first, 1.0), (second, if first == second { 0.4 } else { -0.7 })], stop(random)));
    }
    let uniform = random.chance(0.5);
    let size = random.between(0.3, 1.5);
    let load =
        |random: &mut Random| {
            (0..sites)
                .map(|_| {
                    if uniform {
                        C::new(size, 0.2)
                    } else {
                        C::new(random.between(-1.5, 1.5), random.between(-1.0, 1.0))
                    }
                })
                .collect()
        };
    let loads = vec![(1, load(random)), (3, load(random))];
    let static_load =
        if random.chance(0.5) { (0..sites).map(|_| random.between(-0.3, 0.3)).collect() } else { Vec::new() };
    DampedChain {
        gamma1,
        gamma2,
        damping: random.of(&[0.0, 0.01, 0.2]),
        coupling_damping: random.of(&[0.0, 0.0, 0.05]),
        contacts,
        static_load,
        loads,
        ..DampedChain::new(sites, ends)
    }
}

/// Masses of their own with springs and dashpots between some.
fn sparse(random: &mut Random) -> Structure {
    let n = 2 + random.below(6);
    let (mut stiffness, mut damping) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    for i in 0..n {
        stiffness[(i, i)] += random.between(0.2, 1.0);
        damping[(i, i)] += random.between(0.0, 0.1);
        let j = random.below(n);
        for (matrix, most) in [(&mut stiffness, 0.5), (&mut damping, 0.05)] {
            let spring = random.between(0.0, most);
            for (a, b, sign) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
                matrix[(a, b)] += sign * spring;
            }
        }
    }
    let weights = |random: &mut Random| {
        DVector::from_fn(n, |_, _| if random.chance(0.4) { random.between(-1.0, 1.0) } else { 0.0 })
    };
    let mut first = weights(random);
    first[random.below(n)] = 1.0;
    let contacts = vec![(first, stop(random))];
    Structure {
        mass: DMatrix::from_diagonal(&DVector::from_fn(n, |_, _| random.between(0.3, 2.0))),
        damping,
        stiffness,
        contacts,
        static_load: DVector::from_fn(n, |_, _| random.between(-0.2, 0.2)),
        loads: vec![(1, DVector::from_fn(n, |_, _| C::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0))))],
        modes: None,
    }
}

/// Events until one of them is so slow that rounding grows there, and the state after them.
fn run(structure: ModalStructure, omega: f64, xi: &[[f64; 2]]) -> (Vec<Event>, Simulation) {
    let mut simulation = Simulation::of_modes(structure, omega, 0.4, xi).unwrap();
    let (_, events) = simulation.collect(&until(&simulation, 3, 0.3));
    (events, simulation)
}

fn is_slow(event: &Event) -> bool {
    event.kind == EventKind::Impact && event.velocity_before.abs() < 0.03
}

/// The events that both have before rounding grows, and how far these are apart.
fn compare(one: &[Event], two: &[Event], case: &str) -> (usize, f64) {
    let (mut count, mut worst) = (0, 0.0f64);
    for (a, b) in one.iter().zip(two) {
        if is_slow(a) || is_slow(b) {
            break;
        }
        assert_eq!((a.contact, a.barrier, a.kind), (b.contact, b.barrier, b.kind), "{case}: {a:?} {b:?}");
        let apart = (a.time.to_f64() - b.time.to_f64()).abs().max((a.velocity_after - b.velocity_after).abs());
        worst = worst.max(apart);
        count += 1;
    }
    (count, worst)
}

#[test]
fn local_series_fly_as_modes_do() {
    let mut random = Random(77);
    let (mut impacts, mut rests, mut quiet, mut energies) = (0, 0, 0, 0);
    for round in 0..300 {
        let (modal, omega) = if round % 3 == 0 {
            (sparse(&mut random).modal().unwrap(), random.between(0.5, 1.5))
        } else {
            (chain(&mut random).modal().unwrap(), random.between(0.5, 1.5))
        };
        assert!(modal.operator().is_some());
        let xi: Vec<[f64; 2]> =
            modal.modes().iter().map(|_| [random.between(-0.1, 0.1), random.between(-0.4, 0.4)]).collect();
        if Simulation::of_modes(modal.clone(), omega, 0.4, &xi).is_err() {
            continue;
        }
        let ((one, mut local), (two, mut modes)) = (run(modal.clone(), omega, &xi), run(of_modes(&modal), omega, &xi));
        let (count, worst) = compare(&one, &two, &format!("{round}"));
        assert!(worst < 1e-11, "{round}: {worst:e} of {count}");
        impacts += count;
        rests += one[..count].iter().filter(|event| event.kind != EventKind::Impact).count();
        if count == one.len() && count == two.len() {
            let (a, b) = (local.state(), modes.state());
            let lists = [(&a.displacement, &b.displacement), (&a.velocity, &b.velocity)];
            let apart =
                lists.iter().flat_map(|(a, b)| a.iter().zip(*b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let of_modes =
                a.modes.iter().flatten().zip(b.modes.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-11 && of_modes < 1e-10, "{round}: {apart:e} {of_modes:e}");
            for (a, b) in local.contacts().iter().zip(&modes.contacts()) {
                assert_eq!(a.resting, b.resting, "{round}");
                assert!((a.force - b.force).abs() < 1e-10 && (a.place - b.place).abs() < 1e-11, "{round} {a:?} {b:?}");
            }
            assert!(local.balance().is_none() && modes.balance().is_none());
            // Modes of complex shape do not know theirs.
            if let (Some(own), Some(of_modes)) = (local.energy(), modes.energy()) {
                assert!((own - of_modes).abs() < 1e-11 * (1.0 + own), "{round}: {own} {of_modes}");
                energies += 1;
            }
            quiet += 1;
        }
    }
    println!("{impacts} events, {rests} of rest, {quiet} runs to their ends, {energies} energies");
    assert!(impacts > 1000 && rests > 20 && quiet > 100 && energies > 20, "{impacts} {rests} {quiet} {energies}");
}

/// A long row of any ends in which every mass has stops, and may hit.
fn row(random: &mut Random) -> (DampedChain, Vec<f64>, Vec<f64>) {
    let sites = 50 + random.below(30);
    let uniform = random.chance(0.5);
    let load = |random: &mut Random| {
        let phase = random.between(0.0, 6.0);
        (0..sites).map(|n| C::cis(if uniform { 0.0 } else { phase + 0.3 * n as f64 }) * 0.4).collect::<Vec<C>>()
    };
    let stop =
        Contact { lower: Some(-0.6), upper: Some(random.between(0.5, 1.4)), restitution: random.of(&[0.6, 0.9, 1.0]) };
    let chain = DampedChain {
        gamma1: 0.2,
        gamma2: random.between(0.03, 0.12),
        damping: random.of(&[0.0, 0.01, 0.1]),
        coupling_damping: random.of(&[0.0, 0.02]),
        contacts: (0..sites).map(|n| (vec![(n, 1.0)], stop)).collect(),
        static_load: if random.chance(0.5) { vec![0.1; sites] } else { Vec::new() },
        loads: if random.chance(0.7) { vec![(1, load(random)), (2, load(random))] } else { Vec::new() },
        ..DampedChain::new(sites, RowEnds::ALL[random.below(4)])
    };
    let place = (0..sites).map(|_| random.between(-0.4, 0.4)).collect();
    let velocity = (0..sites).map(|_| if random.chance(0.3) { random.between(-1.5, 1.5) } else { 0.0 }).collect();
    (chain, place, velocity)
}

/// A row by local series and by its modes, to a part of a period.
struct Both {
    local: Simulation,
    modes: Simulation,
    /// Events that both have.
    count: usize,
    /// Neither has more.
    is_whole: bool,
}

/// Runs a row both ways, whose events agree.
fn both(chain: &DampedChain, [place, velocity]: [&[f64]; 2], part: f64, round: usize) -> Both {
    let modal = chain.modal().unwrap();
    let xi = chain.project(&modal, place, velocity).unwrap();
    let of = |structure: ModalStructure| {
        let mut simulation = Simulation::of_modes(structure, 1.5, 0.4, &xi).unwrap();
        let (_, events) = simulation.collect(&until(&simulation, 0, part));
        (events, simulation)
    };
    let ((one, local), (two, modes)) = (of(modal.clone()), of(of_modes(&modal)));
    let (count, worst) = compare(&one, &two, &format!("{round}"));
    assert!(worst < 1e-11, "{round}: {worst:e} of {count}");
    Both { local, modes, count, is_whole: count == one.len() && count == two.len() }
}

/// What an impact starts anew is a part of the row; the others' series go on.
#[test]
fn parts_of_a_row_fly_as_all_modes_do() {
    let mut random = Random(79);
    let (mut impacts, mut restarts, mut windows, mut ends) = (0, 0, 0, 0);
    for round in 0..40 {
        let (chain, place, velocity) = row(&mut random);
        let Both { local, modes, count, is_whole } = both(&chain, [&place, &velocity], 0.8, round);
        let work = local.work();
        (impacts, restarts, windows) = (impacts + count, restarts + work.restarts, windows + work.windows);
        if is_whole {
            let (a, b) = (local.state(), modes.state());
            let pairs = a.displacement.iter().zip(&b.displacement).chain(a.velocity.iter().zip(&b.velocity));
            let apart = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-11, "{round}: {apart:e}");
            ends += 1;
        }
    }
    println!("{impacts} events, {restarts} parts, {windows} windows, {ends} runs to their ends");
    assert!(
        impacts > 800 && restarts > 800 && restarts > 2 * windows && ends > 20,
        "{impacts} {restarts} {windows} {ends}"
    );
}

/// The same of masses that rest on their barriers, pressed there, between those that hit: the force on each is what modes tell, and parts restart
/// beside them.
#[test]
fn parts_of_a_row_restart_beside_masses_at_rest() {
    let mut random = Random(81);
    let (mut impacts, mut restarts, mut windows, mut forces) = (0, 0, 0, 0);
    for round in 0..12 {
        let (mut chain, mut place, mut velocity) = row(&mut random);
        let sites = chain.contacts.len();
        let upper = chain.contacts[0].1.upper.unwrap();
        let is_pressed = |n: usize| n % 9 == 4;
        chain.static_load = (0..sites).map(|n| if is_pressed(n) { 3.0 } else { 0.1 }).collect();
        for n in (0..sites).filter(|n| is_pressed(*n)) {
            (place[n], velocity[n]) = (upper, 0.0);
        }
        let Both { local, modes, count, is_whole } = both(&chain, [&place, &velocity], 0.5, round);
        let work = local.work();
        (impacts, restarts, windows) = (impacts + count, restarts + work.restarts, windows + work.windows);
        if is_whole {
            for (a, b) in local.contacts().iter().zip(&modes.contacts()) {
                assert_eq!(a.resting, b.resting, "{round}");
                assert!((a.force - b.force).abs() < 1e-10, "{round} {a:?} {b:?}");
                forces += usize::from(a.force < -1.0);
            }
        }
    }
    println!("{impacts} events, {restarts} parts, {windows} windows, {forces} forces");
    assert!(impacts > 200 && restarts > 2 * windows && forces > 30, "{impacts} {restarts} {windows} {forces}");
}

/// Rows beside each other, with springs from row to row.
#[test]
fn layers_fly_as_their_modes_do() {
    let mut random = Random(82);
    let (mut events, mut rests, mut ends) = (0, 0, 0);
    for round in 0..40 {
        let (layers, layer_ends) = (2 + random.below(3), [Ends::Closed, Ends::Free, Ends::Fixed][random.below(3)]);
        let one = chain(&mut random);
        let sites = one.sites * layers;
        let load = |random: &mut Random| (0..sites).map(|_| C::new(random.between(-1.5, 1.5), 0.3)).collect::<Vec<C>>();
        let chain = DampedChain {
            layers,
            layer_ends,
            gamma3: random.between(0.0, 0.4),
            contacts: (0..sites).map(|n| (vec![(n, 1.0)], stop(&mut random))).collect(),
            static_load: Vec::new(),
            loads: vec![(1, load(&mut random))],
            ..one
        };
        let Ok(modal) = chain.modal() else { continue };
        let xi: Vec<[f64; 2]> = modal.modes().iter().map(|_| [0.0, random.between(-0.3, 0.3)]).collect();
        if Simulation::of_modes(modal.clone(), 0.9, 0.4, &xi).is_err() {
            continue;
        }
        let ((one, local), (two, modes)) = (run(modal.clone(), 0.9, &xi), run(of_modes(&modal), 0.9, &xi));
        if !local.flight().is_local() {
            continue;
        }
        assert!(!modes.flight().is_local());
        let (count, worst) = compare(&one, &two, &format!("{round}"));
        assert!(worst < 1e-11, "{round}: {worst:e} of {count}");
        events += count;
        rests += one[..count].iter().filter(|event| event.kind != EventKind::Impact).count();
        ends += usize::from(count == one.len() && count == two.len());
    }
    println!("{events} events, {rests} of rest, {ends} runs to their ends");
    assert!(events > 100 && rests > 0 && ends > 0, "{events} {rests} {ends}");
}

/// Tangent vectors see neither that parts are restarted nor change the run, and are those of flight by modes.
#[test]
fn tangents_of_a_row_in_parts_are_those_of_modes() {
    let mut random = Random(80);
    let mut compared = 0;
    for round in 0..12 {
        let (chain, place, velocity) = row(&mut random);
        let modal = chain.modal().unwrap();
        let xi = chain.project(&modal, &place, &velocity).unwrap();
        let direction = [(); 2].map(|()| xi.iter().map(|_| random.between(-1.0, 1.0)).collect::<Vec<f64>>());
        let of = |structure: &ModalStructure| {
            let mut simulation = Simulation::of_modes(structure.clone(), 1.5, 0.4, &xi).unwrap();
            let mut tangents = simulation.tangents_along(std::slice::from_ref(&direction)).unwrap();
            let (limits, mut events) = (until(&simulation, 0, 0.3), Vec::new());
            let report = simulation.run_with(&mut tangents, &limits, |event| events.push(*event)).unwrap();
            let grown = tangents.growth()[0].exp();
            let vector: Vec<f64> = tangents.vector(0).unwrap().iter().flatten().map(|x| x * grown).collect();
            (report, events, vector, tangents.has_grazed())
        };
        let (report, events, vector, grazed) = of(&modal);
        let mut bare = Simulation::of_modes(modal.clone(), 1.5, 0.4, &xi).unwrap();
        let (alone, same) = bare.collect(&until(&bare, 0, 0.3));
        assert_eq!((alone.work, same), (report.work, events.clone()));
        let (_, others, by_modes, _) = of(&of_modes(&modal));
        if grazed || events.iter().any(is_slow) || events.len() != others.len() || report.work.restarts == 0 {
            continue;
        }
        let size = vector.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        let apart = vector.iter().zip(&by_modes).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-9 * size, "{round}: {apart:e} of {size}");
        compared += 1;
    }
    assert!(compared >= 4, "{compared}");
}

/// Exponentials of the state matrix and bisection.
#[test]
fn local_series_hit_where_exponentials_and_bisection_hit() {
    let mut random = Random(78);
    let mut compared = 0;
    for _ in 0..40 {
        let mut structure = sparse(&mut random);
        structure.contacts.iter_mut().for_each(|(_, stop)| stop.restitution = random.between(0.5, 1.0));
        let n = structure.mass.nrows();
        let modal = structure.modal().unwrap();
        let (omega, q) = (random.between(0.4, 1.5), DVector::zeros(n));
        let v = DVector::from_fn(n, |_, _| random.between(-1.0, 1.0));
        let xi = structure.project(&modal, &q, &v).unwrap();
        let mut simulation = Simulation::of_modes(modal, omega, 0.4, &xi).unwrap();
        let (_, events) = simulation.collect(&Limits { impacts: 12, ..until(&simulation, 3, 0.0) });
        let reach = events.last().map_or(0.0, |event| event.time.to_f64());
        let dense = Dense::new(&structure, omega, 0.4, &q, &v).impacts(reach + 1e-6, 2e-3);
        for (event, (contact, time, velocity)) in events.iter().zip(&dense) {
            if event.kind != EventKind::Impact || event.velocity_before.abs() < 0.05 {
                break;
            }
            assert_eq!(event.contact, *contact, "{event:?} {time}");
            assert!((event.time.to_f64() - time).abs() < 1e-9, "{event:?} {time}");
            assert!((event.velocity_before - velocity).abs() < 1e-9, "{event:?} {velocity}");
            compared += 1;
        }
    }
    assert!(compared >= 80, "{compared}");
}

/// Without losses and loads the energy of a ring in which all masses hit stays what it is, whether all restart or parts, and the balance adds up where there are dashpots.
#[test]
fn local_series_keep_the_energy() {
    for (sites, damping) in [(21, 0.0), (101, 0.0), (21, 0.02)] {
        let stop = Contact { lower: Some(-0.6), upper: Some(1.4), restitution: if damping == 0.0 { 1.0 } else { 0.9 } };
        let chain = DampedChain {
            gamma1: 0.2,
            gamma2: 0.1,
            damping,
            contacts: (0..sites).map(|n| (vec![(n, 1.0)], stop)).collect(),
            loads: if damping == 0.0 { Vec::new() } else { vec![(1, vec![C::new(0.3, 0.1); sites])] },
            ..DampedChain::new(sites, RowEnds::ALL[0])
        };
        let modal = chain.modal().unwrap();
        let wave = |k: f64| (0..sites).map(|n| (n as f64 * k).sin()).collect::<Vec<_>>();
        let xi =
            chain.project(&modal, &wave(1.3).iter().map(|x| 0.4 + 0.5 * x).collect::<Vec<_>>(), &wave(2.1)).unwrap();
        let form = modal.energy_form().unwrap();
        let simulation = Simulation::of_modes(modal, 1.5, 0.0, &xi).unwrap();
        let mut simulation = if damping == 0.0 { simulation } else { simulation.with_balance(form.clone()) };
        let start = form.energy(&xi);
        let report =
            simulation.run(&until(&simulation, if damping == 0.0 { 42_000 / sites as u64 } else { 50 }, 0.0), |_| {});
        assert_eq!(report.outcome, Outcome::TimeReached);
        let change = form.energy(&simulation.state().modes) - start;
        let missing =
            simulation.balance().map_or(change, |balance| change - (balance.work - balance.dashpots - balance.impacts));
        println!("{} impacts, {} parts, {missing:e} of {start}", report.work.impacts, report.work.restarts);
        assert!(sites < 64 || report.work.restarts > report.work.impacts / 2, "{report:?}");
        assert!(report.work.impacts > 500 && missing.abs() < 1e-12 * start, "{report:?} {missing:e}");
    }
}

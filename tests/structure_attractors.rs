//! What random structures settle on in a simulation, against dense matrices that share no code: exponentials with loads, saltations, samples.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use vibrochain_breather::{Hit, LoadedStructure, Orbit, Word, admissibility};
use vibrochain_eventsim::{Event, EventKind, Limits, Outcome, Simulation};
use vibrochain_floquet::{Complex, Tolerance, stability};
use vibrochain_lattice::{Barrier, Contact, Structure};
use vibrochain_testkit::{Random, Structure as Dense, StructureImpact};

/// Impacts of the longest word that is looked for, and periods of the force.
const LONGEST: usize = 16;
const PERIODS: u32 = 8;

/// Two to twelve coordinates, one to four contacts, any damping; the orbit is still to be found.
fn random_structure(random: &mut Random) -> Dense {
    let n = 2 + random.below(11);
    let square = |random: &mut Random| {
        let factor = DMatrix::from_fn(n, n, |_, _| random.between(-1.0, 1.0));
        &factor * factor.transpose() / n as f64
    };
    let mass = square(random) * 0.3 + DMatrix::from_diagonal(&DVector::from_fn(n, |_, _| random.between(0.5, 2.0)));
    let stiffness = square(random) + DMatrix::identity(n, n) * random.between(0.05, 1.0);
    let damping = match random.below(3) {
        0 => &mass * random.log(0.01, 0.5) + &stiffness * random.log(0.01, 0.3),
        1 => square(random) * random.log(0.05, 3.0) + &mass * 0.01,
        // One strong dashpot, and a little everywhere.
        _ => {
            let w = DVector::from_fn(n, |_, _| random.between(-1.0, 1.0));
            &w * w.transpose() * random.log(0.1, 10.0) + &mass * random.log(0.02, 0.2)
        }
    };
    let contacts = (0..1 + random.below(4))
        .map(|_| {
            let (i, j) = (random.below(n), random.below(n));
            match random.below(3) {
                0 => DVector::from_fn(n, |k, _| f64::from(u8::from(k == i))),
                1 if i != j => DVector::from_fn(n, |k, _| f64::from(u8::from(k == i)) - f64::from(u8::from(k == j))),
                _ => DVector::from_fn(n, |_, _| random.between(-1.0, 1.0)),
            }
        })
        .collect();
    let omega = random.between(0.4, 2.0);
    Dense {
        load: DVector::from_fn(n, |_, _| random.between(-1.0, 1.0)),
        static_load: DVector::from_fn(n, |_, _| random.between(-0.1, 0.1)),
        physical: true,
        ..Dense::without_orbit([mass, damping, stiffness], contacts, omega)
    }
}

/// (q, q′, cos, sin, 1) of the structure between impacts: a linear flow.
fn flow(dense: &Dense) -> DMatrix<f64> {
    let n = dense.size();
    let inverse = dense.mass.clone().try_inverse().unwrap();
    let mut flow = DMatrix::zeros(2 * n + 3, 2 * n + 3);
    flow.view_mut((0, n), (n, n)).fill_with_identity();
    flow.view_mut((n, 0), (n, n)).copy_from(&-(&inverse * &dense.stiffness));
    flow.view_mut((n, n), (n, n)).copy_from(&-(&inverse * &dense.damping));
    flow.view_mut((n, 2 * n), (n, 1)).copy_from(&(&inverse * &dense.load));
    flow.view_mut((n, 2 * n + 2), (n, 1)).copy_from(&(&inverse * &dense.static_load));
    (flow[(2 * n, 2 * n + 1)], flow[(2 * n + 1, 2 * n)]) = (-dense.omega, dense.omega);
    flow
}

/// Places of all contacts without impacts, over a period: their least and their most.
fn free_motion(dense: &Dense) -> Vec<(f64, f64)> {
    let n = dense.size();
    let part = (flow(dense) * (TAU / dense.omega / 64.0)).exp();
    let period = (0..6).fold(part.clone(), |whole, _| &whole * &whole);
    // The steady motion is what many periods leave.
    let settled = (0..16).fold(period, |whole, _| &whole * &whole);
    let mut z = DVector::zeros(2 * n + 3);
    (z[2 * n], z[2 * n + 2]) = (1.0, 1.0);
    z = settled * z;
    let mut ranges = vec![(f64::INFINITY, f64::NEG_INFINITY); dense.contacts.len()];
    for _ in 0..64 {
        for (w, (low, high)) in dense.contacts.iter().zip(&mut ranges) {
            let place = w.dot(&z.rows(0, n));
            (*low, *high) = (low.min(place), high.max(place));
        }
        z = &part * z;
    }
    ranges
}

/// Stops within the free motion, on one side or two.
fn stops(dense: &Dense, random: &mut Random) -> Vec<Contact> {
    free_motion(dense)
        .into_iter()
        .map(|(low, high)| {
            let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
            let restitution = random.between(0.1, 0.95);
            let [lower, upper] = [-1.0, 1.0].map(|side| middle + side * half * random.between(0.3, 1.2));
            match random.below(3) {
                0 => Contact { lower: Some(lower), upper: None, restitution },
                1 => Contact { lower: None, upper: Some(upper), restitution },
                _ => Contact { lower: Some(lower), upper: Some(upper), restitution },
            }
        })
        .collect()
}

/// The last impacts, if they are those before them so many periods earlier: how many they are, and the periods.
fn repetition(events: &[Event], period: f64) -> Option<(usize, u32)> {
    let last = events.len().checked_sub(1)?;
    let alike = |a: &Event, b: &Event, lapse: f64| {
        (a.contact, a.barrier) == (b.contact, b.barrier)
            && (a.time.to_f64() - b.time.to_f64() - lapse).abs() < 1e-8 * period
            && (a.impulse - b.impulse).abs() < 1e-7 * a.impulse.abs()
    };
    (1..=PERIODS).flat_map(|periods| (1..=LONGEST).map(move |count| (count, periods))).find(|&(count, periods)| {
        let lapse = period * f64::from(periods);
        last + 1 >= 2 * count && (0..count).all(|i| alike(&events[last - i], &events[last - i - count], lapse))
    })
}

/// What becomes of a structure: an orbit, or why there is none.
fn settled(dense: &Dense, structure: &Structure, random: &mut Random) -> Result<(Vec<Event>, u32), &'static str> {
    let (n, period) = (dense.size(), TAU / dense.omega);
    let modal = structure.modal().unwrap();
    let still = dense.stiffness.clone().lu().solve(&dense.static_load).unwrap();
    let mut why = "the start is beyond a stop";
    for (start, periods) in [(0.0, 300), (0.3, 300), (1.0, 300), (0.0, 2000)] {
        let v = DVector::from_fn(n, |_, _| start * random.between(-1.0, 1.0));
        let xi = structure.project(&modal, &still, &v).unwrap();
        let Ok(mut simulation) = Simulation::of_modes(modal.clone(), dense.omega, 0.0, &xi) else { continue };
        let until = simulation.time_of(periods, 0.0);
        let report = simulation.run(&Limits { until: Some(until), ..Limits::default() }, |_| {});
        if report.outcome != Outcome::TimeReached {
            why = "contacts meet, or a cascade";
            continue;
        }
        let until = simulation.time_of(periods + 2 * u64::from(PERIODS) + 1, 0.0);
        let (report, events) = simulation.collect(&Limits { until: Some(until), ..Limits::default() });
        if report.outcome != Outcome::TimeReached {
            why = "contacts meet, or a cascade";
        } else if events.iter().any(|event| event.kind != EventKind::Impact) {
            why = "contacts rest";
        } else if events.is_empty() {
            why = "no impacts";
        } else if let Some((count, periods)) = repetition(&events, period) {
            return Ok((events[events.len() - count..].to_vec(), periods));
        } else {
            why = "no repetition";
        }
    }
    Err(why)
}

/// What was compared, and the worst of it.
#[derive(Debug, Default)]
struct Tally {
    checked: usize,
    /// The worst of places and Newton's law, and of multipliers; and in how many structures either is beyond 1e-9, where dense exponentials
    /// of strong dashpots lose digits.
    residual: f64,
    multipliers: f64,
    loose: usize,
    /// Orbits in complete lists of up to three impacts, by their number.
    listed: [usize; 4],
    without: BTreeMap<&'static str, usize>,
}

impl Tally {
    fn check(&mut self, mut dense: Dense, structure: &Structure, events: &[Event], periods: u32) {
        let force = TAU / dense.omega;
        let model = LoadedStructure::new(Arc::new(structure.modal().unwrap()), dense.omega).unwrap();
        let first = events[0].time.to_f64();
        let impact = |event: &Event| Hit::new(event.contact, event.barrier, event.time.to_f64() - first, event.impulse);
        let impacts: Vec<_> = events.iter().map(impact).collect();
        let orbit = model.orbit_near(periods, first.rem_euclid(force), &impacts).unwrap();
        let case = format!("{} {dense:?}", self.checked);
        for (own, event) in orbit.impacts().iter().zip(&impacts) {
            let off = (own.time - event.time).abs() / force + (own.impulse - event.impulse).abs() / event.impulse.abs();
            assert!(off < 1e-4, "{off:e} {case}");
        }
        assert!(orbit.residual() < 1e-11, "{:e} {case}", orbit.residual());
        assert!(admissibility(&orbit).unwrap().is_physical(), "{case}");
        // Places, Newton's law and multipliers by dense matrices.
        (dense.psi, dense.period) = (orbit.psi().unwrap(), orbit.period());
        let limits = &structure.contacts;
        dense.impacts = (orbit.impacts().iter())
            .map(|impact| StructureImpact {
                contact: impact.site,
                time: impact.time,
                impulse: impact.impulse,
                restitution: limits[impact.site].1.restitution,
                stop: limits[impact.site].1.barrier(impact.barrier).unwrap(),
            })
            .collect();
        let mut worst: f64 = 0.0;
        for (i, (before, impact)) in dense.before().iter().zip(&dense.impacts).enumerate() {
            let newton = impact.impulse / dense.effective_mass(i) + (1.0 + impact.restitution) * before.velocity;
            let off = (before.place - impact.stop).abs().max(newton.abs());
            (self.residual, worst) = (self.residual.max(off), worst.max(off));
            assert!(off < 1e-6, "{off:e} {case}");
        }
        let stability = stability(&orbit, Tolerance::Rounding).unwrap();
        let mut open: Vec<_> = dense.monodromy().complex_eigenvalues().iter().copied().collect();
        assert_eq!(stability.multipliers.len(), open.len(), "{case}");
        for z in &stability.multipliers {
            let distance = |w: &Complex<f64>| (w - z).norm();
            let nearest = (0..open.len()).min_by(|&i, &j| distance(&open[i]).total_cmp(&distance(&open[j]))).unwrap();
            let off = distance(&open.swap_remove(nearest));
            (self.multipliers, worst) = (self.multipliers.max(off), worst.max(off));
            assert!(off < 1e-6, "{z} {off:e} {case}");
        }
        self.loose += usize::from(worst > 1e-9);
        // What a run settles on is not unstable.
        assert!(stability.multipliers.iter().all(|z| z.norm() < 1.0 + 1e-6), "{case}");
        self.stays_inside(&dense, structure, &case);
        self.is_listed(&model, &orbit, periods, &case);
        self.checked += 1;
    }

    /// Contacts at many instants between the impacts.
    fn stays_inside(&self, dense: &Dense, structure: &Structure, case: &str) {
        let (n, flow) = (dense.size(), flow(dense));
        let inverse = dense.mass.clone().try_inverse().unwrap();
        for (i, (impact, state)) in dense.impacts.iter().zip(dense.states()).enumerate() {
            let next = dense.impacts.get(i + 1).map_or(dense.period, |next| next.time);
            let steps = 200;
            let step = (&flow * ((next - impact.time) / f64::from(steps))).exp();
            let (sin, cos) = (dense.omega * (impact.time + dense.psi)).sin_cos();
            let mut z =
                DVector::from_fn(2 * n + 3, |k, _| if k < 2 * n { state[k] } else { [cos, sin, 1.0][k - 2 * n] });
            let mut velocity = z.rows_mut(n, n);
            velocity += &inverse * &dense.contacts[impact.contact] * impact.impulse;
            for _ in 0..steps {
                for (w, stops) in &structure.contacts {
                    let room = stops.room(w.dot(&z.rows(0, n)));
                    assert!(room > -1e-7, "{room:e} {case}");
                }
                z = &step * z;
            }
        }
    }

    /// A complete list of its word has it.
    fn is_listed(&mut self, model: &LoadedStructure, orbit: &Orbit, periods: u32, case: &str) {
        let (n, period) = (orbit.impacts().len(), orbit.period());
        if n > 3 {
            return;
        }
        let name = |barrier: Barrier| if barrier == Barrier::Upper { '+' } else { '-' };
        let word: Vec<_> =
            orbit.impacts().iter().map(|impact| format!("{}{}", impact.site, name(impact.barrier))).collect();
        let word: Word = word.join(",").parse().unwrap();
        let found = model.orbits(&word, periods).unwrap();
        if !found.completeness.is_established() {
            return;
        }
        let apart = |orbit: &Orbit, i: usize| {
            orbit.impacts().get(i + 1).map_or(period, |next| next.time) - orbit.impacts()[i].time
        };
        let is_it = |other: &Orbit, turn: usize| {
            (0..n).all(|i| {
                let (a, b) = (&orbit.impacts()[i], &other.impacts()[(i + turn) % n]);
                let off = (apart(orbit, i) - apart(other, (i + turn) % n)).abs() / period;
                a.site == b.site && off + (a.impulse - b.impulse).abs() / a.impulse.abs() < 1e-6
            })
        };
        // Next to a doubling, a run that still settles has led to the orbit of half the period.
        if (1..n).any(|turn| is_it(orbit, turn)) {
            return;
        }
        let is_there = found.orbits.iter().any(|other| (0..n).any(|turn| is_it(other, turn)));
        let list: Vec<_> = found.orbits.iter().map(Orbit::impacts).collect();
        assert!(is_there, "{word} over {periods}: {:?} not in {list:?}: {case}", orbit.impacts());
        self.listed[n] += 1;
    }
}

fn attractors(seed: u64, wanted: usize) -> Tally {
    let mut random = Random(seed);
    let mut tally = Tally::default();
    while tally.checked < wanted {
        let mut dense = random_structure(&mut random);
        let limits = stops(&dense, &mut random);
        dense.limits = limits.iter().map(|stops| (stops.lower, stops.upper, stops.restitution)).collect();
        let structure = dense.linear();
        match settled(&dense, &structure, &mut random) {
            Ok((events, periods)) => tally.check(dense, &structure, &events, periods),
            Err(why) => *tally.without.entry(why).or_default() += 1,
        }
        assert!(tally.without.values().sum::<usize>() <= 2 * wanted + 20, "{tally:?}");
    }
    println!("{tally:?}");
    tally
}

#[test]
fn what_random_structures_settle_on_is_an_orbit_of_dense_matrices() {
    let tally = attractors(1000, 16);
    assert!(tally.listed[1] > 3 && tally.loose < 2, "{tally:?}");
}

#[test]
#[ignore = "a thousand structures take minutes"]
fn slow_what_a_thousand_random_structures_settle_on_is_an_orbit_of_dense_matrices() {
    let parts: Vec<Tally> = std::thread::scope(|scope| {
        let runs: Vec<_> = (0..4).map(|part| scope.spawn(move || attractors(1000 + part, 250))).collect();
        runs.into_iter().map(|run| run.join().unwrap()).collect()
    });
    let sum = |of: &dyn Fn(&Tally) -> usize| parts.iter().map(of).sum::<usize>();
    assert_eq!(sum(&|part| part.checked), 1000);
    assert!((1..4).all(|n| sum(&|part| part.listed[n]) > 10), "{parts:?}");
    assert!(sum(&|part| part.loose) <= 20, "{parts:?}");
}

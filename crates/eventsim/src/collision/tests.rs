//! Impacts at one instant, against plain numbers in every order.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_lattice::{Contact as Stops, LinearMode, ModalStructure, ModeShape};
use vibrochain_testkit::Random;

use super::*;
use crate::flight::system::System;

/// What contacts are made to do at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Made {
    Hits,
    Grazes,
    Touches,
    Rests,
    Away,
}

/// Contacts with velocities and mobilities as plain numbers.
struct Plain {
    made: Vec<Made>,
    sign: Vec<f64>,
    restitution: Vec<f64>,
    velocity: Vec<f64>,
    mobility: Vec<Vec<f64>>,
    /// A decision was too close to tell.
    close: bool,
}

impl Plain {
    /// Impacts of each contact and velocities at the end, where of those that may hit the first in `order` does; none: it does not end.
    fn settled(&mut self, order: &[usize]) -> Option<(Vec<usize>, Vec<f64>)> {
        let (mut v, mut impacts) = (self.velocity.clone(), vec![0; order.len()]);
        for _ in 0..2000 {
            let is_due = |c: usize| matches!(self.made[c], Made::Hits | Made::Grazes) && impacts[c] == 0;
            let outward = |c: usize| self.sign[c] * v[c];
            let is_at = |c: usize| self.made[c] != Made::Away;
            self.close |= order.iter().any(|&c| is_at(c) && outward(c) != 0.0 && outward(c).abs() < 1e-6);
            let Some(&c) = order.iter().find(|&&c| is_at(c) && (is_due(c) || outward(c) > 1e-9)) else {
                return Some((impacts, v));
            };
            let change = -(1.0 + self.restitution[c]) * self.sign[c] * outward(c).max(0.0);
            let impulse = change / self.mobility[c][c];
            v.iter_mut().enumerate().for_each(|(other, v)| *v += self.mobility[other][c] * impulse);
            // What rounding leaves of none is none.
            v[c] = if self.restitution[c] == 0.0 { 0.0 } else { v[c] };
            impacts[c] += 1;
        }
        None
    }
}

fn orders(of: &[usize]) -> Vec<Vec<usize>> {
    if of.is_empty() {
        return vec![vec![]];
    }
    let first = |&c: &usize| {
        let rest: Vec<usize> = of.iter().copied().filter(|other| *other != c).collect();
        orders(&rest).into_iter().map(move |rest| [&[c], &rest[..]].concat())
    };
    of.iter().flat_map(first).collect()
}

/// Contacts of random weights, some with coordinates in common, at their barriers at one instant.
fn made(random: &mut Random) -> (Motion, Vec<Made>) {
    let (modes, count) = (2 + random.below(5), 2 + random.below(3));
    let part = random.between(0.0, 0.8);
    let shapes: Vec<Vec<f64>> = (0..count)
        .map(|_| {
            let mut shape: Vec<f64> =
                (0..modes).map(|_| if random.chance(part) { random.between(-1.0, 1.0) } else { 0.0 }).collect();
            shape[random.below(modes)] = random.between(0.2, 1.0);
            shape
        })
        .collect();
    let rates: Vec<f64> = (0..modes).map(|_| random.between(0.5, 3.0)).collect();
    let restitution: Vec<f64> =
        (0..count).map(|_| [random.between(0.1, 1.0), 1.0, 0.0][random.below(10) / 4]).collect();
    let made: Vec<Made> = (0..count)
        .map(|_| {
            [Made::Hits, Made::Hits, Made::Hits, Made::Grazes, Made::Touches, Made::Touches, Made::Rests, Made::Away]
        })
        .map(|all| all[random.below(8)])
        .collect();
    let xi: Vec<[f64; 2]> = (0..modes).map(|_| [random.between(-1.0, 1.0), random.between(-1.0, 1.0)]).collect();
    let build = |stops: Vec<Stops>| {
        let mode = |k: usize| {
            let contacts = shapes.iter().map(|shape| shape[k]).collect();
            let shape = ModeShape { contacts, coordinates: Vec::new(), still: 0.0 };
            LinearMode::oscillator(0.01, rates[k] * rates[k], &shape, &[])
        };
        let structure = ModalStructure::new(stops, Vec::new(), (0..modes).map(mode).collect()).unwrap();
        Motion::new(System::new(structure.into(), 1.0, 0.0), &xi)
    };
    let stand = |motion: &mut Motion, sides: &[Barrier]| {
        for c in 0..count {
            if made[c] != Made::Away {
                let touch = if made[c] == Made::Rests { Contact::Resting(sides[c]) } else { Contact::Free };
                motion.places.set(c, Place { reference: Some(sides[c]), x: 0.0, v: None, touch });
            }
        }
        let grazing: Vec<usize> = (0..count).filter(|c| made[*c] == Made::Grazes).collect();
        motion.hold(&grazing);
        for c in (0..count).filter(|c| matches!(made[*c], Made::Hits | Made::Touches)) {
            motion.places.set_velocity(c, motion.flight.velocity(&motion.system, c));
        }
    };
    let free = |c: usize| Stops { lower: None, upper: Some(1e3), restitution: restitution[c] };
    let mut motion = build((0..count).map(free).collect());
    stand(&mut motion, &vec![Barrier::Upper; count]);
    // On the side to which it moves, or from which.
    let sides: Vec<Barrier> = (0..count)
        .map(|c| {
            let outward = motion.flight.velocity(&motion.system, c) > 0.0;
            let is_upper = match made[c] {
                Made::Hits => outward,
                Made::Touches => !outward,
                _ => random.chance(0.5),
            };
            if is_upper { Barrier::Upper } else { Barrier::Lower }
        })
        .collect();
    let at = |c: usize| {
        let place = motion.flight.place(&motion.system, c);
        let (lower, upper) = match (made[c], sides[c]) {
            (Made::Away, _) => (None, Some(place + 1.0)),
            (_, Barrier::Upper) => (None, Some(place)),
            (_, Barrier::Lower) => (Some(place), None),
        };
        Stops { lower, upper, restitution: restitution[c] }
    };
    let mut motion = build((0..count).map(at).collect());
    stand(&mut motion, &sides);
    motion.due = (0..count)
        .filter(|c| matches!(made[*c], Made::Hits | Made::Grazes))
        .map(|contact| Due { contact, barrier: sides[contact], release: false, pull: None })
        .collect();
    (motion, made)
}

/// Where no conflict is told, contacts hit once each in whatever order, to the same end; where one is, some order makes another one hit.
#[test]
fn impacts_at_one_instant_without_a_conflict_commute() {
    let mut random = Random(61);
    let (mut free, mut met, mut together) = (0, 0, 0);
    for round in 0..20_000 {
        let (mut motion, made) = made(&mut random);
        let count = made.len();
        if motion.due.is_empty() {
            continue;
        }
        let side = |c: usize| motion.places[c].reference.map_or(1.0, Barrier::sign);
        let velocity =
            |motion: &Motion, c: usize| motion.places[c].v.unwrap_or_else(|| motion.flight.velocity(&motion.system, c));
        let mut plain = Plain {
            sign: (0..count).map(side).collect(),
            restitution: (0..count).map(|c| motion.system.restitution(c)).collect(),
            velocity: (0..count).map(|c| velocity(&motion, c)).collect(),
            mobility: (0..count).map(|i| (0..count).map(|j| motion.system.mobility(i, j)).collect()).collect(),
            close: false,
            made: made.clone(),
        };
        let ends: Vec<_> = orders(&(0..count).collect::<Vec<_>>()).iter().map(|order| plain.settled(order)).collect();
        if plain.close {
            continue;
        }
        let is_hit = |c: usize| matches!(made[c], Made::Hits | Made::Grazes);
        let once: Vec<usize> = (0..count).map(|c| usize::from(is_hit(c))).collect();
        let is_free = ends.iter().all(|end| {
            end.as_ref().zip(ends[0].as_ref()).is_some_and(|((impacts, end), (_, other))| {
                *impacts == once && end.iter().zip(other).all(|(a, b)| (a - b).abs() < 1e-9)
            })
        });
        let Some((first, second)) = motion.conflict() else {
            assert!(is_free, "{round}: {made:?} {ends:?}");
            let mut changes = Vec::new();
            motion.collide(&mut changes).unwrap();
            let impacts = |c: usize| {
                changes.iter().filter(|change| change.contact == c && change.kind == EventKind::Impact).count()
            };
            assert!((0..count).all(|c| impacts(c) == once[c]), "{round}: {made:?} {changes:?}");
            let (_, end) = ends[0].as_ref().unwrap();
            for c in 0..count {
                let v = motion.flight.velocity(&motion.system, c);
                // Resting contacts may feel what the others do to them only where they leave.
                let is_held = matches!(motion.places[c].touch, Contact::Resting(_));
                assert!(is_held || (v - end[c]).abs() < 1e-9, "{round} {c}: {v} {end:?} {made:?}");
            }
            free += 1;
            continue;
        };
        assert!(is_hit(first) && first != second, "{round}: {made:?} {first} {second}");
        let shares = |i: usize, j: usize| i != j && is_hit(i) && is_hit(j) && plain.mobility[i][j] != 0.0;
        if (0..count).any(|i| (0..count).any(|j| shares(i, j))) {
            continue;
        }
        let hits = |c: usize| ends.iter().any(|end| end.as_ref().is_none_or(|(impacts, _)| impacts[c] > once[c]));
        assert!(hits(second), "{round}: {made:?} {first} {second} {ends:?}");
        met += 1;
        let push = |c: usize| {
            let impulse = -(1.0 + plain.restitution[c]) * plain.velocity[c] / plain.mobility[c][c];
            plain.sign[second] * plain.mobility[second][c] * impulse
        };
        let alone = (0..count).filter(|c| is_hit(*c)).map(push).fold(0.0, f64::max);
        together += usize::from(alone + plain.sign[second] * plain.velocity[second] <= 0.0);
    }
    println!("{free} without a conflict, {met} that push another one, {together} of them only together");
    assert!(free > 2000 && met > 1000 && together > 3, "{free} {met} {together}");
}

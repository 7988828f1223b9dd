//! What is told as the error of the equations of impacts by the shapes of modes is a bound: against equations of modes whose shapes are off
//! by as much, one of which a contact does not see at all.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_breather::{BlochEquations, LinearImpact, ShapeErrors};
use vibrochain_lattice::{Contact, LinearMode, ModalStructure, ModeShape};
use vibrochain_testkit::Random;

const CONTACTS: usize = 2;

/// Modes that swing, that creep, and some that die within a period.
fn modes(random: &mut Random) -> Vec<LinearMode> {
    let mut modes = Vec::new();
    let all_die = random.chance(0.3);
    for k in 0..2 + random.below(3) {
        let frequency = random.log(0.3, 6.0);
        let (decay, square) = match random.below(4) {
            _ if all_die => (random.between(60.0, 200.0), random.between(3e4, 6e4)),
            0 => (random.log(3.0, 60.0) * frequency, frequency * frequency),
            1 => (random.between(20.0, 90.0), frequency * frequency),
            _ => (random.log(1e-3, 0.4) * frequency, frequency * frequency),
        };
        let contacts = (0..CONTACTS).map(|c| if k == c { 0.0 } else { random.between(-1.0, 1.0) }).collect();
        let shape = ModeShape { contacts, ..ModeShape::default() };
        modes.push(LinearMode::oscillator(decay, square - decay * decay, &shape, &[]));
    }
    modes
}

fn length([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}

#[test]
fn errors_of_shapes_bound_what_shapes_that_are_off_make_of_the_equations() {
    let mut random = Random(83);
    let (mut unseen, mut sent, mut apart, mut checked, mut nearest) = (0, 0, 0, 0, 0.0f64);
    for _ in 0..400 {
        let off = 1e-7;
        let mut modes = modes(&mut random);
        for mode in &mut modes {
            mode.errors.rows = smallvec::smallvec![off; CONTACTS];
            mode.errors.columns = smallvec::smallvec![off; CONTACTS];
        }
        let mut moved = modes.clone();
        for pair in moved.iter_mut().flat_map(|mode| mode.rows.iter_mut().chain(&mut mode.columns)) {
            let angle = random.between(0.0, std::f64::consts::TAU);
            *pair = [pair[0] + off * angle.cos(), pair[1] + off * angle.sin()];
        }
        let period = random.between(1.0, 6.0);
        let impacts: Vec<LinearImpact> = (0..2 + random.below(2))
            .map(|i| LinearImpact {
                contact: random.below(CONTACTS),
                time: period * (i as f64 + random.between(0.0, 0.8)) / 3.0,
                impulse: random.between(0.3, 2.0),
                restitution: random.between(0.1, 1.0),
                acceleration_before: random.between(-1.0, 1.0),
            })
            .collect();
        let equations = [modes, moved].map(|modes| {
            let stop = Contact { lower: None, upper: Some(1.0), restitution: 0.8 };
            let structure = ModalStructure::new(vec![stop; CONTACTS], Vec::new(), modes).unwrap();
            BlochEquations::new(structure.participating_modes(&[0, 1]).kernel(period, &[0, 1]), impacts.clone())
        });
        let [own, other] = &equations;
        let (size, mut errors) = (own.size(), ShapeErrors::default());
        for (k, mode) in own.kernel().modes().iter().enumerate() {
            own.shape_errors(k, &mut errors);
            let [row_errors, column_errors] = &errors;
            let tables = [(own.rows(k), other.rows(k), row_errors), (own.columns(k), other.columns(k), column_errors)];
            for (own, other, errors) in tables {
                for (r, (a, b)) in own.iter().zip(other).enumerate() {
                    let (way, error) = ([a[0] - b[0], a[1] - b[1]], errors[r]);
                    let rounding = 1e-14 * (1.0 + length(*a));
                    if mode.coordinates == vibrochain_lattice::Coordinates::Apart {
                        (0..2).for_each(|i| assert!(way[i].abs() <= error[i] + rounding, "{a:?} {b:?} {error:?}"));
                        apart += 1;
                    } else {
                        assert!(length(way) <= error[0] + rounding, "{a:?} {b:?} {error:?}");
                        nearest = nearest.max(length(way) / error[0].max(1e-300));
                    }
                    unseen += usize::from(length(*a) == 0.0 && length(*b) > 0.0);
                    checked += 1;
                }
            }
        }
        for i in 0..impacts.len() {
            let [own_hit, other_hit] = equations.each_ref().map(|equations| {
                let contact = impacts[i].contact;
                equations.kernel().mobility(contact, contact) / (1.0 + impacts[i].restitution)
            });
            let told = own.hit_error(i);
            assert!((own_hit - other_hit).abs() <= told + 1e-13 * own_hit.abs(), "{own_hit} {other_hit} {told:e}");
        }
        // Where all modes die within a period the constant is all that there is.
        let all_dead = (0..own.kernel().modes().len()).all(|k| other.rows(k).iter().all(|row| length(*row) == 0.0));
        if all_dead && !own.sent_errors().is_empty() {
            let entries = own.constant(false).iter().zip(other.constant(false)).zip(own.sent_errors());
            for (at, ((a, b), error)) in entries.enumerate().filter(|(at, _)| (at / size) / 2 != (at % size) / 2) {
                // Numbers this small have no squares.
                assert!((a - b).abs() <= error + 1e-13 * a.abs() + 1e-100, "{at}: {a} {b} {error:e}");
                sent += usize::from((a - b).abs() > 1e-100);
            }
        }
    }
    assert!(
        checked > 5000 && unseen > 100 && apart > 200 && sent > 10 && nearest > 0.3,
        "{checked} {unseen} {apart} {sent} {nearest}"
    );
}

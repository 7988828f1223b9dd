//! Taylor series of a structure with contacts at rest.
//!
//! With σ = s/h the coefficients of ξ follow from dξ/dσ = h(Aξ + b + Σ columns·λ), order by order. A contact at rest has no acceleration,
//! so the coefficient λ_n of the forces solves w_iᵀM⁻¹w_j λ_n = −row·A(Aξ_n + b_n): a system of the size of what rests. Contacts beside a
//! barrier start from the distance and the velocity that are carried for them.

use crate::flight::loads::add;
use crate::flight::modal_flight::ModalFlight;
use crate::flight::places::Places;
use crate::flight::system::System;
use crate::units::{MAX_ORDER, inverse_factorials};
use crate::watch::Contact;
use vibrochain_lattice::Barrier;

/// Highest order that decides where a contact goes from rest.
pub(crate) const LOW: usize = 5;

/// h times the fastest rate: z^24/24! is below rounding.
const REACH: f64 = 1.9;

/// What the last two terms may add, relative to the largest.
const REMAINDER: f64 = f64::EPSILON / 8.0;

/// Halvings of a window until its series is short; damping that couples modes takes one or two.
const HALVINGS: u32 = 64;

type Coefficients = [f64; MAX_ORDER + 1];

/// A window of flight with forces at contacts.
#[derive(Debug, Clone)]
pub(crate) struct Series {
    /// h
    pub(crate) length: f64,
    xi: Vec<[[f64; 2]; MAX_ORDER + 1]>,
    /// Of x of each contact, in σ; 0 at rest.
    pub(crate) contacts: Vec<Coefficients>,
    /// Their rounding, of low orders.
    pub(crate) doubts: Vec<[f64; LOW + 1]>,
    /// On contacts at rest.
    pub(crate) forces: Vec<RestForce>,
    is_short: bool,
}

/// The force of a barrier on a contact at rest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RestForce {
    pub(crate) contact: usize,
    pub(crate) barrier: Barrier,
    /// In σ, positive while the barrier pushes.
    pub(crate) push: Coefficients,
}

impl Series {
    /// Of full order, as long as that allows.
    pub(crate) fn window(system: &System, flight: &ModalFlight, places: &Places) -> Self {
        let mut series = Self::new(system, flight, places, MAX_ORDER, REACH / system.fastest);
        for _ in 0..HALVINGS {
            if series.is_short {
                break;
            }
            series = Self::new(system, flight, places, MAX_ORDER, 0.5 * series.length);
        }
        series
    }

    /// Of low order: where contacts tend to.
    pub(crate) fn tendencies(system: &System, flight: &ModalFlight, places: &Places) -> Self {
        Self::new(system, flight, places, LOW, REACH / system.fastest)
    }

    fn new(system: &System, flight: &ModalFlight, places: &Places, order: usize, h: f64) -> Self {
        let inverse = inverse_factorials();
        let resting: Vec<(usize, Barrier)> = (places.iter().enumerate())
            .filter_map(|(contact, place)| match place.touch {
                Contact::Resting(barrier) => Some((contact, barrier)),
                _ => None,
            })
            .collect();
        let held: Vec<usize> = resting.iter().map(|(contact, _)| *contact).collect();
        let modes = system.modes();
        let mut xi = vec![[[0.0; 2]; MAX_ORDER + 1]; modes.len()];
        let mut doubt = vec![0.0; modes.len()];
        let mut forces = vec![[0.0; MAX_ORDER + 1]; held.len()];
        let mut contacts = vec![[0.0; MAX_ORDER + 1]; places.len()];
        let mut doubts = vec![[0.0; LOW + 1]; places.len()];
        let mut sizes = vec![[0.0; MAX_ORDER + 1]; places.len()];
        let norm = |y: [f64; 2]| y[0].abs() + y[1].abs();
        let mut rises = vec![[0.0; 2]; modes.len()];
        for n in 0..=order {
            for (k, mode) in modes.iter().enumerate() {
                if n == 0 {
                    (xi[k][0], doubt[k]) = (flight.xi[k], f64::EPSILON * norm(flight.xi[k]));
                }
                let now = xi[k][n];
                for (contact, row) in mode.rows.iter().enumerate() {
                    let seen = row[0] * now[0] + row[1] * now[1];
                    contacts[contact][n] += seen;
                    sizes[contact][n] += seen.abs();
                    if n <= LOW {
                        doubts[contact][n] += norm(*row) * doubt[k];
                    }
                }
                let given = system.loads.coefficient(k, &flight.turned, h, n, inverse[n]);
                rises[k] = add(mode.turn.act(mode.generator(), now), given).map(|rise| rise * h);
                let rate = h * (mode.decay.abs() + mode.rate);
                doubt[k] = (rate * doubt[k] + f64::EPSILON * (rate * norm(now) + h * norm(given))) / (n + 1) as f64;
            }
            let pulls = held.iter().map(|&contact| {
                let pull = system.seen_by(contact).map(|(k, mode, row)| {
                    let rise = mode.turn.act(mode.generator(), rises[k]);
                    row[0] * rise[0] + row[1] * rise[1]
                });
                -pull.sum::<f64>() / h
            });
            let pushes = system.impulses(&held, &pulls.collect::<Vec<_>>());
            for (i, push) in pushes.iter().enumerate() {
                forces[i][n] = *push;
                for (rise, mode) in rises.iter_mut().zip(modes) {
                    *rise = add(*rise, mode.columns[held[i]].map(|column| h * column * push));
                }
            }
            if n < order {
                let next = (n + 1) as f64;
                xi.iter_mut().zip(&rises).for_each(|(xi, rise)| xi[n + 1] = rise.map(|rise| rise / next));
            }
        }
        for ((c, place), doubts) in contacts.iter_mut().zip(places.iter()).zip(&mut doubts) {
            c[0] = place.x;
            if let Some(v) = place.v {
                (c[1], doubts[1]) = (v * h, 0.0);
            }
            match place.touch {
                Contact::Resting(_) => *c = [0.0; MAX_ORDER + 1],
                Contact::Leaving(_, m) => c[1..usize::from(m)].fill(0.0),
                Contact::Free => {}
            }
        }
        let is_short = sizes.iter().all(|size| {
            let most = size.iter().fold(0.0, |most: f64, size| most.max(*size));
            size[order - 1] + size[order] <= REMAINDER * most
        });
        let pressing = |((contact, barrier), c): ((usize, Barrier), Coefficients)| RestForce {
            contact,
            barrier,
            push: c.map(|c| -barrier.sign() * c),
        };
        let forces = resting.into_iter().zip(forces).map(pressing).collect();
        Self { length: h, xi, contacts, doubts, forces, is_short }
    }

    /// ξ of mode `k` at σ.
    pub(crate) fn mode(&self, k: usize, sigma: f64) -> [f64; 2] {
        self.xi[k].iter().rev().fold([0.0; 2], |sum, c| [c[0] + sum[0] * sigma, c[1] + sum[1] * sigma])
    }

    /// x and v of a contact at σ.
    pub(crate) fn contact(&self, contact: usize, sigma: f64) -> (f64, f64) {
        let (mut x, mut v) = (0.0, 0.0);
        for c in self.contacts[contact].iter().rev() {
            v = v * sigma + x;
            x = x * sigma + c;
        }
        (x, v / self.length)
    }

    /// The force on a contact at rest, positive towards larger g.
    pub(crate) fn force(&self, contact: usize, sigma: f64) -> f64 {
        let own = self.forces.iter().find(|force| force.contact == contact);
        let push = |force: &RestForce| force.push.iter().rev().fold(0.0, |sum, c| c + sum * sigma);
        own.map_or(0.0, |force| -force.barrier.sign() * push(force))
    }

    /// Rounding of the force on a contact at rest.
    pub(crate) fn force_doubt(&self, system: &System, contact: usize) -> f64 {
        8.0 * self.doubts[contact][2] / (self.length * self.length * system.mobility(contact, contact))
    }

    /// The order, from `from` on, of the first derivative that takes a contact off its barrier or presses it against it, and whether it
    /// presses. `None`: no force that rounding could tell.
    pub(crate) fn tendency(&self, contact: usize, barrier: Barrier, from: usize) -> Option<(u8, bool)> {
        (from..=LOW).find_map(|k| {
            let outward = barrier.sign() * self.contacts[contact][k];
            (outward.abs() > 4.0 * self.doubts[contact][k]).then_some((k as u8, outward > 0.0))
        })
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_lattice::{Complex, Contact as Stops, LinearMode, ModalStructure, ModeShape};
    use vibrochain_testkit::Random;

    use super::*;
    use crate::flight::Flight;
    use crate::motion::Motion;

    /// One to five modes that swing or creep, under a static load and two harmonics, with two contacts.
    fn motion(random: &mut Random) -> Motion {
        let stop = Stops { lower: Some(-100.0), upper: Some(100.0), restitution: 0.7 };
        let modes: Vec<LinearMode> = (0..1 + random.below(5))
            .map(|_| {
                let mut number = || random.between(-1.0, 1.0);
                let shape = ModeShape { contacts: vec![number(), number()], coordinates: Vec::new(), still: number() };
                let loads = [(); 2].map(|()| Complex::new(number(), number()));
                let (decay, frequency) = (random.log(1e-2, 1.0), random.log(0.3, 3.0));
                let square = random.of(&[1.0, 1.0, -0.5]) * frequency * frequency;
                LinearMode::oscillator(decay + frequency, square, &shape, &loads)
            })
            .collect();
        let xi: Vec<[f64; 2]> = modes.iter().map(|_| [random.between(-1.0, 1.0), random.between(-1.0, 1.0)]).collect();
        let structure = ModalStructure::new(vec![stop; 2], vec![1, 3], modes).unwrap();
        Motion::new(System::new(structure.into(), random.between(0.4, 1.5), random.unit()), &xi)
    }

    /// Where nothing rests a window is the flight of the modes.
    #[test]
    fn a_window_without_contacts_at_rest_is_the_exact_flight() {
        let mut random = Random(43);
        for _ in 0..100 {
            let Motion { system, flight: Flight::Modes(flight), places, .. } = motion(&mut random) else { panic!() };
            let series = Series::window(&system, &flight, &places);
            for sigma in [0.1, 0.6, 1.0] {
                let exact = flight.all_at(&system, sigma * series.length);
                for (k, exact) in exact.iter().enumerate() {
                    let told = series.mode(k, sigma);
                    let (off, size) = ((told[0] - exact[0]).hypot(told[1] - exact[1]), 1.0 + exact[0].hypot(exact[1]));
                    assert!(off < 1e-13 * size, "{k} {sigma}: {told:?} {exact:?}");
                }
                let later = ModalFlight::new(&system, exact, sigma * series.length);
                for contact in 0..2 {
                    let (x, v) = series.contact(contact, sigma);
                    assert!((x - later.place(&system, contact)).abs() < 1e-12, "{contact} {sigma}: {x}");
                    assert!((v - later.velocity(&system, contact)).abs() < 1e-11, "{contact} {sigma}: {v}");
                }
            }
        }
    }

    /// A contact at rest is not accelerated, and the force that holds it makes up for what its modes would do: by differences of the series.
    #[test]
    fn forces_on_contacts_at_rest_keep_them_there() {
        let mut random = Random(47);
        for round in 0..100 {
            let Motion { system, flight: Flight::Modes(flight), mut places, .. } = motion(&mut random) else {
                panic!()
            };
            let modes = system.modes().len();
            let held: &[usize] = if modes < 2 { &[round % 2] } else { [&[0][..], &[1], &[0, 1]][round % 3] };
            held.iter().for_each(|&contact| places.touch(contact, Contact::Resting(Barrier::Lower)));
            let series = Series::window(&system, &flight, &places);
            let (h, step) = (series.length, 1e-3);
            for sigma in [0.2, 0.8] {
                let turned = system.loads.later(&flight.turned, sigma * h);
                for (k, mode) in system.modes().iter().enumerate() {
                    let [low, now, high] = [-step, 0.0, step].map(|by| series.mode(k, sigma + by));
                    let given = system.loads.given(k, &turned);
                    let by_rate = mode.turn.act(mode.generator(), now);
                    for i in 0..2 {
                        let pushed: f64 =
                            held.iter().map(|&contact| mode.columns[contact][i] * series.force(contact, sigma)).sum();
                        let (rise, right) = ((high[i] - low[i]) / (2.0 * step * h), by_rate[i] + given[i] + pushed);
                        assert!((rise - right).abs() < 1e-4 * (1.0 + right.abs()), "{round} {k} {i}: {rise} {right}");
                    }
                }
                for &contact in held {
                    let place = |sigma: f64| {
                        system
                            .seen_by(contact)
                            .map(|(k, _, row)| {
                                let xi = series.mode(k, sigma);
                                row[0] * xi[0] + row[1] * xi[1]
                            })
                            .sum::<f64>()
                    };
                    let straight = place(0.0) + sigma * (place(1.0) - place(0.0));
                    assert!((place(sigma) - straight).abs() < 1e-12 * (1.0 + straight.abs()), "{round} {contact}");
                    assert_eq!(series.contact(contact, sigma), (0.0, 0.0));
                    let inward = Series { forces: Vec::new(), ..series.clone() };
                    assert_eq!(inward.force(contact, sigma), 0.0);
                }
            }
        }
    }

    /// From rest on a barrier a contact goes where the first derivative points that does not vanish: place −1/2 t², 1/6 t³ and their like.
    #[test]
    fn the_first_derivative_that_is_not_zero_tells_where_a_contact_goes() {
        let mut series = Series {
            length: 1.0,
            xi: Vec::new(),
            contacts: vec![[0.0; MAX_ORDER + 1]],
            doubts: vec![[1e-12; LOW + 1]],
            forces: Vec::new(),
            is_short: true,
        };
        assert_eq!(series.tendency(0, Barrier::Lower, 2), None);
        for (order, value) in [(5, -1.0), (4, 1.0), (3, -1.0), (2, 1.0)] {
            // What is below four times its doubt is nothing.
            series.contacts[0][order] = value * 3.9e-12;
            let before = series.tendency(0, Barrier::Lower, 2);
            series.contacts[0][order] = value;
            assert_eq!(before, (order < 5).then(|| (order as u8 + 1, value > 0.0)));
            assert_eq!(series.tendency(0, Barrier::Lower, 2), Some((order as u8, value < 0.0)));
            assert_eq!(series.tendency(0, Barrier::Upper, 2), Some((order as u8, value > 0.0)));
            let above = (order < 5).then(|| (order as u8 + 1, value > 0.0));
            assert_eq!(series.tendency(0, Barrier::Lower, order + 1), above);
        }
    }
}

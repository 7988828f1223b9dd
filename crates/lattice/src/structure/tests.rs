//! Modes of matrices against the matrices themselves, by the exponential of M q″ + C q′ + K q = s + Re Σ f_j e^{ijωt} and by linear systems.

use nalgebra::{DMatrix, DVector};
use rustfft::num_complex::Complex;

use super::contact::Contact;
use super::matrices::Structure;

type C = Complex<f64>;

const OMEGA: f64 = 0.83;

/// From −1 to 1, without a pattern.
fn number(seed: usize, at: usize) -> f64 {
    2.0 * (43_758.545_3 * (12.9898 * seed as f64 + 78.233 * at as f64 + 0.5).sin()).rem_euclid(1.0) - 1.0
}

fn matrix(n: usize, seed: usize) -> DMatrix<f64> {
    DMatrix::from_fn(n, n, |i, j| number(seed, 10 * i + j))
}

fn vector(n: usize, seed: usize) -> DVector<f64> {
    DVector::from_fn(n, |i, _| number(seed, i))
}

/// Two of one kind side by side, in coordinates that mix them: each pole has two shapes.
fn twins(half: usize, seed: usize) -> Structure {
    let (one, n) = (structure(half, 4 * seed + 2 + seed % 2), 2 * half);
    let mix = matrix(n, 10 * seed + 8) + DMatrix::identity(n, n) * 2.0;
    let both = |block: &DMatrix<f64>| {
        let mut whole = DMatrix::zeros(n, n);
        [0, half].into_iter().for_each(|at| whole.view_mut((at, at), (half, half)).copy_from(block));
        let mixed = mix.transpose() * whole * &mix;
        (&mixed + mixed.transpose()) * 0.5
    };
    let [mass, damping, stiffness] = [&one.mass, &one.damping, &one.stiffness].map(both);
    Structure { mass, damping, stiffness, ..structure(n, 4 * seed) }
}

/// Structures of all kinds.
fn structures() -> impl Iterator<Item = Structure> {
    let alone = (0..24).map(|seed| structure(1 + seed % 5, seed));
    alone.chain((0..12).map(|seed| twins(1 + seed % 3, seed)))
}

/// Masses on springs with two contacts, a static load and loads of harmonics 1 and 3; dashpots there are none, in proportion, of any kind, or
/// so strong that modes creep.
fn structure(n: usize, seed: usize) -> Structure {
    let [a, b, d] = [1, 2, 3].map(|part| matrix(n, 10 * seed + part));
    let mass = &a * a.transpose() + DMatrix::identity(n, n);
    let stiffness = &b * b.transpose() + DMatrix::identity(n, n) * 0.4;
    let damping = match seed % 4 {
        0 => DMatrix::zeros(0, 0),
        1 => &mass * 0.05 + &stiffness * 0.02,
        2 => &d * d.transpose() * 0.2,
        _ => &d * d.transpose() * 4.0 + &mass * 2.0,
    };
    let stop = Contact { lower: None, upper: Some(1.0), restitution: 0.9 };
    let contacts = [4, 5].map(|part| (vector(n, 10 * seed + part), stop)).to_vec();
    let load = |part: usize| {
        let [re, im] = [part, part + 1].map(|part| vector(n, 10 * seed + part));
        re.zip_map(&im, C::new)
    };
    let (static_load, loads) = (vector(n, 10 * seed + 6), vec![(1, load(7)), (3, load(9))]);
    Structure { mass, damping, stiffness, contacts, static_load, loads, modes: None }
}

impl Structure {
    fn dashpots(&self) -> DMatrix<f64> {
        if self.damping.is_empty() {
            DMatrix::zeros(self.mass.nrows(), self.mass.nrows())
        } else {
            self.damping.clone()
        }
    }

    /// Places and velocities after a time, from the exponential of all: (q, q′, 1, cos and sin of each harmonic).
    fn later(&self, place: &DVector<f64>, velocity: &DVector<f64>, time: f64) -> [DVector<f64>; 2] {
        let n = place.len();
        let inverse = self.mass.clone().try_inverse().unwrap();
        let mut flow = DMatrix::zeros(2 * n + 5, 2 * n + 5);
        flow.view_mut((0, n), (n, n)).fill_with_identity();
        flow.view_mut((n, 0), (n, n)).copy_from(&(-&inverse * &self.stiffness));
        flow.view_mut((n, n), (n, n)).copy_from(&(-&inverse * self.dashpots()));
        flow.view_mut((n, 2 * n), (n, 1)).copy_from(&(&inverse * &self.static_load));
        for (k, (number, load)) in self.loads.iter().enumerate() {
            let (at, w) = (2 * n + 1 + 2 * k, f64::from(*number) * OMEGA);
            flow.view_mut((n, at), (n, 1)).copy_from(&(&inverse * load.map(|f| f.re)));
            flow.view_mut((n, at + 1), (n, 1)).copy_from(&(&inverse * load.map(|f| -f.im)));
            (flow[(at, at + 1)], flow[(at + 1, at)]) = (-w, w);
        }
        let mut state = DVector::zeros(2 * n + 5);
        state.rows_mut(0, n).copy_from(place);
        state.rows_mut(n, n).copy_from(velocity);
        (state[2 * n], state[2 * n + 1], state[2 * n + 3]) = (1.0, 1.0, 1.0);
        let state = (flow * time).exp() * state;
        [state.rows(0, n).clone_owned(), state.rows(n, n).clone_owned()]
    }
}

/// Flights of modes, what contacts and coordinates see of them, energies and powers.
#[test]
fn modes_move_as_the_matrices_say_and_have_their_energies() {
    let (mut checked, mut complex, mut creeping) = (0, 0, 0);
    for (seed, structure) in structures().enumerate() {
        let n = structure.mass.nrows();
        let modal = structure.modal().unwrap();
        complex += modal.modes().iter().filter(|mode| !mode.is_real).count();
        creeping += modal.modes().iter().filter(|mode| mode.rates()[0].im == 0.0).count();
        let (place, velocity) = (vector(n, 500 + seed), vector(n, 600 + seed));
        let xi = structure.project(&modal, &place, &velocity).unwrap();
        let (still, steady) = (modal.still(), [0, 1].map(|place| modal.steady(place, OMEGA).unwrap()));
        let form = structure.energy_form(&modal);
        for time in [0.0, 0.7, 2.9] {
            let turned = [1.0, 3.0].map(|number| C::cis(number * OMEGA * time));
            let held = |k: usize, turned: [C; 2]| {
                [0, 1].map(|i| still[k][i] + (steady[0][k][i] * turned[0] + steady[1][k][i] * turned[1]).re)
            };
            let one = C::new(1.0, 0.0);
            let of_mode = |(k, mode): (usize, &super::linear_mode::LinearMode)| {
                let [from, to] = [[one; 2], turned].map(|turned| held(k, turned));
                let free = mode.turn.act(mode.flight(time), [xi[k][0] - from[0], xi[k][1] - from[1]]);
                [free[0] + to[0], free[1] + to[1]]
            };
            let now: Vec<[f64; 2]> = modal.modes().iter().enumerate().map(of_mode).collect();
            let [q, v] = structure.later(&place, &velocity, time);
            let seen = |pick: &dyn Fn(&super::linear_mode::LinearMode) -> [f64; 2]| -> f64 {
                modal.modes().iter().zip(&now).map(|(mode, xi)| pick(mode)[0] * xi[0] + pick(mode)[1] * xi[1]).sum()
            };
            let near = |what: &str, value: f64, right: f64| {
                assert!((value - right).abs() < 1e-9 * (1.0 + right.abs()), "{seed} {time} {what}: {value} {right}");
            };
            (0..n).for_each(|i| near("coordinate", seen(&|mode| mode.coordinates[i]), q[i]));
            for (i, (weights, _)) in structure.contacts.iter().enumerate() {
                near("contact", seen(&|mode| mode.rows[i]), weights.dot(&q));
            }
            near(
                "energy",
                form.energy(&now),
                0.5 * (v.dot(&(&structure.mass * &v)) + q.dot(&(&structure.stiffness * &q))),
            );
            near("dissipation", form.dissipation(&now), v.dot(&(structure.dashpots() * &v)));
            let push =
                structure.loads.iter().zip(turned).fold(structure.static_load.clone(), |sum, ((_, load), turned)| {
                    sum + load.map(|f| (f * turned).re)
                });
            near("power", form.power(&now, &turned), v.dot(&push));
            if let Some(own) = modal.energy_form() {
                near("energy by modes", own.energy(&now), form.energy(&now));
                near("dissipation by modes", own.dissipation(&now), form.dissipation(&now));
                near("power by modes", own.power(&now, &turned), form.power(&now, &turned));
            }
            checked += 1;
        }
    }
    assert!(checked == 108 && complex > 10 && creeping > 10, "{checked} {complex} {creeping}");
}

/// What contacts do under the loads alone, and what an impulse at one gives to another.
#[test]
fn steady_motions_and_mobilities_solve_the_matrices() {
    for (seed, structure) in structures().enumerate() {
        let modal = structure.modal().unwrap();
        let weights: Vec<&DVector<f64>> = structure.contacts.iter().map(|(weights, _)| weights).collect();
        let held = structure.stiffness.clone().lu().solve(&structure.static_load).unwrap();
        let inverse = structure.mass.clone().try_inverse().unwrap();
        for (place, (number, load)) in structure.loads.iter().enumerate() {
            let w = f64::from(*number) * OMEGA;
            let [m, c, k] =
                [&structure.mass, &structure.dashpots(), &structure.stiffness].map(|m| m.map(|x| C::new(x, 0.0)));
            let swing = (k - m * C::new(w * w, 0.0) + c * C::new(0.0, w)).lu().solve(load).unwrap();
            let (told, errors) = (modal.steady_at(place, OMEGA).unwrap(), modal.steady_errors_at(place, OMEGA, 0.0));
            for (i, weights) in weights.iter().enumerate() {
                let right: C = weights.iter().zip(&swing).map(|(weight, q)| q * *weight).sum();
                assert!(
                    (told[i] - right).norm() < 1e-11 * (1.0 + right.norm()),
                    "{seed} {place} {i}: {} {right}",
                    told[i]
                );
                assert!(
                    errors[i] > 0.0 && errors[i] < 1e-10 * (1.0 + right.norm()),
                    "{seed} {place} {i}: {}",
                    errors[i]
                );
            }
        }
        let still = modal.still();
        for (i, one) in weights.iter().enumerate() {
            let seen: f64 = modal
                .modes()
                .iter()
                .zip(&still)
                .map(|(mode, xi)| mode.rows[i][0] * xi[0] + mode.rows[i][1] * xi[1])
                .sum();
            assert!((seen - one.dot(&held)).abs() < 1e-11 * (1.0 + held.norm()), "{seed} {i}: {seen}");
            for (j, other) in weights.iter().enumerate() {
                let right = one.dot(&(&inverse * *other));
                let (off, told) = ((modal.mobility(i, j) - right).abs(), modal.mobility_error(i, j));
                assert!(off <= told + 1e-13 && told < 1e-10, "{seed} {i} {j}: {off:e} {told:e}");
            }
        }
    }
}

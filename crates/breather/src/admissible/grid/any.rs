//! Contacts of any structure: their accelerations by M⁻¹K, or by the modes.

use smallvec::SmallVec;
use vibrochain_lattice::simd::lanes::{LANES, Lane, all, combine, four};
use wide::f64x4;

use super::diagonals::Diagonals;
use super::turn::turn;
use super::{Flight, Grid};

/// How often bounds are held against those of neighbours: each time they are some thirty times closer.
const SWEEPS: usize = 4;

impl Grid {
    /// Modes at all nodes, masses and their accelerations, and the extremes of these.
    pub(super) fn sample_any(&mut self, flight: Flight<'_>, pulls: Option<&Diagonals>) {
        let step = all(self.step);
        let turns: SmallVec<[_; 4]> = self.frequencies.iter().map(|frequency| turn(four(*frequency), step)).collect();
        let mut state = flight.start.map(SmallVec::<[Lane; 4]>::from_slice);
        let mut rates = state[0].clone();
        let infinite = [f64::INFINITY; LANES];
        self.extremes.fill([infinite, infinite.map(|x| -x), [0.0; LANES]]);
        let states =
            self.displacements.chunks_exact_mut(turns.len()).zip(self.velocities.chunks_exact_mut(turns.len()));
        let masses = self.values.chunks_exact_mut(self.groups).zip(self.accelerations.chunks_exact_mut(self.groups));
        for ((displacement, velocity), (value, acceleration)) in states.zip(masses) {
            for (g, [cos, sin_over, sin_times]) in turns.iter().enumerate() {
                (displacement[g], velocity[g]) = (state[0][g], state[1][g]);
                let (u, w, omega) = (four(displacement[g]), four(velocity[g]), four(self.frequencies[g]));
                rates[g] = (-(omega * omega) * u).to_array();
                state[0][g] = (u * *cos + w * *sin_over).to_array();
                state[1][g] = (w * *cos - u * *sin_times).to_array();
            }
            combine(flight.shapes, displacement.as_flattened().iter().copied(), value);
            match pulls {
                Some(pulls) => pulls.act(value, &mut self.between, |sum| -sum, acceleration),
                None => combine(flight.shapes, rates.as_flattened().iter().copied(), acceleration),
            }
            for (extremes, (value, acceleration)) in self.extremes.iter_mut().zip(value.iter().zip(acceleration)) {
                let ([low, high, top], v) = (extremes.map(four), four(*value));
                let tops = top.fast_max(four(*acceleration).abs());
                *extremes = [low.fast_min(v), high.fast_max(v), tops].map(f64x4::to_array);
            }
        }
    }

    /// Bounds of each mass's own, as far as the modes reach, or its neighbours.
    pub(super) fn bound_any(&mut self, flight: Flight<'_>, pulls: Option<&Diagonals>) {
        self.fourths.clear();
        self.fourths.resize(self.groups * LANES, 0.0);
        let fourths = self.fourths.as_chunks_mut::<LANES>().0;
        let [u, w] = flight.start.map(<[Lane]>::as_flattened);
        let modes = flight.shapes.chunks_exact(self.groups).zip(flight.frequencies).zip(u.iter().zip(w));
        for ((shapes, omega), (u, w)) in modes {
            let square = omega * omega;
            // Ω⁴ times the mode's reach.
            let size = square * omega * (square * u * u + w * w).sqrt();
            for (fourth, shape) in fourths.iter_mut().zip(shapes) {
                *fourth = (four(*fourth) + all(size) * four(*shape).abs()).to_array();
            }
        }
        let eighth = all(0.125 * self.step * self.step);
        self.seconds.clear();
        let seconds = self.extremes.iter().zip(&*fourths);
        self.seconds.extend(seconds.flat_map(|([.., top], fourth)| (four(*top) + eighth * four(*fourth)).to_array()));
        let Some(pulls) = pulls else { return };
        for sweep in 0..=SWEEPS {
            let seconds = self.seconds.as_chunks_mut::<LANES>().0;
            pulls.bound(seconds, &mut self.between, fourths);
            if sweep < SWEEPS {
                for (second, ([.., top], fourth)) in seconds.iter_mut().zip(self.extremes.iter().zip(&*fourths)) {
                    *second = four(*second).fast_min(four(*top) + eighth * four(*fourth)).to_array();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_lattice::simd::lanes::groups;
    use vibrochain_lattice::{Contact, DampedChain, RowEnds};

    use super::*;
    use crate::admissible::grid::{Forces, Grid};

    /// At the nodes values and accelerations are sums of cosines and sines of the modes, and between them these stay within the bounds.
    #[test]
    fn nodes_and_bounds_of_any_structure_hold() {
        let mut random = fastrand::Rng::with_seed(3);
        let (mut grid, mut checked, mut tight) = (Grid::default(), [0; 2], 0);
        for case in 0..300 {
            let count = 1 + random.usize(0..11);
            let (gamma1, gamma2) = (0.1 + random.f64(), 0.5 * random.f64());
            let stop = Contact { lower: Some(-1.0), upper: Some(1.0), restitution: 1.0 };
            let contacts = (0..count).map(|n| (vec![(n, 1.0)], stop)).collect();
            let row = DampedChain { gamma1, gamma2, contacts, ..DampedChain::new(count, RowEnds::FixedFree) };
            let modal = row.modal().unwrap();
            let shape = |k: usize, n: usize| modal.modes()[k].rows[n][0];
            let own = |n: usize| gamma1 + if n + 1 == count { gamma2 } else { 2.0 * gamma2 };
            let sides = |n: usize| [n.checked_sub(1), Some(n + 1).filter(|n| *n < count)];
            let entries = (0..count).flat_map(|n| {
                let sides = sides(n).into_iter().flatten().map(move |other| (n, other, -gamma2));
                sides.chain([(n, n, own(n))])
            });
            let lanes = count.div_ceil(LANES);
            let pulls = Diagonals::new(lanes, entries).unwrap();
            let mut shapes = vec![[0.0; LANES]; count * lanes];
            let mut start = [vec![[0.0; LANES]; lanes], vec![[0.0; LANES]; lanes]];
            for k in 0..count {
                (0..count).for_each(|n| shapes[k * lanes + n / LANES][n % LANES] = shape(k, n));
                // The first mass alone is hit.
                start[1].as_flattened_mut()[k] = shape(k, 0);
                start[0].as_flattened_mut()[k] = if case % 3 == 0 { random.f64() } else { 0.0 };
            }
            let frequencies: Vec<f64> = modal.modes().iter().map(|mode| mode.rate).collect();
            let fastest = frequencies.iter().fold(0.0, |most: f64, rate| most.max(*rate));
            let flight = Flight {
                frequencies: &frequencies,
                fastest,
                shapes: &shapes,
                start: [&start[0], &start[1]],
                driven: None,
            };
            let by_pulls = usize::from(case % 2 == 0);
            let forces = Forces::Any((by_pulls == 1).then_some(&pulls));
            let horizon = random.f64() * 12.0 / fastest;
            assert!(grid.set(flight, forces, horizon));
            assert!(groups(count) >= lanes && grid.intervals().is_multiple_of(2));
            let derivative = |n: usize, t: f64, order: i32| -> f64 {
                let of = |(k, rate): (usize, &f64)| {
                    let (sin, cos) = (rate * t).sin_cos();
                    let [u, w] = [0, 1].map(|i| start[i].as_flattened()[k]);
                    let sign = if order % 4 == 2 { -1.0 } else { 1.0 };
                    sign * shape(k, n) * rate.powi(order) * (u * cos + w * sin / rate)
                };
                frequencies.iter().enumerate().map(of).sum()
            };
            for n in 0..count {
                for node in 0..=grid.intervals() {
                    let (t, place) = (node as f64 * grid.step(), node * grid.stride() + n);
                    assert!((grid.value(place) - derivative(n, t, 0)).abs() < 1e-13);
                    assert!((grid.accelerations.as_flattened()[place] - derivative(n, t, 2)).abs() < 1e-12);
                }
                let (mut most, bound) = (0.0, grid.second(n));
                for part in 0..60 {
                    let t = horizon * f64::from(part) / 59.0;
                    let [second, fourth] = [2, 4].map(|order| derivative(n, t, order).abs());
                    assert!(second <= bound + 1e-13 && fourth <= grid.fourth(forces, n) + 1e-12, "{second} {bound}");
                    assert!(derivative(n, t, 0).abs() <= grid.excursion(n) + 1e-13);
                    most = second.max(most);
                    checked[by_pulls] += 1;
                }
                tight += usize::from(by_pulls == 1 && bound < 1.3 * most);
            }
        }
        assert!(checked[0] > 20_000 && checked[1] > 20_000 && tight > 400, "{checked:?} {tight}");
    }
}

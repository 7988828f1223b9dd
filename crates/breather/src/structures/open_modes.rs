//! Modes next to a resonance, whose states are unknowns of the orbit.
//!
//! Next to a resonance the periodic kernel of a mode is large by (1−R)⁻¹, R = e^{AT}, and so is its steady motion under a load: digits cancel in
//! every row. With the state y just before the first impact among the unknowns nothing is large, however close the resonance is:
//!
//! ```text
//! ξ(t) = e^{At}y + Σ_{t_j<t} e^{A(t−t_j)}c_jP_j + x(t),     (1−R)y − Σ_j e^{A(T−t_j)}c_jP_j − x(T) = 0
//! x(t) = Re e^{iwψ} (e^{iwt} − e^{At})(iw−A)⁻¹L              from rest, of each load that is next to the mode
//! ```

use std::sync::Arc;

use smallvec::SmallVec;
use vibrochain_lattice::{LinearMode, Turn, Turned};

use super::equations::{Equations, System};
use super::open_mode::{OpenMode, State};
use super::periodic_kernel::{UNIT, length, one_less};
use super::point::Point;
use super::resonant_doubts::ResonantDoubt;
use super::response::NEAR;
use crate::equations::linear::{Matrix, Vector};
use crate::error::BreatherError;

/// Modes at most that are taken as unknowns, the closest first: each costs two rows.
const MOST: usize = 4;

/// The relative step of the central differences by a pole: rounding leaves them ten digits, the curvature of the flights twelve.
const MOVED: f64 = 1e-6;

/// What a contact sees of a state.
fn seen([a, b]: [f64; 2], [x, y]: State) -> f64 {
    a * x + b * y
}

impl Equations<'_> {
    /// The equations with the states of the modes next to a resonance among the unknowns, and the point; `None` where no mode is.
    pub(super) fn opened(&self, point: &Point) -> Option<(Self, Point)> {
        let (equations, sums) = self.with_open(self.kernel().nearly_resonant().collect(), NEAR)?;
        let point = equations.with_states(point, &sums);
        Some((equations, point))
    }

    /// The equations with the states of the modes among the unknowns whose |1 − R| is below `distance`, and what loads as close do to these; of so many
    /// modes at most.
    pub(super) fn opened_within(&self, distance: f64, most: usize) -> Option<Self> {
        let mut near: Vec<(usize, f64)> = self.kernel().within(distance).collect();
        near.sort_by(|a, b| b.1.total_cmp(&a.1));
        near.truncate(most);
        Some(self.with_open(near, distance)?.0)
    }

    /// The equations with these modes open, by their places among the regular ones with how close each is, and (1−R)⁻¹ of these. `None` where no mode
    /// is.
    fn with_open(&self, mut near: Vec<(usize, f64)>, of_loads: f64) -> Option<(Self, Vec<Turned>)> {
        let kernel = self.kernel();
        near.sort_by(|a, b| b.1.total_cmp(&a.1));
        near.truncate(MOST);
        if near.is_empty() || self.self_excited {
            return None;
        }
        let places: Vec<usize> = near.iter().map(|(place, _)| *place).collect();
        let opened = |mode: &LinearMode| OpenMode {
            mode: mode.clone(),
            one_less: one_less(mode.flow(), kernel.period),
            loads: SmallVec::new(),
        };
        let chosen = kernel.regular().enumerate().filter(|(place, _)| places.contains(place));
        let (mut open, sums): (Vec<OpenMode>, Vec<Turned>) = chosen.map(|(_, (mode, sum))| (opened(mode), sum)).unzip();
        let driven = self.take_loads(&mut open, of_loads);
        let (structure, omega) = (self.model.structure(), self.model.omega());
        let response = self.response.without(kernel.without(&places), structure, omega, &driven);
        Some((Self { response: Arc::new(response), open, driven, ..self.clone() }, sums))
    }

    /// Gives the loads next to a mode of the structure, to this part of their frequency, to the open modes that see it, and tells which these are:
    /// numbers of modes and harmonics.
    fn take_loads(&self, open: &mut [OpenMode], apart: f64) -> Vec<(usize, usize)> {
        let (structure, omega) = (self.model.structure(), self.model.omega());
        let mut taken = Vec::new();
        if !self.forced {
            return taken;
        }
        for (number, mode) in structure.modes().iter().enumerate() {
            let near = (0..structure.harmonics().len()).filter(|place| structure.is_near(mode, *place, omega, apart));
            let near: Vec<usize> = near.collect();
            if near.is_empty() || mode.turn != Turn::Circular {
                continue;
            }
            let Some(parts) = self.parts_of(mode, open) else { continue };
            for place in near {
                let w = f64::from(structure.harmonics()[place]) * omega;
                for (own, part) in open.iter_mut().zip(&parts).filter(|(_, part)| **part != 0.0) {
                    let load = mode.loads[place].map(|load| load * *part);
                    own.loads.push((w, load, mode.errors.loads[place] * part.abs()));
                }
                taken.push((number, place));
            }
        }
        taken
    }

    /// What of each open mode is in a mode of the structure, as the contacts that are hit see it.
    fn parts_of(&self, mode: &LinearMode, open: &[OpenMode]) -> Option<Vector> {
        let alike: Vec<usize> = (0..open.len()).filter(|&k| open[k].mode.is_alike(mode)).collect();
        let mut parts: Vector = open.iter().map(|_| 0.0).collect();
        let row = |of: &LinearMode, contact: &usize| of.rows[*contact][0];
        let overlap = |k: usize, l: usize| -> f64 {
            self.hit.iter().map(|contact| row(&open[alike[k]].mode, contact) * row(&open[alike[l]].mode, contact)).sum()
        };
        let matrix = Matrix::from_fn(alike.len(), overlap);
        let right: Vector = (alike.iter())
            .map(|&k| self.hit.iter().map(|contact| row(&open[k].mode, contact) * row(mode, contact)).sum())
            .collect();
        if alike.is_empty() {
            return None;
        }
        let solved = matrix.solve(&right)?;
        alike.iter().zip(solved).for_each(|(&k, part)| parts[k] = part);
        Some(parts)
    }

    /// The point with the states that its impulses lead to; `sums` are (1−R)⁻¹ of the open modes.
    fn with_states(&self, point: &Point, sums: &[Turned]) -> Point {
        let mut whole = point.clone();
        whole.offsets.truncate(self.rigid.len());
        for (own, &sum) in self.open.iter().zip(sums) {
            let state = own.act(sum, self.pushed(own, point));
            whole.offsets.extend(state.map(|entry| if entry.is_finite() { entry } else { 0.0 }));
        }
        whole
    }

    /// What impulses and loads have made of rest at the end of the period.
    fn pushed(&self, own: &OpenMode, point: &Point) -> State {
        let period = self.period();
        let [[mut state, ..], _] = own.driven(period, point.psi);
        for strike in &point.strikes {
            let given = own.act(own.mode.flight(period - strike.time), own.mode.columns[strike.contact]);
            state = [0, 1].map(|side| state[side] + strike.impulse * given[side]);
        }
        state
    }

    /// State of an open mode among the offsets of a point.
    fn state(&self, point: &Point, k: usize) -> State {
        let first = self.rigid.len() + 2 * k;
        [point.offsets[first], point.offsets[first + 1]]
    }

    /// Adds what the open modes do at impact `i` to its sums and their sizes, and to the derivatives by the unknowns.
    pub(super) fn add_open(
        &self,
        point: &Point,
        i: usize,
        (sums, sizes): (&mut [f64; 4], &mut [f64; 3]),
        gradient: &mut [Vector; 3],
    ) {
        let (n, strike) = (point.strikes.len(), &point.strikes[i]);
        let own_time = self.time(n, i);
        let first = self.unknowns(n) - 2 * self.open.len();
        for (k, own) in self.open.iter().enumerate() {
            let row = own.mode.rows[strike.contact];
            let (state, flight) = (self.state(point, k), own.mode.flight(strike.time));
            let [driven, by_psi] = own.driven(strike.time, point.psi);
            let mut whole = own.jet(own.act(flight, state));
            let mut size = length(row)
                * (length(state) * own.blur(strike.time) + own.driven_size(strike.time, point.psi))
                + own.mode.errors.rows[strike.contact] / UNIT * (length(state) + length(driven[0]));
            for (j, other) in point.strikes.iter().enumerate().filter(|(_, other)| other.time < strike.time) {
                let lapse = strike.time - other.time;
                let given = own.jet(own.act(own.mode.flight(lapse), own.mode.columns[other.contact]));
                for order in 0..4 {
                    whole[order] = [0, 1].map(|side| whole[order][side] + other.impulse * given[order][side]);
                }
                for (order, gradient) in gradient.iter_mut().enumerate() {
                    gradient[j] += seen(row, given[order]);
                    if let Some(place) = self.time(n, j) {
                        gradient[place] -= other.impulse * seen(row, given[order + 1]);
                    }
                }
                let doubt = own.mode.errors_between(strike.contact, other.contact) / UNIT;
                let reach = length(row) * length(own.mode.columns[other.contact]);
                size += other.impulse.abs() * (reach * own.blur(lapse) + doubt);
            }
            for order in 0..4 {
                sums[order] += seen(row, whole[order]) + seen(row, driven[order]);
            }
            for (order, gradient) in gradient.iter_mut().enumerate() {
                if let Some(place) = own_time {
                    gradient[place] += seen(row, whole[order + 1]) + seen(row, driven[order + 1]);
                }
                if let Some(place) = self.psi(n) {
                    gradient[place] += seen(row, by_psi[order]);
                }
                for (side, unit) in [[1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
                    gradient[first + 2 * k + side] += seen(row, own.jet(own.act(flight, unit))[order]);
                }
            }
            let fast = length([own.mode.decay, own.mode.rate]);
            for entry in sizes.iter_mut() {
                *entry += size;
                size *= fast;
            }
        }
    }

    /// The equations with the pole of open mode `k` moved, its decay and its rate by these parts of its modulus.
    fn with_moved(&self, k: usize, [decay, rate]: [f64; 2]) -> Self {
        let mut moved = self.clone();
        let own = &mut moved.open[k];
        let fast = length([own.mode.decay, own.mode.rate]);
        own.mode.decay += decay * fast;
        own.mode.rate += rate * fast;
        own.one_less = one_less(own.mode.flow(), self.period());
        moved
    }

    /// How errors of the poles of open modes move the rows: a vector for the decay of each mode and one for its rate. The error of a pole is one
    /// number in all rows, so its signs are kept.
    pub(super) fn doubts_of_open(&self, point: &Point) -> Result<Vec<ResonantDoubt>, BreatherError> {
        let mut doubts = Vec::with_capacity(2 * self.open.len());
        for (k, own) in self.open.iter().enumerate() {
            let part = own.mode.errors.poles / length([own.mode.decay, own.mode.rate]);
            for by in [[MOVED, 0.0], [0.0, MOVED]] {
                let [ahead, behind] =
                    [self.with_moved(k, by).system(point)?, self.with_moved(k, by.map(|x| -x)).system(point)?];
                let scale = part / (2.0 * MOVED);
                let rows = ahead.rows.iter().zip(&behind.rows).map(|(a, b)| scale * (a - b)).collect();
                let both = ahead.arrivals.iter().zip(&behind.arrivals);
                let accelerations = both.map(|(a, b)| scale * (a.acceleration - b.acceleration)).collect();
                doubts.push(ResonantDoubt { rows, accelerations });
            }
        }
        Ok(doubts)
    }

    /// The rows of the open modes: after a period each is where it was.
    pub(super) fn close_open(&self, point: &Point, system: &mut System) {
        let (n, period) = (point.strikes.len(), self.period());
        let first = self.unknowns(n) - 2 * self.open.len();
        for (k, own) in self.open.iter().enumerate() {
            let (state, turn) = (self.state(point, k), own.mode.turn);
            let (kept, pushed) = (own.act(own.one_less, state), self.pushed(own, point));
            let [_, [by_psi, ..]] = own.driven(period, point.psi);
            let less = length([own.one_less.even, own.one_less.odd]);
            let mut size = length(state) * (less + own.blur(period)) + own.driven_size(period, point.psi);
            for side in 0..2 {
                let row = first + 2 * k + side;
                system.rows[row] = kept[side] - pushed[side];
                for (other, unit) in [[1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
                    system.jacobian[(row, first + 2 * k + other)] = turn.act(own.one_less, unit)[side];
                }
                if let Some(place) = self.psi(n) {
                    system.jacobian[(row, place)] = -by_psi[side];
                }
            }
            for (j, strike) in point.strikes.iter().enumerate() {
                let column = own.mode.columns[strike.contact];
                let given = own.jet(own.act(own.mode.flight(period - strike.time), column));
                for side in 0..2 {
                    let row = first + 2 * k + side;
                    system.jacobian[(row, j)] -= given[0][side];
                    if let Some(place) = self.time(n, j) {
                        system.jacobian[(row, place)] += strike.impulse * given[1][side];
                    }
                }
                let doubt = own.mode.errors.columns[strike.contact] / UNIT;
                size += strike.impulse.abs() * (length(column) * own.blur(period) + doubt);
            }
            (0..2).for_each(|side| system.sizes[first + 2 * k + side] = size);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vibrochain_lattice::{Chain, Model};

    use crate::structures::model::LoadedStructure;

    /// A lattice with contacts at two of its masses, next to the resonance of its softest mode with the third harmonic of the load or its first.
    fn near(distance: f64, harmonic: f64, coupling: f64) -> LoadedStructure {
        let chain = Chain::new(5, 0.3, coupling).unwrap();
        let omega = 0.3f64.sqrt() / harmonic * (1.0 + distance);
        let model: Model = chain.point().omega(omega).asymmetry(0.2).amplitude(0.4).restitution(0.7).model().unwrap();
        let structure = model.structure(&[vec![0], vec![1]]).unwrap();
        LoadedStructure::new(Arc::new(structure), omega).unwrap()
    }

    /// Words of contacts 0 and 1 that these lattices have orbits of.
    const WORDS: [&str; 3] = ["0+,0-", "0+", "0-,1-"];

    /// Where modes are next to a resonance, but not so near that the periodic kernel loses many digits, rows and derivatives are those of the
    /// kernel: positions and laws vanish together, and every derivative is what differences say.
    #[test]
    fn the_equations_of_open_modes_are_those_of_the_kernel_and_have_its_derivatives() {
        let (mut checked, mut loaded) = (0, 0);
        for (distance, harmonic) in [(4e-5, 3.0), (-1e-4, 1.0), (5e-5, 2.0)] {
            for coupling in [0.0, 0.07] {
                let model = near(distance, harmonic, coupling);
                for word in WORDS {
                    for orbit in model.orbits(&word.parse().unwrap(), 1).unwrap().contacts() {
                        let (closed, point) = orbit.equations().unwrap();
                        let (opened, whole) = closed.opened(&point).unwrap();
                        let (rows, same) = (closed.system(&point).unwrap(), opened.system(&whole).unwrap());
                        for (i, (row, size)) in rows.rows.iter().zip(&rows.sizes).enumerate() {
                            let apart = (row - same.rows[i]).abs();
                            assert!(apart <= 1e-11 * size, "{word} {harmonic} {coupling} {i}: {apart:e} {size:e}");
                        }
                        for (one, other) in rows.arrivals.iter().zip(&same.arrivals) {
                            let apart = (one.acceleration - other.acceleration).abs() + (one.jerk - other.jerk).abs();
                            assert!(apart <= 1e-10 * one.sizes[2], "{word} {harmonic}: {apart:e}");
                        }
                        loaded += usize::from(!opened.driven.is_empty());
                        for place in 0..rows.rows.len() + 2 * opened.open.len() {
                            let unit =
                                if place >= point.strikes.len() { 1e-6 } else { 1e-6 * whole.strikes[0].impulse };
                            let moved = |sign: f64| {
                                let (mut aside, mut step) = (whole.clone(), vec![0.0; same.rows.len()]);
                                step[place] = -sign * unit;
                                opened.take(&mut aside, &step);
                                opened.system(&aside).unwrap()
                            };
                            let (ahead, behind) = (moved(1.0), moved(-1.0));
                            for row in 0..same.rows.len() {
                                let slope = (ahead.rows[row] - behind.rows[row]) / (2.0 * unit);
                                let (told, size) = (same.jacobian[(row, place)], same.sizes[row] / unit.abs());
                                let apart = (slope - told).abs();
                                assert!(
                                    apart < 1e-5 * told.abs() + 1e-8 * size,
                                    "{word} {row} {place}: {slope} {told}"
                                );
                            }
                            checked += 1;
                        }
                    }
                }
            }
        }
        assert!(checked > 100 && loaded > 5, "{checked} {loaded}");
    }

    /// However close a resonance is, the orbits have bounds of their errors, and these are small.
    #[test]
    fn bounds_are_known_however_close_a_resonance_is() {
        let (mut checked, mut known) = (0, 0);
        for distance in [1e-5, -1e-7, 1e-9, -1e-11] {
            for harmonic in [1.0, 2.0, 3.0] {
                for coupling in [0.0, 0.07] {
                    let model = near(distance, harmonic, coupling);
                    for word in WORDS {
                        for orbit in model.orbits(&word.parse().unwrap(), 1).unwrap().contacts() {
                            let strongest = orbit.impulses().iter().fold(0.0, |most: f64, one| most.max(one.abs()));
                            let worst = orbit.impact_errors().iter().map(|one| one.impulse).fold(0.0, f64::max);
                            // Of slower impacts less is known: the mode swings as far as their impulses' digits let it.
                            if strongest < 1e-3 {
                                continue;
                            }
                            known += usize::from(worst < 1e-9 * strongest);
                            checked += 1;
                        }
                    }
                }
            }
        }
        // Of the pairs at half a period that part like the square of the distance some are not told apart.
        assert!(checked > 200 && 20 * known > 19 * checked, "{known} of {checked}");
    }
}

//! The quick look at a flight without losses between impacts of one contact: all masses, or contacts of a structure, on a grid of times,
//! and bounds on what they can do in between.
//!
//! Half a period of one site's breather is one stretch of linear flight, in which every derivative obeys the equation of
//! motion, too; so is what lies between two impacts of a forced one, if the uniform motion under the force is added. If |v̈_n| ≤ B₂ and |v⃛_n| ≤ B₃ on an interval of length h, the mass comes no closer to a barrier than at its
//! ends by more than B₂h²/8, and has no turning point if these are more than B₂h²/2 apart; its velocity leaves the straight line between
//! its values at the ends by no more than B₃h²/8, and its tangent by B₃s²/2. The bounds are each mass's own, from accelerations at the nodes and
//!
//! ```text
//! |v⃜_n| ≤ (γ₁+2γ₂)|v̈_n| + γ₂(|v̈_(n−1)| + |v̈_(n+1)|) ,
//! ```
//!
//! as small as what moves: far masses are displaced, but hardly swing. Of a structure M⁻¹K tells the same; where that is not known, modes do, by
//! their shapes φ and reaches r: |v⃜| ≤ Σ |φ|Ω⁴r. That settles all but a few intervals of the masses next to the breather; those get their own Taylor
//! polynomial from the modes.

mod any;
pub(crate) mod diagonals;
pub(crate) mod turn;

use vibrochain_lattice::simd::lanes::{LANES, Lane, dot, fill, groups};
use vibrochain_lattice::{Chain, DistinctMasses, Wave};
use wide::f64x4;

use crate::admissible::gap::Gap;
use crate::motion::polynomial::{ORDER, Polynomial, taylor};
use diagonals::Diagonals;
use turn::turn;

/// Length of an interval in radians of the fastest motion: shorter ones cost time, longer ones leave more to polynomials.
pub(crate) const INTERVAL: f64 = 0.5;

/// Intervals at least: the ends are looked at in a way of their own.
const FEWEST: usize = 4;

/// Intervals at most: from one to the next the modes are turned on, and rounding adds up. Longer flights go by windows.
const MOST: usize = 24;

/// The same of any structure, of which windows cost ten times as much.
const MOST_OF_ANY: usize = 64;

/// Radians of the fastest mode at most of any structure.
pub(crate) const MOST_RADIANS: f64 = INTERVAL * MOST_OF_ANY as f64;

/// Of a velocity at an end of the flight below this part of that at the next node a mass turns so close to the end that it is as near a barrier
/// there, to rounding.
const STILL: f64 = 1e-9;

/// Intervals in what windows are elsewhere: what is in the way is told of the first of these.
pub(crate) const IN_WINDOW: usize = 2;

/// Modes at most: a node takes the square of their number in steps, a window only twenty times their number.
pub(crate) const MOST_MODES: usize = 48;

/// The modes in the flight that begins with an impact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Flight<'a> {
    /// Ω_k, and the highest one.
    pub(crate) frequencies: &'a [f64],
    pub(crate) fastest: f64,
    /// [mode][mass from the one that is hit on] in groups; of a ring, cos(2πkn/M) of its half in whole groups, and empty of a large one.
    pub(crate) shapes: &'a [Lane],
    /// Displacements and velocities at its start, weights included, in groups of four.
    pub(crate) start: [&'a [Lane]; 2],
    /// What a force adds to all masses of a ring, and its time at the start.
    pub(crate) driven: Option<(&'a Wave, f64)>,
}

impl<'a> Flight<'a> {
    /// Of half a ring that is hit at its first mass.
    pub(crate) fn of_ring(frequencies: &'a [f64], shapes: &'a [Lane], start: [&'a [Lane]; 2]) -> Self {
        Self { frequencies, fastest: frequencies.last().copied().unwrap_or_default(), shapes, start, driven: None }
    }

    /// The same with a uniform motion under a force, whose time is given at its start.
    pub(crate) fn driven(self, wave: &'a Wave, time: f64) -> Self {
        Self { fastest: self.fastest.max(wave.top_rate()), driven: Some((wave, time)), ..self }
    }
}

/// What accelerates masses, and bounds that.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Forces<'a> {
    /// γ₁ and γ₂ of a ring, the latter 0 of a ring of one, and who is next to whom.
    Ring { stiffnesses: (f64, f64), watched: &'a DistinctMasses },
    /// Any structure's: M⁻¹K of its contacts, where nothing else pulls at them; without it the modes alone tell.
    Any(Option<&'a Diagonals>),
}

impl<'a> Forces<'a> {
    pub(crate) fn of_ring(chain: &Chain, watched: &'a DistinctMasses) -> Self {
        Self::Ring { stiffnesses: stiffnesses(chain), watched }
    }
}

/// Values of all masses at the nodes, and the modes they come from.
#[derive(Debug, Clone, Default)]
pub(crate) struct Grid {
    /// Groups of masses, and of modes.
    groups: usize,
    mode_groups: usize,
    intervals: usize,
    step: f64,
    frequencies: Vec<Lane>,
    /// Displacement and velocity of the modes, [node][mode].
    displacements: Vec<Lane>,
    velocities: Vec<Lane>,
    /// Displacements of the masses, [node][mass].
    values: Vec<Lane>,
    /// Their smallest and largest value, and the largest modulus of their accelerations at the nodes.
    extremes: Vec<[Lane; 3]>,
    /// Their accelerations, [node][mass].
    accelerations: Vec<Lane>,
    /// For each mass a bound on |v̈| in the whole flight; of a structure, on |v⃜|; and, from the far end, what lies beyond it in that sum.
    seconds: Vec<f64>,
    fourths: Vec<f64>,
    beyond: Vec<f64>,
    tops: Vec<Lane>,
    reaches: Vec<f64>,
    scratch: Vec<[f64x4; 2]>,
    /// Numbers of all contacts between as many zeros.
    between: Vec<f64>,
    /// The motion under the force around each node, in units of an interval, and bounds of its |v̈| and |v⃜|; nothing without it.
    driven: Vec<[f64; ORDER]>,
    driven_at_most: [f64; 2],
}

impl Grid {
    /// Takes over a flight that lasts for `horizon`. `false` if another way is better.
    pub(crate) fn set(&mut self, flight: Flight<'_>, forces: Forces<'_>, horizon: f64) -> bool {
        let Flight { frequencies, shapes, .. } = flight;
        let (modes, intervals) = (frequencies.len(), horizon * flight.fastest / INTERVAL);
        let most = if matches!(forces, Forces::Ring { .. }) { MOST } else { MOST_OF_ANY };
        let is_short = intervals <= most as f64;
        if shapes.is_empty() || !is_short {
            return false;
        }
        match forces {
            Forces::Ring { .. } if modes > MOST_MODES => return false,
            Forces::Ring { .. } => {
                self.intervals = FEWEST.max(intervals.ceil() as usize);
                self.groups = groups(modes);
                self.mode_groups = self.groups;
            }
            Forces::Any(_) => {
                self.intervals = IN_WINDOW * ((intervals / IN_WINDOW as f64).ceil() as usize).max(1);
                (self.groups, self.mode_groups) = (shapes.len() / modes, modes.div_ceil(LANES));
            }
        }
        self.step = horizon / self.intervals as f64;
        let nodes = self.intervals + 1;
        for list in [&mut self.displacements, &mut self.velocities] {
            list.resize(nodes * self.mode_groups, [0.0; LANES]);
        }
        for list in [&mut self.values, &mut self.accelerations] {
            list.resize(nodes * self.groups, [0.0; LANES]);
        }
        self.extremes.resize(self.groups, [[0.0; LANES]; 3]);
        self.frequencies.clear();
        self.frequencies.resize(self.mode_groups, [0.0; LANES]);
        self.frequencies.as_flattened_mut().iter_mut().zip(frequencies).for_each(|(slot, value)| *slot = *value);
        self.driven.clear();
        self.driven_at_most = [0.0; 2];
        if let Some((wave, begins)) = flight.driven {
            self.driven.extend((0..nodes).map(|node| taylor(wave, begins + node as f64 * self.step, self.step)));
            self.driven_at_most = [2, 4].map(|order| wave.bound(order));
        }
        let (stiffnesses, watched) = match forces {
            Forces::Ring { stiffnesses, watched } => (stiffnesses, watched),
            Forces::Any(pulls) => {
                self.sample_any(flight, pulls);
                self.bound_any(flight, pulls);
                return true;
            }
        };
        // With the number of groups known to the compiler, rows stay in registers.
        match self.groups {
            1 => self.sample::<1>(flight, stiffnesses, watched),
            2 => self.sample::<2>(flight, stiffnesses, watched),
            3 => self.sample::<3>(flight, stiffnesses, watched),
            4 => self.sample::<4>(flight, stiffnesses, watched),
            6 => self.sample::<6>(flight, stiffnesses, watched),
            8 => self.sample::<8>(flight, stiffnesses, watched),
            12 => self.sample::<12>(flight, stiffnesses, watched),
            _ => return false,
        }
        self.bound(stiffnesses, watched)
    }

    /// Modes and masses at all nodes, and the extremes of the latter.
    fn sample<const G: usize>(&mut self, flight: Flight<'_>, (gamma1, gamma2): (f64, f64), watched: &DistinctMasses) {
        let turns = self.turns::<G>();
        let [mut u, mut w] = flight.start.map(row::<G>);
        let last = watched.sites().len() - 1;
        // Two masses may have neighbours that are not next to them in a row.
        let ends = [0, last].map(|mass| (mass, watched.left()[mass], watched.right()[mass]));
        let (own, side) = (-(gamma1 + 2.0 * gamma2), gamma2);
        let shapes = flight.shapes.as_chunks::<G>().0;
        let states = rows_mut::<G>(&mut self.displacements).zip(rows_mut::<G>(&mut self.velocities));
        let masses = rows_mut::<G>(&mut self.values).zip(rows_mut::<G>(&mut self.accelerations));
        for ((displacement, velocity), (value, acceleration)) in states.zip(masses) {
            *displacement = u.map(f64x4::to_array);
            *velocity = w.map(f64x4::to_array);
            let mut v = [f64x4::ZERO; G];
            for (shape, factor) in shapes.iter().zip(displacement.as_flattened()) {
                for i in 0..G {
                    v[i] += f64x4::from(shape[i]) * f64x4::splat(*factor);
                }
            }
            *value = v.map(f64x4::to_array);
            let row = |i: usize| if i < G { v[i].to_array() } else { [0.0; LANES] };
            for i in 0..G {
                // v̈_n = −γ₁v_n − γ₂(2v_n − v_(n−1) − v_(n+1))
                let ([_, .., a], [b, c, d, e], [f, ..]) = (row(i.wrapping_sub(1)), row(i), row(i + 1));
                let sides = f64x4::from([a, b, c, d]) + f64x4::from([c, d, e, f]);
                acceleration[i] = (f64x4::splat(own) * v[i] + f64x4::splat(side) * sides).to_array();
                // On to the next node.
                let [cos, sin_over, sin_times] = turns[i];
                (u[i], w[i]) = (u[i] * cos + w[i] * sin_over, w[i] * cos - u[i] * sin_times);
            }
            let (value, acceleration) = (value.as_flattened(), acceleration.as_flattened_mut());
            for (mass, left, right) in ends {
                acceleration[mass] = own * value[mass] + side * (value[left] + value[right]);
            }
        }
        let infinite = f64x4::splat(f64::INFINITY);
        let (mut low, mut high, mut top) = ([infinite; G], [-infinite; G], [f64x4::ZERO; G]);
        let rows = rows_mut::<G>(&mut self.values).zip(rows_mut::<G>(&mut self.accelerations));
        let per_square = 2.0 / (self.step * self.step);
        for (node, (value, acceleration)) in rows.enumerate() {
            // What obeys the equation of motion without the force bounds the rest of it.
            for i in 0..G {
                top[i] = top[i].fast_max(f64x4::from(acceleration[i]).abs());
            }
            if let Some(driven) = self.driven.get(node) {
                let [place, pull] = [driven[0], driven[2] * per_square].map(f64x4::splat);
                for i in 0..G {
                    value[i] = (f64x4::from(value[i]) + place).to_array();
                    acceleration[i] = (f64x4::from(acceleration[i]) + pull).to_array();
                }
            }
            for i in 0..G {
                let v = f64x4::from(value[i]);
                (low[i], high[i]) = (low[i].fast_min(v), high[i].fast_max(v));
            }
        }
        for (i, extremes) in self.extremes.iter_mut().enumerate().take(G) {
            *extremes = [low[i], high[i], top[i]].map(f64x4::to_array);
        }
    }

    /// What an interval does to each mode.
    fn turns<const G: usize>(&self) -> [[f64x4; 3]; G] {
        let frequency = |i: usize| self.frequencies.get(i).map_or(f64x4::ZERO, |group| f64x4::from(*group));
        std::array::from_fn(|i| turn(frequency(i), f64x4::splat(self.step)))
    }

    /// Bounds of each mass's own. With c = γh²/8 the largest moduli R_n of accelerations on the whole flight obey
    /// R ≤ A + CR, where A_n are the largest at nodes and C has c₁+2c₂ on its diagonal and c₂ beside it. (I − C)⁻¹ has no
    /// negative entry, so that R ≤ r for every r with (I − C)r ≥ A: r = Σ_m θ^|n−m| A_m/(1 − c₁ − 5c₂),
    /// θ = c₂/(1 − c₁ − 4c₂), is one, if the sum takes the mirror images beyond both ends of the half ring. `false` where
    /// these could matter.
    fn bound(&mut self, (gamma1, gamma2): (f64, f64), watched: &DistinctMasses) -> bool {
        let eighth = 0.125 * self.step * self.step;
        let (c1, c2) = (eighth * gamma1, eighth * gamma2);
        let theta = c2 / (1.0 - c1 - 4.0 * c2);
        self.tops.clear();
        self.tops.extend(self.extremes.iter().map(|[_, _, top]| *top));
        let tops = self.tops.as_flattened().iter().take(watched.sites().len());
        self.seconds.clear();
        let (mut sum, mut last) = (0.0, 0.0);
        self.seconds.extend(tops.clone().map(|top| {
            (sum, last) = (top + theta * sum, *top);
            sum
        }));
        // What lies beyond each mass, away from the breather. Beyond the far end the images begin with the last mass (odd
        // rings) or that before it; twice, for what the images beyond the near end, not counted yet, add to them.
        let mut beyond = 2.0 * (theta * sum).max(sum - last);
        self.beyond.clear();
        self.beyond.extend(tops.rev().map(|top| {
            let next = theta * (top + beyond);
            std::mem::replace(&mut beyond, next)
        }));
        // What adds to mass 0 is what its images, beyond the near end, add to all.
        let (Some(near), Some(first)) = (self.beyond.last(), self.seconds.first()) else { return false };
        // Not a number where nothing is accelerated.
        let images = 1.0 + near / first;
        if images.is_nan() || images > 2.0 {
            return false;
        }
        let scale = 1.0 / (1.0 - c1 - 5.0 * c2);
        for (second, beyond) in self.seconds.iter_mut().zip(self.beyond.iter().rev()) {
            *second = scale * (images * *second + beyond) + self.driven_at_most[0];
        }
        true
    }

    /// Number of intervals.
    pub(crate) fn intervals(&self) -> usize {
        self.intervals
    }

    /// Their length.
    pub(crate) fn step(&self) -> f64 {
        self.step
    }

    /// Displacements of all masses at a node, in whole groups.
    pub(crate) fn node(&self, node: usize) -> &[f64] {
        self.values.chunks_exact(self.groups).nth(node).unwrap_or_default().as_flattened()
    }

    /// From a node to the next in the lists below, where a mass has its own number at the first one.
    pub(crate) fn stride(&self) -> usize {
        self.groups * LANES
    }

    /// Displacement of the mass and node at a place.
    pub(crate) fn value(&self, place: usize) -> f64 {
        self.values.as_flattened()[place]
    }

    /// How close to a barrier each mass could come in the whole flight.
    pub(crate) fn reaches(&mut self, gap: impl Fn(usize) -> Gap) -> &[f64] {
        let slack = 0.125 * self.step * self.step;
        self.reaches.clear();
        let seconds = self.seconds.chunks(LANES).zip(&self.extremes).enumerate();
        for (group, (seconds, [low, high, _])) in seconds {
            for (lane, second) in seconds.iter().enumerate() {
                let (Gap { centre, half }, low, high) = (gap(group * LANES + lane), low[lane], high[lane]);
                let out = if centre - low > high - centre { centre - low } else { high - centre };
                self.reaches.push(half - out - slack * second);
            }
        }
        &self.reaches
    }

    /// How far from rest a mass could be in the whole flight.
    pub(crate) fn excursion(&self, mass: usize) -> f64 {
        let [low, high, _] = &self.extremes[mass / LANES];
        low[mass % LANES].abs().max(high[mass % LANES].abs()) + self.slack(mass)
    }

    /// How far between two nodes a mass can leave the range of its values there.
    pub(crate) fn slack(&self, mass: usize) -> f64 {
        0.125 * self.step * self.step * self.seconds[mass]
    }

    /// The bound on |v̈| of a mass.
    #[cfg(test)]
    pub(crate) fn second(&self, mass: usize) -> f64 {
        self.seconds[mass]
    }

    /// A bound on |v⃜| of a mass in the whole flight.
    pub(crate) fn fourth(&self, forces: Forces<'_>, mass: usize) -> f64 {
        let Forces::Ring { stiffnesses: (gamma1, gamma2), watched } = forces else { return self.fourths[mass] };
        let sides = self.seconds[watched.left()[mass]] + self.seconds[watched.right()[mass]];
        (gamma1 + 2.0 * gamma2) * self.seconds[mass] + gamma2 * sides + self.driven_at_most[1]
    }

    /// The shapes of a mass, into `column` where they have to be gathered: of a ring cos(2πkn/M) is symmetric in k and n.
    pub(crate) fn shapes<'a>(
        &self,
        flight: Flight<'a>,
        forces: Forces<'_>,
        mass: usize,
        column: &'a mut Vec<Lane>,
    ) -> &'a [Lane] {
        if let Forces::Ring { .. } = forces {
            return flight.shapes.get(mass * self.groups..(mass + 1) * self.groups).unwrap_or_default();
        }
        let rows = flight.shapes.chunks_exact(self.groups);
        fill(column, rows.map(|row| row[mass / LANES][mass % LANES]), 0.0);
        column
    }

    /// Whether a mass of these shapes surely does not turn in an interval, but at those ends of the flight where it is `known` to; `fourth` is the
    /// bound on its |v⃜|, and places closer than `resolution` are not told apart.
    pub(crate) fn is_monotone(
        &self,
        (shapes, mass): (&[Lane], usize),
        interval: usize,
        (fourth, resolution): (f64, f64),
        known: [bool; 2],
    ) -> bool {
        let [first, last] = [interval, interval + 1].map(|node| {
            let driven = self.driven.get(node).map_or(0.0, |driven| driven[1] / self.step);
            dot(shapes, &self.velocities[node * self.mode_groups..]) + driven
        });
        let (place, accelerations) = (interval * self.stride() + mass, self.accelerations.as_flattened());
        let (before, after) = (accelerations[place], accelerations[place + self.stride()]);
        // The third derivative is within B₄h of its mean.
        let bend = (after - before).abs() + fourth * self.step * self.step;
        let straight = (first > 0.0) == (last > 0.0) && first.abs().min(last.abs()) > 0.125 * bend * self.step;
        // A contact of a structure may feel an impact of another one: it has a corner there.
        let is_still = |velocity: f64, other: f64| {
            velocity.abs() <= STILL * other.abs() || velocity.abs() * self.step <= resolution
        };
        straight
            || (interval == 0 && known[0] && before.abs() > 0.5 * bend && is_still(first, last))
            || (interval + 1 == self.intervals && known[1] && after.abs() > 0.5 * bend && is_still(last, first))
    }

    /// The motion of a mass of these shapes from a node on, in units of an interval.
    pub(crate) fn polynomial(&mut self, shapes: &[Lane], node: usize) -> Polynomial {
        let from = node * self.mode_groups;
        let states = self.displacements.iter().zip(&self.velocities).skip(from);
        let step = f64x4::splat(self.step);
        self.scratch.clear();
        self.scratch.extend(shapes.iter().zip(states).map(|(shape, (u, w))| {
            let shape = f64x4::from(*shape);
            [shape * f64x4::from(*u), shape * f64x4::from(*w) * step]
        }));
        let mut polynomial = Polynomial::of_swings(&mut self.scratch, &self.frequencies, step);
        if let Some(driven) = self.driven.get(node) {
            polynomial.coefficients.iter_mut().zip(driven).for_each(|(own, driven)| *own += driven);
        }
        polynomial
    }
}

/// γ₁ and γ₂ of a ring, the latter without effect on a single mass.
fn stiffnesses(chain: &Chain) -> (f64, f64) {
    (chain.gamma1(), if chain.sites() > 1 { chain.gamma2() } else { 0.0 })
}

/// So many groups, those that are not there 0.
fn row<const G: usize>(list: &[Lane]) -> [f64x4; G] {
    std::array::from_fn(|i| list.get(i).map_or(f64x4::ZERO, |group| f64x4::from(*group)))
}

/// Rows of groups.
fn rows_mut<const G: usize>(list: &mut [Lane]) -> std::slice::IterMut<'_, [Lane; G]> {
    list.as_chunks_mut::<G>().0.iter_mut()
}

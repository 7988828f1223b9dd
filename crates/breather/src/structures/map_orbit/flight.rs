//! Where contacts go in half a period, by values and velocities at the ends of windows and bounds between these.

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::simd::lanes::{LANES, Lane, ONE, ZERO, all, combine, four, total};
use vibrochain_lattice::{Barrier, Contact, Turn};
use wide::f64x4;

use super::modes::Modes;
use crate::motion::polynomial::{Polynomial, turning_points, with_overlap};
use crate::structures::admissible::passage::Passage;
use crate::structures::view::{Lanes, View};

/// Radians of the fastest mode in a window.
const WINDOW: f64 = 1.0;

/// Nodes at most: modes are turned on from one to the next, and rounding adds up.
const MOST_WINDOWS: f64 = 32.0;

/// Two numbers of each mode or contact at one node after the other, four at a time.
type Rows = SmallVec<[[Lane; 2]; 32]>;

/// Where a contact, known by its place in a list, is nearest to a barrier; place, barrier and time are told where it is beyond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Closest {
    pub(super) distance: f64,
    pub(super) place: usize,
    pub(super) barrier: Barrier,
    pub(super) time: f64,
}

impl Closest {
    fn at(distance: f64) -> Self {
        Self { distance, place: 0, barrier: Barrier::Lower, time: 0.0 }
    }

    fn note(&mut self, other: Self) {
        if other.distance < self.distance {
            *self = other;
        }
    }

    /// The nearest one at both ends of a flight of this length, by what contacts do there and where their barriers are.
    fn of_ends(ends: [(&[[Lane; 2]], &[Lanes; 2]); 2], whole: f64) -> Self {
        let mut closest = Self::at(f64::INFINITY);
        for place in 0..LANES * ends[0].0.len() {
            for barrier in [Barrier::Lower, Barrier::Upper] {
                for ((row, stops), time) in ends.into_iter().zip([0.0, whole]) {
                    let [there, _] = row[place / LANES];
                    let stop = stops[usize::from(barrier == Barrier::Upper)][place / LANES][place % LANES];
                    let distance = barrier.sign() * (stop - there[place % LANES]);
                    closest.note(Self { distance, place, barrier, time });
                }
            }
        }
        closest
    }
}

/// Half a period between impacts, in windows.
pub(super) struct Flight<'m> {
    modes: &'m Modes,
    /// Places of the modes just after the first impact, and velocities over Ω.
    start: [Lanes; 2],
    /// cos Ωh, sin Ωh of a window's length h.
    turn: [Lanes; 2],
    half: f64,
    length: f64,
    windows: usize,
}

impl Modes {
    /// The flight from the impact at 0 to half a period later, by the rate of the fastest mode; `None` where that takes too many windows.
    pub(super) fn flight(&self, [first, second]: [f64; 2], (half, fastest): (f64, f64)) -> Option<Flight<'_>> {
        let windows = (half * fastest / WINDOW).ceil().max(1.0);
        if windows > MOST_WINDOWS {
            return None;
        }
        let length = half / windows;
        let (mut place, mut speed, mut turn) =
            (self.gain.clone(), self.gain.clone(), [self.gain.clone(), self.gain.clone()]);
        for g in 0..self.gain.len() {
            let (gain, cos, inverse) = (four(self.gain[g]), four(self.cos[g]), four(self.inverse[g]));
            place[g] = (gain * inverse * (all(first) * cos + all(second))).to_array();
            // Half of what the impulse gives, over Ω.
            speed[g] = (gain * all(0.5 * first) / four(self.frequency[g])).to_array();
            let [cos, sin] = Turn::Circular.turns(length, self.frequency[g]).unwrap_or_default();
            (turn[0][g], turn[1][g]) = (cos, sin);
        }
        Some(Flight { modes: self, start: [place, speed], turn, half, length, windows: windows as usize })
    }
}

impl Flight<'_> {
    /// Two numbers of all modes a window later, the second one over Ω.
    fn turn_on(&self, [place, speed]: &mut [Lanes; 2]) {
        for g in 0..place.len() {
            let ([x, y], [cos, sin]) = ([four(place[g]), four(speed[g])], [0, 1].map(|i| four(self.turn[i][g])));
            place[g] = (x * cos + y * sin).to_array();
            speed[g] = (y * cos - x * sin).to_array();
        }
    }

    /// Whether no other two instants are possible: −K′(T/2 + s) = Σ φ₀² sin Ωs/(2 sin ΩT/2) has no zero for 0 < s ≤ T/2.
    pub(super) fn is_alone(&self) -> bool {
        let modes = self.modes;
        let mut wave: [Lanes; 2] =
            [smallvec![[0.0; LANES]; modes.seen.len()], smallvec![[0.0; LANES]; modes.seen.len()]];
        let mut fourth = ZERO;
        for (g, wave) in wave[1].iter_mut().enumerate() {
            let omega = four(modes.frequency[g]);
            let size = four(modes.seen[g]) * four(modes.inverse[g]) * omega;
            fourth += size.abs() * (omega * omega) * (omega * omega);
            *wave = size.to_array();
        }
        let fourth = total(fourth);
        // Value and slope; the cosines' amplitudes are those of the sines.
        let jet = |[sine, cosine]: &[Lanes; 2]| {
            let mut sums = [ZERO; 2];
            for g in 0..sine.len() {
                sums = [sums[0] + four(sine[g]), sums[1] + four(cosine[g]) * four(modes.frequency[g])];
            }
            sums.map(total)
        };
        let mut here = jet(&wave);
        let mut sign = 0.0;
        for window in 0..self.windows {
            self.turn_on(&mut wave);
            let next = jet(&wave);
            let mut passage = Passage::new(here, next, self.length, fourth);
            passage.off += modes.doubt;
            // 0 at its beginning, it is monotone there; then it keeps its sign.
            let clear = if window == 0 {
                sign = next[0].signum();
                !passage.may_turn([false, false])
            } else {
                passage.points.iter().all(|point| point * sign > passage.off)
            };
            if !clear {
                return false;
            }
            here = next;
        }
        true
    }

    /// The turning point at which a contact is nearest to a barrier. Where contacts go beyond, the first window in which one does tells the farthest
    /// place of that window. `None` where no contact turns. The first contact of the list is the one that is hit: it is on these barriers at both
    /// ends.
    pub(super) fn closest(&self, view: &View, contacts: &[Contact], hit: [Option<Barrier>; 2]) -> Option<Closest> {
        let groups = view.sights.still.len();
        let stops = stops(view, contacts);
        // Without the barriers that the first contact is on.
        let without = |barriers: &[Option<Barrier>]| {
            let mut free = stops.clone();
            for barrier in barriers.iter().flatten() {
                free[usize::from(*barrier == Barrier::Upper)][0][0] = barrier.sign() * f64::INFINITY;
            }
            free
        };
        let (nodes, states) = self.nodes(view);
        let room = |row: &[[Lane; 2]], [lower, upper]: &[Lanes; 2]| {
            let mut least = all(f64::INFINITY);
            for (g, [place, _]) in row.iter().enumerate() {
                let place = four(*place);
                least = least.fast_min((place - four(lower[g])).fast_min(four(upper[g]) - place));
            }
            least.to_array().into_iter().fold(f64::INFINITY, f64::min)
        };
        // At both ends all turn, by symmetry, or are on a barrier.
        let mut rows = nodes.chunks_exact(groups);
        let ends = [rows.next()?, rows.next_back()?];
        let [at_begin, at_end] = [0, 1].map(|i| without(&hit[i..=i]));
        let mut closest = Closest::at(room(ends[0], &at_begin).min(room(ends[1], &at_end)));
        if closest.distance <= 0.0 {
            closest = Closest::of_ends([(ends[0], &at_begin), (ends[1], &at_end)], self.half);
        }
        // Of several that are in the way the first one is told.
        let free = without(&hit);
        let nearest = rows.map(|row| room(row, &free)).fold(f64::INFINITY, f64::min).max(0.0);
        let (fourths, count) = (self.fourths(view), self.modes.gain.len());
        let mut pending = Vec::new();
        for window in 0..self.windows {
            let [begin, end] = [window, window + 1].map(|node| &nodes[node * groups..(node + 1) * groups]);
            for g in 0..groups {
                let [here, there] = [begin[g], end[g]].map(|both| both.map(four));
                let passages = Passage::new(here, there, self.length, four(fourths[g]));
                let rooms = [(Barrier::Lower, 0), (Barrier::Upper, 1)]
                    .map(|(barrier, side)| passages.room(barrier, four(stops[side][g])));
                let room = rooms[0].fast_min(rooms[1]).to_array();
                for (lane, room) in room.into_iter().enumerate() {
                    // Where there is no barrier either may be infinite.
                    if room > closest.distance.min(nearest) || room == f64::INFINITY {
                        continue;
                    }
                    let passage = passages.of(lane);
                    if !passage.may_turn([window == 0, window + 1 == self.windows]) {
                        continue;
                    }
                    let polynomial =
                        self.polynomial(view, g * LANES + lane, &states[window * count..(window + 1) * count]);
                    for (side, barrier) in [Barrier::Lower, Barrier::Upper].into_iter().enumerate() {
                        let stop = stops[side][g][lane];
                        if stop.is_infinite() || passage.room(barrier, stop) > closest.distance.min(nearest) {
                            continue;
                        }
                        let (own, scale) = polynomial.before(barrier, stop, self.length);
                        let range = with_overlap(self.length, [window > 0, window + 1 < self.windows]);
                        let so_far = closest.distance / scale;
                        let mut note = |since: f64, value: f64| {
                            let (distance, time) = ((1.0 - value) * scale, window as f64 * self.length + since);
                            closest.note(Closest { distance, place: g * LANES + lane, barrier, time });
                            closest.distance / scale
                        };
                        turning_points(&own, range, &mut pending, so_far, &mut note, 0.0);
                    }
                }
            }
            if closest.distance <= 0.0 {
                break;
            }
        }
        closest.distance.is_finite().then_some(closest)
    }

    /// Places of all contacts, from where they are still, and velocities at both ends of each window: a row for each; and those of the modes, the
    /// latter over Ω.
    fn nodes(&self, view: &View) -> (Rows, Rows) {
        let groups = view.sights.still.len();
        let (mut nodes, mut states) = (Rows::new(), Rows::new());
        let (mut state, mut rates) = (self.start.clone(), self.start[1].clone());
        let mut seen: [Lanes; 2] = [smallvec![[0.0; LANES]; groups], smallvec![[0.0; LANES]; groups]];
        for window in 0..=self.windows {
            for (rate, (speed, frequency)) in rates.iter_mut().zip(state[1].iter().zip(&self.modes.frequency)) {
                *rate = (four(*speed) * four(*frequency)).to_array();
            }
            let shapes = &view.sights.shapes;
            combine(shapes, state[0].as_flattened().iter().copied(), &mut seen[0]);
            combine(shapes, rates.as_flattened().iter().copied(), &mut seen[1]);
            nodes.extend(seen[0].iter().zip(&seen[1]).map(|(place, speed)| [*place, *speed]));
            if window < self.windows {
                states.extend(state[0].iter().zip(&state[1]).map(|(place, speed)| [*place, *speed]));
                self.turn_on(&mut state);
            }
        }
        (nodes, states)
    }

    /// Bounds of the contacts' |g⁗|.
    fn fourths(&self, view: &View) -> Lanes {
        let groups = view.sights.still.len();
        let mut reach = self.start[0].clone();
        for (g, reach) in reach.iter_mut().enumerate() {
            let (x, y, omega) = (four(self.start[0][g]), four(self.start[1][g]), four(self.modes.frequency[g]));
            *reach = ((x * x + y * y).sqrt() * (omega * omega) * (omega * omega)).to_array();
        }
        let mut sums: Lanes = smallvec![[0.0; LANES]; groups];
        for (row, reach) in view.sights.shapes.chunks_exact(groups).zip(reach.as_flattened()) {
            for (sum, shape) in sums.iter_mut().zip(row) {
                *sum = (four(*sum) + four(*shape).abs() * all(*reach)).to_array();
            }
        }
        sums
    }

    /// The motion of a contact from where the modes are in this state.
    fn polynomial(&self, view: &View, place: usize, state: &[[Lane; 2]]) -> Polynomial {
        let groups = view.sights.still.len();
        let mut shape: Lanes = smallvec![[0.0; LANES]; state.len()];
        let column = view.sights.shapes.chunks_exact(groups).map(|row| row[place / LANES][place % LANES]);
        shape.as_flattened_mut().iter_mut().zip(column).for_each(|(slot, value)| *slot = value);
        let mut terms: SmallVec<[[f64x4; 2]; 4]> = SmallVec::with_capacity(state.len());
        for (g, (shape, state)) in shape.iter().zip(state).enumerate() {
            let ([there, speed], shape) = (state.map(four), four(*shape));
            terms.push([shape * there, shape * speed * four(self.modes.frequency[g])]);
        }
        Polynomial::of_swings(&mut terms, &self.modes.frequency, ONE)
    }
}

/// Lower and upper barriers from where contacts are still, four at a time; as far as can be where there are none.
fn stops(view: &View, contacts: &[Contact]) -> [Lanes; 2] {
    [(Barrier::Lower, f64::NEG_INFINITY), (Barrier::Upper, f64::INFINITY)].map(|(barrier, far)| {
        let mut lanes: Lanes = smallvec![[far; LANES]; view.sights.still.len()];
        let still = view.sights.still.as_flattened();
        for (slot, (contact, still)) in lanes.as_flattened_mut().iter_mut().zip(contacts.iter().zip(still)) {
            *slot = contact.barrier(barrier).map_or(far, |stop| stop - still);
        }
        lanes
    })
}

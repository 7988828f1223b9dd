//! One flight of an orbit in windows of a radian of its fastest part, four modes at a time.

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::{Turn, Turned};

use super::flight::{StructureMotion, reach};
use super::periodic_kernel::length;
use crate::lanes::{LANES, Lane, combine, dot, four};
use crate::motion::polynomial::{ORDER, Polynomial};

/// Radians of the fastest part in a window.
const WINDOW: f64 = 1.0;

/// More windows than this in a flight are not laid: modes far above all others are bounded instead.
const MOST_WINDOWS: f64 = 600.0;

/// Windows after which states are set anew, so that rounding cannot add up.
const REFRESH: usize = 32;

/// As many groups as a structure of sixteen modes has without asking for memory.
type Lanes = SmallVec<[Lane; 4]>;

/// One flight in windows, on which contacts are polynomials to rounding, some of a structure's, known by their places in a list. The motion under a
/// load is one mode more, that nothing damps.
pub(super) struct Windows {
    /// Length of a window, and how many there are.
    pub(super) length: f64,
    count: usize,
    number: usize,
    whole: f64,
    parts: Vec<Part>,
    /// From this one on contacts see both coordinates, before it the first alone.
    both: usize,
    /// What they see, four at a time: of first coordinates, and of second ones behind. And where they are under the static load.
    shapes: Vec<Lane>,
    still: Lanes,
    /// What a window does to the parts.
    step: Flow,
    generator: Flow,
    /// At the window's start and end.
    here: Node,
    next: Node,
    /// Velocities of the parts, and what all contacts have of places and velocities, where that was last looked at.
    rates: Node,
    places: Lanes,
    velocities: Lanes,
    /// Derivatives over factorials at its start as contacts see them, once they are asked for.
    derivatives: Vec<Lane>,
    derived: bool,
}

/// A number of each contact.
pub(super) type Bounds = SmallVec<[f64; 4 * LANES]>;

/// A mode, or the motion under a load, with its state at the beginning.
#[derive(Clone, Copy)]
struct Part {
    flow: (Turn, f64, f64),
    state: [f64; 2],
}

/// What each coordinate keeps, what the first one gets from the second, and the second from the first.
struct Flow([Lanes; 3]);

/// The two coordinates of all parts.
#[derive(Clone, Default)]
struct Node([Lanes; 2]);

impl Flow {
    fn of(parts: &[Part], groups: usize, by: impl Fn(usize) -> Turned) -> Self {
        let mut lanes = [(); 3].map(|()| -> Lanes { smallvec![[0.0; LANES]; groups] });
        for (k, part) in parts.iter().enumerate() {
            let Turned { even, odd } = by(k);
            let [keeps, gets, gives] = &mut lanes;
            let values = [(keeps, even), (gets, odd), (gives, -part.flow.0.sign() * odd)];
            values.into_iter().for_each(|(lanes, value)| lanes.as_flattened_mut()[k] = value);
        }
        Self(lanes)
    }

    /// All coordinates turned, times a number.
    fn act(&self, Node([x, y]): &Node, by: f64, Node([next_x, next_y]): &mut Node) {
        let [keeps, gets, gives] = &self.0;
        for g in 0..x.len() {
            let (a, b, by) = (four(x[g]), four(y[g]), four([by; LANES]));
            next_x[g] = ((four(keeps[g]) * a + four(gets[g]) * b) * by).to_array();
            next_y[g] = ((four(keeps[g]) * b + four(gives[g]) * a) * by).to_array();
        }
    }
}

impl Node {
    fn of(parts: &[Part], groups: usize, state: impl Fn(usize) -> [f64; 2]) -> Self {
        let mut lanes = [(); 2].map(|()| -> Lanes { smallvec![[0.0; LANES]; groups] });
        for k in 0..parts.len() {
            lanes.iter_mut().zip(state(k)).for_each(|(lanes, value)| lanes.as_flattened_mut()[k] = value);
        }
        Self(lanes)
    }
}

impl Windows {
    /// Of the flight after impact `i`. `None` where there would be too many, or a rigid mode is no part of the modes' flight.
    pub(super) fn new(motion: &StructureMotion<'_>, i: usize, contacts: &[usize]) -> Option<Self> {
        let response = motion.response();
        if response.kernel.has_rigid() {
            return None;
        }
        let fastest = motion.felt(i).map(|(mode, _)| length([mode.rate, mode.decay])).fold(0.0, f64::max);
        let fastest = response.swings(0).map(|(rate, _)| rate).fold(fastest, f64::max);
        let whole = motion.until_next(i);
        let windows = (whole * fastest / WINDOW).ceil().max(1.0);
        if windows > MOST_WINDOWS {
            return None;
        }
        let length = whole / windows;
        // Modes of which contacts see one coordinate come first.
        let of_kind = |real: bool| motion.felt(i).filter(move |(mode, _)| mode.is_real == real);
        let modes = || of_kind(true).chain(of_kind(false));
        let both = of_kind(true).count();
        let mut parts: Vec<Part> = Vec::with_capacity(motion.felt(i).count() + response.swings(0).count());
        parts.extend(modes().map(|(mode, state)| Part { flow: (mode.turn, mode.decay, mode.rate), state }));
        for (rate, _) in response.swings(0) {
            let (sin, cos) = (rate * motion.load_time(i, 0.0)).sin_cos();
            parts.push(Part { flow: (Turn::Circular, 0.0, rate), state: [cos, -sin] });
        }
        let groups = parts.len().div_ceil(LANES);
        let count = parts.len();
        let fours = contacts.len().div_ceil(LANES);
        let mut shapes = vec![[0.0; LANES]; (2 * count - both) * fours];
        let mut still: Lanes = smallvec![[0.0; LANES]; fours];
        for (place, &contact) in contacts.iter().enumerate() {
            let (four, lane) = (place / LANES, place % LANES);
            still[four][lane] = response.still(contact);
            let seen = modes().map(|(mode, _)| mode.rows[contact]);
            let seen = seen.chain(response.swings(contact).map(|(_, swing)| [swing.re, swing.im]));
            for (k, [x, y]) in seen.enumerate() {
                shapes[k * fours + four][lane] = x;
                if k >= both {
                    shapes[(count + k - both) * fours + four][lane] = y;
                }
            }
        }
        let flights = Turn::flights(parts.iter().map(|part| part.flow), length);
        let mut all = Self {
            length,
            count: windows as usize,
            number: 0,
            whole,
            both,
            shapes,
            still,
            step: Flow::of(&parts, groups, |k| flights[k]),
            generator: Flow::of(&parts, groups, |k| Turned { even: -parts[k].flow.1, odd: parts[k].flow.2 }),
            here: Node::of(&parts, groups, |k| parts[k].state),
            next: Node::of(&parts, groups, |_| [0.0; 2]),
            rates: Node::of(&parts, groups, |_| [0.0; 2]),
            parts,
            places: smallvec![[0.0; LANES]; fours],
            velocities: smallvec![[0.0; LANES]; fours],
            derivatives: Vec::new(),
            derived: false,
        };
        all.step.act(&all.here, 1.0, &mut all.next);
        Some(all)
    }

    /// Looks from here on at the contacts at these places alone, and tells their new ones.
    pub(super) fn keep(&mut self, places: &mut dyn Iterator<Item = &mut usize>) {
        let kept: SmallVec<[usize; 16]> =
            places.enumerate().map(|(new, place)| std::mem::replace(place, new)).collect();
        let (before, fours) = (self.still.len(), kept.len().div_ceil(LANES));
        // New places come no later than the old ones.
        let pick = |from: &mut [Lane], row: usize| {
            let list = from.as_flattened_mut();
            for (new, old) in kept.iter().enumerate() {
                list[row * fours * LANES + new] = list[row * before * LANES + old];
            }
        };
        let rows = self.shapes.len() / before;
        (0..rows).for_each(|row| pick(&mut self.shapes, row));
        pick(&mut self.still, 0);
        self.shapes.truncate(rows * fours);
        self.still.truncate(fours);
        self.places.truncate(fours);
        self.velocities.truncate(fours);
    }

    /// Since the impact.
    pub(super) fn start(&self) -> f64 {
        self.number as f64 * self.length
    }

    /// Whether the flight goes on before the window, and after it.
    pub(super) fn goes_on(&self) -> [bool; 2] {
        [self.number > 0, self.number + 1 < self.count]
    }

    /// Goes on to the next window, if there is one.
    pub(super) fn advance(&mut self) -> bool {
        self.number += 1;
        if self.number == self.count {
            return false;
        }
        self.derived = false;
        std::mem::swap(&mut self.here, &mut self.next);
        if self.number.is_multiple_of(REFRESH) {
            let at = self.start();
            self.here = self.node_at(at);
        }
        self.step.act(&self.here, 1.0, &mut self.next);
        true
    }

    /// All parts at a time since the impact.
    fn node_at(&self, t: f64) -> Node {
        let flights = Turn::flights(self.parts.iter().map(|part| part.flow), t);
        let there = |k: usize| self.parts[k].flow.0.act(flights[k], self.parts[k].state);
        Node::of(&self.parts, self.here.0[0].len(), there)
    }

    /// The numbers that contacts see at a node.
    fn seen<'n>(&self, Node([x, y]): &'n Node) -> impl Iterator<Item = f64> + Clone + use<'n> {
        let (both, count) = (self.both, self.parts.len());
        x.as_flattened()[..count].iter().chain(&y.as_flattened()[both..count]).copied()
    }

    /// Looks at all contacts at a node.
    fn look(&mut self, at: &Node) {
        let mut rates = std::mem::take(&mut self.rates);
        self.generator.act(at, 1.0, &mut rates);
        let (mut places, mut velocities) = (std::mem::take(&mut self.places), std::mem::take(&mut self.velocities));
        combine(&self.shapes, self.seen(at), &mut places);
        combine(&self.shapes, self.seen(&rates), &mut velocities);
        for (place, still) in places.iter_mut().zip(&self.still) {
            *place = (four(*place) + four(*still)).to_array();
        }
        (self.rates, self.places, self.velocities) = (rates, places, velocities);
    }

    /// Place and velocity of a contact where all were last looked at.
    fn there(&self, place: usize) -> [f64; 2] {
        [&self.places, &self.velocities].map(|list| list.as_flattened()[place])
    }

    /// Places and velocities of some contacts at the window's end.
    pub(super) fn pass(&mut self, places: impl Iterator<Item = usize>, each: impl FnMut([f64; 2])) {
        let next = std::mem::take(&mut self.next);
        self.look(&next);
        self.next = next;
        places.map(|place| self.there(place)).for_each(each);
    }

    /// The same of so many contacts at both ends of the flight.
    pub(super) fn ends(&mut self, count: usize) -> SmallVec<[[[f64; 2]; 2]; 16]> {
        let last = self.node_at(self.whole);
        let first = Node::of(&self.parts, self.here.0[0].len(), |k| self.parts[k].state);
        self.look(&first);
        let mut both: SmallVec<[[[f64; 2]; 2]; 16]> = (0..count).map(|place| [self.there(place); 2]).collect();
        self.look(&last);
        both.iter_mut().enumerate().for_each(|(place, ends)| ends[1] = self.there(place));
        both
    }

    /// Bounds on the whole flight: how far a contact may be from where it is still, and |g⁗|.
    pub(super) fn bounds(&self) -> [Bounds; 2] {
        let (fours, count) = (self.still.len(), self.parts.len());
        [0, 4].map(|order| {
            let mut sums: Bounds = smallvec![0.0; fours * LANES];
            for (k, part) in self.parts.iter().enumerate() {
                let reach = reach(part.flow, part.state, self.whole, order);
                let first = self.shapes[k * fours..(k + 1) * fours].as_flattened();
                match (count + k).checked_sub(self.both).filter(|_| k >= self.both) {
                    None => sums.iter_mut().zip(first).for_each(|(sum, x)| *sum += reach * x.abs()),
                    Some(at) => {
                        let second = self.shapes[at * fours..(at + 1) * fours].as_flattened();
                        let both = first.iter().zip(second);
                        sums.iter_mut().zip(both).for_each(|(sum, (x, y))| *sum += reach * length([*x, *y]));
                    }
                }
            }
            sums
        })
    }

    /// The contact on this window, from its start on.
    pub(super) fn polynomial(&mut self, place: usize) -> Polynomial {
        let width = (2 * self.parts.len() - self.both).div_ceil(LANES);
        if !self.derived {
            self.derived = true;
            let mut derivatives = std::mem::take(&mut self.derivatives);
            derivatives.resize(width * ORDER, [0.0; LANES]);
            let (mut now, mut then) = (self.here.clone(), self.here.clone());
            for (order, row) in derivatives.chunks_exact_mut(width.max(1)).enumerate() {
                row.as_flattened_mut().iter_mut().zip(self.seen(&now)).for_each(|(slot, value)| *slot = value);
                self.generator.act(&now, 1.0 / (order + 1) as f64, &mut then);
                std::mem::swap(&mut now, &mut then);
            }
            self.derivatives = derivatives;
        }
        let mut row: Lanes = smallvec![[0.0; LANES]; width];
        let shapes = self.shapes.chunks_exact(self.still.len()).map(|shape| shape.as_flattened()[place]);
        row.as_flattened_mut().iter_mut().zip(shapes).for_each(|(slot, value)| *slot = value);
        let mut coefficients = [0.0; ORDER];
        for (coefficient, derivatives) in coefficients.iter_mut().zip(self.derivatives.chunks_exact(width.max(1))) {
            *coefficient = dot(&row, derivatives);
        }
        coefficients[0] += self.still.as_flattened()[place];
        Polynomial { coefficients }
    }
}

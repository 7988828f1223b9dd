//! One flight of an orbit in windows of a radian of its fastest part, four modes at a time.

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::Turn;
use vibrochain_lattice::simd::lanes::{LANES, Lane, all, combine, dot, four};

use super::flight::{StructureMotion, reach};
use super::periodic_kernel::length;
use super::view::{Flow, Lanes, Node, Sights, View};
use crate::motion::polynomial::{ORDER, Polynomial};

/// Radians of the fastest part in a window.
const WINDOW: f64 = 1.0;

/// More windows than this in a flight are not laid: modes far above all others are bounded instead.
const MOST_WINDOWS: f64 = 600.0;

/// Windows after which states are set anew, so that rounding cannot add up.
const REFRESH: usize = 32;

/// One flight in windows, on which contacts are polynomials to rounding, some of a structure's, known by their places in a list.
pub(super) struct Windows<'v> {
    view: &'v View,
    /// Length of a window, and how many there are.
    pub(super) length: f64,
    count: usize,
    /// How long the flight is looked at.
    pub(super) whole: f64,
    /// What the contacts see that are still looked at, where these are not all.
    kept: Option<Sights>,
    /// The parts at the beginning.
    first: Node,
    /// What a window does to them.
    step: Flow,
    /// Where each window starts.
    starts: Vec<Node>,
    sighted: Sighted,
    /// Derivatives over factorials at the start of one of them as contacts see them, once they are asked for.
    derivatives: Vec<Lane>,
    derived: Option<usize>,
}

/// Places and velocities of all contacts where they were last looked at, four at a time; and velocities of the parts.
pub(super) struct Sighted {
    pub(super) places: Lanes,
    pub(super) velocities: Lanes,
    rates: Node,
}

impl Sighted {
    /// Looks at all contacts at a node.
    fn look(&mut self, view: &View, kept: &Option<Sights>, at: &Node) {
        let Sights { shapes, still } = kept.as_ref().unwrap_or(&view.sights);
        view.generator.act(at, 1.0, &mut self.rates);
        combine(shapes, view.seen(at), &mut self.places);
        combine(shapes, view.seen(&self.rates), &mut self.velocities);
        for (place, still) in self.places.iter_mut().zip(still) {
            *place = (four(*place) + four(*still)).to_array();
        }
    }
}

impl<'v> Windows<'v> {
    /// Of the flight after impact `i`, as far as `whole`. `None` where there would be too many.
    pub(super) fn new(view: &'v View, motion: &StructureMotion<'_>, i: usize, whole: f64) -> Option<Self> {
        let windows = (whole * view.fastest / WINDOW).ceil().max(1.0);
        if windows > MOST_WINDOWS {
            return None;
        }
        let length = whole / windows;
        let (groups, fours) = (view.flows.len().div_ceil(LANES), view.sights.still.len());
        let mut first = Node::zeros(groups);
        view.numbers.iter().enumerate().for_each(|(k, &number)| first.put(k, motion.state(i, number)));
        for (k, flow) in view.flows.iter().enumerate().skip(view.numbers.len()) {
            let (sin, cos) = (flow.rate * motion.load_time(i, 0.0)).sin_cos();
            first.put(k, [cos, -sin]);
        }
        let flights = Turn::flights(view.flows.iter().copied(), length);
        Some(Self {
            view,
            length,
            count: windows as usize,
            whole,
            kept: None,
            step: Flow::of(&view.flows, |k| flights[k]),
            first,
            starts: Vec::new(),
            sighted: Sighted {
                places: smallvec![[0.0; LANES]; fours],
                velocities: smallvec![[0.0; LANES]; fours],
                rates: Node::zeros(groups),
            },
            derivatives: Vec::new(),
            derived: None,
        })
    }

    /// Looks from here on at the contacts at these places alone, and tells their new ones.
    pub(super) fn keep(&mut self, places: &mut dyn Iterator<Item = &mut usize>) {
        let kept: SmallVec<[usize; 16]> =
            places.enumerate().map(|(new, place)| std::mem::replace(place, new)).collect();
        let (before, fours) = (self.view.sights.still.len(), kept.len().div_ceil(LANES));
        if fours == before {
            let apart = kept.iter().enumerate().any(|(new, old)| new != *old);
            if !apart {
                return;
            }
        }
        let pick = |from: &[Lane]| -> Vec<Lane> {
            let mut list = vec![[0.0; LANES]; from.len() / before * fours];
            for (row, from) in list.chunks_exact_mut(fours).zip(from.chunks_exact(before)) {
                row.as_flattened_mut().iter_mut().zip(&kept).for_each(|(slot, old)| *slot = from.as_flattened()[*old]);
            }
            list
        };
        let Sights { shapes, still } = &self.view.sights;
        self.kept = Some(Sights { shapes: pick(shapes), still: pick(still).into() });
        self.sighted.places.truncate(fours);
        self.sighted.velocities.truncate(fours);
    }

    /// When a window starts, since the impact.
    pub(super) fn start(&self, number: usize) -> f64 {
        number as f64 * self.length
    }

    /// Whether the flight goes on before a window, and after it.
    pub(super) fn goes_on(&self, number: usize) -> [bool; 2] {
        [number > 0, number + 1 < self.count]
    }

    /// Places and velocities of all contacts at the start of each window and at the end of the last one, four at a time: a row for each.
    pub(super) fn nodes(&mut self, nodes: &mut Vec<[Lane; 2]>) {
        nodes.clear();
        self.starts.clear();
        let (mut here, mut next) = (self.first.clone(), self.first.clone());
        for number in 0..=self.count {
            self.sighted.look(self.view, &self.kept, &here);
            nodes.extend(
                self.sighted.places.iter().zip(&self.sighted.velocities).map(|(place, speed)| [*place, *speed]),
            );
            if number == self.count {
                break;
            }
            if (number + 1).is_multiple_of(REFRESH) {
                next = self.node_at(self.start(number + 1));
            } else {
                self.step.act(&here, 1.0, &mut next);
            }
            self.starts.push(here);
            here = next.clone();
        }
    }

    /// All parts at a time since the impact.
    fn node_at(&self, t: f64) -> Node {
        let flights = Turn::flights(self.view.flows.iter().copied(), t);
        let mut node = self.first.clone();
        Flow::of(&self.view.flows, |k| flights[k]).act(&self.first, 1.0, &mut node);
        node
    }

    /// Place and velocity of a contact where all were last looked at.
    fn there(&self, place: usize) -> [f64; 2] {
        [&self.sighted.places, &self.sighted.velocities].map(|list| list.as_flattened()[place])
    }

    /// Places and velocities of so many contacts at both ends of the flight.
    pub(super) fn ends(&mut self, count: usize) -> SmallVec<[[[f64; 2]; 2]; 16]> {
        let last = self.node_at(self.whole);
        self.sighted.look(self.view, &self.kept, &self.first);
        let mut both: SmallVec<[_; 16]> = (0..count).map(|place| [self.there(place); 2]).collect();
        self.sighted.look(self.view, &self.kept, &last);
        both.iter_mut().enumerate().for_each(|(place, ends)| ends[1] = self.there(place));
        both
    }

    /// Bounds on the whole flight, of all contacts, four at a time: how far one may be from where it is still, and |g⁗|.
    pub(super) fn bounds(&self) -> [Lanes; 2] {
        let View { flows, both, sights: Sights { shapes, still }, .. } = self.view;
        let (fours, Node([x, y])) = (still.len(), &self.first);
        [0, 4].map(|order| {
            let mut sums: Lanes = smallvec![[0.0; LANES]; fours];
            for (k, flow) in flows.iter().enumerate() {
                let state = [x, y].map(|lanes| lanes.as_flattened()[k]);
                let reach = all(reach(*flow, state, self.whole, order));
                for (g, sum) in sums.iter_mut().enumerate() {
                    let mut size = four(shapes[k * fours + g]).abs();
                    if k >= *both {
                        let second = shapes[(flows.len() + k - both) * fours + g];
                        size = four(std::array::from_fn(|i| length([shapes[k * fours + g][i], second[i]])));
                    }
                    *sum = (four(*sum) + reach * size).to_array();
                }
            }
            sums
        })
    }

    /// The contact on a window, from its start on.
    pub(super) fn polynomial(&mut self, number: usize, place: usize) -> Polynomial {
        let width = (2 * self.view.flows.len() - self.view.both).div_ceil(LANES);
        if self.derived != Some(number) {
            self.derived = Some(number);
            let mut derivatives = std::mem::take(&mut self.derivatives);
            derivatives.resize(width * ORDER, [0.0; LANES]);
            let start = &self.starts[number];
            let [mut even, mut odd] = [start.clone(), start.clone()];
            for (order, row) in derivatives.chunks_exact_mut(width.max(1)).enumerate() {
                let (now, then) = if order % 2 == 0 { (&even, &mut odd) } else { (&odd, &mut even) };
                row.as_flattened_mut().iter_mut().zip(self.view.seen(now)).for_each(|(slot, value)| *slot = value);
                self.view.generator.act(now, 1.0 / (order + 1) as f64, then);
            }
            self.derivatives = derivatives;
        }
        let mut row: Lanes = smallvec![[0.0; LANES]; width];
        let Sights { shapes, still } = self.kept.as_ref().unwrap_or(&self.view.sights);
        let shapes = shapes.chunks_exact(still.len()).map(|shape| shape.as_flattened()[place]);
        row.as_flattened_mut().iter_mut().zip(shapes).for_each(|(slot, value)| *slot = value);
        let mut coefficients = [0.0; ORDER];
        for (coefficient, derivatives) in coefficients.iter_mut().zip(self.derivatives.chunks_exact(width.max(1))) {
            *coefficient = dot(&row, derivatives);
        }
        coefficients[0] += still.as_flattened()[place];
        Polynomial { coefficients }
    }
}

//! One flight of an orbit in windows of a radian of its fastest part, four modes at a time.

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::Turn;
use vibrochain_lattice::simd::lanes::{LANES, Lane, all, combine, combine_each, four};
use wide::f64x4;

use super::view::{Flow, Lanes, Node, Sights, View, reach};
use crate::motion::polynomial::{ORDER, Polynomial};
use crate::structures::periodic_kernel::length;

/// Radians of the fastest part in a window.
const WINDOW: f64 = 1.0;

/// More windows than this in a flight are not laid: modes far above all others are bounded instead.
const MOST_WINDOWS: f64 = 600.0;

/// Windows after which states are set anew, so that rounding cannot add up.
const REFRESH: usize = 32;

/// Groups of orders of a polynomial.
const FOURS: usize = ORDER / LANES;

/// Memory for the numbers of one flight, which the next flight takes over.
#[derive(Debug, Clone, Default)]
pub(crate) struct Room {
    nodes: Vec<Lane>,
    derivatives: Vec<Lane>,
}

/// One flight in windows, on which contacts are polynomials to rounding, some of a structure's known by their places in a
/// list. Velocities and derivatives count time in windows: of fast modes they stay within the range of `f64`.
pub(crate) struct Windows<'v> {
    view: &'v View,
    /// Length of a window, and how many there are.
    pub(crate) length: f64,
    count: usize,
    /// How long the flight is looked at.
    pub(crate) whole: f64,
    /// What the contacts see that are still looked at, where these are not all.
    kept: Option<Sights>,
    /// The parts where each window starts and where the last one ends, a node after the other; and derivatives over factorials of what contacts see at
    /// the start of a window, [coordinate][order], with the window's number.
    room: &'v mut Room,
    derived: Option<usize>,
    /// The contacts at both ends of the flight.
    ends: SmallVec<[Lane; 16]>,
}

impl<'v> Windows<'v> {
    /// Of a flight as far as `whole`; `begin` sets first and second coordinates of all parts at its start. `None` where there would be too many.
    pub(crate) fn new(
        view: &'v View,
        begin: impl FnOnce([&mut [f64]; 2]),
        whole: f64,
        room: &'v mut Room,
    ) -> Option<Self> {
        let windows = (whole * view.fastest / WINDOW).ceil().max(1.0);
        if windows > MOST_WINDOWS {
            return None;
        }
        let (length, count) = (whole / windows, windows as usize);
        let groups = view.flows.len().div_ceil(LANES);
        let nodes = &mut room.nodes;
        nodes.clear();
        nodes.resize((count + 1) * 2 * groups, [0.0; LANES]);
        let (x, y) = nodes[..2 * groups].as_flattened_mut().split_at_mut(groups * LANES);
        begin([x, y]);
        let flow = |t: f64| {
            let flights = Turn::flights(view.flows.iter().copied(), t);
            Flow::of(&view.flows, |k| flights[k])
        };
        let step = flow(length);
        for number in 1..=count {
            let (before, next) = nodes.split_at_mut(number * 2 * groups);
            if number.is_multiple_of(REFRESH) {
                flow(number as f64 * length).act(&before[..2 * groups], 1.0, &mut next[..2 * groups]);
            } else {
                step.act(&before[(number - 1) * 2 * groups..], 1.0, &mut next[..2 * groups]);
            }
        }
        let ends = SmallVec::new();
        let mut own = Self { view, length, count, whole, kept: None, room, derived: None, ends };
        own.look_at_ends();
        Some(own)
    }

    fn sights(&self) -> &Sights {
        self.kept.as_ref().unwrap_or(&self.view.sights)
    }

    /// The parts where a window starts, or where the last one ends.
    fn node(&self, number: usize) -> &[Lane] {
        let width = 2 * self.view.flows.len().div_ceil(LANES);
        &self.room.nodes[number * width..][..width]
    }

    /// Places and velocities of all contacts at a node.
    fn look(&self, number: usize, row: &mut [Lane]) {
        let (node, Sights { shapes, still }) = (self.node(number), self.sights());
        let mut rates: Node = smallvec![[0.0; LANES]; node.len()];
        self.view.generator.act(node, self.length, &mut rates);
        let (places, velocities) = row.split_at_mut(still.len());
        combine_each(shapes, self.view.seen(node, &rates), [&mut *places, velocities]);
        for (place, still) in places.iter_mut().zip(still) {
            *place = (four(*place) + four(*still)).to_array();
        }
    }

    fn look_at_ends(&mut self) {
        let width = 2 * self.sights().still.len();
        let mut ends = std::mem::take(&mut self.ends);
        ends.resize(2 * width, [0.0; LANES]);
        self.look(0, &mut ends[..width]);
        self.look(self.count, &mut ends[width..]);
        self.ends = ends;
    }

    /// Looks from here on at the contacts at these places alone, and tells their new ones.
    pub(crate) fn keep(&mut self, places: &mut dyn Iterator<Item = &mut usize>) {
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
        self.look_at_ends();
    }

    /// When a window starts, since the impact.
    pub(crate) fn start(&self, number: usize) -> f64 {
        number as f64 * self.length
    }

    /// Whether the flight goes on before a window, and after it.
    pub(crate) fn goes_on(&self, number: usize) -> [bool; 2] {
        [number > 0, number + 1 < self.count]
    }

    /// Places of all contacts where each window starts and where the last one ends, and behind them velocities, four at a time: a row for each.
    pub(crate) fn rows(&self, rows: &mut Vec<Lane>) {
        let (first, last) = self.ends.split_at(self.ends.len() / 2);
        rows.clear();
        rows.reserve((self.count + 1) * first.len());
        rows.extend_from_slice(first);
        rows.resize(self.count * first.len(), [0.0; LANES]);
        for (number, row) in rows.chunks_exact_mut(first.len()).enumerate().skip(1) {
            self.look(number, row);
        }
        rows.extend_from_slice(last);
    }

    /// Place and velocity of a contact at both ends of the flight.
    pub(crate) fn ends(&self, place: usize) -> [[f64; 2]; 2] {
        let (first, last) = self.ends.split_at(self.ends.len() / 2);
        let number = |lanes: &[Lane]| lanes.as_flattened()[place];
        [first, last].map(|row| [number(row), number(&row[row.len() / 2..])])
    }

    /// Where a contact is under the static load.
    pub(crate) fn still(&self, place: usize) -> f64 {
        self.view.sights.still.as_flattened()[place]
    }

    /// Bounds on the whole flight, of all contacts, four at a time: how far one may be from where it is still, and |g⁗|.
    pub(crate) fn bounds(&self) -> [Lanes; 2] {
        let View { flows, both, sights: Sights { shapes, still }, .. } = self.view;
        let fours = still.len();
        let (x, y) = self.node(0).split_at(flows.len().div_ceil(LANES));
        let (x, y) = (x.as_flattened(), y.as_flattened());
        let mut bounds: [Lanes; 2] = [smallvec![[0.0; LANES]; fours], smallvec![[0.0; LANES]; fours]];
        let [excursions, fourths] = bounds.each_mut().map(|lanes| &mut lanes[..fours]);
        for (k, flow) in flows.iter().enumerate() {
            let [reach, fourth] = [0, 4]
                .map(|order| all(reach(flow.counted_in(self.length), [x[k], y[k]], self.whole / self.length, order)));
            let mut add = |g: usize, size: f64x4| {
                excursions[g] = (four(excursions[g]) + reach * size).to_array();
                fourths[g] = (four(fourths[g]) + fourth * size).to_array();
            };
            let first = &shapes[k * fours..][..fours];
            if k < *both {
                first.iter().enumerate().for_each(|(g, first)| add(g, four(*first).abs()));
                continue;
            }
            let second = &shapes[(flows.len() + k - both) * fours..][..fours];
            for (g, (first, second)) in first.iter().zip(second).enumerate() {
                add(g, four(std::array::from_fn(|i| length([first[i], second[i]]))));
            }
        }
        bounds
    }

    /// The contact on a window, from its start on.
    pub(crate) fn polynomial(&mut self, number: usize, place: usize) -> Polynomial {
        if self.derived != Some(number) {
            self.derived = Some(number);
            self.derive(number);
        }
        let Sights { shapes, still } = self.sights();
        let shape = shapes.chunks_exact(still.len()).map(|row| row.as_flattened()[place]);
        let mut coefficients = [0.0; ORDER];
        combine(&self.room.derivatives, shape, coefficients.as_chunks_mut().0);
        coefficients[0] += still.as_flattened()[place];
        Polynomial { coefficients }
    }

    /// Works out the derivatives of all coordinates that contacts see at the start of a window.
    fn derive(&mut self, number: usize) {
        let (both, count) = (self.view.both, self.view.flows.len());
        let groups = count.div_ceil(LANES);
        let width = 2 * groups;
        // Four orders of all coordinates.
        let mut orders: SmallVec<[Lane; 32]> = smallvec![[0.0; LANES]; LANES * width];
        orders[..width].copy_from_slice(self.node(number));
        let mut derivatives = std::mem::take(&mut self.room.derivatives);
        derivatives.resize((2 * count - both) * FOURS, [0.0; LANES]);
        let generator = &self.view.generator;
        for block in 0..FOURS {
            for order in 1..LANES {
                let (before, next) = orders.split_at_mut(order * width);
                let by = self.length / (LANES * block + order) as f64;
                generator.act(&before[(order - 1) * width..], by, &mut next[..width]);
            }
            for g in (0..groups).chain(groups + both / LANES..width) {
                let parts = f64x4::transpose(std::array::from_fn(|order| four(orders[order * width + g])));
                let (from, first_seen, ahead) = if g < groups { (g, 0, 0) } else { (g - groups, both, count - both) };
                for (k, part) in (LANES * from..count).zip(parts).filter(|(k, _)| *k >= first_seen) {
                    derivatives[(k + ahead) * FOURS + block] = part.to_array();
                }
            }
            let (first, last) = orders.split_at_mut((LANES - 1) * width);
            generator.act(last, self.length / (LANES * (block + 1)) as f64, &mut first[..width]);
        }
        self.room.derivatives = derivatives;
    }
}

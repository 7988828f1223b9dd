//! One flight of an orbit in windows of a radian of its fastest part, four modes at a time.

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::simd::lanes::{LANES, Lane, all, combine, dot, four};
use vibrochain_lattice::{ModeFlow, Turn, Turned};

use super::equations::Equations;
use super::flight::{StructureMotion, reach};
use super::periodic_kernel::length;
use crate::motion::polynomial::{ORDER, Polynomial};

/// Radians of the fastest part in a window.
const WINDOW: f64 = 1.0;

/// More windows than this in a flight are not laid: modes far above all others are bounded instead.
const MOST_WINDOWS: f64 = 600.0;

/// Windows after which states are set anew, so that rounding cannot add up.
const REFRESH: usize = 32;

/// As many groups as a structure of sixteen modes has without asking for memory.
pub(super) type Lanes = SmallVec<[Lane; 4]>;

/// What contacts see of an orbit's flights: the modes and the motion under a load, which is one mode more, that nothing damps.
pub(super) struct View {
    /// How each part moves, and the number of each mode among those that are felt.
    flows: SmallVec<[ModeFlow; 16]>,
    numbers: SmallVec<[usize; 16]>,
    /// From this one on contacts see both coordinates, before it the first alone.
    both: usize,
    sights: Sights,
    generator: Flow,
    fastest: f64,
}

/// One flight in windows, on which contacts are polynomials to rounding, some of a structure's, known by their places in a list.
pub(super) struct Windows<'v> {
    view: &'v View,
    /// Length of a window, and how many there are.
    pub(super) length: f64,
    count: usize,
    number: usize,
    whole: f64,
    /// What the contacts see that are still looked at, where these are not all.
    kept: Option<Sights>,
    /// The parts at the beginning.
    first: Node,
    /// What a window does to them.
    step: Flow,
    /// The window's start and end.
    here: Node,
    next: Node,
    sighted: Sighted,
    /// Derivatives over factorials at its start as contacts see them, once they are asked for.
    derivatives: Vec<Lane>,
    derived: bool,
}

/// What contacts see of the parts, four at a time: of first coordinates, and of second ones behind; and where they are under the static load.
struct Sights {
    shapes: Vec<Lane>,
    still: Lanes,
}

/// Places and velocities of all contacts where they were last looked at, four at a time; and velocities of the parts.
pub(super) struct Sighted {
    pub(super) places: Lanes,
    pub(super) velocities: Lanes,
    rates: Node,
}

/// What each coordinate keeps, what the first one gets from the second, and the second from the first.
struct Flow([Lanes; 3]);

/// The two coordinates of all parts.
#[derive(Clone)]
struct Node([Lanes; 2]);

impl Flow {
    fn of(flows: &[ModeFlow], by: impl Fn(usize) -> Turned) -> Self {
        let mut lanes = [(); 3].map(|()| -> Lanes { smallvec![[0.0; LANES]; flows.len().div_ceil(LANES)] });
        for (k, flow) in flows.iter().enumerate() {
            let Turned { even, odd } = by(k);
            let [keeps, gets, gives] = &mut lanes;
            let values = [(keeps, even), (gets, odd), (gives, -flow.turn.sign() * odd)];
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
    fn zeros(groups: usize) -> Self {
        Self([(); 2].map(|()| smallvec![[0.0; LANES]; groups]))
    }

    fn put(&mut self, k: usize, state: [f64; 2]) {
        self.0.iter_mut().zip(state).for_each(|(lanes, value)| lanes.as_flattened_mut()[k] = value);
    }
}

impl View {
    /// Of a list of contacts. `None` where a dashpot or a static load acts on a rigid mode.
    pub(super) fn new(motion: &StructureMotion<'_>, contacts: &[usize]) -> Option<Self> {
        let response = motion.response();
        let rigid = response.kernel.rigid();
        if rigid.iter().any(|mode| mode.decay != 0.0 || Equations::push(mode) != 0.0) {
            return None;
        }
        let regular = response.kernel.regular().map(|(mode, _)| mode);
        let modes: SmallVec<[_; 16]> = regular.chain(rigid).collect();
        // Modes of which contacts see one coordinate come first.
        let mut numbers: SmallVec<[usize; 16]> = (0..modes.len()).filter(|&k| modes[k].is_real).collect();
        let both = numbers.len();
        numbers.extend((0..modes.len()).filter(|&k| !modes[k].is_real));
        let swings: SmallVec<[f64; 1]> = response.swings(0).map(|(rate, _)| rate).collect();
        let mut flows: SmallVec<[_; 16]> = numbers.iter().map(|&k| modes[k].flow()).collect();
        flows.extend(swings.iter().map(|&rate| ModeFlow { turn: Turn::Circular, decay: 0.0, rate }));
        let (count, fours) = (flows.len(), contacts.len().div_ceil(LANES));
        let mut shapes = vec![[0.0; LANES]; (2 * count - both) * fours];
        let mut put =
            |row: usize, place: usize, value: f64| shapes.as_flattened_mut()[row * fours * LANES + place] = value;
        for (row, &k) in numbers.iter().enumerate() {
            for (place, &contact) in contacts.iter().enumerate() {
                let [x, y] = modes[k].rows[contact];
                put(row, place, x);
                if row >= both {
                    put(count + row - both, place, y);
                }
            }
        }
        let mut still: Lanes = smallvec![[0.0; LANES]; fours];
        for (place, &contact) in contacts.iter().enumerate() {
            still.as_flattened_mut()[place] = response.still(contact);
            for (number, (_, swing)) in response.swings(contact).enumerate() {
                let row = numbers.len() + number;
                put(row, place, swing.re);
                put(count + row - both, place, swing.im);
            }
        }
        // A rigid mode goes on as it does: its κ is a unit of velocity.
        let turning = modes.iter().filter(|mode| !mode.is_rigid());
        let fastest = turning.map(|mode| length([mode.rate, mode.decay])).chain(swings).fold(0.0, f64::max);
        let generator = Flow::of(&flows, |k| Turned { even: -flows[k].decay, odd: flows[k].rate });
        Some(Self { flows, numbers, both, sights: Sights { shapes, still }, generator, fastest })
    }

    /// The numbers that contacts see at a node.
    fn seen<'n>(&self, Node([x, y]): &'n Node) -> impl Iterator<Item = f64> + Clone + use<'n> {
        let (both, count) = (self.both, self.flows.len());
        x.as_flattened()[..count].iter().chain(&y.as_flattened()[both..count]).copied()
    }
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
    /// Of the flight after impact `i`. `None` where there would be too many.
    pub(super) fn new(view: &'v View, motion: &StructureMotion<'_>, i: usize) -> Option<Self> {
        let whole = motion.until_next(i);
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
        let mut own = Self {
            view,
            length,
            count: windows as usize,
            number: 0,
            whole,
            kept: None,
            step: Flow::of(&view.flows, |k| flights[k]),
            here: first.clone(),
            first,
            next: Node::zeros(groups),
            sighted: Sighted {
                places: smallvec![[0.0; LANES]; fours],
                velocities: smallvec![[0.0; LANES]; fours],
                rates: Node::zeros(groups),
            },
            derivatives: Vec::new(),
            derived: false,
        };
        own.step.act(&own.here, 1.0, &mut own.next);
        Some(own)
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
        let flights = Turn::flights(self.view.flows.iter().copied(), t);
        let mut node = self.first.clone();
        Flow::of(&self.view.flows, |k| flights[k]).act(&self.first, 1.0, &mut node);
        node
    }

    /// Place and velocity of a contact where all were last looked at.
    fn there(&self, place: usize) -> [f64; 2] {
        [&self.sighted.places, &self.sighted.velocities].map(|list| list.as_flattened()[place])
    }

    /// Places and velocities of all contacts at the window's end, four at a time.
    pub(super) fn pass(&mut self) -> &Sighted {
        self.sighted.look(self.view, &self.kept, &self.next);
        &self.sighted
    }

    /// The same of so many contacts at both ends of the flight.
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

    /// The contact on this window, from its start on.
    pub(super) fn polynomial(&mut self, place: usize) -> Polynomial {
        let width = (2 * self.view.flows.len() - self.view.both).div_ceil(LANES);
        if !self.derived {
            self.derived = true;
            let mut derivatives = std::mem::take(&mut self.derivatives);
            derivatives.resize(width * ORDER, [0.0; LANES]);
            let (mut now, mut then) = (self.here.clone(), self.here.clone());
            for (order, row) in derivatives.chunks_exact_mut(width.max(1)).enumerate() {
                row.as_flattened_mut().iter_mut().zip(self.view.seen(&now)).for_each(|(slot, value)| *slot = value);
                self.view.generator.act(&now, 1.0 / (order + 1) as f64, &mut then);
                std::mem::swap(&mut now, &mut then);
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

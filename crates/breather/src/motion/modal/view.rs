//! What contacts see of an orbit's flights, four modes at a time.

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::simd::lanes::{LANES, Lane, all, four};
use vibrochain_lattice::{Complex, LinearMode, ModeFlow, Turn, Turned};

use crate::structures::periodic_kernel::length;

/// As many groups as a structure of sixteen modes has without asking for memory.
pub(crate) type Lanes = SmallVec<[Lane; 4]>;

/// First coordinates of all parts, and second ones behind, four at a time.
pub(crate) type Node = SmallVec<[Lane; 8]>;

/// What contacts see of an orbit's flights: the modes and the motion under a load, which is one mode more, that nothing damps.
#[derive(Debug, PartialEq)]
pub(crate) struct View {
    /// How each part moves, and the number of each mode among those that are felt.
    pub(crate) flows: SmallVec<[ModeFlow; 16]>,
    pub(crate) numbers: SmallVec<[usize; 16]>,
    /// From this one on contacts see both coordinates, before it the first alone.
    pub(crate) both: usize,
    pub(crate) sights: Sights,
    pub(crate) generator: Flow,
    pub(crate) fastest: f64,
}

/// What contacts see of the parts, four at a time: of first coordinates, and of second ones behind; and where they are under the static load.
#[derive(Debug, PartialEq)]
pub(crate) struct Sights {
    pub(crate) shapes: Vec<Lane>,
    pub(crate) still: Lanes,
}

/// What each coordinate keeps, what the first one gets from the second, and the second from the first.
#[derive(Debug, PartialEq)]
pub(crate) struct Flow([Lanes; 3]);

/// How a motion under a load moves.
fn swing_flow(rate: f64) -> ModeFlow {
    ModeFlow { turn: Turn::Circular, decay: 0.0, rate }
}

impl Flow {
    /// The flow that turns part k by `by(k)`.
    pub(crate) fn of(flows: &[ModeFlow], by: impl Fn(usize) -> Turned) -> Self {
        let mut lanes = [(); 3].map(|()| -> Lanes { smallvec![[0.0; LANES]; flows.len().div_ceil(LANES)] });
        for (k, flow) in flows.iter().enumerate() {
            let Turned { even, odd } = by(k);
            let [keeps, gets, gives] = &mut lanes;
            let values = [(keeps, even), (gets, odd), (gives, -flow.turn.sign() * odd)];
            values.into_iter().for_each(|(lanes, value)| lanes.as_flattened_mut()[k] = value);
        }
        Self(lanes)
    }

    /// How coordinates change.
    fn generator(flows: &[ModeFlow]) -> Self {
        Self::of(flows, |k| Turned { even: -flows[k].decay, odd: flows[k].rate })
    }

    /// All coordinates turned, times a number: from one node into another.
    pub(crate) fn act(&self, node: &[Lane], by: f64, next: &mut [Lane]) {
        let groups = self.0[0].len();
        let [keeps, gets, gives] = self.0.each_ref().map(|lanes| &lanes[..groups]);
        let ((x, y), (next_x, next_y)) = (node.split_at(groups), next.split_at_mut(groups));
        let (y, next_y, by) = (&y[..groups], &mut next_y[..groups], all(by));
        for g in 0..groups {
            let (a, b) = (four(x[g]), four(y[g]));
            next_x[g] = ((four(keeps[g]) * a + four(gets[g]) * b) * by).to_array();
            next_y[g] = ((four(keeps[g]) * b + four(gives[g]) * a) * by).to_array();
        }
    }
}

impl View {
    /// Of contacts that see modes, of which the rigid ones come last, and motions under loads: frequencies and what each contact has of them. `None`
    /// where a dashpot or a static load acts on a rigid mode.
    pub(crate) fn new(
        modes: &[&LinearMode],
        swings: &[(f64, Vec<Complex<f64>>)],
        (contacts, still_at): (&[usize], impl Fn(usize) -> f64),
    ) -> Option<Self> {
        if modes.iter().any(|mode| mode.is_rigid() && (mode.decay != 0.0 || mode.still[1] != 0.0)) {
            return None;
        }
        // Modes of which contacts see one coordinate come first.
        let mut numbers: SmallVec<[usize; 16]> = (0..modes.len()).filter(|&k| modes[k].is_real).collect();
        let both = numbers.len();
        numbers.extend((0..modes.len()).filter(|&k| !modes[k].is_real));
        let mut flows: SmallVec<[_; 16]> = numbers.iter().map(|&k| modes[k].flow()).collect();
        flows.extend(swings.iter().map(|&(rate, _)| swing_flow(rate)));
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
            still.as_flattened_mut()[place] = still_at(contact);
            for (number, (_, swings)) in swings.iter().enumerate() {
                let swing = swings[contact];
                let row = numbers.len() + number;
                put(row, place, swing.re);
                put(count + row - both, place, swing.im);
            }
        }
        // A rigid mode goes on as it does: its κ is a unit of velocity.
        let turning = modes.iter().filter(|mode| !mode.is_rigid());
        let fastest = turning
            .map(|mode| length([mode.rate, mode.decay]))
            .chain(swings.iter().map(|(rate, _)| *rate))
            .fold(0.0, f64::max);
        let generator = Flow::generator(&flows);
        Some(Self { flows, numbers, both, sights: Sights { shapes, still }, generator, fastest })
    }

    /// The same modes, with motions under loads.
    pub(crate) fn under(&self, swings: &[(f64, Vec<Complex<f64>>)], contacts: &[usize]) -> Self {
        let Self { numbers, both, sights: Sights { shapes, still }, .. } = self;
        let mut flows = self.flows.clone();
        flows.extend(swings.iter().map(|&(rate, _)| swing_flow(rate)));
        let fours = still.len();
        let (first, second) = shapes.split_at(numbers.len() * fours);
        let mut all = Vec::with_capacity(shapes.len() + 2 * swings.len() * fours);
        for (modes, part) in [(first, 0), (second, 1)] {
            all.extend_from_slice(modes);
            for (_, swings) in swings {
                let from = all.len();
                all.resize(from + fours, [0.0; LANES]);
                let slots = all[from..].as_flattened_mut().iter_mut().zip(contacts);
                slots.for_each(|(slot, &contact)| *slot = [swings[contact].re, swings[contact].im][part]);
            }
        }
        Self {
            numbers: numbers.clone(),
            both: *both,
            sights: Sights { shapes: all, still: still.clone() },
            generator: Flow::generator(&flows),
            fastest: swings.iter().map(|(rate, _)| *rate).fold(self.fastest, f64::max),
            flows,
        }
    }

    /// The motions under loads, `time` after their beginning: they come behind the modes.
    pub(crate) fn begin_swings(&self, time: f64, [x, y]: [&mut [f64]; 2]) {
        for (k, flow) in self.flows.iter().enumerate().skip(self.numbers.len()) {
            let (sin, cos) = (flow.rate * time).sin_cos();
            [x[k], y[k]] = [cos, -sin];
        }
    }

    /// The numbers that contacts see at a node, with those of its derivative.
    pub(crate) fn seen<'n>(
        &self,
        node: &'n [Lane],
        rates: &'n [Lane],
    ) -> impl Iterator<Item = [f64; 2]> + Clone + use<'n> {
        let (both, count) = (self.both, self.flows.len());
        let second = node.len() / 2 * LANES;
        let part = move |from: usize, to: usize| {
            let [values, rates] = [node, rates].map(|lanes| &lanes.as_flattened()[from..to]);
            values.iter().zip(rates).map(|(value, rate)| [*value, *rate])
        };
        part(0, count).chain(part(second + both, second + count))
    }
}

/// A bound of the length of a mode's state, or of its derivative of some order, in a flight of length `left`.
pub(crate) fn reach(flow: ModeFlow, state: [f64; 2], left: f64, order: u32) -> f64 {
    let ModeFlow { turn, decay, rate } = flow;
    let size = if turn == Turn::Circular {
        // There the generator turns and stretches.
        (0..order).fold(length(state), |size, _| size * length([decay, rate]))
    } else {
        let generator = Turned { even: -decay, odd: rate };
        length((0..order).fold(state, |xi, _| turn.act(generator, xi)))
    };
    let dying = if decay < 0.0 { (-decay * left).exp() } else { 1.0 };
    match turn {
        Turn::Circular => size * dying,
        // Along either pole.
        Turn::Hyperbolic => size * ((rate - decay) * left).exp().max(1.0) * std::f64::consts::SQRT_2,
        Turn::Parabolic => size * dying * (1.0 + rate * left),
    }
}

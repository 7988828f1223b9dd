//! What contacts see of an orbit's flights, four modes at a time.

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::simd::lanes::{LANES, Lane, four};
use vibrochain_lattice::{Complex, LinearMode, ModeFlow, Turn, Turned};

use super::periodic_kernel::length;

/// As many groups as a structure of sixteen modes has without asking for memory.
pub(super) type Lanes = SmallVec<[Lane; 4]>;

/// What contacts see of an orbit's flights: the modes and the motion under a load, which is one mode more, that nothing damps.
#[derive(Debug, PartialEq)]
pub(super) struct View {
    /// How each part moves, and the number of each mode among those that are felt.
    pub(super) flows: SmallVec<[ModeFlow; 16]>,
    pub(super) numbers: SmallVec<[usize; 16]>,
    /// From this one on contacts see both coordinates, before it the first alone.
    pub(super) both: usize,
    pub(super) sights: Sights,
    pub(super) generator: Flow,
    pub(super) fastest: f64,
}

/// What contacts see of the parts, four at a time: of first coordinates, and of second ones behind; and where they are under the static load.
#[derive(Debug, PartialEq)]
pub(super) struct Sights {
    pub(super) shapes: Vec<Lane>,
    pub(super) still: Lanes,
}

/// What each coordinate keeps, what the first one gets from the second, and the second from the first.
#[derive(Debug, PartialEq)]
pub(super) struct Flow([Lanes; 3]);

/// The two coordinates of all parts.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Node(pub(super) [Lanes; 2]);

impl Flow {
    pub(super) fn of(flows: &[ModeFlow], by: impl Fn(usize) -> Turned) -> Self {
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
    pub(super) fn act(&self, Node([x, y]): &Node, by: f64, Node([next_x, next_y]): &mut Node) {
        let [keeps, gets, gives] = &self.0;
        for g in 0..x.len() {
            let (a, b, by) = (four(x[g]), four(y[g]), four([by; LANES]));
            next_x[g] = ((four(keeps[g]) * a + four(gets[g]) * b) * by).to_array();
            next_y[g] = ((four(keeps[g]) * b + four(gives[g]) * a) * by).to_array();
        }
    }
}

impl Node {
    pub(super) fn zeros(groups: usize) -> Self {
        Self([(); 2].map(|()| smallvec![[0.0; LANES]; groups]))
    }

    pub(super) fn put(&mut self, k: usize, state: [f64; 2]) {
        self.0.iter_mut().zip(state).for_each(|(lanes, value)| lanes.as_flattened_mut()[k] = value);
    }
}

impl View {
    /// Of contacts that see modes, of which the rigid ones come last, and motions under loads: frequencies and what each contact has of them. `None`
    /// where a dashpot or a static load acts on a rigid mode.
    pub(super) fn new(
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
        flows.extend(swings.iter().map(|&(rate, _)| ModeFlow { turn: Turn::Circular, decay: 0.0, rate }));
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
        let generator = Flow::of(&flows, |k| Turned { even: -flows[k].decay, odd: flows[k].rate });
        Some(Self { flows, numbers, both, sights: Sights { shapes, still }, generator, fastest })
    }

    /// The numbers that contacts see at a node.
    pub(super) fn seen<'n>(&self, Node([x, y]): &'n Node) -> impl Iterator<Item = f64> + Clone + use<'n> {
        let (both, count) = (self.both, self.flows.len());
        x.as_flattened()[..count].iter().chain(&y.as_flattened()[both..count]).copied()
    }
}

//! The periodic kernel of modes that turn, four at a time: those of real shape and of two complex poles, between contacts that are hit.

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::simd::lanes::{LANES, Lane, all, four, groups, total};
use vibrochain_lattice::{LinearMode, Turn};

use super::sum::{Jet, Sum, UNIT, length};

/// Lists of more modes are summed one by one: what is kept for each of them would be more than the modes themselves.
const MOST: usize = 4096;

type Lanes = SmallVec<[Lane; 6]>;

/// Modes that turn, with (1−R)⁻¹.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct TurningModes {
    rate: Lanes,
    decay: Lanes,
    even: Lanes,
    odd: Lanes,
    /// The length of the generator.
    fast: Lanes,
    is_damped: bool,
    pairs: Vec<Pair>,
}

/// What two contacts make of them.
#[derive(Debug, Clone, PartialEq)]
struct Pair {
    contacts: (usize, usize),
    /// What one sees of the second coordinate's unit that the other gives.
    gains: Lanes,
    /// The sizes of terms, over those of the motion.
    sizes: Lanes,
}

impl TurningModes {
    /// Whether a mode is one of these.
    pub(super) fn holds(mode: &LinearMode) -> bool {
        mode.is_real && mode.turn == Turn::Circular
    }

    /// Of a list of modes those that turn, between the contacts `hit`; none of lists that are long.
    pub(super) fn of<'a>(modes: impl Iterator<Item = (&'a LinearMode, &'a Sum)> + Clone, hit: &[usize]) -> Self {
        let modes = modes.filter(|(mode, _)| Self::holds(mode));
        let count = modes.clone().count();
        if count == 0 || count > MOST {
            return Self::default();
        }
        let lanes = |of: &dyn Fn(&LinearMode, &Sum) -> f64| -> Lanes {
            let mut lanes: Lanes = smallvec![[0.0; LANES]; groups(count)];
            let places = lanes.as_flattened_mut().iter_mut();
            places.zip(modes.clone()).for_each(|(place, (mode, sum))| *place = of(mode, sum));
            lanes
        };
        let pair = |to: usize, from: usize| Pair {
            contacts: (to, from),
            gains: lanes(&|mode, _| mode.rows[to][0] * mode.columns[from][1]),
            sizes: lanes(&|mode, sum| {
                let reach = length(mode.rows[to]) * length(mode.columns[from]);
                reach * (1.0 + sum.blur) + mode.errors_between(to, from) / UNIT
            }),
        };
        Self {
            rate: lanes(&|mode, _| mode.rate),
            decay: lanes(&|mode, _| mode.decay),
            even: lanes(&|_, sum| sum.sum.even),
            odd: lanes(&|_, sum| sum.sum.odd),
            fast: lanes(&|_, sum| sum.fast),
            is_damped: modes.clone().any(|(mode, _)| mode.decay != 0.0),
            pairs: hit
                .iter()
                .flat_map(|&to| hit.iter().map(move |&from| (to, from)))
                .map(|(a, b)| pair(a, b))
                .collect(),
        }
    }

    /// What they have of the kernel and its first three derivatives at 0 < t ≤ T, and sizes of their terms; `None` between other contacts.
    pub(super) fn jet(&self, contacts: (usize, usize), t: f64) -> Option<Jet> {
        let pair = self.pairs.iter().find(|pair| pair.contacts == contacts)?;
        let (mut sums, mut bounds) = ([all(0.0); 4], [all(0.0); 4]);
        for (g, (gain, size)) in pair.gains.iter().zip(&pair.sizes).enumerate() {
            let (rate, decay) = (four(self.rate[g]), four(self.decay[g]));
            let [cos, sin] = Turn::Circular.turns(1.0, (rate * all(t)).to_array())?.map(four);
            let left = if self.is_damped { four(self.decay[g].map(|decay| (-decay * t).exp())) } else { all(1.0) };
            let (flown, turned) = (left * cos, left * sin);
            let (a, b) = (four(self.even[g]), four(self.odd[g]));
            let (mut even, mut odd) = (flown * a - turned * b, flown * b + turned * a);
            let (gain, fast) = (four(*gain), four(self.fast[g]));
            let mut size = four(*size) * (even * even + odd * odd).sqrt();
            for (sum, bound) in sums.iter_mut().zip(&mut bounds) {
                *sum += gain * odd;
                *bound += size;
                (even, odd) = (-(decay * even + rate * odd), rate * even - decay * odd);
                size *= fast;
            }
        }
        Some((sums.map(total), bounds.map(total)))
    }
}

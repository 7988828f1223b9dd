//! Modes that nothing damps half a period after an impact, four at a time, and the impulses that bring their contact to its barriers.

use smallvec::smallvec;
use vibrochain_lattice::simd::lanes::{LANES, Lane, ONE, TWO, ZERO, all, four, total};
use vibrochain_lattice::{ContactMode, Turn};

use crate::motion::modal::view::Lanes;
use crate::structures::response::FixedPart;

/// Where |sin ΩT/2| is below this, next to a resonance, the general path takes states of modes as unknowns.
const NEAR: f64 = 1e-3;

/// Rounding of a mode's share, from its shape to its place, in units of ε; of what turns it on from node to node several times as much.
const SHARE: f64 = 8.0 * f64::EPSILON;
const TURNED_ON: f64 = 256.0 * f64::EPSILON;

/// Errors of a kernel where its derivative vanishes, as a part of its terms.
const STATIONARY: f64 = 1e-13;

/// Where errors may move impulses by more than this part of them, their signs may be rounding.
pub(super) const DELICATE: f64 = 1e-6;

/// Modes as the contact that is hit feels them, four at a time, and half a period.
#[derive(Debug, Clone)]
pub(crate) struct Modes {
    pub(super) frequency: Lanes,
    /// What an impulse gives to the mode's own velocity; what the contact that is hit sees of it, a part of its mobility.
    pub(super) gain: Lanes,
    pub(super) seen: Lanes,
    /// cos ΩT/2, and 1/(2Ω sin ΩT/2).
    pub(super) cos: Lanes,
    pub(super) inverse: Lanes,
    /// Σ over modes of K(0) and K(T/2), of their moduli, and bounds of their errors.
    kernels: [f64; 2],
    sizes: [f64; 2],
    errors: [f64; 2],
    /// Bound of the error of −K′ between, as [`Modes::is_alone`] takes it.
    pub(super) doubt: f64,
}

/// Impulses at 0 and T/2, bounds of their relative errors, and what is left of the positions.
pub(super) struct Impulses {
    pub(super) impulses: [f64; 2],
    pub(super) errors: [f64; 2],
    pub(super) residual: f64,
}

impl Modes {
    /// `None` where a mode is next to a resonance, or held by nothing.
    pub(super) fn at_half(fixed: &FixedPart, contact: usize, half: f64) -> Option<Self> {
        let own = fixed.felt.of_one.as_deref()?;
        let list = &fixed.felt.modes;
        let groups = own.len().div_ceil(LANES);
        let empty = || -> Lanes { smallvec![[0.0; LANES]; groups] };
        let mut modes = Self {
            frequency: empty(),
            gain: empty(),
            seen: empty(),
            cos: empty(),
            inverse: empty(),
            kernels: [0.0; 2],
            sizes: [0.0; 2],
            errors: [0.0; 2],
            doubt: 0.0,
        };
        let (mut kernels, mut sizes, mut errors, mut doubt) = ([ZERO; 2], [ZERO; 2], [ZERO; 2], ZERO);
        for g in 0..groups {
            // Modes that no impact moves fill up the last group of four.
            let of = |number: &dyn Fn(usize) -> f64, pad: f64| -> Lane {
                std::array::from_fn(|i| if g * LANES + i < own.len() { number(g * LANES + i) } else { pad })
            };
            let mode = |number: fn(&ContactMode) -> f64| move |k: usize| number(&own[k]);
            let frequency = of(&mode(|mode| mode.frequency), own.last()?.frequency);
            let gain = of(&|k| list[k].columns[contact][1] * list[k].rate, 0.0);
            let seen = four(of(&|k| list[k].rows[contact][0], 0.0)) * four(gain);
            let [cos, sin] = Turn::Circular.turns(half, frequency)?.map(four);
            if frequency.contains(&0.0) || sin.abs().simd_lt(all(NEAR)).any() {
                return None;
            }
            let omega = four(frequency);
            let inverse = ONE / (TWO * omega * sin);
            let (at_half, at_impulse) = (seen * inverse, seen * inverse * cos);
            kernels = [kernels[0] + at_impulse, kernels[1] + at_half];
            sizes = [sizes[0] + at_impulse.abs(), sizes[1] + at_half.abs()];
            let by_frequency = four(of(&mode(|mode| mode.frequency_error), 0.0));
            let share = four(of(&mode(|mode| mode.weight_error), 0.0)) + by_frequency + all(SHARE);
            let turned = omega * all(half) * (by_frequency + all(2.0 * f64::EPSILON));
            let steep = (cos / sin).abs();
            let off = at_half.abs();
            errors = [
                errors[0] + off * (share * cos.abs() + turned / sin.abs()),
                errors[1] + off * (share + turned * steep),
            ];
            doubt += off * omega * (share + turned * (ONE + steep) + all(TURNED_ON));
            modes.frequency[g] = frequency;
            modes.gain[g] = gain;
            modes.seen[g] = seen.to_array();
            modes.cos[g] = cos.to_array();
            modes.inverse[g] = inverse.to_array();
        }
        modes.kernels = kernels.map(total);
        modes.sizes = sizes.map(total);
        modes.errors = errors.map(total);
        modes.doubt = total(doubt);
        Some(modes)
    }

    /// Impulses that bring the contact to its barriers, by their mean and their difference where they are two. `None` where they have no size.
    pub(super) fn impulses(&self, places: [f64; 2], are_two: bool) -> Option<Impulses> {
        let [own, other] = self.kernels;
        let sum = self.errors[0] + self.errors[1];
        if !are_two {
            let impulse = places[0] / own;
            let error = self.errors[0] / own.abs() + 4.0 * f64::EPSILON;
            let left = (impulse * own - places[0]).abs() / (impulse.abs() * self.sizes[0] + places[0].abs());
            return (impulse != 0.0).then_some(Impulses {
                impulses: [impulse, 0.0],
                errors: [error, 0.0],
                residual: left,
            });
        }
        let [together, apart] = [own + other, own - other];
        let [mean, difference] = mean_and_difference(places, [own, other]);
        let impulses = [0.5 * (mean + difference), 0.5 * (mean - difference)];
        let off = 0.5 * (mean.abs() * sum / together.abs() + difference.abs() * sum / apart.abs())
            + 4.0 * f64::EPSILON * (mean.abs() + difference.abs());
        let left = |i: usize| {
            let terms = [impulses[i] * own, impulses[1 - i] * other];
            let size = impulses[i].abs() * self.sizes[0] + impulses[1 - i].abs() * self.sizes[1] + places[i].abs();
            (terms[0] + terms[1] - places[i]).abs() / size
        };
        let errors = impulses.map(|impulse| off / impulse.abs());
        Some(Impulses { impulses, errors, residual: left(0).max(left(1)) })
    }

    /// Impulses where the second impact is by s earlier or later than half a period after the first, where K′ vanishes. `None` where their signs may
    /// be rounding.
    pub(super) fn aside(&self, s: f64, places: [f64; 2]) -> Option<[f64; 2]> {
        let mut sum = ZERO;
        for (g, frequency) in self.frequency.iter().enumerate() {
            let [cos, _] = Turn::Circular.turns(s, *frequency)?;
            sum += four(self.seen[g]) * four(self.inverse[g]) * four(cos);
        }
        let kernels @ [own, other] = [self.kernels[0], total(sum)];
        // K is stationary there: the error of s is small to second order.
        let off = self.errors.iter().sum::<f64>() + self.sizes.iter().sum::<f64>() * STATIONARY;
        if off > DELICATE * (own + other).abs().min((own - other).abs()) {
            return None;
        }
        let [mean, difference] = mean_and_difference(places, kernels);
        Some([0.5 * (mean + difference), 0.5 * (mean - difference)])
    }

    /// Displacements and velocities of the modes just after an impact, half of whose jump is above the mean velocity; the other impact is by s more
    /// than half a period later.
    pub(super) fn start(&self, [own, other]: [f64; 2], s: f64) -> [Lanes; 2] {
        let (mut place, mut speed) = (self.gain.clone(), self.gain.clone());
        for g in 0..self.gain.len() {
            let (gain, cos, inverse) = (four(self.gain[g]), four(self.cos[g]), four(self.inverse[g]));
            let [turned, sin] = if s == 0.0 {
                [ONE, ZERO]
            } else {
                Turn::Circular.turns(s, self.frequency[g]).unwrap_or_default().map(four)
            };
            place[g] = (gain * inverse * (all(own) * cos + all(other) * turned)).to_array();
            let by_other = all(other) * sin * inverse * four(self.frequency[g]);
            speed[g] = (gain * (all(0.5 * own) + by_other)).to_array();
        }
        [place, speed]
    }
}

/// Sum and difference of the impulses, from the places of both impacts and what either does to itself and to the other.
fn mean_and_difference(places: [f64; 2], [own, other]: [f64; 2]) -> [f64; 2] {
    [(places[0] + places[1]) / (own + other), (places[0] - places[1]) / (own - other)]
}

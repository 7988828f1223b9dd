//! Two impacts of one contact on its two barriers, without loads and losses: K′ of the contact with itself is odd about half a period, and so
//! vanishes there. With s = φ − T/2 and frequencies Ω and parts b² of the mobility as that contact feels the modes,
//!
//! ```text
//! G(s) = −K′ = Σ b² sin Ωs / (2 sin ΩT/2) + (the part of what nothing holds)·s/T,      0 ≤ s ≤ T/2.
//! ```
//!
//! Where G has no other zero the orbit whose impacts are half a period apart is the only one; every other one has a mirror image in time.

use smallvec::SmallVec;
use vibrochain_lattice::simd::lanes::{LANES, Lane, ZERO, all, four};
use vibrochain_lattice::{ContactMode, Stop, Turn};
use wide::f64x4;

use super::at_times::{Impacts, Start};
use super::orbits::Starts;
use super::two_impacts::{FINEST, MOST_PIECES};
use crate::error::BreatherError;
use crate::roots::dual::Dual;
use crate::roots::interval::{Clearance, Enclosed, Zeros};
use crate::search::completeness::Searched;
use crate::structures::point::Point;

/// Where |sin ΩT/2| is below this, next to a resonance, errors of frequencies blur all amplitudes: the search of several contacts takes over.
const NEAR: f64 = 1e-3;

/// Rounding of an amplitude and of a sine, in units of ε.
pub(super) const ROUNDED: f64 = 8.0;

/// G of a contact.
struct HalfPeriod {
    /// Ω and b²/(2 sin ΩT/2).
    modes: SmallVec<[[f64; 2]; 16]>,
    /// The slope that what nothing holds adds.
    drift: f64,
    /// A bound of |G⁗|.
    fourth: f64,
    /// Errors of G and its derivative, by rounding and errors of the modes.
    doubts: [f64; 2],
}

impl HalfPeriod {
    /// `None` next to a resonance.
    fn new(modes: &[ContactMode], period: f64) -> Option<Self> {
        let half = 0.5 * period;
        let mut own = Self { modes: SmallVec::new(), drift: 0.0, fourth: 0.0, doubts: [0.0; 2] };
        for some in modes.chunks(LANES) {
            let frequencies: Lane = std::array::from_fn(|i| some.get(i).map_or(0.0, |mode| mode.frequency));
            let [cos, sin] = Turn::Circular.turns(half, frequencies)?;
            for (mode, (cos, sin)) in some.iter().zip(cos.into_iter().zip(sin)) {
                let ContactMode { frequency, weight, frequency_error, weight_error } = *mode;
                if frequency == 0.0 {
                    own.drift += weight / period;
                    own.doubts[1] += (weight_error + ROUNDED * f64::EPSILON) * weight / period;
                    own.doubts[0] += (weight_error + ROUNDED * f64::EPSILON) * weight;
                    continue;
                }
                if sin.abs() < NEAR {
                    return None;
                }
                let amplitude = 0.5 * weight / sin;
                let turned = frequency * half * (frequency_error + 2.0 * f64::EPSILON);
                let error = weight_error + ROUNDED * f64::EPSILON + turned * (1.0 + (cos / sin).abs());
                let size = amplitude.abs();
                own.doubts[0] += size * error;
                own.doubts[1] += size * frequency * (error + frequency_error);
                own.fourth += size * frequency.powi(4);
                own.modes.push([frequency, amplitude]);
            }
        }
        Some(own)
    }

    /// G and three derivatives at four places.
    fn jets(&self, places: Lane) -> [f64x4; 4] {
        let mut jet = [four(places) * all(self.drift), all(self.drift), ZERO, ZERO];
        for [frequency, amplitude] in &self.modes {
            let [cos, sin] = Turn::Circular.turns(*frequency, places).unwrap_or_default().map(four);
            let (rise, slope) = (sin * all(*amplitude), cos * all(amplitude * frequency));
            let square = all(frequency * frequency);
            jet = [jet[0] + rise, jet[1] + slope, jet[2] - rise * square, jet[3] - slope * square];
        }
        jet
    }
}

impl Enclosed for HalfPeriod {
    fn clearances(&self, centres: Lane, radii: Lane) -> [Clearance; LANES] {
        let enclosed = Dual::from_jet(self.jets(centres), all(self.fourth), four(radii)).widened(self.doubts);
        Clearance::of(&enclosed)
    }

    fn at(&self, x: f64) -> (f64, f64) {
        let [value, slope, ..] = self.jets([x; LANES]).map(|lanes| lanes.to_array()[0]);
        (value, slope)
    }

    fn known_zeros(&self) -> SmallVec<[f64; 2]> {
        SmallVec::from_slice(&[0.0])
    }
}

/// Zeros s > 0 of G; `None` next to a resonance, and where a search would take too long.
fn zeros(modes: &[ContactMode], period: f64, stop: &Stop) -> Option<Zeros> {
    let function = HalfPeriod::new(modes, period)?;
    let fastest = function.modes.iter().fold(0.0, |most: f64, [frequency, _]| most.max(*frequency));
    let mut zeros = Zeros::default();
    zeros.stop = stop.clone();
    let pieces = ((0.5 * fastest * period) as usize).clamp(4, MOST_PIECES);
    zeros.find(&function, 0.0, 0.5 * period, pieces, |_| FINEST * period);
    (zeros.exhausted == 0).then_some(zeros)
}

/// Times by which the second impact may be earlier or later than half a period after the first; `None` where not all are known.
pub(in crate::structures) fn other_lapses(modes: &[ContactMode], period: f64, stop: &Stop) -> Option<Vec<f64>> {
    zeros(modes, period, stop).filter(|zeros| zeros.unresolved.is_empty()).map(|zeros| zeros.simple)
}

impl Impacts<'_> {
    /// Both impacts of one contact on its two barriers, without loads and losses; `None` of others, next to a resonance, and where a search would
    /// take too long.
    pub(super) fn proved_of_both_sides(&self) -> Option<Starts> {
        let equations = self.equations;
        let &[(contact, barrier), (other, opposite)] = &self.letters[..] else { return None };
        if equations.has_time() || contact != other || barrier == opposite {
            return None;
        }
        // Where both stops are at the rest position nothing has a size.
        self.places().filter(|places| places.iter().any(|place| *place != 0.0))?;
        let modes = equations.kernel().felt.of_one.as_deref()?;
        let period = equations.period();
        Some(self.at_half_and(&zeros(modes, period, equations.model.stop())?))
    }

    /// The impulses half a period apart, by their mean and their difference; `None` where something is held by nothing.
    fn closed_form(&self, half: f64) -> Option<Point> {
        let (equations, contact) = (self.equations, self.letters[0].0);
        let places = self.places().filter(|_| equations.rigid.is_empty())?;
        let [own, other] = [0.0, half].map(|t| equations.kernel().jet(contact, contact, t).0[0]);
        let [mean, apart] = [(places[0] + places[1]) / (own + other), (places[0] - places[1]) / (own - other)];
        let impulses = [0.5 * (mean + apart), 0.5 * (mean - apart)];
        impulses.iter().all(|impulse| impulse.is_finite()).then(|| self.point(&[0.0, half], &impulses))
    }

    fn at_half_and(&self, zeros: &Zeros) -> Starts {
        let half = 0.5 * self.equations.period();
        let mut starts = Vec::with_capacity(1 + 2 * zeros.simple.len());
        let mut unresolved = 2 * zeros.unresolved.len();
        let there = |phi: f64| -> Result<_, BreatherError> {
            Ok(self.linear(&[0.0, phi])?.solve().map(|x| self.point(&[0.0, phi], &x)))
        };
        match self.closed_form(half).map_or_else(|| there(half), |point| Ok(Some(point)))? {
            Some(point) => starts.push(Start::zero(point)),
            None => unresolved += 1,
        }
        for s in zeros.simple.iter().flat_map(|s| [half - s, half + s]) {
            match there(s)? {
                Some(point) => starts.push(Start::zero(point)),
                None => unresolved += 1,
            }
        }
        for s in zeros.unresolved.iter().flat_map(|s| [half - s, half + s]) {
            starts.extend(there(s)?.map(Start::from));
        }
        Ok((starts, Searched { intervals: zeros.intervals, unresolved, ..Searched::default() }))
    }
}

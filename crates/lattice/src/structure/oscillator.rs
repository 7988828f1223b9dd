//! A mode of real shape, from its frequency, its dashpot and what is seen of its shape, with bounds of its errors.

use rustfft::num_complex::Complex;
use smallvec::SmallVec;

use super::error::StructureError;
use super::linear_mode::{LinearMode, ModeErrors, ModeShape};
use super::modal::MOST_DAMPING;
use crate::simd::twofold::Twofold;

type C = Complex<f64>;

/// What a contact sees of a mode below this part of what it may see is rounding of what the structure was given by.
const UNFELT: f64 = 16.0 * f64::EPSILON;

/// A number of two parts, with a bound of its error.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Bounded {
    pub(super) sum: Twofold,
    pub(super) error: f64,
}

impl Bounded {
    /// What is seen of a mode; 0 where it is rounding of its terms, the sum of whose moduli is `size`: a rigid mode would be pushed by it for
    /// ever.
    pub(super) fn unless_rounding(self, size: f64) -> Self {
        let value = self.sum.value().abs();
        if value > 4.0 * f64::EPSILON * size { self } else { Self { error: self.error + value, ..Self::default() } }
    }
}

/// What is seen of a mode without damping, of a shape φ with φᵀMφ = 1.
#[derive(Debug, Clone, Default)]
pub(super) struct SeenShape {
    pub(super) contacts: Vec<Bounded>,
    pub(super) coordinates: Vec<f64>,
    pub(super) still: Bounded,
    /// By both parts of each load.
    pub(super) loads: Vec<[Bounded; 2]>,
}

impl SeenShape {
    /// Mode number `k`, of Ω² = `square` and δ = `decay`.
    ///
    /// # Errors
    /// [`StructureError::Overdamped`]
    pub(super) fn oscillator(self, k: usize, square: Bounded, decay: Bounded) -> Result<LinearMode, StructureError> {
        let (frequency, delta) = (square.sum.value().sqrt(), decay.sum.value());
        // ν² = Ω² − δ² would be that of a rigid mode in the end.
        if square.sum.high > 0.0 && delta > MOST_DAMPING * frequency {
            return Err(StructureError::Overdamped { mode: k, ratio: delta / frequency });
        }
        let value = |seen: &Bounded| seen.sum.value();
        let still = value(&self.still);
        let contacts: Vec<f64> = self.contacts.iter().map(value).collect();
        let shape = ModeShape { contacts, coordinates: self.coordinates, still };
        let loads: Vec<C> = self.loads.iter().map(|[re, im]| C::new(value(re), value(im))).collect();
        let turned_error = square.error + (2.0 * delta.abs() + decay.error) * decay.error;
        let turned = match (square.sum - decay.sum * decay.sum).value() {
            // One pole of a rigid mode is 0, exactly.
            _ if square.sum.high == 0.0 => -delta * delta,
            // Both poles are one as far as numbers tell.
            turned if turned.abs() <= turned_error => 0.0,
            turned => turned,
        };
        let mut mode = LinearMode::exact_oscillator(delta, turned, &shape, &loads);
        let rate = mode.rate;
        let of_rate = f64::EPSILON * rate + (turned_error / rate).min(turned_error.sqrt());
        let (part, given) = (of_rate / rate, |error: f64, value: f64| error + 0.5 * f64::EPSILON * value.abs());
        let rows: SmallVec<[f64; 2]> = self.contacts.iter().map(|seen| given(seen.error, value(seen))).collect();
        let added = |error: f64, value: f64| (error + (part + f64::EPSILON) * value.abs()) / rate;
        mode.errors = ModeErrors {
            poles: of_rate + decay.error + 0.5 * f64::EPSILON * delta.abs(),
            columns: rows.iter().zip(&shape.contacts).map(|(error, shape)| added(*error, *shape)).collect(),
            rows,
            still: added(self.still.error, still),
            loads: (self.loads.iter().zip(&loads))
                .map(|([re, im], load)| added(re.error + im.error, load.norm()))
                .collect(),
        };
        Ok(mode)
    }
}

/// A mode that a contact sees by rounding of its shape alone is not seen: one that grows would be felt in the end. `sizes` are what each contact
/// may see of it.
pub(super) fn without_rounding(mut mode: LinearMode, sizes: impl Iterator<Item = f64>) -> LinearMode {
    for (number, size) in sizes.enumerate() {
        let [first, second] = mode.rows[number];
        let seen = first.hypot(second);
        if seen <= UNFELT * size {
            mode.errors.rows[number] += seen;
            mode.errors.columns[number] += mode.columns[number][0].hypot(mode.columns[number][1]);
            (mode.rows[number], mode.columns[number]) = ([0.0; 2], [0.0; 2]);
        }
    }
    mode
}

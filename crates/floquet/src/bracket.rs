//! The zero of a function of order 1 in a step of a branch or curve, with its error.

pub(crate) use vibrochain_breather::bracket::zero;

/// A function at its zero, over its values on both sides: more, and it jumped.
const JUMP: f64 = 1e-3;

/// Worst case over what rounding is seen to be.
const SAFETY: f64 = 4.0;

/// Rounding of a function that is of order 1.
const ROUNDING: f64 = 1e-13;

/// Where beside its zero such a function is looked at for its slope, as a part of the step.
const BESIDE: f64 = 1e-2;

/// The zero of a function of order 1 in a step of a branch, whose values at both ends differ in sign, and how far rounding moves it. `None` where
/// it jumps, or has no value.
pub(crate) fn crossing(
    [first, last]: [f64; 2],
    length: f64,
    mut at: impl FnMut(f64) -> Option<f64>,
) -> Option<(f64, f64)> {
    let s = zero((0.0, first), (length, last), length, |s| at(s).ok_or(())).ok()?;
    // Before its first point, and to it, there may be no step.
    let (before, behind) = ((s - BESIDE * length).max(0.0), (s + BESIDE * length).min(length));
    let low = if before > 0.0 { at(before)? } else { first };
    let high = if behind < length { at(behind)? } else { last };
    let here = at(s)?.abs();
    if here > JUMP * low.abs().max(high.abs()) {
        return None;
    }
    Some((s, SAFETY * here.max(ROUNDING) / ((high - low) / (behind - before)).abs()))
}

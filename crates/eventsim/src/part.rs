//! Parts of a row that an event is felt in: what is restarted in the middle of a window.
//!
//! What happens to a mass reaches its m-th neighbour with γ₂^m τ^{2m+1}/(2m+1)!: within the rest of a window only the nearest R neighbours on
//! either side can notice ([`reach`](crate::units::reach)), and only they get new series, from the same stencil; at the ends of the part the neighbours' series are
//! known, and stay (at the end of a row there are none). An event then costs what R costs, whatever the length of the row.
//!
//! Parts that touch are restarted as one, so that simultaneous events keep the mirror symmetry of a ring to the bit.

use std::ops::Range;

/// Cost of restarting a mass in the middle of a window relative to its share of a whole window; measured.
pub(crate) const RESTART_COST: f64 = 2.0;

/// Least number of neighbours restarted on either side: the derivatives that decide a contact look two masses far.
pub(crate) const LEAST_REACH: usize = 3;

/// How far from the computed instant, relative to its distance from the base, a restart may take place: the rounding
/// of that instant. A breather repeats its flights to the bit, and rounding errors that repeat add up; spread over the
/// neighbouring instants they average out. The impact law corrects for the distance left to the barrier.
pub(crate) const DITHER: f64 = 8.0 * f64::EPSILON;

/// A part of the row: first site and number of masses.
pub(crate) type Part = (usize, usize);

/// The masses of a part, each range with its first column: over the end of the ring there are two.
#[inline(always)]
pub(crate) fn ranges((start, length): Part, sites: usize) -> [(Range<usize>, usize); 2] {
    let end = start + length;
    [(start..end.min(sites), 0), (0..end.saturating_sub(sites), length.min(sites - start))]
}

/// The parts of a row within `reach` of what is due, `count` sites that rise, merged where less than a mass is between
/// them. False if they make up so much of the row that all of it had better be restarted.
#[inline(always)]
pub(crate) fn split(
    (count, due): (usize, impl Fn(usize) -> usize),
    reach: usize,
    (sites, is_closed): (usize, bool),
    parts: &mut Vec<Part>,
) -> bool {
    parts.clear();
    if (2 * reach + 1).saturating_mul(count).saturating_mul(2) > sites {
        return false;
    }
    // Distance from a contact to the next around the ring; a part begins after a wide one.
    let gap = |i: usize| {
        let (from, to) = (due(i), due((i + 1) % count));
        if to > from { to - from } else { to + sites - from }
    };
    let wide = |i: usize| gap(i) > 2 * reach + 2 || (!is_closed && i + 1 == count);
    let Some(cut) = (0..count).find(|&i| wide(i)) else { return false };
    let mut start = None;
    let mut length = 1;
    for i in (0..count).map(|i| (cut + 1 + i) % count) {
        let first = *start.get_or_insert(due(i));
        if !wide(i) {
            length += gap(i);
            continue;
        }
        parts.push(if is_closed {
            ((first + sites - reach) % sites, length + 2 * reach)
        } else {
            let begin = first.saturating_sub(reach);
            (begin, (first + length + reach).min(sites) - begin)
        });
        start = None;
        length = 1;
    }
    true
}

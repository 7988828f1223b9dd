//! Parts of a row that an event is felt in: what is restarted in the middle of a window.
//!
//! What happens to a mass reaches its m-th neighbour with γ₂^m τ^{2m+1}/(2m+1)!: within the rest of a window only the nearest R neighbours on
//! either side can notice ([`reach`](crate::units::reach)), and only they get new series, from the same stencil; at the ends of the part the neighbours' series are
//! known, and stay (at the end of a row there are none). An event then costs what R costs, whatever the length of the row.
//!
//! Parts that touch are restarted as one, so that simultaneous events keep the mirror symmetry of a ring to the bit.

use std::ops::Range;

use crate::units::ORDERS;

/// Cost of restarting a mass in the middle of a window relative to its share of a whole window; measured.
const RESTART_COST: f64 = 2.0;

/// Least number of neighbours restarted on either side: the derivatives that decide a contact look two masses far.
pub(crate) const LEAST_REACH: usize = 3;

/// How far from the computed instant, relative to its distance from the base, a restart may take place: the rounding
/// of that instant. A breather repeats its flights to the bit, and rounding errors that repeat add up; spread over the
/// neighbouring instants they average out. The impact law corrects for the distance left to the barrier.
pub(crate) const DITHER: f64 = 8.0 * f64::EPSILON;

/// Events that a mean of their rate goes back.
const EVENTS: f64 = 16.0;

/// Change of the rate of events, relative, below which the order of the series stays what it was: costs of neighbouring orders differ
/// by more where they differ at all.
const SAME_RATE: f64 = 1.0 / 16.0;

/// An order that has been chosen, with its horizon, and for what.
#[derive(Debug, Clone, Copy)]
struct Choice {
    least: u8,
    rate: f64,
    order: usize,
    horizon: f64,
}

/// How often events come, and the order of series that costs least then.
#[derive(Debug, Clone, Default)]
pub(crate) struct Pace {
    /// Events a unit of internal time, a running mean.
    rate: f64,
    /// Time since the last event, at the base.
    since_event: f64,
    chosen: Option<Choice>,
}

impl Pace {
    /// The base moves on.
    pub(crate) fn pass(&mut self, s: f64) {
        self.since_event += s;
    }

    /// Takes note of an event at `s` since the base.
    pub(crate) fn note_event(&mut self, s: f64) {
        let flight = self.since_event + s;
        self.since_event = -s;
        let mean = if self.rate > 0.0 { 1.0 / self.rate } else { flight };
        let mean = mean + (flight - mean) / EVENTS;
        self.rate = if mean > 0.0 { 1.0 / mean } else { 0.0 };
    }

    /// Order and horizon of the next window: least cost a unit of time at the present rate of events. `touched` is the share of all masses that
    /// restarts with one at any time in a window of each order, if these are few.
    ///
    /// A mass that leaves a barrier with a derivative of high order needs a series that has it: `least` orders.
    pub(crate) fn choose(
        &mut self,
        least: u8,
        horizons: &[f64; ORDERS.len()],
        touched: &[Option<f64>; ORDERS.len()],
    ) -> (usize, f64) {
        let rate = self.rate;
        let is_same = |chosen: &Choice| chosen.least == least && (rate - chosen.rate).abs() <= SAME_RATE * chosen.rate;
        if let Some(chosen) = self.chosen.filter(is_same) {
            return (chosen.order, chosen.horizon);
        }
        let cost = |(order, horizon): (usize, f64), touched: Option<f64>| {
            // If every event restarts all masses, the rest of the window is lost …
            let used = if rate * horizon > 1e-9 { -(-rate * horizon).exp_m1() / rate } else { horizon };
            // … or its neighbours only.
            let of_parts = touched.map_or(f64::INFINITY, |share| 1.0 / horizon + RESTART_COST * rate * share);
            order as f64 * of_parts.min(1.0 / used)
        };
        let last = ORDERS.len() - 1;
        let choices = ORDERS.into_iter().zip(*horizons).zip(*touched);
        let choices = choices.filter(|((order, _), _)| *order >= usize::from(least));
        let best = choices.map(|(choice, touched)| (cost(choice, touched), choice)).min_by(|a, b| a.0.total_cmp(&b.0));
        let (order, horizon) = best.map_or((ORDERS[last], horizons[last]), |(_, choice)| choice);
        self.chosen = Some(Choice { least, rate, order, horizon });
        (order, horizon)
    }
}

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

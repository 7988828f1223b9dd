//! Modes that die within a period: where the period is cut for them, and what impacts send straight on to later ones of the same period.
//!
//! A period later nothing is left of them, and their flight back over it is more than numbers hold: they are no poles of J(z), and stand in
//! J₀ alone.

use vibrochain_lattice::{BlochKernel, BlochMode, Complex, Coordinates, Turned};

use super::linear_impact::LinearImpact;

/// Exponents: from the first on a mode dies fast, beyond the second nothing is left of it, and a flight back by the third is next to what
/// numbers can hold.
const FAST: f64 = 20.0;
const NOTHING: f64 = 75.0;
const RANGE: f64 = 600.0;

/// Times of the impacts since one of them. Where a mode dies fast the period is cut where it has longest to do so.
pub(super) fn since_cut(kernel: &BlochKernel, impacts: &[LinearImpact]) -> Vec<f64> {
    let period = kernel.period();
    let is_fast = |mode: &BlochMode| mode.rates().iter().any(|rate| -rate.re * period > FAST);
    let mut cut = 0;
    if kernel.modes().iter().any(is_fast) {
        let before = |i: usize| match i {
            0 => impacts[0].time + period - impacts[impacts.len() - 1].time,
            _ => impacts[i].time - impacts[i - 1].time,
        };
        cut = (0..impacts.len()).rev().max_by(|&i, &j| before(i).total_cmp(&before(j))).unwrap_or(0);
    }
    let since = |(i, impact): (usize, &LinearImpact)| {
        let later = impact.time - impacts[cut].time;
        if i < cut { later + period } else { later }
    };
    impacts.iter().enumerate().map(since).collect()
}

/// Which coordinates of a mode have died when the next period begins, `spread` after it was cut.
pub(super) fn died(mode: &BlochMode, spread: f64, period: f64) -> [bool; 2] {
    let died = |rate: Complex<f64>| -rate.re * (period - spread) > NOTHING || -rate.re * spread > RANGE;
    let both = mode.rates().map(died);
    match mode.coordinates {
        Coordinates::Shared(_) => [both[0] && both[1]; 2],
        Coordinates::Apart => both,
    }
}

/// A number in some of its coordinates, all of them or one of two that are apart.
pub(super) fn only(these: [bool; 2], Turned { even, odd }: Turned) -> Turned {
    Turned { even: if these[0] { even } else { 0.0 }, odd: if these[1] { odd } else { 0.0 } }
}

pub(super) fn largest(number: Turned) -> f64 {
    number.even.abs().max(number.odd.abs())
}

/// Impacts in a period that is cut.
pub(super) struct Cut<'a> {
    pub(super) kernel: &'a BlochKernel,
    pub(super) impacts: &'a [LinearImpact],
    /// Their times since the cut.
    pub(super) since: &'a [f64],
}

/// J₀ outside, what it changes by with the time of its row's impact, and its errors.
pub(super) struct Sent<'a> {
    pub(super) now: &'a mut [f64],
    pub(super) slide: &'a mut [f64],
    pub(super) errors: &'a mut [f64],
}

/// What impacts send straight on to later ones of the same period in the coordinates of mode `k` that die before the next.
pub(super) fn send_on(cut: &Cut<'_>, k: usize, died: [bool; 2], sent: Sent<'_>) {
    let &Cut { kernel, impacts, since } = cut;
    let (mode, size) = (&kernel.modes()[k], 2 * impacts.len());
    let coordinates = mode.coordinates;
    let omega = std::f64::consts::TAU / kernel.period();
    for (i, to) in impacts.iter().enumerate() {
        for (j, by) in impacts.iter().enumerate().filter(|(j, _)| since[*j] < since[i]) {
            let (row, column) = (kernel.row(k, to.contact), kernel.column(k, by.contact));
            let [[seen, _], [_, sent_error]] = [to, by].map(|impact| kernel.shape_errors(k, impact.contact));
            let t = since[i] - since[j];
            let mut flight = only(died, mode.flight(t));
            let turned = f64::EPSILON * (4.0 + 2.0 * (mode.rate + mode.decay.abs()) * t) + mode.rate_error * t;
            let jets = [(); 4].map(|()| {
                let value = coordinates.pair(row, flight, column);
                let given = coordinates.given(flight, column);
                let carried = coordinates.carried(sent_error, flight);
                let error =
                    turned * coordinates.reach(row, given) + coordinates.reach_error([row, seen], [given, carried]);
                flight = coordinates.product(flight, mode.generator());
                (value, error)
            });
            let [jet, errors] = [jets.map(|(value, _)| value), jets.map(|(_, error)| error)];
            let at = 2 * i * size + 2 * j;
            for (matrix, jet) in [(&mut *sent.now, &jet[..3]), (&mut *sent.slide, &jet[1..])] {
                matrix[at] += omega * jet[0];
                matrix[at + 1] -= jet[1];
                matrix[at + size] += jet[1];
                matrix[at + size + 1] -= jet[2] / omega;
            }
            sent.errors[at] += omega * errors[0];
            sent.errors[at + 1] += errors[1];
            sent.errors[at + size] += errors[1];
            sent.errors[at + size + 1] += errors[2] / omega;
        }
    }
}

//! A certified step of one contact towards its barriers, in flight.
//!
//! g is a sum of terms: damped sines, sines of the loads, and what modes answer from rest. Of each its curvature over the rest of the window
//! is bounded, |row·A²ξ| e^{gd}, and so is its size. With any part of the terms taken by their curvature and the others by their size,
//!
//! ```text
//! f(τ+d) ≥ f₁(τ) + f₁′(τ) d − B₁ d²/2 − R₂      for all d ≥ 0 within the window,
//! ```
//!
//! so no step to the first root of this passes the first root of f. Terms are sorted by rate and all cuts are tried: far from a barrier
//! fast modes of small size do not shorten the step, next to it all curvature counts and convergence is quadratic ([`crate::watch`]).

use crate::flight::loads::add;
use crate::flight::modal_flight::ModalFlight;
use crate::flight::places::Place;
use crate::flight::system::{System, Term};
use crate::watch::Step;
use crate::watch::safe_step::{ROUNDING, Side, safe_step, side};
use vibrochain_lattice::{Barrier, Complex, LinearMode, Turn};

/// One term at an instant, summed with all slower ones; its own size over what is left of the window.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Share {
    value: f64,
    slope: f64,
    bend: f64,
    size: f64,
}

/// What a contact does at `s` since the base.
#[derive(Debug, Clone, Copy)]
pub(crate) struct View {
    pub(crate) x: f64,
    pub(crate) v: f64,
    /// Rounding of x.
    pub(crate) margin: f64,
}

/// The most of |row·e^{Ad}y| for 0 ≤ d ≤ h.
fn bound(mode: &LinearMode, row: [f64; 2], y: [f64; 2], h: f64) -> f64 {
    let across = [y[1], -mode.turn.sign() * y[0]];
    let [along, across] = [y, across].map(|y| (row[0] * y[0] + row[1] * y[1]).abs());
    let fastest = mode.rates().map(|rate| rate.re).into_iter().fold(f64::NEG_INFINITY, f64::max);
    let growth = if fastest > 0.0 { (fastest * h).exp() } else { 1.0 };
    let turned = mode.rate * h;
    growth
        * match mode.turn {
            Turn::Circular => along.hypot(across).min(along + turned * across),
            Turn::Hyperbolic => along + turned.min(1.0) * across,
            // The most of κd e^{−δd} is κ/(δe).
            Turn::Parabolic if mode.decay > 0.0 => {
                along + turned.min(mode.rate / (mode.decay * std::f64::consts::E)) * across
            }
            Turn::Parabolic => along + turned * across,
        }
}

/// A contact in flight.
#[derive(Clone, Copy)]
pub(crate) struct Approach<'a> {
    pub(crate) system: &'a System,
    pub(crate) flight: &'a ModalFlight,
    pub(crate) contact: usize,
    /// Where it is at the base.
    pub(crate) place: &'a Place,
}

impl Approach<'_> {
    /// x and v of the contact at `s`, and into `shares` its terms over `left` from there.
    pub(crate) fn view(&self, s: f64, left: f64, shares: &mut Vec<Share>) -> View {
        let &Self { system, flight, contact, place } = self;
        shares.clear();
        let (mut x, mut size) = (0.0, place.x.abs());
        let mut total = Share::default();
        for term in &system.terms {
            let (rise, value, slope, bend, most) = match *term {
                Term::Mode(k) => {
                    let mode = &system.modes()[k];
                    let row = mode.rows[contact];
                    if row == [0.0; 2] {
                        continue;
                    }
                    let dot = |y: [f64; 2]| row[0] * y[0] + row[1] * y[1];
                    let a = mode.generator();
                    let act = |y| mode.turn.act(a, y);
                    let added = mode.turn.act(mode.increment(s), flight.free[k]);
                    let (moved, given) = system.loads.since(mode, k, &flight.turned, s);
                    let added = add(added, moved);
                    let y = add(flight.free[k], added);
                    let (mut most, mut bend) = (bound(mode, row, y, left), bound(mode, row, act(act(y)), left));
                    for (j, load) in system.loads.answered_from_rest(k) {
                        // ξ′ = Aξ + b e^{iwt}: what the load adds from now on.
                        for b in [load.map(|b| b.re), load.map(|b| b.im)] {
                            let w = system.loads.rates[j];
                            most += left * bound(mode, row, b, left);
                            bend += left * bound(mode, row, act(act(b)), left)
                                + bound(mode, row, act(b), 0.0)
                                + w * dot(b).abs();
                        }
                    }
                    (dot(added), dot(y), dot(add(act(y), given)), bend, most)
                }
                Term::Load(j) => {
                    let swing = system.swings[contact][j] * flight.turned[j];
                    if swing == Complex::default() {
                        continue;
                    }
                    let w = system.loads.rates[j];
                    let (sin, cos) = (0.5 * w * s).sin_cos();
                    let turn = Complex::new(-2.0 * sin * sin, 2.0 * sin * cos);
                    let now = swing * (turn + 1.0);
                    ((swing * turn).re, now.re, -w * now.im, w * w * swing.norm(), swing.norm())
                }
            };
            x += rise;
            size += rise.abs();
            total =
                Share { value: total.value + value, slope: total.slope + slope, bend: total.bend + bend, size: most };
            shares.push(total);
        }
        View { x: place.x + x, v: total.slope, margin: ROUNDING * size }
    }

    /// One step of the contact from `tau` since the base.
    pub(crate) fn step(&self, (tau, horizon): (&mut f64, f64), shares: &mut Vec<Share>) -> (Step, Option<Barrier>) {
        let &Self { system, contact, place, .. } = self;
        let View { x, v, margin } = self.view(*tau, horizon - *tau, shares);
        let all = shares.last().copied().unwrap_or_default();
        let mut ahead = f64::INFINITY;
        for barrier in [Barrier::Lower, Barrier::Upper] {
            let Some(at) = place.barrier(system, contact, barrier) else { continue };
            let (sign, slope) = (barrier.sign(), -barrier.sign() * v);
            let f = sign * (at - x);
            let mut best = match side(f, slope, all.bend, margin, *tau) {
                Side::Contact(d) => {
                    *tau = (*tau + d).max(0.0);
                    return (Step::Hit, Some(barrier));
                }
                Side::Ahead(d) => d,
            };
            let mut rest = 0.0;
            for cut in (0..shares.len()).rev() {
                rest += shares[cut].size;
                let slow = if cut > 0 { shares[cut - 1] } else { Share::default() };
                let f = f - sign * (slow.value - all.value) - rest - 2.0 * margin;
                // With more terms taken by their size it only falls.
                if f <= 0.0 {
                    break;
                }
                best = best.max(safe_step(f, -sign * slow.slope, slow.bend));
            }
            ahead = ahead.min(best);
        }
        *tau += ahead;
        (if *tau > horizon { Step::Clear } else { Step::Later }, None)
    }
}

#[cfg(test)]
mod tests;

//! The mode that a breather has drawn out of the band of the lattice.
//!
//! With every w_j in the band a wave that runs off, a zero of f is a motion that no wave of the ring need carry. If none is in
//! the band, its w is real: a mode localised at the breather. If one is, the mode emits waves there and w is complex: its real
//! part is the frequency at which the mode swings, meetings with the modes of the ring left out, and its imaginary part the
//! rate at which it is lost to waves whose form has the sign of its own. If theirs is the other one, it grows by what it
//! emits. (The answer +i/D is that of waves which come in; f with the other sign has the complex conjugate zeros.)
//!
//! A zero w = u is at the same time one at −ū and at all u + jω. Of u and −u that one is the mode's frequency on
//! which Krein's form is positive. A stiffer impact (larger κ) moves it, to first order, by −∂f/∂κ over f′, and by that
//! theory times its form is what the impact does to a definite quadratic form: the sign of that ratio is the sign of the form.

use super::form::{C, Form};
use super::signature::Signature;
use crate::bracket::zero;

/// Places at which f is looked at between two edges of the band.
const LOOKS: usize = 32;

/// Waves into which the mode may be lost. With three and more of them it is no longer one that lasts.
const MOST_WAVES: usize = 2;

/// |Im w|/ω beyond which a zero is no mode: it turns by less than it grows, e^1.9 a period.
const MOST_LOSS: f64 = 0.3;

/// The mode that a breather has drawn out of the band, by multipliers the one that is not next to a mode of the ring.
///
/// It is there if a harmonic of ω is in the band (there the breather itself takes the place between two modes of the ring),
/// or if a mode has left the band at its edge. Of orbits with two impacts only one that emits no waves is looked for, and of
/// any only one that emits at most two.
///
/// ```
/// use vibrochain_breather::{Family, Finder, OrbitList};
/// use vibrochain_floquet::{DressedModes, Signature};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(6, 0.2, 0.2)?, 0.69, 0.4)?;
/// let (mut finder, mut found) = (Finder::new(6), OrbitList::default());
/// finder.find(&model, Family::SingleSided, &mut found)?;
/// let mut modes = DressedModes::default();
/// modes.replace(finder.prepared(&found.orbits[0])?)?;
/// // ω is between Ω₁ = 0.632 and Ω₂ = 0.894: no mode is left there, but one below the band, which begins at 0.447.
/// assert!(modes.frequency(1).is_none());
/// let mode = modes.internal_mode().unwrap();
/// assert!((mode.frequency / 0.69 - 0.533).abs() < 1e-3 && mode.loss == 0.0);
/// assert_eq!(mode.signature(0.69), Some(Signature::Negative));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InternalMode {
    /// That with positive form, from 0 to ω; a mode that impacts once a period has it up to multiples of ω. ω/2 while the mode
    /// doubles the period against itself.
    pub frequency: f64,
    /// Rate at which it would be lost to waves, or, negative, grow by emitting them, if these did not come back around the
    /// ring.
    pub loss: f64,
}

impl InternalMode {
    /// Krein signature of its multiplier in the upper half plane; `None` where that is −1, its own mirror image.
    pub fn signature(&self, omega: f64) -> Option<Signature> {
        match self.frequency / omega {
            turns if turns < 0.5 => Some(Signature::Positive),
            turns if turns > 0.5 => Some(Signature::Negative),
            _ => None,
        }
    }
}

/// A zero between two edges of the band.
#[derive(Debug, Clone, Copy)]
struct OwnZero {
    w: C,
    /// Derivative of f there.
    slope: C,
}

/// A part of 0 to ω/2 in which the same w_j are in the band.
#[derive(Debug)]
struct Part {
    from: f64,
    to: f64,
    waves: Vec<f64>,
}

/// The narrowest one, and, for the w_j into which it is lost, where in the band the coefficient of reflection has its zero.
pub(super) fn internal_mode(form: &Form, zeros: &mut Vec<C>) -> Option<InternalMode> {
    let omega = form.omega();
    let mut best: Option<(OwnZero, Vec<f64>)> = None;
    for part in parts(form) {
        // Two impacts: waves that run off move the trivial pair from 1, and what is found is as often that as a mode.
        if form.is_double() && !part.waves.is_empty() {
            continue;
        }
        let found = if part.waves.is_empty() { localised(form, &part) } else { leaking(form, &part) };
        for zero in found {
            if best.as_ref().is_none_or(|(least, _)| zero.w.im.abs() < least.w.im.abs()) {
                best = Some((zero, part.waves.clone()));
            }
        }
    }
    let Some((zero, waves)) = best else {
        return doubled(form).then_some(InternalMode { frequency: 0.5 * omega, loss: 0.0 });
    };
    let positive = (form.stiffness(zero.w) / zero.slope).re > 0.0;
    if zero.w.im != 0.0 {
        // Backward waves are those of −ū.
        zeros.extend(waves.iter().map(|&j| {
            let w = zero.w + j * omega;
            if w.re > 0.0 { w } else { -w.conj() }
        }));
    }
    // u and ω − ū have the same imaginary part.
    let frequency = if positive { zero.w.re } else { omega - zero.w.re };
    // (0 − 0 is 0, and not −0.)
    Some(InternalMode { frequency, loss: 0.0 - zero.w.im })
}

/// 0 to ω/2, cut at the edges of the band: all w_j and their mirror images fall there.
fn parts(form: &Form) -> Vec<Part> {
    let omega = form.omega();
    let high = form.edges().fold(0.0, f64::max);
    let mut cuts = vec![0.0, 0.5 * omega];
    cuts.extend(form.edges().map(|edge| {
        let rest = edge.rem_euclid(omega);
        rest.min(omega - rest)
    }));
    cuts.sort_unstable_by(f64::total_cmp);
    let mut parts = Vec::new();
    for pair in cuts.windows(2) {
        let &[from, to] = pair else { continue };
        if to - from < 1e-9 * omega {
            continue;
        }
        let middle = 0.5 * (from + to);
        let (first, last) = (((-high - middle) / omega).ceil(), ((high - middle) / omega).floor());
        let mut waves = Vec::new();
        let mut j = first;
        while j <= last && waves.len() <= MOST_WAVES {
            if form.carries(middle + j * omega) {
                waves.push(j);
            }
            j += 1.0;
        }
        if waves.len() <= MOST_WAVES {
            parts.push(Part { from, to, waves });
        }
    }
    parts
}

impl Part {
    /// Places closer to each other at both ends.
    fn places(&self) -> impl Iterator<Item = f64> + '_ {
        (0..LOOKS).map(|i| {
            let angle = std::f64::consts::PI * (i as f64 + 0.5) / LOOKS as f64;
            self.from + 0.5 * (self.to - self.from) * (1.0 - angle.cos())
        })
    }
}

fn slope(form: &Form, w: C) -> C {
    let step = 1e-6 * form.omega();
    (form.free(w + step) - form.free(w - step)) / (2.0 * step)
}

/// f is real: its changes of sign.
fn localised(form: &Form, part: &Part) -> Vec<OwnZero> {
    let value = |w: f64| form.free(C::from(w)).re;
    let looks: Vec<(f64, f64)> = part.places().map(|w| (w, value(w))).collect();
    let mut found = Vec::new();
    for pair in looks.windows(2) {
        let &[low, high] = pair else { continue };
        if (low.1 * high.1).is_nan() || low.1 * high.1 >= 0.0 {
            continue;
        }
        let Ok(w) = zero(low, high, high.0, |w| Ok::<f64, ()>(value(w))) else { continue };
        let w = C::from(w);
        found.push(OwnZero { w, slope: slope(form, w) });
    }
    found
}

/// Zeros next to the real axis, by the secant method from where |f| is least on it.
fn leaking(form: &Form, part: &Part) -> Vec<OwnZero> {
    let omega = form.omega();
    let looks: Vec<(f64, f64)> = part.places().map(|w| (w, form.free(C::from(w)).norm())).collect();
    let at = |i: usize| looks.get(i).map_or(f64::INFINITY, |look| look.1);
    let longest = 0.1 * (part.to - part.from);
    let mut found = Vec::new();
    for (i, &(start, size)) in looks.iter().enumerate() {
        if i > 0 && at(i - 1) < size || at(i + 1) < size {
            continue;
        }
        let (mut last, mut w) = (C::from(start), C::new(start, 1e-5 * omega));
        let mut at_last = form.free(last);
        for _ in 0..60 {
            let value = form.free(w);
            let mut step = value * (w - last) / (value - at_last);
            if !(step.re.is_finite() && step.im.is_finite()) {
                break;
            }
            if step.norm() > longest {
                step *= longest / step.norm();
            }
            (last, at_last) = (w, value);
            w -= step;
            if step.norm() < 1e-12 * omega {
                let slope = slope(form, w);
                let settled = form.free(w).norm() < 1e-7 * (slope * omega).norm();
                let inside = w.re > part.from && w.re < part.to && w.im.abs() < MOST_LOSS * omega;
                // Waves at ω/2 that feed each other are no mode of the breather's.
                let mirrored = (w.re / omega - 0.5).abs() < 1e-6 || w.re < 1e-6 * omega;
                if settled && inside && !mirrored {
                    found.push(OwnZero { w, slope });
                }
                break;
            }
        }
    }
    found
}

/// The mode has met its own mirror image at −1, outside the band: then f, which is negative far out on ν < −1, is not at −1.
fn doubled(form: &Form) -> bool {
    let halves = |edge: f64| (edge / form.omega() - 0.5).floor();
    // No odd multiple of ω/2 is in a band.
    form.bands().all(|(low, high)| halves(low) == halves(high)) && form.free(C::from(0.5 * form.omega())).re > 0.0
}

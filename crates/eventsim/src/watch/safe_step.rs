//! Steps that stay short of the first contact.
//!
//! Let f be the distance to a barrier (or, for a mass at rest, the force that holds it there) and B ≥ −f″ over the
//! window ([`crate::series::bound`]). From any τ with f > 0,
//!
//! ```text
//! f(τ+d) ≥ f(τ) + f′(τ) d − B d²/2      for all d ≥ 0 within the window,
//! ```
//!
//! so the first positive root d of the parabola is never beyond the first root of f: stepping there is safe, and no
//! contact can hide in the step, however short (a peak 1e-6 beyond the barrier, a graze). If the parabola has no root
//! there is no contact. Near a root with f′ < 0 the step is Newton's plus terms of the second order: it converges
//! quadratically, from the safe side. Near a touch it converges linearly until rounding decides.
//!
//! **A mass that starts on its barrier** has f(0) = 0. If it leaves with f′ > 0 the parabola's second root is the
//! answer, 2f′/B. If it leaves with a higher order m (3 after a release) the known zero is divided out:
//! g = f/s^m, g(0) > 0, and g ≥ g(0) − G s with a bound G of the same kind gives the first safe step.

use crate::series::bound;

/// Rounding of a series relative to its terms, and of a step relative to the time: see [`crate::watch`].
pub(crate) const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Distance to the first root of f + f′d − B d²/2 for f ≥ 0 (a negative f is rounding, and counts as 0); infinite if
/// there is none ahead.
pub(crate) fn safe_step(f: f64, slope: f64, bend: f64) -> f64 {
    let f = if f > 0.0 { f } else { 0.0 };
    let discriminant = slope * slope + 2.0 * bend * f;
    if discriminant < 0.0 {
        return f64::INFINITY;
    }
    if slope < 0.0 {
        2.0 * f / (discriminant.sqrt() - slope)
    } else if bend > 0.0 {
        (discriminant.sqrt() + slope) / bend
    } else {
        f64::INFINITY
    }
}

/// First safe step of a function that starts as g₀ s^m, g = `g[0]` + `g[1]` s + …, g₀ > 0; infinite if it stays
/// positive.
pub(crate) fn departure(g: &[f64], horizon: f64) -> f64 {
    let (_, lowest) = bound::polynomial(g, horizon);
    if lowest > 0.0 {
        return f64::INFINITY;
    }
    let (_, slope) = bound::polynomial(g.get(1..).unwrap_or_default(), horizon);
    if slope < 0.0 { g[0] / -slope } else { f64::INFINITY }
}

/// One side of a step.
pub(crate) enum Side {
    Ahead(f64),
    Contact(f64),
}

pub(crate) fn side(f: f64, slope: f64, bend: f64, margin: f64, tau: f64) -> Side {
    let step = safe_step(f, slope, bend);
    if slope < 0.0 && (f <= margin || step <= ROUNDING * tau) {
        // Newton's last step, of either sign, is below the rounding margin of the approach.
        return Side::Contact(f / -slope);
    }
    if f <= 0.0 && step <= ROUNDING * tau {
        return Side::Contact(0.0);
    }
    Side::Ahead(step)
}

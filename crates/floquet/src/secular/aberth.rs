//! Ehrlich and Aberth's simultaneous iteration for the zeros of f(z) = 1 + Σ ρ/(z−p) + conj.
//!
//! The zeros interlace the poles as long as impacts disturb little: one start inside each gap between poles sorted by
//! angle, slightly inside the circle. (Started at the poles the iteration fails.) Newton's correction uses the numerator's
//! logarithmic derivative, f′/f + Σ 1/(z−p), and repels the other approximations.

use nalgebra::Complex;

use super::error::SecularError;
use super::rational::Rational;
use vibrochain_breather::lanes::{Lane, ONE, ZERO, all, fill, four, total};

type C = Complex<f64>;

/// Work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct Aberth {
    pub(crate) roots: Vec<C>,
    pub(crate) errors: Vec<f64>,
    settled: Vec<bool>,
    angles: Vec<f64>,
    root_re: Vec<Lane>,
    root_im: Vec<Lane>,
}

const SWEEPS: usize = 100;

impl Aberth {
    /// All zeros into `roots`. `angles` are those of the poles on the upper half circle. The first `trivial` ones are known to be 1:
    /// they repel the others and stay.
    pub(crate) fn solve(&mut self, form: &Rational, angles: &[f64], trivial: usize) -> Result<(), SecularError> {
        let Self { roots, errors, settled, angles: sorted, root_re, root_im } = self;
        sorted.clear();
        sorted.extend_from_slice(angles);
        sorted.sort_unstable_by(f64::total_cmp);
        roots.clear();
        errors.clear();
        let m = sorted.len();
        // Between neighbours, on both halves; and next to +1 and −1. Off the mirror image, so that pairs may turn real.
        let radius = 1.0 - 0.3 / (m as f64 + 1.0);
        for pair in sorted.windows(2) {
            let (middle, tilt) = (0.5 * (pair[0] + pair[1]), 0.05 * (pair[1] - pair[0]));
            roots.push(C::from_polar(radius, middle + tilt));
            roots.push(C::from_polar(radius, -middle + tilt));
        }
        if let (Some(first), Some(last)) = (sorted.first(), sorted.last()) {
            roots.push(C::from_polar(radius, 0.1 * first));
            roots.push(C::from_polar(radius, std::f64::consts::PI - 0.1 * (std::f64::consts::PI - last)));
        }
        let (one, wanted) = (C::new(1.0, 0.0), 2 * m);
        if trivial > 0 && wanted > 0 {
            // In the place of the start next to +1.
            roots.swap(0, wanted - 2);
            roots.iter_mut().take(trivial).for_each(|root| *root = one);
        }
        // Those that fill up the last group are too far away to repel.
        fill(root_re, roots.iter().map(|z| z.re), 1e150);
        fill(root_im, roots.iter().map(|z| z.im), 0.0);
        settled.clear();
        settled.resize(wanted, false);
        settled.iter_mut().take(trivial).for_each(|settled| *settled = true);
        let mut open = wanted - trivial.min(wanted);
        for _ in 0..SWEEPS {
            for i in 0..wanted {
                if settled[i] {
                    continue;
                }
                let z = roots[i];
                let value = form.evaluate(z);
                let mut log = value.slope / value.f + value.poles;
                // All others repel; from itself it has no distance.
                let (mut re, mut im) = (ZERO, ZERO);
                let (x, y) = (all(z.re), all(z.im));
                for (root_re, root_im) in root_re.iter().zip(&*root_im) {
                    let (u, v) = (x - four(*root_re), y - four(*root_im));
                    let square = u * u + v * v;
                    let itself = square.simd_eq(ZERO);
                    let scale = itself.select(ZERO, ONE / itself.select(ONE, square));
                    re += u * scale;
                    im -= v * scale;
                }
                log -= C::new(total(re), total(im));
                let step = one / log;
                if step.re.is_finite() && step.im.is_finite() {
                    let next = z - step;
                    roots[i] = next;
                    root_re.as_flattened_mut()[i] = next.re;
                    root_im.as_flattened_mut()[i] = next.im;
                }
                // The iteration is of third order: after a step this small nothing is left to gain but rounding.
                let small = 1e-18 * z.norm_sqr().max(1e-6);
                let zero = 2.0 * f64::EPSILON * value.noise;
                if step.norm_sqr() <= small || value.f.norm_sqr() <= zero * zero {
                    settled[i] = true;
                    open -= 1;
                }
            }
            if open == 0 {
                break;
            }
        }
        errors.resize(trivial.min(wanted), 0.0);
        for z in roots.iter_mut().skip(trivial) {
            let mut value = form.evaluate(*z);
            let step = value.f / value.slope;
            if step.norm_sqr() <= 1e-14 * z.norm_sqr().max(1e-6) {
                *z -= step;
                value = form.evaluate(*z);
            }
            // And it is rounded itself.
            errors.push(form.doubt(*z) / value.slope.norm_sqr().sqrt() + 2.0 * f64::EPSILON * z.norm_sqr().sqrt());
        }
        if open == 0 { Ok(()) } else { Err(SecularError::Incomplete { found: wanted - open, wanted }) }
    }
}

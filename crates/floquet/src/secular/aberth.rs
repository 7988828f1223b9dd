//! Ehrlich and Aberth's simultaneous iteration for the zeros of f(z) = 1 + Σ ρ/(z−p) + conj.
//!
//! The zeros interlace the poles as long as impacts disturb little: one start inside each gap between poles sorted by
//! angle, slightly inside the circle. (Started at the poles the iteration fails.) Newton's correction uses the numerator's
//! logarithmic derivative, f′/f + Σ 1/(z−p), and repels the other approximations.

use nalgebra::Complex;

use super::doubt::Doubt;
use super::forced::SecularMultipliers;
use super::lanes::{ONE, ZERO, all, four, total};

type C = Complex<f64>;

/// Work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct Aberth {
    pub(crate) roots: Vec<C>,
    pub(crate) errors: Vec<f64>,
    settled: Vec<bool>,
    angles: Vec<f64>,
}

/// f, f′, Σ 1/(z−p), and a bound of the rounding error of f.
pub(super) struct Value {
    pub(super) f: C,
    pub(super) slope: C,
    poles: C,
    noise: f64,
}

pub(super) fn evaluate(form: &SecularMultipliers, z: C) -> Value {
    let (mut f_re, mut f_im, mut s_re, mut s_im) = (ZERO, ZERO, ZERO, ZERO);
    let (mut p_re, mut p_im, mut noise) = (ZERO, ZERO, ZERO);
    let lanes = form.pole_re.iter().zip(&form.pole_im).zip(form.residue_re.iter().zip(&form.residue_im));
    for ((pole_re, pole_im), (residue_re, residue_im)) in lanes {
        let (pole_im, residue_re, residue_im) = (four(*pole_im), four(*residue_re), four(*residue_im));
        let u = all(z.re) - four(*pole_re);
        for (v, r) in [(all(z.im) - pole_im, residue_im), (all(z.im) + pole_im, -residue_im)] {
            let scale = ONE / (u * u + v * v);
            let (a, b) = (u * scale, -v * scale);
            // ρ/(z−p) and its square over ρ
            let (x, y) = (residue_re * a - r * b, residue_re * b + r * a);
            f_re += x;
            f_im += y;
            s_re -= x * a - y * b;
            s_im -= x * b + y * a;
            p_re += a;
            p_im += b;
            noise += x.abs() + y.abs();
        }
    }
    Value {
        f: C::new(1.0 + total(f_re), total(f_im)),
        slope: C::new(total(s_re), total(s_im)),
        poles: C::new(total(p_re), total(p_im)),
        noise: 1.0 + total(noise),
    }
}

/// Error of f from those of residues and poles.
fn doubt(form: &SecularMultipliers, z: C) -> f64 {
    let mut doubt = ZERO;
    let lanes = form.pole_re.iter().zip(&form.pole_im).zip(form.residue_error.iter().zip(&form.pole_error));
    for ((pole_re, pole_im), (residue, pole)) in lanes {
        let (u, pole_im) = (all(z.re) - four(*pole_re), four(*pole_im));
        for v in [all(z.im) - pole_im, all(z.im) + pole_im] {
            let inverse = ONE / (u * u + v * v);
            doubt += four(*residue) * inverse.sqrt() + four(*pole) * inverse;
        }
    }
    f64::EPSILON + total(doubt)
}

const SWEEPS: usize = 100;

impl Aberth {
    /// All zeros into `roots`. `angles` are those of the poles on the upper half circle.
    pub(crate) fn solve(&mut self, form: &SecularMultipliers, angles: &[f64]) -> Result<(), Doubt> {
        let Self { roots, errors, settled, angles: sorted } = self;
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
        let wanted = 2 * m;
        settled.clear();
        settled.resize(wanted, false);
        let one = C::new(1.0, 0.0);
        let mut open = wanted;
        for _ in 0..SWEEPS {
            for i in 0..wanted {
                if settled[i] {
                    continue;
                }
                let z = roots[i];
                let value = evaluate(form, z);
                let mut log = value.slope / value.f + value.poles;
                let (mut re, mut im) = (0.0, 0.0);
                for (j, other) in roots.iter().enumerate() {
                    if j != i {
                        let (u, v) = (z.re - other.re, z.im - other.im);
                        let scale = 1.0 / (u * u + v * v);
                        re += u * scale;
                        im -= v * scale;
                    }
                }
                log -= C::new(re, im);
                let step = one / log;
                if step.re.is_finite() && step.im.is_finite() {
                    roots[i] = z - step;
                }
                // The iteration is of third order: after a step this small nothing is left to gain but rounding.
                let small = 1e-9 * z.norm().max(1e-3);
                if step.norm() <= small || value.f.norm() <= 2.0 * f64::EPSILON * value.noise {
                    settled[i] = true;
                    open -= 1;
                }
            }
            if open == 0 {
                break;
            }
        }
        for z in roots.iter_mut() {
            let mut value = evaluate(form, *z);
            let step = value.f / value.slope;
            if step.norm() <= 1e-7 * z.norm().max(1e-3) {
                *z -= step;
                value = evaluate(form, *z);
            }
            // And it is rounded itself.
            errors.push(doubt(form, *z) / value.slope.norm() + 2.0 * f64::EPSILON * z.norm());
        }
        if open == 0 { Ok(()) } else { Err(Doubt::Incomplete { found: wanted - open, wanted }) }
    }
}

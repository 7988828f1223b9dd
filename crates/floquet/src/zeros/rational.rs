//! The secular function of a forced orbit by its poles and residues, f(z) = 1 + Σ ρ/(z−p) + conj.

use nalgebra::Complex;
use vibrochain_lattice::simd::lanes::{Lane, ONE, ZERO, all, four, total};

type C = Complex<f64>;

/// Poles of the upper half plane and their residues.
#[derive(Debug, Clone, Default)]
pub(crate) struct Rational {
    /// p and ρ
    pub(crate) pole_re: Vec<Lane>,
    pub(crate) pole_im: Vec<Lane>,
    pub(crate) residue_re: Vec<Lane>,
    pub(crate) residue_im: Vec<Lane>,
    /// Errors of ρ, and |ρ| times those of p.
    pub(crate) residue_error: Vec<Lane>,
    pub(crate) pole_error: Vec<Lane>,
}

/// A zero this close to its pole is no start: f is not known there.
const HIDDEN: f64 = 1e-10;

/// f, f′, Σ 1/(z−p), a bound of the rounding error of f in units of ε, and an estimate of that of f′ where f tells of none.
pub(crate) struct Value {
    pub(crate) f: C,
    pub(crate) slope: C,
    pub(crate) poles: C,
    pub(crate) noise: f64,
    pub(crate) slope_error: f64,
}

impl Rational {
    /// f and what goes with it at `z`.
    pub(crate) fn evaluate(&self, z: C) -> Value {
        let (mut f_re, mut f_im, mut s_re, mut s_im) = (ZERO, ZERO, ZERO, ZERO);
        let (mut p_re, mut p_im, mut noise) = (ZERO, ZERO, ZERO);
        let lanes = self.pole_re.iter().zip(&self.pole_im).zip(self.residue_re.iter().zip(&self.residue_im));
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
            slope_error: 0.0,
        }
    }

    /// How far from one of the poles of the upper half plane the zero is that belongs to it, to first order in its own residue. `None`
    /// where that is so little that the pole hides it.
    pub(crate) fn beside(&self, place: usize) -> Option<C> {
        let at = |lanes: &[Lane]| lanes.as_flattened()[place];
        let (x, y) = (at(&self.pole_re), at(&self.pole_im));
        let (mut f_re, mut f_im) = (ZERO, ZERO);
        let lanes = self.pole_re.iter().zip(&self.pole_im).zip(self.residue_re.iter().zip(&self.residue_im));
        for ((pole_re, pole_im), (residue_re, residue_im)) in lanes {
            let (pole_im, residue_re, residue_im) = (four(*pole_im), four(*residue_re), four(*residue_im));
            let u = all(x) - four(*pole_re);
            for (v, r) in [(all(y) - pole_im, residue_im), (all(y) + pole_im, -residue_im)] {
                let square = u * u + v * v;
                let itself = square.simd_eq(ZERO);
                let scale = itself.select(ZERO, ONE / itself.select(ONE, square));
                f_re += (residue_re * u + r * v) * scale;
                f_im += (r * u - residue_re * v) * scale;
            }
        }
        let residue = C::new(at(&self.residue_re), at(&self.residue_im));
        let offset = -residue / C::new(1.0 + total(f_re), total(f_im));
        (offset.norm_sqr() > HIDDEN * HIDDEN).then_some(offset)
    }

    /// Error of f from those of residues and poles.
    pub(crate) fn doubt(&self, z: C) -> f64 {
        let mut doubt = ZERO;
        let lanes = self.pole_re.iter().zip(&self.pole_im).zip(self.residue_error.iter().zip(&self.pole_error));
        for ((pole_re, pole_im), (residue, pole)) in lanes {
            let (u, pole_im) = (all(z.re) - four(*pole_re), four(*pole_im));
            for v in [all(z.im) - pole_im, all(z.im) + pole_im] {
                let inverse = ONE / (u * u + v * v);
                doubt += four(*residue) * inverse.sqrt() + four(*pole) * inverse;
            }
        }
        f64::EPSILON + total(doubt)
    }
}

#[cfg(test)]
mod tests;

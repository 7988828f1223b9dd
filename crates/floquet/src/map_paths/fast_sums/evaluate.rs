//! Values of F and its derivatives. ν is given as an origin plus an offset t, the origin by its distances to the poles,
//! so that nothing is lost next to a pole or next to ±1.

use nalgebra::Complex;
use vibrochain_lattice::simd::lanes::{Lane, ONE, TWO, ZERO, all, four, total};

use crate::map_paths::fast_sums::multipole::{complex_series, series};
use crate::map_paths::fast_sums::neighbourhood::NearPoles;

/// F in the neighbourhood of an origin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Local<'a> {
    pub(crate) near_poles: &'a NearPoles,
    pub(crate) distances: &'a [Lane],
    /// The origin in the coordinate of the field of far poles, if there are any.
    pub(crate) origin: Option<f64>,
}

/// F and its first two derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Jet {
    pub(crate) value: f64,
    pub(crate) slope: f64,
    pub(crate) bend: f64,
}

impl Local<'_> {
    /// Σ R/(D+t) and derivatives in t.
    pub(crate) fn jet(&self, at: f64) -> Jet {
        let (mut value, mut slope, mut bend) = (ZERO, ZERO, ZERO);
        let t = all(at);
        for (residue, distance) in self.near_poles.charges[0].iter().zip(self.distances) {
            let inverse = ONE / (four(*distance) + t);
            let term = four(*residue) * inverse;
            let square = term * inverse;
            value += term;
            slope -= square;
            bend += square * inverse;
        }
        let near = Jet { value: total(value), slope: total(slope), bend: 2.0 * total(bend) };
        let Some(origin) = self.origin else { return near };
        let NearPoles { scale, far: [field, field_slope, field_bend], .. } = self.near_poles;
        let u = origin + at * scale;
        Jet {
            value: near.value + series(field, u),
            slope: near.slope + scale * series(field_slope, u),
            bend: near.bend + scale * scale * series(field_bend, u),
        }
    }

    /// What is left out is known there.
    pub(crate) fn holds(&self, t: Complex<f64>) -> bool {
        self.origin.is_none_or(|origin| self.near_poles.holds(t * self.near_poles.scale + origin))
    }

    /// Σ R/(D+t).
    pub(crate) fn value(&self, t: f64) -> f64 {
        let mut value = ZERO;
        for (residue, distance) in self.near_poles.charges[0].iter().zip(self.distances) {
            value += four(*residue) / (four(*distance) + all(t));
        }
        total(value)
            + self.origin.map_or(0.0, |origin| series(&self.near_poles.far[0], origin + t * self.near_poles.scale))
    }

    /// The residue of a pole at the origin itself.
    pub(crate) fn charge_here(&self) -> f64 {
        let pairs = self.near_poles.charges[0].as_flattened().iter().zip(self.distances.as_flattened());
        pairs.filter(|(_, distance)| **distance == 0.0).map(|(residue, _)| residue).sum()
    }

    /// Error of F from those of the residues, of the poles and of the sum.
    pub(crate) fn noise(&self, t: Complex<f64>) -> f64 {
        let mut noise = ZERO;
        let [residues, errors] = &self.near_poles.charges;
        let (re, square) = (all(t.re), all(t.im * t.im));
        let lanes = residues.iter().zip(errors).zip(&self.near_poles.shifts).zip(self.distances);
        for (((residue, error), shift), distance) in lanes {
            let u = four(*distance) + re;
            let inverse = ONE / (u * u + square).sqrt();
            let rounding = all(4.0 * f64::EPSILON) + four(*shift) * inverse;
            noise += (four(*error) + four(*residue).abs() * rounding) * inverse;
        }
        total(noise) + self.near_poles.noise
    }

    /// Error of F as the function that its poles and residues define, from the sum alone.
    pub(crate) fn rounding(&self, t: Complex<f64>) -> f64 {
        let mut size = ZERO;
        let (re, square) = (all(t.re), all(t.im * t.im));
        for (residue, distance) in self.near_poles.charges[0].iter().zip(self.distances) {
            let u = four(*distance) + re;
            size += four(*residue).abs() / (u * u + square).sqrt();
        }
        4.0 * f64::EPSILON * total(size) + self.near_poles.rounding
    }

    /// Error of a real simple root.
    pub(crate) fn root_error(&self, t: f64) -> f64 {
        self.noise(Complex::new(t, 0.0)) / self.jet(t).slope.abs()
    }

    /// F and F′ at complex t.
    pub(crate) fn complex(&self, t: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
        let (mut re, mut im, mut slope_re, mut slope_im) = (ZERO, ZERO, ZERO, ZERO);
        let (x, y) = (all(t.re), all(t.im));
        for (residue, distance) in self.near_poles.charges[0].iter().zip(self.distances) {
            let (u, residue) = (four(*distance) + x, four(*residue));
            let scale = ONE / (u * u + y * y);
            let (a, b) = (u * scale, -y * scale);
            re += residue * a;
            im += residue * b;
            slope_re -= residue * (a * a - b * b);
            slope_im -= TWO * residue * a * b;
        }
        let (value, slope) = (Complex::new(total(re), total(im)), Complex::new(total(slope_re), total(slope_im)));
        let Some(origin) = self.origin else { return (value, slope) };
        let NearPoles { scale, far: [field, field_slope, _], .. } = self.near_poles;
        let u = t * scale + origin;
        let [far, far_slope] = complex_series([field, field_slope], u);
        (value + far, slope + far_slope * scale)
    }
}

//! Values of F and its derivatives. ν is given as an origin plus an offset t, the origin by its distances to the poles,
//! so that nothing is lost next to a pole or next to ±1.

use nalgebra::Complex;

use super::cauchy::{complex_series, series};
use super::leaf::Leaf;
use vibrochain_breather::lanes::{Lane, ONE, TWO, ZERO, all, four, total};

/// F in the neighbourhood of an origin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Local<'a> {
    pub(crate) residues: &'a [Lane],
    pub(crate) errors: &'a [Lane],
    pub(crate) shifts: &'a [Lane],
    pub(crate) distances: &'a [Lane],
    /// What the poles left out contribute.
    pub(crate) far: Option<Far<'a>>,
}

/// The field of far poles as a polynomial.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Far<'a> {
    pub(crate) leaf: &'a Leaf,
    /// The origin, in the polynomial's coordinate.
    pub(crate) origin: f64,
}

impl Far<'_> {
    /// The polynomial is good there: within an ellipse about its interval on which it still converges fast.
    pub(crate) fn holds(&self, t: Complex<f64>) -> bool {
        let u = t * self.leaf.scale + self.origin;
        u.re.abs() <= 1.2 && u.im.abs() <= 0.5
    }

    fn coordinate(&self, t: f64) -> f64 {
        self.origin + t * self.leaf.scale
    }
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
        for (residue, distance) in self.residues.iter().zip(self.distances) {
            let inverse = ONE / (four(*distance) + t);
            let term = four(*residue) * inverse;
            let square = term * inverse;
            value += term;
            slope -= square;
            bend += square * inverse;
        }
        let near = Jet { value: total(value), slope: total(slope), bend: 2.0 * total(bend) };
        let Some(far) = self.far else { return near };
        let (u, scale) = (far.coordinate(at), far.leaf.scale);
        Jet {
            value: near.value + series(&far.leaf.value, u),
            slope: near.slope + scale * series(&far.leaf.slope, u),
            bend: near.bend + scale * scale * series(&far.leaf.bend, u),
        }
    }

    /// Σ R/(D+t).
    pub(crate) fn value(&self, t: f64) -> f64 {
        let mut value = ZERO;
        for (residue, distance) in self.residues.iter().zip(self.distances) {
            value += four(*residue) / (four(*distance) + all(t));
        }
        total(value) + self.far.map_or(0.0, |far| series(&far.leaf.value, far.coordinate(t)))
    }

    /// Error of F from those of the residues, of the poles and of the sum.
    pub(crate) fn noise(&self, t: Complex<f64>) -> f64 {
        let mut noise = ZERO;
        let (re, square) = (all(t.re), all(t.im * t.im));
        let lanes = self.residues.iter().zip(self.errors).zip(self.shifts).zip(self.distances);
        for (((residue, error), shift), distance) in lanes {
            let u = four(*distance) + re;
            let inverse = ONE / (u * u + square).sqrt();
            let rounding = all(4.0 * f64::EPSILON) + four(*shift) * inverse;
            noise += (four(*error) + four(*residue).abs() * rounding) * inverse;
        }
        total(noise) + self.far.map_or(0.0, |far| far.leaf.noise)
    }

    /// Error of F as the function that its poles and residues define, from the sum alone.
    pub(crate) fn rounding(&self, t: Complex<f64>) -> f64 {
        let mut size = ZERO;
        let (re, square) = (all(t.re), all(t.im * t.im));
        for (residue, distance) in self.residues.iter().zip(self.distances) {
            let u = four(*distance) + re;
            size += four(*residue).abs() / (u * u + square).sqrt();
        }
        4.0 * f64::EPSILON * total(size) + self.far.map_or(0.0, |far| far.leaf.rounding)
    }

    /// Error of a real simple root.
    pub(crate) fn root_error(&self, t: f64) -> f64 {
        self.noise(Complex::new(t, 0.0)) / self.jet(t).slope.abs()
    }

    /// F and F′ at complex t.
    pub(crate) fn complex(&self, t: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
        let (mut re, mut im, mut slope_re, mut slope_im) = (ZERO, ZERO, ZERO, ZERO);
        let (x, y) = (all(t.re), all(t.im));
        for (residue, distance) in self.residues.iter().zip(self.distances) {
            let (u, residue) = (four(*distance) + x, four(*residue));
            let scale = ONE / (u * u + y * y);
            let (a, b) = (u * scale, -y * scale);
            re += residue * a;
            im += residue * b;
            slope_re -= residue * (a * a - b * b);
            slope_im -= TWO * residue * a * b;
        }
        let (value, slope) = (Complex::new(total(re), total(im)), Complex::new(total(slope_re), total(slope_im)));
        let Some(far) = self.far else { return (value, slope) };
        let u = t * far.leaf.scale + far.origin;
        (value + complex_series(&far.leaf.value, u), slope + complex_series(&far.leaf.slope, u) * far.leaf.scale)
    }
}

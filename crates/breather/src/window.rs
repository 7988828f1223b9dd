//! Exact flight of all watched masses over short windows, as Taylor polynomials from the equation of motion,
//!
//! ```text
//! c_{k+2} = (−γ₁c_k − γ₂(2c_k − c_left − c_right) + F_k) / ((k+1)(k+2)) .
//! ```
//!
//! Time is counted in a unit near one radian of the fastest motion: c_k would leave the range of `f64` for frequencies
//! beyond 1e16. The unit is a power of two, so that it costs no digit.
//!
//! A window is at most one radian of the fastest motion, so that ORDER terms leave a remainder below rounding. The
//! polynomials are each mass's own: far from the breather their coefficients are as small as the motion itself, and
//! bounds taken from them are as tight, which no bound common to the ring could be.

use vibrochain_lattice::{LARGE_RING, Model, Wave};

use crate::motion::Motion;

/// Number of coefficients: the first one left out is below 1/20! = 4e-19 of the motion.
pub(crate) const ORDER: usize = 20;

/// Windows after which the masses are set anew from the modes, so that rounding cannot add up.
const REFRESH: usize = 32;

/// The masses that need watching: one half of a ring that is symmetric about site `home`, or all of it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Watched {
    pub(crate) sites: Vec<usize>,
    left: Vec<usize>,
    right: Vec<usize>,
}

impl Watched {
    pub(crate) fn set(&mut self, ring: usize, home: Option<usize>) {
        let count = if home.is_some() { ring / 2 + 1 } else { ring };
        // Symmetry folds a site beyond the half ring onto its mirror image.
        let fold = |n: usize| if home.is_some() { n.min(ring - n) } else { n };
        if self.sites.len() != count || self.sites.first() != Some(&home.unwrap_or(0)) || self.right.len() != count {
            self.sites.clear();
            self.sites.extend((0..count).map(|n| (home.unwrap_or(0) + n) % ring));
            self.left.clear();
            self.left.extend((0..count).map(|n| fold((n + ring - 1) % ring)));
            self.right.clear();
            self.right.extend((0..count).map(|n| fold((n + 1) % ring)));
        }
    }
}

/// The polynomials of the current window.
#[derive(Debug, Clone, Default)]
pub(crate) struct Window {
    /// [order][mass]
    coefficients: Vec<f64>,
    masses: usize,
    since_refresh: usize,
    unit: f64,
    /// Displacement and velocity of all masses of a large ring.
    all: Vec<(f64, f64)>,
    lows: Vec<f64>,
    highs: Vec<f64>,
}

impl Window {
    /// Counts time in units for a fastest motion of `rate` radians a unit of the model's time, from the next placement on.
    pub(crate) fn set_rate(&mut self, rate: f64) {
        self.unit = 2f64.powi(-(rate.log2().floor() as i32));
    }

    /// The unit of time.
    pub(crate) fn unit(&self) -> f64 {
        self.unit
    }

    /// Sets all masses from the modes, `elapsed` after the start of an interval between impacts.
    pub(crate) fn place(&mut self, watched: &Watched, motion: &mut Motion, interval: usize, elapsed: f64) {
        self.masses = watched.sites.len();
        self.coefficients.resize(ORDER * self.masses, 0.0);
        self.since_refresh = 0;
        motion.seek(interval, elapsed);
        let (values, slopes) = self.coefficients.split_at_mut(self.masses);
        if motion.sites() >= LARGE_RING {
            motion.all_sites(&mut self.all);
            for ((value, slope), &site) in values.iter_mut().zip(slopes).zip(&watched.sites) {
                let (displacement, velocity) = self.all[site];
                (*value, *slope) = (displacement, velocity * self.unit);
            }
            return;
        }
        let slopes = &mut slopes[..self.masses];
        motion.masses(&watched.sites, values, slopes);
        slopes.iter_mut().for_each(|slope| *slope *= self.unit);
    }

    /// Works out the polynomials from displacement and velocity; `time` is t+ψ, for the force, at the window's start.
    pub(crate) fn expand(&mut self, watched: &Watched, model: &Model, force: &Wave, time: f64) {
        let n = self.masses;
        let squared = self.unit * self.unit;
        let (g1, g2) = (model.chain().gamma1() * squared, model.chain().gamma2() * squared);
        let mut pushes = [0.0; ORDER - 2];
        for term in force.terms() {
            let (sin, cos) = (term.rate * time + term.phase).sin_cos();
            // Derivatives of A cos: A cos, −Aω sin, −Aω² cos, Aω³ sin, …, over k!.
            let mut size = term.amplitude * squared;
            let rate = term.rate * self.unit;
            let quarter = [cos, -sin, -cos, sin];
            for (k, push) in pushes.iter_mut().enumerate() {
                *push += size * quarter[k % 4];
                size *= rate / (k + 1) as f64;
            }
        }
        for (k, push) in pushes.into_iter().enumerate() {
            let scale = 1.0 / ((k + 1) * (k + 2)) as f64;
            let (known, rest) = self.coefficients.split_at_mut((k + 2) * n);
            let (c, next) = (&known[k * n..(k + 1) * n], &mut rest[..n]);
            let coefficient =
                |own: f64, left: f64, right: f64| scale * (push - g1 * own - g2 * (2.0 * own - (left + right)));
            // Neighbours stand side by side, but for the ends.
            for ((next, own), sides) in next.iter_mut().skip(1).zip(&c[1..]).zip(c.windows(3)) {
                *next = coefficient(*own, sides[0], sides[2]);
            }
            for i in [0, n - 1] {
                next[i] = coefficient(c[i], c[watched.left[i]], c[watched.right[i]]);
            }
        }
    }

    /// Moves on by `step`, in units: through the polynomials, or from the modes where rounding is due to be cleared.
    pub(crate) fn advance(&mut self, watched: &Watched, motion: &mut Motion, interval: usize, elapsed: f64, step: f64) {
        self.since_refresh += 1;
        if self.since_refresh >= REFRESH {
            self.place(watched, motion, interval, elapsed);
            return;
        }
        // Horner's rule for value and slope of all masses at once.
        let n = self.masses;
        let (values, slopes) = (&mut self.lows, &mut self.highs);
        for scratch in [&mut *values, &mut *slopes] {
            scratch.clear();
            scratch.resize(n, 0.0);
        }
        for c in self.coefficients.chunks_exact(n).rev() {
            for ((value, slope), c) in values.iter_mut().zip(slopes.iter_mut()).zip(c) {
                *slope = *slope * step + *value;
                *value = *value * step + c;
            }
        }
        self.coefficients[..n].copy_from_slice(values);
        self.coefficients[n..2 * n].copy_from_slice(slopes);
    }

    /// Displacement of mass `i` at the window's start.
    pub(crate) fn displacement(&self, i: usize) -> f64 {
        self.coefficients[i]
    }

    /// Works out the ranges of all masses within `length`, in units.
    pub(crate) fn enclose(&mut self, length: f64) {
        let n = self.masses;
        let (lows, highs) = (&mut self.lows, &mut self.highs);
        for scratch in [&mut *lows, &mut *highs] {
            scratch.clear();
            scratch.resize(n, 0.0);
        }
        for c in self.coefficients.chunks_exact(n).skip(1).rev() {
            for ((low, high), c) in lows.iter_mut().zip(highs.iter_mut()).zip(c) {
                let (below, above) = (c + length * *low, c + length * *high);
                *low = if below < 0.0 { below } else { 0.0 };
                *high = if above > 0.0 { above } else { 0.0 };
            }
        }
        for ((low, high), start) in lows.iter_mut().zip(highs.iter_mut()).zip(&self.coefficients) {
            (*low, *high) = (start + length * *low, start + length * *high);
        }
    }

    /// Smallest and largest displacement that mass `i` could have within the length last enclosed: each coefficient of the
    /// wrong sign is dropped, so that what is left can only grow.
    pub(crate) fn range(&self, i: usize) -> (f64, f64) {
        (self.lows[i], self.highs[i])
    }

    /// The polynomial of mass `i`, in units of time.
    pub(crate) fn polynomial(&self, i: usize) -> Polynomial {
        let mut coefficients = [0.0; ORDER];
        for (k, c) in coefficients.iter_mut().enumerate() {
            *c = self.coefficients[k * self.masses + i];
        }
        Polynomial { coefficients }
    }
}

/// A Taylor polynomial.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Polynomial {
    coefficients: [f64; ORDER],
}

impl Polynomial {
    /// Value and first derivative.
    pub(crate) fn evaluate(&self, s: f64) -> (f64, f64) {
        let (mut value, mut slope) = (0.0, 0.0);
        for &c in self.coefficients.iter().rev() {
            slope = slope * s + value;
            value = value * s + c;
        }
        (value, slope)
    }

    /// Value, first and second derivative.
    pub(crate) fn jet(&self, s: f64) -> [f64; 3] {
        let (mut value, mut slope, mut half_curvature) = (0.0, 0.0, 0.0);
        for &c in self.coefficients.iter().rev() {
            half_curvature = half_curvature * s + slope;
            slope = slope * s + value;
            value = value * s + c;
        }
        [value, slope, 2.0 * half_curvature]
    }

    /// A bound on the modulus of the third derivative on 0 … `length`.
    pub(crate) fn third_bound(&self, length: f64) -> f64 {
        let mut bound = 0.0;
        for (k, c) in self.coefficients.iter().enumerate().skip(3).rev() {
            bound = bound * length + c.abs() * (k * (k - 1) * (k - 2)) as f64;
        }
        bound
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_and_bounds_of_a_sine() {
        let mut coefficients = [0.0; ORDER];
        let mut factorial = 1.0;
        for (k, c) in coefficients.iter_mut().enumerate() {
            factorial *= k.max(1) as f64;
            *c = [0.0, 1.0, 0.0, -1.0][k % 4] / factorial;
        }
        let sine = Polynomial { coefficients };
        for s in [0.0, 0.3, 1.0_f64] {
            let [value, slope, curvature] = sine.jet(s);
            assert!((value - s.sin()).abs() < 1e-15 && (slope - s.cos()).abs() < 1e-15);
            assert!((curvature + s.sin()).abs() < 1e-14);
            assert_eq!(sine.evaluate(s), (value, slope));
        }
        assert!(sine.third_bound(1.0) >= 1.0 && sine.third_bound(1.0) <= 1.6);
        let coefficients = coefficients.to_vec();
        let mut window = Window { coefficients, masses: 1, unit: 1.0, ..Window::default() };
        window.enclose(1.0);
        let (low, high) = window.range(0);
        assert!(low <= 0.0 && high >= 1f64.sin() && high <= 1.01);
    }

    #[test]
    fn watched_half_rings_fold_onto_themselves() {
        let mut watched = Watched::default();
        for (ring, left, right) in [
            (1, vec![0], vec![0]),
            (2, vec![1, 0], vec![1, 0]),
            (5, vec![1, 0, 1], vec![1, 2, 2]),
            (6, vec![1, 0, 1, 2], vec![1, 2, 3, 2]),
        ] {
            watched.set(ring, Some(0));
            assert_eq!((&watched.left, &watched.right), (&left, &right), "{ring}");
        }
        watched.set(5, Some(3));
        assert_eq!(watched.sites, [3, 4, 0]);
        watched.set(5, None);
        assert_eq!((watched.sites.len(), watched.left[0], watched.right[4]), (5, 4, 0));
    }
}

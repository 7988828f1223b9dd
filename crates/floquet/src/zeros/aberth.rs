//! Ehrlich and Aberth's simultaneous iteration for the zeros of a function with known poles p, for f(z) = 1 + Σ ρ/(z−p) + conj. and for
//! the determinant of an orbit's equations ([`crate::spectrum`]).
//!
//! Newton's correction uses the numerator's logarithmic derivative, f′/f + Σ 1/(z−p), and repels the other approximations. f is real on
//! the real axis: its zeros are real or come in conjugate pairs, of which one is worked out for both. Each pair of poles has a pair to
//! begin with, the zeros beside them as their own residue has it, no farther off than half the way to the next pole. A pair that comes to the
//! real axis may be two real zeros: it is parted, and both go on alone. (Started at the poles it fails.)

use nalgebra::Complex;
use vibrochain_lattice::simd::lanes::{Lane, ONE, ZERO, all, fill, four, total};

use super::excess::modulus;
use super::rational::{Rational, Value};

type C = Complex<f64>;

/// A function that is real on the real axis, has poles that are known and as many zeros as these.
pub(crate) trait Meromorphic {
    /// f, f′ and what goes with them.
    fn evaluate(&mut self, z: C) -> Value;
}

impl Meromorphic for Rational {
    fn evaluate(&mut self, z: C) -> Value {
        Rational::evaluate(self, z)
    }
}

/// When a step is the last.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Last {
    /// As a part of the modulus.
    pub(crate) of_modulus: f64,
    /// As a part of the distance to the nearest other approximation.
    pub(crate) of_distance: f64,
}

/// Work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct Aberth {
    /// The zeros, two by two.
    pub(crate) roots: Vec<C>,
    /// Which two are each other's conjugates.
    paired: Vec<bool>,
    settled: Vec<bool>,
    root_re: Vec<Lane>,
    root_im: Vec<Lane>,
}

const SWEEPS: usize = 100;

/// Sweeps after which two that have not settled are parted: twice as many as pairs take that are none of real zeros.
const PATIENCE: usize = 12;

/// The part of its distance from the real axis that a pair may keep in one step, or it is parted.
const FALL: f64 = 0.1;

/// By how much two that are parted leave the mirror image of each other, in parts of what lay between them: the iteration would keep it.
const TILT: f64 = 1e-3;

/// A step that rounding makes longer or shorter by more than this part of it leads nowhere.
const LOST: f64 = 0.3;

impl Aberth {
    /// The zeros of any function of this kind from as many starts, two of which are paired if they follow each other and are conjugates,
    /// the first in an even place; true where all have settled. Zeros that are known to begin with stay, `known` of them in front.
    pub(crate) fn solve_from(
        &mut self,
        form: &mut impl Meromorphic,
        starts: impl Iterator<Item = C>,
        known: usize,
        last: Last,
    ) -> bool {
        self.roots.clear();
        self.roots.extend(starts);
        let conjugates = |pair: &[C]| matches!(pair, [one, other] if one.im != 0.0 && *other == one.conj());
        self.paired.clear();
        self.paired.extend(self.roots.chunks(2).map(conjugates));
        self.spread();
        self.iterate(form, known, last);
        self.settled.iter().all(|settled| *settled)
    }

    /// Sweeps until all have settled, or long enough.
    fn iterate(&mut self, form: &mut impl Meromorphic, known: usize, last: Last) {
        let wanted = self.roots.len();
        self.settled.clear();
        self.settled.resize(wanted, false);
        self.settled[..known].fill(true);
        for sweep in 0..SWEEPS {
            if sweep == PATIENCE {
                for i in (0..wanted).step_by(2) {
                    if !self.settled[i] {
                        self.part(i, self.roots[i]);
                    }
                }
            }
            for i in 0..wanted {
                if !(self.settled[i] || self.paired[i / 2] && i % 2 == 1) {
                    self.step(form, i, last);
                }
            }
            if self.settled.iter().all(|settled| *settled) {
                break;
            }
        }
    }

    /// Lays the approximations out in groups of four.
    fn spread(&mut self) {
        let Self { roots, root_re, root_im, .. } = self;
        // Those that fill up the last group are too far away to repel.
        fill(root_re, roots.iter().map(|z| z.re), 1e150);
        fill(root_im, roots.iter().map(|z| z.im), 0.0);
    }

    fn put(&mut self, i: usize, z: C) {
        self.roots[i] = z;
        self.root_re.as_flattened_mut()[i] = z.re;
        self.root_im.as_flattened_mut()[i] = z.im;
    }

    /// Lets the two of a pair go each its own way, from beside each other where they come to the real axis at `z`.
    fn part(&mut self, i: usize, z: C) {
        if self.paired[i / 2] {
            self.paired[i / 2] = false;
            let apart = z.im.abs().max(0.5 * self.roots[i].im.abs());
            self.put(i, C::new(z.re + apart, TILT * apart));
            self.put(i + 1, C::new(z.re - apart, 2.0 * TILT * apart));
        }
    }

    /// One step of one of them, and of its conjugate; one of `last` settles it.
    fn step(&mut self, form: &mut impl Meromorphic, i: usize, last: Last) {
        let z = self.roots[i];
        let value = form.evaluate(z);
        let mut log = value.slope / value.f + value.poles;
        // All others repel; from itself it has no distance.
        let (mut re, mut im, mut nearest) = (ZERO, ZERO, ZERO);
        let (x, y) = (all(z.re), all(z.im));
        for (root_re, root_im) in self.root_re.iter().zip(&self.root_im) {
            let (u, v) = (x - four(*root_re), y - four(*root_im));
            let square = u * u + v * v;
            let itself = square.simd_eq(ZERO);
            let scale = itself.select(ZERO, ONE / itself.select(ONE, square));
            re += u * scale;
            im -= v * scale;
            nearest = nearest.fast_max(scale);
        }
        log -= C::new(total(re), total(im));
        let step = C::new(1.0, 0.0) / log;
        let pair = self.paired[i / 2];
        if step.re.is_finite() && step.im.is_finite() {
            let next = z - step;
            if pair && next.im <= FALL * z.im {
                return self.part(i, next);
            }
            self.put(i, next);
            if pair {
                self.put(i + 1, next.conj());
            }
        }
        let nearest = nearest.to_array().into_iter().fold(f64::MIN_POSITIVE, f64::max).recip();
        let [of_modulus, of_distance] = [last.of_modulus, last.of_distance].map(|last| last * last);
        let small = (of_modulus * z.norm_sqr().max(1e-6)).max(of_distance * nearest);
        let zero = 2.0 * f64::EPSILON * value.noise;
        let lost = value.slope_error > LOST * modulus(log) * modulus(value.f);
        if step.norm_sqr() <= small || value.f.norm_sqr() <= zero * zero || lost {
            self.settled[i] = true;
            self.settled[i + usize::from(pair)] = true;
        }
    }
}

//! Ehrlich and Aberth's simultaneous iteration for the zeros of a function with known poles p, for f(z) = 1 + Σ ρ/(z−p) + conj. and for
//! the determinant of an orbit's equations ([`crate::spectrum`]).
//!
//! Newton's correction uses the numerator's logarithmic derivative, f′/f + Σ 1/(z−p), and repels the other approximations. f is real on
//! the real axis: its zeros are real or come in conjugate pairs, of which one is worked out for both. Each pair of poles has a pair to
//! begin with, the zeros beside them as their own residue has it, no farther off than the next pole. A pair that comes to the real axis
//! may be two real zeros: it is parted, and both go on alone. Where two end at one zero, which the sum of all shows, the iteration
//! begins anew with one start inside each gap between poles sorted by angle, and none paired. (Started at the poles it fails.)

use nalgebra::Complex;
use vibrochain_lattice::simd::lanes::{Lane, ONE, ZERO, all, fill, four, total};

use super::error::SecularError;
use super::excess::modulus;
use super::rational::{Rational, Value};

type C = Complex<f64>;
const PI: f64 = std::f64::consts::PI;

/// Where the iteration begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Start {
    /// In pairs, each beside its poles: half the work.
    Beside,
    /// Between the poles, none paired.
    Between,
}

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
    pub(crate) errors: Vec<f64>,
    /// Which two are each other's conjugates.
    paired: Vec<bool>,
    settled: Vec<bool>,
    order: Vec<u32>,
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

/// Steps this small, to the modulus, are the last beside poles: the iteration is of third order, and Newton's method has the rest and says whether it is.
const LAST: f64 = 1e-5;

/// Steps of Newton's method this small leave nothing to gain but rounding.
const SETTLED: f64 = 1e-9;

/// What a step of Newton's method may be that is taken thereafter.
const POLISH: f64 = 1e-7;

/// A step that rounding makes longer or shorter by more than this part of it leads nowhere.
const LOST: f64 = 0.3;

/// Steps of Newton's method at most.
const LAST_STEPS: usize = 3;

impl Aberth {
    /// All zeros into `roots`. `angles` are those of the poles on the upper half circle. The first `trivial` ones are known to be 1:
    /// they repel the others and stay, which goes with a start between the poles.
    pub(crate) fn solve(
        &mut self,
        form: &mut Rational,
        angles: &[f64],
        trivial: usize,
        start: Start,
    ) -> Result<(), SecularError> {
        let wanted = 2 * angles.len();
        let trivial = trivial.min(wanted);
        self.begin(form, angles, start);
        if trivial > 0 {
            // In the place of the start next to +1.
            self.put(wanted - 2, self.roots[0]);
            (0..trivial).for_each(|i| self.put(i, C::new(1.0, 0.0)));
        }
        let of_modulus = if start == Start::Beside { LAST } else { SETTLED };
        self.iterate(form, trivial, Last { of_modulus, of_distance: 0.0 });
        self.errors.clear();
        self.errors.resize(trivial, 0.0);
        for i in trivial..wanted {
            if self.paired[i / 2] && i % 2 == 1 {
                self.errors.push(self.errors[i - 1]);
                continue;
            }
            let (error, ended) = self.finish(form, i);
            self.errors.push(error);
            if !ended && start == Start::Beside {
                return Err(SecularError::Incomplete { found: i, wanted });
            }
        }
        let found = self.settled.iter().filter(|settled| **settled).count();
        if found == wanted { Ok(()) } else { Err(SecularError::Incomplete { found, wanted }) }
    }

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

    /// Two for each pole of the upper half plane.
    fn begin(&mut self, form: &Rational, angles: &[f64], start: Start) {
        let Self { roots, paired, order, .. } = self;
        let m = angles.len();
        order.clear();
        order.extend(0..m as u32);
        order.sort_unstable_by(|&a, &b| angles[a as usize].total_cmp(&angles[b as usize]));
        let angle = |place: usize| order.get(place).map_or(PI, |&k| angles[k as usize]);
        let radius = 1.0 - 0.3 / (m as f64 + 1.0);
        roots.clear();
        for place in 0..m {
            let (from, to) = (angle(place), angle(place + 1));
            let beside = if start == Start::Beside { form.beside(order[place] as usize) } else { None };
            if let Some(offset) = beside {
                let gap = if place > 0 { (to - from).min(from - angle(place - 1)) } else { to - from };
                let z = C::from_polar(1.0, from) + offset * (gap / modulus(offset)).min(1.0);
                roots.extend([C::new(z.re, z.im.abs()), C::new(z.re, -z.im.abs())]);
            } else if place + 1 < m || start == Start::Beside {
                // On both halves, off the mirror image, so that pairs may turn real.
                let (middle, tilt) =
                    (0.5 * (from + to), if start == Start::Between { 0.05 * (to - from) } else { 0.0 });
                roots.extend([middle, -middle].map(|angle| C::from_polar(radius, angle + tilt)));
            } else {
                // And next to +1 and −1.
                roots.extend([0.1 * angle(0), PI - 0.1 * (PI - from)].map(|angle| C::from_polar(radius, angle)));
            }
        }
        paired.clear();
        paired.resize(m, start == Start::Beside);
        self.spread();
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

    /// Whether two have ended at one zero, as far as their errors tell.
    pub(crate) fn any_met(&self) -> bool {
        let largest = self.errors.iter().copied().fold(0.0, f64::max);
        let near = all(4.0 * largest * largest);
        self.roots.iter().any(|z| {
            let (x, y) = (all(z.re), all(z.im));
            let met = self.root_re.iter().zip(&self.root_im).map(|(re, im)| {
                let (u, v) = (x - four(*re), y - four(*im));
                (u * u + v * v).simd_le(near).select(ONE, ZERO)
            });
            // Each meets itself.
            total(met.fold(ZERO, |sum, met| sum + met)) > 1.0
        })
    }

    /// Last steps by Newton's method: the error, and whether they end.
    fn finish(&mut self, form: &Rational, i: usize) -> (f64, bool) {
        let mut z = self.roots[i];
        let mut value = form.evaluate(z);
        let least = SETTLED * SETTLED * z.norm_sqr().max(1e-6);
        let mut ended = false;
        for _ in 0..LAST_STEPS {
            let step = value.f / value.slope;
            let zero = 2.0 * f64::EPSILON * value.noise;
            ended = step.norm_sqr() <= least || value.f.norm_sqr() <= zero * zero;
            if step.norm_sqr() <= POLISH * POLISH * z.norm_sqr().max(1e-6) {
                z -= step;
                // Next to a pole even a small step changes the slope, and with it the error.
                value = form.evaluate(z);
            }
            if ended {
                break;
            }
        }
        self.put(i, z);
        if self.paired[i / 2] {
            self.put(i + 1, z.conj());
        }
        // What is left of the way counts where it is more than rounding; and the zero is rounded itself.
        let left = form.doubt(z).max(modulus(value.f));
        (left / modulus(value.slope) + 2.0 * f64::EPSILON * modulus(z), ended)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibrochain_testkit::Random;

    /// f(z) = 1 + Σ ρ/(z−p) + conj. with zeros that are known: two residues are those of Π(z−ζ)/Π(z−p).
    fn with_zeros(zeros: [C; 2], poles: [C; 2]) -> Rational {
        let mut form = Rational::default();
        let [first, second] = [0, 1].map(|k| {
            let (p, other) = (poles[k], poles[1 - k]);
            let above = zeros.iter().fold(C::new(1.0, 0.0), |product, z| product * (p - z) * (p - z.conj()));
            above / ((p - p.conj()) * (p - other) * (p - other.conj()))
        });
        form.pole_re.push([poles[0].re, poles[1].re, 1e100, 1e100]);
        form.pole_im.push([poles[0].im, poles[1].im, 0.0, 0.0]);
        form.residue_re.push([first.re, second.re, 0.0, 0.0]);
        form.residue_im.push([first.im, second.im, 0.0, 0.0]);
        // Of ten products and differences.
        form.residue_error.push([first, second, C::default(), C::default()].map(|r| 10.0 * f64::EPSILON * r.norm()));
        form.pole_error.push([0.0; 4]);
        form
    }

    /// The zero that is told is within its error of the right one; and what is far from a zero is not said to be one.
    #[test]
    fn last_steps_end_at_a_zero_or_say_that_they_do_not() {
        let (mut random, mut ended) = (Random(3), 0);
        for round in 0..300 {
            let mut at = |radius: f64| C::from_polar(radius * random.between(0.8, 1.0), random.between(0.3, 2.8));
            let (zeros, poles) = ([at(1.0), at(1.2)], [at(0.9), at(0.9)]);
            let apart = [zeros[0] - zeros[1], poles[0] - poles[1], zeros[0] - poles[0], zeros[0] - poles[1]];
            if apart.iter().any(|distance| distance.norm() < 0.1) {
                continue;
            }
            let form = with_zeros(zeros, poles);
            let aside = [0.0, 1e-10, 1e-8, 5e-8, 1e-4, 1e-2][round % 6];
            let start = zeros[0] + C::from_polar(aside, random.between(-3.0, 3.0));
            let mut aberth = Aberth { roots: vec![start, start.conj()], paired: vec![true], ..Aberth::default() };
            aberth.spread();
            let (error, settled) = aberth.finish(&form, 0);
            let off = (aberth.roots[0] - zeros[0]).norm();
            assert_eq!(aberth.roots[1], aberth.roots[0].conj());
            assert!(settled == (aside < 1e-6), "{aside:e} {off:e}");
            // Of a step that does not settle the error is one to first order.
            let slack = if settled { 1.001 } else { 2.0 };
            assert!(off <= slack * error && error < 1e-11 + 3.0 * aside, "{aside:e} {off:e} {error:e}");
            ended += usize::from(settled);
        }
        assert!(ended > 100, "{ended}");
    }
}

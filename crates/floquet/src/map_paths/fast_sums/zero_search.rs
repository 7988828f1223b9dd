//! Zeros of a function with simple poles, as large rings have it: nearly all of them lie next to the poles, in between.
//!
//! A search is Newton's method with the poles and the known zeros of the neighbourhood divided out: only what is nearby matters to each
//! other, so that a search costs the same for any number of poles. What is left then is far from the poles or in bad company, and little:
//! Laguerre's method, all poles and all known zeros divided out, so that nothing but missing zeros is there to be found. Each of its steps
//! takes a pass over the poles, which bounds their number.
//!
//! A zero comes with its mirror image on the other side of the real axis: the one above stands for both.

use crate::map_paths::fast_sums::evaluate::Local;
use crate::map_paths::fast_sums::neighbourhood::Nearby;
use crate::map_paths::reversible::residues::Residues;
use nalgebra::Complex;
use vibrochain_lattice::simd::lanes::{Lane, ONE, TWO, ZERO, all, fill, four, total};

type C = Complex<f64>;

/// Poles on either side that are divided out, with the zeros next to them.
pub(crate) const REACH: usize = 12;
/// Steps of one search nearby.
const STEPS: usize = 50;
/// Terms that all searches over the whole ring may add up, those of zeros already known: for 50 000 zeros 2499 steps, whose sums alone took 19 s of a
/// busy processor. Ten times as many would keep a map three minutes at one orbit.
const BUDGET: usize = 250_000_000;
/// Searches over the whole ring that may fail one after the other.
const ATTEMPTS: u32 = 4;
/// No zero.
const NONE: u32 = u32::MAX;

/// A zero by its offset from the pole at `place`, with its mirror image unless it is `real`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Zero {
    pub(crate) place: usize,
    pub(crate) offset: C,
    pub(crate) error: f64,
    pub(crate) real: bool,
}

impl Zero {
    /// It, or it and its mirror image.
    pub(crate) fn number(&self) -> usize {
        if self.real { 1 } else { 2 }
    }
}

/// Zeros that are known; also the work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct ZeroSearch {
    pub(crate) zeros: Vec<Zero>,
    /// Mirror images counted.
    pub(crate) found: usize,
    /// The last zero at each place, and of each zero the one before it.
    heads: Vec<u32>,
    before: Vec<u32>,
    /// Offsets of poles and zeros divided out.
    near_poles: Vec<C>,
    near_known: Vec<C>,
    scratch: Nearby,
    known_re: Vec<Lane>,
    known_im: Vec<Lane>,
}

/// What became of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Attempt {
    Added,
    /// It ended at a zero that was known before.
    Known,
    Lost,
}

impl ZeroSearch {
    /// Forgets all zeros.
    pub(crate) fn begin(&mut self, poles: &Residues) {
        self.zeros.clear();
        self.before.clear();
        self.found = 0;
        self.scratch.forget();
        self.heads.clear();
        self.heads.resize(poles.count(), NONE);
    }

    /// Adds a zero.
    pub(crate) fn note(&mut self, poles: &Residues, zero: Zero) {
        let place = place_at(poles, zero.place, zero.offset.re);
        self.before.push(std::mem::replace(&mut self.heads[place], self.zeros.len() as u32));
        self.found += zero.number();
        self.zeros.push(zero);
    }

    /// Collects offsets of poles and known zeros about the pole at `place`.
    fn surround(&mut self, poles: &Residues, place: usize) {
        let (first, last) = (place.saturating_sub(REACH), (place + REACH).min(self.heads.len() - 1));
        self.near_poles.clear();
        self.near_known.clear();
        for other in first..=last {
            self.near_poles.push(C::new(poles.distance(other, place), 0.0));
        }
        for head in &self.heads[first.saturating_sub(1)..=last] {
            let mut index = *head;
            while let Some(zero) = self.zeros.get(index as usize) {
                let offset = zero.offset + poles.distance(zero.place, place);
                self.near_known.push(offset);
                if !zero.real {
                    self.near_known.push(offset.conj());
                }
                index = self.before[index as usize];
            }
        }
    }

    /// One search, from an offset from the pole at `place`.
    pub(crate) fn nearby(&mut self, poles: &Residues, place: usize, start: C) -> Attempt {
        let (mut place, mut offset) = (place, start);
        let mut scratch = std::mem::take(&mut self.scratch);
        let mut result = Attempt::Lost;
        for _ in 0..3 {
            self.surround(poles, place);
            let left = place.min(self.heads.len().saturating_sub(2));
            let width = poles.distance((left + 1).min(self.heads.len() - 1), left).abs();
            // Known zeros are where a search that has moved on may have ended.
            let is_known = |known: &[C], at: C, part: f64| {
                known.iter().any(|known| (at - known).norm_sqr() <= part * part * width * width)
            };
            if is_known(&self.near_known, offset, 1e-6) {
                result = Attempt::Known;
                break;
            }
            let near = poles.window(place.min(poles.count().saturating_sub(2)), place, &mut scratch);
            let Some(zero) = self.newton(&near, offset) else { break };
            let zero = above(zero);
            let now = place_at(poles, place, zero.re);
            if now.abs_diff(place) <= REACH / 2 {
                let Some((offset, error, real)) = refine(&near, zero) else { break };
                let offset = if real { offset } else { above(offset) };
                // Next to a known zero nothing is left of what it is divided out of.
                result = if is_known(&self.near_known, offset, 1e-9) {
                    Attempt::Known
                } else {
                    self.note(poles, Zero { place, offset, error, real });
                    Attempt::Added
                };
                break;
            }
            offset = zero + poles.distance(place, now);
            place = now;
        }
        self.scratch = scratch;
        result
    }

    /// Newton's method in the neighbourhood; `None` if it leaves it.
    fn newton(&self, near: &Local<'_>, start: C) -> Option<C> {
        let mut offset = start;
        for _ in 0..STEPS {
            let (value, slope) = jet(near, offset)?;
            if value == C::default() {
                return Some(offset);
            }
            let mut log = slope / value;
            self.near_poles.iter().for_each(|pole| log += inverse(offset - pole));
            self.near_known.iter().for_each(|zero| log -= inverse(offset - zero));
            let step = inverse(log);
            if !(step.re.is_finite() && step.im.is_finite()) {
                return None;
            }
            offset -= step;
            // Of second order; next to the axis rounding may leave no more than this.
            if step.norm_sqr() < 1e-20 * offset.norm_sqr() {
                return Some(offset);
            }
        }
        None
    }

    /// Laguerre's method for the polynomial whose zeros are those missing of `wanted`.
    pub(crate) fn anywhere(&mut self, poles: &Residues, wanted: usize) {
        let mut steps = BUDGET / (2 * wanted + 1);
        let mut attempt = 0;
        while self.found < wanted && attempt < ATTEMPTS {
            let missing = wanted - self.found;
            let both = |zero: &Zero| {
                let z = poles.nu(zero.place, zero.offset).complex();
                [z, z.conj()].into_iter().take(zero.number())
            };
            let known: Vec<C> = self.zeros.iter().flat_map(both).collect();
            fill(&mut self.known_re, known.iter().map(|z| z.re), 1e100);
            fill(&mut self.known_im, known.iter().map(|z| z.im), 0.0);
            let rest: f64 = known.iter().map(|nu| nu.re).sum();
            let mean = (poles.sum_of_roots() - rest) / missing as f64;
            let start = C::from_polar(0.5, 1.5 + f64::from(attempt)) + mean;
            let Some(z) = self.laguerre(poles, start, missing, &mut steps) else { return };
            // The last steps are the function's own, from the nearest pole.
            let place = poles.poles().partition_point(|pole| *pole <= z.re).saturating_sub(1);
            let offset = C::new(z.re, z.im.abs()) - poles.poles()[place];
            let mut result = self.nearby(poles, place, offset);
            if result == Attempt::Lost {
                result = self.far_off(poles, place, offset);
            }
            attempt = if result == Attempt::Added { 0 } else { attempt + 1 };
        }
    }

    /// A zero too far off for a neighbourhood, all poles one by one.
    fn far_off(&mut self, poles: &Residues, place: usize, start: C) -> Attempt {
        let mut scratch = std::mem::take(&mut self.scratch);
        poles.distances(place, &mut scratch.distances);
        let refined = refine(&poles.about(&scratch.distances), start);
        self.scratch = scratch;
        let Some((offset, error, real)) = refined else { return Attempt::Lost };
        let offset = if real { offset } else { above(offset) };
        let size = offset.norm();
        let known = |zero: &Zero| (zero.offset + poles.distance(zero.place, place) - offset).norm() <= 1e-9 * size;
        if (offset - start).norm() > 1e-6 * size || self.zeros.iter().any(known) {
            return Attempt::Known;
        }
        self.note(poles, Zero { place, offset, error, real });
        Attempt::Added
    }

    fn laguerre(&self, poles: &Residues, start: C, missing: usize, steps: &mut usize) -> Option<C> {
        let (mut z, n) = (start, missing as f64);
        while *steps > 0 {
            *steps -= 1;
            let (mut log, mut slope) = logarithmic(poles, z);
            let mut sums = [ZERO; 4];
            for (re, im) in self.known_re.iter().zip(&self.known_im) {
                let (u, v) = (all(z.re) - four(*re), all(z.im) - four(*im));
                let scale = ONE / (u * u + v * v);
                let (a, b) = (u * scale, -v * scale);
                let terms = [a, b, a * a - b * b, TWO * a * b];
                sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
            }
            let sum = |i: usize| C::new(total(sums[i]), total(sums[i + 1]));
            log -= sum(0);
            slope += sum(2);
            let root = ((log * log + slope * n) * (1.0 - n)).sqrt();
            let (plus, minus) = (log + root, log - root);
            let step = inverse(if plus.norm_sqr() > minus.norm_sqr() { plus } else { minus }) * n;
            if !(step.re.is_finite() && step.im.is_finite()) {
                return None;
            }
            z -= step;
            // Of third order.
            if step.norm() < 1e-6 * z.im.abs().max(1e-6) {
                return Some(z);
            }
        }
        None
    }
}

/// Value and derivative; `None` where the field of far poles is not good.
fn jet(near: &Local<'_>, offset: C) -> Option<(C, C)> {
    near.holds(offset).then(|| near.complex(offset))
}

/// The one of a zero and its mirror image that stands for both.
fn above(offset: C) -> C {
    C::new(offset.re, offset.im.abs().max(f64::MIN_POSITIVE))
}

/// The last pole, in their order, before an offset from another one; the first one before all.
fn place_at(poles: &Residues, from: usize, offset: f64) -> usize {
    let last = poles.count() - 1;
    let mut place = from.min(last);
    while place > 0 && offset < poles.distance(place, from) {
        place -= 1;
    }
    while place < last && offset > poles.distance(place + 1, from) {
        place += 1;
    }
    place
}

/// The logarithmic derivative of the polynomial F·Π(ν−d), and its own derivative.
fn logarithmic(poles: &Residues, nu: C) -> (C, C) {
    let (x, y) = (all(nu.re), all(nu.im));
    let mut sums = [ZERO; 10];
    for (residue, pole) in poles.whole.charges[0].iter().zip(&poles.poles) {
        let (u, residue) = (x - four(*pole), four(*residue));
        let scale = ONE / (u * u + y * y);
        // 1/(ν−d), its square and cube
        let (a, b) = (u * scale, -y * scale);
        let (a2, b2) = (a * a - b * b, TWO * a * b);
        let (a3, b3) = (a2 * a - b2 * b, a2 * b + b2 * a);
        let terms = [residue * a, residue * b, residue * a2, residue * b2, residue * a3, residue * b3, a, b, a2, b2];
        // What pads a group is far away, but not to be counted among the poles.
        sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
    }
    let sum = |i: usize| C::new(total(sums[i]), total(sums[i + 1]));
    let (value, slope, half_bend) = (sum(0), -sum(2), sum(4));
    let ratio = slope / value;
    (ratio + sum(6), half_bend * 2.0 / value - ratio * ratio - sum(8))
}

/// Last steps without others in the way, and what the zero is: its offset, error, and whether it is real; `None` if there is none. Two that
/// rounding cannot tell apart are left as they are.
fn refine(near: &Local<'_>, start: C) -> Option<(C, f64, bool)> {
    let mut offset = start;
    for _ in 0..4 {
        let (value, slope) = jet(near, offset)?;
        let step = value / slope;
        if step.norm() <= 2.0 * f64::EPSILON * offset.norm() {
            break;
        }
        // Two zeros close to each other: the iteration knows better.
        if step.norm() < 1e-3 * offset.im.abs().max(1e-3 * offset.norm()) {
            offset -= step;
        }
    }
    let (value, slope) = jet(near, offset)?;
    let (rounding, noise) = (near.rounding(offset), near.noise(offset));
    let error = noise / slope.norm();
    if !error.is_finite() || value.norm() > 1e3 * rounding {
        return None;
    }
    // Of the function as it has been worked out; that it may have an error itself does not matter here.
    let reach = 4.0 * (rounding / slope.norm() + f64::EPSILON * offset.norm());
    let foot = C::new(offset.re, 0.0);
    let side = |at: C| jet(near, at).map(|(value, _)| value.re > 0.0);
    let crosses = || side(foot - reach) != side(foot + reach);
    if (offset - foot).norm() <= reach && crosses() {
        return Some((foot, error, true));
    }
    Some((offset, error, false))
}

pub(crate) fn inverse(z: C) -> C {
    let scale = 1.0 / (z.re * z.re + z.im * z.im);
    C::new(z.re * scale, -z.im * scale)
}

//! Roots of a large ring that brackets do not show: complex pairs above all, and the two more that a gap may hold now and
//! then. Only roots nearby matter to each other, so that each search costs the same for any number of modes.
//!
//! 1. Newton from the lowest points of |F|, the poles and the known roots of the neighbourhood divided out.
//! 2. The same from above every leaf of the tree over the poles, and from above every gap: a gap between equal signs may hold
//!    three roots, where residues differ much in size.
//! 3. What is left is far from the real axis or in bad company, and little: Laguerre's method, all poles and all known roots
//!    divided out, so that nothing but missing roots is there to be found. Each step takes a pass over the modes, which
//!    bounds their number.

use nalgebra::Complex;

use super::evaluate::Local;
use super::pair::Suspect;
use super::residues::Residues;
use super::root::{Root, Roots};
use vibrochain_breather::lanes::{Lane, ONE, TWO, ZERO, all, fill, four, total};

type C = Complex<f64>;

/// Gaps on either side whose roots and poles are divided out.
const REACH: usize = 12;
/// Steps of one search nearby.
const STEPS: usize = 50;
/// Terms that all searches over the whole ring may add up: a few seconds' worth.
const BUDGET: usize = 500_000_000;

/// Searches over the whole ring that may fail one after the other.
const ATTEMPTS: u32 = 4;

const NONE: u32 = u32::MAX;

/// Work space: which late root is in which gap, and what surrounds the place of a search.
#[derive(Debug, Clone, Default)]
pub(crate) struct Missing {
    /// The last late root of each gap, and of each late root the one before it.
    heads: Vec<u32>,
    before: Vec<u32>,
    /// Offsets of poles and roots divided out.
    poles: Vec<f64>,
    known: Vec<C>,
    negative: Vec<Lane>,
    known_re: Vec<Lane>,
    known_im: Vec<Lane>,
}

impl Missing {
    /// Seeks what `roots` lack of `wanted`, where `gaps` names the first root of every gap.
    pub(crate) fn search(
        &mut self,
        form: &Residues,
        roots: &mut Roots,
        suspects: &mut [Suspect],
        wanted: usize,
        scratch: &mut Vec<Lane>,
    ) {
        self.heads.clear();
        self.heads.resize(wanted, NONE);
        self.before.clear();
        let early = roots.list.len();
        suspects.sort_unstable_by(|a, b| a.closeness.total_cmp(&b.closeness));
        for suspect in suspects.iter() {
            if roots.list.len() >= wanted {
                return;
            }
            let height = suspect.height;
            self.nearby(form, roots, early, (suspect.gap, Complex::new(suspect.t, height)), scratch);
        }
        for leaf in 0..form.leaves.len() {
            for part in [0.4, 0.15] {
                if roots.list.len() >= wanted {
                    return;
                }
                let (gap, offset, half) = form.above(leaf);
                self.nearby(form, roots, early, (gap, Complex::new(offset, part * half)), scratch);
            }
        }
        for gap in 0..wanted {
            if roots.list.len() >= wanted {
                return;
            }
            let width = form.distance(gap + 1, gap);
            if width > 0.0 {
                self.nearby(form, roots, early, (gap, Complex::new(0.5 * width, width)), scratch);
            }
        }
        self.anywhere(form, roots, early, wanted, scratch);
    }

    /// Collects poles and known roots about the pole at `place`.
    fn surround(&mut self, form: &Residues, roots: &Roots, early: usize, place: usize) {
        let (first, last) = (place.saturating_sub(REACH), (place + REACH).min(self.heads.len() - 1));
        self.poles.clear();
        self.poles.extend((first..=last + 1).map(|other| form.distance(other, place)));
        self.known.clear();
        let from = |root: &Root| root.t + form.distance(root.place, place);
        let range = roots.gaps[first] as usize..roots.gaps[last + 1] as usize;
        self.known.extend(roots.list[range].iter().map(from));
        if first == 0 || last + 1 == self.heads.len() {
            // The roots at and beyond ±1.
            self.known.extend(roots.list[roots.gaps[self.heads.len()] as usize..early].iter().map(from));
        }
        for head in &self.heads[first..=last] {
            let mut index = *head;
            while index != NONE {
                self.known.push(from(&roots.list[early + index as usize]));
                index = self.before[index as usize];
            }
        }
    }

    /// One search near the real axis.
    fn nearby(
        &mut self,
        form: &Residues,
        roots: &mut Roots,
        early: usize,
        (gap, start): (usize, C),
        scratch: &mut Vec<Lane>,
    ) -> Outcome {
        let (mut gap, mut t) = (gap, start);
        for _ in 0..3 {
            self.surround(form, roots, early, gap);
            // Known roots are where a search that has moved on may have ended.
            let close = 1e-12 * form.distance(gap + 1, gap).powi(2);
            if self.known.iter().any(|known| (t - known).norm_sqr() <= close) {
                return Outcome::Known;
            }
            let local = form.window(gap, gap, scratch);
            let Some(root) = self.newton(local, t) else { return Outcome::Lost };
            let now = self.gap_of(form, gap, root.re);
            if now.abs_diff(gap) <= REACH / 2 {
                let found = settle(local, root);
                // Next to a known root nothing is left of what it is divided out of.
                let again = |known: &C| found.is_some_and(|(t, _)| (t - known).norm_sqr() <= 1e-6 * close);
                if self.known.iter().any(again) {
                    return Outcome::Known;
                }
                return self.add(form, roots, gap, found);
            }
            t = root + form.distance(gap, now);
            gap = now;
        }
        Outcome::Lost
    }

    /// The gap at an offset from the pole at `place`.
    fn gap_of(&self, form: &Residues, place: usize, t: f64) -> usize {
        let mut gap = place.min(self.heads.len() - 1);
        while gap > 0 && t < form.distance(gap, place) {
            gap -= 1;
        }
        while gap + 1 < self.heads.len() && t > form.distance(gap + 1, place) {
            gap += 1;
        }
        gap
    }

    /// Newton's method in the neighbourhood; `None` if it leaves it.
    fn newton(&self, local: Local<'_>, start: C) -> Option<C> {
        let mut t = start;
        for _ in 0..STEPS {
            let (value, slope) = local.complex(t);
            if value == C::default() {
                return Some(t);
            }
            let mut log = slope / value;
            self.poles.iter().for_each(|pole| log += inverse(t - pole));
            self.known.iter().for_each(|root| log -= inverse(t - root));
            let step = inverse(log);
            t -= step;
            let left = !(step.re.is_finite() && step.im.is_finite()) || local.far.is_some_and(|far| !far.holds(t));
            if left {
                return None;
            }
            // Of second order; next to the real axis rounding may leave no more than this.
            if step.norm_sqr() < 1e-20 * t.norm_sqr() {
                return Some(t);
            }
        }
        None
    }

    /// Adds what a search has found: one real root, or a pair.
    fn add(&mut self, form: &Residues, roots: &mut Roots, place: usize, found: Option<(C, f64)>) -> Outcome {
        let Some((t, error)) = found else { return Outcome::Lost };
        let gap = self.gap_of(form, place, t.re);
        let pair = [t, t.conj()];
        for t in pair.into_iter().take(if t.im == 0.0 { 1 } else { 2 }) {
            self.before.push(self.heads[gap]);
            self.heads[gap] = self.before.len() as u32 - 1;
            roots.list.push(Root { place, t, error });
        }
        Outcome::Added
    }

    /// Laguerre's method for the polynomial whose zeros are the missing roots.
    fn anywhere(&mut self, form: &Residues, roots: &mut Roots, early: usize, wanted: usize, scratch: &mut Vec<Lane>) {
        let mut steps = BUDGET / (2 * wanted + 1);
        self.negative.clear();
        self.negative.extend(form.poles.iter().map(|lane| lane.map(|d| -d)));
        let mut attempt = 0;
        while roots.list.len() < wanted && attempt < ATTEMPTS {
            let missing = wanted - roots.list.len();
            let nu = |root: &Root| form.nu(root.place, root.t).complex();
            fill(&mut self.known_re, roots.list.iter().map(|root| nu(root).re), 1e100);
            fill(&mut self.known_im, roots.list.iter().map(|root| root.t.im), 0.0);
            let rest: f64 = roots.list.iter().map(|root| nu(root).re).sum();
            let centre = (form.sum_of_roots() - rest) / missing as f64;
            let start = Complex::from_polar(0.5, 1.5 + f64::from(attempt)) + centre;
            let Some(z) = self.laguerre(form, start, missing, &mut steps) else { return };
            // The last steps are F's own, from the nearest pole.
            let gap = form.poles().partition_point(|pole| *pole <= z.re).saturating_sub(1).min(wanted - 1);
            let t = Complex::new(z.re - form.poles()[gap], z.im.abs());
            let mut outcome = self.nearby(form, roots, early, (gap, t), scratch);
            if outcome == Outcome::Lost {
                // Too far off for the neighbourhood: all poles one by one.
                form.distances(gap, scratch);
                let found = settle(form.about(scratch), t);
                if found.is_some_and(|(root, _)| (root - t).norm() <= 1e-6 * t.norm()) {
                    outcome = self.add(form, roots, gap, found);
                }
            }
            attempt = if outcome == Outcome::Added { 0 } else { attempt + 1 };
        }
    }

    fn laguerre(&self, form: &Residues, start: C, missing: usize, steps: &mut usize) -> Option<C> {
        let (mut z, n) = (start, missing as f64);
        while *steps > 0 {
            *steps -= 1;
            let (log, slope) = self.logarithmic(form, z);
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

    /// The logarithmic derivative of Π(z−d)F(z)/Π(z−ν) and its derivative, over the whole ring.
    fn logarithmic(&self, form: &Residues, z: C) -> (C, C) {
        let (x, y) = (all(z.re), all(z.im));
        let mut sums = [ZERO; 10];
        for (residue, negative) in form.residues.iter().zip(&self.negative) {
            let (u, residue) = (four(*negative) + x, four(*residue));
            let scale = ONE / (u * u + y * y);
            // 1/(z−d), its square and cube
            let (a, b) = (u * scale, -y * scale);
            let (a2, b2) = (a * a - b * b, TWO * a * b);
            let (a3, b3) = (a2 * a - b2 * b, a2 * b + b2 * a);
            let terms =
                [residue * a, residue * b, residue * a2, residue * b2, residue * a3, residue * b3, a, b, a2, b2];
            // What pads a group is far away, but not to be counted among the poles.
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        for (re, im) in self.known_re.iter().zip(&self.known_im) {
            let (u, v) = (x - four(*re), y - four(*im));
            let scale = ONE / (u * u + v * v);
            let (a, b) = (u * scale, -v * scale);
            sums[6] -= a;
            sums[7] -= b;
            sums[8] -= a * a - b * b;
            sums[9] -= TWO * a * b;
        }
        let sum = |i: usize| Complex::new(total(sums[i]), total(sums[i + 1]));
        let (value, slope, half_bend) = (sum(0), -sum(2), sum(4));
        let ratio = slope / value;
        (ratio + sum(6), half_bend * 2.0 / value - ratio * ratio - sum(8))
    }
}

/// What became of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Outcome {
    Added,
    /// It ended at a root that was known before.
    Known,
    Lost,
}

fn inverse(z: C) -> C {
    let scale = 1.0 / (z.re * z.re + z.im * z.im);
    Complex::new(z.re * scale, -z.im * scale)
}

/// Two last steps without others in the way, and what the root is: real, one of a pair (the upper one), or `None` if there is no
/// root. Two that rounding cannot tell apart are left as they are.
fn settle(local: Local<'_>, start: C) -> Option<(C, f64)> {
    let mut t = start;
    for _ in 0..4 {
        let (value, slope) = local.complex(t);
        let step = value / slope;
        if step.norm() <= 2.0 * f64::EPSILON * t.norm() {
            break;
        }
        // Two roots close to each other: the iteration knows better.
        if step.norm() < 1e-3 * t.im.abs().max(1e-3 * t.norm()) {
            t -= step;
        }
    }
    let (value, slope) = local.complex(t);
    let rounding = local.rounding(t);
    let error = local.noise(t) / slope.norm();
    if !error.is_finite() || value.norm() > 1e3 * rounding {
        return None;
    }
    // Of F as it has been worked out; that F may have an error itself does not matter here.
    let reach = 4.0 * (rounding / slope.norm() + f64::EPSILON * t.norm());
    if t.im.abs() <= reach && (local.value(t.re - reach) > 0.0) != (local.value(t.re + reach) > 0.0) {
        return Some((Complex::new(t.re, 0.0), error));
    }
    Some((Complex::new(t.re, t.im.abs().max(f64::MIN_POSITIVE)), error))
}

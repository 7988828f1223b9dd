//! All zeros of f(z) = 1 + A(ν) − B(ν)/z of a large ring (see [`super::forced_large`]), most of them next to the unit circle
//! between the poles.
//!
//! They are sought in θ, z = e^{iθ}, one start inside each gap between poles, poles and known zeros of the neighbourhood
//! divided out; what is missing then from farther inside; and the few that are far from the circle by Laguerre's method, all
//! that is known divided out. Zeros and poles come in pairs θ, −θ̄, of which that with 0 ≤ Re θ ≤ π is kept.

use nalgebra::Complex;

use super::circle::{CircleForm, I, Local, Value, inverse, whole};
use super::doubt::Doubt;
use vibrochain_breather::lanes::Lane;

type C = Complex<f64>;
const PI: f64 = std::f64::consts::PI;

/// Gaps on either side whose zeros and poles are divided out.
const REACH: usize = 12;
/// Steps of one search.
const STEPS: usize = 50;
/// Terms that all searches over the whole ring may add up.
const BUDGET: usize = 200_000_000;
/// Searches over the whole ring that may fail one after the other.
const ATTEMPTS: u32 = 4;
const NONE: u32 = u32::MAX;

/// A zero by its offset in θ from the pole at `place`; `real` means z real.
#[derive(Debug, Clone, Copy)]
struct Root {
    place: usize,
    tau: C,
    z: C,
    error: f64,
    real: bool,
    before: u32,
}

/// The zeros; also the work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct CircleRoots {
    list: Vec<Root>,
    found: usize,
    heads: Vec<u32>,
    near_poles: Vec<C>,
    near_known: Vec<C>,
    scratch: Vec<Lane>,
    /// All 2m of them and their errors.
    pub(crate) values: Vec<C>,
    pub(crate) errors: Vec<f64>,
}

/// What became of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Outcome {
    Added,
    /// It ended at a zero that was known before.
    Known,
    Lost,
}

impl CircleRoots {
    /// All zeros of f, of which the first `trivial` are known to be 1.
    pub(crate) fn solve(&mut self, form: &CircleForm, trivial: usize) -> Result<(), Doubt> {
        let m = form.poles.len();
        let wanted = 2 * m;
        self.list.clear();
        self.found = 0;
        self.heads.clear();
        self.heads.resize(m + 1, NONE);
        if let Some(last) = form.poles.last() {
            let tau = C::new(-last.angle, 0.0);
            let one = Root { place: m - 1, tau, z: C::new(1.0, 0.0), error: 0.0, real: true, before: NONE };
            (0..trivial).for_each(|_| self.note(m, one));
        }
        // One start inside each gap, then farther inside.
        for depth in [0.12, 0.8, 3.0] {
            for gap in 0..=m {
                if self.found >= wanted {
                    break;
                }
                let place = gap.saturating_sub(1);
                let left = if gap == 0 { PI } else { form.poles[gap - 1].angle };
                let right = form.poles.get(gap).map_or(0.0, |pole| pole.angle);
                let width = (left - right).abs().max(1e-12);
                let off = if gap == 0 || gap == m { 0.13 } else { 0.47 };
                let middle = if gap == 0 { left - off * width } else { right + off * width };
                let start = C::new(middle - form.poles[place].angle, depth * width);
                self.nearby(form, place, start);
            }
        }
        self.anywhere(form, wanted);
        self.values.clear();
        self.errors.clear();
        for root in &self.list {
            self.values.push(root.z);
            self.errors.push(root.error);
            if !root.real {
                self.values.push(root.z.conj());
                self.errors.push(root.error);
            }
        }
        let found = self.values.len();
        if found == wanted { Ok(()) } else { Err(Doubt::Incomplete { found, wanted }) }
    }

    /// |f₂/f′| of another function with the same poles at all zeros, in the order of `values`; both functions are evaluated alike,
    /// so that their difference is good.
    pub(crate) fn moved(&self, form: &CircleForm, other: &CircleForm) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.values.len());
        let mut scratch = Vec::new();
        for root in &self.list {
            let local = form.leaf(root.place).zip(other.leaf(root.place)).map(|(leaf, moved)| {
                form.distances(root.place, leaf, &mut scratch);
                let local = Local { pole: &form.poles[root.place], leaf, distances: &scratch };
                let at = local.place(root.tau);
                let there = Local { pole: &other.poles[root.place], leaf: moved, distances: &scratch };
                local.holds(at.0).then(|| {
                    let here = local.value(at);
                    (there.value(at).f - here.f).norm() / here.slope.norm() * root.z.norm()
                })
            });
            let by = local.flatten().unwrap_or_else(|| {
                let [here, slope, _] = whole(form, root.z);
                (whole(other, root.z)[0] - here).norm() / slope.norm()
            });
            out.push(by);
            if !root.real {
                out.push(by);
            }
        }
        out
    }

    /// Collects offsets of poles and known zeros about the pole at `place`, mirror images included.
    fn surround(&mut self, form: &CircleForm, place: usize) {
        self.near_poles.clear();
        self.near_known.clear();
        let m = form.poles.len();
        let origin = form.poles[place].angle;
        let first = place.saturating_sub(REACH);
        let last = (place + REACH).min(m - 1);
        // Mirror images are as near as the ends are.
        let (low, high) = (place < REACH, place + REACH >= m);
        for pole in &form.poles[first..=last] {
            self.near_poles.push(C::new(pole.angle - origin, 0.0));
            if low {
                self.near_poles.push(C::new(2.0 * PI - pole.angle - origin, 0.0));
            }
            if high {
                self.near_poles.push(C::new(-pole.angle - origin, 0.0));
            }
        }
        for gap in first..=last + 1 {
            let mut index = self.heads[gap];
            while let Some(root) = self.list.get(index as usize) {
                let angle = form.poles[root.place].angle;
                let theta = root.tau + (angle - origin);
                self.near_known.push(theta);
                if !root.real && low {
                    self.near_known.push(C::new(2.0 * (PI - origin) - theta.re, theta.im));
                }
                if !root.real && high {
                    self.near_known.push(C::new(-2.0 * origin - theta.re, theta.im));
                }
                index = root.before;
            }
        }
    }

    /// One search in the neighbourhood of a pole.
    fn nearby(&mut self, form: &CircleForm, place: usize, start: C) -> Outcome {
        let (mut place, mut tau) = (place, start);
        let mut scratch = std::mem::take(&mut self.scratch);
        let mut outcome = Outcome::Lost;
        for _ in 0..3 {
            self.surround(form, place);
            let left = place.min(form.poles.len().saturating_sub(2));
            let width = form.poles[left].angle - form.poles.get(left + 1).map_or(0.0, |next| next.angle);
            if self.near_known.iter().any(|known| (tau - known).norm_sqr() <= 1e-12 * width * width) {
                outcome = Outcome::Known;
                break;
            }
            let Some(leaf) = form.leaf(place) else { break };
            form.distances(place, leaf, &mut scratch);
            let local = Local { pole: &form.poles[place], leaf, distances: &scratch };
            let Some(root) = self.newton(&local, tau) else { break };
            // The nearest pole, on this side of the mirror.
            let mut theta = root.re + form.poles[place].angle;
            let mirrored = !(0.0..=PI).contains(&theta);
            if mirrored {
                theta = if theta < 0.0 { -theta } else { 2.0 * PI - theta };
            }
            let gap = form.poles.partition_point(|pole| pole.angle > theta);
            let now = gap.saturating_sub(1);
            let here = C::new(if mirrored { theta - form.poles[place].angle } else { root.re }, root.im);
            if now.abs_diff(place) <= REACH / 2 {
                outcome = self.settle(&local, place, (gap, width), here);
                break;
            }
            tau = here + (form.poles[place].angle - form.poles[now].angle);
            place = now;
        }
        self.scratch = scratch;
        outcome
    }

    fn newton(&self, local: &Local<'_>, start: C) -> Option<C> {
        let mut tau = start;
        for _ in 0..STEPS {
            let at = local.place(tau);
            if !local.holds(at.0) {
                return None;
            }
            let Value { f, slope } = local.value(at);
            if f == C::default() {
                return Some(tau);
            }
            let mut log = slope / f;
            self.near_poles.iter().for_each(|pole| log += inverse(tau - pole));
            self.near_known.iter().for_each(|root| log -= inverse(tau - root));
            let step = inverse(log);
            if !(step.re.is_finite() && step.im.is_finite()) {
                return None;
            }
            tau -= step;
            if step.norm_sqr() < 1e-20 * tau.norm_sqr() {
                return Some(tau);
            }
        }
        None
    }

    /// Last steps without others in the way, and the zero is noted: on the real axis if f changes its sign there.
    fn settle(&mut self, local: &Local<'_>, place: usize, (gap, width): (usize, f64), start: C) -> Outcome {
        let mut tau = start;
        for _ in 0..4 {
            let Value { f, slope } = local.value(local.place(tau));
            let step = f / slope;
            if step.norm() <= 2.0 * f64::EPSILON * tau.norm() {
                break;
            }
            // Two zeros close to each other: the iteration knows better.
            if step.norm() < 1e-6 * tau.norm() {
                tau -= step;
            }
        }
        // Next to a known zero nothing is left of what it is divided out of.
        if self.near_known.iter().any(|known| (tau - known).norm_sqr() <= 1e-18 * width * width) {
            return Outcome::Known;
        }
        let at = local.place(tau);
        let Value { f, slope } = local.value(at);
        let (rounding, noise) = local.errors(at);
        let error = noise / slope.norm();
        if !error.is_finite() || f.norm() > 1e3 * rounding {
            return Outcome::Lost;
        }
        let angle = local.pole.angle;
        let end = if angle + tau.re < 0.5 * PI { 0.0 } else { PI };
        let off = (angle + tau.re - end).abs();
        let reach = 4.0 * (rounding / slope.norm() + f64::EPSILON * (tau.norm() + 1.0));
        let mut real = false;
        if off <= reach {
            let on_axis = |im: f64| local.value(local.place(C::new(end - angle, im))).f.re > 0.0;
            real = on_axis(tau.im - reach) != on_axis(tau.im + reach);
        }
        if real {
            tau.re = end - angle;
        }
        let modulus = (-tau.im).exp();
        let z = if real {
            C::new(if end == 0.0 { modulus } else { -modulus }, 0.0)
        } else {
            C::new(local.pole.d, local.pole.sine) * (I * tau).exp()
        };
        self.note(gap, Root { place, tau, z, error: error * modulus, real, before: NONE });
        Outcome::Added
    }

    fn note(&mut self, gap: usize, root: Root) {
        let before = std::mem::replace(&mut self.heads[gap], self.list.len() as u32);
        self.found += if root.real { 1 } else { 2 };
        self.list.push(Root { before, ..root });
    }

    /// Laguerre's method for the polynomial whose zeros are the missing ones.
    fn anywhere(&mut self, form: &CircleForm, wanted: usize) {
        let mut steps = BUDGET / (2 * wanted + 1);
        let mut attempt = 0;
        while self.found < wanted && attempt < ATTEMPTS {
            let missing = wanted - self.found;
            let start = C::from_polar(0.3 + 0.2 * f64::from(attempt), 0.9 + 1.3 * f64::from(attempt));
            let Some(z) = self.laguerre(form, start, missing, &mut steps) else { return };
            let z = C::new(z.re, z.im.abs());
            let theta = -I * z.ln();
            let gap = form.poles.partition_point(|pole| pole.angle > theta.re);
            let place = gap.saturating_sub(1);
            let mut outcome = self.nearby(form, place, theta - form.poles[place].angle);
            if outcome == Outcome::Lost {
                outcome = self.far_off(form, gap, z);
            }
            attempt = if outcome == Outcome::Added { 0 } else { attempt + 1 };
        }
    }

    /// A zero too far off for a neighbourhood, all poles one by one.
    fn far_off(&mut self, form: &CircleForm, gap: usize, start: C) -> Outcome {
        let mut z = start;
        for _ in 0..3 {
            let [f, slope, _] = whole(form, z);
            let step = f / slope;
            if step.norm() < 1e-3 * z.norm().max(1e-6) {
                z -= step;
            }
        }
        let [f, slope, _] = whole(form, z);
        let (mut size, mut noise) = (1.0, 0.0);
        for pole in &form.poles {
            let p = C::new(pole.d, pole.sine);
            let (a, b) = ((z - p).norm(), (z - p.conj()).norm());
            let modulus = pole.residue.norm();
            size += modulus * (1.0 / a + 1.0 / b);
            noise += pole.error * (1.0 / a + 1.0 / b) + pole.shift * modulus * (1.0 / (a * a) + 1.0 / (b * b));
        }
        let rounding = 8.0 * f64::EPSILON * size;
        let error = (rounding + noise) / slope.norm();
        if !error.is_finite() || f.norm() > 1e3 * rounding {
            return Outcome::Lost;
        }
        let reach = 4.0 * (rounding / slope.norm() + f64::EPSILON);
        let on_axis = |x: f64| whole(form, C::new(x, 0.0))[0].re > 0.0;
        let real = z.im.abs() <= reach && on_axis(z.re - reach) != on_axis(z.re + reach);
        let z = if real { C::new(z.re, 0.0) } else { C::new(z.re, z.im.abs()) };
        if self.list.iter().any(|known| (known.z - z).norm() <= 1e-9 * z.norm()) {
            return Outcome::Known;
        }
        let place = gap.saturating_sub(1);
        let tau = if z.norm() > 0.0 { -I * z.ln() - form.poles[place].angle } else { C::new(0.0, 1e3) };
        self.note(gap, Root { place, tau, z, error, real, before: NONE });
        Outcome::Added
    }

    fn laguerre(&self, form: &CircleForm, start: C, missing: usize, steps: &mut usize) -> Option<C> {
        let (mut z, n) = (start, missing as f64);
        while *steps > 0 {
            *steps -= 1;
            let [f, slope, bend] = whole(form, z);
            let ratio = slope / f;
            let (mut log, mut log_slope) = (ratio, bend / f - ratio * ratio);
            for pole in &form.poles {
                let p = C::new(pole.d, pole.sine);
                for inverse in [inverse(z - p), inverse(z - p.conj())] {
                    log += inverse;
                    log_slope -= inverse * inverse;
                }
            }
            let mut known = |w: C| {
                let inverse = inverse(z - w);
                log -= inverse;
                log_slope += inverse * inverse;
            };
            for root in &self.list {
                known(root.z);
                if !root.real {
                    known(root.z.conj());
                }
            }
            let root = ((log * log + log_slope * n) * (1.0 - n)).sqrt();
            let (plus, minus) = (log + root, log - root);
            let step = inverse(if plus.norm_sqr() > minus.norm_sqr() { plus } else { minus }) * n;
            if !(step.re.is_finite() && step.im.is_finite()) {
                return None;
            }
            z -= step;
            // Of third order.
            if step.norm() < 1e-8 {
                return Some(z);
            }
        }
        None
    }
}

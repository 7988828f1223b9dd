//! All zeros of f(z) = 1 + A(ν) − B(ν)/z of a large ring (see [`super::forced_large`]), most of them next to the unit circle
//! between the poles.
//!
//! They are sought in θ, z = e^{iθ}, one start inside each gap between poles, poles and known zeros of the neighbourhood
//! divided out; what is missing then from farther inside; and the few that are far from the circle by Laguerre's method, all
//! that is known divided out. Zeros and poles come in pairs θ, −θ̄, of which that with 0 ≤ Re θ ≤ π is kept.

use nalgebra::Complex;

use super::cauchy::{Nodal, Tree, complex_series, derivative};
use super::doubt::Doubt;
use super::lanes::{Lane, ONE, TWO, ZERO, all, fill, four, total};

type C = Complex<f64>;
const PI: f64 = std::f64::consts::PI;
const I: C = Complex::new(0.0, 1.0);

/// Gaps on either side whose zeros and poles are divided out.
const REACH: usize = 12;
/// Steps of one search.
const STEPS: usize = 50;
/// Terms that all searches over the whole ring may add up.
const BUDGET: usize = 200_000_000;
/// Searches over the whole ring that may fail one after the other.
const ATTEMPTS: u32 = 4;
const NONE: u32 = u32::MAX;

/// A pole e^{iφ}, 0 < φ < π.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CirclePole {
    cos: f64,
    sin: f64,
    /// cos φ, sin φ, φ
    d: f64,
    sine: f64,
    angle: f64,
    residue: C,
    /// Errors of ρ and of φ.
    error: f64,
    shift: f64,
}

impl CirclePole {
    /// From cos, sin(φ/2) ≥ 0; the conjugate is taken if `imaginary` < 0.
    pub(crate) fn new(cos: f64, sin: f64, imaginary: f64, residue: C, error: f64, shift: f64) -> Self {
        let residue = if imaginary < 0.0 { residue.conj() } else { residue };
        let (d, sine) = ((cos - sin) * (cos + sin), 2.0 * sin * cos);
        Self { cos, sin, d, sine, angle: 2.0 * sin.atan2(cos), residue, error, shift }
    }

    fn charges(&self) -> [f64; 2] {
        [self.residue.re, self.residue.re * self.d + self.residue.im * self.sine]
    }
}

/// f, its poles by rising d.
#[derive(Debug, Clone, Default)]
pub(crate) struct CircleForm {
    pub(crate) poles: Vec<CirclePole>,
    leaves: Vec<Leaf>,
}

/// The gaps of one leaf of the tree over the poles, each named by the place of its left pole.
#[derive(Debug, Clone)]
struct Leaf {
    end: usize,
    a: Vec<Lane>,
    b: Vec<Lane>,
    cos: Vec<Lane>,
    sin: Vec<Lane>,
    errors: Vec<Lane>,
    shifts: Vec<Lane>,
    middle: f64,
    scale: f64,
    /// Fields of far poles: A, B and their derivatives.
    far: [Nodal; 4],
    noise: f64,
    rounding: f64,
}

/// f and df/dθ, and bounds of the errors of f: from rounding alone, and in all.
struct Value {
    f: C,
    slope: C,
}

impl CircleForm {
    /// Divides the poles into leaves.
    pub(crate) fn divide(&mut self) {
        let points: Vec<f64> = self.poles.iter().map(|pole| pole.d).collect();
        let charges: Vec<[f64; 3]> = self
            .poles
            .iter()
            .map(|pole| {
                let [a, b] = pole.charges();
                [a, b, pole.error]
            })
            .collect();
        let total_error: f64 = self.poles.iter().map(|pole| pole.error).sum();
        self.leaves.clear();
        for field in Tree::new(&points, false).fields(&points, &charges, &Tree::new(&points, true)) {
            let places: Vec<usize> = field.near.iter().flat_map(Clone::clone).collect();
            let lanes = |value: &dyn Fn(&CirclePole) -> f64, pad: f64| {
                let mut lanes = Vec::new();
                fill(&mut lanes, places.iter().map(|&place| value(&self.poles[place])), pad);
                lanes
            };
            let size = |channel: usize| field.far[channel].iter().map(|c: &f64| c.abs()).sum::<f64>();
            let rounding = 1e-14 * (size(0) + size(1));
            self.leaves.push(Leaf {
                end: field.targets.end,
                a: lanes(&|pole| pole.charges()[0], 0.0),
                b: lanes(&|pole| pole.charges()[1], 0.0),
                cos: lanes(&|pole| pole.cos, 1e50),
                sin: lanes(&|pole| pole.sin, 1e50),
                errors: lanes(&|pole| pole.error, 0.0),
                shifts: lanes(&|pole| pole.shift * pole.residue.norm(), 0.0),
                middle: field.middle,
                scale: if field.half > 0.0 { 1.0 / field.half } else { 0.0 },
                far: [field.far[0], field.far[1], derivative(&field.far[0]), derivative(&field.far[1])],
                noise: rounding + 2.0 * (field.far[2][0].abs() + total_error),
                rounding,
            });
        }
    }

    fn leaf(&self, place: usize) -> Option<&Leaf> {
        self.leaves.get(self.leaves.partition_point(|leaf| leaf.end <= place)).or(self.leaves.last())
    }

    /// Distances d − d_l from the pole at `place` into `out`.
    fn distances(&self, place: usize, leaf: &Leaf, out: &mut Vec<Lane>) {
        let own = &self.poles[place];
        out.clear();
        if own.d < 0.0 {
            let c = all(own.cos);
            out.extend(leaf.cos.iter().map(|other| (TWO * (c - four(*other)) * (c + four(*other))).to_array()));
        } else {
            let s = all(own.sin);
            out.extend(leaf.sin.iter().map(|other| (TWO * (four(*other) - s) * (four(*other) + s)).to_array()));
        }
    }
}

/// f about one pole.
struct Local<'a> {
    pole: &'a CirclePole,
    leaf: &'a Leaf,
    distances: &'a [Lane],
}

impl Local<'_> {
    /// ν − d, e^{−iθ} and sin θ at θ = φ + τ.
    fn place(&self, tau: C) -> (C, C, C) {
        let half = tau * 0.5;
        let (s, c) = (half.sin(), half.cos());
        let between = c * self.pole.sine + s * self.pole.d;
        let t = -(between * s) * 2.0;
        let (sin, cos) = (tau.sin(), tau.cos());
        let sine = cos * self.pole.sine + sin * self.pole.d;
        let inverse = (-I * tau).exp() * C::new(self.pole.d, -self.pole.sine);
        (t, inverse, sine)
    }

    /// The far field's polynomial is good there.
    fn holds(&self, t: C) -> bool {
        let u = (t + (self.pole.d - self.leaf.middle)) * self.leaf.scale;
        u.re.abs() <= 1.2 && u.im.abs() <= 0.5
    }

    fn value(&self, (t, inverse, sine): (C, C, C)) -> Value {
        let (x, y) = (all(t.re), all(t.im));
        let mut sums = [ZERO; 8];
        for ((a, b), distance) in self.leaf.a.iter().zip(&self.leaf.b).zip(self.distances) {
            let (u, a, b) = (four(*distance) + x, four(*a), four(*b));
            let scale = ONE / (u * u + y * y);
            let (re, im) = (u * scale, -y * scale);
            let (re2, im2) = (re * re - im * im, TWO * re * im);
            let terms = [a * re, a * im, b * re, b * im, a * re2, a * im2, b * re2, b * im2];
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        let sum = |i: usize| C::new(total(sums[i]), total(sums[i + 1]));
        let u = (t + (self.pole.d - self.leaf.middle)) * self.leaf.scale;
        let far = |i: usize| complex_series(&self.leaf.far[i], u);
        let (a, b) = (sum(0) + far(0), sum(2) + far(1));
        let (a_slope, b_slope) = (far(2) * self.leaf.scale - sum(4), far(3) * self.leaf.scale - sum(6));
        let f = a - b * inverse + 1.0;
        Value { f, slope: I * b * inverse - sine * (a_slope - b_slope * inverse) }
    }

    /// Errors of f: of the sums alone, and of residues and poles, too.
    fn errors(&self, (t, inverse, sine): (C, C, C)) -> (f64, f64) {
        let (mut size, mut noise) = (ZERO, ZERO);
        let (x, square) = (all(t.re), all(t.im * t.im));
        let (tilt, slide) = (all(inverse.norm()), all(sine.norm()));
        let leaf = self.leaf;
        let lanes = leaf.a.iter().zip(&leaf.b).zip(leaf.errors.iter().zip(&leaf.shifts)).zip(self.distances);
        for (((a, b), (error, shift)), distance) in lanes {
            let u = four(*distance) + x;
            let near = ONE / (u * u + square).sqrt();
            size += (four(*a).abs() + four(*b).abs() * tilt) * near;
            noise += (ONE + tilt) * (four(*error) + four(*shift) * slide * near) * near;
        }
        let rounding = 4.0 * f64::EPSILON * (1.0 + total(size)) + leaf.rounding * (1.0 + inverse.norm());
        (rounding, rounding + total(noise) + leaf.noise * (1.0 + inverse.norm()))
    }
}

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

fn inverse(z: C) -> C {
    let scale = 1.0 / (z.re * z.re + z.im * z.im);
    C::new(z.re * scale, -z.im * scale)
}

impl CircleRoots {
    /// All zeros of f.
    pub(crate) fn solve(&mut self, form: &CircleForm) -> Result<(), Doubt> {
        let m = form.poles.len();
        let wanted = 2 * m;
        self.list.clear();
        self.found = 0;
        self.heads.clear();
        self.heads.resize(m + 1, NONE);
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

/// f, f′ and f″ in z over all poles.
fn whole(form: &CircleForm, z: C) -> [C; 3] {
    let mut sums = [C::new(1.0, 0.0), C::default(), C::default()];
    for pole in &form.poles {
        let p = C::new(pole.d, pole.sine);
        for (p, residue) in [(p, pole.residue), (p.conj(), pole.residue.conj())] {
            let inverse = inverse(z - p);
            let term = residue * inverse;
            sums[0] += term;
            sums[1] -= term * inverse;
            sums[2] += term * inverse * inverse * 2.0;
        }
    }
    sums
}

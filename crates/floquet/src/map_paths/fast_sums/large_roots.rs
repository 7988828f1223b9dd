//! All zeros of f(z) = 1 + A(ν) − B(ν)/z of a large ring (see [`crate::map_paths::fast_sums::large_general`]), most of them next to the unit circle
//! between the poles.
//!
//! They are sought in θ, z = e^{iθ}: from one start inside each gap between poles, then from farther inside, then anywhere. Zeros and poles
//! come in pairs θ, −θ̄, of which that with 0 ≤ Re θ ≤ π is kept; on Re θ = 0 and π f is real.

use nalgebra::Complex;
use smallvec::SmallVec;

use crate::map_paths::fast_sums::near_circle::{CircleForm, I, NearCircle, whole};
use crate::map_paths::fast_sums::neighbourhood::Nearby;
use crate::map_paths::fast_sums::zero_search::{Near, Poles, REACH, Zero, ZeroSearch, inverse};
use crate::zeros::SecularError;

type C = Complex<f64>;
const PI: f64 = std::f64::consts::PI;

/// The zeros; also the work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct CircleRoots {
    search: ZeroSearch<3>,
    /// All 2m of them and their errors.
    pub(crate) values: Vec<C>,
    pub(crate) errors: Vec<f64>,
}

impl CircleRoots {
    /// All zeros of f, of which the first `trivial` are known to be 1.
    pub(crate) fn solve(&mut self, form: &CircleForm, trivial: usize) -> Result<(), SecularError> {
        let Self { search, values, errors } = self;
        let m = form.poles.len();
        let wanted = 2 * m;
        search.begin(form);
        if let Some(last) = form.poles.last() {
            let one = Zero { place: m - 1, offset: C::new(-last.angle, 0.0), error: 0.0, real: true };
            (0..trivial).for_each(|_| search.note(form, one));
        }
        for depth in [0.12, 0.8, 3.0] {
            for gap in 0..=m {
                if search.found >= wanted {
                    break;
                }
                let place = gap.saturating_sub(1);
                let left = if gap == 0 { PI } else { form.poles[gap - 1].angle };
                let right = form.poles.get(gap).map_or(0.0, |pole| pole.angle);
                let width = (left - right).abs().max(1e-12);
                let off = if gap == 0 || gap == m { 0.13 } else { 0.47 };
                let middle = if gap == 0 { left - off * width } else { right + off * width };
                search.nearby(form, place, C::new(middle - form.poles[place].angle, depth * width));
            }
        }
        search.anywhere(form, wanted);
        values.clear();
        errors.clear();
        for zero in &search.zeros {
            let z = form.variable(zero);
            for z in [z, z.conj()].into_iter().take(zero.number()) {
                values.push(z);
                errors.push(zero.error * z.norm());
            }
        }
        let found = values.len();
        if found == wanted { Ok(()) } else { Err(SecularError::Incomplete { found, wanted }) }
    }

    /// |f₂/f′| of another function with the same poles at all zeros, in the order of `values`; both functions are evaluated alike,
    /// so that their difference is good.
    pub(crate) fn moved(&self, form: &CircleForm, other: &CircleForm) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.values.len());
        let (mut scratch, mut scratch_of_other) = (Nearby::default(), Nearby::default());
        for zero in &self.search.zeros {
            let mut change = |whole: bool| {
                let (here, slope) = Near::value(&form.near(zero.place, whole, &mut scratch)?, zero.offset)?;
                let (there, _) = Near::value(&other.near(zero.place, whole, &mut scratch_of_other)?, zero.offset)?;
                Some((there - here).norm() / slope.norm() * (-zero.offset.im).exp())
            };
            let by = change(false).or_else(|| change(true)).unwrap_or(f64::NAN);
            out.extend(std::iter::repeat_n(by, zero.number()));
        }
        out
    }
}

impl Poles<3> for CircleForm {
    type Near<'a> = NearCircle<'a>;

    fn count(&self) -> usize {
        self.poles.len()
    }

    fn distance(&self, place: usize, from: usize) -> f64 {
        self.poles[place].angle - self.poles[from].angle
    }

    fn place_at(&self, from: usize, offset: f64) -> usize {
        let theta = self.poles[from].angle + offset;
        self.poles.partition_point(|pole| pole.angle > theta).saturating_sub(1)
    }

    fn images(&self, from: usize, offset: C, _: bool) -> SmallVec<[C; 2]> {
        let origin = self.poles[from].angle;
        // Mirror images are as near as the ends are.
        let ends = [(from < REACH, PI), (from + REACH >= self.poles.len(), 0.0)].into_iter().filter(|end| end.0);
        ends.map(|(_, end)| C::new(2.0 * (end - origin) - offset.re, offset.im)).collect()
    }

    fn kept(&self, from: usize, offset: C) -> C {
        let origin = self.poles[from].angle;
        let theta = offset.re + origin;
        let end = theta.clamp(0.0, PI);
        if theta == end { offset } else { C::new(2.0 * end - theta - origin, offset.im) }
    }

    fn near<'a>(&'a self, place: usize, whole: bool, scratch: &'a mut Nearby<3>) -> Option<NearCircle<'a>> {
        self.about(place, whole, scratch)
    }

    fn variable(&self, zero: &Zero) -> C {
        let pole = &self.poles[zero.place];
        if !zero.real {
            return pole.pole() * (I * zero.offset).exp();
        }
        let modulus = (-zero.offset.im).exp();
        C::new(if pole.angle + zero.offset.re < 0.5 * PI { modulus } else { -modulus }, 0.0)
    }

    fn find(&self, z: C) -> (usize, C) {
        let theta = -I * z.ln();
        let place = self.poles.partition_point(|pole| pole.angle > theta.re).saturating_sub(1);
        (place, theta - self.poles[place].angle)
    }

    fn logarithmic(&self, z: C) -> (C, C) {
        let [f, slope, bend] = whole(self, z);
        let ratio = slope / f;
        let (mut log, mut log_slope) = (ratio, bend / f - ratio * ratio);
        for pole in &self.poles {
            let p = pole.pole();
            for inverse in [inverse(z - p), inverse(z - p.conj())] {
                log += inverse;
                log_slope -= inverse * inverse;
            }
        }
        (log, log_slope)
    }

    fn start(&self, attempt: u32, _: &[C], _: usize) -> C {
        C::from_polar(0.3 + 0.2 * f64::from(attempt), 0.9 + 1.3 * f64::from(attempt))
    }

    fn close_enough(&self, _: C) -> f64 {
        1e-8
    }
}

impl Near for NearCircle<'_> {
    fn value(&self, tau: C) -> Option<(C, C)> {
        let at = self.place(tau);
        self.holds(at.t).then(|| self.value(at))
    }

    fn errors(&self, tau: C) -> (f64, f64) {
        self.errors(self.place(tau))
    }

    fn axis(&self, tau: C) -> (C, C) {
        let angle = self.pole.angle;
        let end = if angle + tau.re < 0.5 * PI { 0.0 } else { PI };
        (C::new(end - angle, tau.im), I)
    }

    fn resolution(&self, tau: C) -> f64 {
        f64::EPSILON * (tau.norm() + 1.0)
    }
}

//! f(z) = 1 + A(ν) − B(ν)/z of a large ring (see [`crate::map_paths::fast_sums::large_general`]) next to one of its poles, the near poles one by
//! one and the others as a polynomial, and in the whole plane.

use nalgebra::Complex;
use vibrochain_lattice::simd::lanes::{Lane, ONE, TWO, ZERO, all, four, total};

use crate::map_paths::fast_sums::multipole::complex_series;
use crate::map_paths::fast_sums::neighbourhood::{ChargedPole, NearPoles, Nearby, Neighbourhood, divide};
use crate::map_paths::fast_sums::zero_search::inverse;
use crate::map_paths::reversible::pole::Angle;

type C = Complex<f64>;
pub(crate) const I: C = Complex::new(0.0, 1.0);

/// A pole e^{iφ}, 0 < φ < π.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CirclePole {
    pub(crate) at: Angle,
    /// sin φ, φ
    pub(crate) sine: f64,
    pub(crate) angle: f64,
    pub(crate) residue: C,
    /// Errors of ρ and of φ.
    error: f64,
    shift: f64,
}

impl CirclePole {
    /// The conjugate is taken if `imaginary` < 0.
    pub(crate) fn new(at: Angle, imaginary: f64, residue: C, error: f64, shift: f64) -> Self {
        let residue = if imaginary < 0.0 { residue.conj() } else { residue };
        Self { at, sine: 2.0 * at.sin * at.cos, angle: 2.0 * at.sin.atan2(at.cos), residue, error, shift }
    }

    /// e^{iφ}
    pub(crate) fn pole(&self) -> C {
        C::new(self.at.d, self.sine)
    }

    fn source(&self) -> ChargedPole<3> {
        let Self { at, sine, residue, .. } = *self;
        let charges = [residue.re, residue.re * at.d + residue.im * sine, self.error];
        ChargedPole { at, shift: self.shift * residue.norm(), charges }
    }
}

/// f, its poles by rising d.
#[derive(Debug, Clone, Default)]
pub(crate) struct CircleForm {
    pub(crate) poles: Vec<CirclePole>,
    /// A and B next to each pole, and from all poles one by one.
    neighbourhoods: Vec<Neighbourhood<3>>,
    pub(crate) whole: NearPoles<3>,
}

impl CircleForm {
    /// Divides the poles into neighbourhoods.
    pub(crate) fn divide(&mut self) {
        self.whole.fill(self.poles.iter().map(CirclePole::source));
        let points: Vec<f64> = self.poles.iter().map(|pole| pole.at.d).collect();
        self.neighbourhoods = divide(&points, |place| self.poles[place].source().charges);
    }

    /// f about the pole at `place`; from all poles one by one if `whole`.
    pub(crate) fn about<'a>(&'a self, place: usize, whole: bool, nearby: &'a mut Nearby<3>) -> Option<NearCircle<'a>> {
        let pole = &self.poles[place];
        let (near_poles, distances) = if whole {
            self.whole.distances(&pole.at, &mut nearby.distances);
            (&self.whole, nearby.distances.as_slice())
        } else {
            let neighbourhood = self.neighbourhoods.partition_point(|neighbourhood| neighbourhood.gaps.end <= place);
            let neighbourhood = self.neighbourhoods.get(neighbourhood).or(self.neighbourhoods.last())?;
            nearby.look(&self.whole, neighbourhood, &pole.at)
        };
        Some(NearCircle { pole, near_poles, distances })
    }
}

/// f about one pole.
pub(crate) struct NearCircle<'a> {
    pub(crate) pole: &'a CirclePole,
    pub(crate) near_poles: &'a NearPoles<3>,
    pub(crate) distances: &'a [Lane],
}

/// θ next to a pole.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Beside {
    /// ν − d
    pub(crate) t: C,
    /// e^{−iθ}
    inverse: C,
    /// sin θ
    sine: C,
}

impl NearCircle<'_> {
    /// θ = φ + τ.
    pub(crate) fn place(&self, tau: C) -> Beside {
        let half = tau * 0.5;
        let (s, c) = sin_cos(half);
        let CirclePole { at: Angle { d, .. }, sine, .. } = *self.pole;
        let between = c * sine + s * d;
        let t = -(between * s) * 2.0;
        let (sin, cos) = sin_cos(tau);
        Beside { t, inverse: (-I * tau).exp() * C::new(d, -sine), sine: cos * sine + sin * d }
    }

    /// In the coordinate of the field of far poles.
    fn scaled(&self, t: C) -> C {
        (t + (self.pole.at.d - self.near_poles.middle)) * self.near_poles.scale
    }

    /// That field is known there.
    pub(crate) fn holds(&self, t: C) -> bool {
        self.near_poles.holds(self.scaled(t))
    }

    /// f and df/dθ.
    pub(crate) fn value(&self, Beside { t, inverse, sine }: Beside) -> (C, C) {
        let (x, y) = (all(t.re), all(t.im));
        let mut sums = [ZERO; 8];
        let NearPoles { charges: [a, b, _], scale, far: [[far_a, far_a_slope, _], [far_b, far_b_slope, _], _], .. } =
            self.near_poles;
        for ((a, b), distance) in a.iter().zip(b).zip(self.distances) {
            let (u, a, b) = (four(*distance) + x, four(*a), four(*b));
            let scale = ONE / (u * u + y * y);
            let (re, im) = (u * scale, -y * scale);
            let (re2, im2) = (re * re - im * im, TWO * re * im);
            let terms = [a * re, a * im, b * re, b * im, a * re2, a * im2, b * re2, b * im2];
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        let sum = |i: usize| C::new(total(sums[i]), total(sums[i + 1]));
        let [far_a, far_b, far_a_slope, far_b_slope] =
            complex_series([far_a, far_b, far_a_slope, far_b_slope], self.scaled(t));
        let (a, b) = (sum(0) + far_a, sum(2) + far_b);
        let (a_slope, b_slope) = (far_a_slope * scale - sum(4), far_b_slope * scale - sum(6));
        let f = a - b * inverse + 1.0;
        (f, I * b * inverse - sine * (a_slope - b_slope * inverse))
    }

    /// Errors of f: of the sums alone, and of residues and poles, too.
    pub(crate) fn errors(&self, Beside { t, inverse, sine }: Beside) -> (f64, f64) {
        let (mut size, mut noise) = (ZERO, ZERO);
        let (x, square) = (all(t.re), all(t.im * t.im));
        let (tilt, slide) = (all(inverse.norm()), all(sine.norm()));
        let NearPoles { charges: [a, b, errors], shifts, noise: field_noise, rounding: field_rounding, .. } =
            self.near_poles;
        let lanes = a.iter().zip(b).zip(errors.iter().zip(shifts)).zip(self.distances);
        for (((a, b), (error, shift)), distance) in lanes {
            let u = four(*distance) + x;
            let near = ONE / (u * u + square).sqrt();
            size += (four(*a).abs() + four(*b).abs() * tilt) * near;
            noise += (ONE + tilt) * (four(*error) + four(*shift) * slide * near) * near;
        }
        let rounding = 4.0 * f64::EPSILON * (1.0 + total(size)) + field_rounding * (1.0 + inverse.norm());
        (rounding, rounding + total(noise) + 2.0 * field_noise * (1.0 + inverse.norm()))
    }
}

/// Both at once, for what each takes alone.
fn sin_cos(z: C) -> (C, C) {
    let ((sin, cos), sinh, cosh) = (z.re.sin_cos(), z.im.sinh(), z.im.cosh());
    (C::new(sin * cosh, cos * sinh), C::new(cos * cosh, -sin * sinh))
}

/// f, f′ and f″ in z over all poles.
pub(crate) fn whole(form: &CircleForm, z: C) -> [C; 3] {
    let mut sums = [C::new(1.0, 0.0), C::default(), C::default()];
    for pole in &form.poles {
        let p = pole.pole();
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

//! f(z) = 1 + A(ν) − B(ν)/z of a large ring (see [`super::forced_large`]) next to one of its poles, the near poles one by
//! one and the others as a polynomial, and in the whole plane.

use nalgebra::Complex;

use super::cauchy::{Nodal, Tree, complex_series, derivative};
use super::search::inverse;
use vibrochain_breather::lanes::{Lane, ONE, TWO, ZERO, all, fill, four, total};

type C = Complex<f64>;
pub(super) const I: C = Complex::new(0.0, 1.0);

/// A pole e^{iφ}, 0 < φ < π.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CirclePole {
    pub(super) cos: f64,
    pub(super) sin: f64,
    /// cos φ, sin φ, φ
    pub(super) d: f64,
    pub(super) sine: f64,
    pub(super) angle: f64,
    pub(super) residue: C,
    /// Errors of ρ and of φ.
    pub(super) error: f64,
    pub(super) shift: f64,
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
    /// All poles, and no field of others.
    pub(super) whole: Leaf,
}

/// The gaps of one leaf of the tree over the poles, each named by the place of its left pole.
#[derive(Debug, Clone, Default)]
pub(super) struct Leaf {
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
        let near = |places: &mut dyn Iterator<Item = usize>| {
            let places: Vec<usize> = places.collect();
            let lanes = |value: &dyn Fn(&CirclePole) -> f64, pad: f64| {
                let mut lanes = Vec::new();
                fill(&mut lanes, places.iter().map(|&place| value(&self.poles[place])), pad);
                lanes
            };
            Leaf {
                a: lanes(&|pole| pole.charges()[0], 0.0),
                b: lanes(&|pole| pole.charges()[1], 0.0),
                cos: lanes(&|pole| pole.cos, 1e50),
                sin: lanes(&|pole| pole.sin, 1e50),
                errors: lanes(&|pole| pole.error, 0.0),
                shifts: lanes(&|pole| pole.shift * pole.residue.norm(), 0.0),
                ..Leaf::default()
            }
        };
        self.leaves.clear();
        for field in Tree::new(&points, false).fields(&points, &charges, &Tree::new(&points, true)) {
            let size = |channel: usize| field.far[channel].iter().map(|c: &f64| c.abs()).sum::<f64>();
            let rounding = 1e-14 * (size(0) + size(1));
            self.leaves.push(Leaf {
                end: field.targets.end,
                middle: field.middle,
                scale: if field.half > 0.0 { 1.0 / field.half } else { 0.0 },
                far: [field.far[0], field.far[1], derivative(&field.far[0]), derivative(&field.far[1])],
                noise: rounding + 2.0 * (field.far[2][0].abs() + total_error),
                rounding,
                ..near(&mut field.near.iter().flat_map(Clone::clone))
            });
        }
        self.whole = near(&mut (0..self.poles.len()));
    }

    pub(super) fn leaf(&self, place: usize) -> Option<&Leaf> {
        self.leaves.get(self.leaves.partition_point(|leaf| leaf.end <= place)).or(self.leaves.last())
    }

    /// Distances d − d_l from the pole at `place` into `out`.
    pub(super) fn distances(&self, place: usize, leaf: &Leaf, out: &mut Vec<Lane>) {
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
pub(super) struct Local<'a> {
    pub(super) pole: &'a CirclePole,
    pub(super) leaf: &'a Leaf,
    pub(super) distances: &'a [Lane],
}

impl Local<'_> {
    /// ν − d, e^{−iθ} and sin θ at θ = φ + τ.
    pub(super) fn place(&self, tau: C) -> (C, C, C) {
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
    pub(super) fn holds(&self, t: C) -> bool {
        let u = (t + (self.pole.d - self.leaf.middle)) * self.leaf.scale;
        u.re.abs() <= 1.2 && u.im.abs() <= 0.5
    }

    /// f and df/dθ.
    pub(super) fn value(&self, (t, inverse, sine): (C, C, C)) -> (C, C) {
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
        (f, I * b * inverse - sine * (a_slope - b_slope * inverse))
    }

    /// Errors of f: of the sums alone, and of residues and poles, too.
    pub(super) fn errors(&self, (t, inverse, sine): (C, C, C)) -> (f64, f64) {
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

/// f, f′ and f″ in z over all poles.
pub(super) fn whole(form: &CircleForm, z: C) -> [C; 3] {
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

//! All orbits of two impacts under a load of one harmonic, with proof: enclosures of F(φ) = C² + S² − Δ², the determinants of the linear
//! equations of (P₁, P₂, c, s) by Cramer's rule (`search`).
//!
//! Kernels K, K′ of all four pairs of impacts and the load's cosines at the second one are functions of φ with known derivatives; what they
//! multiply is fixed. So F is a sum of products, and the same formula serves for numbers and for enclosures.

use vibrochain_lattice::{Complex, LinearMode, Turn};

use super::equations::Equations;
use crate::lanes::Lane;
use crate::roots::enclosure::{Algebra, Dual};
use crate::roots::interval::{Clearance, Enclosed, Zeros, one_by_one};

type C = Complex<f64>;

/// Of the period at both ends, within which two impacts of one contact cannot be told from one.
const COINCIDENT: f64 = 1e-4;

/// Intervals are not halved below this part of the period.
const RESOLUTION: f64 = 1e-11;

/// F of two impacts.
pub(super) struct Function<'a> {
    equations: &'a Equations<'a>,
    contacts: [usize; 2],
    rate: f64,
    swings: [C; 2],
    /// (1+e) of both, and their mobilities.
    weights: [f64; 2],
    mobilities: [f64; 2],
    /// Stops less what is still. Where both are 0, F = −Δ², and Δ is sought instead.
    places: [f64; 2],
    /// K and K′ of each contact with itself, a period later.
    own: [[f64; 2]; 2],
    /// Bounds of |K⁽ᵐ⁾| for m = 2 … 5 from one contact to the other, each way.
    bounds: [[f64; 6]; 2],
}

impl<'a> Function<'a> {
    /// `None` of rigid modes, of modes that grow, without a single harmonic, and of a contact that the load does not move.
    pub(super) fn new(equations: &'a Equations<'a>, contacts: [usize; 2], places: [f64; 2]) -> Option<Self> {
        let (rate, swing) = equations.single()?;
        let modes = equations.model.structure().modes();
        // Where the load does not move one of them, F may vanish altogether.
        let moved = contacts.iter().all(|&contact| swing[contact].norm() > 0.0);
        if !moved || !equations.rigid.is_empty() || modes.iter().any(|mode| !is_held(mode)) {
            return None;
        }
        let own = contacts.map(|contact| {
            let (jet, _) = equations.kernel.jet(contact, contact, 0.0);
            [jet[0], jet[1]]
        });
        let bounds = [(0, 1), (1, 0)].map(|(to, from)| equations.kernel.bounds(contacts[to], contacts[from]));
        Some(Self {
            equations,
            contacts,
            rate,
            swings: contacts.map(|contact| swing[contact]),
            weights: contacts.map(|contact| 1.0 + equations.restitution(contact)),
            mobilities: contacts.map(|contact| equations.mobility(contact)),
            places,
            own,
            bounds,
        })
    }

    /// Whether both stops are where the contacts are still: only the direction of (c, s) counts.
    pub(super) fn is_homogeneous(&self) -> bool {
        self.places == [0.0; 2]
    }

    /// All zeros between the coincident ends; the second list is where two may have merged, the last number says whether all places were looked at.
    pub(super) fn zeros(&self) -> Zeros {
        let mut zeros = Zeros::default();
        let period = self.equations.period();
        let fastest = self.equations.model.structure().modes().iter().map(|mode| mode.rate).fold(self.rate, f64::max);
        let pieces = ((fastest * period) as usize).clamp(16, 4000);
        let cut = if self.contacts[0] == self.contacts[1] { COINCIDENT } else { RESOLUTION };
        zeros.find(self, cut * period, (1.0 - cut) * period, pieces, |_| RESOLUTION * period);
        zeros
    }

    /// F of kernels K₁₂ (at T−φ), K₂₁ (at φ) and the load at the second impact, by value and slope in time.
    fn formula<T: Algebra>(&self, kernels: [[T; 2]; 2], load: [[T; 2]; 2]) -> T {
        // Rows: places of both, laws of both; columns: P₁, P₂, c, s. The first load is a number.
        let [k12, k21] = kernels;
        let first = self.swings[0];
        let (g1, d1) =
            ([first.re, -first.im], [-self.rate * first.im * self.weights[0], -self.rate * first.re * self.weights[0]]);
        let [g2, d2] = load;
        let d2 = d2.map(|x| x.scaled(self.weights[1]));
        let laws = [k12[1].scaled(self.weights[0]), k21[1].scaled(self.weights[1])];
        let own = [0, 1].map(|i| self.mobilities[i] + self.weights[i] * self.own[i][1]);
        // 2 × 2 minors of the first two columns, by pairs of rows: (place 1, place 2, law 1, law 2).
        let columns: [[Entry<T>; 4]; 2] = [
            [Entry::Number(self.own[0][0]), Entry::Function(k21[0]), Entry::Number(own[0]), Entry::Function(laws[1])],
            [Entry::Function(k12[0]), Entry::Number(self.own[1][0]), Entry::Function(laws[0]), Entry::Number(own[1])],
        ];
        let cos = [Entry::Number(g1[0]), Entry::Function(g2[0]), Entry::Number(d1[0]), Entry::Function(d2[0])];
        let sin = [Entry::Number(g1[1]), Entry::Function(g2[1]), Entry::Number(d1[1]), Entry::Function(d2[1])];
        let right =
            [Entry::Number(self.places[0]), Entry::Number(self.places[1]), Entry::Number(0.0), Entry::Number(0.0)];
        let zero = k12[0].scaled(0.0);
        let determinant = |third: &[Entry<T>; 4], fourth: &[Entry<T>; 4]| {
            let mut sum = zero;
            for (i, j, k, l, sign) in PAIRS {
                let upper = minor(&columns[0], &columns[1], i, j, zero);
                let lower = minor(third, fourth, k, l, zero);
                sum = sum + (upper * lower).scaled(sign);
            }
            sum
        };
        let whole = determinant(&cos, &sin);
        if self.is_homogeneous() {
            return whole;
        }
        let (c, s) = (determinant(&right, &sin), determinant(&cos, &right));
        c * c + s * s - whole * whole
    }

    /// Enclosures about a centre.
    fn enclose(&self, phi: f64, radius: f64) -> Dual {
        let equations = self.equations;
        let of_kernel = |lapse: f64, to: usize, from: usize, bounds: &[f64; 6], sign: f64| {
            let jet = equations.kernel.long_jet(self.contacts[to], self.contacts[from], lapse);
            // K(±φ): odd derivatives change sign with it.
            let flip = |order: i32| if order % 2 == 0 { 1.0 } else { sign };
            let place = [jet[0], flip(1) * jet[1], jet[2], flip(1) * jet[3]];
            let slope = [jet[1], flip(1) * jet[2], jet[3], flip(1) * jet[4]];
            // What rounding makes of the terms, far more than of their sum next to a resonance.
            let (_, sizes) = equations.kernel.jet(self.contacts[to], self.contacts[from], lapse);
            let doubt = sizes.map(|size| 4.0 * f64::EPSILON * size);
            [
                Dual::from_jet(place, bounds[4], radius).widened([doubt[0], doubt[1]]),
                Dual::from_jet(slope, bounds[5], radius).widened([doubt[1], doubt[2]]),
            ]
        };
        let k12 = of_kernel(-phi, 0, 1, &self.bounds[0], -1.0);
        let k21 = of_kernel(phi, 1, 0, &self.bounds[1], 1.0);
        // Re of ĝe^{iwφ}(c + is), and of its slope.
        let size = self.swings[1].norm();
        let turned = self.swings[1] * C::from_polar(1.0, self.rate * phi);
        let wave = |value: C, size: f64| {
            // Re and −Im of the swing are cosines of φ, a quarter of a turn apart.
            let real = Dual::wave(value.re, value.im, self.rate, size, radius);
            let imaginary = Dual::wave(-value.im, value.re, self.rate, size, radius);
            [real, imaginary]
        };
        let place = wave(turned, size);
        let speed = wave(turned * C::new(0.0, self.rate), size * self.rate);
        self.formula([k12, k21], [place, speed])
    }
}

/// An entry of the equations: a number, or a function of φ.
#[derive(Clone, Copy)]
enum Entry<T> {
    Number(f64),
    Function(T),
}

/// Pairs of rows for Laplace's expansion by the first two columns, with their signs.
const PAIRS: [(usize, usize, usize, usize, f64); 6] = [
    (0, 1, 2, 3, 1.0),
    (0, 2, 1, 3, -1.0),
    (0, 3, 1, 2, 1.0),
    (1, 2, 0, 3, 1.0),
    (1, 3, 0, 2, -1.0),
    (2, 3, 0, 1, 1.0),
];

fn minor<T: Algebra>(first: &[Entry<T>; 4], second: &[Entry<T>; 4], i: usize, j: usize, zero: T) -> T {
    product(first[i], second[j], zero) - product(first[j], second[i], zero)
}

fn product<T: Algebra>(a: Entry<T>, b: Entry<T>, zero: T) -> T {
    match (a, b) {
        (Entry::Number(a), Entry::Number(b)) => zero.shifted(a * b),
        (Entry::Number(a), Entry::Function(b)) | (Entry::Function(b), Entry::Number(a)) => b.scaled(a),
        (Entry::Function(a), Entry::Function(b)) => a * b,
    }
}

/// Nothing of it grows.
fn is_held(mode: &LinearMode) -> bool {
    match mode.turn {
        Turn::Circular => mode.decay >= 0.0,
        Turn::Hyperbolic => mode.decay >= mode.rate,
        Turn::Parabolic => mode.decay > 0.0,
    }
}

impl Enclosed for Function<'_> {
    fn clearances(&self, centres: Lane, radii: Lane) -> [Clearance; crate::lanes::LANES] {
        one_by_one(centres, radii, |phi, radius| self.enclose(phi, radius))
    }

    fn at(&self, phi: f64) -> (f64, f64) {
        self.enclose(phi, 0.0).at_centre()
    }
}

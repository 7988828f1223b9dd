//! All orbits of two impacts, with proof, under a load of one harmonic or without loads and losses. They are zeros of one function F of the
//! time φ between the impacts, which is enclosed on intervals.
//!
//! Under a load the linear equations of (P₁, P₂, c, s) (`at_times`) are solved by Cramer's rule: F = C² + S² − Δ².
//!
//! Rows are the places p₁, p₂ and laws l₁, l₂. U are the minors of the columns of P₁, P₂ in two rows, Δ and C + iS are sums of them times those
//! of the other two columns (Laplace). With ĝ the load's amplitudes, ρ = ĝ₁ĝ₂* e^{−iωφ}, w = ω(1+e) and r the stops less what is still,
//!
//! ```text
//! Δ = Im ρ·(w₁w₂U_pp + U_ll) − Re ρ·(w₁U₁₂ + w₂U₂₁) + w₂|ĝ₂|²U₁₁ + w₁|ĝ₁|²U₂₂       U_ij: rows p_i and l_j
//! |ĝ₁|C = |ĝ₁|²a + Re ρ·b + Im ρ·r₁U_ll,           a = w₁(r₁U₂₂ − r₂U₁₂)
//! |ĝ₁|S = −|ĝ₁|²r₂U_ll + Re ρ·r₁U_ll − Im ρ·b,     b = w₂(r₂U₁₁ − r₁U₂₁)
//! ```
//!
//! but for a rotation of (C, S).
//!
//! Without loads the places give the impulses, and one of Newton's laws follows from the other. As K′ of a contact with itself is odd, the law
//! that is left is P₁K₂₁′(φ) = 0: F = K₂₁′.
//!
//! The same formulas serve for numbers and for enclosures.

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::simd::lanes::{LANES, Lane, ZERO, all, four};
use vibrochain_lattice::{Complex, Stop, Turn};
use wide::f64x4;

use crate::roots::dual::{Algebra, Dual};
use crate::roots::interval::{Clearance, Enclosed, Zeros};
use crate::roots::taylor::Taylor;
use crate::structures::between::Between;
use crate::structures::equations::Equations;

type C = Complex<f64>;

/// Of the period at both ends, within which two impacts on one barrier under a load cannot be told from one; or, without loads, of two contacts,
/// whose K₂₁′ is 0 at one instant.
const COINCIDENT: f64 = 1e-4;

/// Intervals are not halved below this part of the period.
pub(super) const RESOLUTION: f64 = 1e-11;

/// The same of one function: next to a resonance its zeros come in pairs, as close as the square of the distance.
pub(super) const FINEST: f64 = 1e-14;

/// Places closer than this part of the period are one: next to a fold rounding blurs each zero of a pair alone.
pub(super) const PAIR: f64 = 1e-6;

/// Intervals to begin with: where modes are far faster than the load, they have died out in nearly all of them.
pub(super) const MOST_PIECES: usize = 512;

/// And no fewer, where the whole period is searched.
const LEAST_PIECES: usize = 16;

/// The part of the period from which on two impacts can be told from one, which are `alike` at one instant.
pub(super) fn told_apart(alike: bool) -> f64 {
    if alike { COINCIDENT } else { RESOLUTION }
}

/// F of two impacts.
pub(super) struct Function {
    pub(super) period: f64,
    /// Without loads.
    is_free: bool,
    between: Between,
    /// ω
    rate: f64,
    /// ρ at φ = 0, and |ĝ|² of both.
    product: C,
    squares: [f64; 2],
    /// (1+e) of both, and w.
    weights: [f64; 2],
    fast: [f64; 2],
    /// Stops less what is still. Where both are 0, F = −Δ², and Δ is sought instead.
    places: [f64; 2],
    /// Of each contact with itself, a period later: K, and 1/m + (1+e)K′.
    own: [[f64; 2]; 2],
    /// Where two impacts begin to be told apart.
    least: f64,
    /// Both impacts are on one barrier of one contact: an orbit has the shorter time between them before the longer one as well as after it.
    alike: bool,
    stop: Stop,
    /// Without loads, an impulse at one of the two contacts does not move the other at once: F vanishes where the instants are one.
    vanishes: bool,
}

/// U₁₁, U₁₂, U₂₁, U₂₂, U_ll and Δ.
struct Minors<T> {
    u11: T,
    u12: T,
    u21: T,
    u22: T,
    laws: T,
    whole: T,
}

impl Function {
    /// `None` of modes that grow; of rigid ones under a load, of several harmonics, of a contact that the load does not move, and without loads where both
    /// stops are at the rest position: nothing has a size.
    pub(super) fn new(equations: &Equations<'_>, contacts: [usize; 2], places: [f64; 2]) -> Option<Self> {
        let is_free = !equations.forced;
        let (rate, swings) = match equations.single() {
            Some((rate, swing)) => (rate, contacts.map(|contact| swing[contact])),
            None if is_free && places != [0.0; 2] => (0.0, [C::default(); 2]),
            None => return None,
        };
        // Where the load does not move one of them, F may vanish altogether.
        if !is_free && (equations.kernel().has_rigid() || swings.iter().any(|swing| swing.norm() == 0.0)) {
            return None;
        }
        let weights = contacts.map(|contact| 1.0 + equations.restitution(contact));
        let own = contacts.map(|contact| equations.own(contact));
        let (period, vanishes) = (equations.period(), is_free && are_apart(equations, contacts));
        let on_one_barrier = !is_free && contacts[0] == contacts[1] && places[0] == places[1];
        Some(Self {
            period,
            is_free,
            between: Between::new(equations.kernel(), contacts[0], contacts[1])?,
            rate,
            product: swings[0] * swings[1].conj(),
            squares: swings.map(|swing| swing.norm_sqr()),
            weights,
            fast: weights.map(|weight| rate * weight),
            places,
            own,
            least: period * told_apart(vanishes || on_one_barrier),
            alike: on_one_barrier,
            stop: equations.model.stop().clone(),
            vanishes,
        })
    }

    /// Whether both stops are where the contacts are still: only the direction of (c, s) counts.
    pub(super) fn is_homogeneous(&self) -> bool {
        self.places == [0.0; 2]
    }

    /// All zeros between the coincident ends, or those in some intervals of φ, which rise.
    pub(super) fn zeros(&self, within: Option<&[[f64; 2]]>) -> Zeros {
        let mut zeros = Zeros::default();
        zeros.stop = self.stop.clone();
        let rate = self.between.fastest.max(self.rate);
        // Where it is known to vanish at one instant it is followed up to there.
        let least = if self.vanishes { 0.0 } else { self.least };
        let longest = if self.alike { 0.5 * self.period * (1.0 + PAIR) } else { self.period - least };
        let inside = |[from, to]: &[f64; 2]| [from.max(least), to.min(longest)];
        let ranges: SmallVec<[[f64; 2]; 8]> = within.unwrap_or(&[[least, longest]]).iter().map(inside).collect();
        let ranges: SmallVec<[[f64; 2]; 8]> = ranges.into_iter().filter(|[from, to]| from < to).collect();
        let fewest = if within.is_some() { 1 } else { LEAST_PIECES };
        let pieces = |length: f64| ((rate * length) as usize).clamp(fewest, MOST_PIECES);
        zeros.find_in(self, &ranges, pieces, |_| FINEST * self.period);
        zeros.unresolved.retain(|phi| (self.least..=self.period - self.least).contains(phi));
        zeros
    }

    /// How many of these places, which rise, are apart.
    pub(super) fn apart(&self, places: impl Iterator<Item = f64>) -> usize {
        apart(places, PAIR * self.period)
    }

    /// Minors of the columns of P₁ and P₂ in the rows that change, and Δ.
    fn minors<T: Algebra>(&self, [there, back]: [[T; 2]; 2], [along, across]: [T; 2]) -> Minors<T> {
        let ([w1, w2], [n1, n2]) = (self.fast, self.squares);
        let [[k1, law1], [k2, law2]] = self.own;
        // K₂₁ and (1+e₂)K₂₁′ at the second impact, K₁₂ and (1+e₁)K₁₂′ at the first.
        let ([place2, slope2], [place1, slope1]) =
            ([there[0], there[1].scaled(self.weights[1])], [back[0], back[1].scaled(self.weights[0])]);
        let u11 = slope1.scaled(k1) - place1.scaled(law1);
        let u12 = (slope2 * place1).scaled(-1.0).shifted(k1 * law2);
        let u21 = (place2 * slope1).shifted(-law1 * k2);
        let u22 = place2.scaled(law2) - slope2.scaled(k2);
        let laws = (slope2 * slope1).scaled(-1.0).shifted(law1 * law2);
        let both = (place2 * place1).scaled(-1.0).shifted(k1 * k2);
        let whole = across * (both.scaled(w1 * w2) + laws) - along * (u12.scaled(w1) + u21.scaled(w2))
            + u11.scaled(w2 * n2)
            + u22.scaled(w1 * n1);
        Minors { u11, u12, u21, u22, laws, whole }
    }

    /// C and S.
    fn phases<T: Algebra>(&self, minors: &Minors<T>, [along, across]: [T; 2]) -> [T; 2] {
        let ([w1, w2], size, [r1, r2]) = (self.fast, self.squares[0].sqrt(), self.places);
        let a = (minors.u22.scaled(r1) - minors.u12.scaled(r2)).scaled(w1 * size);
        let b = (minors.u11.scaled(r2) - minors.u21.scaled(r1)).scaled(w2 / size);
        let felt = minors.laws.scaled(r1 / size);
        [a + along * b + across * felt, along * felt - across * b - minors.laws.scaled(r2 * size)]
    }

    /// F of both kernels with their slopes, and of Re ρ and Im ρ.
    fn formula<T: Algebra>(&self, kernels: [[T; 2]; 2], waves: [T; 2]) -> T {
        if self.is_free {
            let [[_, slope], _] = kernels;
            return slope;
        }
        let minors = self.minors(kernels, waves);
        if self.is_homogeneous() {
            return minors.whole;
        }
        let [c, s] = self.phases(&minors, waves);
        c * c + s * s - minors.whole * minors.whole
    }

    /// How far F stays away from 0 on four intervals: by the enclosure of F itself, or by those of C, S and Δ one by one, which on long
    /// intervals say more.
    fn clearance(&self, kernels: [[Taylor<1, f64x4>; 2]; 2], waves: [Taylor<1, f64x4>; 2]) -> f64x4 {
        if self.is_free {
            return self.formula(kernels, waves).clearance();
        }
        let minors = self.minors(kernels, waves);
        if self.is_homogeneous() {
            return minors.whole.clearance();
        }
        let ([c, s], whole) = (self.phases(&minors, waves), minors.whole);
        let least = |one: Taylor<1, f64x4>| one.clearance().fast_max(ZERO);
        let [above, below] = [least(c) * least(c) + least(s) * least(s), whole.most() * whole.most()];
        let inside = least(whole) * least(whole) - (c.most() * c.most() + s.most() * s.most());
        let by_one = (above - below).fast_max(inside);
        (c * c + s * s - whole * whole).clearance().fast_max(by_one)
    }

    /// Enclosures of what F is made of, about four φ.
    fn pieces(&self, phis: Lane, radii: Lane) -> [[Dual<Taylor<1, f64x4>>; 2]; 3] {
        let radius = four(radii);
        let (jets, fourths) = self.between.jets(phis, radii);
        let kernels = [0, 1].map(|way| {
            let ([value, slope, bend, third], fourth) = (jets[way], fourths[way]);
            let [of_value, of_slope, of_bend] = self.between.doubts[way];
            // At T − φ the slope in time is the opposite of that in φ.
            let sign = [1.0, -1.0][way];
            [
                Dual::from_jet([value, slope, bend, third], fourth, radius).widened([of_value, of_slope]),
                Dual::from_jet([slope, bend, third, fourth], ZERO, radius).widened([of_slope, of_bend]).scaled(sign),
            ]
        });
        let [cos, sin] = Turn::Circular.turns(self.rate, phis).unwrap_or_default().map(four);
        let (re, im) = (
            cos * all(self.product.re) + sin * all(self.product.im),
            cos * all(self.product.im) - sin * all(self.product.re),
        );
        let size = self.product.norm();
        // Re ρ and Im ρ are cosines of φ, a quarter of a turn apart.
        let waves = [Dual::wave(re, -im, self.rate, size, radius), Dual::wave(im, re, self.rate, size, radius)];
        [kernels[0], kernels[1], waves]
    }

    /// F′
    pub(super) fn slope(&self, phi: f64) -> f64 {
        self.at(phi).1
    }

    /// Whether F″ keeps its sign, on four intervals.
    pub(super) fn bends(&self, phis: Lane, radii: Lane) -> [bool; LANES] {
        let ([there, back, [re, im]], radius) = (self.pieces(phis, radii), four(radii));
        let (jets, fourths) = self.between.jets(phis, radii);
        let with_slopes = |way: usize, [place, law]: [Dual<Taylor<1, f64x4>>; 2]| {
            let (sign, [.., third]) = ([1.0, -1.0][way], jets[way]);
            let rest = fourths[way] * radius + all(self.between.doubts[way][2] * self.between.fastest);
            let third = Taylor { value: third * all(sign), slope: [ZERO], rest, radius: [radius] };
            let derivative = Dual { function: law.derivative, derivative: third };
            [Dual { function: place, derivative: law.scaled(sign) }, Dual { function: law, derivative }]
        };
        let waves = [(re, im.scaled(self.rate)), (im, re.scaled(-self.rate))];
        let waves = waves.map(|(function, derivative)| Dual { function, derivative });
        let curved = self.formula([with_slopes(0, there), with_slopes(1, back)], waves);
        curved.derivative.derivative.clearance().to_array().map(|clearance| clearance > 0.0)
    }
}

/// How many of these places, which rise, are farther apart than so much.
pub(super) fn apart(places: impl Iterator<Item = f64>, width: f64) -> usize {
    let mut last = f64::NEG_INFINITY;
    places.filter(move |place| *place - std::mem::replace(&mut last, *place) > width).count()
}

/// Whether an impulse at one contact does not move the other at once, but for rounding of the modes' shapes.
fn are_apart(equations: &Equations<'_>, [one, other]: [usize; 2]) -> bool {
    let size = (equations.mobility(one) * equations.mobility(other)).sqrt();
    equations.model.structure().mobility(one, other).abs() <= 64.0 * f64::EPSILON * size
}

impl Enclosed for Function {
    fn clearances(&self, centres: Lane, radii: Lane) -> [Clearance; LANES] {
        let pieces = self.pieces(centres, radii);
        let [there, back, waves] = pieces.map(|pair| pair.map(|piece| piece.function));
        // Where the function itself has no zero nobody asks for its slope.
        let function = self.clearance([there, back], waves).to_array();
        if function.iter().all(|clearance| *clearance > 0.0) {
            return function.map(Clearance::away);
        }
        let [there, back, waves] = pieces;
        let mut clearances = Clearance::of(&self.formula([there, back], waves));
        clearances.iter_mut().zip(function).for_each(|(clearance, function)| clearance.function = function);
        clearances
    }

    fn at(&self, phi: f64) -> (f64, f64) {
        let jets = self.between.jets_at(phi);
        let [there, back] = [0, 1].map(|way| {
            let [value, slope, bend] = jets[way];
            let sign = [1.0, -1.0][way];
            [(value, slope), (sign * slope, sign * bend)].map(|(function, derivative)| Dual { function, derivative })
        });
        let rho = self.product * C::from_polar(1.0, -self.rate * phi);
        let waves = [(rho.re, self.rate * rho.im), (rho.im, -self.rate * rho.re)];
        let waves = waves.map(|(function, derivative)| Dual { function, derivative });
        let point = self.formula([there, back], waves);
        (point.function, point.derivative)
    }

    fn known_zeros(&self) -> SmallVec<[f64; 2]> {
        if self.vanishes { smallvec![0.0, self.period] } else { SmallVec::new() }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use smallvec::smallvec;
    use vibrochain_lattice::{Barrier, Contact, LinearMode, ModalStructure, ModeShape};
    use vibrochain_testkit::Random;

    use super::*;
    use crate::roots::assert_enclosed::assert_enclosed;
    use crate::structures::model::LoadedStructure;
    use crate::structures::search::at_times::Impacts;

    /// F has the sign that elimination gives, its slope is that of its values, and enclosures hold what they enclose.
    #[test]
    fn the_expanded_determinants_are_those_of_elimination() {
        let mut random = Random(83);
        let (mut checked, mut away) = (0, 0);
        for round in 0..60 {
            let mut mode = || {
                // Below, at and above critical damping.
                let (frequency, ratio) = (random.log(0.3, 5.0), [random.log(1e-3, 0.9), 1.0, 1.5][random.below(3)]);
                let contacts = vec![random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
                let shape = ModeShape { contacts, coordinates: Vec::new(), still: random.between(-0.1, 0.1) };
                let load = C::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0));
                LinearMode::oscillator(
                    ratio * frequency,
                    frequency * frequency * (1.0 - ratio * ratio),
                    &shape,
                    &[load],
                )
            };
            let modes = (0..4).map(|_| mode()).collect();
            let contact = Contact { lower: Some(-0.7), upper: Some(0.4), restitution: random.between(0.3, 1.0) };
            let structure = ModalStructure::new(vec![contact; 2], vec![1], modes).unwrap();
            let model = LoadedStructure::new(Arc::new(structure), random.between(0.5, 3.0)).unwrap();
            let letters = [(0, Barrier::Upper), (round % 2, Barrier::Lower)];
            let equations = Equations::new(&model, 1, letters.iter().map(|letter| letter.0)).unwrap();
            let places = letters.map(|(c, barrier)| model.barrier(c, barrier).unwrap() - equations.still(c));
            let function = Function::new(&equations, letters.map(|letter| letter.0), places).unwrap();
            let impacts = Impacts { equations: &equations, letters: smallvec![letters[0], letters[1]] };
            let period = equations.period();
            let scale = (1..40).map(|i| function.at(period * f64::from(i) / 40.0).0.abs()).fold(0.0, f64::max);
            for i in 1..40 {
                let phi = period * f64::from(i) / 40.0;
                let (value, slope) = function.at(phi);
                // Half a period apart at one contact the equations are singular, and elimination has no answer: F is C² + S² there.
                let half = letters[0].0 == letters[1].0 && i == 20;
                if half {
                    assert!(value > 0.0, "{value}");
                } else if value.abs() > 1e-9 * scale {
                    assert_eq!(value > 0.0, impacts.value(phi).unwrap()[0] > 0.0, "{phi} {value}");
                }
                let h = 1e-5 * period;
                let quotient = (function.at(phi + h).0 - function.at(phi - h).0) / (2.0 * h);
                assert!((slope - quotient).abs() < 1e-5 * (slope.abs() + scale / period), "{slope} {quotient}");
                let radius = period * random.log(1e-4, 0.02);
                away += assert_enclosed(&function, phi, radius, [h, period - h]);
                checked += 1;
            }
        }
        assert!(checked == 60 * 39 && away > 10_000, "{checked} {away}");
    }
}

//! What loads add to the modes of a structure.
//!
//! A load b e^{iwt} (w = 0: the static one) moves a mode ξ′ = Aξ + b e^{iwt} steadily by (iw − A)⁻¹b e^{iwt}. Next to a resonance that is
//! large, and a deviation from it large, too, and for a rigid mode under a static load it does not exist. There the answer from rest
//!
//! ```text
//! ∫₀ˢ e^{A(s−r)} b e^{iwr} dr = s e^{iws} φ₁((A − iw)s) b ,      φ₁(Z) = (e^Z − 1)/Z = Σ Z^k/(k+1)! ,
//! ```
//!
//! is taken from each base of flight on: it has no such limit.
//!
//! A mode that answers the static load steadily is measured from where that load holds it, and feels it no more: places of contacts
//! beside their barriers are small there, and keep their digits.

use vibrochain_lattice::{Complex, LinearMode, ModalStructure, Turn, Turned};

type C = Complex<f64>;

/// A load is answered from rest where a pole is within this part of its frequency (for the static load, of ω). Two digits, no more, are
/// lost beyond it; and below it the exponent of φ₁ stays small.
const NEAR: f64 = 1.0 / 64.0;

/// How a mode answers a load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Answer {
    /// It does not feel it.
    Spared,
    /// Steadily: ξ under e^{iw(t+ψ)}.
    Steady([C; 2]),
    /// From rest.
    FromRest,
}

/// Loads of a structure: the static one, then its harmonics.
#[derive(Debug, Clone)]
pub(crate) struct Loads {
    /// w of each.
    pub(crate) rates: Vec<f64>,
    psi: f64,
    given: Vec<Vec<[C; 2]>>,
    pub(crate) answers: Vec<Vec<Answer>>,
    /// ξ of each mode where the static load holds it, from which it is measured; 0 of one that answers that load from rest.
    pub(crate) equilibrium: Vec<[f64; 2]>,
}

impl Loads {
    pub(crate) fn new(structure: &ModalStructure, omega: f64, psi: f64) -> Self {
        let Self { rates, .. } = Self::of_harmonics(structure.harmonics(), omega, psi);
        let still = |mode: &LinearMode| mode.still.map(|load| C::new(load, 0.0));
        let mut given: Vec<Vec<[C; 2]>> = (structure.modes().iter())
            .map(|mode| std::iter::once(still(mode)).chain(mode.loads.iter().copied()).collect())
            .collect();
        let answer = |mode: &LinearMode, w: f64, load: [C; 2]| {
            let distance =
                mode.rates().map(|rate| (C::new(0.0, w) - rate).norm()).into_iter().fold(f64::INFINITY, f64::min);
            if load == [C::default(); 2] {
                Answer::Spared
            } else if distance < NEAR * if w == 0.0 { omega } else { w } {
                Answer::FromRest
            } else {
                Answer::Steady(mode.steady(w, load))
            }
        };
        let mut answers: Vec<Vec<Answer>> = (structure.modes().iter().zip(&given))
            .map(|(mode, given)| rates.iter().zip(given).map(|(w, load)| answer(mode, *w, *load)).collect())
            .collect();
        let held = |(answers, given): (&mut Vec<Answer>, &mut Vec<[C; 2]>)| {
            let Answer::Steady(xi) = answers[0] else { return [0.0; 2] };
            (answers[0], given[0]) = (Answer::Spared, [C::default(); 2]);
            xi.map(|xi| xi.re)
        };
        let equilibrium = answers.iter_mut().zip(&mut given).map(held).collect();
        Self { rates, psi, given, answers, equilibrium }
    }

    /// Rates and phase alone, where nothing is known of modes.
    pub(crate) fn of_harmonics(harmonics: &[u32], omega: f64, psi: f64) -> Self {
        let driven = harmonics.iter().map(|number| f64::from(*number) * omega);
        let rates = std::iter::once(0.0).chain(driven).collect();
        Self { rates, psi, given: Vec::new(), answers: Vec::new(), equilibrium: Vec::new() }
    }

    /// About how far the loads move mode `k`; a resonance counts as what is next to it.
    pub(crate) fn response(&self, mode: &LinearMode, k: usize, omega: f64) -> f64 {
        let of_load = |(w, load): (&f64, &[C; 2])| {
            let distance =
                mode.rates().map(|rate| (C::new(0.0, *w) - rate).norm()).into_iter().fold(f64::INFINITY, f64::min);
            load[0].norm().max(load[1].norm()) / distance.max(NEAR * if *w == 0.0 { omega } else { *w })
        };
        self.rates.iter().zip(&self.given[k]).map(of_load).fold(0.0, f64::max)
    }

    /// e^{iw(t+ψ)} of each load at a time within a period.
    pub(crate) fn turned(&self, offset: f64) -> Vec<C> {
        let mut turned = Vec::new();
        self.turn(offset, &mut turned);
        turned
    }

    /// The same, into a list there is.
    pub(crate) fn turn(&self, offset: f64, turned: &mut Vec<C>) {
        turned.clear();
        turned.push(C::new(1.0, 0.0));
        turned.extend(self.rates[1..].iter().map(|w| C::cis(w * offset + w * self.psi)));
    }

    /// The same `s` later.
    pub(crate) fn later(&self, turned: &[C], s: f64) -> Vec<C> {
        let mut later = Vec::new();
        self.turn_on(turned, s, &mut later);
        later
    }

    /// The same, into a list there is.
    pub(crate) fn turn_on(&self, turned: &[C], s: f64, later: &mut Vec<C>) {
        later.clear();
        later.extend_from_slice(turned);
        let driven = later.iter_mut().zip(&self.rates).skip(1);
        driven.for_each(|(turned, w)| *turned *= C::cis(w * s));
    }

    /// What all loads give to mode `k` at an instant.
    pub(crate) fn given(&self, k: usize, turned: &[C]) -> [f64; 2] {
        sum(self.given[k].iter().zip(turned).map(|(load, turned)| real(*load, *turned)))
    }

    /// The n-th Taylor coefficient of that in the time over `h`.
    pub(crate) fn coefficient(&self, k: usize, turned: &[C], h: f64, n: usize, inverse_factorial: f64) -> [f64; 2] {
        let terms = self.given[k].iter().zip(turned).zip(&self.rates).filter(|(_, w)| n == 0 || **w != 0.0);
        sum(terms
            .map(|((load, turned), w)| real(*load, turned * C::new(0.0, w * h).powu(n as u32) * inverse_factorial)))
    }

    /// The steady part of ξ at an instant.
    pub(crate) fn steady(&self, k: usize, turned: &[C]) -> [f64; 2] {
        sum(self.answers[k].iter().zip(turned).map(|(answer, turned)| match answer {
            Answer::Steady(load) => real(*load, *turned),
            _ => [0.0; 2],
        }))
    }

    /// Loads that mode `k` answers from rest, with their numbers.
    pub(crate) fn answered_from_rest(&self, k: usize) -> impl Iterator<Item = (usize, [C; 2])> {
        let given = self.answers[k].iter().zip(&self.given[k]).enumerate();
        given.filter(|(_, (answer, _))| **answer == Answer::FromRest).map(|(j, (_, load))| (j, *load))
    }

    /// What those have added to ξ since they were e^{iw(t+ψ)} = `turned`, and what they give now.
    pub(crate) fn since(&self, mode: &LinearMode, k: usize, turned: &[C], s: f64) -> ([f64; 2], [f64; 2]) {
        let (mut moved, mut given) = ([0.0; 2], [0.0; 2]);
        for (j, load) in self.answered_from_rest(k) {
            let now = turned[j] * C::cis(self.rates[j] * s);
            let answer = mode.turn.act(average(mode, self.rates[j], s), load);
            moved = add(moved, real(answer, now * s));
            given = add(given, real(load, now));
        }
        (moved, given)
    }
}

/// φ₁((A − iw)s)
fn average(mode: &LinearMode, w: f64, s: f64) -> Turned<C> {
    let turn = mode.turn;
    let z = Turned { even: C::new(-mode.decay * s, -w * s), odd: C::new(mode.rate * s, 0.0) };
    let is_close = turn != Turn::Parabolic && z.odd.re.abs() >= 0.5;
    if !is_close && z.even.norm() < 1.0 {
        let (mut term, mut total) = (Turned { even: C::new(1.0, 0.0), odd: C::default() }, Turned::default());
        for k in 1..=24 {
            total = Turned { even: total.even + term.even, odd: total.odd + term.odd };
            let product = turn.product(term, z);
            let next = f64::from(k + 1);
            term = Turned { even: product.even / next, odd: product.odd / next };
        }
        return total;
    }
    if is_close {
        let root = turn.root();
        let [first, second] = [z.even + root * z.odd, z.even - root * z.odd].map(phi);
        return Turned { even: (first + second) * 0.5, odd: (first - second) / (root * 2.0) };
    }
    // (1 − e^{(A−iw)s}) (iw − A)⁻¹ / s: both poles are far from iw.
    let by = mode.generator().resolvent(turn, C::new(0.0, w));
    let flight = mode.flight(s).complex();
    let back = C::cis(-w * s);
    let rest = Turned { even: C::new(1.0, 0.0) - flight.even * back, odd: -flight.odd * back };
    let product = turn.product(rest, by);
    Turned { even: product.even / s, odd: product.odd / s }
}

/// (e^z − 1)/z
fn phi(z: C) -> C {
    if z.norm() >= 0.5 {
        return (z.exp() - 1.0) / z;
    }
    (1..=16).rev().fold(C::new(1.0, 0.0), |sum, k| C::new(1.0, 0.0) + z * sum / f64::from(k + 1))
}

fn real(load: [C; 2], turned: C) -> [f64; 2] {
    load.map(|load| (load * turned).re)
}

pub(crate) fn add(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

fn sum(terms: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    terms.fold([0.0; 2], add)
}

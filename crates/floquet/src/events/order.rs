//! Without loss: pairs of multipliers along the circle, with their Krein signatures, each part of the orbit's symmetries by itself.

use std::hash::{Hash, Hasher};

use nalgebra::Complex;
use vibrochain_breather::{BlochEquations, ContactOrbit};

use super::half_sums::SPLIT;
use crate::spectrum::KreinForms;
use crate::stripes::signature::Signature;

/// ν as near to each other as this are asked for together: an eigenvector of one alone mixes with the other's.
const TOGETHER: f64 = 1e-10;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum State {
    Signed(Signature),
    /// On the circle, too near to another one for its signature.
    Open,
    OffCircle,
}

/// A pair of multipliers, or of those of half a period where the orbit repeats itself after that.
#[derive(Debug, Clone, Copy)]
struct Pair {
    /// None of another part meets it.
    part: u32,
    /// Re ½(μ + 1/μ)
    place: f64,
    state: State,
}

/// All pairs that feel the impacts but real ones, part by part, by rising place.
#[derive(Debug, Clone)]
pub(crate) struct Order {
    reflections: usize,
    pairs: Vec<Pair>,
}

/// Alike in all but places.
impl PartialEq for Order {
    fn eq(&self, other: &Self) -> bool {
        self.reflections == other.reflections && self.states().eq(other.states())
    }
}

impl Hash for Order {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        self.reflections.hash(hasher);
        self.states().for_each(|state| state.hash(hasher));
    }
}

impl Order {
    /// Of an orbit by the half-sums ν of its pairs.
    pub(crate) fn of_orbit(orbit: &ContactOrbit, half_sums: &[Complex<f64>]) -> Option<Self> {
        Self::of(&orbit.bloch_equations().0, half_sums)
    }

    /// Of an orbit by its equations and the half-sums ν of its pairs; `None` where parts cannot be told.
    pub(crate) fn of(equations: &BlochEquations, half_sums: &[Complex<f64>]) -> Option<Self> {
        let forms = KreinForms::new(equations);
        let reflections = forms.reflections();
        let is_on = |nu: &Complex<f64>| nu.im.abs() <= SPLIT;
        let moves = |nu: &&Complex<f64>| nu.im > SPLIT || is_on(nu) && nu.re.abs() < 1.0;
        let mut sums: Vec<Complex<f64>> = half_sums.iter().filter(moves).copied().collect();
        sums.sort_by(|a, b| a.re.total_cmp(&b.re));
        let mut pairs = Vec::with_capacity(sums.len());
        for alike in sums.chunk_by(|a, b| (a - b).norm() <= TOGETHER) {
            let nu = alike[0];
            let (multiplier, unknown) = if is_on(&nu) {
                (Complex::new(nu.re, ((1.0 - nu.re) * (1.0 + nu.re)).sqrt()), State::Open)
            } else {
                (nu + (nu * nu - 1.0).sqrt(), State::OffCircle)
            };
            let wanted = reflections > 0 || unknown == State::Open;
            let Some(told) = forms.at(multiplier, alike.len()).filter(|_| wanted) else {
                if reflections > 0 {
                    return None;
                }
                pairs.extend(alike.iter().map(|nu| Pair { part: 0, place: nu.re, state: unknown }));
                continue;
            };
            for one in told {
                let place = one.half.map_or(nu, |half| (half + half.inv()) * 0.5).re;
                // Of two of half a period the one in the upper half plane may belong to the lower multiplier.
                let form = if one.half.is_some_and(|half| half.im < 0.0) { -one.form } else { one.form };
                let signed = Signature::of_form(form).filter(|_| unknown == State::Open);
                pairs.push(Pair { part: one.part, place, state: signed.map_or(unknown, State::Signed) });
            }
        }
        pairs.sort_by(|a, b| a.part.cmp(&b.part).then(a.place.total_cmp(&b.place)));
        Some(Self { reflections, pairs })
    }

    /// Whether every signature is told.
    pub(crate) fn is_told(&self) -> bool {
        self.pairs.iter().all(|pair| pair.state != State::Open)
    }

    /// Numbers of reflections, and of pairs.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.reflections, self.pairs.len()]
    }

    fn states(&self) -> impl Iterator<Item = (u32, State)> + '_ {
        self.pairs.iter().map(|pair| (pair.part, pair.state))
    }

    fn on_circle(&self) -> impl Iterator<Item = &Pair> + '_ {
        self.pairs.iter().filter(|pair| pair.state != State::OffCircle)
    }

    /// Parts of the pairs on the circle with their signatures, as often as there is one.
    pub(crate) fn kinds(&self) -> Vec<(u32, Option<i8>)> {
        let kind = |pair: &Pair| {
            let State::Signed(signature) = pair.state else { return (pair.part, None) };
            (pair.part, Some(signature.value()))
        };
        let mut kinds: Vec<_> = self.on_circle().map(kind).collect();
        kinds.sort_unstable();
        kinds
    }

    /// The first two on the circle that have changed places in another order of as many of each kind, so that a stripe must lie between: their
    /// part, and how many of it come before them.
    pub(crate) fn swapped(&self, other: &Self) -> Option<(u32, usize)> {
        if self.reflections != other.reflections || self.kinds() != other.kinds() {
            return None;
        }
        let place = self.on_circle().zip(other.on_circle()).position(|(a, b)| a.state != b.state)?;
        let part = self.on_circle().nth(place)?.part;
        Some((part, self.on_circle().take(place).filter(|pair| pair.part == part).count()))
    }

    /// The square of the distance between two neighbours on the circle, as [`swapped`](Self::swapped) has them.
    pub(crate) fn gap(&self, (part, first): (u32, usize)) -> Option<f64> {
        let mut own = self.on_circle().filter(|pair| pair.part == part).skip(first);
        let (one, next) = (own.next()?, own.next()?);
        Some((next.place - one.place).powi(2))
    }
}

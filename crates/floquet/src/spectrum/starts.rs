//! Where the iteration begins: beside each pole, where the zeros are that belong to it to first order.
//!
//! With the m poles at q of one frequency kept apart, det B(z) = 0 is det(z − q + q·C J⁻¹A) = 0 to first order in z − q.

use nalgebra::{Complex, DMatrix, Schur};
use vibrochain_lattice::BlochMode;

use super::function::SpectralFunction;
use crate::zeros::modulus;

type C = Complex<f64>;

/// A start that nothing is known of is its pole turned by this angle and moved inward by this part.
const TURNED: f64 = 0.3;
const INWARD: f64 = 0.95;

/// Two starts that are closer than this part of their way from the pole are one; another is sought in so many directions.
const ALIKE: f64 = 0.2;
const TURNS: i32 = 6;

/// A zero closer to its pole than this part of the way to the next one is no start: f is known too poorly there to lead away from it.
const HIDDEN: f64 = 1e-2;

/// A start is no farther from its pole than this part of the way to the next one. Next to that one it would meet the start of another pole: of
/// 2001 poles all zeros are found in 3 steps each so, and not in 100 where starts may go all the way.
pub(super) const WAY: f64 = 0.5;

/// Poles below this modulus have died out within a period: so have as many multipliers.
pub(super) const DEAD: f64 = 1e-13;

/// What is left at the next period of modes that J(z) takes for dead may be this much.
pub(super) const NEGLIGIBLE: f64 = 1e-30;

/// As many starts as there are poles.
#[derive(Debug, Clone, Default)]
pub(super) struct Starts {
    /// Poles that have died out: what belongs to them is no more told from 0 than they are.
    pub(super) dead: Vec<C>,
    /// Those of a real pole whose partner is dead.
    pub(super) single: Vec<C>,
    /// Those of the two poles of a mode, conjugates of each other but for real poles.
    pub(super) pairs: Vec<[C; 2]>,
}

/// A start with the pole that it is beside and the way to the nearest other one.
#[derive(Debug, Clone, Copy)]
struct Beside {
    at: C,
    pole: C,
    gap: f64,
}

impl SpectralFunction<'_> {
    /// A start beside each pole.
    pub(super) fn starts(&self) -> Starts {
        let modes = self.equations.kernel().modes();
        let (mut starts, mut list) = (Starts::default(), Vec::with_capacity(modes.len()));
        let mut from = 0;
        let same = |a: &BlochMode, b: &BlochMode| (a.coordinates, a.decay, a.rate) == (b.coordinates, b.decay, b.rate);
        for alike in modes.chunk_by(same) {
            let (count, poles) = (alike.len(), alike[0].poles());
            let alive = poles.map(|pole| modulus(pole) >= DEAD);
            let dead = poles.into_iter().zip(alive).filter(|(_, alive)| !alive);
            starts.dead.extend(dead.flat_map(|(pole, _)| std::iter::repeat_n(pole, count)));
            if alive != [false; 2] && alike[0].coordinates.are_parabolic() {
                let length = modulus(poles[0]);
                let start = Beside { at: C::from_polar(INWARD * length, TURNED), pole: poles[0], gap: length };
                list.extend(std::iter::repeat_n([Some(start); 2], count));
            } else if alive != [false; 2] {
                let beside = |which: usize| if alive[which] { self.beside(from, count, which) } else { Vec::new() };
                let first = beside(0);
                let second = if alike[0].coordinates.are_circular() { first.clone() } else { beside(1) };
                list.extend((0..count).map(|k| [first.get(k).copied(), second.get(k).copied()]));
            }
            from += count;
        }
        let mut taken: Vec<C> = Vec::with_capacity(2 * list.len());
        for both in list {
            let [Some(one), Some(other)] = both else {
                let single = both.into_iter().flatten().map(|start| start.away_from(&taken));
                let single: Vec<C> = single.collect();
                taken.extend(&single);
                starts.single.extend(single);
                continue;
            };
            // Those of two complex poles are conjugates.
            let paired = one.at == other.at;
            let first = one.away_from(&taken);
            taken.push(first);
            let upper = C::new(first.re, first.im.abs());
            let pair = if paired { [upper, upper.conj()] } else { [first, other.away_from(&taken)] };
            taken.push(pair[1]);
            starts.pairs.push(pair);
        }
        starts
    }

    /// The same, each pole turned and moved inward: far from all of them, and none paired.
    pub(super) fn turned_starts(&self) -> Starts {
        let mut starts = Starts::default();
        let poles = self.equations.kernel().modes().iter().map(|mode| mode.poles());
        for both in poles {
            let (alive, dead): (Vec<C>, Vec<C>) = both.into_iter().partition(|pole| modulus(*pole) >= DEAD);
            starts.dead.extend(dead);
            match alive[..] {
                [one, other] => starts.pairs.push([one, other]),
                _ => starts.single.extend(alive),
            }
        }
        // Those of one pole must not be the same.
        let count = starts.pairs.len() as f64;
        let by = |k: usize| C::from_polar(INWARD - 0.1 * (1.0 - INWARD) * k as f64 / count, TURNED);
        starts.pairs.iter_mut().enumerate().for_each(|(k, both)| *both = both.map(|pole| pole * by(k)));
        starts.single.iter_mut().for_each(|pole| *pole *= C::from_polar(INWARD, -TURNED));
        starts
    }

    /// The starts beside the first or second pole of `count` modes that are alike.
    fn beside(&self, from: usize, count: usize, which: usize) -> Vec<Beside> {
        let own: Vec<_> = (from..from + count).map(|k| self.poles_of(k)[which]).collect();
        let pole = own[0].value;
        let others = self.of_simple_poles().filter(|k| !(from..from + count).contains(k));
        let others = others.flat_map(|k| &self.poles[2 * k..2 * k + 2]);
        let gap = others.map(|other| modulus(other - pole)).fold(modulus(pole), f64::min);
        let size = self.equations.size();
        let all = size + count;
        let bordered = DMatrix::from_row_slice(all, all, &self.bordered(pole, &own));
        let offsets = || {
            let (apart, a) = (bordered.view((0, 0), (size, size)), bordered.view((0, size), (size, count)));
            let c = bordered.view((size, 0), (count, size));
            let offsets: DMatrix<C> = c * apart.clone_owned().lu().solve(&a.clone_owned())?;
            let finite = offsets.iter().all(|entry| entry.re.is_finite() && entry.im.is_finite());
            if finite && count == 1 {
                return Some(vec![offsets[(0, 0)]]);
            }
            let schur = if finite { Schur::try_new(offsets, f64::EPSILON, 100 * count)? } else { return None };
            Some(schur.eigenvalues()?.iter().copied().collect::<Vec<_>>())
        };
        let offsets = offsets().unwrap_or_else(|| vec![C::default(); count]);
        let start = |offset: C| {
            // A start on the pole itself says nothing; a real one would never leave the axis.
            let offset = if modulus(offset) > HIDDEN * gap { offset } else { C::new(0.0, HIDDEN * gap) };
            let offset = if (pole + offset).im == 0.0 { offset * C::new(1.0, 1e-3) } else { offset };
            Beside { at: pole + offset * (WAY * gap / modulus(offset)).min(1.0), pole, gap }
        };
        offsets.into_iter().map(start).collect()
    }
}

impl Beside {
    /// The start, or another one half-way to the next pole where one that is taken is as near.
    fn away_from(&self, taken: &[C]) -> C {
        let length = modulus(self.at - self.pole);
        let is_free = |z: C| taken.iter().all(|other| modulus(other - z) > ALIKE * modulus(z - self.pole));
        let around = (0..TURNS).map(|k| self.pole + C::from_polar(0.5 * self.gap, TURNED + f64::from(k)));
        std::iter::once(self.at).chain(around).find(|z| is_free(*z)).unwrap_or(self.at + 0.5 * length)
    }
}

//! All multipliers of an orbit in order, each made as it is asked for: by falling modulus, then by argument.
//!
//! Those of the modes that feel no impact are known in closed form, e^{±iΩT}: half of a ring's need not be written down before they are
//! needed. Of the others what the order asks for is worked out once. On the circle the two runs are merged.

use nalgebra::Complex;
use vibrochain_breather::LatticeOrbit;

use crate::multipliers::{modulus_in_order, spared_modes};
use crate::verdict::Verdict;

type C = Complex<f64>;

/// Multipliers and verdict of one orbit, as [`crate::Stability`] has them, without a list of all of them: those of the modes that feel no
/// impact are made as they are asked for.
///
/// ```
/// use vibrochain_breather::{Family, Finder, breathers};
/// use vibrochain_floquet::{Analyser, Tolerance};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 0.8, 0.4)?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let multipliers = Analyser::default().multipliers(orbit, &mut Finder::new(21), Tolerance::Rounding)?;
/// assert!(multipliers.len() == 42 && multipliers.sorted().count() == 42);
/// assert!((multipliers.sorted().next().unwrap_or_default() - multipliers.verdict.leading).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Multipliers {
    /// The verdict; its [`Verdict::method`] is that of the multipliers, too.
    pub verdict: Verdict,
    /// Those that were worked out, as they were found.
    found: Vec<C>,
    /// How many are known to be 1.
    trivial: usize,
    spared: Spared,
}

impl Multipliers {
    pub(crate) fn new(verdict: Verdict, found: Vec<C>, trivial: usize, spared: Spared) -> Self {
        Self { verdict, found, trivial, spared }
    }

    /// Number of multipliers, 2M.
    pub fn len(&self) -> usize {
        self.found.len() + self.trivial + 2 * self.spared.0.len()
    }

    /// There is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All multipliers in the order of [`crate::sort_multipliers`]. Of those that are alike to it, found ones come before the trivial pair
    /// of a conservative orbit, and that before the modes that feel no impact.
    pub fn sorted(&self) -> impl Iterator<Item = Complex<f64>> + '_ {
        // Without losses nearly all are on the circle.
        let (mut outside, mut on_circle) = (Vec::new(), Vec::with_capacity(self.found.len()));
        for (place, z) in self.found.iter().enumerate() {
            let (modulus, argument, place) = (modulus_in_order(z), z.arg(), place as u32);
            if modulus == 1.0 {
                on_circle.push((argument, place));
            } else {
                outside.push((modulus, argument, place));
            }
        }
        // Places differ, so that there is one order.
        outside.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        on_circle.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let inside = outside.split_off(outside.partition_point(|away| away.0.total_cmp(&1.0).is_gt()));
        let found = |place: u32| self.found[place as usize];
        let away = move |list: Vec<(f64, f64, u32)>| list.into_iter().map(move |(_, _, place)| found(place));
        let on_circle = on_circle.into_iter().map(move |(argument, place)| (argument, found(place)));
        let trivial = std::iter::repeat_n((0.0, C::new(1.0, 0.0)), self.trivial);
        let on_circle = merged(merged(on_circle, trivial), self.spared.around());
        // Boxed here, where it is optimised, whoever asks.
        Box::new(away(outside).chain(on_circle.map(|(_, z)| z)).chain(away(inside))) as Box<dyn Iterator<Item = C> + '_>
    }
}

/// Two runs by rising argument in one; where both are alike the first run's come first.
fn merged(
    first: impl Iterator<Item = (f64, C)>,
    second: impl Iterator<Item = (f64, C)>,
) -> impl Iterator<Item = (f64, C)> {
    let (mut first, mut second) = (first.peekable(), second.peekable());
    std::iter::from_fn(move || match (first.peek(), second.peek()) {
        (Some((a, _)), Some((b, _))) if a.total_cmp(b).is_gt() => second.next(),
        (Some(_), _) => first.next(),
        (None, _) => second.next(),
    })
}

/// The modes that feel no impact, by rising argument of that one of their two multipliers which is not below the real axis.
#[derive(Debug, Clone, Default)]
pub(crate) struct Spared(Vec<SparedMode>);

#[derive(Debug, Clone, Copy)]
struct SparedMode {
    argument: f64,
    /// ±ΩT
    phase: f64,
    number: u32,
}

impl SparedMode {
    fn above(&self) -> C {
        C::from_polar(1.0, self.phase)
    }
}

impl Spared {
    /// Those of an orbit whose impacts are at one site.
    pub(crate) fn of(orbit: LatticeOrbit<'_>) -> Self {
        Self::new(orbit.period(), spared_modes(orbit).unwrap_or_default().into_iter())
    }

    /// Modes by number and frequency, by rising number.
    pub(crate) fn new(period: f64, modes: impl Iterator<Item = (usize, f64)>) -> Self {
        let mode = |(number, frequency): (usize, f64)| {
            let phase = frequency * period;
            let argument = C::from_polar(1.0, phase).arg();
            SparedMode { argument: argument.abs(), phase: phase.copysign(argument), number: number as u32 }
        };
        let mut list: Vec<SparedMode> = modes.map(mode).collect();
        // Modes of one number are alike.
        list.sort_unstable_by(|a, b| a.argument.total_cmp(&b.argument).then(a.number.cmp(&b.number)));
        Self(list)
    }

    /// Both multipliers of each, once around the circle from −π to π.
    fn around(&self) -> impl Iterator<Item = (f64, C)> + '_ {
        let alike = self.0.chunk_by(|a, b| a.argument == b.argument);
        let below = alike.rev().flatten().map(|mode| (-mode.argument, C::from_polar(1.0, -mode.phase)));
        below.chain(self.0.iter().map(|mode| (mode.argument, mode.above())))
    }

    /// The number of the last mode one of whose multipliers is `z`, of this argument or minus that; `from` is where the last search
    /// ended.
    pub(crate) fn number(&self, z: C, argument: f64, from: &mut usize) -> Option<usize> {
        *from = partition_point_from(&self.0, *from, |mode| mode.argument < argument);
        let alike = self.0[*from..].iter().take_while(|mode| mode.argument == argument);
        let bits = |z: C| (z.re.to_bits(), z.im.abs().to_bits());
        alike.filter(|mode| bits(mode.above()) == bits(z)).last().map(|mode| mode.number as usize)
    }
}

/// As [`slice::partition_point`], quick where the answer is next to `from`.
pub(crate) fn partition_point_from<T>(list: &[T], from: usize, below: impl Fn(&T) -> bool) -> usize {
    let (mut low, mut high, mut step) = (from, from, 1);
    while high < list.len() && below(&list[high]) {
        (low, high, step) = (high + 1, high + step, 2 * step);
    }
    while low > 0 && !below(&list[low - 1]) {
        (low, high, step) = (low.saturating_sub(step), low - 1, 2 * step);
    }
    let high = high.clamp(low, list.len());
    low + list[low..high].partition_point(below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_from_anywhere_ends_where_one_from_the_middle_does() {
        let mut random = fastrand::Rng::with_seed(3);
        for _ in 0..2000 {
            let mut list: Vec<u32> = (0..random.usize(0..40)).map(|_| random.u32(0..30)).collect();
            list.sort_unstable();
            let (from, value) = (random.usize(0..=list.len()), random.u32(0..31));
            let expected = list.partition_point(|other| *other < value);
            assert_eq!(partition_point_from(&list, from, |other| *other < value), expected, "{list:?} {from} {value}");
        }
    }
}

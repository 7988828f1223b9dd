//! How far an orbit's times, impulses and accelerations may be from those of the model.
//!
//! Rows F of the equations are off by what is left of them and by bounds of their errors, δF. To first order unknowns are off by r = |J⁻¹|δF.
//! That is a bound only as long as J does not change much on the way: with H = Σ_k |J⁻¹ ∂_kJ| r′_k, from the equations at points a little
//! aside, there is a root within r′ if r + H r′ ≤ r′ (Krawczyk). r′ begins at 2r and is widened where it does not hold; where that does not help nothing
//! is known.

use smallvec::SmallVec;

use super::equations::{Equations, System};
use super::periodic_kernel::UNIT;
use super::point::{Point, Strike};
use crate::equations::linear::{Factors, Matrix, Vector, dot, zeros};
use crate::error::BreatherError;

/// Unknowns that are off by less, as parts of what they can be, have no square that counts: next to a fold at the distance of the root of
/// rounding they are off by about that root.
const FIRST_ORDER: f64 = 1e-10;

/// How often r′ is widened before no bound is known.
const WIDENED: usize = 3;

/// A time that is off by more of the period is not known.
const MOST: f64 = 0.05;

/// Errors of an impact, in units of what they are errors of.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ImpactError {
    /// Of its time.
    pub time: f64,
    /// Of its impulse.
    pub impulse: f64,
    /// Of the acceleration there.
    pub acceleration: f64,
}

impl ImpactError {
    /// Of what is not known.
    pub(crate) const LOST: Self = Self { time: f64::INFINITY, impulse: f64::INFINITY, acceleration: f64::INFINITY };
}

/// Errors of one origin: what it does to each impact, with signs.
pub type Together = SmallVec<[ImpactError; 2]>;

/// Bounds of errors of an orbit.
#[derive(Debug, Clone)]
pub(super) struct OrbitErrors {
    /// Of the unknowns, and of the acceleration at each impact.
    pub(super) unknowns: Vector,
    pub(super) accelerations: Vector,
    /// The same by origin.
    pub(super) origins: Vec<Together>,
    /// Those of the unknowns and of the accelerations to first order, by which orbits are told apart, and judged, where no bound is known.
    pub(super) estimates: [Vector; 2],
}

impl OrbitErrors {
    /// Those of a point that solves the equations; `on_the_way` those that first order bounds alone.
    ///
    /// # Errors
    /// As [`Equations::system`].
    pub(super) fn of(
        equations: &Equations<'_>,
        point: &Point,
        system: &System,
        on_the_way: bool,
    ) -> Result<Self, BreatherError> {
        let (n, size) = (point.strikes.len(), system.rows.len());
        let off: Vector = system.rows.iter().zip(&system.sizes).map(|(row, size)| row.abs() + UNIT * size).collect();
        let own: Vector = system.arrivals.iter().map(|arrival| 2.0 * UNIT * arrival.sizes[2]).collect();
        let lost = |count: usize| -> Vector { SmallVec::from_elem(f64::INFINITY, count) };
        // At a fold the unknowns are not determined by the rows.
        let Some(factors) = Factors::new(system.jacobian.clone()) else {
            return Ok(Self::unknown([lost(size), lost(n)]));
        };
        let inverse = factors.inverse();
        let mut first: Vector = (0..size).map(|i| weighted(inverse.row(i), &off)).collect();
        let along = |i: usize, moved: &[f64]| dot(&system.gradients[i], moved);
        let mut origins: Vec<Together> = Vec::with_capacity(2 * size + n);
        for row in 0..size {
            let moved: Vector = (0..size).map(|i| inverse[(i, row)] * off[row]).collect();
            origins.push((0..n).map(|i| equations.impact_error(n, i, &moved, along(i, &moved))).collect());
        }
        // What is one number in all rows keeps its signs.
        let mut apart = own;
        for doubt in equations.resonant_doubts(point).into_iter().chain(equations.doubts_of_open(point)?) {
            let moved: Vector = factors.solve(&doubt.rows).iter().map(|by| -by).collect();
            first.iter_mut().zip(&moved).for_each(|(error, by)| *error += by.abs());
            let carried = |i: usize| along(i, &moved) + doubt.accelerations[i];
            origins.push((0..n).map(|i| equations.impact_error(n, i, &moved, carried(i))).collect());
            // Both are far larger than their sum, of which as many digits are left as the matrix lets be.
            for (i, error) in apart.iter_mut().enumerate() {
                let size: f64 = system.gradients[i].iter().zip(&moved).map(|(slope, by)| (slope * by).abs()).sum();
                *error += size * f64::EPSILON * equations.steepest();
            }
        }
        let of_accelerations = |apart: &Vector, origins: &[Together]| -> Vector {
            let carried = |i: usize| origins.iter().map(|origin| origin[i].acceleration.abs()).sum::<f64>();
            apart.iter().enumerate().map(|(i, apart)| apart + carried(i)).collect()
        };
        let estimates = [first.clone(), of_accelerations(&apart, &origins)];
        if !first.iter().all(|error| error.is_finite()) {
            return Ok(Self::unknown([lost(size), lost(n)]));
        }
        let mut unknowns = first;
        if equations.parts(point, &unknowns) > FIRST_ORDER {
            if on_the_way {
                return Ok(Self::unknown(estimates));
            }
            let beyond = beyond_first_order(equations, point, system, (&factors, &unknowns))?;
            let Some((bent, more)) = beyond else { return Ok(Self::unknown(estimates)) };
            apart.iter_mut().zip(more).for_each(|(error, by)| *error += by);
            for (place, by) in bent.iter().enumerate().filter(|(_, by)| **by > 0.0) {
                let mut moved = zeros(size);
                moved[place] = *by;
                unknowns[place] += by;
                origins.push((0..n).map(|i| equations.impact_error(n, i, &moved, along(i, &moved))).collect());
            }
        }
        let accelerations = of_accelerations(&apart, &origins);
        let late = |strike: &Strike| ImpactError { time: equations.fixed_time_error(strike), ..ImpactError::default() };
        origins.push(point.strikes.iter().map(late).collect());
        for (i, acceleration) in apart.into_iter().enumerate() {
            let mut origin: Together = SmallVec::from_elem(ImpactError::default(), n);
            origin[i].acceleration = acceleration;
            origins.push(origin);
        }
        Ok(Self { unknowns, accelerations, origins, estimates })
    }

    fn unknown(estimates: [Vector; 2]) -> Self {
        let [unknowns, accelerations] = estimates.each_ref().map(|list| SmallVec::from_elem(f64::INFINITY, list.len()));
        let origins = vec![SmallVec::from_elem(ImpactError::LOST, accelerations.len())];
        Self { unknowns, accelerations, origins, estimates }
    }
}

/// Σ |a_i| b_i
fn weighted(row: &[f64], by: &[f64]) -> f64 {
    row.iter().zip(by).map(|(x, off)| x.abs() * off).sum()
}

impl Equations<'_> {
    /// Half a period is rounded.
    pub(super) fn fixed_time_error(&self, strike: &Strike) -> f64 {
        if self.is_mirrored && strike.time > 0.0 { f64::EPSILON * self.period() } else { 0.0 }
    }

    /// What changes of the unknowns do to impact `i` of `n`, with that of its acceleration.
    pub(super) fn impact_error(&self, n: usize, i: usize, moved: &[f64], acceleration: f64) -> ImpactError {
        ImpactError { time: self.time(n, i).map_or(0.0, |place| moved[place]), impulse: moved[i], acceleration }
    }
}

/// What is to be added to errors r of first order, and to those of accelerations; `None` where no bound is known.
fn beyond_first_order(
    equations: &Equations<'_>,
    point: &Point,
    system: &System,
    (factors, first): (&Factors, &Vector),
) -> Result<Option<(Vector, Vector)>, BreatherError> {
    // A little more than nothing for what is not off at all.
    let least: Vector = equations.scales(point).iter().map(|scale| f64::EPSILON * scale).collect();
    let first: Vector = first.iter().zip(&least).map(|(first, least)| first + least).collect();
    let mut reach: Vector = first.iter().map(|first| 2.0 * first).collect();
    for _ in 0..WIDENED {
        let Some((bent, accelerations)) = bent(equations, point, system, (factors, &reach))? else { return Ok(None) };
        let whole: Vector = first.iter().zip(&bent).map(|(first, bent)| first + bent).collect();
        if whole.iter().zip(&reach).all(|(whole, reach)| whole <= reach) {
            return Ok(Some((bent, accelerations)));
        }
        // An unknown that hardly moves to first order moves with the squares of others.
        reach = whole.iter().zip(&reach).map(|(whole, reach)| reach.max(2.0 * whole)).collect();
    }
    Ok(None)
}

/// H r′ for errors r′, and what these do to accelerations beyond first order; `None` where a time is not known.
fn bent(
    equations: &Equations<'_>,
    point: &Point,
    system: &System,
    (factors, reach): (&Factors, &Vector),
) -> Result<Option<(Vector, Vector)>, BreatherError> {
    let (n, size) = (point.strikes.len(), reach.len());
    let times = &reach[equations.times(n)];
    if times.iter().any(|time| *time > MOST * equations.period()) {
        return Ok(None);
    }
    let mut bent = zeros(size);
    let add = |bent: &mut Vector, matrix: &Matrix, less: f64| {
        for j in 0..size {
            let column: Vector = (0..size).map(|i| matrix[(i, j)]).collect();
            for (i, (by, entry)) in bent.iter_mut().zip(factors.solve(&column)).enumerate() {
                *by += (entry - if i == j { less } else { 0.0 }).abs() * reach[j];
            }
        }
    };
    // The inverse of a matrix that is nearly singular is none.
    add(&mut bent, &system.jacobian, 1.0);
    let mut accelerations = zeros(n);
    for place in 0..size {
        let mut step = zeros(size);
        step[place] = reach[place];
        let mut aside = point.clone();
        equations.take(&mut aside, &step);
        let there = equations.system(&aside)?;
        let change = Matrix::from_fn(size, |i, j| there.jacobian[(i, j)] - system.jacobian[(i, j)]);
        add(&mut bent, &change, 0.0);
        for (i, by) in accelerations.iter_mut().enumerate() {
            let change = |j: usize| (there.gradients[i][j] - system.gradients[i][j]).abs() * reach[j];
            *by += (0..size).map(change).sum::<f64>();
        }
    }
    Ok(Some((bent, accelerations)))
}

impl Equations<'_> {
    /// What unknowns are measured by: impulses by the largest, times by the inverse of the fastest mode's rate, offsets by themselves.
    fn scales(&self, point: &Point) -> Vector {
        let n = point.strikes.len();
        let impulse = point.strikes.iter().map(|strike| strike.impulse.abs()).fold(0.0, f64::max);
        let time = self.kernel().fastest().max(self.period().recip()).recip();
        let offset = point.offsets.iter().fold(0.0, |most: f64, offset| most.max(offset.abs()));
        let of = |k: usize| match k {
            k if k < n => impulse,
            k if k < self.unknowns(n) - point.offsets.len() => time,
            _ => offset,
        };
        (0..self.unknowns(n)).map(of).collect()
    }

    /// How much more than by rounding a mode next to a resonance is off at most.
    fn steepest(&self) -> f64 {
        self.kernel().nearly_resonant().map(|(_, doubt)| doubt / f64::EPSILON).fold(1.0, f64::max)
    }

    /// The largest part of its scale that an unknown is off by.
    fn parts(&self, point: &Point, errors: &[f64]) -> f64 {
        let parts =
            errors.iter().zip(self.scales(point)).map(|(error, scale)| if *error > 0.0 { error / scale } else { 0.0 });
        parts.fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape};

    use crate::structures::flight::ContactMotion;
    use crate::structures::model::LoadedStructure;
    use crate::structures::orbit::ContactOrbit;

    /// One mass under a load, with stops at ±`stop`.
    fn model(stop: f64, omega: f64, decay: f64, loads: f64) -> LoadedStructure {
        let shape = ModeShape { contacts: vec![1.0], coordinates: Vec::new(), still: 0.0 };
        let mut mode = LinearMode::oscillator(decay, 1.0 - decay * decay, &shape, &[Complex::new(1.0, 0.0)]);
        mode.errors.loads[0] += loads;
        let stop = Contact { lower: Some(-stop), upper: Some(stop), restitution: 0.8 };
        let structure = ModalStructure::new(vec![stop], vec![1], vec![mode]).unwrap();
        LoadedStructure::new(Arc::new(structure), omega).unwrap()
    }

    fn orbits(model: &LoadedStructure, word: &str) -> Vec<ContactOrbit> {
        model.orbits(&word.parse().unwrap(), 1).unwrap().contacts().cloned().collect()
    }

    /// The acceleration at an impact moves with the unknowns as much as by its own terms: a load that is known worse moves impulse, phase and
    /// acceleration as far as orbits of the other load are away.
    #[test]
    fn errors_of_a_load_are_carried_to_accelerations() {
        let off = 1e-7;
        let (mut checked, mut near) = (0, 0);
        for omega in [2.1, 2.325, 2.6] {
            let (rough, exact) = (model(0.1, omega, 0.05, off), model(0.1, omega, 0.05, 0.0));
            let moved = model(0.1, omega, 0.05, 0.0);
            let moved = Arc::new(moved.structure().with_loads_times(1.0 + off, 1.0));
            let moved = LoadedStructure::new(moved, omega).unwrap();
            for word in ["0+", "0+,0-"] {
                let lists = [&rough, &exact, &moved].map(|model| orbits(model, word));
                for (rough, (exact, moved)) in lists[0].iter().zip(lists[1].iter().zip(&lists[2])) {
                    let all = rough.impact_errors().iter().zip(exact.impacts()).zip(moved.impacts());
                    for ((told, a), b) in all {
                        let apart = [
                            (a.impulse - b.impulse, told.impulse),
                            (a.time - b.time, told.time),
                            (a.acceleration - b.acceleration, told.acceleration),
                        ];
                        for (off, error) in apart {
                            assert!(off.abs() <= error, "{word} {omega}: {off:e} {error:e}");
                        }
                        // Its own terms are off by 4e-15, and that is not all.
                        let (off, error) = apart[2];
                        assert!(off.abs() > 1e-9 && error < 1e3 * off.abs(), "{word} {omega}: {off:e} {error:e}");
                        checked += 1;
                    }
                    let [told, right] = [rough, moved].map(|orbit| ContactMotion::new(orbit).unwrap());
                    for i in 0..rough.impacts().len() {
                        let jets = [&told, &right].map(|motion| motion.jet(0, i, 0.0));
                        for order in 0..4 {
                            let (off, error) = ((jets[0][order] - jets[1][order]).abs(), told.error(0, order, i));
                            assert!(off <= error && error < 1e-4, "{word} {omega} {i} {order}: {off:e} {error:e}");
                            near += usize::from(error < 1e3 * off);
                        }
                    }
                }
            }
        }
        // Places are the barriers'.
        assert!(checked >= 12 && near >= checked / 2, "{checked} {near}");
    }

    /// Two orbits that are born in a fold part like the root of the distance: what is off by more than that distance may be either, or none,
    /// and no bound of it is known. Farther away the bound holds.
    #[test]
    fn next_to_a_fold_no_bound_is_known_where_first_order_is_not_enough() {
        // One impact a period is there where |g|·√(…) reaches the stop: from here on there are none.
        let swing = |stop: f64| orbits(&model(stop, 2.325, 0.05, 0.0), "0+").len();
        let (mut there, mut gone) = (0.1, 10.0);
        while gone - there > 1e-15 * gone {
            let middle = 0.5 * (there + gone);
            if middle <= there || middle >= gone {
                break;
            }
            if swing(middle) == 2 { there = middle } else { gone = middle }
        }
        let (mut open, mut known) = (0, 0);
        for power in -14..-3 {
            let distance = 10f64.powi(power);
            let (rough, other) =
                (model(there - distance, 2.325, 0.05, 1e-9), model(there - distance, 2.325, 0.05, 0.0));
            let moved =
                LoadedStructure::new(Arc::new(other.structure().with_loads_times(1.0 + 1e-9, 1.0)), 2.325).unwrap();
            for (told, exact) in orbits(&rough, "0+").iter().zip(orbits(&moved, "0+")) {
                let off = (told.impacts()[0].impulse - exact.impacts()[0].impulse).abs();
                let told = told.impact_errors()[0].impulse;
                assert!(off <= told, "{distance:e}: {off:e} {told:e}");
                *(if told.is_finite() { &mut known } else { &mut open }) += 1;
                assert!(power > -9 || told.is_infinite(), "{distance:e} {told:e}");
            }
        }
        assert!(open >= 6 && known >= 6, "{open} {known}");
    }

    /// Next to a resonance of a mode that nothing damps its frequency moves an acceleration by itself and, the other way, through impulses and
    /// phase: what is told is about the sum, which orbits of another frequency show.
    #[test]
    fn what_a_frequency_moves_next_to_a_resonance_is_told_with_its_signs() {
        let (mut checked, mut near) = (0, 0);
        for (omega, distance, off) in [(2.325, 1e-5, 1e-10), (2.325, -1e-6, 1e-11), (2.6, 1e-6, 1e-11)] {
            let model = |shift: f64, doubt: f64| {
                let shape = |seen: f64| ModeShape { contacts: vec![seen], coordinates: Vec::new(), still: 0.0 };
                let load = |size: f64| [Complex::new(size, 0.0)];
                let frequency: f64 = 2.0 * omega + distance + shift;
                let mut free = LinearMode::oscillator(0.0, frequency.powi(2), &shape(0.4), &load(0.0));
                free.errors.poles += doubt;
                let modes = vec![LinearMode::oscillator(0.05, 0.9975, &shape(1.0), &load(1.0)), free];
                let stop = Contact { lower: None, upper: Some(0.1), restitution: 0.8 };
                let structure = ModalStructure::new(vec![stop], vec![1], modes).unwrap();
                LoadedStructure::new(Arc::new(structure), omega).unwrap()
            };
            let lists = [model(0.0, off), model(off, 0.0)].map(|model| orbits(&model, "0+"));
            for (told, moved) in lists[0].iter().zip(&lists[1]) {
                let apart = (told.impacts()[0].acceleration - moved.impacts()[0].acceleration).abs();
                let told = told.impact_errors()[0].acceleration;
                assert!(apart <= told);
                // Each of the two is as much larger as the distance is than the doubt: 10⁵ times.
                near += usize::from(told < 100.0 * apart);
                checked += 1;
            }
        }
        assert!(checked >= 3 && near == checked, "{checked} {near}");
    }
}

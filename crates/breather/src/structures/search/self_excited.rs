//! Orbits of structures that no load drives and a negative dashpot excites: nothing gives their period, which is an unknown like times.
//!
//! Of one impact Newton's law alone holds the period,
//!
//! ```text
//! F(T) = 1/m + (1+e)K′ = 0,     K′ a period after the impact,
//! ```
//!
//! and the place gives the impulse. All zeros of F between two periods are enclosed. With A the generator of a mode and R = e^{AT},
//!
//! ```text
//! K′ = ΣAR(1−R)⁻¹,    K′_T = ΣA²R(1−R)⁻²,    K′_TT = ΣA³R(1+R)(1−R)⁻³
//! ```
//!
//! between what the contact sees and what it is given. Of more impacts Newton's method begins at many periods and times.

use std::f64::consts::TAU;

use vibrochain_lattice::simd::lanes::{LANES, Lane};
use vibrochain_lattice::{Complex, LinearMode, Turn};

use super::at_times::{Impacts, Start};
use super::orbits::Starts;
use super::starts::{STARTS, golden};
use super::two_impacts::RESOLUTION;
use crate::error::BreatherError;
use crate::roots::interval::{Clearance, Enclosed, Zeros};
use crate::search::completeness::{Partial, Searched};
use crate::structures::periodic_kernel::{PeriodicKernel, length};
use crate::structures::point::Point;

/// Periods that are searched: from this part of the fastest mode's to so many of the slowest one's.
const SHORTEST: f64 = 1e-3;
const LONGEST: f64 = 4.0;

/// Intervals to begin with, at least and at most.
const PIECES: [usize; 2] = [64, 4096];

/// A mode that grows by less than this part of its frequency may do so by rounding.
const GROWTH: f64 = 1e-12;

/// Rounding of a term with the few operations that it takes.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

impl Impacts<'_> {
    /// Whether a mode grows by itself. Without one, losses end every motion.
    pub(super) fn are_excited(&self) -> bool {
        let grows = |mode: &LinearMode| mode.rates().iter().any(|rate| rate.re > GROWTH * rate.norm());
        self.equations.model.structure().modes().iter().any(grows)
    }

    /// The shortest and the longest period that are searched.
    pub(super) fn periods(&self) -> [f64; 2] {
        let modes = self.equations.kernel().felt.modes.iter();
        let frequencies: Vec<f64> = modes.map(frequency).filter(|frequency| *frequency > 0.0).collect();
        let fastest = frequencies.iter().copied().fold(0.0, f64::max);
        let slowest = frequencies.iter().copied().fold(fastest, f64::min);
        [SHORTEST * TAU / fastest, LONGEST * TAU / slowest]
    }

    /// Starts of orbits whose period is an unknown, between two periods.
    pub(super) fn of_own_period(&self, periods: [f64; 2]) -> Starts {
        match self.letters.len() {
            1 => self.proved_periods(periods).unwrap_or_else(|| self.starts_of_periods(periods)),
            _ => self.starts_of_periods(periods),
        }
    }

    /// Of one impact all zeros of F; `None` where it cannot be enclosed, or takes too long.
    fn proved_periods(&self, [from, to]: [f64; 2]) -> Option<Starts> {
        let law = PeriodLaw::new(self)?;
        let mut zeros = Zeros::default();
        zeros.stop = self.equations.model.stop().clone();
        let pieces = ((law.fastest() * to) as usize).clamp(PIECES[0], PIECES[1]);
        zeros.find(&law, from, to, pieces, |_| RESOLUTION * to);
        if zeros.exhausted > 0 {
            return None;
        }
        let (mut starts, mut unresolved) = (Vec::new(), zeros.unresolved.len());
        let known = zeros.simple.iter().map(|period| (*period, true));
        for (period, is_zero) in known.chain(zeros.unresolved.iter().map(|period| (*period, false))) {
            match self.of_period(period, &[0.0]) {
                Ok(Some(point)) => starts.push(Start::new(point, is_zero)),
                Ok(None) => unresolved += usize::from(is_zero),
                Err(error) => return Some(Err(error)),
            }
        }
        Some(Ok((starts, Searched { intervals: zeros.intervals, unresolved, ..Searched::default() })))
    }

    /// Starts spread over periods and times.
    fn starts_of_periods(&self, [from, to]: [f64; 2]) -> Starts {
        let n = self.letters.len();
        let mut starts = Vec::with_capacity(STARTS);
        for number in 1..=STARTS {
            let spread = |axis: usize| (0.5 + number as f64 * golden(axis, n)).fract();
            let period = from + (to - from) * spread(0);
            let mut times: Vec<f64> = (1..n).map(|axis| period * spread(axis)).collect();
            times.push(0.0);
            times.sort_by(f64::total_cmp);
            let point = self.of_period(period, &times)?;
            // A start that pulls leads to orbits that do.
            starts.extend(point.filter(|point| !point.pulls()).map(Start::from));
        }
        Ok((starts, Searched::partial(Partial::Starts(STARTS))))
    }

    /// Impulses and offsets by the positions at given times; `None` where these leave them open.
    fn of_period(&self, period: f64, times: &[f64]) -> Result<Option<Point>, BreatherError> {
        self.equations.model.heard()?;
        self.equations.at_period(period, |equations| {
            let impacts = Impacts { equations, letters: self.letters.clone() };
            let solved = impacts.linear(times)?.solve();
            let solved = solved.filter(|x| x.iter().all(|x| x.is_finite()));
            Ok(solved.map(|x| impacts.point(times, &x)))
        })
    }
}

/// Of a mode, the root of the product of its poles, or the one that is not 0.
fn frequency(mode: &LinearMode) -> f64 {
    let [one, other] = mode.rates().map(|rate| rate.norm());
    if one * other > 0.0 { (one * other).sqrt() } else { one.max(other) }
}

/// Newton's law of one impact as a function of the period.
struct PeriodLaw<'a> {
    impacts: &'a Impacts<'a>,
    contact: usize,
    weight: f64,
}

impl<'a> PeriodLaw<'a> {
    /// `None` where a mode's poles are double, and of rigid modes with a dashpot.
    fn new(impacts: &'a Impacts<'a>) -> Option<Self> {
        let [(contact, _)] = impacts.letters[..] else { return None };
        let law = Self { impacts, contact, weight: 1.0 + impacts.equations.restitution(contact) };
        let simple = |mode: &LinearMode| {
            if mode.is_rigid() { mode.decay == 0.0 } else { mode.turn != Turn::Parabolic }
        };
        let all = law.modes().all(simple);
        all.then_some(law)
    }

    fn modes(&self) -> impl Iterator<Item = &LinearMode> {
        self.impacts.equations.kernel().felt.modes.iter()
    }

    fn fastest(&self) -> f64 {
        self.modes().map(frequency).fold(0.0, f64::max)
    }

    /// F and its derivative, and what rounding makes of the first.
    fn jet(&self, period: f64) -> ([f64; 2], f64) {
        let equations = self.impacts.equations;
        let (modes, felt) = (equations.model.structure().modes(), equations.kernel().felt.clone());
        let kernel = PeriodicKernel::new(modes, felt, &[self.contact], period);
        let (jet, sizes) = kernel.jet(self.contact, self.contact, 0.0);
        let slope = kernel.by_period(self.contact, self.contact, 0.0)[1];
        let mobility = equations.mobility(self.contact);
        let value = mobility + self.weight * jet[1];
        ([value, self.weight * slope], ROUNDING * (mobility + self.weight * sizes[1]))
    }

    /// A bound of |F″| between two periods.
    fn bend(&self, from: f64, to: f64) -> f64 {
        let of = |mode: &LinearMode| {
            // Of a mode that nothing damps, K′ is −½ of what it does in a moment, at any period.
            if mode.is_rigid() || mode.resonant_frequency().is_some() && mode.is_real {
                return 0.0;
            }
            let reach = length(mode.rows[self.contact]) * length(mode.columns[self.contact]);
            // Of two real poles the larger bound, as of a conjugate pair either.
            let own = mode.rates().map(|rate| {
                // R(1+R)/(1−R)³ only changes its sign when R is replaced by 1/R, so |R| ≤ 1 may be assumed.
                let (growth, turn) = (rate.re.abs(), rate.im);
                let most = (-growth * from).exp();
                let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
                let there = Complex::new(-growth * middle, turn * middle).exp();
                let around = (1.0 - there).norm() - there.norm() * (rate.norm() * half).exp_m1();
                let off = around.max(-(-growth * from).exp_m1());
                if off > 0.0 { rate.norm().powi(3) * most * (1.0 + most) / off.powi(3) } else { f64::INFINITY }
            });
            if reach == 0.0 { 0.0 } else { reach * own[0].max(own[1]) }
        };
        self.weight * self.modes().map(of).sum::<f64>()
    }
}

impl Enclosed for PeriodLaw<'_> {
    fn clearances(&self, centres: Lane, radii: Lane) -> [Clearance; LANES] {
        std::array::from_fn(|i| {
            let (centre, radius) = (centres[i], radii[i]);
            let ([value, slope], doubt) = self.jet(centre);
            let bend = self.bend(centre - radius, centre + radius) * (1.0 + 1e-9);
            let function = value.abs() - (slope.abs() + 0.5 * bend * radius) * radius - doubt;
            // Of the slope rounding is as large a part.
            let derivative = slope.abs() - bend * radius - doubt * self.fastest();
            let end = |period: f64| {
                let ([value, _], doubt) = self.jet(period);
                if value.abs() > doubt { value } else { 0.0 }
            };
            // They are asked for where there may be a zero, and one alone.
            let alone = function <= 0.0 && derivative > 0.0;
            let ends = if alone { [centre - radius, centre + radius].map(end) } else { [0.0; 2] };
            Clearance { function, derivative, ends, centre: (value, slope) }
        })
    }

    fn at(&self, period: f64) -> (f64, f64) {
        let ([value, slope], _) = self.jet(period);
        (value, slope)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use smallvec::smallvec;
    use vibrochain_lattice::{Barrier, Contact, ModalStructure, ModeShape};
    use vibrochain_testkit::Random;

    use super::*;
    use crate::structures::equations::Equations;
    use crate::structures::model::LoadedStructure;

    fn model(random: &mut Random, modes: usize) -> LoadedStructure {
        let mode = |k: usize| {
            let (frequency, ratio) = (random.log(0.3, 6.0), random.log(1e-3, 0.4));
            let ratio = if k == 0 { -ratio } else { ratio * [1.0, 0.0, 4.0][random.below(3)] };
            let shape = ModeShape { contacts: vec![random.between(0.2, 1.0)], coordinates: Vec::new(), still: 0.0 };
            LinearMode::oscillator(ratio * frequency, frequency * frequency * (1.0 - ratio * ratio), &shape, &[])
        };
        let modes = (0..modes).map(mode).collect();
        let stop = Contact { lower: Some(-1.0), upper: None, restitution: random.between(0.2, 1.0) };
        let structure = ModalStructure::new(vec![stop], Vec::new(), modes).unwrap();
        LoadedStructure::new(Arc::new(structure), 1.0).unwrap()
    }

    /// The slope of F is that of its values, and bounds of its second derivative hold all over an interval.
    #[test]
    fn enclosures_of_the_law_hold_what_they_enclose() {
        let mut random = Random(71);
        let (mut slopes, mut away, mut rising) = (0, 0, 0);
        for round in 0..40 {
            let model = model(&mut random, 1 + round % 3);
            let equations = Equations::new(&model, 1, [0].into_iter()).unwrap();
            let impacts = Impacts { equations: &equations, letters: smallvec![(0, Barrier::Lower)] };
            let law = PeriodLaw::new(&impacts).unwrap();
            let [from, to] = impacts.periods();
            for _ in 0..60 {
                let centre = random.log(20.0 * from, 0.9 * to);
                let radius = centre * random.log(1e-5, 5e-2);
                let ([value, slope], _) = law.jet(centre);
                let h = 1e-6 * centre;
                let quotient = (law.at(centre + h).0 - law.at(centre - h).0) / (2.0 * h);
                let bend = law.bend(centre - radius, centre + radius);
                if bend.is_finite() {
                    assert!((slope - quotient).abs() <= 1e-6 * (1.0 + slope.abs()) + bend * h, "{slope} {quotient}");
                    slopes += 1;
                }
                let clearance = law.clearances([centre; LANES], [radius; LANES])[2];
                for k in -20..=20 {
                    let (near, rise) = law.at(centre + radius * f64::from(k) / 20.0);
                    if clearance.function > 0.0 {
                        assert!(near * value > 0.0 && near.abs() >= clearance.function * (1.0 - 1e-9));
                        away += 1;
                    } else if clearance.derivative > 0.0 {
                        assert!(rise * slope > 0.0);
                        rising += 1;
                    }
                }
            }
        }
        assert!(slopes > 1000 && away > 20_000 && rising > 200, "{slopes} {away} {rising}");
    }
}

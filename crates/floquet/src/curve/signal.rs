//! What vanishes all along a curve.

use nalgebra::Complex;
use smallvec::SmallVec;
use vibrochain_breather::{BranchError, BreatherError, Finder, Orbit, SurfacePoint};
use vibrochain_lattice::{Barrier, Stop};

use crate::analyser::Analyser;
use crate::error::FloquetError;
use crate::locate::spectrum_events::{discriminant, half_sums, regular_determinant, upper_half};
use crate::locate::{Event, Evidence, Polisher};

type C = Complex<f64>;

/// Newton's steps from where a mass was nearest to where it is, and the share of a period that it may have moved by.
const STEPS: usize = 24;
const FARTHEST: f64 = 0.05;

/// Where else it is looked for, in periods.
const ASIDE: [f64; 5] = [0.0, 0.01, -0.01, 0.04, -0.04];

/// A mass that is no farther than this beyond a barrier, or hits it no faster than this over ω, touches it: at a grazing that is rounding.
pub(super) const TOUCHES: f64 = 1e-9;

/// How far half a sum of two multipliers may jump from what was expected: farther, it is another pair's.
const JUMP: f64 = 0.1;

/// Rounding of dense eigenvalues, in units of that of the norm.
const DENSE: f64 = 100.0;

/// Why a function has no value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Blind {
    /// No orbit there.
    Lost(BranchError),
    /// No multipliers.
    Unwatched(FloquetError),
    /// The mass or the pair is not where it was expected.
    Other,
}

impl From<BranchError> for Blind {
    fn from(error: BranchError) -> Self {
        Self::Lost(error)
    }
}

impl From<BreatherError> for Blind {
    fn from(error: BreatherError) -> Self {
        Self::Lost(error.into())
    }
}

impl From<FloquetError> for Blind {
    fn from(error: FloquetError) -> Self {
        Self::Unwatched(error)
    }
}

/// The function of an orbit that vanishes at the event.
#[derive(Debug, Clone, Copy)]
pub(super) enum Signal {
    /// Velocity before an impact, towards its barrier.
    Velocity(usize),
    /// Distance of a mass to a barrier where it turns round; its mark is when, as a part of the period.
    Distance { site: usize, barrier: Barrier },
    /// Determinant of the equations among orbits of the same symmetry.
    Fold,
    /// Determinant of all equations.
    Equations,
    /// det(A + shift), made regular, over its size `log` at the start.
    Shifted { shift: f64, log: f64 },
    /// μ₁μ₂ − 1 of the pair that meets the circle; its mark is ½(μ₁ + μ₂), cos θ there.
    Pair,
    /// (ν₁ − ν₂)² of the two that collide; their mark is ½(ν₁ + ν₂).
    Collision,
}

/// Its value, and the mark by which what it belongs to is known again at the next orbit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Value {
    pub(super) value: f64,
    pub(super) mark: f64,
}

/// Who looks at orbits.
pub(super) struct Sight {
    analyser: Analyser,
    pub(super) finder: Finder,
    pub(super) sites: usize,
    pub(super) spectra: usize,
}

impl Signal {
    /// That of an event, and its first mark.
    pub(super) fn of(event: Event, evidence: Evidence, orbit: &Orbit) -> Option<(Self, f64)> {
        let conservative = orbit.model().is_conservative();
        Some(match (event, evidence) {
            (Event::Grazing, Evidence::Impact(i)) => (Self::Velocity(i), 0.0),
            (Event::Grazing, Evidence::Touch(touch)) => {
                (Self::Distance { site: touch.site, barrier: touch.barrier }, touch.time / orbit.period())
            }
            (Event::Fold, _) => (Self::Fold, 0.0),
            (Event::Pitchfork, _) if conservative => (Self::Shifted { shift: -1.0, log: 0.0 }, 0.0),
            (Event::Pitchfork, _) => (Self::Equations, 0.0),
            (Event::PeriodDoubling, _) => (Self::Shifted { shift: 1.0, log: 0.0 }, 0.0),
            (Event::NeimarkSacker, Evidence::Multiplier(multiplier)) => {
                let signal = if orbit.model().loss() == 0.0 { Self::Collision } else { Self::Pair };
                (signal, multiplier.re / multiplier.norm())
            }
            _ => return None,
        })
    }

    /// The impacts of an orbit that have no velocity where this vanishes: by symmetry it may be several.
    pub(super) fn grazing(self, orbit: &Orbit) -> SmallVec<[usize; 2]> {
        let still = |i: &usize| orbit.impacts()[*i].velocity_before.abs() <= TOUCHES * orbit.model().omega();
        match self {
            Self::Velocity(own) => (0..orbit.impacts().len()).filter(|i| *i == own || still(i)).collect(),
            _ => SmallVec::new(),
        }
    }

    /// Whether it is seen by the multipliers.
    pub(super) fn is_spectral(self) -> bool {
        matches!(self, Self::Shifted { .. }) || self.has_angle()
    }

    /// Whether its mark is the cosine of a multiplier's angle.
    pub(super) fn has_angle(self) -> bool {
        matches!(self, Self::Pair | Self::Collision)
    }
}

impl Sight {
    pub(super) fn new(sites: usize, stop: &Stop) -> Self {
        Self { analyser: Analyser::default(), finder: Finder::new(sites).until(stop), sites, spectra: 0 }
    }

    /// Eigenvalues: μ, or ν of a reversible orbit.
    pub(super) fn spectrum(&mut self, orbit: &Orbit) -> Result<Vec<C>, FloquetError> {
        self.spectra += 1;
        self.analyser.dense.solve(orbit, &mut self.finder)?;
        Ok(self.analyser.dense.values.clone())
    }

    /// ln|D| and the sign of D = det(A + shift), made regular, of the orbit whose eigenvalues were worked out last.
    pub(super) fn determinant(&self, orbit: &Orbit, shift: f64) -> (f64, f64) {
        regular_determinant(orbit, self.analyser.dense.matrix_of(orbit), shift)
    }

    /// A signal at an orbit, of what has its mark near the one expected.
    pub(super) fn value(&mut self, signal: Signal, point: &SurfacePoint, expected: f64) -> Result<Value, Blind> {
        let orbit = point.orbit();
        let marked = |value: f64| Ok(Value { value, mark: expected });
        match signal {
            Signal::Velocity(i) => {
                let impact = orbit.impacts().get(i).ok_or(Blind::Other)?;
                marked(impact.velocity_before * impact.barrier.sign())
            }
            Signal::Distance { site, barrier } => self.distance(orbit, (site, barrier), expected),
            Signal::Fold => marked(point.fold_determinant()),
            Signal::Equations => marked(point.determinant()),
            Signal::Shifted { shift, log } => {
                let _ = self.spectrum(orbit)?;
                let (logarithm, sign) = self.determinant(orbit, shift);
                marked(sign * (logarithm - log).exp())
            }
            Signal::Pair => {
                let values = self.spectrum(orbit)?;
                let pairs = pairs(&values);
                let off = |&&[a, b]: &&[C; 2]| (0.5 * (a + b).re - expected).abs() + ((a * b).re - 1.0).abs();
                let [mut a, mut b] = *pairs.iter().min_by(|p, q| off(p).total_cmp(&off(q))).ok_or(Blind::Other)?;
                let slack = DENSE * f64::EPSILON * self.analyser.dense.matrix_of(orbit).norm();
                if a.im > 0.0
                    && orbit.impact_site().is_some()
                    && let Some(better) = Polisher::new(orbit, &mut self.finder)?.polished(a, slack)
                {
                    (a, b) = (better, better.conj());
                }
                let mark = 0.5 * (a + b).re;
                near(mark, expected)?;
                // |μ|² − 1 by factors: the sum of squares would round it.
                let value = if a.im > 0.0 { (a.norm() - 1.0) * (a.norm() + 1.0) } else { (a * b).re - 1.0 };
                Ok(Value { value, mark })
            }
            Signal::Collision => {
                let values = self.spectrum(orbit)?;
                let mut sums = half_sums(&values, orbit.is_reversible());
                let value = discriminant(expected, &sums).ok_or(Blind::Other)?;
                sums.sort_by(|a, b| (a - expected).norm_sqr().total_cmp(&(b - expected).norm_sqr()));
                let mark = 0.5 * (sums[0] + sums[1]).re;
                near(mark, expected)?;
                Ok(Value { value, mark })
            }
        }
    }

    /// How far a mass is from a barrier where it turns round.
    fn distance(&mut self, orbit: &Orbit, (site, barrier): (usize, Barrier), expected: f64) -> Result<Value, Blind> {
        let (period, omega) = (orbit.period(), orbit.model().omega());
        let wall = orbit.model().barrier(barrier);
        let motion = self.finder.motion(orbit)?;
        let mut turn = |start: f64| -> Option<Value> {
            let mut t = start;
            for _ in 0..STEPS {
                let mass = motion.at(site, t.rem_euclid(period));
                let step = mass.velocity / mass.acceleration;
                t -= step;
                let moved = (t - start).abs();
                if moved.is_nan() || moved > FARTHEST * period {
                    return None;
                }
                if step.abs() * omega <= 4.0 * f64::EPSILON {
                    break;
                }
            }
            let mass = motion.at(site, t.rem_euclid(period));
            // Nearest, not farthest.
            let nearest = barrier.sign() * mass.acceleration <= 0.0;
            nearest.then(|| Value { value: barrier.sign() * (wall - mass.displacement), mark: t / period })
        };
        let start = expected * period;
        // Where a mass that was nearest once a period comes near twice, before and after.
        let places = ASIDE.iter().map(|aside| start + aside * period);
        places.filter_map(&mut turn).next().ok_or(Blind::Other)
    }
}

fn near(mark: f64, expected: f64) -> Result<(), Blind> {
    if (mark - expected).abs() <= JUMP { Ok(()) } else { Err(Blind::Other) }
}

/// Pairs that may be the one that meets the circle: two that are complex conjugates, or two real neighbours.
fn pairs(values: &[C]) -> Vec<[C; 2]> {
    let complex = upper_half(values).into_iter().map(|value| [value, value.conj()]);
    let mut real: Vec<f64> =
        values.iter().filter(|value| value.im.abs() <= crate::locate::spectrum_events::SPLIT).map(|z| z.re).collect();
    real.sort_by(f64::total_cmp);
    let real = real.windows(2).map(|two| [C::from(two[0]), C::from(two[1])]);
    complex.chain(real.collect::<Vec<_>>()).collect()
}

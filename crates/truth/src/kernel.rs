//! The periodic impulse response K_n(t) by the plain sum over modes:
//!
//! ```text
//! K_n(t) = Σ_k b_k² cos(2πkn/M) · cos(Ω_k(t−T/2)) / (2Ω_k sin(Ω_kT/2)),      0 ≤ t ≤ T,   T = 2π·periods/ω
//! ```
//!
//! Nothing here is clever. What cancels (soft modes, near resonances, large arguments) is met by more digits: the
//! precision is raised beyond the one asked for by what the worst mode loses.

use vibrochain_lattice::Chain;

use crate::error::TruthError;
use crate::real::Real;

/// Digits kept beyond those that are asked for.
const GUARD_BITS: f64 = 32.0;

/// The impulse response at one time and its derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct Jet {
    /// K_n, for γ₁ = 0 without the rigid mode's static part.
    pub value: Real,
    /// dK_n/dt, at the impulse the mean of both sides.
    pub slope: Real,
    /// d²K_n/dt², without the impulse itself.
    pub curvature: Real,
    /// d³K_n/dt³, at the impulse the mean of both sides.
    pub third: Real,
}

/// One mode even about site 0.
#[derive(Debug, Clone)]
struct Mode {
    /// Ω, zero for a rigid mode.
    frequency: Real,
    /// b²
    weight: Real,
    /// b²/(2 sin(ΩT/2)); not used for a rigid mode.
    amplitude: Real,
    /// b²/(Ω²T); zero for a rigid mode.
    fixed: Real,
}

/// cos and sin of Ω_k(t−T/2) for all modes at one time.
struct Waves {
    offset: Real,
    at_impulse: bool,
    cos_sin: Vec<(Real, Real)>,
}

/// The exact periodic impulse response of a ring, all digits good.
///
/// ```
/// use vibrochain_lattice::Chain;
/// use vibrochain_truth::{DEFAULT_BITS, Kernel};
/// let kernel = Kernel::new(&Chain::new(21, 0.2, 0.1)?, 1.5, 1, DEFAULT_BITS)?;
/// assert!((kernel.chi2() + 0.5788951801307799).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Kernel {
    chain: Chain,
    omega: f64,
    bits: usize,
    work: usize,
    period: Real,
    modes: Vec<Mode>,
    /// cos(2πj/M), j = 0 … M−1
    cosines: Vec<Real>,
}

impl Kernel {
    /// The response of `chain` to an impulse at site 0 every `force_periods` periods of `omega`, to `bits` binary digits
    /// at least.
    ///
    /// # Errors
    /// [`TruthError::Resonance`] where a mode is met to all digits; [`TruthError::Parameter`] for a frequency that is
    /// not positive and finite, or no periods.
    pub fn new(chain: &Chain, omega: f64, force_periods: u32, bits: usize) -> Result<Self, TruthError> {
        if !(omega > 0.0 && omega.is_finite()) {
            return Err(TruthError::Parameter { name: "omega", value: omega, requirement: "a positive finite number" });
        }
        if force_periods == 0 {
            return Err(TruthError::Parameter { name: "force_periods", value: 0.0, requirement: "1 or more" });
        }
        // How many digits the worst mode loses: measured once with those of an f64 difference of squares, twice over.
        let trial = bits.max(256);
        let lost = Self::lost_bits(chain, omega, force_periods, trial)?;
        let work = bits + (GUARD_BITS + lost).ceil() as usize;
        let period = period(omega, force_periods, work);
        let cosines = ring_cosines(chain.sites(), work);
        let modes = (0..chain.even_modes())
            .map(|k| {
                let frequency = frequency(chain, k, work);
                let count = if k == 0 || 2 * k == chain.sites() { 1.0 } else { 2.0 };
                let weight = Real::new(count, work) / chain.sites() as f64;
                let (sin, _) = (&frequency * &period / 2.0).sin_cos();
                let rigid = frequency.is_zero();
                let amplitude = if rigid { Real::zero(work) } else { &weight / (sin * 2.0) };
                let fixed = if rigid { Real::zero(work) } else { &weight / (&frequency * &frequency * &period) };
                Mode { frequency, weight, amplitude, fixed }
            })
            .collect();
        Ok(Self { chain: *chain, omega, bits, work, period, modes, cosines })
    }

    /// Digits lost by the worst mode: 2 log₂(1/y) between its static and dynamic parts, log₂(y/|sin y|) in the sine.
    fn lost_bits(chain: &Chain, omega: f64, force_periods: u32, trial: usize) -> Result<f64, TruthError> {
        let half = |bits| period(omega, force_periods, bits) / 2.0;
        let mut worst = 0.0_f64;
        for k in 0..chain.even_modes() {
            let mut y = frequency(chain, k, trial) * half(trial);
            if y.is_zero() {
                continue;
            }
            let size = y.log2_abs();
            if size > 0.0 {
                let bits = trial + size.ceil() as usize;
                y = frequency(chain, k, bits) * half(bits);
            }
            let resonant = size - y.sin_cos().0.log2_abs();
            if resonant > 0.75 * trial as f64 + size.max(0.0) {
                return Err(TruthError::Resonance { mode: k, omega: omega / f64::from(force_periods) });
            }
            worst = worst.max(resonant).max(-4.0 * size);
        }
        Ok(worst)
    }

    /// The ring.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// Frequency ω of the force, as given.
    pub fn omega(&self) -> f64 {
        self.omega
    }

    /// Binary digits asked for.
    pub fn bits(&self) -> usize {
        self.bits
    }

    /// Binary digits calculated with.
    pub fn work_bits(&self) -> usize {
        self.work
    }

    /// Period T of the impulses.
    pub fn period(&self) -> &Real {
        &self.period
    }

    /// Number of modes even about a site.
    pub fn modes(&self) -> usize {
        self.modes.len()
    }

    /// Ω_k of the even modes, k = 0 … ⌊M/2⌋.
    pub fn frequencies(&self) -> impl Iterator<Item = &Real> {
        self.modes.iter().map(|mode| &mode.frequency)
    }

    /// b_k² of the even modes.
    pub fn weights(&self) -> impl Iterator<Item = &Real> {
        self.modes.iter().map(|mode| &mode.weight)
    }

    /// K_n(t) for any t, `site` = n counted from the one that is hit. For γ₁ = 0 the rigid mode's static part is infinite
    /// and left out: K_n is then known up to a constant common to all sites.
    pub fn value(&self, site: usize, t: &Real) -> Real {
        self.dynamic(site, t) + self.static_part(site)
    }

    /// K_n(t) less its mean over a period.
    pub fn dynamic(&self, site: usize, t: &Real) -> Real {
        self.sum(site, 0, &self.waves(t))
    }

    /// The mean of K_n over a period: the displacement that a constant force of one impulse a period holds up. For
    /// γ₁ = 0 without the rigid mode, which nothing holds.
    pub fn static_part(&self, site: usize) -> Real {
        let mut sum = Real::zero(self.work);
        for (k, mode) in self.modes.iter().enumerate() {
            sum += &mode.fixed * self.shape(k, site);
        }
        sum
    }

    /// The uniform mode's share in [`Kernel::static_part`], 1/(γ₁MT); `None` for γ₁ = 0.
    pub fn uniform_static(&self) -> Option<Real> {
        self.modes.first().map(|mode| mode.fixed.clone()).filter(|fixed| !fixed.is_zero())
    }

    /// dK_n/dt; at the impulse the mean of both sides, which is 0.
    pub fn slope(&self, site: usize, t: &Real) -> Real {
        self.sum(site, 1, &self.waves(t))
    }

    /// d²K_n/dt², without the impulse itself.
    pub fn curvature(&self, site: usize, t: &Real) -> Real {
        self.sum(site, 2, &self.waves(t))
    }

    /// d³K_n/dt³; at the impulse the mean of both sides, which is 0.
    pub fn third(&self, site: usize, t: &Real) -> Real {
        self.sum(site, 3, &self.waves(t))
    }

    /// All of them at once, for the price of one.
    pub fn jet(&self, site: usize, t: &Real) -> Jet {
        let waves = self.waves(t);
        Jet {
            value: self.sum(site, 0, &waves) + self.static_part(site),
            slope: self.sum(site, 1, &waves),
            curvature: self.sum(site, 2, &waves),
            third: self.sum(site, 3, &waves),
        }
    }

    /// K_n(t) at the sites n = 0 … ⌊M/2⌋; the ring is symmetric about site 0.
    pub fn profile(&self, t: &Real) -> Vec<Real> {
        let waves = self.waves(t);
        (0..self.modes.len()).map(|n| self.sum(n, 0, &waves) + self.static_part(n)).collect()
    }

    /// χ₁(φ) = −2K₀(φ).
    pub fn chi1(&self, phi: &Real) -> Real {
        self.value(0, phi) * -2.0
    }

    /// χ₂ = −2K₀(0).
    pub fn chi2(&self) -> Real {
        self.value(0, &Real::zero(self.work)) * -2.0
    }

    /// χ₃(φ) = 2K₀′(φ).
    pub fn chi3(&self, phi: &Real) -> Real {
        self.slope(0, phi) * 2.0
    }

    /// cos(2πkn/M)
    pub(crate) fn shape(&self, k: usize, site: usize) -> &Real {
        let sites = self.cosines.len();
        // M ≤ 10⁷: the product fits.
        &self.cosines[(k % sites) * (site % sites) % sites]
    }

    fn waves(&self, t: &Real) -> Waves {
        // Folded into the period: t − T⌊t/T⌋.
        let folded = if t.is_negative() || *t >= self.period {
            t - &self.period * (t / &self.period).floor()
        } else {
            t.with_bits(t.bits().max(self.work))
        };
        let offset = &folded - &self.period / 2.0;
        let cos_sin = self.modes.iter().map(|mode| {
            let (sin, cos) = (&mode.frequency * &offset).sin_cos();
            (cos, sin)
        });
        Waves { at_impulse: folded.is_zero(), cos_sin: cos_sin.collect(), offset }
    }

    /// Σ_k cos(2πkn/M) × the derivative of order 0 … 3 of a mode's dynamic part.
    fn sum(&self, site: usize, order: usize, waves: &Waves) -> Real {
        let mut sum = Real::zero(self.work);
        if order % 2 == 1 && waves.at_impulse {
            return sum;
        }
        for (k, (mode, (cos, sin))) in self.modes.iter().zip(&waves.cos_sin).enumerate() {
            let term = if mode.frequency.is_zero() {
                self.rigid(&mode.weight, order, &waves.offset)
            } else {
                match order {
                    0 => &mode.amplitude * cos / &mode.frequency - &mode.fixed,
                    1 => -(&mode.amplitude * sin),
                    2 => -(&mode.amplitude * cos * &mode.frequency),
                    _ => &mode.amplitude * sin * &mode.frequency * &mode.frequency,
                }
            };
            sum += term * self.shape(k, site);
        }
        sum
    }

    /// The limit Ω → 0 of a mode's dynamic part: b²(T/24 − (t−T/2)²/(2T)) and its derivatives.
    fn rigid(&self, weight: &Real, order: usize, offset: &Real) -> Real {
        match order {
            0 => weight * (&self.period / 24.0 - offset * offset / (&self.period * 2.0)),
            1 => -(weight * offset / &self.period),
            2 => -(weight / &self.period),
            _ => Real::zero(self.work),
        }
    }
}

/// T = 2π·periods/ω
fn period(omega: f64, force_periods: u32, bits: usize) -> Real {
    Real::pi(bits) * (2.0 * f64::from(force_periods)) / omega
}

/// Ω_k = √(γ₁ + 4γ₂ sin²(πk/M))
fn frequency(chain: &Chain, k: usize, bits: usize) -> Real {
    let (sin, _) = (Real::pi(bits) * k as f64 / chain.sites() as f64).sin_cos();
    (&sin * &sin * 4.0 * chain.gamma2() + chain.gamma1()).sqrt()
}

fn ring_cosines(sites: usize, bits: usize) -> Vec<Real> {
    let half: Vec<Real> =
        (0..=sites / 2).map(|j| (Real::pi(bits) * (2 * j) as f64 / sites as f64).sin_cos().1).collect();
    (0..sites).map(|j| half[j.min(sites - j)].clone()).collect()
}

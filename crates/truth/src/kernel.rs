//! The periodic impulse response K_nm(t) of mass n to impulses at mass m, by the plain sum over modes:
//!
//! ```text
//! K_nm(t) = Σ_k φ_k(n) φ_k(m) · cos(Ω_k(t−T/2)) / (2Ω_k sin(Ω_kT/2)),      0 ≤ t ≤ T,   T = 2π·periods/ω
//! ```
//!
//! Modes are products of one along the rows and one across the layers (`direction`); on a ring Σ φ_k(n)φ_k(m) over a pair of
//! one frequency is b_k² cos(2πk(n−m)/M).
//!
//! Nothing here is clever. What cancels (soft modes, near resonances, large arguments) is met by more digits: the
//! precision is raised beyond the one asked for by what the worst mode loses.

use vibrochain_lattice::Chain;

use crate::direction::Direction;
use crate::error::TruthError;
use crate::real::Real;

/// Digits kept beyond those that are asked for.
const GUARD_BITS: f64 = 32.0;

/// The impulse response at one time and its derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct Jet {
    /// K_nm, for a lattice that nothing holds without the rigid mode's static part.
    pub value: Real,
    /// dK_nm/dt, at the impulse the mean of both sides.
    pub slope: Real,
    /// d²K_nm/dt², without the impulse itself.
    pub curvature: Real,
    /// d³K_nm/dt³, at the impulse the mean of both sides.
    pub third: Real,
}

/// One frequency: a mode, or a pair of a ring.
#[derive(Debug, Clone)]
struct Mode {
    /// Ω, zero for a rigid mode.
    frequency: Real,
    /// What makes products of shapes those of normalised ones: on a ring b².
    weight: Real,
    /// weight/(2 sin(ΩT/2)); not used for a rigid mode.
    amplitude: Real,
    /// weight/(Ω²T); zero for a rigid mode.
    fixed: Real,
}

/// cos and sin of Ω_k(t−T/2) for all modes at one time.
pub(crate) struct Waves {
    offset: Real,
    at_impulse: bool,
    cos_sin: Vec<(Real, Real)>,
}

/// The exact periodic impulse response between any two masses of a lattice, all digits good.
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
    along: Direction,
    across: Direction,
}

impl Kernel {
    /// The response of `chain` to an impulse every `force_periods` periods of `omega`, to `bits` binary digits
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
        let [along, across] = Direction::both(chain).map(|direction| direction.tabulated(work));
        let modes = (0..along.modes() * across.modes())
            .map(|k| {
                let frequency = frequency(chain, k, work);
                let (k, l) = (k % along.modes(), k / along.modes());
                let weight = along.weight(k, work) * across.weight(l, work);
                let (sin, _) = (&frequency * &period / 2.0).sin_cos();
                let rigid = frequency.is_zero();
                let amplitude = if rigid { Real::zero(work) } else { &weight / (sin * 2.0) };
                let fixed = if rigid { Real::zero(work) } else { &weight / (&frequency * &frequency * &period) };
                Mode { frequency, weight, amplitude, fixed }
            })
            .collect();
        Ok(Self { chain: *chain, omega, bits, work, period, modes, along, across })
    }

    /// Digits lost by the worst mode: 2 log₂(1/y) between its static and dynamic parts, log₂(y/|sin y|) in the sine.
    fn lost_bits(chain: &Chain, omega: f64, force_periods: u32, trial: usize) -> Result<f64, TruthError> {
        let half = |bits| period(omega, force_periods, bits) / 2.0;
        let mut worst = 0.0_f64;
        let [along, across] = Direction::both(chain);
        for k in 0..along.modes() * across.modes() {
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

    /// The lattice.
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

    /// Number of frequencies: on a ring that of the modes even about a site.
    pub fn modes(&self) -> usize {
        self.modes.len()
    }

    /// Ω_k, of the modes along the rows for each of those across; on a ring k = 0 … ⌊M/2⌋.
    pub fn frequencies(&self) -> impl Iterator<Item = &Real> {
        self.modes.iter().map(|mode| &mode.frequency)
    }

    /// b_k² = φ_k(site)² of each frequency; on a ring those of all sites.
    pub fn weights(&self, site: usize) -> impl Iterator<Item = Real> + '_ {
        self.shares(site, site)
    }

    /// φ_k(n) φ_k(m) of each frequency.
    pub(crate) fn shares(&self, to: usize, from: usize) -> impl Iterator<Item = Real> + '_ {
        self.modes.iter().enumerate().map(move |(k, mode)| &mode.weight * self.shape(k, to, from))
    }

    /// K_nm(t) for any t, of mass n = `to` to impulses at mass m = `from`. For a lattice that nothing holds the rigid mode's
    /// static part is infinite and left out: K is then known up to a constant common to all sites.
    pub fn value(&self, to: usize, from: usize, t: &Real) -> Real {
        self.dynamic(to, from, t) + self.static_part(to, from)
    }

    /// K_nm(t) less its mean over a period.
    pub fn dynamic(&self, to: usize, from: usize, t: &Real) -> Real {
        self.sum([to, from], 0, &self.waves(t))
    }

    /// The mean of K_nm over a period: the displacement that a constant force of one impulse a period holds up. For
    /// a lattice that nothing holds without the rigid mode.
    pub fn static_part(&self, to: usize, from: usize) -> Real {
        let mut sum = Real::zero(self.work);
        for (k, mode) in self.modes.iter().enumerate() {
            sum += &mode.fixed * self.shape(k, to, from);
        }
        sum
    }

    /// The uniform mode's share in [`Kernel::static_part`], 1/(γ₁MT); `None` for γ₁ = 0, and where walls leave no such mode.
    pub fn uniform_static(&self) -> Option<Real> {
        let uniform = self.modes.first().filter(|mode| !self.chain.has_walls() && !mode.frequency.is_zero());
        uniform.map(|mode| mode.fixed.clone())
    }

    /// dK_nm/dt; at the impulse the mean of both sides, which is 0.
    pub fn slope(&self, to: usize, from: usize, t: &Real) -> Real {
        self.sum([to, from], 1, &self.waves(t))
    }

    /// d²K_nm/dt², without the impulse itself.
    pub fn curvature(&self, to: usize, from: usize, t: &Real) -> Real {
        self.sum([to, from], 2, &self.waves(t))
    }

    /// d³K_nm/dt³; at the impulse the mean of both sides, which is 0.
    pub fn third(&self, to: usize, from: usize, t: &Real) -> Real {
        self.sum([to, from], 3, &self.waves(t))
    }

    /// All of them at once, for the price of one.
    pub fn jet(&self, to: usize, from: usize, t: &Real) -> Jet {
        self.jet_of(to, from, &self.waves(t))
    }

    /// The same at a time whose waves are known.
    pub(crate) fn jet_of(&self, to: usize, from: usize, waves: &Waves) -> Jet {
        let [value, slope, curvature, third] = [0, 1, 2, 3].map(|order| self.sum([to, from], order, waves));
        Jet { value: value + self.static_part(to, from), slope, curvature, third }
    }

    /// K_n0(t) of all masses n; of a ring, which is symmetric about site 0, of n = 0 … ⌊M/2⌋.
    pub fn profile(&self, t: &Real) -> Vec<Real> {
        let waves = self.waves(t);
        let count = if self.chain.is_ring() { self.modes.len() } else { self.chain.sites() };
        (0..count).map(|n| self.sum([n, 0], 0, &waves) + self.static_part(n, 0)).collect()
    }

    /// χ₁(φ) = −2K₀₀(φ).
    pub fn chi1(&self, phi: &Real) -> Real {
        self.value(0, 0, phi) * -2.0
    }

    /// χ₂ = −2K₀₀(0).
    pub fn chi2(&self) -> Real {
        self.value(0, 0, &Real::zero(self.work)) * -2.0
    }

    /// χ₃(φ) = 2K₀₀′(φ).
    pub fn chi3(&self, phi: &Real) -> Real {
        self.slope(0, 0, phi) * 2.0
    }

    /// The shape of frequency `k` at one mass times that at another, but for the weight; on a ring cos(2πk(n−m)/M).
    fn shape(&self, k: usize, to: usize, from: usize) -> Real {
        let (length, modes) = (self.along.masses(), self.along.modes());
        let along = self.along.product(k % modes, to % length, from % length);
        // (One layer has the shape 1.)
        if self.chain.layers() == 1 {
            along
        } else {
            along * self.across.product(k / modes, to / length, from / length)
        }
    }

    pub(crate) fn waves(&self, t: &Real) -> Waves {
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

    /// Σ_k shape × the derivative of order 0 … 3 of a mode's dynamic part.
    fn sum(&self, [to, from]: [usize; 2], order: usize, waves: &Waves) -> Real {
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
            sum += term * self.shape(k, to, from);
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

/// Ω = √(γ₁ + λ_k(γ₂) + λ_l(γ₃))
fn frequency(chain: &Chain, mode: usize, bits: usize) -> Real {
    let [along, across] = Direction::both(chain);
    let (k, l) = (mode % along.modes(), mode / along.modes());
    let springs = along.stiffness(k, bits) * chain.gamma2() + across.stiffness(l, bits) * chain.gamma3();
    (springs + chain.gamma1()).sqrt()
}

//! The periodic impulse response K_n(t): displacement of site n when site 0 receives a unit impulse at every
//! t = 0, ±T, ±2T, ….
//!
//! ```text
//! K_n(t) = Σ_k b_k² cos(2πkn/M) · cos(Ω_k(t−T/2)) / (2Ω_k sin(Ω_kT/2)),      0 ≤ t ≤ T          (docs/guide/model.md)
//! ```
//!
//! exact, at the cost of one sine a mode, where the paper sums a Fourier series that converges like 1/J.
//!
//! Each mode's term is split as static + dynamic,
//!
//! ```text
//! 1/(Ω_k²T)   +   [ cos x/(2Ω_k sin y) − 1/(Ω_k²T) ],      y = Ω_kT/2,  x = Ω_k(t−T/2),
//! ```
//!
//! the answer to the mean force and to the rest. For soft modes or short periods (y → 0) the static part grows
//! like 1/y² while breathers hang on the dynamic part, which stays finite even for a rigid mode (Ω = 0); added
//! together they would lose 2·log₁₀(1/y) digits. Callers that know the net impulse use the parts; `value` adds them.
//!
//! | module | holds |
//! |---|---|
//! | `reset` | what the modes have at a frequency of the impulses |
//! | `at_sites` | K_n at any site and time, mode by mode |
//! | `jets` | [`KernelJet`]: K₀ and its derivatives about the middle of the period, four modes or times at a time |
//! | `sensitivity` | how far rounding of the data moves it |

mod at_sites;
mod jets;
mod reset;
mod sensitivity;

pub use jets::KernelJet;

use crate::error::Resonance;
use crate::model::chain::Chain;
use crate::modes::shapes::Shapes;
use crate::modes::spectrum::Spectrum;
use crate::simd::lanes::Lane;

/// Closed form of the periodic impulse response for one spectrum and one period.
///
/// ```
/// use vibrochain_lattice::{Chain, ImpulseResponse, Spectrum};
/// // One mass on a spring: K(t) = cos(Ω(t−T/2)) / (2Ω sin(ΩT/2)).
/// let response = ImpulseResponse::new(&Spectrum::new(Chain::new(1, 1.0, 0.0)?), 3.0)?;
/// let t = 0.7_f64;
/// let half = std::f64::consts::PI / 3.0;
/// assert!((response.value(0, t) - (t - half).cos() / (2.0 * half.sin())).abs() < 1e-15);
/// # Ok::<(), vibrochain_lattice::LatticeError>(())
/// ```
#[derive(Debug, Clone)]
pub struct ImpulseResponse {
    chain: Chain,
    /// The site that answers where none is named, and of its modes φ_k² over the weight; 1 on a ring, and not listed.
    home: usize,
    squares: Vec<f64>,
    /// The products of the two, b_k² of home; not listed on a ring.
    own: Vec<f64>,
    omega: f64,
    period: f64,
    shapes: Shapes,
    /// How many there are; the lists below are filled up to whole groups of four.
    modes: usize,
    frequencies: Vec<f64>,
    weights: Vec<f64>,
    /// y, sin y and cos y, the last two with the nearest multiple of π taken out of y exactly.
    half_phase: Vec<f64>,
    sin_half: Vec<f64>,
    cos_half: Vec<f64>,
    /// 1/(Ω²T), 0 for a rigid mode.
    statics: Vec<f64>,
    /// Dynamic response of the modes at the impulse and half a period after it, and the sums that orbits start from.
    at_impulse: Vec<f64>,
    at_half: Vec<f64>,
    dynamic_at_impulse: f64,
    dynamic_at_half: f64,
    static_stiffness: f64,
    /// What every time needs of a mode: b²/sinc y and (y − sin y)/y³ for y < 1, b²/(2 sin y) and sin y/y otherwise.
    scales: Vec<f64>,
    offsets: Vec<f64>,
    condition: f64,
    /// The highest frequency.
    top: f64,
}

impl ImpulseResponse {
    /// The response of `spectrum` to impulses repeated with frequency `omega`.
    ///
    /// # Errors
    /// [`Resonance`] when a harmonic of `omega` meets a mode to within rounding
    /// ([`RESONANCE_TOLERANCE`](crate::RESONANCE_TOLERANCE), relative).
    pub fn new(spectrum: &Spectrum, omega: f64) -> Result<Self, Resonance> {
        let mut response = Self::vacant(spectrum.chain());
        response.reset(spectrum, omega)?;
        Ok(response)
    }

    /// The lattice.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// Number of masses.
    pub fn sites(&self) -> usize {
        self.chain.sites()
    }

    /// Number of modes even about site 0.
    pub fn modes(&self) -> usize {
        self.modes
    }

    /// Base frequency of the impulses.
    pub fn omega(&self) -> f64 {
        self.omega
    }

    /// Period T of the impulses.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Ω_k of the even modes.
    pub fn frequencies(&self) -> &[f64] {
        &self.frequencies[..self.modes]
    }

    /// Weights of the modes ([`Spectrum::weights`]): on a ring b_k².
    pub fn weights(&self) -> &[f64] {
        &self.weights[..self.modes]
    }

    /// sin(Ω_kT/2) of the even modes.
    pub fn sin_half(&self) -> &[f64] {
        &self.sin_half[..self.modes]
    }

    /// cos(Ω_kT/2) of the even modes.
    pub fn cos_half(&self) -> &[f64] {
        &self.cos_half[..self.modes]
    }

    /// Shapes of the modes.
    pub fn shapes(&self) -> &Shapes {
        &self.shapes
    }

    /// max_k Ω_k/|Ω_k − jω| over harmonics j ≥ 1: a relative error δ in a frequency moves the response by about
    /// this times δ. 1 where no harmonic comes near a mode.
    pub fn condition(&self) -> f64 {
        self.condition
    }

    /// 1/(γ₁MT): the uniform displacement that one unit of net impulse a period holds up; between walls, where no mode is
    /// uniform, 1/(Ω₀²MT). `None` where nothing holds the lattice as a whole and a
    /// periodic motion needs a net impulse of zero ([`Chain::is_adrift`]).
    pub fn uniform_static(&self) -> Option<f64> {
        if self.chain.is_adrift() {
            None
        } else if self.chain.has_walls() {
            // Any measure of what a net impulse holds up will do, if it is the same for all sites.
            let lowest = self.frequencies.first().copied().unwrap_or(1.0);
            Some(1.0 / (lowest * lowest * self.sites() as f64 * self.period))
        } else {
            Some(1.0 / (self.chain.gamma1() * self.sites() as f64 * self.period))
        }
    }

    /// Static responses of all modes, see [`ImpulseResponse::mode_static`].
    pub fn statics(&self) -> &[f64] {
        &self.statics[..self.modes]
    }

    /// 1/S₀ with S₀ = Σ b_k²/(Ω_k²T), the static stiffness at home times T; 0 where nothing holds the lattice.
    pub fn static_stiffness(&self) -> f64 {
        self.static_stiffness
    }

    /// Share of [`ImpulseResponse::uniform_static`] in the static response at home: (1/γ₁MT)/S₀, 1 where nothing holds the lattice.
    #[inline]
    pub fn uniform_share(&self) -> f64 {
        self.uniform_static().map_or(1.0, |uniform| uniform * self.static_stiffness())
    }

    /// What states at an impact and half a period after it are made of, four modes at a time: weights, static responses, dynamic ones at
    /// the impulse and half a period after it. What fills up the last group weighs nothing.
    #[doc(hidden)]
    pub fn in_fours(&self) -> impl Iterator<Item = [Lane; 4]> + '_ {
        fours([&self.weights, &self.statics, &self.at_impulse, &self.at_half])
    }

    /// Four modes at a time in the same way: frequencies, weights, cosines and sines of ΩT/2.
    #[doc(hidden)]
    pub fn swings_in_fours(&self) -> impl Iterator<Item = [Lane; 4]> + '_ {
        fours([&self.frequencies, &self.weights, &self.cos_half, &self.sin_half])
    }

    /// Dynamic responses of all modes, without their weights, at the impulse.
    pub fn at_impulse(&self) -> &[f64] {
        &self.at_impulse[..self.modes]
    }

    /// Dynamic responses of all modes, without their weights, half a period after the impulse.
    pub fn at_half(&self) -> &[f64] {
        &self.at_half[..self.modes]
    }

    /// Dynamic part of K₀ at the impulse, t = 0: Σ b_k² [cot y/(2Ω) − 1/(Ω²T)].
    pub fn dynamic_at_impulse(&self) -> f64 {
        self.dynamic_at_impulse
    }

    /// Dynamic part of K₀ half a period after the impulse: Σ b_k² [1/(2Ω sin y) − 1/(Ω²T)].
    pub fn dynamic_at_half(&self) -> f64 {
        self.dynamic_at_half
    }
}

/// Groups of four lists side by side.
fn fours(lists: [&Vec<f64>; 4]) -> impl Iterator<Item = [Lane; 4]> + '_ {
    let [a, b, c, d] = lists.map(|list| list.as_chunks().0.iter());
    a.zip(b).zip(c.zip(d)).map(|((a, b), (c, d))| [*a, *b, *c, *d])
}

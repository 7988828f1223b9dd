//! Stable or not, and how stability is lost.

use nalgebra::Complex;

/// How the leading multiplier leaves the unit circle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Mechanism {
    /// Through +1.
    Pitchfork,
    /// Through −1.
    PeriodDoubling,
    /// As a complex pair.
    NeimarkSacker,
}

impl Mechanism {
    /// The name used in files: `pitchfork`, `period-doubling`, `neimark-sacker`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pitchfork => "pitchfork",
            Self::PeriodDoubling => "period-doubling",
            Self::NeimarkSacker => "neimark-sacker",
        }
    }

    /// The mechanism of a multiplier outside the circle.
    pub fn of(multiplier: Complex<f64>) -> Self {
        if multiplier.im != 0.0 {
            Self::NeimarkSacker
        } else if multiplier.re > 0.0 {
            Self::Pitchfork
        } else {
            Self::PeriodDoubling
        }
    }
}

/// From which growth per period an orbit counts as unstable.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Tolerance {
    /// Strict: from the growth that rounding could feign, [`Verdict::resolution`].
    #[default]
    Rounding,
    /// From this growth |μ| − 1 per period on, if larger than the resolution. (The paper's map of forced breathers
    /// corresponds to about 0.01, see `errata`.)
    Growth(f64),
}

/// The verdict on an orbit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// No perturbation grows by more than the tolerance.
    pub stable: bool,
    /// How stability is lost, for an unstable orbit.
    pub mechanism: Option<Mechanism>,
    /// Largest modulus of the non-trivial multipliers whose perturbations reach an impact. (Modes odd about the one
    /// site that is hit do not: their multipliers lie on the circle exactly.) 1 for a chain that has none. Without
    /// coupling, γ₂ = 0, the masses that are not hit count too, with modulus 1.
    pub spectral_radius: f64,
    /// The multiplier of that modulus.
    pub leading: Complex<f64>,
    /// Growth that rounding alone could feign: a perturbation of size n·ε·‖M‖ of an n×n matrix moves a simple multiplier
    /// by about as much, but pulls a pair that meets on the circle (elastic impacts) off it by the square root.
    pub resolution: f64,
}

impl Verdict {
    /// Growth of the leading perturbation per period, |μ| − 1.
    pub fn growth(&self) -> f64 {
        self.spectral_radius - 1.0
    }

    pub(crate) fn new(leading: Option<Complex<f64>>, resolution: f64, tolerance: Tolerance) -> Self {
        let leading = leading.unwrap_or(Complex::new(1.0, 0.0));
        let spectral_radius = leading.re.hypot(leading.im);
        let allowed = match tolerance {
            Tolerance::Rounding => resolution,
            Tolerance::Growth(growth) => growth.max(resolution),
        };
        let stable = spectral_radius - 1.0 <= allowed;
        let mechanism = (!stable).then(|| Mechanism::of(leading));
        Self { stable, mechanism, spectral_radius, leading, resolution }
    }
}

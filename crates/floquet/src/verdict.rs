//! Stable or not, and how stability is lost.

use std::fmt;

use nalgebra::Complex;
use vibrochain_breather::LatticeOrbit;

use crate::zeros::modulus;

/// Where the leading multiplier of an unstable orbit is: how stability is lost.
///
/// A verdict knows one point, not the way to it. Of a multiplier beyond +1 that does not say what happens at +1: orbits of one
/// family may end there in a fold or others branch off in a pitchfork; a conservative one may have its extreme energy there,
/// and go on. [`Mechanism::Pitchfork`] is said only where symmetry leaves nothing else; which one it is elsewhere is found by
/// following the branch to where the multiplier is +1, see [`crate::locate()`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[must_use]
pub enum Mechanism {
    /// Through +1; a fold or a pitchfork, which one is not known.
    PlusOne,
    /// Through +1, by a perturbation that breaks the orbit's symmetry, u(t + T/2) = −u(t) (without asymmetry, φ = T/2). It
    /// comes back after half a period with its sign turned against the orbit's: where its multiplier is +1 two orbits branch
    /// off that are each other's mirror images.
    Pitchfork,
    /// Through −1.
    PeriodDoubling,
    /// As a complex pair.
    NeimarkSacker,
}

vibrochain_lattice::names!(Mechanism {
    PlusOne "plus-one", Pitchfork "pitchfork", PeriodDoubling "period-doubling", NeimarkSacker "neimark-sacker",
});

impl Mechanism {
    /// The leading multiplier is real and above +1, whatever else is known.
    pub fn is_through_plus_one(self) -> bool {
        matches!(self, Self::PlusOne | Self::Pitchfork)
    }

    /// What a multiplier outside the circle says on its own.
    pub fn of(multiplier: Complex<f64>) -> Self {
        if multiplier.im != 0.0 {
            Self::NeimarkSacker
        } else if multiplier.re > 0.0 {
            Self::PlusOne
        } else {
            Self::PeriodDoubling
        }
    }
}

/// Excesses that errors of an orbit's own data can feign: one multiplier moves by about the error, two that meet on the circle by its root.
const ROUNDING: f64 = 1e-12;
const SPLIT_BY_ROUNDING: f64 = 1e-6;

/// From which excess per period an orbit counts as unstable.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(from = "Option<f64>", into = "Option<f64>")
)]
pub enum Tolerance {
    /// Strict: from any excess that is not rounding, see [`Verdict::resolution`].
    #[default]
    Rounding,
    /// From this excess |μ| − 1 per period on. (The paper's map of forced breathers corresponds to about 0.01, see
    /// `errata`.)
    Excess(f64),
}

impl Tolerance {
    /// The excess still called stable.
    pub(crate) fn allowed(self) -> f64 {
        match self {
            Self::Rounding => 0.0,
            Self::Excess(excess) => excess,
        }
    }
}

/// As `threshold` in scenes: the excess, or none.
impl From<Option<f64>> for Tolerance {
    fn from(threshold: Option<f64>) -> Self {
        threshold.map_or(Self::Rounding, Self::Excess)
    }
}

impl From<Tolerance> for Option<f64> {
    fn from(tolerance: Tolerance) -> Self {
        match tolerance {
            Tolerance::Rounding => None,
            Tolerance::Excess(excess) => Some(excess),
        }
    }
}

/// What is asked of an orbit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Question<'a> {
    pub(crate) orbit: LatticeOrbit<'a>,
    pub(crate) tolerance: Tolerance,
    /// All multipliers, and the error of the leading one even where the verdict does not hang on it.
    pub(crate) thorough: bool,
}

/// Where an answer comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[must_use]
pub enum Method {
    /// From the secular function: zeros of a scalar function, counted or found.
    #[default]
    Secular,
    /// From a matrix: where it was asked for ([`crate::Analyser::dense`]), and where a verdict alone is asked for of an orbit that is
    /// its own mirror image in time, of few masses: with impacts at several sites, or where the secular function left it open; and where
    /// zeros of the determinant could not be counted or cost too much.
    Dense,
}

impl Method {
    /// The name used in files: `secular`, `dense`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Secular => "secular",
            Self::Dense => "dense",
        }
    }
}

/// The verdict on an orbit: stable, unstable, or too close to the border to be told (`undecided`).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[must_use]
pub struct Verdict {
    /// No perturbation grows by more than the tolerance, errors allowed for.
    pub stable: bool,
    /// The excess is closer to the tolerance than its own error: neither stable nor unstable can be said.
    pub undecided: bool,
    /// How stability is lost, for an unstable orbit.
    pub mechanism: Option<Mechanism>,
    /// Largest modulus of the non-trivial multipliers whose perturbations reach an impact. (Modes odd about the one
    /// site that is hit do not, nor do masses without coupling: their multipliers lie on the circle exactly.) 1 for a
    /// chain that has none, and where structure alone keeps all of them on the circle.
    pub spectral_radius: f64,
    /// The multiplier of that modulus. Where all are on the circle and none leads, any of them; [`crate::Analyser::verdict`]
    /// then names the trivial 1 and works none out.
    #[cfg_attr(feature = "serde", serde(serialize_with = "crate::serde_impl::complex"))]
    pub leading: Complex<f64>,
    /// Estimated error of the spectral radius, and of the excess. [`crate::Analyser::stability`] works out for every orbit
    /// what the errors of its own data add to it, [`crate::Analyser::verdict`] only where the answer may hang on it; there a
    /// dense matrix's is that of a well-conditioned eigenvalue. 0 where structure decides.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub resolution: f64,
    /// Where the verdict comes from.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub method: Method,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) excess: f64,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.mechanism {
            Some(mechanism) => write!(f, "unstable ({mechanism})")?,
            None => write!(f, "{}", if self.undecided { "undecided" } else { "stable" })?,
        }
        write!(f, ", spectral radius {}", self.spectral_radius)
    }
}

impl Verdict {
    /// Excess of the leading perturbation per period, |μ| − 1: from the secular function with its own relative accuracy, so
    /// that it may be far below the rounding of the spectral radius.
    pub fn excess(&self) -> f64 {
        self.excess
    }

    /// Errors of the orbit's own data could change the verdict: its excess is that near to the tolerance. A verdict by structure does not hang
    /// on them, and an undecided one claims nothing.
    pub(crate) fn hangs_on_rounding(&self, lossless: bool, tolerance: Tolerance) -> bool {
        let reach = if lossless { SPLIT_BY_ROUNDING } else { ROUNDING };
        !self.undecided && self.excess != 0.0 && (self.excess - tolerance.allowed()).abs() < reach
    }

    /// Every multiplier lies on the circle, by structure.
    pub(crate) fn on_circle(leading: Option<Complex<f64>>) -> Self {
        let leading = leading.unwrap_or(Complex::new(1.0, 0.0));
        let (mechanism, method) = (None, Method::Secular);
        Self {
            stable: true,
            undecided: false,
            mechanism,
            spectral_radius: 1.0,
            leading,
            resolution: 0.0,
            method,
            excess: 0.0,
        }
    }

    /// The verdict on two spaces that do not mix.
    pub(crate) fn or_worse(self, other: Self) -> Self {
        let rank = |verdict: &Self| (!verdict.stable && !verdict.undecided, verdict.undecided, verdict.excess);
        let (worse, better) = if rank(&self) < rank(&other) { (other, self) } else { (self, other) };
        // An instability beyond doubt stays one, but how large it is may be in question.
        let open = better.excess + better.resolution - worse.excess;
        Self { resolution: if better.undecided { worse.resolution.max(open) } else { worse.resolution }, ..worse }
    }

    /// An excess that may as well be none.
    pub(crate) fn unsettled(leading: Complex<f64>, excess: f64, resolution: f64, tolerance: Tolerance) -> Self {
        let stable = excess + resolution < tolerance.allowed();
        Self { stable, undecided: !stable, mechanism: None, ..Self::of_excess(leading, excess, resolution, tolerance) }
    }

    /// Compares the excess of the leading multiplier, known up to `resolution`, with the tolerance.
    pub(crate) fn of_excess(leading: Complex<f64>, excess: f64, resolution: f64, tolerance: Tolerance) -> Self {
        let above = excess - tolerance.allowed();
        // Where the error is not a number nothing is known.
        let undecided = resolution.is_nan() || above.abs() <= resolution;
        let stable = !undecided && above < 0.0;
        let mechanism = (!undecided && !stable).then(|| Mechanism::of(leading));
        // Of a small multiplier the modulus itself has more digits.
        let spectral_radius = if excess < -0.5 { modulus(leading) } else { 1.0 + excess };
        let method = Method::Secular;
        Self { stable, undecided, mechanism, spectral_radius, leading, resolution, method, excess }
    }
}

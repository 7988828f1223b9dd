//! A stripe of instability along a line in the plane of parameters, and why there is none.

use nalgebra::Complex;
use thiserror::Error;
use vibrochain_breather::{BreatherError, Family};
use vibrochain_lattice::{Model, Parameter, ParameterError};

/// Conservative breathers of one family along a line: all parameters but one are those of the model.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct StripeLine {
    /// The other parameters.
    pub model: Model,
    /// Single- or double-sided.
    pub family: Family,
    /// The parameter that varies.
    pub free: Parameter,
}

impl StripeLine {
    pub(super) fn check(&self) -> Result<(), NoStripe> {
        let family = matches!(self.family, Family::DoubleSided | Family::SingleSided);
        if family && self.model.is_conservative() { Ok(()) } else { Err(NoStripe::NotConservative) }
    }
}

/// What is at the end of a stripe.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StripeEnd {
    /// Two pairs of multipliers meet on the circle, or one meets itself at −1.
    Edge,
    /// The stripe goes on beyond the range, or beyond the last physical breather.
    Open,
}

/// A stripe of instability on a line.
///
/// ```
/// use vibrochain_breather::Family;
/// use vibrochain_floquet::{StripeFinder, StripeLine};
/// use vibrochain_lattice::{Chain, Model, Parameter};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4)?;
/// let line = StripeLine { model, family: Family::DoubleSided, free: Parameter::Omega };
/// // Ω̃₈ + Ω̃₉ = ω near ω = 1.52.
/// let stripe = StripeFinder::default().near(&line, (8, 9), 1, 1.52)?;
/// assert!(stripe.resolved && (stripe.centre - 1.521774380629).abs() < 1e-12);
/// assert!((stripe.half_width / 2.3381e-4 - 1.0).abs() < 1e-4 && (stripe.growth / 4.845e-4 - 1.0).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct Stripe {
    /// Modes k ≤ l and harmonic j, as in [`Collision`](crate::Collision); k = l is a mode against itself (period doubling). `None` if no
    /// two modes are next to the multipliers that meet.
    pub pair: Option<((usize, usize), usize)>,
    /// Middle of both ends.
    pub centre: f64,
    /// Estimated error of the centre and, as long as the stripe is resolved, of either end.
    pub error: f64,
    /// Half the distance of the ends. It has digits of its own, however small against the error it is.
    pub half_width: f64,
    /// The least value of the parameter, and the largest.
    pub edges: [f64; 2],
    /// What is there.
    pub ends: [StripeEnd; 2],
    /// The largest ln|μ| inside, per period.
    pub growth: f64,
    /// The multiplier that has it.
    pub multiplier: Complex<f64>,
    /// The parameter can tell the ends apart; if not they are where the centre is.
    pub resolved: bool,
}

impl Stripe {
    /// A mode against itself.
    pub(super) fn is_doubling(&self) -> bool {
        self.pair.is_some_and(|((k, l), _)| k == l)
    }

    pub(super) fn is_about(&self, value: f64) -> bool {
        self.edges[0] < value && value < self.edges[1]
    }

    /// Takes over both edges.
    pub(super) fn set_edges(&mut self, edges: [f64; 2]) {
        self.edges = edges;
        self.centre = 0.5 * (edges[0] + edges[1]);
        self.half_width = 0.5 * (edges[1] - edges[0]);
    }
}

/// Why there is no stripe.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum NoStripe {
    /// A parameter out of range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The orbit cannot be had there.
    #[error(transparent)]
    Breather(#[from] BreatherError),
    /// Force or losses, or a family of other orbits.
    #[error(
        "stripes are collisions of modes without loss: give a single- or double-sided breather without force and with elastic impacts"
    )]
    NotConservative,
    /// No breather, or none of finite saltation.
    #[error("there is no breather at this value")]
    NoBreather,
    /// One of the modes is not there: the breather has drawn it out of the band.
    #[error("mode {mode} is none of the breather at this value")]
    NoMode {
        /// Its number.
        mode: usize,
    },
    /// Both multipliers have one signature, or, of a symmetric breather, are opposite roots.
    #[error("the two modes pass each other")]
    Passes,
    /// Nothing is met near the value, or more than two modes at once.
    #[error("the two modes do not meet near this value, or not alone")]
    Elsewhere,
}

//! Krein signatures of multipliers, and of the modes of the bare ring.

use nalgebra::Complex;
use vibrochain_breather::BlochEquations;
use vibrochain_lattice::ImpulseResponse;

use crate::spectrum::KreinForms;

/// Part of the action below which the sign of the form is rounding's: the form of a pair that has met, or left the circle, is 0.
const NO_FORM: f64 = 1e-7;

/// Krein signature of a pair of multipliers e^{±iθ}, by the one in the upper half plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(into = "i8"))]
#[must_use]
pub enum Signature {
    /// Krein's form is positive on it: it is the e^{iΩT} of its mode.
    Positive,
    /// Krein's form is negative on it: it is the e^{−iΩT} of its mode.
    Negative,
}

impl Signature {
    /// By the sign of a number that is not 0.
    fn of(sign: f64) -> Self {
        if sign > 0.0 { Self::Positive } else { Self::Negative }
    }

    /// By Krein's form, as a part of the action, on a multiplier in the upper half plane.
    pub(crate) fn of_form(form: f64) -> Option<Self> {
        if form.abs() > NO_FORM { Some(Self::of(form)) } else { None }
    }

    /// Of a multiplier above or below the real axis.
    pub(super) fn at(multiplier: Complex<f64>, forms: &KreinForms) -> Option<Self> {
        let told = forms.at(multiplier, 1)?;
        Self::of_form(told.first()?.form * multiplier.im.signum())
    }

    /// +1 or −1.
    pub fn value(self) -> i8 {
        match self {
            Self::Positive => 1,
            Self::Negative => -1,
        }
    }
}

impl From<Signature> for i8 {
    fn from(signature: Signature) -> Self {
        signature.value()
    }
}

/// Signature of a multiplier on the unit circle, above or below the real axis, of an orbit without losses, by its equations J(z): the sign of
/// Krein's form on its eigenvector, for the one in the upper half plane. `None` for what is no multiplier of the modes that feel the impacts,
/// or not on the circle, for one of a pair that has met, and where energy is lost. O(n r²) for n modes and r impacts.
///
/// ```
/// use vibrochain_breather::{Family, Finder, OrbitList};
/// use vibrochain_floquet::{Complex, Secular, Signature, signature};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(6, 0.2, 0.15)?, 1.2, 0.4)?;
/// let (mut finder, mut found, mut secular) = (Finder::new(6), OrbitList::default(), Secular::default());
/// finder.find(&model, Family::DoubleSided, &mut found)?;
/// secular.replace(finder.prepared(&found.orbits[0])?)?;
/// let (equations, _) = finder.at_contacts(&found.orbits[0])?.bloch_equations();
/// let told = |nu: &Complex<f64>| {
///     let multiplier = Complex::new(nu.re, (1.0 - nu.re * nu.re).sqrt());
///     (multiplier.arg(), signature(&equations, multiplier))
/// };
/// let mut signatures: Vec<_> = secular.roots()?.0.iter().map(told).collect();
/// signatures.sort_by(|a, b| a.0.total_cmp(&b.0));
/// // The mode with the smallest frequency turns by less than half a circle, the other two by more.
/// let (negative, positive) = (Some(Signature::Negative), Some(Signature::Positive));
/// assert_eq!(signatures.iter().map(|s| s.1).collect::<Vec<_>>(), [negative, negative, positive]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn signature(equations: &BlochEquations, multiplier: Complex<f64>) -> Option<Signature> {
    let is_kept = equations.kernel().modes().iter().all(|mode| mode.decay == 0.0)
        && equations.impacts().iter().all(|impact| impact.restitution == 1.0);
    if is_kept { Signature::at(multiplier, &KreinForms::without_parts(equations)) } else { None }
}

/// Signature of even mode k of the bare ring, the sign of sin Ω_kT; `None` where rounding could have changed it, 2Ω_k = jω.
///
/// With a breather on the ring the modes swing at other frequencies, and some multipliers have passed −1: see
/// [`crate::DressedModes::signatures`]. (The signs of the residues of [`crate::Residues`] bracket real roots, and are others: a
/// root that passes the pole of a mode turns the sign of its residue, but keeps its signature.)
///
/// ```
/// use vibrochain_floquet::{Signature, bare_signature};
/// use vibrochain_lattice::{Chain, ImpulseResponse, Spectrum};
/// let spectrum = Spectrum::new(Chain::new(21, 0.2, 0.1)?);
/// // Ω runs from 0.447 to 0.775: at ω = 1.2 some modes are below ω/2 and some are above.
/// let response = ImpulseResponse::new(&spectrum, 1.2)?;
/// assert_eq!(bare_signature(&response, 0), Some(Signature::Positive));
/// assert_eq!(bare_signature(&response, 10), Some(Signature::Negative));
/// assert_eq!(bare_signature(&response, 11), None);
/// # Ok::<(), vibrochain_lattice::LatticeError>(())
/// ```
pub fn bare_signature(response: &ImpulseResponse, mode: usize) -> Option<Signature> {
    let half = 0.5 * response.frequencies().get(mode)? * response.period();
    let sin = 2.0 * response.sin_half().get(mode)? * response.cos_half().get(mode)?;
    // The phase carries a relative error of about 2ε.
    if sin.abs() > 4.0 * f64::EPSILON * (1.0 + half) { Some(Signature::of(sin)) } else { None }
}

//! Krein signatures of the modes of the ring.

use vibrochain_lattice::ImpulseResponse;

/// Krein signature of a pair of multipliers e^{±iθ}, by the one in the upper half plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Signature {
    /// Krein's form is positive on it: it is the e^{iΩT} of its mode.
    Positive,
    /// Krein's form is negative on it: it is the e^{−iΩT} of its mode.
    Negative,
}

impl Signature {
    /// +1 or −1.
    pub fn value(self) -> i8 {
        match self {
            Self::Positive => 1,
            Self::Negative => -1,
        }
    }
}

/// Signature of even mode k of the ring, the sign of sin Ω_kT; `None` where rounding could have changed it, 2Ω_k = jω.
///
/// Signatures are of one kind up to ω = 2Ω_max; below that the modes above jω/2 and those below it have opposite ones, and
/// can collide. (The signs of the residues of [`crate::Residues`] bracket real roots, and are others: a root that passes
/// the pole of a mode turns the sign of its residue, but keeps its signature.)
///
/// ```
/// use vibrochain_floquet::{Signature, signature};
/// use vibrochain_lattice::{Chain, ImpulseResponse, Spectrum};
/// let spectrum = Spectrum::new(Chain::new(21, 0.2, 0.1)?);
/// // Ω runs from 0.447 to 0.775: at ω = 1.2 some modes are below ω/2 and some are above.
/// let response = ImpulseResponse::new(&spectrum, 1.2)?;
/// assert_eq!(signature(&response, 0), Some(Signature::Positive));
/// assert_eq!(signature(&response, 10), Some(Signature::Negative));
/// assert_eq!(signature(&response, 11), None);
/// # Ok::<(), vibrochain_lattice::LatticeError>(())
/// ```
pub fn signature(response: &ImpulseResponse, mode: usize) -> Option<Signature> {
    let half = mode_half_phase(response, mode)?;
    let sin = 2.0 * response.sin_half().get(mode)? * response.cos_half().get(mode)?;
    // The phase carries a relative error of about 2ε.
    if sin.abs() <= 4.0 * f64::EPSILON * (1.0 + half) {
        None
    } else if sin > 0.0 {
        Some(Signature::Positive)
    } else {
        Some(Signature::Negative)
    }
}

fn mode_half_phase(response: &ImpulseResponse, mode: usize) -> Option<f64> {
    response.frequencies().get(mode).map(|frequency| 0.5 * frequency * response.period())
}

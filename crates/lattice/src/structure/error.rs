//! What can be wrong with a structure.

use rustfft::num_complex::Complex;
use thiserror::Error;

use crate::error::Short;

/// Why there is no such structure, or no answer about it.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StructureError {
    /// A list or a matrix has the wrong size.
    #[error("{what} has {given} entries where the structure needs {wanted}")]
    Size {
        /// Which one.
        what: String,
        /// Its size.
        given: usize,
        /// The size that fits.
        wanted: usize,
    },
    /// A number is not finite, or outside its range.
    #[error("{what} = {} is out of range: give {requirement}", Short(*value))]
    Range {
        /// Which one.
        what: String,
        /// Its value.
        value: f64,
        /// What it must be.
        requirement: &'static str,
    },
    /// A matrix is not symmetric.
    #[error("{what} is not symmetric: its entries ({row}, {column}) and ({column}, {row}) differ")]
    Asymmetric {
        /// Which one.
        what: &'static str,
        /// A row where it is not.
        row: usize,
        /// And the column.
        column: usize,
    },
    /// The mass matrix is not positive.
    #[error("the mass matrix is not positive definite: every coordinate needs a mass; eliminate those without")]
    Massless,
    /// The stiffness has a negative eigenvalue.
    #[error(
        "the stiffness matrix is indefinite (eigenvalue {} relative to mass): the structure falls over between its stops; give a \
         stiffness without negative eigenvalues",
        Short(*square)
    )]
    Unstable {
        /// The eigenvalue Ω².
        square: f64,
    },
    /// A contact that moves with no coordinate.
    #[error("contact {contact} has no weight: name the coordinate it is at, or weights of which one is not 0")]
    NoWeight {
        /// Its number.
        contact: usize,
    },
    /// Dashpots couple more modes than are worked out together.
    #[error(
        "dashpots couple {modes} modes, at most {most} are worked out together: keep the slowest, modes = {most}, or give dashpots that do not \
         couple them"
    )]
    Coupled {
        /// How many.
        modes: usize,
        /// The most.
        most: usize,
    },
    /// A contact that stands still in all modes that are kept.
    #[error("contact {contact} does not move in the first {modes} modes: keep more of them")]
    Unmoved {
        /// Its number.
        contact: usize,
        /// How many are kept.
        modes: usize,
    },
    /// A contact with its lower barrier above the upper one.
    #[error("contact {contact} has its lower barrier at {} and its upper one at {}: give lower < upper", Short(*lower), Short(*upper))]
    Barriers {
        /// Its number.
        contact: usize,
        /// The lower barrier.
        lower: f64,
        /// The upper one.
        upper: f64,
    },
    /// There is nothing to hit.
    #[error("the structure has no contact: give one at least")]
    NoContact,
    /// Two poles of the damped structure coincide and have one shape.
    #[error(
        "two modes of the damped structure meet at the rate {} + {}i: change a damping a little",
        Short(*re),
        Short(*im)
    )]
    Defective {
        /// Real part of the rate.
        re: f64,
        /// Its imaginary part.
        im: f64,
    },
    /// A dashpot couples a mode without stiffness to others.
    #[error("dashpots couple a rigid motion to others: give it a spring, however soft, or a dashpot of its own alone")]
    RigidDamped,
    /// Of a mode that is damped far beyond critical, the slow motion has no digits.
    #[error(
        "mode {mode} is damped {ratio:.0e} times as much as makes it critical: of its slow motion no digits are left; give less damping, or leave its mass away"
    )]
    Overdamped {
        /// The mode.
        mode: usize,
        /// Its damping ratio ζ.
        ratio: f64,
    },
    /// A harmonic of the load meets a mode that nothing damps.
    #[error(
        "resonance: harmonic {harmonic} of omega = {} meets mode {mode} (frequency {}) that nothing damps; move omega off it or \
         give it damping",
        Short(*omega),
        Short(*frequency)
    )]
    Resonance {
        /// Number of the harmonic.
        harmonic: u32,
        /// Of the mode.
        mode: usize,
        /// The mode's frequency.
        frequency: f64,
        /// ω
        omega: f64,
    },
    /// The eigenvalues were not found.
    #[error("the eigenvalues of the structure did not converge")]
    NotConverged,
}

impl StructureError {
    /// Refuses a list of another size.
    pub(super) fn sized(what: &str, given: usize, wanted: usize) -> Result<(), Self> {
        if given == wanted { Ok(()) } else { Err(Self::Size { what: what.to_owned(), given, wanted }) }
    }
}

/// Refuses loads that do not fit `n` coordinates.
pub(super) fn check_loads<'a>(
    n: usize,
    still: &[f64],
    loads: impl Iterator<Item = (u32, &'a [Complex<f64>])>,
) -> Result<(), StructureError> {
    if !still.is_empty() {
        StructureError::sized("the static load", still.len(), n)?;
    }
    finite("the static load", still.iter().copied())?;
    for (number, load) in loads {
        StructureError::sized("the load", load.len(), n)?;
        if number == 0 {
            let (what, requirement) =
                ("harmonic of the load".to_owned(), "a number from 1; the static load has its own key");
            return Err(StructureError::Range { what, value: 0.0, requirement });
        }
        finite("the load", load.iter().flat_map(|f| [f.re, f.im]))?;
    }
    Ok(())
}

/// Refuses what is no number.
pub(super) fn finite(what: &str, mut values: impl Iterator<Item = f64>) -> Result<(), StructureError> {
    match values.find(|value| !value.is_finite()) {
        Some(value) => Err(StructureError::Range { what: what.to_owned(), value, requirement: "finite numbers" }),
        None => Ok(()),
    }
}

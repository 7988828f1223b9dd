//! Why a check could not be made.

use thiserror::Error;

/// Failures of this crate. Logarithms are given because the numbers are beyond the range of `f64`.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TruthError {
    /// A frequency that is not a positive finite number, or no period at all.
    #[error("{name} = {value} is out of range: give {requirement}")]
    Parameter {
        /// The parameter's name.
        name: &'static str,
        /// The value as given.
        value: f64,
        /// What the value must be.
        requirement: &'static str,
    },
    /// A harmonic of the motion meets a mode: no periodic response exists.
    #[error(
        "resonance: a harmonic of the orbit's frequency {omega} meets mode {mode}, or the force the uniform mode; move omega or a stiffness off it"
    )]
    Resonance {
        /// The mode k.
        mode: usize,
        /// Frequency of the orbit.
        omega: f64,
    },
    /// The orbit is of a structure that is no lattice.
    #[error("this orbit is of a structure that is no lattice: ask TrueStructureOrbit")]
    NoLattice,
    /// The orbit is of a lattice with dashpots.
    #[error("this orbit is of a lattice with dashpots: ask TrueStructureOrbit")]
    Dashpots,
    /// Impacts lose energy and no force restores it.
    #[error("restitution below 1 without a force: no periodic orbit exists; give an amplitude or restitution 1")]
    Dissipative,
    /// The equations are singular at the start, or an impact has no speed.
    #[error("singular: {what}")]
    Singular {
        /// What is singular.
        what: &'static str,
    },
    /// Newton's method did not settle.
    #[error(
        "did not converge: after {iterations} steps the last one was 1e{last_step:.0} of the solution, {moved:e} away from the start; give more bits, or a better start"
    )]
    NotConverged {
        /// Steps taken.
        iterations: usize,
        /// log₁₀ of the last step relative to the solution.
        last_step: f64,
        /// Distance from the start, relative.
        moved: f64,
    },
    /// A multiplier that is e^{±iΩT} itself: modes of equal frequency (γ₂ = 0), of which impacts touch only one
    /// combination.
    #[error(
        "the multiplier sits on a pole: it is exp(±iΩT) of mode {mode} itself, shared by {multiplicity} modes of equal frequency (to this precision)"
    )]
    OnPole {
        /// The lowest mode of that frequency.
        mode: usize,
        /// How many modes even about the site share it.
        multiplicity: usize,
    },
    /// The secular determinant is for impacts at one site.
    #[error("the impacts are at several sites; the secular determinant is for one")]
    SeveralSites,
    /// Two things to be compared are not of the same shape.
    #[error("not comparable: {what}")]
    Mismatch {
        /// What differs.
        what: &'static str,
    },
}

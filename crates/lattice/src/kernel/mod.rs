//! The kernel K^z of impacts that repeat every period, each z times the one before: a sum over any list of modes.
//!
//! ```text
//! K^z_ij(t) = Σ_{n≥0} z⁻ⁿ w_iᵀ h(t+nT) w_j,      0 < t ≤ T
//! ```
//!
//! with h the impulse response of M q″ + C q′ + K q. z = 1 is the periodic kernel of orbits; at a multiplier z it carries the
//! perturbation. A mode is a pair of poles of (λ²M + λC + K)⁻¹: a damped oscillator of real shape ([`BlochKernel::push_oscillator`]),
//! a complex pole and its conjugate, or two real ones, where the damping mixes the undamped modes ([`crate::LinearMode::pole`],
//! [`crate::LinearMode::real_poles`]).
//!
//! | module | holds |
//! |---|---|
//! | `turn` | [`Turn`]: the two-dimensional flow of one mode, e^{At}, regular at critical damping |
//! | `coordinates` | [`Coordinates`]: those of two poles together, or of each of two real ones |
//! | `bloch` | [`BlochKernel`]: modes, their shapes at the contacts, sums over them |
//! | `clusters` | [`ModeCluster`]: modes whose poles nearly coincide, as one |

pub(crate) mod bloch;
pub(crate) mod clusters;
pub(crate) mod coordinates;
pub(crate) mod damped_steady;
pub(crate) mod decay;
pub(crate) mod impulse;
pub(crate) mod steady;
pub(crate) mod turn;

pub use bloch::{BlochJet, BlochKernel, BlochMode};
pub use clusters::ModeCluster;
pub use coordinates::Coordinates;
pub use turn::{ModeFlow, Turn, Turned, oscillator_flight};

#[cfg(test)]
mod tests;

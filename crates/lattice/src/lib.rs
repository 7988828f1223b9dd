//! The linear lattice underneath a vibro-impact chain: a ring, and rows with other ends and in several layers.
//!
//! ```text
//! Point ──> Model: Chain, Force, Barrier ──> Spectrum ──> ImpulseResponse, BlochKernel, Propagator
//! Structure, DampedChain ──> ModalStructure: LinearMode, Contact ──────> BlochKernel
//! ```
//!
//! Between impacts the chain is linear: `M` unit masses on a ring, each held by an on-site spring γ₁ and
//! coupled to both neighbours by γ₂,
//!
//! ```text
//! ü_n = −γ₁ u_n − γ₂ (2u_n − u_{n+1} − u_{n−1}) + F(t+ψ),     |u_n − a| ≤ 1 ,
//! ```
//!
//! under the force F(t) = A cos ωt or any sum of its odd harmonics.
//! Everything is dimensionless: the half width of the gap and the mass are 1.
//!
//! Conventions, the same in every layer above:
//! - a ring has `sites` = M masses, numbered 0 … M−1 (the paper's N is M − 1); other lattices are numbered row by row
//!   ([`Chain`]);
//! - modes are numbered by wavenumber k, Ω_k² = γ₁ + 4γ₂ sin²(πk/M); a vector over modes holds those even
//!   about site 0, k = 0 … ⌊M/2⌋, because impacts at site 0 excite no others;
//! - `omega` is the frequency of the force and of a map, T = 2π/ω its period;
//! - transforms carry their normalisation in the weights b_k² (1/M or 2/M), so that Σ b_k² = 1.
//!
//! | name | what it is |
//! |---|---|
//! | [`Chain`], [`Model`], [`Barrier`] | validated parameters |
//! | [`Force`], [`Wave`] | odd harmonics and the uniform motion they drive |
//! | [`Ends`], [`RowEnds`] | closed, free, fixed, or fixed and free; modes of one row, by images |
//! | [`DampedChain`] | one row with dashpots, any contacts and loads |
//! | [`Steady`] | motion under the force alone, between walls too |
//! | [`Spectrum`] | frequencies, weights, band, resonances |
//! | [`Parameter`], [`DampedParameter`], [`Row`] | the real ones by name, to be varied, those of damped chains alone; their table |
//! | [`Point`] | values of all of them, not yet checked, from which a model is made |
//! | [`Shapes`] | what each mode makes of each mass |
//! | [`DistinctMasses`] | the masses that symmetry leaves |
//! | [`ImpulseResponse`] | the periodic impulse response K_n(t) in closed form |
//! | [`BlochKernel`] | the kernel K^z of impacts that repeat every period, each z times the one before, of any damped modes |
//! | [`Decay`] | harmonic response, far field in full relative accuracy |
//! | [`Propagator`] | exact free flight |
//! | [`Stop`], [`aside()`] | ends long work early; waits for work that cannot look at it |
//!
//! With the feature `serde` values are written and read by the names of `mapgen`'s JSON, and what is out of range is refused.
//!
//! # Example
//!
//! ```
//! use vibrochain_lattice::{Chain, ImpulseResponse, Spectrum};
//!
//! let spectrum = Spectrum::new(Chain::new(21, 0.2, 0.1)?);
//! let response = ImpulseResponse::new(&spectrum, 1.5)?;
//! // χ₂ of the paper is −2 K₀(0).
//! assert!((-2.0 * response.value(0, 0.0) + 0.5788951801307799).abs() < 1e-14);
//! # Ok::<(), vibrochain_lattice::LatticeError>(())
//! ```

mod aside;
mod error;
mod flight;
mod kernel;
mod model;
mod modes;
mod names;
#[doc(hidden)]
pub mod simd;
mod stop;
mod structure;

pub use aside::aside;
pub use error::{LatticeError, MAX_MAGNITUDE, ParameterError, RESONANCE_TOLERANCE, Resonance, Short};
pub use flight::propagator::Propagator;
pub use kernel::decay::{Decay, decay, far_field, far_motion, harmonic_response};
pub use kernel::impulse::{ImpulseResponse, KernelJet};
pub use kernel::steady::Steady;
pub use kernel::{
    BlochJet, BlochKernel, BlochMode, Coordinates, ModeCluster, ModeFlow, Turn, Turned, oscillator_flight,
};
pub use model::chain::{Barrier, Chain, Layout, MAX_SITES};
pub use model::force::{Force, Harmonic, MAX_HARMONIC, MAX_HARMONICS, MAX_PHASE, Wave, WaveTerm};
pub use model::parameter::{DampedParameter, Parameter, Part, Range, Row};
pub use model::params::Model;
pub use model::point::Point;
#[cfg(feature = "serde")]
pub use model::serde_impl::PointPart;
pub use modes::distinct::DistinctMasses;
pub use modes::row::{Ends, RowEnds};
pub use modes::shapes::Shapes;
pub use modes::spectrum::Spectrum;
/// What a structure is given by, so that this crate can be used alone.
#[cfg(feature = "matrices")]
pub use nalgebra::{DMatrix, DVector};
pub use rustfft::num_complex::Complex;
pub use simd::small::{sinc, sine_over};
pub use stop::{Stop, Stopped};
pub use structure::contact::Contact;
pub use structure::contact_modes::ContactMode;
pub use structure::damped_chain::DampedChain;
pub use structure::damped_chain::felt_shapes::FeltShapes;
pub use structure::energy::{Block, EnergyForm};
pub use structure::error::StructureError;
pub use structure::linear_mode::{LinearMode, ModeErrors, ModeShape};
#[cfg(feature = "matrices")]
pub use structure::matrices::Structure;
pub use structure::modal::ModalStructure;
pub use structure::operator::{Bands, Layering, Pulls, SparseOperator};
pub use structure::participating::ParticipatingModes;

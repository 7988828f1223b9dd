//! Linear stability of vibro-impact orbits.
//!
//! ```text
//! Orbit ── stability, Analyser ──> Stability: Verdict, multipliers
//!   ├───── locate, diagram ──────> Located, Diagram: events along one parameter
//!   └───── curve ────────────────> EventCurve: an event over two parameters
//! ```
//!
//! Between impacts perturbations fly freely, at an impact they go through a saltation matrix; one period of both is the
//! monodromy matrix, its eigenvalues are the Floquet multipliers μ. An orbit is stable if none lies outside the unit
//! circle; the leading one says how stability is lost: through +1 (a fold or a pitchfork), through −1 (period doubling)
//! or as a complex pair (Neimark–Sacker). See the paper, sec. III.
//!
//! | name | what it is |
//! |---|---|
//! | [`Saltation`] | a perturbation through an impact |
//! | [`full_monodromy`], [`even_monodromy`] | a perturbation through a period |
//! | [`ImpactSpectrum`] | all multipliers of one orbit of any word, as the zeros of one determinant |
//! | [`Secular`] | the same determinant where one site takes all impacts, or two mirror each other, for maps |
//! | [`DressedModes`], [`Collision`], [`Stripe`] | which modes collide, and how wide stripes are |
//! | [`stability`], [`Analyser`] | multipliers and verdict, by the path that fits an orbit |
//! | [`Multipliers`] | all multipliers in order, made as they are asked for |
//! | [`odd_multipliers`], [`leading_modes`] | multipliers that feel no impact; perturbations that grow most |
//! | [`locate()`] | bifurcations and grazing in one parameter |
//! | [`branches`], [`event_curve`] | events of any linear structure with stops, on branches and along curves |
//! | [`Verdict`], [`Mechanism`], [`Tolerance`], [`Method`] | stable or not, how stability is lost, from which excess on, where the answer comes from |
//!
//! With the feature `serde` values are written by the names of `mapgen`'s JSON; those that hold nothing derived are read, too.
//!
//! Multipliers are per period of the orbit (two periods of the force for a doubled one). Dimensionless throughout.
//!
//! # Example
//!
//! ```
//! use vibrochain_breather::{Family, breathers};
//! use vibrochain_floquet::{Tolerance, stability};
//! use vibrochain_lattice::Point;
//!
//! let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
//! let model = ring.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model()?;
//! for orbit in &breathers(&model, Family::DoubleSided)?.orbits {
//!     let verdict = stability(orbit, Tolerance::Excess(0.01))?.verdict;
//!     println!("|μ| = {}, stable within 1 % a period: {}", verdict.spectral_radius, verdict.stable);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod all_multipliers;
mod analyser;
mod bracket;
mod curve;
mod eigenvectors;
mod error;
mod events;
mod locate;
mod map_paths;
mod multipliers;
mod phases;
mod reference;
mod saltation;
#[cfg(feature = "serde")]
mod serde_impl;
mod singular;
mod sizes;
mod spectrum;
mod stripes;
mod structures;
mod symmetry;
mod verdict;
mod zeros;

pub use all_multipliers::Multipliers;
pub use analyser::{Analyser, Stability, stability};
pub use curve::{
    CurveEnd, CurveError, CurvePoint, EventCurve, Special, SpecialPoint, Walk, Window, event_curve, event_curves,
};
pub use eigenvectors::{FloquetMode, leading_modes, leading_modes_until};
pub use error::FloquetError;
pub use locate::{
    Answer, BranchRequest, BranchedOrbit, Branching, Course, Diagram, DiagramPoint, End, Event, EventSide, Evidence,
    FollowedBranch, LocateError, Located, Origin, Search, Station, Unresolved, branch_events, branches, diagram,
    diagram_until, is_physical_about, locate, locate_until,
};
pub use map_paths::{ModeLabels, Reason, Residues, Secular, SecularVerdict, Standing};
pub use multipliers::{odd_multipliers, participating_modes, sort_multipliers};
pub use nalgebra::{Complex, DMatrix};
pub use phases::phases;
pub use reference::eigen::eigenvalues;
pub use reference::monodromy::{MAX_DIMENSION, even_monodromy, full_monodromy};
pub use saltation::{Saltation, saltations};
pub use spectrum::{ImpactSpectrum, ModalShape};
pub use stripes::{
    Collision, DressedModes, InternalMode, NoStripe, Passing, Signature, Stripe, StripeEnd, StripeFinder, StripeLine,
    StripeRow, bare_signature, passings, signature,
};
pub use structures::BlochProblem;
pub use verdict::{Mechanism, Method, Tolerance, Verdict};
pub use zeros::SecularError;

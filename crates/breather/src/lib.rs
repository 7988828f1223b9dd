//! Exact periodic orbits (discrete breathers) of vibro-impact chains, and of any linear structure with stops.
//!
//! ```text
//! Model ── breathers, Finder ──> OrbitList: Completeness, Orbit… ──> Motion, Admissibility, Condition, Branch
//! LoadedStructure ── orbits ──────────┘
//! ```
//!
//! Between impacts the chain is linear, so that a periodic orbit is a superposition of periodic impulse responses.
//! What remains are the conditions at the impacts: position on the barrier, Newton's law. Every family of the paper has
//! a closed form or, with a force and two impacts, one analytic function of one variable whose zeros are all its
//! orbits; under several harmonics two functions of two variables. An orbit is *physical* if every impact meets its
//! barrier from inside and every mass stays strictly inside the gap at all other times.
//!
//! | name | what it is |
//! |---|---|
//! | [`Orbit`], [`Impact`], [`Family`] | a periodic orbit of a lattice or of any other structure, by its impacts |
//! | [`LatticeOrbit`], [`ContactOrbit`] | with what only a lattice's has; as contacts know it, with the errors of its impacts |
//! | [`breathers`], [`Finder`], [`OrbitList`] | from parameters to orbits |
//! | [`MapBreather`] | what a map asks of a conservative breather, without its orbit |
//! | [`Completeness`], [`Proof`] | whether a list of orbits is all, and how that is known |
//! | [`Motion`] | every mass at any time |
//! | [`Admissibility`], [`Obstruction`] | physical or what is in the way |
//! | [`BlochEquations`] | J(z): the linearised equations of the impacts with a Bloch factor, on any linear structure |
//! | [`Condition`] | distances to resonance and grazing, conditioning of the equations; errors |
//! | [`Branch`] | orbits along one parameter, through folds |
//! | [`Word`] | which mass meets which barrier, in which order; [`Word::enumerate`] lists words of a few sites |
//! | [`Finder::find_word`] | all orbits of a word |
//! | [`Limit`] | what becomes of orbits at a resonance |
//! | [`Branch::leaving`] | the orbits that branch off |
//!
//! With the feature `serde` values are written by the names of `mapgen orbit --json`; those that hold nothing derived are read, too.
//! An orbit is read from binary formats alone, to the last bit.
//!
//! Dimensionless throughout, see `vibrochain-lattice`. t = 0 is the impact on the upper barrier of a
//! double-sided orbit, the only or first impact of the others.
//!
//! # Example
//!
//! ```
//! use vibrochain_breather::{Chain, Family, Model, admissibility, breathers};
//!
//! let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4)?;
//! let found = breathers(&model, Family::DoubleSided)?;
//! let orbit = &found.orbits[0];
//! assert!((orbit.impacts()[1].impulse - 2.0 * 0.9739394321743282).abs() < 1e-13);
//! assert!(admissibility(orbit)?.is_physical());
//! # Ok::<(), vibrochain_breather::BreatherError>(())
//! ```

mod admissible;
mod branch_error;
mod equations;
mod error;
mod motion;
mod orbit;
mod roots;
mod search;
mod structures;
mod tracer;
mod word;

pub use admissible::answer::{Admissibility, Approach, Obstruction};
pub use admissible::check::admissibility;
pub use admissible::map_breather::{MapBreather, MapSearch};
pub use branch_error::BranchError;
#[doc(hidden)]
pub use equations::linear;
pub use equations::{BlochEquations, LinearImpact, ShapeErrors, Shift};
pub use error::{BreatherError, NoBreather, Unsearched};
pub use motion::{Kinematics, Motion};
pub use orbit::{Family, Hit, Impact, LatticeOrbit, Orbit, time_between};
pub use roots::bracket;
pub use search::at_resonance::Limit;
pub use search::completeness::{Completeness, Proof};
pub use search::finder::{Finder, Prepared, Scope, breathers, condition};
pub use search::orbit_list::OrbitList;
pub use search::words::ended::{End, Ended};
pub use structures::branch::continuation::{Branch, BranchPoint, Continuation};
pub use structures::branch::departure::Departure;
pub use structures::branch::family::{FreeNumbers, ModelFamily};
pub use structures::condition::Condition;
pub use structures::errors::{ImpactError, Together};
pub use structures::flight::ContactMotion;
pub use structures::map_orbit::MapOrbit;
pub use structures::model::LoadedStructure;
pub use structures::orbit::ContactOrbit;
pub use structures::reversible::ReversibleOrbit;
pub use tracer::line;
pub use tracer::pace::Pace;
pub use tracer::solution_curve::{SolutionCurve, SolutionPoint};
#[doc(hidden)]
pub use tracer::system;
pub use tracer::walk;
/// What orbits are asked of, so that this crate can be used alone.
pub use vibrochain_lattice::{Chain, Model};
pub use word::{Letter, MAX_IMPACTS, Word, WordError};

/// The larger of two errors. `f64::max` would drop one that is not a number; here it makes the bound infinite.
pub(crate) fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::INFINITY } else { a.max(b) }
}

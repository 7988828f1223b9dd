//! Exact periodic orbits (discrete breathers) of vibro-impact chains.
//!
//! Between impacts the chain is linear, so that a periodic orbit is a superposition of periodic impulse responses.
//! What remains are the conditions at the impacts: position on the barrier, Newton's law. Every family of the paper has
//! a closed form or, with a force and two impacts, one analytic function of one variable whose zeros are all its
//! orbits; under several harmonics two functions of two variables. An orbit is *physical* if every impact meets its
//! barrier from inside and every mass stays strictly inside the gap at all other times.
//!
//! | name | what it is |
//! |---|---|
//! | [`Orbit`], [`Impact`], [`Family`] | a periodic orbit, by its impacts |
//! | [`breathers`], [`Finder`], [`Found`] | from parameters to orbits |
//! | [`Sketch`] | what a map asks of a conservative breather, without its orbit |
//! | [`Completeness`], [`Proof`] | whether a list of orbits is all, and how that is known |
//! | [`Motion`] | every mass at any time |
//! | [`Admissibility`], [`Obstruction`] | physical or what is in the way |
//! | [`BlochEquations`] | J(z): the linearised equations of the impacts with a Bloch factor, on any linear structure |
//! | [`Condition`] | distance to resonance, grazing and folds; errors |
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

mod admissibility;
mod alone;
mod assembly;
mod beside;
mod branch;
mod branching;
mod completeness;
mod condition;
mod conservative;
mod corrector;
mod display;
mod easel;
mod enclosure;
mod ended;
mod enumeration;
mod equations;
mod error;
mod finder;
mod flights;
mod followed;
mod forced_double;
mod forced_harmonics;
mod forced_places;
mod forced_single;
mod free_phases;
mod grid;
mod harmonic_impacts;
#[doc(hidden)]
pub mod lanes;
mod linear;
mod motion;
mod one_mass;
mod orbit;
mod overdetermined;
mod patch;
mod pattern;
#[cfg(feature = "serde")]
mod plain;
mod planar_roots;
mod polish;
mod polynomial;
mod positions;
mod radiation;
mod reduction;
mod resonances;
mod rises;
mod roots;
mod side_by_side;
mod sketch;
mod surface;
mod symmetries;
mod two_impacts;
mod two_instants;
mod uncoupled;
mod unknowns;
mod watch;
mod window;
mod word;
mod word_search;
mod worst;

pub use admissibility::{Admissibility, Approach, Obstruction};
pub use beside::Limit;
pub use branch::{Branch, BranchPoint};
pub use branching::Departure;
pub use completeness::{Completeness, Proof};
pub use condition::{Condition, ImpactError, Together};
pub use ended::{End, Ended};
pub use equations::{BlochEquations, LinearImpact};
pub use error::{BranchError, BreatherError, NoBreather, Unsearched};
pub use finder::{Finder, Found, Prepared, Wanted, breathers, condition};
pub use motion::{Kinematics, Motion};
pub use orbit::{Family, Hit, Impact, Orbit};
pub use sketch::{Sketch, Sketched};
pub use surface::{Surface, SurfacePoint};
/// What orbits are asked of, so that this crate can be used alone.
pub use vibrochain_lattice::{Chain, Model};
pub use watch::admissibility;
pub use word::{Letter, MAX_IMPACTS, Word, WordError};

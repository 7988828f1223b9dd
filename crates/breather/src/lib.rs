//! Exact periodic orbits (discrete breathers) of vibro-impact chains.
//!
//! Between impacts the chain is linear, so that a periodic orbit is a superposition of periodic impulse responses.
//! What remains are the conditions at the impacts: position on the barrier, Newton's law. Every family of the paper has
//! a closed form or, with a force and two impacts, one analytic function of one variable whose zeros are all its
//! orbits; under several harmonics two functions of two variables. An orbit is *physical* if every impact meets its
//! barrier from inside and every mass stays strictly inside the gap at all other times.
//!
//! | module | holds |
//! |---|---|
//! | `orbit`, `assembly` | [`Orbit`], [`Impact`], [`Family`]; orbits from their impulses |
//! | `finder` | [`breathers`], [`Finder`], [`Found`]: from parameters to orbits |
//! | `sketch`, `easel` | [`Sketch`]: what a map asks of a conservative breather, without its orbit |
//! | `completeness` | [`Completeness`], [`Proof`]: whether a list of orbits is all, and how that is known |
//! | `conservative`, `asymmetric`, `forced_single`, `forced_double`, `two_impacts` | the families |
//! | `one_mass`, `flights` | a mass without coupling: equations that know of no resonance |
//! | `radiation`, `rises` | bounds that tell where no physical orbit can be |
//! | `forced_harmonics`, `harmonic_impacts` | the forced ones under several harmonics |
//! | `motion` | [`Motion`]: every mass at any time |
//! | `admissibility`, `watch`, `window`, `grid`, `polynomial` | [`Admissibility`], [`Obstruction`]: physical or what is in the way |
//! | `unknowns`, `equations`, `polish` | the equations of any impact word, linearised; Newton steps on them |
//! | `equations::bloch` | [`BlochEquations`]: J(z), the same with a Bloch factor, on any linear structure: multipliers are where it is singular |
//! | `condition` | [`Condition`]: distance to resonance, grazing and folds; errors |
//! | `branch`, `corrector`, `resonances`, `symmetries`, `reduction`, `linear` | [`Branch`]: orbits along one parameter, through folds |
//! | `word` | [`Word`]: which mass meets which barrier, in which order |
//! | `enumeration` | all words of a few sites |
//! | `word_search`, `uncoupled`, `free_phases` | [`Finder::find_word`]: all orbits of a word |
//! | `alone`, `side_by_side`, `followed`, `ended` | masses alone, put side by side, followed as they are coupled |
//! | `beside` | [`Limit`]: what becomes of orbits at a resonance |
//! | `branching` | [`Branch::leaving`]: the orbits that branch off |
//! | `enclosure`, `roots` | all zeros of a function, with proof |
//! | `stop` | a flag that ends long searches |
//! | `patch`, `planar_roots` | all zeros of two functions in the plane, with proof |
//!
//! With the feature `serde` values are written by the names of `mapgen orbit --json`; those that hold nothing derived are read, too.
//!
//! Dimensionless throughout, see `vibrochain-lattice`. t = 0 is the impact on the upper barrier of a
//! double-sided orbit, the only or first impact of the others.
//!
//! # Example
//!
//! ```
//! use vibrochain_breather::{Family, breathers, admissibility};
//! use vibrochain_lattice::{Chain, Model};
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
mod asymmetric;
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
mod patch;
#[cfg(feature = "serde")]
mod plain;
mod planar_roots;
mod polish;
mod polynomial;
mod radiation;
mod reduction;
mod resonances;
mod rises;
mod roots;
mod side_by_side;
mod sketch;
mod stop;
mod surface;
mod symmetries;
mod two_impacts;
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
pub use watch::admissibility;
pub use word::{Letter, MAX_IMPACTS, Word, WordError};

//! What becomes of perturbed breathers: many simulated runs from each, over the cells of a map, and what they end in.
//!
//! Breathers are found as maps find them, and runs are simulated by `vibrochain_eventsim`, which knows nothing of them.
//!
//! | name | what it is |
//! |---|---|
//! | [`Start`] | on an orbit, perturbed |
//! | [`End`] | how a run ends |
//! | [`measure`] | the Lyapunov exponent along a breather |
//! | [`Ensemble`] | what is asked, within limits; seeds |
//! | [`Home`], [`Fate`] | one run |
//! | [`Witness`] | one run that somebody else carries on |
//! | [`fates()`], [`Ensembled`] | all cells of a scene, in parallel, in order |
//! | [`Strobe`], [`Diagram`] | sections, and bifurcation diagrams by simulation |
//! | [`table`] | columns and rows, written and read back |
//! | [`Fates`] | all that is asked of a scene, as chunks and tables have it |
//!
//! ```
//! use vibrochain_lattice::Stop;
//! use vibrochain_breather::{Family, breathers};
//! use vibrochain_fate::{End, Ensemble, Home};
//! use vibrochain_lattice::Point;
//!
//! // A pair of a saddle and a node: the first is left, the second is come back to.
//! let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
//! let model = ring.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model()?;
//! let ensemble = Ensemble { periods: 200, ..Ensemble::default() };
//! let orbits = breathers(&model, Family::DoubleSided)?.orbits;
//! let runs = orbits.iter().map(|orbit| {
//!     let run = Home::of(orbit)?.run(&ensemble, 1, &Stop::default());
//!     Ok(run.map(|fate| fate.left))
//! });
//! let left: Vec<_> = runs.collect::<Result<_, vibrochain_breather::BreatherError>>()?;
//! assert_eq!(left[0], Some(None));
//! assert!(left[1].flatten().is_some_and(|periods| periods < 10.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// Its `ensure!` and `refuse!`.
#[macro_use]
extern crate vibrochain_maps;

mod content;
mod diagram;
mod end;
mod ensemble;
mod exponent;
mod fates;
mod follow;
mod origin;
mod reader;
mod repeat;
mod run;
mod section;
mod start;
mod structures;
pub mod table;
mod witness;

pub use content::Fates;
pub use diagram::{Column, Diagram, MAX_POINTS, SectionPoint, Sectioned};
pub use end::End;
pub use ensemble::{Ensemble, OutOfRange};
pub use exponent::{Measured, Unmeasured, measure};
pub use fates::{BreatherFates, CellFates, Ensembled, From, fates};
pub use reader::Reader;
pub use run::{Fate, Home, LOOKED_AT};
pub use section::Strobe;
pub use start::{ModeShape, Start};
pub use witness::{Outcome, Pattern, Witness};

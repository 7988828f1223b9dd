#![doc = include_str!("../docs/rust.md")]

pub use vibrochain_breather as breather;
pub use vibrochain_eventsim as eventsim;
pub use vibrochain_floquet as floquet;
pub use vibrochain_lattice as lattice;
#[cfg(feature = "maps")]
pub use vibrochain_maps as maps;

// What twenty lines need, by one name each; all else by its layer.
pub use breather::LoadedStructure;
pub use breather::{Admissibility, Family, Impact, Orbit, OrbitList, Word, admissibility, breathers};
pub use eventsim::{Event, EventKind, Limits, Outcome, Simulation, Time};
pub use floquet::{Mechanism, Stability, Tolerance, Verdict, stability};
pub use lattice::{Barrier, Chain, Complex, Contact, DMatrix, DVector, Model, Point, Structure};
#[cfg(feature = "maps")]
pub use maps::cell::{Cell, Class, Worker};
#[cfg(feature = "maps")]
pub use maps::scene::Scene;

//! Facade; see README.
pub use vibrochain_breather as breather;
pub use vibrochain_floquet as floquet;
pub use vibrochain_lattice as lattice;

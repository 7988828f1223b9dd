//! What branches and curves tell of their orbits, be they a chain's or any structure's.

use vibrochain_breather::{Orbit, StructureOrbit};

/// An orbit as points of branches and curves tell it.
pub trait Followed {
    /// Its period.
    fn period(&self) -> f64;
    /// The time of the second impact of two.
    fn phi(&self) -> Option<f64>;
    /// The phase of the force, as a time.
    fn psi(&self) -> Option<f64>;
    /// The impulses, in the order of the impacts.
    fn impulses(&self) -> Vec<f64>;
}

macro_rules! followed {
    ($($orbit:ty),*) => { $(
        impl Followed for $orbit {
            fn period(&self) -> f64 {
                self.period()
            }

            fn phi(&self) -> Option<f64> {
                self.phi()
            }

            fn psi(&self) -> Option<f64> {
                self.psi()
            }

            fn impulses(&self) -> Vec<f64> {
                self.impulses()
            }
        }
    )* };
}

followed!(Orbit, StructureOrbit);

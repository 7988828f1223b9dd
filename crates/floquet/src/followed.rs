//! What branches and curves tell of their orbits, be they a chain's or any structure's.

use vibrochain_breather::{Hit, Orbit, StructureOrbit};

/// An orbit as points of branches and curves tell it.
pub trait Followed: Clone {
    /// Its period.
    fn period(&self) -> f64;
    /// Periods of the force in one of its own.
    fn force_periods(&self) -> u32;
    /// The time of the second impact of two.
    fn phi(&self) -> Option<f64>;
    /// The phase of the force, as a time.
    fn psi(&self) -> Option<f64>;
    /// The impulses, in the order of the impacts.
    fn impulses(&self) -> Vec<f64>;
    /// The impacts, in order of time; contacts of a structure stand in place of sites.
    fn hits(&self) -> Vec<Hit>;
    /// Whether it has neither a force nor losses.
    fn is_conservative(&self) -> bool;
    /// Whether barriers on either side are as far from 0, so that an orbit may have a mirror image that hits the others.
    fn is_centred(&self) -> bool;
}

macro_rules! followed {
    ($orbit:ty, $hits:expr, $conservative:expr, $centred:expr) => {
        impl Followed for $orbit {
            fn period(&self) -> f64 {
                self.period()
            }

            fn force_periods(&self) -> u32 {
                self.force_periods()
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

            fn hits(&self) -> Vec<Hit> {
                $hits(self)
            }

            fn is_conservative(&self) -> bool {
                $conservative(self)
            }

            fn is_centred(&self) -> bool {
                $centred(self)
            }
        }
    };
}

followed!(
    Orbit,
    |orbit: &Self| orbit.impacts().iter().map(Hit::from).collect(),
    |orbit: &Self| orbit.model().is_conservative(),
    |orbit: &Self| orbit.model().asymmetry() == 0.0
);
followed!(StructureOrbit, StructureOrbit::hits, StructureOrbit::is_conservative, StructureOrbit::is_centred);

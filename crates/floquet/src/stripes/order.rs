//! In which order Krein's signatures stand along the unit circle. From one orbit to the next the order changes only where multipliers of
//! opposite signatures have met, or one pair has met itself at ±1: between two stable orbits of different order there is a stripe, however
//! thin. Multipliers off the circle have their place in the order, too, so that a thin stable band between two stripes shows as well; their
//! place also changes where they drift past a pair on the circle, which is no event.

use std::hash::{DefaultHasher, Hash, Hasher};

use vibrochain_breather::{Finder, Orbit};

use crate::error::FloquetError;
use crate::events::{Order, Watcher};
use crate::locate::LocateError;
use crate::verdict::Tolerance;

/// The order of the signatures of all multipliers along the upper half of the unit circle: a number that is the same for equal orders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SignatureOrder(u64);

/// Finds orders; keeps what the next orbit of the same lattice needs again.
#[derive(Debug, Default)]
pub struct OrderFinder {
    watcher: Watcher,
    finder: Finder,
}

impl OrderFinder {
    /// The most masses: on larger lattices one order takes more time than computing the cells that it saves.
    pub const MOST_MASSES: usize = 200;

    /// The order of an orbit without losses; `None` where nothing couples the masses, and their multipliers are equal, and where a signature cannot
    /// be told.
    ///
    /// # Errors
    /// [`FloquetError::TooLarge`] beyond [`Self::MOST_MASSES`], [`FloquetError::Grazing`], [`FloquetError::NotConverged`].
    ///
    /// ```
    /// use vibrochain_breather::{Finder, OrbitList, Scope};
    /// use vibrochain_floquet::OrderFinder;
    /// use vibrochain_lattice::{Chain, Model};
    /// let (mut finder, mut found, mut orders) = (Finder::new(6), OrbitList::default(), OrderFinder::default());
    /// let mut order = |omega: f64| -> Result<_, Box<dyn std::error::Error>> {
    ///     let model = Model::conservative(Chain::new(6, 0.2, 0.1)?, omega, 0.2)?;
    ///     finder.find_word(&model, &"0+1+,0-1-".parse()?, Scope::All, &mut found)?;
    ///     Ok(orders.of(&found.orbits[0])?)
    /// };
    /// // The breather is unstable between 1.36977 and 1.37226.
    /// assert_eq!(order(1.36)?, order(1.365)?);
    /// assert_ne!(order(1.365)?, order(1.38)?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of(&mut self, orbit: &Orbit) -> Result<Option<SignatureOrder>, FloquetError> {
        if let Some(chain) = orbit.model().map(|model| model.chain()) {
            if chain.sites() > Self::MOST_MASSES {
                return Err(FloquetError::TooLarge { dimension: chain.sites(), limit: Self::MOST_MASSES });
            }
            if chain.is_uncoupled() {
                return Ok(None);
            }
        }
        let known = self.finder.at_contacts(orbit)?;
        let half_sums = match self.watcher.spectrum(&known, Tolerance::Rounding) {
            Ok((half_sums, _)) => half_sums,
            Err(LocateError::Floquet(error)) => return Err(error),
            Err(_) => return Ok(None),
        };
        let order = Order::of_orbit(&known, &half_sums).filter(Order::is_told);
        Ok(order.map(|order| {
            let mut hasher = DefaultHasher::new();
            order.hash(&mut hasher);
            SignatureOrder(hasher.finish())
        }))
    }
}

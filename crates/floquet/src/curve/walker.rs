//! Who walks along a curve, and what is known of a point there.

use smallvec::SmallVec;
use vibrochain_breather::{Surface, SurfacePoint};

use super::answer::{Special, Window};
use super::signal::{Sight, Signal};
use crate::locate::Event;

/// A function that changes sign where something else happens, and which of its kind it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Monitor {
    pub(super) special: Special,
    pub(super) which: usize,
    pub(super) value: f64,
}

/// What is seen at a foot besides the event.
#[derive(Debug, Clone, Default)]
pub(super) struct Aspects {
    pub(super) monitors: SmallVec<[Monitor; 8]>,
    /// Whether the orbit is physical, touches aside.
    pub(super) physical: Option<bool>,
    /// The pair is real: the curve is that of no event any more.
    pub(super) ends: bool,
}

impl Aspects {
    pub(super) fn add(&mut self, special: Special, which: usize, value: f64) {
        if value.is_finite() {
            self.monitors.push(Monitor { special, which, value });
        }
    }

    pub(super) fn get(&self, of: &Monitor) -> Option<f64> {
        self.monitors.iter().find(|one| (one.special, one.which) == (of.special, of.which)).map(|one| one.value)
    }
}

/// A point on the curve.
#[derive(Debug, Clone)]
pub(super) struct Foot {
    pub(super) point: SurfacePoint,
    /// Length of the chords up to it.
    pub(super) at: f64,
    /// The signal's mark.
    pub(super) mark: f64,
    /// Of the signal across the curve, per unit of length.
    pub(super) slope: f64,
    /// What else is seen there.
    pub(super) aspects: Aspects,
}

/// Who walks.
pub(super) struct Walker {
    pub(super) surface: Surface,
    pub(super) sight: Sight,
    pub(super) signal: Signal,
    /// The impacts that have no velocity all along the curve.
    pub(super) grazing: SmallVec<[usize; 2]>,
    pub(super) event: Event,
    pub(super) window: Window,
    pub(super) tolerance: f64,
    /// Whether what else happens on the way is looked for.
    pub(super) special: bool,
}

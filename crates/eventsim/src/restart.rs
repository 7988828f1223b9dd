//! Restarts at an event: of the whole ring, or of the masses that can feel it.
//!
//! What happens to a mass reaches its m-th neighbour with γ₂^m τ^{2m+1}/(2m+1)!: within the rest of a window only the
//! nearest R neighbours on either side can notice ([`Units::reach`](crate::units::Units::reach)), and only they get new
//! series, from the same stencil; at the ends of the part the neighbours' series are known, and stay. An event then
//! costs what R costs, whatever the size of the ring.
//!
//! Parts that touch are restarted as one, so that simultaneous events keep the mirror symmetry of the ring to the bit.

use crate::bound;
use crate::collision::Change;
use crate::engine::Engine;
use crate::series::{Extent, LANES, Rows, Weights};
use crate::units::MAX_ORDER;

impl Engine {
    /// Restarts the flight at `s` since the base with the contacts in `due`. True if the base has moved to `s`.
    pub(crate) fn restart(&mut self, s: f64, changes: &mut Vec<Change>) -> bool {
        self.note_event(s);
        self.rebase(s);
        self.collide(0.0, changes);
        self.begin_window();
        true
    }

    /// Takes note of an event at `s` since the base: a mean over some sixteen events; the rate is its inverse.
    fn note_event(&mut self, s: f64) {
        let flight = self.since_event + s;
        self.since_event = -s;
        let mean = if self.event_rate > 0.0 { 1.0 / self.event_rate } else { flight };
        let mean = mean + (flight - mean) / 16.0;
        self.event_rate = if mean > 0.0 { 1.0 / mean } else { 0.0 };
    }
}

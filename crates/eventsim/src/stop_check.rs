//! Looks at a request to stop, often enough and at next to no cost.

use vibrochain_lattice::Stop;

/// Terms of flights between two looks: well below a millisecond of work, and some hundred times the cost of a look.
const BETWEEN_LOOKS: usize = 2_000;

/// A request to stop, and how many steps of a run are left before the next look at it.
#[derive(Debug, Clone)]
pub(crate) struct StopCheck {
    stop: Stop,
    stride: usize,
    left: usize,
}

impl StopCheck {
    /// For steps over so many terms each.
    pub(crate) fn new(stop: Stop, terms: usize) -> Self {
        Self { stop, stride: BETWEEN_LOOKS / terms.max(1), left: 0 }
    }

    /// Whether the run is to end, after one more step.
    pub(crate) fn is_raised(&mut self) -> bool {
        if self.left > 0 {
            self.left -= 1;
            return false;
        }
        self.left = self.stride;
        self.stop.is_raised()
    }
}

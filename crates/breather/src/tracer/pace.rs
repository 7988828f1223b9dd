//! How long steps are, of all that is traced.

/// The shortest step: where even this one fails, the curve is lost.
const SHORTEST: f64 = 1e-9;

/// A step that was made lets the next be longer by the first factor at most, one that failed is tried again shorter by the second.
const GROW: f64 = 1.5;
const SHRINK: f64 = 0.4;

/// The length of the next step, in units of what is traced.
#[derive(Debug, Clone, Copy)]
pub struct Pace {
    length: f64,
}

impl Pace {
    /// The longest step, where the range of a parameter is one unit, and so is a change of order 1 of the orbit.
    pub const LONGEST: f64 = 0.02;

    /// Steps that begin with this one.
    pub fn new(first: f64) -> Self {
        Self { length: first }
    }

    /// The next step.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The step has failed: whether a shorter one may succeed.
    pub fn shorten(&mut self) -> bool {
        self.length *= SHRINK;
        self.length >= SHORTEST
    }

    /// The step has been made: the next may be longer by as much as is `wanted`, but no longer than `longest`.
    pub fn lengthen(&mut self, wanted: f64, longest: f64) {
        self.length = (self.length * wanted.clamp(SHRINK, GROW)).min(longest);
    }
}

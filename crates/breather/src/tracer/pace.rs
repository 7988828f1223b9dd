//! How long steps are, of all that is traced. The unit is the range of a parameter, or the side of a window, and a change of order 1 of the
//! orbit; of a word's branch in the coupling it is the coupling asked for.
//!
//! | followed | longest step | measured with others |
//! |---|---|---|
//! | branches | 0.02 | 0.1 assembles 6 to 63 % fewer orbits and loses no event, but leaves a quarter to a half of the points that a diagram is drawn through |
//! | curves | 0.02 | 0.03 assembles up to a fifth fewer orbits, and misses the 1:1 point of the fold curve in docs/gallery.md, which 0.01 confirms |
//! | borders of classes | 0.02 | not measured: borders of two kinds may lie side by side, and a long chord could jump from one to the other |
//! | edges of stripes | 0.02 | 0.05 finds the same 333 borders in the same time (`mapgen curves` of scenes/conservative-n20.toml, 50 × 25) |
//! | a word in the coupling | 0.1 | 0.02 finds the same orbits in four times as many instructions (`mapgen words`, 12 masses); only the end of the way is asked for |

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
    /// The longest step.
    pub const LONGEST: f64 = 0.02;

    /// The same where only the end of the way is asked for.
    pub const LONGEST_TO_AN_END: f64 = 0.1;

    /// Steps as short as this lead nowhere but to a place where the curve ends.
    pub const CRAWL: f64 = 1e-6;

    /// So many of them in a row are enough to say so.
    pub const MOST_CRAWLING: usize = 64;

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

//! Where the first letter of a text stands.

use crate::backend::drawing::{Across, Place, Upright, Words};

/// Heights in em above the line on which letters stand: of the middle of numerals and small letters, and of the upper end of a line.
const MIDDLE: f64 = 0.35;
const TOP: f64 = 0.82;

/// Where the first letter stands of words so many em wide.
pub(crate) fn corner(words: &Words, width: f64) -> Place {
    let back = match words.anchor.0 {
        Across::Left => 0.0,
        Across::Centre => 0.5 * width,
        Across::Right => width,
    } * words.size;
    let down = match words.anchor.1 {
        Upright::Top => TOP,
        Upright::Middle => MIDDLE,
        Upright::Base => 0.0,
    } * words.size;
    let [x, y] = words.at;
    if words.upwards { [x + down, y + back] } else { [x - back, y + down] }
}

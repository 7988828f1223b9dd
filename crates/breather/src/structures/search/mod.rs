//! All orbits of a word: of up to three impacts with proof; of more, those that starts lead to.
//!
//! | module | holds |
//! |---|---|
//! | `orbits` | [`LoadedStructure::orbits`](crate::LoadedStructure::orbits): which search a word takes, and the list that comes of it |
//! | `at_times` | impulses, offsets and phase at given times |
//! | `distinct` | which orbits of a list are one, and which are orbits of its word |
//! | `half_period` | the same of one contact between two barriers, without loads and losses |
//! | `one_contact` | the same of one contact that no dashpot damps |
//! | `two_impacts` | the proof that no two impacts are missing |
//! | `merged` | the number of orbits where two zeros may have merged |
//! | `open_pieces` | what modes next to a resonance put into the tables of `phase_plane` |
//! | `phase_plane` | the same of one and of two under loads of several harmonics, and where nothing holds a structure |
//! | `three_impacts` | the same of three |
//! | `elimination` | the null vector that zeros in a plane have |
//! | `self_excited` | orbits whose period is their own |
//! | `scan`, `starts` | where there is no proof |

mod at_times;
mod distinct;
mod elimination;
pub(super) mod half_period;
mod merged;
mod one_contact;
mod open_pieces;
mod orbits;
mod phase_plane;
mod scan;
mod self_excited;
mod starts;
mod three_impacts;
mod two_impacts;

pub(crate) use orbits::{Listed, Request};

//! Stripes of instability in conservative maps: which two modes of the ring collide, and on which harmonic.
//!
//! | module | holds |
//! |---|---|
//! | `signature` | [`signature()`]: on which multiplier of a pair the energy is positive |
//! | `form` | the secular function at one frequency, waves in the band running off |
//! | `internal` | [`InternalMode`]: the mode that the breather has drawn out of the band |
//! | `dressed` | [`DressedModes`]: the frequencies of the modes with the breather on the ring |
//! | `collision` | [`Collision`]: the pair behind an unstable multiplier |
//! | `passing` | [`passings`]: which pairs meet from one point to the next |
//! | `reversal`, `pencil` | two modes that meet, as two oscillators that the impacts couple |
//! | `stripe`, `finder` | [`Stripe`]: where a stripe begins and ends on a line, and how strong it is |
//! | `place` | what is off the circle at a point of a line |
//! | `row` | [`StripeRow`]: all stripes on a line |
//!
//! A mode that swings freely over a period turns by e^{iΩT} and, its mirror image, by e^{−iΩT}. Krein's form
//!
//! ```text
//! ½ i (ẋ̄·x − x̄·ẋ) ,    which the flow and elastic impacts keep,
//! ```
//!
//! is positive on the first and negative on the second. A multiplier leaves the unit circle only by meeting one of the
//! other sign: e^{iΩ_kT} = e^{−iΩ_lT}, Ω_k + Ω_l = jω. Where Ω_k − Ω_l = jω, multipliers of equal sign meet, and pass.
//! k = l is a mode against itself, at −1 for odd j (period doubling); for even j it is a resonance of the orbit itself.
//!
//! Of the m modes even about the site that is hit m−1 are left to collide, the breather takes the place of one: each of
//! them swings between two neighbouring frequencies of the bare ring, Ω_k < Ω̃_k < Ω_{k+1}, and the stripes are where
//! Ω̃_k + Ω̃_l = jω. One of them may have left the band: it is then the internal mode, number m−1. On long
//! rings that is hardly apart from Ω_k + Ω_l = jω; on short ones it is the whole picture.

mod collision;
mod dressed;
mod finder;
mod form;
mod internal;
mod passing;
mod pencil;
mod place;
mod reversal;
mod row;
pub(crate) mod signature;
mod stripe;

pub use collision::Collision;
pub use dressed::DressedModes;
pub use finder::StripeFinder;
pub use internal::InternalMode;
pub use passing::{Passing, passings};
pub use row::StripeRow;
pub use signature::{Signature, bare_signature, signature};
pub use stripe::{NoStripe, Stripe, StripeEnd, StripeLine};

//! Where a forced double-sided breather could be physical, from samples of the kernel alone.
//!
//! With impulses P = −2(m + d) and 2(m − d), a gap of 2, θ the phase of the force at the middle of the two impacts, X + iY = Ã e^{iθ}, h = ωφ/2,
//! D = 2(K₀(φ) − K₀(0)) and χ₃ = 2K₀′(φ), an orbit both of whose impulses point into the gap has m > 0 and |d| ≤ m. Its conditions
//! D m = 1 − Y sin h, χ₃m + qd = −ωY cos h and χ₃d − qm = −ωX sin h, with X² + Y² = Ã² and |Ã| < 1, then ask for
//!
//! ```text
//! D > 0,      m ≥ (1 − |Ã|)/D,
//! |χ₃| − q ≤ ω|Ã cos h| D/(1 − |Ã|)          (the second)
//! χ₃² + q² ≤ ω²Ã² D²/(1 − |Ã|)²              (the squares of the last two, added)
//! ```
//!
//! D and χ₃ = −2s are those of the grid in `kernel_grid`, as cubics with bounds. That leaves little more than the places where the mass that
//! is hit could bounce without force, in which alone zeros of F are searched for.

use smallvec::SmallVec;
use vibrochain_lattice::ImpulseResponse;

use crate::orbit::WRONG_SIGN;
use crate::search::screens::kernel_grid::{KernelGrid, Piece, Samples};

/// Places are not narrowed below this part of an interval of the grid: the search halves on.
const FINEST: f64 = 1.0 / 8.0;

/// Room for the rounding of the bounds, and for orbits that polishing could turn round, whose |d| exceeds m.
const ROOM: f64 = 1.0 + 4.0 * WRONG_SIGN;

/// What decides whether a right-signed orbit can be on an interval.
struct Bounds {
    error: f64,
    rise_error: f64,
    omega: f64,
    loss: f64,
    /// ω|Ã|/(1 − |Ã|)
    drive: f64,
}

impl Bounds {
    /// Whether a right-signed orbit can be on a piece of δ > 0.
    fn allows(&self, piece: &Piece) -> bool {
        let most = piece.rise.into_iter().fold(f64::NEG_INFINITY, f64::max) + self.rise_error;
        if most <= 0.0 {
            return false;
        }
        let reach = 2.0 * most * self.drive * ROOM;
        let same_sign = piece.s.iter().all(|b| (*b > 0.0) == (piece.s[0] > 0.0));
        let least = if same_sign { piece.s.iter().map(|b| b.abs()).fold(f64::INFINITY, f64::min) } else { 0.0 };
        let slope = (2.0 * (least - self.error)).max(0.0);
        // |cos h| = |sin ωδ/2|
        let cosine = (0.5 * self.omega * piece.to).min(1.0);
        slope - self.loss * ROOM <= cosine * reach && slope.hypot(self.loss) <= reach
    }

    fn narrow(&self, piece: &Piece, finest: f64, places: &mut Vec<(f64, f64)>) {
        if !self.allows(piece) {
            return;
        }
        if piece.to - piece.from > finest {
            piece.split(0.5).iter().for_each(|half| self.narrow(half, finest, places));
            return;
        }
        match places.last_mut() {
            Some(last) if last.1 == piece.from => last.1 = piece.to,
            _ => places.push((piece.from, piece.to)),
        }
    }
}

/// The intervals of φ, rising, outside of which no right-signed double-sided orbit under a cosine of response `force` can be, and the number of
/// intervals of the grid they come from. `None` where that cannot be told, or is not worth it: the force alone may carry the masses to their
/// barriers.
pub(crate) fn places(
    grid: &mut KernelGrid,
    response: &ImpulseResponse,
    (force, loss): (f64, f64),
) -> Option<(SmallVec<[[f64; 2]; 8]>, usize)> {
    let force = force.abs();
    if force >= 1.0 {
        return None;
    }
    let mut places = grid.take_places();
    let samples: Samples<'_> = grid.samples(response)?;
    let omega = response.omega();
    let drive = omega * force / (1.0 - force);
    let bounds = Bounds { error: samples.error, rise_error: samples.rise_error, omega, loss, drive };
    let intervals = samples.intervals();
    for i in 0..intervals {
        let piece = samples.piece(i);
        bounds.narrow(&piece, FINEST * (piece.to - piece.from), &mut places);
    }
    let flights = both_ways(grid.put_places(places), 0.5 * response.period());
    Some((flights, intervals))
}

/// Intervals of δ ≥ 0 and their mirror images, as intervals of φ = T/2 + δ.
fn both_ways(places: &[(f64, f64)], half: f64) -> SmallVec<[[f64; 2]; 8]> {
    let is_middle = |place: &&(f64, f64)| place.0 == 0.0;
    let before = places.iter().rev().filter(|place| !is_middle(place)).map(|(from, to)| [half - to, half - from]);
    let middle = places.iter().find(is_middle).map(|(_, to)| [half - to, half + to]);
    let after = places.iter().filter(|place| !is_middle(place)).map(|(from, to)| [half + from, half + to]);
    before.chain(middle).chain(after).collect()
}

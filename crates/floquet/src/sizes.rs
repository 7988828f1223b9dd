//! The sizes at which one way to a verdict gives place to another, with what was measured.
//!
//! | | below | above |
//! |---|---|---|
//! | [`LARGE`] modes | sums over pairs of modes; eigenvalues of a matrix for a verdict on a small word that is its own mirror image in time | sums in O(M); zeros of the determinant |
//! | [`MOST_DENSE`] rows | a matrix answers words of many impacts; residues of few digits give place to all zeros of the determinant | there is no answer; it has the digits it has |
//!
//! Two more bound what an answer may cost: [`MOST_WORK`] for all zeros of a determinant, [`most_refined`] for single ones of a large ring.

use vibrochain_breather::LatticeOrbit;

/// Modes up to which what is dear for many is cheap. Sums over pairs take as long as Cauchy sums at 256 modes of an orbit that is its own
/// mirror image in time (`cargo bench --bench spectrum`).
pub(crate) const LARGE: usize = 256;

/// Rows of a matrix that take seconds: 1.2 s for a pair on 1251 masses, 5.6 s on 2000.
pub(crate) const MOST_DENSE: usize = 2000;

/// Entries of J(z) times pairs of modes that all zeros of a determinant may cost: some three seconds.
const MOST_WORK: f64 = 1e8;

/// Whether all zeros of an orbit's determinant are worked out.
pub(crate) fn is_affordable(orbit: LatticeOrbit<'_>) -> bool {
    let chain = orbit.model().chain();
    let modes = if orbit.centre().is_some() { chain.even_modes() } else { chain.sites() };
    modes <= most_modes(orbit.impacts().len())
}

/// Modes up to which all zeros of the determinant of so many impacts are worked out.
pub(crate) fn most_modes(impacts: usize) -> usize {
    (MOST_WORK.sqrt() / (2 * impacts) as f64) as usize
}

/// Multipliers of so many modes that are refined one by one before the rest is left with the errors it has: each takes a few passes over
/// the modes, and ten times as many would be ten seconds for 10⁶ masses.
pub(crate) fn most_refined(modes: usize) -> usize {
    LARGE.min(2_000_000 / modes.max(1))
}

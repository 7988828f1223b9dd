//! Which of the breathers of a word run ahead, and which fall behind, in a perturbation.
//!
//! Without coupling each mass that is hit may be anywhere on its own orbit: r phases, of which a change of all alike is a shift in time. Coupling
//! gives the others a frequency, or a growth. A perturbation that does no more than shift mass n by a time τ_n is τ_n(v̇_n, v̈_n); of any, τ_n is
//! read off by projection on that.

use vibrochain_breather::{BreatherError, Finder, Orbit};

use crate::eigenvectors::FloquetMode;

/// The time by which each mass that is hit, by rising site, runs ahead in the real part of a perturbation, just before the first impact; the
/// largest is 1. Of a perturbation that is no shift in time the numbers mean nothing.
///
/// # Errors
/// [`BreatherError`] of an orbit next to a resonance; the search for it has passed the same check.
///
/// ```
/// use vibrochain_breather::{Finder, OrbitList, Scope};
/// use vibrochain_floquet::{leading_modes, phases};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.05)?, 1.5, 0.2)?;
/// let (mut finder, mut found) = (Finder::new(21), OrbitList::default());
/// finder.find_word(&model, &"0+1-,0-1+".parse()?, Scope::All, &mut found)?;
/// let orbit = &found.orbits[0];
/// // Two breathers out of phase drift apart.
/// let apart = phases(orbit, &leading_modes(orbit, 1)?[0], &mut finder)?;
/// assert_eq!((apart[0].0, apart[1].0), (0, 1));
/// assert!(apart[0].1 * apart[1].1 < -0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn phases(orbit: &Orbit, mode: &FloquetMode, finder: &mut Finder) -> Result<Vec<(usize, f64)>, BreatherError> {
    let omega = orbit.frequency();
    let motion = finder.motion(orbit)?;
    // The end of the last flight is just before the first impact.
    let last = motion.intervals().saturating_sub(1);
    let (_, length) = motion.interval(last);
    motion.seek(last, length);
    let shift = |site: usize| {
        let flow = motion.site(site);
        let (along, across) = (flow.velocity * omega, flow.acceleration);
        let (u, v) = (mode.displacement.get(site), mode.velocity.get(site));
        let (u, v) = (u.map_or(0.0, |z| z.re) * omega, v.map_or(0.0, |z| z.re));
        (u * along + v * across) / (along * along + across * across)
    };
    let mut shifts: Vec<(usize, f64)> = orbit.hit_sites().into_iter().map(|site| (site, shift(site))).collect();
    let largest = shifts.iter().map(|shift| shift.1).max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(1.0);
    shifts.iter_mut().for_each(|shift| shift.1 /= largest);
    Ok(shifts)
}

//! As `reversible`, for words of several sites, mass by mass instead of mode by mode.
//!
//! Impacts are at 0 (the masses I₀) and half a period later (I₁); a word of one instant has its impacts in the middle of the period and
//! none at its ends. With c, s, −s̃ the entries of the flight over half a period, u ← u, u ← v, v ← u, and those with T over a whole one, the
//! flight–impacts–flight is W = (A B; C Aᵀ),
//!
//! ```text
//! A_nm = c^T − 2 Σ_i c_ni c_im + Σ_i s_ni (2 s̃_im + κ_i c_im)
//! B_nm = s^T − 2 Σ_i (c_ni s_im + s_ni c_im) + Σ_i κ_i s_ni s_im                      i in I₁
//! C_nm = −s̃^T + 2 Σ_i (s̃_ni c_im + c_ni s̃_im) + Σ_i κ_i c_ni c_im
//! ```
//!
//! M = W S₀ and Q = diag(1, −1) S₀, whose space Qx = x has displacements x of the masses that are not in I₀ and velocities β of
//! those that are. There ½(M + M⁻¹) is
//!
//! ```text
//! x ← x   A_nm                          x ← β   −B_ni
//! β ← x   C_im − ½κ_i A_im              β ← β   −A_ji + ½κ_i B_ij
//! ```
//!
//! and the orbit's own flow gives the left eigenvector of ν = 1, v⁻ for each β and −v̈ for each x.

use vibrochain_breather::{Finder, Orbit};
use vibrochain_lattice::{Propagator, Spectrum};

use crate::error::FloquetError;
use crate::reference::square::{Reflector, Square};
use crate::saltation::{Saltation, saltations};

/// Work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct ReversibleWord {
    pub(crate) block: Square,
    reflector: Reflector,
    left: Vec<f64>,
    flights: Vec<[f64; 3]>,
    /// Of the last orbit's chain: that of the next one in most sweeps.
    spectrum: Option<Spectrum>,
}

impl ReversibleWord {
    /// Builds the block of dimension M − 1 whose eigenvalues are the ν of all pairs but the trivial one.
    pub(crate) fn build(&mut self, orbit: &Orbit, finder: &mut Finder) -> Result<(), FloquetError> {
        let chain = orbit.model().chain();
        let (sites, period, omega) = (chain.sites(), orbit.period(), orbit.frequency());
        let hits: Vec<Saltation> = saltations(orbit)?.collect();
        let one_instant = hits.iter().all(|hit| hit.time == 0.0);
        let at_ends = |hit: &&Saltation| hit.time == 0.0 && !one_instant;
        let middle: Vec<&Saltation> = hits.iter().filter(|hit| !at_ends(hit)).collect();
        // κ of the masses in I₀.
        let mut ends = vec![None; sites];
        hits.iter().filter(at_ends).for_each(|hit| ends[hit.site] = Some(hit.kappa));

        let motion = finder.motion(orbit)?;
        motion.at(0, if one_instant { 0.5 * period } else { 0.0 });
        self.left.clear();
        self.left.extend((0..sites).map(|n| -motion.site(n).acceleration));
        if !one_instant {
            let first = orbit.impacts().iter().filter(|impact| impact.time == 0.0);
            first.for_each(|impact| self.left[impact.site] = impact.velocity_before * omega);
        }

        let spectrum = match self.spectrum.take() {
            Some(spectrum) if spectrum.chain() == chain => spectrum,
            _ => Spectrum::new(*chain),
        };
        let (half, whole) = (Propagator::new(&spectrum, 0.5 * period), Propagator::new(&spectrum, period));
        self.spectrum = Some(spectrum);
        // Of each impact in the middle κ, and the flight there from every mass, which is that back from it.
        self.flights.clear();
        for hit in &middle {
            self.flights.extend((0..sites).map(|n| {
                let [[c, s], [minus_s, _]] = half.block(n, hit.site);
                [c, s, -minus_s]
            }));
        }
        let impacts = || middle.iter().map(|hit| hit.kappa).zip(self.flights.chunks_exact(sites));
        let a = |n: usize, m: usize| {
            impacts().fold(whole.block(n, m)[0][0], |a, (kappa, flight)| {
                let ([c_n, s_n, _], [c_m, _, t_m]) = (flight[n], flight[m]);
                a + (s_n * (2.0 * t_m + kappa * c_m) - 2.0 * c_n * c_m)
            })
        };
        let b = |n: usize, m: usize| {
            impacts().fold(whole.block(n, m)[0][1], |b, (kappa, flight)| {
                let ([c_n, s_n, _], [c_m, s_m, _]) = (flight[n], flight[m]);
                b + (kappa * s_n * s_m - 2.0 * (c_n * s_m + s_n * c_m))
            })
        };
        let c = |n: usize, m: usize| {
            impacts().fold(whole.block(n, m)[1][0], |c, (kappa, flight)| {
                let ([c_n, _, t_n], [c_m, _, t_m]) = (flight[n], flight[m]);
                c + (kappa * c_n * c_m + 2.0 * (t_n * c_m + c_n * t_m))
            })
        };
        self.block.reset(sites);
        for n in 0..sites {
            for m in 0..sites {
                self.block.row_mut(n)[m] = match (ends[n], ends[m]) {
                    (None, None) => a(n, m),
                    // β in units of velocities over ω.
                    (None, Some(_)) => -b(n, m) * omega,
                    (Some(kappa), None) => (c(n, m) - 0.5 * kappa * a(n, m)) / omega,
                    (Some(kappa), Some(_)) => 0.5 * kappa * b(n, m) - a(m, n),
                };
            }
        }
        self.reflector.set(self.left.iter().copied());
        self.block.reflect(&self.reflector);
        self.block.drop_first();
        Ok(())
    }
}

//! The motion that a uniform force drives without impacts: that of one mass on its spring, everywhere alike, or less near walls.
//!
//! Between walls each term of the force, cos wt, makes site n swing by
//!
//! ```text
//! g_n(w) = (1 − λ^(n+1))(1 − λ^(M−n)) / ((1 + λ^(M+1))(γ₁ − w²))                              w outside the band, see `decay`
//! g_n(w) = sin ½κ(n+1) sin ½κ(M−n) / (2γ₂ sin² ½κ cos ½κ(M+1))                                inside
//! ```
//!
//! products, in which nothing cancels: not even at w² = γ₁, where without walls there would be a resonance. With walls those are at
//! the modes that are even about the middle, every other one.

use crate::error::{RESONANCE_TOLERANCE, Resonance};
use crate::kernel::damped_steady;
use crate::kernel::decay::{Decay, decay, power};
use crate::model::chain::Chain;
use crate::model::force::{Wave, WaveTerm};
use crate::model::params::Model;
use crate::modes::row::Ends;
use crate::modes::spectrum::Spectrum;

/// The motion under the force alone, as a function of site and time t + ψ.
///
/// ```
/// use vibrochain_lattice::{Chain, Ends};
/// let chain = Chain::new(3, 0.2, 0.1)?;
/// let ring = chain.point().omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9);
/// let steady = ring.model()?.steady()?;
/// assert_eq!(steady.at(0), steady.at(1));
/// // Walls hold their neighbours back.
/// let held = ring.ends(Ends::Fixed).omega(0.1).model()?.steady()?;
/// assert!(held.at(0).value(0.0) < held.at(1).value(0.0) && held.at(0) == held.at(2));
/// # Ok::<(), vibrochain_lattice::LatticeError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[must_use]
pub struct Steady {
    /// The uniform motion; between walls the force.
    wave: Wave,
    walls: Option<Chain>,
    dashpots: [f64; 2],
}

impl Model {
    /// The motion that the force drives without impacts, of every mass: [`Model::steady_response`], or less between walls.
    ///
    /// # Errors
    /// [`Resonance`] when a harmonic meets a mode that the force reaches.
    pub fn steady(&self) -> Result<Steady, Resonance> {
        let (chain, dashpots) = (*self.chain(), self.dashpots());
        if chain.ends() != Ends::Fixed {
            return Ok(Steady { wave: self.steady_response()?, walls: None, dashpots });
        }
        let wave = self.force_wave();
        if !self.is_damped() && wave.terms().iter().any(|term| term.amplitude != 0.0) {
            // The force is even about the middle, and alike in all layers.
            let row = Chain::alone_with(&chain);
            let spectrum = Spectrum::new(row);
            for term in wave.terms() {
                for (mode, &frequency) in spectrum.frequencies().iter().enumerate().step_by(2) {
                    let distance = frequency - term.rate;
                    if distance.abs() <= RESONANCE_TOLERANCE * term.rate {
                        let harmonic = (term.rate / self.omega()).round() as u64;
                        return Err(Resonance { harmonic, mode, frequency, omega: self.omega(), distance });
                    }
                }
            }
        }
        Ok(Steady { wave, walls: Some(chain), dashpots })
    }
}

impl Steady {
    fn is_damped(&self) -> bool {
        self.dashpots != [0.0; 2]
    }

    /// The motion of one mass.
    pub fn at(&self, site: usize) -> Wave {
        match &self.walls {
            None => self.wave,
            Some(chain) if self.is_damped() => {
                self.wave.turned(|term| damped_steady::held(chain, self.dashpots, term.rate, site % chain.length()))
            }
            Some(chain) => self.wave.scaled(|term| held(chain, term.rate, site % chain.length())),
        }
    }

    /// A bound of a derivative of the motion at all sites and times.
    #[inline]
    pub fn bound(&self, order: i32) -> f64 {
        let Some(chain) = &self.walls else { return self.wave.bound(order) };
        let held = |rate: f64| match self.is_damped() {
            true => damped_steady::held_at_most(chain, self.dashpots, rate),
            false => held_at_most(chain, rate),
        };
        let most = |term: &WaveTerm| term.amplitude.abs() * held(term.rate) * term.rate.powi(order);
        self.wave.terms().iter().map(most).sum()
    }

    /// The amplitude of a uniform motion that is a cosine of phase 0, with its sign; otherwise a bound of the displacement.
    pub fn reach(&self) -> f64 {
        if self.walls.is_none() { self.wave.reach() } else { self.bound(0) }
    }

    /// The highest rate of a term that is not 0; 0 if there is none.
    pub fn top_rate(&self) -> f64 {
        self.wave.top_rate()
    }

    /// The motion, where all masses move alike.
    pub fn uniform(&self) -> Option<&Wave> {
        self.walls.is_none().then_some(&self.wave)
    }
}

/// γ₁ − w², with one rounding of the square.
fn below(chain: &Chain, w: f64) -> f64 {
    (-w).mul_add(w, chain.gamma1())
}

/// g_n(w).
fn held(chain: &Chain, w: f64, n: usize) -> f64 {
    let (m, gamma2) = (chain.length(), chain.gamma2());
    if gamma2 == 0.0 {
        return 1.0 / below(chain, w);
    }
    match decay(chain, w) {
        Decay::Evanescent(factor) => {
            let ends = (1.0 - power(factor, n + 1)) * (1.0 - power(factor, m - n));
            ends / ((1.0 + power(factor, m + 1)) * below(chain, w))
        }
        Decay::Propagating(wavenumber) => {
            let half = 0.5 * wavenumber;
            // sin(½κj)/sin ½κ
            let ratio = |j: usize| if half > 0.0 { (half * j as f64).sin() / half.sin() } else { j as f64 };
            ratio(n + 1) * ratio(m - n) / (2.0 * gamma2 * (half * (m + 1) as f64).cos())
        }
    }
}

/// A bound of |g_n(w)| at all n.
fn held_at_most(chain: &Chain, w: f64) -> f64 {
    let (m, gamma2) = (chain.length(), chain.gamma2());
    if gamma2 == 0.0 {
        return 1.0 / below(chain, w).abs();
    }
    match decay(chain, w) {
        Decay::Evanescent(factor) if factor > 0.0 => 1.0 / below(chain, w).abs(),
        Decay::Evanescent(factor) => {
            let size = factor.abs();
            (1.0 + size) * (1.0 + size) / ((1.0 - power(size, m + 1)) * below(chain, w).abs())
        }
        Decay::Propagating(wavenumber) => {
            let half = 0.5 * wavenumber;
            // Of two factors whose arguments sum to ½κ(M+1): each at most 1, and at most its argument over sin ½κ.
            let middle = 0.5 * (m + 1) as f64 * if half > 0.0 { half / half.sin() } else { 1.0 };
            let most = middle.min(if half > 0.0 { 1.0 / half.sin() } else { f64::INFINITY });
            most * most / (2.0 * gamma2 * (half * (m + 1) as f64).cos().abs())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_solves_the_equation_of_motion_between_walls() {
        let mut checked = 0;
        for (m, gamma1, gamma2, layers) in [(1, 0.2, 0.1, 1), (2, 0.0, 0.3, 1), (5, 0.2, 0.05, 2), (12, 0.25, 0.1, 1)] {
            let layer = if layers > 1 { 0.07 } else { 0.0 };
            let chain = Chain::new(m, gamma1, gamma2).unwrap().with_ends(Ends::Fixed);
            let chain = chain.with_layers(layers, layer, Ends::Free).unwrap();
            // Below, in and above the band; at its lower edge too.
            for omega in [0.1, 0.5, 0.55, 0.7, 0.83, 1.5, 4.0] {
                let model = chain.point().omega(omega).asymmetry(0.1).amplitude(0.3).restitution(0.9).model().unwrap();
                let steady = model.steady().unwrap();
                let size = steady.bound(0);
                for n in 0..chain.sites() {
                    let [value, _, acceleration, _] = steady.at(n).jet(0.4);
                    let sides = chain.neighbours(n).map(|n| n.map_or(0.0, |n| steady.at(n).value(0.4)));
                    let left = chain.spring_force(value, sides) + model.force_wave().value(0.4) - acceleration;
                    assert!(left.abs() < 1e-14 * (1.0 + size), "{chain} {omega} {n}: {left:e}");
                    assert!(value.abs() <= size * (1.0 + 1e-14), "{chain} {omega} {n}: {value} {size}");
                    checked += 1;
                }
            }
        }
        assert_eq!(checked, 7 * (1 + 2 + 10 + 12));
    }

    #[test]
    fn it_solves_the_equation_of_motion_with_dashpots() {
        let (mut checked, mut resonant) = (0, 0);
        for (m, gamma1, gamma2, layers) in [(1, 0.2, 0.1, 1), (2, 0.0, 0.3, 1), (5, 0.2, 0.05, 2), (12, 0.25, 0.1, 1)] {
            let layer = if layers > 1 { 0.07 } else { 0.0 };
            for (ends, dashpots) in [Ends::Closed, Ends::Fixed, Ends::Free]
                .into_iter()
                .flat_map(|ends| [[0.03, 0.0], [0.0, 0.07], [-1e-3, 0.02], [2.0, 5.0]].map(|dashpots| (ends, dashpots)))
            {
                let chain = Chain::new(m, gamma1, gamma2).unwrap().with_ends(ends);
                let chain = chain.with_layers(layers, layer, Ends::Free).unwrap();
                for omega in [0.1, 0.5, 0.55, 0.7, 0.83, 1.5, 4.0] {
                    let point = chain.point().damping(dashpots[0]).coupling_damping(dashpots[1]);
                    let model = point.omega(omega).amplitude(0.3).restitution(0.9).model().unwrap();
                    let Ok(steady) = model.steady() else {
                        // Where no dashpot acts on masses that move alike.
                        assert!(dashpots[0] == 0.0 && ends != Ends::Fixed && gamma1 == 0.25 && omega == 0.5);
                        resonant += 1;
                        continue;
                    };
                    let size = steady.bound(0);
                    for n in 0..chain.sites() {
                        let [value, velocity, acceleration, _] = steady.at(n).jet(0.4);
                        let of = |neighbour: usize, order: usize| steady.at(neighbour).jet(0.4)[order];
                        let [sides, speeds] =
                            [0, 1].map(|order| chain.neighbours(n).map(|n| n.map_or(0.0, |n| of(n, order))));
                        let stretch = 2.0 * velocity - speeds[0] - speeds[1];
                        let lost = dashpots[0] * velocity + dashpots[1] * stretch;
                        let pushed = chain.spring_force(value, sides) + model.force_wave().value(0.4);
                        let left = pushed - lost - acceleration;
                        assert!(left.abs() < 1e-13 * (1.0 + 20.0 * size), "{chain} {dashpots:?} {omega} {n}: {left:e}");
                        assert!(value.abs() <= size * (1.0 + 1e-13), "{chain} {omega} {n}: {value} {size}");
                        checked += 1;
                    }
                }
            }
        }
        assert!(checked > 2000 && resonant == 2, "{checked} {resonant}");
    }

    #[test]
    fn only_modes_that_the_force_reaches_resonate() {
        let chain = Chain::new(4, 0.25, 0.1).unwrap().with_ends(Ends::Fixed);
        let frequencies = Spectrum::new(chain).frequencies().to_vec();
        for (mode, frequency) in frequencies.into_iter().enumerate() {
            let answer =
                chain.point().omega(frequency).asymmetry(0.1).amplitude(0.3).restitution(0.9).model().unwrap().steady();
            assert_eq!(answer.is_err(), mode % 2 == 0, "{mode}");
            if let Err(resonance) = answer {
                assert_eq!((resonance.harmonic, resonance.mode), (1, mode));
            }
        }
        assert!(
            chain.point().omega(0.5).asymmetry(0.1).amplitude(0.3).restitution(0.9).model().unwrap().steady().is_ok()
        );
    }
}

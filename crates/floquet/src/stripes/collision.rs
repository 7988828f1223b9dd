//! The pair of modes behind an unstable multiplier.

use nalgebra::Complex;
use std::f64::consts::TAU;

use super::dressed::DressedModes;

/// Two modes that have collided: Ω̃_k + Ω̃_l = jω, up to the detuning.
///
/// It is always a sum: where the difference of two frequencies is a harmonic, multipliers of equal Krein signature meet,
/// and none leaves the circle.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[must_use]
pub struct Collision {
    /// k ≤ l; mode k is the one between Ω_k and Ω_{k+1}, and the last one, [`DressedModes::count`] − 1, the internal mode.
    /// Equal for a mode against itself (period doubling).
    pub modes: (usize, usize),
    /// j
    pub harmonic: usize,
    /// Ω̃_k + Ω̃_l − jω (dimensionless). `None` where a mode cannot be told apart from the breather.
    pub detuning: Option<f64>,
}

/// A place in turns of the circle that lies between two modes.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    mode: usize,
    /// Winding number: whole turns added to the phase.
    winding: f64,
    /// Distance from the mode's own phase, in units of what its gap spans.
    distance: f64,
    frequency: Option<f64>,
}

impl DressedModes {
    /// The pair whose collision has made the multiplier μ of the orbit taken over leave the circle: μ has the phase of the
    /// one and the opposite phase of the other, up to whole turns. `None` for a multiplier that left through +1, which no
    /// mode need have met, and for a phase where no mode is.
    ///
    /// Where the band of the ring is wider than ω several pairs may have that phase; the one nearest to it is named.
    ///
    /// ```
    /// use vibrochain_breather::{Family, Finder, OrbitList};
    /// use vibrochain_floquet::{Analyser, DressedModes, Tolerance};
    /// use vibrochain_lattice::{Chain, Model};
    /// let model = Model::conservative(Chain::new(6, 0.2, 0.15)?, 1.6, 0.4)?;
    /// let (mut finder, mut found) = (Finder::new(6), OrbitList::default());
    /// finder.find(&model, Family::DoubleSided, &mut found)?;
    /// let verdict = Analyser::default().verdict(&found.orbits[0], &mut finder, Tolerance::Rounding)?;
    /// let mut modes = DressedModes::default();
    /// modes.replace(finder.prepared(&found.orbits[0])?)?;
    /// let collision = modes.collision(verdict.leading).unwrap();
    /// assert_eq!((collision.modes, collision.harmonic), ((1, 2), 1));
    /// assert!(collision.detuning.unwrap().abs() < 0.01);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn collision(&self, leading: Complex<f64>) -> Option<Collision> {
        let turns = leading.arg().abs() / TAU;
        if leading.im == 0.0 {
            // Half a turn up and half a turn down are one place: a mode against itself. With half-period symmetry it is a
            // pair ±i of roots, which does not meet.
            if leading.re >= 0.0 || self.is_symmetric() {
                return None;
            }
            let here = self.candidates(0.5).into_iter().min_by(|a, b| a.distance.total_cmp(&b.distance))?;
            let harmonic = 2.0 * here.winding + 1.0;
            let detuning = here.frequency.map(|frequency| 2.0 * frequency - harmonic * self.omega());
            return Some(Collision { modes: (here.mode, here.mode), harmonic: harmonic as usize, detuning });
        }
        let (up, down) = (self.candidates(turns), self.candidates(-turns));
        let mut best: Option<(f64, Collision)> = None;
        for a in &up {
            for b in down.iter().filter(|b| b.mode != a.mode) {
                let harmonic = a.winding + b.winding;
                let distance = a.distance + b.distance;
                if self.is_symmetric() && harmonic % 2.0 != 0.0 || best.is_some_and(|(least, _)| least <= distance) {
                    continue;
                }
                let sum = a.frequency.zip(b.frequency).map(|(a, b)| a + b);
                let detuning = sum.map(|sum| sum - harmonic * self.omega());
                let modes = (a.mode.min(b.mode), a.mode.max(b.mode));
                best = Some((distance, Collision { modes, harmonic: harmonic as usize, detuning }));
            }
        }
        best.map(|(_, collision)| collision)
    }

    /// All modes between whose neighbours Ω_k/ω and Ω_{k+1}/ω the place lies, whole turns added, and the internal mode, which
    /// has no neighbours, if it is not farther away than those would be.
    fn candidates(&self, place: f64) -> Vec<Candidate> {
        let mut found = Vec::new();
        for mode in 0..self.count() {
            let Some((low, high)) = self.gap(mode) else { continue };
            let (low, high) = (low / self.omega(), high / self.omega());
            let mut winding = (low - place).ceil();
            let mut frequency = None;
            while place + winding < high {
                let own = *frequency.get_or_insert_with(|| self.frequency(mode));
                let centre = own.map_or(0.5 * (low + high), |own| own / self.omega());
                let distance = (place + winding - centre).abs() / (high - low);
                found.push(Candidate { mode, winding, distance, frequency: own });
                winding += 1.0;
            }
        }
        if let Some(mode) = self.internal_mode() {
            let winding = (mode.frequency / self.omega() - place).round();
            let distance = ((place + winding) * self.omega() - mode.frequency).abs() / self.spacing();
            if distance < 1.0 {
                found.push(Candidate { mode: self.count() - 1, winding, distance, frequency: Some(mode.frequency) });
            }
        }
        found
    }
}

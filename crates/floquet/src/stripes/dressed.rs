//! Modes of the lattice with the breather on it.
//!
//! With the secular function f of the orbit (`form`) linear in the answer G₀ of the ring at Ω, and Ω and no other
//! w_j = Ω + jω in the band, f = 0 is the phase condition of a standing wave, exactly:
//!
//! ```text
//! D G₀ = −cot x = −c,    x = qM/2,   Ω² = γ₁ + 4γ₂ sin²(q/2),   D² = (Ω²−γ₁)(γ₁+4γ₂−Ω²),
//! ```
//!
//! c what the rest of f demands; the wave returns from the breather by arccot c late. Other w_j in the band are what couples
//! modes to each other, those of opposite signature among them. Give them the answer ±i/D of the infinite ring, waves that
//! run off and do not come back: then c is complex and e^{2ix} = (c+i)/(c−i) is the coefficient of reflection, and its phase
//! alone makes x(Ω) = πk + arg/2 the condition for mode k. That is the frequency Ω̃_k to which the breather shifts mode k,
//! between Ω_k (x = πk) and Ω_{k+1}, all meetings with others left out. (f itself is never resonant then, and neither does
//! Ω̃ jump where another mode passes.)
//!
//! A mode that the breather has drawn out of the band (`internal`) loses waves to a w_j in the band: it is a zero of the
//! coefficient of reflection next to the real axis, and turns its phase by 2π within the width of that loss. Meetings
//! with it are left out by dividing by its factor (Ω−z)/(Ω−z̄), which has modulus 1.
//!
//! On other lattices waves that run off are answered by some A + iB, and a standing wave by G₀ = A − B cot x, x from 0 at one mode that feels
//! the impacts to π at the next: the same with c = (A − G₀)/B demanded of the rest of f. Where no other w_j is in a band f is real, and its
//! zeros are the same whatever A and B are.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::OnceLock;

use nalgebra::Complex;
use vibrochain_breather::{ContactOrbit, Prepared};

use super::form::{C, Form};
use super::internal::{InternalMode, internal_mode};
use super::signature::Signature;
use crate::bracket::zero;
use crate::error::FloquetError;
use crate::multipliers::participating_modes;
use crate::saltation::{Saltation, saltations};
use crate::spectrum::KreinForms;

/// Two modes this close, relatively, have none between them.
const EQUAL: f64 = 1e-9;

/// The frequencies Ω̃_k of the modes of the lattice with a breather on it, apart from collisions: Ω_k < Ω̃_k < Ω_{k+1} between two that
/// feel the impacts, numbered by rising frequency ([`crate::participating_modes`]), and,
/// as the last one, that of the internal mode, which is not in the band ([`InternalMode`]).
///
/// Above ω = 2Ω_max, where none can collide, e^{±iΩ̃T} are multipliers of the orbit.
///
/// ```
/// use vibrochain_breather::{Family, Finder, OrbitList};
/// use vibrochain_floquet::DressedModes;
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(6, 0.2, 0.15)?, 1.7, 0.4)?;
/// let (mut finder, mut found) = (Finder::new(6), OrbitList::default());
/// finder.find(&model, Family::DoubleSided, &mut found)?;
/// let mut modes = DressedModes::default();
/// modes.replace(finder.prepared(&found.orbits[0])?)?;
/// // Bare modes at 0.447, 0.592, 0.807 and 0.896; the breather leaves three, in between, and has none of its own.
/// let dressed: Vec<f64> = modes.frequencies().flatten().collect();
/// assert!((dressed[0] - 0.493).abs() < 1e-3 && (dressed[1] - 0.720).abs() < 1e-3 && (dressed[2] - 0.876).abs() < 1e-3);
/// assert!(dressed.len() == 3 && modes.internal_mode().is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct DressedModes {
    /// Ω_k
    bare: Vec<f64>,
    form: Form,
    symmetric: bool,
    /// Looked for when it is asked for, where no other mode depends on it.
    internal: OnceLock<Option<InternalMode>>,
    /// Zeros of the coefficient of reflection in the band that are the internal mode.
    zeros: Vec<C>,
}

impl DressedModes {
    /// Takes over an orbit that is its own mirror image in time ([`is_reversible`](vibrochain_breather::Orbit::is_reversible)) and hit at one site; any other has no such modes, nor has
    /// one of a frequency so low that hundreds of its harmonics are below the band.
    ///
    /// # Errors
    /// [`FloquetError::Grazing`].
    pub fn replace(&mut self, prepared: Prepared<'_>) -> Result<(), FloquetError> {
        let (orbit, response) = (prepared.orbit(), prepared.response());
        self.bare.clear();
        self.zeros.clear();
        self.internal = OnceLock::from(None);
        let Some(site) = orbit.impact_site().filter(|_| orbit.is_reversible()) else { return Ok(()) };
        let _ = saltations(&orbit)?;
        let e = orbit.model().restitution();
        let kappas: smallvec::SmallVec<[f64; 2]> =
            orbit.impacts().iter().map(|impact| Saltation::reduced(impact, e)).collect();
        // Its own mirror image half a period later, if the gap is its own mirror image.
        self.symmetric = kappas.len() == 2 && orbit.model().asymmetry() == 0.0;
        if !self.form.set(prepared, &kappas, self.symmetric) {
            return Ok(());
        }
        let chain = orbit.model().chain();
        if chain.is_ring() {
            self.bare.extend_from_slice(response.frequencies());
        } else {
            self.bare.extend(participating_modes(chain, site).into_iter().map(|(_, frequency)| frequency));
        }
        // On a ring one mode has its place between each two, and what has left the band is missing there. Between the bands of several
        // channels a mode may be localised, and be the one that has its place there.
        if chain.is_ring() && self.form.is_double() {
            // Only one that emits no waves is looked for: it leaves no zeros in the band.
            self.internal = OnceLock::new();
        } else if chain.is_ring() || (0..self.count().saturating_sub(1)).any(|k| self.is_missing(k)) {
            self.internal = OnceLock::from(internal_mode(&self.form, &mut self.zeros));
        }
        Ok(())
    }

    /// Number of modes: those between two neighbours of the bare ring, and the internal mode, the last one.
    pub fn count(&self) -> usize {
        self.bare.len()
    }

    /// ω
    pub(super) fn omega(&self) -> f64 {
        self.form.omega()
    }

    /// The orbit is its own mirror image half a period later: its multipliers are squares, and modes that meet at an odd
    /// harmonic have opposite roots and do not collide.
    pub fn is_symmetric(&self) -> bool {
        self.symmetric
    }

    /// All frequencies, by rising k.
    pub fn frequencies(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        (0..self.count()).map(|k| self.frequency(k))
    }

    /// The internal mode, number [`Self::count`] − 1, if it has one.
    pub fn internal_mode(&self) -> Option<&InternalMode> {
        let look = || if self.bare.is_empty() { None } else { internal_mode(&self.form, &mut Vec::new()) };
        self.internal.get_or_init(look).as_ref()
    }

    /// The mean distance of neighbouring modes.
    pub(super) fn spacing(&self) -> f64 {
        match self.bare.as_slice() {
            [first, .., last] => (last - first) / (self.bare.len() - 1) as f64,
            _ => 0.0,
        }
    }

    /// Ω_k and Ω_{k+1}, which enclose mode k. `None` where jω is between them, too: what is there is the breather itself.
    pub(super) fn gap(&self, k: usize) -> Option<(f64, f64)> {
        let (low, high) = (*self.bare.get(k)?, *self.bare.get(k + 1)?);
        let harmonics = |frequency: f64| (frequency / self.omega()).floor();
        (harmonics(low) == harmonics(high)).then_some((low, high))
    }

    /// There is a place between two modes, and none has it.
    fn is_missing(&self, k: usize) -> bool {
        self.frequency(k).is_none() && self.gap(k).is_none_or(|(low, high)| high - low > EQUAL * high)
    }

    /// Ω̃_k; `None` where there is none between the two modes: the breather has drawn it out of the band, or a harmonic of
    /// ω is there instead. That of the last k is the internal mode.
    pub fn frequency(&self, k: usize) -> Option<f64> {
        if k + 1 == self.count() {
            return self.internal_mode().map(|mode| mode.frequency);
        }
        let (low, high) = self.gap(k)?;
        let width = high - low;
        if width <= EQUAL * high {
            return None;
        }
        let excess = |w: f64| {
            let at = self.form.phase_between(k, w) - self.delay(w);
            if at.is_nan() { Err(()) } else { Ok(at) }
        };
        // x − πk − arg/2 is not positive at the lower end and not negative at the upper one, whatever the phase is there.
        let w = zero((low, -FRAC_PI_2), (high, FRAC_PI_2), high, excess).ok()?;
        // A phase that jumps by π has no zero.
        excess(w).is_ok_and(|at| at.abs() < 1e-6).then_some(w)
    }

    /// Signature of the multiplier of each mode, by rising k, the internal mode last: of all multipliers on the circle, and their
    /// mirror images, that next to e^{iΩ̃T}. `None` where that is next to another mode, or has the form of the other sign: then
    /// the mode's own has left the circle, or is too far from the place where it would be without meetings to be told apart.
    ///
    /// `roots` are those of the orbit taken over, ν = ½(μ + 1/μ), as [`crate::Secular::roots`] has them. O(M) for each.
    pub fn signatures(&self, orbit: &ContactOrbit, roots: &[Complex<f64>]) -> Vec<Option<Signature>> {
        // In turns of the circle, from −½ to ½: where the form is positive. It is negative at the mirror images.
        let (equations, _) = orbit.bloch_equations();
        let forms = KreinForms::without_parts(&equations);
        let on_the_circle = roots.iter().filter(|nu| nu.im == 0.0 && nu.re.abs() < 1.0);
        let positive: Vec<f64> = on_the_circle
            .filter_map(|nu| {
                let multiplier = C::new(nu.re, ((1.0 - nu.re) * (1.0 + nu.re)).sqrt());
                let sign = Signature::at(multiplier, &forms)?.value();
                Some(f64::from(sign) * multiplier.arg() / TAU)
            })
            .collect();
        let places: Vec<Option<f64>> = self.frequencies().map(|w| w.map(|w| w / self.omega())).collect();
        let apart = |a: f64, b: f64| (a - b - (a - b).round()).abs();
        let signature_at = |place: f64| {
            let nearest = positive.iter().copied().min_by(|a, b| apart(*a, place).total_cmp(&apart(*b, place)))?;
            let distance = apart(nearest, place);
            // (At −1 and +1 both are as near.)
            let other_form = positive.iter().any(|turn| apart(-turn, place) <= distance);
            let nearer = |other: &f64| apart(nearest, *other) < distance;
            let other_mode = places.iter().flatten().any(nearer);
            (!other_form && !other_mode).then_some(if nearest > 0.0 {
                Signature::Positive
            } else {
                Signature::Negative
            })
        };
        places.iter().map(|place| place.and_then(signature_at)).collect()
    }

    /// Half the phase of the coefficient of reflection, from 0 to π, the internal mode left out.
    fn delay(&self, w: f64) -> f64 {
        let own = |z: &C| (w - z.conj()) / (w - z);
        let rest: C = self.zeros.iter().map(own).product();
        (0.5 * (self.reflection(w) * rest).arg()).rem_euclid(PI)
    }

    /// The coefficient of reflection of waves of frequency w in the band (dimensionless), the waves of its partners w + jω running off. Its
    /// modulus is 1 where no partner is in the band.
    ///
    /// ```
    /// # use vibrochain_breather::{Family, Finder, OrbitList};
    /// # use vibrochain_floquet::DressedModes;
    /// # use vibrochain_lattice::{Chain, Model};
    /// let modes = |omega: f64| -> Result<DressedModes, Box<dyn std::error::Error>> {
    ///     let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, omega, 0.4)?;
    ///     let (mut finder, mut found, mut modes) = (Finder::new(21), OrbitList::default(), DressedModes::default());
    ///     finder.find_symmetric(&model, Family::DoubleSided, &mut found)?;
    ///     modes.replace(finder.prepared(&found.orbits[0])?)?;
    ///     Ok(modes)
    /// };
    /// // The band ends at 0.775: above twice that, waves come back whole; below, some come back stronger.
    /// assert!((modes(1.6)?.reflection(0.7).norm() - 1.0).abs() < 1e-9 && modes(1.5)?.reflection(0.75).norm() < 0.999);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn reflection(&self, w: f64) -> Complex<f64> {
        // Linear in G₀.
        let [without, with] = self.form.without_and_with(w);
        let green = -without / (with - without);
        let (offset, scale) = self.form.standing(w);
        let c = (offset - green) * scale;
        (c + C::i()) / (c - C::i())
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_breather::{Family, Finder, OrbitList};
    use vibrochain_lattice::{Chain, Model};

    use super::*;

    fn modes(family: Family, sites: usize, gamma2: f64, omega: f64) -> DressedModes {
        let model = Model::conservative(Chain::new(sites, 0.2, gamma2).unwrap(), omega, 0.4).unwrap();
        let (mut finder, mut found) = (Finder::new(sites), OrbitList::default());
        finder.find_symmetric(&model, family, &mut found).unwrap();
        let mut modes = DressedModes::default();
        modes.replace(finder.prepared(&found.orbits[0]).unwrap()).unwrap();
        modes
    }

    #[test]
    fn waves_come_back_whole_where_nothing_else_is_in_the_band() {
        for (family, sites) in [(Family::DoubleSided, 41), (Family::SingleSided, 40), (Family::DoubleSided, 7)] {
            // The band ends at 1.
            for omega in [2.1, 2.5, 4.0] {
                let modes = modes(family, sites, 0.2, omega);
                for w in [0.46, 0.6, 0.777, 0.9, 0.99] {
                    let size = modes.reflection(w).norm();
                    assert!((size - 1.0).abs() < 1e-9, "{family:?} {omega} {w}: {size}");
                }
            }
        }
    }

    #[test]
    fn harmonics_without_number_are_not_counted_through() {
        for gamma2 in [0.0, 1e-9, 0.2] {
            for omega in [5e-4, 1e-9] {
                assert_eq!(modes(Family::SingleSided, 21, gamma2, omega).frequencies().flatten().count(), 0);
            }
        }
        assert!(modes(Family::SingleSided, 21, 1e-3, 0.1).frequencies().flatten().count() > 0);
    }

    #[test]
    fn less_of_a_wave_is_turned_into_others_the_faster_the_impacts_follow() {
        for part in [0.98, 0.93] {
            let turned = [1.2, 1.4, 1.6, 1.8, 1.95].map(|omega| {
                let size = modes(Family::DoubleSided, 401, 0.2, omega).reflection(0.5 * part * omega).norm();
                size.ln().abs()
            });
            assert!(turned[0] > 0.04 && turned.windows(2).all(|pair| pair[1] < pair[0]), "{turned:?}");
        }
    }

    #[test]
    fn a_long_ring_has_the_frequencies_of_the_same_reflection() {
        // x(Ω) − arg/2 is a multiple of π in every ring, and the reflection is one and the same.
        let (short, long) = (modes(Family::DoubleSided, 31, 0.1, 1.3), modes(Family::DoubleSided, 301, 0.1, 1.3));
        for k in 0..short.count() - 1 {
            let w = short.frequency(k).unwrap();
            assert!((short.reflection(w) - long.reflection(w)).norm() < 1e-6);
            let turns = (short.form.phase_between(0, w) - long.delay(w)) / PI;
            assert!((turns - turns.round()).abs() < 1e-6);
        }
    }
}

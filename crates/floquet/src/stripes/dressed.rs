//! Modes of the ring with the breather on it.
//!
//! A wave e^{iΩt} that reaches the breather is answered at Ω and, by impacts once a period, at all w_j = Ω + jω. The secular
//! function of the orbit is a quadratic form in what the ring answers there, its Green function G(w) = Σ b²/(Ω_l²−w²):
//!
//! ```text
//! one impact:    f = −s² + g(h − κ/2),    s = (2/T) Σ_j w_j G_j,   g = (2/T) Σ_j G_j,   h = (2/T) Σ_j (1 + w_j² G_j),
//! two impacts:   f = f₀f₁ − (δ²/4) g₀g₁,  each over T/2, f₀ with the even j, f₁ with the odd ones, κ the mean of both.
//! ```
//!
//! Each G_j enters linearly. If Ω and no other w_j is in the band, f = 0 is the phase condition of a standing wave, exactly:
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
//! Sums over all j: those of a few nodes in closed form, and the difference between ring and nodes for the w_j in or near the
//! band. Nodes are the modes themselves, which differ in the band alone, or n Chebyshev nodes where the modes are more:
//! outside the band these differ by λ^2n, λ the decay from site to site.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::Complex;
use vibrochain_breather::Orbit;
use vibrochain_lattice::{ImpulseResponse, sine_over};

use crate::error::FloquetError;
use crate::saltation::saltations;

type C = Complex<f64>;

/// Chebyshev nodes that stand for the modes of a ring that has more.
const NODES: usize = 8;

/// cosh of the decay from which λ^16 < 1e-12: distance from the centre of the band in Ω², over half its width.
const FAR: f64 = 2.9;

/// A node, with cos y, sin y/Ω and Ω sin y of its phase y over the time between impacts.
#[derive(Debug, Clone, Copy, Default)]
struct Node {
    weight: f64,
    square: f64,
    cos: f64,
    over: f64,
    times: f64,
}

/// s, g and h.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    s: C,
    g: C,
    h: C,
}

impl Sums {
    /// f of one impact.
    fn form(&self, kappa: f64) -> C {
        self.g * (self.h - 0.5 * kappa) - self.s * self.s
    }
}

/// The frequencies Ω̃_k of the modes of the ring with a breather on it, apart from collisions: Ω_k < Ω̃_k < Ω_{k+1}.
///
/// Above ω = 2Ω_max, where none can collide, e^{±iΩ̃T} are multipliers of the orbit.
///
/// ```
/// use vibrochain_breather::{Family, Finder, Found};
/// use vibrochain_floquet::DressedModes;
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(6, 0.2, 0.15)?, 1.7, 0.4)?;
/// let (mut finder, mut found) = (Finder::new(6), Found::default());
/// finder.find(&model, Family::DoubleSided, &mut found)?;
/// let mut modes = DressedModes::default();
/// modes.set(&found.orbits[0], finder.response())?;
/// // Bare modes at 0.447, 0.592, 0.807 and 0.896; the breather leaves three, in between.
/// let dressed: Vec<f64> = modes.frequencies().flatten().collect();
/// assert!((dressed[0] - 0.493).abs() < 1e-3 && (dressed[1] - 0.720).abs() < 1e-3 && (dressed[2] - 0.876).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct DressedModes {
    sites: usize,
    gamma1: f64,
    gamma2: f64,
    omega: f64,
    /// Ω_k
    bare: Vec<f64>,
    nodes: Vec<Node>,
    /// Up to where the nodes do not do.
    reach: f64,
    /// Mean and half the difference of the κ of both impacts; one impact has no difference.
    kappa: f64,
    delta: f64,
    double: bool,
    symmetric: bool,
}

impl DressedModes {
    /// Takes over an orbit that is its own mirror image in time ([`Orbit::is_reversible`]); any other has no such modes.
    /// `response` is that of the orbit's chain and frequency.
    ///
    /// # Errors
    /// [`FloquetError::Grazing`].
    pub fn set(&mut self, orbit: &Orbit, response: &ImpulseResponse) -> Result<(), FloquetError> {
        self.bare.clear();
        if !orbit.is_reversible() {
            return Ok(());
        }
        let kappas: smallvec::SmallVec<[f64; 2]> = saltations(orbit)?.map(|hit| hit.kappa).collect();
        let (first, second) = match kappas.as_slice() {
            [only] => (*only, *only),
            [first, second] => (*first, *second),
            _ => return Ok(()),
        };
        let chain = orbit.model().chain();
        (self.sites, self.gamma1, self.gamma2) = (chain.sites(), chain.gamma1(), chain.gamma2());
        self.omega = response.omega();
        self.double = kappas.len() == 2;
        // Its own mirror image half a period later, if the gap is its own mirror image.
        self.symmetric = self.double && orbit.model().asymmetry() == 0.0;
        self.kappa = 0.5 * (first + second);
        self.delta = if self.symmetric { 0.0 } else { 0.5 * (first - second) };
        self.bare.extend_from_slice(response.frequencies());
        let time = self.time();
        let node = |weight: f64, frequency: f64| {
            let over = sine_over(frequency, time);
            let square = frequency * frequency;
            Node { weight, square, cos: (frequency * time).cos(), over, times: square * over }
        };
        let centre = self.gamma1 + 2.0 * self.gamma2;
        self.nodes.clear();
        // From 2n sites on the ring is the better known by n nodes.
        let far = if self.sites < 2 * NODES {
            let modes = response.weights().iter().zip(&self.bare);
            self.nodes.extend(modes.map(|(weight, frequency)| node(*weight, *frequency)));
            1.0
        } else {
            let angles = (0..NODES).map(|i| PI * (i as f64 + 0.5) / NODES as f64);
            let squares = angles.map(|angle| centre - 2.0 * self.gamma2 * angle.cos());
            self.nodes.extend(squares.map(|square| node(1.0 / NODES as f64, square.sqrt())));
            FAR
        };
        self.reach = (centre + 2.0 * self.gamma2 * far).sqrt();
        Ok(())
    }

    /// Number of modes that are left beside the breather.
    pub fn count(&self) -> usize {
        self.bare.len().saturating_sub(1)
    }

    /// ω
    pub(super) fn omega(&self) -> f64 {
        self.omega
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

    /// Ω_k and Ω_{k+1}, which enclose mode k.
    pub(super) fn gap(&self, k: usize) -> Option<(f64, f64)> {
        Some((*self.bare.get(k)?, *self.bare.get(k + 1)?))
    }

    /// Ω̃_k; `None` where there is none between the two modes: the breather has drawn it out of the band, or a harmonic of
    /// ω is there instead.
    pub fn frequency(&self, k: usize) -> Option<f64> {
        let (mut low, mut high) = self.gap(k)?;
        let width = high - low;
        if width <= 1e-9 * high {
            return None;
        }
        // x − πk − arg/2 is not positive at the lower end and not negative at the upper one, whatever the phase is there.
        let excess = |w: f64| self.phase(w) - PI * k as f64 - self.delay(w);
        let (mut at_low, mut at_high) = (-FRAC_PI_2, FRAC_PI_2);
        let mut side = 0_i32;
        for step in 0..80 {
            let chord = (low * at_high - high * at_low) / (at_high - at_low);
            // Regula falsi, the weight of an end that stays halved (Illinois); every fourth step is a plain half.
            let w = if step % 4 != 3 && chord > low && chord < high { chord } else { 0.5 * (low + high) };
            let at = excess(w);
            if at.is_nan() {
                return None;
            }
            if at.abs() < 1e-13 || high - low <= 4.0 * f64::EPSILON * high {
                // A phase that jumps by π has no zero, and a multiple of ω is the breather itself.
                let turns = w / self.omega;
                let own = (turns - turns.round()).abs() < 1e-7;
                return (at.abs() < 1e-6 && !own).then_some(w);
            }
            if at > 0.0 {
                (high, at_high) = (w, at);
                if side == 1 {
                    at_low *= 0.5;
                }
                side = 1;
            } else {
                (low, at_low) = (w, at);
                if side == -1 {
                    at_high *= 0.5;
                }
                side = -1;
            }
        }
        None
    }

    /// x = qM/2 of a wave.
    fn phase(&self, w: f64) -> f64 {
        let sine = ((w * w - self.gamma1) / (4.0 * self.gamma2)).clamp(0.0, 1.0).sqrt();
        sine.asin() * self.sites as f64
    }

    /// Half the phase of the coefficient of reflection, from 0 to π.
    fn delay(&self, w: f64) -> f64 {
        (0.5 * self.reflection(w).arg()).rem_euclid(PI)
    }

    /// The coefficient of reflection. Its modulus is not 1 where waves are turned into others, at w_j in the band.
    fn reflection(&self, w: f64) -> C {
        // Linear in G₀.
        let (without, with) = (self.form(w, 0.0), self.form(w, 1.0));
        let green = -without / (with - without);
        let c = -green * self.density(w * w).max(0.0).sqrt();
        (c + C::i()) / (c - C::i())
    }

    /// D²: positive in the band.
    fn density(&self, square: f64) -> f64 {
        (square - self.gamma1) * (self.gamma1 + 4.0 * self.gamma2 - square)
    }

    /// Between impacts.
    fn time(&self) -> f64 {
        TAU / self.omega * if self.double { 0.5 } else { 1.0 }
    }

    /// f at w, for any answer G₀.
    fn form(&self, w: f64, green: f64) -> C {
        if !self.double {
            return self.sums(w, Some(green)).form(self.kappa);
        }
        // The odd w_j are w + ω and every second one from there.
        let (even, odd) = (self.sums(w, Some(green)), self.sums(w + self.omega, None));
        even.form(self.kappa) * odd.form(self.kappa) - 0.25 * self.delta * self.delta * even.g * odd.g
    }

    /// The sums over all w_j = w + (2π/time)j; `own` stands for G(w) itself.
    fn sums(&self, w: f64, own: Option<f64>) -> Sums {
        let time = self.time();
        let (sin, cos) = (w * time).sin_cos();
        let mut sums = Sums::default();
        for node in &self.nodes {
            let pole = node.weight / (cos - node.cos);
            sums.s += sin * pole;
            sums.g += node.over * pole;
            sums.h += node.times * pole;
        }
        let twice = 2.0 / time;
        let step = TAU / time;
        let (first, last) = (((-self.reach - w) / step).ceil().min(0.0), ((self.reach - w) / step).floor().max(0.0));
        let mut j = first;
        while j <= last {
            let w = w + step * j;
            let green = match own {
                Some(own) if j == 0.0 => C::new(own, 0.0),
                _ => self.green(w),
            };
            let nodes: f64 = self.nodes.iter().map(|node| node.weight / (node.square - w * w)).sum();
            let rest = twice * (green - nodes);
            sums.s += w * rest;
            sums.g += rest;
            sums.h += w * w * rest;
            j += 1.0;
        }
        sums
    }

    /// G(w): the ring's outside the band, the infinite ring's inside, where waves run off.
    fn green(&self, w: f64) -> C {
        let square = w * w;
        let density = self.density(square);
        if density > 0.0 {
            return C::new(0.0, w.signum() / density.sqrt());
        }
        let root = (-density).sqrt();
        // λ of the decay from site to site; above the band neighbours are in antiphase.
        let (below, distance) = if square < self.gamma1 {
            (true, self.gamma1 - square)
        } else {
            (false, square - self.gamma1 - 4.0 * self.gamma2)
        };
        let cosh_minus_one = distance / (2.0 * self.gamma2);
        let decay = 1.0 / (1.0 + cosh_minus_one + (cosh_minus_one * (cosh_minus_one + 2.0)).sqrt());
        let sites = self.sites as f64;
        let sign = if below || self.sites.is_multiple_of(2) { 1.0 } else { -1.0 };
        let around = sign * decay.powf(sites);
        let size = (1.0 + around) / ((1.0 - around) * root);
        C::new(if below { size } else { -size }, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_breather::{Family, Finder, Found};
    use vibrochain_lattice::{Chain, Model};

    use super::*;

    fn modes(family: Family, sites: usize, gamma2: f64, omega: f64) -> DressedModes {
        let model = Model::conservative(Chain::new(sites, 0.2, gamma2).unwrap(), omega, 0.4).unwrap();
        let (mut finder, mut found) = (Finder::new(sites), Found::default());
        finder.find_symmetric(&model, family, &mut found).unwrap();
        let mut modes = DressedModes::default();
        modes.set(&found.orbits[0], finder.response()).unwrap();
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
        for k in 0..short.count() {
            let w = short.frequency(k).unwrap();
            assert!((short.reflection(w) - long.reflection(w)).norm() < 1e-6);
            let turns = (short.phase(w) - long.delay(w)) / PI;
            assert!((turns - turns.round()).abs() < 1e-6);
        }
    }
}

//! The secular function of an orbit at one frequency.
//!
//! A wave e^{iwt} that reaches the breather is answered at w and, by impacts once a period, at all w_j = w + jω. The secular
//! function of the orbit is a quadratic form in what the lattice answers there, its Green function G(w) = Σ b²/(Ω_l²−w²):
//!
//! ```text
//! one impact:    f = −s² + g(h − 2κ'),    s = (2/T) Σ_j w_j G_j,   g = (2/T) Σ_j G_j,   h = (2/T) Σ_j (1 + w_j² G_j),
//! two impacts:   f = f₀f₁ − 4δ² g₀g₁,  each over T/2, f₀ with the even j, f₁ with the odd ones, κ' the mean of both and δ half their difference.
//! ```
//!
//! Each G_j enters linearly. Those of w_j in the band are ±i/D here, D² = (w²−γ₁)(γ₁+4γ₂−w²), as in the infinite ring: waves that
//! run off and do not come back. f is then analytic between the edges of the band.
//!
//! Sums over all j: those of a few nodes in closed form, and the difference between ring and nodes for the w_j in or near the
//! band. Nodes are the modes themselves, which differ in the band alone, or n Chebyshev nodes where the modes are more:
//! outside the band these differ by λ^2n, λ the decay from site to site.
//!
//! On other lattices waves run off along the rows, either way, in channels: each shape ψ_l across the layers has a band of its own, and in it
//! the share ψ_l² of ±i/D; outside it its modes answer one by one.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use nalgebra::Complex;
use vibrochain_breather::Prepared;
use vibrochain_lattice::{Ends, Spectrum, sine_over};

use crate::map_paths::Modes;

pub(super) type C = Complex<f64>;

/// Chebyshev nodes that stand for the modes of a ring that has more.
const NODES: usize = 8;

/// cosh of the decay from which λ^16 < 1e-12: distance from the centre of the band in Ω², over half its width.
const FAR: f64 = 2.9;

/// The most w_j in or near the band: f takes all of them one by one, and with that many no mode is told apart from a wave.
const MOST_HARMONICS: f64 = 1000.0;

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
struct WaveSums {
    s: C,
    g: C,
    h: C,
}

impl WaveSums {
    /// f of one impact.
    fn form(&self, kappa: f64) -> C {
        self.g * (self.h - 2.0 * kappa) - self.s * self.s
    }

    /// The ring answers G at w, `twice` being 2 over the time between impacts.
    fn add(&mut self, w: C, green: C, twice: f64) {
        let part = twice * green;
        self.s += w * part;
        self.g += part;
        self.h += w * w * part;
    }
}

/// Waves with one shape across the layers.
#[derive(Debug, Clone, Default)]
struct Channel {
    /// Where waves run: between the edges of the band of a ring, elsewhere between the first mode and the last.
    low: f64,
    high: f64,
    /// Ω² of the lower edge of an infinite row's band.
    edge: f64,
    /// ψ_l²
    share: f64,
    /// The modes.
    nodes: Range<usize>,
}

impl Channel {
    fn carries(&self, w: f64) -> bool {
        w.abs() > self.low && w.abs() < self.high
    }
}

/// Sine and cosine, to the bit those of the library, which takes each apart for itself. Most are asked of real numbers.
fn sin_cos(z: C) -> (C, C) {
    let (sin, cos) = z.re.sin_cos();
    let (sinh, cosh) = if z.im == 0.0 { (z.im, 1.0) } else { (z.im.sinh(), z.im.cosh()) };
    (C::new(sin * cosh, cos * sinh), C::new(cos * cosh, -sin * sinh))
}

/// A positive power, to the bit that of the library, which asks for the phase of real numbers, too.
fn power(z: C, exponent: f64) -> C {
    if z.im == 0.0 && z.re > 0.0 { C::new(z.re.powf(exponent), z.im) } else { z.powf(exponent) }
}

/// f of an orbit, for any w.
#[derive(Debug, Clone, Default)]
pub(super) struct Form {
    ring: bool,
    /// One on a ring.
    channels: Vec<Channel>,
    sites: usize,
    gamma1: f64,
    gamma2: f64,
    omega: f64,
    nodes: Vec<Node>,
    /// Up to where the nodes do not do.
    reach: f64,
    /// Mean and half the difference of the κ' of both impacts; one impact has no difference.
    kappa: f64,
    delta: f64,
    double: bool,
}

impl Form {
    /// Takes over an orbit of one or two impacts a period; false for any other, and for a frequency with more than
    /// [`MOST_HARMONICS`] harmonics up to the band.
    pub(super) fn set(&mut self, prepared: Prepared<'_>, kappas: &[f64], symmetric: bool) -> bool {
        let (chain, response) = (prepared.orbit().model().chain(), prepared.response());
        let (first, second) = match kappas {
            [only] => (*only, *only),
            [first, second] => (*first, *second),
            _ => return false,
        };
        (self.sites, self.gamma1, self.gamma2) = (chain.sites(), chain.gamma1(), chain.gamma2());
        self.omega = response.omega();
        self.double = kappas.len() == 2;
        self.kappa = 0.5 * (first + second);
        self.delta = if symmetric { 0.0 } else { 0.5 * (first - second) };
        let time = self.time();
        let node = |weight: f64, frequency: f64| {
            let over = sine_over(frequency, time);
            let square = frequency * frequency;
            Node { weight, square, cos: (frequency * time).cos(), over, times: square * over }
        };
        let centre = self.gamma1 + 2.0 * self.gamma2;
        self.nodes.clear();
        self.channels.clear();
        self.ring = chain.is_ring();
        if !self.ring {
            return self.set_rows(prepared, node);
        }
        let (low, high) = (self.gamma1.sqrt(), (self.gamma1 + 4.0 * self.gamma2).sqrt());
        self.channels.push(Channel { low, high, edge: self.gamma1, share: 1.0, nodes: 0..0 });
        // From 2n sites on the ring is the better known by n nodes.
        let far = if self.sites < 2 * NODES {
            let modes = response.weights().iter().zip(response.frequencies());
            self.nodes.extend(modes.map(|(weight, frequency)| node(*weight, *frequency)));
            1.0
        } else {
            let angles = (0..NODES).map(|i| PI * (i as f64 + 0.5) / NODES as f64);
            let squares = angles.map(|angle| centre - 2.0 * self.gamma2 * angle.cos());
            self.nodes.extend(squares.map(|square| node(1.0 / NODES as f64, square.sqrt())));
            FAR
        };
        self.reach = (centre + 2.0 * self.gamma2 * far).sqrt();
        2.0 * self.reach <= MOST_HARMONICS * self.omega
    }

    /// The same, of a lattice that is no ring.
    fn set_rows(&mut self, prepared: Prepared<'_>, node: impl Fn(f64, f64) -> Node) -> bool {
        let (chain, response) = (prepared.orbit().model().chain(), prepared.response());
        let Some(site) = prepared.orbit().impact_site() else { return false };
        let Ok(row) = chain.with_layers(1, 0.0, Ends::Closed) else { return false };
        let row = Spectrum::new(row);
        // Between walls the band begins below the first mode.
        let first = row.frequencies().first().map_or(0.0, |f| f * f - self.gamma1);
        let length = row.frequencies().len();
        let squares: Vec<f64> = response.shapes().evens(site, site).take(response.modes()).collect();
        let modes = response.frequencies().iter().zip(response.weights().iter().zip(&squares));
        let modes: Vec<_> = modes.map(|(frequency, (weight, square))| (*frequency, *weight, *square)).collect();
        for channel in modes.chunks(length) {
            let from = self.nodes.len();
            let mut felt = channel.iter().filter(|(.., square)| !Modes::is_spared(*square));
            self.nodes.extend(felt.clone().map(|(frequency, weight, square)| node(weight * square, *frequency)));
            let (Some(&(low, ..)), Some(&(lowest, ..))) = (felt.next(), channel.first()) else { continue };
            let high = felt.next_back().map_or(low, |(high, ..)| *high);
            let nodes = from..self.nodes.len();
            let share = self.nodes[nodes.clone()].iter().map(|node| node.weight).sum();
            self.channels.push(Channel { low, high, edge: lowest * lowest - first, share, nodes });
        }
        self.reach = self.edges().fold(0.0, f64::max);
        2.0 * self.reach <= MOST_HARMONICS * self.omega
    }

    /// ω
    pub(super) fn omega(&self) -> f64 {
        self.omega
    }

    /// Lower and upper edges of all bands.
    pub(super) fn bands(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.channels.iter().map(|channel| (channel.low, channel.high))
    }

    /// All of these edges.
    pub(super) fn edges(&self) -> impl Iterator<Item = f64> + '_ {
        self.bands().flat_map(|(low, high)| [low, high])
    }

    /// Waves run off at w.
    pub(super) fn carries(&self, w: f64) -> bool {
        self.channels.iter().any(|channel| channel.carries(w))
    }

    /// Phase x of a standing wave at w between the modes k and k + 1, from 0 at the one to π at the other.
    pub(super) fn phase_between(&self, k: usize, w: f64) -> f64 {
        if self.ring {
            return self.half_wave_number(w) * self.sites as f64 - PI * k as f64;
        }
        let answer: f64 = self.nodes.iter().map(|node| node.weight / (node.square - w * w)).sum();
        let (offset, scale) = self.standing(w);
        1f64.atan2((offset - answer) * scale)
    }

    /// A and 1/B, with the answer of waves that run off A + iB: cot x = (A − G)/B. Where none does any will do.
    pub(super) fn standing(&self, w: f64) -> (f64, f64) {
        if self.ring {
            return (0.0, self.density(C::from(w * w)).re.max(0.0).sqrt());
        }
        if !self.carries(w) {
            return (0.0, self.gamma1 + self.gamma2);
        }
        let free = self.green(C::from(w));
        (free.re, free.im.abs().recip())
    }

    /// Two impacts a period.
    pub(super) fn is_double(&self) -> bool {
        self.double
    }

    /// q/2 of a wave in the band.
    fn half_wave_number(&self, w: f64) -> f64 {
        ((w * w - self.gamma1) / (4.0 * self.gamma2)).clamp(0.0, 1.0).sqrt().asin()
    }

    /// D² at w²: positive in the band.
    fn density(&self, square: C) -> C {
        (square - self.gamma1) * (self.gamma1 + 4.0 * self.gamma2 - square)
    }

    /// f at w, for the answers G₀ = 0 and G₀ = 1.
    pub(super) fn without_and_with(&self, w: f64) -> [C; 2] {
        let w = C::from(w);
        // The odd w_j are w + ω and every second one from there.
        let odd = self.double.then(|| self.sums(w + self.omega, false));
        let mut even = self.sums(w, true);
        let without = self.product(&even, odd.as_ref());
        even.add(w, C::from(1.0), 2.0 / self.time());
        [without, self.product(&even, odd.as_ref())]
    }

    /// f at w, all waves run off, without its zero at the harmonics of ω: divided by cos wT − 1.
    pub(super) fn free(&self, w: C) -> C {
        let odd = self.double.then(|| self.sums(w + self.omega, false));
        self.product(&self.sums(w, false), odd.as_ref()) / self.trivial(w)
    }

    /// What a change of κ' adds to that, but for a negative factor.
    pub(super) fn stiffness(&self, w: C) -> C {
        let even = self.sums(w, false);
        let change = if self.double {
            let odd = self.sums(w + self.omega, false);
            even.g * odd.form(self.kappa) + even.form(self.kappa) * odd.g
        } else {
            even.g
        };
        change / self.trivial(w)
    }

    fn trivial(&self, w: C) -> C {
        // cos x − 1 = −2 sin²(x/2)
        let sin = (w * (PI / self.omega)).sin();
        -2.0 * sin * sin
    }

    fn product(&self, even: &WaveSums, odd: Option<&WaveSums>) -> C {
        let own = even.form(self.kappa);
        odd.map_or(own, |odd| own * odd.form(self.kappa) - 4.0 * self.delta * self.delta * even.g * odd.g)
    }

    /// Between impacts.
    fn time(&self) -> f64 {
        TAU / self.omega * if self.double { 0.5 } else { 1.0 }
    }

    /// The sums over all w_j = w + (2π/time)j, G₀ = 0 if so wanted.
    fn sums(&self, w: C, without: bool) -> WaveSums {
        let time = self.time();
        let (sin, cos) = sin_cos(w * time);
        let mut sums = WaveSums::default();
        for node in &self.nodes {
            let pole = node.weight / (cos - node.cos);
            sums.s += sin * pole;
            sums.g += node.over * pole;
            sums.h += node.times * pole;
        }
        let step = TAU / time;
        let (first, last) =
            (((-self.reach - w.re) / step).ceil().min(0.0), ((self.reach - w.re) / step).floor().max(0.0));
        let mut j = first;
        while j <= last {
            let w = w + step * j;
            let left_out = without && j == 0.0;
            // Where no wave runs off, nodes that are the modes say all.
            if self.ring || left_out || self.carries(w.re) {
                let green = if left_out { C::default() } else { self.green(w) };
                let square = w * w;
                let nodes: C = self.nodes.iter().map(|node| node.weight / (node.square - square)).sum();
                sums.add(w, green - nodes, 2.0 / time);
            }
            j += 1.0;
        }
        sums
    }

    /// G(w): the lattice's outside the band, that of waves that run off inside.
    fn green(&self, w: C) -> C {
        let square = w * w;
        if !self.ring {
            return self.channels.iter().map(|channel| self.green_of(channel, w)).sum();
        }
        let density = self.density(square);
        if self.carries(w.re) {
            return C::i() * w.re.signum() / density.sqrt();
        }
        let root = (-density).sqrt();
        // λ of the decay from site to site; above the band neighbours are in antiphase.
        let below = w.re.abs() <= self.gamma1.sqrt();
        let distance = if below { self.gamma1 - square } else { square - self.gamma1 - 4.0 * self.gamma2 };
        let cosh_minus_one = distance / (2.0 * self.gamma2);
        let decay = (cosh_minus_one + 1.0 + (cosh_minus_one * (cosh_minus_one + 2.0)).sqrt()).inv();
        let sign = if below || self.sites.is_multiple_of(2) { 1.0 } else { -1.0 };
        let around = sign * power(decay, self.sites as f64);
        let size = (1.0 + around) / ((1.0 - around) * root);
        if below { size } else { -size }
    }

    /// What the waves of one channel answer.
    fn green_of(&self, channel: &Channel, w: C) -> C {
        let square = w * w;
        if !channel.carries(w.re) {
            return self.nodes[channel.nodes.clone()].iter().map(|node| node.weight / (node.square - square)).sum();
        }
        let density = (square - channel.edge) * (channel.edge + 4.0 * self.gamma2 - square);
        C::i() * w.re.signum() * channel.share / density.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quick_functions_are_the_librarys_to_the_bit() {
        let mut random = fastrand::Rng::with_seed(17);
        let bits = |z: C| [z.re, z.im].map(f64::to_bits);
        for i in 0..30_000 {
            let im = [0.0, -0.0, 0.3 * random.f64() - 0.15][i % 3];
            let z = C::new(20.0 * random.f64() - 10.0, im);
            let (sin, cos) = sin_cos(z);
            assert_eq!((bits(sin), bits(cos)), (bits(z.sin()), bits(z.cos())), "{z}");
            let z = C::new(1.2 * random.f64() - 0.1, im);
            let sites = random.u32(1..60);
            assert_eq!(bits(power(z, f64::from(sites))), bits(z.powf(f64::from(sites))), "{z} {sites}");
        }
    }
}

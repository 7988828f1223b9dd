//! The secular function of an orbit at one frequency.
//!
//! A wave e^{iwt} that reaches the breather is answered at w and, by impacts once a period, at all w_j = w + jω. The secular
//! function of the orbit is a quadratic form in what the ring answers there, its Green function G(w) = Σ b²/(Ω_l²−w²):
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

use std::f64::consts::{PI, TAU};

use nalgebra::Complex;
use vibrochain_lattice::{Chain, ImpulseResponse, sine_over};

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

/// f of an orbit, for any w.
#[derive(Debug, Clone, Default)]
pub(super) struct Form {
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
    pub(super) fn set(&mut self, chain: &Chain, response: &ImpulseResponse, kappas: &[f64], symmetric: bool) -> bool {
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

    /// ω
    pub(super) fn omega(&self) -> f64 {
        self.omega
    }

    /// Two impacts a period.
    pub(super) fn is_double(&self) -> bool {
        self.double
    }

    /// M
    pub(super) fn sites(&self) -> usize {
        self.sites
    }

    /// Edges of the band.
    pub(super) fn band(&self) -> (f64, f64) {
        (self.gamma1.sqrt(), (self.gamma1 + 4.0 * self.gamma2).sqrt())
    }

    /// q/2 of a wave in the band.
    pub(super) fn half_wave_number(&self, w: f64) -> f64 {
        ((w * w - self.gamma1) / (4.0 * self.gamma2)).clamp(0.0, 1.0).sqrt().asin()
    }

    /// D² at w²: positive in the band.
    pub(super) fn density(&self, square: C) -> C {
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
        let (sin, cos) = ((w * time).sin(), (w * time).cos());
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
            let green = if without && j == 0.0 { C::default() } else { self.green(w) };
            let square = w * w;
            let nodes: C = self.nodes.iter().map(|node| node.weight / (node.square - square)).sum();
            sums.add(w, green - nodes, 2.0 / time);
            j += 1.0;
        }
        sums
    }

    /// G(w): the ring's outside the band, the infinite ring's inside.
    fn green(&self, w: C) -> C {
        let square = w * w;
        let density = self.density(square);
        let (low, high) = self.band();
        if w.re.abs() > low && w.re.abs() < high {
            return C::i() * w.re.signum() / density.sqrt();
        }
        let root = (-density).sqrt();
        // λ of the decay from site to site; above the band neighbours are in antiphase.
        let below = w.re.abs() <= low;
        let distance = if below { self.gamma1 - square } else { square - self.gamma1 - 4.0 * self.gamma2 };
        let cosh_minus_one = distance / (2.0 * self.gamma2);
        let decay = (cosh_minus_one + 1.0 + (cosh_minus_one * (cosh_minus_one + 2.0)).sqrt()).inv();
        let sign = if below || self.sites.is_multiple_of(2) { 1.0 } else { -1.0 };
        let around = sign * decay.powf(self.sites as f64);
        let size = (1.0 + around) / ((1.0 - around) * root);
        if below { size } else { -size }
    }
}

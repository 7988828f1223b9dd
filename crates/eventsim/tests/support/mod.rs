//! Shared by the tests: reproducible random states and an independent truth.
#![allow(dead_code, unreachable_pub, reason = "each test uses its part")]
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_lattice::{Barrier, ImpulseResponse, Model, Spectrum};

/// Half impulses p₁, p₂ of the conservative double-sided breather of `model`, on the lower barrier at T/2 and on the
/// upper one at 0: the two positions are linear in them, with the impulse response at T/2 and 0 for coefficients.
pub fn half_impulses(model: &Model) -> [f64; 2] {
    let response = ImpulseResponse::new(&Spectrum::new(*model.chain()), model.omega()).unwrap();
    let (half, zero) = (response.value(0, 0.5 * model.period()), response.value(0, 0.0));
    let a = model.asymmetry();
    // 2p₁ half − 2p₂ zero = a + 1 and 2p₁ zero − 2p₂ half = a − 1: by their sum and difference.
    let difference = a / (half + zero); // p₁ − p₂
    let sum = 1.0 / (half - zero); // p₁ + p₂
    [0.5 * (sum + difference), 0.5 * (sum - difference)]
}

/// State of that breather just after its impact at t = 0, from the closed form.
pub fn breather(model: &Model) -> (Vec<f64>, Vec<f64>) {
    let [p1, p2] = half_impulses(model);
    let sites = model.chain().sites();
    let response = ImpulseResponse::new(&Spectrum::new(*model.chain()), model.omega()).unwrap();
    let half = 0.5 * model.period();
    let mut u: Vec<f64> =
        (0..sites).map(|n| 2.0 * p1 * response.value(n, half) - 2.0 * p2 * response.value(n, 0.0)).collect();
    let upper = model.barrier(Barrier::Upper);
    assert!((u[0] - upper).abs() < 1e-14);
    u[0] = upper;
    let mut v = vec![0.0; sites];
    v[0] = -p2;
    (u, v)
}

/// xorshift64*, good enough to pick states.
pub struct Random(pub u64);

impl Random {
    /// Uniform in −1 … 1.
    pub fn signed(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// A state within the gap, with speeds up to `speed`.
    pub fn state(&mut self, model: &Model, speed: f64) -> (Vec<f64>, Vec<f64>) {
        let sites = model.chain().sites();
        let u = (0..sites).map(|_| model.asymmetry() + 0.9 * self.signed()).collect();
        let v = (0..sites).map(|_| speed * self.signed()).collect();
        (u, v)
    }
}

/// One impact of the truth.
#[derive(Debug, Clone, Copy)]
pub struct Impact {
    pub time: f64,
    pub site: usize,
    pub barrier: Barrier,
    pub before: f64,
}

/// The linear ring by its modes: cos(2πkn/M) and sin(2πkn/M), and the forced motion of the uniform one.
struct Modes {
    model: Model,
    psi: f64,
    /// Ω_k and the two shapes of each mode, normalised.
    frequencies: Vec<f64>,
    shapes: Vec<Vec<f64>>,
    /// Amplitudes at `start`: q cos + p sin/Ω.
    q: Vec<f64>,
    p: Vec<f64>,
    start: f64,
}

impl Modes {
    fn new(model: &Model, psi: f64) -> Self {
        let m = model.chain().sites();
        let (mut frequencies, mut shapes) = (Vec::new(), Vec::new());
        for k in 0..=m / 2 {
            let angle = |n: usize| std::f64::consts::TAU * ((k * n) % m) as f64 / m as f64;
            let single = k == 0 || 2 * k == m;
            let norm = (if single { 1.0 } else { 2.0 } / m as f64).sqrt();
            let stiffness = model.chain().gamma1() + 4.0 * model.chain().gamma2() * (0.5 * angle(1)).sin().powi(2);
            frequencies.push(stiffness.sqrt());
            shapes.push((0..m).map(|n| norm * angle(n).cos()).collect());
            if !single {
                frequencies.push(stiffness.sqrt());
                shapes.push((0..m).map(|n| norm * angle(n).sin()).collect());
            }
        }
        let modes = frequencies.len();
        Self { model: *model, psi, frequencies, shapes, q: vec![0.0; modes], p: vec![0.0; modes], start: 0.0 }
    }

    /// The forced motion Ã cos ω(t+ψ) and its velocity.
    fn driven(&self, t: f64) -> (f64, f64) {
        let (w, g1) = (self.model.omega(), self.model.chain().gamma1());
        self.model.force().harmonics().iter().fold((0.0, 0.0), |sum, harmonic| {
            let rate = f64::from(harmonic.number) * w;
            let response = harmonic.amplitude / (g1 - rate * rate);
            let (sin, cos) = (rate * (t + self.psi) + harmonic.phase).sin_cos();
            (sum.0 + response * cos, sum.1 - response * rate * sin)
        })
    }

    fn set(&mut self, t: f64, u: &[f64], v: &[f64]) {
        let (g, h) = self.driven(t);
        for (k, shape) in self.shapes.iter().enumerate() {
            self.q[k] = shape.iter().zip(u).map(|(s, u)| s * (u - g)).sum();
            self.p[k] = shape.iter().zip(v).map(|(s, v)| s * (v - h)).sum();
        }
        self.start = t;
    }

    fn get(&self, t: f64, u: &mut [f64], v: &mut [f64]) {
        let (g, h) = self.driven(t);
        u.fill(g);
        v.fill(h);
        let s = t - self.start;
        for (k, shape) in self.shapes.iter().enumerate() {
            let f = self.frequencies[k];
            let (sin, cos) = (f * s).sin_cos();
            let over = if f == 0.0 { s } else { sin / f };
            let (position, velocity) = (self.q[k] * cos + self.p[k] * over, self.p[k] * cos - self.q[k] * f * sin);
            for ((u, v), shape) in u.iter_mut().zip(v.iter_mut()).zip(shape) {
                *u += position * shape;
                *v += velocity * shape;
            }
        }
    }
}

/// Impacts by brute force: the exact modal flow, looked at `samples` times a period; every mass behind a barrier at a
/// sample has hit it since the last, and the earliest is found by bisection. Knows nothing of bounds, series or rest.
pub fn scan(model: &Model, psi: f64, u: &[f64], v: &[f64], periods: f64, samples: u32) -> Vec<Impact> {
    let sites = u.len();
    let mut modes = Modes::new(model, psi);
    modes.set(0.0, u, v);
    let (mut u, mut v) = (u.to_vec(), v.to_vec());
    let mut impacts: Vec<Impact> = Vec::new();
    let step = model.period() / f64::from(samples);
    let last = (periods * f64::from(samples)) as u64;
    let mut known = 0.0; // no impact is outstanding up to here
    let outside = |u: f64| {
        if u > model.barrier(Barrier::Upper) {
            Some(Barrier::Upper)
        } else if u < model.barrier(Barrier::Lower) {
            Some(Barrier::Lower)
        } else {
            None
        }
    };
    for i in 1..=last {
        let t = i as f64 * step;
        loop {
            modes.get(t, &mut u, &mut v);
            let suspects: Vec<_> = (0..sites).filter_map(|n| outside(u[n]).map(|b| (n, b))).collect();
            let mut first: Option<(f64, usize, Barrier)> = None;
            for (n, barrier) in suspects {
                let (mut low, mut high) = (known, t);
                for _ in 0..80 {
                    let middle = 0.5 * (low + high);
                    modes.get(middle, &mut u, &mut v);
                    // A mass that has just left this barrier is behind it by rounding; it moves inward.
                    let beyond =
                        outside(u[n]) == Some(barrier) && (v[n] * barrier.sign() > 0.0 || middle - known > 1e-9);
                    if beyond { high = middle } else { low = middle }
                }
                if first.is_none_or(|(time, ..)| high < time) {
                    first = Some((high, n, barrier));
                }
            }
            let Some((time, site, barrier)) = first else { break };
            modes.get(time, &mut u, &mut v);
            impacts.push(Impact { time, site, barrier, before: v[site] });
            u[site] = model.barrier(barrier);
            v[site] *= -model.restitution();
            modes.set(time, &u, &v);
            known = time;
        }
        known = t;
    }
    impacts
}

//! Internal units and the table of Taylor orders.
//!
//! Time is scaled by a power of two (exactly, therefore) such that the fastest rate
//!
//! ```text
//! r = max(√(γ₁+4γ₂+4γ₃), jω)      (ω/4 without a force, to keep windows near a period; j the highest harmonic of it)
//! ```
//!
//! lies in [1, 2). Every coefficient of every series then is of the size of the motion, for any γ and ω.

use vibrochain_lattice::{Barrier, Chain, Ends, Force, Model};

/// Highest order of a Taylor series.
pub(crate) const MAX_ORDER: usize = 24;

/// Orders in use. All even: a displacement and a velocity start one chain of coefficients each.
pub(crate) const ORDERS: [usize; 8] = [10, 12, 14, 16, 18, 20, 22, 24];

/// What a truncated series may miss, relative to the gap: an eighth of a unit in the last place.
pub(crate) const REMAINDER: f64 = f64::EPSILON / 8.0;

/// How fast derivatives grow: |d_{k+2}| ≤ r² max(|d_k|, |d_{k+1}|/r) + |F_k|, and |F_k| ≤ A r^k.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Growth {
    /// r
    pub(crate) rate: f64,
    /// A; half of it where only every other derivative counts.
    pub(crate) forced: f64,
}

/// 1/k!.
pub(crate) fn inverse_factorials() -> [f64; MAX_ORDER + 1] {
    let mut table = [1.0; MAX_ORDER + 1];
    let mut factorial = 1.0; // exact up to 22!, and right to the last digit beyond
    for (k, entry) in table.iter_mut().enumerate().skip(1) {
        factorial *= k as f64;
        *entry = 1.0 / factorial;
    }
    table
}

/// The next number of a reproducible sequence in −1 … 1 (Knuth's linear congruential generator).
pub(crate) fn spread(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
    f64::from((*seed >> 32) as i32) * 2f64.powi(-31)
}

/// The model in internal units.
#[derive(Debug, Clone)]
pub(crate) struct Units {
    /// Internal time is time × `scale`, a power of two; velocities are divided by it.
    pub(crate) scale: f64,
    /// Who is whose neighbour; its stiffnesses are in units of their own.
    pub(crate) chain: Chain,
    /// One row of masses: neighbours stand side by side.
    pub(crate) is_row: bool,
    pub(crate) gamma1: f64,
    pub(crate) gamma2: f64,
    pub(crate) gamma3: f64,
    pub(crate) omega: f64,
    /// Σ|A_j|, a bound of the force.
    pub(crate) amplitude: f64,
    force: Force,
    pub(crate) restitution: f64,
    pub(crate) lower: f64,
    pub(crate) upper: f64,
    /// r of the module's text.
    pub(crate) rate: f64,
    pub(crate) inverse_factorial: [f64; MAX_ORDER + 1],
    /// 1/k from k = 1 on.
    pub(crate) inverse: [f64; MAX_ORDER + 1],
}

impl Units {
    pub(crate) fn new(model: &Model) -> Self {
        let chain = model.chain();
        // In a row of one mass without walls the coupling cancels.
        let alone = chain.length() == 1 && chain.ends() != Ends::Fixed;
        let coupling = if alone { 0.0 } else { chain.gamma2() };
        // Whatever the ends: each mass has at most two springs along its row and two across.
        let stiffness = (chain.gamma1() + 4.0 * coupling + 4.0 * chain.gamma3()).sqrt();
        let forced = model.amplitude() > 0.0;
        let rate = stiffness.max(if forced { model.force_wave().top_rate() } else { 0.25 * model.omega() });
        // The power of two below: the exponent alone.
        let scale = f64::from_bits(rate.to_bits() & 0x7ff0_0000_0000_0000);
        let square = scale * scale;
        Self {
            scale,
            chain: *chain,
            is_row: chain.layers() == 1,
            gamma1: chain.gamma1() / square,
            gamma2: coupling / square,
            gamma3: chain.gamma3() / square,
            omega: model.omega() / scale,
            amplitude: model.amplitude() / square,
            force: *model.force(),
            restitution: model.restitution(),
            lower: model.barrier(Barrier::Lower),
            upper: model.barrier(Barrier::Upper),
            rate: rate / scale,
            inverse_factorial: inverse_factorials(),
            inverse: std::array::from_fn(|k| 1.0 / k.max(1) as f64),
        }
    }

    /// What is known `of` the neighbours of mass `n`; a wall does not move.
    pub(crate) fn sides(&self, n: usize, of: impl Fn(usize) -> f64) -> [f64; 4] {
        let [left, right, below, above] = self.chain.neighbours(n);
        let of = |side: Option<usize>| side.map_or(0.0, &of);
        if self.is_row { [of(left), of(right), 0.0, 0.0] } else { [of(left), of(right), of(below), of(above)] }
    }

    /// What the springs do to a mass at `own` with its neighbours at `sides`, in the order of [`Chain::neighbours`].
    pub(crate) fn pull(&self, own: f64, [left, right, below, above]: [f64; 4]) -> f64 {
        let row = self.gamma2 * ((left + right) - 2.0 * own) - self.gamma1 * own;
        if self.is_row { row } else { row + self.gamma3 * ((below + above) - 2.0 * own) }
    }

    /// How fast derivatives grow.
    pub(crate) fn growth(&self) -> Growth {
        Growth { rate: self.rate, forced: 0.5 * self.amplitude }
    }

    pub(crate) fn barrier(&self, barrier: Barrier) -> f64 {
        match barrier {
            Barrier::Lower => self.lower,
            Barrier::Upper => self.upper,
        }
    }

    /// Longest window of each order when no mass is faster than `fastest`.
    ///
    /// Taylor's remainder after order K is at most z^{K+1}/(K+1)! times the size of the motion, z = rH, and
    /// z^K/K! for the velocity. With the force in it the K-th derivative is at most
    /// r^K [|u| + (K/2) A/r²], A = Σ|A_j|. The size of the motion is |u| ≤ 1+a up to the first impact; a window outlives impacts
    /// of distant masses, after which the series of those nearer by describe a ring without barriers, with energy
    /// enough for |u| + |v|/r: the factor 4 covers its growth, cosh z, over the longest window.
    pub(crate) fn horizons(&self, fastest: f64) -> [f64; ORDERS.len()] {
        let size = 4.0 * (self.upper + fastest / self.rate);
        ORDERS.map(|order| {
            let k = order as f64;
            let amplitude = size + 0.5 * k * self.amplitude / (self.rate * self.rate);
            self.horizon(order, amplitude)
        })
    }

    /// The same of each order for perturbations: no force, and a size of one with room for its growth in a window.
    pub(crate) fn free_horizons(&self) -> [f64; ORDERS.len()] {
        ORDERS.map(|order| self.horizon(order, 4.0))
    }

    fn horizon(&self, order: usize, amplitude: f64) -> f64 {
        (REMAINDER / amplitude / self.inverse_factorial[order]).powf(1.0 / order as f64) / self.rate
    }

    /// How many neighbours on either side in a row can feel, within `time`, what happens to a mass now.
    pub(crate) fn reach(&self, time: f64, size: f64) -> usize {
        reach([self.gamma2, 0.0], time, size)
    }

    /// Derivatives F, F′, F″ … of the force at `phase` (internal time): of A cos ωt, or of the sum of its harmonics.
    pub(crate) fn force(&self, phase: f64, derivatives: &mut [f64; MAX_ORDER + 1]) {
        if self.amplitude == 0.0 {
            return; // zero from the start
        }
        let square = self.scale * self.scale;
        derivatives.fill(0.0);
        for harmonic in self.force.harmonics() {
            let rate = f64::from(harmonic.number) * self.omega;
            let (sin, cos) = (rate * phase + harmonic.phase).sin_cos();
            let cycle = [cos, -sin, -cos, sin];
            let mut size = harmonic.amplitude / square;
            for (k, derivative) in derivatives.iter_mut().enumerate() {
                *derivative += size * cycle[k % 4];
                size *= rate;
            }
        }
    }
}

/// How many neighbours on either side in a row can feel, within `time`, what happens to a mass now, through springs and dashpots between them.
///
/// A jump of velocity Δv displaces the m-th neighbour by at most about Δv γ₂^m τ^{2m+1}/(2m+1)!, and with `size`
/// for Δv this is compared with rounding. A dashpot passes on what a spring would take twice as many derivatives for: the divisor of the i-th
/// passage is then no less than i+1, of a spring (i+1)(i+2).
pub(crate) fn reach([spring, dashpot]: [f64; 2], time: f64, size: f64) -> usize {
    let (square, first) = (spring.abs() * time * time, dashpot.abs() * time);
    let mut term = size * time;
    let mut m = 0;
    while term > REMAINDER {
        m += 1;
        let k = m as f64;
        term *=
            if first == 0.0 { square / (2.0 * k * (2.0 * k + 1.0)) } else { (square / (k + 2.0) + first) / (k + 1.0) };
    }
    m
}

#[cfg(test)]
mod tests;

//! The periodic kernel: what contacts do after an impulse that repeats every period.
//!
//! A regular mode has ξ(t) = e^{At}(1−R)⁻¹c, R = e^{AT}. A rigid one has none: its kernel here is that of the impulse together with a
//! constant pull −1/T that balances it, and the condition that all impulses balance the static load makes the pulls cancel against it.
//!
//! ```text
//! rigid:                k = t/2 − t²/2T
//! with a dashpot c:     k = [ ½ − t/T − e^{−ct}/(1−e^{−cT}) ]/c
//! ```

use vibrochain_lattice::{LinearMode, Turn, Turned};

/// From here on 1 − R is rounding: the period is a whole number of the mode's own.
const RESONANT: f64 = 1e14;

/// A part of a contact's mobility that is rounding: a contact at a node of the mode.
const UNSEEN: f64 = 1e-12;

/// One mode's part.
#[derive(Debug, Clone)]
enum Sum {
    /// (1−R)⁻¹, and how much its errors are larger than those of R.
    Regular {
        sum: Turned,
        steep: f64,
    },
    Rigid,
}

/// The kernel and its derivatives between contacts.
#[derive(Debug, Clone)]
pub(super) struct PeriodicKernel<'a> {
    pub(super) period: f64,
    modes: &'a [LinearMode],
    sums: Vec<Sum>,
}

impl<'a> PeriodicKernel<'a> {
    pub(super) fn new(modes: &'a [LinearMode], period: f64) -> Self {
        let of_mode = |mode: &LinearMode| {
            if mode.is_rigid() {
                return Sum::Rigid;
            }
            let one_less = one_less(mode, period);
            let square = match mode.turn {
                Turn::Circular => one_less.even * one_less.even + one_less.odd * one_less.odd,
                Turn::Hyperbolic => {
                    // By the two poles.
                    (one_less.even + one_less.odd) * (one_less.even - one_less.odd)
                }
                Turn::Parabolic => one_less.even * one_less.even,
            };
            // 1 − R = a − bJ has the inverse (a + bJ)/(a² + σb²); `odd` holds −b.
            let sum = Turned { even: one_less.even / square, odd: -one_less.odd / square };
            let size = (mode.decay.abs() + mode.rate) * period;
            Sum::Regular { sum, steep: size / square.abs().sqrt() }
        };
        Self { period, modes, sums: modes.iter().map(of_mode).collect() }
    }

    /// Number of rigid modes.
    pub(super) fn rigid(&self) -> impl Iterator<Item = &'a LinearMode> + '_ {
        self.sums.iter().zip(self.modes).filter(|(sum, _)| matches!(sum, Sum::Rigid)).map(|(_, mode)| mode)
    }

    /// The first mode that impacts of these contacts would drive without bound.
    pub(super) fn resonant(&self, contacts: &[usize]) -> Option<usize> {
        let seen = |mode: &LinearMode, contact: usize| {
            let (row, column) = (mode.rows[contact], mode.columns[contact]);
            mode.rate * row[0].hypot(row[1]) * column[0].hypot(column[1])
        };
        let drives = |mode: &LinearMode, contact: usize| {
            let all: f64 = self.modes.iter().map(|other| seen(other, contact)).sum();
            seen(mode, contact) > UNSEEN * all
        };
        self.sums.iter().zip(self.modes).position(|(sum, mode)| match *sum {
            Sum::Regular { steep, .. } => steep >= RESONANT && contacts.iter().any(|contact| drives(mode, *contact)),
            Sum::Rigid => false,
        })
    }

    /// (1−R)⁻¹ of mode `k` if it is regular.
    pub(super) fn sum(&self, k: usize) -> Option<Turned> {
        match self.sums[k] {
            Sum::Regular { sum, .. } => Some(sum),
            Sum::Rigid => None,
        }
    }

    /// K and its first three derivatives at −T < t ≤ T, for t ≤ 0 the past impulses alone: K(t+T). And the size of the terms of K, with
    /// what next to a resonance is lost on them.
    pub(super) fn jet(&self, to: usize, from: usize, t: f64) -> ([f64; 4], [f64; 3]) {
        let t = if t > 0.0 { t } else { t + self.period };
        let (mut jet, mut sizes) = ([0.0; 4], [0.0; 3]);
        for (mode, sum) in self.modes.iter().zip(&self.sums) {
            let (row, column) = (mode.rows[to], mode.columns[from]);
            match *sum {
                Sum::Regular { sum, steep } => {
                    if row == [0.0; 2] || column == [0.0; 2] {
                        continue;
                    }
                    let turn = mode.turn;
                    let mut motion = turn.product(mode.flight(t), sum);
                    let size = row[0].hypot(row[1]) * column[0].hypot(column[1]) * motion.even.hypot(motion.odd);
                    let fast = mode.decay.hypot(mode.rate);
                    for (order, entry) in jet.iter_mut().enumerate() {
                        *entry += pair(turn, row, motion, column);
                        motion = turn.product(motion, mode.generator());
                        if let Some(place) = sizes.get_mut(order) {
                            *place += size * (1.0 + steep) * fast.powi(order as i32);
                        }
                    }
                }
                Sum::Rigid => {
                    let shapes = row[0] * column[1] * mode.rate;
                    for (order, own) in rigid_jet(mode, self.period, t).into_iter().enumerate() {
                        jet[order] += shapes * own;
                        if let Some(place) = sizes.get_mut(order) {
                            *place += (shapes * own).abs();
                        }
                    }
                }
            }
        }
        (jet, sizes)
    }
}

impl PeriodicKernel<'_> {
    /// K and its first four derivatives, of regular modes.
    pub(super) fn long_jet(&self, to: usize, from: usize, t: f64) -> [f64; 5] {
        let t = if t > 0.0 { t } else { t + self.period };
        let mut jet = [0.0; 5];
        for (mode, sum) in self.modes.iter().zip(&self.sums) {
            let Sum::Regular { sum, .. } = *sum else { continue };
            let (row, column) = (mode.rows[to], mode.columns[from]);
            let mut motion = mode.turn.product(mode.flight(t), sum);
            for entry in &mut jet {
                *entry += pair(mode.turn, row, motion, column);
                motion = mode.turn.product(motion, mode.generator());
            }
        }
        jet
    }

    /// Bounds of |K⁽ᵐ⁾| for m = 0 … 5 on the whole period, of modes that do not grow.
    pub(super) fn bounds(&self, to: usize, from: usize) -> [f64; 6] {
        let mut bounds = [0.0; 6];
        for (mode, sum) in self.modes.iter().zip(&self.sums) {
            let Sum::Regular { sum, .. } = *sum else { continue };
            let (row, column) = (mode.rows[to], mode.columns[from]);
            let mut motion = sum;
            for bound in &mut bounds {
                // Of J(a + bJ) the length of (a, b) times at most this; e^{At} is no longer than 1, or than 1 + κt of a double pole.
                let flight = match mode.turn {
                    Turn::Circular => 1.0,
                    Turn::Hyperbolic => std::f64::consts::SQRT_2,
                    Turn::Parabolic => 1.0 + mode.rate / mode.decay,
                };
                let size = match mode.turn {
                    Turn::Circular => motion.even.hypot(motion.odd),
                    _ => motion.even.abs() + motion.odd.abs(),
                };
                *bound += flight * size * row[0].hypot(row[1]) * column[0].hypot(column[1]);
                motion = mode.turn.product(motion, mode.generator());
            }
        }
        bounds
    }
}

/// k of a rigid mode and its first three derivatives at 0 ≤ t ≤ T. (Its rows are [φ, 0], its columns [0, φ/κ].)
pub(super) fn rigid_jet(mode: &LinearMode, period: f64, t: f64) -> [f64; 4] {
    let (part, dashpot) = (t / period, 2.0 * mode.decay);
    if dashpot == 0.0 {
        return [0.5 * t * (1.0 - part), 0.5 - part, -period.recip(), 0.0];
    }
    let dying = (-dashpot * t).exp() / -(-dashpot * period).exp_m1();
    let speed = dying - (dashpot * period).recip();
    [(0.5 - part - dying) / dashpot, speed, -dashpot * dying, dashpot * dashpot * dying]
}

/// 1 − e^{AT} as a + bJ, without cancellation next to a resonance.
fn one_less(mode: &LinearMode, period: f64) -> Turned {
    let (decay, angle) = (-mode.decay * period, mode.rate * period);
    match mode.turn {
        Turn::Circular => {
            let half = (0.5 * angle).sin();
            Turned { even: 2.0 * half * half - decay.exp_m1() * angle.cos(), odd: -decay.exp() * angle.sin() }
        }
        Turn::Hyperbolic => {
            let [slow, fast] = [decay + angle, decay - angle].map(|x| -x.exp_m1());
            Turned { even: 0.5 * (slow + fast), odd: 0.5 * (slow - fast) }
        }
        Turn::Parabolic => Turned { even: -decay.exp_m1(), odd: -decay.exp() * angle },
    }
}

/// row·(a + bJ)·column
pub(super) fn pair(turn: Turn, row: [f64; 2], by: Turned, column: [f64; 2]) -> f64 {
    by.even * (row[0] * column[0] + row[1] * column[1])
        + by.odd * (row[0] * column[1] - turn.sign() * row[1] * column[0])
}

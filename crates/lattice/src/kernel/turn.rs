//! The flow of one mode: two real coordinates and one commuting algebra.
//!
//! A pair of poles λ = −δ ± κ√(−σ) has the generator A = −δ + κJ with J² = −σ. σ = 1 turns (two complex poles), σ = −1 stretches
//! (two real ones), σ = 0 shears (one double pole: a rigid mode, or critical damping). Flights e^{At}, their sums over periods and
//! products of these are all of the form a + bJ. So no formula divides by the distance of the two poles, and critical damping needs
//! no case of its own but σ = 0.

use rustfft::num_complex::Complex;
use smallvec::SmallVec;
use std::ops::{Add, Mul};
use wide::f64x4;

use crate::simd::sines::{MOST, sin_cos as sines};
use crate::simd::small::sine_over;

type C = Complex<f64>;

/// How the two coordinates of a mode move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turn {
    /// Two complex poles.
    Circular,
    /// Two real poles.
    Hyperbolic,
    /// One double pole.
    Parabolic,
}

/// What displacement and velocity of q″ + 2δq′ + Ω²q = 0 are after a time, of those before it: `[[q←q, q←q′], [q′←q, q′←q′]]`.
pub fn oscillator_flight(frequency: f64, decay: f64, t: f64) -> [[f64; 2]; 2] {
    if decay == 0.0 {
        let phase = frequency * t;
        return [[phase.cos(), sine_over(frequency, t)], [-frequency * phase.sin(), phase.cos()]];
    }
    let flow = ModeFlow::oscillator(frequency, decay);
    let Turned { even, odd } = flow.turn.flight(decay, flow.rate, t);
    // x′ = −δx + κy
    let over = odd / flow.rate;
    [[even + decay * over, over], [-frequency * frequency * over, even - decay * over]]
}

/// How the coordinates of a mode move, e^{(−δ + κJ)t}.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeFlow {
    /// J
    pub turn: Turn,
    /// δ
    pub decay: f64,
    /// κ
    pub rate: f64,
}

impl ModeFlow {
    /// That of q″ + 2δq′ + Ω²q, the first coordinate being q.
    pub fn oscillator(frequency: f64, decay: f64) -> Self {
        // By both factors, so that a mode next to critical keeps its digits.
        let square = (frequency - decay.abs()) * (frequency + decay.abs());
        let (turn, rate) = match square {
            0.0 => (Turn::Parabolic, if decay == 0.0 { 1.0 } else { decay.abs() }),
            above if above > 0.0 => (Turn::Circular, above.sqrt()),
            below => (Turn::Hyperbolic, (-below).sqrt()),
        };
        Self { turn, decay, rate }
    }

    /// The same with time counted in a unit.
    pub fn counted_in(self, unit: f64) -> Self {
        Self { turn: self.turn, decay: self.decay * unit, rate: self.rate * unit }
    }
}

impl Turn {
    /// σ = −J²
    #[inline]
    pub fn sign(self) -> f64 {
        match self {
            Self::Circular => 1.0,
            Self::Hyperbolic => -1.0,
            Self::Parabolic => 0.0,
        }
    }

    /// √(−σ), the eigenvalue of J that belongs to the first pole.
    #[inline]
    pub fn root(self) -> C {
        match self {
            Self::Circular => C::new(0.0, 1.0),
            Self::Hyperbolic => C::new(1.0, 0.0),
            Self::Parabolic => C::default(),
        }
    }

    /// The product of two numbers a + bJ.
    pub fn product<T>(self, first: Turned<T>, second: Turned<T>) -> Turned<T>
    where
        T: Copy + Mul<Output = T> + Add<Output = T> + Mul<f64, Output = T>,
    {
        Turned {
            even: first.even * second.even + first.odd * second.odd * -self.sign(),
            odd: first.even * second.odd + first.odd * second.even,
        }
    }

    /// e^{(−δ + κJ)t}
    pub fn flight(self, decay: f64, rate: f64, t: f64) -> Turned {
        let (even, odd) = match self {
            Self::Circular => {
                let (sin, cos) = (rate * t).sin_cos();
                (cos, sin)
            }
            Self::Hyperbolic => ((rate * t).cosh(), (rate * t).sinh()),
            Self::Parabolic => (1.0, rate * t),
        };
        // Of a mode without damping the bits stay what they are.
        let decayed = if decay == 0.0 { 1.0 } else { (-decay * t).exp() };
        if self == Self::Hyperbolic {
            // By the two exponentials: cosh and sinh of an overdamped mode may overflow where its flight does not.
            let (slow, fast) = (((rate - decay) * t).exp(), ((-rate - decay) * t).exp());
            let odd = if rate * t.abs() < 0.5 { decayed * odd } else { 0.5 * (slow - fast) };
            return Turned { even: 0.5 * (slow + fast), odd };
        }
        Turned { even: decayed * even, odd: decayed * odd }
    }

    /// e^{(−δ + κJ)t} − 1, which keeps its digits however short t is.
    pub fn increment(self, decay: f64, rate: f64, t: f64) -> Turned {
        let fall = (-decay * t).exp_m1();
        match self {
            Self::Circular => {
                let (sin, cos) = (0.5 * rate * t).sin_cos();
                Turned { even: fall * (1.0 - 2.0 * sin * sin) - 2.0 * sin * sin, odd: (1.0 + fall) * 2.0 * sin * cos }
            }
            Self::Hyperbolic => {
                let [slow, fast] = [rate - decay, -rate - decay].map(|rate| (rate * t).exp_m1());
                Turned { even: 0.5 * (slow + fast), odd: self.flight(decay, rate, t).odd }
            }
            Self::Parabolic => Turned { even: fall, odd: (1.0 + fall) * rate * t },
        }
    }

    /// e^{κJt} at four times, where the coordinates turn: without what they lose. `None` of others.
    pub fn turns(self, rate: f64, times: [f64; 4]) -> Option<[[f64; 4]; 2]> {
        if self != Self::Circular {
            return None;
        }
        let angles = times.map(|t| rate * t);
        if angles.iter().all(|angle| angle.abs() <= MOST) {
            let [sin, cos] = sines(f64x4::from(angles)).map(f64x4::to_array);
            return Some([cos, sin]);
        }
        let both = angles.map(f64::sin_cos);
        Some([both.map(|(_, cos)| cos), both.map(|(sin, _)| sin)])
    }

    /// e^{(−δ + κJ)t} of modes, by their turns and rates δ, κ, over one time: four at a time where their coordinates turn.
    pub fn flights(modes: impl Iterator<Item = ModeFlow>, t: f64) -> SmallVec<[Turned; 16]> {
        let modes: SmallVec<[ModeFlow; 16]> = modes.collect();
        let mut flights = SmallVec::with_capacity(modes.len());
        // Many modes of a structure often lose alike.
        let (mut known, mut left) = (0.0, 1.0);
        for modes in modes.chunks(4) {
            let angle = |mode: &ModeFlow| if mode.turn == Self::Circular { mode.rate * t } else { 0.0 };
            let angles = std::array::from_fn(|i| modes.get(i).map_or(0.0, angle));
            let [cos, sin] = Self::Circular.turns(1.0, angles).unwrap_or_default();
            for (i, &ModeFlow { turn, decay, rate }) in modes.iter().enumerate() {
                if turn != Self::Circular {
                    flights.push(turn.flight(decay, rate, t));
                    continue;
                }
                if decay != known {
                    (known, left) = (decay, (-decay * t).exp());
                }
                flights.push(Turned { even: left * cos[i], odd: left * sin[i] });
            }
        }
        flights
    }

    /// row·(a + bJ)·column
    #[inline]
    pub fn pair<T>(self, row: [f64; 2], by: Turned<T>, column: [f64; 2]) -> T
    where
        T: Copy + Mul<f64, Output = T> + Add<Output = T>,
    {
        by.even * (row[0] * column[0] + row[1] * column[1])
            + by.odd * (row[0] * column[1] - self.sign() * row[1] * column[0])
    }

    /// (a + bJ)·column
    pub fn act<T>(self, by: Turned<T>, column: [T; 2]) -> [T; 2]
    where
        T: Copy + Mul<Output = T> + Add<Output = T> + Mul<f64, Output = T>,
    {
        [by.even * column[0] + by.odd * column[1], by.even * column[1] + by.odd * column[0] * -self.sign()]
    }
}

/// A number a + bJ.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Turned<T = f64> {
    /// a
    pub even: T,
    /// b
    pub odd: T,
}

impl Turned {
    /// The eigenvalues a ± b√(−σ): of a flight the two factors e^{λt}.
    #[inline]
    pub fn eigenvalues(self, turn: Turn) -> [C; 2] {
        let along = turn.root() * self.odd;
        [along + self.even, -along + self.even]
    }

    /// (z − R)⁻¹ for R = a + bJ, by its two poles: the determinant is a product of distances.
    pub fn resolvent(self, turn: Turn, z: C) -> Turned<C> {
        let [first, second] = self.eigenvalues(turn).map(|pole| (z - pole).inv());
        let scale = first * second;
        Turned { even: (z - self.even) * scale, odd: scale * self.odd }
    }

    /// The same number with complex parts.
    pub fn complex(self) -> Turned<C> {
        Turned { even: C::new(self.even, 0.0), odd: C::new(self.odd, 0.0) }
    }
}

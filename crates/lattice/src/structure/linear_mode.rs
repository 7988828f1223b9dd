//! One mode of a structure: two real coordinates ξ with ξ′ = Aξ + what impulses and loads give, A = −δ + κJ ([`Turn`]).

use rustfft::num_complex::Complex;
use smallvec::{SmallVec, smallvec};

use crate::kernel::turn::{ModeFlow, Turn, Turned};

type C = Complex<f64>;

/// Poles this close, against their size, are equal.
pub(super) const ALIKE: f64 = 1e-13;

/// A pair of poles of (λ²M + λC + K)⁻¹.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearMode {
    /// How its coordinates move.
    pub turn: Turn,
    /// δ, the rate at which it dies; below 0 it grows.
    pub decay: f64,
    /// κ
    pub rate: f64,
    /// What each contact sees of ξ.
    pub rows: SmallVec<[[f64; 2]; 1]>,
    /// What a unit impulse at each contact adds to ξ.
    pub columns: SmallVec<[[f64; 2]; 1]>,
    /// What each coordinate sees of ξ; empty where these are not asked for.
    pub coordinates: Vec<[f64; 2]>,
    /// What the static load adds to ξ in a unit of time.
    pub still: [f64; 2],
    /// What the loads of each harmonic add, with their phases: Re of it times e^{ijω(t+ψ)}.
    pub loads: Vec<[C; 2]>,
    /// It is an oscillator of real shape: contacts see the first coordinate, impulses change the second.
    pub is_real: bool,
    /// Bounds of the errors of these numbers.
    pub errors: ModeErrors,
}

/// How far the numbers of a mode may be from those of the matrices that it was made of. A list without entries: they are as given.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ModeErrors {
    /// Of either pole λ.
    pub poles: f64,
    /// Of what each contact sees of ξ.
    pub rows: SmallVec<[f64; 2]>,
    /// Of what a unit impulse at each contact adds to ξ.
    pub columns: SmallVec<[f64; 2]>,
    /// Of what the static load adds.
    pub still: f64,
    /// Of what the loads of each harmonic add.
    pub loads: Vec<f64>,
}

impl ModeErrors {
    /// Of numbers that are right up to the rounding of a root, a product and a quotient.
    fn of_rounding(mode: &LinearMode) -> Self {
        const UNIT: f64 = 2.0 * f64::EPSILON;
        let length = |list: &[f64; 2]| list[0].hypot(list[1]);
        Self {
            poles: UNIT * (mode.decay.abs() + mode.rate),
            rows: smallvec![0.0; mode.rows.len()],
            columns: mode.columns.iter().map(|column| UNIT * length(column)).collect(),
            still: UNIT * length(&mode.still),
            loads: mode.loads.iter().map(|load| UNIT * load.iter().map(|load| load.norm()).sum::<f64>()).collect(),
        }
    }
}

/// The shape φ of a mode as it is asked for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ModeShape<T> {
    /// wᵀφ at each contact.
    pub contacts: Vec<T>,
    /// φ itself; may be left out.
    pub coordinates: Vec<T>,
    /// φᵀs of the static load.
    pub still: T,
}

impl LinearMode {
    /// q″ + 2δq′ + (δ² + ν²)q of real shape with φᵀMφ = 1, `square` being ν²; `loads` are φᵀf of each harmonic. A rigid mode has δ = 0 and
    /// ν² = 0, one with a dashpot c of its own δ = c/2 and ν² = −c²/4.
    pub fn oscillator(decay: f64, square: f64, shape: &ModeShape<f64>, loads: &[C]) -> Self {
        Self::exact_oscillator(decay, square, shape, loads).with_rounding()
    }

    /// The same without bounds of errors.
    pub(super) fn exact_oscillator(decay: f64, square: f64, shape: &ModeShape<f64>, loads: &[C]) -> Self {
        let (turn, rate) = if square > 0.0 {
            (Turn::Circular, square.sqrt())
        } else if square < 0.0 {
            (Turn::Hyperbolic, (-square).sqrt())
        } else {
            // Any scale serves where both poles are one.
            (Turn::Parabolic, if decay == 0.0 { 1.0 } else { decay.abs() })
        };
        let seen = |shape: &f64| [*shape, 0.0];
        Self {
            turn,
            decay,
            rate,
            rows: shape.contacts.iter().map(seen).collect(),
            columns: shape.contacts.iter().map(|shape| [0.0, shape / rate]).collect(),
            coordinates: shape.coordinates.iter().map(seen).collect(),
            still: [0.0, shape.still / rate],
            loads: loads.iter().map(|load| [C::default(), load / rate]).collect(),
            is_real: true,
            errors: ModeErrors::default(),
        }
    }

    /// A complex pole λ and its conjugate, φᵀ(2λM + C)φ = 1: φφᵀ is the residue there. `loads` are (Re φ)ᵀf and (Im φ)ᵀf.
    pub fn pole(rate: C, shape: &ModeShape<C>, loads: &[[C; 2]]) -> Self {
        // The complex amplitude ξ, as (Re ξ, −Im ξ).
        let seen = |shape: &C| [2.0 * shape.re, 2.0 * shape.im];
        let given = |shape: C| [shape.re, -shape.im];
        let mode = Self {
            turn: Turn::Circular,
            decay: -rate.re,
            rate: rate.im,
            rows: shape.contacts.iter().map(seen).collect(),
            columns: shape.contacts.iter().copied().map(given).collect(),
            coordinates: shape.coordinates.iter().map(seen).collect(),
            still: given(shape.still),
            loads: loads.iter().map(|[real, imaginary]| [*real, -*imaginary]).collect(),
            is_real: false,
            errors: ModeErrors::default(),
        };
        mode.with_rounding()
    }

    /// Two real poles, each with the sign of its residue: sign·φφᵀ. `loads` are φᵀf of both.
    pub fn real_poles(rates: [f64; 2], signs: [f64; 2], shapes: [&ModeShape<f64>; 2], loads: &[[C; 2]]) -> Self {
        let root = 0.5f64.sqrt();
        let seen = |lists: [&[f64]; 2]| -> Vec<[f64; 2]> {
            lists[0].iter().zip(lists[1]).map(|(a, b)| [(a + b) * root, (a - b) * root]).collect()
        };
        let given = |a: f64, b: f64| {
            let (a, b) = (signs[0] * a, signs[1] * b);
            [(a + b) * root, (a - b) * root]
        };
        let [contacts, coordinates] =
            [|shape: &ModeShape<f64>| shape.contacts.clone(), |shape: &ModeShape<f64>| shape.coordinates.clone()]
                .map(|list| shapes.map(list));
        let mode = Self {
            turn: Turn::Hyperbolic,
            decay: -0.5 * (rates[0] + rates[1]),
            rate: 0.5 * (rates[0] - rates[1]),
            rows: seen([&contacts[0], &contacts[1]]).into(),
            columns: contacts[0].iter().zip(&contacts[1]).map(|(a, b)| given(*a, *b)).collect(),
            coordinates: seen([&coordinates[0], &coordinates[1]]),
            still: given(shapes[0].still, shapes[1].still),
            loads: (loads.iter())
                .map(|[a, b]| {
                    let (a, b) = (a * signs[0], b * signs[1]);
                    [(a + b) * root, (a - b) * root]
                })
                .collect(),
            is_real: false,
            errors: ModeErrors::default(),
        };
        mode.with_rounding()
    }

    fn with_rounding(mut self) -> Self {
        self.errors = ModeErrors::of_rounding(&self);
        self
    }

    /// ξ of an oscillator where φᵀMq = `at` and φᵀMq′ = `moving`.
    pub(super) fn amplitudes(&self, at: f64, moving: f64) -> [f64; 2] {
        [at, (moving + self.decay * at) / self.rate]
    }

    /// How its coordinates move.
    pub fn flow(&self) -> ModeFlow {
        ModeFlow { turn: self.turn, decay: self.decay, rate: self.rate }
    }

    /// A bound of the error of what one contact sees times what another gives, per size of the number between them.
    pub fn errors_between(&self, to: usize, from: usize) -> f64 {
        let size = |[x, y]: [f64; 2]| (x * x + y * y).sqrt();
        let [seen, given] =
            [(&self.errors.rows, to), (&self.errors.columns, from)].map(|(list, contact)| list[contact]);
        seen * (size(self.columns[from]) + given) + size(self.rows[to]) * given
    }

    /// e^{At}
    pub fn flight(&self, t: f64) -> Turned {
        self.turn.flight(self.decay, self.rate, t)
    }

    /// e^{At} − 1, which keeps its digits however short t is.
    pub fn increment(&self, t: f64) -> Turned {
        self.turn.increment(self.decay, self.rate, t)
    }

    /// A
    pub fn generator(&self) -> Turned {
        Turned { even: -self.decay, odd: self.rate }
    }

    /// The poles λ.
    pub fn rates(&self) -> [C; 2] {
        self.generator().eigenvalues(self.turn)
    }

    /// The same mode with its dashpot times `factor`, if it is an oscillator.
    pub fn damped_times(&self, factor: f64) -> Self {
        if !self.is_real {
            return self.clone();
        }
        let given = |columns: &[[f64; 2]]| columns.iter().map(|column| column[1] * self.rate).collect::<Vec<_>>();
        let seen = |rows: &[[f64; 2]]| rows.iter().map(|row| row[0]).collect::<Vec<_>>();
        let shape = ModeShape {
            contacts: given(&self.columns),
            coordinates: seen(&self.coordinates),
            still: self.still[1] * self.rate,
        };
        let square = self.turn.sign() * self.rate * self.rate + self.decay * self.decay;
        let decay = self.decay * factor;
        let loads: Vec<C> = self.loads.iter().map(|load| load[1] * self.rate).collect();
        let mut mode = Self::oscillator(decay, square - decay * decay, &shape, &loads);
        // Of Ω² = κ² + δ², and of ν² = Ω² − δ² with it.
        let of_square = 2.0 * (self.rate + self.decay.abs()) * self.errors.poles
            + 2.0 * f64::EPSILON * (square.abs() + decay * decay);
        let of_rate = (of_square / mode.rate).min(of_square.sqrt());
        mode.errors.poles += of_rate + factor.abs() * self.errors.poles;
        mode.errors.rows.clone_from(&self.errors.rows);
        let (part, scale) = (of_rate / mode.rate, self.rate / mode.rate);
        let moved = |own: &mut f64, before: f64, value: f64| *own += before * scale + part * value;
        for (k, own) in mode.errors.columns.iter_mut().enumerate() {
            moved(own, self.errors.columns[k], mode.columns[k][1].abs());
        }
        moved(&mut mode.errors.still, self.errors.still, mode.still[1].abs());
        for (k, own) in mode.errors.loads.iter_mut().enumerate() {
            moved(own, self.errors.loads[k], mode.loads[k][1].norm());
        }
        mode
    }

    /// Whether another oscillator has the same poles, to the rounding of eigenvalues.
    pub fn is_alike(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= ALIKE * (self.decay.abs() + self.rate);
        self.is_real
            && other.is_real
            && self.turn == other.turn
            && near(self.decay, other.decay)
            && near(self.rate, other.rate)
    }

    /// The frequency at which a harmonic drives the mode without bound; `None` where something damps it, or it does not swing.
    pub fn resonant_frequency(&self) -> Option<f64> {
        (self.decay == 0.0 && self.turn == Turn::Circular).then_some(self.rate)
    }

    /// Whether a pole is 0: nothing holds the mode in its place.
    pub fn is_rigid(&self) -> bool {
        match self.turn {
            Turn::Circular => self.decay == 0.0 && self.rate == 0.0,
            Turn::Hyperbolic => self.decay.abs() == self.rate.abs(),
            Turn::Parabolic => self.decay == 0.0,
        }
    }

    /// The coordinates, complex, under a load `given`·e^{iwt}: (iw − A)⁻¹·given. Not finite at a resonance.
    pub fn steady(&self, w: f64, given: [C; 2]) -> [C; 2] {
        let by = self.generator().resolvent(self.turn, C::new(0.0, w));
        self.turn.act(by, given)
    }
}

//! The kernel of any list of modes.

use std::f64::consts::SQRT_2;

use rustfft::num_complex::Complex;

use super::coordinates::Coordinates;
use super::turn::{Turn, Turned};
use crate::structure::linear_mode::LinearMode;

type C = Complex<f64>;

/// One mode between contacts: how it moves, and what each contact sees of it and gives to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlochMode {
    /// How its coordinates move.
    pub coordinates: Coordinates,
    /// δ, the rate at which it dies.
    pub decay: f64,
    /// κ: the frequency of a mode that swings, half the distance of two real poles, the inverse of the period for a double pole.
    pub rate: f64,
    /// The flight over one period, R = e^{AT}.
    pub period: Turned,
    /// Error of the larger pole e^{λT}.
    pub pole_error: f64,
    /// Error of the rates λ beyond rounding.
    pub rate_error: f64,
    /// Error of its shape at any contact beyond rounding.
    pub shape_error: f64,
}

impl BlochMode {
    /// The poles λ of the impulse response.
    #[inline]
    pub fn rates(&self) -> [C; 2] {
        self.coordinates.eigenvalues(self.generator())
    }

    /// The poles e^{λT} of the kernel in z.
    #[inline]
    pub fn poles(&self) -> [C; 2] {
        self.coordinates.eigenvalues(self.period)
    }

    /// Errors of the poles e^{λT}.
    #[inline]
    pub fn pole_errors(&self) -> [f64; 2] {
        match self.coordinates {
            Coordinates::Shared(_) => [self.pole_error; 2],
            // The faster one is as well known, to its size.
            Coordinates::Apart if self.period.even == 0.0 => [0.0; 2],
            Coordinates::Apart => [self.pole_error, self.pole_error * (self.period.odd / self.period.even)],
        }
    }

    /// e^{At}
    pub fn flight(&self, t: f64) -> Turned {
        self.coordinates.flight(self.decay, self.rate, t)
    }

    /// e^{At} and e^{−At}
    pub fn flights(&self, t: f64) -> [Turned; 2] {
        let forth = self.flight(t);
        let turns_alone = self.decay == 0.0 && self.coordinates.are_circular();
        [forth, if turns_alone { Turned { even: forth.even, odd: -forth.odd } } else { self.flight(-t) }]
    }

    /// Numbers as long as e^{At} and e^{−At}: those of a mode that swings need no sine.
    pub fn flight_sizes(&self, t: f64) -> [Turned; 2] {
        if !self.coordinates.are_circular() {
            return self.flights(t);
        }
        let size = if self.decay == 0.0 { 1.0 } else { (-self.decay * t).exp() };
        [size, size.recip()].map(|even| Turned { even, odd: 0.0 })
    }

    /// A = −δ + κJ
    pub fn generator(&self) -> Turned {
        self.coordinates.generator(self.decay, self.rate)
    }

    /// Takes the error of its rates beyond what a root rounds.
    fn know(&mut self, rate_error: f64, period: f64) {
        // Most modes are known as well as that, and moduli take their time.
        if rate_error == 0.0 {
            return;
        }
        let size = self.poles().map(|pole| pole.norm_sqr()).into_iter().fold(0.0, f64::max).sqrt();
        self.rate_error += rate_error;
        self.pole_error += size * (rate_error * period).exp_m1();
    }
}

/// What rounding alone makes of a shape, relative.
const ROUNDED: f64 = 2.0 * f64::EPSILON;

/// What a contact sees of a mode and gives to it, in the mode's own coordinates.
type Sight = [[f64; 2]; 2];

/// K^z and its first three derivatives in t, and what they change by with z.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BlochJet {
    /// K, K′, K″, K‴
    pub kernel: [C; 4],
    /// The same, differentiated by z.
    pub slope: [C; 4],
}

/// The kernel K^z between contacts, for one period; dimensionless.
///
/// ```
/// use vibrochain_lattice::{BlochKernel, Complex};
/// // One mass on a spring that a dashpot damps, hit once a period, by z⁻¹ of the impulse a period earlier.
/// let (frequency, damping, period) = (1.3, 0.2, 4.0);
/// let mut kernel = BlochKernel::new(period, 1);
/// kernel.push_oscillator(frequency, damping, &[1.0]);
/// let (t, z) = (1.1, Complex::new(0.9, 0.4));
/// let jet = kernel.jet(0, 0, t, z);
/// let swing = frequency * (1.0 - damping * damping as f64).sqrt();
/// let answer = |t: f64| (-damping * frequency * t).exp() * (swing * t).sin() / swing;
/// let sum: Complex<f64> = (0..400).map(|n| z.powi(-n) * answer(t + period * f64::from(n))).sum();
/// assert!((jet.kernel[0] - sum).norm() < 1e-14);
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BlochKernel {
    period: f64,
    contacts: usize,
    modes: Vec<BlochMode>,
    /// What a contact sees of a mode's two coordinates, and what a unit impulse at it gives them: [mode][contact]
    rows: Vec<[f64; 2]>,
    columns: Vec<[f64; 2]>,
    /// Errors of the lengths of both beyond rounding and what the modes tell; empty where there are none.
    doubts: Vec<[f64; 2]>,
}

impl BlochKernel {
    /// A kernel between so many contacts, without modes yet.
    pub fn new(period: f64, contacts: usize) -> Self {
        Self { period, contacts, ..Self::default() }
    }

    /// The same with room for so many modes.
    pub(super) fn with_room(period: f64, contacts: usize, modes: usize) -> Self {
        let [rows, columns] = [(); 2].map(|()| Vec::with_capacity(contacts * modes));
        Self { period, contacts, modes: Vec::with_capacity(modes), rows, columns, doubts: Vec::new() }
    }

    /// Adds an oscillator q″ + 2ζΩq′ + Ω²q of real shape: `shapes` are w_iᵀφ at the contacts, φᵀMφ = 1. ζ may be anything, below 0,
    /// 1 and beyond; Ω = 0 is a rigid mode, whose kernel is infinite at z = 1 alone.
    pub fn push_oscillator(&mut self, frequency: f64, damping: f64, shapes: &[f64]) {
        let square = frequency * frequency * (1.0 - damping) * (1.0 + damping);
        self.push_decaying(damping * frequency, square, shapes);
    }

    /// The same by rates: poles λ = −δ ± √(−ν²), `square` being ν². A rigid mode with a dashpot c has δ = c/2, ν² = −c²/4.
    pub fn push_decaying(&mut self, decay: f64, square: f64, shapes: &[f64]) {
        let (turn, rate) = if square > 0.0 {
            (Turn::Circular, square.sqrt())
        } else if square < 0.0 {
            (Turn::Hyperbolic, (-square).sqrt())
        } else {
            (Turn::Parabolic, self.period.recip())
        };
        let sight = |shape: &f64| [[*shape, 0.0], [0.0, shape / rate]];
        self.push(turn, (decay, rate), shapes.iter().map(sight));
    }

    /// The kernel of modes of a structure between some of its contacts.
    pub fn of_modes(modes: &[LinearMode], period: f64, contacts: &[usize]) -> Self {
        let mut kernel = Self::with_room(period, contacts.len(), modes.len());
        kernel.doubts.reserve_exact(contacts.len() * modes.len());
        for mode in modes {
            let sights = contacts.iter().map(|&contact| [mode.rows[contact], mode.columns[contact]]);
            kernel.push(mode.turn, (mode.decay, mode.rate), sights);
            if let Some(last) = kernel.modes.last_mut() {
                let known = f64::EPSILON * (mode.decay.abs() + mode.rate);
                last.know((mode.errors.poles - known).max(0.0), period);
            }
            let errors = contacts.iter().map(|&contact| [mode.errors.rows[contact], mode.errors.columns[contact]]);
            kernel.doubts.extend(errors);
        }
        kernel
    }

    fn push(&mut self, turn: Turn, (decay, rate): (f64, f64), sights: impl Iterator<Item = Sight>) {
        let coordinates = Coordinates::of(turn, rate, self.period);
        let period = coordinates.flight(decay, rate, self.period);
        // The exponent carries a relative error of 2ε.
        let slowest = if turn == Turn::Hyperbolic { rate - decay } else { -decay };
        let pole_error =
            f64::EPSILON * (2.0 + 2.0 * (decay.abs() + rate) * self.period) * (slowest * self.period).exp();
        let mode = BlochMode { coordinates, decay, rate, period, pole_error, rate_error: 0.0, shape_error: 0.0 };
        self.add(mode, sights);
    }

    fn add(&mut self, mode: BlochMode, sights: impl Iterator<Item = Sight>) {
        self.modes.push(mode);
        for [row, column] in sights.take(self.contacts) {
            let [row, column] = mode.coordinates.told(row, column);
            self.rows.push(row);
            self.columns.push(column);
        }
    }

    /// Adds a mode of another kernel.
    pub(super) fn push_again(&mut self, of: &Self, k: usize) {
        let own = k * of.contacts..(k + 1) * of.contacts;
        let doubts = of.doubts.get(own.clone()).unwrap_or_default();
        let sights = of.rows[own.clone()].iter().zip(&of.columns[own]).map(|(row, column)| [*row, *column]);
        self.push_told(of.modes[k], sights);
        let from = self.doubts.len() - self.contacts;
        self.doubts[from..].iter_mut().zip(doubts).for_each(|(own, doubt)| *own = *doubt);
    }

    /// Adds a mode whose sights are in its own coordinates, and all of whose errors it tells itself.
    pub(super) fn push_told(&mut self, mode: BlochMode, sights: impl Iterator<Item = Sight>) {
        self.modes.push(mode);
        for [row, column] in sights.take(self.contacts) {
            self.rows.push(row);
            self.columns.push(column);
        }
        self.doubts.resize(self.rows.len(), [0.0; 2]);
    }

    /// The same of a period that is known up to a part of it alone, as that of a self-excited orbit is: rates are known no better.
    pub fn of_uncertain_period(mut self, part: f64) -> Self {
        for mode in &mut self.modes {
            mode.know(part * (mode.decay.abs() + mode.rate), self.period);
        }
        self
    }

    /// The period T.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Number of contacts.
    pub fn contacts(&self) -> usize {
        self.contacts
    }

    /// The modes, as they were added.
    pub fn modes(&self) -> &[BlochMode] {
        &self.modes
    }

    /// What a contact sees of the two coordinates of mode `k`.
    pub fn row(&self, k: usize, contact: usize) -> [f64; 2] {
        self.rows[k * self.contacts + contact]
    }

    /// What a unit impulse at a contact gives to the two coordinates of mode `k`.
    pub fn column(&self, k: usize, contact: usize) -> [f64; 2] {
        self.columns[k * self.contacts + contact]
    }

    /// Errors of [`Self::row`] and [`Self::column`], as [`Coordinates::carried`] has them.
    pub fn shape_errors(&self, k: usize, contact: usize) -> [[f64; 2]; 2] {
        let at = k * self.contacts + contact;
        let coordinates = self.modes[k].coordinates;
        let [row, column] = coordinates.doubts(self.doubt(k, contact));
        let rounded = |error, entries| coordinates.with_part(error, ROUNDED, entries);
        [rounded(row, self.rows[at]), rounded(column, self.columns[at])]
    }

    /// Errors of the lengths of what a contact sees and gives, beyond rounding.
    fn doubt(&self, k: usize, contact: usize) -> [f64; 2] {
        let BlochMode { shape_error, rate, .. } = self.modes[k];
        let [row, column] = self.doubts.get(k * self.contacts + contact).copied().unwrap_or_default();
        [shape_error + row, shape_error / rate + column]
    }

    /// Error of the shape of mode `k`, against the largest that a contact sees of it: of what contacts see and of what they give.
    pub fn shape_error(&self, k: usize) -> f64 {
        let own = k * self.contacts..(k + 1) * self.contacts;
        let largest = |table: &[[f64; 2]]| table.iter().flatten().fold(0.0f64, |most, x| most.max(x.abs()));
        let doubt = |which| (0..self.contacts).map(|contact| self.doubt(k, contact)[which]).fold(0.0f64, f64::max);
        let part = |size: f64, doubt: f64| if size == 0.0 { 0.0 } else { SQRT_2 * (doubt / size + ROUNDED) };
        part(largest(&self.rows[own.clone()]), doubt(0)) + part(largest(&self.columns[own.clone()]), doubt(1))
    }

    /// The velocity that a unit impulse at one contact gives to another, w_iᵀM⁻¹w_j: the inverse of the effective mass for i = j.
    pub fn mobility(&self, to: usize, from: usize) -> f64 {
        let of_mode = |k: usize| {
            let mode = &self.modes[k];
            mode.coordinates.pair(self.row(k, to), mode.generator(), self.column(k, from))
        };
        (0..self.modes.len()).map(of_mode).sum()
    }

    /// Error of [`Self::mobility`] by the shapes.
    pub fn mobility_error(&self, to: usize, from: usize) -> f64 {
        let of_mode = |k: usize| {
            let coordinates = self.modes[k].coordinates;
            let given = coordinates.given(self.modes[k].generator(), self.column(k, from));
            let [[seen, _], [_, error]] = [to, from].map(|contact| self.shape_errors(k, contact));
            let carried = coordinates.carried(error, self.modes[k].generator());
            coordinates.reach_error([self.row(k, to), seen], [given, carried])
        };
        (0..self.modes.len()).map(of_mode).sum()
    }

    /// K^z between two contacts at −T < t ≤ T: for t ≤ 0 the past impacts alone count, K^z(t+T)/z; so t = 0 is just before an impact.
    pub fn jet(&self, to: usize, from: usize, t: f64, z: Complex<f64>) -> BlochJet {
        let mut jet = BlochJet::default();
        for (k, mode) in self.modes.iter().enumerate() {
            let coordinates = mode.coordinates;
            let resolvent = coordinates.resolvent(mode.period, z);
            // Σ z⁻ⁿRⁿ = 1 + R(z−R)⁻¹ from n = 0, and (z−R)⁻¹ times a flight longer by T from n = 1.
            let squared = coordinates.product(resolvent, resolvent);
            let (flight, sum, slope) = if t > 0.0 {
                let past = coordinates.product(mode.period.complex(), resolvent);
                (mode.flight(t), coordinates.one_more(past), coordinates.product(mode.period.complex(), squared))
            } else {
                (mode.flight(t + self.period), resolvent, squared)
            };
            let (row, column) = (self.row(k, to), self.column(k, from));
            let mut flight = flight.complex();
            for order in 0..4 {
                jet.kernel[order] += coordinates.pair(row, coordinates.product(flight, sum), column);
                jet.slope[order] -= coordinates.pair(row, coordinates.product(flight, slope), column);
                flight = coordinates.product(flight, mode.generator().complex());
            }
        }
        jet
    }
}

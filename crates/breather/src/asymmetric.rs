//! Conservative double-sided breathers with φ ≠ T/2.
//!
//! Energy balance at the impacts asks for χ₃(φ) = 0. φ = T/2 always solves it, and alone if every mode is slower than the
//! breather; otherwise there can be more (`errata`: "orthogonality, hence φ = π/ω"). With δ = φ − T/2 they are the zeros
//! of
//!
//! ```text
//! s(δ) = −K₀′(φ) = Σ_k a_k sin(Ω_kδ)/Ω_k ,      a_k = b_k² Ω_k / (2 sin(Ω_kT/2)) ,
//! ```
//!
//! an odd function, so that δ > 0 is enough: −δ gives the mirror image in time.
//!
//! [`all`] finds every zero. A map asks only for those that can be physical, and has few of them: [`candidates`] first samples
//! s and the rise D = K₀(φ) − K₀(0) on a grid, and searches where s can vanish and D is not too small for the
//! bound on [`Radiation`].

use vibrochain_lattice::{ImpulseResponse, Model};
use wide::f64x4;

use crate::conservative::{double_sided_draft, impulses};
use crate::enclosure::Dual;
use crate::grid::{INTERVAL, turn};
use crate::lanes::{LANES, Lane, total};
use crate::orbit::Draft;
use crate::radiation::Radiation;
use crate::roots::{Enclosed, Zeros};

/// Orbits closer than this part of half a period to the symmetric one, which they branch from, are not told from it.
const APART: f64 = 1e-6;

/// Intervals at most; more would be hundreds of orbits, which the search then reports as not finished.
const MOST: usize = 4096;

/// s(δ), enclosed.
struct Balance<'a> {
    response: &'a ImpulseResponse,
    fourth: f64,
}

impl Enclosed for Balance<'_> {
    fn enclose(&self, delta: f64, radius: f64) -> Dual {
        let jet = self.response.jet_from_half(delta);
        Dual::from_jet([jet.slope, jet.curvature, jet.third, self.fourth], 0.0, radius)
    }
}

/// Ω of the fastest mode.
fn top(response: &ImpulseResponse) -> f64 {
    response.frequencies().last().copied().unwrap_or_default()
}

/// All of them.
pub(crate) fn all(model: &Model, response: &ImpulseResponse, zeros: &mut Zeros, found: impl FnMut(Draft)) {
    if top(response) < response.omega() {
        // Then Ω_kT/2 < π and every mode's sin Ω_kδ/sin Ω_kT/2 has the sign of δ: s ≠ 0 for δ ≠ 0.
        return;
    }
    let half = 0.5 * response.period();
    let pieces = 8 + (half * top(response)) as usize;
    search(response, zeros, (APART * half, half), pieces.min(MOST));
    drafts(model, response, zeros, found);
}

/// Those that can be physical, as far as `radiation` tells, in the places that `rises` has found.
pub(crate) fn candidates(
    model: &Model,
    response: &ImpulseResponse,
    rises: &Rises,
    zeros: &mut Zeros,
    found: impl FnMut(Draft),
) {
    for &(from, to) in &rises.places {
        search(response, zeros, (from.max(APART * 0.5 * response.period()), to), 1);
    }
    drafts(model, response, zeros, found);
}

/// Adds the zeros of s in a range of δ > 0 to `zeros`.
fn search(response: &ImpulseResponse, zeros: &mut Zeros, (from, to): (f64, f64), pieces: usize) {
    let balance = Balance { response, fourth: response.derivative_bounds()[3] };
    let shortest = APART * 0.5 * response.period();
    zeros.find(&balance, from, to, pieces, |delta: f64| 64.0 * f64::EPSILON * delta.max(shortest));
}

/// The orbits at the zeros of s and their mirror images.
fn drafts(model: &Model, response: &ImpulseResponse, zeros: &Zeros, mut found: impl FnMut(Draft)) {
    let half = 0.5 * response.period();
    for delta in zeros.simple.iter().flat_map(|&zero| [-zero, zero]) {
        let kernel = response.jet_from_half(delta).value;
        if let Some((impulses, displacement)) = impulses(model, response, kernel) {
            found(double_sided_draft(response, 0.0, half + delta, impulses, displacement));
        }
    }
}

/// Four modes on their way from δ = 0 to T/2: sin(Ωδ)/Ω, cos Ωδ and (1 − cos Ωδ)/Ω², and what a step does to them.
#[derive(Debug, Clone, Copy)]
struct Swing {
    amplitude: f64x4,
    frequency: f64x4,
    state: [f64x4; 3],
    turn: [f64x4; 3],
}

/// s, s′ and Σ a_k (1 − cos Ω_kδ)/Ω_k² = K₀(T/2) − K₀(φ) on a grid of δ from 0 to T/2, and the places where a physical orbit can be.
#[derive(Debug, Clone, Default)]
pub(crate) struct Rises {
    swings: Vec<Swing>,
    nodes: Vec<[f64; 3]>,
    /// Intervals of δ.
    places: Vec<(f64, f64)>,
}

impl Rises {
    /// Forgets the places.
    pub(crate) fn clear(&mut self) {
        self.places.clear();
    }

    /// Places that are left to be searched.
    pub(crate) fn places(&self) -> usize {
        self.places.len()
    }

    /// Finds the places of δ > 0 where neither s ≠ 0 nor the bound on radiation excludes a physical orbit.
    pub(crate) fn set(&mut self, response: &ImpulseResponse, radiation: &Radiation) {
        self.places.clear();
        let half = 0.5 * response.period();
        let intervals = ((half * top(response) / INTERVAL).ceil() as usize).max(4);
        if intervals > MOST {
            self.places.push((0.0, half));
            return;
        }
        let step = half / intervals as f64;
        let [second, third, size] = self.start(response, step);
        self.sample(intervals);
        // Cubics through values and slopes at both ends err by h⁴/384 times the fourth derivative; rounding adds up from step
        // to step.
        let quartic = step.powi(4) / 384.0;
        let rounding = 8.0 * f64::EPSILON * intervals as f64 * size;
        let (error, rise_error) = (quartic * third + rounding, quartic * second + rounding * half);
        let highest = self.nodes.last().map_or(0.0, |node| node[2]);
        for (i, ends) in self.nodes.windows(2).enumerate() {
            let [[s, slope, lift], [next, next_slope, next_lift]] = [ends[0], ends[1]];
            let third_of = step / 3.0;
            // In Bernstein's form a cubic stays within its coefficients.
            let cubic = [s, s + third_of * slope, next - third_of * next_slope, next];
            let least = cubic.iter().map(|b| b.abs()).fold(f64::INFINITY, f64::min);
            let no_zero = if i == 0 {
                // But for the one at δ = 0, next to which s′ keeps its sign.
                slope.abs() > 0.5 * second * step * step + rounding / step
            } else {
                least > error && cubic.iter().all(|b| (*b > 0.0) == (s > 0.0))
            };
            if no_zero {
                continue;
            }
            let (rise, next_rise) = (highest - lift, highest - next_lift);
            let cubic = [rise, rise - third_of * s, next_rise + third_of * next, next_rise];
            let most = cubic.into_iter().fold(f64::NEG_INFINITY, f64::max) + rise_error;
            let turns = |node: usize| 0.5 + 0.5 * node as f64 / intervals as f64;
            if most > 0.0 && most >= (1.0 - 1e-9) * radiation.least_rise(turns(i), turns(i + 1)) {
                let (from, to) = (i as f64 * step, if i + 1 == intervals { half } else { (i + 1) as f64 * step });
                match self.places.last_mut() {
                    Some(last) if last.1 == from => last.1 = to,
                    _ => self.places.push((from, to)),
                }
            }
        }
    }

    /// Puts the modes at δ = 0. Tells Σ|a|Ω², Σ|a|Ω³ and Σ|a|·T/2, the size of terms of s.
    fn start(&mut self, response: &ImpulseResponse, step: f64) -> [f64; 3] {
        let (frequencies, weights, sines) = (response.frequencies(), response.weights(), response.sin_half());
        let (mut second, mut third, mut size) = (f64x4::ZERO, f64x4::ZERO, f64x4::ZERO);
        self.swings.clear();
        for k in (0..frequencies.len()).step_by(LANES) {
            let (mut frequency, mut amplitude): (Lane, Lane) = ([0.0; LANES], [0.0; LANES]);
            for i in 0..LANES.min(frequencies.len() - k) {
                let rate = frequencies[k + i];
                frequency[i] = rate;
                // Ω/(2 sin ΩT/2) is 1/T for a rigid mode.
                let factor = if rate > 0.0 { 0.5 * rate / sines[k + i] } else { 1.0 / response.period() };
                amplitude[i] = weights[k + i] * factor;
            }
            let (frequency, amplitude) = (f64x4::from(frequency), f64x4::from(amplitude));
            let [cos, sin_over, _] = turn(frequency, f64x4::splat(step));
            // 1 − cos = sin²/(1 + cos)
            let lift = sin_over * sin_over / (f64x4::ONE + cos);
            let state = [f64x4::ZERO, f64x4::ONE, f64x4::ZERO];
            self.swings.push(Swing { amplitude, frequency, state, turn: [sin_over, cos, lift] });
            let term = amplitude.abs() * frequency * frequency;
            (second, third, size) = (second + term, third + term * frequency, size + amplitude.abs());
        }
        [total(second), total(third), total(size) * 0.5 * response.period()]
    }

    fn sample(&mut self, intervals: usize) {
        self.nodes.clear();
        for _ in 0..=intervals {
            let mut sums = [f64x4::ZERO; 3];
            for Swing { amplitude, frequency, state, turn } in &mut self.swings {
                let ([sin, cos, lift], [sin_step, cos_step, lift_step]) = (*state, *turn);
                for (sum, value) in sums.iter_mut().zip([sin, cos, lift]) {
                    *sum += *amplitude * value;
                }
                *state = [
                    sin * cos_step + cos * sin_step,
                    cos * cos_step - *frequency * *frequency * sin * sin_step,
                    lift + sin * sin_step + cos * lift_step,
                ];
            }
            self.nodes.push(sums.map(total));
        }
    }
}

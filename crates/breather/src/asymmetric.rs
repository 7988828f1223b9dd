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
    search(response, zeros, &[(0.0, half)], pieces.min(MOST));
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
    if rises.places.is_empty() {
        return;
    }
    search(response, zeros, &rises.places, 1);
    drafts(model, response, zeros, found);
}

/// Adds the zeros of s in intervals of δ > 0 to `zeros`, each of them in so many `pieces` to begin with.
fn search(response: &ImpulseResponse, zeros: &mut Zeros, places: &[(f64, f64)], pieces: usize) {
    let balance = Balance { response, fourth: response.derivative_bounds()[3] };
    let shortest = APART * 0.5 * response.period();
    let resolution = |delta: f64| 64.0 * f64::EPSILON * delta.max(shortest);
    for &(from, to) in places {
        zeros.find(&balance, from.max(shortest), to, pieces, resolution);
    }
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

/// How often an interval is halved before it is searched: the bound on radiation then knows φ to a hundredth of a radian of
/// the fastest mode, for less than one more sample would cost.
const HALVINGS: u32 = 6;

/// s and D on an interval as cubics in Bernstein's form, within whose coefficients they stay.
#[derive(Debug, Clone, Copy)]
struct Piece {
    from: f64,
    to: f64,
    s: [f64; 4],
    rise: [f64; 4],
}

impl Piece {
    fn halves(&self) -> [Self; 2] {
        let middle = 0.5 * (self.from + self.to);
        let ([s, s_after], [rise, rise_after]) = (halves(self.s), halves(self.rise));
        [Self { to: middle, s, rise, ..*self }, Self { from: middle, s: s_after, rise: rise_after, ..*self }]
    }
}

/// Both halves of a cubic (de Casteljau).
fn halves([a, b, c, d]: [f64; 4]) -> [[f64; 4]; 2] {
    let mean = |x: f64, y: f64| 0.5 * (x + y);
    let (ab, bc, cd) = (mean(a, b), mean(b, c), mean(c, d));
    let (abc, bcd) = (mean(ab, bc), mean(bc, cd));
    let middle = mean(abc, bcd);
    [[a, ab, abc, middle], [middle, bcd, cd, d]]
}

/// What decides whether a physical orbit can be on an interval.
struct Bounds<'a> {
    radiation: &'a Radiation,
    period: f64,
    asymmetry: f64,
    /// 2K₀(0), infinite for γ₁ = 0.
    twice: f64,
    /// How far the cubics can be off.
    error: f64,
    rise_error: f64,
    /// |s′(0)|, less its rounding, and the bound on |s‴|.
    flat: f64,
    second: f64,
}

impl Bounds<'_> {
    /// Whether any orbit on an interval is excluded by the sign of its impulses or by what it radiates. Half impulses have the mean
    /// 1/(2D) and half the difference a/(2(D + 2K₀(0))).
    fn radiates(&self, piece: &Piece) -> bool {
        let most = piece.rise.into_iter().fold(f64::NEG_INFINITY, f64::max) + self.rise_error;
        let least = piece.rise.into_iter().fold(f64::INFINITY, f64::min) - self.rise_error;
        let [from, to] = [piece.from, piece.to].map(|delta| 0.5 + delta / self.period);
        let difference = 0.5 * self.asymmetry / (most + self.twice).abs().max((least + self.twice).abs());
        // A difference larger than the mean turns one impulse round; a little of that polishing an orbit could mend.
        let turned = least > 0.0 && difference > 1.01 * 0.5 / least;
        most <= 0.0 || turned || !self.radiation.allows_between(from, to, 0.5 / most, difference)
    }

    /// Adds the parts of an interval that are left to `places`.
    fn narrow(&self, piece: Piece, halvings: u32, places: &mut Vec<(f64, f64)>) {
        let no_zero = if piece.from == 0.0 {
            // But for the one at δ = 0, next to which s′ keeps its sign: s″(0) = 0.
            self.flat > 0.5 * self.second * piece.to * piece.to
        } else {
            let least = piece.s.iter().map(|b| b.abs()).fold(f64::INFINITY, f64::min);
            least > self.error && piece.s.iter().all(|b| (*b > 0.0) == (piece.s[0] > 0.0))
        };
        if no_zero {
            return;
        }
        // The bound's sines are worth their while before the halvings and after them.
        if (halvings == HALVINGS || halvings == 0) && self.radiates(&piece) {
            return;
        }
        if halvings > 0 {
            for half in piece.halves() {
                self.narrow(half, halvings - 1, places);
            }
            return;
        }
        match places.last_mut() {
            Some(last) if last.1 == piece.from => last.1 = piece.to,
            _ => places.push((piece.from, piece.to)),
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
    pub(crate) fn set(&mut self, model: &Model, response: &ImpulseResponse, radiation: &Radiation) {
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
        let highest = self.nodes.last().map_or(0.0, |node| node[2]);
        let bounds = Bounds {
            radiation,
            period: response.period(),
            asymmetry: model.asymmetry(),
            twice: 2.0 * (response.static_stiffness().recip() + response.dynamic_at_impulse()),
            error: quartic * third + rounding,
            rise_error: quartic * second + rounding * half,
            flat: self.nodes.first().map_or(0.0, |node| node[1].abs() - rounding / step),
            second,
        };
        let third_of = step / 3.0;
        for (i, ends) in self.nodes.windows(2).enumerate() {
            let [[s, slope, lift], [next, next_slope, next_lift]] = [ends[0], ends[1]];
            let (rise, next_rise) = (highest - lift, highest - next_lift);
            let piece = Piece {
                from: i as f64 * step,
                to: if i + 1 == intervals { half } else { (i + 1) as f64 * step },
                s: [s, s + third_of * slope, next - third_of * next_slope, next],
                rise: [rise, rise - third_of * s, next_rise + third_of * next, next_rise],
            };
            bounds.narrow(piece, HALVINGS, &mut self.places);
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

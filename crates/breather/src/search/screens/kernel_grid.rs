//! Where a conservative double-sided breather with φ ≠ T/2 could be physical.
//!
//! [`KernelGrid`] samples s = −K₀′ (`asymmetric`) and the rise K₀ − K₀(0) on a grid of δ = φ − T/2, closes in on the places where s can
//! vanish, and keeps those that nothing else excludes:
//!
//! - the rise at φ, D, must be positive and not too small for the bound on [`Radiation`];
//! - every mass must stay inside its gap. It moves by u_n(t) = P₁K_n(t) + P₂K_n(t−φ), and as K_n is even,
//!
//! ```text
//! u_n(t) − u_n(φ−t) = (P₁−P₂)(K_n(t) − K_n(t−φ)) .
//! ```
//!
//! For the mass that is hit this is the whole gap, 2, at t = 0, when K₀(0) − K₀(φ) = −D. So |K_n(t) − K_n(t−φ)| ≤ D for all n and t,
//! whatever the asymmetry. It is looked at for the mass that is hit and the one opposite, where waves have a crest.

use vibrochain_lattice::simd::lanes::{Lane, total};
use vibrochain_lattice::{ImpulseResponse, Model};
use wide::f64x4;

use crate::admissible::grid::turn::turn;
use crate::search::screens::radiation::Radiation;

/// Intervals at most; more would be hundreds of orbits, which the search then reports as not finished.
pub(crate) const MOST: usize = 4096;

/// Length of a grid's interval in radians of the fastest mode. Cubics err by 1/400 of a term then, and a place is known to
/// a hundredth of a radian; a finer grid would cost more than it tells.
const INTERVAL: f64 = 1.0;

/// Places are not narrowed below this part of an interval: the cubics know no more.
const FINEST: f64 = 1.0 / 128.0;

/// Times of a period at most at which masses are looked at.
const TIMES: usize = 64;

/// Ω of the fastest mode.
pub(crate) fn top(response: &ImpulseResponse) -> f64 {
    response.frequencies().last().copied().unwrap_or_default()
}

/// s and K₀ − K₀(0) on an interval as cubics in Bernstein's form, within whose coefficients they stay.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Piece {
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) s: [f64; 4],
    pub(crate) rise: [f64; 4],
}

impl Piece {
    /// The parts before and after the fraction `t`.
    pub(crate) fn split(&self, t: f64) -> [Self; 2] {
        let middle = self.from + t * (self.to - self.from);
        let ([s, s_after], [rise, rise_after]) = (split(self.s, t), split(self.rise, t));
        [Self { to: middle, s, rise, ..*self }, Self { from: middle, s: s_after, rise: rise_after, ..*self }]
    }

    /// The fractions between which s can vanish if it is off by no more than `error`: a cubic leaves the line through its
    /// ends by no more than its inner coefficients do. In the wrong order if it cannot.
    fn crossing(&self, error: f64) -> [f64; 2] {
        let [a, b, c, d] = self.s;
        let bends = [b - (2.0 * a + d) / 3.0, c - (a + 2.0 * d) / 3.0];
        let low = bends[0].min(bends[1]).min(0.0) - error;
        let high = bends[0].max(bends[1]).max(0.0) + error;
        let ends = [low, high].map(|bend| (a + bend) / (a - d));
        // Without a slope no fraction tells.
        if a == d { [0.0, 1.0] } else { [ends[0].min(ends[1]).max(0.0), ends[0].max(ends[1]).min(1.0)] }
    }
}

/// Both parts of a cubic (de Casteljau).
fn split([a, b, c, d]: [f64; 4], t: f64) -> [[f64; 4]; 2] {
    let mean = |x: f64, y: f64| x + t * (y - x);
    let (ab, bc, cd) = (mean(a, b), mean(b, c), mean(c, d));
    let (abc, bcd) = (mean(ab, bc), mean(bc, cd));
    let middle = mean(abc, bcd);
    [[a, ab, abc, middle], [middle, bcd, cd, d]]
}

/// What is sampled at δ = 0, h, 2h, …, T/2, of the mass that is hit and of the one opposite to it.
#[derive(Debug, Clone, Copy)]
struct Node {
    /// s, the latter's −K′.
    s: [f64; 2],
    /// s′
    slope: f64,
    /// K(T/2) − K; of the former Σ a_k (1 − cos Ω_kδ)/Ω_k².
    lift: [f64; 2],
}

/// Samples, and cubics between them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Samples<'a> {
    nodes: &'a [Node],
    step: f64,
    half: f64,
    /// How far the cubics can be off.
    pub(crate) error: f64,
    pub(crate) rise_error: f64,
    /// What rounding can make of s.
    rounding: f64,
    /// Bounds on |s′| and |s‴|.
    first: f64,
    second: f64,
}

impl Samples<'_> {
    pub(crate) fn intervals(&self) -> usize {
        self.nodes.len() - 1
    }

    /// The lift of one of the two masses on an interval, in Bernstein's form.
    fn lift(&self, i: usize, mass: usize) -> [f64; 4] {
        let [[s, lift], [next, next_lift]] = [i, i + 1].map(|i| [self.nodes[i].s[mass], self.nodes[i].lift[mass]]);
        let third = self.step / 3.0;
        [lift, lift + third * s, next_lift - third * next, next_lift]
    }

    pub(crate) fn piece(&self, i: usize) -> Piece {
        let highest = self.nodes.last().map_or(0.0, |node| node.lift[0]);
        let [[s, slope], [next, next_slope]] = [i, i + 1].map(|i| [self.nodes[i].s[0], self.nodes[i].slope]);
        let third = self.step / 3.0;
        Piece {
            from: i as f64 * self.step,
            to: if i + 1 == self.intervals() { self.half } else { (i + 1) as f64 * self.step },
            s: [s, s + third * slope, next - third * next_slope, next],
            rise: self.lift(i, 0).map(|lift| highest - lift),
        }
    }

    /// The lift of one of the two masses at the time T/2 + `offset`, |offset| ≤ T.
    fn lift_at(&self, offset: f64, mass: usize) -> f64 {
        // K is even about T/2 and has the period T.
        let (nodes, distance) = (self.intervals() as f64, offset.abs() / self.step);
        let place = if distance > nodes { 2.0 * nodes - distance } else { distance };
        let i = (place as usize).min(self.intervals() - 1);
        split(self.lift(i, mass), place - i as f64)[0][3]
    }
}

/// What decides whether a physical orbit can be on an interval.
struct Bounds<'a> {
    samples: Samples<'a>,
    radiation: &'a Radiation,
    asymmetry: f64,
    /// 2K₀(0), infinite for γ₁ = 0.
    twice: f64,
    /// |s′(0)|, less its rounding, and the bounds on |s| and |s″|.
    flat: f64,
    steepest: f64,
    second: f64,
}

impl Bounds<'_> {
    /// Whether any orbit on an interval is excluded by the sign of its impulses or by what it radiates. Half impulses have the mean
    /// 1/(2D) and half the difference a/(2(D + 2K₀(0))).
    fn radiates(&self, piece: &Piece) -> bool {
        let [least, most] = self.rise_bounds(piece);
        let [from, to] = [piece.from, piece.to].map(|delta| 0.5 + 0.5 * delta / self.samples.half);
        let difference = 0.5 * self.asymmetry / (most + self.twice).abs().max((least + self.twice).abs());
        // A difference larger than the mean turns one impulse round; a little of that polishing an orbit could mend.
        let turned = least > 0.0 && difference > 1.01 * 0.5 / least;
        turned || !self.radiation.allows_between(from, to, 0.5 / most, difference)
    }

    /// Bounds on D.
    fn rise_bounds(&self, piece: &Piece) -> [f64; 2] {
        let least = piece.rise.into_iter().fold(f64::INFINITY, f64::min) - self.samples.rise_error;
        [least, piece.rise.into_iter().fold(f64::NEG_INFINITY, f64::max) + self.samples.rise_error]
    }

    /// Whether the mass that is hit or the one opposite leaves its gap for any φ of an interval, as far as some times of a
    /// period tell.
    fn leaves(&self, piece: &Piece) -> bool {
        let Samples { half, .. } = self.samples;
        let (delta, radius) = (0.5 * (piece.from + piece.to), 0.5 * (piece.to - piece.from));
        let [_, most] = self.rise_bounds(piece);
        let limit = most + 2.0 * self.samples.rise_error + self.steepest * radius;
        let times = TIMES.min(4 * self.samples.intervals());
        (0..times).any(|i| {
            // Of the time since φ.
            let offset = half * (2.0 * i as f64 / times as f64 - 2.0);
            let change = |mass| self.samples.lift_at(offset + half + delta, mass) - self.samples.lift_at(offset, mass);
            change(0).abs().max(change(1).abs()) > limit
        })
    }

    /// Adds the parts of an interval that are left to `places`.
    fn narrow(&self, piece: Piece, places: &mut Vec<(f64, f64)>) {
        let no_zero = if piece.from == 0.0 {
            // But for the one at δ = 0, next to which s′ keeps its sign: s″(0) = 0.
            self.flat > 0.5 * self.second * piece.to * piece.to
        } else {
            let least = piece.s.iter().map(|b| b.abs()).fold(f64::INFINITY, f64::min);
            least > self.samples.error && piece.s.iter().all(|b| (*b > 0.0) == (piece.s[0] > 0.0))
        };
        if no_zero || self.rise_bounds(&piece)[1] <= 0.0 || self.radiates(&piece) {
            return;
        }
        if piece.to - piece.from > FINEST * self.samples.step {
            let [low, high] = if piece.from == 0.0 { [0.0, 1.0] } else { piece.crossing(self.samples.error) };
            if high - low > 0.5 {
                for half in piece.split(0.5) {
                    self.narrow(half, places);
                }
            } else if low <= high {
                let [before, _] = piece.split(high);
                let [_, between] = before.split(low / high.max(f64::MIN_POSITIVE));
                self.narrow(between, places);
            }
            return;
        }
        if self.leaves(&piece) {
            return;
        }
        match places.last_mut() {
            Some(last) if last.1 == piece.from => last.1 = piece.to,
            _ => places.push((piece.from, piece.to)),
        }
    }
}

/// Four modes on their way from δ = 0 to T/2: a sin(Ωδ)/Ω, a cos Ωδ and a (1 − cos Ωδ)/Ω², and what a step does to them.
#[derive(Debug, Clone, Copy)]
struct Swing {
    state: [f64x4; 3],
    turn: [f64x4; 4],
    /// Opposite to the impacts.
    shape: f64x4,
}

/// The grid of [`Samples`], and the places where a physical orbit can be.
#[derive(Debug, Clone, Default)]
pub(crate) struct KernelGrid {
    swings: Vec<Swing>,
    nodes: Vec<Node>,
    /// Intervals of δ.
    places: Vec<(f64, f64)>,
}

impl KernelGrid {
    /// Forgets the places.
    pub(crate) fn clear(&mut self) {
        self.places.clear();
    }

    /// Room for other places, empty.
    pub(crate) fn take_places(&mut self) -> Vec<(f64, f64)> {
        let mut places = std::mem::take(&mut self.places);
        places.clear();
        places
    }

    /// Takes over places.
    pub(crate) fn put_places(&mut self, places: Vec<(f64, f64)>) -> &[(f64, f64)] {
        self.places = places;
        &self.places
    }

    /// Intervals of δ > 0 that are left to be searched.
    pub(crate) fn places(&self) -> &[(f64, f64)] {
        &self.places
    }

    /// Finds the places of δ > 0 where nothing excludes a physical orbit.
    pub(crate) fn set(&mut self, model: &Model, response: &ImpulseResponse, radiation: &Radiation) {
        let mut places = self.take_places();
        match self.bounds(model, response, radiation) {
            Some(bounds) => {
                (0..bounds.samples.intervals()).for_each(|i| bounds.narrow(bounds.samples.piece(i), &mut places));
            }
            None => places.push((0.0, 0.5 * response.period())),
        }
        self.places = places;
    }

    /// `None` where a grid would take too many intervals.
    fn bounds<'a>(
        &'a mut self,
        model: &Model,
        response: &ImpulseResponse,
        radiation: &'a Radiation,
    ) -> Option<Bounds<'a>> {
        let samples = self.samples(response)?;
        let Samples { nodes, step, rounding, first, second, .. } = samples;
        Some(Bounds {
            samples,
            radiation,
            asymmetry: model.asymmetry(),
            twice: 2.0 * (response.static_stiffness().recip() + response.dynamic_at_impulse()),
            flat: nodes.first().map_or(0.0, |node| node.slope.abs() - rounding / step),
            // No place is farther from a node than half a step.
            steepest: nodes.iter().flat_map(|node| node.s).fold(0.0, |most: f64, s| most.max(s.abs()))
                + 0.5 * step * first,
            second,
        })
    }

    /// The grid for one impulse response; `None` where it would take too many intervals.
    pub(crate) fn samples(&mut self, response: &ImpulseResponse) -> Option<Samples<'_>> {
        let half = 0.5 * response.period();
        let intervals = ((half * top(response) / INTERVAL).ceil() as usize).max(4);
        if intervals > MOST {
            return None;
        }
        let step = half / intervals as f64;
        let [first, second, third] = self.start(response, step);
        self.sample(intervals);
        // Cubics through values and slopes at both ends err by h⁴/384 times the fourth derivative; rounding adds up from step
        // to step.
        let quartic = step.powi(4) / 384.0;
        let rounding = 8.0 * f64::EPSILON * intervals as f64 * first * half;
        let (error, rise_error) = (quartic * third + rounding, quartic * second + rounding * half);
        Some(Samples { nodes: &self.nodes, step, half, error, rise_error, rounding, first, second })
    }

    /// Puts the modes at δ = 0. Tells Σ|a|, Σ|a|Ω² and Σ|a|Ω³, the bounds on |s′|, |s‴| and |s⁗|.
    fn start(&mut self, response: &ImpulseResponse, step: f64) -> [f64; 3] {
        let (mut first, mut second, mut third) = (f64x4::ZERO, f64x4::ZERO, f64x4::ZERO);
        let mut opposite = response.shapes().evens(response.sites() / 2, 0);
        self.swings.clear();
        for swings in response.swings_in_fours() {
            let [frequency, weight, _, sine] = swings.map(f64x4::from);
            // Ω/(2 sin ΩT/2) is 1/T for a rigid mode.
            let factor = f64x4::splat(0.5) * frequency / sine;
            let amplitude =
                weight * frequency.simd_gt(f64x4::ZERO).select(factor, f64x4::splat(1.0 / response.period()));
            let shape: Lane = std::array::from_fn(|_| opposite.next().unwrap_or_default());
            let square = frequency * frequency;
            // By two halves of a step, as far as its series reach: 1 − cos Ωh = 2 sin² Ωh/2.
            let [cos_half, sin_half, _] = turn(frequency, f64x4::splat(0.5 * step));
            let (sin, lift) = (sin_half * cos_half, sin_half * sin_half);
            let (sin, lift) = (sin + sin, lift + lift);
            let state = [f64x4::ZERO, amplitude, f64x4::ZERO];
            let turn = [sin, f64x4::ONE - square * lift, lift, square * sin];
            self.swings.push(Swing { state, turn, shape: f64x4::from(shape) });
            let (size, term) = (amplitude.abs(), amplitude.abs() * square);
            (first, second, third) = (first + size, second + term, third + term * frequency);
        }
        [total(first), total(second), total(third)]
    }

    fn sample(&mut self, intervals: usize) {
        self.nodes.clear();
        for _ in 0..=intervals {
            let mut sums = [f64x4::ZERO; 5];
            for Swing { state, turn, shape } in &mut self.swings {
                let ([sin, cos, lift], [sin_step, cos_step, lift_step, bend]) = (*state, *turn);
                let terms = [sin, sin * *shape, cos, lift, lift * *shape];
                (0..5).for_each(|i| sums[i] += terms[i]);
                *state = [
                    sin * cos_step + cos * sin_step,
                    cos * cos_step - sin * bend,
                    lift + sin * sin_step + cos * lift_step,
                ];
            }
            let [s, far_s, slope, lift, far_lift] = sums.map(total);
            self.nodes.push(Node { s: [s, far_s], slope, lift: [lift, far_lift] });
        }
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_lattice::{Chain, Spectrum};

    use super::*;

    #[test]
    fn cubics_and_crossings_are_as_good_as_they_say() {
        let mut random = fastrand::Rng::with_seed(17);
        let (mut grid, mut grids, mut tight) = (KernelGrid::default(), 0, 0);
        for _ in 0..1500 {
            let gamma1 = 0.6 * (random.f64() - 0.1).max(0.0);
            let chain = Chain::new(random.usize(1..40), gamma1, 0.3 * random.f64()).unwrap();
            let omega = (0.1 + random.f64()) * (gamma1 + 4.0 * chain.gamma2()).sqrt();
            let model = Model::conservative(chain, omega, 0.5).unwrap();
            let Ok(response) = ImpulseResponse::new(&Spectrum::new(chain), omega) else { continue };
            let Some(radiation) = Radiation::of(&response) else { continue };
            let Some(bounds) = grid.bounds(&model, &response, &radiation) else { continue };
            grids += 1;
            for _ in 0..20 {
                let offset = response.period() * random.f64();
                for (mass, site) in [0, chain.sites() / 2].into_iter().enumerate() {
                    let half = bounds.samples.half;
                    let lift = response.value(site, half) - response.value(site, half + offset);
                    for sign in [1.0, -1.0] {
                        let sampled = bounds.samples.lift_at(sign * offset, mass);
                        assert!((sampled - lift).abs() <= bounds.samples.rise_error, "{model:?}");
                    }
                }
                let mut piece = bounds.samples.piece(random.usize(0..bounds.samples.intervals()));
                let fraction = random.f64();
                let delta = piece.from + fraction * (piece.to - piece.from);
                let s = -response.derivative(0, bounds.samples.half + delta);
                assert!((split(piece.s, fraction)[0][3] - s).abs() <= bounds.samples.error, "{model:?}");
                // Moved so that it vanishes there.
                piece.s = piece.s.map(|b| b - s);
                let [low, high] = piece.crossing(bounds.samples.error);
                assert!((low..=high).contains(&fraction), "{model:?}");
                tight += u32::from(high - low < 0.2);
            }
        }
        assert!(grids > 1000 && tight > 10_000, "{grids} {tight}");
    }
}

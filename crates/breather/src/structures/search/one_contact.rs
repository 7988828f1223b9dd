//! Two impacts of one contact that no dashpot damps, under a load of one harmonic: F in the time from half the orbit's period.
//!
//! The kernel of such a contact is even about half the period. Written about the middle between the two impacts, their four conditions are symmetric:
//!
//! | letter | meaning |
//! |---|---|
//! | δ = φ − T/2, h = ωφ/2 | ω the load's frequency |
//! | u, v | P₁ = −2(u + v), P₂ = 2(u − v) |
//! | θ; X, Y | the load's phase at the middle; ĝ cos θ, ĝ sin θ with its amplitude ĝ |
//! | G, a | half the difference and half the sum of the two stops, less what is still |
//! | D = 2(K(φ)−K(0)), Σ = −2(K(φ)+K(0)), χ = 2K′(φ) | of a chain the paper's χ₂−χ₁, χ₁+χ₂, χ₃ |
//! | l = (1−e)/(1+e)m | what impacts lose |
//!
//! ```text
//! D u + Y sin h = G            Σ v + X cos h = a
//! χ u + l v + ωY cos h = 0     χ v − l u + ωX sin h = 0
//! ```
//!
//! For given φ they are linear in (u, v, X, Y). Cramer's rule gives X = x/Δ, Y = y/Δ with S = l² + χ²,
//!
//! ```text
//! Δ = ωχ(D cos²h + Σ sin²h) − sin h cos h (S + ω²DΣ)
//! x = aωχD cos h − aS sin h − ωlΣG cos h      y = ω sin h (χΣG + alD) − SG cos h
//! ```
//!
//! and F = x² + y² − ĝ²Δ² is left. At δ = 0 χ and one of sin h, cos h vanish together, and solutions crowd there as l → 0, as a → 0 and at
//! pitchforks: relative accuracy in δ keeps them apart. Σ enters as gΣ with a stiffness g, which is 0 where nothing holds the contact.

use smallvec::SmallVec;
use vibrochain_lattice::simd::lanes::{LANES, Lane, ZERO, all, four, total};
use vibrochain_lattice::{ContactMode, Turn};
use wide::f64x4;

use super::at_times::{Impacts, Start};
use super::half_period::ROUNDED;
use super::orbits::Starts;
use super::two_impacts::{MOST_PIECES, PAIR, RESOLUTION, apart};
use crate::roots::dual::{Algebra, Dual};
use crate::roots::interval::{Clearance, Enclosed, Zeros};
use crate::roots::taylor::Taylor;
use crate::search::completeness::Searched;
use crate::structures::point::{Point, Strike};

/// Where δ = 0 solves by itself F has a double zero there; the search stays this part of half the period away from it. Orbits closer than that to
/// their pitchfork are not told from the symmetric one. The same of two impacts on one barrier that are nearly one.
const GUARD: f64 = 1e-7;

/// What breaks the symmetry puts two orbits next to δ = 0 at a part of the period of its order: below this they are at δ = 0 to rounding.
const SYMMETRIC: f64 = 1e-18;

/// From this |sin ΩT/2| on a mode is next to a resonance.
const LOST: f64 = 1e-8;

/// Intervals that a search of the whole period begins with at least.
const LEAST: usize = 8;

/// One mode: its frequency, and a of a cos Ωδ.
type Term = [f64; 2];

/// F of one contact.
struct OneContact {
    modes: SmallVec<[Term; 16]>,
    /// What a mode that nothing holds adds to K″.
    drift: f64,
    half: f64,
    /// ω, and the number of quarter turns of h at δ = 0.
    rate: f64,
    quarters: u32,
    /// ĝ
    load: f64,
    /// G and a.
    stops: [f64; 2],
    loss: f64,
    /// K(0) − K(T/2)
    rise: f64,
    /// g, and 4gK(T/2).
    stiffness: f64,
    held: f64,
    /// A bound of |K⁗|.
    fourth: f64,
    /// Sums of a, aΩ and aΩ², each times the error of its mode: what rounding makes of K and its derivatives.
    doubts: [f64; 3],
}

impl OneContact {
    /// `None` next to a resonance: zeros come in pairs there, as close as the square of the distance, and rounding loses them.
    fn modes(&mut self, modes: &[ContactMode], mobility: f64) -> Option<()> {
        let period = 2.0 * self.half;
        let mut at_half = 0.0;
        for mode in modes {
            let ContactMode { frequency, weight, frequency_error, weight_error } = *mode;
            let given = mobility * weight;
            if frequency == 0.0 {
                self.drift -= given / period;
                continue;
            }
            let angle = frequency * self.half;
            let sin = angle.sin();
            // A mode far slower than the orbit is not next to a resonance.
            if sin.abs() < LOST * angle.min(1.0) {
                return None;
            }
            let amplitude = 0.5 * given / (frequency * sin);
            // Next to a resonance without the error of 1/sin ΩT/2, which is one number in all terms: of a mode nearby.
            let turned = angle * (frequency_error + 2.0 * f64::EPSILON);
            let error = weight_error + ROUNDED * f64::EPSILON + turned;
            let size = amplitude.abs();
            for (power, doubt) in self.doubts.iter_mut().enumerate() {
                *doubt += size * error * frequency.powi(power as i32);
            }
            self.fourth += size * frequency.powi(4);
            at_half += amplitude;
            let sine = (0.5 * frequency * self.half).sin();
            self.rise -= 2.0 * amplitude * sine * sine;
            self.modes.push([frequency, amplitude]);
        }
        self.rise += 0.5 * self.drift * self.half * self.half;
        (self.stiffness, self.held) = if self.drift == 0.0 {
            let stiffness = (4.0 * at_half.abs() + self.rise.abs()).recip();
            (stiffness, 4.0 * at_half * stiffness)
        } else {
            (0.0, 1.0)
        };
        Some(())
    }

    /// K − K(T/2) with three derivatives about four δ.
    fn jets(&self, deltas: Lane) -> [f64x4; 4] {
        let delta = four(deltas);
        let drift = all(self.drift);
        let mut jet = [delta * delta * drift * all(0.5), delta * drift, drift, ZERO];
        for &[frequency, amplitude] in &self.modes {
            // By half the angle next to δ = 0 no digit is lost.
            let [cos, sin] = Turn::Circular.turns(0.5 * frequency, deltas).unwrap_or_default().map(four);
            let fallen = sin * sin * all(2.0 * amplitude);
            let slope = sin * cos * all(2.0 * amplitude * frequency);
            let square = all(frequency * frequency);
            jet[0] -= fallen;
            jet[1] -= slope;
            jet[2] -= (all(amplitude) - fallen) * square;
            jet[3] += slope * square;
        }
        jet
    }

    /// D, χ, gΣ, sin h and cos h about four δ.
    fn pieces(&self, deltas: Lane, radii: Lane) -> [Dual<Taylor<1, f64x4>>; 5] {
        let ([value, slope, curvature, third], radius) = (self.jets(deltas), four(radii));
        let fourth = all(self.fourth);
        // The error of a term is a part of the term, which vanishes at δ = 0.
        let reach = four(deltas).abs() + radius;
        let [size, fast, faster] = self.doubts.map(all);
        let of_value = (size * all(2.0)).fast_min(faster * reach * reach * all(0.5));
        let of_slope = fast.fast_min(faster * reach);
        let widened = |dual: Dual<Taylor<1, f64x4>>, function: f64x4, derivative: f64x4| Dual {
            function: Taylor { rest: dual.function.rest + function, ..dual.function },
            derivative: Taylor { rest: dual.derivative.rest + derivative, ..dual.derivative },
        };
        let kernel = widened(Dual::from_jet([value, slope, curvature, third], fourth, radius), of_value, of_slope);
        let slope = widened(Dual::from_jet([slope, curvature, third, fourth], ZERO, radius), of_slope, faster);
        let end = 4.0 * self.doubts[0];
        let difference = kernel.shifted(-self.rise).scaled(2.0).widened([end, 0.0]);
        let [sin_h, cos_h] = {
            let [cos, sin] = Turn::Circular.turns(0.5 * self.rate, deltas).unwrap_or_default().map(four);
            self.waves(cos, sin).map(|(value, down)| Dual::wave(value, down, 0.5 * self.rate, 1.0, radius))
        };
        [difference, slope.scaled(2.0), self.sum(kernel).widened([self.stiffness * end, 0.0]), sin_h, cos_h]
    }

    /// K − K(T/2) with two derivatives at one δ: four modes at a time.
    fn jet(&self, delta: f64) -> [f64; 3] {
        let mut sums = [ZERO; 3];
        for modes in self.modes.chunks(LANES) {
            let term = |i: usize| modes.get(i).copied().unwrap_or_default();
            let (frequency, amplitude): (Lane, Lane) =
                (std::array::from_fn(|i| term(i)[0]), std::array::from_fn(|i| term(i)[1]));
            let [cos, sin] = Turn::Circular.turns(0.5 * delta, frequency).unwrap_or_default().map(four);
            let (frequency, doubled) = (four(frequency), four(amplitude) * all(2.0));
            let fallen = sin * sin * doubled;
            sums[0] -= fallen;
            sums[1] -= sin * cos * doubled * frequency;
            sums[2] -= (doubled * all(0.5) - fallen) * frequency * frequency;
        }
        let [value, slope, curvature] = sums.map(total);
        [value + 0.5 * self.drift * delta * delta, slope + self.drift * delta, curvature + self.drift]
    }

    /// D, χ, gΣ, sin h and cos h at one δ.
    fn pieces_at(&self, delta: f64) -> [Dual<f64>; 5] {
        let [value, slope, curvature] = self.jet(delta);
        let kernel = Dual { function: value, derivative: slope };
        let slope = Dual { function: slope, derivative: curvature };
        let (rate, (sin, cos)) = (0.5 * self.rate, (0.5 * self.rate * delta).sin_cos());
        let [sin_h, cos_h] =
            self.waves(cos, sin).map(|(value, down)| Dual { function: value, derivative: -rate * down });
        [kernel.shifted(-self.rise).scaled(2.0), slope.scaled(2.0), self.sum(kernel), sin_h, cos_h]
    }

    /// gΣ
    fn sum<T: Algebra>(&self, kernel: T) -> T {
        kernel.shifted(self.rise).scaled(-2.0 * self.stiffness).shifted(-self.held)
    }

    /// sin h and cos h from the cosine and sine of ωδ/2, each with the opposite of its slope over the rate.
    fn waves<T: Copy + std::ops::Neg<Output = T>>(&self, cos: T, sin: T) -> [(T, T); 2] {
        match self.quarters {
            0 => [(sin, -cos), (cos, sin)],
            1 => [(cos, sin), (-sin, cos)],
            2 => [(-sin, cos), (-cos, -sin)],
            _ => [(-cos, -sin), (sin, -cos)],
        }
    }

    /// g(x, y, Δ) from these.
    fn cramer<T: Algebra>(&self, [d, chi, sum, sin, cos]: [T; 5]) -> [T; 3] {
        let ([gap, mean], l, g, w) = (self.stops, self.loss, self.stiffness, self.rate);
        let s = (chi * chi).shifted(l * l);
        let (d_cos, sum_sin) = (d * cos, sum * sin);
        let determinant = (chi * ((d_cos * cos).scaled(g) + sum_sin * sin)).scaled(w)
            - sin * cos * (s.scaled(g) + (d * sum).scaled(w * w));
        let (mut x, mut y) =
            ((chi * d_cos).scaled(mean * w * g) - (s * sin).scaled(mean * g), (d * sin).scaled(mean * w * l * g));
        if gap != 0.0 {
            x = x - (sum * cos).scaled(w * l * gap);
            y = y + (chi * sum_sin).scaled(w * gap) - (s * cos).scaled(g * gap);
        }
        [x, y, determinant]
    }

    /// F
    fn formula<T: Algebra>(&self, pieces: [T; 5]) -> T {
        let [x, y, determinant] = self.cramer(pieces);
        let scaled = determinant.scaled(self.load);
        x * x + y * y - scaled * scaled
    }

    /// P₁, P₂ and the phase of the load at the first impact, at a zero δ; `None` where the conditions do not determine them.
    fn solution(&self, delta: f64) -> Option<[f64; 3]> {
        let pieces = self.pieces_at(delta).map(|point| point.function);
        let [x, y, determinant] = self.cramer(pieces);
        self.numbers(delta, pieces, (y / determinant).atan2(x / determinant))
    }

    /// The same for given θ, with the pieces at δ.
    fn numbers(&self, delta: f64, [d, _, sum, sin, cos]: [f64; 5], theta: f64) -> Option<[f64; 3]> {
        let ([gap, mean], (across, along)) = (self.stops, theta.sin_cos());
        let u = (gap - self.load * across * sin) / d;
        let v = self.stiffness * (mean - self.load * along * cos) / sum;
        let h = std::f64::consts::FRAC_PI_2 * f64::from(self.quarters) + 0.5 * self.rate * delta;
        let all = [-2.0 * (u + v), 2.0 * (u - v), theta - h];
        all.iter().all(|number| number.is_finite()).then_some(all)
    }

    /// Both solutions at δ = 0 where that solves by itself: there χ and one of sin h, cos h vanish, and one condition is left, a line that meets the
    /// circle X² + Y² = ĝ². Where it does not, how many times as large loads have to be.
    fn symmetric_solutions(&self) -> Result<[Option<[f64; 3]>; 2], f64> {
        let pieces = self.pieces_at(0.0).map(|point| point.function);
        let ([d, _, sum, sin, cos], [gap, mean]) = (pieces, self.stops);
        let (l, g, w) = (self.loss, self.stiffness, self.rate);
        // ωDX sin h + lY sin h = lG, or ωΣY cos h − lX cos h = −la.
        let ([along, across], right) = if self.quarters.is_multiple_of(2) {
            ([-l * g * cos, w * sum * cos], -l * g * mean)
        } else {
            ([w * d * sin, l * sin], l * gap)
        };
        let distance = right / along.hypot(across) / self.load;
        if distance.is_nan() || distance.abs() > 1.0 {
            return Err(distance.abs());
        }
        let (direction, opening) = (across.atan2(along), distance.acos());
        Ok([direction + opening, direction - opening].map(|theta| self.numbers(0.0, pieces, theta)))
    }

    /// Whether both impacts are on one barrier.
    fn is_alike(&self) -> bool {
        self.stops[0] == 0.0
    }

    /// δ = 0 solves by itself.
    fn is_symmetric(&self) -> bool {
        let ([gap, mean], size) = (self.stops, self.stops[0].abs().max(self.stops[1].abs()));
        let broken = if self.quarters.is_multiple_of(2) { gap } else { mean * self.stiffness * 2.0 * self.rise.abs() };
        (broken * self.loss).abs() <= SYMMETRIC * size
    }

    /// Zeros δ, all of them or those in some intervals of φ.
    fn zeros(&self, within: Option<&[[f64; 2]]>, zeros: &mut Zeros) {
        let guard = if self.is_symmetric() { GUARD * self.half } else { 0.0 };
        let edge = self.half * (1.0 - if self.is_alike() { GUARD } else { 2.0 * RESOLUTION });
        // Of one orbit begun at either impact the shorter time.
        let most = if self.is_alike() { -guard } else { edge };
        let both = |[from, to]: [f64; 2]| [[from.max(-edge), to.min(-guard)], [from.max(guard), to.min(most)]];
        let all = [[-self.half, self.half]];
        let places: SmallVec<[[f64; 2]; 8]> = match within {
            Some(within) => within.iter().map(|place| place.map(|phi| phi - self.half)).collect(),
            None => SmallVec::from_slice(&all),
        };
        let ranges: SmallVec<[[f64; 2]; 8]> =
            places.into_iter().flat_map(both).filter(|[from, to]| from < to).collect();
        let fastest = self.modes.iter().fold(self.rate, |most, [frequency, _]| most.max(*frequency));
        let least = if within.is_some() { 1 } else { LEAST / 2 };
        let pieces = |length: f64| (least + (length * fastest) as usize).min(MOST_PIECES);
        zeros.find_in(self, &ranges, pieces, |delta| 64.0 * f64::EPSILON * delta.abs().max(1e-20 * self.half));
    }
}

impl Enclosed for OneContact {
    fn clearances(&self, centres: Lane, radii: Lane) -> [Clearance; LANES] {
        let pieces = self.pieces(centres, radii);
        // Where the function itself has no zero nobody asks for its slope.
        let function = self.formula(pieces.map(|piece| piece.function)).clearance().to_array();
        if function.iter().all(|clearance| *clearance > 0.0) {
            return function.map(Clearance::away);
        }
        Clearance::of(&self.formula(pieces))
    }

    fn at(&self, delta: f64) -> (f64, f64) {
        let point = self.formula(self.pieces_at(delta));
        (point.function, point.derivative)
    }
}

impl Impacts<'_> {
    /// F of two impacts of one contact; `None` of others, with dashpots, next to a resonance, under a static load of what nothing holds, and where both
    /// stops are at the rest position.
    fn function_of_one_contact(&self) -> Option<OneContact> {
        let equations = self.equations;
        let &[(contact, _), (other, _)] = &self.letters[..] else { return None };
        let (rate, swings) = equations.single().filter(|_| contact == other)?;
        let modes = equations.kernel().felt.of_one.as_deref().filter(|_| equations.open.is_empty())?;
        if !equations.rigid.iter().all(|drift| drift.push == 0.0) || swings[contact].norm() == 0.0 {
            return None;
        }
        let places = self.places().filter(|places| places.iter().any(|place| *place != 0.0))?;
        let (half, e) = (0.5 * equations.period(), equations.restitution(contact));
        let mobility = equations.mobility(contact);
        let mut function = OneContact {
            modes: SmallVec::new(),
            drift: 0.0,
            half,
            rate,
            quarters: (rate * half / std::f64::consts::PI).round() as u32 % 4,
            load: swings[contact].norm(),
            stops: [0.5 * (places[0] - places[1]), 0.5 * (places[0] + places[1])],
            loss: mobility * (1.0 - e) / (1.0 + e),
            rise: 0.0,
            stiffness: 0.0,
            held: 0.0,
            fourth: 0.0,
            doubts: [0.0; 3],
        };
        function.modes(modes, mobility)?;
        Some(function)
    }

    /// Where to find all orbits of two impacts of one contact that no dashpot damps, or all but those at places that are left open; `None` of others, and
    /// where the search takes too long.
    pub(super) fn proved_of_one_contact(&self, within: Option<&[[f64; 2]]>) -> Option<Starts> {
        let function = self.function_of_one_contact()?;
        let mut zeros = Zeros::default();
        zeros.stop = self.equations.model.stop().clone();
        function.zeros(within, &mut zeros);
        if zeros.exhausted > 0 {
            return None;
        }
        let unresolved = apart(zeros.unresolved.iter().copied(), PAIR * function.half);
        let mut searched = Searched { intervals: zeros.intervals, unresolved, ..Searched::default() };
        let mut solutions: SmallVec<[(f64, Option<[f64; 3]>); 4]> = SmallVec::new();
        // Of impacts on one barrier what repeats after half the time is none.
        if function.is_symmetric() && !(function.is_alike() && function.quarters.is_multiple_of(2)) {
            match function.symmetric_solutions() {
                Ok(both) => solutions.extend(both.map(|numbers| (0.0, numbers))),
                Err(times) if times.is_nan() => searched.unresolved += 1,
                Err(times) => searched.too_weak = Some(times).filter(|_| zeros.simple.is_empty()),
            }
        }
        solutions.extend(zeros.simple.iter().map(|&delta| (delta, function.solution(delta))));
        let known = |(delta, numbers): &(f64, Option<[f64; 3]>)| {
            numbers.map(|numbers| Start::zero(self.point_of(function.half + delta, numbers)))
        };
        let starts: Vec<Start> = solutions.iter().filter_map(known).collect();
        searched.unresolved += solutions.len() - starts.len();
        Some(Ok((starts, searched)))
    }

    /// The point with these impulses and this phase of the load at the first impact.
    fn point_of(&self, phi: f64, [first, second, phase]: [f64; 3]) -> Point {
        let equations = self.equations;
        let strike = |(&(contact, barrier), (time, impulse))| Strike { contact, barrier, time, impulse };
        let strikes = self.letters.iter().zip([(0.0, first), (phi, second)]).map(strike).collect();
        let own = equations.single().map_or(0.0, |(rate, swings)| (phase - swings[self.letters[0].0].arg()) / rate);
        let offsets = SmallVec::from_elem(0.0, equations.rigid.len());
        let point = Point { strikes, psi: own, period: equations.period(), offsets };
        equations.with_offsets(point.clone()).unwrap_or(point)
    }
}

#[cfg(test)]
mod tests;

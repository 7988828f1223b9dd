//! What two modes that meet have to do with each other: the multipliers of a reversible orbit of one site as those of two oscillators
//! that feel each other through its impacts. (Of the secular function, which has a double zero where they meet, rounding would leave half
//! the digits; and where a mode hardly moves the mass that is hit, its root lies as close to its pole as a stripe is wide.)
//!
//! Over the time τ between impacts, with φ = Ωτ, the impact's strength K and E the matrix whose one entry 1 is the last, a multiplier
//! e^{iϑ} of one impact a period, τ = T, has
//!
//! ```text
//! det N(ϑ) = 0,    N = Σ (b²/2Ω) [ cot ½(φ−ϑ) v₊v₊ᵀ + cot ½(φ+ϑ) v₋v₋ᵀ ] − KE,    v± = (1, ±Ω),    K = Σ b²Ω cot ½φ:
//! ```
//!
//! the secular function of `secular::single_sided`, each mode's pole taken apart into those of e^{iΩT} and e^{−iΩT}. Two impacts of signed
//! impulses P₀ and P₁, half a period apart, have τ = T/2, multipliers e^{2iϑ} and, as derived in `secular::double_sided`,
//!
//! ```text
//! det | N(ϑ)  δE     | = 0,    K = Σ b²Ω(cos φ + ½(X+1/X))/sin φ,    δ = ½(X−1/X) Σ b²Ω/sin φ,    X = P₁/P₀.
//!     | δE    N(ϑ+π) |
//! ```
//!
//! Modes k and l with Ω̃_k + Ω̃_l = jω are next to a pole e^{iφ} of the one, e^{−iφ′} of the other, at one ϑ; with two impacts and odd j one of
//! them has ϑ + π, so that δ alone couples them: how much the two impacts differ. With M the rest of the matrix, these two poles left out,
//!
//! ```text
//! diag(tan ½(φ−ϑ), tan ½(φ′+ϑ)) + Wᵀ M⁻¹ W,    W = (√(b²/2Ω) v₊, √(b′²/2Ω′) v′₋)
//! ```
//!
//! has the same zeros. It has no pole near by, its slope is −½ and +½ but for the rest: two signatures.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix2, Matrix4, Matrix4x2, Vector2, Vector4};
use vibrochain_breather::Prepared;

use super::pencil::Pencil;
use crate::map_paths::Modes;

/// A mode between two impacts.
#[derive(Debug, Clone, Copy)]
struct Phase {
    weight: f64,
    frequency: f64,
    /// φ, sin φ/Ω, Ω sin φ
    phase: f64,
    over: f64,
    times: f64,
}

impl Phase {
    /// √(b²/2Ω) (1, ±Ω)
    fn direction(&self, sign: f64) -> Vector2<f64> {
        Vector2::new(1.0, sign * self.frequency) * (0.5 * self.weight / self.frequency).sqrt()
    }
}

/// A matrix and its derivative by ϑ.
type Sloped = (Matrix2<f64>, Matrix2<f64>);

/// An orbit's impacts and the modes between them.
#[derive(Debug, Clone, Default)]
pub(super) struct Reversal {
    modes: Modes,
    phases: Vec<Phase>,
    /// T or T/2
    time: f64,
    /// K
    strength: f64,
    /// δ; `None` of one impact.
    difference: Option<f64>,
    /// The two impulses have opposite signs, as they should.
    opposed: bool,
}

/// The modes whose poles are kept, that of e^{iφ} of the first and that of e^{−iφ} of the second.
pub(super) type Kept = (usize, usize);

impl Reversal {
    /// Takes over an orbit; false for one of neither kind, and for one without a finite saltation.
    pub(super) fn set(&mut self, prepared: Prepared<'_>) -> bool {
        let (orbit, response) = (prepared.orbit(), prepared.response());
        if !orbit.is_reversible() || orbit.impact_site().is_none() {
            return false;
        }
        self.modes.set_felt(prepared);
        let list = self.modes.list();
        let double = match orbit.impacts() {
            [_] => false,
            [_, _] => true,
            _ => return false,
        };
        self.time = if double { 0.5 } else { 1.0 } * response.period();
        self.phases.clear();
        self.phases.extend(list.iter().map(|mode| {
            let twice = if double { 1.0 } else { 2.0 * mode.cos };
            Phase {
                weight: mode.weight,
                frequency: mode.frequency,
                phase: mode.frequency * self.time,
                over: twice * mode.sin_over,
                times: twice * mode.sin_times,
            }
        }));
        let direct = list.iter().map(|mode| mode.weight * mode.cos * mode.inverse).sum();
        (self.strength, self.difference, self.opposed) = (direct, None, true);
        if double {
            // P₀ + P₁ and P₀ − P₁ from positions: of X next to −1 all digits count.
            let [mut sum, mut difference, mut crossed] = [0.0; 3];
            for mode in list {
                // tan ½φ/Ω
                let tangent =
                    if mode.cos > 0.0 { mode.sin_over / (1.0 + mode.cos) } else { (1.0 - mode.cos) / mode.sin_times };
                sum += mode.weight / (tangent * mode.frequency * mode.frequency);
                difference += mode.weight * tangent;
                crossed += mode.weight * mode.inverse;
            }
            let (sum, difference) = (4.0 * orbit.model().asymmetry() / sum, 4.0 / difference);
            let (first, second) = (0.5 * (sum - difference), 0.5 * (sum + difference));
            let product = first * second;
            self.opposed = product < 0.0;
            self.strength += 0.5 * crossed * (first * first + second * second) / product;
            self.difference = Some(0.5 * crossed * sum * difference / product);
        }
        self.strength.is_finite() && self.difference.is_none_or(f64::is_finite)
    }

    /// T, or T/2 of two impacts.
    pub(super) fn time(&self) -> f64 {
        self.time
    }

    /// ϑ turns twice where the multiplier turns once.
    pub(super) fn is_double(&self) -> bool {
        self.difference.is_some()
    }

    /// The modes that swing most at the two frequencies.
    pub(super) fn kept(&self, frequencies: [f64; 2]) -> Option<Kept> {
        let [first, second] = frequencies.map(|w| {
            let amplitude =
                |mode: &Phase| mode.weight / mode.frequency / (0.5 * (w * self.time - mode.phase)).sin().powi(2);
            let modes = self.phases.iter().enumerate().filter(|(_, mode)| mode.frequency > 0.0);
            modes.max_by(|(_, a), (_, b)| amplitude(a).total_cmp(&amplitude(b))).map(|(k, _)| k)
        });
        Some((first?, second?))
    }

    /// A number that changes where a harmonic meets a mode or an impulse vanishes: orbits on both sides are not one branch.
    pub(super) fn sheet(&self) -> f64 {
        let turns = if self.is_double() { 2.0 } else { 1.0 } / TAU;
        let passed: f64 = self.phases.iter().map(|mode| (turns * mode.phase).floor()).sum();
        if self.opposed { passed } else { -1.0 - passed }
    }

    /// N(ϑ) without the poles e^{iφ} and e^{−iφ} of some modes.
    fn rest(&self, angle: f64, [forward, backward]: [Option<usize>; 2]) -> Sloped {
        let (sin, cos) = angle.sin_cos();
        let ([mut sigma, mut g, mut h], [mut sigma_slope, mut g_slope, mut h_slope]) = ([0.0; 3], [0.0; 3]);
        let (mut value, mut slope) = (Matrix2::zeros(), Matrix2::zeros());
        for (k, mode) in self.phases.iter().enumerate() {
            let (up, down) = (0.5 * (mode.phase - angle), 0.5 * (mode.phase + angle));
            let left_out =
                [(forward, up, 1.0), (backward, down, -1.0)].map(|(out, half, sign)| (out == Some(k), half, sign));
            if left_out.iter().any(|(out, ..)| *out) {
                for (_, half, sign) in left_out.into_iter().filter(|(out, ..)| !out) {
                    let direction = mode.direction(sign);
                    let dyad = direction * direction.transpose();
                    value += dyad / half.tan();
                    slope += dyad * (0.5 * sign / half.sin().powi(2));
                }
                continue;
            }
            // cos ϑ − cos φ
            let distance = 2.0 * up.sin() * down.sin();
            let (pole, bend) = (mode.weight / distance, mode.weight * sin / (distance * distance));
            sigma += pole;
            g += mode.over * pole;
            h += mode.times * pole;
            sigma_slope += bend;
            g_slope += mode.over * bend;
            h_slope += mode.times * bend;
        }
        let (q, q_slope) = (sin * sigma, cos * sigma + sin * sigma_slope);
        value += Matrix2::new(g, q, q, h - self.strength);
        slope += Matrix2::new(g_slope, q_slope, q_slope, h_slope);
        (value, slope)
    }

    /// The pencil of two modes at a harmonic, about ϑ.
    pub(super) fn pencil(&self, angle: f64, (first, second): Kept, harmonic: usize) -> Option<Pencil> {
        let [one, other] = [(first, 1.0), (second, -1.0)].map(|(k, sign)| self.phases[k].direction(sign));
        let apart = self.is_double() && !harmonic.is_multiple_of(2);
        let here = self.rest(angle, [Some(first), (!apart).then_some(second)]);
        let (mut value, mut slope) = (Matrix4::identity(), Matrix4::zeros());
        let mut place = |(rest, bend): Sloped, at: usize| {
            value.fixed_view_mut::<2, 2>(at, at).copy_from(&rest);
            slope.fixed_view_mut::<2, 2>(at, at).copy_from(&bend);
        };
        place(here, 0);
        if let Some(delta) = self.difference {
            place(self.rest(angle + PI, [None, apart.then_some(second)]), 2);
            (value[(1, 3)], value[(3, 1)]) = (delta, delta);
        }
        let other =
            if apart { Vector4::new(0.0, 0.0, other[0], other[1]) } else { Vector4::new(other[0], other[1], 0.0, 0.0) };
        let inner = Matrix4x2::from_columns(&[Vector4::new(one[0], one[1], 0.0, 0.0), other]);
        let solved = value.lu().solve(&inner)?;
        let (rest, bend) = (inner.transpose() * solved, -(solved.transpose() * slope * solved));
        let turned = if apart { angle + PI } else { angle };
        let [up, down] =
            [self.phases[first].phase - angle, self.phases[second].phase + turned].map(|half| (0.5 * half).tan());
        Some(Pencil {
            value: [up + rest[(0, 0)], rest[(0, 1)], down + rest[(1, 1)]],
            slope: [bend[(0, 0)] - 0.5 * (1.0 + up * up), bend[(0, 1)], bend[(1, 1)] + 0.5 * (1.0 + down * down)],
        })
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_breather::{Family, Finder, OrbitList};
    use vibrochain_testkit::{Random, Ranges};

    use super::*;

    #[test]
    fn slopes_are_those_of_the_entries() {
        let (mut random, mut finder, mut found) = (Random(3), Finder::new(2), OrbitList::default());
        let (mut reversal, mut checked) = (Reversal::default(), [0; 3]);
        for i in 0..400 {
            let model = random.model(&Ranges { sites: [2, 20], ..Ranges::CONSERVATIVE });
            let family = [Family::SingleSided, Family::DoubleSided][i % 2];
            finder.find_symmetric(&model, family, &mut found).unwrap();
            let Some(orbit) = found.orbits.first() else { continue };
            if !reversal.set(finder.prepared(orbit).unwrap()) {
                continue;
            }
            for harmonic in [1_usize, 2] {
                let (angle, step) = (random.between(0.1, 6.0), 1e-5);
                let w = angle / reversal.time();
                let kept = reversal.kept([w, harmonic as f64 * model.omega() - w]).unwrap();
                let [low, here, high] =
                    [-step, 0.0, step].map(|by| reversal.pencil(angle + by, kept, harmonic).unwrap());
                for i in 0..3 {
                    let slope = (high.value[i] - low.value[i]) / (2.0 * step);
                    let bend = (high.value[i] + low.value[i] - 2.0 * here.value[i]).abs() / step;
                    // Next to a pole differences say nothing.
                    if bend < 0.1 * slope.abs() {
                        assert!(
                            (slope - here.slope[i]).abs() < 1e-2 * slope.abs(),
                            "{harmonic} {i} {slope} {here:?} {orbit:?}"
                        );
                        checked[i] += 1;
                    }
                }
            }
        }
        assert!(checked.iter().all(|count| *count > 300), "{checked:?}");
    }
}

//! Reversible words of any sites on lattices of any size: how many multipliers are on the circle, and how many real ones beyond it, by the
//! inertia of one symmetric matrix; nothing of the ring's size is solved.
//!
//! With ν = cos θ, c, s = cos, sin(ΩT/2), x = s/Ω, y = sΩ and d = cos ΩT, K̂ of [`super::impact_matrix`] for impacts at 0 and T/2 is,
//! rows and columns scaled by phases, f = 4ⁿ det S with
//!
//! ```text
//! S = (U  E; Eᵀ  L−κ'),      entries Σ_k b²φ_iφ_j/(ν−d) times
//!
//!         both at one instant          half a period apart
//! U       cx                           x cos(θ/2)
//! E       ½ sin θ                      c sin(θ/2)
//! L       cy                           y cos(θ/2)
//! ```
//!
//! real and symmetric for −1 < ν < 1. Each mode has the residue cs·φφᵀ ⊗ vvᵀ, so that the number n₊ of positive eigenvalues rises by the
//! rank of φ (the shapes of its frequency that the impacts feel) as ν passes d, or falls, by the sign of cs. What n₊ does beside that are
//! zeros of f: between two places there are at least |Δn₊ − Σ ±rank|. Beyond ±1 the trigonometric functions are hyperbolic, S is real
//! and symmetric again, with other signs, has no poles, and at infinity n positive eigenvalues of 2n.
//!
//! f has as many zeros as Σ rank, one of them the trivial ν = 1. If that many are counted, none is left for anywhere else. n₊ is taken
//! only where every eigenvalue is farther from 0 than errors of the entries reach (Weyl): the count is a certificate.

use nalgebra::{Complex, DMatrix};
use smallvec::SmallVec;
use vibrochain_breather::lanes::{Lane, ONE, ZERO, all, fill, four, total};
use vibrochain_breather::{Condition, Prepared};
use wide::f64x4;

use super::error::SecularError;
use super::growth::{Nu, outside};
use super::modes::{Mode, Modes};
use crate::saltation::Saltation;

/// Where a mode is that pads a group of four.
const FAR: f64 = 1e100;

/// Distances from ±1 of the outermost places inside, tried in this order: so near that a free phase is not mistaken for the trivial zero,
/// so far that the trivial zero is told from rounding.
const ENDS: [f64; 3] = [1e-10, 1e-8, 1e-6];

/// Doublings of the distance from ±1 that reach the largest multiplier there can be: 2^70 · 1e-10 is 1e11.
const DOUBLINGS: i32 = 70;

/// Places in each gap, if one is not enough.
const FINER: usize = 7;

/// Halvings of the bracket of a multiplier beyond ±1.
const HALVINGS: usize = 60;

/// On which side of ±1.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Side {
    Inside,
    BeyondOne,
    BeyondMinusOne,
}

/// A place ν, with 1 − ν and 1 + ν to their own digits.
#[derive(Debug, Clone, Copy)]
struct Place {
    side: Side,
    nu: f64,
    below: f64,
    above: f64,
}

impl Place {
    /// ±(1 + delta), inside for a negative one.
    fn next_to(end: f64, delta: f64) -> Self {
        let side = match (delta > 0.0, end > 0.0) {
            (false, _) => Side::Inside,
            (true, true) => Side::BeyondOne,
            (true, false) => Side::BeyondMinusOne,
        };
        let (near, far) = (-delta, 2.0 + delta);
        let (below, above) = if end > 0.0 { (near, far) } else { (far, near) };
        Self { side, nu: end * (1.0 + delta), below, above }
    }

    fn inside(nu: f64) -> Self {
        Self { side: Side::Inside, nu, below: 1.0 - nu, above: 1.0 + nu }
    }
}

/// What the sums need of four modes: weight, weight times c, cx, x, cy, y in units of ω, the pole and its error.
#[derive(Debug, Clone, Copy)]
struct Group {
    parts: [Lane; 6],
    /// A bound of all of these, and of their errors.
    size: Lane,
    error: Lane,
    pole: Lane,
    shift: Lane,
}

/// The matrix S of one orbit; also the work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct Inertia {
    modes: Modes,
    groups: Vec<Group>,
    /// Shapes of all modes between two sites that are hit, on a ring by their distance: [pair][group].
    shapes: Vec<Lane>,
    /// Of two impacts: which pair; whether they are at the later instant.
    pairs: Vec<usize>,
    late: Vec<bool>,
    /// κ'/ω and its error.
    kappas: Vec<(f64, f64)>,
    /// Poles d by rising d, with what n₊ rises by.
    poles: Vec<(f64, i64)>,
    zeros: i64,
    sums: Vec<[f64x4; 6]>,
}

impl Inertia {
    /// Takes over a reversible orbit.
    pub(crate) fn set(&mut self, prepared: Prepared<'_>, condition: &Condition) {
        let (orbit, response) = (prepared.orbit(), prepared.response());
        let (impacts, omega) = (orbit.impacts(), response.omega());
        let first = impacts.first().map_or(0.0, |impact| impact.time);
        self.modes.set(response);
        let modes = self.modes.list();
        self.kappas.clear();
        self.kappas.extend(impacts.iter().zip(&condition.impacts).map(|(impact, error)| {
            let kappa = Saltation::reduced(impact, 1.0) / omega;
            let of_acceleration = error.acceleration / (2.0 * impact.velocity_before * omega);
            (kappa, of_acceleration.abs() + (kappa * error.impulse / impact.impulse).abs())
        }));
        self.late.clear();
        self.late.extend(impacts.iter().map(|impact| impact.time > first));
        let (shapes, ring) = (response.shapes(), orbit.model().chain().is_ring());
        let mut classes: Vec<[usize; 2]> = Vec::new();
        self.pairs.clear();
        for one in impacts {
            for other in impacts {
                let (low, high) = (one.site.min(other.site), one.site.max(other.site));
                let pair = if ring { [high - low, 0] } else { [high, low] };
                let class = classes.iter().position(|&known| known == pair).unwrap_or_else(|| {
                    classes.push(pair);
                    classes.len() - 1
                });
                self.pairs.push(class);
            }
        }
        self.shapes.clear();
        let mut lanes = Vec::new();
        for &[to, from] in &classes {
            let cosines: Vec<f64> = shapes.evens(to, from).take(modes.len()).collect();
            fill(&mut lanes, cosines.into_iter(), 0.0);
            self.shapes.extend_from_slice(&lanes);
        }
        let column = |part: &dyn Fn(&Mode) -> f64, pad: f64| {
            let mut lanes = Vec::new();
            fill(&mut lanes, modes.iter().map(part), pad);
            lanes
        };
        let parts: [Vec<Lane>; 6] = [
            column(&|mode| mode.weight, 0.0),
            column(&|mode| mode.weight * mode.cos, 0.0),
            column(&|mode| mode.weight * mode.cos * mode.sin_over * omega, 0.0),
            column(&|mode| mode.weight * mode.sin_over * omega, 0.0),
            column(&|mode| mode.weight * mode.cos * mode.sin_times / omega, 0.0),
            column(&|mode| mode.weight * mode.sin_times / omega, 0.0),
        ];
        let size = |mode: &Mode| {
            let ratio = mode.frequency / omega;
            // xω is ω/Ω at most, and π.
            mode.weight * ratio.max((1.0 / ratio).min(4.0))
        };
        let error = |mode: &Mode| size(mode) * f64::EPSILON * (mode.frequency * response.period() + 8.0);
        let (size, error) = (column(&size, 0.0), column(&error, 0.0));
        let pole = column(&|mode| (mode.cos - mode.sin) * (mode.cos + mode.sin), FAR);
        let shift = column(&|mode| f64::EPSILON * (mode.shift + 2.0), 0.0);
        self.groups.clear();
        self.groups.extend((0..pole.len()).map(|g| {
            let parts = std::array::from_fn(|i| parts[i][g]);
            Group { parts, size: size[g], error: error[g], pole: pole[g], shift: shift[g] }
        }));
        // A mode that is alone with its frequency has one shape, a doublet's second one may have a node at all sites.
        let home = impacts.first().map_or(0, |impact| impact.site);
        let doublet = |k: usize| 1 + i64::from(impacts.iter().any(|impact| shapes.odd(k, impact.site, home) != 0.0));
        let sites = orbit.hit_sites();
        let rank = |k: usize| {
            if ring {
                return doublet(k);
            }
            let projector = DMatrix::from_fn(sites.len(), sites.len(), |i, j| shapes.even(k, sites[i], sites[j]));
            projector.symmetric_eigenvalues().iter().filter(|value| !Modes::is_spared(**value)).count() as i64
        };
        self.poles.clear();
        self.poles.extend(modes.iter().enumerate().map(|(k, mode)| {
            let rising = if (mode.cos > 0.0) == (mode.sin > 0.0) { 1 } else { -1 };
            ((mode.cos - mode.sin) * (mode.cos + mode.sin), rising * rank(k))
        }));
        self.poles.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.zeros = self.poles.iter().map(|(_, rise)| rise.abs()).sum();
    }

    /// n₊ at a place, if it is beyond doubt.
    fn positive(&mut self, place: Place) -> Option<i64> {
        let n = self.kappas.len();
        let count = self.groups.len();
        let classes = self.shapes.len() / count.max(1);
        self.sums.clear();
        self.sums.resize(classes, [ZERO; 6]);
        let mut noise = ZERO;
        let nu = all(place.nu);
        for (g, Group { parts, size, error, pole, shift }) in self.groups.iter().enumerate() {
            let inverse = ONE / (nu - four(*pole));
            let parts = parts.map(|part| four(part) * inverse);
            noise += four(*error) * inverse.abs() + four(*size) * four(*shift) * inverse * inverse;
            for (class, sums) in self.sums.iter_mut().enumerate() {
                let shape = four(self.shapes[class * count + g]);
                sums.iter_mut().zip(&parts).for_each(|(sum, part)| *sum += shape * *part);
            }
        }
        let sums: Vec<[f64; 6]> = self.sums.iter().map(|sums| sums.map(total)).collect();
        let (sine, cosine) = ((0.5 * place.below.abs()).sqrt(), (0.5 * place.above.abs()).sqrt());
        // Signs that make S real and symmetric: of U, of E and of L, for impacts at the earlier and the later instant.
        let signs = |i: usize, j: usize| match (place.side, self.late[i], self.late[j]) {
            (Side::Inside, ..) => [1.0, 1.0, 1.0],
            (Side::BeyondOne, ..) | (Side::BeyondMinusOne, false, false) => [1.0, 1.0, -1.0],
            (Side::BeyondMinusOne, true, true) => [-1.0, 1.0, 1.0],
            (Side::BeyondMinusOne, false, true) => [1.0, 1.0, 1.0],
            (Side::BeyondMinusOne, true, false) => [1.0, -1.0, 1.0],
        };
        let mut matrix = DMatrix::zeros(2 * n, 2 * n);
        for i in 0..n {
            for j in 0..n {
                let [one, c, cx, x, cy, y] = sums[self.pairs[i * n + j]];
                let [upper, even, lower] = signs(i, j);
                let (u, e, l) = if self.late[i] == self.late[j] {
                    (cx, sine * cosine * one, cy)
                } else {
                    (x * cosine, c * sine, y * cosine)
                };
                let kappa = if i == j { self.kappas[i].0 } else { 0.0 };
                matrix[(i, j)] = upper * u;
                matrix[(i, n + j)] = even * e;
                matrix[(n + j, i)] = even * e;
                matrix[(n + i, n + j)] = lower * (l - kappa);
            }
        }
        if !matrix.iter().all(|entry| entry.is_finite()) {
            return None;
        }
        let kappa_error = self.kappas.iter().map(|(_, error)| *error).fold(0.0, f64::max);
        // Of the entries, in each row; of the eigenvalues, which are found to rounding of the largest.
        let values = matrix.symmetric_eigenvalues();
        let largest = values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let size = (2 * n) as f64;
        // Far beyond ±1 they are larger than 1.
        let factor = sine.max(cosine).max(sine * cosine).max(1.0);
        let doubt = size * (factor * total(noise) + 4.0 * f64::EPSILON * largest) + kappa_error;
        let certain = values.iter().all(|value| value.abs() > doubt);
        certain.then(|| values.iter().filter(|value| **value > 0.0).count() as i64)
    }

    /// At least how many zeros are between the outermost places inside, these `reach` from ±1, and with `finer` places in each gap.
    fn inside(&mut self, reach: f64, finer: usize) -> Option<i64> {
        let mut last = self.positive(Place::next_to(-1.0, -reach))?;
        let (mut expected, mut zeros) = (0, 0);
        for gap in 0..self.poles.len() {
            expected += self.poles[gap].1;
            let Some(&(next, _)) = self.poles.get(gap + 1) else { break };
            let left = self.poles[gap].0;
            for part in 1..=finer {
                let nu = left + (next - left) * part as f64 / (finer + 1) as f64;
                if nu <= left || nu >= next {
                    continue;
                }
                if let Some(here) = self.positive(Place::inside(nu)) {
                    zeros += (here - last - expected).abs();
                    (last, expected) = (here, 0);
                }
            }
        }
        let end = self.positive(Place::next_to(1.0, -reach))?;
        Some(zeros + (end - last - expected).abs())
    }

    /// At least how many zeros are beyond an end, from `reach` off it on, and a bracket of the outermost one.
    fn beyond(&mut self, end: f64, reach: f64) -> Option<(i64, Option<[f64; 2]>)> {
        let n = self.kappas.len() as i64;
        let mut last = self.positive(Place::next_to(end, reach))?;
        let (mut zeros, mut bracket) = (0, (last != n).then_some([reach, f64::INFINITY]));
        let mut low = reach;
        for doubling in 1..=DOUBLINGS {
            let delta = reach * 2f64.powi(doubling);
            let Some(here) = self.positive(Place::next_to(end, delta)) else { continue };
            if here != last {
                zeros += (here - last).abs();
                bracket = Some([low, delta]);
            }
            (last, low) = (here, delta);
        }
        if last != n {
            return None;
        }
        let Some([mut low, mut high]) = bracket else { return Some((zeros, None)) };
        // n₊ is n from the upper end on.
        for _ in 0..HALVINGS {
            let middle = (low * high).sqrt();
            match self.positive(Place::next_to(end, middle)) {
                Some(here) if here == n => high = middle,
                Some(_) => low = middle,
                None => break,
            }
        }
        Some((zeros, Some([low, high])))
    }

    /// How many zeros are on the circle or real.
    ///
    /// # Errors
    /// [`SecularError::Tangency`] where nothing can be told from rounding next to ±1.
    pub(crate) fn count(&mut self) -> Result<Count, SecularError> {
        let nearest = self.poles.iter().map(|(d, _)| 1.0 - d.abs()).fold(1.0, f64::min);
        let wanted = self.zeros - 1;
        let mut best: Option<Count> = None;
        for reach in ENDS {
            let reach = reach.min(0.25 * nearest);
            let (Some(up), Some(down)) = (self.beyond(1.0, reach), self.beyond(-1.0, reach)) else { continue };
            for finer in [1, FINER] {
                let Some(inside) = self.inside(reach, finer) else { break };
                let found = inside + up.0 + down.0;
                let missing = usize::try_from(wanted - found).map_err(|_| SecularError::Tangency)?;
                if best.as_ref().is_none_or(|best| missing < best.missing) {
                    let ends = [(1.0, up.1), (-1.0, down.1)];
                    let real = ends.into_iter().filter_map(|(end, bracket)| bracket.map(|bracket| (end, bracket)));
                    best = Some(Count { wanted: wanted as usize, missing, real: real.map(Real::new).collect() });
                }
                if missing == 0 {
                    break;
                }
            }
            if best.as_ref().is_some_and(|best| best.missing == 0) {
                break;
            }
        }
        best.ok_or(SecularError::Tangency)
    }
}

/// What is known of the zeros but the trivial one.
#[derive(Debug, Clone)]
pub(crate) struct Count {
    pub(crate) wanted: usize,
    /// Those that are neither on the circle nor real.
    pub(crate) missing: usize,
    /// The outermost one beyond either end.
    pub(crate) real: SmallVec<[Real; 2]>,
}

/// A multiplier outside the circle, known by its bracket.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Real {
    pub(crate) multiplier: Complex<f64>,
    pub(crate) growth: f64,
    pub(crate) error: f64,
}

impl Real {
    fn new((end, [low, high]): (f64, [f64; 2])) -> Self {
        let [low_growth, high_growth] = [low, high].map(outside);
        let [multiplier, _] = Nu::beyond(end, 0.5 * (low + high)).multipliers();
        let growth = 0.5 * (low_growth + high_growth);
        Self { multiplier, growth, error: (high_growth - low_growth).max(8.0 * f64::EPSILON * growth) }
    }
}

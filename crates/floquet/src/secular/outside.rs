//! Words of any sites under a force or with losses: how many multipliers are outside a circle |z| = R ≥ 1, by the turns that f makes
//! along it.
//!
//! f = (1+e)^{2n} det K̂ (see [`super::impact_matrix`]) has no pole outside the unit circle, and a value there at infinity. So along |z| = R
//! it turns once against the clock's sense less than at infinity for each zero outside; by f(z̄) = conj f(z) half the circle is enough.
//! The matrix that is followed is [`super::bordered`]'s 𝓑, which has no poles near: how they turn is known, with the pole left inside. So R = 1
//! is as good as any other where impacts dissipate: no multiplier need be on the circle.
//!
//! **Why no turn is missed.** From one place to the next, E(s) = 𝓑(0)⁻¹(𝓑(s) − 𝓑(0)) is known at s = ½ and 1, and is off the parabola through
//! these by ‖𝓑⁻¹‖ δθ³/(72√3) max‖d³𝓑/dθ³‖ at most, which a sum over the distances to all poles bounds. Where ‖E‖_F and all that errors of
//! the entries can do to it are below ¾, det(1+E(s)) ≠ 0 on the way, and |arg| ≤ |tr E| + Σ_{m≥2}‖E‖_F^m/m < π: its principal value is the
//! turn.
//! The step is shortened until that holds; where it becomes nothing, a multiplier is on the circle as far as can be told.

use std::f64::consts::PI;

use nalgebra::{Complex, DMatrix};
use vibrochain_breather::{Condition, Prepared};

use super::bordered::Bordered;
use super::error::SecularError;
use super::growth::modulus;

type C = Complex<f64>;

/// ‖E‖_F and all errors, at most: Σ_{m≥2} xᵐ/m is 0.64 then.
const FARTHEST: f64 = 0.75;

/// |tr E|, at most: with what higher powers add it is well below π.
const LONGEST_TURN: f64 = 2.2;

/// Of three places s = 0, ½, 1: how far what goes through them is from a parabola, as a part of its third derivative, 1/(12√3)/3!.
const OF_PARABOLA: f64 = 0.00802;

/// How far from a parabola a step may be; more is not worth the trial.
const CURVED: f64 = 0.12;

/// Part of ‖E‖_F that the next step aims at.
const AIM: f64 = 0.5;

/// Steps of one half circle.
const MOST_STEPS: usize = 3_000_000;

/// Matrices that a pole and its gap take, where multipliers are some 10⁻⁶ from the circle: for the estimate of what a count costs.
const MATRICES_OF_A_POLE: f64 = 300.0;

/// The least step, in angle.
const LEAST_STEP: f64 = 1e-15;

/// Zeros outside a circle, and places from where Newton's method may find them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Turns {
    pub(crate) outside: usize,
    pub(crate) starts: Vec<C>,
}

/// A place on the circle with 𝓑 there.
struct Node {
    angle: f64,
    matrix: DMatrix<C>,
    inverse: DMatrix<C>,
    norm: f64,
    /// det 𝓑 up to a positive factor, and the logarithm of that.
    phase: C,
    size: f64,
}

/// Counts zeros; also the work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct OutsideCircle {
    matrix: Bordered,
}

impl OutsideCircle {
    /// Takes over an orbit.
    ///
    /// # Errors
    /// [`SecularError::Coincident`] for a pole at ±1.
    pub(crate) fn set(&mut self, prepared: Prepared<'_>, condition: &Condition) -> Result<(), SecularError> {
        self.matrix.set(prepared, condition)
    }

    fn node(&mut self, radius: f64, angle: f64) -> Option<Node> {
        let matrix = self.matrix.evaluate(C::from_polar(radius, angle));
        let factors = matrix.clone().lu();
        let (mut phase, mut size) = (C::new(factors.p().determinant::<f64>(), 0.0), 0.0);
        for pivot in factors.u().diagonal().iter() {
            let length = modulus(*pivot);
            size += length.ln();
            phase *= *pivot / length;
        }
        let inverse = factors.try_inverse()?;
        let norm = inverse.norm();
        (norm.is_finite() && phase.re.is_finite()).then_some(Node { angle, matrix, inverse, norm, phase, size })
    }

    /// One step from a node, as long as it is sure to miss no turn, to `end` at the most; `guess` is the step to begin with, and to go on
    /// with.
    fn step(&mut self, radius: f64, node: &Node, end: f64, guess: &mut f64) -> Option<Node> {
        let mut step = guess.min(end - node.angle);
        let root = (node.matrix.nrows() as f64).sqrt();
        while step > LEAST_STEP {
            let (third, error) = self.matrix.bounds(radius, node.angle, step);
            let (rest, off) = (node.norm * third * step.powi(3) * OF_PARABOLA, node.norm * error);
            let fair = rest <= CURVED && off <= CURVED;
            if !fair {
                step *= if rest.is_finite() { (0.9 * (CURVED / rest).cbrt()).clamp(0.1, 0.8) } else { 0.5 };
                continue;
            }
            let angle = if step >= end - node.angle { end } else { node.angle + step };
            let other = self.node(radius, angle)?;
            let moved = &node.inverse * (&other.matrix - &node.matrix);
            let half = self.matrix.evaluate(C::from_polar(radius, 0.5 * (node.angle + angle)));
            let bent = &node.inverse * (half - (&other.matrix + &node.matrix) * C::new(0.5, 0.0));
            let (far, turn, curved) = (moved.norm(), moved.trace(), bent.norm() + rest);
            let sure = far + curved + off <= FARTHEST && turn.im.abs() + root * (curved + off) <= LONGEST_TURN;
            if sure {
                *guess = step * (AIM / (far + curved)).clamp(0.5, 2.0);
                return Some(other);
            }
            step *= (AIM / (far + curved)).clamp(0.1, 0.7);
        }
        None
    }

    /// How many zeros are outside |z| = `radius` ≥ 1, with their multiplicities.
    ///
    /// # Errors
    /// [`SecularError::Tangency`] where a zero is on the circle as far as can be told.
    pub(crate) fn turns(&mut self, radius: f64) -> Result<Turns, SecularError> {
        let middle = |a: usize, b: usize| {
            0.5 * (self.matrix.poles[self.matrix.clusters[a].end - 1].0
                + self.matrix.poles[self.matrix.clusters[b].start].0)
        };
        let count = self.matrix.clusters.len();
        let upper: Vec<usize> =
            (0..count).filter(|&c| self.matrix.poles[self.matrix.clusters[c].start].0 > 0.0).collect();
        // What is passed near, and where the next one begins; all that is passed far off, at once.
        let mut stretches: Vec<(Option<usize>, f64)> = Vec::new();
        for &passed in &upper {
            let end = if passed + 1 < count { middle(passed, passed + 1) } else { PI };
            let near = self.matrix.is_near(radius, passed).then_some(passed);
            match stretches.last_mut() {
                Some((None, last)) if near.is_none() => *last = end,
                _ => stretches.push((near, end)),
            }
        }
        let mut turned = 0.0;
        let mut guess = radius - 1.0 + 0.1 * PI / count as f64;
        let mut last: Option<Node> = None;
        let mut targets: Vec<(f64, C)> = Vec::new();
        for (passed, end) in stretches {
            let from = last.as_ref().map_or(0.0, |node| node.angle);
            let changed = self.matrix.border(passed);
            let mut node = match last.take() {
                Some(node) if !changed => node,
                _ => self.node(radius, from).ok_or(SecularError::Tangency)?,
            };
            while node.angle < end {
                let other = self.step(radius, &node, end, &mut guess).ok_or(SecularError::Tangency)?;
                let [here, there] = [&node, &other].map(|node| C::from_polar(radius, node.angle));
                let turn = other.phase * node.phase.conj();
                let turn = turn.im.atan2(turn.re);
                turned +=
                    turn + self.matrix.of_bordering(radius, other.angle) - self.matrix.of_bordering(radius, node.angle);
                let newton = (there - here) / C::new(other.size - node.size, turn);
                targets.push((modulus(newton), (here + there) * 0.5 - newton));
                if targets.len() > MOST_STEPS {
                    return Err(SecularError::Tangency);
                }
                node = other;
            }
            last = Some(node);
        }
        // Half of them, against the clock's sense of z.
        let outside = -turned / PI;
        if (outside - outside.round()).abs() > 1e-6 || outside < -0.5 {
            return Err(SecularError::Tangency);
        }
        // Where Newton's method has the shortest way.
        let least = |i: usize| {
            let distance = |i: usize| targets[i].0;
            (i == 0 || distance(i - 1) >= distance(i)) && targets.get(i + 1).is_none_or(|next| next.0 >= distance(i))
        };
        let outer = (0..targets.len()).filter(|&i| least(i)).map(|i| targets[i].1).filter(|z| z.norm_sqr() >= 1.0);
        Ok(Turns { outside: outside.round() as usize, starts: outer.collect() })
    }

    /// Multiplications that a count along the unit circle takes.
    pub(crate) fn terms(&self) -> f64 {
        let (n, groups) = (self.matrix.matrix.impacts as f64, self.matrix.groups.len() as f64);
        MATRICES_OF_A_POLE * groups * (groups * 6.0 * n * (n + 1.0) + 50.0 * (2.0 * n + 10.0).powi(3))
    }

    /// All multipliers that the impacts feel.
    pub(crate) fn zeros(&self) -> usize {
        2 * self.matrix.groups.iter().map(|group| group.modes.len()).sum::<usize>()
    }
}

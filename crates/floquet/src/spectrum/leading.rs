//! What a verdict asks for: the multipliers that lead, and that all others surely do not.
//!
//! Where every pole p is simple, f = 1 + Σ ρ/(z−p) + conj. ([`Rational`]) with
//!
//! ```text
//! ρ = p·Π(m(1+e))²·cᵀ adj J(p) a,      J(p) without the pole's own dyad p/(z−p)·a cᵀ.
//! ```
//!
//! So J is worked out once for each pole, and the zeros are found together from sums of numbers. With n approximations z_i and
//! W_i = f(z_i)Π(z_i−p)/Π(z_i−z_j), all zeros are within n|W_i| of one of them (Smith); what these discs keep away from the circle that
//! the leading ones are on cannot lead. These are refined by null vectors, unless the sum itself knows them well enough.

use nalgebra::Complex;
use smallvec::SmallVec;
use vibrochain_breather::linear::{determinant, determinant_and_condition};
use vibrochain_lattice::simd::lanes::{LANES, Lane, ZERO, all, fill, four};
use wide::f64x4;

use super::function::{Pole, SpectralFunction};
use super::refine::Origin;
use super::solve::{LAST, refined};
use super::starts::{DEAD, NEGLIGIBLE, WAY};
use super::zero::Zero;
use crate::zeros::{Aberth, Rational, Value, excess, modulus};

type C = Complex<f64>;

/// Zeros closer to the leading one's modulus than this are refined as well: what the orbit's own errors do to them is not asked otherwise.
const ASIDE: f64 = 1e-5;

/// An error of the leading one beyond this says that those of the others may be large, too.
const WELL_KNOWN: f64 = 1e-8;

/// Errors of an excess, in units of the multiplier, that nobody would want to have smaller.
const PRECISE: f64 = 1e-12;

/// Poles closer than this part of their modulus are close.
const CLOSE: f64 = 1e-3;

/// A zero closer to its pole than this part of the way to the next one is no start.
const HIDDEN: f64 = 1e-2;

/// f as a sum over its poles in the upper half plane, and approximations of all its zeros: two conjugates follow each other.
pub(super) struct BySum {
    form: Rational,
    poles: Vec<C>,
    pub(super) roots: Vec<C>,
}

impl SpectralFunction<'_> {
    /// All zeros as the sum has them; `None` where another way is to be taken.
    pub(super) fn by_sum(&self) -> Option<BySum> {
        let mut form = self.rational()?;
        let (re, im) = (form.pole_re.as_flattened(), form.pole_im.as_flattened());
        let mut poles = Vec::with_capacity(re.len());
        poles.extend(re.iter().zip(im).filter(|(re, _)| **re < 1e100).map(|(re, im)| C::new(*re, *im)));
        let mut aberth = Aberth::default();
        let starts = starts(&form, &poles);
        let found = aberth.solve_from(&mut form, starts.into_iter(), 0, LAST);
        found.then_some(BySum { form, poles, roots: aberth.roots })
    }

    /// The zeros of largest modulus, refined, if it is sure that all others are smaller; `None` where another way is to be taken.
    pub(crate) fn leading(&self, data: &[Origin]) -> Option<Vec<Zero>> {
        let BySum { form, poles, roots } = self.by_sum()?;
        let reaches = discs(&form, &poles, &roots);
        let farthest = roots.iter().zip(&reaches).map(|(z, reach)| modulus(*z) - reach).fold(0.0, f64::max);
        let mut list = Vec::new();
        for (i, (z, reach)) in roots.iter().zip(&reaches).enumerate() {
            if !reach.is_finite() {
                return None;
            }
            if modulus(*z) + reach + ASIDE < farthest {
                continue;
            }
            // Its disc holds one zero alone.
            let alone = |(j, (other, own)): (usize, (&C, &f64))| j == i || modulus(z - other) > reach + own;
            if !roots.iter().zip(&reaches).enumerate().all(alone) {
                return None;
            }
            if i % 2 == 1 && *z == roots[i - 1].conj() {
                let before: Zero = *list.last()?;
                list.push(Zero { z: before.z.conj(), ..before });
                continue;
            }
            // The sum is cheap, and what it knows spares the equations a step.
            let Value { f, slope, .. } = form.evaluate(*z);
            let near = z - f / slope;
            let by_sum = if data.is_empty() { settled(&form, near) } else { None };
            let zero = by_sum.or_else(|| refined(self, near, data))?;
            if modulus(zero.z - z) > reach + zero.error || zero.error > WELL_KNOWN * (1.0 + modulus(*z)) {
                return None;
            }
            list.push(zero);
        }
        Some(list)
    }

    /// f by its poles of the upper half plane and their residues; `None` where they are not simple, or too close.
    fn rational(&self) -> Option<Rational> {
        let (modes, size) = (self.equations.kernel().modes(), self.equations.size());
        if self.shift.is_some()
            || self.equations.left_out() > NEGLIGIBLE
            || modes.iter().any(|mode| !mode.coordinates.are_circular())
        {
            return None;
        }
        let groups = (size * size).div_ceil(LANES);
        // What each mode adds: Re and Im of a complex number of its own times these, [mode][even, odd][entry].
        let mut tables = vec![[0.0; LANES]; 2 * groups * modes.len()];
        for (k, table) in tables.chunks_exact_mut(2 * groups).enumerate() {
            let (even, odd) = table.split_at_mut(groups);
            let (even, odd) = (even.as_flattened_mut(), odd.as_flattened_mut());
            for (i, row) in self.equations.rows(k).iter().enumerate() {
                for (j, column) in self.equations.columns(k).iter().enumerate() {
                    even[i * size + j] = row[0] * column[0] + row[1] * column[1];
                    odd[i * size + j] = row[0] * column[1] - row[1] * column[0];
                }
            }
        }
        let mut constant: Vec<Lane> = Vec::new();
        fill(&mut constant, self.equations.constant(false).iter().copied(), 0.0);
        let scale = self.equations.scale();
        let border = size + 1;
        let (mut matrix, mut sizes) = (vec![C::default(); border * border], Vec::new());
        let (mut poles, mut residues) = (Vec::with_capacity(modes.len()), Vec::with_capacity(modes.len()));
        let (mut residue_errors, mut pole_errors) = (Vec::with_capacity(modes.len()), Vec::with_capacity(modes.len()));
        let (mut real, mut imaginary) = (vec![ZERO; groups], vec![ZERO; groups]);
        let firsts: SmallVec<[Pole; 16]> = self.of_simple_poles().map(|k| self.poles_of(k)[0]).collect();
        for own in &firsts {
            let z = own.value;
            // What has died when the next period begins leads nowhere; of what is about to, the residue counts all the same.
            if self.equations.rows(own.mode).iter().flatten().all(|entry| *entry == 0.0) {
                continue;
            }
            if modulus(z) < DEAD {
                return None;
            }
            real.iter_mut().zip(&constant).for_each(|(entry, own)| *entry = four(*own));
            imaginary.fill(ZERO);
            let mut nearest = f64::INFINITY;
            for (other, table) in firsts.iter().zip(tables.chunks_exact(2 * groups)) {
                // p/(z−p) of both poles, of which the own one is left out.
                let mut share = |pole: C| {
                    let way = z - pole;
                    let square = way.norm_sqr();
                    nearest = nearest.min(square);
                    pole * way.conj() * square.recip()
                };
                let first = if other.mode == own.mode { C::default() } else { share(other.value) };
                let second = share(other.value.conj());
                let even = (first + second) * 0.5;
                let odd = (first - second) * C::new(0.0, -0.5);
                let (evens, odds) = table.split_at(groups);
                let [a, b, c, d] = [even.re, odd.re, even.im, odd.im].map(all);
                for g in 0..groups {
                    let (e, o): (f64x4, f64x4) = (four(evens[g]), four(odds[g]));
                    real[g] += a * e + b * o;
                    imaginary[g] += c * e + d * o;
                }
            }
            let nearest = nearest.sqrt();
            let sound = nearest > 8.0 * own.error;
            if !sound {
                return None;
            }
            let [a, c] = self.dyad(own);
            for i in 0..size {
                for j in 0..size {
                    let (group, lane) = ((i * size + j) / LANES, (i * size + j) % LANES);
                    matrix[i * border + j] = C::new(real[group].to_array()[lane], imaginary[group].to_array()[lane]);
                }
                matrix[i * border + size] = a[i];
                matrix[size * border + i] = c[i];
            }
            matrix[size * border + size] = C::default();
            // Far from other poles nothing much cancels in the determinant; else its own condition tells.
            let (bordered, condition) = if nearest > CLOSE * modulus(z) {
                (determinant(&mut matrix, border), 1.0)
            } else {
                determinant_and_condition(&mut matrix, &mut sizes, border)
            };
            let residue = -bordered * z * scale;
            let size_of = modulus(residue);
            let error = f64::EPSILON * 16.0 + self.relative(own.mode) + own.error / nearest;
            poles.push(if z.im < 0.0 { z.conj() } else { z });
            residues.push(if z.im < 0.0 { residue.conj() } else { residue });
            residue_errors.push(size_of * error * condition.max(1.0));
            pole_errors.push(size_of * own.error);
        }
        if poles.is_empty() {
            return None;
        }
        let mut form = Rational::default();
        fill(&mut form.pole_re, poles.iter().map(|pole| pole.re), 1e100);
        fill(&mut form.pole_im, poles.iter().map(|pole| pole.im), 0.0);
        fill(&mut form.residue_re, residues.iter().map(|residue| residue.re), 0.0);
        fill(&mut form.residue_im, residues.iter().map(|residue| residue.im), 0.0);
        fill(&mut form.residue_error, residue_errors.into_iter(), 0.0);
        fill(&mut form.pole_error, pole_errors.into_iter(), 0.0);
        Some(form)
    }
}

/// A pair beside each pole, where the zero is to first order of its own residue.
fn starts(form: &Rational, poles: &[C]) -> Vec<C> {
    let beside = |(k, pole): (usize, &C)| {
        let others = poles.iter().enumerate().filter(|(l, _)| *l != k).map(|(_, other)| modulus(other - pole));
        let gap = others.fold(modulus(*pole).min(2.0 * pole.im), f64::min);
        let offset = form.beside(k).filter(|offset| modulus(*offset) > HIDDEN * gap);
        let offset = offset.unwrap_or(C::new(0.0, HIDDEN * gap));
        let z = pole + offset * (WAY * gap / modulus(offset)).min(1.0);
        let z = C::new(z.re, z.im.abs().max(1e-3 * gap));
        [z, z.conj()]
    };
    poles.iter().enumerate().flat_map(beside).collect()
}

/// A zero, if the sum knows it, and its side of the circle, as well as anybody would want to.
fn settled(form: &Rational, z: C) -> Option<Zero> {
    let Value { f, slope, noise, .. } = form.evaluate(z);
    let left = form.doubt(z) + modulus(f) + f64::EPSILON * noise;
    let error = left / modulus(slope) + 2.0 * f64::EPSILON * modulus(z);
    let excess = excess(z).abs();
    (error <= PRECISE * (1.0 + excess) && excess > error).then(|| Zero { error, ..Zero::new(z, true) })
}

/// n|W_i| of all approximations.
fn discs(form: &Rational, poles: &[C], roots: &[C]) -> Vec<f64> {
    let mut reaches = Vec::with_capacity(roots.len());
    for (i, z) in roots.iter().enumerate() {
        if i % 2 == 1 && *z == roots[i - 1].conj() {
            reaches.push(reaches[i - 1]);
            continue;
        }
        let value = form.evaluate(*z);
        let size = modulus(value.f) + f64::EPSILON * value.noise + form.doubt(*z);
        // Poles and approximations come in the same order: no product of some of them is large or small.
        let others = roots.iter().enumerate().map(|(j, other)| if i == j { 1.0 } else { (z - other).norm_sqr() });
        let ways = poles.iter().flat_map(|pole| [(z - pole).norm_sqr(), (z - pole.conj()).norm_sqr()]);
        let square: f64 = ways.zip(others).map(|(way, other)| way / other).product();
        reaches.push(roots.len() as f64 * size * square.sqrt());
    }
    reaches
}

#[cfg(test)]
mod tests;

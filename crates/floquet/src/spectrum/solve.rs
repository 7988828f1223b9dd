//! All zeros: found together, refined one by one or, where they are too close for that, together, and counted.

use nalgebra::Complex;
use vibrochain_breather::BlochEquations;
use vibrochain_lattice::{Coordinates, Turn};

use super::function::{OfHalfSum, SpectralFunction, outer};
use super::refine::{Origin, Refined};
use super::starts::{DEAD, NEGLIGIBLE, Starts};
use super::zero::Zero;
use crate::zeros::{Aberth, Last, Nu, modulus};

type C = Complex<f64>;

/// The iteration is of third order: a step of this part of what lies between zeros leaves Newton's method next to nothing to do.
pub(super) const LAST: Last = Last { of_modulus: 1e-13, of_distance: 1e-3 };

/// An error this many times smaller than the distance to the next zero is one of first order.
const ALONE: f64 = 8.0;

/// Attempts to find what a first one has missed, and the most zeros that are sought so.
const MENDS: usize = 3;
const MOST_MISSING: usize = 8;

/// Room for what estimates of errors leave out in the checks of sum and product.
const ROOM: f64 = 16.0;

/// All zeros of f.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Zeros {
    /// Without those that are known to begin with.
    pub(crate) list: Vec<Zero>,
    /// They are zeros in ν, of two multipliers each.
    pub(crate) reciprocal: bool,
    /// How many at the end of the list have died out within a period.
    pub(crate) dead: usize,
    /// Every one is apart from the rest, and their sum and product are what they must be.
    pub(crate) certified: bool,
}

/// Whether neither impacts nor modes lose energy: a multiplier comes with its inverse.
pub(super) fn is_reciprocal(equations: &BlochEquations) -> bool {
    let (modes, impacts) = (equations.kernel().modes(), equations.impacts());
    impacts.iter().all(|impact| impact.restitution == 1.0)
        && modes.iter().all(|mode| {
            let turns = [Turn::Circular, Turn::Parabolic].map(Coordinates::Shared);
            mode.decay == 0.0 && turns.contains(&mode.coordinates)
        })
}

/// Whether an impact takes all velocity.
fn is_plastic(equations: &BlochEquations) -> bool {
    equations.impacts().iter().any(|impact| impact.restitution == 0.0)
}

/// All multipliers of the modes that feel the impacts, but the trivial pair of a conservative orbit, where each mode's poles are its own.
pub(super) fn zeros_apart(equations: &BlochEquations, conservative: bool, data: &[Origin]) -> Zeros {
    let reciprocal = is_reciprocal(equations);
    let function = SpectralFunction::new(equations, conservative);
    let trivial = match (&function.shift, conservative) {
        (_, false) => Trivial::None,
        (Some(_), true) => Trivial::LeftOut,
        (None, true) => Trivial::Known,
    };
    let mut search = Search { function, reciprocal, trivial, data };
    // The sum has no digits next to 0, where a plastic impact leaves a zero.
    let by_sum = if reciprocal || is_plastic(equations) { None } else { search.function.by_sum() };
    if let Some(sum) = by_sum.filter(|sum| sum.roots.len() == search.function.poles.len()) {
        let all = search.told_apart(sum.roots, Vec::new());
        if all.certified {
            return all;
        }
    }
    let starts = search.function.starts();
    let mut first = search.attempt(starts);
    for _ in 0..MENDS {
        if first.certified {
            return first;
        }
        let Some(mended) = search.mend(&first) else { break };
        first = mended;
    }
    if first.certified {
        return first;
    }
    // Two that have ended at one zero have begun too close to it.
    let starts = search.function.turned_starts();
    let turned = search.attempt(starts);
    if turned.certified { turned } else { first }
}

struct Search<'a> {
    function: SpectralFunction<'a>,
    reciprocal: bool,
    trivial: Trivial,
    data: &'a [Origin],
}

/// What becomes of the trivial pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Trivial {
    /// There is none.
    None,
    /// The function has it: two zeros that are known.
    Known,
    /// The function is without it.
    LeftOut,
}

impl Search<'_> {
    /// All zeros from these starts; of what is dead they are known.
    fn attempt(&mut self, Starts { dead: mut starts, single, pairs }: Starts) -> Zeros {
        let half_sum = |z: C| (z + z.inv()) * 0.5;
        let (dead, per_mode) = (starts.len(), self.per_mode());
        starts.extend(single);
        let from = if pairs.is_empty() { dead } else { starts.len() };
        if self.reciprocal {
            starts.extend(pairs.iter().map(|pair| half_sum(pair[0])));
        } else {
            starts.extend(pairs.into_iter().flatten());
        }
        let mut known = dead;
        if self.trivial != Trivial::None && starts.len() >= dead + per_mode {
            // In place of the starts next to +1.
            let distance = |k: &usize| modulus(starts[*k] - 1.0);
            let first = (from..starts.len()).step_by(per_mode).min_by(|a, b| distance(a).total_cmp(&distance(b)));
            for k in 0..per_mode {
                starts.swap(dead + k, first.unwrap_or(dead) + k);
                starts[dead + k] = C::new(1.0, 0.0);
            }
            if self.trivial == Trivial::Known {
                known += per_mode;
            } else {
                starts.drain(dead..dead + per_mode);
            }
        }
        self.solve(starts, dead, known)
    }

    /// All zeros from starts of which the first `dead` have died out and stay, and more up to `known` stay.
    fn solve(&mut self, starts: Vec<C>, dead: usize, known: usize) -> Zeros {
        let mut aberth = Aberth::default();
        if self.reciprocal {
            aberth.solve_from(&mut OfHalfSum(&mut self.function), starts.into_iter(), known, LAST);
        } else {
            aberth.solve_from(&mut self.function, starts.into_iter(), known, LAST);
        }
        let trivial = if self.trivial == Trivial::Known { self.per_mode() } else { 0 };
        let roots = aberth.roots.split_off(dead + trivial);
        let mut gone = aberth.roots;
        gone.truncate(dead);
        self.told_apart(roots, gone)
    }

    /// The zeros next to approximations, told apart and counted, and those that have gone to 0.
    fn told_apart(&mut self, mut roots: Vec<C>, mut gone: Vec<C>) -> Zeros {
        // Next to z = 0 rows and columns of J vanish. Scaled to equal size they are rounding, and refinement ends at another zero.
        if !self.reciprocal {
            gone.extend(roots.extract_if(.., |z| modulus(*z) < DEAD));
            if gone.is_empty() {
                gone.extend(self.left_by_plastic_impacts(&mut roots));
            }
        }
        let dead = gone.len();
        let mut list = self.settled(&roots);
        // A multiplier that has died out is not told from 0; how small those are the product of all says.
        let error = DEAD.max(self.left_for(&list, dead));
        list.extend(gone.into_iter().map(|z| Zero { error, rounding: error, ..Zero::new(z, true) }));
        let known_enough = |zero: &Zero| zero.apart && zero.error <= USELESS * (1.0 + modulus(zero.z));
        // Where two meet the iteration creeps, and does not end; what counts is that each is told from the rest.
        let missed = if list.iter().all(known_enough) { self.missed_by_sum(&list) } else { None };
        // A pencil is straight, which its zeros are not: what their sum lacks any of them may be off by.
        list.iter_mut().filter(|zero| !zero.alone).for_each(|zero| zero.error += missed.unwrap_or(0.0));
        let certified = missed.is_some() && list.iter().all(known_enough);
        let certified = certified && self.function.equations.left_out() <= NEGLIGIBLE;
        Zeros { list, dead, reciprocal: self.reciprocal, certified }
    }

    /// The root that is exactly 0 where an impact takes all velocity: that leaves its contact on the barrier and at rest, two numbers of which
    /// time makes up for one. The iteration creeps there; next to 0 alone it is this one.
    fn left_by_plastic_impacts(&self, roots: &mut Vec<C>) -> Option<C> {
        let least = (0..roots.len()).min_by(|&a, &b| modulus(roots[a]).total_cmp(&modulus(roots[b])))?;
        let next = (0..roots.len()).filter(|&k| k != least).map(|k| modulus(roots[k])).fold(f64::INFINITY, f64::min);
        let is_next_to_zero = modulus(roots[least]) < CREEPING.min(CREEPING.sqrt() * next);
        (is_plastic(&self.function.equations) && is_next_to_zero).then(|| {
            roots.remove(least);
            C::default()
        })
    }

    /// The geometric mean of so many multipliers beside those of the list, by the product of all.
    fn left_for(&self, list: &[Zero], dead: usize) -> f64 {
        if dead == 0 {
            return 0.0;
        }
        let known: f64 = list.iter().map(|zero| modulus(zero.z).ln()).sum();
        ((self.logarithms().iter().sum::<f64>() - known) / dead as f64).exp()
    }

    /// ln Π|μ|: what is lost at impacts, and what in dashpots.
    fn logarithms(&self) -> [f64; 2] {
        let (impacts, kernel) = (self.function.equations.impacts(), self.function.equations.kernel());
        let at_impacts: f64 = impacts.iter().map(|impact| 2.0 * impact.restitution.ln()).sum();
        let decay: f64 = kernel.modes().iter().map(|mode| mode.decay).sum();
        [at_impacts, -2.0 * decay * kernel.period()]
    }

    /// Zeros in their plane that belong to one mode.
    fn per_mode(&self) -> usize {
        if self.reciprocal { 1 } else { 2 }
    }

    /// Once more with the zeros that have been told apart, and others in place of those that have been found twice or not at all: the sum of
    /// all says where these are, and which one it is if there is only one.
    fn mend(&mut self, failed: &Zeros) -> Option<Zeros> {
        let count = failed.list.len() - failed.dead;
        let (mut kept, mut missing): (Vec<C>, usize) = (Vec::with_capacity(count), 0);
        let mut taken: Vec<&Zero> = Vec::with_capacity(count);
        for zero in &failed.list[..count] {
            let again = taken.iter().any(|other| self.distance(zero, other) <= ALONE * (zero.error + other.error));
            let known = zero.settled || zero.held;
            if known && (zero.apart || !again) && zero.error <= USELESS * (1.0 + modulus(zero.z)) {
                taken.push(zero);
                kept.push(if self.reciprocal { zero.nu.complex() } else { zero.z });
            } else {
                missing += 1;
            }
        }
        let (trace, _) = self.function.trace()?;
        if missing == 0 || missing > MOST_MISSING {
            return None;
        }
        let trivial = if self.trivial == Trivial::None { 0.0 } else { 2.0 };
        let dead = &failed.list[count..];
        let half = if self.reciprocal { 0.5 } else { 1.0 };
        let left = (trace - trivial) * half - kept.iter().sum::<C>() - dead.iter().map(|zero| zero.z).sum::<C>() * half;
        let centre = left / missing as f64;
        if !(centre.re.is_finite() && centre.im.is_finite()) {
            return None;
        }
        let around = |k: usize| match missing {
            1 => C::new(centre.re, 1e-3 * f64::EPSILON.sqrt()),
            _ => {
                centre
                    + C::from_polar(
                        0.1 * (1.0 + modulus(centre)),
                        0.7 + std::f64::consts::TAU * k as f64 / missing as f64,
                    )
            }
        };
        let mut starts: Vec<C> = dead.iter().map(|zero| zero.z).collect();
        if self.trivial == Trivial::Known {
            starts.extend(std::iter::repeat_n(C::new(1.0, 0.0), self.per_mode()));
        }
        starts.extend(kept);
        let known = starts.len();
        starts.extend((0..missing).map(around));
        Some(self.solve(starts, failed.dead, known))
    }

    /// Distance of two zeros in their plane.
    fn distance(&self, a: &Zero, b: &Zero) -> f64 {
        if !self.reciprocal {
            return modulus(a.z - b.z);
        }
        let close = |from: fn(&Nu) -> f64| (from(&a.nu) - from(&b.nu)).abs();
        close(|nu| nu.below).min(close(|nu| nu.above)).hypot(a.nu.im - b.nu.im)
    }

    /// A refined multiplier in its plane.
    fn placed(&self, Refined { z, error, rounding }: Refined, settled: bool) -> Zero {
        if self.reciprocal {
            return Zero::of_pair(z, [error, rounding], settled);
        }
        Zero { error, rounding, ..Zero::new(z, settled) }
    }

    /// The multiplier next to an approximation in its plane.
    fn multiplier(&self, root: C) -> C {
        if self.reciprocal { outer(root) } else { root }
    }

    /// The zeros next to approximations, no two the same.
    fn settled(&mut self, roots: &[C]) -> Vec<Zero> {
        let count = roots.len();
        let mut zeros: Vec<Zero> = Vec::with_capacity(count);
        let mut plain: Vec<bool> = Vec::with_capacity(count);
        for (i, root) in roots.iter().enumerate() {
            // The first of two conjugates has been refined for both.
            if i % 2 == 1 && !self.reciprocal && *root == roots[i - 1].conj() && plain[i - 1] {
                zeros.push(Zero { z: zeros[i - 1].z.conj(), ..zeros[i - 1] });
                plain.push(true);
                continue;
            }
            let z = self.multiplier(*root);
            let refined = self.function.refine(z, self.data);
            plain.push(refined.is_some());
            zeros.push(self.placed(refined.unwrap_or(Refined::begun(z)), refined.is_some()));
        }
        let near = |search: &Self, a: &Zero, b: &Zero| search.distance(a, b) <= ALONE * (a.error + b.error);
        let mut group: Vec<usize> = (0..count).collect();
        for i in 0..count {
            for j in i + 1..count {
                if near(self, &zeros[i], &zeros[j]) && group[i] != group[j] {
                    let (keep, drop) = (group[i].min(group[j]), group[i].max(group[j]));
                    group.iter_mut().filter(|own| **own == drop).for_each(|own| *own = keep);
                }
            }
        }
        for first in 0..count {
            let members: Vec<usize> = (first..count).filter(|&i| group[i] == first).collect();
            if group[first] != first || members.len() == 1 && plain[first] {
                continue;
            }
            self.settle_group(&members, roots, members.iter().all(|&i| plain[i]), &mut zeros);
        }
        for i in 0..count {
            let apart = (0..count).all(|j| group[j] == group[i] || !near(self, &zeros[i], &zeros[j]));
            zeros[i].apart = apart;
        }
        self.symmetric(&mut zeros);
        zeros
    }

    /// Zeros that are not told apart, together; `plain` if each has been refined by itself.
    fn settle_group(&self, members: &[usize], roots: &[C], plain: bool, zeros: &mut [Zero]) {
        let centre = members.iter().map(|&i| roots[i]).sum::<C>() / members.len() as f64;
        let farthest = members.iter().map(|&i| modulus(roots[i] - centre)).fold(0.0, f64::max);
        let together = self.function.refine_together(self.multiplier(centre), members.len(), self.data);
        let found = together.map(|(found, held)| {
            // Two in ν that nothing holds on the real axis may have left it.
            let settled = held || !self.reciprocal;
            let zero = |refined| Zero { held, alone: false, ..self.placed(refined, settled) };
            found.into_iter().map(zero).collect::<Vec<_>>()
        });
        let begun = self.placed(Refined::begun(self.multiplier(centre)), false);
        // A pencil that leads away did not have this many zeros close together.
        let here = |zero: &Zero| self.distance(zero, &begun) <= STRAY * (farthest + zero.error);
        let Some(found) = found.filter(|found| found.iter().all(here)) else {
            // Nothing is known of what no null vector leads to.
            let begun = |i: usize| self.placed(Refined::begun(self.multiplier(roots[i])), false);
            return members.iter().for_each(|&i| zeros[i] = Zero { error: f64::INFINITY, ..begun(i) });
        };
        let clear =
            |i: usize, j: usize| self.distance(&zeros[i], &zeros[j]) > ALONE * (zeros[i].rounding + zeros[j].rounding);
        if !(plain && members.iter().all(|&i| members.iter().all(|&j| i == j || clear(i, j)))) {
            return members.iter().zip(found).for_each(|(&i, zero)| zeros[i] = zero);
        }
        // The orbit's own errors mix them, and rounding does not: each stays where it is. A pencil that misses one knows its error no better.
        let missed = |&i: &usize| found.iter().map(|zero| self.distance(zero, &zeros[i])).fold(f64::INFINITY, f64::min);
        let reach = found.iter().map(|zero| zero.error).fold(0.0, f64::max);
        let error = reach + members.iter().map(missed).fold(0.0, f64::max);
        let (held, settled) = (found[0].held, found[0].settled);
        members.iter().for_each(|&i| zeros[i] = Zero { error, held, settled, ..zeros[i] });
    }

    /// Complex zeros in exactly conjugate pairs, real ones without imaginary part.
    fn symmetric(&self, zeros: &mut [Zero]) {
        let mirror = |zero: &Zero| Zero { z: zero.z.conj(), nu: Nu { im: -zero.nu.im, ..zero.nu }, ..*zero };
        let height = |zero: &Zero| if self.reciprocal { zero.nu.im.abs() } else { zero.z.im.abs() };
        let mut done = vec![false; zeros.len()];
        for i in 0..zeros.len() {
            if done[i] {
                continue;
            }
            done[i] = true;
            let image = mirror(&zeros[i]);
            let partner = (0..zeros.len())
                .filter(|&j| !done[j])
                .map(|j| (j, self.distance(&zeros[j], &image)))
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .filter(|(_, distance)| *distance < 2.0 * height(&zeros[i]));
            if let Some((j, _)) = partner {
                let error = zeros[i].error.max(zeros[j].error);
                let rounding = zeros[i].rounding.max(zeros[j].rounding);
                let both = |own: fn(&Zero) -> bool| own(&zeros[i]) && own(&zeros[j]);
                let (settled, apart) = (both(|zero| zero.settled), both(|zero| zero.apart));
                let (held, alone) = (both(|zero| zero.held), both(|zero| zero.alone));
                zeros[i] = Zero { error, rounding, settled, alone, apart, held, ..zeros[i] };
                zeros[j] = mirror(&zeros[i]);
                done[j] = true;
            } else {
                let off = height(&zeros[i]);
                zeros[i].error += off;
                zeros[i].rounding += off;
                if self.reciprocal {
                    zeros[i].nu.im = 0.0;
                    zeros[i].z = zeros[i].nu.multipliers()[0];
                } else {
                    zeros[i].z.im = 0.0;
                }
            }
        }
    }

    /// What the sum of all multipliers is off by beyond what those explain that are told apart; `None` where it or their product are not those of
    /// the poles plus what the impacts make of them: f = 1 + tr(J₀⁻¹ΣARC)/z + … far out, f(0) = Πe². The equations count as they are: errors of
    /// the orbit's data, large next to a resonance, would leave room for a zero.
    fn missed_by_sum(&self, list: &[Zero]) -> Option<f64> {
        let both = |zero: &Zero| if self.reciprocal { zero.nu.multipliers().to_vec() } else { vec![zero.z] };
        let mut all: Vec<C> = list.iter().flat_map(both).collect();
        all.extend(std::iter::repeat_n(C::new(1.0, 0.0), if self.trivial == Trivial::None { 0 } else { 2 }));
        if all.len() != self.function.poles.len() {
            return None;
        }
        let scale = 1.0 + self.function.poles.iter().map(|pole| modulus(*pole)).sum::<f64>();
        // Of those that are not told apart the sum is known all the same: the iteration has found them together.
        let told = |alone: bool| list.iter().filter(move |zero| zero.alone == alone && (zero.settled || zero.held));
        let [alone, together] = [true, false].map(|own| 2.0 * told(own).map(|zero| zero.rounding).sum::<f64>());
        let (trace, trace_error) = self.function.trace()?;
        let sum: C = all.iter().sum();
        let sizes: f64 = all.iter().map(|z| modulus(*z)).sum::<f64>() + modulus(trace);
        let known = ROOM * (alone + f64::EPSILON * scale * all.len() as f64 + trace_error) + CLOSED * sizes;
        let missed = modulus(sum - trace) - known;
        let is_idle = known > TELLING * sizes && !list.iter().all(|zero| zero.alone);
        let by_sum = !is_idle && missed <= ROOM * together;
        if self.reciprocal || !by_sum {
            return by_sum.then_some(missed.max(0.0));
        }
        let relative: f64 = list.iter().map(|zero| (zero.rounding / modulus(zero.z)).min(1.0)).sum();
        let logarithm: f64 = all.iter().map(|z| modulus(*z).ln()).sum();
        let [losses, poles] = self.logarithms();
        // One that is 0 to rounding has no logarithm to speak of.
        let by_product = relative > 0.5
            || (logarithm - losses - poles).abs() <= ROOM * relative + CLOSED * (1.0 + losses.abs() + poles.abs());
        by_product.then_some(missed.max(0.0))
    }
}

/// One zero next to an approximation in the plane of z.
pub(super) fn refined(function: &SpectralFunction<'_>, start: C, data: &[Origin]) -> Option<Zero> {
    let Refined { z, error, rounding } = function.refine(start, data)?;
    Some(Zero { error, rounding, ..Zero::new(z, true) })
}

/// How far, of their sizes, sum and product may be off beyond what errors explain: two zeros that are one are off by their distance from
/// the one that is missing, and where poles crowd that is small.
const CLOSED: f64 = 1e-11;

/// A sum that is unknown by more than this part of its terms says little of how many zeros are where several were refined together.
const TELLING: f64 = 1e-6;

/// A zero counts as found only if its error is at most this part of its size.
const USELESS: f64 = 1e-2;

/// A root this close to 0 may be 0.
const CREEPING: f64 = 1e-4;

/// How far, as a multiple of their distances and errors, several zeros may be from where they were sought together.
const STRAY: f64 = 100.0;

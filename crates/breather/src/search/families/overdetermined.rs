//! Words of two instants without force whose impacts no symmetry makes alike: where Newton's law cannot hold for φ ≠ T/2.
//!
//! With the impulses P(δ) of `positions`, Newton's law is several rows R_i(δ) = Σ_j P_j s_ij, s = −K′, for one unknown, δ. As a rule
//! nothing solves them but δ = 0, where all s vanish; to show it an interval is discarded as soon as one row cannot vanish on it, and
//! halved otherwise. As P grows without bound where the positions are singular, x = τ (P, s, 1) takes its place, with c·x = 1 for c
//! about the direction of x: M(δ) x = (0, …, 0, 1) is regular. About the centre of an interval, with radius r and bounds B₂, B₃ on |K″|,
//! |K‴|,
//!
//! ```text
//! |K̂_ij − K̂_ij(c)| ≤ e_ij = |s_ij(c)| r + ½B₂r²           hence  |x − x(c)| ≤ 2u,  u = |M⁻¹| e |x|,  where |M⁻¹| e u ≤ ½u
//! |s_ij − s_ij(c)| ≤ |s′_ij(c)| r + ½B₃r²                    or next to δ = 0
//! |s_ij/δ − s_ij(c)/c| ≤ ½B₃r                                (s/δ is the mean of s′ on 0 … δ)
//! ```
//!
//! Impacts that symmetries turn into each other, with the instants exchanged in time where that leaves the word as it is, have one
//! impulse but for signs σ and are one unknown: where the other combinations of impulses are undetermined, Newton's law summed over the
//! symmetries does not feel them.
//!
//! The rows of s/δ do not vanish at δ = 0. If no mass is hit at both instants all s vanish at φ = 0, too, and there s/(T/2−δ) takes the
//! place of s/δ.

use vibrochain_lattice::KernelJet;

use crate::equations::System;
use crate::equations::linear::{Matrix, Vector, dot};
use crate::orbit::WRONG_SIGN;
use crate::roots::interval::Zeros;
use crate::search::families::positions::Positions;
use crate::search::families::two_instants::{APART, UNFELT, pieces};

/// Intervals are not halved below this part of half a period.
const FINEST: f64 = 1e-9;

/// Intervals that a search may take, as one function's may; most take fewer than 500.
const MOST_INTERVALS: usize = 20_000;

/// The most terms that a search may add up in sums over modes: seconds on large lattices.
const MOST_TERMS: usize = 100_000_000;

/// Intervals longer than this part of their distance to a place where all s vanish take s/δ, others s itself, which is known better.
const NEAR: f64 = 0.25;

/// Rounding of kernels relative to their terms: eight times what enclosures allow for (`taylor`).
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Adds the places of 0 < δ < T/2 where all rows may vanish to the unresolved ones; with `judged` those alone where every impulse can
/// have the right sign.
pub(crate) fn search(positions: &Positions<'_>, classes: &[usize], judged: bool, zeros: &mut Zeros) {
    let response = positions.response();
    let (half, count) = (0.5 * response.period(), pieces(response));
    let rows = Rows::new(positions, classes, judged);
    if rows.apart && !rows.are_felt() {
        zeros.exhausted += 1;
        return;
    }
    let most =
        zeros.intervals + (MOST_TERMS / (response.modes() * rows.bounds.len())).clamp(count, MOST_INTERVALS.max(count));
    let (from, to) = (APART * half, half * (1.0 - APART));
    let end = |i: usize| from + (to - from) * (i as f64 / count as f64);
    let mut stack: Vec<(f64, f64)> = (0..count).rev().map(|i| (end(i), end(i + 1))).collect();
    while let Some((low, high)) = stack.pop() {
        if zeros.intervals >= most || zeros.stop.is_raised() {
            zeros.exhausted += stack.len() + 1;
            return;
        }
        zeros.intervals += 1;
        let (centre, radius) = (0.5 * (low + high), 0.5 * (high - low));
        if rows.exclude(centre, radius) {
            continue;
        }
        if radius > FINEST * half {
            stack.extend([(centre, high), (low, centre)]);
        } else if zeros.unresolved.last().is_none_or(|&last| centre - last > 8.0 * radius) {
            zeros.unresolved.push(centre);
        }
    }
}

/// What the rows of a word are made of.
struct Rows<'a, 'b> {
    positions: &'a Positions<'b>,
    /// The class of each impact, and the first impact of each class.
    classes: &'a [usize],
    heads: Vec<usize>,
    judged: bool,
    /// No mass is hit at both instants.
    apart: bool,
    /// Of each pair of masses what its modes have of the kernel, what its static part lacks, and B₁ to B₄.
    shapes: Vec<Vec<f64>>,
    drops: Vec<f64>,
    bounds: Vec<[f64; 4]>,
    half: f64,
}

/// The rows of s/δ about a place, by head and class, and how far they can be off.
struct Slopes {
    rows: Matrix,
    wide: Matrix,
}

/// τ (P, s, 1) of the classes about a place, and how far it can be off.
struct Impulses {
    scaled: Vector,
    doubt: Vector,
}

impl<'a, 'b> Rows<'a, 'b> {
    fn new(positions: &'a Positions<'b>, classes: &'a [usize], judged: bool) -> Self {
        let response = positions.response();
        let shapes = positions.each_pair(|one, other| response.shapes().evens(one, other).collect::<Vec<f64>>());
        let bounds = shapes.iter().map(|shapes| response.derivative_bounds_of(shapes)).collect();
        // As the positions have it half a period apart.
        let drop = |(shapes, still): (&Vec<f64>, &[f64; 2])| response.jet_of(shapes, 0.0).value - still[1];
        let drops = shapes.iter().zip(&positions.still).map(drop).collect();
        let count = classes.iter().max().map_or(0, |last| last + 1);
        let heads = (0..count).filter_map(|class| classes.iter().position(|other| *other == class)).collect();
        let (apart, half) = (!positions.share_masses(), 0.5 * response.period());
        Self { positions, classes, heads, judged, apart, shapes, drops, bounds, half }
    }

    /// Whether masses hit at one instant feel those hit at the other: else all hit whenever they like.
    fn are_felt(&self) -> bool {
        let positions = self.positions;
        let felt = |jet: &KernelJet, bounds: &[f64; 4]| jet.slope.abs() > UNFELT * bounds[0];
        (1..8).any(|i| {
            let jets = self.jets(self.half * f64::from(i) / 8.0);
            let across = |i: usize, j: usize| positions.is_across(i, j).then(|| positions.pair(i, j));
            let mut pairs = (0..positions.hits.len()).flat_map(|i| (0..i).filter_map(move |j| across(i, j)));
            pairs.any(|pair| felt(&jets[pair], &self.bounds[pair]))
        })
    }

    /// Kernels of each pair of masses at φ.
    fn jets(&self, delta: f64) -> Vec<KernelJet> {
        let response = self.positions.response();
        let pairs = self.shapes.iter().zip(&self.drops);
        pairs
            .map(|(shapes, drop)| {
                let jet = response.jet_of(shapes, delta);
                KernelJet { value: jet.value - drop, ..jet }
            })
            .collect()
    }

    /// The barrier's sign of an impact, that of its impulse in its class.
    fn sign(&self, impact: usize) -> f64 {
        self.positions.hits[impact].0.barrier.sign()
    }

    /// Of what acts from each impact on each, what acts on the head of a class from all of another, by the pair of masses and by whether
    /// they hit at different instants.
    fn summed(&self, signed: bool, of: impl Fn(usize, bool) -> f64) -> Matrix {
        let mut sums = Matrix::zeros(self.heads.len());
        for (row, &i) in self.heads.iter().enumerate() {
            for (j, &class) in self.classes.iter().enumerate() {
                let sign = if signed { self.sign(i) * self.sign(j) } else { 1.0 };
                sums[(row, class)] += sign * of(self.positions.pair(i, j), self.positions.is_across(i, j));
            }
        }
        sums
    }

    /// Whether no orbit of the word has its δ within `radius` of `centre`.
    fn exclude(&self, centre: f64, radius: f64) -> bool {
        let jets = self.jets(centre);
        let slopes = self.slopes(&jets, centre, radius);
        if self.judged && slopes.are_one_way() {
            return true;
        }
        let Some(impulses) = self.impulses(&jets, radius) else { return false };
        self.judged && impulses.point_both_ways() || slopes.exclude(&impulses)
    }

    fn slopes(&self, jets: &[KernelJet], centre: f64, radius: f64) -> Slopes {
        let distance = if self.apart { centre.min(self.half - centre) } else { centre };
        let near = radius > NEAR * distance;
        let scale = if near { distance } else { 1.0 };
        let slope = |pair: usize| jets[pair].slope / scale;
        let wide = |pair: usize| {
            let [first, second, third, _] = self.bounds[pair];
            if near {
                0.5 * third * radius + ROUNDING * (slope(pair).abs() + second)
            } else {
                let bend = jets[pair].curvature.abs() + 0.5 * third * radius;
                bend * radius + ROUNDING * (slope(pair).abs() + first)
            }
        };
        Slopes {
            rows: self.summed(true, |pair, across| if across { slope(pair) } else { 0.0 }),
            wide: self.summed(false, |pair, across| if across { wide(pair) } else { 0.0 }),
        }
    }

    /// `None` where too little is known of them.
    fn impulses(&self, jets: &[KernelJet], radius: f64) -> Option<Impulses> {
        let (positions, n) = (self.positions, self.heads.len());
        let kernels =
            self.summed(true, |pair, across| if across { jets[pair].value } else { positions.still[pair][0] });
        let net = |class: usize| {
            self.classes.iter().enumerate().filter(|(_, of)| **of == class).map(|(j, _)| self.sign(j)).sum::<f64>()
        };
        // Where an exchange of the barriers is among the symmetries nothing is held up: s = 0.
        let held = if (0..n).all(|class| net(class) == 0.0) { 1.0 } else { positions.response().static_stiffness() };
        let matrix = Matrix::from_fn(n + 1, |i, j| match (i < n, j < n) {
            (true, true) => kernels[(i, j)],
            (true, false) => self.sign(self.heads[i]),
            (false, true) => net(j),
            (false, false) => -held,
        });
        let stops: Vector = self.heads.iter().map(|&i| self.sign(i) * positions.stops[i]).chain([0.0]).collect();
        // Impulses are like those of a mass that crosses the gap in half a period.
        let units: Vector = (0..n).map(|_| positions.response().omega()).chain([1.0, 1.0]).collect();
        let mut scaled = matrix.solve(&stops)?;
        scaled.push(1.0);
        let length = scaled.iter().zip(&units).map(|(x, unit)| (x / unit).powi(2)).sum::<f64>().sqrt();
        if !length.is_finite() {
            return None;
        }
        scaled.iter_mut().for_each(|x| *x /= length);
        let border: Vector = scaled.iter().zip(&units).map(|(x, unit)| x / (unit * unit)).collect();
        let stops: Vector = stops.iter().map(|stop| -stop).collect();
        let system = System::new(matrix.bordered(&stops, &border), &units);
        // e, with the worst signs.
        let changes = self.summed(false, |pair, across| {
            let change = jets[pair].slope.abs() * radius + 0.5 * self.bounds[pair][1] * radius * radius;
            let rounding = ROUNDING * jets[pair].value.abs().max(positions.still[pair][0].abs());
            if across { change + rounding } else { rounding }
        });
        let moved = |by: &[f64]| -> Vector {
            let sizes: Vector = by[..n].iter().map(|x| x.abs()).collect();
            (0..n + 2).map(|i| if i < n { dot(changes.row(i), &sizes) } else { 0.0 }).collect()
        };
        let first = system.spread(&moved(&scaled));
        let second = system.spread(&moved(&first));
        let shrinks = second.iter().zip(&first).all(|(second, first)| *second <= 0.5 * first);
        shrinks.then(|| Impulses { scaled, doubt: first.iter().map(|first| 2.0 * first).collect() })
    }
}

impl Slopes {
    /// Some row has terms of one sign alone, if every impulse has the right one.
    fn are_one_way(&self) -> bool {
        let n = self.rows.size();
        (0..n).any(|i| {
            let felt = || (0..n).filter(|&j| self.wide[(i, j)] > 0.0);
            let surely = |sign: f64| felt().all(|j| sign * self.rows[(i, j)] > self.wide[(i, j)]);
            felt().next().is_some() && (surely(1.0) || surely(-1.0))
        })
    }

    /// Some row cannot vanish.
    fn exclude(&self, Impulses { scaled, doubt }: &Impulses) -> bool {
        let n = self.rows.size();
        (0..n).any(|i| {
            let (rows, wide) = (self.rows.row(i), self.wide.row(i));
            let doubts = (0..n).map(|j| wide[j] * scaled[j].abs() + (rows[j].abs() + wide[j]) * doubt[j]).sum();
            dot(rows, &scaled[..n]).abs() > doubts
        })
    }
}

impl Impulses {
    /// Two impulses surely point different ways, or one surely points the wrong way.
    fn point_both_ways(&self) -> bool {
        let (scaled, doubt, n) = (&self.scaled, &self.doubt, self.scaled.len() - 2);
        let largest = (0..n).map(|j| scaled[j].abs() + doubt[j]).fold(0.0, f64::max);
        let surely = |sign: f64| (0..n).any(|j| sign * scaled[j] > doubt[j] + 2.0 * WRONG_SIGN * largest);
        // P is the class's times the barrier's sign, and points into the gap if that is negative.
        surely(1.0) && (surely(-1.0) || scaled[n + 1] > doubt[n + 1])
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_lattice::{Chain, ImpulseResponse, Model, Spectrum};
    use vibrochain_testkit::Random;

    use super::*;
    use crate::word::Word;

    /// Slopes and impulses anywhere within a radius are within their bounds about its centre, next to δ = 0 and T/2 and away from both, and the
    /// bounds are no idle numbers.
    #[test]
    fn slopes_and_impulses_stay_within_their_bounds() {
        let mut random = Random(41);
        let (mut checked, mut nearest) = ([0; 2], [[0.0_f64; 2]; 2]);
        for round in 0..600 {
            let text = ["0+,1-", "0-,2-", "0+1-,2+", "0+1+,0-1-", "0-2-,1-2-"][round % 5];
            let chain = Chain::new(3 + random.below(3), random.between(0.1, 1.0), random.log(1e-3, 0.5)).unwrap();
            let model = Model::conservative(chain, random.between(0.3, 2.5), 0.3).unwrap();
            let word: Word = text.parse().unwrap();
            let Ok(response) = ImpulseResponse::new(&Spectrum::new(chain), model.omega()) else { continue };
            let Ok(positions) = Positions::new(&model, &response, &word) else { continue };
            let classes = word.classes(&model, true);
            let rows = Rows::new(&positions, &classes, true);
            let distance = |delta: f64| if rows.apart { delta.min(rows.half - delta) } else { delta };
            let radius = rows.half * random.log(1e-6, 1e-2);
            let end = random.chance(0.3);
            let centre = match random.chance(0.5) {
                true => radius * random.between(1.0, 4.0),
                false => random.between(radius, rows.half - radius),
            };
            let centre = if end { rows.half - centre } else { centre };
            let near = radius > NEAR * distance(centre);
            let jets = rows.jets(centre);
            let slopes = rows.slopes(&jets, centre, radius);
            let impulses = rows.impulses(&jets, radius);
            for part in [-0.98, -0.5, 0.5, 0.98] {
                let delta = centre + part * radius;
                let there = rows.jets(delta);
                let scale = if near { distance(delta) } else { 1.0 };
                let exact = rows.summed(true, |pair, across| if across { there[pair].slope / scale } else { 0.0 });
                let n = exact.size();
                for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                    let (off, wide) = ((exact[(i, j)] - slopes.rows[(i, j)]).abs(), slopes.wide[(i, j)]);
                    assert!(off <= wide, "{text} {near} {i} {j} {part}: {off:e} {wide:e}");
                    let tight = &mut nearest[usize::from(near)][0];
                    *tight = tight.max(if wide > 0.0 { off / wide } else { 0.0 });
                }
                let (Some(about), Some(here)) = (&impulses, rows.impulses(&there, 0.0)) else { continue };
                // With c·x = 1, as about the centre.
                let unit = |k: usize| if k < n { response.omega() } else { 1.0 };
                let along = |k: usize| about.scaled[k] * here.scaled[k] / (unit(k) * unit(k));
                let length: f64 = (0..n + 2).map(along).sum();
                for k in 0..n + 2 {
                    let (off, doubt) = ((here.scaled[k] / length - about.scaled[k]).abs(), about.doubt[k]);
                    assert!(off <= doubt, "{text} {k} {part}: {off:e} {doubt:e}");
                    let tight = &mut nearest[usize::from(near)][1];
                    *tight = tight.max(off / doubt);
                }
                checked[usize::from(near)] += 1;
            }
        }
        assert!(checked.iter().all(|count| *count > 300), "{checked:?}");
        assert!(nearest.as_flattened().iter().all(|part| *part > 0.2), "{nearest:?}");
    }
}

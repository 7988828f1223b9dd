//! Orbits of a word of more than two instants without force and losses, followed from masses that are hardly coupled.
//!
//! Without coupling each mass swings by itself, and nothing fixes its phase θ against the others': its orbits are a family of as many
//! dimensions as there are masses that are hit. Weak coupling leaves those whose phases are at rest: the tail of mass B gives mass A,
//! over a period, as much energy as it takes. With the hits of each mass alone, i of A and j of B,
//!
//! ```text
//! F_A(θ) = Σ_B Σ_ij P_i P_j K′_AB(t_i + θ_A − t_j − θ_B) = 0     for each A,
//! ```
//!
//! which is the gradient of Σ P_i P_j K_AB, and a condition that remains of Newton's law once impulses and times of each mass have
//! followed the coupling. Where ∂F/∂θ is regular one branch of orbits begins (words.md calls this the phase rule). Masses whose orbits
//! are symmetric in time leave zeros where their impacts mirror each other, which are exact; others are found by Newton's method from a
//! grid of phases.

use vibrochain_lattice::{ImpulseResponse, Model, Stop};

use crate::equations::linear::{Matrix, Vector, zeros};
use crate::error::{BreatherError, NoBreather, Unsearched};
use crate::orbit::Hit;
use crate::search::finder::Finder;
use crate::search::orbit_list::OrbitList;
use crate::search::words::coupling_continuation::{Effort, follow_from, with_part};
use crate::search::words::isolated_mass::{self, Alone, Beat};
use crate::search::words::superpose::{list, orbit_of, superpose};
use crate::search::words::uncoupled::{MOST_STARTS, parts, unfinished};
use crate::word::Word;
use crate::word::enumeration::combinations;

/// Parts of the coupling asked for at which phases are looked for: the first at which the masses feel each other by more than
/// rounding.
const PARTS: [f64; 5] = [0.02, 0.06, 0.2, 0.5, 1.0];

/// An answer of one mass to another beyond this many times their impulses is no rounding: that of a sum of cosines, with six digits
/// beside it.
const FELT: f64 = 1e-10;

/// A sum of such answers below this is 0.
const ROUNDING: f64 = 1e-14;

/// The least number of phases of one mass that are tried, and the most of all masses together.
const TRIED: u32 = 24;
const MOST_TRIED: usize = 4096;

/// Steps of Newton's method at most; phases, in periods, that differ by less are one.
const STEPS: usize = 12;
const SAME: f64 = 1e-7;

/// Adds the orbits of `word`, of one row, that can be followed to the model's coupling: how many starts were followed, and how many are left; or
/// why there is nothing to follow.
pub(crate) fn find(
    finder: &mut Finder,
    model: &Model,
    word: &Word,
    found: &mut OrbitList,
) -> Result<Result<(usize, usize), NoBreather>, BreatherError> {
    finder.prepare(model, model.omega())?;
    if model.chain().gamma1() == 0.0 {
        return Ok(Err(NoBreather::NotSearched(Unsearched::Unheld)));
    }
    let parts = parts(word);
    let mut solutions = Vec::new();
    for (_, barriers) in &parts {
        match isolated_mass::without_force(model, barriers, &finder.stop)? {
            Ok(list) => solutions.push(list),
            Err(none) => return Ok(Err(none)),
        }
    }
    let all = solutions.iter().fold(1_usize, |product, list| product.saturating_mul(list.len()));
    let (mut starts, mut left, mut felt) = (0, all, false);
    let mut effort = Effort::until(&finder.stop);
    for choice in combinations(solutions.iter().map(Vec::len).collect()).take(MOST_STARTS) {
        if effort.is_spent() {
            break;
        }
        left -= 1;
        let masses: Vec<(usize, &Alone)> =
            choice.iter().zip(&solutions).zip(&parts).map(|((&i, list), (site, _))| (*site, &list[i])).collect();
        let Some(AtRest { weak, phases, untried }) = at_rest(finder, model, &masses)? else { continue };
        felt = true;
        left += untried;
        let mut seen: Vec<Vec<Hit>> = Vec::new();
        for phases in phases {
            let turned = |((site, alone), phase): (&(usize, &Alone), &f64)| {
                let later = |&beat: &Beat| Beat { turn: beat.turn + phase, ..beat };
                (*site, alone.beats.iter().map(later).collect())
            };
            let placed: Vec<(usize, Vec<Beat>)> = masses.iter().zip(&phases).map(turned).collect();
            let Some((_, hits)) = superpose(word, &placed) else { continue };
            let again = |other: &Vec<Hit>| other.iter().zip(&hits).all(|(a, b)| (a.time - b.time).abs() <= SAME);
            if seen.iter().any(again) {
                continue;
            }
            seen.push(hits.clone());
            let Some(start) = orbit_of(&weak, 1, 0.0, hits)? else { continue };
            if effort.is_spent() {
                left += 1;
                continue;
            }
            starts += 1;
            let ended = follow_from(&start, model, &mut effort)?;
            list(ended, found);
        }
    }
    Ok(if felt { Ok((starts, unfinished(found, left))) } else { Err(NoBreather::NotSearched(Unsearched::FreePhases)) })
}

/// Phases of the masses, in periods, the first one's 0, that weak coupling leaves at rest.
struct AtRest {
    weak: Model,
    phases: Vec<Vec<f64>>,
    /// Beginnings that were not tried, because there are too many.
    untried: usize,
}

/// `None` where masses do not feel each other by more than rounding.
fn at_rest(finder: &mut Finder, model: &Model, masses: &[(usize, &Alone)]) -> Result<Option<AtRest>, BreatherError> {
    for part in PARTS {
        let weak = with_part(model, part)?;
        // A resonance on the way is not in the way of a start.
        if finder.prepare(&weak, weak.omega()).is_err() {
            continue;
        }
        let tails = Tails { response: &finder.response, masses, scale: strength(masses) };
        if tails.are_felt() {
            let (phases, untried) = tails.zeros(&finder.stop)?;
            return Ok(Some(AtRest { weak, phases, untried }));
        }
    }
    Ok(None)
}

/// The largest product of impulses of two masses.
fn strength(masses: &[(usize, &Alone)]) -> f64 {
    let largest =
        masses.iter().flat_map(|(_, alone)| &alone.beats).fold(0.0, |most: f64, beat| most.max(beat.impulse.abs()));
    largest * largest
}

/// What masses with their own orbits feel of each other.
struct Tails<'a> {
    response: &'a ImpulseResponse,
    masses: &'a [(usize, &'a Alone)],
    scale: f64,
}

impl Tails<'_> {
    /// What B gives A where A is `ahead` of it, in periods, and how that changes; impulses by their scale.
    fn between(&self, a: usize, b: usize, ahead: f64) -> [f64; 2] {
        let ((to, one), (from, other)) = (self.masses[a], self.masses[b]);
        let period = self.response.period();
        let mut sum = [0.0; 2];
        for &Beat { turn: at, impulse, .. } in &one.beats {
            for &Beat { turn: before, impulse: push, .. } in &other.beats {
                let turn = (at + ahead - before).rem_euclid(1.0);
                let jet = self.response.jet_between(to, from, (turn - 0.5) * period);
                let product = impulse * push / self.scale;
                sum = [sum[0] + product * jet.slope, sum[1] + product * jet.curvature * period];
            }
        }
        sum
    }

    /// Whether every mass feels another, and so all of them each other.
    fn are_felt(&self) -> bool {
        let feels = |a: usize, b: usize| {
            (0..TRIED).any(|step| self.between(a, b, (f64::from(step) + 0.37) / f64::from(TRIED))[0].abs() > FELT)
        };
        let count = self.masses.len();
        let mut reached = vec![0];
        let mut next = 0;
        while next < reached.len() {
            let more: Vec<usize> = (0..count).filter(|b| !reached.contains(b) && feels(reached[next], *b)).collect();
            reached.extend(more);
            next += 1;
        }
        reached.len() == count
    }

    /// F of all masses but the first, and its derivatives.
    fn forces(&self, phases: &[f64]) -> (Vector, Matrix) {
        let count = self.masses.len();
        let (mut forces, mut matrix) = (zeros(count - 1), Matrix::zeros(count - 1));
        for a in 1..count {
            for b in (0..count).filter(|&b| b != a) {
                let [force, change] = self.between(a, b, phases[a] - phases[b]);
                forces[a - 1] += force;
                matrix[(a - 1, a - 1)] += change;
                if b > 0 {
                    matrix[(a - 1, b - 1)] -= change;
                }
            }
        }
        (forces, matrix)
    }

    /// All phases at rest that a grid of them leads to, and how many places of the grid were left out.
    fn zeros(&self, stop: &Stop) -> Result<(Vec<Vec<f64>>, usize), BreatherError> {
        let others = self.masses.len() - 1;
        // Mirror images of masses that repeat k and l times a period are at multiples of half a period over their common multiple.
        let common = self.masses.iter().fold(1, |common, (_, alone)| least_common(common, alone.repeats));
        let cells = |fine: u32| (2 * common * fine) as usize;
        let fits = |fine: &u32| cells(*fine).checked_pow(others as u32).is_some_and(|all| all <= MOST_TRIED);
        let fine = (1..=TRIED.div_ceil(2 * common)).rev().find(fits).unwrap_or(1);
        let cell = 1.0 / cells(fine) as f64;
        let mut zeros: Vec<Vec<f64>> = Vec::new();
        for place in combinations(vec![cells(fine); others]).take(MOST_TRIED) {
            stop.heard()?;
            let start: Vec<f64> = std::iter::once(0.0).chain(place.iter().map(|&i| i as f64 * cell)).collect();
            let Some(phases) = self.zero(&start, cell) else { continue };
            let apart = |x: f64, y: f64| ((x - y) - (x - y).round()).abs();
            if !zeros.iter().any(|other| other.iter().zip(&phases).all(|(x, y)| apart(*x, *y) <= SAME)) {
                zeros.push(phases);
            }
        }
        let all = cells(fine).checked_pow(others as u32).unwrap_or(usize::MAX);
        Ok((zeros, all.saturating_sub(MOST_TRIED)))
    }

    /// The phases at rest within a cell of `start`.
    fn zero(&self, start: &[f64], cell: f64) -> Option<Vec<f64>> {
        let mut phases = start.to_vec();
        for step in 0..STEPS {
            let (forces, matrix) = self.forces(&phases);
            // Each mass is held by what it feels most.
            let held = (0..forces.len()).all(|i| matrix.row(i).iter().any(|entry| entry.abs() > FELT));
            if !held {
                return None;
            }
            // Where symmetry puts it, but for rounding.
            if step == 0 && forces.iter().all(|force| force.abs() <= ROUNDING) {
                return matrix.solve(&forces).map(|_| phases);
            }
            let change = matrix.solve(&forces)?;
            phases[1..].iter_mut().zip(&change).for_each(|(phase, change)| *phase -= change);
            if phases.iter().zip(start).any(|(phase, start)| (phase - start).abs() > cell) {
                return None;
            }
            if change.iter().all(|change| change.abs() < 1e-3 * SAME) {
                return Some(phases);
            }
        }
        None
    }
}

/// The least common multiple, which impacts a word has room for keep small.
fn least_common(a: u32, b: u32) -> u32 {
    (1..=b).map(|i| a * i).find(|multiple| multiple.is_multiple_of(b)).unwrap_or(a)
}

//! The lines on which two modes meet, Ω̃_k ± Ω̃_l = jω, row by row of the map: from one cell to the next, in or beside those
//! with a breather of one family, the number (Ω̃_k ± Ω̃_l)/ω passes a whole one.

use std::collections::BTreeMap;

use rayon::ThreadPool;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use vibrochain_breather::{Family, Finder, OrbitList};
use vibrochain_cli::common::error::CliError;
use vibrochain_cli::stripes::StripeRows;
use vibrochain_floquet::{DressedModes, Passing, participating_modes, passings};
use vibrochain_lattice::{Parameter, Stop};
use vibrochain_plot::Tile;

use crate::stripes::cuts::{Carrier, Cut, family};

/// What tells lines apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Key {
    /// Of double-sided breathers, or of single-sided ones.
    pub(super) double: bool,
    pub(super) k: usize,
    pub(super) l: usize,
    pub(super) harmonic: usize,
    pub(super) sum: bool,
}

/// A line meets a row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    pub(super) key: Key,
    pub(super) row: usize,
    /// Where, in columns from the first.
    pub(super) place: f64,
    /// Where no such breather is: met by carrying on a cut, not drawn.
    pub(super) beyond: bool,
}

/// What is found along the rows of the map.
#[derive(Debug, Default)]
pub(super) struct Rows {
    pub(super) crossings: Vec<Crossing>,
    pub(super) cuts: Vec<Cut>,
    /// For comparison: whether a cell is within one cell, along its row, of a line of sums of the bare lattice's modes, and of
    /// differences.
    pub(super) bare: [Vec<bool>; 2],
}

/// A piece of a line.
#[derive(Debug, Clone)]
pub(super) struct Line {
    pub(super) family: Family,
    pub(super) modes: (usize, usize),
    pub(super) harmonic: usize,
    pub(super) sum: bool,
    pub(super) points: Vec<LinePoint>,
}

/// One of its points.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinePoint {
    pub(super) omega: f64,
    pub(super) gamma2: f64,
}

const FAMILIES: [Family; 2] = [Family::DoubleSided, Family::SingleSided];

/// All crossings and cuts, by rows.
///
/// # Errors
/// [`CliError::Interrupted`].
pub(super) fn rows(map: &StripeRows, tiles: &[Tile], pool: &ThreadPool, stop: &Stop) -> Result<Rows, CliError> {
    let rows: Result<Vec<Rows>, CliError> = pool.install(|| {
        (0..map.gamma2.points)
            .into_par_iter()
            .map_init(
                || Worker {
                    carrier: Carrier::new(map.scene.base.sites(), stop),
                    finder: Finder::new(map.scene.base.sites()).until(stop),
                    found: OrbitList::default(),
                    modes: DressedModes::default(),
                },
                |worker, row| worker.row(map, tiles, row),
            )
            .collect()
    });
    let mut all = Rows::default();
    for row in rows? {
        all.crossings.extend(row.crossings);
        all.cuts.extend(row.cuts);
        all.bare.iter_mut().zip(row.bare).for_each(|(all, row)| all.extend(row));
    }
    Ok(all)
}

struct Worker {
    carrier: Carrier,
    finder: Finder,
    found: OrbitList,
    modes: DressedModes,
}

impl Worker {
    fn row(&mut self, map: &StripeRows, tiles: &[Tile], row: usize) -> Result<Rows, CliError> {
        let mut all = Rows { bare: bare(map, row), ..Rows::default() };
        let symmetric = map.scene.base.get(Parameter::Asymmetry) == 0.0;
        let columns = map.omega.points;
        let (mut here, mut last) = (Vec::new(), Vec::new());
        for of in FAMILIES {
            let double = of == Family::DoubleSided;
            let is = |column: usize| tiles.get(map.cell(row, column)).and_then(family) == Some(of);
            // A breather that is not physical has modes, too: a line is not to end short of the last cell.
            let beside: Vec<bool> =
                (0..columns).map(|column| (column.saturating_sub(1)..=(column + 1).min(columns - 1)).any(is)).collect();
            let mut wanted = beside.clone();
            let cuts = self.carrier.cuts(map, tiles, row, of).ok_or(CliError::Interrupted)?;
            for cut in &cuts {
                wanted[cut.from..=cut.to].fill(true);
            }
            all.cuts.extend(cuts);
            last.clear();
            for column in 0..columns {
                here.clear();
                if wanted[column] {
                    self.frequencies(map, map.cell(row, column), of, &mut here);
                }
                // A cell that was stopped has no modes.
                self.finder.stop().heard().map_err(|_| CliError::Interrupted)?;
                let beyond = !(beside[column] && column > 0 && beside[column - 1]);
                passings(&last, &here, double && symmetric, |Passing { modes: (k, l), harmonic, sum, part }| {
                    let key = Key { double, k, l, harmonic, sum };
                    all.crossings.push(Crossing { key, row, place: column as f64 - 1.0 + part, beyond });
                });
                std::mem::swap(&mut here, &mut last);
            }
        }
        Ok(all)
    }

    /// Ω̃/ω of all modes in one cell, of a breather that there is.
    fn frequencies(&mut self, map: &StripeRows, cell: usize, family: Family, out: &mut Vec<Option<f64>>) -> Option<()> {
        let model = map.scene.point(cell as u64).model().ok()?;
        self.finder.find_symmetric(&model, family, &mut self.found).ok()?;
        self.modes.replace(self.finder.prepared(self.found.orbits.first()?).ok()?).ok()?;
        out.extend(self.modes.frequencies().map(|frequency| frequency.map(|frequency| frequency / model.omega())));
        Some(())
    }
}

/// The places where two modes of the bare lattice meet, whose frequencies do not depend on ω, and of which no line is drawn: which cells of a row have
/// one between the cells on either side. (As ω falls to 0 there are more and more harmonics from one cell to the next.)
fn bare(map: &StripeRows, row: usize) -> [Vec<bool>; 2] {
    let columns = map.omega.points;
    let mut near = [vec![false; columns], vec![false; columns]];
    let Ok(model) = map.scene.point(map.cell(row, 0) as u64).model() else { return near };
    let frequencies = participating_modes(model.chain(), 0);
    for (k, (_, low)) in frequencies.iter().enumerate() {
        for (l, (_, high)) in frequencies.iter().enumerate().skip(k) {
            // A mode against itself collides at odd harmonics only, and has no difference.
            let [sums, differences] = &mut near;
            let is_met = |column: usize, value: f64| between(value, k == l, cells_about(map, column));
            for column in 0..columns {
                sums[column] = sums[column] || is_met(column, low + high);
                differences[column] = differences[column] || k != l && is_met(column, high - low);
            }
        }
    }
    near
}

/// ω one cell below and one above a column; beyond either end of the map is still next to it.
fn cells_about(map: &StripeRows, column: usize) -> (f64, f64) {
    (map.omega.value(column as f64 - 1.0), map.omega.value(column as f64 + 1.0))
}

/// Whether a harmonic jω, j odd if so wanted, is `value` at an ω from `low` to `high`.
fn between(value: f64, odd: bool, (low, high): (f64, f64)) -> bool {
    let last = if low > 0.0 { value / low } else { f64::INFINITY };
    let mut harmonic = (value / high).ceil().max(1.0);
    if odd && harmonic % 2.0 == 0.0 {
        harmonic += 1.0;
    }
    value > 0.0 && harmonic <= last
}

/// The lines of dressed modes: crossings of neighbouring rows, put together.
pub(super) fn joined(map: &StripeRows, crossings: &[Crossing]) -> Vec<Line> {
    let mut by_key: BTreeMap<Key, Vec<&Crossing>> = BTreeMap::new();
    for crossing in crossings.iter().filter(|crossing| !crossing.beyond) {
        by_key.entry(crossing.key).or_default().push(crossing);
    }
    // |dω/dγ₂| of a sum of two modes is below 4/Ω.
    let base = &map.scene.base;
    let slope = 4.0 / base.get(Parameter::Gamma1).sqrt().max(0.05);
    let reach = 4.0 + slope * map.gamma2.step / map.omega.step;
    let mut lines = Vec::new();
    for (key, crossings) in by_key {
        let mut open: Vec<(usize, f64, Line)> = Vec::new();
        for crossing in crossings {
            let point =
                LinePoint { omega: map.omega.value(crossing.place), gamma2: map.gamma2.value(crossing.row as f64) };
            let near = open
                .iter_mut()
                .filter(|(row, place, _)| row + 1 == crossing.row && (place - crossing.place).abs() <= reach)
                .min_by(|a, b| (a.1 - crossing.place).abs().total_cmp(&(b.1 - crossing.place).abs()));
            match near {
                Some((row, place, line)) => {
                    (*row, *place) = (crossing.row, crossing.place);
                    line.points.push(point);
                }
                None => {
                    let family = if key.double { Family::DoubleSided } else { Family::SingleSided };
                    let Key { k, l, harmonic, sum, .. } = key;
                    let line = Line { family, modes: (k, l), harmonic, sum, points: vec![point] };
                    open.push((crossing.row, crossing.place, line));
                }
            }
        }
        lines.extend(open.into_iter().map(|(_, _, line)| line));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_harmonic_is_met_between_two_frequencies_as_counting_them_says() {
        let (mut met, mut missed) = (0, 0);
        for i in 0..4000 {
            let part = |step: f64| (f64::from(i) * step).fract();
            let (value, low) = (0.1 + 3.0 * part(0.618_033_988_7), 0.05 + part(0.414_213_562_3));
            let about = (low, low + 0.2 * part(0.732_050_807_5));
            for odd in [false, true] {
                let counted = (1..200)
                    .filter(|j| !odd || j % 2 == 1)
                    .any(|j| (about.0..=about.1).contains(&(value / f64::from(j))));
                assert_eq!(between(value, odd, about), counted, "{value} {odd} {about:?}");
                *(if counted { &mut met } else { &mut missed }) += 1;
            }
        }
        assert!(met > 1000 && missed > 1000, "{met} {missed}");
        // Down to no frequency at all, in one step; a mode at rest has no harmonic.
        assert!(between(1.2, true, (-0.4, 1e-300)) && between(1.2, false, (1e-300, 1e-9)));
        assert!(between(0.3, true, (0.0, 0.4)) && !between(0.0, false, (-0.4, 0.4)));
    }
}

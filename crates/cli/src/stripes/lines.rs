//! The lines on which two modes meet, Ω̃_k ± Ω̃_l = jω, row by row of the map: from one cell to the next, in or beside those
//! with a breather of one family, the number (Ω̃_k ± Ω̃_l)/ω passes a whole one.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::ThreadPool;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use vibrochain_breather::{Family, Finder, Found};
use vibrochain_floquet::DressedModes;
use vibrochain_lattice::{Chain, Spectrum};

use crate::error::CliError;
use crate::output::Number;
use crate::plot::Tile;
use crate::stripes::cuts::{Carrier, Cut};
use crate::stripes::family;
use crate::stripes::request::Request;

/// The frequencies whose sums and differences are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Modes {
    /// Those of the ring with the breather on it.
    Dressed,
    /// Those of the bare ring, for comparison.
    Bare,
}

/// What tells lines apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Key {
    pub(super) modes: Modes,
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
    /// Cells whose breather's own mode grows by itself ([`DressedModes::own_grows`]).
    pub(super) growing: Vec<usize>,
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
pub(super) fn rows(request: &Request, tiles: &[Tile], pool: &ThreadPool, stop: &AtomicBool) -> Result<Rows, CliError> {
    let rows: Option<Vec<Rows>> = pool.install(|| {
        (0..request.gamma2.points)
            .into_par_iter()
            .map_init(
                || Worker {
                    carrier: Carrier::new(request.scene.base.sites),
                    finder: Finder::new(request.scene.base.sites),
                    found: Found::default(),
                    modes: DressedModes::default(),
                },
                |worker, row| worker.row(request, tiles, row, stop),
            )
            .collect()
    });
    let mut all = Rows::default();
    for row in rows.ok_or(CliError::Interrupted)? {
        all.crossings.extend(row.crossings);
        all.cuts.extend(row.cuts);
        all.growing.extend(row.growing);
    }
    Ok(all)
}

struct Worker {
    carrier: Carrier,
    finder: Finder,
    found: Found,
    modes: DressedModes,
}

impl Worker {
    /// One row; `None` if stopped.
    fn row(&mut self, request: &Request, tiles: &[Tile], row: usize, stop: &AtomicBool) -> Option<Rows> {
        let mut all = Rows::default();
        let symmetric = request.scene.base.get(crate::parameter::Parameter::Asymmetry) == 0.0;
        let columns = request.omega.points;
        let (mut here, mut last) = (Vec::new(), Vec::new());
        for of in FAMILIES {
            let double = of == Family::DoubleSided;
            let is = |column: usize| tiles.get(request.cell(row, column)).and_then(family) == Some(of);
            // A breather that is not physical has modes, too: a line is not to end short of the last cell.
            let beside: Vec<bool> =
                (0..columns).map(|column| (column.saturating_sub(1)..=(column + 1).min(columns - 1)).any(is)).collect();
            let mut wanted = beside.clone();
            let cuts = self.carrier.cuts(request, tiles, row, of, stop)?;
            for cut in &cuts {
                wanted.get_mut(cut.from..=cut.to)?.fill(true);
            }
            all.cuts.extend(cuts);
            last.clear();
            for column in 0..columns {
                if stop.load(Ordering::Relaxed) {
                    return None;
                }
                here.clear();
                if wanted[column] {
                    let cell = request.cell(row, column);
                    if self.frequencies(request, cell, of, &mut here) && is(column) {
                        all.growing.push(cell);
                    }
                }
                let beyond = !(beside[column] && column > 0 && beside[column - 1]);
                pairs(&last, &here, double && symmetric, |k, l, harmonic, sum, part| {
                    let key = Key { modes: Modes::Dressed, double, k, l, harmonic, sum };
                    all.crossings.push(Crossing { key, row, place: column as f64 - 1.0 + part, beyond });
                });
                std::mem::swap(&mut here, &mut last);
            }
        }
        bare(request, row, &mut all.crossings);
        Some(all)
    }

    /// Ω̃/ω of all modes in one cell, and whether the breather's own grows by itself.
    fn frequencies(&mut self, request: &Request, cell: usize, family: Family, out: &mut Vec<Option<f64>>) -> bool {
        let Ok(model) = request.scene.point(cell as u64).model() else { return false };
        if self.finder.find_symmetric(&model, family, &mut self.found).is_err() {
            return false;
        }
        let Some(orbit) = self.found.orbits.first() else { return false };
        if self.modes.set(orbit, self.finder.response()).is_err() {
            return false;
        }
        out.extend(self.modes.frequencies().map(|frequency| frequency.map(|frequency| frequency / model.omega())));
        self.modes.own_grows()
    }
}

/// Pairs of modes whose sum or difference passes a whole number from one list to the next: calls `found` with k ≤ l, that
/// number, whether it is a sum, and at which part of the way.
fn pairs(
    from: &[Option<f64>],
    to: &[Option<f64>],
    even_only: bool,
    mut found: impl FnMut(usize, usize, usize, bool, f64),
) {
    let modes: Vec<_> = from.iter().zip(to).enumerate().filter_map(|(k, (a, b))| Some((k, (*a)?, (*b)?))).collect();
    for (i, &(k, k_from, k_to)) in modes.iter().enumerate() {
        for &(l, l_from, l_to) in &modes[i..] {
            for (sum, a, b) in [(true, k_from + l_from, k_to + l_to), (false, l_from - k_from, l_to - k_to)] {
                let harmonic = a.max(b).floor();
                // One and no jump of a mode; a mode against itself at an even harmonic is a resonance. (The breather's own
                // mode stays at ω/2 while it doubles the period: both ends are passed.)
                let passed = a.min(b) <= harmonic && a != b && harmonic >= 1.0 && (a - b).abs() < 0.5;
                let odd = harmonic % 2.0 != 0.0;
                if passed && !(k == l && !(sum && odd)) && !(even_only && odd) {
                    found(k, l, harmonic as usize, sum, (harmonic - a) / (b - a));
                }
            }
        }
    }
}

/// The same for the bare ring, whose frequencies do not depend on ω.
fn bare(request: &Request, row: usize, all: &mut Vec<Crossing>) {
    let base = &request.scene.base;
    let gamma2 = request.scene.point(request.cell(row, 0) as u64).get(crate::parameter::Parameter::Gamma2);
    let Ok(chain) = Chain::new(base.sites, base.get(crate::parameter::Parameter::Gamma1), gamma2) else { return };
    let spectrum = Spectrum::new(chain);
    let frequencies = spectrum.frequencies();
    // One cell beyond either end is still next to the map.
    let (least, most) = (request.omega.value(-1.0), request.omega.value(request.omega.points as f64));
    for (k, low) in frequencies.iter().enumerate() {
        for (l, high) in frequencies.iter().enumerate().skip(k) {
            for (sum, value) in [(true, low + high), (false, high - low)] {
                let harmonics = (value / most).ceil().max(1.0)..=(value / least.max(f64::MIN_POSITIVE)).floor();
                let mut harmonic = *harmonics.start();
                while harmonics.contains(&harmonic) && harmonic < 1e6 {
                    if k != l || sum && harmonic % 2.0 != 0.0 {
                        let key = Key { modes: Modes::Bare, double: false, k, l, harmonic: harmonic as usize, sum };
                        let place = request.omega.place(value / harmonic);
                        all.push(Crossing { key, row, place, beyond: false });
                    }
                    harmonic += 1.0;
                }
            }
        }
    }
}

/// The lines of dressed modes: crossings of neighbouring rows, put together.
pub(super) fn joined(request: &Request, crossings: &[Crossing]) -> Vec<Line> {
    let mut by_key: BTreeMap<Key, Vec<&Crossing>> = BTreeMap::new();
    let drawn = |crossing: &&Crossing| crossing.key.modes == Modes::Dressed && !crossing.beyond;
    for crossing in crossings.iter().filter(drawn) {
        by_key.entry(crossing.key).or_default().push(crossing);
    }
    // |dω/dγ₂| of a sum of two modes is below 4/Ω.
    let base = &request.scene.base;
    let slope = 4.0 / base.get(crate::parameter::Parameter::Gamma1).sqrt().max(0.05);
    let reach = 4.0 + slope * request.gamma2.step / request.omega.step;
    let mut lines = Vec::new();
    for (key, crossings) in by_key {
        let mut open: Vec<(usize, f64, Line)> = Vec::new();
        for crossing in crossings {
            let point = LinePoint {
                omega: request.omega.value(crossing.place),
                gamma2: request.gamma2.value(crossing.row as f64),
            };
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

/// The table of lines.
///
/// # Errors
/// [`CliError::Computation`].
pub(super) fn table(lines: &[Line]) -> Result<Vec<u8>, CliError> {
    let failed = |error: &dyn std::fmt::Display| CliError::Computation(format!("could not write the lines: {error}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    let columns = ["family", "mode1", "mode2", "harmonic", "sum", "gamma2", "omega", "signature_product"];
    writer.write_record(columns).map_err(|error| failed(&error))?;
    for line in lines {
        let (k, l) = line.modes;
        // On a sum the multipliers that meet are e^{iΩT} of one mode and e^{−iΩT} of the other.
        let product = if line.sum { "-1" } else { "1" };
        for point in &line.points {
            let record = [
                line.family.name().to_owned(),
                k.to_string(),
                l.to_string(),
                line.harmonic.to_string(),
                line.sum.to_string(),
                Number(point.gamma2).to_string(),
                Number(point.omega).to_string(),
                product.to_owned(),
            ];
            writer.write_record(&record).map_err(|error| failed(&error))?;
        }
    }
    writer.into_inner().map_err(|error| failed(&error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_are_passed_once_each_way() {
        let seen = |from: &[f64], to: &[f64], even| {
            let some = |values: &[f64]| values.iter().copied().map(Some).collect::<Vec<_>>();
            let mut all = Vec::new();
            pairs(&some(from), &some(to), even, |k, l, j, sum, part| all.push((k, l, j, sum, (part * 100.0).round())));
            all
        };
        // 0.6 + 0.5 → 0.55 + 0.35, and 2·0.5 = 1 is met by mode 1 at its start.
        assert_eq!(seen(&[0.6, 0.55], &[0.55, 0.35], false), [(0, 1, 1, true, 60.0), (1, 1, 1, true, 25.0)]);
        assert_eq!(seen(&[0.55, 0.35], &[0.6, 0.55], false).len(), 2);
        assert_eq!(seen(&[0.6, 0.55], &[0.55, 0.35], true), []);
        // A difference; and 2Ω = 2ω is none.
        assert_eq!(seen(&[0.3, 1.4], &[0.3, 1.2], false), [(0, 1, 1, false, 50.0)]);
        assert_eq!(seen(&[1.1], &[0.9], false), []);
    }
}

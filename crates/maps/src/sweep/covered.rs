//! Which cells of the finest grid lie in a stripe of instability, told by the stripes' edges alone: stripes thinner than a cell of the
//! grid that is refined pass between its points unseen.

use vibrochain_breather::Family;
use vibrochain_lattice::Stop;

use crate::borders::StripeCourse;
use crate::cell::Class;
use crate::extent::Extent;
use crate::scene::Scene;

/// How exact edges are, in columns of the finest grid: a cell nearer to one is looked at whether it lies in the stripe or not.
const EXACT: f64 = 0.02;

/// The most exact and the least that edges are told, in parts of the window.
const FINEST: f64 = 1e-9;
const COARSEST: f64 = 1e-5;

/// Neighbouring cells of a row that lie in one stripe: the first and the last.
#[derive(Debug, Clone, Copy)]
struct Run {
    first: u32,
    last: u32,
    /// Whether the first and the last are so near to the edge that they may lie outside.
    doubt: [bool; 2],
    /// The last cell of any run up to this one.
    reach: u32,
    family: Family,
}

/// The cells that lie in stripes, by rows of the finest grid; of each row by their first cells.
#[derive(Debug, Default)]
pub(super) struct Covered {
    rows: Vec<Vec<Run>>,
}

/// Whether none of this family's stripes shows in cells of this class: a stable breather of the other wins.
fn hides(class: Option<Class>, family: Family) -> bool {
    match class {
        Some(Class::StableDouble) => family == Family::SingleSided,
        Some(Class::StableSingle) => family == Family::DoubleSided,
        _ => false,
    }
}

/// Puts the runs of a row in order.
fn sort(runs: &mut [Run]) {
    runs.sort_by_key(|run| (run.first, run.last));
    let mut reach = 0;
    for run in runs {
        reach = reach.max(run.last);
        run.reach = reach;
    }
}

impl Covered {
    /// Of a scene whose finest grid is `finest`. Threads are those of the pool that this is called in.
    pub(super) fn of(finest: &Scene, stop: &Stop) -> Self {
        let Some([columns, rows]) = finest.plane().map(|plane| plane.map(|axis| axis.points())) else {
            return Self::default();
        };
        let steps = [columns, rows].map(|points| (points - 1) as f64);
        let tolerance = (EXACT / steps[0].max(steps[1])).clamp(FINEST, COARSEST);
        let courses = StripeCourse::all(finest, tolerance, stop);
        let mut covered = Self { rows: if courses.is_empty() { Vec::new() } else { vec![Vec::new(); rows] } };
        for StripeCourse { family, points } in courses {
            for ends in points.windows(2) {
                let ([(low, from), (high, to)], true) = ([ends[0], ends[1]], ends[0].0 < ends[1].0) else { continue };
                // Rows from one end to, not including, the other: each is some chord's, the last end is hardly a row.
                let row_at = |y: f64| (y * steps[1]).ceil().clamp(0.0, rows as f64) as usize;
                let end = if high >= 1.0 { rows } else { row_at(high) };
                for (row, runs) in covered.rows.iter_mut().enumerate().take(end).skip(row_at(low)) {
                    let share = (row as f64 / steps[1] - low) / (high - low);
                    let edges = [0, 1].map(|i| (from[i] + share * (to[i] - from[i])) * steps[0]);
                    let (first, last) = ((edges[0] - EXACT).ceil().max(0.0), (edges[1] + EXACT).floor().min(steps[0]));
                    if first <= last {
                        let doubt = [first < edges[0] + EXACT, last > edges[1] - EXACT];
                        runs.push(Run { first: first as u32, last: last as u32, doubt, reach: 0, family });
                    }
                }
            }
        }
        covered.rows.iter_mut().for_each(|runs| sort(runs));
        covered
    }

    /// Whether some of these cells lie in a stripe that would show, and others do not; what is computed of them is of this class.
    pub(super) fn divides(&self, square: Extent, class: Option<Class>) -> bool {
        let Extent { column, row, size } = square;
        let rows = self.rows.iter().skip(row as usize).take(size as usize);
        let (mut whole, mut none) = (false, false);
        for runs in rows {
            let from = runs.partition_point(|run| run.reach < column);
            let met = runs[from..].iter().take_while(|run| run.first < column + size);
            let met = met.filter(|run| run.last >= column && !hides(class, run.family));
            let mut inside = false;
            for run in met {
                if run.first > column || run.last < column + size - 1 {
                    return true;
                }
                inside = true;
            }
            whole |= inside;
            none |= !inside;
            if whole && none {
                return true;
            }
        }
        false
    }

    /// Whether these cells lie in a stripe of a family: all of them surely, or surely none; `None` otherwise.
    pub(super) fn holds(&self, square: Extent, family: Family) -> Option<bool> {
        let Extent { column, row, size } = square;
        let mut all = None;
        for runs in self.rows.iter().skip(row as usize).take(size as usize) {
            let from = runs.partition_point(|run| run.reach < column);
            let met = runs[from..].iter().take_while(|run| run.first < column + size);
            let mut inside = false;
            for run in met.filter(|run| run.last >= column && run.family == family) {
                let [first, last] = run.doubt;
                let (first, last) = (run.first + u32::from(first), i64::from(run.last) - i64::from(last));
                if first > column || last < i64::from(column + size - 1) {
                    return None;
                }
                inside = true;
            }
            if *all.get_or_insert(inside) != inside {
                return None;
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use fastrand::Rng;

    use super::*;

    /// Against every cell of a square, one by one.
    #[test]
    fn a_square_is_divided_where_some_of_its_rows_are_in_stripes_and_others_are_not_or_a_part_of_one() {
        let mut random = Rng::with_seed(5);
        let mut number = |below: u32| random.u32(..below);
        let (columns, rows) = (64, 16);
        let mut told = [0; 2];
        for _ in 0..200 {
            let mut covered = Covered { rows: vec![Vec::new(); rows as usize] };
            for row in &mut covered.rows {
                for _ in 0..number(5) {
                    let first = number(columns);
                    let last = (first + number(3) * number(20)).min(columns - 1);
                    let family = if number(3) == 0 { Family::SingleSided } else { Family::DoubleSided };
                    let doubt = [number(8) == 0, number(8) == 0];
                    row.push(Run { first, last, doubt, reach: 0, family });
                }
                sort(row);
            }
            for class in [None, Some(Class::None), Some(Class::StableDouble), Some(Class::StableSingle)] {
                let size = 1 << number(4);
                let square = Extent { column: number(columns / size) * size, row: number(rows / size) * size, size };
                let within = |at: u32| square.column <= at && at < square.column + size;
                let mut inside = Vec::new();
                let mut cut = false;
                for row in &covered.rows[square.row as usize..(square.row + size) as usize] {
                    let shown = row.iter().filter(|run| !hides(class, run.family));
                    let met: Vec<_> =
                        shown.map(|run| (run.first..=run.last).filter(|at| within(*at)).count()).collect();
                    cut |= met.iter().any(|cells| (1..size as usize).contains(cells));
                    inside.push(met.contains(&(size as usize)));
                }
                let expected = cut || inside.contains(&true) && inside.contains(&false);
                assert_eq!(covered.divides(square, class), expected, "{square:?} {class:?} {covered:?}");
                told[usize::from(expected)] += 1;
                for family in [Family::DoubleSided, Family::SingleSided] {
                    let rows = &covered.rows[square.row as usize..(square.row + size) as usize];
                    let sure = |run: &Run| run.first + u32::from(run.doubt[0])..run.last + 1 - u32::from(run.doubt[1]);
                    let (mut whole, mut met) = (true, false);
                    for row in rows {
                        let of: Vec<_> = row.iter().filter(|run| run.family == family).collect();
                        let touches = |run: &&&Run| (run.first..=run.last).any(within);
                        let all = |run: &&Run| sure(run).filter(|at| within(*at)).count() == size as usize;
                        let met_here: Vec<_> = of.iter().filter(touches).copied().collect();
                        met |= !met_here.is_empty();
                        whole &= !met_here.is_empty() && met_here.iter().all(all);
                    }
                    let expected = if !met { Some(false) } else { whole.then_some(true) };
                    assert_eq!(covered.holds(square, family), expected, "{square:?} {covered:?}");
                }
            }
        }
        assert!(told.iter().all(|times| *times > 100), "{told:?}");
    }
}

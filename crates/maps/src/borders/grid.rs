//! A coarse look at the window, and which of the changes between neighbouring places a border explains.

use crate::cell::Class;

/// Two neighbouring places of a grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Edge {
    pub(super) column: usize,
    pub(super) row: usize,
    /// Whether the other one is the next column's, not the next row's.
    pub(super) across: bool,
}

/// A curve this near to a place of the grid, in steps, passes on either side of it.
const NEAR: f64 = 1e-6;

/// What lives at the places of a grid over the whole window, sides included.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    size: [usize; 2],
    classes: Vec<Option<Class>>,
    /// Of each place, whether a border passes between it and the next in its row, and between it and the next in its column.
    passed: Vec<[bool; 2]>,
}

impl Grid {
    /// The places of a grid of this size, a row after the other, as parts of the window's sides.
    pub(super) fn places([columns, rows]: [usize; 2]) -> impl Iterator<Item = [f64; 2]> {
        let part = |i: usize, count: usize| i as f64 / (count - 1) as f64;
        (0..rows).flat_map(move |row| (0..columns).map(move |column| [part(column, columns), part(row, rows)]))
    }

    pub(super) fn new(size: [usize; 2], classes: Vec<Option<Class>>) -> Self {
        let passed = vec![[false; 2]; classes.len()];
        Self { size, classes, passed }
    }

    fn number(&self, column: usize, row: usize) -> usize {
        row * self.size[0] + column
    }

    /// Both places of an edge.
    pub(super) fn ends(&self, edge: Edge) -> [[f64; 2]; 2] {
        let part = |i: usize, count: usize| i as f64 / (count - 1) as f64;
        let place = |column, row| [part(column, self.size[0]), part(row, self.size[1])];
        let Edge { column, row, across } = edge;
        [place(column, row), place(column + usize::from(across), row + usize::from(!across))]
    }

    /// That a border passes between two places, whether or not one is known.
    pub(super) fn pass(&mut self, edge: Edge) {
        let number = self.number(edge.column, edge.row);
        self.passed[number][usize::from(!edge.across)] = true;
    }

    /// Marks all that a line, in parts of the window's sides, passes between.
    pub(super) fn mark(&mut self, line: &[[f64; 2]]) {
        let steps = [0, 1].map(|i| (self.size[i] - 1) as f64);
        for pair in line.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|[x, y]| [x * steps[0], y * steps[1]]);
            for along in 0..2 {
                // The grid's lines at whole numbers of the other coordinate.
                let other = 1 - along;
                let (low, high) = (a[other].min(b[other]), a[other].max(b[other]));
                let first = (low - NEAR).ceil().max(0.0);
                let last = (high + NEAR).floor().min(steps[other]);
                let mut line = first;
                while line <= last {
                    let share =
                        if high > low { ((line - a[other]) / (b[other] - a[other])).clamp(0.0, 1.0) } else { 0.5 };
                    let met = a[along] + share * (b[along] - a[along]);
                    for place in [met - NEAR, met + NEAR] {
                        if (0.0..steps[along]).contains(&place) {
                            let [own, line] = [place as usize, line as usize];
                            let across = along == 0;
                            let (column, row) = if across { (own, line) } else { (line, own) };
                            self.pass(Edge { column, row, across });
                        }
                    }
                    line += 1.0;
                }
            }
        }
    }

    /// Where two neighbours differ without a border in between: those next to each other together, the longest run first.
    pub(super) fn unexplained(&self) -> Vec<Vec<Edge>> {
        let [columns, rows] = self.size;
        // Edges of one square belong together; each edge is one of two squares.
        let mut edges: Vec<Edge> = Vec::new();
        let mut of_square = vec![Vec::new(); columns * rows];
        for row in 0..rows {
            for column in 0..columns {
                for across in [true, false] {
                    let (next_column, next_row) = (column + usize::from(across), row + usize::from(!across));
                    if next_column == columns || next_row == rows {
                        continue;
                    }
                    let number = self.number(column, row);
                    let both = (self.classes[number], self.classes[self.number(next_column, next_row)]);
                    if let (Some(one), Some(other)) = both
                        && one != other
                        && !self.passed[number][usize::from(!across)]
                    {
                        of_square[number].push(edges.len());
                        // The square on the other side of the edge.
                        let before = if across {
                            row.checked_sub(1).map(|row| (column, row))
                        } else {
                            column.checked_sub(1).map(|column| (column, row))
                        };
                        if let Some((column, row)) = before {
                            of_square[self.number(column, row)].push(edges.len());
                        }
                        edges.push(Edge { column, row, across });
                    }
                }
            }
        }
        let mut parent: Vec<usize> = (0..edges.len()).collect();
        fn root(parent: &mut [usize], mut edge: usize) -> usize {
            while parent[edge] != edge {
                parent[edge] = parent[parent[edge]];
                edge = parent[edge];
            }
            edge
        }
        for pair in of_square.iter().flat_map(|square| square.windows(2)) {
            let [one, other] = [pair[0], pair[1]].map(|edge| root(&mut parent, edge));
            parent[one.max(other)] = one.min(other);
        }
        let mut runs: Vec<Vec<Edge>> = Vec::new();
        let mut run_of = vec![None; edges.len()];
        for (number, edge) in edges.iter().enumerate() {
            let first = root(&mut parent, number);
            let run = *run_of[first].get_or_insert_with(|| {
                runs.push(Vec::new());
                runs.len() - 1
            });
            runs[run].push(*edge);
        }
        runs.sort_by_key(|run| std::cmp::Reverse(run.len()));
        runs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_border_explains_what_it_passes_between() {
        let inside = |[x, y]: [f64; 2]| (x - 0.5_f64).hypot(y - 0.5) < 0.3;
        let class = |place| Some(if inside(place) { Class::StableDouble } else { Class::None });
        let mut grid = Grid::new([41, 31], Grid::places([41, 31]).map(class).collect());
        let before = grid.unexplained();
        assert!(before.len() == 1 && before[0].len() > 60, "{}", before.len());
        // Each edge has the circle between its ends.
        assert!(
            before[0].iter().all(|edge| grid.ends(*edge).map(inside).iter().filter(|inside| **inside).count() == 1)
        );
        let circle = |angle: f64| [0.5 + 0.3 * angle.cos(), 0.5 + 0.3 * angle.sin()];
        let turn =
            |part: f64| (0..=1000).map(|i| circle(part * std::f64::consts::TAU * f64::from(i) / 1000.0)).collect();
        let half: Vec<[f64; 2]> = turn(0.5);
        grid.mark(&half);
        let left: usize = grid.unexplained().iter().map(Vec::len).sum();
        assert!((left as f64 / before[0].len() as f64 - 0.5).abs() < 0.1, "{left}");
        let whole: Vec<[f64; 2]> = turn(1.0);
        grid.mark(&whole);
        assert!(grid.unexplained().is_empty());
    }
}

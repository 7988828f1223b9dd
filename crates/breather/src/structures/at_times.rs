//! Impulses, offsets and phase at given times: under a load of one harmonic, (c, s) = (cos, sin) of jωψ, these obey linear equations.

use smallvec::SmallVec;
use vibrochain_lattice::{Barrier, Complex};

use super::equations::{Equations, Point, Strike};
use super::error::StructureOrbitError;
use crate::equations::linear::{Factors, Matrix, Vector, zeros};

/// A word's impacts, in order, and the equations of their contacts.
pub(super) struct Impacts<'a> {
    pub(super) equations: &'a Equations<'a>,
    pub(super) letters: SmallVec<[(usize, Barrier); 4]>,
}

impl Impacts<'_> {
    /// Stops less what is still, of every impact.
    pub(super) fn places(&self) -> Option<SmallVec<[f64; 4]>> {
        let place = |&(contact, barrier): &(usize, Barrier)| {
            Some(self.equations.model.barrier(contact, barrier).ok()? - self.equations.still(contact))
        };
        self.letters.iter().map(place).collect()
    }

    /// The linear equations of impulses, offsets and, under a load, (c, s), at given times.
    pub(super) fn linear(&self, times: &[f64]) -> Result<Linear, StructureOrbitError> {
        let equations = self.equations;
        let (n, rigid) = (times.len(), equations.rigid.len());
        let load = equations.single();
        // Positions, balances and, under a load, Newton's laws.
        let rows = n + rigid + if load.is_some() { n } else { 0 };
        let columns = n + rigid + if load.is_some() { 2 } else { 0 };
        let mut linear =
            Linear { columns, rows: SmallVec::with_capacity(rows), right: Vector::new(), laws: SmallVec::new() };
        let mut laws: SmallVec<[Vector; 2]> = SmallVec::new();
        for (i, &(contact, barrier)) in self.letters.iter().enumerate() {
            equations.model.heard()?;
            let (mut place, mut law) = (zeros(columns), zeros(columns));
            let weight = 1.0 + equations.restitution(contact);
            for (j, &(other, _)) in self.letters.iter().enumerate() {
                let lapse = if i == j { 0.0 } else { times[i] - times[j] };
                let (jet, _) = equations.kernel().jet(contact, other, lapse);
                (place[j], law[j]) = (jet[0], weight * jet[1]);
            }
            law[i] += equations.mobility(contact);
            for (k, drift) in equations.rigid.iter().enumerate() {
                place[n + k] = drift.shapes[contact];
            }
            if let Some((rate, swing)) = load {
                let there = swing[contact] * Complex::from_polar(1.0, rate * times[i]);
                let speed = there * Complex::new(0.0, rate) * weight;
                (place[n + rigid], place[n + rigid + 1]) = (there.re, -there.im);
                (law[n + rigid], law[n + rigid + 1]) = (speed.re, -speed.im);
            }
            linear.rows.push(place);
            linear.right.push(equations.model.barrier(contact, barrier)? - equations.still(contact));
            laws.push(law);
        }
        for drift in &equations.rigid {
            let mut row = zeros(columns);
            for (j, &(contact, _)) in self.letters.iter().enumerate() {
                row[j] = drift.shapes[contact];
            }
            linear.rows.push(row);
            linear.right.push(-drift.push * equations.period());
        }
        if load.is_some() {
            for law in laws {
                linear.rows.push(law);
                linear.right.push(0.0);
            }
        } else {
            linear.laws = laws;
        }
        Ok(linear)
    }

    /// The point of a solution of the linear equations.
    pub(super) fn point(&self, times: &[f64], x: &[f64]) -> Point {
        let (n, rigid) = (times.len(), self.equations.rigid.len());
        let strikes = self.letters.iter().zip(times).zip(x).map(|((&(contact, barrier), &time), &impulse)| Strike {
            contact,
            barrier,
            time,
            impulse,
        });
        let psi = match self.equations.single() {
            Some((rate, _)) => x[n + rigid + 1].atan2(x[n + rigid]) / rate,
            None => 0.0,
        };
        Point { strikes: strikes.collect(), psi, offsets: x[n..n + rigid].iter().copied().collect() }
    }

    /// Both phases where the equations leave a line of (c, s), which meets the circle: of one impact; and of two half a period apart where
    /// what the second one asks is what the first one does.
    pub(super) fn on_a_line(&self, times: &[f64]) -> Result<Vec<Point>, StructureOrbitError> {
        let linear = self.linear(times)?;
        let size = linear.columns;
        // (c, s) along a direction in which the equations determine the rest best.
        let bordered = [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|direction| {
            let row = |j: usize| if j + 2 < size { 0.0 } else { direction[j + 2 - size] };
            Factors::new(Matrix::from_fn(size, |i, j| if i + 1 < size { linear.rows[i][j] } else { row(j) }))
        });
        let best = bordered.into_iter().flatten().max_by(|a, b| a.determinant.abs().total_cmp(&b.determinant.abs()));
        let Some(best) = best else { return Ok(Vec::new()) };
        let solved = |last: f64| {
            let right: Vector = linear.right[..size - 1].iter().copied().chain([last]).collect();
            Some(best.solve(&right)).filter(|x| x.iter().all(|x| x.is_finite()))
        };
        let (Some(base), Some(moved)) = (solved(0.0), solved(1.0)) else { return Ok(Vec::new()) };
        let along: Vector = moved.iter().zip(&base).map(|(a, b)| a - b).collect();
        // |(c, s)|² = 1 on base + τ·along
        let [c, s] = [size - 2, size - 1].map(|place| (base[place], along[place]));
        let (square, half, rest) = (c.1 * c.1 + s.1 * s.1, c.0 * c.1 + s.0 * s.1, c.0 * c.0 + s.0 * s.0 - 1.0);
        let under = half * half - square * rest;
        if under < 0.0 || square == 0.0 {
            return Ok(Vec::new());
        }
        let far = -(half + under.sqrt().copysign(half));
        let roots = [far / square, if far == 0.0 { 0.0 } else { rest / far }];
        let at = |tau: f64| base.iter().zip(&along).map(|(base, along)| base + tau * along).collect::<Vector>();
        Ok(roots.into_iter().map(|tau| self.point(times, &at(tau))).collect())
    }
}

/// Linear equations, square or one short, and Newton's laws where these are left over.
#[derive(Debug, Clone)]
pub(super) struct Linear {
    pub(super) columns: usize,
    rows: SmallVec<[Vector; 4]>,
    pub(super) right: Vector,
    pub(super) laws: SmallVec<[Vector; 2]>,
}

impl Linear {
    pub(super) fn matrix(&self) -> Matrix {
        Matrix::from_fn(self.columns, |i, j| self.rows[i][j])
    }

    pub(super) fn solve(&self) -> Option<Vector> {
        self.matrix().solve(&self.right)
    }
}

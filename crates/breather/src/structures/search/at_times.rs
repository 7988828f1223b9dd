//! Impulses, offsets and phase at given times: under a load of one harmonic, (c, s) = (cos, sin) of jωψ, these obey linear equations.

use smallvec::SmallVec;
use vibrochain_lattice::{Barrier, Complex};

use crate::equations::linear::{Factors, Matrix, Vector, unit, zeros};
use crate::error::BreatherError;
use crate::structures::equations::Equations;
use crate::structures::periodic_kernel::UNIT;
use crate::structures::point::{Point, Strike};

/// Where Newton's method begins.
pub(super) struct Start {
    pub(super) point: Point,
    /// It belongs to a zero that is known to be there.
    pub(super) is_zero: bool,
}

impl From<Point> for Start {
    fn from(point: Point) -> Self {
        Self::new(point, false)
    }
}

impl Start {
    pub(super) fn new(point: Point, is_zero: bool) -> Self {
        Self { point, is_zero }
    }

    pub(super) fn zero(point: Point) -> Self {
        Self::new(point, true)
    }
}

/// Zeros, and places where there may be some.
pub(super) fn all_places<'p, T: Copy>(zeros: &'p [T], unresolved: &'p [T]) -> impl Iterator<Item = (T, bool)> + 'p {
    zeros.iter().map(|at| (*at, true)).chain(unresolved.iter().map(|at| (*at, false)))
}

/// An equation that is off by this part of its terms holds: numbers that solve others have lost some digits.
const HOLDS: f64 = 1e3 * f64::EPSILON;

/// Of a line whose distance from 0 differs by less than this from the circle's radius, rounding decides whether it meets the circle twice or not at
/// all.
const GRAZES: f64 = 1e-6;

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
    pub(super) fn linear(&self, times: &[f64]) -> Result<Linear, BreatherError> {
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
        // Behind (c, s) states of open modes.
        let states = x[n + rigid..].iter().skip(if self.equations.single().is_some() { 2 } else { 0 });
        let offsets = x[n..n + rigid].iter().chain(states).copied().collect();
        let period = self.equations.period();
        Point { strikes: strikes.collect(), psi, period, offsets }
    }

    /// The line of (c, s) that the equations leave: of one impact; and of two half a period apart where what the second one asks is what the
    /// first one does. `None` where they leave more.
    pub(super) fn line(&self, times: &[f64]) -> Result<Option<Line>, BreatherError> {
        let linear = self.linear(times)?;
        let size = linear.columns;
        // (c, s) along a direction in which the equations determine the rest best.
        let bordered = [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|direction| {
            let row = |j: usize| if j + 2 < size { 0.0 } else { direction[j + 2 - size] };
            Factors::new(Matrix::from_fn(size, |i, j| if i + 1 < size { linear.rows[i][j] } else { row(j) }))
        });
        let best = bordered.iter().flatten().max_by(|a, b| a.determinant.abs().total_cmp(&b.determinant.abs()));
        let Some(best) = best else { return Ok(None) };
        let solved = |last: f64| {
            let right: Vector = linear.right[..size - 1].iter().copied().chain([last]).collect();
            Some(best.solve(&right)).filter(|x| x.iter().all(|x| x.is_finite()))
        };
        let (Some(base), Some(moved)) = (solved(0.0), solved(1.0)) else { return Ok(None) };
        // Of elastic impacts half a period apart the terms P/m and (1+e)K′P of a law cancel in its entry: the size of P/m is counted, too.
        let laws = times.len() + self.equations.rigid.len();
        let own = |x: &Vector, row: usize| self.equations.mobility(self.letters[row - laws].0) * x[row - laws].abs();
        let misfits = [&base, &moved].map(|x| linear.misfit(size - 1, x, |row| own(x, row)));
        let along = moved.iter().zip(&base).map(|(a, b)| a - b).collect();
        let of_phase: Vector = (0..size - 1)
            .map(|row| best.solve(&unit(size, row)))
            .map(|moved| moved[size - 2].hypot(moved[size - 1]))
            .collect();
        let blurs = [&base, &moved].map(|x| {
            let of_row = |(row, moved): (usize, &f64)| {
                moved * (linear.size(row, x) + if row < laws { 0.0 } else { own(x, row) })
            };
            UNIT * of_phase.iter().enumerate().map(of_row).sum::<f64>()
        });
        Ok(Some(Line { base, along, misfit: misfits[0].max(misfits[1]), blur: blurs[0].max(blurs[1]) }))
    }

    /// Both phases where that line meets the circle.
    pub(super) fn on_a_line(&self, times: &[f64]) -> Result<Vec<Start>, BreatherError> {
        Ok(self.line(times)?.map_or_else(Vec::new, |line| self.starts_on(&line, times)))
    }

    /// The same of a line that is known.
    pub(super) fn starts_on(&self, line: &Line, times: &[f64]) -> Vec<Start> {
        let start = |x: &Vector| Start::new(self.point(times, x), line.holds());
        line.on_the_circle().iter().map(start).collect()
    }
}

/// The points that solve as many of the linear equations as there are unknowns, less one: base + τ·along.
pub(super) struct Line {
    base: Vector,
    along: Vector,
    /// The largest residual of the equations that are left, as a part of the sum of the moduli of their terms.
    pub(super) misfit: f64,
    /// What rounding of the equations makes of (c, s): under a load that hardly moves the contacts all that they are.
    blur: f64,
}

impl Line {
    /// Whether every point of the line solves the equations that are left, too, to within rounding.
    pub(super) fn holds(&self) -> bool {
        self.misfit <= HOLDS
    }

    /// The least distance of (c, s) from 0 on the line, the τ of that point, and the length of (c, s) along; `None` where (c, s) do not vary.
    fn foot(&self) -> Option<[f64; 3]> {
        let size = self.base.len();
        let [c, s] = [size - 2, size - 1].map(|place| (self.base[place], self.along[place]));
        let length = c.1.hypot(s.1);
        let distance = (c.0 * s.1 - s.0 * c.1).abs() / length;
        (!distance.is_nan()).then_some([distance, -(c.0 * c.1 + s.0 * s.1) / length / length, length])
    }

    /// How many times as large loads have to be for the line to meet the circle; `None` where it does.
    pub(super) fn too_weak(&self) -> Option<f64> {
        self.foot().map(|[distance, ..]| distance).filter(|distance| *distance > 1.0)
    }

    /// Whether the line meets the circle twice or does not meet it, whatever rounding has done to it.
    pub(super) fn is_decided(&self) -> bool {
        self.foot().is_some_and(|[distance, ..]| (distance - 1.0).abs() > GRAZES) && self.is_sharp()
    }

    /// The same as far as rounding of the equations alone goes.
    pub(super) fn is_sharp(&self) -> bool {
        let blurred =
            |[distance, foot, _]: [f64; 3]| (distance - 1.0).abs() <= ((1.0 - foot).abs() + foot.abs()) * self.blur;
        !self.foot().is_some_and(blurred)
    }

    /// The two points of the line with c² + s² = 1. They are worked out from the line's distance from 0, not from a quadratic equation: where the line
    /// nearly touches the circle, both keep their digits.
    pub(super) fn on_the_circle(&self) -> SmallVec<[Vector; 2]> {
        let Some([distance, foot, length]) = self.foot().filter(|foot| foot[0] <= 1.0) else {
            return SmallVec::new();
        };
        // Lists begin with the solution of the larger τ.
        let reach = (((1.0 - distance) * (1.0 + distance)).sqrt() / length).copysign(foot);
        let at = |tau: f64| self.base.iter().zip(&self.along).map(|(base, along)| base + tau * along).collect();
        [foot + reach, foot - reach].map(at).into()
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

    /// The sum of the moduli of the terms of an equation.
    fn size(&self, number: usize, x: &[f64]) -> f64 {
        self.rows[number].iter().zip(x).map(|(entry, x)| (entry * x).abs()).sum::<f64>() + self.right[number].abs()
    }

    /// The largest residual that x leaves of equations number `first` and later, as a part of the sum of the moduli of their terms; `own` is the size
    /// of terms that cancel within an entry.
    fn misfit(&self, first: usize, x: &[f64], own: impl Fn(usize) -> f64) -> f64 {
        let of_row = |number: usize| {
            let terms = || self.rows[number].iter().zip(x).map(|(entry, x)| entry * x).chain([-self.right[number]]);
            let size = self.size(number, x) + own(number);
            if size > 0.0 { terms().sum::<f64>().abs() / size } else { 0.0 }
        };
        (first..self.rows.len()).map(of_row).fold(0.0, f64::max)
    }

    pub(super) fn solve(&self) -> Option<Vector> {
        self.matrix().solve(&self.right)
    }
}

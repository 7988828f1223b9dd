//! In which two coordinates the flight of a mode is written.

use rustfft::num_complex::Complex;
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};
use std::ops::{Add, Mul, Sub};

use super::turn::{Turn, Turned};

type C = Complex<f64>;

/// Half the distance of two real poles, times the period, beyond which each has a coordinate of its own.
const FAR: f64 = 0.5;

/// The coordinates of a mode. A number of either kind, [`Turned`], acts on them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinates {
    /// Both poles share them, and may meet: a number is a + bJ.
    Shared(Turn),
    /// Each of two real poles has one: a number is a factor for each. In sums and differences of both, a flight back in time of the faster
    /// pole would drown the slower one.
    Apart,
}

impl Coordinates {
    /// Those in which a mode of this turn keeps its digits for a period.
    pub(super) fn of(turn: Turn, rate: f64, period: f64) -> Self {
        if turn == Turn::Hyperbolic && rate * period > FAR { Self::Apart } else { Self::Shared(turn) }
    }

    /// What a contact sees of the mode, and gives to it, in these coordinates; told in those of the algebra.
    pub(super) fn told(self, row: [f64; 2], column: [f64; 2]) -> [[f64; 2]; 2] {
        match self {
            Self::Shared(_) => [row, column],
            // The eigenvectors of J.
            Self::Apart => {
                [[row[0] + row[1], row[0] - row[1]], [0.5 * (column[0] + column[1]), 0.5 * (column[0] - column[1])]]
            }
        }
    }

    /// Errors of a row and a column by their lengths, in these coordinates: one number where these turn into one another, one for each where
    /// they do not.
    pub(super) fn doubts(self, [row, column]: [f64; 2]) -> [[f64; 2]; 2] {
        match self {
            Self::Shared(_) => [[row, 0.0], [column, 0.0]],
            Self::Apart => [[SQRT_2 * row; 2], [FRAC_1_SQRT_2 * column; 2]],
        }
    }

    /// What is left of the error of a row or a column when a number has acted on it: of coordinates that turn into one another the length of
    /// what it may be, and nothing in the second place; of two that do not, either's own.
    #[inline]
    pub fn carried(self, error: [f64; 2], by: Turned) -> [f64; 2] {
        match self {
            Self::Shared(Turn::Circular) => [error[0] * (by.even * by.even + by.odd * by.odd).sqrt(), 0.0],
            Self::Shared(_) => [error[0] * (by.even.abs() + by.odd.abs()), 0.0],
            Self::Apart => [error[0] * by.even.abs(), error[1] * by.odd.abs()],
        }
    }

    /// An error with that part of the entries themselves.
    #[inline]
    pub fn with_part(self, error: [f64; 2], part: f64, entries: [f64; 2]) -> [f64; 2] {
        let [x, y] = entries;
        match self {
            Self::Shared(_) => [error[0] + part * (x * x + y * y).sqrt(), 0.0],
            Self::Apart => [error[0] + part * x.abs(), error[1] + part * y.abs()],
        }
    }

    /// Whether the poles are two complex ones.
    #[inline]
    pub fn are_circular(self) -> bool {
        self == Self::Shared(Turn::Circular)
    }

    /// Whether both poles are one.
    #[inline]
    pub fn are_parabolic(self) -> bool {
        self == Self::Shared(Turn::Parabolic)
    }

    /// A, of a mode that dies at the rate `decay`.
    #[inline]
    pub fn generator(self, decay: f64, rate: f64) -> Turned {
        match self {
            Self::Shared(_) => Turned { even: -decay, odd: rate },
            Self::Apart => Turned { even: rate - decay, odd: -rate - decay },
        }
    }

    /// e^{At}
    pub fn flight(self, decay: f64, rate: f64, t: f64) -> Turned {
        match self {
            Self::Shared(turn) => turn.flight(decay, rate, t),
            Self::Apart => Turned { even: ((rate - decay) * t).exp(), odd: ((-rate - decay) * t).exp() },
        }
    }

    /// The product of two numbers.
    pub fn product<T>(self, first: Turned<T>, second: Turned<T>) -> Turned<T>
    where
        T: Copy + Mul<Output = T> + Add<Output = T> + Mul<f64, Output = T>,
    {
        match self {
            Self::Shared(turn) => turn.product(first, second),
            Self::Apart => Turned { even: first.even * second.even, odd: first.odd * second.odd },
        }
    }

    /// A number added to the unit of both.
    pub fn one_more(self, number: Turned<C>) -> Turned<C> {
        match self {
            Self::Shared(_) => Turned { even: number.even + 1.0, odd: number.odd },
            Self::Apart => Turned { even: number.even + 1.0, odd: number.odd + 1.0 },
        }
    }

    /// row·number
    #[inline]
    pub fn seen<T>(self, row: [f64; 2], by: Turned<T>) -> [T; 2]
    where
        T: Copy + Mul<f64, Output = T> + Add<Output = T> + Sub<Output = T>,
    {
        match self {
            Self::Shared(turn) => {
                [by.even * row[0] - by.odd * (turn.sign() * row[1]), by.odd * row[0] + by.even * row[1]]
            }
            Self::Apart => [by.even * row[0], by.odd * row[1]],
        }
    }

    /// number·column
    #[inline]
    pub fn given<T>(self, by: Turned<T>, column: [f64; 2]) -> [T; 2]
    where
        T: Copy + Mul<f64, Output = T> + Add<Output = T> + Sub<Output = T>,
    {
        match self {
            Self::Shared(turn) => {
                [by.even * column[0] + by.odd * column[1], by.even * column[1] - by.odd * (turn.sign() * column[0])]
            }
            Self::Apart => [by.even * column[0], by.odd * column[1]],
        }
    }

    /// row·number·column
    #[inline]
    pub fn pair<T>(self, row: [f64; 2], by: Turned<T>, column: [f64; 2]) -> T
    where
        T: Copy + Mul<f64, Output = T> + Add<Output = T>,
    {
        match self {
            Self::Shared(turn) => turn.pair(row, by, column),
            Self::Apart => by.even * (row[0] * column[0]) + by.odd * (row[1] * column[1]),
        }
    }

    /// How large a product of a row and a column can be, per size of the number between them.
    #[inline]
    pub fn reach(self, row: [f64; 2], column: [f64; 2]) -> f64 {
        let length = |[x, y]: [f64; 2]| (x * x + y * y).sqrt();
        match self {
            Self::Shared(_) => length(row) * length(column),
            Self::Apart => (row[0] * column[0]).abs() + (row[1] * column[1]).abs(),
        }
    }

    /// What the errors of a row and a column make of their product, per size of the number between them.
    #[inline]
    pub fn reach_error(self, [row, row_error]: [[f64; 2]; 2], [column, column_error]: [[f64; 2]; 2]) -> f64 {
        self.reach(row_error, column) + self.reach(row, column_error) + self.reach(row_error, column_error)
    }

    /// The eigenvalues of a number: of a flight the two factors e^{λt}.
    #[inline]
    pub fn eigenvalues(self, number: Turned) -> [C; 2] {
        match self {
            Self::Shared(turn) => number.eigenvalues(turn),
            Self::Apart => [number.even, number.odd].map(|value| C::new(value, 0.0)),
        }
    }

    /// (z − R)⁻¹
    pub fn resolvent(self, number: Turned, z: C) -> Turned<C> {
        match self {
            Self::Shared(turn) => number.resolvent(turn, z),
            Self::Apart => Turned { even: (z - number.even).inv(), odd: (z - number.odd).inv() },
        }
    }

    /// (z − R)⁻¹ at a real z.
    pub fn real_resolvent(self, number: Turned, z: f64) -> Turned {
        let (way, odd) = (z - number.even, number.odd);
        let square = match self {
            Self::Shared(Turn::Circular) => way * way + odd * odd,
            // By the two poles.
            Self::Shared(Turn::Hyperbolic) => (way - odd) * (way + odd),
            Self::Shared(Turn::Parabolic) => way * way,
            Self::Apart => return Turned { even: way.recip(), odd: (z - odd).recip() },
        };
        Turned { even: way / square, odd: odd / square }
    }

    /// 1
    pub fn unit(self) -> Turned {
        Turned { even: 1.0, odd: if self == Self::Apart { 1.0 } else { 0.0 } }
    }

    /// The component of a row along the eigenvector of the first or second pole. The two poles must differ.
    #[inline]
    pub fn seen_of_pole(self, which: usize, row: [C; 2]) -> C {
        match self {
            Self::Shared(turn) => row[0] + eigenvector(turn, which) * row[1],
            Self::Apart => row[which],
        }
    }

    /// The component of a column along the eigenvector of the first or second pole. The two poles must differ.
    #[inline]
    pub fn given_to_pole(self, which: usize, column: [C; 2]) -> C {
        match self {
            Self::Shared(turn) => (column[0] + column[1] * eigenvector(turn, which).conj()) * 0.5,
            Self::Apart => column[which],
        }
    }
}

/// Of modulus 1 where the poles differ.
#[inline]
fn eigenvector(turn: Turn, which: usize) -> C {
    if which == 0 { turn.root() } else { -turn.root() }
}

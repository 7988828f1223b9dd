//! One direction of a lattice, M masses in a row: its modes by their plain formulas.
//!
//! | ends | λ_k/γ | normalised shape |
//! |---|---|---|
//! | closed | 4 sin²(πk/M), k = 0 … ⌊M/2⌋ | cos and sin of 2πkn/M |
//! | free | 4 sin²(πk/2M), k = 0 … M−1 | √(2/M) cos(πk(n+½)/M), 1/√M for k = 0 |
//! | fixed | 4 sin²(πk/2(M+1)), k = 1 … M | √(2/(M+1)) sin(πk(n+1)/(M+1)) |

use vibrochain_lattice::{Chain, Ends};

use crate::real::Real;

/// A row of masses. Its modes are numbered from 0, whatever k begins with.
#[derive(Debug, Clone)]
pub(crate) struct Direction {
    masses: usize,
    ends: Ends,
    /// Of a full turn in as many steps; empty until [`Direction::tabulated`].
    cosines: Vec<Real>,
}

impl Direction {
    /// Along the rows and across the layers.
    pub(crate) fn both(chain: &Chain) -> [Self; 2] {
        [(chain.length(), chain.ends()), (chain.layers(), chain.layer_ends())].map(|(masses, ends)| Self {
            masses,
            ends,
            cosines: Vec::new(),
        })
    }

    /// The same with its shapes to so many digits.
    pub(crate) fn tabulated(self, bits: usize) -> Self {
        let steps = self.steps();
        let turn = |j: usize| (Real::pi(bits) * (2 * j) as f64 / steps as f64).sin_cos().1;
        let half: Vec<Real> = (0..=steps / 2).map(turn).collect();
        Self { cosines: (0..steps).map(|j| half[j.min(steps - j)].clone()).collect(), ..self }
    }

    /// Steps of a full turn of which all angles of shapes are multiples.
    fn steps(&self) -> usize {
        match self.ends {
            Ends::Closed => self.masses,
            Ends::Free => 4 * self.masses,
            Ends::Fixed => 4 * (self.masses + 1),
        }
    }

    pub(crate) fn masses(&self) -> usize {
        self.masses
    }

    /// Number of frequencies: pairs of a ring count once.
    pub(crate) fn modes(&self) -> usize {
        if self.ends == Ends::Closed { self.masses / 2 + 1 } else { self.masses }
    }

    /// λ/γ
    pub(crate) fn stiffness(&self, mode: usize, bits: usize) -> Real {
        let (k, turn) = match self.ends {
            Ends::Closed => (mode, self.masses),
            Ends::Free => (mode, 2 * self.masses),
            Ends::Fixed => (mode + 1, 2 * (self.masses + 1)),
        };
        let (sin, _) = (Real::pi(bits) * k as f64 / turn as f64).sin_cos();
        &sin * &sin * 4.0
    }

    /// The square of what normalises a shape.
    pub(crate) fn weight(&self, mode: usize, bits: usize) -> Real {
        let (count, of) = match self.ends {
            Ends::Closed if mode == 0 || 2 * mode == self.masses => (1.0, self.masses),
            Ends::Free if mode == 0 => (1.0, self.masses),
            Ends::Closed | Ends::Free => (2.0, self.masses),
            Ends::Fixed => (2.0, self.masses + 1),
        };
        Real::new(count, bits) / of as f64
    }

    /// The shape between walls, without weight: sin x = cos (x − a quarter of a turn).
    fn sine(&self, mode: usize, n: usize) -> &Real {
        &self.cosines[(2 * (mode + 1) * (n + 1) + 3 * (self.masses + 1)) % self.steps()]
    }

    /// What a mode between walls takes of a push that is 1 at all masses, at each of them: φ(n) Σ_m φ(m).
    pub(crate) fn pushed(&self, mode: usize, bits: usize) -> Vec<Real> {
        let sum = (0..self.masses).fold(Real::zero(bits), |sum, n| sum + self.sine(mode, n));
        let share = sum * self.weight(mode, bits);
        (0..self.masses).map(|n| self.sine(mode, n) * &share).collect()
    }

    /// The shape at one mass times that at another, without weights; of a pair of a ring the sum of both products.
    pub(crate) fn product(&self, mode: usize, to: usize, from: usize) -> Real {
        let steps = self.steps();
        // At most 10⁷ masses: the products fit.
        let cos = |step: usize| &self.cosines[step % steps];
        match self.ends {
            Ends::Closed => cos(mode * to.abs_diff(from)).clone(),
            Ends::Free => cos(mode * (2 * to + 1)) * cos(mode * (2 * from + 1)),
            Ends::Fixed => self.sine(mode, to) * self.sine(mode, from),
        }
    }
}

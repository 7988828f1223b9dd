//! What the error of a frequency does to the equations of an orbit next to a resonance.
//!
//! There the kernel of a mode is large by (1−R)⁻¹, and so is what its rounding makes of a row. But the error of (1−R)⁻¹ is one number in all
//! rows: to the orbit it is another frequency of the mode, by a rounding, and Newton's matrix takes it back nearly whole. So it is carried as
//! one vector of rows, and not with the worst sign of each.

use vibrochain_lattice::Complex;

use super::equations::{Equations, Point};
use crate::equations::linear::{Vector, zeros};

type C = Complex<f64>;

/// A load this close to a mode, relative to itself, moves it by a number whose error is one in all rows.
const NEAR: f64 = 1e-3;

/// What one number with an error adds to the rows, and to the accelerations of the impacts; times its relative error.
#[derive(Debug, Clone)]
pub(super) struct ResonantDoubt {
    pub(super) rows: Vector,
    pub(super) accelerations: Vector,
}

impl Equations<'_> {
    /// Those of the modes next to a resonance with the period, and with a load.
    pub(super) fn resonant_doubts(&self, point: &Point) -> Vec<ResonantDoubt> {
        let impulses = self.kernel().nearly_resonant().map(|(place, doubt)| {
            self.doubt(point, doubt, |i| {
                let strike = &point.strikes[i];
                let mut jet = [0.0; 3];
                for (j, other) in point.strikes.iter().enumerate() {
                    let lapse = if i == j { 0.0 } else { strike.time - other.time };
                    let own = self.kernel().jet_of_mode(place, strike.contact, other.contact, lapse);
                    jet.iter_mut().zip(own).for_each(|(sum, own)| *sum += other.impulse * own);
                }
                jet
            })
        });
        let structure = self.model.structure();
        let modes = structure.modes().iter().filter(|_| self.forced);
        let loads =
            modes.flat_map(|mode| structure.harmonics().iter().zip(&mode.loads).map(move |(j, load)| (mode, j, load)));
        let driven = loads.filter_map(|(mode, harmonic, load)| {
            let w = f64::from(*harmonic) * self.model.omega();
            let away =
                mode.rates().map(|rate| (C::new(0.0, w) - rate).norm()).into_iter().fold(f64::INFINITY, f64::min);
            if *load == [C::default(); 2] || away >= NEAR * w {
                return None;
            }
            let xi = mode.steady(w, *load);
            Some(self.doubt(point, f64::EPSILON * w / away, |i| {
                let (strike, row) = (&point.strikes[i], mode.rows[point.strikes[i].contact]);
                let turn = C::from_polar(1.0, w * (strike.time + point.psi));
                let swing = (xi[0] * row[0] + xi[1] * row[1]) * turn;
                [swing, swing * C::new(0.0, w), swing * C::new(-w * w, 0.0)].map(|part| part.re)
            }))
        });
        impulses.chain(driven).collect()
    }

    /// From place, velocity and acceleration at each impact.
    fn doubt(&self, point: &Point, relative: f64, part: impl Fn(usize) -> [f64; 3]) -> ResonantDoubt {
        let n = point.strikes.len();
        let (mut rows, mut accelerations) = (zeros(self.unknowns(n)), zeros(n));
        for (i, strike) in point.strikes.iter().enumerate() {
            let [place, velocity, acceleration] = part(i).map(|part| relative * part);
            rows[i] = place;
            if let Some(row) = self.row_of_law(n, i) {
                rows[row] = (1.0 + self.restitution(strike.contact)) * velocity;
            }
            accelerations[i] = acceleration;
        }
        ResonantDoubt { rows, accelerations }
    }
}

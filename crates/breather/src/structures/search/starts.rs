//! Orbits of longer words: Newton's method from starts spread over times and phase.

use super::at_times::{Impacts, Start};
use super::orbits::Starts;
use crate::equations::linear::{Matrix, zeros};
use crate::error::BreatherError;
use crate::search::completeness::{Partial, Searched};
use crate::structures::point::{Point, Strike};

/// Starts of a word of three impacts or more.
pub(super) const STARTS: usize = 600;

impl Impacts<'_> {
    /// Starts spread over times and phase, with impulses that fit them.
    pub(super) fn starts(&self) -> Starts {
        let (n, period) = (self.letters.len(), self.equations.period());
        let mut points = Vec::with_capacity(STARTS);
        for number in 0..STARTS {
            // Additive recurrence by roots of the golden kind: even in all dimensions.
            let spread = |axis: usize| (0.5 + (number + 1) as f64 * golden(axis, n + 1)).fract();
            let mut times: Vec<f64> = (1..n).map(|axis| period * spread(axis)).collect();
            times.push(0.0);
            times.sort_by(f64::total_cmp);
            let psi = self.equations.model.period() * spread(0);
            points.extend(self.start(&times, psi)?.map(Start::from));
        }
        Ok((points, Searched::partial(Partial::Starts(STARTS))))
    }

    /// Impulses by Newton's laws at given times and phase, offsets by the positions.
    fn start(&self, times: &[f64], psi: f64) -> Result<Option<Point>, BreatherError> {
        let n = times.len();
        let strikes = self.letters.iter().zip(times).map(|(&(contact, barrier), &time)| Strike {
            contact,
            barrier,
            time,
            impulse: 0.0,
        });
        let offsets = smallvec::smallvec![0.0; self.equations.rigid.len()];
        let mut point = Point { strikes: strikes.collect(), psi, period: self.equations.period(), offsets };
        let mut law = Matrix::zeros(n);
        let mut right = zeros(n);
        for (i, strike) in point.strikes.iter().enumerate() {
            self.equations.model.heard()?;
            let weight = 1.0 + self.equations.restitution(strike.contact);
            let load = self.equations.load(strike.contact, strike.time + psi);
            right[i] = if self.equations.forced {
                -weight * load[1]
            } else {
                self.equations.model.barrier(strike.contact, strike.barrier)? - self.equations.still(strike.contact)
            };
            for (j, other) in point.strikes.iter().enumerate() {
                let lapse = if i == j { 0.0 } else { strike.time - other.time };
                let (jet, _) = self.equations.kernel().jet(strike.contact, other.contact, lapse);
                law[(i, j)] = if self.equations.forced { weight * jet[1] } else { jet[0] };
            }
            if self.equations.forced {
                law[(i, i)] += self.equations.mobility(strike.contact);
            }
        }
        let Some(impulses) = law.solve(&right) else { return Ok(None) };
        point.strikes.iter_mut().zip(&impulses).for_each(|(strike, impulse)| strike.impulse = *impulse);
        // A start that pulls leads to orbits that do.
        if point.strikes.iter().any(|strike| strike.barrier.sign() * strike.impulse > 0.0) {
            return Ok(None);
        }
        self.equations.with_offsets(point).map(Some)
    }
}

/// Powers of the inverse of the root of x^{d+1} = x + 1.
pub(super) fn golden(axis: usize, dimensions: usize) -> f64 {
    let mut root: f64 = 2.0;
    for _ in 0..30 {
        root = (1.0 + root).powf(1.0 / (dimensions as f64 + 1.0));
    }
    root.powi(-(axis as i32 + 1))
}

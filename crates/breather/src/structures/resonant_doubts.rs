//! What the error of a frequency does to the equations of an orbit next to a resonance.
//!
//! There the kernel of a mode is large by (1−R)⁻¹, and so is what its rounding makes of a row. But the error of (1−R)⁻¹ is one number in all
//! rows: to the orbit it is another frequency of the mode, by a rounding, and Newton's matrix takes it back nearly whole. So it is carried as
//! one vector of rows, and not with the worst sign of each.

use vibrochain_lattice::Complex;

use super::equations::Equations;
use super::periodic_kernel::EITHER_WAY;
use super::point::Point;
use super::response::NEAR;
use crate::equations::linear::{Vector, zeros};

type C = Complex<f64>;

/// What one number with an error adds to the rows, and to the accelerations of the impacts; times its relative error.
#[derive(Debug, Clone)]
pub(super) struct ResonantDoubt {
    pub(super) rows: Vector,
    pub(super) accelerations: Vector,
}

impl Equations<'_> {
    /// Those of the modes next to a resonance with the period, and with a load: of each what changes it in size, and what turns it.
    pub(super) fn resonant_doubts(&self, point: &Point) -> Vec<ResonantDoubt> {
        let near = self.kernel().nearly_resonant().flat_map(|of| EITHER_WAY.map(|by| (of, by)));
        let impulses = near.map(|((place, doubt), by)| {
            self.doubt(point, doubt, |i| {
                let strike = &point.strikes[i];
                let mut jet = [0.0; 3];
                for (j, other) in point.strikes.iter().enumerate() {
                    let lapse = if i == j { 0.0 } else { strike.time - other.time };
                    let own = self.kernel().jet_of_mode(place, by, (strike.contact, other.contact), lapse);
                    jet.iter_mut().zip(own).for_each(|(sum, own)| *sum += other.impulse * own);
                }
                jet
            })
        });
        let (structure, omega) = (self.model.structure(), self.model.omega());
        let modes = structure.modes().iter().enumerate().filter(|_| self.forced);
        let driven = modes.flat_map(|(number, mode)| {
            let apart = (0..structure.harmonics().len()).filter(move |place| !self.driven.contains(&(number, *place)));
            apart.map(move |place| (mode, place))
        });
        let driven = driven.filter(|(mode, place)| structure.is_near(mode, *place, omega, NEAR));
        let driven = driven.flat_map(|(mode, place)| [C::new(1.0, 0.0), C::new(0.0, 1.0)].map(|by| (mode, place, by)));
        let loads = driven.map(|(mode, place, by)| {
            let w = f64::from(structure.harmonics()[place]) * omega;
            let xi = mode.steady(w, mode.loads[place]);
            self.doubt(point, structure.swing_error(mode, place, omega), |i| {
                let (strike, row) = (&point.strikes[i], mode.rows[point.strikes[i].contact]);
                let turn = C::from_polar(1.0, w * (strike.time + point.psi));
                let swing = (xi[0] * row[0] + xi[1] * row[1]) * turn * by;
                [swing, swing * C::new(0.0, w), swing * C::new(-w * w, 0.0)].map(|part| part.re)
            })
        });
        impulses.chain(loads).collect()
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

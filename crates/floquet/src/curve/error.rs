//! How well points of a curve are known.

use vibrochain_breather::Surface;
use vibrochain_lattice::Parameter;

use super::signal::Blind;
use super::walker::{Foot, Walker};
use crate::bracket::{DATA_ROUNDING, SAFETY, SAMPLE_STEP, spread};

/// The error is worked out at every so many points; between two it is no more than this times the larger of theirs.
const EVERY: usize = 16;
const BETWEEN: f64 = 2.0;

/// Points to each side across the curve at which rounding is sampled.
const SAMPLES: i32 = 3;

impl Walker {
    /// The error at each of the feet, as a part of the window's sides.
    pub(super) fn errors(&mut self, feet: &[Foot]) -> Vec<f64> {
        let last = feet.len().saturating_sub(1);
        let places: Vec<usize> = (0..last).step_by(EVERY).chain([last]).collect();
        let told: Vec<f64> = places.iter().map(|&i| self.error_at(feet, i).unwrap_or(f64::INFINITY)).collect();
        let mut errors = vec![f64::INFINITY; feet.len()];
        for (k, pair) in places.windows(2).enumerate() {
            let both = told[k].max(told[k + 1]);
            errors[pair[0]..=pair[1]].fill(BETWEEN * both);
        }
        places.iter().zip(&told).for_each(|(&i, error)| errors[i] = *error);
        errors
    }

    /// What rounding of the signal, of the equations and of the data does to the curve across itself.
    fn error_at(&mut self, feet: &[Foot], i: usize) -> Result<f64, Blind> {
        let (foot, window) = (&feet[i], self.window);
        let gradient = self.gradient(&foot.point, foot.mark)?;
        let slope = gradient[0].hypot(gradient[1]);
        let normal = gradient.map(|x| x / slope);
        let (mut values, mut first, mut second) = (Vec::new(), Vec::new(), Vec::new());
        let across = foot.point.heading(normal);
        for k in -SAMPLES..=SAMPLES {
            let s = f64::from(k) * SAMPLE_STEP;
            let Ok(there) = self.surface.step(&foot.point, normal.map(|x| s * x)) else { continue };
            values.push(self.value(&there, foot.mark)?.value - slope * s);
            let parts = window.parts(there.values());
            first.push(parts[0] - across[0] * s);
            second.push(parts[1] - across[1] * s);
        }
        let place = spread(first.into_iter()).hypot(spread(second.into_iter()));
        let along = SAFETY * spread(values.into_iter()) / slope * across[0].hypot(across[1]);
        Ok(along + SAFETY * place + DATA_ROUNDING * self.sensitivity(feet, i))
    }

    /// Σ |π ∂/∂π| of the place of the curve, across itself, over all parameters π of the model.
    fn sensitivity(&self, feet: &[Foot], i: usize) -> f64 {
        let (foot, window) = (&feet[i], self.window);
        let (from, to) = (&feet[i.saturating_sub(1)], &feet[(i + 1).min(feet.len() - 1)]);
        let (from, to) = (window.parts(from.point.values()), window.parts(to.point.values()));
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let norm = dx.hypot(dy);
        let across = if norm > 0.0 { [dy.abs() / norm, dx.abs() / norm] } else { [1.0, 1.0] };
        let (orbit, sides) = (foot.point.orbit(), window.sides());
        let model = orbit.model();
        let mut sum: f64 = (0..2).map(|k| across[k] * (model.get(window.parameters[k]) / sides[k]).abs()).sum();
        // The axis that the curve crosses more steeply.
        let axis = usize::from(across[1] > across[0]);
        for parameter in Parameter::ALL {
            let value = model.get(parameter);
            let absent = model.is_conservative() && matches!(parameter, Parameter::Amplitude | Parameter::Restitution);
            if window.parameters.contains(&parameter) || value == 0.0 || absent {
                continue;
            }
            let free = [(window.parameters[axis], sides[axis]), (parameter, value)];
            // Where the change breaks a symmetry there is no such curve, nor rounding that would do it.
            let Ok(surface) = Surface::through(orbit, free) else { continue };
            let mut beside = self.beside(surface);
            let Ok(start) = beside.surface.start() else { continue };
            let Ok(gradient) = beside.gradient(&start, foot.mark) else { continue };
            let heading = start.heading([-gradient[1], gradient[0]]);
            let rate = (heading[0] / heading[1]).abs();
            if rate.is_finite() {
                sum += across[axis] * rate;
            }
        }
        sum
    }
}

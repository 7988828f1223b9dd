//! Orbits of two impacts by the values of a function of the time between them in many places: where it cannot be enclosed.

use std::f64::consts::TAU;

use super::at_times::Impacts;
use super::orbits::Starts;
use crate::equations::linear::Factors;
use crate::error::BreatherError;
use crate::roots::bracket::zero;
use crate::search::completeness::{Partial, Searched};

/// Places at which a function of one variable is looked at, for each turn of the fastest mode that counts, and at least and at most.
const PLACES: f64 = 24.0;
const LEAST_PLACES: usize = 240;
const MOST_PLACES: usize = 20_000;

impl Impacts<'_> {
    /// Zeros of the function of the time between two impacts, by its values in many places.
    pub(super) fn scan(&self) -> Starts {
        let period = self.equations.period();
        let felt = |(rate, size): (f64, f64)| if size > 0.0 { rate } else { 0.0 };
        let modes = self.equations.model.structure().modes();
        let fastest = modes.iter().map(|mode| {
            let size: f64 = self
                .letters
                .iter()
                .map(|&(contact, _)| mode.rows[contact][0].abs() + mode.rows[contact][1].abs())
                .sum();
            felt((mode.rate, size))
        });
        let fastest = fastest.fold(self.equations.model.omega(), f64::max);
        let places = ((PLACES * fastest * period / TAU) as usize).clamp(LEAST_PLACES, MOST_PLACES);
        let at = |phi: f64| self.value(phi).map(|value| value[0]);
        let both: Vec<(f64, [f64; 2])> = (1..places)
            .map(|i| period * i as f64 / places as f64)
            .map(|phi| Ok((phi, self.value(phi)?)))
            .collect::<Result<_, BreatherError>>()?;
        let grid: Vec<(f64, f64)> = both.iter().map(|&(phi, [value, _])| (phi, value)).collect();
        let mut zeros_found = Vec::new();
        for pair in grid.windows(2) {
            let [(a, left), (b, right)] = [pair[0], pair[1]];
            if left == 0.0 {
                zeros_found.push(a);
            } else if left * right < 0.0 {
                zeros_found.push(zero((a, left), (b, right), period, at)?);
            }
        }
        // A structure that is its own mirror image: there F has a double zero, and no sign changes.
        let mut starts = if self.equations.forced { self.on_a_line(&[0.0, 0.5 * period])? } else { Vec::new() };
        // Where Δ = 0, F is a sum of squares: between two places with F < 0 that is a pair of zeros, or of all barriers at the rest
        // position a double one, with F = −Δ² all around.
        for pair in both.windows(2) {
            let [(a, [left, first]), (b, [right, last])] = [pair[0], pair[1]];
            if self.equations.forced && left < 0.0 && right < 0.0 && first * last < 0.0 {
                let place = zero((a, first), (b, last), period, |phi| self.value(phi).map(|value| value[1]))?;
                starts.extend(self.on_a_line(&[0.0, place])?);
                let value = at(place)?;
                if value > 0.0 {
                    for end in [(a, left), (b, right)] {
                        zeros_found.push(zero(end, (place, value), period, at)?);
                    }
                }
            }
        }
        for three in grid.windows(3) {
            // Two zeros between two places show as a dip.
            let [left, middle, right] = [three[0].1, three[1].1, three[2].1];
            if left * middle > 0.0 && middle * right > 0.0 && middle.abs() < left.abs() && middle.abs() < right.abs() {
                // With its sign: |F| itself is least at either zero, where rounding alone decides on which side.
                let signed = |phi: f64| at(phi).map_or(f64::NAN, |value| value * middle.signum());
                let turn = lowest(signed, three[0].0, three[2].0);
                let value = at(turn)?;
                if value * middle <= 0.0 {
                    for end in [three[0], three[2]] {
                        zeros_found.push(zero(end, (turn, value), period, at)?);
                    }
                }
            }
        }
        for phi in zeros_found {
            if let Some(x) = self.linear(&[0.0, phi])?.solve() {
                starts.push(self.point(&[0.0, phi], &x).into());
            }
        }
        Ok((starts, Searched::partial(Partial::Places(places))))
    }

    /// F(φ), or the law that is left times the determinant; and the determinant Δ.
    pub(super) fn value(&self, phi: f64) -> Result<[f64; 2], BreatherError> {
        let linear = self.linear(&[0.0, phi])?;
        let Some(factors) = Factors::new(linear.matrix()) else { return Ok([0.0; 2]) };
        let (x, scale) = (factors.solve(&linear.right), factors.determinant);
        let value = if self.equations.forced {
            let (c, s) = (x[linear.columns - 2] * scale, x[linear.columns - 1] * scale);
            c * c + s * s - scale * scale
        } else {
            linear.laws[1].iter().zip(&x).map(|(law, x)| law * x).sum::<f64>() * scale
        };
        Ok([value, scale])
    }
}

/// Where a function is least between two places, by golden sections.
fn lowest(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let (mut x, mut y) = (b - golden * (b - a), a + golden * (b - a));
    let (mut at_x, mut at_y) = (f(x), f(y));
    for _ in 0..60 {
        if at_x < at_y {
            (b, y, at_y) = (y, x, at_x);
            x = b - golden * (b - a);
            at_x = f(x);
        } else {
            (a, x, at_x) = (x, y, at_y);
            y = a + golden * (b - a);
            at_y = f(y);
        }
    }
    0.5 * (a + b)
}

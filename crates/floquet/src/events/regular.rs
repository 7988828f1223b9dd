//! det J(e^{iθ}) made regular, and what rounding does to it.
//!
//! Rows are divided by the lengths they would have without resonance; each mode's poles p are taken away by (z−p₁)(z−p₂)/z, over its size
//! where z is far from them; and columns are measured by impulses, whose signs are taken away.

use nalgebra::Complex;
use vibrochain_breather::linear::{cofactors, determinant};
use vibrochain_breather::{BlochEquations, ShapeErrors};

type C = Complex<f64>;

/// A mode's poles farther from a multiplier than this leave its size alone.
const NEAR: f64 = 0.05;

/// Rounding of an entry, with room for the few operations that it takes.
const ENTRY: f64 = 4.0 * f64::EPSILON;

/// J(e^{iθ}) and its derivative by θ, and what makes its determinant regular.
pub(super) struct Regular<'a> {
    equations: &'a BlochEquations,
    z: C,
    size: usize,
    matrix: Vec<C>,
    slopes: Vec<C>,
    /// Of the rows.
    lengths: Vec<f64>,
    factor: C,
}

impl<'a> Regular<'a> {
    pub(super) fn of(equations: &'a BlochEquations, theta: f64) -> Self {
        let z = if theta == std::f64::consts::PI { C::new(-1.0, 0.0) } else { C::from_polar(1.0, theta) };
        let (size, modes) = (equations.size(), equations.kernel().modes());
        let (mut matrix, mut slopes) = (Vec::new(), Vec::new());
        equations.fill(z, &mut matrix, Some(&mut slopes));
        let mut terms: Vec<f64> = equations.constant(false).iter().map(|entry| entry.abs()).collect();
        let mut factor = C::new(equations.impacts().iter().map(|impact| impact.impulse.signum()).product(), 0.0);
        for (k, mode) in modes.iter().enumerate() {
            let (rows, columns) = (equations.rows(k), equations.columns(k));
            for (row, line) in rows.iter().zip(terms.chunks_mut(size)) {
                line.iter_mut().zip(columns).for_each(|(entry, column)| {
                    *entry += mode.coordinates.reach(*row, *column);
                });
            }
            let [one, other] = mode.poles();
            let away = (z - one) * (z - other) / z;
            factor *= away / away.norm().hypot(NEAR);
        }
        let length = |terms: &[f64]| terms.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        let lengths: Vec<f64> = terms.chunks(size).map(length).collect();
        for ((row, slope), length) in matrix.chunks_mut(size).zip(slopes.chunks_mut(size)).zip(&lengths) {
            row.iter_mut().for_each(|entry| *entry /= *length);
            // dz/dθ = iz
            slope.iter_mut().for_each(|entry| *entry *= C::i() * z / *length);
        }
        Self { equations, z, size, matrix, slopes, lengths, factor }
    }

    /// The determinant and its derivative where it vanishes. Both are real without losses.
    pub(super) fn values(mut self) -> [C; 2] {
        let size = self.size;
        let slope: C = (0..size)
            .map(|i| {
                let mut one = self.matrix.clone();
                one[i * size..(i + 1) * size].copy_from_slice(&self.slopes[i * size..(i + 1) * size]);
                determinant(&mut one, size)
            })
            .sum();
        [determinant(&mut self.matrix, size) * self.factor, slope * self.factor]
    }

    /// What rounding does to the determinant next to 0, with the worst signs; but a simple pole moves all entries together. `left_out` is the
    /// row of an acceleration that the equations do not hold.
    pub(super) fn rounding(mut self, left_out: Option<usize>) -> f64 {
        let (size, equations, z) = (self.size, self.equations, self.z);
        let Some(mut minors) = cofactors(&mut self.matrix, size) else { return f64::INFINITY };
        minors.chunks_mut(size).zip(&self.lengths).for_each(|(row, length)| row.iter_mut().for_each(|x| *x /= *length));
        let mut errors = entry_errors(equations, z, false);
        for (i, slide) in slide_errors(equations).into_iter().enumerate().filter(|(i, _)| left_out != Some(2 * i + 1)) {
            errors[(2 * i + 1) * (size + 1)] += slide;
        }
        let own: f64 = minors.iter().zip(errors).map(|(minor, error)| minor.norm() * error).sum();
        let modes = equations.kernel().modes().iter().enumerate();
        let apart = modes.filter(|(_, mode)| !mode.coordinates.are_parabolic());
        let of_poles = apart.flat_map(|(k, mode)| [0, 1].map(|which| (k, mode, which))).map(|(k, mode, which)| {
            let complex = |pair: &[f64; 2]| pair.map(|x| C::new(x, 0.0));
            let given =
                equations.columns(k).iter().map(|column| mode.coordinates.given_to_pole(which, complex(column)));
            let given: Vec<C> = given.collect();
            let moved: C = (equations.rows(k).iter().zip(minors.chunks(size)))
                .map(|(row, minors)| {
                    let through: C = minors.iter().zip(&given).map(|(minor, given)| minor * given).sum();
                    mode.coordinates.seen_of_pole(which, complex(row)) * through
                })
                .sum();
            // The derivative of p/(z−p).
            let slope = z / (z - mode.poles()[which]).powi(2);
            (slope * moved).norm() * mode.pole_errors()[which]
        });
        (own + of_poles.sum::<f64>()) * self.factor.norm()
    }
}

/// Errors of the entries of J(z): of the shapes and flights of modes, and of the sums; and of the poles, but of simple ones only if these are
/// asked for.
fn entry_errors(equations: &BlochEquations, z: C, simple: bool) -> Vec<f64> {
    let mut errors: Vec<f64> = equations.constant(false).iter().map(|entry| ENTRY * entry.abs()).collect();
    let (mut doubts, size) = (ShapeErrors::default(), equations.size());
    for (k, mode) in equations.kernel().modes().iter().enumerate() {
        // Sums of the past have 1/(z−p), and its error is that of the pole.
        let near = mode.poles().map(|pole| (z - pole).norm().recip());
        let near = near[0].max(near[1]).max(1.0);
        // A pole at z itself is that of a rigid mode, of which accelerations say nothing.
        if !near.is_finite() {
            continue;
        }
        let period = equations.kernel().period();
        let flights = ENTRY * (1.0 + (mode.rate + mode.decay.abs()) * period) + mode.rate_error * period;
        let of_pole = if simple || mode.coordinates.are_parabolic() { mode.pole_error * near } else { 0.0 };
        let (rows, columns) = (equations.rows(k), equations.columns(k));
        equations.shape_errors(k, &mut doubts);
        let [row_errors, column_errors] = &doubts;
        let reach = |row: [f64; 2], column: [f64; 2]| mode.coordinates.reach(row, column);
        for (i, line) in errors.chunks_mut(size).enumerate() {
            for (j, error) in line.iter_mut().enumerate() {
                let shapes = mode.coordinates.reach_error([rows[i], row_errors[i]], [columns[j], column_errors[j]]);
                *error += near * ((flights + of_pole) * reach(rows[i], columns[j]) + shapes);
            }
        }
    }
    errors.iter_mut().zip(equations.sent_errors()).for_each(|(error, sent)| *error += sent);
    errors
}

/// Errors of the accelerations over ωP that J(z) holds: as they are summed, which is what J(1) makes of the past impacts.
fn slide_errors(equations: &BlochEquations) -> Vec<f64> {
    if let Some(errors) = equations.slide_errors() {
        return errors.to_vec();
    }
    let (size, impacts) = (equations.size(), equations.impacts());
    let errors = entry_errors(equations, C::new(1.0, 0.0), true);
    let of = |i: usize| {
        let row = &errors[(2 * i + 1) * size..(2 * i + 2) * size];
        let sums: f64 = impacts.iter().enumerate().map(|(j, other)| row[2 * j + 1] * other.impulse.abs()).sum();
        (sums + 2.0 * ENTRY * impacts[i].acceleration_before.abs() / equations.omega()) / impacts[i].impulse.abs()
    };
    (0..impacts.len()).map(of).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use vibrochain_breather::LinearImpact;
    use vibrochain_lattice::BlochKernel;
    use vibrochain_testkit::Random;

    use super::*;

    /// A part by which periods are off: far more than rounding, far less than what is not linear in it.
    const PART: f64 = 1e-10;

    /// Two or three impacts over two to five modes that swing, and the same in a period that is longer by a part.
    fn twice(random: &mut Random) -> [(BlochKernel, Vec<LinearImpact>); 2] {
        let (modes, count, period) = (2 + random.below(4), 2 + random.below(2), random.between(1.0, 6.0));
        let kernels = (0..modes).map(|_| {
            let damping = random.log(1e-3, 3.0);
            (random.log(0.3, 6.0), damping, [(); 2].map(|()| random.between(-1.0, 1.0)))
        });
        let kernels: Vec<_> = kernels.collect();
        let impacts: Vec<LinearImpact> = (0..count)
            .map(|i| LinearImpact {
                contact: random.below(2),
                time: period * (i as f64 + random.between(0.0, 0.8)) / 3.0,
                impulse: random.between(0.3, 2.0),
                restitution: random.between(0.4, 1.0),
                acceleration_before: random.between(-1.0, 1.0),
            })
            .collect();
        [1.0, 1.0 + PART].map(|longer| {
            let mut kernel = BlochKernel::new(period * longer, 2);
            kernels
                .iter()
                .for_each(|(frequency, damping, shapes)| kernel.push_oscillator(*frequency, *damping, shapes));
            (kernel, impacts.clone())
        })
    }

    /// Entries of J and accelerations as sums over modes move with the period by less than their errors, and these are no idle numbers.
    #[test]
    fn entries_and_accelerations_move_within_their_errors() {
        let (mut random, mut near) = (Random(17), [0.0_f64; 2]);
        for round in 0..300 {
            let [(kernel, impacts), (longer, later)] = twice(&mut random);
            let told = BlochEquations::new(kernel.of_uncertain_period(PART), impacts);
            let moved = BlochEquations::new(longer, later);
            let (size, z) = (told.size(), C::from_polar(1.0, random.between(0.1, PI)));
            let (here, there) = (told.matrix(z), moved.matrix(z));
            // Rows of places are in units of 1/ω, columns of times in units of ω.
            let by_omega = |at: usize| [1.0 + PART, 1.0][at / size % 2] / [1.0, 1.0 + PART][at % 2];
            for (at, error) in entry_errors(&told, z, true).into_iter().enumerate() {
                let off = (here[at] - there[at] * by_omega(at)).norm();
                assert!(off <= error, "{round} {at}: {off:e} {error:e}");
                near[0] = near[0].max(off / error);
            }
            let one = C::new(1.0, 0.0);
            let [here, there] = [&told, &moved].map(|equations| equations.matrix(one));
            let impulses: Vec<f64> = told.impacts().iter().map(|impact| impact.impulse).collect();
            for (i, error) in slide_errors(&told).into_iter().enumerate() {
                let slide = |sums: &[C]| {
                    let row = &sums[(2 * i + 1) * size..(2 * i + 2) * size];
                    impulses.iter().enumerate().map(|(j, impulse)| row[2 * j + 1].re * impulse).sum::<f64>()
                        / impulses[i]
                };
                let off = (slide(&here) - slide(&there) / (1.0 + PART)).abs();
                assert!(off <= error, "{round} {i}: {off:e} {error:e}");
                near[1] = near[1].max(off / error);
                // What rounding leaves of the acceleration itself.
                let own = told.impacts()[i].acceleration_before.abs() / (told.omega() * impulses[i].abs());
                assert!(error >= 2.0 * f64::EPSILON * own, "{round} {i}");
            }
        }
        assert!(near.iter().all(|near| *near > 0.05), "{near:?}");
    }

    /// The determinant next to 0, where the acceleration of the first impact makes it vanish, moves by less than is told, be it a period that is
    /// off or an acceleration; and its slope is that of a finite difference.
    #[test]
    fn a_determinant_that_vanishes_moves_by_less_than_its_rounding() {
        let (mut random, mut near, mut checked) = (Random(29), [0.0_f64; 2], 0);
        for round in 0..200 {
            let mut both = twice(&mut random);
            let size = 2 * both[0].1.len();
            let matrix = BlochEquations::new(both[0].0.clone(), both[0].1.clone()).matrix(C::new(-1.0, 0.0));
            let whole = determinant(&mut matrix.clone(), size);
            let mut one = matrix.clone();
            (0..size).for_each(|j| one[size + j] = C::new(if j == 1 { 1.0 } else { 0.0 }, 0.0));
            let slide = -(whole / determinant(&mut one, size)).re;
            if slide.abs() > 30.0 {
                continue;
            }
            let added = slide * std::f64::consts::TAU / both[0].0.period() * both[0].1[0].impulse;
            both.iter_mut().for_each(|(_, impacts)| impacts[0].acceleration_before += added);
            let [(kernel, impacts), (longer, later)] = both;
            let told = BlochEquations::new(kernel.of_uncertain_period(PART), impacts.clone());
            let moved = BlochEquations::new(longer, later);
            let at = |equations: &BlochEquations, theta: f64| Regular::of(equations, theta).values()[0];
            let (here, rounding) = (at(&told, PI), Regular::of(&told, PI).rounding(None));
            let off = (at(&moved, PI) - here).norm();
            assert!(here.norm() <= 1e-3 * rounding && off <= rounding, "{round}: {here} {off:e} {rounding:e}");
            near[0] = near[0].max(off / rounding);
            for (i, error) in slide_errors(&told).into_iter().enumerate() {
                let mut aside = impacts.clone();
                aside[i].acceleration_before += error * told.omega() * aside[i].impulse;
                let off = (at(&BlochEquations::new(told.kernel().clone(), aside), PI) - here).norm();
                assert!(off <= 1.001 * rounding, "{round} {i}: {off:e} {rounding:e}");
                near[1] = near[1].max(off / rounding);
                // Without its row the acceleration does not count.
                let without = Regular::of(&told, PI).rounding(Some(2 * i + 1));
                assert!(
                    (rounding - without - off).abs() <= 1e-3 * rounding,
                    "{round} {i}: {rounding:e} {without:e} {off:e}"
                );
            }
            let [_, slope] = Regular::of(&told, PI).values();
            let difference = (at(&told, PI + 1e-6) - at(&told, PI - 1e-6)) / 2e-6;
            assert!((slope - difference).norm() < 1e-4 * (slope.norm() + 1e-2), "{round}: {slope} {difference}");
            checked += 1;
        }
        assert!(checked > 100 && near.iter().all(|near| *near > 0.1), "{checked} {near:?}");
    }
}

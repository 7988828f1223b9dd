//! Steady motions of a structure under its loads, with bounds of their errors.

use rustfft::num_complex::Complex;

use super::error::StructureError;
use super::linear_mode::LinearMode;
use super::modal::ModalStructure;
use crate::error::RESONANCE_TOLERANCE;

type C = Complex<f64>;

impl ModalStructure {
    /// Coordinates ξ of all modes under harmonic number `place` of the loads at frequency ω, complex: Re of them times e^{ijω(t+ψ)}.
    ///
    /// # Errors
    /// [`StructureError::Resonance`] where a mode that nothing damps is met.
    pub fn steady(&self, place: usize, omega: f64) -> Result<Vec<[C; 2]>, StructureError> {
        let mut all = vec![[C::default(); 2]; self.modes().len()];
        for driven in self.driven(place, omega) {
            let (k, xi) = driven?;
            all[k] = xi;
        }
        Ok(all)
    }

    /// The motion of each contact under that harmonic, complex.
    ///
    /// # Errors
    /// As [`ModalStructure::steady`].
    pub fn steady_at(&self, place: usize, omega: f64) -> Result<Vec<C>, StructureError> {
        let mut sums = vec![C::default(); self.contacts().len()];
        for driven in self.driven(place, omega) {
            let (k, xi) = driven?;
            sums.iter_mut().zip(&self.modes()[k].rows).for_each(|(sum, row)| *sum += xi[0] * row[0] + xi[1] * row[1]);
        }
        Ok(sums)
    }

    /// The same without modes of some numbers.
    pub fn steady_but(&self, place: usize, omega: f64, left_out: impl Fn(usize) -> bool) -> Vec<C> {
        let w = f64::from(self.harmonics()[place]) * omega;
        let mut sums = vec![C::default(); self.contacts().len()];
        for (_, mode) in
            self.modes().iter().enumerate().filter(|(k, mode)| !left_out(*k) && mode.loads[place] != [C::default(); 2])
        {
            let xi = mode.steady(w, mode.loads[place]);
            sums.iter_mut().zip(&mode.rows).for_each(|(sum, row)| *sum += xi[0] * row[0] + xi[1] * row[1]);
        }
        sums
    }

    /// Numbers and coordinates of the modes that it drives.
    fn driven(&self, place: usize, omega: f64) -> impl Iterator<Item = Result<(usize, [C; 2]), StructureError>> {
        let harmonic = self.harmonics()[place];
        let w = f64::from(harmonic) * omega;
        let driven = self.modes().iter().enumerate().filter(move |(_, mode)| mode.loads[place] != [C::default(); 2]);
        driven.map(move |(k, mode)| {
            if distance(mode, w) <= RESONANCE_TOLERANCE * w {
                return Err(StructureError::Resonance { harmonic, mode: k, frequency: mode.rate, omega });
            }
            Ok((k, mode.steady(w, mode.loads[place])))
        })
    }

    /// Coordinates ξ of all modes under the static load alone; of a rigid one 0.
    pub fn still(&self) -> Vec<[f64; 2]> {
        let of_mode = |mode: &LinearMode| {
            if mode.still == [0.0; 2] || mode.is_rigid() {
                return [0.0; 2];
            }
            mode.steady(0.0, mode.still.map(|load| C::new(load, 0.0))).map(|xi| xi.re)
        };
        self.modes().iter().map(of_mode).collect()
    }

    /// Bounds of the errors of [`ModalStructure::steady_at`]: next to a resonance a mode swings as far as its frequency is known, and a
    /// load that it feels by rounding alone may drive it. Without those of driven modes closer to the load's frequency than a part of it,
    /// which [`ModalStructure::swing_error`] tells one by one.
    pub fn steady_errors_at(&self, place: usize, omega: f64, apart: f64) -> Vec<f64> {
        let modes = self.modes().iter().filter(|mode| !self.is_near(mode, place, omega, apart));
        self.errors_of(self.rate(place, omega), modes.map(|mode| (mode, mode.loads[place], mode.errors.loads[place])))
    }

    /// Whether a harmonic of the loads drives a mode closer to its frequency than a part of that.
    pub fn is_near(&self, mode: &LinearMode, place: usize, omega: f64, apart: f64) -> bool {
        let w = f64::from(self.harmonics()[place]) * omega;
        mode.loads[place] != [C::default(); 2] && distance(mode, w) < apart * w
    }

    /// A bound of the error of the swing of a mode under a harmonic of the loads, as a part of it.
    pub fn swing_error(&self, mode: &LinearMode, place: usize, omega: f64) -> f64 {
        let size = mode.loads[place][0].norm() + mode.loads[place][1].norm();
        let [even, odd] = resolvent(mode, self.rate(place, omega)[0]);
        part(mode, self.rate(place, omega), even + odd) + ROUNDING + mode.errors.loads[place] / size
    }

    /// The frequency of a harmonic of the loads, and a bound of its rounding.
    fn rate(&self, place: usize, omega: f64) -> [f64; 2] {
        let harmonic = self.harmonics()[place];
        let rate = f64::from(harmonic) * omega;
        [rate, if harmonic.is_power_of_two() { 0.0 } else { 0.5 * f64::EPSILON * rate }]
    }

    /// Bounds of the errors of what each contact sees of [`ModalStructure::still`].
    pub fn still_errors(&self) -> Vec<f64> {
        let modes = self.modes().iter().filter(|mode| !mode.is_rigid());
        let given = |mode: &LinearMode| mode.still.map(|load| C::new(load, 0.0));
        self.errors_of([0.0; 2], modes.map(|mode| (mode, given(mode), mode.errors.still)))
    }

    /// From modes with what drives them and bounds of its errors.
    fn errors_of<'a>(&self, rate: [f64; 2], driven: impl Iterator<Item = (&'a LinearMode, [C; 2], f64)>) -> Vec<f64> {
        let mut sums = vec![0.0; self.contacts().len()];
        for (mode, given, error) in driven {
            let given = given.map(C::norm);
            if given == [0.0; 2] && error == 0.0 {
                continue;
            }
            let [even, odd] = resolvent(mode, rate[0]);
            // Of either coordinate its terms, not their sum.
            let xi = [even * given[0] + odd * given[1], even * given[1] + odd * given[0]];
            let size = xi[0].hypot(xi[1]);
            let moved = (even + odd) * error + if size > 0.0 { size * part(mode, rate, even + odd) } else { 0.0 };
            for (contact, sum) in sums.iter_mut().enumerate() {
                let row = mode.rows[contact].map(f64::abs);
                let seen = row[0] * xi[0] + row[1] * xi[1];
                let length = (row[0] * row[0] + row[1] * row[1]).sqrt();
                *sum += length * moved + ROUNDING * seen + mode.errors.rows[contact] * (size + moved);
            }
        }
        sums
    }
}

/// Of what a contact sees of a mode: each of the two poles takes a difference, an inverse of seven roundings in all and half as many of a product,
/// what drives and what sees it one each.
const ROUNDING: f64 = 6.5 * f64::EPSILON;

/// The lengths of a and b of (iw − A)⁻¹ = a + bJ, which together are no less than its own.
fn resolvent(mode: &LinearMode, w: f64) -> [f64; 2] {
    let by = mode.generator().resolvent(mode.turn, C::new(0.0, w));
    [by.even.norm(), by.odd.norm()]
}

/// How far a load's frequency is from the nearer pole of a mode.
fn distance(mode: &LinearMode, w: f64) -> f64 {
    mode.rates().map(|rate| (C::new(0.0, w) - rate).norm()).into_iter().fold(f64::INFINITY, f64::min)
}

/// A bound of the error of (iw − A)⁻¹, which is no longer than `length`, by those of A and of w, as a part of it.
fn part(mode: &LinearMode, [_, rounding]: [f64; 2], length: f64) -> f64 {
    let off = (mode.errors.poles + rounding) * length;
    if off < 1.0 { off / (1.0 - off) } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::contact::Contact;
    use crate::structure::linear_mode::ModeShape;

    /// The swing of an oscillator next to its resonance moves with the frequency of the oscillator by as much as is told, whichever error
    /// there is: of poles, of the shape, of the load, of a load that is not felt but for it.
    #[test]
    fn errors_of_steady_motions_are_those_of_the_modes() {
        let stop = Contact { lower: None, upper: Some(1.0), restitution: 0.9 };
        let made = |square: f64, shape: f64, load: f64| {
            let shape = ModeShape { contacts: vec![shape], coordinates: Vec::new(), still: load };
            LinearMode::oscillator(1e-3, square - 1e-6, &shape, &[C::new(load, 0.0)])
        };
        let mut checked = 0;
        for (square, shape, load) in [(1e-10, 0.0, 0.0), (0.0, 1e-9, 0.0), (0.0, 0.0, 1e-9)] {
            for given in [1.0, 0.0] {
                if given == 0.0 && load == 0.0 {
                    continue;
                }
                let mut mode = made(1.0, 1.0, given);
                let exact = mode.errors.clone();
                mode.errors.poles += 0.51 * square;
                mode.errors.rows[0] += shape;
                // What is added is divided by the frequency.
                mode.errors.loads[0] += load + 0.51 * square * given;
                mode.errors.still += load + 0.51 * square * given;
                let told = ModalStructure::new(vec![stop], vec![1], vec![mode]).unwrap();
                let moved = made(1.0 + square, 1.0 + shape, given + load);
                let moved = ModalStructure::new(vec![stop], vec![1], vec![moved]).unwrap();
                for omega in [0.9, 0.999, 1.0001] {
                    let off = (told.steady_at(0, omega).unwrap()[0] - moved.steady_at(0, omega).unwrap()[0]).norm();
                    let error = told.steady_errors_at(0, omega, 0.0)[0];
                    assert!(off <= error && error <= 20.0 * off, "{square} {shape} {load} {omega}: {off:e} {error:e}");
                    checked += 1;
                }
                let [a, b] = [&told, &moved].map(|structure| {
                    let mode = &structure.modes()[0];
                    mode.rows[0][0] * structure.still()[0][0] + mode.rows[0][1] * structure.still()[0][1]
                });
                assert!((a - b).abs() <= told.still_errors()[0]);
                assert!(exact.poles < 1e-14);
            }
        }
        assert_eq!(checked, 12);
    }
}

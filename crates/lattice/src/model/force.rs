//! Periodic forces with F(t + T/2) = −F(t): sums of odd harmonics, and the uniform motion they drive.
//!
//! ```text
//! F(t) = Σ_j A_j cos(jωt + θ_j),     j odd                                             (paper, sec. II: any symmetric F)
//! G(t) = Σ_j A_j/(γ₁ − j²ω²) cos(jωt + θ_j),     G̈ + γ₁G = F
//! ```
//!
//! Both are a [`Wave`]. The plain cosine is one harmonic, j = 1 with phase 0.

use std::fmt;

use rustfft::num_complex::Complex;

use crate::error::{MAX_MAGNITUDE, ParameterError, check};
use crate::model::parameter::Parameter;

/// The most harmonics of a force: it is held inline, so that a model stays a plain value.
pub const MAX_HARMONICS: usize = 8;

/// The highest number of a harmonic. Beyond it a window of flight would be a thousandth of a period.
pub const MAX_HARMONIC: u32 = 999;

/// The largest phase, in radians: larger ones have lost digits already.
pub const MAX_PHASE: f64 = 100.0;

/// One harmonic of a force, A cos(jωt + θ).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Harmonic {
    /// Its number j, odd.
    #[cfg_attr(feature = "serde", serde(rename = "harmonic"))]
    pub number: u32,
    /// Its amplitude A, of either sign.
    pub amplitude: f64,
    /// Its phase θ in radians.
    #[cfg_attr(feature = "serde", serde(default))]
    pub phase: f64,
}

/// A force as a sum of odd harmonics of the frequency ω, rising in j.
///
/// ```
/// use vibrochain_lattice::{Force, Harmonic};
/// // The first three terms of a square wave.
/// let terms = [(1, 0.3), (3, -0.1), (5, 0.06)].map(|(number, amplitude)| Harmonic { number, amplitude, phase: 0.0 });
/// let force = Force::new(&terms)?;
/// assert_eq!(force.harmonics().len(), 3);
/// assert!((force.amplitude() - 0.46).abs() < 1e-15 && force.cosine_amplitude().is_none());
/// assert!(Force::new(&[Harmonic { number: 2, amplitude: 0.1, phase: 0.0 }]).is_err());
/// # Ok::<(), vibrochain_lattice::ParameterError>(())
/// ```
#[derive(Clone, Copy, PartialEq)]
pub struct Force {
    count: usize,
    harmonics: [Harmonic; MAX_HARMONICS],
}

impl fmt::Debug for Force {
    /// The harmonics there are, without the room for others.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.harmonics()).finish()
    }
}

impl Force {
    /// The plain cosine A cos ωt; A = 0 is no force.
    ///
    /// # Errors
    /// A [`ParameterError`] unless 0 ≤ A ≤ 1e100.
    pub fn cosine(amplitude: f64) -> Result<Self, ParameterError> {
        Parameter::Amplitude.check(amplitude)?;
        let mut harmonics = [Harmonic::default(); MAX_HARMONICS];
        // A minus zero would survive the range check and change signs downstream.
        harmonics[0] = Harmonic { number: 1, amplitude: amplitude + 0.0, phase: 0.0 };
        Ok(Self { count: 1, harmonics })
    }

    /// The sum of `harmonics`, in any order. Those of amplitude 0 are left out; the first harmonic alone with phase 0 and
    /// A ≥ 0 is the plain cosine.
    ///
    /// # Errors
    /// A [`ParameterError`] unless there are 1 to [`MAX_HARMONICS`] of them, each number is odd, at most
    /// [`MAX_HARMONIC`] and given once, Σ|A_j| ≤ 1e100 and |θ_j| ≤ [`MAX_PHASE`].
    pub fn new(harmonics: &[Harmonic]) -> Result<Self, ParameterError> {
        let count = harmonics.len();
        check((1..=MAX_HARMONICS).contains(&count), "number of harmonics", count as f64, "1 to 8 of them")?;
        let mut force = Self { count: 0, harmonics: [Harmonic::default(); MAX_HARMONICS] };
        let mut sum = 0.0;
        for (i, &Harmonic { number, amplitude, phase }) in harmonics.iter().enumerate() {
            let odd = number % 2 == 1 && number <= MAX_HARMONIC;
            check(odd, "harmonic", f64::from(number), "an odd number from 1 to 999: a symmetric force has no others")?;
            let first = harmonics.iter().position(|other| other.number == number) == Some(i);
            check(first, "harmonic", f64::from(number), "each harmonic of the force only once")?;
            sum += amplitude.abs();
            let finite = amplitude.is_finite() && sum <= MAX_MAGNITUDE;
            check(finite, "harmonic amplitude", amplitude, "finite numbers, together at most 1e100")?;
            check(phase.abs() <= MAX_PHASE, "harmonic phase", phase, "radians from -100 to 100")?;
            if amplitude != 0.0 {
                force.harmonics[force.count] = Harmonic { number, amplitude, phase: phase + 0.0 };
                force.count += 1;
            }
        }
        if force.count == 0 {
            return Self::cosine(0.0);
        }
        force.harmonics[..force.count].sort_by_key(|harmonic| harmonic.number);
        Ok(force)
    }

    /// The same shape with Σ|A_j| = `amplitude`; no force becomes the plain cosine.
    ///
    /// # Errors
    /// A [`ParameterError`] unless 0 ≤ A ≤ 1e100.
    pub fn scaled_to(&self, amplitude: f64) -> Result<Self, ParameterError> {
        let plain = Self::cosine(amplitude)?;
        if self.cosine_amplitude().is_some() {
            return Ok(plain);
        }
        let ratio = amplitude / self.amplitude();
        let scaled: Vec<Harmonic> =
            self.harmonics().iter().map(|term| Harmonic { amplitude: term.amplitude * ratio, ..*term }).collect();
        Self::new(&scaled)
    }

    /// The harmonics, rising in number. No force is a first harmonic of amplitude 0.
    pub fn harmonics(&self) -> &[Harmonic] {
        &self.harmonics[..self.count]
    }

    /// The amplitude A of a plain cosine; `None` for any other force.
    #[inline]
    pub fn cosine_amplitude(&self) -> Option<f64> {
        match self.harmonics() {
            [Harmonic { number: 1, amplitude, phase: 0.0 }] if *amplitude >= 0.0 => Some(*amplitude),
            _ => None,
        }
    }

    /// The greatest common divisor p of the numbers: the force's least period is T/p.
    pub fn repetitions(&self) -> u32 {
        let gcd = |mut a: u32, mut b: u32| {
            while b != 0 {
                (a, b) = (b, a % b);
            }
            a
        };
        self.harmonics().iter().fold(0, |divisor, harmonic| gcd(divisor, harmonic.number)).max(1)
    }

    /// Σ|A_j|, which |F| never exceeds: the amplitude of a plain cosine, 0 without force.
    pub fn amplitude(&self) -> f64 {
        self.harmonics().iter().map(|harmonic| harmonic.amplitude.abs()).sum()
    }
}

/// One term of a [`Wave`], c cos(rt + θ).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WaveTerm {
    /// c
    pub amplitude: f64,
    /// r = jω
    pub rate: f64,
    /// θ in radians
    pub phase: f64,
}

/// A sum of cosines, Σ c_j cos(r_j t + θ_j): a force, or the uniform motion it drives.
#[derive(Debug, Clone, Copy, Default)]
#[must_use]
pub struct Wave {
    count: usize,
    terms: [WaveTerm; MAX_HARMONICS],
}

impl PartialEq for Wave {
    /// By the terms that there are.
    fn eq(&self, other: &Self) -> bool {
        self.terms() == other.terms()
    }
}

// What the inner loops of orbits ask is marked to be inlined: there is no pass over all crates at linking.
impl Wave {
    /// The harmonics of `force` at the frequency `omega`, each amplitude divided by `stiffness(j, jω)`.
    pub(crate) fn new<E>(force: &Force, omega: f64, stiffness: impl Fn(u32, f64) -> Result<f64, E>) -> Result<Self, E> {
        let mut wave = Self { count: 0, terms: [WaveTerm::default(); MAX_HARMONICS] };
        for (term, harmonic) in wave.terms.iter_mut().zip(force.harmonics()) {
            let rate = f64::from(harmonic.number) * omega;
            let amplitude = harmonic.amplitude / stiffness(harmonic.number, rate)?;
            *term = WaveTerm { amplitude, rate, phase: harmonic.phase };
            wave.count += 1;
        }
        Ok(wave)
    }

    /// Each term's amplitude times `factor`.
    pub(crate) fn scaled(mut self, factor: impl Fn(&WaveTerm) -> f64) -> Self {
        self.terms.iter_mut().take(self.count).for_each(|term| term.amplitude *= factor(term));
        self
    }

    /// Each term turned by the angle of a complex number and times its size.
    pub(crate) fn turned(mut self, by: impl Fn(&WaveTerm) -> Complex<f64>) -> Self {
        for term in self.terms.iter_mut().take(self.count) {
            let (size, angle) = by(term).to_polar();
            (term.amplitude, term.phase) = (term.amplitude * size, term.phase + angle);
        }
        self
    }

    /// The terms, rising in rate.
    #[inline]
    pub fn terms(&self) -> &[WaveTerm] {
        &self.terms[..self.count]
    }

    /// Value at `t`.
    #[inline]
    pub fn value(&self, t: f64) -> f64 {
        let terms = self.terms().iter().filter(|term| term.amplitude != 0.0);
        terms.map(|term| term.amplitude * (term.rate * t + term.phase).cos()).sum()
    }

    /// Value and first three derivatives at `t`.
    #[inline]
    pub fn jet(&self, t: f64) -> [f64; 4] {
        let mut jet = [0.0; 4];
        // No force is a term of amplitude 0: not worth a sine.
        for &WaveTerm { amplitude: g, rate: w, phase } in self.terms().iter().filter(|term| term.amplitude != 0.0) {
            let (sin, cos) = (w * t + phase).sin_cos();
            jet[0] += g * cos;
            jet[1] += -g * w * sin;
            jet[2] += -g * w * w * cos;
            jet[3] += g * w * w * w * sin;
        }
        jet
    }

    /// As [`Wave::jet`], but sums of the terms' moduli: what rounding errors go with.
    pub fn moduli(&self, t: f64) -> [f64; 4] {
        let mut moduli = [0.0; 4];
        for term in self.terms() {
            let (sin, cos) = (term.rate * t + term.phase).sin_cos();
            let mut size = term.amplitude.abs();
            for (modulus, part) in moduli.iter_mut().zip([cos, sin, cos, sin]) {
                *modulus += size * part.abs();
                size *= term.rate;
            }
        }
        moduli
    }

    /// Σ|c_j| r_j^`order`, a bound of that derivative at all times.
    #[inline]
    pub fn bound(&self, order: i32) -> f64 {
        self.terms().iter().map(|term| term.amplitude.abs() * term.rate.powi(order)).sum()
    }

    /// The amplitude of a single cosine of phase 0, with its sign; otherwise Σ|c_j|.
    #[inline]
    pub fn reach(&self) -> f64 {
        match self.terms() {
            [WaveTerm { amplitude, phase: 0.0, .. }] => *amplitude,
            _ => self.bound(0),
        }
    }

    /// The highest rate of a term that is not 0; 0 if there is none.
    #[inline]
    pub fn top_rate(&self) -> f64 {
        self.terms().iter().filter(|term| term.amplitude != 0.0).map(|term| term.rate).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::chain::Chain;

    fn harmonic(number: u32, amplitude: f64, phase: f64) -> Harmonic {
        Harmonic { number, amplitude, phase }
    }

    #[test]
    fn lists_are_checked() {
        let nine: Vec<_> = (0..9).map(|i| harmonic(2 * i + 1, 0.1, 0.0)).collect();
        assert!(Force::new(&nine[..8]).is_ok());
        for (bad, name) in [
            (&[][..], "number of harmonics"),
            (&nine, "number of harmonics"),
            (&[harmonic(0, 0.1, 0.0)], "harmonic"),
            (&[harmonic(1, 0.1, 0.0), harmonic(4, 0.1, 0.0)], "harmonic"),
            (&[harmonic(1001, 0.1, 0.0)], "harmonic"),
            (&[harmonic(3, 0.1, 0.0), harmonic(3, 0.0, 1.0)], "harmonic"),
            (&[harmonic(3, f64::NAN, 0.0)], "harmonic amplitude"),
            (&[harmonic(1, 9e99, 0.0), harmonic(3, 9e99, 0.0)], "harmonic amplitude"),
            (&[harmonic(3, 0.1, f64::INFINITY)], "harmonic phase"),
            (&[harmonic(3, 0.1, f64::NAN)], "harmonic phase"),
        ] {
            assert_eq!(Force::new(bad).unwrap_err().name, name, "{bad:?}");
        }
    }

    #[test]
    fn one_plain_harmonic_is_the_cosine() {
        let cosine = Force::cosine(0.3).unwrap();
        assert_eq!(Force::new(&[harmonic(1, 0.3, 0.0)]).unwrap(), cosine);
        assert_eq!(Force::new(&[harmonic(5, 0.0, 1.0), harmonic(1, 0.3, -0.0)]).unwrap(), cosine);
        assert_eq!(Force::new(&[harmonic(5, 0.0, 1.0)]).unwrap(), Force::cosine(0.0).unwrap());
        for other in [harmonic(1, 0.3, 0.1), harmonic(1, -0.3, 0.0), harmonic(3, 0.3, 0.0)] {
            assert_eq!(Force::new(&[other]).unwrap().cosine_amplitude(), None);
        }
    }

    #[test]
    fn a_force_without_the_first_harmonic_may_repeat_within_the_period() {
        let of = |numbers: &[u32]| {
            let harmonics: Vec<_> = numbers.iter().map(|&number| harmonic(number, 0.1, 0.0)).collect();
            Force::new(&harmonics).unwrap().repetitions()
        };
        assert_eq!([of(&[1]), of(&[3]), of(&[9, 15]), of(&[3, 5]), of(&[1, 9])], [1, 3, 3, 1, 1]);
    }

    #[test]
    fn the_uniform_motion_obeys_its_equation_and_the_symmetry() {
        let force = Force::new(&[harmonic(5, 0.2, 2.5), harmonic(1, 0.7, 0.4), harmonic(3, -0.3, -1.0)]).unwrap();
        let ring = Chain::new(5, 0.2, 0.1).unwrap().point();
        let model = ring.omega(1.5).asymmetry(0.4).under(&force).restitution(0.9).model().unwrap();
        let (push, response) = (model.force_wave(), model.steady_response().unwrap());
        for i in 0..20 {
            let t = 0.37 * f64::from(i);
            let jet = response.jet(t);
            let plain: f64 = [(1.0, 0.7, 0.4), (3.0, -0.3, -1.0), (5.0, 0.2, 2.5)]
                .iter()
                .map(|(j, a, phase): &(f64, f64, f64)| a * (j * 1.5 * t + phase).cos())
                .sum();
            assert!((push.value(t) - plain).abs() < 1e-14);
            assert!((jet[2] + 0.2 * jet[0] - push.value(t)).abs() < 1e-14);
            assert!((push.value(t + 0.5 * model.period()) + push.value(t)).abs() < 1e-13);
            let h = 1e-5;
            for k in 0..3 {
                let slope = (response.jet(t + h)[k] - response.jet(t - h)[k]) / (2.0 * h);
                assert!((slope - jet[k + 1]).abs() < 1e-7 * response.bound(k as i32 + 3), "{k}");
            }
            let moduli = response.moduli(t);
            assert!((0..4).all(|k| jet[k].abs() <= moduli[k] && moduli[k] <= response.bound(k as i32)));
            assert!(jet[0].abs() <= model.force_response().unwrap());
        }
        assert_eq!(response.top_rate(), 7.5);
    }

    #[test]
    fn any_harmonic_on_the_uniform_mode_is_a_resonance() {
        let force = Force::new(&[harmonic(1, 0.7, 0.4), harmonic(3, 1e-9, 0.0)]).unwrap();
        let model =
            Chain::new(5, 2.25, 0.1).unwrap().point().omega(0.5).under(&force).restitution(0.5).model().unwrap();
        let error = model.steady_response().unwrap_err();
        assert_eq!((error.harmonic, error.mode), (3, 0));
        assert!(error.to_string().contains("harmonic 3 of omega = 0.5 meets mode 0"), "{error}");
    }
}

//! One damped oscillator with one stop, x″ + cx′ + x = A cos ω(t+ψ), x ≤ d: its orbits of one impact, their period doublings and the grazing curve,
//! in closed form in many digits, against the engine of structures.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::sync::Arc;

use vibrochain_breather::{LoadedStructure, ModelFamily, Orbit};
use vibrochain_floquet::{BranchRequest, Event, Tolerance, branches, stability};
use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape, Stop};
use vibrochain_testkit::Random;
use vibrochain_truth::Real;

const BITS: usize = 256;

/// e^x by its series of a part of x.
fn exp(x: &Real) -> Real {
    let part = x.times_power_of_two(-12);
    let (mut sum, mut term) = (Real::one(BITS), Real::one(BITS));
    for n in 1..60 {
        term = &term * &part / f64::from(n);
        sum = &sum + &term;
    }
    (0..12).fold(sum, |sum, _| &sum * &sum)
}

/// What is given, as numbers that both sides have to all digits.
#[derive(Debug, Clone, Copy)]
struct Given {
    damping: f64,
    restitution: f64,
    omega: f64,
    stop: f64,
}

impl Given {
    fn model(self, load: f64) -> Result<LoadedStructure, String> {
        let decay = 0.5 * self.damping;
        let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: 0.0 };
        let mode = LinearMode::oscillator(decay, 1.0 - decay * decay, &shape, &[Complex::new(load, 0.0)]);
        let stop = Contact { lower: None, upper: Some(self.stop), restitution: self.restitution };
        let structure = ModalStructure::new(vec![stop], vec![1], vec![mode]).map_err(|error| error.to_string())?;
        LoadedStructure::new(Arc::new(structure), self.omega).map_err(|error| error.to_string())
    }

    fn family(self) -> ModelFamily {
        Arc::new(move |values: &[f64]| self.model(values[0]))
    }
}

/// The free oscillator over one period of the force, in many digits.
struct Truth {
    given: Given,
    omega: Real,
    /// e^{Bt} at the period, of (x, x′).
    flight: [[Real; 2]; 2],
    /// Re and Im of 1 − ω² + iωc.
    stiffness: [Real; 2],
    /// K and K′ just before the impact: of all earlier ones.
    kernel: [Real; 2],
}

/// An orbit of one impact: impulse, cos and sin of ωψ, and its multipliers' sum.
struct TrueOrbit {
    impulse: Real,
    phase: [Real; 2],
    trace: Real,
}

impl Truth {
    fn new(given: Given) -> Self {
        let real = |x: f64| Real::new(x, BITS);
        let (omega, damping) = (real(given.omega), real(given.damping));
        let period = Real::pi(BITS) * 2.0 / &omega;
        let decay = &damping / 2.0;
        let frequency = (Real::one(BITS) - &decay * &decay).sqrt();
        let left = exp(&-(&decay * &period));
        let (sin, cos) = (&frequency * &period).sin_cos();
        let (along, across) = (&left * &cos, &left * &sin / &frequency);
        let flight = [[&along + &decay * &across, across.clone()], [-across.clone(), &along - &decay * &across]];
        // A unit impulse is (0, 1); (1 − e^{BT})⁻¹e^{BT} of it is what all earlier ones have left.
        let one = Real::one(BITS);
        let (p, q) = (&one - &flight[0][0], &one - &flight[1][1]);
        let determinant = &p * &q - &flight[0][1] * &flight[1][0];
        let (x, v) = (&flight[0][1], &flight[1][1]);
        let kernel = [(&q * x + &flight[0][1] * v) / &determinant, (&flight[1][0] * x + &p * v) / &determinant];
        let stiffness = [&one - &omega * &omega, &omega * &damping];
        Self { given, omega, flight, stiffness, kernel }
    }

    /// Both orbits under the load A; none below the least load.
    fn orbits(&self, load: &Real) -> Vec<TrueOrbit> {
        let loss = Real::new(self.given.restitution, BITS) + 1.0;
        let [re, im] = &self.stiffness;
        let size = (re * re + im * im).sqrt();
        let swing = load / &size;
        // With x = ωψ + θ: P = b sin x and |g|cos x + K P = d.
        let [place, slope] = &self.kernel;
        let ratio = &self.omega * &swing * &loss / (&loss * slope + 1.0);
        let (a, stop) = (place * &ratio / &swing, Real::new(self.given.stop, BITS) / &swing);
        let square = &a * &a + 1.0;
        let under = &square - &stop * &stop;
        if under.is_negative() {
            return Vec::new();
        }
        let of = |sign: f64| {
            let root = under.sqrt() * sign;
            let (cos, sin) = ((&stop - &a * &root) / &square, (&a * &stop + &root) / &square);
            let impulse = &ratio * &sin;
            // g = A/(1 − ω² + iωc) has the phase θ of its conjugate denominator.
            let phase = [(&cos * re - &sin * im) / &size, (&sin * re + &cos * im) / &size];
            let trace = self.trace(load, &impulse, &phase[0]);
            TrueOrbit { impulse, phase, trace }
        };
        vec![of(1.0), of(-1.0)]
    }

    /// The trace of the monodromy matrix e^{BT}S. The saltation matrix S has −e on the diagonal and (a⁺ + e a⁻)/v⁻ below it.
    fn trace(&self, load: &Real, impulse: &Real, cos: &Real) -> Real {
        let (e, damping) = (Real::new(self.given.restitution, BITS), Real::new(self.given.damping, BITS));
        let before = -impulse.clone() / (&e + 1.0);
        let pull = load * cos - Real::new(self.given.stop, BITS);
        let after = -(&e * &before);
        let slide = (&pull - &damping * &after + &e * (&pull - &damping * &before)) / &before;
        slide * &self.flight[0][1] - &e * (&self.flight[0][0] + &self.flight[1][1])
    }

    /// The product of both multipliers.
    fn determinant(&self) -> Real {
        let flight = &self.flight[0][0] * &self.flight[1][1] - &self.flight[0][1] * &self.flight[1][0];
        flight * self.given.restitution * self.given.restitution
    }
}

fn own(given: Given, load: f64) -> Vec<Orbit> {
    given.model(load).unwrap().orbits(&"0+".parse().unwrap(), 1).unwrap().orbits
}

fn given(random: &mut Random) -> Given {
    Given {
        damping: random.log(1e-3, 0.5),
        restitution: random.between(0.3, 1.0),
        omega: random.between(0.6, 3.5),
        stop: random.between(0.05, 1.0),
    }
}

#[test]
fn one_impact_to_the_last_digits() {
    let mut random = Random(37);
    let (mut orbits, mut multipliers) = (0, 0);
    for _ in 0..200 {
        let (given, load) = (given(&mut random), random.log(0.2, 5.0));
        let truth = Truth::new(given);
        let all = truth.orbits(&Real::new(load, BITS));
        for orbit in own(given, load) {
            let (impact, error) = (&orbit.impacts()[0], &orbit.contacts().unwrap().impact_errors()[0]);
            let nearest = all.iter().map(|one| (&one.impulse - impact.impulse).abs().to_f64());
            let (at, off) = nearest.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            let size = impact.impulse.abs();
            // What is claimed, and little more.
            assert!(off <= 4.0 * error.impulse + 4.0 * f64::EPSILON * size, "{off:e} {impact:?} {given:?}");
            let (sin, cos) = (Real::new(orbit.psi().unwrap(), BITS) * given.omega).sin_cos();
            let [true_cos, true_sin] = &all[at].phase;
            let turned = ((&sin - true_sin).abs() + (&cos - true_cos).abs()).to_f64();
            assert!(turned < 1e-9 * (1.0 + error.impulse / off.max(f64::MIN_POSITIVE)), "{turned:e} {given:?}");
            orbits += 1;
            let Ok(stability) = stability(&orbit, Tolerance::Rounding) else { continue };
            let sum: Complex<f64> = stability.multipliers.iter().sum();
            let product: Complex<f64> = stability.multipliers.iter().product();
            // At a graze multipliers are without bound, and lose digits in proportion.
            let room = 1e-10 * (1.0 + sum.norm()).powi(2);
            assert!((&all[at].trace - sum.re).abs().to_f64() < room, "{} {sum} {given:?}", all[at].trace);
            assert!((truth.determinant() - product.re).abs().to_f64() < room, "{product} {given:?}");
            multipliers += 1;
        }
    }
    assert!(orbits > 200 && multipliers > 200, "{orbits} {multipliers}");
}

/// Along the load: where the impact loses its velocity A = d√((1−ω²)² + c²ω²), and where it doubles its period tr M + 1 + det M = 0.
#[test]
fn grazings_and_doublings_to_the_last_digits() {
    let mut random = Random(41);
    let (mut grazings, mut doublings) = (0, 0);
    for _ in 0..60 {
        let given = given(&mut random);
        let truth = Truth::new(given);
        let [re, im] = &truth.stiffness;
        let graze = (re * re + im * im).sqrt() * given.stop;
        let load = graze.to_f64() * random.between(1.2, 2.5);
        let Some(orbit) = own(given, load).into_iter().find(|orbit| orbit.impacts()[0].impulse < 0.0) else { continue };
        let course = BranchRequest {
            from: 0.3 * graze.to_f64(),
            to: 2.0 * load,
            events: Event::ALL.to_vec(),
            generations: 0,
            tolerance: Tolerance::Rounding,
        };
        let found = branches(&orbit, &given.family(), load, &course, &Stop::default()).unwrap();
        for event in found.branches[0].events() {
            let room = |error: f64| 8.0 * error + 1e-13 * event.value;
            if event.event == Event::Grazing && event.orbit.impacts()[0].impulse.abs() < 1e-9 {
                let off = (&graze - event.value).abs().to_f64();
                assert!(off <= room(event.error), "{off:e} ± {:e} {given:?}", event.error);
                grazings += 1;
            }
            if event.event == Event::PeriodDoubling {
                let impulse = event.orbit.impacts()[0].impulse;
                let condition = |load: &Real| {
                    let near = |one: &TrueOrbit| (&one.impulse - impulse).abs().to_f64();
                    let all = truth.orbits(load);
                    let nearest = all.into_iter().min_by(|a, b| near(a).total_cmp(&near(b))).unwrap();
                    nearest.trace + 1.0 + truth.determinant()
                };
                // The secant's method from beside it.
                let (mut last, mut next) = (Real::new(event.value * (1.0 + 1e-9), BITS), Real::new(event.value, BITS));
                for _ in 0..8 {
                    let (before, here) = (condition(&last), condition(&next));
                    if (&here - &before).is_zero() {
                        break;
                    }
                    let step = &here * (&next - &last) / (&here - &before);
                    (last, next) = (next.clone(), &next - &step);
                }
                let off = (&next - event.value).abs().to_f64();
                assert!(off <= room(event.error), "{off:e} ± {:e} {given:?}", event.error);
                doublings += 1;
            }
        }
    }
    assert!(grazings > 20 && doublings > 10, "{grazings} {doublings}");
}

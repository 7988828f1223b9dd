//! The equations of an orbit of a mass without coupling, from one impact to the next: a problem of two dimensions.
//!
//! With Ω = √γ₁, flight i from impact i to impact j = i+1 of duration τ, b its barrier, v⁺ = eP/(1+e) and v⁻ = −P/(1+e),
//!
//! ```text
//! position   b_i cos Ωτ + v⁺_i sin Ωτ/Ω + f(τ) − b_j  = 0        velocity   −Ωb_i sin Ωτ + v⁺_i cos Ωτ + ḟ(τ) − v⁻_j = 0
//! ```
//!
//! f is what the force adds to a mass that starts at rest at 0. Unlike the kernels nothing here knows of a resonance: the periodic
//! answer to an impulse is large there, and so is the steady answer to the force, but a flight is not. The orbit's errors
//! follow from what is left of these equations, rounding allowed for.

use crate::equations::linear::{Matrix, Vector, zeros};
use crate::equations::{System, UNIT};
use crate::orbit::Orbit;
use vibrochain_lattice::{WaveTerm, sine_over};

/// Of |Ω−ω|/(Ω+ω) below which Ω² − ω² is taken out of the force's answer.
const NEAR: f64 = 0.1;

/// What the equations say of an orbit: what may be left of each, and how the unknowns follow from it. The unknowns stand as the
/// impulses, the times but the first, the phase.
pub(crate) struct Flights {
    impacts: usize,
    pub(crate) system: System,
    pub(crate) left: Vector,
}

impl Flights {
    /// `None` for an orbit that is not of this kind: with coupling, at several sites, or without force.
    pub(crate) fn of(orbit: &Orbit) -> Option<Self> {
        let (model, n) = (orbit.model(), orbit.impacts().len());
        if orbit.centre().is_none() || model.is_conservative() || !model.chain().is_uncoupled() {
            return None;
        }
        let (mut matrix, mut left) = (Matrix::zeros(2 * n), zeros(2 * n));
        let e = model.restitution();
        for i in 0..n {
            let j = (i + 1) % n;
            let flight = Flight::new(orbit, i, j);
            for (row, of) in [(2 * i, 0), (2 * i + 1, 1)] {
                matrix[(row, i)] += flight.by_velocity[of] * e / (1.0 + e);
                matrix[(row, 2 * n - 1)] += flight.by_start[of] + flight.by_end[of];
                left[row] = flight.left[of].abs() + flight.rounding[of];
                for (impact, change) in [(i, flight.by_start[of]), (j, flight.by_end[of])] {
                    if impact > 0 {
                        matrix[(row, n + impact - 1)] += change;
                    }
                }
            }
            matrix[(2 * i + 1, j)] += 1.0 / (1.0 + e);
        }
        let mut units = zeros(2 * n);
        units[..n].fill(orbit.impacts().iter().map(|impact| impact.impulse.abs()).fold(f64::MIN_POSITIVE, f64::max));
        units[n..].fill(orbit.period());
        units[2 * n - 1] = model.period();
        Some(Self { impacts: n, system: System::new(matrix, units), left })
    }

    /// Place of the time of impact `i`.
    pub(crate) fn time(&self, i: usize) -> Option<usize> {
        (i > 0).then_some(self.impacts + i - 1)
    }

    /// Place of the phase.
    pub(crate) fn psi(&self) -> usize {
        2 * self.impacts - 1
    }
}

/// One flight: its equations, position first, and their derivatives.
struct Flight {
    left: [f64; 2],
    rounding: [f64; 2],
    /// By v⁺, by the time of the start and by that of the end; a change of the force's phase is one of both times.
    by_velocity: [f64; 2],
    by_start: [f64; 2],
    by_end: [f64; 2],
}

impl Flight {
    fn new(orbit: &Orbit, i: usize, j: usize) -> Self {
        let model = orbit.model();
        let (from, to) = (&orbit.impacts()[i], &orbit.impacts()[j]);
        let duration = to.time - from.time;
        let duration = if j > i { duration } else { duration + orbit.period() };
        let rate = model.chain().gamma1().sqrt();
        let (sin, cos) = (rate * duration).sin_cos();
        let slow = sine_over(rate, duration);
        let (start, end) = (model.barrier(from.barrier), model.barrier(to.barrier));
        let (out, arrival) = (from.velocity_after, to.velocity_before);
        let force = model.force_wave();
        let psi = orbit.psi_or_zero();
        let mut driven = [0.0; 2];
        // Terms by size, and what a relative error of the times and rates does to them.
        let mut sizes = [(start * cos).abs() + (out * slow).abs() + end.abs(), 0.0];
        sizes[1] = (rate * start * sin).abs() + (out * cos).abs() + arrival.abs();
        let turn = rate * duration;
        let mut swing = [
            turn * ((start * sin).abs() + (out * cos / rate.max(1.0 / duration)).abs()),
            turn * ((rate * start * cos).abs() + (out * sin).abs()),
        ];
        for term in force.terms() {
            let phase = term.rate * (from.time + psi) + term.phase;
            let (sin, cos) = phase.sin_cos();
            let [even, even_slope, odd, odd_slope] = answers(rate, term, duration);
            driven[0] += term.amplitude * (cos * even - sin * odd);
            driven[1] += term.amplitude * (cos * even_slope - sin * odd_slope);
            let size = term.amplitude.abs();
            let (value, slope) = (even.abs() + odd.abs(), even_slope.abs() + odd_slope.abs());
            let turns = 1.0 + (term.rate * (from.time.abs() + psi.abs())) + term.phase.abs();
            sizes[0] += size * value * turns;
            sizes[1] += size * slope * turns;
            // A force moves a mass at rest by no more than this.
            let most = (term.rate + rate) * duration;
            swing[0] += size * most * duration * duration.min(1.0 / rate);
            swing[1] += size * most * duration;
        }
        let position = start * cos + out * slow + driven[0];
        let velocity = -rate * start * sin + out * cos + driven[1];
        let stiffness = model.chain().gamma1();
        let pull = |place: f64, time: f64| force.value(time + psi) - stiffness * place;
        let (pushed, stopped) = (pull(start, from.time), pull(end, to.time));
        Self {
            left: [position - end, velocity - arrival],
            rounding: [0, 1].map(|of| UNIT * (sizes[of] + swing[of])),
            by_velocity: [slow, cos],
            by_start: [-(cos * out + slow * pushed), -(cos * pushed - rate * sin * out)],
            by_end: [velocity, stopped],
        }
    }
}

/// What a mass at rest at 0 makes of cos ωt and of sin ωt in the time `t`: displacement and velocity of each. With s = Ω+ω and
/// d = Ω−ω, (cos ωt − cos Ωt)/(Ω²−ω²) = 2 sin(st/2) sin(dt/2)/(sd) and so on: smooth at d = 0.
fn answers(rate: f64, term: &WaveTerm, t: f64) -> [f64; 4] {
    let omega = term.rate;
    let (sum, difference) = (rate + omega, rate - omega);
    if difference.abs() > NEAR * sum {
        let stiffness = sum * difference;
        let ((sin, cos), (slow_sin, slow_cos)) = ((omega * t).sin_cos(), (rate * t).sin_cos());
        return [
            (cos - slow_cos) / stiffness,
            (rate * slow_sin - omega * sin) / stiffness,
            (sin - omega * sine_over(rate, t)) / stiffness,
            omega * (cos - slow_cos) / stiffness,
        ];
    }
    let (fast_sin, fast_cos) = (0.5 * sum * t).sin_cos();
    let beat = sine_over(0.5 * difference, t) * 0.5;
    let (fast, slow) = (fast_sin / sum * (0.5 * difference * t).cos(), fast_cos * beat);
    let even = 2.0 * fast_sin * beat / sum;
    [even, slow + fast, (fast - slow) / rate, omega * even]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::orbit::{Family, Hit};
    use crate::search::finder::{Finder, OrbitList};
    use vibrochain_lattice::{Chain, Force, Harmonic};

    #[test]
    fn answers_solve_the_equation_of_motion_next_to_a_resonance_and_away_from_it() {
        for (rate, omega) in [(1.0_f64, 0.3_f64), (0.7, 2.0), (1.0, 1.0 + 1e-9), (1.0, 0.999), (0.0, 0.5)] {
            let term = WaveTerm { amplitude: 1.0, rate: omega, phase: 0.0 };
            for t in [0.3, 2.0, 9.0] {
                // ∫ sin Ω(t−s)/Ω cos ωs ds and the like, by the trapezoidal rule with its first correction.
                let steps = 20_000;
                let h = t / f64::from(steps);
                let mut by_hand = [0.0; 4];
                for i in 0..=steps {
                    let s = h * f64::from(i);
                    let weight = if i == 0 || i == steps { 0.5 * h } else { h };
                    let (sin, cos) = (omega * s).sin_cos();
                    let (kernel, slope) = (sine_over(rate, t - s), (rate * (t - s)).cos());
                    for (sum, part) in by_hand.iter_mut().zip([kernel * cos, slope * cos, kernel * sin, slope * sin]) {
                        *sum += weight * part;
                    }
                }
                for (found, expected) in answers(rate, &term, t).into_iter().zip(by_hand) {
                    assert!((found - expected).abs() < 2e-6, "{rate} {omega} {t}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn orbits_fulfil_the_equations_and_their_derivatives_are_difference_quotients() {
        let mut random = fastrand::Rng::with_seed(3);
        let (mut finder, mut found, mut checked) = (Finder::new(1), OrbitList::default(), [0; 3]);
        for _ in 0..200 {
            let chain = Chain::new(1 + random.usize(0..4), 0.1 + random.f64(), 0.0).unwrap();
            let harmonics = [(1, 0.5), (3, 0.1 * random.f64())].map(|(number, amplitude)| Harmonic {
                number,
                amplitude,
                phase: if number == 1 { 0.0 } else { 1.0 },
            });
            let force = Force::new(&harmonics).unwrap();
            let (omega, a) = (0.3 + 2.0 * random.f64(), 0.8 * random.f64());
            let point = chain.point().omega(omega).asymmetry(a);
            let model = point.under(&force).restitution(0.2 + 0.7 * random.f64()).model().unwrap();
            for (number, family) in
                [Family::DoubleSided, Family::SingleSided, Family::PeriodDoubled].into_iter().enumerate()
            {
                if finder.find(&model, family, &mut found).is_err() {
                    continue;
                }
                for orbit in found.orbits.iter().take(2) {
                    let n = orbit.impacts().len();
                    let flights = Flights::of(orbit).unwrap();
                    let scale = 1.0 + orbit.velocity_scale() + orbit.length_scale();
                    assert!(flights.left.iter().all(|left| *left < 1e-9 * scale), "{:?} {model:?}", flights.left);
                    // Each unknown moved a little, in an orbit written by hand.
                    let hits = |step: f64, place: usize| {
                        let mut hits: Vec<_> = orbit.impacts().iter().map(Hit::from).collect();
                        let mut psi = orbit.psi_or_zero();
                        match place {
                            place if place < n => hits[place].impulse += step,
                            place if place == 2 * n - 1 => psi += step,
                            _ => hits[1].time += step,
                        }
                        let moved = Orbit::from_impulses(&model, orbit.force_periods(), psi, &hits).unwrap();
                        (0..n).flat_map(|i| Flight::new(&moved, i, (i + 1) % n).left).collect::<Vec<_>>()
                    };
                    let h = 1e-6;
                    for place in 0..2 * n {
                        let (plus, minus) = (hits(h, place), hits(-h, place));
                        for row in 0..2 * n {
                            let slope = (plus[row] - minus[row]) / (2.0 * h);
                            let known = flights.system.matrix[(row, place)];
                            assert!(
                                (slope - known).abs() < 1e-6 * scale * (1.0 + known.abs()),
                                "{row} {place}: {slope} {known}"
                            );
                        }
                    }
                    checked[number] += 1;
                }
            }
        }
        assert!(checked.iter().all(|count| *count > 20), "{checked:?}");
    }
}

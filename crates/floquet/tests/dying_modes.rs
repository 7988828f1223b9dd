//! Modes that die within a period, up to at once, between impacts of any spacing: multipliers from J(z) against a dense matrix of flights and
//! saltations, whose flights all go forward in time.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use nalgebra::{DMatrix, DVector};
use vibrochain_breather::{BlochEquations, LinearImpact};
use vibrochain_floquet::{Complex, ImpactSpectrum};
use vibrochain_lattice::BlochKernel;
use vibrochain_testkit::Random;

/// One oscillator: δ, δ² + ν², and its shape at the contacts.
struct Mode {
    decay: f64,
    stiffness: f64,
    shapes: Vec<f64>,
}

/// e^{At} of place and velocity, by its two poles.
fn flight(mode: &Mode, t: f64) -> [[f64; 2]; 2] {
    let root = Complex::new(mode.decay * mode.decay - mode.stiffness, 0.0).sqrt();
    let slow = if root.re > 0.0 { -mode.stiffness / (root + mode.decay) } else { root - mode.decay };
    let fast = -root - mode.decay;
    let (a, b) = ((slow * t).exp(), (fast * t).exp());
    let far = slow - fast;
    let entries =
        [[(a * -fast + b * slow) / far, (a - b) / far], [slow * fast * (b - a) / far, (a * slow - b * fast) / far]];
    entries.map(|row| row.map(|entry| entry.re))
}

/// The matrix of a period that begins at t = 0, just before the first impact.
fn monodromy(modes: &[Mode], impacts: &[LinearImpact], period: f64) -> DMatrix<f64> {
    let n = modes.len();
    let mut matrix = DMatrix::identity(2 * n, 2 * n);
    for (i, impact) in impacts.iter().enumerate() {
        let shape = DVector::from_iterator(n, modes.iter().map(|mode| mode.shapes[impact.contact]));
        let mobility = shape.norm_squared();
        let velocity = -impact.impulse * mobility / (1.0 + impact.restitution);
        let jump = (1.0 + impact.restitution) / mobility;
        // x⁺ = Dx⁻ with D of velocities alone; the instant moves by −δg/g′⁻.
        let mut saltation = DMatrix::identity(2 * n, 2 * n);
        for k in 0..n {
            for l in 0..n {
                saltation[(n + k, n + l)] -= jump * shape[k] * shape[l];
                saltation[(k, l)] += shape[k] * impact.impulse * shape[l] / velocity;
                let risen =
                    -2.0 * modes[k].decay * shape[k] * impact.impulse + jump * shape[k] * impact.acceleration_before;
                saltation[(n + k, l)] += risen * shape[l] / velocity;
            }
        }
        let until = if i + 1 < impacts.len() { impacts[i + 1].time } else { period } - impact.time;
        let mut flown = DMatrix::zeros(2 * n, 2 * n);
        for (k, mode) in modes.iter().enumerate() {
            let [[a, b], [c, d]] = flight(mode, until);
            (flown[(k, k)], flown[(k, n + k)], flown[(n + k, k)], flown[(n + k, n + k)]) = (a, b, c, d);
        }
        matrix = flown * saltation * matrix;
    }
    matrix
}

#[test]
fn modes_that_die_between_impacts_leave_the_others_their_digits() {
    let mut random = Random(29);
    let (mut certified, mut rapid, mut worst) = (0, 0, 0.0f64);
    const ROUNDS: usize = 600;
    for round in 0..ROUNDS {
        let (count, contacts, period) = (2 + random.below(4), 1 + random.below(2), random.between(1.0, 8.0));
        let modes: Vec<Mode> = (0..count)
            .map(|k| {
                // Two that go on, others that die the sooner the more there are; some swing, some are overdamped.
                let frequency = if k < 2 { random.between(0.5, 3.0) } else { random.log(3.0, 1e3) };
                let ratio = if k < 2 { random.log(1e-3, 0.1) } else { random.log(0.2, 30.0) };
                let shapes = (0..contacts).map(|_| random.between(-1.0, 1.0)).collect();
                Mode { decay: ratio * frequency, stiffness: frequency * frequency, shapes }
            })
            .collect();
        let times = 1 + random.below(5);
        let crowded = round % 3 == 0;
        let impacts: Vec<LinearImpact> = (0..times)
            .map(|i| LinearImpact {
                contact: random.below(contacts),
                time: if i == 0 { 0.0 } else { period * (i as f64 + random.between(0.0, 0.5)) / times as f64 }
                    * if crowded { 0.01 } else { 1.0 },
                impulse: random.between(0.2, 2.0),
                restitution: random.between(0.3, 1.0),
                acceleration_before: random.between(-1.0, 1.0),
            })
            .collect();
        let mut kernel = BlochKernel::new(period, contacts);
        modes.iter().for_each(|mode| {
            kernel.push_decaying(mode.decay, mode.stiffness - mode.decay * mode.decay, &mode.shapes);
        });
        let spectrum = ImpactSpectrum::new(&BlochEquations::new(kernel, impacts.clone()));
        assert_eq!(spectrum.multipliers.len(), 2 * count);
        let matrix = monodromy(&modes, &impacts, period);
        let norm = matrix.norm();
        let dies = |mode: &Mode| mode.decay * period > 75.0;
        rapid += usize::from(modes.iter().any(dies) && times > 1);
        if !spectrum.is_certified {
            continue;
        }
        certified += 1;
        let mut open: Vec<Complex<f64>> = matrix.complex_eigenvalues().iter().copied().collect();
        for (z, error) in spectrum.multipliers.iter().zip(&spectrum.errors) {
            let distance = |w: &Complex<f64>| (w - z).norm();
            let nearest = (0..open.len()).min_by(|&i, &j| distance(&open[i]).total_cmp(&distance(&open[j]))).unwrap();
            let off = distance(&open.swap_remove(nearest));
            assert!(off < error + 1e-10 * norm, "{round}: {z} {off:e} {error:e} {norm:e}");
            worst = worst.max(off / norm);
        }
    }
    println!("{certified} of {ROUNDS}, {rapid} rapid, worst {worst:e}");
    assert!(certified * 200 > ROUNDS * 199 && rapid * 2 > ROUNDS, "{certified} {rapid}");
}

//! Complex pairs of roots.

use nalgebra::Complex;
use vibrochain_lattice::simd::lanes::Lane;

use crate::map_paths::fast_sums::evaluate::Local;
use crate::map_paths::reversible::residues::Residues;
use crate::zeros::modulus;

/// A gap whose least |F| is not zero: complex roots may be near.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Suspect {
    pub(crate) gap: usize,
    pub(crate) t: f64,
    pub(crate) height: f64,
    pub(crate) closeness: f64,
}

/// A complex root, by its offset from the pole at `place`, and its error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair {
    pub(crate) place: usize,
    pub(crate) t: Complex<f64>,
    pub(crate) error: f64,
}

/// Seeks up to `wanted` complex pairs from the lowest points, the most suspicious one first.
pub(crate) fn from_suspects(
    form: &Residues,
    suspects: &mut [Suspect],
    wanted: usize,
    scratch: &mut Vec<Lane>,
    pairs: &mut Vec<Pair>,
) {
    pairs.clear();
    suspects.sort_unstable_by(|a, b| a.closeness.total_cmp(&b.closeness));
    let one = Complex::new(1.0, 0.0);
    for suspect in suspects {
        if pairs.len() >= wanted {
            break;
        }
        let place = suspect.gap;
        let width = form.distance(place + 1, place);
        let start = Complex::new(suspect.t, suspect.height);
        // The neighbouring poles and the pairs already found next to them are divided out.
        let from = |pair: &Pair, t: Complex<f64>| t + form.distance(place, pair.place) - pair.t;
        let weight = |t: Complex<f64>| {
            let ends = one / t + one / (t - width);
            pairs.iter().fold(ends, |sum, pair| {
                let upper = from(pair, t);
                let lower = upper + Complex::new(0.0, 2.0 * pair.t.im);
                sum - one / upper - one / lower
            })
        };
        form.distances(place, scratch);
        let local = form.about(scratch);
        let found = newton(local, start, weight);
        let Some((t, slope)) = found else { continue };
        if pairs.iter().any(|pair| modulus(from(pair, t)) < 1e-6 * t.im) {
            continue;
        }
        let error = local.noise(t) / modulus(slope);
        pairs.push(Pair { place, t, error });
    }
}

/// Newton's method for a complex root, from next to a gap's lowest point: the poles that `weight` names and the roots
/// already found are divided out. `None` unless it settles off the real axis.
fn newton(
    local: Local<'_>,
    start: Complex<f64>,
    weight: impl Fn(Complex<f64>) -> Complex<f64>,
) -> Option<(Complex<f64>, Complex<f64>)> {
    let (mut t, size) = (start, modulus(start));
    for _ in 0..40 {
        let (value, slope) = local.complex(t);
        let step = (slope / value + weight(t)).inv();
        if !(step.re.is_finite() && step.im.is_finite()) {
            return (value == Complex::new(0.0, 0.0) && t.im != 0.0).then_some((t, slope));
        }
        t -= step;
        if step.norm_sqr() < 1e-26 * t.im * t.im {
            // The last step was quadratic: its successor is below rounding.
            return Some((Complex::new(t.re, t.im.abs()), slope));
        }
        if t.im.abs() < 1e-16 * size {
            return None;
        }
    }
    None
}

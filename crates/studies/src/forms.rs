//! The paper's closed forms of forced orbits for a given time φ of the second impact, as printed and as they hold.
//!
//! The program itself solves for φ in another form (`vibrochain-breather`, `one_contact`); this one draws a(φ), serves as
//! a check that shares no code with it, and shows what the misprints do.
//!
//! ```text
//! q = (1−e)/(1+e),  S = q² + χ₃²,  D = χ₂ − χ₁,  c, s = cos wφ, sin wφ
//! P = S(1−c) + wD(q−χ₃)s,   Q = Ss + wD[(q−χ₃)c − (q+χ₃)],   σ = √(P²+Q²)
//! double-sided    wψ = atan2(Q, P) ± arccos(2S/(σÃ)),  w = ω
//! period-doubled  wψ = atan2(Q, P) ± π/2,              w = 2ω of the paper, the force's frequency
//! ```

use vibrochain_lattice::{ImpulseResponse, Model};

/// χ₁, χ₂, χ₃ of the paper at a time φ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Kernels {
    pub(crate) chi1: f64,
    pub(crate) chi2: f64,
    pub(crate) chi3: f64,
}

impl Kernels {
    pub(crate) fn at(response: &ImpulseResponse, phi: f64) -> Self {
        let (chi1, chi2) = (-2.0 * response.value(0, phi), -2.0 * response.value(0, 0.0));
        Self { chi1, chi2, chi3: 2.0 * response.derivative(0, phi) }
    }
}

/// Which text is followed where the print is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Reading {
    /// Everything as it holds.
    Mended,
    /// σ as printed.
    Sigma,
    /// α = +arccos(P/σ), the upper sign of the print.
    Alpha,
    /// p₂ of the doubled orbit with the sign as printed.
    Impulse,
    /// The second term of α's numerator with ω for 2ω, in the doubled orbit, as printed.
    AlphaFrequency,
}

/// Phase, impulses and the asymmetry that belong to φ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Form {
    /// w ψ
    pub(crate) phase: f64,
    pub(crate) p1: f64,
    pub(crate) p2: f64,
    pub(crate) asymmetry: f64,
    /// Violation of the second position condition, which a right form fulfils.
    pub(crate) residual: f64,
}

/// P, Q, σ and α in a reading.
fn alpha(kernels: &Kernels, q: f64, w: f64, phi: f64, reading: Reading, doubled: bool) -> (f64, f64) {
    let Kernels { chi1, chi2, chi3 } = *kernels;
    let (s, c) = (w * phi).sin_cos();
    let (square, d) = (q * q + chi3 * chi3, chi2 - chi1);
    let slope = if reading == Reading::AlphaFrequency { 0.5 * w } else { w };
    let p = square * (1.0 - c) + slope * d * (q - chi3) * s;
    let big_q = square * s + w * d * ((q - chi3) * c - (q + chi3));
    let whole = square * (1.0 - c) + w * d * (q - chi3) * s;
    let mut sigma = whole.hypot(big_q);
    if reading == Reading::Sigma {
        // 2χ₃² is printed as 2χ³; the doubled orbit has −q⁴ for +q⁴ on top.
        let fourth = if doubled { chi3.powi(4) - q.powi(4) } else { chi3.powi(4) + q.powi(4) };
        let printed = 2.0 * w * w * chi3 * chi3 * d * d * (1.0 + c) - 4.0 * w * chi3 * square * d * s
            + 2.0 * (fourth + q * q * (w * w * d * d + 2.0 * chi3.powi(3))) * (1.0 - c);
        sigma = printed.max(0.0).sqrt();
    }
    let alpha = match reading {
        Reading::Alpha => (p / sigma).clamp(-1.0, 1.0).acos(),
        // The quadrant is granted, so that the other misprint is seen alone. (The doubled orbit needs σ for α only.)
        Reading::AlphaFrequency => (p / sigma).clamp(-1.0, 1.0).acos().copysign(big_q),
        Reading::Sigma if doubled => (p / sigma).clamp(-1.0, 1.0).acos().copysign(big_q),
        _ => big_q.atan2(p),
    };
    (sigma, alpha)
}

/// The double-sided orbit of a given φ on the branch ± of ψ; `None` where that branch does not exist. `kernels` are those
/// of the force's frequency.
pub(crate) fn double_sided(
    kernels: &Kernels,
    model: &Model,
    force: f64,
    phi: f64,
    branch: f64,
    reading: Reading,
) -> Option<Form> {
    let (q, w) = (model.loss(), model.omega());
    let Kernels { chi1, chi2, chi3 } = *kernels;
    let square = q * q + chi3 * chi3;
    let (sigma, alpha) = alpha(kernels, q, w, phi, reading, false);
    let cosine = 2.0 * square / (sigma * force);
    if cosine.is_nan() || cosine.abs() > 1.0 {
        return None;
    }
    let phase = alpha + branch * cosine.acos();
    let (first, second) = (phase, phase + w * phi);
    let p1 = force * w * (q * second.sin() - chi3 * first.sin()) / square;
    let p2 = -force * w * (chi3 * second.sin() + q * first.sin()) / square;
    let asymmetry = -p1 * chi1 + p2 * chi2 + force * first.cos() - 1.0;
    let residual = -p1 * chi2 + p2 * chi1 + force * second.cos() + 1.0 - asymmetry;
    Some(Form { phase, p1, p2, asymmetry, residual })
}

/// The doubled orbit of a given φ; `kernels` are those of half the force's frequency.
pub(crate) fn period_doubled(
    kernels: &Kernels,
    model: &Model,
    force: f64,
    phi: f64,
    branch: f64,
    reading: Reading,
) -> Form {
    let (q, w) = (model.loss(), model.omega());
    let Kernels { chi1, chi2, chi3 } = *kernels;
    let square = q * q + chi3 * chi3;
    let (_, alpha) = alpha(kernels, q, w, phi, reading, true);
    let phase = alpha + branch * std::f64::consts::FRAC_PI_2;
    let (first, second) = (phase, phase + w * phi);
    let p1 = force * w * (q * second.sin() - chi3 * first.sin()) / square;
    let sign = if reading == Reading::Impulse { -1.0 } else { 1.0 };
    let p2 = sign * force * w * (chi3 * second.sin() + q * first.sin()) / square;
    let asymmetry = -p1 * chi1 - p2 * chi2 + force * first.cos() + 1.0;
    let residual = -p1 * chi2 - p2 * chi1 + force * second.cos() + 1.0 - asymmetry;
    Form { phase, p1, p2, asymmetry, residual }
}

#[cfg(test)]
mod tests {
    use vibrochain_breather::{Family, breathers};
    use vibrochain_lattice::{Point, Spectrum};

    use super::*;

    /// Every orbit that the search finds lies on a branch of the closed form, and the misprints miss it.
    #[test]
    fn the_mended_forms_pass_through_every_solution() {
        for (gamma, omega, a, amplitude, e) in
            [((0.2, 0.1), 1.5, 0.4, 0.1, 0.9), ((0.1, 0.05), 1.33, 0.0, 1.5, 0.6), ((0.2, 0.1), 1.5, 0.5, 0.9, 0.9)]
        {
            let ring = Point::ring(21).gamma1(gamma.0).gamma2(gamma.1);
            let model = ring.omega(omega).asymmetry(a).amplitude(amplitude).restitution(e).model().unwrap();
            let response = ImpulseResponse::new(&Spectrum::new(*model.chain()), omega).unwrap();
            let force = model.force_response().unwrap();
            let found = breathers(&model, Family::DoubleSided).unwrap().orbits;
            assert!(found.len() >= 2);
            for orbit in found {
                let phi = orbit.phi().unwrap();
                let kernels = Kernels::at(&response, phi);
                let error = |reading| {
                    let forms = [1.0, -1.0].map(|branch| double_sided(&kernels, &model, force, phi, branch, reading));
                    let errors = forms.iter().flatten().map(|form| (form.asymmetry - a).abs() + form.residual.abs());
                    errors.fold(f64::INFINITY, f64::min)
                };
                assert!(error(Reading::Mended) < 1e-12, "{phi} {}", error(Reading::Mended));
                if (phi / model.period() - 0.5).abs() > 1e-3 {
                    assert!(error(Reading::Sigma) > 1e-6);
                }
            }
        }
    }

    #[test]
    fn the_doubled_orbit_is_met_and_its_misprints_miss_it() {
        let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
        let model = ring.omega(1.07).asymmetry(0.8).amplitude(0.1582).restitution(0.25).model().unwrap();
        let orbit = &breathers(&model, Family::PeriodDoubled).unwrap().orbits[0];
        let response = ImpulseResponse::new(&Spectrum::new(*model.chain()), orbit.frequency()).unwrap();
        let force = model.force_response().unwrap();
        let phi = orbit.phi().unwrap();
        let kernels = Kernels::at(&response, phi);
        let error = |reading| {
            let forms = [1.0, -1.0].map(|branch| period_doubled(&kernels, &model, force, phi, branch, reading));
            let errors = forms.iter().map(|form| (form.asymmetry - 0.8).abs() + form.residual.abs());
            errors.fold(f64::INFINITY, f64::min)
        };
        assert!(error(Reading::Mended) < 1e-13);
        for reading in [Reading::Impulse, Reading::AlphaFrequency] {
            assert!(error(reading) > 1e-3, "{reading:?}");
        }
    }
}

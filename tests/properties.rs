//! Laws that hold at every parameter point.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use nalgebra::DMatrix;
use proptest::prelude::*;
use vibrochain::breather::{Family, Orbit, admissibility, breathers};
use vibrochain::floquet::{Tolerance, even_monodromy, full_monodromy, stability};
use vibrochain::lattice::{Chain, ImpulseResponse, Model, Spectrum};

const FAMILIES: [Family; 3] = [Family::DoubleSided, Family::SingleSided, Family::PeriodDoubled];

fn conservative() -> impl Strategy<Value = Model> {
    (1usize..24, 0.02..1.0, 0.0..0.5, 0.3..4.0, 0.0..0.95).prop_filter_map("valid", |(sites, g1, g2, omega, a)| {
        Model::conservative(Chain::new(sites, g1, g2).ok()?, omega, a).ok()
    })
}

fn forced() -> impl Strategy<Value = Model> {
    (1usize..24, 0.02..1.0, 0.0..0.5, 0.5..4.0, 0.0..0.95, 0.01..2.0, 0.1..=1.0).prop_filter_map(
        "valid",
        |(sites, g1, g2, omega, a, amplitude, e)| {
            Model::forced(Chain::new(sites, g1, g2).ok()?, omega, a, amplitude, e).ok()
        },
    )
}

/// All orbits of a model whose harmonics keep some distance from the modes (next to a resonance digits are lost by nature).
fn orbits(model: &Model) -> Vec<Orbit> {
    let spectrum = Spectrum::new(*model.chain());
    let away = [1.0, 0.5].iter().all(|part| {
        ImpulseResponse::new(&spectrum, part * model.omega()).is_ok_and(|response| response.condition() < 1e3)
    });
    let off_force = (model.chain().gamma1().sqrt() / model.omega() - 1.0).abs() > 1e-2;
    if !away || !off_force {
        return Vec::new();
    }
    FAMILIES.iter().flat_map(|&family| breathers(model, family).unwrap().orbits).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn impact_conditions_hold(model in prop_oneof![conservative(), forced()]) {
        for orbit in orbits(&model) {
            let scale = orbit.impacts().iter().map(|impact| impact.impulse.abs()).fold(1.0, f64::max);
            prop_assert!(orbit.residual() <= 1e-11 * scale, "{} {:?}", orbit.residual(), orbit);
        }
    }

    #[test]
    fn phase_space_volume_shrinks_by_the_square_of_restitution_per_impact(model in prop_oneof![conservative(), forced()]) {
        for orbit in orbits(&model) {
            let matrix = even_monodromy(&orbit).unwrap();
            let expected = model.restitution().powi(2 * orbit.impacts().len() as i32);
            // Cancellation in a determinant goes with the product of the rows' sizes; grazing orbits have huge ones.
            let size: f64 = matrix.row_iter().map(|row| row.norm().max(1.0)).product();
            prop_assume!(size < 1e12);
            prop_assert!((matrix.determinant() - expected).abs() < 1e-14 * size + 1e-12, "{}", matrix.determinant());
        }
    }

    #[test]
    fn conservative_flow_is_canonical_and_its_multipliers_come_in_reciprocal_pairs(model in conservative()) {
        for orbit in orbits(&model) {
            let matrix = full_monodromy(&orbit).unwrap();
            let m = model.chain().sites();
            let form = DMatrix::from_fn(2 * m, 2 * m, |i, j| f64::from(u8::from(j == i + m)) - f64::from(u8::from(i == j + m)));
            let scale = matrix.norm().powi(2);
            let defect = (matrix.transpose() * &form * &matrix - &form).amax();
            prop_assert!(defect < 1e-12 * scale, "{defect:e} of {scale:e}");
            let multipliers = stability(&orbit, Tolerance::Rounding).unwrap().multipliers;
            for mu in &multipliers {
                let partner = multipliers.iter().map(|other| (other - mu.inv()).norm()).fold(f64::INFINITY, f64::min);
                prop_assert!(partner < 1e-7 * (1.0 + mu.inv().norm()), "{mu} has no partner");
            }
        }
    }

    #[test]
    fn units_of_time_do_not_matter(model in prop_oneof![conservative(), forced()], s in 1e-4..1e4_f64) {
        let chain = model.chain();
        let scaled = Model::forced(
            Chain::new(chain.sites(), s * chain.gamma1(), s * chain.gamma2()).unwrap(),
            s.sqrt() * model.omega(),
            model.asymmetry(),
            s * model.amplitude(),
            model.restitution(),
        )
        .unwrap();
        let (before, after) = (orbits(&model), orbits(&scaled));
        prop_assume!(!before.is_empty() && !after.is_empty());
        prop_assert_eq!(before.len(), after.len());
        for (a, b) in before.iter().zip(&after) {
            for (p, q) in a.impacts().iter().zip(b.impacts()) {
                let size = 1.0 + p.impulse.abs();
                prop_assert!((q.impulse - s.sqrt() * p.impulse).abs() < 1e-7 * size, "{} {}", p.impulse, q.impulse);
                prop_assert!((q.time * s.sqrt() - p.time).abs() < 1e-7 * a.period());
            }
            let (p, q) = (admissibility(a).unwrap(), admissibility(b).unwrap());
            prop_assert_eq!(p.is_physical(), q.is_physical());
            if let (Some(p), Some(q)) = (p.margin, q.margin) {
                prop_assert!((p - q).abs() < 1e-7 * (1.0 + p.abs()), "{p} {q}");
            }
            // The radius of nearly meeting multipliers moves like a square root of rounding.
            let radius = |orbit: &Orbit| stability(orbit, Tolerance::Rounding).unwrap().verdict;
            let (p, q) = (radius(a), radius(b));
            let slack = 1e-6 * p.spectral_radius + 10.0 * p.resolution.max(q.resolution);
            prop_assert!((p.spectral_radius - q.spectral_radius).abs() < slack, "{p:?} {q:?}");
        }
    }
}

//! All double-sided breathers at a point, their multipliers and verdicts.

use vibrochain::{Family, Point, Tolerance, admissibility, breathers, stability};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let point = Point::ring(21).gamma1(0.2).gamma2(0.1).omega(1.5).asymmetry(0.4);
    let model = point.amplitude(0.1).restitution(0.9).model()?;
    let found = breathers(&model, Family::DoubleSided)?;
    for orbit in &found.orbits {
        let answer = stability(orbit, Tolerance::Excess(0.01))?;
        println!("φ = {:?}: |μ| = {}, {}", orbit.phi(), answer.verdict.spectral_radius, admissibility(orbit)?);
        assert_eq!(answer.multipliers.len(), 42);
        assert!(orbit.residual() < 1e-14);
    }
    println!("{}", found.completeness);
    assert_eq!(found.orbits.len(), 2);
    Ok(())
}

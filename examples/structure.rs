//! A structure of two masses, of which the second meets a stop once a period of the force.

use std::sync::Arc;

use vibrochain::{Complex, Contact, DMatrix, DVector, LoadedStructure, Structure, Tolerance, admissibility, stability};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let stop = Contact { lower: None, upper: Some(0.7), restitution: 0.8 };
    let structure = Structure {
        mass: DMatrix::identity(2, 2),
        damping: DMatrix::from_row_slice(2, 2, &[0.02, 0.0, 0.0, 0.1]),
        stiffness: DMatrix::from_row_slice(2, 2, &[1.0, -0.3, -0.3, 0.8]),
        contacts: vec![(DVector::from_vec(vec![0.0, 1.0]), stop)],
        loads: vec![(1, DVector::from_vec(vec![Complex::new(0.3, 0.0); 2]))],
        ..Structure::default()
    };
    let model = LoadedStructure::new(Arc::new(structure.modal()?), 0.8)?;
    let found = model.orbits(&"0+".parse()?, 1)?;
    for orbit in &found.orbits {
        let verdict = stability(orbit, Tolerance::Rounding)?.verdict;
        println!("P = {:?}: |μ| = {}, {}", orbit.impulses(), verdict.spectral_radius, admissibility(orbit)?);
    }
    assert_eq!(found.orbits.len(), 2);
    Ok(())
}

//! A chain is a structure whose modes are known in closed form: asked of both, the same orbits, obstructions and multipliers, cells, branches and
//! runs.
//!
//! Matrices are put together spring by spring (`testkit::stiffness`) and their modes found by a dense solver.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod branches;
mod ends;
mod lists;
mod maps;
mod runs;

use nalgebra::{Complex, DMatrix, DVector};
use std::sync::Arc;
use vibrochain_breather::{Family, LoadedStructure, Word};
use vibrochain_lattice::{Barrier, Contact, Model, Structure};
use vibrochain_testkit::stiffness;

/// The matrices of a model's chain, contact n at mass n.
fn matrices(model: &Model) -> Structure {
    let n = model.chain().sites();
    let unit = |site: usize| DVector::from_fn(n, |i, _| f64::from(u8::from(i == site)));
    let [lower, upper] = [Barrier::Lower, Barrier::Upper].map(|barrier| Some(model.barrier(barrier)));
    let contact = Contact { lower, upper, restitution: model.restitution() };
    let load = |amplitude: f64, phase: f64| DVector::from_element(n, Complex::from_polar(amplitude, phase));
    let harmonics = model.force().harmonics().iter();
    let unit_springs = model.chain().point().gamma1(1.0).gamma2(1.0).gamma3(0.0).chain().unwrap();
    let [own, between] = model.dashpots();
    let damping = DMatrix::identity(n, n) * (own - between) + stiffness(&unit_springs) * between;
    Structure {
        damping,
        mass: DMatrix::identity(n, n),
        stiffness: stiffness(model.chain()),
        contacts: (0..n).map(|site| (unit(site), contact)).collect(),
        loads: harmonics.map(|harmonic| (harmonic.number, load(harmonic.amplitude, harmonic.phase))).collect(),
        ..Structure::default()
    }
}

/// The chain of a model as a structure.
fn structure(model: &Model) -> LoadedStructure {
    LoadedStructure::new(Arc::new(matrices(model).modal().unwrap()), model.omega()).unwrap()
}

/// A family's word at one mass, with its periods of the force.
fn word(family: Family, site: usize) -> (Word, u32) {
    let (text, periods) = match family {
        Family::DoubleSided => (format!("{site}+,{site}-"), 1),
        Family::SingleSided => (format!("{site}-"), 1),
        Family::PeriodDoubled | Family::Word => (format!("{site}-,{site}-"), 2),
    };
    (text.parse().unwrap(), periods)
}

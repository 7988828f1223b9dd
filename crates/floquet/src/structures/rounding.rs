//! What rounding does to a test function where it vanishes.
//!
//! A determinant next to 0 changes by Σ adj(A)_ji δA_ij. It may be far below 1 all about: of an orbit of many impacts it is a product of many
//! small pivots, so that an absolute bound tells nothing.

use vibrochain_breather::StructureOrbit;
use vibrochain_breather::system::{Evaluation, Vector};

use super::test_function::{Regular, Test, of_another_one};
use crate::linear::moved_by;

/// Of a test function of order 1.
pub(super) const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Of an entry of the orbit's own equations, as a part of its row.
const ENTRY: f64 = 8.0 * f64::EPSILON;

/// Of each value of a test function.
pub(super) fn rounding(test: Test, here: &Evaluation<StructureOrbit, Vector>, mark: Option<f64>) -> f64 {
    let orbit = &here.orbit;
    let regular = |theta: f64| Some(Regular::of(orbit, &orbit.bloch_equations().0, theta));
    let told = match test {
        Test::One => return of_equations(here),
        Test::AnotherOne => of_another_one(orbit),
        Test::MinusOne => regular(std::f64::consts::PI),
        Test::Circle | Test::Collision => regular(mark.unwrap_or(0.0)),
        Test::Velocity(_) | Test::Touch(..) => None,
    };
    told.map_or(ROUNDING, |told| told.rounding())
}

/// Of det J(1), its rows scaled to length 1.
fn of_equations(here: &Evaluation<StructureOrbit, Vector>) -> f64 {
    let size = here.matrix.size();
    let mut entries = Vec::with_capacity(size * size);
    for i in 0..size {
        let row = here.matrix.row(i);
        let length = row.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        entries.extend(row.iter().map(|entry| nalgebra::Complex::new(entry / length, 0.0)));
    }
    moved_by(&mut entries, &vec![ENTRY; size * size], size)
}

//! What rounding does to a test function where it vanishes.
//!
//! A determinant next to 0 changes by Σ adj(A)_ji δA_ij. It may be far below 1 all about: of an orbit of many impacts it is a product of many
//! small pivots, so that an absolute bound tells nothing.

use smallvec::smallvec;
use vibrochain_breather::ContactOrbit;
use vibrochain_breather::linear::cofactors;
use vibrochain_breather::system::{Evaluation, Matrix};

use super::regular::Regular;
use super::test_function::{REAL, Test, Values};

/// Of a test function of order 1.
pub(super) const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Of an entry of the orbit's own equations, as a part of its row.
const ENTRY: f64 = 8.0 * f64::EPSILON;

/// Of each value of a test function.
pub(super) fn rounding<K>(test: Test, here: &Evaluation<ContactOrbit, K>, mark: Option<f64>) -> Values {
    told(test, here, mark).unwrap_or_else(|| smallvec![ROUNDING; 2])
}

fn told<K>(test: Test, here: &Evaluation<ContactOrbit, K>, mark: Option<f64>) -> Option<Values> {
    let orbit = &here.orbit;
    let regular = |theta: f64| Some(Regular::of(&orbit.bloch_equations().0, theta).rounding(None));
    Some(match test {
        Test::Fold => smallvec![of_equations(&here.matrix)],
        Test::One => smallvec![of_equations(here.all())],
        Test::AnotherOne => {
            let (mut equations, _) = orbit.bloch_equations();
            let shift = equations.leave_out_shift()?;
            smallvec![Regular::of(&equations, 0.0).rounding(Some(shift.place))]
        }
        Test::MinusOne => smallvec![regular(std::f64::consts::PI)?],
        Test::Circle | Test::Collision => {
            let error = regular(mark?)?;
            smallvec![error, error / mark?.sin().abs().max(REAL)]
        }
        Test::Release(i) => {
            let [_, error] = orbit.acceleration_after(i).ok()??;
            smallvec![error / (orbit.model().omega() * orbit.speed())]
        }
        Test::Velocity(_) | Test::Touch(..) | Test::Corner(..) => return None,
    })
}

/// Of det J(1), its rows scaled to length 1.
fn of_equations(matrix: &Matrix) -> f64 {
    let size = matrix.size();
    let mut entries = Vec::with_capacity(size * size);
    for i in 0..size {
        let row = matrix.row(i);
        let length = row.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        entries.extend(row.iter().map(|entry| entry / length));
    }
    let moved = |factors: Vec<f64>| factors.iter().map(|factor| ENTRY * factor.abs()).sum();
    cofactors(&mut entries, size).map_or(f64::INFINITY, moved)
}

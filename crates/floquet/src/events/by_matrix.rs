//! Multipliers of an orbit without losses from the matrix that takes the modes which its impacts feel over a period: what tells pairs that meet from
//! one better than the zeros of a determinant.

use nalgebra::{Complex, DMatrix};
use vibrochain_breather::{BlochEquations, LinearImpact};

use crate::reference::eigen::eigenvalues;

/// Both coordinates of all modes.
pub(super) type State = Vec<[f64; 2]>;

/// The state of modes a flight later.
pub(super) fn fly(equations: &BlochEquations, state: &mut State, t: f64) {
    for (mode, own) in equations.kernel().modes().iter().zip(state) {
        *own = mode.coordinates.given(mode.flight(t), *own);
    }
}

/// What an impact makes of a small change of the state before it, which moves its time by τ: column·δP − A column·Pτ is added.
pub(super) fn strike(equations: &BlochEquations, impact: &LinearImpact, state: &mut State) {
    let kernel = equations.kernel();
    let (contact, mobility) = (impact.contact, kernel.mobility(impact.contact, impact.contact));
    let velocity = -impact.impulse * mobility / (1.0 + impact.restitution);
    let dot = |row: [f64; 2], own: [f64; 2]| row[0] * own[0] + row[1] * own[1];
    let (mut place, mut speed) = (0.0, 0.0);
    for (k, (mode, own)) in kernel.modes().iter().zip(state.iter()).enumerate() {
        place += dot(kernel.row(k, contact), *own);
        speed += dot(kernel.row(k, contact), mode.coordinates.given(mode.generator(), *own));
    }
    let late = -place / velocity;
    let impulse = -(1.0 + impact.restitution) * (speed + impact.acceleration_before * late) / mobility;
    for (k, (mode, own)) in kernel.modes().iter().zip(state).enumerate() {
        let column = kernel.column(k, contact);
        let turned = mode.coordinates.given(mode.generator(), column);
        for side in 0..2 {
            own[side] += column[side] * impulse - turned[side] * impact.impulse * late;
        }
    }
}

/// All multipliers of the modes that the impacts feel but the two of the orbit's own shift in time, if it is conservative.
pub(crate) fn multipliers(equations: &BlochEquations, is_conservative: bool) -> Option<Vec<Complex<f64>>> {
    let (kernel, impacts) = (equations.kernel(), equations.impacts());
    let size = 2 * kernel.modes().len();
    let mut matrix = DMatrix::zeros(size, size);
    for j in 0..size {
        let mut state: State = vec![[0.0; 2]; kernel.modes().len()];
        state[j / 2][j % 2] = 1.0;
        let mut since = impacts.first()?.time;
        for impact in impacts {
            fly(equations, &mut state, impact.time - since);
            strike(equations, impact, &mut state);
            since = impact.time;
        }
        fly(equations, &mut state, kernel.period() + impacts[0].time - since);
        (0..size).for_each(|i| matrix[(i, j)] = state[i / 2][i % 2]);
    }
    let mut values = Vec::with_capacity(size);
    eigenvalues(&matrix, &mut values).ok()?;
    if is_conservative {
        values.sort_by(|a, b| (b - 1.0).norm().total_cmp(&(a - 1.0).norm()));
        values.truncate(size.checked_sub(2)?);
    }
    Some(values)
}

//! What modes next to a resonance, whose states are unknowns (`open_modes`), put into tables of enclosures. With y the state just before the first
//! impact, which is at 0, and x what the loads next to the mode make of rest,
//!
//! ```text
//! seen at t_i       row·(e^{At_i}y + Σ_{j<i} e^{A(t_i−t_j)}c_jP_j + x(t_i))
//! a period later    (1−R)y − Σ_j e^{A(T−t_j)}c_jP_j − x(T) = 0                 x(t) = Re e^{iwψ}D(t),  D′ = AD + e^{iwt}L
//! ```
//!
//! All of it is bounded however close the resonance is.

use smallvec::SmallVec;
use vibrochain_lattice::Complex;

use crate::roots::patch::{Patch, Piece};
use crate::structures::equations::Equations;
use crate::structures::open_mode::{OpenMode, State};
use crate::structures::periodic_kernel::length;

type C = Complex<f64>;

/// Rounding of a flight's entry, in units of ε: sums of a few products.
const ROUNDED: f64 = 8.0;

/// One mode as the impacts of a word see it.
#[derive(Debug)]
pub(super) struct OpenRows {
    own: OpenMode,
    contacts: SmallVec<[usize; 3]>,
    /// 1+e
    weights: SmallVec<[f64; 3]>,
    period: f64,
}

/// Of a place and of Newton's law, which has the velocity times 1+e.
pub(super) type Seen = [Piece; 2];

/// What depends on the time of the second impact alone.
#[derive(Debug, Clone)]
pub(super) struct OpenStrip {
    pub(super) state: [Seen; 2],
    pub(super) first: Seen,
    pub(super) left: [Piece; 2],
    pub(super) driven: Driven,
}

/// w of each load, and of place and law the real and the imaginary part of D.
pub(super) type Driven = SmallVec<[(f64, [[Piece; 2]; 2]); 1]>;

/// What a contact sees of a state.
fn seen([a, b]: [f64; 2], [x, y]: State) -> f64 {
    a * x + b * y
}

impl OpenRows {
    /// Those of all open modes.
    pub(super) fn of(equations: &Equations<'_>, contacts: &[usize]) -> Vec<Self> {
        let weights = || contacts.iter().map(|contact| 1.0 + equations.restitution(*contact));
        let rows = |own: &OpenMode| Self {
            own: own.clone(),
            contacts: contacts.iter().copied().collect(),
            weights: weights().collect(),
            period: equations.period(),
        };
        equations.open.iter().map(rows).collect()
    }

    /// |A| at most.
    fn fast(&self) -> f64 {
        length([self.own.mode.decay, self.own.mode.rate])
    }

    /// The largest rate of the mode and its loads; and the largest of the loads alone.
    pub(super) fn fastest(&self) -> [f64; 2] {
        let loads = self.own.loads.iter().map(|load| load.0).fold(0.0, f64::max);
        [self.fast().max(loads), loads]
    }

    /// What a unit impulse gives at most. Rows of the mode may vanish but for rounding, as half a period apart with the load in phase: they are
    /// divided by no less.
    pub(super) fn given(&self) -> f64 {
        self.contacts.iter().map(|contact| length(self.own.mode.columns[*contact])).fold(f64::MIN_POSITIVE, f64::max)
    }

    /// Rounding of what a flight as long as `t` makes of a column and a row sees, and errors of these.
    fn doubt(&self, t: f64, row: [f64; 2], column: [f64; 2], errors: f64) -> f64 {
        ROUNDED * f64::EPSILON * self.own.blur(t) * length(row) * length(column) + errors
    }

    /// What impact `i` sees of a state with these derivatives, which is no longer than `size` on the interval.
    fn seen_by(&self, i: usize, jet: [State; 4], size: f64, doubt: f64) -> Seen {
        let (row, weight, fast) = (self.own.mode.rows[self.contacts[i]], self.weights[i], self.fast());
        let (jet, third) = (jet.map(|state| seen(row, state)), length(row) * size * fast * fast * fast);
        [
            Piece { jet: [jet[0], jet[1], jet[2]], third, doubt },
            Piece {
                jet: [jet[1], jet[2], jet[3]].map(|x| weight * x),
                third: weight * fast * third,
                doubt: weight * fast * doubt,
            },
        ]
    }

    /// What impact `i` at a time sees of each coordinate of y.
    pub(super) fn state(&self, i: usize, time: f64) -> [Seen; 2] {
        let (mode, contact) = (&self.own.mode, self.contacts[i]);
        let flight = mode.flight(time);
        [[1.0, 0.0], [0.0, 1.0]].map(|unit| {
            let doubt = self.doubt(time, mode.rows[contact], unit, mode.errors.rows[contact]);
            self.seen_by(i, self.own.jet(self.own.act(flight, unit)), 1.0, doubt)
        })
    }

    /// What impact `to` sees of the impulse of an earlier one.
    pub(super) fn passed(&self, [to, from]: [usize; 2], lapse: f64) -> Seen {
        let mode = &self.own.mode;
        let [contact, hit] = [to, from].map(|i| self.contacts[i]);
        let column = mode.columns[hit];
        let doubt = self.doubt(lapse, mode.rows[contact], column, mode.errors_between(contact, hit));
        self.seen_by(to, self.own.jet(self.own.act(mode.flight(lapse), column)), length(column), doubt)
    }

    /// What the impulse of impact `j` leaves of both coordinates at the end of the period.
    pub(super) fn left(&self, j: usize, time: f64) -> [Piece; 2] {
        let (mode, contact) = (&self.own.mode, self.contacts[j]);
        let column = mode.columns[contact];
        let jet = self.own.jet(self.own.act(mode.flight(self.period - time), column));
        let third = self.fast().powi(3) * length(column);
        let doubt = self.doubt(self.period, [1.0, 0.0], column, mode.errors.columns[contact]);
        // Later impacts have less of the period left.
        [0, 1].map(|side| Piece { jet: [jet[0][side], -jet[1][side], jet[2][side]], third, doubt })
    }

    /// 1 − R, by rows.
    pub(super) fn one_less(&self) -> [[f64; 2]; 2] {
        let [first, second] = [[1.0, 0.0], [0.0, 1.0]].map(|unit| self.own.act(self.own.one_less, unit));
        [[first[0], second[0]], [first[1], second[1]]]
    }

    /// What impact `i` sees of D at a time.
    pub(super) fn driven(&self, i: usize, time: f64, radius: f64) -> Driven {
        let (contact, weight, fast) = (self.contacts[i], self.weights[i], self.fast());
        let (row, row_error) = (self.own.mode.rows[contact], self.own.mode.errors.rows[contact]);
        let of = |&(w, load, error): &(f64, [C; 2], f64)| {
            let size = load[0].norm() + load[1].norm();
            let jet = self.own.driven_jet(w, load, time).map(|[x, y]| x * row[0] + y * row[1]);
            // |D| ≤ t|L|, and each derivative adds one of the load.
            let second = fast * (fast * (time + radius) + 1.0) * size + w * size;
            let third = fast * second + w * w * size;
            let fourth = fast * third + w * w * w * size;
            let reach = length(row);
            let blur = ROUNDED * f64::EPSILON * (self.own.blur(time) + w * time);
            let steep = reach * (blur * size + error) + row_error * size;
            let (doubt, of_law) = (time * steep, (fast * time + 1.0) * steep);
            let parts: [fn(C) -> f64; 2] = [|d| d.re, |d| d.im];
            let place = parts.map(|part| {
                let [value, slope, bend, _] = jet.map(part);
                Piece { jet: [value, slope, bend], third: reach * third, doubt }
            });
            let law = parts.map(|part| {
                let [_, slope, bend, last] = jet.map(part);
                let jet = [slope, bend, last].map(|x| weight * x);
                Piece { jet, third: weight * reach * fourth, doubt: weight * of_law }
            });
            (w, [place, law])
        };
        self.own.loads.iter().map(of).collect()
    }

    /// D at the end of the period, with w and the error of each coordinate.
    pub(super) fn pushed(&self) -> impl Iterator<Item = (f64, [C; 2], f64)> + '_ {
        self.own.loads.iter().map(|&(w, load, error)| {
            let [state, ..] = self.own.driven_jet(w, load, self.period);
            let size = load[0].norm() + load[1].norm();
            let blur = ROUNDED * f64::EPSILON * (self.own.blur(self.period) + w * self.period);
            (w, state, self.period * (blur * size + error))
        })
    }

    /// All that depends on the time of the second impact alone.
    pub(super) fn strip(&self, time: f64, radius: f64) -> OpenStrip {
        OpenStrip {
            state: self.state(1, time),
            first: self.passed([1, 0], time),
            left: self.left(1, time),
            driven: self.driven(1, time, radius),
        }
    }
}

/// Re e^{iwψ}D of place and law, as functions of φ and ψ.
pub(super) fn at_phase(driven: &Driven, psi: f64, radius: [f64; 2]) -> [Patch; 2] {
    let mut sums = [Patch::constant(0.0, radius); 2];
    for (w, parts) in driven {
        let (sin, cos) = (w * psi).sin_cos();
        let doubt = f64::EPSILON * (4.0 + w * psi.abs());
        let [along, across] =
            [[cos, sin], [sin, -cos]].map(|parts| Piece { doubt, ..Piece::wave(parts, *w, 1.0) }.along(1, radius));
        for (sum, [re, im]) in sums.iter_mut().zip(parts) {
            *sum = *sum + along * re.along(0, radius) - across * im.along(0, radius);
        }
    }
    sums
}

#[cfg(test)]
mod tests;

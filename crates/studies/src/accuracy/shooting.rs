//! Suite `shooting`: an orbit of two damped masses by shooting with a general solver, by this program, and in many digits.

use std::f64::consts::TAU;
use std::hint::black_box;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use ode_solvers::System;
use vibrochain_breather::{Hit, LoadedStructure, Orbit, Word, admissibility};
use vibrochain_lattice::{Barrier, Complex, Contact, Structure};
use vibrochain_truth::{DEFAULT_BITS, Real, StructureStart, TrueStructureImpact, TrueStructureOrbit};

use crate::accuracy::meter::Meter;
use crate::accuracy::steppers::{State, StepperError, dop853_end};
use crate::accuracy::table::{Row, Table};
use crate::accuracy::{Suite, computation};
use vibrochain_cli::common::error::CliError;

pub(super) const SUITE: Suite = Suite {
    name: "shooting",
    title: "An orbit of two damped masses",
    prose: "Two masses, with dashpots that couple their modes and a load on the second; the first hits one stop, or two in turn. Methods begin with \
            two digits of the orbit; the truth has 57.\n\n- *shooting*: Newton's method on the state that a period brings back, flights by DOP853, \
            derivatives by differences;\n- *closed form*: what `mapgen` does from given impacts, with the bound that it tells;\n- *closed form, \
            all orbits*: without a start, with proof that there are no more;\n- *many digits*: shooting with exponentials of so many \
            bits.\n\nShooting buys digits with steps; the closed form has all that an `f64` holds in less time than shooting takes for four.",
    error: "largest of the errors of impulses (over the largest one), of times and ψ over the period",
    run,
};

/// Frequency of the load.
const OMEGA: f64 = 1.5;

/// Name, lower stop and word. Each has one physical orbit, which is stable.
const CASES: [(&str, Option<f64>, &str); 2] = [("one stop", None, "0+"), ("two stops", Some(-0.5), "0+,0-")];

fn structure(lower: Option<f64>) -> Structure {
    let contact = Contact { lower, upper: Some(0.4), restitution: 0.8 };
    Structure {
        mass: DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 0.7]),
        damping: DMatrix::from_row_slice(2, 2, &[0.08, -0.02, -0.02, 0.03]),
        stiffness: DMatrix::from_row_slice(2, 2, &[1.6, -0.5, -0.5, 1.1]),
        contacts: vec![(DVector::from_vec(vec![1.0, 0.0]), contact)],
        loads: vec![(1, DVector::from_vec(vec![Complex::new(0.0, 0.0), Complex::new(1.0, 0.0)]))],
        ..Structure::default()
    }
}

/// Impacts and phase: what a method says, or begins with.
#[derive(Debug, Clone)]
struct Answer {
    psi: f64,
    impacts: Vec<Hit>,
    /// A bound of [`Answer::error`], where one is told.
    bound: Option<f64>,
}

impl Answer {
    fn of(orbit: &Orbit) -> Self {
        let hit = |impact: &vibrochain_breather::Impact| Hit::from(impact);
        let largest = orbit.impulses().into_iter().map(f64::abs).fold(0.0, f64::max);
        let bound = orbit.contacts().map(|contacts| {
            let errors = contacts.impact_errors().iter();
            let parts = errors.flat_map(|error| [error.impulse / largest, error.time / orbit.period()]);
            parts.fold(contacts.psi_error() / orbit.period(), f64::max)
        });
        Self { psi: orbit.psi().unwrap_or_default(), impacts: orbit.impacts().iter().map(hit).collect(), bound }
    }

    /// The nearest numbers.
    fn rounded(truth: &TrueStructureOrbit, start: &Self) -> Self {
        let hit = |(hit, truth): (&Hit, &TrueStructureImpact)| Hit {
            time: truth.time.to_f64(),
            impulse: truth.impulse.to_f64(),
            ..*hit
        };
        let impacts = start.impacts.iter().zip(truth.impacts()).map(hit).collect();
        Self { psi: truth.psi().map_or(0.0, Real::to_f64), impacts, bound: None }
    }

    /// The same in two digits.
    fn rough(&self) -> Self {
        let two = |x: f64| {
            if x == 0.0 {
                x
            } else {
                let unit = 10f64.powf(x.abs().log10().floor() - 1.0);
                (x / unit).round() * unit
            }
        };
        let impacts = self.impacts.iter().map(|hit| Hit { time: two(hit.time), impulse: two(hit.impulse), ..*hit });
        Self { psi: two(self.psi), impacts: impacts.collect(), bound: None }
    }

    fn start<'a>(&'a self, structure: &'a Structure) -> StructureStart<'a> {
        StructureStart { structure, omega: OMEGA, force_periods: 1, psi: self.psi, impacts: &self.impacts }
    }

    fn error(&self, truth: &TrueStructureOrbit) -> f64 {
        let period = truth.period().log10_abs();
        let largest = truth.impacts().iter().map(|impact| impact.impulse.log10_abs()).fold(f64::NEG_INFINITY, f64::max);
        let around = |x: Real| {
            let turns = (&x / truth.period() + 0.5).floor();
            (x - turns * truth.period()).log10_abs() - period
        };
        let parts = truth.impacts().iter().zip(&self.impacts).flat_map(|(truth, hit)| {
            [(&truth.impulse - hit.impulse).log10_abs() - largest, around(&truth.time - hit.time)]
        });
        let psi = truth.psi().map_or(f64::NEG_INFINITY, |truth| around(truth - self.psi));
        10f64.powf(parts.fold(psi, f64::max))
    }
}

/// q″ = M⁻¹(f u − Kq − Cq′) of (q, q′, u, v), with u′ = −ωv and v′ = ωu. The load's clock is among the unknowns because ode_solvers 0.6.2
/// hands a wrong time to the last stage of its steps.
#[derive(Clone, Copy)]
struct Smooth<'a> {
    shooting: &'a Shooting,
}

impl System<f64, State> for Smooth<'_> {
    fn system(&self, _: f64, y: &State, dy: &mut State) {
        let Shooting { stiffness, damping, load, .. } = self.shooting;
        for i in 0..2 {
            dy[i] = y[2 + i];
            let springs: f64 = (0..2).map(|j| stiffness[(i, j)] * y[j] + damping[(i, j)] * y[2 + j]).sum();
            dy[2 + i] = load[i] * y[4] - springs;
        }
        (dy[4], dy[5]) = (-OMEGA * y[5], OMEGA * y[4]);
    }
}

/// Shooting with a general solver: unknown are the state just before the first impact, the times of the others, and ψ.
struct Shooting {
    /// M⁻¹K, M⁻¹C and M⁻¹f.
    stiffness: DMatrix<f64>,
    damping: DMatrix<f64>,
    load: DVector<f64>,
    contact: Contact,
    /// Of the mass that hits.
    mass: f64,
    barriers: Vec<Barrier>,
    tolerance: f64,
}

/// Steps of Newton's method at most.
const STEPS: usize = 12;

impl Shooting {
    fn new(structure: &Structure, barriers: Vec<Barrier>, tolerance: f64) -> Self {
        let inverse = structure.mass.map(|mass| if mass == 0.0 { 0.0 } else { 1.0 / mass });
        let load = structure.loads[0].1.map(|f| f.re);
        Self {
            stiffness: &inverse * &structure.stiffness,
            damping: &inverse * &structure.damping,
            load: &inverse * load,
            contact: structure.contacts[0].1,
            mass: structure.mass[(0, 0)],
            barriers,
            tolerance,
        }
    }

    fn time(&self, unknowns: &DVector<f64>, impact: usize) -> f64 {
        if impact == 0 {
            0.0
        } else if impact == self.barriers.len() {
            TAU / OMEGA
        } else {
            unknowns[3 + impact]
        }
    }

    /// The flight after an impact. (The solver's vectors are of another version of the same library.)
    fn fly(&self, state: &DVector<f64>, unknowns: &DVector<f64>, impact: usize) -> Result<DVector<f64>, StepperError> {
        let (from, until) = (self.time(unknowns, impact), self.time(unknowns, impact + 1));
        let (sin, cos) = (OMEGA * (unknowns[3 + self.barriers.len()] + from)).sin_cos();
        let begin = State::from_iterator(6, state.iter().copied().chain([cos, sin]));
        let end = dop853_end(Smooth { shooting: self }, &begin, until - from, self.tolerance)?;
        Ok(DVector::from_column_slice(&end.as_slice()[..4]))
    }

    /// How far each impact is from its stop, and the state from where it began; with the impulses.
    fn residuals(&self, unknowns: &DVector<f64>) -> Result<(DVector<f64>, Vec<f64>), StepperError> {
        let count = self.barriers.len();
        let mut state = unknowns.rows(0, 4).into_owned();
        let mut residuals = DVector::zeros(4 + count);
        let mut impulses = Vec::with_capacity(count);
        for (i, &barrier) in self.barriers.iter().enumerate() {
            residuals[i] = state[0] - self.contact.barrier(barrier).unwrap_or_default();
            let kick = -(1.0 + self.contact.restitution) * state[2];
            impulses.push(self.mass * kick);
            state[2] += kick;
            state = self.fly(&state, unknowns, i)?;
        }
        residuals.rows_mut(count, 4).copy_from(&(state - unknowns.rows(0, 4)));
        Ok((residuals, impulses))
    }

    /// Newton's method with differences, until its steps are as small as the tolerance or no longer shrink.
    fn solve(&self, start: &Answer) -> Result<Answer, CliError> {
        let count = self.barriers.len();
        let mut unknowns = self.begin(start)?;
        let mut last = f64::INFINITY;
        for _ in 0..STEPS {
            let (residuals, _) = self.residuals(&unknowns).map_err(computation)?;
            let mut jacobian = DMatrix::zeros(4 + count, 4 + count);
            // Half the digits that a flight has.
            let step = self.tolerance.max(f64::EPSILON).sqrt();
            for j in 0..4 + count {
                let mut moved = unknowns.clone();
                moved[j] += step;
                let (there, _) = self.residuals(&moved).map_err(computation)?;
                jacobian.set_column(j, &((there - &residuals) / step));
            }
            let by = jacobian.lu().solve(&residuals).ok_or_else(|| computation("shooting met a singular matrix"))?;
            unknowns -= &by;
            let size = by.amax();
            if size < self.tolerance || size > 0.5 * last {
                break;
            }
            last = size;
        }
        let (_, impulses) = self.residuals(&unknowns).map_err(computation)?;
        let hit = |i: usize| Hit::new(0, self.barriers[i], self.time(&unknowns, i), impulses[i]);
        Ok(Answer { psi: unknowns[3 + count], impacts: (0..count).map(hit).collect(), bound: None })
    }

    /// The state that returns if the impulses are those of the start: the flights are linear in it.
    fn begin(&self, start: &Answer) -> Result<DVector<f64>, CliError> {
        let count = self.barriers.len();
        let mut unknowns = DVector::zeros(4 + count);
        start.impacts.iter().enumerate().skip(1).for_each(|(i, hit)| unknowns[3 + i] = hit.time);
        unknowns[3 + count] = start.psi;
        let returns = |state: &DVector<f64>| {
            let mut state = state.clone();
            for (i, hit) in start.impacts.iter().enumerate() {
                state[2] += hit.impulse / self.mass;
                state = self.fly(&state, &unknowns, i)?;
            }
            Ok::<_, StepperError>(state)
        };
        let rest = returns(&DVector::zeros(4)).map_err(computation)?;
        let mut matrix = DMatrix::identity(4, 4);
        for j in 0..4 {
            let unit = DVector::from_fn(4, |i, _| f64::from(u8::from(i == j)));
            let moved = returns(&unit).map_err(computation)? - &rest;
            matrix.set_column(j, &(unit - moved));
        }
        let state = matrix.lu().solve(&rest).ok_or_else(|| computation("no state returns"))?;
        unknowns.rows_mut(0, 4).copy_from(&state);
        Ok(unknowns)
    }
}

fn model(structure: &Structure) -> Result<LoadedStructure, CliError> {
    LoadedStructure::new(Arc::new(structure.modal().map_err(computation)?), OMEGA).map_err(computation)
}

/// The physical orbit of a word.
fn physical(structure: &Structure, word: &Word) -> Result<Answer, CliError> {
    let orbits = model(structure)?.orbits(word, 1).map_err(computation)?.orbits;
    let is_physical = |orbit: &&Orbit| admissibility(orbit).is_ok_and(|answer| answer.is_physical());
    let orbit = orbits.iter().find(is_physical).ok_or_else(|| computation("no physical orbit of two masses"))?;
    Ok(Answer::of(orbit))
}

fn run(meter: &mut Meter<'_>) -> Result<Table, CliError> {
    let tolerances: &[f64] = if meter.is_quick() { &[1e-5, 1e-9] } else { &[1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13] };
    let digits: &[usize] = if meter.is_quick() { &[64, 128] } else { &[64, 128, 256] };
    let mut table = Table::default();
    for (case, lower, word) in CASES {
        let structure = structure(lower);
        let word = word.parse().map_err(computation)?;
        let told = physical(&structure, &word)?;
        let truth = TrueStructureOrbit::near(&told.start(&structure), DEFAULT_BITS).map_err(computation)?;
        let start = told.rough();
        let mut measure = |method: &str, setting: String, find: &mut dyn FnMut() -> Result<Vec<Answer>, CliError>| {
            meter.tell(case, method, &setting);
            let (answers, seconds) = meter.time(find)?;
            let errors = answers.iter().map(|answer| (answer.error(&truth), answer.bound));
            let nearest = errors.min_by(|a, b| a.0.total_cmp(&b.0));
            let (error, bound) = nearest.ok_or_else(|| computation("no orbit of two masses"))?;
            let mut notes = Vec::new();
            if answers.len() > 1 {
                notes.push(format!("{} orbits", answers.len()));
            }
            notes.extend(bound.map(|bound| format!("bound {bound:.3e}")));
            let note = notes.join(", ");
            table.rows.push(Row { case: case.to_owned(), method: method.to_owned(), setting, seconds, error, note });
            Ok::<(), CliError>(())
        };
        for &tolerance in tolerances {
            let barriers = start.impacts.iter().map(|hit| hit.barrier).collect();
            let shooting = Shooting::new(&structure, barriers, tolerance);
            measure("shooting", format!("tolerance {tolerance:e}"), &mut || {
                Ok(vec![shooting.solve(black_box(&start))?])
            })?;
        }
        measure("closed form", "no step".to_owned(), &mut || {
            let orbit = model(black_box(&structure))?.orbit_near(1, start.psi, &start.impacts).map_err(computation)?;
            Ok(vec![Answer::of(&orbit)])
        })?;
        measure("closed form, all orbits", "all orbits".to_owned(), &mut || {
            let found = model(black_box(&structure))?.orbits(&word, 1).map_err(computation)?;
            Ok(found.orbits.iter().map(Answer::of).collect())
        })?;
        for &bits in digits {
            measure("many digits", format!("{bits} bits"), &mut || {
                let found =
                    TrueStructureOrbit::near(&black_box(&start).start(&structure), bits).map_err(computation)?;
                Ok(vec![Answer::rounded(&found, &start)])
            })?;
        }
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Its steps are those of a solver that knows nothing of modes, and it ends where the closed form does.
    #[test]
    fn shooting_ends_on_the_orbit_from_two_digits() {
        for (_, lower, word) in CASES {
            let structure = structure(lower);
            let told = physical(&structure, &word.parse().unwrap()).unwrap();
            let truth = TrueStructureOrbit::near(&told.start(&structure), 128).unwrap();
            let (error, bound) = (told.error(&truth), told.bound.unwrap());
            assert!(error <= bound && bound < 1e-11, "{word}: {error:e} {bound:e}");
            assert!(told.rough().error(&truth) > 1e-4, "{word}");
            let errors = [1e-5, 1e-8, 1e-12].map(|tolerance| {
                let barriers = told.impacts.iter().map(|hit| hit.barrier).collect();
                Shooting::new(&structure, barriers, tolerance).solve(&told.rough()).unwrap().error(&truth)
            });
            assert!(errors[0] > errors[1] && errors[1] > errors[2] && errors[2] < 1e-9, "{word} {errors:?}");
        }
    }
}

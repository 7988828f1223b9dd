//! Suite `simulation`: a breather followed for many periods by the event-driven simulation and by general methods.

use vibrochain_breather::{Family, breathers};
use vibrochain_eventsim::{Limits, Outcome, Simulation, Time};
use vibrochain_lattice::{Chain, Model};

use crate::accuracy::meter::Meter;
use crate::accuracy::steppers::{dop853, rk4, time_stepping};
use crate::accuracy::table::{Row, Table};
use crate::accuracy::{Suite, computation};
use vibrochain_cli::common::error::CliError;
use vibrochain_cli::simulate::start::Start;

pub(super) const SUITE: Suite = Suite {
    name: "simulation",
    title: "Simulation of a breather",
    prose: "The conservative double-sided breather of the paper's defaults, started in the middle of a flight and followed \
            for 10 and for 100 periods. It is periodic: the truth at the end is the start.\n\n- *exact flight*: \
            `vibrochain-eventsim`, impacts found with bounds;\n- *DOP853*: adaptive Runge–Kutta method of order 8 (the \
            crate `ode_solvers`), Newton's method for the time of an impact;\n- *Runge–Kutta 4*: fixed step, bisection for \
            the time of an impact;\n- *time stepping*: Moreau's midpoint rule with a fixed step, no search for \
            impacts.\n\nExact flight has no step to choose and ends at rounding. Time stepping gains one digit for ten \
            times the steps.",
    error: "largest difference of a displacement or velocity from the exact motion at the end",
    run,
};

/// Fixed steps a period.
const RK4_STEPS: [u64; 6] = [16, 32, 64, 128, 512, 2048];
const MOREAU_STEPS: [u64; 5] = [32, 128, 512, 4096, 32768];
const TOLERANCES: [f64; 5] = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12];

fn run(meter: &mut Meter<'_>) -> Result<Table, CliError> {
    let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4)?;
    let orbits = breathers(&model, Family::DoubleSided).map_err(computation)?.orbits;
    let orbit = orbits.first().ok_or_else(|| computation("the paper's breather was not found"))?;
    let start = Start::on(orbit)?;
    let state: Vec<f64> = start.displacement.iter().chain(&start.velocity).copied().collect();
    let error = |end: &[f64]| state.iter().zip(end).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    let mut table = Table::default();
    // A look needs neither the longest runs nor the finest steps.
    let (lengths, fewer): (&[u64], _) = if meter.is_quick() { (&[2], 2) } else { (&[10, 100], 0) };
    for &periods in lengths {
        let case = format!("{periods} periods");
        let time = periods as f64 * model.period();
        let mut measure = |method: &str, setting: String, run: &dyn Fn() -> Result<(Vec<f64>, u64), CliError>| {
            meter.tell(&case, method, &setting);
            let ((end, impacts), seconds) = meter.time(run)?;
            let expected = 2 * periods;
            let note =
                if impacts == expected { String::new() } else { format!("{impacts} impacts instead of {expected}") };
            let (case, method) = (case.clone(), method.to_owned());
            table.rows.push(Row { case, method, setting, seconds, error: error(&end), note });
            Ok::<(), CliError>(())
        };
        measure("exact flight", "no step".to_owned(), &|| {
            let mut simulation =
                Simulation::new(&model, start.psi, &start.displacement, &start.velocity).map_err(computation)?;
            let report = simulation.run(&Limits::until(Time::new(&model, periods, 0.0)), |_| {});
            if report.outcome != Outcome::TimeReached {
                return Err(computation(format!("the simulation ended early: {:?}", report.outcome)));
            }
            let end = simulation.state();
            Ok((end.displacement.into_iter().chain(end.velocity).collect(), report.work.impacts))
        })?;
        for tolerance in &TOLERANCES[..TOLERANCES.len() - fewer] {
            measure("DOP853", format!("tolerance {tolerance:e}"), &|| {
                let run = dop853(&model, &state, time, *tolerance).map_err(computation)?;
                Ok((run.state, run.impacts))
            })?;
        }
        for steps in &RK4_STEPS[..RK4_STEPS.len() - fewer] {
            measure("Runge–Kutta 4", format!("{steps} steps a period"), &|| {
                let run = rk4(&model, &state, time, steps * periods);
                Ok((run.state, run.impacts))
            })?;
        }
        for steps in &MOREAU_STEPS[..MOREAU_STEPS.len() - fewer] {
            measure("time stepping", format!("{steps} steps a period"), &|| {
                let run = time_stepping(&model, &state, time, steps * periods);
                Ok((run.state, run.impacts))
            })?;
        }
    }
    Ok(table)
}

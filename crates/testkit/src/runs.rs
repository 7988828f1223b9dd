//! Whether a simulated run goes along an orbit.

use vibrochain_breather::{ContactMotion, Orbit};
use vibrochain_eventsim::{Event, EventKind, Limits, Outcome, Simulation};

/// Whether a run from the middle of the first flight has the orbit's impacts for a period, and nothing else: times to 1e-8 of the period,
/// impulses to 1e-7 of their size.
pub fn run_follows(orbit: &Orbit) -> bool {
    let orbit = orbit.contacts().unwrap();
    let (model, motion) = (orbit.model(), ContactMotion::new(orbit).unwrap());
    let s = 0.5 * motion.until_next(0);
    let psi = orbit.psi().map_or(0.0, |psi| (psi + s).rem_euclid(model.period()));
    let xi = motion.modes(0, s).unwrap();
    let structure = (**model.structure()).clone();
    let Ok(mut simulation) = Simulation::of_modes(structure, model.omega(), psi, &xi) else { return false };
    let until = simulation.time_of(u64::from(orbit.force_periods()), 0.0);
    let (report, events) = simulation.collect(&Limits { until: Some(until), ..Limits::default() });
    let impacts = orbit.impacts();
    let alike = |(i, event): (usize, &Event)| {
        let impact = &impacts[(i + 1) % impacts.len()];
        let time = impact.time - s + if i + 1 >= impacts.len() { orbit.period() } else { 0.0 };
        event.kind == EventKind::Impact
            && event.contact == impact.site
            && (event.time.to_f64() - time).abs() < 1e-8 * orbit.period()
            && (event.impulse - impact.impulse).abs() < 1e-7 * impact.impulse.abs()
    };
    report.outcome == Outcome::TimeReached && events.len() == impacts.len() && events.iter().enumerate().all(alike)
}

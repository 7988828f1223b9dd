//! Curves of events of a lattice's orbits over two of its parameters: those of the lattice as a structure with contacts at the masses that hit.

use vibrochain_breather::{BranchError, Continuation, Orbit};
use vibrochain_lattice::Parameter;

use super::answer::{CurveError, EventCurve, Walk, Window};
use super::tracer::CurveRequest;
use super::way::followed;
use crate::events::Watcher;
use crate::locate::{Event, Evidence, needs_force};

/// Follows the event at `orbit` both ways through a window of two parameters. `evidence` is what shows it
/// ([`Located`](crate::Located)); `tolerance` is how far a straight line between neighbouring points may be from the curve, as a part
/// of the window's sides.
///
/// # Errors
/// [`CurveError`]. What stops the curve on its way is its end, not an error.
///
/// ```
/// use vibrochain_breather::{Family, breathers};
/// use vibrochain_floquet::{Event, Search, Window, curve, locate};
/// use vibrochain_lattice::{Parameter, Point};
/// let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
/// let model = ring.omega(1.07).asymmetry(0.8).amplitude(0.165).restitution(0.25).model()?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let found = locate(orbit, &Search::new(orbit, Event::PeriodDoubling, Parameter::Amplitude))?;
/// let window = Window { parameters: [Parameter::Amplitude, Parameter::Restitution], from: [0.1, 0.2], to: [0.3, 0.3] };
/// let doubling = curve(&found.located[0].orbit, Event::PeriodDoubling, found.located[0].evidence, &window, 1e-4)?;
/// assert!(doubling.points.len() > 10 && doubling.points.iter().all(|point| point.error < 1e-9));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn curve(
    orbit: &Orbit,
    event: Event,
    evidence: Evidence,
    window: &Window,
    tolerance: f64,
) -> Result<EventCurve, CurveError> {
    curve_along(orbit, event, evidence, &Walk::new(*window, tolerance))
}

/// The same, no farther and with no more on the way than is asked for.
///
/// # Errors
/// As [`curve`].
pub fn curve_along(orbit: &Orbit, event: Event, evidence: Evidence, walk: &Walk<'_>) -> Result<EventCurve, CurveError> {
    let &Walk { window, tolerance, special, until, ref stop } = walk;
    check(orbit, &window, tolerance)?;
    let lattice = orbit.lattice().map_err(BranchError::from)?;
    let (parameters, sides) = (window.parameters, window.sides());
    let uncoupled = (0..2).find(|&i| parameters[i] == Parameter::Gamma2 && window.from[i] == 0.0);
    let (name, window) = (orbit.family(), [window.from, window.to]);
    let asked = CurveRequest { event, evidence, name, window, tolerance, uncoupled, special, until };
    let start = orbit.followed(stop).map_err(BranchError::from)?;
    let values = parameters.map(|parameter| lattice.model().get(parameter));
    let base = Continuation::through(&start, lattice.models(&parameters, stop), &values, &sides, stop)?;
    let found = followed((base, &start), Watcher::default(), &asked);
    // On the way a failure is an end.
    stop.heard()?;
    found
}

fn check(orbit: &Orbit, window: &Window, tolerance: f64) -> Result<(), CurveError> {
    let [one, other] = window.parameters;
    if one == other {
        return Err(CurveError::Same(one));
    }
    if !(1e-12..=1e-2).contains(&tolerance) {
        return Err(CurveError::Tolerance(tolerance));
    }
    let model = orbit.lattice().map_err(BranchError::from)?.model();
    let conservative = model.is_conservative();
    for (i, parameter) in window.parameters.into_iter().enumerate() {
        let (value, from, to) = (model.get(parameter), window.from[i], window.to[i]);
        if !(from <= value && value <= to && from < to) {
            return Err(CurveError::Outside { parameter, value, from, to });
        }
        if conservative && needs_force(parameter) {
            return Err(CurveError::NoForce(parameter));
        }
    }
    Ok(())
}

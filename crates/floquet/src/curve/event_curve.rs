//! An event of orbits, followed through a window of two numbers of their model.

use vibrochain_breather::{BranchError, BreatherError, Continuation, FreeNumbers, Orbit};

use super::answer::{CurveError, EventCurve, Walk};
use super::tracer::CurveRequest;
use super::way::followed;
use crate::events::Watcher;
use crate::locate::{Event, Evidence, Located};

/// Follows the event at `orbit` both ways through a window of two numbers, from where these begin. `evidence` is what shows it
/// ([`Located`](crate::Located)).
///
/// # Errors
/// [`CurveError`]. What stops the curve on its way is its end, not an error.
///
/// ```
/// use vibrochain_breather::{Family, breathers};
/// use vibrochain_floquet::{Event, Search, Walk, Window, event_curve, locate};
/// use vibrochain_lattice::{Parameter, Point, Stop};
/// let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
/// let model = ring.omega(1.07).asymmetry(0.8).amplitude(0.165).restitution(0.25).model()?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let found = &locate(orbit, &Search::new(orbit, Event::PeriodDoubling, Parameter::Amplitude))?.located[0];
/// let numbers = found.orbit.lattice()?.numbers(&[Parameter::Amplitude, Parameter::Restitution], &Stop::default());
/// let walk = Walk::new(Window { from: [0.1, 0.2], to: [0.3, 0.3] }, 1e-4);
/// let doubling = event_curve(&found.orbit, found.event, found.evidence, &numbers, &walk)?;
/// assert!(doubling.points.len() > 10 && doubling.points.iter().all(|point| point.error < 1e-9));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn event_curve(
    orbit: &Orbit,
    event: Event,
    evidence: Evidence,
    numbers: &FreeNumbers,
    walk: &Walk<'_>,
) -> Result<EventCurve, CurveError> {
    let Walk { window, stop, .. } = walk;
    check(numbers, walk)?;
    let start = orbit.followed(stop).map_err(BranchError::from)?;
    let base = Continuation::through(&start, numbers.models.clone(), &numbers.start, &window.sides(), stop);
    let base = base.map_err(|error| match error {
        BranchError::Breather(BreatherError::LoadWithoutPhase { which }) => {
            CurveError::NoLoad(numbers.names[which].clone())
        }
        error => error.into(),
    })?;
    let uncoupled = numbers.coupling.filter(|&i| window.from[i] == 0.0);
    let asked = CurveRequest { event, evidence, name: orbit.family(), uncoupled, walk };
    let found = followed((base, &start), Watcher::default(), &asked);
    // On the way a failure is an end.
    stop.heard()?;
    found
}

/// The curves of all these events along the first of two numbers, each followed once.
///
/// # Errors
/// As [`event_curve`].
pub fn event_curves<'a>(
    located: impl IntoIterator<Item = &'a Located>,
    numbers: &FreeNumbers,
    walk: &Walk<'_>,
) -> Result<Vec<EventCurve>, CurveError> {
    let mut curves: Vec<EventCurve> = Vec::new();
    for Located { event, evidence, orbit, value, .. } in located {
        let start = std::iter::once(*value).chain(numbers.start.iter().copied().skip(1)).collect();
        let numbers = FreeNumbers { start, ..numbers.clone() };
        let known = |curve: &EventCurve| matches!(numbers.start[..], [x, y] if curve.passes(([x, y], orbit), walk));
        if !curves.iter().any(known) {
            curves.push(event_curve(orbit, *event, *evidence, &numbers, walk)?);
        }
    }
    Ok(curves)
}

fn check(numbers: &FreeNumbers, &Walk { window, tolerance, .. }: &Walk<'_>) -> Result<(), CurveError> {
    let (&[one, other], [name, other_name]) = (&numbers.start[..], &numbers.names[..]) else {
        return Err(CurveError::Numbers(numbers.start.len()));
    };
    if name == other_name {
        return Err(CurveError::Same(name.clone()));
    }
    if !(1e-12..=1e-2).contains(&tolerance) {
        return Err(CurveError::Tolerance(tolerance));
    }
    for (i, (value, name)) in [(one, name), (other, other_name)].into_iter().enumerate() {
        let (from, to) = (window.from[i], window.to[i]);
        if !(from <= value && value <= to && from < to) {
            return Err(CurveError::Outside { name: name.clone(), value, from, to });
        }
    }
    Ok(())
}

//! The curve through a start, both ways to its ends.

use vibrochain_breather::line::{Line, Step, chord_error, joined, trace};
use vibrochain_breather::{BranchError, Orbit, Surface};
use vibrochain_lattice::{Parameter, Resonance, Spectrum};

use super::answer::{CurveEnd, CurveError, CurvePoint, EventCurve, Special, SpecialPoint, Walk, Window};
use super::signal::{Blind, Sight, Signal};
use super::walk::{length, plus};
use super::walker::{Foot, Walker};
use crate::locate::{Event, Evidence};

/// Points as near as this are one.
const SAME: f64 = 1e-14;

/// Impulses this much larger or smaller than at the start, or than those of a tenth of the forcing's own speed, are on their way to
/// infinity or to 0.
const UNBOUNDED: f64 = 1e4;
const FAINT: f64 = 1e-6;
const OWN_SPEED: f64 = 0.1;

/// A curve that is lost this near to a resonance, as a part of ω, ends there.
const NEAR: f64 = 1e-3;

/// One way along the curve from its start.
struct Way<'a> {
    walker: &'a mut Walker,
    until: &'a dyn Fn([f64; 2], Option<bool>) -> bool,
    /// Along the curve at the start.
    direction: [f64; 2],
    special: Vec<(usize, Special, f64)>,
    /// How many of these were known before the last step.
    told: usize,
    /// Why the last step failed.
    why: Blind,
}

/// What a way has passed.
struct Passed {
    feet: Vec<Foot>,
    special: Vec<(usize, Special, f64)>,
    end: CurveEnd,
}

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
/// use vibrochain_lattice::{Chain, Model, Parameter};
/// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 1.07, 0.8, 0.165, 0.25)?;
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
    let (signal, mark) = Signal::of(event, evidence, orbit).ok_or(CurveError::NotThere(event))?;
    let sides = window.sides();
    let free = [0, 1].map(|i| (window.parameters[i], sides[i]));
    let sight = Sight::new(orbit.model().chain().sites(), stop);
    let surface = Surface::through(orbit, free)?.until(stop);
    let grazing = signal.grazing(orbit);
    let mut walker = Walker { surface, sight, signal, grazing, event, window, tolerance, special };
    let started = walker.start(mark);
    stop.heard()?;
    let (start, direction) = started.map_err(|blind| match blind {
        Blind::Lost(error) => CurveError::Branch(error),
        Blind::Unwatched(error) => CurveError::Floquet(error),
        Blind::Other => CurveError::NotThere(event),
    })?;
    // The other way, across is the other way, too.
    let turned = Foot { slope: -start.slope, ..start.clone() };
    let behind = walker.follow(&turned, direction.map(|x| -x), until);
    let ahead = match behind.end {
        CurveEnd::Closed => Passed { feet: vec![start.clone()], special: Vec::new(), end: CurveEnd::Closed },
        _ => walker.follow(&start, direction, until),
    };
    let curve = walker.joined(evidence, behind, ahead);
    // On the way a failure is an end.
    stop.heard()?;
    Ok(curve)
}

fn check(orbit: &Orbit, window: &Window, tolerance: f64) -> Result<(), CurveError> {
    let [one, other] = window.parameters;
    if one == other {
        return Err(CurveError::Same(one));
    }
    if !(1e-12..=1e-2).contains(&tolerance) {
        return Err(CurveError::Tolerance(tolerance));
    }
    let conservative = orbit.model().is_conservative();
    for (i, parameter) in window.parameters.into_iter().enumerate() {
        let (value, from, to) = (orbit.model().get(parameter), window.from[i], window.to[i]);
        if !(from <= value && value <= to && from < to) {
            return Err(CurveError::Outside { parameter, value, from, to });
        }
        if conservative && matches!(parameter, Parameter::Amplitude | Parameter::Restitution) {
            return Err(CurveError::NoForce(parameter));
        }
    }
    Ok(())
}

impl Walker {
    /// Follows the curve in one direction to its end.
    fn follow(&mut self, start: &Foot, direction: [f64; 2], until: &dyn Fn([f64; 2], Option<bool>) -> bool) -> Passed {
        let tolerance = self.tolerance;
        let mut way = Way { walker: self, until, direction, special: Vec::new(), told: 0, why: Blind::Other };
        let (feet, end) = trace(&mut way, start.clone(), tolerance);
        Passed { feet, special: way.special, end }
    }

    /// Whether the curve is back where it began, between two feet.
    fn passes(&self, start: &Foot, from: &Foot, to: &Foot) -> bool {
        let step = self.surface.between(&from.point, &to.point);
        let back = self.surface.between(&from.point, &start.point);
        let share = (back[0] * step[0] + back[1] * step[1]) / (step[0] * step[0] + step[1] * step[1]);
        let aside = length(plus(back, step, -share));
        (0.0..=1.0).contains(&share)
            && aside <= 0.2 * length(step)
            && self.surface.distance(&from.point, &start.point) <= 1.5 * length(step)
    }

    /// One curve of two ways from its start.
    fn joined(mut self, evidence: Evidence, behind: Passed, ahead: Passed) -> EventCurve {
        let closed = behind.end == CurveEnd::Closed;
        let count = behind.feet.len();
        let turned = |(place, kind, error): (usize, Special, f64)| (count - 1 - place, kind, error);
        let mut special: Vec<(usize, Special, f64)> = behind.special.into_iter().rev().map(turned).collect();
        special.extend(ahead.special.into_iter().map(|(place, kind, error)| (count - 1 + place, kind, error)));
        let feet = joined(behind.feet, ahead.feet);
        let errors = self.errors(&feet);
        let points: Vec<CurvePoint> =
            feet.iter().zip(&errors).map(|(foot, error)| self.described(foot, *error)).collect();
        let named = |(point, special, error): (usize, Special, f64)| SpecialPoint {
            special,
            point,
            values: points[point].values,
            error,
        };
        let special = special.into_iter().map(named).collect();
        let ends = if closed { [CurveEnd::Closed, CurveEnd::Closed] } else { [behind.end, ahead.end] };
        let evaluations = self.surface.evaluations();
        EventCurve { event: self.event, evidence, points, special, ends, evaluations, spectra: self.sight.spectra }
    }

    fn described(&mut self, foot: &Foot, error: f64) -> CurvePoint {
        let angle = self.signal.has_angle().then(|| foot.mark.clamp(-1.0, 1.0).acos() / std::f64::consts::PI);
        let (values, orbit) = (foot.point.values(), foot.point.orbit().clone());
        CurvePoint { values, error, orbit, angle, physical: foot.aspects.physical }
    }
}

impl Line for Way<'_> {
    type Point = Foot;
    type End = CurveEnd;
    const CLOSED: CurveEnd = CurveEnd::Closed;
    const LONG: CurveEnd = CurveEnd::Long;

    fn ahead(&mut self, feet: &[Foot], length: f64) -> Option<Step<Foot, CurveEnd>> {
        let (walker, direction, last) = (&mut *self.walker, self.direction, feet.last()?);
        let (far, _) = walker.ahead(feet, direction, length);
        self.why = Blind::Other;
        if walker.is_inside(plus(walker.plane(&last.point), last.point.heading(far), 1.0)) {
            match walker.advance(feet, direction, length) {
                Ok(next) if walker.is_inside(walker.plane(&next.point)) => return Some(Step::On(next)),
                Ok(_) => {}
                Err(blind) => {
                    self.why = blind;
                    return None;
                }
            }
        }
        walker.edge(feet, direction, length).map(|(foot, end)| Step::Out(Some(foot), end))
    }

    fn bend(&self, feet: [&Foot; 3]) -> f64 {
        let [a, b, c] = feet.map(|foot| foot.at);
        chord_error(feet.map(|foot| self.walker.plane(&foot.point)), [b - a, c - b])
    }

    fn closed(&mut self, feet: &[Foot], next: &Foot) -> Option<Foot> {
        let closed = feet.len() > 3 && self.walker.passes(&feet[0], &feet[feet.len() - 1], next);
        closed.then(|| Foot { at: next.at, ..feet[0].clone() })
    }

    fn pass(&mut self, feet: &mut Vec<Foot>, next: Foot) {
        self.told = self.special.len();
        for (kind, foot, error) in self.walker.between(feet, self.direction, &next) {
            // Those at one place are all told of that place.
            if feet.last().is_some_and(|last| foot.at - last.at > SAME) {
                feet.push(foot);
            }
            self.special.push((feet.len() - 1, kind, error));
        }
        if feet.last().is_some_and(|last| next.at - last.at > SAME) {
            feet.push(next);
        }
    }

    fn ended(&mut self, feet: &mut Vec<Foot>) -> Option<CurveEnd> {
        let last = feet.last()?;
        if last.aspects.ends {
            let real = |(_, one, _): &&(usize, Special, f64)| matches!(one, Special::OneToOne | Special::OneToTwo);
            let passed = self.special[self.told..].iter().rfind(real).map(|&(place, special, _)| (place, special));
            // Where rounding hides the place itself the curve ends beside it.
            let other = if last.mark > 0.0 { Special::OneToOne } else { Special::OneToTwo };
            let (place, kind) = passed.unwrap_or((feet.len().saturating_sub(2), other));
            feet.truncate(place + 1);
            self.special.retain(|(other, ..)| *other <= place);
            return Some(CurveEnd::Special(kind));
        }
        if (self.until)(last.point.values(), last.aspects.physical) {
            return Some(CurveEnd::Halted);
        }
        let first = feet[0].point.orbit();
        let scale = first.strength().max(OWN_SPEED * first.model().omega());
        // On a curve along which all impulses vanish, the first point's are rounding.
        let vanish = first.strength() < FAINT * scale;
        match last.point.orbit().strength() / scale {
            UNBOUNDED.. => Some(CurveEnd::Unbounded),
            ..FAINT if !vanish => Some(CurveEnd::ImpulsesVanish),
            _ => None,
        }
    }

    fn lost(&self, feet: &[Foot]) -> CurveEnd {
        let orbit = feet[feet.len() - 1].point.orbit();
        if let Some(resonance) = resonance(orbit) {
            return CurveEnd::Resonance(resonance);
        }
        match self.why.clone() {
            Blind::Other if orbit.model().loss() == 0.0 && self.walker.signal.is_spectral() => CurveEnd::Thin,
            Blind::Lost(error) => CurveEnd::Lost(error),
            Blind::Unwatched(error) => CurveEnd::Unwatched(error),
            Blind::Other => CurveEnd::Lost(BranchError::NoConvergence),
        }
    }
}

/// The resonance that an orbit stands next to.
fn resonance(orbit: &Orbit) -> Option<Resonance> {
    let (spectrum, omega) = (Spectrum::new(*orbit.model().chain()), orbit.frequency());
    let near = |(mode, &frequency): (usize, &f64)| {
        let harmonic = (frequency / omega).round();
        let distance = (-harmonic).mul_add(omega, frequency);
        (harmonic >= 1.0 && distance.abs() <= NEAR * omega).then_some(Resonance {
            harmonic: harmonic as u64,
            mode,
            frequency,
            omega,
            distance,
        })
    };
    let all = spectrum.frequencies().iter().enumerate().filter_map(near);
    all.min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()))
}

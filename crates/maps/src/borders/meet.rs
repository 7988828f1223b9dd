//! A change between two places, enclosed, and the events that make it.

use vibrochain_floquet::{Course, End, Event, Located, diagram_until};
use vibrochain_lattice::Spectrum;

use super::border::BorderKind;
use super::part::{ClassProbe, Part};
use crate::cell::Class;

/// How near a change is enclosed before its event is looked for, as a part of the window's side.
const ENCLOSED: f64 = 1e-7;

/// How far the event is looked for on either side.
const BESIDE: f64 = 1e-4;

/// From how far an orbit is followed to it, where nothing else changes in between.
const BACK: f64 = 2e-5;

/// How near a change in a face is enclosed, and how far from there it is looked for along one parameter.
const NEAR: f64 = 1e-9;
const FAR: f64 = 1e-3;

/// What is found of a change.
#[derive(Debug, Clone)]
pub(super) struct Met {
    /// Two places next to it.
    pub(super) ends: [[f64; 2]; 2],
    /// The events that happen there.
    pub(super) events: Vec<Located>,
    /// A border that is known passes there.
    pub(super) known: bool,
    /// Mode and harmonic of the resonance between the two places.
    pub(super) resonance: Option<(usize, f64)>,
    /// What else may make it, if a branch ends there.
    pub(super) end: BorderKind,
}

/// Halves until two places where what lives there differs are as near as `near`: the last place where it is what lives at the first,
/// and the first behind it where something else that is known lives.
pub(super) fn enclose<C: Copy + PartialEq>(
    class: &mut impl FnMut([f64; 2]) -> Option<C>,
    ends: [[f64; 2]; 2],
    near: f64,
) -> Option<([[f64; 2]; 2], [C; 2])> {
    let place = |share: f64| [0, 1].map(|i| ends[0][i] + share * (ends[1][i] - ends[0][i]));
    let length = (ends[1][0] - ends[0][0]).hypot(ends[1][1] - ends[0][1]);
    let (first, last) = (class(ends[0])?, class(ends[1])?);
    if first == last {
        return None;
    }
    let (mut low, mut high, mut beyond) = (0.0, 1.0, Some(last));
    while (high - low) * length > near {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        match class(place(middle)) {
            Some(one) if one == first => low = middle,
            other => (high, beyond) = (middle, other),
        }
    }
    let beyond = match beyond {
        Some(one) => one,
        None => {
            // Out of what is not known, to where something is.
            let (mut dark, mut light, mut seen) = (high, 1.0, last);
            while (light - dark) * length > near {
                let middle = 0.5 * (dark + light);
                if middle <= dark || middle >= light {
                    break;
                }
                match class(place(middle)) {
                    Some(one) => (light, seen) = (middle, one),
                    None => dark = middle,
                }
            }
            high = light;
            seen
        }
    };
    (beyond != first).then(|| ([place(low), place(high)], [first, beyond]))
}

/// How far a mode's frequency is above a harmonic of the orbits', which is ω over so many periods of the force.
pub(super) fn detuning(probe: &ClassProbe<'_>, (mode, multiple): (usize, f64), place: [f64; 2]) -> Option<f64> {
    let model = probe.model(place)?;
    let frequency = *Spectrum::new(*model.chain()).frequencies().get(mode)?;
    Some((-multiple).mul_add(model.omega(), frequency))
}

/// The mode and the harmonic that are equal somewhere between two places.
fn resonance(probe: &ClassProbe<'_>, ends: [[f64; 2]; 2]) -> Option<(usize, f64)> {
    let one = probe.model(ends[0])?;
    let frequencies = Spectrum::new(*one.chain());
    let mut places = frequencies.frequencies().iter().enumerate();
    places.find_map(|(mode, frequency)| {
        let multiple = (frequency / one.omega()).round();
        let there = detuning(probe, (mode, multiple), ends[1])?;
        let here = (-multiple).mul_add(one.omega(), *frequency);
        (multiple >= 1.0 && here * there <= 0.0).then_some((mode, multiple))
    })
}

/// Looks for the events that make a change.
pub(super) fn meet(
    probe: &mut ClassProbe<'_>,
    part: &Part,
    (axis, ends): (usize, [[f64; 2]; 2]),
    is_known: impl Fn([f64; 2]) -> bool,
) -> Option<Met> {
    let (ends, classes) = enclose(&mut |place| probe.class(part, place), ends, ENCLOSED)?;
    let mut met = Met { ends, events: Vec::new(), known: is_known(ends[0]), resonance: None, end: BorderKind::Change };
    if met.known {
        return Some(met);
    }
    if part.task.stability && !part.is_strict() && !classes.contains(&Class::None) {
        met.end = BorderKind::Threshold;
        return Some(met);
    }
    met.resonance = resonance(probe, ends);
    if met.resonance.is_some() {
        met.end = BorderKind::Resonance;
        return Some(met);
    }
    let parameter = probe.scene.axes[axis].parameter;
    let value = |part_along: f64, probe: &ClassProbe<'_>| {
        let mut place = ends[0];
        place[axis] = part_along.clamp(0.0, 1.0);
        probe.window.point(place)[axis]
    };
    let parts = [ends[0][axis].min(ends[1][axis]), ends[0][axis].max(ends[1][axis])];
    let [from, to] = [value(parts[0] - BESIDE, probe), value(parts[1] + BESIDE, probe)];
    let slack = [value(parts[0] - 2.0 * ENCLOSED, probe), value(parts[1] + 2.0 * ENCLOSED, probe)];
    let events =
        if part.task.stability { Event::ALL.to_vec() } else { vec![Event::Grazing, Event::Pitchfork, Event::Fold] };
    for side in 0..2 {
        // A little away from the change Newton's method has an easier start.
        let mut start = ends[side];
        let away = if ends[side][axis] < ends[1 - side][axis] { -BACK } else { BACK };
        start[axis] = (start[axis] + away).clamp(0.0, 1.0);
        if probe.class(part, start) != Some(classes[side]) {
            start = ends[side];
        }
        for orbit in probe.orbits(part, start) {
            let course = Course { from, to, events: events.clone(), ..Course::new(&orbit, parameter) };
            let Ok(diagram) = diagram_until(&orbit, &course, probe.stop()) else { continue };
            for branch in &diagram.branches {
                let here = |value: f64| slack[0] <= value && value <= slack[1];
                for located in branch.events().filter(|located| here(located.value)) {
                    let known = |other: &Located| other.event == located.event && other.evidence == located.evidence;
                    if !met.events.iter().any(known) {
                        met.events.push(located.clone());
                    }
                }
                for (value, end) in &branch.ends {
                    let kind = match end {
                        End::Resonance(_) => BorderKind::Resonance,
                        End::Unbounded => BorderKind::Unbounded,
                        End::ImpulsesVanish => BorderKind::ImpulsesVanish,
                        _ => continue,
                    };
                    if from < *value && *value < to {
                        met.end = kind;
                    }
                }
            }
        }
        if !met.events.is_empty() {
            break;
        }
    }
    Some(met)
}

/// Two places along one parameter between which the same changes as between two others.
pub(super) fn along_one(
    probe: &mut ClassProbe<'_>,
    part: &Part,
    ends: [[f64; 2]; 2],
) -> Option<(usize, [[f64; 2]; 2])> {
    let (close, _) = enclose(&mut |place| probe.class(part, place), ends, NEAR)?;
    let middle = [0, 1].map(|i| 0.5 * (close[0][i] + close[1][i]));
    let mut aside = NEAR;
    while aside < FAR {
        for axis in 0..2 {
            let mut ends = [middle; 2];
            ends[0][axis] = (middle[axis] - aside).max(0.0);
            ends[1][axis] = (middle[axis] + aside).min(1.0);
            if let [Some(one), Some(other)] = ends.map(|place| probe.class(part, place))
                && one != other
            {
                return Some((axis, ends));
            }
        }
        aside *= 4.0;
    }
    None
}

//! The motion of an orbit from its impacts: the modes at the start of every interval between them.

use vibrochain_lattice::simd::lanes::{LANES, groups};
use vibrochain_lattice::{ImpulseResponse, Shapes};

use super::Motion;
use super::dying::DyingModes;
use crate::orbit::{Hit, LatticeOrbit};

/// The most numbers of a table of shapes: those of 128 modes at as many places.
const TABLE: usize = 128 * 128;

fn net_impulses(orbit: LatticeOrbit<'_>) -> impl Iterator<Item = f64> {
    orbit.sources().iter().map(|source| source.net_impulse)
}

/// The modes of a lattice, as impulses that repeat every period move them.
enum Modes<'a> {
    /// Those that nothing damps.
    Free(&'a ImpulseResponse),
    /// Those of a lattice with dashpots.
    Dying(Box<DyingModes>),
}

impl Modes<'_> {
    fn frequencies(&self) -> &[f64] {
        match self {
            Self::Free(response) => response.frequencies(),
            Self::Dying(modes) => modes.frequencies(),
        }
    }

    /// The factor of each mode in the impulse response.
    fn weights(&self) -> &[f64] {
        match self {
            Self::Free(response) => response.weights(),
            Self::Dying(modes) => modes.weights(),
        }
    }

    /// Adds states for one source, without the factors: at rest where the mean force of its impulses holds each mode. With dashpots they are 0, as
    /// [`Self::add_response`] has that part, too.
    fn begin(&self, states: &mut Vec<(f64, f64)>, net: f64) {
        match self {
            Self::Free(response) => states.extend(response.statics().iter().map(|part| (net * part, 0.0))),
            Self::Dying(modes) => states.extend(modes.weights().iter().map(|_| (0.0, 0.0))),
        }
    }

    /// Adds what an impulse does to all modes, without the factors, some time after it.
    fn add_response(&self, states: &mut [(f64, f64)], impulse: f64, elapsed: f64) {
        match self {
            Self::Free(response) => add_response(states, response, impulse, elapsed),
            Self::Dying(modes) => modes.add_response(states, impulse, elapsed),
        }
    }

    /// Whether the orbit itself tells where the uniform mode stands: its impulses do not.
    fn are_adrift(&self, orbit: LatticeOrbit<'_>) -> bool {
        match self {
            Self::Free(_) => !orbit.model().chain().has_walls(),
            Self::Dying(_) => true,
        }
    }
}

/// The period that an impulse response repeats by.
fn period(orbit: LatticeOrbit<'_>, response: Option<&ImpulseResponse>) -> f64 {
    response.map_or_else(|| orbit.period(), ImpulseResponse::period)
}

impl Motion {
    /// Takes over another orbit; `response` must be of its chain and frequency, and `None` of a lattice with dashpots.
    pub(crate) fn load(&mut self, orbit: LatticeOrbit<'_>, response: Option<&ImpulseResponse>) {
        if self.is_of(orbit, response) {
            // An orbit just found is there already.
            return;
        }
        let (model, period) = (orbit.model(), period(orbit, response));
        let modes = match response {
            Some(response) => Modes::Free(response),
            None => {
                let mut modes = self.dying.take().unwrap_or_else(|| Box::new(DyingModes::new(model, period)));
                modes.reset(model, period);
                Modes::Dying(modes)
            }
        };
        let shapes = || response.map_or_else(|| Shapes::new(model.chain()), |response| response.shapes().clone());
        self.begin(orbit, shapes, modes.frequencies());
        self.period = period;
        self.decays.clear();
        if let Modes::Dying(modes) = &modes {
            self.decays.extend_from_slice(&modes.decays);
        }
        self.set_states(orbit, &modes);
        self.now.resize(self.sites.len() * self.frequencies.len(), [0.0; 3]);
        if let Modes::Dying(modes) = modes {
            self.dying = Some(modes);
        }
    }

    /// The modes at the start of every interval.
    fn set_states(&mut self, orbit: LatticeOrbit<'_>, modes: &Modes<'_>) {
        let (weights, adrift) = (modes.weights(), modes.are_adrift(orbit));
        self.states.clear();
        for (i, &start) in self.starts.iter().enumerate() {
            if i > 0 && start == self.starts[i - 1] {
                // Nothing moves between impacts of one instant.
                self.states.extend_from_within(self.states.len() - orbit.sources().len() * weights.len()..);
                continue;
            }
            for (s, source) in orbit.sources().iter().enumerate() {
                let (from, net) = (self.states.len(), source.net_impulse);
                // The place of the uniform mode is common to all sources; the first one carries it. Its shape is 1.
                let held = adrift.then_some(if s == 0 { orbit.uniform_offset() } else { 0.0 });
                if let Modes::Free(response) = modes
                    && let Some(parts) = at_instants(orbit, response, start)
                {
                    add_states(&mut self.states, response, (net, held), parts);
                    continue;
                }
                modes.begin(&mut self.states, net);
                let states = &mut self.states[from..];
                if let Some(held) = held {
                    states[0].0 = held / weights[0];
                }
                for impact in orbit.impacts().iter().filter(|impact| impact.site == source.site) {
                    let elapsed = start - impact.time;
                    modes.add_response(
                        states,
                        impact.impulse,
                        if elapsed < 0.0 { elapsed + self.period } else { elapsed },
                    );
                }
                for ((q, p), weight) in states.iter_mut().zip(weights) {
                    (*q, *p) = (weight * *q, weight * *p);
                }
            }
        }
    }

    /// Takes over all but what modes do.
    fn begin(&mut self, orbit: LatticeOrbit<'_>, shapes: impl FnOnce() -> Shapes, frequencies: &[f64]) {
        let model = orbit.model();
        (self.origin.uniform_offset, self.origin.dashpots) = (orbit.uniform_offset(), model.dashpots());
        self.origin.impacts.clear();
        self.origin.impacts.extend(orbit.impacts().iter().map(Hit::from));
        self.origin.net_impulses.clear();
        self.origin.net_impulses.extend(net_impulses(orbit));
        if !self.shapes.are_of(model.chain()) {
            self.shapes = shapes();
            self.table.clear();
        }
        self.set_table(orbit, frequencies.len());
        self.frequencies.clear();
        self.frequencies.extend_from_slice(frequencies);
        (self.psi, self.steady, self.force) = (orbit.psi_or_zero(), *orbit.steady(), model.force_wave());
        self.chain = *model.chain();
        self.sites.clear();
        self.sites.extend(orbit.sources().iter().map(|source| source.site));
        self.starts.clear();
        self.starts.extend(orbit.impacts().iter().map(|impact| impact.time));
    }

    /// Holds this orbit already.
    pub(crate) fn is_of(&self, orbit: LatticeOrbit<'_>, response: Option<&ImpulseResponse>) -> bool {
        self.period == period(orbit, response)
            && self.origin.dashpots == orbit.model().dashpots()
            && self.psi == orbit.psi_or_zero()
            && self.origin.uniform_offset == orbit.uniform_offset()
            && self.origin.impacts.iter().copied().eq(orbit.impacts().iter().map(Hit::from))
            && self.origin.net_impulses.iter().copied().eq(net_impulses(orbit))
            && self.chain == *orbit.model().chain()
            && self.steady == *orbit.steady()
    }

    /// Exchanges the modes of the lattice with dashpots with another motion. The orbits stay where they are.
    pub(crate) fn take_modes(&mut self, other: &mut Self) {
        std::mem::swap(&mut self.dying, &mut other.dying);
    }

    fn set_table(&mut self, orbit: LatticeOrbit<'_>, modes: usize) {
        let centred = orbit.centre().is_some();
        let sources = orbit.sources().iter().map(|source| if centred { 0 } else { source.site });
        let places = if centred { modes } else { self.shapes.sites() };
        if !self.table.is_empty() && self.table_of.1 == places && self.table_of.0.iter().copied().eq(sources.clone()) {
            return;
        }
        self.table.clear();
        self.table_of = (sources.collect(), places);
        let (rows, groups) = (self.table_of.0.len() * modes, groups(places));
        if rows.saturating_mul(groups * LANES) > TABLE {
            return;
        }
        self.table.resize(rows * groups, [0.0; LANES]);
        for (row, shapes) in self.table.chunks_exact_mut(groups).enumerate() {
            let (k, source) = (row % modes, self.table_of.0[row / modes]);
            let places = shapes.as_flattened_mut().iter_mut().enumerate().take(places);
            places.for_each(|(n, shape)| *shape = self.shapes.even(k, n, source));
        }
    }
}

/// An impulse, and what one of size 1 does to each mode's displacement and to its velocity.
#[derive(Clone, Copy)]
struct Part<'a> {
    impulse: f64,
    moved: &'a [f64],
    jump: f64,
}

/// What the impacts of an orbit of one site have done at the time `start`, if each was then, or half a period before.
fn at_instants<'a>(orbit: LatticeOrbit<'_>, response: &'a ImpulseResponse, start: f64) -> Option<[Part<'a>; 2]> {
    let part = |time: f64, impulse: f64| {
        let elapsed = if start < time { start - time + response.period() } else { start - time };
        if elapsed == 0.0 {
            // Just after the impact the velocity is half the jump above its mean.
            Some(Part { impulse, moved: response.at_impulse(), jump: 0.5 })
        } else if elapsed == 0.5 * response.period() {
            // The slope of an even function.
            Some(Part { impulse, moved: response.at_half(), jump: 0.0 })
        } else {
            None
        }
    };
    match orbit.impacts() {
        [one] => Some([part(one.time, one.impulse)?, Part { impulse: 0.0, moved: response.at_half(), jump: 0.0 }]),
        [one, other] if one.site == other.site => {
            Some([part(one.time, one.impulse)?, part(other.time, other.impulse)?])
        }
        _ => None,
    }
}

/// Adds the states of all modes, weights included, from two impulses and what their net impulse holds up; of a uniform mode this is
/// given.
fn add_states(
    states: &mut Vec<(f64, f64)>,
    response: &ImpulseResponse,
    (net, held): (f64, Option<f64>),
    [one, other]: [Part<'_>; 2],
) {
    let speed = one.impulse * one.jump + other.impulse * other.jump;
    let modes = response.weights().iter().zip(response.statics()).zip(one.moved.iter().zip(other.moved));
    let from = states.len();
    states.extend(modes.map(|((weight, still), (by_one, by_other))| {
        (weight * (net * still + one.impulse * by_one + other.impulse * by_other), weight * speed)
    }));
    if let (Some(held), Some(first), Some(weight)) = (held, states.get_mut(from), response.weights().first()) {
        first.0 = weight * (held / weight + one.impulse * one.moved[0] + other.impulse * other.moved[0]);
    }
}

/// Adds what an impulse does to all modes, weights apart, some time after it.
fn add_response(states: &mut [(f64, f64)], response: &ImpulseResponse, impulse: f64, elapsed: f64) {
    if elapsed == 0.0 {
        for ((q, p), dynamic) in states.iter_mut().zip(response.at_impulse()) {
            *q += impulse * dynamic;
            // Just after the impact the velocity is half the jump above its mean.
            *p += impulse * 0.5;
        }
    } else if elapsed == 0.5 * response.period() {
        // The slope of an even function.
        states.iter_mut().zip(response.at_half()).for_each(|((q, _), dynamic)| *q += impulse * dynamic);
    } else {
        for (k, (q, p)) in states.iter_mut().enumerate() {
            *q += impulse * response.mode_dynamic(k, elapsed);
            *p += impulse * response.mode_slope(k, elapsed);
        }
    }
}

//! Tangent vectors on a run: carried from event to event, and changed there as small perturbations are ([`crate::tangent`]).

use crate::cascade::Change;
use crate::error::TangentError;
use crate::event::EventKind;
use crate::flight::Flight;
use crate::flight::modal_flight::ModalFlight;
use crate::flight::places::{Place, Places};
use crate::flight::rest_series::Series;
use crate::motion::Motion;
use crate::tangent::Tangents;
use crate::watch::Contact;
use vibrochain_lattice::Barrier;

/// An impulse that another contact sees by less than this part of its terms is rounding.
const UNSEEN: f64 = 1e-12;

/// What small perturbations learn of a run under way.
pub(crate) trait Perturbations {
    /// The run stands just before impacts at `now` since its base.
    fn arrive(&mut self, motion: &Motion, now: f64);

    /// They have been applied.
    fn meet(&mut self, motion: &Motion, changes: &[Change]);
}

/// There are none.
pub(crate) struct WithoutTangents;

impl Perturbations for WithoutTangents {
    fn arrive(&mut self, _: &Motion, _: f64) {}

    fn meet(&mut self, _: &Motion, _: &[Change]) {}
}

/// Tangent vectors on a run.
pub(crate) struct WithTangents<'a> {
    tangents: &'a mut Tangents,
    /// The clock at the instant of the vectors.
    at: (u64, f64),
    /// Contacts at rest since then.
    resting: Vec<usize>,
    /// Accelerations of the contacts that are due, and forces on all that rest, before their impacts.
    before: Vec<(usize, f64)>,
    forces: Vec<f64>,
}

impl<'a> WithTangents<'a> {
    /// On a run that is at `now` since its base.
    ///
    /// # Errors
    /// [`TangentError::OtherModel`].
    pub(crate) fn new(tangents: &'a mut Tangents, motion: &Motion, now: f64) -> Result<Self, TangentError> {
        if !tangents.system.is_alike(&motion.system) {
            return Err(TangentError::OtherModel);
        }
        let (at, resting) = (motion.clock.after(now), motion.places.resting().to_vec());
        let mut mounted = Self { tangents, at, resting, before: Vec::new(), forces: Vec::new() };
        mounted.hold();
        Ok(mounted)
    }

    /// Carries the vectors to `now` since the base.
    pub(crate) fn fly_to(&mut self, motion: &Motion, now: f64) {
        let left = now - motion.clock.until(self.at.0, self.at.1);
        self.at = motion.clock.after(now);
        if left <= 0.0 {
            return;
        }
        if let Tangents { flight: Some(flight), directions, .. } = &mut *self.tangents {
            for [place, velocity] in &mut directions.vectors {
                flight.drift([place, velocity], left, &self.resting);
            }
            return;
        }
        let held = |contact: usize| {
            let is_resting = self.resting.contains(&contact);
            // Which of its barriers says nothing of a motion without loads.
            let touch = if is_resting { Contact::Resting(Barrier::Upper) } else { Contact::Free };
            Place { touch, ..Place::free(0.0) }
        };
        let places = Places::of((0..motion.places.len()).map(held));
        let is_held = !self.resting.is_empty();
        self.tangents.each(|system, flight| {
            if !is_held {
                flight.xi = flight.all_at(system, left);
                return;
            }
            let mut rest = left;
            while rest > 0.0 {
                let series = Series::window(system, flight, &places);
                let step = rest.min(series.length);
                let xi = (0..flight.xi.len()).map(|k| series.mode(k, step / series.length)).collect();
                *flight = ModalFlight::new(system, xi, 0.0);
                rest -= step;
            }
        });
        self.hold();
    }

    /// Contacts at rest have no perturbation: what rounding leaves of one is taken off.
    fn hold(&mut self) {
        if self.resting.is_empty() {
            return;
        }
        if self.tangents.flight.is_some() {
            for part in self.tangents.directions.vectors.iter_mut().flatten() {
                self.resting.iter().for_each(|contact| part[*contact] = 0.0);
            }
            return;
        }
        let resting = std::mem::take(&mut self.resting);
        self.tangents.each(|system, flight| {
            let off = |of: &dyn Fn(usize) -> f64| resting.iter().map(|&contact| -of(contact)).collect::<Vec<_>>();
            let places = system.impulses(&resting, &off(&|contact| flight.place(system, contact)));
            for (&contact, amount) in resting.iter().zip(places) {
                flight.shift(system, contact, amount);
            }
            let velocities = system.impulses(&resting, &off(&|contact| flight.velocity(system, contact)));
            for (&contact, impulse) in resting.iter().zip(velocities) {
                flight.strike(system, contact, impulse);
            }
        });
        self.resting = resting;
    }

    /// Whether the place, the velocity or the acceleration of one contact changes with an impulse at another.
    fn sees(&self, to: usize, from: usize) -> bool {
        if let Some(flight) = &self.tangents.flight {
            return to == from || flight.local.operator.beside(to).contains(&from);
        }
        let (mut sums, mut sizes) = ([0.0; 2], [0.0; 2]);
        for mode in self.tangents.system.modes() {
            let (row, a) = (mode.rows[to], mode.generator());
            let once = mode.turn.act(a, mode.columns[from]);
            for (i, given) in [once, mode.turn.act(a, once)].into_iter().enumerate() {
                let terms = [row[0] * given[0], row[1] * given[1]];
                sums[i] += terms[0] + terms[1];
                sizes[i] += terms[0].abs() + terms[1].abs();
            }
        }
        (0..2).any(|i| sums[i].abs() > UNSEEN * sizes[i])
    }
}

impl Perturbations for WithTangents<'_> {
    fn arrive(&mut self, motion: &Motion, now: f64) {
        self.fly_to(motion, now);
        self.before.clear();
        let due = motion.due.iter().filter(|due| !due.release);
        if motion.system.is_direct() || matches!(motion.flight, Flight::Local(_)) && motion.places.resting().is_empty()
        {
            self.before.extend(due.map(|due| (due.contact, motion.bends(due.contact)[0])));
            return;
        }
        self.forces = vec![0.0; motion.places.len()];
        // One that comes back to where it was let go is not leaving any more: its acceleration is what it is.
        let arrived = |place: &Place| match place.touch {
            Contact::Resting(_) => *place,
            _ => Place { touch: Contact::Free, ..*place },
        };
        let tendencies = motion.flight.tendencies(&motion.system, &Places::of(motion.places.iter().map(arrived)));
        self.before.extend(due.map(|due| (due.contact, tendencies.bends(due.contact)[0])));
        let resting = motion.places.resting().iter();
        resting.for_each(|contact| self.forces[*contact] = tendencies.force(*contact));
    }

    fn meet(&mut self, motion: &Motion, changes: &[Change]) {
        let hits: Vec<&Change> = changes.iter().filter(|change| change.kind == EventKind::Impact).collect();
        let released = changes.iter().filter(|change| change.kind == EventKind::Release);
        let released: Vec<usize> = released.map(|change| change.contact).collect();
        // Of several impacts nobody says which one has released it.
        if hits.len() > 1 && !released.is_empty() {
            self.tangents.directions.grazed = true;
        }
        for (i, hit) in hits.iter().enumerate() {
            let together = hits[..i].iter().any(|other| {
                other.contact == hit.contact
                    || self.sees(hit.contact, other.contact)
                    || self.sees(other.contact, hit.contact)
            });
            if hit.before == 0.0 || together {
                self.tangents.directions.grazed = true;
                continue;
            }
            let before = self.before.iter().find(|(contact, _)| *contact == hit.contact);
            let acceleration = before.map_or(0.0, |(_, acceleration)| *acceleration);
            let restitution = motion.system.restitution(hit.contact);
            if let Tangents { flight: Some(flight), directions, .. } = &mut *self.tangents {
                let kick = (1.0 + restitution) * acceleration / (hit.before * flight.local.scale);
                let operator = &flight.local.operator;
                let felt = if operator.is_damped() { operator.beside(hit.contact) } else { Vec::new() };
                for [place, velocity] in &mut directions.vectors {
                    let given = hit.impulse * place[hit.contact] / (hit.before * operator.masses[hit.contact]);
                    velocity[hit.contact] = kick * place[hit.contact] - restitution * velocity[hit.contact];
                    place[hit.contact] *= -restitution;
                    for &n in &felt {
                        let jump = operator.pull(n, true, |m| if m == hit.contact { given } else { 0.0 });
                        velocity[n] -= jump / flight.local.scale;
                    }
                }
                continue;
            }
            let forces = &self.forces;
            self.tangents.each(|system, flight| {
                let (place, velocity) = (flight.place(system, hit.contact), flight.velocity(system, hit.contact));
                let earlier = place / hit.before;
                let change = (1.0 + restitution) * (acceleration * earlier - velocity);
                flight.strike(system, hit.contact, system.impulse(hit.contact, change));
                flight.shift(system, hit.contact, hit.impulse * earlier);
                for &contact in &released {
                    flight.strike(system, contact, -forces[contact] * earlier);
                }
            });
        }
        self.resting.clear();
        self.resting.extend_from_slice(motion.places.resting());
        self.hold();
        self.tangents.directions.keep_apart();
    }
}

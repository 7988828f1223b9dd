//! Is an orbit of a structure physical? Every contact must stay inside its barriers between its impacts: decided by bounds, not samples.
//!
//! Where no mode is far faster than a flight is long, contacts are polynomials on windows of a radian, whose turning points are isolated as
//! those of a chain's masses are. Otherwise, with d the distance to a barrier and B ≥ |g″| on the rest of a flight, d stays positive until the
//! root of d + d′h − Bh²/2: steps to these roots pass no contact.

use smallvec::smallvec;
use vibrochain_lattice::Barrier;
use wide::f64x4;

use super::error::StructureOrbitError;
use super::flight::StructureMotion;
use super::orbit::StructureOrbit;
use super::windows::{Lanes, View, Windows};
use crate::admissible::answer::{Admissibility, Approach, Obstruction};
use crate::admissible::check::Depth;
use crate::lanes::{LANES, Number, four};
use crate::motion::polynomial::{Polynomial, turning_points, with_overlap};

/// Distances below this part of a contact's reach are a touch.
const TOUCH: f64 = 1e-13;

/// Impacts closer than this part of the period are at one instant.
const TOGETHER: f64 = 1e-12;

/// Steps for one contact in one flight; a graze of 1e-13 takes some dozens.
const MOST_STEPS: usize = 2_000_000;

/// Whether an orbit is physical, with the least distance at a turning point or what is in the way, where it is farthest out; contacts stand
/// in place of sites.
///
/// # Errors
/// [`StructureOrbitError`] at a resonance.
pub fn structure_admissibility(orbit: &StructureOrbit) -> Result<Admissibility, StructureOrbitError> {
    check(orbit, Depth::Worst)
}

/// As [`structure_admissibility`], to the first thing that is in the way: what a map asks.
///
/// # Errors
/// As [`structure_admissibility`].
pub fn structure_is_physical(orbit: &StructureOrbit) -> Result<Admissibility, StructureOrbitError> {
    check(orbit, Depth::First)
}

fn check(orbit: &StructureOrbit, depth: Depth) -> Result<Admissibility, StructureOrbitError> {
    let impacts = orbit.impacts();
    for (number, impact) in impacts.iter().enumerate() {
        if impact.barrier.sign() * impact.velocity_before <= 0.0 {
            let obstruction = Obstruction::WrongSign {
                impact: number,
                site: impact.contact,
                time: impact.time,
                velocity_before: impact.velocity_before,
            };
            return Ok(Admissibility { margin: None, obstruction: Some(obstruction), closest: None });
        }
    }
    let motion = StructureMotion::new(orbit)?;
    let mut search = Search { orbit, motion: &motion, closest: None, pending: Vec::new(), depth };
    let order = search.order();
    let view = View::new(&motion, &order);
    for i in 0..impacts.len() {
        if motion.until_next(i) <= TOGETHER * orbit.period() || search.is_decided() {
            continue;
        }
        match view.as_ref().and_then(|view| Windows::new(view, &motion, i)) {
            Some(mut windows) => search.by_windows(&mut windows, &order, i),
            None => search.by_steps(i)?,
        }
    }
    let closest = search.closest;
    let obstruction = closest.as_ref().filter(|(least, _)| *least <= 0.0).map(|(least, approach)| {
        Obstruction::Crossing { site: approach.site, barrier: approach.barrier, time: approach.time, excess: -least }
    });
    let (margin, closest) = match closest {
        Some((least, approach)) => (Some(least), Some(approach)),
        None => (None, None),
    };
    Ok(Admissibility { margin, obstruction, closest })
}

struct Search<'a> {
    orbit: &'a StructureOrbit,
    motion: &'a StructureMotion<'a>,
    closest: Option<(f64, Approach)>,
    pending: Vec<(f64, f64)>,
    depth: Depth,
}

impl Search<'_> {
    /// Nothing that is still to come changes the answer.
    fn is_decided(&self) -> bool {
        self.depth == Depth::First && self.closest.as_ref().is_some_and(|(least, _)| *least <= 0.0)
    }

    fn note(&mut self, least: f64, (contact, barrier): (usize, Barrier), time: f64) {
        if self.closest.as_ref().is_none_or(|(other, _)| least < *other) {
            let time = time.rem_euclid(self.orbit.period());
            self.closest = Some((least, Approach { site: contact, barrier, time }));
        }
    }

    /// Contacts with a barrier, those that are hit first: the others are seldom nearer. Of those that do the same, as mirror images of each
    /// other have it, between barriers at the same places one.
    fn order(&self) -> Vec<usize> {
        let (contacts, response) = (self.orbit.model().structure().contacts(), self.motion.response());
        let is_hit = |contact: usize| self.orbit.impacts().iter().any(|impact| impact.contact == contact);
        let stopped = |contact: &usize| contacts[*contact].lower.is_some() || contacts[*contact].upper.is_some();
        let stops = |contact: usize| (contacts[contact].lower, contacts[contact].upper);
        let is_first = |contact: &usize| {
            let first = response.kernel.felt.twins[*contact];
            let same = || stops(first) == stops(*contact) && response.are_twins(first, *contact);
            first == *contact || is_hit(first) || is_hit(*contact) || !same()
        };
        let mut order: Vec<usize> = (0..contacts.len()).filter(stopped).filter(is_first).collect();
        order.sort_by_key(|&contact| !is_hit(contact));
        order
    }

    /// Whether a contact is on a barrier at an instant of impacts.
    fn is_hit(&self, contact: usize, barrier: Barrier, time: f64) -> bool {
        let period = self.orbit.period();
        let there = self.orbit.impacts().iter().filter(|impact| impact.contact == contact && impact.barrier == barrier);
        there
            .map(|impact| (impact.time - time).rem_euclid(period))
            .any(|apart| apart.min(period - apart) <= TOGETHER * period)
    }

    /// Turning points of the contacts' polynomials, window by window.
    fn by_windows(&mut self, windows: &mut Windows<'_>, order: &[usize], i: usize) {
        let begins = self.orbit.impacts()[i].time;
        let whole = self.motion.until_next(i);
        let bounds = windows.bounds();
        let [excursions, fourths] = bounds.each_ref().map(|lanes| lanes.as_flattened());
        let mut watched: Vec<Watched> = Vec::with_capacity(order.len());
        for (place, [here, end]) in windows.ends(order.len()).into_iter().enumerate() {
            let contact = order[place];
            let stops = [Barrier::Lower, Barrier::Upper].map(|barrier| {
                let stop = self.orbit.model().structure().contacts()[contact].barrier(barrier)?;
                // Most contacts are far from their barriers, and stay there.
                let room = barrier.sign() * (stop - self.motion.response().still(contact)) - excursions[place];
                let is_far = self.closest.as_ref().is_some_and(|(least, _)| room > least.max(0.0));
                (!is_far).then_some((barrier, stop))
            });
            // A contact that feels an impact of another has a corner there.
            for (barrier, stop) in stops.into_iter().flatten() {
                for (s, [at, _]) in [(0.0, here), (whole, end)] {
                    if !self.is_hit(contact, barrier, begins + s) {
                        self.note(barrier.sign() * (stop - at), (contact, barrier), begins + s);
                    }
                }
            }
            if stops.iter().any(Option::is_some) {
                watched.push(Watched { contact, place, fourth: fourths[place], stops, here });
            }
        }
        if watched.is_empty() {
            return;
        }
        windows.keep(&mut watched.iter_mut().map(|own| &mut own.place));
        // Of all of them, four at a time.
        let lanes = |pad: f64, of: fn(&Watched) -> f64| {
            let mut lanes: Lanes = smallvec![[pad; LANES]; watched.len().div_ceil(LANES)];
            lanes.as_flattened_mut().iter_mut().zip(&watched).for_each(|(slot, own)| *slot = of(own));
            lanes
        };
        let [lower, upper] = [
            lanes(f64::NEG_INFINITY, |own| own.stops[0].map_or(f64::NEG_INFINITY, |(_, stop)| stop)),
            lanes(f64::INFINITY, |own| own.stops[1].map_or(f64::INFINITY, |(_, stop)| stop)),
        ];
        let fourths = lanes(0.0, |own| own.fourth);
        let mut here = [lanes(0.0, |own| own.here[0]), lanes(0.0, |own| own.here[1])];
        let mut there = here.clone();
        let mut pending = std::mem::take(&mut self.pending);
        loop {
            let sighted = windows.pass();
            there[0].copy_from_slice(&sighted.places);
            there[1].copy_from_slice(&sighted.velocities);
            for (group, four_watched) in watched.chunks(LANES).enumerate() {
                let [begin, end] = [&here, &there].map(|both| both.each_ref().map(|lanes| four(lanes[group])));
                let passages = Passage::new(begin, end, windows.length, four(fourths[group]));
                let rooms = [(Barrier::Lower, &lower), (Barrier::Upper, &upper)]
                    .map(|(barrier, stops)| passages.room(barrier, four(stops[group])));
                let room = (-(-rooms[0]).at_least(-rooms[1])).to_array();
                for (lane, own) in four_watched.iter().enumerate() {
                    if self.closest.as_ref().is_some_and(|(least, _)| room[lane] >= *least) {
                        continue;
                    }
                    self.pass(windows, own, passages.of(lane), begins, &mut pending);
                }
            }
            std::mem::swap(&mut here, &mut there);
            if self.is_decided() || !windows.advance() {
                break;
            }
        }
        self.pending = pending;
    }

    /// Looks at one contact on a window.
    fn pass(
        &mut self,
        windows: &mut Windows<'_>,
        own: &Watched,
        passage: Passage<f64>,
        begins: f64,
        pending: &mut Vec<(f64, f64)>,
    ) {
        if !passage.may_turn() {
            return;
        }
        let mut polynomial: Option<Polynomial> = None;
        for (barrier, stop) in own.stops.into_iter().flatten() {
            if self.closest.as_ref().is_some_and(|(least, _)| passage.room(barrier, stop) >= *least) {
                continue;
            }
            let own_polynomial = polynomial.get_or_insert_with(|| windows.polynomial(own.place));
            self.turns(windows, own_polynomial, (own.contact, barrier, stop), begins, pending);
        }
    }

    /// Takes note of the turning points on a window.
    fn turns(
        &mut self,
        windows: &Windows<'_>,
        polynomial: &Polynomial,
        (contact, barrier, stop): (usize, Barrier, f64),
        begins: f64,
        pending: &mut Vec<(f64, f64)>,
    ) {
        // In the form that turning points are sought in: the distance is 1 − |p|, and p beyond −1 is far away.
        let terms = polynomial.coefficients.iter().enumerate();
        let far = terms.fold(0.0, |sum: f64, (k, c)| sum + c.abs() * windows.length.powi(k as i32));
        let scale = 2.0 * (far + stop.abs()).max(f64::MIN_POSITIVE);
        let mut own = *polynomial;
        own.coefficients.iter_mut().for_each(|c| *c *= barrier.sign() / scale);
        own.coefficients[0] += 1.0 - barrier.sign() * stop / scale;
        let start = begins + windows.start();
        let least = self.closest.as_ref().map_or(f64::INFINITY, |(least, _)| *least / scale);
        let mut note = |s: f64, value: f64| {
            self.note((1.0 - value) * scale, (contact, barrier), start + s);
            self.closest.as_ref().map_or(f64::INFINITY, |(least, _)| *least / scale)
        };
        turning_points(&own, with_overlap(windows.length, windows.goes_on()), pending, least, &mut note, 0.0);
    }

    /// By bounds alone, step by step.
    fn by_steps(&mut self, i: usize) -> Result<(), StructureOrbitError> {
        let begins = self.orbit.impacts()[i].time;
        let structure = self.orbit.model().structure().clone();
        let length = self.motion.until_next(i);
        for contact in self.order() {
            let stops = &structure.contacts()[contact];
            for barrier in [Barrier::Lower, Barrier::Upper] {
                let Some(stop) = stops.barrier(barrier) else { continue };
                if self.is_decided() {
                    continue;
                }
                let touch = TOUCH * stops.reach().max(f64::MIN_POSITIVE);
                let watch = Watch { motion: self.motion, contact, barrier, stop, i, length, touch };
                let (leaves, arrives) =
                    (self.is_hit(contact, barrier, begins), self.is_hit(contact, barrier, begins + length));
                if let Some((least, s)) = watch.least(leaves, arrives)? {
                    self.note(least, (contact, barrier), begins + s);
                }
            }
        }
        Ok(())
    }
}

/// A contact that may come near its barriers, where it is and how fast at a window's start.
struct Watched {
    contact: usize,
    /// Its place among those that are looked at, and a bound of its |g⁗|.
    place: usize,
    fourth: f64,
    stops: [Option<(Barrier, f64)>; 2],
    here: [f64; 2],
}

/// The cubic that has a contact's place and velocity at both ends of a window, by Bézier's four points, between which it stays, and how far
/// the contact can be from it: h⁴/384 times a bound of |g⁗|, and √3h³/216 times that in its velocity. Of one contact, or of four.
struct Passage<T> {
    points: [T; 4],
    off: T,
    length: f64,
}

impl<T: Number> Passage<T> {
    fn new([place, velocity]: [T; 2], [end, last]: [T; 2], length: f64, fourth: T) -> Self {
        let third = length / 3.0;
        // What rounding adds is as small against the terms as this.
        let off = (fourth * length.powi(4) / T::of(384.0)) * (1.0 + 1e-9) + (place.modulus() + end.modulus()) * 1e-14;
        Self { points: [place, place + velocity * third, end - last * third, end], off, length }
    }

    /// How much room it surely leaves before a barrier.
    fn room(&self, barrier: Barrier, stop: T) -> T {
        let [a, b, c, d] = self.points.map(|place| (place - stop) * barrier.sign());
        -(a.at_least(b).at_least(c.at_least(d))) - self.off
    }
}

impl Passage<f64x4> {
    /// That of one of the four.
    fn of(&self, lane: usize) -> Passage<f64> {
        let own = |four: f64x4| four.to_array()[lane];
        Passage { points: self.points.map(own), off: own(self.off), length: self.length }
    }
}

impl Passage<f64> {
    /// Whether the velocity may vanish.
    fn may_turn(&self) -> bool {
        let [a, b, c, d] = self.points;
        let slopes = [b - a, c - b, d - c].map(|way| way * 3.0 / self.length);
        // √3/216 of what is 1/384 in place.
        let off = self.off * 3.08 / self.length;
        !(slopes.iter().all(|slope| *slope > off) || slopes.iter().all(|slope| *slope < -off))
    }
}

/// One contact and one barrier in one flight.
struct Watch<'a> {
    motion: &'a StructureMotion<'a>,
    contact: usize,
    barrier: Barrier,
    stop: f64,
    i: usize,
    length: f64,
    touch: f64,
}

impl Watch<'_> {
    /// The distance to the barrier and its derivative.
    fn distance(&self, s: f64) -> [f64; 2] {
        let [place, velocity, _] = self.motion.contact(self.contact, self.i, s);
        let sign = self.barrier.sign();
        [sign * (self.stop - place), -sign * velocity]
    }

    /// The least distance at a turning point or end of the flight, and where; `None` if it only goes. `leaves`, `arrives`: it is on the
    /// barrier at the ends.
    fn least(&self, leaves: bool, arrives: bool) -> Result<Option<(f64, f64)>, StructureOrbitError> {
        let bend = |s: f64| self.motion.most_acceleration(self.contact, self.i, s, self.length) * (1.0 + 1e-12);
        let whole = bend(0.0);
        let (first, last) = (self.distance(0.0), self.distance(self.length));
        let mut s = if leaves { (1.999 * first[1] / whole).max(0.0) } else { 0.0 };
        let end = if arrives { self.length - (1.999 * -last[1] / whole).max(0.0) } else { self.length };
        let mut least: Option<(f64, f64)> = None;
        let mut keep = |d: f64, s: f64| {
            if least.is_none_or(|(other, _)| d < other) {
                least = Some((d, s));
            }
        };
        if leaves {
            // Between its first turn and here it comes back no farther than this.
            s = s.min(end);
        }
        let mut before: Option<(f64, f64)> = None;
        for _ in 0..MOST_STEPS {
            let [d, slope] = self.distance(s);
            if let Some((s_before, slope_before)) = before
                && slope_before < 0.0
                && slope >= 0.0
            {
                let turn = self.turning(s_before, s);
                keep(self.distance(turn)[0], turn);
            }
            if d <= self.touch {
                // Beyond, or as good as there: how far it goes.
                let turn = self.deepest(s);
                keep(self.distance(turn)[0].min(0.0), turn);
                return Ok(least);
            }
            if s >= end {
                return Ok(least);
            }
            let bend = bend(s).max(f64::MIN_POSITIVE);
            let step = (slope + (slope * slope + 2.0 * bend * d).sqrt()) / bend;
            before = Some((s, slope));
            s = (s + step.max(1e-9 * self.length)).min(end);
        }
        Err(StructureOrbitError::TooStiff { contact: self.contact, steps: MOST_STEPS })
    }

    /// Where the distance turns between two places.
    fn turning(&self, mut low: f64, mut high: f64) -> f64 {
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.distance(middle)[1] < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }

    /// The first turn after a place beyond the barrier.
    fn deepest(&self, from: f64) -> f64 {
        let step = 1e-3 * self.length;
        let mut s = from;
        while s < self.length {
            let next = (s + step).min(self.length);
            if self.distance(next)[1] >= 0.0 {
                return self.turning(s, next);
            }
            s = next;
        }
        self.length
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape};
    use vibrochain_testkit::Random;

    use super::*;
    use crate::structures::model::StructureModel;
    use crate::structures::search::structure_orbits;

    /// A few modes with two contacts, one on one side and one between two barriers.
    fn structure(random: &mut Random) -> ModalStructure {
        let mut mode = || {
            let (frequency, ratio) = (random.log(0.3, 6.0), random.log(1e-3, 1.5));
            let contacts = vec![random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
            let shape = ModeShape { contacts, coordinates: Vec::new(), still: random.between(-0.1, 0.1) };
            let load = Complex::new(random.between(-1.0, 1.0), 0.0);
            LinearMode::oscillator(ratio * frequency, frequency * frequency * (1.0 - ratio * ratio), &shape, &[load])
        };
        let modes: Vec<_> = (0..5).map(|_| mode()).collect();
        let contacts = vec![
            Contact { lower: None, upper: Some(random.between(0.0, 0.5)), restitution: random.between(0.3, 1.0) },
            Contact { lower: Some(-random.log(0.1, 2.0)), upper: Some(random.log(0.1, 2.0)), restitution: 0.8 },
        ];
        ModalStructure::new(contacts, vec![1], modes).unwrap()
    }

    /// Windows, steps and samples agree on what is in the way, and how near the nearest is.
    #[test]
    fn windows_and_steps_agree() {
        let mut random = Random(29);
        let (mut physical, mut crossing, mut first) = (0, 0, 0);
        for _ in 0..300 {
            let structure = Arc::new(structure(&mut random));
            let model = StructureModel::new(structure, random.between(0.5, 3.0)).unwrap();
            let word = random.of(&["0+", "0+,0+", "1-,1+", "0+,1-"]).parse().unwrap();
            let Ok(found) = structure_orbits(&model, &word, 1) else { continue };
            for orbit in &found.orbits {
                let answer = structure_admissibility(orbit).unwrap();
                let Some(margin) = answer.margin else { continue };
                let motion = StructureMotion::new(orbit).unwrap();
                let mut search =
                    Search { orbit, motion: &motion, closest: None, pending: Vec::new(), depth: Depth::Worst };
                (0..orbit.impacts().len()).for_each(|i| search.by_steps(i).unwrap());
                let Some((stepped, _)) = search.closest else {
                    assert!(margin > 0.0);
                    continue;
                };
                assert_eq!(stepped <= 0.0, margin <= 0.0, "{stepped} {margin} {orbit:?}");
                if margin <= 0.0 {
                    crossing += 1;
                    let quick = structure_is_physical(orbit).unwrap();
                    assert!(!quick.is_physical());
                    first += usize::from(quick.margin != answer.margin);
                    let mut least = f64::INFINITY;
                    for i in 0..orbit.impacts().len() {
                        for n in 1..400 {
                            let s = motion.until_next(i) * f64::from(n) / 400.0;
                            let rooms = model.structure().contacts().iter().enumerate();
                            least =
                                rooms.map(|(c, stops)| stops.room(motion.contact(c, i, s)[0])).fold(least, f64::min);
                        }
                    }
                    assert!(margin <= least + 1e-9 && margin > least - 0.02 * (1.0 + least.abs()), "{margin} {least}");
                } else {
                    physical += 1;
                    assert!(margin <= stepped + 1e-9, "{margin} {stepped} {orbit:?}");
                }
            }
        }
        assert!(physical > 20 && crossing > 100 && first > 20, "{physical} {crossing} {first}");
    }
}

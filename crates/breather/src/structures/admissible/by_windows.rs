//! Contacts as polynomials on windows of a radian, whose turning points are isolated.

use smallvec::smallvec;
use vibrochain_lattice::simd::lanes::{LANES, Number, four};
use vibrochain_lattice::{Barrier, Stopped};
use wide::f64x4;

use super::Search;
use crate::motion::polynomial::{Polynomial, turning_points, with_overlap};
use crate::structures::windows::{Lanes, Windows};

/// A contact that may come near its barriers, where it is and how fast at a window's start.
struct Watched {
    contact: usize,
    /// Its place among those that are looked at, and a bound of its |g⁗|.
    place: usize,
    fourth: f64,
    stops: [Option<(Barrier, f64)>; 2],
    here: [f64; 2],
}

/// A barrier of a contact, and where it is.
#[derive(Debug, Clone, Copy)]
struct Wall {
    contact: usize,
    barrier: Barrier,
    stop: f64,
    /// The contact is surely off it until then, since the flight's beginning.
    clear: f64,
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

impl Search<'_> {
    /// Turning points of the contacts' polynomials, window by window.
    pub(super) fn by_windows(&mut self, windows: &mut Windows<'_>, order: &[usize], i: usize) -> Result<(), Stopped> {
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
                    if self.impact_at(contact, barrier, begins + s).is_none() {
                        self.note(barrier.sign() * (stop - at), (contact, barrier), begins + s);
                    }
                }
            }
            if stops.iter().any(Option::is_some) {
                watched.push(Watched { contact, place, fourth: fourths[place], stops, here });
            }
        }
        if watched.is_empty() {
            return Ok(());
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
            self.motion.heard()?;
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
        Ok(())
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
            let clear = self.clear_after(own.contact, barrier, begins);
            let wall = Wall { contact: own.contact, barrier, stop, clear };
            self.turns(windows, own_polynomial, wall, begins, pending);
        }
    }

    /// Takes note of the turning points on a window.
    fn turns(
        &mut self,
        windows: &Windows<'_>,
        polynomial: &Polynomial,
        Wall { contact, barrier, stop, clear }: Wall,
        begins: f64,
        pending: &mut Vec<(f64, f64)>,
    ) {
        let [from, to] = with_overlap(windows.length, windows.goes_on());
        let from = from.max(if clear > 0.0 { clear - windows.start() } else { f64::NEG_INFINITY });
        if from >= to {
            return;
        }
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
        turning_points(&own, [from, to], pending, least, &mut note, 0.0);
    }
}

#[cfg(test)]
mod tests;

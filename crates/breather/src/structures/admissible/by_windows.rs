//! Contacts as polynomials on windows of a radian, whose turning points are isolated.

use smallvec::smallvec;
use vibrochain_lattice::simd::lanes::{LANES, Lane, all, four};
use vibrochain_lattice::{Barrier, Stopped};

use super::Search;
use super::passage::Passage;
use crate::admissible::gap::Depth;
use crate::motion::polynomial::{Polynomial, turning_points, with_overlap};
use crate::structures::view::Lanes;
use crate::structures::windows::Windows;

/// A contact that may come near its barriers.
struct Watched {
    contact: usize,
    /// Its place among those that are looked at, and a bound of its |g⁗|.
    place: usize,
    fourth: f64,
    stops: [Option<(Barrier, f64)>; 2],
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

impl Search<'_> {
    /// Turning points of the contacts' polynomials, window by window.
    pub(super) fn by_windows(&mut self, windows: &mut Windows<'_>, order: &[usize], i: usize) -> Result<(), Stopped> {
        let begins = self.orbit.impacts()[i].time;
        let whole = windows.whole;
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
                watched.push(Watched { contact, place, fourth: fourths[place], stops });
            }
        }
        if watched.is_empty() {
            return Ok(());
        }
        windows.keep(&mut watched.iter_mut().map(|own| &mut own.place));
        // Of all of them, four at a time.
        let lanes = |pad: f64, of: &dyn Fn(&Watched) -> f64| {
            let mut lanes: Lanes = smallvec![[pad; LANES]; watched.len().div_ceil(LANES)];
            lanes.as_flattened_mut().iter_mut().zip(&watched).for_each(|(slot, own)| *slot = of(own));
            lanes
        };
        let far = [f64::NEG_INFINITY, f64::INFINITY];
        let stop = |own: &Watched, side: usize| own.stops[side].map_or(far[side], |(_, stop)| stop);
        let stops = [0, 1].map(|side| lanes(far[side], &|own| stop(own, side)));
        let fourths = lanes(0.0, &|own| own.fourth);
        let mut nodes = std::mem::take(&mut self.nodes);
        windows.nodes(&mut nodes);
        // A contact that a barrier does not hit before the flight or after it comes no less near than it is anywhere.
        let is_hit = |contact, barrier| {
            [begins, begins + self.motion.until_next(i)]
                .iter()
                .any(|at| self.impact_at(contact, barrier, *at).is_some())
        };
        let free = [0, 1].map(|side| {
            let of = |own: &Watched| own.stops[side].filter(|(barrier, _)| !is_hit(own.contact, *barrier));
            lanes(far[side], &|own| of(own).map_or(far[side], |(_, stop)| stop))
        });
        let mut nearest = all(f64::INFINITY);
        for row in nodes.chunks_exact(fourths.len()) {
            for (g, [places, _]) in row.iter().enumerate() {
                let rooms = [four(*places) - four(free[0][g]), four(free[1][g]) - four(*places)];
                nearest = nearest.fast_min(rooms[0].fast_min(rooms[1]));
            }
        }
        let nearest = nearest.to_array().into_iter().fold(f64::INFINITY, f64::min);
        // Of several that are in the way the first one is told.
        let nearest = if self.depth == Depth::First { nearest.max(0.0) } else { nearest };
        let mut pending = std::mem::take(&mut self.pending);
        let rows: &[[Lane; 2]] = &nodes;
        let rows = rows.chunks_exact(fourths.len());
        for (number, (begin, end)) in rows.clone().zip(rows.skip(1)).enumerate() {
            self.motion.heard()?;
            for (group, four_watched) in watched.chunks(LANES).enumerate() {
                let [begin, end] = [begin[group], end[group]].map(|both| both.map(four));
                let passages = Passage::new(begin, end, windows.length, four(fourths[group]));
                let rooms = [(Barrier::Lower, &stops[0]), (Barrier::Upper, &stops[1])]
                    .map(|(barrier, stops)| passages.room(barrier, four(stops[group])));
                let room = rooms[0].fast_min(rooms[1]).to_array();
                for (lane, own) in four_watched.iter().enumerate() {
                    if room[lane] <= self.limit(nearest) {
                        self.pass((&mut *windows, number), own, (passages.of(lane), nearest), begins, &mut pending);
                    }
                }
            }
            if self.is_decided() {
                break;
            }
        }
        (self.pending, self.nodes) = (pending, nodes);
        Ok(())
    }

    /// The least distance so far, or where contacts have been seen to be nearer: what stays farther away does not count.
    fn limit(&self, nearest: f64) -> f64 {
        self.closest.as_ref().map_or(nearest, |(least, _)| least.min(nearest))
    }

    /// Looks at one contact on a window.
    fn pass(
        &mut self,
        (windows, number): (&mut Windows<'_>, usize),
        own: &Watched,
        (passage, nearest): (Passage<f64>, f64),
        begins: f64,
        pending: &mut Vec<(f64, f64)>,
    ) {
        if !passage.may_turn(windows.goes_on(number).map(|more| !more)) {
            return;
        }
        let mut polynomial: Option<Polynomial> = None;
        for (barrier, stop) in own.stops.into_iter().flatten() {
            if passage.room(barrier, stop) > self.limit(nearest) {
                continue;
            }
            let own_polynomial = polynomial.get_or_insert_with(|| windows.polynomial(number, own.place));
            let clear = self.clear_after(own.contact, barrier, begins);
            let wall = Wall { contact: own.contact, barrier, stop, clear };
            self.turns((windows, number), own_polynomial, wall, begins, pending);
        }
    }

    /// Takes note of the turning points on a window.
    fn turns(
        &mut self,
        (windows, number): (&Windows<'_>, usize),
        polynomial: &Polynomial,
        Wall { contact, barrier, stop, clear }: Wall,
        begins: f64,
        pending: &mut Vec<(f64, f64)>,
    ) {
        let [from, to] = with_overlap(windows.length, windows.goes_on(number));
        let from = from.max(if clear > 0.0 { clear - windows.start(number) } else { f64::NEG_INFINITY });
        if from >= to {
            return;
        }
        let (own, scale) = polynomial.before(barrier, stop, windows.length);
        let start = begins + windows.start(number);
        let least = self.closest.as_ref().map_or(f64::INFINITY, |(least, _)| *least / scale);
        let mut note = |s: f64, value: f64| {
            self.note((1.0 - value) * scale, (contact, barrier), start + s);
            self.closest.as_ref().map_or(f64::INFINITY, |(least, _)| *least / scale)
        };
        turning_points(&own, [from, to], pending, least, &mut note, 0.0);
    }
}

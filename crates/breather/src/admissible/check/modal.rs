//! By modes: contacts as polynomials on windows of a radian, whose turning points are isolated.

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::simd::lanes::{LANES, all, four};
use vibrochain_lattice::{Barrier, Stopped};

use super::search::Search;
use crate::admissible::gap::Depth;
use crate::motion::modal::passage::{Passage, STILL};
use crate::motion::modal::view::Lanes;
use crate::motion::modal::windows::Windows;
use crate::motion::polynomial::{Polynomial, turning_points, with_overlap};

/// A contact that may come near its barriers.
struct Watched {
    contact: usize,
    /// Its place among those that are looked at, and a bound of its |g⁗|.
    place: usize,
    fourth: f64,
    /// Its barriers, and whether it ever hits them.
    stops: [Option<(Barrier, f64)>; 2],
    hits: [bool; 2],
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
    /// Turning points of the contacts' polynomials, window by window, of the flight that begins at a time.
    pub(crate) fn by_modes(&mut self, windows: &mut Windows<'_>, order: &[usize], begins: f64) -> Result<(), Stopped> {
        let whole = windows.whole;
        let bounds = windows.bounds();
        let [excursions, fourths] = bounds.each_ref().map(|lanes| lanes.as_flattened());
        let mut watched: SmallVec<[Watched; 16]> = SmallVec::new();
        for (place, &contact) in order.iter().enumerate() {
            let still = windows.still(place);
            let stops = self.barriers(contact).map(|stop| {
                stop.filter(|&(barrier, stop)| {
                    // Most contacts are far from their barriers, and stay there.
                    let room = barrier.sign() * (stop - still) - excursions[place];
                    room <= self.closest.distance.max(0.0)
                })
            });
            if stops == [None; 2] {
                continue;
            }
            let ends = windows.ends(place);
            let hits = stops.map(|stop| stop.is_some_and(|(barrier, _)| self.hits(contact, barrier)));
            for ((barrier, stop), hits) in stops.into_iter().zip(hits).filter_map(|(stop, hits)| Some((stop?, hits))) {
                let [[here, after], [there, last]] = ends;
                let still = 6.0 * STILL * excursions[place];
                // A contact that is about to hit comes nearer all the time: its place counts only where it turns, by itself or by another's impact.
                let turns = || {
                    let before = after - self.jolt(contact, begins) * windows.length;
                    before.min(after) <= still && before.max(after) >= -still
                };
                if !hits || !self.hits_at(contact, begins) && turns() {
                    self.note(barrier.sign() * (stop - here), (contact, barrier), begins);
                }
                if !hits || !self.hits_at(contact, begins + whole) && last.abs() <= still {
                    self.note(barrier.sign() * (stop - there), (contact, barrier), begins + whole);
                }
            }
            watched.push(Watched { contact, place, fourth: fourths[place], stops, hits });
        }
        if watched.is_empty() {
            return Ok(());
        }
        windows.keep(&mut watched.iter_mut().map(|own| &mut own.place));
        // Of all of them, four at a time.
        let fours = watched.len().div_ceil(LANES);
        let lanes = |pad: f64| -> Lanes { smallvec![[pad; LANES]; fours] };
        let far = || [lanes(f64::NEG_INFINITY), lanes(f64::INFINITY)];
        let (mut stops, mut free, mut fourths) = (far(), far(), lanes(0.0));
        for (place, own) in watched.iter().enumerate() {
            fourths.as_flattened_mut()[place] = own.fourth;
            for (side, (_, stop)) in own.stops.iter().enumerate().filter_map(|(side, stop)| Some((side, (*stop)?))) {
                stops[side].as_flattened_mut()[place] = stop;
                if !own.hits[side] {
                    free[side].as_flattened_mut()[place] = stop;
                }
            }
        }
        let mut rows = std::mem::take(&mut self.lists.rows);
        windows.rows(&mut rows);
        let mut nearest = all(f64::INFINITY);
        for row in rows.chunks_exact(2 * fours) {
            for (g, places) in row[..fours].iter().enumerate() {
                let rooms = [four(*places) - four(free[0][g]), four(free[1][g]) - four(*places)];
                nearest = nearest.fast_min(rooms[0].fast_min(rooms[1]));
            }
        }
        let nearest = nearest.to_array().into_iter().fold(f64::INFINITY, f64::min);
        // Of several that are in the way the first one is told.
        let nearest = if self.depth == Depth::First { nearest.max(0.0) } else { nearest };
        let mut pending = std::mem::take(&mut self.lists.pending);
        let nodes = rows.chunks_exact(2 * fours);
        for (number, (begin, end)) in nodes.clone().zip(nodes.skip(1)).enumerate() {
            self.stop.heard()?;
            for (group, four_watched) in watched.chunks(LANES).enumerate() {
                let [begin, end] = [begin, end].map(|row| [row[group], row[fours + group]].map(four));
                let passages = Passage::new(begin, end, 1.0, four(fourths[group]));
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
        (self.lists.pending, self.lists.rows) = (pending, rows);
        Ok(())
    }

    /// The least distance so far, or where contacts have been seen to be nearer: what stays farther away does not count.
    fn limit(&self, nearest: f64) -> f64 {
        self.closest.distance.min(nearest)
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
            let clear = self.clear_after(own.contact, barrier, begins).unwrap_or_default();
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
        let [from, to] = with_overlap(1.0, windows.goes_on(number));
        let first = if clear > 0.0 { (clear - windows.start(number)) / windows.length } else { f64::NEG_INFINITY };
        let from = from.max(first);
        if from >= to {
            return;
        }
        let (own, scale) = polynomial.before(barrier, stop);
        let start = begins + windows.start(number);
        let least = self.closest.distance / scale;
        let mut note = |s: f64, value: f64| {
            self.note((1.0 - value) * scale, (contact, barrier), start + s * windows.length);
            self.closest.distance / scale
        };
        turning_points(&own, [from, to], pending, least, &mut note, 0.0);
    }
}

//! What a map asks of an orbit without loads and losses, all of whose impacts are of one contact: one a period, or two on both barriers. Is it
//! physical, by what margin, with which impulses?
//!
//! A fast path: a cell of a map of such orbits takes a tenth of the time. The general one is [`LoadedStructure::candidates`] and
//! [`ContactOrbit::first_obstruction`](super::orbit::ContactOrbit::first_obstruction); what needs more than closed forms is left to it
//! ([`MapSearch::Open`]). With frequencies Ω and shapes φ of the modes, φ₀ at the contact that is hit, contact c does after impulses P, Q at 0, T/2 + s
//!
//! ```text
//! Σ φ_c φ₀ [P cos Ω(t−T/2) + Q cos Ω(t−s)] / (2Ω sin ΩT/2),      0 ≤ t ≤ T/2 + s.
//! ```
//!
//! Impacts with s ≠ 0, where K′ vanishes, come in pairs ±s that are each other's mirror images in time: both are physical, or neither. A cell of which
//! one is physical is left to the search.

mod alone;
pub(crate) mod modes;

use std::sync::Arc;

use smallvec::SmallVec;
use vibrochain_lattice::{Barrier, Contact};

use super::model::LoadedStructure;
use super::response::FixedPart;
use super::reversible::ReversibleOrbit;
use super::search::half_period::other_lapses;
use crate::admissible::answer::Obstruction;
use crate::admissible::check::on_grid::{Ends, OnGrid, Watched};
use crate::admissible::gap::{Closest, Depth, Gap};
use crate::admissible::grid::{Flight, Forces, MOST_RADIANS};
use crate::admissible::map_breather::MapSearch;
use crate::motion::modal::view::View;
use crate::search::finder::Finder;
use crate::word::Word;
use modes::{DELICATE, Impulses, Modes};

/// An impulse below this part of the other one is next to grazing.
const GRAZING: f64 = 1e-5;

/// Positions miss their barriers by no more than this part of their terms: rounding.
const ROUNDED: f64 = 64.0 * f64::EPSILON;

/// Two impacts nearer to each other, or to half a period, than this part of the period are left to the search.
const CLOSE: f64 = 1e-3;

/// Whether a barrier pulls by more than this part of the larger impulse: no such orbit is a candidate.
fn surely_pulls(barriers: [Option<Barrier>; 2], impulses: [f64; 2]) -> bool {
    pulls(barriers, impulses).any(|pull| pull > GRAZING)
}

/// Whether both push by more than that.
fn surely_push(barriers: [Option<Barrier>; 2], impulses: [f64; 2]) -> bool {
    pulls(barriers, impulses).all(|pull| pull < -GRAZING)
}

/// How barriers pull, as parts of the larger impulse.
fn pulls(barriers: [Option<Barrier>; 2], impulses: [f64; 2]) -> impl Iterator<Item = f64> {
    let most = impulses[0].abs().max(impulses[1].abs());
    let of = move |(barrier, impulse): (Option<Barrier>, f64)| Some(barrier?.sign() * impulse / most);
    barriers.into_iter().zip(impulses).filter_map(of)
}

/// An orbit whose impacts, of one contact, are half a period apart, or the only one; or another one that is not physical.
///
/// ```
/// use std::sync::Arc;
/// use vibrochain_breather::{Finder, MapSearch, LoadedStructure};
/// use vibrochain_lattice::{Contact, LinearMode, ModalStructure, ModeShape};
/// let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: 0.0 };
/// let mode = LinearMode::oscillator(0.0, 1.0, &shape, &[]);
/// let stop = Contact { lower: Some(-1.0), upper: Some(0.7), restitution: 1.0 };
/// let structure = Arc::new(ModalStructure::new(vec![stop], vec![], vec![mode])?);
/// let model = LoadedStructure::new(structure, 1.5)?;
/// let word = "0+,0-".parse()?;
/// let MapSearch::One(orbit) = Finder::default().map_orbit(&model, &word, 1) else { panic!() };
/// let impulse = model.orbits(&word, 1)?.orbits[0].impacts()[0].impulse;
/// assert!((orbit.impulses()[0] - impulse).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct MapOrbit {
    fixed: Arc<FixedPart>,
    period: f64,
    impulses: [f64; 2],
    /// When the second impact is, if there is one.
    phi: Option<f64>,
    /// Of two impulses half a period apart the bound of the relative error of their ratio.
    ratio_error: Option<f64>,
    margin: Option<f64>,
    crossing: Option<Obstruction>,
    residual: f64,
}

impl MapOrbit {
    /// Momenta that the barriers give, signed.
    pub fn impulses(&self) -> &[f64] {
        &self.impulses[..1 + usize::from(self.phi.is_some())]
    }

    /// Times of the impacts. The second one of a physical orbit is at T/2.
    pub fn times(&self) -> impl Iterator<Item = f64> + Clone {
        [Some(0.0), self.phi].into_iter().flatten()
    }

    /// The orbit's period.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// What is in the way; `None` of a physical orbit.
    pub fn obstruction(&self) -> Option<Obstruction> {
        self.crossing
    }

    /// The least distance at a turning point, if there is one.
    pub fn margin(&self) -> Option<f64> {
        self.margin
    }

    /// How far contacts are from their barriers at impacts, as a part of the terms of their places.
    pub fn residual(&self) -> f64 {
        self.residual
    }

    /// What its multipliers depend on; `None` of impacts that are not half a period apart.
    pub fn reversible(&self) -> Option<ReversibleOrbit<'_>> {
        let [first, second] = self.impulses;
        let ratio = self.ratio_error.map(|error| (second / first, error));
        let modes = self.fixed.felt.of_one.as_deref()?;
        (ratio.is_some() || self.phi.is_none()).then_some(ReversibleOrbit { modes, period: self.period, ratio })
    }
}

/// The contacts that are looked at, first the one that is hit, and what they see of the modes.
#[derive(Clone, Copy)]
struct Sights<'a> {
    modes: &'a Modes,
    view: &'a View,
    order: &'a [usize],
    contacts: &'a [Contact],
    forces: Forces<'a>,
}

impl Finder {
    /// What lives at a point of a word of one impact, or of two of one contact on both barriers, where closed forms tell it: without loads and losses,
    /// away from resonances, and where no orbit is physical whose two impacts are not half a period apart. Where none is physical, the first candidate
    /// of the word tells what is in its way.
    pub fn map_orbit(&mut self, model: &LoadedStructure, word: &Word, force_periods: u32) -> MapSearch<MapOrbit> {
        self.find_map_orbit(model, word, force_periods).unwrap_or(MapSearch::Open)
    }

    fn find_map_orbit(
        &mut self,
        model: &LoadedStructure,
        word: &Word,
        force_periods: u32,
    ) -> Option<MapSearch<MapOrbit>> {
        let mut letters = word.letters();
        let (first, second) = (letters.next()?, letters.next());
        let is_opposite = second.is_none_or(|other| other.site == first.site && other.barrier != first.barrier);
        let is_simple = word.instants().len() == 1 + usize::from(second.is_some()) && letters.next().is_none();
        if !is_opposite || !is_simple || force_periods != 1 || model.heard().is_err() {
            return None;
        }
        let contacts = model.structure().contacts();
        let stops = contacts.get(first.site)?;
        let fixed = model.fixed(&[first.site]);
        if fixed.forced || fixed.self_excited || !fixed.is_held || model.masses().is_some() {
            return None;
        }
        let watched = fixed.view(contacts);
        let (order, view) = (&watched.0, watched.1.as_ref()?);
        let (period, half) = (model.period(), 0.5 * model.period());
        if half * view.fastest > MOST_RADIANS {
            return None;
        }
        let Self { watch, half_period, .. } = self;
        // Words of one contact share them.
        let is_known = |(known, of, _): &(Arc<FixedPart>, f64, Modes)| Arc::ptr_eq(known, &fixed) && *of == half;
        if !half_period.as_deref().is_some_and(is_known) {
            let fresh = (fixed.clone(), half, Modes::at_half(&fixed, first.site, half)?);
            match half_period.as_deref_mut() {
                Some(known) => *known = fresh,
                None => *half_period = Some(Box::new(fresh)),
            }
        }
        let (.., modes) = half_period.as_deref()?;
        // Barriers from where the contact is still.
        let still = fixed.still(first.site);
        let place = |barrier: Barrier| Some(stops.barrier(barrier)? - still);
        let barriers = [Some(first.barrier), second.map(|letter| letter.barrier)];
        let places = [place(first.barrier)?, second.map_or(Some(0.0), |letter| place(letter.barrier))?];
        let Impulses { impulses, errors, residual } = modes.impulses(places, second.is_some())?;
        let least =
            impulses.iter().take(1 + usize::from(second.is_some())).fold(f64::INFINITY, |least, p| least.min(p.abs()));
        let most = impulses[0].abs().max(impulses[1].abs());
        let is_sharp = errors.iter().all(|error| *error <= DELICATE) && residual <= ROUNDED;
        if !is_sharp || least < GRAZING * most {
            return None;
        }
        let forces = Forces::Any(fixed.pulls(model.structure()));
        let sights = Sights { modes, view, order, contacts, forces };
        let on_grid = &mut watch.on_grid;
        let mut blocked = None;
        if second.is_some() && !modes.is_alone(half, view.fastest) {
            // The second impact is the earlier, the larger s.
            for s in other_lapses(fixed.felt.of_one.as_deref()?, period, model.stop())?.into_iter().rev() {
                let impulses = modes.aside(s, places)?;
                if surely_pulls(barriers, impulses) {
                    continue;
                }
                if !surely_push(barriers, impulses) || s.min(half - s) < CLOSE * period {
                    return None;
                }
                let crossing = sights.surely_crosses(on_grid, impulses, half, s)?;
                let (fixed, phi) = (fixed.clone(), Some(half - s));
                let margin = Some(crossing.distance);
                blocked.get_or_insert(MapOrbit {
                    fixed,
                    period,
                    impulses,
                    phi,
                    ratio_error: None,
                    margin,
                    crossing: Some(obstruction(crossing)),
                    residual,
                });
            }
        }
        let blocked = blocked.map_or(MapSearch::None, MapSearch::One);
        if surely_pulls(barriers, impulses) {
            return Some(blocked);
        }
        let closest = sights.closest(on_grid, impulses, half, second.is_none())?;
        let margin = Some(closest.distance).filter(|margin| margin.is_finite());
        let crossing = (closest.distance <= 0.0).then(|| obstruction(closest));
        if crossing.is_some() && matches!(blocked, MapSearch::One(_)) {
            return Some(blocked);
        }
        let ratio_error = second.map(|_| errors.iter().sum::<f64>() + 4.0 * f64::EPSILON);
        let phi = second.map(|_| half);
        Some(MapSearch::One(MapOrbit { fixed, period, impulses, phi, ratio_error, margin, crossing, residual }))
    }
}

/// What is in the way there.
fn obstruction(Closest { distance, site, barrier, time }: Closest) -> Obstruction {
    Obstruction::Crossing { site, barrier, time, excess: -distance }
}

impl Sights<'_> {
    /// Where contacts come nearest to a barrier, or what is first in the way, in half a period after the first of these impulses, of one or two half a
    /// period apart. `None` where that takes too many nodes.
    fn closest(self, on_grid: &mut OnGrid, impulses: [f64; 2], half: f64, one: bool) -> Option<Closest> {
        self.on_grid(on_grid, (impulses, 0.0), half, Ends { one, turning: true }, |on_grid, watched, gaps| {
            let mut closest = Closest::NONE;
            on_grid.closest(watched, |mass| gaps[mass], Depth::First, &mut closest);
            let is_beyond = closest.distance <= 0.0;
            let first = is_beyond.then(|| on_grid.first_beyond(watched, |mass| gaps[mass]));
            first.filter(|first| first.distance <= 0.0).unwrap_or(closest)
        })
    }

    /// What is first in the way of two impacts of which the second is by s less than half a period after the first; `None` unless something surely
    /// is.
    fn surely_crosses(self, on_grid: &mut OnGrid, impulses: [f64; 2], half: f64, s: f64) -> Option<Closest> {
        let [first, second] = impulses;
        let flights = [((impulses, -s), half - s), (([second, first], s), half + s)];
        let mut before = 0.0;
        for (start, whole) in flights {
            let ends = Ends { one: false, turning: false };
            let (beyond, is_sure) = self.on_grid(on_grid, start, whole, ends, |on_grid, watched, gaps| {
                let beyond = on_grid.first_beyond(watched, |mass| gaps[mass]);
                let place = self.order.iter().position(|contact| *contact == beyond.site);
                let size = place.map_or(0.0, |place| gaps[place].half);
                (beyond, beyond.distance < -DELICATE * size)
            })?;
            if beyond.distance <= 0.0 {
                return is_sure.then_some(Closest { time: before + beyond.time, ..beyond });
            }
            before = whole;
        }
        None
    }

    /// What `look` tells of the flight that begins with the first of two impulses and lasts for `whole`; the other one is s later than half a
    /// period. `None` where that takes too many nodes.
    fn on_grid<T>(
        self,
        on_grid: &mut OnGrid,
        (impulses, s): ([f64; 2], f64),
        whole: f64,
        ends: Ends,
        look: impl FnOnce(&mut OnGrid, Watched<'_>, &[Gap]) -> T,
    ) -> Option<T> {
        let Self { modes, view, order, contacts, forces } = self;
        let start = modes.start(impulses, s);
        let flight = Flight {
            frequencies: &modes.frequency.as_flattened()[..view.flows.len()],
            fastest: view.fastest,
            shapes: &view.sights.shapes,
            start: [&start[0], &start[1]],
            driven: None,
        };
        if !on_grid.grid.set(flight, forces, whole) {
            return None;
        }
        let still = view.sights.still.as_flattened();
        let mut gaps: SmallVec<[Gap; 16]> = SmallVec::new();
        let gap = |(place, &contact): (usize, &usize)| {
            Gap::of(&contacts[contact], still[place], on_grid.grid.excursion(place))
        };
        gaps.extend(order.iter().enumerate().map(gap));
        // Where there is no contact there is room enough.
        gaps.resize(still.len(), Gap { centre: 0.0, half: f64::INFINITY });
        Some(look(on_grid, Watched { flight, forces, sites: order, ends, begins: 0.0 }, &gaps))
    }
}

#[cfg(test)]
mod tests;

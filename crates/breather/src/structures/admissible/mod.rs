//! Is an orbit of a structure physical? Every contact must stay inside its barriers between its impacts: decided by bounds, not samples.
//!
//! Where no mode is far faster than a flight is long, contacts are polynomials on windows (`by_windows`), as a chain's masses are. Otherwise
//! bounds of the acceleration lead from step to step (`by_steps`).

mod by_steps;
mod by_windows;
pub(super) mod passage;
mod release;

use smallvec::SmallVec;
use vibrochain_lattice::Barrier;
use vibrochain_lattice::simd::lanes::Lane;

use super::flight::ContactMotion;
use super::orbit::ContactOrbit;
use super::windows::Windows;
use crate::admissible::answer::{Admissibility, Approach, Obstruction};
use crate::admissible::check::check as check_masses;
use crate::admissible::gap::Depth;
use crate::error::BreatherError;
use crate::orbit::{Impact, time_between};
use release::{Release, TOGETHER};

impl ContactOrbit {
    /// Whether the orbit is physical, with the least distance at a turning point or what is in the way, where it is farthest out: of a lattice among
    /// all its masses; of any other structure contacts stand in place of sites.
    ///
    /// # Errors
    /// [`BreatherError`] at a resonance.
    pub fn admissibility(&self) -> Result<Admissibility, BreatherError> {
        self.checked(Depth::Worst)
    }

    /// The same check as [`ContactOrbit::admissibility`], which ends at the first obstruction that it finds: enough for a cell of a map.
    ///
    /// # Errors
    /// As [`ContactOrbit::admissibility`].
    pub fn first_obstruction(&self) -> Result<Admissibility, BreatherError> {
        self.checked(Depth::First)
    }

    pub(crate) fn checked(&self, depth: Depth) -> Result<Admissibility, BreatherError> {
        check(self, depth)
    }
}

fn check(orbit: &ContactOrbit, depth: Depth) -> Result<Admissibility, BreatherError> {
    if let Some(orbit) = orbit.of_all_masses() {
        return check_masses(&orbit?, depth);
    }
    let impacts = orbit.impacts();
    for (number, impact) in impacts.iter().enumerate() {
        if impact.barrier.sign() * impact.velocity_before <= 0.0 {
            let obstruction = Obstruction::WrongSign {
                impact: number,
                site: impact.site,
                time: impact.time,
                velocity_before: impact.velocity_before,
            };
            return Ok(Admissibility { margin: None, obstruction: Some(obstruction), closest: None });
        }
    }
    let motion = ContactMotion::new(orbit)?;
    let mut clear = SmallVec::new();
    for (number, impact) in impacts.iter().enumerate() {
        match Release::after(orbit, &motion, number)? {
            Release::Leaves(time) => clear.push(time),
            Release::Rests(acceleration_after) => {
                let (site, time) = (impact.site, impact.time);
                let obstruction = Obstruction::Sticking { impact: number, site, time, acceleration_after };
                return Ok(Admissibility { margin: None, obstruction: Some(obstruction), closest: None });
            }
        }
    }
    let (pending, rows) = (Vec::new(), Vec::new());
    let mut search = Search { orbit, motion: &motion, clear, closest: None, pending, rows, depth };
    let (order, view) = &*motion.response().view(orbit.model().structure().contacts());
    // What contacts do in one half of the period they do in the other, backwards.
    let is_mirrored = orbit.is_reversible();
    for i in 0..impacts.len() {
        if motion.until_next(i) <= TOGETHER * orbit.period() || search.is_decided() {
            continue;
        }
        if i > 0 && is_mirrored {
            break;
        }
        let half = if is_mirrored && impacts.len() == 1 { 0.5 } else { 1.0 };
        let whole = half * motion.until_next(i);
        match view.as_ref().and_then(|view| Windows::new(view, &motion, i, whole)) {
            Some(mut windows) => search.by_windows(&mut windows, order, i)?,
            None => search.by_steps(order, i)?,
        }
    }
    let mut closest = search.closest;
    if let Some((_, approach)) = &mut closest {
        approach.time = approach.time.rem_euclid(orbit.period());
    }
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
    orbit: &'a ContactOrbit,
    motion: &'a ContactMotion<'a>,
    /// For how long after each impact its contact is surely off its barrier.
    clear: SmallVec<[f64; 4]>,
    closest: Option<(f64, Approach)>,
    pending: Vec<(f64, f64)>,
    /// Contacts where windows begin and end: work space.
    rows: Vec<Lane>,
    depth: Depth,
}

impl Search<'_> {
    /// Nothing that is still to come changes the answer.
    fn is_decided(&self) -> bool {
        self.depth == Depth::First && self.closest.as_ref().is_some_and(|(least, _)| *least <= 0.0)
    }

    fn note(&mut self, least: f64, (contact, barrier): (usize, Barrier), time: f64) {
        if self.closest.as_ref().is_none_or(|(other, _)| least < *other) {
            self.closest = Some((least, Approach { site: contact, barrier, time }));
        }
    }

    /// The impact of a contact on a barrier at an instant, if there is one.
    fn impact_at(&self, contact: usize, barrier: Barrier, time: f64) -> Option<usize> {
        let (period, impacts) = (self.orbit.period(), self.orbit.impacts());
        let is_there = |impact: &Impact| {
            (impact.site, impact.barrier) == (contact, barrier)
                && time_between(impact.time, time, period) <= TOGETHER * period
        };
        impacts.iter().position(is_there)
    }

    /// For how long after an instant a contact is surely off a barrier that it has just hit; 0 where nothing is known.
    fn clear_after(&self, contact: usize, barrier: Barrier, time: f64) -> f64 {
        self.impact_at(contact, barrier, time).map_or(0.0, |impact| self.clear[impact])
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape};
    use vibrochain_testkit::Random;

    use super::*;
    use crate::structures::model::LoadedStructure;

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
            let model = LoadedStructure::new(structure, random.between(0.5, 3.0)).unwrap();
            let word = random.of(&["0+", "0+,0+", "1-,1+", "0+,1-"]).parse().unwrap();
            let Ok(found) = model.orbits(&word, 1) else { continue };
            for orbit in found.contacts() {
                let answer = orbit.admissibility().unwrap();
                let Some(margin) = answer.margin else { continue };
                let motion = ContactMotion::new(orbit).unwrap();
                let clear = smallvec::smallvec![0.0; orbit.impacts().len()];
                let (pending, rows, depth) = (Vec::new(), Vec::new(), Depth::Worst);
                let mut search = Search { orbit, motion: &motion, clear, closest: None, pending, rows, depth };
                let order = &motion.response().view(model.structure().contacts()).0;
                (0..orbit.impacts().len()).for_each(|i| search.by_steps(order, i).unwrap());
                let Some((stepped, _)) = search.closest else {
                    assert!(margin > 0.0);
                    continue;
                };
                assert_eq!(stepped <= 0.0, margin <= 0.0, "{stepped} {margin} {orbit:?}");
                if margin <= 0.0 {
                    crossing += 1;
                    let quick = orbit.first_obstruction().unwrap();
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

//! Is an orbit of a structure physical? Every contact must stay inside its barriers between its impacts: decided by bounds, not samples.
//!
//! Where no mode is far faster than a flight is long, contacts are polynomials on windows (`admissible/check/modal.rs`). Otherwise
//! bounds of the acceleration lead from step to step (`by_steps`).

mod by_steps;
mod release;

use smallvec::SmallVec;

use super::flight::ContactMotion;
use super::orbit::ContactOrbit;
use crate::admissible::answer::{Admissibility, Obstruction};
use crate::admissible::check::check as check_masses;
use crate::admissible::check::search::{Lists, Search, wrong_sign};
use crate::admissible::gap::Depth;
use crate::error::BreatherError;
use crate::motion::modal::windows::{Room, Windows};
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
    if let Some(wrong) = wrong_sign(impacts) {
        return Ok(Admissibility::barred(wrong));
    }
    let motion = ContactMotion::new(orbit)?;
    let mut clear = SmallVec::new();
    for (number, impact) in impacts.iter().enumerate() {
        match Release::after(orbit, &motion, number)? {
            Release::Leaves(time) => clear.push(time),
            Release::Rests(acceleration_after) => {
                let (site, time) = (impact.site, impact.time);
                return Ok(Admissibility::barred(Obstruction::Sticking {
                    impact: number,
                    site,
                    time,
                    acceleration_after,
                }));
            }
        }
    }
    let contacts = orbit.model().structure().contacts();
    let stops = |contact: usize| [contacts[contact].lower, contacts[contact].upper];
    let mut lists = Lists::default();
    let search = Search::new((impacts, orbit.period()), &stops, depth, orbit.model().stop(), &mut lists);
    let mobility = |contact: usize, other: usize| orbit.model().structure().mobility(contact, other);
    let mut search = search.of_contacts(&mobility, clear);
    let (order, view) = &*motion.response().view(contacts);
    let mut room = Room::default();
    // What contacts do in one half of the period they do in the other, backwards.
    let is_mirrored = orbit.is_reversible();
    for (i, impact) in impacts.iter().enumerate() {
        if motion.until_next(i) <= TOGETHER * orbit.period() {
            continue;
        }
        if search.is_decided() || i > 0 && is_mirrored {
            break;
        }
        let half = if is_mirrored && impacts.len() == 1 { 0.5 } else { 1.0 };
        let whole = half * motion.until_next(i);
        let windows = view.as_ref().and_then(|view| {
            let begin = |both: [&mut [f64]; 2]| motion.begin(view, i, both);
            Windows::new(view, begin, whole, &mut room)
        });
        match windows {
            Some(mut windows) => search.by_modes(&mut windows, order, impact.time)?,
            None => by_steps::search(&mut search, orbit, &motion, order, i)?,
        }
    }
    Ok(Admissibility::of(search.closest, orbit.period()))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vibrochain_lattice::{Barrier, Complex, Contact, LinearMode, ModalStructure, ModeShape};
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
                let contacts = model.structure().contacts();
                let stops = |contact: usize| [contacts[contact].lower, contacts[contact].upper];
                let mut lists = Lists::default();
                let of = (orbit.impacts(), orbit.period());
                let search = Search::new(of, &stops, Depth::Worst, model.stop(), &mut lists);
                let mobility = |contact: usize, other: usize| model.structure().mobility(contact, other);
                let mut search = search.of_contacts(&mobility, clear);
                let order = &motion.response().view(contacts).0;
                let impacts = 0..orbit.impacts().len();
                impacts.for_each(|i| by_steps::search(&mut search, orbit, &motion, order, i).unwrap());
                let stepped = search.closest.distance;
                if !stepped.is_finite() {
                    assert!(margin > 0.0);
                    continue;
                }
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

    /// The margin is the least distance at which a contact turns, its own impacts aside: by samples of the whole period, in which what an impact of
    /// another turns round is a corner.
    #[test]
    fn the_margin_is_of_the_nearest_turn() {
        const SAMPLES: u32 = 2000;
        let mut random = Random(43);
        let (mut checked, mut corners) = (0, 0);
        for _ in 0..600 {
            let model = LoadedStructure::new(Arc::new(structure(&mut random)), random.between(0.5, 3.0)).unwrap();
            let word = random.of(&["0+,1-", "0+,1+", "0+,1-,1+"]).parse().unwrap();
            let Ok(found) = model.orbits(&word, 1) else { continue };
            for orbit in found.contacts() {
                let answer = orbit.admissibility().unwrap();
                let Some(margin) = answer.margin.filter(|_| answer.is_physical()) else { continue };
                let motion = ContactMotion::new(orbit).unwrap();
                let (mut least, mut is_corner) = (f64::INFINITY, false);
                for (contact, stops) in model.structure().contacts().iter().enumerate() {
                    // Places with what is before them: its own impact, one of another, or nothing.
                    let mut places = Vec::new();
                    for (i, impact) in orbit.impacts().iter().enumerate() {
                        places.extend((0..SAMPLES).map(|n| {
                            let s = motion.until_next(i) * f64::from(n) / f64::from(SAMPLES);
                            (motion.contact(contact, i, s)[0], n == 0, n == 0 && impact.site == contact)
                        }));
                    }
                    let count = places.len();
                    for barrier in [Barrier::Lower, Barrier::Upper] {
                        let Some(stop) = stops.barrier(barrier) else { continue };
                        let room = |n: usize| barrier.sign() * (stop - places[n % count].0);
                        for n in 0..count {
                            let (_, at_impact, own) = places[n];
                            let here = room(n);
                            let turns = (here - room(n + count - 1)) * (here - room(n + 1)) >= 0.0;
                            if !own && turns && here < least {
                                (least, is_corner) = (here, at_impact);
                            }
                        }
                    }
                }
                assert!((margin - least).abs() < 1e-4 * (1.0 + least), "{word} {margin} {least} {is_corner}");
                checked += 1;
                corners += usize::from(is_corner);
            }
        }
        assert!(checked > 20 && corners > 0, "{checked} {corners}");
    }
}

//! The search for a closest approach, by bounds that leave no gap.
//!
//! Symmetry halves the work twice: masses n and M − n about a single impacted site, and a conservative orbit's mirror image
//! in time. Then one of two ways:
//!
//! - short flights of a small ring without dashpots, of which one site takes all impacts, are sampled on a grid; each mass has its own bounds between
//!   the nodes (`on_grid`);
//! - all other flights are cut into windows of one radian of the fastest motion, in which each motion is a polynomial, exact to rounding. Masses get
//!   theirs from local series, with bounds of their own (`local`): far from the breather these are small, even where the force moves all masses
//!   close to a barrier. Contacts of any other structure get theirs from its modes (`modal`).
//!
//! Either passes over a mass, or an interval, that cannot come closer than the smallest distance known so far, or cannot
//! have a turning point, and isolates the turning points of what is left (`polynomial`).

mod local;
mod modal;
pub(crate) mod on_grid;
pub(crate) mod search;

use vibrochain_lattice::simd::lanes::Lane;
use vibrochain_lattice::{DistinctMasses, Model, Stop};

use crate::admissible::answer::Admissibility;
use crate::admissible::gap::{Closest, Depth, Gap};
use crate::admissible::grid::{Flight, Forces, MOST_MODES};
use crate::error::BreatherError;
use crate::motion::Motion;
use crate::motion::window::Window;
use crate::orbit::{LatticeOrbit, Orbit, Reflection, SIMULTANEOUS};
use local::Stretch;
use on_grid::{Ends, OnGrid, Watched};
use search::{Lists, Search, wrong_sign};

/// Work space of the check.
#[derive(Debug, Clone, Default)]
pub(crate) struct Watch {
    watched: DistinctMasses,
    window: Window,
    lists: Lists,
    pub(crate) on_grid: OnGrid,
    /// Displacements and velocities of the modes at the start of the flight that the grid takes over.
    start: [Vec<Lane>; 2],
    pub(crate) stop: Stop,
}

impl Watch {
    /// Decides for `orbit`, whose motion `motion` holds.
    pub(crate) fn check(
        &mut self,
        orbit: LatticeOrbit<'_>,
        motion: &mut Motion,
        depth: Depth,
    ) -> Result<Admissibility, BreatherError> {
        if let Some(wrong) = wrong_sign(orbit.impacts()) {
            return Ok(Admissibility::barred(wrong));
        }
        let reflection = orbit.reflection();
        let delayed = reflection.is_some_and(|reflection| reflection.delayed);
        let horizon = match (orbit.is_reversible(), delayed) {
            // What one half of the ring does in one quarter of a period the other does in the next, backwards.
            (true, true) => 0.25 * orbit.period(),
            (true, false) => 0.5 * orbit.period(),
            (false, _) => orbit.period(),
        };
        let mirror = reflection.filter(|_| !delayed).map(|reflection| reflection.mirror);
        self.watched.reset(orbit.model().chain(), mirror);
        let mut closest = self.by_flights(orbit, motion, depth, horizon, true)?;
        // Of two masses that move alike the first one.
        if let Some(mirror) = mirror.filter(|_| orbit.impact_site().is_none()) {
            let image = Reflection { mirror, delayed }.image(closest.site, orbit.model().chain().sites());
            closest.site = image.min(closest.site);
        }
        Ok(Admissibility::of(closest, orbit.period()))
    }

    /// The closest approach of the watched masses as far as `horizon`, flight by flight: where the grid may be taken and is short, on that.
    fn by_flights(
        &mut self,
        orbit: LatticeOrbit<'_>,
        motion: &mut Motion,
        depth: Depth,
        horizon: f64,
        on_grid: bool,
    ) -> Result<Closest, BreatherError> {
        let Self { watched, window, on_grid: by_nodes, start, lists, stop } = self;
        let (model, a) = (orbit.model(), orbit.model().asymmetry());
        let stops = |_| [Some(a - 1.0), Some(a + 1.0)];
        let mut search = Search::new((orbit.impacts(), orbit.period()), &stops, depth, stop, lists);
        let is_few = model.chain().even_modes() <= MOST_MODES && orbit.centre().is_some() && !model.is_damped();
        let forces = Forces::of_ring(model.chain(), watched);
        let is_half = orbit.is_reversible() && horizon == 0.5 * orbit.period();
        local::lay(window, motion, horizon)?;
        for interval in 0..motion.intervals() {
            let (begins, length) = motion.interval(interval);
            if begins >= horizon || search.is_decided() {
                break;
            }
            let whole = length.min(horizon - begins);
            if whole <= SIMULTANEOUS * orbit.period() {
                continue;
            }
            let turns = is_half && begins + whole >= horizon;
            if on_grid && is_few {
                let flight = motion.flight(interval, start);
                if by_nodes.grid.set(flight, forces, whole) {
                    let ends = Ends { one: orbit.impacts().len() == 1, turning: turns };
                    let watched = Watched { flight, forces, sites: watched.sites(), ends, begins };
                    by_nodes.closest(watched, |_| Gap::around(a), depth, &mut search.closest);
                    continue;
                }
            }
            let goes_on = orbit.is_reversible() && !is_half;
            let stretch = Stretch { interval, begins, whole, goes_on, turns };
            search.by_series(orbit, motion, (watched, window), stretch)?;
        }
        Ok(search.closest)
    }

    /// The smallest distance that masses keep from their barriers, or 0 or less where one of them does not, on the flight from the first
    /// impact, of `one` or two, of a conservative breather at site 0 to half a period later; `None` if that needs windows.
    pub(crate) fn margin(&mut self, model: &Model, flight: Flight<'_>, horizon: f64, one: bool) -> Option<f64> {
        self.watched.reset(model.chain(), Some(0));
        let forces = Forces::of_ring(model.chain(), &self.watched);
        if !self.on_grid.grid.set(flight, forces, horizon) {
            return None;
        }
        let mut closest = Closest::NONE;
        let watched =
            Watched { flight, forces, sites: self.watched.sites(), ends: Ends { one, turning: true }, begins: 0.0 };
        self.on_grid.closest(watched, |_| Gap::around(model.asymmetry()), Depth::First, &mut closest);
        Some(closest.distance).filter(|distance| distance.is_finite())
    }
}

/// Checks an orbit: the one-shot form of [`crate::Finder::admissibility`].
///
/// # Errors
/// [`BreatherError::TooStiff`]; [`BreatherError::Resonance`], which an orbit that exists has already passed.
pub fn admissibility(orbit: &Orbit) -> Result<Admissibility, BreatherError> {
    check(orbit, Depth::Worst)
}

/// The same as far as it is asked for.
pub(crate) fn check(orbit: &Orbit, depth: Depth) -> Result<Admissibility, BreatherError> {
    if let Some(contacts) = orbit.contacts() {
        return contacts.checked(depth);
    }
    let lattice = orbit.lattice()?;
    let mut motion = Motion::of(orbit)?;
    Watch::default().check(lattice, &mut motion, depth)
}

#[cfg(test)]
mod tests {
    use vibrochain_lattice::{Chain, Force, Harmonic, Point};

    use super::*;
    use crate::orbit::Family;
    use crate::search::finder::Finder;
    use crate::search::orbit_list::OrbitList;

    /// Random conservative orbits of all kinds: soft and stiff, next to resonance, with and without coupling, physical or not.
    fn orbits(mut visit: impl FnMut(LatticeOrbit<'_>, &mut Motion)) {
        let mut random = fastrand::Rng::with_seed(11);
        let (mut finder, mut found) = (Finder::new(1), OrbitList::default());
        for _ in 0..3000 {
            let sites = [1, 2, 3, 4, 5, 6, 11, 21, 40, 64][random.usize(0..10)];
            let gamma1 = [0.0, 1e-3, 0.2, 0.2, 0.2, 40.0][random.usize(0..6)];
            let gamma2 = [0.0, 1e-9, 0.1, 0.3, 5.0][random.usize(0..5)] * random.f64();
            let Ok(chain) = Chain::new(sites, gamma1, gamma2) else { continue };
            let Ok(model) = Model::conservative(chain, 0.3 + 3.0 * random.f64(), 0.9 * random.f64()) else { continue };
            for family in [Family::DoubleSided, Family::SingleSided] {
                if finder.find(&model, family, &mut found).is_err() {
                    continue;
                }
                for orbit in found.orbits.iter().filter(|orbit| orbit.is_reversible()) {
                    if orbit.impacts().iter().all(|impact| impact.is_right_signed() && impact.impulse.abs() < 1e3) {
                        visit(orbit.lattice().unwrap(), &mut Motion::of(orbit).unwrap());
                    }
                }
            }
        }
    }

    #[test]
    fn grid_and_windows_agree() {
        let (mut watch, mut compared, mut physical) = (Watch::default(), 0, 0);
        orbits(|orbit, motion| {
            let horizon = 0.5 * orbit.period();
            watch.watched.reset(orbit.model().chain(), orbit.centre().map(|centre| 2 * centre));
            let mut start = Default::default();
            let flight = motion.flight(0, &mut start);
            let forces = Forces::of_ring(orbit.model().chain(), &watch.watched);
            if !watch.on_grid.grid.set(flight, forces, horizon) {
                return;
            }
            let gap = Gap::around(orbit.model().asymmetry());
            let ends = Ends { one: orbit.impacts().len() == 1, turning: true };
            let watched = Watched { flight, forces, sites: watch.watched.sites(), ends, begins: 0.0 };
            let [mut grid, mut first] = [Closest::NONE; 2];
            watch.on_grid.closest(watched, |_| gap, Depth::Worst, &mut grid);
            watch.on_grid.closest(watched, |_| gap, Depth::First, &mut first);
            let windows = watch.by_flights(orbit, motion, Depth::Worst, horizon, false).unwrap();
            let size = motion.states_bound().max(1.0);
            let same = (grid.distance - windows.distance).abs() < 1e-13 * size || grid.distance == windows.distance;
            assert!(same, "{} {} {orbit:?}", grid.distance, windows.distance);
            for told in [&grid, &windows].into_iter().filter(|told| told.distance.is_finite()) {
                let there = motion.at(told.site, told.time).displacement;
                let off = (gap.distance(there) - told.distance).abs();
                assert!(off < 1e-13 * size, "{off:e} at {} of {orbit:?}", told.time);
            }
            if windows.distance.abs() > 1e-13 * size {
                assert_eq!(first.distance > 0.0, windows.distance > 0.0, "{orbit:?}");
            }
            compared += 1;
            physical += usize::from(grid.distance > 0.0);
        });
        assert!(compared > 1000 && physical > 200 && physical < compared - 200, "{compared} {physical}");
    }

    /// Under a force, of one harmonic and of two: flights from impact to impact, on the grid with bounds that hold, and by local series.
    #[test]
    fn forced_flights_on_the_grid_are_those_of_windows() {
        let mut random = fastrand::Rng::with_seed(31);
        let (mut finder, mut found, mut watch) = (Finder::new(1), OrbitList::default(), Watch::default());
        let (mut seen, mut bounded) = ([[0; 2]; 2], 0);
        for case in 0..1200 {
            let sites = [1, 2, 5, 6, 11, 21, 40][random.usize(0..7)];
            let chain = Chain::new(sites, [0.0, 0.2, 1.0][random.usize(0..3)], 0.4 * random.f64()).unwrap();
            let (omega, a) = (0.5 + 3.0 * random.f64(), 0.9 * random.f64());
            let second = if case % 2 == 0 { 0.0 } else { 0.3 * random.f64() };
            let harmonics = [(1, 0.5 * random.f64()), (3, second)];
            let harmonics = harmonics.map(|(number, amplitude)| Harmonic { number, amplitude, phase: random.f64() });
            let force = Force::new(&harmonics[..1 + case % 2]).unwrap();
            let point = Point::ring(sites).on(&chain).under(&force).omega(omega).asymmetry(a);
            let Ok(model) = point.restitution(0.5 + 0.5 * random.f64()).model() else { continue };
            for family in [Family::DoubleSided, Family::SingleSided] {
                if finder.find(&model, family, &mut found).is_err() {
                    continue;
                }
                for orbit in &found.orbits {
                    let orbit = orbit.lattice().unwrap();
                    if !orbit.impacts().iter().all(|impact| impact.is_right_signed() && impact.impulse.abs() < 1e3) {
                        continue;
                    }
                    let (mut motion, horizon) = (Motion::of(&orbit).unwrap(), orbit.period());
                    watch.watched.reset(orbit.model().chain(), orbit.centre().map(|centre| 2 * centre));
                    let mut by = |grid| watch.by_flights(orbit, &mut motion, Depth::Worst, horizon, grid).unwrap();
                    let [grid, windows] = [true, false].map(&mut by);
                    let size = motion.states_bound().max(1.0);
                    let same =
                        (grid.distance - windows.distance).abs() < 1e-13 * size || grid.distance == windows.distance;
                    assert!(same, "{} {} {orbit:?}", grid.distance, windows.distance);
                    seen[usize::from(case % 2 == 1)][usize::from(grid.distance > 0.0)] += 1;
                    let copy = motion.clone();
                    let mut start = Default::default();
                    let (begins, length) = copy.interval(0);
                    let flight = copy.flight(0, &mut start);
                    let forces = Forces::of_ring(orbit.model().chain(), &watch.watched);
                    let grid = &mut watch.on_grid.grid;
                    assert_eq!(begins, 0.0);
                    if !grid.set(flight, forces, length) {
                        continue;
                    }
                    let gap = Gap::around(a);
                    for part in 0..20 {
                        motion.seek(0, length * (f64::from(part) + 0.5) / 20.0);
                        for (i, &site) in watch.watched.sites().iter().enumerate().take(4) {
                            let now = motion.site(site);
                            let scale = size * motion.top_frequency().powi(2).max(1.0);
                            assert!(now.acceleration.abs() <= grid.second(i) + 1e-12 * scale, "{site} {now:?}");
                            let left = gap.distance(now.displacement);
                            assert!(grid.reaches(|_| gap)[i] <= left + 1e-13 * size, "{site} {now:?}");
                            bounded += 1;
                        }
                    }
                }
            }
        }
        assert!(seen.as_flattened().iter().all(|&count| count > 30) && bounded > 20_000, "{seen:?} {bounded}");
    }

    /// Pairs and larger words in phase, in turns and without symmetry: half the ring, or a quarter of the period, tells what all
    /// masses do in half a period, or in all of it where the times are not symmetric.
    #[test]
    fn what_a_reflection_leaves_tells_all() {
        let mut random = fastrand::Rng::with_seed(23);
        let (mut finder, mut found, mut watch) = (Finder::new(1), OrbitList::default(), Watch::default());
        let mut seen = [[0; 2]; 3];
        for _ in 0..1500 {
            let sites = random.usize(4..24);
            let [i, j, k] = [(); 3].map(|()| random.usize(0..sites));
            let word = match random.usize(0..6) {
                0 => format!("{i}+{j}+,{i}-{j}-"),
                1 => format!("{i}+{j}-,{i}-{j}+"),
                2 => format!("{i}-,{j}-"),
                3 => format!("{i}-{j}-"),
                4 => format!("{i}+{j}+{k}+,{i}-{j}-{k}-"),
                _ => format!("{i}+{j}+,{i}-"),
            };
            let Ok(word) = word.parse() else { continue };
            let chain = Chain::new(sites, [0.0, 0.2][random.usize(0..2)], 0.2 * random.f64()).unwrap();
            let a = [0.0, 0.3][random.usize(0..2)];
            let model = Model::conservative(chain, 0.4 + 2.5 * random.f64(), a).unwrap();
            if finder.find_word(&model, &word, crate::Scope::All, &mut found).is_err() {
                continue;
            }
            for orbit in &found.orbits {
                let orbit = orbit.lattice().unwrap();
                let sane = |impact: &crate::Impact| impact.is_right_signed() && impact.impulse.abs() < 1e2;
                if orbit.impact_site().is_some() || !orbit.impacts().iter().all(sane) {
                    continue;
                }
                let kind = orbit.reflection().map_or(0, |reflection| 1 + usize::from(reflection.delayed));
                let told = finder.admissibility(&orbit).unwrap();
                let mut motion = Motion::of(&orbit).unwrap();
                watch.watched.reset(orbit.model().chain(), None);
                let horizon = orbit.period() * if orbit.is_reversible() { 0.5 } else { 1.0 };
                let all = watch.by_flights(orbit, &mut motion, Depth::Worst, horizon, false).unwrap();
                let (size, margin) = (motion.states_bound().max(1.0), told.margin.unwrap());
                assert!((margin - all.distance).abs() < 1e-13 * size, "{word} {margin} {} {orbit:?}", all.distance);
                let closest = told.closest.unwrap();
                let there = motion.at(closest.site, closest.time).displacement;
                assert!((Gap::around(a).distance(there) - margin).abs() < 1e-13 * size, "{word} {closest:?}");
                seen[kind][usize::from(told.is_physical())] += 1;
            }
        }
        assert!(seen.as_flattened().iter().all(|&count| count > 15), "{seen:?}");
    }

    /// Next to a resonance one mode swings alone, and turns in the middle of the half period: at a node. By rounding the
    /// turning point was in neither interval, and an obstruction elsewhere was told instead.
    #[test]
    fn a_turning_point_at_a_node_is_seen() {
        let chain = Chain::new(62, 1.476_579_579_125_765, 0.428_386_291_716_417_73).unwrap();
        let model = Model::conservative(chain, 0.701_835_800_484_123_1, 0.104_565_698_832_268_67).unwrap();
        let orbit = crate::breathers(&model, Family::SingleSided).unwrap().orbits.remove(0);
        let mut motion = Motion::of(&orbit).unwrap();
        let middle = Gap::around(model.asymmetry()).distance(motion.at(31, 0.25 * orbit.period()).displacement);
        let found = crate::admissibility(&orbit).unwrap();
        assert!(
            (found.margin.unwrap() - middle).abs() < 1e-14 && found.closest.unwrap().site == 31,
            "{found:?} {middle}"
        );
    }

    #[test]
    fn bounds_of_the_grid_hold_between_its_nodes() {
        let (mut watch, mut checked) = (Watch::default(), 0);
        orbits(|orbit, motion| {
            let horizon = 0.5 * orbit.period();
            watch.watched.reset(orbit.model().chain(), orbit.centre().map(|centre| 2 * centre));
            let (mut start, copy) = (Default::default(), motion.clone());
            let flight = copy.flight(0, &mut start);
            let forces = Forces::of_ring(orbit.model().chain(), &watch.watched);
            let grid = &mut watch.on_grid.grid;
            if checked > 60_000 || !grid.set(flight, forces, horizon) {
                return;
            }
            let size = motion.states_bound().max(1.0) * motion.top_frequency().powi(2).max(1.0);
            let gap = Gap::around(orbit.model().asymmetry());
            for (i, &site) in watch.watched.sites().iter().enumerate().take(8) {
                for part in 0..40 {
                    motion.seek(0, horizon * (f64::from(part) + 0.5) / 40.0);
                    let now = motion.site(site);
                    let second = grid.second(i);
                    assert!(now.acceleration.abs() <= second + 1e-12 * size, "{site} {second} {now:?}");
                    // v⃜ is to v̈ what v̈ is to v; from the modes.
                    let ring = motion.sites();
                    let tau = std::f64::consts::TAU / ring as f64;
                    let shape = |k: usize| (tau * ((k * i) % ring) as f64).cos();
                    let modes = motion.modes().iter().zip(flight.frequencies).enumerate();
                    let fourth: f64 = modes.map(|(k, (mode, rate))| -shape(k) * rate * rate * mode[2]).sum();
                    let rate = motion.top_frequency().powi(2).max(1.0);
                    assert!(fourth.abs() <= grid.fourth(forces, i) + 1e-12 * size * rate, "{site} {fourth} {now:?}");
                    let (reach, left) = (grid.reaches(|_| gap)[i], gap.distance(now.displacement));
                    assert!(reach <= left + 1e-13 * size, "{site} {reach} {now:?}");
                    checked += 1;
                }
            }
        });
        assert!(checked > 20_000);
    }
}

//! By values on a grid of a flight between impacts of one contact, and each mass's own bounds between its nodes.

use vibrochain_lattice::simd::lanes::Lane;

use crate::admissible::gap::{Closest, Depth, Gap, RESOLUTION};
use crate::admissible::grid::{Flight, Forces, Grid, IN_WINDOW};
use crate::motion::polynomial::{Polynomial, turning_points, with_overlap};

/// Intervals before and after a node in which a mass is the polynomial around it: a radian of the fastest motion.
const AROUND: usize = 2;

/// What a flight must know of the impacts at its ends, which are of its first mass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ends {
    /// There is one alone, at its start.
    pub(crate) one: bool,
    /// Every mass turns at both ends, or has a corner, unless it is hit there: the flight is half a period of an orbit that is its own mirror image in
    /// time.
    pub(crate) turning: bool,
}

impl Ends {
    /// Whether a mass is known to turn at either end.
    fn turns(self, mass: usize) -> [bool; 2] {
        [self.turning && mass > 0, self.turning && (mass > 0 || self.one)]
    }
}

/// A flight, and who is looked at in it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Watched<'a> {
    pub(crate) flight: Flight<'a>,
    pub(crate) forces: Forces<'a>,
    /// Numbers of the masses.
    pub(crate) sites: &'a [usize],
    pub(crate) ends: Ends,
    /// When it begins.
    pub(crate) begins: f64,
}

/// A grid of the flight, and work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct OnGrid {
    pub(crate) grid: Grid,
    near: Vec<usize>,
    column: Vec<Lane>,
    pending: Vec<(f64, f64)>,
    around: Around,
}

/// A mass's motion around a node, in units of an interval and of half its gap: of the mass and the node last asked for.
type Around = Option<((usize, usize), Polynomial)>;

/// A mass, and how far it may leave the range of its values at the nodes.
#[derive(Clone, Copy)]
struct Mass<'a> {
    number: usize,
    shapes: &'a [Lane],
    gap: Gap,
    slack: f64,
    /// B₂h²/2, and what rounding makes of values.
    apart: f64,
    resolution: f64,
}

impl<'a> Mass<'a> {
    #[inline]
    fn new(grid: &Grid, number: usize, gap: Gap, shapes: &'a [Lane]) -> Self {
        let (slack, resolution) = (grid.slack(number), RESOLUTION * gap.half);
        Self { number, shapes, gap, slack, apart: 4.0 * slack + resolution, resolution }
    }

    /// Whether it stays farther away than `distance` in an interval with these values at its ends, or has no turning point there.
    #[inline]
    fn is_settled(&self, [here, there]: [f64; 2], distance: f64) -> bool {
        let least = self.gap.distance(here).min(self.gap.distance(there));
        least - self.slack >= distance - self.resolution || (there - here).abs() > self.apart
    }
}

impl OnGrid {
    /// The closest approach in the flight that the grid holds, or one at which a mass is beyond a barrier.
    pub(crate) fn closest(
        &mut self,
        watched: Watched<'_>,
        gap: impl Fn(usize) -> Gap + Copy,
        depth: Depth,
        closest: &mut Closest,
    ) {
        self.at_ends(watched, gap, closest);
        if depth == Depth::First && closest.distance < -RESOLUTION {
            return;
        }
        let Self { grid, near, column, pending, around } = self;
        *around = None;
        let Watched { flight, forces, sites, begins, .. } = watched;
        let last = grid.intervals();
        near.clear();
        let far = |mass: usize| closest.distance - RESOLUTION * gap(mass).half;
        let masses = (0..sites.len()).zip(grid.reaches(gap));
        near.extend(masses.filter(|(mass, reach)| *mass == 0 || **reach < far(*mass)).map(|(mass, _)| mass));
        for &number in &*near {
            let shapes = grid.shapes(flight, forces, number, column);
            let mass = Mass::new(grid, number, gap(number), shapes);
            let mut value = grid.value(number);
            for interval in 0..last {
                let here = std::mem::replace(&mut value, grid.value((interval + 1) * grid.stride() + number));
                let time = || begins + interval as f64 * grid.step();
                // Where it is not hit, any place counts; the ends are noted.
                let distance = mass.gap.distance(here);
                if number > 0 && distance < closest.distance {
                    closest.note(mass.gap, sites[number], time(), here);
                }
                if depth == Depth::First && interval > 0 && distance < -RESOLUTION {
                    closest.note(mass.gap, sites[number], time(), here);
                    return;
                }
                if mass.is_settled([here, value], closest.distance) {
                    continue;
                }
                turn(grid, (pending, around), watched, (&mass, interval), closest);
                if depth == Depth::First && closest.distance <= 0.0 {
                    return;
                }
            }
        }
    }

    /// What is first in the way in the flight that the grid holds: of all places beyond a barrier at its ends, and in the first window in which
    /// there is one, the farthest. Without one the distance is positive.
    pub(crate) fn first_beyond(&mut self, watched: Watched<'_>, gap: impl Fn(usize) -> Gap + Copy) -> Closest {
        let mut closest = Closest::NONE;
        self.at_ends(watched, gap, &mut closest);
        let Self { grid, near, column, pending, around } = self;
        *around = None;
        let Watched { flight, forces, sites, .. } = watched;
        near.clear();
        near.extend((0..sites.len()).zip(grid.reaches(gap)).filter(|(_, reach)| **reach <= 0.0).map(|(mass, _)| mass));
        for interval in 0..grid.intervals() {
            for &number in &*near {
                let values = [interval, interval + 1].map(|node| grid.value(node * grid.stride() + number));
                let limit = closest.distance.min(f64::MIN_POSITIVE);
                if !Mass::new(grid, number, gap(number), &[]).is_settled(values, limit) {
                    let mass = Mass::new(grid, number, gap(number), grid.shapes(flight, forces, number, column));
                    turn(grid, (pending, around), watched, (&mass, interval), &mut closest);
                }
            }
            if (interval + 1).is_multiple_of(IN_WINDOW) && closest.distance <= 0.0 {
                break;
            }
        }
        closest
    }

    /// Takes note of masses at both ends, where they are not hit.
    fn at_ends(&self, watched: Watched<'_>, gap: impl Fn(usize) -> Gap, closest: &mut Closest) {
        let Watched { sites, ends, begins, .. } = watched;
        for (end, node) in [0, self.grid.intervals()].into_iter().enumerate() {
            let hit = usize::from(!ends.turns(0)[end]);
            for (mass, &value) in self.grid.node(node).iter().enumerate().take(sites.len()).skip(hit) {
                if gap(mass).distance(value) < closest.distance {
                    closest.note(gap(mass), sites[mass], begins + node as f64 * self.grid.step(), value);
                }
            }
        }
    }
}

/// Takes note of a mass's turning points in an interval.
fn turn(
    grid: &mut Grid,
    (pending, around): (&mut Vec<(f64, f64)>, &mut Around),
    Watched { forces, sites, ends, begins, .. }: Watched<'_>,
    (&Mass { number, shapes, gap, resolution, .. }, interval): (&Mass<'_>, usize),
    closest: &mut Closest,
) {
    let bounds = (grid.fourth(forces, number), resolution);
    if grid.is_monotone((shapes, number), interval, bounds, ends.turns(number)) {
        return;
    }
    let (last, step) = (grid.intervals(), grid.step());
    let node = last.min(interval - interval % (2 * AROUND) + AROUND);
    let polynomial = match around {
        Some((known, polynomial)) if *known == (number, node) => polynomial,
        _ => &mut around.insert(((number, node), grid.polynomial(shapes, node).over(gap.half))).1,
    };
    let so_far = closest.distance / gap.half;
    let mut note = |s: f64, displacement: f64| {
        closest.note(gap, sites[number], begins + (node as f64 + s) * step, displacement * gap.half);
        closest.distance / gap.half
    };
    let from = interval as f64 - node as f64;
    let range = with_overlap(1.0, [interval > 0, interval + 1 < last]).map(|s| from + s);
    turning_points(polynomial, range, pending, so_far, &mut note, gap.centre / gap.half);
}

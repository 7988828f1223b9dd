//! By values on a grid of a conservative breather's half period, and each mass's own bounds between its nodes.

use super::{Closest, Depth, Impacts, RESOLUTION, Watch, distance};
use crate::admissible::grid::Flight;
use crate::motion::polynomial::{turning_points, with_overlap};

impl Watch {
    /// The flight that `self.grid` holds.
    pub(super) fn on_grid(&mut self, flight: Flight<'_>, impacts: Impacts, depth: Depth, closest: &mut Closest) {
        let Self { watched, grid, pending, near, .. } = self;
        let (a, masses) = (impacts.asymmetry, watched.sites().len());
        let (last, step) = (grid.intervals(), grid.step());
        let time = |node: usize| node as f64 * step;
        let site = |mass: usize| watched.sites()[mass];
        // Every mass turns at both ends, by symmetry, the one that is hit only where it is not.
        let turns = |mass: usize| [mass > 0, mass > 0 || impacts.one];
        for (end, node) in [0, last].into_iter().enumerate() {
            for (mass, &value) in grid.node(node).iter().enumerate().take(masses).skip(usize::from(!turns(0)[end])) {
                if distance(a, value) < closest.distance {
                    closest.note(a, site(mass), time(node), value);
                }
            }
        }
        if depth == Depth::First && closest.distance < -RESOLUTION {
            return;
        }
        near.clear();
        let far = closest.distance - RESOLUTION;
        near.extend(
            (0..masses).zip(grid.reaches(a)).filter(|(mass, reach)| *mass == 0 || **reach < far).map(|(mass, _)| mass),
        );
        for &mass in &*near {
            let (slack, turns) = (grid.slack(mass), turns(mass));
            // B₂h²/2, and what rounding makes of values.
            let apart = 4.0 * slack + RESOLUTION;
            let mut value = grid.value(mass);
            for interval in 0..last {
                let here = std::mem::replace(&mut value, grid.value((interval + 1) * grid.stride() + mass));
                let ends = [here, value].map(|value| distance(a, value));
                // Where it is not hit, any place counts; the ends are noted.
                if mass > 0 && ends[0] < closest.distance {
                    closest.note(a, site(mass), time(interval), here);
                }
                if depth == Depth::First && interval > 0 && ends[0] < -RESOLUTION {
                    closest.note(a, site(mass), time(interval), here);
                    return;
                }
                if ends[0].min(ends[1]) - slack >= closest.distance - RESOLUTION || (value - here).abs() > apart {
                    continue;
                }
                if grid.is_monotone((flight, mass), interval, grid.fourth(flight, watched, mass), turns) {
                    continue;
                }
                let polynomial = grid.polynomial(flight, mass, interval);
                let so_far = closest.distance;
                let mut note = |s: f64, displacement: f64| {
                    closest.note(a, site(mass), time(interval) + s * step, displacement);
                    closest.distance
                };
                let range = with_overlap(1.0, [interval > 0, interval + 1 < last]);
                turning_points(&polynomial, range, pending, so_far, &mut note, a);
                if depth == Depth::First && closest.distance <= 0.0 {
                    return;
                }
            }
        }
    }
}

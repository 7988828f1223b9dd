//! What leaves an orbit as it is: a symmetry of the lattice together with a shift in time, or with its reversal.

use vibrochain_lattice::{Ends, Layout};

use crate::orbit::{LatticeOrbit, SIMULTANEOUS};

/// One of them: where each impact comes to, and whether time is reversed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Symmetry {
    pub(crate) images: Vec<usize>,
    pub(crate) reversed: bool,
}

/// A symmetry of a row of `count` masses: n comes to shift ± n.
#[derive(Debug, Clone, Copy)]
struct Move {
    count: usize,
    shift: usize,
    mirrored: bool,
}

impl Move {
    fn of(self, site: usize) -> usize {
        (self.shift + if self.mirrored { self.count - site } else { site }) % self.count
    }
}

/// Those that bring one place to another.
fn moves(count: usize, ends: Ends, from: usize, to: usize) -> Vec<Move> {
    let all = match ends {
        Ends::Closed => vec![((to + count - from) % count, false), ((to + from) % count, true)],
        Ends::Free | Ends::Fixed => vec![(0, false), (count - 1, true)],
    };
    let moves = all.into_iter().map(|(shift, mirrored)| Move { count, shift, mirrored });
    moves.filter(|one| one.of(from) == to).collect()
}

/// All symmetries of an orbit, the one that moves nothing among them. Impulses and times are compared as those of masses put side by
/// side, which no rounding has driven apart yet.
pub(crate) fn symmetries(orbit: LatticeOrbit<'_>) -> Vec<Symmetry> {
    let impacts = orbit.impacts();
    let layout: Layout = orbit.model().chain().layout();
    let conservative = orbit.is_conservative();
    let (period, clock) = (orbit.period(), orbit.force_period());
    let largest = impacts.iter().fold(0.0, |most: f64, impact| most.max(impact.impulse.abs()));
    let close = |apart: f64, round: f64| (apart - (apart / round).round() * round).abs() <= SIMULTANEOUS * period;
    let mut all: Vec<Symmetry> = Vec::new();
    let Some(first) = impacts.first() else { return all };
    let place = |site: usize| layout.place(site);
    for target in impacts {
        let ((site, layer), (to, to_layer)) = (place(first.site), place(target.site));
        let along = moves(layout.length, layout.ends, site, to);
        let across = moves(layout.layers, layout.layer_ends, layer, to_layer);
        for (along, across) in along.iter().flat_map(|along| across.iter().map(move |across| (along, across))) {
            for reversed in [false, true] {
                // The force tells the time: it is not reversed, nor shifted but by its period.
                if !conservative && (reversed || !close(target.time - first.time, clock)) {
                    continue;
                }
                let image = |impact: &crate::Impact| {
                    let (site, layer) = place(impact.site);
                    let moved = (along.of(site), across.of(layer));
                    let since = impact.time - first.time;
                    let time = target.time + if reversed { -since } else { since };
                    impacts.iter().position(|other| {
                        place(other.site) == moved
                            && other.barrier == impact.barrier
                            && close(other.time - time, period)
                            && (other.impulse - impact.impulse).abs() <= SIMULTANEOUS * largest
                    })
                };
                let Some(images) = impacts.iter().map(image).collect::<Option<Vec<_>>>() else { continue };
                let symmetry = Symmetry { images, reversed };
                if !all.contains(&symmetry) {
                    all.push(symmetry);
                }
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use vibrochain_lattice::{Barrier, Chain, Model};

    use super::*;
    use crate::orbit::{Hit, Orbit};

    #[test]
    fn symmetries_of_the_lattice_and_of_time_are_found() {
        let chain = Chain::new(9, 0.2, 0.05).unwrap();
        let (quiet, forced) = (
            Model::conservative(chain, 1.5, 0.2).unwrap(),
            chain.point().omega(1.5).asymmetry(0.2).amplitude(0.1).restitution(0.9).model().unwrap(),
        );
        let count = |model: &Model, hits: &[(usize, f64, f64)]| {
            let hit = |&(site, turn, impulse): &(usize, f64, f64)| {
                Hit::new(site, Barrier::Lower, turn * model.period(), impulse)
            };
            let hits: Vec<Hit> = hits.iter().map(hit).collect();
            let all = symmetries(Orbit::from_impulses(model, 1, 0.3, &hits).unwrap().lattice().unwrap());
            [false, true].map(|reversed| all.iter().filter(|one| one.reversed == reversed).count())
        };
        // A pair: nothing moves, or both are exchanged; the same in reversed time.
        assert_eq!(count(&quiet, &[(0, 0.0, 1.0), (2, 0.0, 1.0)]), [2, 2]);
        assert_eq!(count(&forced, &[(0, 0.0, 1.0), (2, 0.0, 1.0)]), [2, 0]);
        assert_eq!(count(&quiet, &[(0, 0.0, 1.0), (2, 0.0, 1.1)]), [1, 1]);
        // A wave round the ring has a third of a turn, and reflections that reverse it.
        assert_eq!(count(&quiet, &[(0, 0.0, 1.0), (3, 1.0 / 3.0, 1.0), (6, 2.0 / 3.0, 1.0)]), [3, 3]);
        assert_eq!(count(&forced, &[(0, 0.0, 1.0), (3, 1.0 / 3.0, 1.0), (6, 2.0 / 3.0, 1.0)]), [1, 0]);
        assert_eq!(count(&quiet, &[(0, 0.0, 1.0), (3, 0.2, 1.0), (6, 0.5, 1.0)]), [1, 0]);
        // One mass: its own reflection says nothing new of its impacts.
        assert_eq!(count(&forced, &[(4, 0.0, 1.0)]), [1, 0]);
    }
}

//! The courses of stripes through a window, of which no raster need tell: from rows in which they are found, each followed both ways.

use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};
use vibrochain_breather::Family;
use vibrochain_floquet::StripeFinder;
use vibrochain_lattice::{Parameter, Stop};

use super::lanes::{Lane, Liner, Row};
use super::part::{ClassProbe, Part};
use crate::regions::Window;
use crate::scene::Scene;

/// Rows in which stripes are looked for by themselves, and points of one.
const ROWS: usize = 16;
const ROW_POINTS: usize = 800;

/// Where the stripes of one part are looked for.
pub(super) struct Courses<'a> {
    pub(super) scene: &'a Scene,
    pub(super) window: Window,
    pub(super) part: &'a Part,
    pub(super) family: Family,
    /// How far a chord between two points may be from the edge, as a part of the window's sides.
    pub(super) tolerance: f64,
    pub(super) stop: &'a Stop,
}

/// The family whose stripes are known by their modes, if a part has one.
pub(super) fn striped(scene: &Scene, part: &Part) -> Option<Family> {
    let family = match part.task.families.first() {
        Some(&family @ (Family::DoubleSided | Family::SingleSided)) => family,
        _ => return None,
    };
    (scene.is_conservative() && part.is_strict()).then_some(family)
}

/// Where nothing couples masses, multipliers stand on the circle together: no border, but an end of all of them.
pub(super) fn is_uncoupled(scene: &Scene, place: [f64; 2]) -> bool {
    scene.axes.iter().zip(place).any(|(axis, part)| {
        let coupling = matches!(axis.parameter, Parameter::Gamma2 | Parameter::Gamma3);
        coupling && part == 0.0 && axis.first() == 0.0
    })
}

impl Courses<'_> {
    /// All of them, and what rows could not tell: where along y, and between which values. `told` hears of rows.
    pub(super) fn lanes(&self, told: &dyn Fn(usize, usize)) -> (Vec<Lane>, Vec<(f64, [f64; 2])>) {
        let Self { scene, window, part, family, tolerance, stop } = *self;
        // Both sides, too, but not where nothing couples masses: all modes are one there.
        let rows = (0..=ROWS).map(|row| row as f64 / ROWS as f64);
        let rows: Vec<f64> = rows.filter(|&y| !is_uncoupled(scene, [0.5, y])).collect();
        told(0, rows.len());
        let workers = || (ClassProbe::new(scene, window, stop), StripeFinder::until(stop));
        let rows: Vec<Row> = rows
            .par_iter()
            .map_init(workers, |(probe, finder), &y| {
                if stop.is_raised() {
                    return Row::default();
                }
                Liner { probe, part, finder, family, tolerance }.row(y, (0.0, 1.0), ROW_POINTS)
            })
            .collect();
        let (mut lanes, mut unresolved): (Vec<Lane>, Vec<_>) = (Vec::new(), Vec::new());
        let [from, to] = [0.0, 1.0].map(|x| window.point([x, 0.0])[0]);
        let part_of = |value: f64| (value - from) / (to - from);
        for (done, row) in rows.iter().enumerate() {
            if stop.is_raised() {
                break;
            }
            told(done, rows.len());
            let new = row.stripes.iter().filter(|stripe| {
                let edges = stripe.edges.map(part_of);
                !lanes.iter().any(|lane| {
                    let same = stripe.pair == Some((lane.modes, lane.harmonic));
                    // One with another name is another one, unless both have their width in common.
                    let wide = edges[1] - edges[0] > 10.0 * tolerance;
                    (same || wide) && lane.has(row.y, edges, 3.0 * tolerance)
                })
            });
            let new: Vec<_> = new.collect();
            let more: Vec<Option<Lane>> = new
                .par_iter()
                .map_init(workers, |(probe, finder), stripe| {
                    Liner { probe, part, finder, family, tolerance }.lane(row.y, stripe)
                })
                .collect();
            lanes.extend(more.into_iter().flatten());
            unresolved.extend(row.unresolved.iter().map(|&range| (row.y, range)));
        }
        (lanes, unresolved)
    }
}

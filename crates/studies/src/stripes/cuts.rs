//! Runs of like cells along a row. A stripe does not end where the breather does: past that the same equations have an orbit
//! that would hit or pass a mass, or lies under another family's, and its multipliers go on. So a run is carried on, both ways,
//! for as long as there is a multiplier of its kind, and its line may be out there.

use vibrochain_breather::{Family, Finder, OrbitList};
use vibrochain_cli::stripes::StripeRows;
use vibrochain_floquet::{Analyser, Complex, Mechanism, Tolerance, participating_modes};
use vibrochain_lattice::Stop;

use vibrochain_maps::cell::Class;
use vibrochain_plot::Tile;

/// |μ| − 1 from which a multiplier is off the circle: a dense solver, where one is asked, splits the trivial pair by 1e-7.
const OFF: f64 = 1e-6;

/// The family of a tile's orbit.
pub(super) fn family(tile: &Tile) -> Option<Family> {
    let (family, _) = tile.class?.parts()?;
    Some(family).filter(|family| *family != Family::Word)
}

/// What cells of a run have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Group {
    Unstable(Mechanism),
    Stable,
}

impl Group {
    /// Those of the table, in its order.
    pub(super) const ALL: [Self; 4] = [
        Self::Unstable(Mechanism::NeimarkSacker),
        Self::Unstable(Mechanism::PeriodDoubling),
        Self::Unstable(Mechanism::PlusOne),
        Self::Stable,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Unstable(mechanism) => mechanism.name(),
            Self::Stable => "stable",
        }
    }

    pub(super) fn has(self, tile: &Tile) -> bool {
        match self {
            // Whether a symmetry breaks does not matter to a multiplier's way.
            Self::Unstable(Mechanism::PlusOne) => tile.mechanism.is_some_and(Mechanism::is_through_plus_one),
            Self::Unstable(mechanism) => tile.mechanism == Some(mechanism),
            Self::Stable => matches!(tile.class, Some(Class::StableDouble | Class::StableSingle)),
        }
    }

    /// An orbit with these multipliers belongs to it, too.
    fn goes_on(self, multipliers: &[Complex<f64>]) -> bool {
        let mut off = multipliers.iter().filter(|z| z.norm() > 1.0 + OFF);
        match self {
            Self::Unstable(mechanism) => off.any(|z| Mechanism::of(*z) == mechanism),
            Self::Stable => off.next().is_none(),
        }
    }
}

/// A run of cells of one family and group, side by side in a row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cut {
    pub(super) double: bool,
    pub(super) group: Group,
    pub(super) row: usize,
    /// Its columns.
    pub(super) first: usize,
    pub(super) last: usize,
    /// Those as far as it could be carried on.
    pub(super) from: usize,
    pub(super) to: usize,
}

/// Finds them.
pub(super) struct Carrier {
    finder: Finder,
    found: OrbitList,
    analyser: Analyser,
}

impl Carrier {
    pub(super) fn new(sites: usize, stop: &Stop) -> Self {
        Self { finder: Finder::new(sites).until(stop), found: OrbitList::default(), analyser: Analyser::default() }
    }

    /// All runs in one row; `None` if stopped.
    pub(super) fn cuts(&mut self, map: &StripeRows, tiles: &[Tile], row: usize, of: Family) -> Option<Vec<Cut>> {
        let columns = map.omega.points;
        let group = |column: usize| {
            let tile = tiles.get(map.cell(row, column)).filter(|tile| family(tile) == Some(of))?;
            Group::ALL.into_iter().find(|group| group.has(tile))
        };
        let groups: Vec<Option<Group>> = (0..columns).map(group).collect();
        let mut cuts = Vec::new();
        let mut first = 0;
        for run in groups.chunk_by(|a, b| a == b) {
            let last = first + run.len() - 1;
            if let Some(group) = run.first().copied().flatten() {
                let (mut from, mut to) = (first, last);
                while from > 0 && self.goes_on(map, row, (from, from - 1), of, group) {
                    from -= 1;
                }
                while to + 1 < columns && self.goes_on(map, row, (to, to + 1), of, group) {
                    to += 1;
                }
                cuts.push(Cut { double: of == Family::DoubleSided, group, row, first, last, from, to });
            }
            // A run that was stopped ends short.
            self.finder.stop().heard().ok()?;
            first = last + 1;
        }
        Some(cuts)
    }

    /// From one column to the next one no harmonic of ω passes a mode, where the orbit would begin anew, and the group stays.
    fn goes_on(
        &mut self,
        map: &StripeRows,
        row: usize,
        (here, next): (usize, usize),
        of: Family,
        group: Group,
    ) -> bool {
        let model = |column| map.scene.point(map.cell(row, column) as u64).model().ok();
        let (Some(here), Some(next)) = (model(here), model(next)) else { return false };
        if self.finder.find_symmetric(&next, of, &mut self.found).is_err() {
            return false;
        }
        let passed = |frequency: &f64| (frequency / here.omega()).floor() != (frequency / next.omega()).floor();
        if participating_modes(next.chain(), 0).iter().any(|(_, frequency)| passed(frequency)) {
            return false;
        }
        let Some(orbit) = self.found.orbits.first() else { return false };
        let stability = self.analyser.stability(orbit, &mut self.finder, Tolerance::Rounding);
        stability.is_ok_and(|stability| group.goes_on(&stability.multipliers))
    }
}

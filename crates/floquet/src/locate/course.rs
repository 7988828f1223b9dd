//! What is asked of a bifurcation diagram, and what it holds.

use vibrochain_breather::{Hit, Orbit};
use vibrochain_lattice::{Barrier, Parameter};

use super::answer::{End, Event, Located, Search, Unresolved};
use crate::verdict::{Tolerance, Verdict};

/// Impulses and flights that agree to this part of the largest, and of the period, are those of one orbit, as far as chords between
/// points of a branch tell them.
const ALIKE: f64 = 1e-4;

/// What is asked of a branch.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
pub struct Course {
    /// The parameter that is varied; the orbit has its start.
    pub free: Parameter,
    /// Least value to go to.
    pub from: f64,
    /// Largest value to go to.
    pub to: f64,
    /// The events that are looked for.
    pub events: Vec<Event>,
    /// How often a branch may leave another: 0 for the orbit's own alone.
    pub generations: u32,
    /// What counts as stable.
    pub tolerance: Tolerance,
}

impl Course {
    /// Of the orbit's own branch, over the default range of the parameter ([`Search::new`]), with all events.
    pub fn new(orbit: &Orbit, free: Parameter) -> Self {
        let Search { from, to, .. } = Search::new(orbit, Event::Fold, free);
        Self { free, from, to, events: Event::ALL.to_vec(), generations: 0, tolerance: Tolerance::Rounding }
    }
}

/// A point of a diagram.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct DiagramPoint {
    /// Value of the free parameter.
    pub value: f64,
    /// The orbit.
    #[cfg_attr(feature = "serde", serde(flatten, serialize_with = "crate::serde_impl::of_branch"))]
    pub orbit: Orbit,
    /// Smallest distance of any mass to a barrier, where all impacts are right-signed.
    pub margin: Option<f64>,
    /// Whether it is physical, where that can be told.
    pub physical: Option<bool>,
    /// Its stability, where it can be judged.
    #[cfg_attr(feature = "serde", serde(rename = "stability"))]
    pub verdict: Option<Verdict>,
}

/// What a branch passes.
#[derive(Debug, Clone, PartialEq)]
pub enum Station {
    /// A point.
    Point(DiagramPoint),
    /// An event.
    Event(Located),
}

impl Station {
    /// The value of the parameter, and the orbit.
    fn place(&self) -> (f64, &Orbit) {
        match self {
            Self::Point(point) => (point.value, &point.orbit),
            Self::Event(located) => (located.value, &located.orbit),
        }
    }
}

/// What [`FollowedBranch::is_physical_about`] tells, of stations in any form: `tell` says of one its event, if it is no point, and whether
/// its orbit is physical.
pub fn is_physical_about<S>(stations: &[S], at: usize, tell: impl Fn(&S) -> (Option<Event>, Option<bool>)) -> bool {
    let told = |station: &S| match tell(station) {
        (None, physical) => Some(physical == Some(true)),
        (Some(_), _) => None,
    };
    let grazes = |station: &&S| matches!(tell(station).0, Some(Event::Grazing | Event::Sticking));
    let (before, behind) = stations.split_at(at.min(stations.len()));
    let mut before = before.iter().rev().take_while(|station| !grazes(station));
    let own = behind.first().and_then(told);
    let mut behind = behind.iter().skip(1).take_while(|station| !grazes(station));
    let nearest = [own, before.find_map(told), behind.find_map(told)];
    let itself = stations.get(at).is_some_and(|station| matches!(tell(station), (Some(_), Some(true))));
    nearest.contains(&Some(true)) || itself && nearest == [None; 3]
}

/// Where a branch of a diagram was taken up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Origin {
    /// The branch that it leaves.
    pub branch: usize,
    /// Which of that one's stations is the event at which it does.
    pub station: usize,
}

/// A branch of a diagram.
#[derive(Debug, Clone, PartialEq)]
pub struct FollowedBranch {
    /// Where it leaves another; `None` for the orbit's own.
    pub origin: Option<Origin>,
    /// How many branches lie between it and the orbit's own.
    pub generation: u32,
    /// Points and events in the order of the way, from one end to the other.
    pub stations: Vec<Station>,
    /// Where there may be more events, hidden by rounding.
    pub unresolved: Vec<Unresolved>,
    /// Steps in which a thin stripe may hide. Without loss, those in which Krein signatures do not tell: some next to places where pairs meet. With
    /// losses, those in which rounding leaves open which multipliers cross the circle.
    pub untold: usize,
    /// Where and how the way ends at the first and behind the last station. One that leaves another has its origin first.
    pub ends: Vec<(f64, End)>,
}

impl FollowedBranch {
    /// Its points.
    pub fn points(&self) -> impl Iterator<Item = &DiagramPoint> {
        self.stations.iter().filter_map(|station| match station {
            Station::Point(point) => Some(point),
            Station::Event(_) => None,
        })
    }

    /// Its events.
    pub fn events(&self) -> impl Iterator<Item = &Located> {
        self.stations.iter().filter_map(|station| match station {
            Station::Event(located) => Some(located),
            Station::Point(_) => None,
        })
    }

    /// Whether the orbits just before or just behind a station are physical. At a grazing the one there is a matter of rounding; beyond
    /// another one they are others.
    pub fn is_physical_about(&self, station: usize) -> bool {
        is_physical_about(&self.stations, station, |station| match station {
            Station::Point(point) => (None, point.physical),
            Station::Event(located) => (Some(located.event), located.physical),
        })
    }
}

impl FollowedBranch {
    /// Whether it ends at an event of orbits that repeat or mirror themselves sooner.
    pub(super) fn ends_at(&self, located: &Located) -> bool {
        let same = |one: &Located| {
            one.event == located.event
                && (one.value - located.value).abs() <= ALIKE * ALIKE * located.value.abs() + one.error + located.error
                && are_alike(&one.orbit, &located.orbit)
        };
        self.origin.is_some() && self.events().any(|one| self.ends_on_simpler(one.value) && same(one))
    }

    /// Whether orbits that repeat or mirror themselves sooner end it there.
    pub(super) fn ends_on_simpler(&self, value: f64) -> bool {
        [End::Pitchfork, End::PeriodDoubling].into_iter().any(|end| self.ends.contains(&(value, end)))
    }

    /// Whether an orbit is one of it, or the mirror image of one.
    pub(super) fn holds(&self, value: f64, orbit: &Orbit) -> bool {
        let passed: Vec<(f64, Vec<Trait>)> = self
            .stations
            .iter()
            .map(Station::place)
            .map(|(value, one)| {
                let comparable = one.force_periods() == orbit.force_periods();
                (value, if comparable { traits(one, 1.0) } else { Vec::new() })
            })
            .collect();
        // Where the gap is symmetric, an orbit has a mirror image that hits the other barriers.
        let images = [1.0, -1.0].into_iter().filter(|sign| *sign > 0.0 || orbit.is_centred());
        images.map(|sign| traits(orbit, sign)).any(|sought| {
            let strongest = sought.iter().map(|one| one.impulse.abs()).fold(0.0, f64::max);
            passed.windows(2).any(|pair| {
                let ((low, from), (high, to)) = (&pair[0], &pair[1]);
                let share = if high == low { 0.0 } else { (value - low) / (high - low) };
                let between = |a: f64, b: f64| a + share * (b - a);
                (value - low) * (value - high) <= 0.0
                    && from.len() == sought.len()
                    && to.len() == sought.len()
                    && sought.iter().zip(from.iter().zip(to)).all(|(one, (a, b))| {
                        (a.place, b.place) == (one.place, one.place)
                            && (between(a.impulse, b.impulse) - one.impulse).abs() <= ALIKE * strongest
                            && (between(a.flight, b.flight) - one.flight).abs() <= ALIKE
                    })
            })
        })
    }
}

/// Whether two orbits at one value are the same, or mirror images of each other.
fn are_alike(one: &Orbit, other: &Orbit) -> bool {
    let sought = traits(one, 1.0);
    let strongest = sought.iter().map(|one| one.impulse.abs()).fold(0.0, f64::max);
    let images = [1.0, -1.0].into_iter().filter(|sign| *sign > 0.0 || other.is_centred());
    one.force_periods() == other.force_periods()
        && images.map(|sign| traits(other, sign)).any(|found| {
            found.len() == sought.len()
                && found.iter().zip(&sought).all(|(a, b)| {
                    a.place == b.place
                        && (a.impulse - b.impulse).abs() <= ALIKE * strongest
                        && (a.flight - b.flight).abs() <= ALIKE
                })
        })
}

/// What tells an impact from others, whichever the orbit begins with.
struct Trait {
    place: (usize, bool),
    impulse: f64,
    /// Time to the orbit's next impact, as a part of the period.
    flight: f64,
}

/// Those of an orbit, or of its mirror image in space.
fn traits(orbit: &Orbit, sign: f64) -> Vec<Trait> {
    let (hits, period) = (orbit.hits(), orbit.period());
    let next = |i: usize| hits.get(i + 1).map_or_else(|| hits[0].time + period, |hit| hit.time);
    let of = |(i, hit): (usize, &Hit)| Trait {
        place: (hit.site, (hit.barrier == Barrier::Upper) == (sign > 0.0)),
        impulse: sign * hit.impulse,
        flight: (next(i) - hit.time) / period,
    };
    let mut traits: Vec<Trait> = hits.iter().enumerate().map(of).collect();
    traits.sort_by(|a, b| a.place.cmp(&b.place).then(a.impulse.total_cmp(&b.impulse)));
    traits
}

/// A bifurcation diagram.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct Diagram {
    /// The orbit's own branch first, then those that leave it, then those that leave these.
    pub branches: Vec<FollowedBranch>,
    /// Events at which no branch could be taken up, though one was looked for.
    pub dead_ends: Vec<Origin>,
    /// All branches were followed: not more left than are ever looked at.
    pub complete: bool,
    /// Orbits assembled.
    pub evaluations: usize,
    /// Eigenvalue problems solved.
    pub spectra: usize,
}

impl Diagram {
    /// The event at a station, if it is one.
    pub fn event_at(&self, origin: Origin) -> Option<&Located> {
        match self.branches.get(origin.branch)?.stations.get(origin.station)? {
            Station::Event(located) => Some(located),
            Station::Point(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_breather::{Family, breathers};
    use vibrochain_lattice::{Chain, Model};

    use super::*;

    /// In an asymmetric gap no two orbits are images of each other.
    #[test]
    fn an_orbit_is_alike_to_itself_alone() {
        let mut compared = 0;
        for omega in [1.2, 1.5, 1.9] {
            let model = Model::conservative(Chain::new(5, 0.2, 0.1).unwrap(), omega, 0.4).unwrap();
            let lists = [Family::DoubleSided, Family::SingleSided].map(|family| breathers(&model, family).unwrap());
            let orbits: Vec<_> = lists.iter().flat_map(|list| &list.orbits).collect();
            for (i, one) in orbits.iter().enumerate() {
                for (j, other) in orbits.iter().enumerate() {
                    assert_eq!(are_alike(one, other), i == j, "{omega}: {i} {j}");
                    compared += 1;
                }
            }
        }
        assert!(compared >= 12, "{compared}");
    }
}

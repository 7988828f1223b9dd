//! One cell of a map: a parameter point and what lives there.

use serde::Serialize;
use vibrochain_breather::{BreatherError, Completeness, Family, Finder, MapSearch, Orbit, OrbitList, Scope, Word};
use vibrochain_floquet::{Analyser, Collision, DressedModes, FloquetError, Mechanism, Tolerance, Verdict};
use vibrochain_lattice::{Model, Stop};

use crate::absence::Absence;
use crate::first_obstruction::FirstObstruction;
use crate::standing::Standing;

/// What a map is asked to compute.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// Families to look for: double-sided, single-sided.
    pub families: Vec<Family>,
    /// Impact words that are no family's.
    pub words: Vec<Word>,
    /// Whether conservative double-sided orbits with φ ≠ T/2 are left out.
    pub symmetric: bool,
    /// Whether stability is wanted; existence alone is cheaper.
    pub stability: bool,
    /// From which excess an orbit counts as unstable.
    pub tolerance: Tolerance,
    /// Whether the modes that have collided are wanted, of conservative orbits.
    pub collisions: bool,
    /// Whether tables have a column for the strongest impulse.
    pub impulse: bool,
}

/// What a scene calls the double-sided family without conservative orbits with φ ≠ T/2.
pub const SYMMETRIC: &str = "double-sided-symmetric";

impl Task {
    /// The families as a scene names them.
    pub fn family_names(&self) -> impl Iterator<Item = String> + '_ {
        let name = |family: &Family| match family {
            Family::DoubleSided if self.symmetric => SYMMETRIC,
            family => family.name(),
        };
        self.families.iter().map(move |family| name(family).to_owned()).chain(self.words.iter().map(Word::to_string))
    }
}

/// Existence and stability in one word, the `class` column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Class {
    /// No physical breather.
    None,
    /// A stable double-sided breather.
    StableDouble,
    /// A stable single-sided breather.
    StableSingle,
    /// Double-sided, unstable.
    UnstableDouble,
    /// Single-sided, unstable.
    UnstableSingle,
    /// Double-sided, stability not asked for.
    Double,
    /// Single-sided, stability not asked for.
    Single,
    /// A stable breather of another word.
    StableWord,
    /// Of another word, unstable.
    UnstableWord,
    /// Of another word, stability not asked for.
    Word,
}

vibrochain_lattice::names!(Class {
    None "none", StableDouble "stable-double", StableSingle "stable-single", UnstableDouble "unstable-double",
    UnstableSingle "unstable-single", Double "double", Single "single", StableWord "stable-word",
    UnstableWord "unstable-word", Word "word",
});

impl Class {
    fn of(family: Family, stable: Option<bool>) -> Self {
        match (family, stable) {
            (Family::SingleSided, Some(true)) => Self::StableSingle,
            (Family::SingleSided, Some(false)) => Self::UnstableSingle,
            (Family::SingleSided, None) => Self::Single,
            (Family::Word, Some(true)) => Self::StableWord,
            (Family::Word, Some(false)) => Self::UnstableWord,
            (Family::Word, None) => Self::Word,
            (_, Some(true)) => Self::StableDouble,
            (_, Some(false)) => Self::UnstableDouble,
            (_, None) => Self::Double,
        }
    }

    /// The family of the breather that gives the class, and whether it is stable where that was asked; `None` without a breather.
    #[must_use]
    pub fn parts(self) -> Option<(Family, Option<bool>)> {
        let families = [Family::DoubleSided, Family::SingleSided, Family::Word].into_iter();
        let mut all = families.flat_map(|family| [Some(true), Some(false), None].map(|stable| (family, stable)));
        all.find(|&(family, stable)| Self::of(family, stable) == self)
    }
}

/// Whether a cell is what it seems, the `status` column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Status {
    /// Computed.
    Ok,
    /// A harmonic meets a mode: no periodic motion is defined.
    Resonance,
    /// Computed, but orbits that the scene leaves out, or that no search reaches, could live here.
    Incomplete,
    /// Computed, but two orbits may have merged closer than rounding can tell (a fold), or the search for solutions was
    /// cut short (hundreds of them at very low frequency).
    Unresolved,
    /// The excess of an orbit that could decide the class is closer to the border of stability than its own error: the
    /// class is not known.
    Undecided,
    /// An eigenvalue iteration did not converge; the class is not known.
    NotConverged,
    /// An impact grazes: its saltation matrix is not finite; the class is not known.
    IllConditioned,
    /// The ring is too large for the stability analysis; the class is not known.
    TooLarge,
    /// The fastest mode swings too often in a period for every mass to be followed; the class is not known.
    TooStiff,
}

vibrochain_lattice::names!(Status {
    Ok "ok", Resonance "resonance", Incomplete "incomplete", Unresolved "unresolved", Undecided "undecided" | "marginal",
    NotConverged "not-converged", IllConditioned "ill-conditioned", TooLarge "too-large", TooStiff "too-stiff",
});

impl Status {
    /// What is known of a list of orbits says so much of their cell.
    #[must_use]
    pub fn of_list(completeness: Completeness) -> Self {
        match completeness {
            completeness if completeness.is_established() => Self::Ok,
            Completeness::Open { .. } => Self::Unresolved,
            _ => Self::Incomplete,
        }
    }

    fn of_orbit(error: &BreatherError) -> Self {
        match error {
            BreatherError::Resonance(_) => Self::Resonance,
            BreatherError::TooStiff { .. } | BreatherError::LongFlight { .. } => Self::TooStiff,
            BreatherError::NotConverged { .. } => Self::NotConverged,
            // None can happen to a validated model and word, without a flag; the cell is marked, not dropped.
            _ => Self::IllConditioned,
        }
    }

    fn of(error: &FloquetError) -> Self {
        match error {
            FloquetError::Grazing { .. } => Self::IllConditioned,
            FloquetError::NotConverged { .. } => Self::NotConverged,
            FloquetError::TooLarge { .. } | FloquetError::TooManyModes { .. } => Self::TooLarge,
            FloquetError::Uncounted(_) => Self::NotConverged,
            FloquetError::Breather(error) => Self::of_orbit(error),
        }
    }
}

/// The result at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// The class; `None` where it could not be decided (see `status`).
    pub class: Option<Class>,
    /// How the orbit that gives the class loses stability, if it does.
    pub mechanism: Option<Mechanism>,
    /// Its spectral radius.
    pub spectral_radius: Option<f64>,
    /// Its margin: the smallest distance left to a barrier at a turning point.
    pub margin: Option<f64>,
    /// The strongest of its impulses, as it is signed.
    pub impulse: Option<f64>,
    /// Number of physical orbits of the families asked for.
    pub solutions: u32,
    /// Whether all of this could be computed.
    pub status: Status,
    /// Largest residual of the physical orbits.
    pub residual: f64,
    /// Which modes have collided, where that was asked for.
    pub collision: Option<Collision>,
    /// Why it has no physical orbit, where maps tell that: those of structures do.
    pub absence: Option<Absence>,
    /// What is in the way of its first candidate.
    pub obstruction: Option<FirstObstruction>,
}

impl Cell {
    /// Where nothing lives.
    pub const EMPTY: Self = Self {
        class: Some(Class::None),
        mechanism: None,
        spectral_radius: None,
        margin: None,
        impulse: None,
        solutions: 0,
        status: Status::Ok,
        residual: 0.0,
        collision: None,
        absence: None,
        obstruction: None,
    };

    /// With what the best of its orbits says, if there is one.
    fn of_best(mut self, best: Option<Candidate>) -> Self {
        let unknown = self.status >= Status::NotConverged;
        match best {
            // An orbit whose stability is unknown could still be the stable one that wins.
            Some(best) if !unknown || best.standing.verdict.is_some_and(|verdict| verdict.stable) => {
                let verdict = best.standing.verdict;
                if verdict.is_some_and(|verdict| verdict.undecided) {
                    self.class = None;
                    self.status = Status::Undecided;
                } else {
                    self.class = Some(Class::of(best.family, verdict.map(|verdict| verdict.stable)));
                }
                self.mechanism = verdict.and_then(|verdict| verdict.mechanism);
                self.spectral_radius = verdict.map(|verdict| verdict.spectral_radius);
                self.margin = best.margin;
                self.impulse = best.impulse;
                self.collision = best.collision;
            }
            _ if unknown => self.class = None,
            _ => {}
        }
        self
    }
}

/// A candidate for the orbit that gives a cell its class.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    family: Family,
    standing: Standing,
    margin: Option<f64>,
    impulse: Option<f64>,
    collision: Option<Collision>,
}

/// Work space for cells, one a thread.
#[derive(Debug, Clone)]
pub struct Worker {
    finder: Finder,
    analyser: Analyser,
    found: OrbitList,
    modes: DressedModes,
}

impl Worker {
    /// For rings of `sites` masses.
    pub fn new(sites: usize) -> Self {
        Self {
            finder: Finder::new(sites),
            analyser: Analyser::default(),
            found: OrbitList::default(),
            modes: DressedModes::default(),
        }
    }

    /// The same worker, whose work ends soon after `stop` is raised: a cell computed then, or next, is none.
    #[must_use]
    pub fn until(mut self, stop: &Stop) -> Self {
        self.finder = self.finder.until(stop);
        self
    }

    /// Computes one cell.
    pub fn cell(&mut self, model: &Model, task: &Task) -> Cell {
        self.of_map_breathers(model, task).unwrap_or_else(|| self.examine(model, task, |_, _| {}))
    }

    /// The cell from [`vibrochain_breather::MapBreather`]s, which take half the time of their orbits; `None` where they cannot tell all of it.
    /// The general path, which this is held against, is [`Worker::examine`].
    fn of_map_breathers(&mut self, model: &Model, task: &Task) -> Option<Cell> {
        if !model.is_conservative() || !task.words.is_empty() || task.collisions {
            return None;
        }
        let mut cell = Cell::EMPTY;
        let mut best: Option<Candidate> = None;
        for (word, &family) in task.families.iter().enumerate() {
            let breather = match self.finder.map_breather(model, family) {
                MapSearch::Open => return None,
                MapSearch::None => continue,
                MapSearch::One(breather) => breather,
            };
            cell.solutions += 1;
            cell.residual = cell.residual.max(breather.residual());
            let keeps = |best: &Candidate| best.standing.keeps_its_place((word, true), task.tolerance, |_| false);
            if task.stability && best.as_ref().is_some_and(keeps) {
                continue;
            }
            let verdict = match task.stability {
                true => Some(self.analyser.map_verdict(model, &breather, task.tolerance)?),
                false => None,
            };
            let (margin, impulse) = (Some(breather.margin()), Some(breather.strongest_impulse()));
            let candidate =
                Candidate { family, standing: Standing { word, verdict }, margin, impulse, collision: None };
            if best.as_ref().is_none_or(|best| candidate.standing.beats(&best.standing)) {
                best = Some(candidate);
            }
        }
        Some(cell.of_best(best))
    }

    /// Computes one cell, and shows every physical orbit of it; with `true` one that is the best so far: the last of these gives
    /// the cell its class.
    pub fn examine(&mut self, model: &Model, task: &Task, mut show: impl FnMut(&Orbit, bool)) -> Cell {
        let mut cell = Cell::EMPTY;
        let mut best: Option<Candidate> = None;
        let wanted = if task.symmetric { Scope::SymmetricCandidates } else { Scope::Candidates };
        let families = task.families.iter().map(|&family| (family, None));
        let words = task.words.iter().map(|word| (Family::Word, Some(word)));
        for (number, (family, word)) in families.chain(words).enumerate() {
            let searched = match word {
                None => self.finder.search(model, family, wanted, &mut self.found),
                Some(word) => self.finder.find_word(model, word, wanted, &mut self.found),
            };
            match searched {
                Ok(()) => {}
                Err(error) => {
                    let status = Status::of_orbit(&error);
                    let class = if status == Status::Resonance { Some(Class::None) } else { None };
                    return Cell { class, status, ..cell };
                }
            }
            cell.status = cell.status.max(Status::of_list(self.found.completeness));
            for orbit in &self.found.orbits {
                let admissibility = match self.finder.quick_admissibility(orbit) {
                    Ok(admissibility) => admissibility,
                    Err(error) => {
                        cell.status = cell.status.max(Status::of_orbit(&error));
                        continue;
                    }
                };
                if !admissibility.is_physical() {
                    continue;
                }
                cell.solutions += 1;
                cell.residual = cell.residual.max(orbit.residual());
                // One that is no better than another needs no verdict.
                let (analyser, finder) = (&mut self.analyser, &mut self.finder);
                let exceeds = |reach| analyser.surely_exceeds(orbit, finder, reach).is_ok_and(|beyond| beyond);
                let other = (number, model.is_conservative());
                if best
                    .as_ref()
                    .filter(|_| task.stability)
                    .is_some_and(|best| best.standing.keeps_its_place(other, task.tolerance, exceeds))
                {
                    show(orbit, false);
                    continue;
                }
                let verdict = if task.stability {
                    match self.analyser.verdict(orbit, &mut self.finder, task.tolerance) {
                        Ok(verdict) => Some(verdict),
                        Err(error) => {
                            cell.status = cell.status.max(Status::of(&error));
                            continue;
                        }
                    }
                } else {
                    None
                };
                let collision = match verdict.filter(|verdict| task.collisions && verdict.mechanism.is_some()) {
                    Some(verdict) => collision(&mut self.modes, &mut self.finder, orbit, &verdict),
                    None => None,
                };
                let (margin, impulse) = (admissibility.margin, orbit.strongest_impulse());
                let standing = Standing { word: number, verdict };
                let candidate = Candidate { family, standing, margin, impulse, collision };
                let better = best.as_ref().is_none_or(|best| candidate.standing.beats(&best.standing));
                show(orbit, better);
                if better {
                    best = Some(candidate);
                }
            }
        }
        cell.of_best(best)
    }
}

/// The modes whose collision has made an orbit unstable. That none can be named is no failure of the cell.
fn collision(modes: &mut DressedModes, finder: &mut Finder, orbit: &Orbit, verdict: &Verdict) -> Option<Collision> {
    modes.replace(finder.prepared(orbit).ok()?).ok()?;
    modes.collision(verdict.leading)
}

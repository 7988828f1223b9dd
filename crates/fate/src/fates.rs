//! Ensembles over a scene: many runs from the breathers of every cell, on many threads, in an order that does not depend on them.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};

use rayon::iter::{IntoParallelRefIterator, ParallelBridge, ParallelIterator};
use vibrochain_breather::{Finder, Orbit, Word};
use vibrochain_floquet::{Analyser, Stability, Tolerance};
use vibrochain_lattice::Stop;
use vibrochain_maps::cell::{Cell, Worker};
use vibrochain_maps::grid::Grid;
use vibrochain_maps::scene::Scene;
use vibrochain_maps::summary::Summary;
use vibrochain_maps::sweep::{Ended, Job};

use crate::end::End;
use crate::ensemble::Ensemble;
use crate::exponent::{Measured, measure_from};
use crate::run::{Fate, Home};

/// Runs of a block of cells, at whose end threads wait for each other: a hundred kilobytes, and a second of work or more.
const BLOCK: u64 = 512;

/// Periods of a breather over which its exponent is measured at most, where no more than its directions settle.
const MEASURED: u64 = 2000;

/// From which breathers of a cell runs start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum From {
    /// The one that gives the cell its class: a stable one, if there is one.
    #[default]
    Class,
    /// Every physical one.
    Every,
    /// Every one that is unstable.
    Unstable,
    /// None: of a structure, rest under its static load.
    Rest,
}

vibrochain_lattice::names!(From { Class "class", Every "every", Unstable "unstable", Rest "rest" });

/// What has become of the runs from one breather.
#[derive(Debug, Clone, PartialEq)]
pub struct BreatherFates {
    /// Its number among the physical breathers of the cell, from 1.
    pub number: u32,
    /// Its family, or its word.
    pub name: String,
    /// Its spectral radius, where that is known.
    pub spectral_radius: Option<f64>,
    /// ln|μ|/T of its largest multiplier, those that feel no impact included: the exponent predicted.
    pub predicted: Option<f64>,
    /// The exponent measured along it, and its error.
    pub measured: Option<(f64, f64)>,
    /// Runs of each kind of end, in the order of [`End::NAMES`].
    pub ends: [u32; End::NAMES.len()],
    /// Words of other breathers that runs have come to, and how many each.
    pub words: BTreeMap<Word, u32>,
    /// Runs that have left it.
    pub left: u32,
    /// Their mean time to leave, in periods of the force, and its standard error if there are two or more.
    pub leave_time: Option<(f64, Option<f64>)>,
    /// Mean largest exponent of the chaotic ends.
    pub chaos_exponent: Option<f64>,
}

impl BreatherFates {
    /// The most frequent kind of end, the first of equals; none without runs.
    #[must_use]
    pub fn dominant(&self) -> Option<usize> {
        let most = self.ends.iter().max().filter(|most| **most > 0)?;
        self.ends.iter().position(|count| count == most)
    }

    /// The share of the runs that end so, by the number of its kind in [`End::NAMES`].
    #[must_use]
    pub fn share(&self, kind: usize) -> f64 {
        f64::from(self.ends[kind]) / f64::from(self.runs().max(1))
    }

    /// The words of other breathers with their numbers of runs, as tables have them: "0+,0- 3; 0-,0- 1".
    #[must_use]
    pub fn words_text(&self) -> String {
        self.words.iter().map(|(word, count)| format!("{word} {count}")).collect::<Vec<_>>().join("; ")
    }

    /// Runs in all.
    #[must_use]
    pub fn runs(&self) -> u32 {
        self.ends.iter().sum()
    }

    fn of(departure: &Departure, measured: Option<Measured>, fates: &[Fate]) -> Self {
        let mut words = BTreeMap::new();
        let mut ends = [0; End::NAMES.len()];
        for fate in fates {
            ends[fate.end.kind()] += 1;
            if let End::Periodic(word) = &fate.end {
                *words.entry(word.clone()).or_default() += 1;
            }
        }
        let times: Vec<f64> = fates.iter().filter_map(|fate| fate.left).collect();
        let chaotic = fates.iter().filter(|fate| fate.end == End::Chaos);
        let exponents: Vec<f64> = chaotic.filter_map(|fate| Some(fate.exponent?.value)).collect();
        Self {
            number: departure.number,
            name: departure.name.clone(),
            spectral_radius: departure.spectral_radius,
            predicted: departure.predicted,
            measured: measured.map(|measured| (measured.value, measured.error)),
            ends,
            words,
            left: times.len() as u32,
            leave_time: mean(&times),
            chaos_exponent: mean(&exponents).map(|(mean, _)| mean),
        }
    }
}

/// Mean and standard error of the mean.
fn mean(values: &[f64]) -> Option<(f64, Option<f64>)> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let scatter = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    match values.len() {
        0 => None,
        1 => Some((mean, None)),
        _ => Some((mean, Some((scatter / (n * (n - 1.0))).sqrt()))),
    }
}

/// A cell, and what becomes of what lives there.
#[derive(Debug, Clone, PartialEq)]
pub struct CellFates {
    /// Its number in the scene.
    pub number: u64,
    /// What a sweep finds there.
    pub cell: Cell,
    /// Those of its breathers that were asked for.
    pub breathers: Vec<BreatherFates>,
}

/// A breather with all that its runs need.
pub(crate) struct Departure {
    pub(crate) number: u32,
    pub(crate) name: String,
    pub(crate) spectral_radius: Option<f64>,
    pub(crate) predicted: Option<f64>,
    /// Whether runs start on an orbit, whose exponent can be measured.
    pub(crate) measured: bool,
    pub(crate) home: Home,
}

impl Departure {
    /// From an orbit of this period, as far as its stability is known.
    pub(crate) fn of(number: u32, name: String, known: Option<&Stability>, period: f64, home: Home) -> Self {
        let spectral_radius = known.map(|known| known.verdict.spectral_radius);
        let predicted = known.and_then(|known| predicted(known, period));
        Self { number, name, spectral_radius, predicted, measured: true, home }
    }
}

/// A cell before its runs.
pub struct Found {
    pub(crate) cell: Cell,
    pub(crate) departures: Vec<Departure>,
}

/// A scene from whose cells runs start.
pub trait Ensembled: Grid {
    /// Whether an ensemble can be run over it.
    ///
    /// # Errors
    /// What is missing or out of range.
    fn takes(&self, ensemble: &Ensemble, from: From) -> Result<(), String>;

    /// What lives in a cell, and whence runs start. `None` if stopped.
    fn find(&self, cell: u64, from: From, worker: &mut Self::Worker, stop: &Stop) -> Option<Found>;
}

/// What one thread does at a time.
enum Work {
    Measure,
    Run(u64),
}

/// What came of it.
enum Done {
    Measured(Option<Measured>),
    Run(Fate),
}

/// Computes all cells of a scene and hands them to `sink` in order. `tick` is called, from any thread, with each number of runs that is
/// done, of as many as cells times starts.
///
/// What is handed on is the same for any number of threads: every run has a seed of its own, [`Ensemble::seed_of`].
pub fn fates<S: Ensembled, E>(
    job: &Job<'_, S>,
    ensemble: &Ensemble,
    from: From,
    tick: impl Fn(u64) + Sync,
    mut sink: impl FnMut(CellFates) -> Result<(), E>,
) -> Ended<E> {
    let whole = 0..job.scene.cells();
    of_parts(job, (ensemble, from), &[whole], tick, |_, _, cell| sink(cell))
}

/// As [`fates()`], of the cells of `parts`. `sink` learns which of the parts a cell is of, and whether it is its last.
pub(crate) fn of_parts<S: Ensembled, E>(
    job: &Job<'_, S>,
    (ensemble, from): (&Ensemble, From),
    parts: &[Range<u64>],
    tick: impl Fn(u64) + Sync,
    mut sink: impl FnMut(usize, bool, CellFates) -> Result<(), E>,
) -> Ended<E> {
    // Blocks go on over the ends of parts, which may be shorter than what keeps many threads at work.
    let block = (BLOCK / ensemble.starts.max(1)).max(1) as usize;
    let of_part = |(part, cells): (usize, &Range<u64>)| {
        let end = cells.end;
        cells.clone().map(move |cell| Place { part, last: cell + 1 == end, cell })
    };
    let mut places = parts.iter().enumerate().flat_map(of_part);
    let mut total = Summary::default();
    loop {
        let places: Vec<Place> = places.by_ref().take(block).collect();
        if places.is_empty() {
            return Ended::Complete(total);
        }
        let ended = of_block(job, (ensemble, from), &places, &tick, |place, cell| {
            total.count(&cell.cell);
            sink(place.part, place.last, cell)
        });
        match ended {
            Ended::Complete(()) => {}
            Ended::Stopped => return Ended::Stopped,
            Ended::Failed(error) => return Ended::Failed(error),
        }
    }
}

/// A cell of one of several parts.
struct Place {
    part: usize,
    last: bool,
    cell: u64,
}

/// What comes in any order, in its own.
struct InOrder<T> {
    receiver: Receiver<(usize, T)>,
    waiting: BTreeMap<usize, T>,
    next: usize,
}

impl<T> Iterator for InOrder<T> {
    type Item = T;

    fn next(&mut self) -> Option<T> {
        while !self.waiting.contains_key(&self.next) {
            let (place, item) = self.receiver.recv().ok()?;
            self.waiting.insert(place, item);
        }
        self.next += 1;
        self.waiting.remove(&(self.next - 1))
    }
}

/// Computes the cells of one block, and hands on each as soon as it and those before it are finished: whoever keeps them loses
/// little by a kill.
fn of_block<S: Ensembled, E>(
    job: &Job<'_, S>,
    (ensemble, from): (&Ensemble, From),
    places: &[Place],
    tick: &(impl Fn(u64) + Sync),
    mut sink: impl FnMut(&Place, CellFates) -> Result<(), E>,
) -> Ended<E, ()> {
    let Job { scene, pool, stop } = *job;
    let find = |worker: &mut S::Worker, place: &Place| {
        let found = scene.find(place.cell, from, worker, stop)?;
        if found.departures.is_empty() {
            tick(ensemble.starts);
        }
        Some(found)
    };
    let found: Vec<Option<Found>> = pool.install(|| places.par_iter().map_init(|| scene.worker(stop), find).collect());
    let mut work: Vec<(&Departure, u64, u64, Work)> = Vec::new();
    for (found, place) in found.iter().zip(places) {
        for (breather, departure) in (0..).zip(found.iter().flat_map(|found| &found.departures)) {
            work.push((departure, place.cell, breather, Work::Measure));
            work.extend((0..ensemble.starts).map(|start| (departure, place.cell, breather, Work::Run(start))));
        }
    }
    let closed = AtomicBool::new(false);
    let run = |(departure, cell, breather, work): (&Departure, u64, u64, Work)| -> Option<Done> {
        if closed.load(Ordering::Relaxed) {
            return None;
        }
        let start = match work {
            Work::Measure => {
                let measure = || measure_from(&departure.home.origin, MEASURED, stop).ok();
                let measured = if departure.measured { measure() } else { None };
                return (!stop.is_raised()).then_some(Done::Measured(measured));
            }
            Work::Run(start) => start,
        };
        let seed = ensemble.seed_of(cell, departure.number.into(), start);
        let fate = departure.home.run(ensemble, seed, stop)?;
        if breather == 0 {
            tick(1);
        }
        Some(Done::Run(fate))
    };
    // Whoever collects may have gone.
    let each = |sender: &mut Sender<_>, (place, work)| drop(sender.send((place, run(work))));
    pool.in_place_scope(|scope| {
        let (sender, receiver) = channel();
        let each = &each;
        // Taken in order.
        scope.spawn(move |_| work.into_iter().enumerate().par_bridge().for_each_with(sender, each));
        let mut done = InOrder { receiver, waiting: BTreeMap::new(), next: 0 };
        let ended = collect(ensemble, places, &found, &mut done, &mut sink);
        closed.store(true, Ordering::Relaxed);
        ended
    })
}

/// Puts runs together to cells.
fn collect<E>(
    ensemble: &Ensemble,
    places: &[Place],
    found: &[Option<Found>],
    done: &mut InOrder<Option<Done>>,
    sink: &mut impl FnMut(&Place, CellFates) -> Result<(), E>,
) -> Ended<E, ()> {
    for (found, place) in found.iter().zip(places) {
        let Some(found) = found else { return Ended::Stopped };
        let mut breathers = Vec::with_capacity(found.departures.len());
        for departure in &found.departures {
            let (mut measured, mut fates) = (None, Vec::new());
            for _ in 0..=ensemble.starts {
                match done.next().flatten() {
                    Some(Done::Measured(value)) => measured = value,
                    Some(Done::Run(fate)) => fates.push(fate),
                    None => return Ended::Stopped,
                }
            }
            breathers.push(BreatherFates::of(departure, measured, &fates));
        }
        let cell = CellFates { number: place.cell, cell: found.cell, breathers };
        if let Err(error) = sink(place, cell) {
            return Ended::Failed(error);
        }
    }
    Ended::Complete(())
}

impl Ensembled for Scene {
    fn takes(&self, ensemble: &Ensemble, from: From) -> Result<(), String> {
        ensure!(from != From::Rest, "--breathers rest is of structures: give class, every or unstable");
        ensure!(
            !ensemble.in_sequence,
            "--in-sequence is of structures: masses of a chain share no coordinate, and hit at one instant in any order"
        );
        ensemble.check(self.base.sites()).map_err(|error| error.to_string())
    }

    fn find(&self, number: u64, from: From, worker: &mut Worker, stop: &Stop) -> Option<Found> {
        // The scene's corners were checked, so that every point between is a valid model.
        let model = self.point(number).model().ok()?;
        let (mut orbits, mut count): (Vec<(u32, Orbit)>, _) = (Vec::new(), 0);
        let cell = worker.examine(&model, &self.task, |orbit, best| {
            count += 1;
            if from == From::Class && best {
                orbits.clear();
            }
            if from != From::Class || best {
                orbits.push((count, orbit.clone()));
            }
        });
        let tolerance = self.task.tolerance;
        let departures = orbits.iter().filter_map(|(number, orbit)| departure(*number, orbit, tolerance, stop));
        let asked = |(_, unstable): &(Departure, bool)| from != From::Unstable || *unstable;
        let departures = departures.filter(asked).map(|(departure, _)| departure).collect();
        // What was stopped is not known.
        (!stop.is_raised()).then_some(Found { cell, departures })
    }
}

/// Whence runs start, and whether the breather is unstable, as the scene counts it.
fn departure(number: u32, orbit: &Orbit, tolerance: Tolerance, stop: &Stop) -> Option<(Departure, bool)> {
    let home = Home::of(orbit).ok()?;
    let mut finder = Finder::default().until(stop);
    let known = Analyser::default().stability(orbit, &mut finder, tolerance).ok();
    let unstable = known.as_ref().is_some_and(|known| !known.verdict.stable && !known.verdict.undecided);
    Some((Departure::of(number, orbit.name(), known.as_ref(), orbit.period(), home), unstable))
}

/// ln|μ|/T of the largest multiplier.
fn predicted(known: &Stability, period: f64) -> Option<f64> {
    let largest = known.multipliers.iter().map(|multiplier| multiplier.norm()).reduce(f64::max)?;
    // On the circle exactly, as structure keeps it, it has no rounding.
    Some(if known.verdict.spectral_radius == 1.0 { 0.0 } else { largest.ln() / period })
}

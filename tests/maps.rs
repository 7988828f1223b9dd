//! What the paper's conservative maps must show.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use vibrochain::breather::{Completeness, Family, Finder, Orbit, OrbitList, Scope, admissibility, breathers};
use vibrochain::floquet::{Tolerance, stability};
use vibrochain::lattice::{Chain, Model, Parameter};
use vibrochain_maps::cell::{Class, Status, Task, Worker};
use vibrochain_testkit::Values::{Either, Even, Is};
use vibrochain_testkit::{Random, Ranges};

const GAMMA1: f64 = 0.2;
const ASYMMETRY: f64 = 0.4;

fn model(sites: usize, gamma2: f64, omega: f64) -> Model {
    Model::conservative(Chain::new(sites, GAMMA1, gamma2).unwrap(), omega, ASYMMETRY).unwrap()
}

/// Points of the paper's map.
fn grid(columns: usize, rows: usize) -> impl Iterator<Item = (f64, f64)> {
    (0..rows).flat_map(move |j| {
        (0..columns).map(move |i| (0.3 * j as f64 / (rows - 1) as f64, 0.4 + 2.6 * i as f64 / (columns - 1) as f64))
    })
}

fn physical(finder: &mut Finder, model: &Model, family: Family) -> bool {
    let mut found = OrbitList::default();
    finder.find_symmetric(model, family, &mut found).unwrap();
    found.orbits.iter().any(|orbit| finder.admissibility(orbit).unwrap().is_physical())
}

#[test]
fn no_cell_holds_both_conservative_families() {
    for sites in [6, 11, 21, 41] {
        let mut finder = Finder::new(sites);
        let mut cells = [0, 0];
        for (gamma2, omega) in grid(130, 60) {
            let model = model(sites, gamma2, omega);
            let double = physical(&mut finder, &model, Family::DoubleSided);
            let single = physical(&mut finder, &model, Family::SingleSided);
            assert!(!(double && single), "{sites} {gamma2} {omega}");
            cells[0] += usize::from(double);
            cells[1] += usize::from(single);
        }
        assert!(cells.iter().all(|&count| count > 300), "{sites} {cells:?}");
    }
}

#[test]
fn the_boundary_between_the_families_is_the_grazing_line() {
    for (sites, gamma2) in [(6, 0.02), (11, 0.05), (21, 0.1), (41, 0.03), (1, 0.0)] {
        let mut finder = Finder::new(sites);
        // Along ω: single-sided below the line, double-sided above it.
        let edge = |family: Family, finder: &mut Finder| {
            let (mut single, mut double) = (0.6, 1.5);
            assert!(physical(finder, &model(sites, gamma2, double), Family::DoubleSided));
            for _ in 0..50 {
                let omega = 0.5 * (single + double);
                let above = physical(finder, &model(sites, gamma2, omega), family) == (family == Family::DoubleSided);
                *(if above { &mut double } else { &mut single }) = omega;
            }
            double
        };
        let from_above = edge(Family::DoubleSided, &mut finder);
        // Just above the line the upper impact grazes: its impulse vanishes there.
        let orbit = |omega| breathers(&model(sites, gamma2, omega), Family::DoubleSided).unwrap().orbits[0].clone();
        assert!(orbit(from_above + 1e-9).impacts()[0].impulse.abs() < 1e-6, "{sites}");
        // Just below it the single-sided breather's peak stops short of the upper barrier by as little.
        let found = breathers(&model(sites, gamma2, from_above - 1e-9), Family::SingleSided).unwrap();
        let margin = admissibility(&found.orbits[0]).unwrap().margin.unwrap();
        assert!((0.0..1e-6).contains(&margin), "{sites}: {margin}");
    }
}

/// Conservative double-sided orbits with φ ≠ T/2.
fn asymmetric(orbit: &Orbit) -> bool {
    orbit.family() == Family::DoubleSided && orbit.phi() != Some(0.5 * orbit.period())
}

const BOTH: [Family; 2] = [Family::DoubleSided, Family::SingleSided];

fn task(symmetric: bool) -> Task {
    Task {
        families: BOTH.to_vec(),
        words: Vec::new(),
        symmetric,
        stability: true,
        tolerance: Tolerance::Rounding,
        collisions: false,
        impulse: false,
    }
}

/// What a cell should say, from the full lists: physical orbits, those with φ ≠ T/2 among them, and the class of the best.
fn listed(model: &Model) -> (Vec<Orbit>, usize, Class) {
    let lists = BOTH.map(|family| breathers(model, family).unwrap());
    let physical: Vec<Orbit> = lists
        .into_iter()
        .flat_map(|found| found.orbits)
        .filter(|orbit| admissibility(orbit).unwrap().is_physical())
        .collect();
    let class = |orbit: &Orbit| {
        let stable = stability(orbit, Tolerance::Rounding).unwrap().verdict.stable;
        match (orbit.family(), stable) {
            (Family::DoubleSided, true) => Class::StableDouble,
            (_, true) => Class::StableSingle,
            (Family::DoubleSided, false) => Class::UnstableDouble,
            (_, false) => Class::UnstableSingle,
        }
    };
    // Classes are declared in the order in which they win, after "none".
    let best = physical.iter().map(class).min().unwrap_or(Class::None);
    let count = physical.iter().filter(|orbit| asymmetric(orbit)).count();
    (physical, count, best)
}

/// Compares a cell with the lists; the number of physical orbits with φ ≠ T/2, or `None` where a verdict is not certain.
fn compare(worker: &mut Worker, model: &Model) -> Option<usize> {
    let cell = worker.cell(model, &task(false));
    let (physical, asymmetric, class) = listed(model);
    assert_eq!(cell.solutions as usize, physical.len(), "{model:?} {cell:?}");
    // A scene that leaves orbits out says so wherever there could be any.
    let fewer = worker.cell(model, &task(true));
    assert_eq!(fewer.solutions as usize, physical.len() - asymmetric, "{model:?}");
    assert!(fewer.status == Status::Incomplete || asymmetric == 0, "{model:?} {fewer:?}");
    (cell.status == Status::Ok).then(|| assert_eq!(cell.class, Some(class), "{model:?}"))?;
    Some(asymmetric)
}

#[test]
fn cells_hold_what_the_lists_hold_at_low_frequency() {
    // Half of this map has breathers with φ ≠ T/2 and no other.
    let (mut worker, mut cells, mut with) = (Worker::new(3), 0, 0);
    for (i, j) in (0..20).flat_map(|i| (0..20).map(move |j| (i, j))) {
        let (omega, gamma2) = (0.45 + 0.2 * f64::from(i) / 19.0, 0.1 + 0.3 * f64::from(j) / 19.0);
        let model = Model::conservative(Chain::new(3, 0.14, gamma2).unwrap(), omega, 0.0).unwrap();
        if let Some(asymmetric) = compare(&mut worker, &model) {
            cells += 1;
            with += usize::from(asymmetric > 0);
        }
    }
    assert!(cells > 300 && with > 100, "{cells} {with}");
    // Rings and parameters at random, most of them with harmonics in the band.
    let mut random = Random(22);
    let ranges = Ranges {
        sites: [1, 12],
        gamma1: Either(0.08, &Is(0.0), &Even(0.0, 0.6)),
        gamma2: Even(0.001, 0.3),
        asymmetry: Either(0.4, &Is(0.0), &Even(0.0, 0.9)),
        ..Ranges::CONSERVATIVE
    };
    let (mut points, mut orbits) = (0, 0);
    for _ in 0..3000 {
        let model = random.model(&ranges);
        let top = (model.chain().gamma1() + 4.0 * model.chain().gamma2()).sqrt();
        let model = model.with(Parameter::Omega, random.between(0.25, 1.2) * top).unwrap();
        points += 1;
        orbits += compare(&mut worker, &model).unwrap_or(0);
    }
    assert!(points == 3000 && orbits > 100, "{points} {orbits}");
}

#[test]
fn the_papers_maps_hold_symmetric_conservative_orbits_alone() {
    let (mut orbits, mut places) = (0, 0);
    for sites in [6, 11, 21, 41] {
        let mut finder = Finder::new(sites);
        let (mut found, mut candidates) = (OrbitList::default(), OrbitList::default());
        for (gamma2, omega) in grid(80, 40) {
            let model = model(sites, gamma2, omega);
            finder.find(&model, Family::DoubleSided, &mut found).unwrap();
            finder.search(&model, Family::DoubleSided, Scope::SymmetricCandidates, &mut candidates).unwrap();
            if let Completeness::Asked { left_out } = candidates.completeness {
                places += left_out;
            }
            for orbit in found.orbits.iter().filter(|orbit| asymmetric(orbit)) {
                orbits += 1;
                assert!(!finder.admissibility(orbit).unwrap().is_physical(), "{sites} {gamma2} {omega}");
            }
        }
    }
    // The bound on radiation leaves few of them to be looked at.
    assert!(orbits > 500 && places < orbits / 2, "{orbits} {places}");
}

#[test]
fn the_map_at_n_20_has_stripes_of_instability() {
    let mut worker = Worker::new(21);
    let task = task(false);
    // Along one row, the double-sided breather loses and regains stability many times.
    let classes: Vec<_> = (0..1200)
        .map(|i| worker.cell(&model(21, 0.15, 1.2 + 0.8 * f64::from(i) / 1199.0), &task))
        .inspect(|cell| assert_eq!(cell.status, Status::Ok))
        .map(|cell| cell.class.unwrap())
        .collect();
    let changes = classes.windows(2).filter(|pair| pair[0] != pair[1]).count();
    assert!(changes > 30, "{changes}");
    assert!(classes.iter().all(|class| matches!(class, Class::StableDouble | Class::UnstableDouble)));
}

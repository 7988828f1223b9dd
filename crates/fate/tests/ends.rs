//! Ends of runs that are known by other means, and ensembles that do not depend on threads.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use vibrochain_breather::{Family, Orbit, admissibility, breathers};
use vibrochain_eventsim::{Limits, Simulation, Time};
use vibrochain_fate::{CellFates, Column, Diagram, End, Ensemble, Fates, From, Home, Sectioned, fates, table};
use vibrochain_floquet::{Tolerance, stability};
use vibrochain_lattice::{Model, Point, Stop};
use vibrochain_maps::scene::Scene;
use vibrochain_maps::summary::Summary;
use vibrochain_maps::sweep::{Content, Ended, Job, ReadRows};
use vibrochain_testkit::scenes::{FATE as SCENE, ONE_MASS as LINE};

fn physical(model: &Model, family: Family) -> Vec<Orbit> {
    let orbits = breathers(model, family).unwrap().orbits;
    orbits.into_iter().filter(|orbit| admissibility(orbit).unwrap().is_physical()).collect()
}

fn run(orbit: &Orbit, ensemble: &Ensemble, seed: u64) -> vibrochain_fate::Fate {
    Home::of(orbit).unwrap().run(ensemble, seed, &Stop::default()).unwrap()
}

fn default_model() -> Model {
    Point::ring(21).gamma1(0.2).gamma2(0.1).omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model().unwrap()
}

#[test]
fn a_breather_that_grows_slowly_is_stayed_with_and_a_saddle_is_left() {
    let orbits = physical(&default_model(), Family::DoubleSided);
    let [node, saddle] = &orbits[..] else { panic!("{}", orbits.len()) };
    let ensemble = Ensemble { periods: 600, ..Ensemble::default() };
    for seed in 0..4 {
        let stayed = run(node, &ensemble, seed);
        assert_eq!((stayed.end, stayed.left), (End::Breather, None));
        let left = run(saddle, &ensemble, seed);
        assert!(left.end != End::Breather && left.left.is_some_and(|time| time < 20.0), "{left:?}");
    }
}

#[test]
fn times_to_leave_grow_by_the_logarithm_of_the_perturbation_over_that_of_the_multiplier() {
    let saddle = &physical(&default_model(), Family::DoubleSided)[1];
    let growth = stability(saddle, Tolerance::Rounding).unwrap().verdict.spectral_radius.ln();
    let mean = |size: f64| {
        let ensemble = Ensemble { size, periods: 60, ..Ensemble::default() };
        let times = (0..40).map(|seed| run(saddle, &ensemble, seed).left.unwrap());
        times.sum::<f64>() / 40.0
    };
    let (large, small) = (mean(1e-4), mean(1e-8));
    // The same directions, so that only the logarithm differs; impacts tell of it once or twice a period.
    let expected = 1e4_f64.ln() / growth;
    assert!((small - large - expected).abs() < 0.25, "{large} {small} {expected}");
}

#[test]
fn all_ends_that_are_named_occur_where_they_should() {
    // (Found by `mapgen fate`; what each means is checked against the run itself.)
    let model = default_model();
    let orbits = physical(&model, Family::DoubleSided);
    let ensemble = Ensemble { periods: 1500, ..Ensemble::default() };
    let ends: Vec<End> = (0..12).map(|seed| run(&orbits[1], &ensemble, ensemble.seed_of(0, 0, seed)).end).collect();
    let quiet = ends.iter().position(|end| *end == End::Quiet).unwrap();
    assert!(ends.iter().any(|end| matches!(end, End::Periodic(_))), "{ends:?}");
    // Quiet: the same start, simulated on, has no impact in its last periods.
    let mut start = vibrochain_fate::Start::on(&orbits[1]).unwrap();
    start.perturb_at_random(&model, ensemble.size, ensemble.seed_of(0, 0, quiet as u64));
    let mut simulation = start.simulation(&model).unwrap();
    let before = simulation.run(&Limits::until(Time::new(&model, 1400, 0.0)), |_| {}).work.impacts;
    let after = simulation.run(&Limits::until(Time::new(&model, 1500, 0.0)), |_| {}).work.impacts;
    assert!(before > 0 && before == after);
    // Chaos: two neighbours of a run that ends so part by more than any power of time would.
    let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
    let model = ring.omega(1.2).asymmetry(0.4).amplitude(0.1).restitution(0.9).model().unwrap();
    let orbit = &physical(&model, Family::DoubleSided)[0];
    let ensemble = Ensemble { periods: 1500, ..Ensemble::default() };
    let fate = run(orbit, &ensemble, 1);
    assert_eq!(fate.end, End::Chaos);
    let exponent = fate.exponent.unwrap();
    let state_at = |shift: f64, periods| {
        let mut start = vibrochain_fate::Start::on(orbit).unwrap();
        start.perturb_at_random(&model, ensemble.size, 1);
        let mut simulation = start.simulation(&model).unwrap();
        simulation.run(&Limits::until(Time::new(&model, 1000, 0.0)), |_| {});
        let mut state = simulation.state();
        state.velocity[3] += shift;
        let mut simulation = Simulation::new(&model, start.psi, &state.displacement, &state.velocity).unwrap();
        simulation.run(&Limits::until(Time::new(&model, periods, 0.0)), |_| {});
        simulation.state().displacement
    };
    let apart = |periods| {
        let (one, other) = (state_at(0.0, periods), state_at(1e-12, periods));
        one.iter().zip(&other).fold(0.0, |most: f64, (one, other)| most.max((one - other).abs()))
    };
    let periods = 120;
    let rate = (apart(periods) / 1e-12).ln() / (periods as f64 * model.period());
    println!("{exponent:?} {rate}");
    assert!((0.4..2.5).contains(&(rate / exponent.value)), "{exponent:?} {rate}");
}

fn scene(text: &str) -> Scene {
    Scene::parse(Path::new("scene.toml"), text).unwrap()
}

fn all(threads: usize, ensemble: &Ensemble, from: From, text: &str) -> Vec<CellFates> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let (scene, stop) = (scene(text), Stop::default());
    let mut cells = Vec::new();
    let job = Job { scene: &scene, pool: &pool, stop: &stop };
    let ended = fates(
        &job,
        ensemble,
        from,
        |_| {},
        |cell| {
            cells.push(cell);
            Ok::<(), ()>(())
        },
    );
    assert!(matches!(ended, Ended::Complete(summary) if summary.cells() == cells.len() as u64));
    cells
}

#[test]
fn shares_follow_from_the_seed_whatever_the_threads() {
    let ensemble = Ensemble { starts: 6, periods: 300, seed: 9, ..Ensemble::default() };
    let text = |cells: &[CellFates]| {
        let scene = scene(SCENE);
        cells.iter().flat_map(|cell| table::rows(&scene, cell)).map(|row| row.join(",") + "\n").collect::<String>()
    };
    for from in [From::Class, From::Every, From::Unstable] {
        let one = all(1, &ensemble, from, SCENE);
        assert_eq!(one.iter().map(|cell| cell.number).collect::<Vec<_>>(), (0..12).collect::<Vec<_>>());
        let width = table::header(&scene(SCENE)).len();
        assert!(one.iter().flat_map(|cell| table::rows(&scene(SCENE), cell)).all(|row| row.len() == width));
        for threads in [2, 5] {
            assert_eq!(text(&all(threads, &ensemble, from, SCENE)), text(&one), "{from:?} {threads}");
        }
        let other = all(2, &Ensemble { seed: 10, ..ensemble }, from, SCENE);
        assert_ne!(text(&other), text(&one), "{from:?}");
    }
}

#[test]
fn from_every_breather_start_as_many_as_there_are_and_from_the_unstable_ones_fewer() {
    let ensemble = Ensemble { starts: 2, periods: 20, ..Ensemble::default() };
    // With a force, where none is stable, and without.
    let conservative = SCENE.replace("forcing = { amplitude = 0.1, restitution = 0.9 }", "");
    let both = |from| [SCENE, &conservative].map(|text| all(2, &ensemble, from, text)).concat();
    let [class, every, unstable] = [From::Class, From::Every, From::Unstable].map(both);
    let mut counts = [0; 3];
    for ((class, every), unstable) in class.iter().zip(&every).zip(&unstable) {
        assert_eq!(every.breathers.len(), every.cell.solutions as usize);
        assert_eq!(class.breathers.len(), usize::from(class.cell.solutions > 0));
        assert!(unstable.breathers.iter().all(|breather| breather.spectral_radius.unwrap() > 1.0));
        // The same breather, from the same seeds.
        assert!(class.breathers.iter().chain(&unstable.breathers).all(|breather| every.breathers.contains(breather)));
        for (count, cell) in counts.iter_mut().zip([class, every, unstable]) {
            *count += cell.breathers.len();
            for breather in &cell.breathers {
                assert_eq!(breather.runs(), 2);
                let (value, error) = breather.measured.unwrap();
                assert!((value - breather.predicted.unwrap()).abs() < 1e-6 + error, "{breather:?}");
            }
        }
    }
    assert!(counts[0] >= 12 && counts[1] > counts[2] && counts[2] >= 6, "{counts:?}");
}

#[test]
fn a_flag_that_is_raised_ends_it_with_whole_cells() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let (scene, flag) = (scene(SCENE), Arc::new(AtomicBool::new(false)));
    let stop = Stop::from(&flag);
    let job = Job { scene: &scene, pool: &pool, stop: &stop };
    let ensemble = Ensemble { starts: 3, periods: 200, ..Ensemble::default() };
    let mut cells = Vec::new();
    let runs = std::sync::atomic::AtomicU64::new(0);
    let tick = |count| {
        if runs.fetch_add(count, Ordering::Relaxed) >= 6 {
            flag.store(true, Ordering::Relaxed);
        }
    };
    let ended = fates(&job, &ensemble, From::Class, tick, |cell| {
        cells.push(cell);
        Ok::<(), ()>(())
    });
    assert_eq!(ended, Ended::Stopped);
    assert!(cells.len() < 12);
    let whole = all(1, &ensemble, From::Class, SCENE);
    assert_eq!(cells, whole[..cells.len()]);
}

#[test]
fn what_a_table_tells_of_a_cell_reads_back_and_what_it_cannot_tell_is_refused() {
    let scene = scene(SCENE);
    let ensemble = Ensemble { starts: 3, periods: 200, size: 0.05, ..Ensemble::default() };
    let (mut read, mut words) = (0, 0);
    for from in From::ALL {
        let fates = Fates { ensemble, from };
        let cells = all(2, &ensemble, from, SCENE);
        let rows: Vec<String> = cells.iter().map(|cell| csv_rows(&scene, cell)).collect();
        let text = rows.concat();
        let summary = Summary::of(&cells.iter().map(|cell| cell.cell).collect::<Vec<_>>());
        let take = |text: &str, range: std::ops::Range<u64>| -> Result<Vec<CellFates>, String> {
            let mut seen = Vec::new();
            let mut each = |number: u64, cell: &CellFates| {
                assert_eq!(number, cell.number);
                seen.push(cell.clone());
            };
            let mut reader = fates.reader(&scene, range);
            // In pieces that end anywhere.
            text.as_bytes().chunks(23).try_for_each(|piece| reader.take(piece, &mut each))?;
            reader.finish(&summary, &mut each)?;
            Ok(seen)
        };
        let whole = 0..scene.cells();
        let back = take(&text, whole.clone()).unwrap();
        assert_eq!(back.len(), cells.len());
        for (mine, theirs) in cells.iter().zip(&back) {
            assert_eq!((mine.number, &mine.breathers), (theirs.number, &theirs.breathers));
            assert_eq!((mine.cell.solutions, mine.cell.status), (theirs.cell.solutions, theirs.cell.status));
            read += mine.breathers.len();
            words += mine.breathers.iter().map(|breather| breather.words.len()).sum::<usize>();
        }
        assert!(take(&rows[1..].concat(), whole.clone()).unwrap_err().contains("row 1: it is of another cell"));
        assert!(take(&rows[..11].concat(), whole.clone()).unwrap_err().contains("it has rows of 11 cells for 12"));
        assert!(take(&text, 0..11).unwrap_err().contains("it is of more than its 11 cells"));
        assert!(take(&text.replacen(",3,", ",4,", 1), whole.clone()).is_err());
        assert!(take(&text.replacen(",ok,", ",so,", 1), whole.clone()).unwrap_err().contains("its status is `so`"));
        assert!(take(text.trim_end(), whole).is_err());
    }
    assert!(read >= 30 && words > 5, "{read} {words}");
}

fn csv_rows(scene: &Scene, cell: &CellFates) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    table::rows(scene, cell).into_iter().for_each(|row| writer.write_record(row).unwrap());
    String::from_utf8(writer.into_inner().unwrap()).unwrap()
}

#[test]
fn settings_are_text_that_reads_back() {
    let ensemble = Ensemble { size: 0.1 + 0.2, seed: u64::MAX, leave: 1e-7, ..Ensemble::default() };
    for from in From::ALL {
        let fates = Fates { ensemble, from };
        let settings = fates.settings();
        assert_eq!(Fates::from_settings(&settings), Ok(fates));
        assert_eq!(settings.len(), 8);
        for name in settings.keys() {
            let mut without = settings.clone();
            without.remove(name);
            assert!(Fates::from_settings(&without).unwrap_err().contains(name));
            without.insert(name.clone(), "much".to_owned());
            assert!(Fates::from_settings(&without).unwrap_err().contains("`much`"));
        }
    }
}

fn columns(threads: usize, carry: bool, text: &str) -> Vec<Column> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let (scene, stop) = (scene(text), Stop::default());
    let ensemble = Ensemble { periods: 400, ..Ensemble::default() };
    let diagram = Diagram { scene: &scene, ensemble: &ensemble, points: 8, carry };
    assert_eq!(scene.watched(), [0]);
    let mut columns = Vec::new();
    let job = Job { scene: &scene, pool: &pool, stop: &stop };
    let ended = diagram.compute(
        &job,
        |_| {},
        |column| {
            columns.push(column);
            Ok::<(), ()>(())
        },
    );
    assert_eq!(ended, Ended::Complete(()));
    columns
}

#[test]
fn a_diagram_has_the_breather_where_that_is_stable() {
    let text = LINE.replace("from = 0.25, to = 0.5, points = 6", "from = 0.15, to = 0.5, points = 12");
    let one = columns(1, false, &text);
    assert_eq!(one, columns(3, false, &text));
    let carried = columns(3, true, &text);
    let scene = scene(&text);
    let (mut compared, mut followed) = (0, 0);
    for (column, carried) in one.iter().zip(&carried) {
        assert!(column.complete && column.points.len() == 8 && column.points[7].period == 399);
        let model = scene.point(column.number).model().unwrap();
        let orbits = physical(&model, Family::SingleSided);
        let stable =
            orbits.iter().find(|orbit| stability(orbit, Tolerance::Rounding).unwrap().verdict.spectral_radius < 0.9);
        let Some(orbit) = stable else { continue };
        // Where the force is greatest: t + ψ a whole period.
        let time = (-orbit.psi().unwrap()).rem_euclid(model.period());
        let (u, v) = vibrochain_breather::Motion::of(orbit).unwrap().state(time);
        let is_there = |column: &Column| {
            column.points.iter().all(|point| {
                let [(x, w)] = point.states[..] else { panic!() };
                (x - u[0]).abs().max((w - v[0]).abs()) < 1e-6
            })
        };
        assert!(is_there(column), "{}", column.number);
        compared += 1;
        // (From the end of the run before another motion may be nearer.)
        followed += usize::from(is_there(carried));
    }
    assert!(compared >= 5 && followed >= 3, "{compared} {followed}");
}

/// Where a period has doubled there are two points; where that is, multipliers know.
#[test]
fn a_diagram_has_two_points_below_the_period_doubling() {
    let text = LINE.replace("from = 0.25, to = 0.5, points = 6", "from = 0.29, to = 0.32, points = 16");
    let scene = scene(&text);
    let mut seen = [0; 2];
    for column in columns(2, false, &text) {
        let model = scene.point(column.number).model().unwrap();
        let orbit = &physical(&model, Family::SingleSided)[0];
        let radius = stability(orbit, Tolerance::Rounding).unwrap().verdict.spectral_radius;
        // Next to the doubling runs take longer to settle than these are.
        if (radius - 1.0).abs() < 0.04 {
            continue;
        }
        let at = |i: usize| column.points[i].states[0].0;
        let (every, every_other) = ((at(7) - at(6)).abs(), (at(7) - at(5)).abs());
        assert!(every_other < 1e-6 && (every > 1e-3) == (radius > 1.0), "{radius}: {every:e} {every_other:e}");
        seen[usize::from(radius > 1.0)] += 1;
    }
    assert!(seen.iter().all(|&seen| seen >= 4), "{seen:?}");
}

//! Branches of orbits of any linear structure, the events on them and their curves: against the chain's own engine where nothing damps, and
//! against closed forms.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::collections::BTreeSet;

use vibrochain_breather::{Family, Orbit, Word, breathers};
use vibrochain_floquet::{
    BranchRequest, Course, End, Event, Evidence, FollowedBranch, Located, Special, SpecialPoint, Tolerance, Walk,
    Window, branches, diagram, event_curves,
};
use vibrochain_lattice::{Chain, Model, Parameter, Stop};
use vibrochain_maps::structure::along::{family, numbers};
use vibrochain_maps::structure::{Setting, StructureScene};

fn scene(text: &str) -> StructureScene {
    StructureScene::of_text(text, std::path::Path::new(".")).unwrap()
}

fn branch(scene: &StructureScene, orbit: &Orbit, setting: Setting, [from, to]: [f64; 2]) -> FollowedBranch {
    let course =
        BranchRequest { from, to, events: Event::ALL.to_vec(), generations: 0, tolerance: Tolerance::Rounding };
    let value = scene.get(setting).unwrap();
    let diagram = branches(orbit, &family(scene, &[setting]), value, &course, &Stop::default());
    diagram.unwrap().branches.swap_remove(0)
}

/// A chain as a structure: γ₁, γ₂, ω, a, A, e.
fn chain(sites: usize, [gamma1, gamma2, omega, asymmetry, amplitude, restitution]: [f64; 6]) -> StructureScene {
    let contact = |at: usize| {
        let (lower, upper) = (asymmetry - 1.0, asymmetry + 1.0);
        format!("[[contact]]\nat = {at}\nlower = {lower}\nupper = {upper}\nrestitution = {restitution}\n")
    };
    let contacts: String = (0..sites).map(contact).collect();
    let ones = vec![1.0; sites];
    let structure = format!("chain = {{ sites = {sites}, gamma1 = {gamma1}, gamma2 = {gamma2} }}");
    let mut scene = scene(&format!("omega = {omega}\n[structure]\n{structure}\n{contacts}[force]\nload = {ones:?}\n"));
    scene.set(Setting::Load, amplitude).unwrap();
    scene
}

fn model(sites: usize, [gamma1, gamma2, omega, asymmetry, amplitude, restitution]: [f64; 6]) -> Model {
    let chain = Chain::new(sites, gamma1, gamma2).unwrap();
    chain.point().omega(omega).asymmetry(asymmetry).amplitude(amplitude).restitution(restitution).model().unwrap()
}

/// On which side orbits branch off, whether each is stable, and by how much the impulses of the first differ: as a root does, so that this is told
/// by its square over the way.
fn branched(found: &Located) -> Option<(bool, Vec<Option<bool>>, f64)> {
    let branching = found.branching.as_ref()?;
    let sizes: Vec<f64> = branching.orbits[0].orbit.impulses().into_iter().map(f64::abs).collect();
    let spread = sizes.iter().fold(0.0, |a: f64, b| a.max(*b)) - sizes.iter().fold(f64::INFINITY, |a, b| a.min(*b));
    let stable = branching.orbits.iter().map(|one| one.verdict.map(|verdict| verdict.stable)).collect();
    Some((branching.above, stable, spread * spread / (branching.value - found.value)))
}

/// Without dashpots the structure is the chain: both find the same events, by other equations, unknowns and test functions, and the same orbits
/// that branch off there.
#[test]
fn a_chain_without_dashpots_has_the_events_of_its_own_engine() {
    use Parameter::{Amplitude, Asymmetry, Gamma2, Omega};
    let single = Family::SingleSided;
    let cases = [
        (5, [0.2, 0.1, 1.07, 0.8, 0.165, 0.25], single, Amplitude, Setting::Load, [0.1, 0.4]),
        (5, [0.2, 0.1, 1.07, 0.8, 0.165, 0.25], single, Omega, Setting::Omega, [0.9, 1.3]),
        (5, [1.0, 0.05, 1.5, 0.4, 0.3, 0.8], Family::DoubleSided, Omega, Setting::Omega, [1.2, 1.9]),
        (4, [1.0, 0.1, 1.6, 0.5, 0.2, 0.9], single, Gamma2, Setting::Gamma2, [0.02, 0.2]),
        (1, [1.0, 0.0, 1.5, 0.9, 0.3, 0.8], single, Omega, Setting::Omega, [1.2, 1.98]),
        (3, [1.0, 0.1, 1.9, 0.3, 0.2, 0.95], single, Asymmetry, Setting::Asymmetry, [0.05, 0.8]),
        (5, [1.0, 0.05, 1.5, 0.0, 0.3, 0.8], Family::DoubleSided, Amplitude, Setting::Load, [0.1, 0.6]),
        (5, [1.0, 0.05, 1.5, 0.4, 0.0, 1.0], Family::DoubleSided, Omega, Setting::Omega, [1.3, 2.0]),
    ];
    let (mut compared, mut branches, mut met) = (0, 0, BTreeSet::new());
    for (sites, numbers, family, free, setting, range) in cases {
        let scene = chain(sites, numbers);
        let found = scene.model().unwrap().orbits(&Word::of_family(family).unwrap(), 1).unwrap();
        for orbit in breathers(&model(sites, numbers), family).unwrap().orbits {
            let mut asked = Course::new(&orbit, free);
            (asked.from, asked.to) = (range[0], range[1]);
            let expected = &diagram(&orbit, &asked).unwrap().branches[0];
            let is_it = |one: &&Orbit| {
                (one.impacts()[0].impulse - orbit.impacts()[0].impulse).abs() < 1e-9
                    && one.psi().is_none_or(|psi| (psi - orbit.psi().unwrap()).abs() < 1e-8)
            };
            let own = branch(&scene, found.orbits.iter().find(is_it).unwrap(), setting, range);
            let of = |found: (Event, f64, f64)| (found.0.name(), found.1, found.2);
            let mine: Vec<_> = own.events().map(|one| of((one.event, one.value, one.error))).collect();
            let theirs: Vec<_> = expected.events().map(|one| of((one.event, one.value, one.error))).collect();
            let about = format!("{sites} {numbers:?} {family:?} {free:?}\n{mine:?}\n{theirs:?}\n{:?}", own.unresolved);
            assert_eq!(mine.len(), theirs.len(), "{about}");
            for (name, value, error) in &theirs {
                let same = |one: &&(&str, f64, f64)| one.0 == *name && (one.1 - value).abs() <= 1e-12 + error + one.2;
                assert_eq!(mine.iter().filter(same).count(), 1, "{name} at {value}: {about}");
            }
            for one in expected.events() {
                let same = |mine: &&Located| mine.event == one.event && (mine.value - one.value).abs() < 1e-9;
                let mine = own.events().find(same).unwrap();
                let [mine, theirs] = [branched(mine), branched(one)];
                assert_eq!(mine.is_some(), theirs.is_some(), "{:?} at {}: {about}", one.event, one.value);
                let (Some(mine), Some(theirs)) = (mine, theirs) else { continue };
                assert_eq!((mine.0, &mine.1), (theirs.0, &theirs.1), "{:?} at {}: {about}", one.event, one.value);
                assert!((mine.2 / theirs.2 - 1.0).abs() < 0.02, "{mine:?} {theirs:?} {about}");
                branches += mine.1.len();
            }
            assert_eq!(own.ends.len(), expected.ends.len());
            compared += theirs.len();
            met.extend(theirs.iter().map(|(name, ..)| *name));
        }
    }
    assert!(compared > 50 && branches > 10 && met.len() == 5, "{compared} {branches} {met:?}");
}

/// The whole grazing curve of a damped oscillator is A = d·√((1−ω²)² + c²ω²), through both resonances of its impacts.
#[test]
fn the_grazing_curve_of_a_damped_oscillator_is_known_by_hand() {
    let mut scene = scene(
        "omega = 0.8\n[structure]\nmasses = [1]\nstiffness = [[1]]\ndamping = [[0.1]]\n[[contact]]\nat = 0\nupper = 1\nrestitution = 0.8\n[force]\nload = [1]\n",
    );
    let grazing = |omega: f64| ((1.0 - omega * omega).powi(2) + 0.01 * omega * omega).sqrt();
    scene.set(Setting::Load, 1.1 * grazing(0.8)).unwrap();
    let found = scene.model().unwrap().orbits(&"0+".parse().unwrap(), 1).unwrap();
    let mut followed = 0;
    for orbit in &found.orbits {
        let own = branch(&scene, orbit, Setting::Load, [0.05, 2.0]);
        let Some(event) =
            own.events().find(|one| one.event == Event::Grazing && (one.value - grazing(0.8)).abs() < 1e-9)
        else {
            continue;
        };
        assert!((event.value - grazing(0.8)).abs() <= event.error + 1e-15, "{} ± {}", event.value, event.error);
        let window = Window { from: [0.05, 0.45], to: [3.0, 1.9] };
        let settings = [Setting::Load, Setting::Omega];
        let answer =
            event_curves([event], &numbers(&scene, &settings).unwrap(), &Walk::new(window, 1e-4)).unwrap().remove(0);
        assert!(answer.points.len() > 30);
        for point in &answer.points {
            let [load, omega] = point.values;
            assert!((load - grazing(omega)).abs() < 1e-10, "{omega}: {load} {}", grazing(omega));
        }
        let reached = answer.points.iter().map(|point| point.values[1]);
        let (least, most) = reached.fold((f64::INFINITY, 0.0_f64), |(a, b), omega| (a.min(omega), b.max(omega)));
        assert!(least < 0.4501 && most > 1.8999, "{least} {most} {:?}", answer.ends);
        followed += 1;
    }
    assert!(followed > 0);
}

/// A curve of period doublings, of folds and of Neimark–Sacker points is where the chain's own engine has it.
#[test]
fn curves_of_a_chain_without_dashpots_are_those_of_its_own_engine() {
    let values = [0.2, 0.1, 1.07, 0.8, 0.165, 0.25];
    let scene = chain(5, values);
    let found = scene.model().unwrap().orbits(&"0-".parse().unwrap(), 1).unwrap();
    let window = Window { from: [0.12, 1.03], to: [0.3, 1.12] };
    let settings = [Setting::Load, Setting::Omega];
    let (mut seen, mut special) = (BTreeSet::new(), BTreeSet::new());
    for orbit in &found.orbits {
        let own = branch(&scene, orbit, Setting::Load, [window.from[0], window.to[0]]);
        for event in own.events().filter(|one| seen.insert(one.event.name())) {
            let mine = event_curves([event], &numbers(&scene, &settings).unwrap(), &Walk::new(window, 1e-4))
                .unwrap()
                .remove(0);
            let chains = breathers(&model(5, values), Family::SingleSided).unwrap().orbits;
            let mut asked = Course::new(&chains[0], Parameter::Amplitude);
            (asked.from, asked.to) = (window.from[0], window.to[0]);
            let located = chains.iter().find_map(|orbit| {
                let branches = diagram(orbit, &asked).ok()?;
                let located = branches.branches[0]
                    .events()
                    .find(|one| one.event == event.event && (one.value - event.value).abs() < 1e-9)?;
                Some(located.clone())
            });
            let located = located.unwrap();
            let parameters = [Parameter::Amplitude, Parameter::Omega];
            let free = located.orbit.lattice().unwrap().numbers(&parameters, &Stop::default());
            let theirs = event_curves([&located], &free, &Walk::new(window, 1e-4)).unwrap().remove(0);
            assert!(mine.points.len() > 10 && theirs.points.len() > 10, "{}", event.event);
            // Every point of one is on the other's line, and both reach as far.
            for (points, line) in
                [(places(&mine.points), places(&theirs.points)), (places(&theirs.points), places(&mine.points))]
            {
                for point in points {
                    let off = line.windows(2).map(|ends| distance(&window, point, [ends[0], ends[1]]));
                    let off = off.fold(f64::INFINITY, f64::min);
                    assert!(off < 4e-4, "{}: {point:?} {off}\n{:?}\n{:?}", event.event, mine.ends, theirs.ends);
                }
            }
            // What happens on the chain's curve happens on this one, at the same place.
            let by_multipliers = |one: &&SpecialPoint| {
                !matches!(one.special, Special::Cusp | Special::With(Event::Grazing | Event::Fold | Event::Pitchfork))
            };
            for theirs in theirs.special.iter().filter(by_multipliers) {
                let apart = |one: &SpecialPoint| {
                    let [a, b] = [one.values, theirs.values].map(|values| window.parts(values));
                    (a[0] - b[0]).hypot(a[1] - b[1])
                };
                let same = mine.special.iter().filter(|one| one.special == theirs.special);
                let off = same.map(apart).fold(f64::INFINITY, f64::min);
                assert!(off < 1e-6, "{} {theirs:?} {off} {:?}", event.event, mine.special);
                special.insert(theirs.special.to_string());
            }
        }
    }
    assert!(seen.len() >= 3, "{seen:?}");
    assert!(special.contains("neimark-sacker"), "{special:?}");
}

fn places(points: &[vibrochain_floquet::CurvePoint]) -> Vec<[f64; 2]> {
    points.iter().map(|point| point.values).collect()
}

/// How far a place is from a straight line between two others, as a part of the window's sides.
fn distance(window: &Window, place: [f64; 2], ends: [[f64; 2]; 2]) -> f64 {
    let place = window.parts(place);
    let [from, to] = ends.map(|end| window.parts(end));
    let (chord, away) = ([to[0] - from[0], to[1] - from[1]], [place[0] - from[0], place[1] - from[1]]);
    let square = (chord[0] * chord[0] + chord[1] * chord[1]).max(f64::MIN_POSITIVE);
    let share = ((away[0] * chord[0] + away[1] * chord[1]) / square).clamp(0.0, 1.0);
    (away[0] - share * chord[0]).hypot(away[1] - share * chord[1])
}

/// All orbits of one impact a period at one frequency are one loop, the stop being a sum of a cosine and a sine of the phase: 0 without velocity at
/// the cosine's ends, farthest at those of the sum. Round it once each of them is told once, whatever the phase is then.
#[test]
fn a_branch_closes_where_its_phase_has_gone_round() {
    let (omega, c, e) = (2.6f64, 0.1f64, 0.8f64);
    let text = format!(
        "omega = {omega}\nword = \"0+\"\n[structure]\nmasses = [1]\nstiffness = [[1]]\ndamping = [[{c}]]\n\
         [[contact]]\nat = 0\nupper = 0.05\nrestitution = {e}\n[force]\nload = [1]\n"
    );
    let scene = scene(&text);
    // P = ω|g| sin x·(1+e)/(1 + (1+e)K′), and the stop is |g| cos x + KP.
    let (rate, dying) = ((1.0 - 0.25 * c * c).sqrt(), 0.5 * c);
    let pole = vibrochain_lattice::Complex::new(-dying, rate);
    let gone = (pole * (std::f64::consts::TAU / omega)).exp();
    let kernel = gone / (vibrochain_lattice::Complex::new(1.0, 0.0) - gone) / rate;
    let size = ((1.0 - omega * omega).powi(2) + (c * omega).powi(2)).sqrt().recip();
    let sine = omega * size * (1.0 + e) * kernel.im / (1.0 + (1.0 + e) * (pole * kernel).im);
    let farthest = size.hypot(sine);
    let found = scene.model().unwrap().orbits(&"0+".parse().unwrap(), 1).unwrap();
    assert_eq!(found.orbits.len(), 2);
    for orbit in &found.orbits {
        let branch = branch(&scene, orbit, Setting::Upper(0), [-3.0, 5.0]);
        let values = |wanted: &dyn Fn(&Located) -> bool| {
            let mut values: Vec<f64> = branch.events().filter(|one| wanted(one)).map(|one| one.value).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let folds = values(&|one| one.event == Event::Fold);
        let lost = values(&|one| matches!(one.evidence, Evidence::Impact(_)));
        for (told, right) in [(folds, farthest), (lost, size)] {
            assert_eq!(told.len(), 2, "{told:?}");
            assert!(
                told.iter().zip([-right, right]).all(|(told, right)| (told - right).abs() < 1e-9),
                "{told:?} {right}"
            );
        }
        // None of any kind stands twice.
        let all: Vec<_> = branch.events().collect();
        let same = |i: usize, j: usize| {
            all[i].event == all[j].event && (all[i].value - all[j].value).abs() <= all[i].error + all[j].error
        };
        assert!((0..all.len()).all(|j| (0..j).all(|i| !same(i, j))), "{}", all.len());
        assert!(branch.ends.iter().any(|end| end.1 == End::Closed), "{:?}", branch.ends);
    }
}

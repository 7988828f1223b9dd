//! Stripes along lines of parameters against what does not know of two modes: counts of multipliers from point to point, events located
//! on the branch, eigenvalues of the dense monodromy matrix.

use nalgebra::Complex;
use vibrochain_breather::{Family, Finder, OrbitList};
use vibrochain_floquet::{
    Analyser, Course, Event, NoStripe, Secular, Stripe, StripeEnd, StripeFinder, StripeLine, Tolerance, diagram,
    eigenvalues, even_monodromy, participating_modes,
};
use vibrochain_lattice::{Chain, Model, Parameter};
use vibrochain_testkit::Random;

const BOTH: [Family; 2] = [Family::DoubleSided, Family::SingleSided];

fn line(sites: usize, gamma2: f64, omega: f64, asymmetry: f64, family: Family, free: Parameter) -> StripeLine {
    let model = Model::conservative(Chain::new(sites, 0.2, gamma2).unwrap(), omega, asymmetry).unwrap();
    StripeLine { model, family, free }
}

/// Pairs of complex ν of a physical breather, those below −1 and above 1, and how many harmonics are below its modes.
#[derive(Debug, Clone, Copy)]
struct Off {
    complex: isize,
    below: isize,
    above: isize,
    passed: f64,
}

fn off_circle(
    (finder, found, secular): (&mut Finder, &mut OrbitList, &mut Secular),
    line: &StripeLine,
    omega: f64,
) -> Option<Off> {
    let model = line.model.with(Parameter::Omega, omega).unwrap();
    finder.find_symmetric(&model, line.family, found).ok()?;
    let orbit = found.orbits.first()?;
    if !finder.quick_admissibility(orbit).ok()?.is_physical() {
        return None;
    }
    secular.replace(finder.prepared(orbit).ok()?).ok()?;
    let (roots, _) = secular.roots().ok()?;
    let count = |of: &dyn Fn(&Complex<f64>) -> bool| roots.iter().filter(|nu| of(nu)).count() as isize;
    let passed = participating_modes(model.chain(), 0).iter().map(|(_, frequency)| (frequency / omega).floor()).sum();
    Some(Off {
        complex: count(&|nu| nu.im > 0.0),
        below: count(&|nu| nu.im == 0.0 && nu.re < -1.0),
        above: count(&|nu| nu.im == 0.0 && nu.re > 1.0),
        passed,
    })
}

fn is_doubling(stripe: &Stripe) -> bool {
    stripe.pair.is_some_and(|((k, l), _)| k == l)
}

/// Every change of the count of multipliers off the circle, at so many points a unit of ω, is an edge of a stripe. The number of changes.
fn none_is_missing(line: &StripeLine, density: f64) -> usize {
    let (from, to) = (0.4, 3.0);
    let row = StripeFinder::default().along(line, (from, to), 4000).unwrap();
    assert_eq!(row.unresolved, Vec::<[f64; 2]>::new(), "{line:?}");
    let points = ((to - from) * density) as usize;
    let (mut finder, mut found, mut secular) = (Finder::new(21), OrbitList::default(), Secular::default());
    let (mut last, mut events): (Option<Off>, _) = (None, 0);
    for i in 0..=points {
        let at = |i: usize| from + (to - from) * i as f64 / points as f64;
        let here = off_circle((&mut finder, &mut found, &mut secular), line, at(i));
        if let (Some(before), Some(after)) = (last, here)
            && before.passed == after.passed
        {
            let (complex, below) = (after.complex - before.complex, after.below - before.below);
            // Two beyond −1 may turn complex, or the other way round, and so may two above 1: nothing happens on the circle.
            if (complex, below) != (0, 0) && below != -2 * complex && before.above == after.above {
                let inside = |edge: f64| edge > at(i - 1) - 1e-8 && edge < at(i) + 1e-8;
                let told = row.stripes.iter().flat_map(|stripe| stripe.edges).any(inside);
                assert!(told, "{line:?} between {} and {}: {before:?} {after:?}", at(i - 1), at(i));
                events += 1;
            }
        }
        last = here;
    }
    events
}

#[test]
fn rows_have_all_stripes_that_a_scan_sees() {
    let mut random = Random(1);
    let mut events = 0;
    for _ in 0..2 {
        let gamma2 = random.between(0.0, 0.3);
        for family in BOTH {
            events += none_is_missing(&line(21, gamma2, 1.0, 0.4, family, Parameter::Omega), 1e4);
        }
    }
    assert!(events > 150, "{events}");
}

#[test]
#[ignore = "slow: ten minutes"]
fn slow_ten_rows_have_all_stripes_that_a_scan_of_five_million_points_sees() {
    let mut random = Random(20);
    let mut events = 0;
    for _ in 0..10 {
        let gamma2 = random.between(0.0, 0.3);
        for family in BOTH {
            events += none_is_missing(&line(21, gamma2, 1.0, 0.4, family, Parameter::Omega), 2e6);
        }
    }
    assert!(events > 1000, "{events}");
}

#[test]
fn as_many_multipliers_are_off_the_circle_as_stripes_are_about_a_point() {
    let mut random = Random(7);
    let (mut finder, mut found, mut secular) = (Finder::new(21), OrbitList::default(), Secular::default());
    let (mut checked, mut without) = ([0; 2], 0);
    // One stripe's edge found twice; one told to end where the next one does; one hidden between two others.
    for gamma2 in
        [0.25636363636363635, 0.1725752508361204, 0.2729096989966555, 0.1806020066889632, random.between(0.0, 0.3)]
    {
        for family in BOTH {
            let line = line(21, gamma2, 1.0, 0.4, family, Parameter::Omega);
            let row = StripeFinder::default().along(&line, (0.4, 3.0), 4000).unwrap();
            assert_eq!(row.unresolved, Vec::<[f64; 2]>::new(), "{line:?}");
            for _ in 0..10_000 {
                let omega = random.between(0.4, 3.0);
                let Some(off) = off_circle((&mut finder, &mut found, &mut secular), &line, omega) else { continue };
                if off.above > 0
                    || row.stripes.iter().flat_map(|stripe| stripe.edges).any(|edge| (edge - omega).abs() < 1e-9)
                {
                    continue;
                }
                let about = row.stripes.iter().filter(|stripe| stripe.edges[0] < omega && omega < stripe.edges[1]);
                // A mode against itself, or two that two others of the kind may have become.
                let told: isize = about.map(|stripe| if is_doubling(stripe) { 1 } else { 2 }).sum();
                let off_circle = 2 * off.complex + off.below;
                // Of single-sided breathers some are off the circle wherever there is a breather: no edge, and no stripe.
                if family == Family::SingleSided && told < off_circle {
                    without += 1;
                    continue;
                }
                assert_eq!(told, off_circle, "{line:?} at {omega}: {off:?}");
                checked[usize::from(told > 0)] += 1;
            }
        }
    }
    println!("{checked:?} {without}");
    assert!(checked[0] > 25_000 && checked[1] > 4_000 && without < 1_000, "{checked:?} {without}");
}

#[test]
fn edges_are_the_events_of_the_branch() {
    let mut random = Random(5);
    let (mut finder, mut found) = (Finder::new(8), OrbitList::default());
    let (mut located, mut rows) = (0, 0);
    while rows < 24 {
        let family = BOTH[rows % 2];
        let (sites, gamma2) = (4 + random.below(8), random.between(0.03, 0.25));
        let omega = random.between(0.9, 1.6);
        let free = random.of(&[Parameter::Omega, Parameter::Gamma2]);
        let line = line(sites, gamma2, omega, random.between(0.1, 0.6), family, free);
        finder.find_symmetric(&line.model, family, &mut found).unwrap();
        let Some(orbit) = found.orbits.first() else { continue };
        if !finder.admissibility(orbit).unwrap().is_physical() {
            continue;
        }
        let start = line.model.get(free);
        let (from, to) = (0.85 * start, 1.15 * start);
        let events = vec![Event::NeimarkSacker, Event::PeriodDoubling];
        let course = Course { from, to, events, ..Course::new(orbit, free) };
        let branch = &diagram(orbit, &course).unwrap().branches[0];
        let row = StripeFinder::default().along(&line, (from, to), 400).unwrap();
        for event in branch.events().filter(|event| event.physical == Some(true)) {
            let distance = |stripe: &Stripe| {
                stripe.edges.iter().map(|edge| (edge - event.value).abs()).fold(f64::INFINITY, f64::min)
            };
            let nearest = row.stripes.iter().map(distance).fold(f64::INFINITY, f64::min);
            // `locate` sees the two multipliers as one until they are apart by the root of rounding.
            assert!(nearest < 1e-11 * start + 16.0 * event.error, "{line:?} {} {nearest:e}", event.value);
            located += 1;
        }
        rows += 1;
    }
    assert!(located > 40, "{located}");
}

#[test]
fn inside_a_stripe_dense_eigenvalues_grow_as_told_and_beside_it_they_do_not() {
    let (mut finder, mut found) = (Finder::new(11), OrbitList::default());
    let mut analyser = Analyser::default();
    let (mut checked, mut doubling) = (0, 0);
    // Where none has left through +1.
    for (sites, gamma2, asymmetry, from) in
        [(11, 0.1, 0.4, 1.1), (10, 0.2, 0.1, 1.3), (6, 0.15, 0.4, 1.3), (9, 0.1, 0.1, 1.1)]
    {
        let line = line(sites, gamma2, 1.0, asymmetry, Family::DoubleSided, Parameter::Omega);
        let row = StripeFinder::default().along(&line, (from, 2.5), 600).unwrap();
        assert!(row.unresolved.is_empty());
        let mut at = |omega: f64| {
            let model = line.model.with(Parameter::Omega, omega).unwrap();
            finder.find_symmetric(&model, line.family, &mut found).unwrap();
            let orbit = &found.orbits[0];
            let mut values = Vec::new();
            eigenvalues(&even_monodromy(orbit).unwrap(), &mut values).unwrap();
            let dense = values.iter().map(|value| value.norm()).fold(0.0, f64::max).ln();
            let verdict = analyser.verdict(orbit, &mut finder, Tolerance::Rounding).unwrap();
            (dense, verdict.stable)
        };
        for stripe in row.stripes.iter().filter(|stripe| stripe.half_width > 1e-6) {
            let alone = |other: &Stripe| {
                other.centre == stripe.centre
                    || (other.centre - stripe.centre).abs() > 2.0 * stripe.half_width + other.half_width
            };
            if stripe.growth < 1e-5 || stripe.ends != [StripeEnd::Edge; 2] || !row.stripes.iter().all(alone) {
                continue;
            }
            let most =
                (-50..=50).map(|i| at(stripe.centre + f64::from(i) * 0.02 * stripe.half_width).0).fold(0.0, f64::max);
            assert!((most / stripe.growth - 1.0).abs() < 1e-3, "{stripe:?} {most:e}");
            for part in [-0.999, 0.999, -1.001, 1.001, -1.5, 1.5] {
                let (_, stable) = at(stripe.centre + part * stripe.half_width);
                assert_eq!(stable, part.abs() > 1.0, "{part} {stripe:?}");
            }
            checked += 1;
            doubling += usize::from(stripe.pair.unwrap().0.0 == stripe.pair.unwrap().0.1);
        }
    }
    println!("{checked} stripes, {doubling} of one mode");
    assert!(checked > 12 && doubling > 5, "{checked} {doubling}");
}

#[test]
fn outlines_along_a_row_are_the_stripes_with_another_growth() {
    let mut finder = StripeFinder::default();
    let (mut same, mut others) = (0, 0);
    for (family, gamma2) in [(Family::DoubleSided, 0.1), (Family::SingleSided, 0.1), (Family::SingleSided, 0.2)] {
        let line = line(11, gamma2, 1.0, 0.4, family, Parameter::Omega);
        let row = finder.along(&line, (0.4, 2.5), 300).unwrap();
        let outlines = finder.outlines_along(&line, (0.4, 2.5), 300).unwrap();
        assert_eq!(outlines.stripes.len(), row.stripes.len());
        assert_eq!(outlines.unresolved, row.unresolved);
        for (outline, stripe) in outlines.stripes.iter().zip(&row.stripes) {
            let Stripe { growth, multiplier, .. } = *stripe;
            assert_eq!(Stripe { growth, multiplier, ..*outline }, *stripe);
            *(if outline.growth == growth { &mut same } else { &mut others }) += 1;
        }
    }
    // Of those that are told by counts the growth is the same.
    assert!(same > 3 && others > 10, "{same} {others}");
}

#[test]
fn what_is_no_stripe_is_told() {
    let mut finder = StripeFinder::default();
    let mut near = |line: &StripeLine, modes, harmonic, value| finder.near(line, modes, harmonic, value).unwrap_err();
    // A symmetric breather's odd harmonics; no mode at 0.447, which is the breather's; far from any line.
    let symmetric = line(6, 0.15, 1.0, 0.0, Family::DoubleSided, Parameter::Omega);
    assert_eq!(near(&symmetric, (0, 1), 1, 1.2), NoStripe::Passes);
    let single = line(6, 0.1, 1.0, 0.4, Family::SingleSided, Parameter::Omega);
    assert_eq!(near(&single, (0, 1), 1, 0.5), NoStripe::NoMode { mode: 0 });
    let double = line(21, 0.1, 1.0, 0.4, Family::DoubleSided, Parameter::Omega);
    assert_eq!(near(&double, (8, 9), 1, 1.9), NoStripe::Elsewhere);
    assert!(matches!(near(&double, (8, 9), 1, -1.0), NoStripe::Parameter(_)));
    let forced =
        double.model.chain().point().omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model().unwrap();
    let forced = StripeLine { model: forced, ..double };
    assert_eq!(near(&forced, (8, 9), 1, 1.5), NoStripe::NotConservative);
    assert_eq!(StripeFinder::default().along(&forced, (1.0, 2.0), 10).unwrap_err(), NoStripe::NotConservative);
    // One mass has no modes to collide; a row of one point, or none.
    let alone = line(1, 0.0, 1.0, 0.4, Family::DoubleSided, Parameter::Omega);
    assert_eq!(StripeFinder::default().along(&alone, (0.7, 3.0), 50).unwrap().stripes, []);
    for points in [0, 1] {
        assert_eq!(StripeFinder::default().along(&double, (1.0, 1.6), points).unwrap().stripes, []);
    }
}

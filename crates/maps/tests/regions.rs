//! Regions between curves whose areas are known by hand, or whose sides an implicit function tells.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::f64::consts::{PI, TAU};

use fastrand::Rng;
use vibrochain_maps::regions::{Regions, Subdivision, Window};

type Place = [f64; 2];

/// A curve, and on which side of it a point lies: by the sign, near it by its distance.
#[derive(Debug, Clone, Copy)]
enum Shape {
    /// Centre, radius.
    Circle(Place, f64),
    /// A point on it, direction.
    Line(Place, f64),
    /// y = height + amplitude sin(waves x + phase).
    Wave { height: f64, amplitude: f64, waves: f64, phase: f64 },
}

impl Shape {
    fn side(self, [x, y]: Place) -> f64 {
        match self {
            Self::Circle([cx, cy], radius) => radius - (x - cx).hypot(y - cy),
            Self::Line([px, py], angle) => (y - py) * angle.cos() - (x - px) * angle.sin(),
            Self::Wave { height, amplitude, waves, phase } => y - height - amplitude * (waves * x + phase).sin(),
        }
    }

    /// Points with chords that err by less than 1e-6; the distances vary at random.
    fn points(self, random: &mut Rng) -> Vec<Place> {
        let (turns, step) = match self {
            Self::Circle(_, radius) => (TAU, (8e-6 / radius).sqrt().min(0.1)),
            Self::Line(..) => (4.0, 0.3),
            Self::Wave { amplitude, waves, .. } => (1.2, (8e-6 / (amplitude * waves * waves)).sqrt().min(0.1)),
        };
        let count = (turns / step).ceil() as usize;
        let turn = random.f64();
        let mut points: Vec<Place> = (0..=count)
            .map(|i| {
                let inner = i > 0 && i < count;
                let part = (i as f64 + if inner { 0.3 * (random.f64() - 0.5) } else { 0.0 }) / count as f64;
                match self {
                    Self::Circle([cx, cy], radius) => {
                        let (sin, cos) = (TAU * (part + turn)).sin_cos();
                        [cx + radius * cos, cy + radius * sin]
                    }
                    Self::Line([px, py], angle) => {
                        let along = 4.0 * (part - 0.5);
                        [px + along * angle.cos(), py + along * angle.sin()]
                    }
                    Self::Wave { height, amplitude, waves, phase } => {
                        let x = 1.2 * part - 0.1;
                        [x, height + amplitude * (waves * x + phase).sin()]
                    }
                }
            })
            .collect();
        if matches!(self, Self::Circle(..)) {
            points[count] = points[0];
        }
        points
    }
}

const TOLERANCE: f64 = 1e-6;

fn unit() -> Window {
    Window::new([0.0, 1.0], [0.0, 1.0]).unwrap()
}

fn class(shapes: &[Shape], point: Place) -> u32 {
    shapes.iter().enumerate().map(|(i, shape)| u32::from(shape.side(point) > 0.0) << i).sum()
}

fn cut(shapes: &[Shape], seed: u64) -> Regions<u32> {
    let mut random = Rng::with_seed(seed);
    let borders: Vec<Vec<Place>> = shapes.iter().map(|shape| shape.points(&mut random)).collect();
    let subdivision = Subdivision::new(unit(), &borders, TOLERANCE).unwrap();
    subdivision.classified(500, || (), |(), point| class(shapes, point))
}

fn share(regions: &Regions<u32>, class: u32) -> (f64, f64) {
    regions.areas().iter().find(|area| area.class == class).map_or((0.0, 0.0), |area| (area.share, area.error))
}

/// Twice the area inside an outline.
fn shoelace(outline: &[Place]) -> f64 {
    // From the first point on, so that nothing cancels in a small one.
    let [x, y] = outline[0];
    let next = outline.iter().skip(1).chain(&outline[..1]);
    outline.iter().zip(next).map(|(a, b)| (a[0] - x) * (b[1] - y) - (a[1] - y) * (b[0] - x)).sum()
}

/// How often an outline goes around a point, by the rising and falling sides on its right.
fn winding(outline: &[Place], [x, y]: Place) -> i32 {
    let next = outline.iter().skip(1).chain(&outline[..1]);
    let right = |a: &Place, b: &Place| (b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1]);
    outline
        .iter()
        .zip(next)
        .map(|(a, b)| match (a[1] <= y, b[1] <= y) {
            (true, false) if right(a, b) > 0.0 => 1,
            (false, true) if right(a, b) < 0.0 => -1,
            _ => 0,
        })
        .sum()
}

/// All that must hold of any regions: areas, outlines and points agree with each other, and points with the shapes. Returns how
/// many points were held against the shapes.
fn checked(regions: &Regions<u32>, shapes: &[Shape], points: usize, seed: u64) -> usize {
    let whole: f64 = regions.regions().iter().map(|region| region.share).sum();
    assert!((whole - 1.0).abs() < 1e-12, "{whole}");
    let classes: f64 = regions.areas().iter().map(|area| area.share).sum();
    assert!((classes - 1.0).abs() < 1e-12);
    for region in regions.regions() {
        let area: f64 = region.outlines.iter().map(|outline| 0.5 * shoelace(outline)).sum();
        // Tens of thousands of terms of both signs.
        assert!((area - region.share).abs() < 1e-11, "{area} {}", region.share);
        let outer = region.outlines.iter().filter(|outline| shoelace(outline) > 0.0).count();
        assert_eq!(outer, 1, "{shapes:?}");
    }
    let mut random = Rng::with_seed(seed);
    let mut held = 0;
    for i in 0..points {
        let point = [random.f64(), random.f64()];
        let found = regions.region(point).unwrap();
        if shapes.iter().all(|shape| shape.side(point).abs() > 2.0 * TOLERANCE) {
            assert_eq!(found.class, class(shapes, point), "{point:?} {shapes:?}");
            held += 1;
        }
        if i % 20 == 0 {
            let around = |outlines: &[Vec<Place>]| outlines.iter().map(|outline| winding(outline, point)).sum::<i32>();
            for region in regions.regions() {
                assert_eq!(around(&region.outlines), i32::from(std::ptr::eq(region, found)), "{point:?}");
            }
        }
    }
    held
}

#[test]
fn areas_known_by_hand() {
    let circle = |x: f64, y: f64, radius: f64| Shape::Circle([x, y], radius);
    let lens = |radius: f64, apart: f64| {
        2.0 * radius * radius * (apart / (2.0 * radius)).acos()
            - 0.5 * apart * (4.0 * radius * radius - apart * apart).sqrt()
    };
    let (r, d) = (0.3, 0.25);
    type Case = (&'static str, Vec<Shape>, Vec<(u32, f64)>, usize);
    let cases: Vec<Case> = vec![
        ("circle", vec![circle(0.5, 0.5, 0.4)], vec![(1, 0.16 * PI), (0, 1.0 - 0.16 * PI)], 2),
        (
            "lens",
            vec![circle(0.4, 0.5, r), circle(0.4 + d, 0.5, r)],
            vec![(3, lens(r, d)), (1, r * r * PI - lens(r, d)), (2, r * r * PI - lens(r, d))],
            4,
        ),
        (
            "crossing lines",
            vec![Shape::Line([0.5, 0.5], PI / 4.0), Shape::Line([0.5, 0.5], -PI / 4.0)],
            vec![(0, 0.25), (1, 0.25), (2, 0.25), (3, 0.25)],
            4,
        ),
        (
            "ring",
            vec![circle(0.5, 0.5, 0.4), circle(0.45, 0.55, 0.2)],
            vec![(1, 0.12 * PI), (3, 0.04 * PI), (0, 1.0 - 0.16 * PI)],
            3,
        ),
        (
            "circles that touch from outside",
            vec![circle(0.3, 0.5, 0.2), circle(0.7, 0.5, 0.2)],
            vec![(1, 0.04 * PI), (2, 0.04 * PI), (0, 1.0 - 0.08 * PI)],
            3,
        ),
        (
            "circles that touch from inside",
            vec![circle(0.5, 0.5, 0.4), circle(0.7, 0.5, 0.2)],
            vec![(1, 0.12 * PI), (3, 0.04 * PI), (0, 1.0 - 0.16 * PI)],
            3,
        ),
        (
            "a circle on a line",
            vec![circle(0.5, 0.5, 0.25), Shape::Line([0.0, 0.25], 0.0)],
            vec![(3, PI / 16.0), (0, 0.25), (2, 0.75 - PI / 16.0)],
            3,
        ),
        ("a circle that leaves the window", vec![circle(0.0, 1.0, 0.5)], vec![(1, PI / 16.0), (0, 1.0 - PI / 16.0)], 2),
    ];
    for (name, shapes, areas, count) in cases {
        let regions = cut(&shapes, 1);
        assert!(regions.unexplained().is_empty(), "{name}");
        for (class, expected) in areas {
            let (share, error) = share(&regions, class);
            assert!((share - expected).abs() <= error && error < 1e-5, "{name} {class}: {share} {expected} {error:e}");
        }
        // Where curves touch, chords may cut off slivers, but none that a picture or a sum could notice.
        let visible = regions.regions().iter().filter(|region| region.share > 1e-6).count();
        assert_eq!(visible, count, "{name}");
        assert!(checked(&regions, &shapes, 2000, 7) > 1950);
    }
}

#[test]
fn a_hole_has_an_outline_of_its_own() {
    let regions = cut(&[Shape::Circle([0.5, 0.5], 0.4), Shape::Circle([0.5, 0.5], 0.2)], 4);
    let holes: Vec<(u32, usize)> =
        regions.regions().iter().map(|region| (region.class, region.outlines.len())).collect();
    assert_eq!(holes, [(0, 2), (1, 2), (3, 1)]);
    assert!(regions.border(0).iter().chain(regions.border(1)).all(|part| part.separates));
}

#[test]
fn a_stripe_far_thinner_than_its_chords_err_keeps_its_area() {
    for apart in [1e-5, 1e-7, 1e-9, 1e-10] {
        let shapes = [Shape::Circle([0.5, 0.5], 0.4), Shape::Circle([0.5, 0.5], 0.4 + apart)];
        let regions = cut(&shapes, 9);
        let expected = PI * ((0.4 + apart).powi(2) - 0.16);
        let (share, _) = share(&regions, 2);
        // The corners are rounded to 1e-12; chords farther apart than they err do not correspond.
        let most = 1e-4 + 1e-12 / apart + if apart > TOLERANCE { 0.1 * TOLERANCE / apart } else { 0.0 };
        assert!((share / expected - 1.0).abs() < most, "{apart:e} {share:e} {expected:e}");
        // One ring, not a chain of pieces.
        assert_eq!(regions.regions().len(), 3, "{apart:e}");
        // From one edge of the window to the other.
        let wave = |height| Shape::Wave { height, amplitude: 0.2, waves: 5.0, phase: 0.3 };
        let shapes = [wave(0.5), wave(0.5 + apart)];
        let regions = cut(&shapes, 10);
        let stripe = regions.areas().iter().find(|area| area.class == 1).unwrap();
        assert!((stripe.share / apart - 1.0).abs() < most, "{apart:e} {}", stripe.share);
        assert_eq!(regions.regions().len(), 3, "{apart:e}");
    }
}

#[test]
fn copies_of_a_curve_are_one_border() {
    let circle = Shape::Circle([0.5, 0.5], 0.4);
    let mut random = Rng::with_seed(3);
    let borders: Vec<Vec<Place>> = (0..6).map(|_| circle.points(&mut random)).collect();
    let cut = Subdivision::new(unit(), &borders, TOLERANCE).unwrap();
    let regions = cut.classified(100, || (), |(), point| class(&[circle], point));
    assert_eq!(regions.regions().len(), 2);
    assert!(checked(&regions, &[circle], 500, 5) > 490);
}

#[test]
fn a_missing_border_is_told_with_points_on_both_sides() {
    let shapes = [Shape::Circle([0.5, 0.5], 0.4), Shape::Circle([0.45, 0.5], 0.15)];
    let borders = [shapes[0].points(&mut Rng::with_seed(1))];
    let cut = Subdivision::new(unit(), &borders, TOLERANCE).unwrap();
    assert_eq!(cut.faces(), 2);
    let regions = cut.classified(200, || (), |(), point| class(&shapes, point));
    let [face] = regions.unexplained() else { panic!("{:?}", regions.unexplained()) };
    assert!((face.share - 0.16 * PI).abs() < 1e-5);
    assert!([1, 3].iter().all(|wanted| face.points.iter().any(|(_, found)| found == wanted)));
    assert!(face.points.iter().all(|(point, found)| class(&shapes, *point) == *found));
    for (found, expected) in [(1, 0.16 * PI - 0.0225 * PI), (3, 0.0225 * PI)] {
        let (share, error) = share(&regions, found);
        // A class that holds no face has no area; most points say that this one is of class 1.
        assert!((share - expected).abs() <= error, "{found}");
    }
}

/// A curve that is followed to where another one is known ends up to three tolerances aside of it: no gap is left to pass through.
#[test]
fn an_end_some_tolerances_aside_is_joined() {
    for tolerance in [1e-6, 1e-5, 1e-4] {
        let end = [0.5 - 3.0 * tolerance, 0.5];
        let borders = [vec![[0.0, 0.5], [0.2, 0.5], end], vec![[0.5, 0.0], [0.5, 0.3], [0.5, 1.0]]];
        let cut = Subdivision::new(unit(), &borders, tolerance).unwrap();
        let class = |(): &mut (), [x, y]: Place| if x > 0.5 { 2 } else { u32::from(y > 0.5) };
        let regions = cut.classified(2000, || (), class);
        assert!(regions.unexplained().is_empty() && regions.closed().is_empty(), "{tolerance}");
        assert_eq!(regions.areas().len(), 3);
    }
}

#[test]
fn what_separates_nothing_leaves_no_trace_in_regions() {
    let mut random = Rng::with_seed(8);
    let circle = Shape::Circle([0.5, 0.5], 0.3);
    let wave = Shape::Wave { height: 0.5, amplitude: 0.1, waves: 9.0, phase: 0.0 };
    let borders =
        [circle.points(&mut random), wave.points(&mut random), vec![[0.5, 0.5], [0.6, 0.9]], vec![[0.1, 0.1]]];
    let cut = Subdivision::new(unit(), &borders, TOLERANCE).unwrap();
    let regions = cut.classified(100, || (), |(), point| class(&[circle], point));
    assert_eq!((regions.regions().len(), regions.borders()), (2, 4));
    assert!(regions.border(0).iter().all(|part| part.separates) && regions.border(3).is_empty());
    let idle = regions.border(1).iter().chain(regions.border(2));
    assert_eq!(idle.clone().filter(|part| part.separates).count(), 0);
    assert!(idle.count() >= 2);
}

#[test]
fn curves_at_random_cut_the_window_as_their_implicit_functions_do() {
    let (mut held, mut regions_seen) = (0, 0);
    for seed in 0..60 {
        let mut random = Rng::with_seed(seed);
        let count = random.usize(1..=9);
        let mut shapes: Vec<Shape> = Vec::new();
        while shapes.len() < count {
            let r = |random: &mut Rng, from: f64, to: f64| from + (to - from) * random.f64();
            let tiny = 10f64.powf(r(&mut random, -12.0, -4.0));
            let shape = match (random.u32(0..6), shapes.last().copied()) {
                // Beside the last one, or touching it.
                (0, Some(Shape::Circle(centre, radius))) => Shape::Circle(centre, radius + tiny),
                (0, Some(Shape::Wave { height, amplitude, waves, phase })) => {
                    Shape::Wave { height: height + tiny, amplitude, waves, phase }
                }
                (1, Some(Shape::Circle([x, y], radius))) => {
                    let (sin, cos) = r(&mut random, 0.0, TAU).sin_cos();
                    let inner = radius * r(&mut random, 0.2, 0.9);
                    Shape::Circle([x + (radius - inner) * cos, y + (radius - inner) * sin], inner)
                }
                (1, Some(Shape::Line(place, angle))) => Shape::Line(place, angle + tiny),
                (2, _) => Shape::Line([random.f64(), random.f64()], r(&mut random, 0.0, PI)),
                (3, _) => Shape::Wave {
                    height: random.f64(),
                    amplitude: r(&mut random, 0.01, 0.3),
                    waves: r(&mut random, 1.0, 30.0),
                    phase: r(&mut random, 0.0, TAU),
                },
                _ => Shape::Circle([random.f64(), random.f64()], r(&mut random, 0.002, 0.6)),
            };
            shapes.push(shape);
        }
        let regions = cut(&shapes, seed);
        // Stripes of 1e-12 to 1e-10 may be thinner than the cubics between points of this distance are good.
        let unexplained: f64 = regions.unexplained().iter().map(|face| face.share).sum();
        assert!(unexplained < 5e-10, "{seed} {unexplained:e} {shapes:?}");
        held += checked(&regions, &shapes, 1000, seed);
        regions_seen += regions.regions().len();
    }
    assert!(held > 59_000 && regions_seen > 500, "{held} {regions_seen}");
}

#[test]
fn scribble_is_cut_without_a_panic_and_fills_the_window() {
    let mut random = Rng::with_seed(17);
    let mut faces = 0;
    for round in 0..40 {
        // On coarse grids many corners coincide and many chords overlap.
        let steps = [3, 10, 1000, 1_000_000][round % 4];
        let mut point = || [0, 1].map(|_| f64::from(random.i32(-1..=steps + 1)) / f64::from(steps));
        let borders: Vec<Vec<Place>> = (0..5).map(|_| (0..40).map(|_| point()).collect()).collect();
        let cut = Subdivision::new(unit(), &borders, TOLERANCE).unwrap();
        faces += cut.faces();
        let regions = cut.classified(50, || (), |(), [x, y]| u32::from((3.0 * x).sin() + y > 1.0));
        let whole: f64 = regions.regions().iter().map(|region| region.share).sum();
        assert!((whole - 1.0).abs() < 1e-12);
    }
    assert!(faces > 10_000, "{faces}");
}

#[test]
fn what_has_no_place_is_refused_by_number() {
    let cut = |borders: &[Vec<Place>], tolerance| Subdivision::new(unit(), borders, tolerance).map(|cut| cut.faces());
    for bad in [[f64::NAN, 0.5], [0.5, f64::INFINITY], [1e9, 0.0]] {
        let message = cut(&[vec![[0.0, 0.0], [1.0, 1.0]], vec![[0.5, 0.5], bad]], 1e-6).unwrap_err().to_string();
        assert!(message.contains("point 1 of border 1"), "{message}");
    }
    for tolerance in [0.0, -1.0, f64::NAN, 1.0] {
        assert!(cut(&[], tolerance).unwrap_err().to_string().contains("from 1e-12 to 0.01"));
    }
    assert_eq!(cut(&[], 1e-6).unwrap(), 1);
    assert_eq!(cut(&[Vec::new(), vec![[0.5, 0.5]; 3], vec![[0.0, 0.0], [1.0, 0.0]]], 1e-6).unwrap(), 1);
    // A window of other units, and points outside of it.
    let window = Window::new([-2.0, 2.0], [10.0, 30.0]).unwrap();
    let regions = Subdivision::new(window, &[vec![[0.0, 0.0], [0.0, 50.0]]], 1e-6).unwrap();
    let regions = regions.classified(20, || (), |(), [x, _]| x > 0.0);
    assert_eq!(
        (regions.at([-1.0, 20.0]), regions.at([1.0, 30.0]), regions.at([1.0, 30.1])),
        (Some(&false), Some(&true), None)
    );
    assert_eq!((regions.at([-2.0, 10.0]), regions.at([2.0, 10.0])), (Some(&false), Some(&true)));
}

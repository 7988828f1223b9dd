//! Curves of events in two parameters against searches in one, and multipliers at their special points.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::f64::consts::{PI, TAU};

use vibrochain_breather::{Family, Orbit, breathers};
use vibrochain_floquet::{
    CurveEnd, CurveError, Event, EventCurve, Search, Special, Tolerance, Window, curve, locate, stability,
};
use vibrochain_lattice::{Chain, Model, Parameter};
use vibrochain_testkit::Random;

const TOLERANCE: f64 = 1e-6;

fn forced(omega: f64, asymmetry: f64, amplitude: f64, restitution: f64) -> Model {
    Model::forced(Chain::new(21, 0.2, 0.1).unwrap(), omega, asymmetry, amplitude, restitution).unwrap()
}

fn conservative(sites: usize, gamma2: f64, omega: f64) -> Model {
    Model::conservative(Chain::new(sites, 0.2, gamma2).unwrap(), omega, 0.4).unwrap()
}

fn first(model: &Model, family: Family) -> Orbit {
    breathers(model, family).unwrap().orbits.first().unwrap().clone()
}

/// The curve through the first event that a search along one parameter finds.
fn followed(orbit: &Orbit, event: Event, free: Parameter, window: &Window, tolerance: f64) -> EventCurve {
    let found = locate(orbit, &Search::new(orbit, event, free)).unwrap();
    let located = found.located.first().unwrap();
    curve(&located.orbit, event, located.evidence, window, tolerance).unwrap()
}

fn amplitudes_and_restitutions() -> Window {
    Window { parameters: [Parameter::Amplitude, Parameter::Restitution], from: [0.05, 0.05], to: [0.4, 1.0] }
}

fn frequencies_and_couplings() -> Window {
    Window { parameters: [Parameter::Omega, Parameter::Gamma2], from: [0.4, 0.0], to: [3.0, 0.3] }
}

/// How far a straight line between two points is from the event, as a part of the window, by a search along the axis that it crosses.
fn sagitta(curve: &EventCurve, i: usize, window: &Window) -> Option<f64> {
    let (from, to) = (&curve.points[i], &curve.points[i + 1]);
    let middle = [0, 1].map(|k| 0.5 * (from.values[k] + to.values[k]));
    let [dx, dy] = [0, 1].map(|k| (to.values[k] - from.values[k]) / window.sides()[k]);
    let axis = usize::from(dx.abs() > dy.abs());
    let across = [dy, dx][axis].abs() / dx.hypot(dy);
    let (free, reach) = (window.parameters[axis], 2e-3 * window.sides()[axis]);
    [1.0, -1.0].into_iter().find_map(|side| {
        let start = middle[axis] + 0.5 * side * reach;
        let other = window.parameters[1 - axis];
        let model = from.orbit.model().with(other, middle[1 - axis]).ok()?.with(free, start).ok()?;
        let list = breathers(&model, from.orbit.family()).ok()?;
        list.orbits.iter().find_map(|orbit| {
            let search = Search { event: curve.event, free, from: middle[axis] - reach, to: middle[axis] + reach };
            let found = locate(orbit, &search).ok()?;
            let apart = |value: f64| (value - middle[axis]).abs() / window.sides()[axis] * across;
            found.located.iter().map(|one| apart(one.value)).min_by(f64::total_cmp)
        })
    })
}

#[test]
fn straight_lines_between_points_err_by_no_more_than_asked() {
    let plane = Window { parameters: [Parameter::Omega, Parameter::Amplitude], from: [0.8, 0.02], to: [1.6, 0.6] };
    let (single, double) = (first(&forced(1.07, 0.8, 0.165, 0.25), Family::SingleSided), Family::DoubleSided);
    let cases = [
        (single.clone(), Event::Grazing, Parameter::Amplitude, amplitudes_and_restitutions()),
        (single.clone(), Event::PeriodDoubling, Parameter::Amplitude, amplitudes_and_restitutions()),
        (single.clone(), Event::Fold, Parameter::Amplitude, amplitudes_and_restitutions()),
        (single, Event::PeriodDoubling, Parameter::Amplitude, plane),
        (first(&conservative(6, 0.15, 1.3), double), Event::Grazing, Parameter::Omega, frequencies_and_couplings()),
        (first(&conservative(6, 0.15, 1.3), double), Event::Pitchfork, Parameter::Omega, frequencies_and_couplings()),
        (
            first(&conservative(6, 0.15, 1.3), double),
            Event::PeriodDoubling,
            Parameter::Omega,
            frequencies_and_couplings(),
        ),
        (
            first(&conservative(6, 0.15, 1.3), double),
            Event::NeimarkSacker,
            Parameter::Omega,
            frequencies_and_couplings(),
        ),
    ];
    let (mut random, mut farthest) = (Random(5), 0.0_f64);
    for (orbit, event, free, window) in cases {
        let curve = followed(&orbit, event, free, &window, TOLERANCE);
        assert!(curve.points.len() > 100, "{event} {}", curve.points.len());
        let (mut checked, mut worst) = (0, 0.0_f64);
        for _ in 0..12 {
            let i = (random.unit() * (curve.points.len() - 1) as f64) as usize;
            if let Some(apart) = sagitta(&curve, i, &window) {
                (checked, worst) = (checked + 1, worst.max(apart));
            }
        }
        assert!(checked >= 6 && worst <= TOLERANCE, "{event} in {:?}: {checked} {worst:e}", window.parameters);
        farthest = farthest.max(worst);
    }
    // Nor are they shorter without need.
    assert!(farthest > 0.1 * TOLERANCE, "{farthest:e}");
}

#[test]
fn special_points_have_the_multipliers_that_make_them() {
    let curve = followed(
        &first(&forced(1.07, 0.8, 0.165, 0.25), Family::SingleSided),
        Event::PeriodDoubling,
        Parameter::Amplitude,
        &amplitudes_and_restitutions(),
        1e-5,
    );
    let multipliers = |curve: &EventCurve, special: Special| {
        let point = curve.special.iter().find(|one| one.special == special).unwrap();
        assert!(point.error < 1e-9, "{special} {:e}", point.error);
        stability(&curve.points[point.point].orbit, Tolerance::Rounding).unwrap().multipliers
    };
    let values = multipliers(&curve, Special::With(Event::Fold));
    for goal in [1.0, -1.0] {
        // A pair ±1 that a fold and a doubling have in common, each simple.
        let nearest = values.iter().map(|value| (value - goal).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-9, "{goal} {nearest:e}");
    }
    // Where the stripe's edge passes e^{2πi/3}.
    let orbit = first(&conservative(21, 0.15, 1.3), Family::DoubleSided);
    let curve = followed(&orbit, Event::NeimarkSacker, Parameter::Omega, &frequencies_and_couplings(), 1e-5);
    let values = multipliers(&curve, Special::OneToThree);
    let mut near: Vec<f64> = values.iter().map(|value| (value.arg().abs() - TAU / 3.0).abs()).collect();
    near.sort_by(f64::total_cmp);
    // Two pairs have met there: to the root of rounding.
    assert!(near[3] < 1e-6, "{near:?}");
    let angle = curve.points[curve.special[0].point].angle.unwrap();
    assert!((angle * PI - TAU / 3.0).abs() < 1e-9);
}

/// A curve is the same from wherever it is taken up, and ends where its window does.
#[test]
fn a_curve_is_the_same_from_another_of_its_points() {
    let window = amplitudes_and_restitutions();
    let orbit = first(&forced(1.07, 0.8, 0.165, 0.25), Family::SingleSided);
    let whole = followed(&orbit, Event::Fold, Parameter::Amplitude, &window, TOLERANCE);
    assert_eq!(whole.ends, [CurveEnd::Edge, CurveEnd::Edge]);
    let mut ends: Vec<[f64; 2]> = [whole.points.first(), whole.points.last()].map(|end| end.unwrap().values).to_vec();
    ends.sort_by(|a, b| a[1].total_cmp(&b[1]));
    let at_edges = ends.iter().all(|values| window.parts(*values).iter().any(|part| *part == 0.0 || *part == 1.0));
    assert!(at_edges, "{ends:?}");
    let mut checked = 0;
    for point in whole.points.iter().step_by(60) {
        let again = curve(&point.orbit, Event::Fold, whole.evidence, &window, TOLERANCE).unwrap();
        let mut others: Vec<[f64; 2]> =
            [again.points.first(), again.points.last()].map(|end| end.unwrap().values).to_vec();
        others.sort_by(|a, b| a[1].total_cmp(&b[1]));
        for (a, b) in ends.iter().zip(&others) {
            assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-11, "{ends:?} {others:?}");
        }
        checked += 1;
    }
    assert!(checked >= 4, "{checked}");
}

#[test]
fn what_cannot_be_followed_is_told() {
    let orbit = first(&conservative(6, 0.15, 1.3), Family::DoubleSided);
    let found = locate(&orbit, &Search::new(&orbit, Event::Grazing, Parameter::Omega)).unwrap();
    let (start, evidence) = (&found.located[0].orbit, found.located[0].evidence);
    let with = |parameters, tolerance| {
        let window = Window { parameters, ..frequencies_and_couplings() };
        curve(start, Event::Grazing, evidence, &window, tolerance).unwrap_err()
    };
    assert_eq!(with([Parameter::Omega; 2], 1e-6), CurveError::Same(Parameter::Omega));
    assert_eq!(with([Parameter::Omega, Parameter::Gamma2], 0.1), CurveError::Tolerance(0.1));
    assert_eq!(with([Parameter::Omega, Parameter::Amplitude], 1e-6), CurveError::NoForce(Parameter::Amplitude));
    let message = with([Parameter::Gamma1, Parameter::Gamma2], 1e-6).to_string();
    assert!(message.contains("gamma1 = 0.2 is not in the window from 0.4 to 3"), "{message}");
}

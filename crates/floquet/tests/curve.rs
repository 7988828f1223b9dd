//! Curves of events in two parameters against searches in one, and multipliers at their special points.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::f64::consts::{PI, TAU};

use vibrochain_breather::{Family, Finder, Orbit, breathers};
use vibrochain_floquet::{
    Analyser, CurveEnd, CurveError, Event, EventCurve, Search, Special, Tolerance, Walk, event_curve, locate, stability,
};
use vibrochain_lattice::{Chain, Model, Parameter, Point, Stop};
use vibrochain_testkit::{Plane, Random};

const TOLERANCE: f64 = 1e-6;

fn forced(omega: f64, asymmetry: f64, amplitude: f64, restitution: f64) -> Model {
    let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
    ring.omega(omega).asymmetry(asymmetry).amplitude(amplitude).restitution(restitution).model().unwrap()
}

fn conservative(sites: usize, gamma2: f64, omega: f64) -> Model {
    Model::conservative(Chain::new(sites, 0.2, gamma2).unwrap(), omega, 0.4).unwrap()
}

fn first(model: &Model, family: Family) -> Orbit {
    breathers(model, family).unwrap().orbits.first().unwrap().clone()
}

/// The curve through the first event that a search along one parameter finds.
fn followed(orbit: &Orbit, event: Event, free: Parameter, window: &Plane, tolerance: f64) -> EventCurve {
    let found = locate(orbit, &Search::new(orbit, event, free)).unwrap();
    let located = found.located.first().unwrap();
    window.curve(&located.orbit, event, located.evidence, tolerance).unwrap()
}

fn amplitudes_and_restitutions() -> Plane {
    Plane::new([Parameter::Amplitude, Parameter::Restitution], [0.05, 0.05], [0.4, 1.0])
}

fn frequencies_and_couplings() -> Plane {
    Plane::new([Parameter::Omega, Parameter::Gamma2], [0.4, 0.0], [3.0, 0.3])
}

/// How far a straight line between two points is from the event, as a part of the window, by a search along the axis that it crosses.
fn sagitta(curve: &EventCurve, i: usize, window: &Plane) -> Option<f64> {
    let (from, to) = (&curve.points[i], &curve.points[i + 1]);
    let middle = [0, 1].map(|k| 0.5 * (from.values[k] + to.values[k]));
    let [dx, dy] = [0, 1].map(|k| (to.values[k] - from.values[k]) / window.sides()[k]);
    let axis = usize::from(dx.abs() > dy.abs());
    let across = [dy, dx][axis].abs() / dx.hypot(dy);
    let (free, reach) = (window.parameters[axis], 2e-3 * window.sides()[axis]);
    [1.0, -1.0].into_iter().find_map(|side| {
        let start = middle[axis] + 0.5 * side * reach;
        let other = window.parameters[1 - axis];
        let model = from.orbit.model().unwrap().with(other, middle[1 - axis]).ok()?.with(free, start).ok()?;
        let list = breathers(&model, from.orbit.family()).ok()?;
        // Other orbits may have the event, too, farther away.
        let nearest = list.orbits.iter().filter_map(|orbit| {
            let search = Search { event: curve.event, free, from: middle[axis] - reach, to: middle[axis] + reach };
            let found = locate(orbit, &search).ok()?;
            let apart = |value: f64| (value - middle[axis]).abs() / window.sides()[axis] * across;
            found.located.iter().map(|one| apart(one.value)).min_by(f64::total_cmp)
        });
        nearest.min_by(f64::total_cmp)
    })
}

#[test]
fn straight_lines_between_points_err_by_no_more_than_asked() {
    // Nearer to the modes the curve lies in many folds, and others double within what is searched.
    let plane = Plane::new([Parameter::Omega, Parameter::Amplitude], [1.02, 0.02], [1.6, 0.6]);
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
        for _ in 0..24 {
            if checked >= 12 {
                break;
            }
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
    let third = curve.special.iter().find(|one| one.special == Special::OneToThree).unwrap();
    let angle = curve.points[third.point].angle.unwrap();
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
        let again = window.curve(&point.orbit, Event::Fold, whole.evidence, TOLERANCE).unwrap();
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
fn impulses_that_are_rounding_all_along_end_no_curve() {
    // One mass without coupling swings A/|1 − ω²| far and touches the near barrier where that is 1 − a.
    let chain = Chain::new(1, 1.0, 0.0).unwrap();
    let truth = |omega: f64| 0.1 * (1.0 - omega * omega).abs();
    for (from, to) in [(0.7, 0.98), (1.1, 1.9), (2.1, 2.9)] {
        let window = Plane::new([Parameter::Amplitude, Parameter::Omega], [1e-4, from], [1.0, to]);
        for start in [0.3, 0.8] {
            let omega = from + start * (to - from);
            let point = chain.point().omega(omega).asymmetry(0.9);
            let model = point.amplitude(1.2 * truth(omega)).restitution(0.8).model().unwrap();
            let list = breathers(&model, Family::SingleSided).unwrap();
            let mut followed = 0;
            for orbit in &list.orbits {
                let search = Search { event: Event::Grazing, free: Parameter::Amplitude, from: 1e-4, to: 1.0 };
                let found = locate(orbit, &search).unwrap();
                let near = |value: f64| (value - truth(omega)).abs() < 1e-9;
                let Some(located) = found.located.iter().find(|one| near(one.value)) else { continue };
                let curve = window.curve(&located.orbit, Event::Grazing, located.evidence, 1e-4).unwrap();
                assert_eq!(curve.ends, [CurveEnd::Edge, CurveEnd::Edge], "{from} {start}");
                assert!(curve.special.is_empty(), "{from} {start}: {:?}", curve.special);
                assert!(curve.points.iter().all(|point| point.physical == Some(true)), "{from} {start}");
                let mut ends = [curve.points[0].values[1], curve.points[curve.points.len() - 1].values[1]];
                ends.sort_by(f64::total_cmp);
                assert_eq!(ends, [from, to]);
                for point in &curve.points {
                    let [amplitude, omega] = point.values;
                    assert!((amplitude - truth(omega)).abs() < 1e-12, "{omega} {amplitude}");
                }
                followed += 1;
            }
            assert!(followed > 0, "{from} {start}");
        }
    }
}

/// Their orbit lasts however far it is followed: once a curve of period doublings crept there for fifty thousand points.
#[test]
fn a_curve_ends_where_impulses_grow_without_bound() {
    let (window, orbit) = (frequencies_and_couplings(), first(&conservative(6, 0.15, 1.3), Family::DoubleSided));
    let found = locate(&orbit, &Search::new(&orbit, Event::PeriodDoubling, Parameter::Omega)).unwrap();
    let mut unbounded = 0;
    for located in &found.located {
        let curve = window.curve(&located.orbit, Event::PeriodDoubling, located.evidence, 1e-4).unwrap();
        assert!(curve.points.len() < 5000 && !curve.ends.contains(&CurveEnd::Long), "{}", curve.points.len());
        for (end, point) in curve.ends.iter().zip([curve.points.first(), curve.points.last()]) {
            if *end == CurveEnd::Unbounded {
                assert!(point.unwrap().orbit.impulses()[0].abs() > 1e3);
                unbounded += 1;
            }
        }
    }
    assert!(unbounded >= 2, "{unbounded}");
}

/// Towards the modes resonances fold it again and again; it was lost at ω = 1.0104 once.
#[test]
fn a_curve_goes_on_between_resonances() {
    let plane = Plane::new([Parameter::Amplitude, Parameter::Omega], [0.02, 0.8], [0.6, 1.6]);
    let single = first(&forced(1.07, 0.8, 0.165, 0.25), Family::SingleSided);
    let curve = followed(&single, Event::PeriodDoubling, Parameter::Amplitude, &plane, 1e-6);
    let beyond: Vec<_> = curve.points.iter().filter(|point| point.values[1] < 1.0103).collect();
    assert!(beyond.len() > 100 && beyond.iter().any(|point| point.values[1] < 1.005), "{}", beyond.len());
    let mut random = Random(7);
    let doubles = |_: &usize| {
        let point = beyond[random.below(beyond.len())];
        let all = stability(&point.orbit, Tolerance::Rounding).unwrap().multipliers;
        all.iter().any(|mu| (mu + 1.0).norm() < 1e-6)
    };
    // Next to grazing orbits multipliers lose digits.
    let count = (0..40).filter(doubles).count();
    assert!(count >= 36, "{count}");
}

/// Without coupling modes have their multipliers on the circle at any frequency. With little coupling the mass that hits feeds all of them on one
/// side of one frequency and damps them on the other, whatever the mode: all curves lead there, and each was lost on its way.
#[test]
fn curves_of_modes_end_where_masses_are_not_coupled() {
    let ring = Point::ring(5).gamma1(0.2).gamma2(0.05133674).omega(0.8153237).asymmetry(0.4);
    let model = ring.amplitude(0.1).restitution(0.9).model().unwrap();
    let orbit = breathers(&model, Family::SingleSided).unwrap().orbits[1].clone();
    let found = locate(&orbit, &Search::new(&orbit, Event::NeimarkSacker, Parameter::Omega)).unwrap();
    let mut ends = Vec::new();
    for located in &found.located {
        let curve =
            frequencies_and_couplings().curve(&located.orbit, Event::NeimarkSacker, located.evidence, 1e-6).unwrap();
        assert!(!curve.ends.iter().any(|end| matches!(end, CurveEnd::Lost(_))), "{:?}", curve.ends);
        let points = [curve.points.first(), curve.points.last()];
        let there = curve.ends.iter().zip(points).filter(|(end, _)| **end == CurveEnd::Uncoupled);
        ends.extend(there.map(|(_, point)| point.unwrap().values));
    }
    assert!(ends.len() >= 2, "{ends:?}");
    let first = ends[0][0];
    // All at one frequency, as the mass that hits is alone there.
    assert!(ends.iter().all(|[omega, gamma2]| (omega - first).abs() < 1e-3 && *gamma2 < 3e-5), "{ends:?}");
}

#[test]
fn what_cannot_be_followed_is_told() {
    let orbit = first(&conservative(6, 0.15, 1.3), Family::DoubleSided);
    let found = locate(&orbit, &Search::new(&orbit, Event::Grazing, Parameter::Omega)).unwrap();
    let (start, evidence) = (&found.located[0].orbit, found.located[0].evidence);
    let with = |parameters, tolerance| {
        let window = Plane { parameters, ..frequencies_and_couplings() };
        window.curve(start, Event::Grazing, evidence, tolerance).unwrap_err()
    };
    assert_eq!(with([Parameter::Omega; 2], 1e-6), CurveError::Same("omega".to_owned()));
    assert_eq!(with([Parameter::Omega, Parameter::Gamma2], 0.1), CurveError::Tolerance(0.1));
    let force = with([Parameter::Omega, Parameter::Amplitude], 1e-6);
    assert_eq!(force, CurveError::NoLoad("amplitude".to_owned()));
    let message = with([Parameter::Gamma1, Parameter::Gamma2], 1e-6).to_string();
    assert!(message.contains("gamma1 = 0.2 is not in the window from 0.4 to 3"), "{message}");
}

/// The asymmetry at which a double-sided breather under a force has its second impact at φ, on the branch of ψ that holds the cusp: the
/// impulses from Newton's law, which is linear in them, at both impacts, ψ from the width of the gap, and the asymmetry is what is
/// left. The impulse response is the plain sum over the modes of the ring.
fn asymmetry_at(model: &Model, phi: f64) -> f64 {
    let (chain, omega, amplitude) = (model.chain(), model.omega(), model.amplitude());
    let (masses, period) = (chain.sites() as f64, TAU / omega);
    let modes = || {
        (0..chain.sites()).map(|k| {
            let sine = (PI * k as f64 / masses).sin();
            (chain.gamma1() + 4.0 * chain.gamma2() * sine * sine).sqrt()
        })
    };
    let height = |t: f64| {
        let of = |w: f64| (w * (t - 0.5 * period)).cos() / (2.0 * w * (0.5 * w * period).sin());
        modes().map(of).sum::<f64>() / masses
    };
    let slope = |t: f64| {
        let of = |w: f64| -(w * (t - 0.5 * period)).sin() / (2.0 * (0.5 * w * period).sin());
        modes().map(of).sum::<f64>() / masses
    };
    let half_loss = 0.5 * (1.0 - model.restitution()) / (1.0 + model.restitution());
    let steady = amplitude / (chain.gamma1() - omega * omega);
    let (there, back) = (slope(phi), slope(period - phi));
    let determinant = half_loss * half_loss - there * back;
    let (cosine, sine) = ((omega * phi).cos(), (omega * phi).sin());
    // Displacement at both impacts for a force whose phase at the first one has this cosine and sine.
    let displacements = |c: f64, s: f64| {
        let pushes = [steady * omega * s, steady * omega * (s * cosine + c * sine)];
        let first = (half_loss * pushes[0] - back * pushes[1]) / determinant;
        let second = (half_loss * pushes[1] - there * pushes[0]) / determinant;
        let later = c * cosine - s * sine;
        [
            first * height(0.0) + second * height(period - phi) + steady * c,
            first * height(phi) + second * height(0.0) + steady * later,
        ]
    };
    let ([a, b], [c, d]) = (displacements(1.0, 0.0), displacements(0.0, 1.0));
    let (x, y) = (a - b, c - d);
    let phase = y.atan2(x) - (2.0 / x.hypot(y)).acos();
    0.5 * displacements(phase.cos(), phase.sin()).iter().sum::<f64>()
}

/// Two folds of double-sided breathers meet where a(φ) has no slope and no curvature: three breathers merge there.
#[test]
fn folds_meet_in_a_cusp_where_three_breathers_merge() {
    let at = |asymmetry: f64, amplitude: f64| {
        let ring = Point::ring(6).gamma1(0.5).gamma2(0.05);
        ring.omega(0.93).asymmetry(asymmetry).amplitude(amplitude).restitution(0.76).model().unwrap()
    };
    let list = |model: &Model| breathers(model, Family::DoubleSided).unwrap().orbits;
    let window = Plane::new([Parameter::Asymmetry, Parameter::Amplitude], [0.3, 2.2], [0.95, 3.0]);
    let start = list(&at(0.64, 2.55));
    // The formula is that of the family: it gives the asymmetry back.
    let own: Vec<&Orbit> = start
        .iter()
        .filter(|orbit| (asymmetry_at(orbit.model().unwrap(), orbit.phi().unwrap()) - 0.64).abs() < 1e-12)
        .collect();
    assert!(own.len() >= 3, "{}", own.len());
    let (mut met, mut folds) = (0, 0);
    for orbit in own {
        let search = Search { from: 0.3, to: 0.95, ..Search::new(orbit, Event::Fold, Parameter::Asymmetry) };
        for located in locate(orbit, &search).unwrap().located {
            folds += 1;
            let curve = window.curve(&located.orbit, Event::Fold, located.evidence, TOLERANCE).unwrap();
            let special = curve.special.iter().find(|special| special.special == Special::Cusp);
            let Some(special) = special else { continue };
            met += 1;
            let point = &curve.points[special.point];
            let (model, phi) = (point.orbit.model().unwrap(), point.orbit.phi().unwrap());
            assert!((asymmetry_at(model, phi) - point.values[0]).abs() < 1e-12);
            let h = 2e-3;
            let value = |i: i32| asymmetry_at(model, phi + f64::from(i) * h);
            let first = (8.0 * (value(1) - value(-1)) - (value(2) - value(-2))) / (12.0 * h);
            let second = (16.0 * (value(1) + value(-1)) - (value(2) + value(-2)) - 30.0 * value(0)) / (12.0 * h * h);
            let third = (value(2) - value(-2) - 2.0 * (value(1) - value(-1))) / (2.0 * h * h * h);
            assert!(third.abs() > 0.1 && first.abs() < 1e-8 && second.abs() < 1e-5, "{first} {second} {third}");
            // Along the amplitude, between the two folds: two more breathers than before the cusp.
            let near = |amplitude: f64| {
                let between: Vec<f64> = curve
                    .points
                    .windows(2)
                    .filter(|pair| (pair[0].values[1] < amplitude) != (pair[1].values[1] < amplitude))
                    .map(|pair| {
                        let part = (amplitude - pair[0].values[1]) / (pair[1].values[1] - pair[0].values[1]);
                        pair[0].values[0] + part * (pair[1].values[0] - pair[0].values[0])
                    })
                    .collect();
                let [low, high] = between.try_into().unwrap();
                list(&at(0.5 * (low + high), amplitude)).len()
            };
            let before = list(&at(point.values[0], point.values[1] - 0.01)).len();
            assert_eq!(near(point.values[1] + 0.02), before + 2);
        }
    }
    assert!(met >= 2 && folds >= met, "{met} of {folds}");
}

/// An edge of a stripe of the paper's map runs into the corner where masses are not coupled and the orbit's frequency is that of a mass alone, where
/// no orbit of all masses can be told: it is told up to there. In between one side of it is stable, the other not, as a dense matrix says.
#[test]
fn an_edge_that_comes_to_a_resonance_is_told_up_to_there() {
    let ring = Point::ring(21).gamma1(0.2).asymmetry(0.4);
    let at = |omega: f64, gamma2: f64| {
        let model = ring.gamma2(gamma2).omega(omega).model().unwrap();
        breathers(&model, Family::SingleSided).unwrap().orbits.remove(0)
    };
    let orbit = at(0.4836, 0.017938470077622917);
    let (event, free) = (Event::NeimarkSacker, Parameter::Omega);
    let found = locate(&orbit, &Search { event, free, from: 0.4836, to: 0.4837 }).unwrap();
    let located = found.located.iter().find(|one| (one.value - 0.48365595).abs() < 1e-8).unwrap();
    let window = Plane::new([Parameter::Omega, Parameter::Gamma2], [0.4, 0.0], [3.0, 0.3]);
    let walk = Walk { special: false, ..Walk::new(window.window, 1e-6) };
    let numbers = located.orbit.lattice().unwrap().numbers(&window.parameters, &Stop::default());
    let edge = event_curve(&located.orbit, event, located.evidence, &numbers, &walk).unwrap();
    let [first, last] = [0, edge.points.len() - 1].map(|i| edge.points[i].values);
    let corner = first[1].min(last[1]);
    assert!(edge.points.len() > 20 && corner < 1e-4, "{} {first:?} {last:?}", edge.points.len());
    let mut sides = 0;
    for point in edge.points.iter().filter(|point| (0.01..0.03).contains(&point.values[1])) {
        let [omega, gamma2] = point.values;
        let stable = [-1e-7, 1e-7].map(|by| {
            let orbit = at(omega + by, gamma2);
            let mut finder = Finder::new(21);
            let verdict = Analyser::dense().verdict(&orbit, &mut finder, Tolerance::Rounding).unwrap();
            verdict.spectral_radius < 1.0 + 1e-9
        });
        sides += usize::from(stable[0] != stable[1]);
    }
    assert!(sides > 3, "{sides}");
}

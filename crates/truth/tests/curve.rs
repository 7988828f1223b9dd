//! Points of curves of events in two parameters: with many digits the event is there, to the error claimed.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::f64::consts::PI;

use vibrochain_breather::{Branch, Family, Hit, Orbit, breathers};
use vibrochain_floquet::{CurvePoint, Event, EventCurve, Search, locate};
use vibrochain_lattice::{Chain, Model, Parameter, Point, Spectrum};
use vibrochain_testkit::{Plane, Random};
use vibrochain_truth::{Complex, DEFAULT_BITS, TrueOrbit, TrueSpectrum};

fn forced(omega: f64, asymmetry: f64, amplitude: f64, restitution: f64) -> Model {
    let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
    ring.omega(omega).asymmetry(asymmetry).amplitude(amplitude).restitution(restitution).model().unwrap()
}

fn followed(model: &Model, family: Family, event: Event, window: &Plane) -> EventCurve {
    let orbit = &breathers(model, family).unwrap().orbits[0];
    let found = locate(orbit, &Search::new(orbit, event, Parameter::Amplitude)).unwrap();
    let located = found.located.first().unwrap();
    window.curve(&located.orbit, event, located.evidence, 1e-4).unwrap()
}

/// The orbit with its second impact half a period after the first, and as strong.
fn symmetric(orbit: &Orbit) -> Orbit {
    let [first, second] = orbit.impacts() else { unreachable!() };
    let impulse = 0.5 * (first.impulse - second.impulse);
    let hits = [(first, 0.0, impulse), (second, 0.5 * orbit.period(), -impulse)]
        .map(|(impact, time, impulse)| Hit::new(impact.site, impact.barrier, time, impulse));
    Orbit::from_impulses(orbit.model().unwrap(), 1, orbit.psi().unwrap(), &hits).unwrap()
}

/// Which side of the event an orbit is on: that of −1 for a period doubling, of 1 for a pitchfork, of the circle for a pair.
fn side(orbit: &Orbit, event: Event, point: &CurvePoint) -> bool {
    // At a pitchfork an orbit is as symmetric as the root of its rounding; the one meant is so exactly.
    let orbit = if event == Event::Pitchfork { &symmetric(orbit) } else { orbit };
    let orbit = TrueOrbit::refine(orbit, DEFAULT_BITS).unwrap();
    let spectrum = TrueSpectrum::new(&orbit).unwrap();
    let real = |mu: f64| spectrum.characteristic(&Complex::new(mu, 0.0, DEFAULT_BITS)).unwrap().to_f64().0 > 0.0;
    match event {
        Event::PeriodDoubling => return real(-1.0),
        Event::Pitchfork => return real(1.0),
        _ => {}
    }
    let angle = point.angle.unwrap() * PI;
    let (multiplier, moved) = spectrum.refine((angle.cos(), angle.sin())).unwrap();
    assert!(moved < 1e-6, "{moved:e}");
    (multiplier.norm_sqr() + -1.0).to_f64() > 0.0
}

/// Curves, each from its first event along the amplitude.
fn cases() -> Vec<(Model, Family, Event, Plane)> {
    let window = |second, from, to| Plane::new([Parameter::Amplitude, second], from, to);
    let doubling = forced(1.07, 0.8, 0.165, 0.25);
    let pair = forced(1.5, 0.4, 0.1, 0.9);
    let centred = Point::ring(21).gamma1(0.1).gamma2(0.05).omega(1.33).amplitude(1.5).restitution(0.9).model().unwrap();
    vec![
        (doubling, Family::SingleSided, Event::PeriodDoubling, window(Parameter::Restitution, [0.1, 0.1], [0.3, 0.9])),
        (doubling, Family::SingleSided, Event::PeriodDoubling, window(Parameter::Omega, [0.1, 1.0], [0.3, 1.15])),
        (doubling, Family::SingleSided, Event::PeriodDoubling, window(Parameter::Asymmetry, [0.1, 0.7], [0.3, 0.9])),
        (pair, Family::DoubleSided, Event::NeimarkSacker, window(Parameter::Omega, [0.06, 1.3], [0.3, 2.0])),
        (pair, Family::DoubleSided, Event::NeimarkSacker, window(Parameter::Restitution, [0.06, 0.7], [0.3, 0.95])),
        (centred, Family::DoubleSided, Event::Pitchfork, window(Parameter::Omega, [0.5, 1.2], [3.0, 1.5])),
    ]
}

/// Whether the event is within the error of a point, along the axis that the curve crosses; `None` where no branch leads to both sides.
fn encloses(curve: &EventCurve, i: usize, window: &Plane) -> Option<bool> {
    let (point, from, to) = (&curve.points[i], &curve.points[i - 1], &curve.points[i + 1]);
    let [dx, dy] = [0, 1].map(|k| (to.values[k] - from.values[k]).abs() / window.sides()[k]);
    // Farther, as the curve crosses it aslant.
    let axis = usize::from(dx > dy);
    let reach = point.error * window.sides()[axis] * dx.hypot(dy) / dx.max(dy);
    let free = window.parameters[axis];
    let at = |value: f64| point.orbit.model().unwrap().with(free, value).unwrap();
    let beyond = |sign: f64| point.values[axis] + sign * reach;
    if curve.event == Event::Pitchfork {
        // At a pitchfork a branch has two directions. The point's own impacts stand for the symmetric orbit beside it, which is as near as the error.
        let hits: Vec<Hit> = point.orbit.impacts().iter().map(Hit::from).collect();
        let beside = |sign: f64| {
            let psi = point.orbit.psi().unwrap();
            side(&Orbit::from_impulses(&at(beyond(sign)), 1, psi, &hits).unwrap(), curve.event, point)
        };
        return Some(beside(1.0) != beside(-1.0));
    }
    let mut branch = Branch::of_orbit(&point.orbit, free, window.sides()[axis]).unwrap();
    let start = branch.start().ok()?;
    let mut beside = |sign: f64| {
        let there = branch.at(&start, beyond(sign)).ok()?;
        Some(side(&there.orbit().to_orbit(point.orbit.family()).unwrap(), curve.event, point))
    };
    Some(beside(1.0)? != beside(-1.0)?)
}

/// Looks at `each` points of every curve, at random; how many in all.
fn check(each: usize) -> usize {
    let mut random = Random(23);
    let mut all = 0;
    for (model, family, event, window) in cases() {
        let curve = followed(&model, family, event, &window);
        let (mut checked, mut vague) = (0, 0);
        for _ in 0..2 * each {
            let i = 1 + random.below(curve.points.len() - 2);
            let point = &curve.points[i];
            let Some(enclosed) = encloses(&curve, i, &window) else { continue };
            assert!(enclosed, "{event} at {:?} ± {:e}", point.values, point.error);
            checked += 1;
            vague += usize::from(point.error > 1e-9);
            if checked == each {
                break;
            }
        }
        assert!(checked == each && vague <= checked / 4 + 1, "{event}: {checked} {vague}");
        all += checked;
    }
    all
}

/// Towards a resonance all derivatives grow without bound.
#[test]
fn next_to_a_resonance_events_are_where_curves_say() {
    let model = Model::conservative(Chain::new(6, 0.2, 0.15).unwrap(), 1.3, 0.4).unwrap();
    let orbit = &breathers(&model, Family::DoubleSided).unwrap().orbits[0];
    let window = Plane::new([Parameter::Omega, Parameter::Gamma2], [0.4, 0.0], [3.0, 0.3]);
    let found = locate(orbit, &Search::new(orbit, Event::PeriodDoubling, Parameter::Omega)).unwrap();
    let (mut checked, mut claimed) = (0, 0);
    for located in &found.located {
        let curve = window.curve(&located.orbit, located.event, located.evidence, 1e-4).unwrap();
        let near = |i: &usize| {
            let chain = curve.points[*i].orbit.model().unwrap().chain();
            let ratios = Spectrum::new(*chain).frequencies().to_vec();
            let apart = |frequency: f64| (frequency / curve.points[*i].orbit.frequency()).fract();
            ratios.into_iter().map(apart).any(|part| part > 0.0 && part.min(1.0 - part) < 3e-3)
        };
        let next: Vec<usize> = (1..curve.points.len() - 1).filter(near).collect();
        for &i in next.iter().step_by(next.len().div_ceil(12).max(1)) {
            let point = &curve.points[i];
            let Some(enclosed) = encloses(&curve, i, &window) else { continue };
            assert!(enclosed, "at {:?} ± {:e}", point.values, point.error);
            checked += 1;
            claimed += usize::from(point.error < 1e-9);
        }
    }
    assert!(checked >= 6 && claimed == checked, "{checked} {claimed}");
}

#[test]
fn events_are_where_curves_say_to_the_error_claimed() {
    assert_eq!(check(7), 42);
}

#[test]
#[ignore = "slow: half a minute"]
fn slow_events_are_where_curves_say_at_two_hundred_points() {
    assert_eq!(check(34), 204);
}

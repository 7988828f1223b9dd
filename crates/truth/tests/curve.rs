//! Points of curves of events in two parameters: with many digits the event is there, to the error claimed.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::f64::consts::PI;

use vibrochain_breather::{Branch, Family, Orbit, breathers};
use vibrochain_floquet::{CurvePoint, Event, EventCurve, Search, Window, curve, locate};
use vibrochain_lattice::{Chain, Model, Parameter};
use vibrochain_truth::{Complex, DEFAULT_BITS, TrueOrbit, TrueSpectrum};

fn forced(omega: f64, asymmetry: f64, amplitude: f64, restitution: f64) -> Model {
    Model::forced(Chain::new(21, 0.2, 0.1).unwrap(), omega, asymmetry, amplitude, restitution).unwrap()
}

fn followed(model: &Model, family: Family, event: Event, window: &Window) -> EventCurve {
    let orbit = &breathers(model, family).unwrap().orbits[0];
    let found = locate(orbit, &Search::new(orbit, event, Parameter::Amplitude)).unwrap();
    let located = found.located.first().unwrap();
    curve(&located.orbit, event, located.evidence, window, 1e-4).unwrap()
}

/// Which side of the event an orbit is on: that of −1 for a period doubling, of the circle for a pair.
fn side(orbit: &Orbit, event: Event, point: &CurvePoint) -> bool {
    let orbit = TrueOrbit::refine(orbit, DEFAULT_BITS).unwrap();
    let spectrum = TrueSpectrum::new(&orbit).unwrap();
    if event == Event::PeriodDoubling {
        return spectrum.characteristic(&Complex::new(-1.0, 0.0, DEFAULT_BITS)).unwrap().to_f64().0 > 0.0;
    }
    let angle = point.angle.unwrap() * PI;
    let (multiplier, moved) = spectrum.refine((angle.cos(), angle.sin())).unwrap();
    assert!(moved < 1e-6, "{moved:e}");
    (multiplier.norm_sqr() + -1.0).to_f64() > 0.0
}

#[test]
fn events_are_where_curves_say_to_the_error_claimed() {
    let cases = [
        (
            forced(1.07, 0.8, 0.165, 0.25),
            Family::SingleSided,
            Event::PeriodDoubling,
            Window { parameters: [Parameter::Amplitude, Parameter::Restitution], from: [0.1, 0.1], to: [0.3, 0.9] },
        ),
        (
            forced(1.5, 0.4, 0.1, 0.9),
            Family::DoubleSided,
            Event::NeimarkSacker,
            Window { parameters: [Parameter::Amplitude, Parameter::Omega], from: [0.06, 1.3], to: [0.3, 2.0] },
        ),
    ];
    for (model, family, event, window) in cases {
        let curve = followed(&model, family, event, &window);
        let (mut checked, mut vague) = (0, 0);
        let step = 1 + curve.points.len() / 20;
        for (i, point) in curve.points.iter().enumerate().skip(1).step_by(step) {
            let last = curve.points.len() - 1;
            let (from, to) = (&curve.points[i.saturating_sub(1)], &curve.points[(i + 1).min(last)]);
            let [dx, dy] = [0, 1].map(|k| (to.values[k] - from.values[k]).abs() / window.sides()[k]);
            // Along the axis that the curve crosses; farther, as it crosses it aslant.
            let axis = usize::from(dx > dy);
            let reach = point.error * window.sides()[axis] * dx.hypot(dy) / dx.max(dy);
            let free = window.parameters[axis];
            let mut branch = Branch::through(&point.orbit, free, window.sides()[axis]).unwrap();
            let Ok(start) = branch.start() else { continue };
            let sides = [1.0, -1.0].map(|sign| {
                let there = branch.at(&start, point.values[axis] + sign * reach).unwrap();
                side(there.orbit(), event, point)
            });
            assert!(sides[0] != sides[1], "{event} at {:?} ± {:e}", point.values, point.error);
            checked += 1;
            vague += usize::from(point.error > 1e-9);
        }
        assert!(checked >= 12 && vague <= checked / 4, "{event}: {checked} {vague}");
    }
}

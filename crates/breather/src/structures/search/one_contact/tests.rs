//! The symmetric form of F against elimination.

use std::sync::Arc;

use smallvec::smallvec;
use vibrochain_lattice::{Barrier, Complex, Contact, LinearMode, ModalStructure, ModeShape};
use vibrochain_testkit::Random;

use super::*;
use crate::roots::assert_enclosed::assert_enclosed;
use crate::structures::equations::Equations;
use crate::structures::model::LoadedStructure;

/// F has the sign that elimination gives, its slope is that of its values, enclosures hold what they enclose, and numbers at its zeros solve the
/// linear equations; of both barriers and of one, any harmonic and number of periods, with what nothing holds and without.
#[test]
fn the_symmetric_form_is_that_of_elimination() {
    let mut random = Random(29);
    let (mut checked, mut away, mut solved, mut rounds) = (0, 0, 0, 0);
    while rounds < 60 {
        let held = random.chance(0.8);
        let restitution = random.between(0.3, 1.0);
        let contact = Contact { lower: Some(-0.7), upper: Some(0.4), restitution };
        let mut mode = |number: usize| {
            let square = if number == 0 && !held { 0.0 } else { random.log(0.1, 9.0) };
            let still = if square == 0.0 { 0.0 } else { random.between(-0.1, 0.1) };
            let shape = ModeShape { contacts: vec![random.between(0.2, 1.0)], coordinates: Vec::new(), still };
            LinearMode::oscillator(0.0, square, &shape, &[Complex::new(random.between(0.1, 1.0), 0.0)])
        };
        let modes = (0..1 + rounds % 5).map(&mut mode).collect();
        let structure = ModalStructure::new(vec![contact], vec![1 + random.below(2) as u32], modes).unwrap();
        let model = LoadedStructure::new(Arc::new(structure), random.between(0.5, 3.0)).unwrap();
        let periods = 1 + random.below(3) as u32;
        let second = random.of(&[Barrier::Lower, Barrier::Upper]);
        let equations = Equations::new(&model, periods, [0, 0].into_iter()).unwrap();
        let impacts = Impacts { equations: &equations, letters: smallvec![(0, Barrier::Upper), (0, second)] };
        let Some(function) = impacts.function_of_one_contact() else { continue };
        rounds += 1;
        let half = function.half;
        let place = |i: i32| half * f64::from(i) / 20.5;
        let scale = (-20..=20).map(|i| function.at(place(i)).0.abs()).fold(0.0, f64::max);
        for i in -20..=20 {
            let delta = place(i);
            let (value, slope) = function.at(delta);
            if i != 0 && value.abs() > 1e-9 * scale {
                let told = impacts.value(half + delta).unwrap()[0];
                assert_eq!(value > 0.0, told > 0.0, "{delta} {value} {told}");
            }
            let h = 1e-5 * half;
            let quotient = (function.at(delta + h).0 - function.at(delta - h).0) / (2.0 * h);
            assert!((slope - quotient).abs() < 1e-5 * (slope.abs() + scale / half), "{slope} {quotient}");
            let radius = half * random.log(1e-4, 0.02);
            away += assert_enclosed(&function, delta, radius, [f64::NEG_INFINITY, f64::INFINITY]);
            checked += 1;
        }
        let mut zeros = Zeros::default();
        function.zeros(None, &mut zeros);
        for &delta in zeros.simple.iter().filter(|delta| delta.abs() > 1e-3 * half) {
            let point = impacts.point_of(half + delta, function.solution(delta).unwrap());
            let system = equations.system(&point).unwrap();
            let worst = system.rows.iter().zip(&system.sizes).map(|(row, size)| row.abs() / size).fold(0.0, f64::max);
            assert!(worst < 1e-10, "{delta} {worst:e}");
            solved += 1;
        }
    }
    assert!(checked == 60 * 41 && away > 10_000 && solved > 60, "{checked} {away} {solved}");
}

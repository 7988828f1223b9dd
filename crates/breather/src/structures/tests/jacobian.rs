//! The equations' derivatives are what differences of their rows say, at orbits and elsewhere.

use smallvec::smallvec;
use vibrochain_lattice::{Barrier, Chain, Stop};
use vibrochain_testkit::Random;

use super::{model, next_to_a_resonance};
use crate::structures::equations::Equations;
use crate::structures::model::LoadedStructure;
use crate::structures::point::{Point, Strike};

/// How far an unknown is moved, as a part of its size.
const STEP: f64 = 1e-6;

/// Masses of a ring or of a row with free ends, under a force or none.
fn lattice(random: &mut Random) -> LoadedStructure {
    let sites = 2 + random.below(6);
    let chain = Chain::new(sites, random.between(0.1, 1.1), random.between(0.01, 0.3)).unwrap();
    let point = chain.point().omega(random.between(0.4, 2.4)).asymmetry(random.between(0.0, 0.5));
    let point = match random.chance(0.5) {
        true => point,
        false => point.amplitude(random.between(0.1, 1.1)).restitution(random.between(0.3, 1.0)),
    };
    LoadedStructure::of_masses(&point.model().unwrap(), &[0, 1], &Stop::default()).unwrap()
}

/// Impacts at any times, not orbits at all.
#[test]
fn the_jacobian_is_the_derivative_of_the_rows() {
    let mut random = Random(5);
    let (mut checked, mut open) = ([0; 4], 0);
    for round in 0..240 {
        let (count, kind) = (1 + round % 4, round / 4 % 3);
        let model = match kind {
            0 => model(&mut random),
            1 => next_to_a_resonance(&mut random, 1e-9),
            _ => lattice(&mut random),
        };
        // The first contact of these has no lower barrier.
        let barrier =
            |random: &mut Random| if kind == 2 && random.chance(0.5) { Barrier::Lower } else { Barrier::Upper };
        let mut times: Vec<f64> = (0..count).map(|_| model.period() * random.between(0.05, 0.95)).collect();
        times[0] = 0.0;
        times.sort_by(f64::total_cmp);
        let strike = |time: f64, random: &mut Random| Strike {
            contact: random.below(2),
            barrier: barrier(random),
            time,
            impulse: random.between(-1.0, 1.0),
        };
        let strikes: Vec<Strike> = times.into_iter().map(|time| strike(time, &mut random)).collect();
        let contacts = strikes.iter().map(|strike| strike.contact);
        let Ok(equations) = Equations::new(&model, 1, contacts) else { continue };
        let point = Point {
            strikes: strikes.iter().copied().collect(),
            psi: if equations.forced { 0.3 } else { 0.0 },
            period: equations.period(),
            offsets: smallvec![0.0; equations.rigid.len()],
        };
        let (equations, point) = equations.opened(&point).unwrap_or((equations, point));
        let system = equations.system(&point).unwrap();
        for unknown in 0..system.rows.len() {
            let mut step = vec![0.0; system.rows.len()];
            let moved = |by: f64, step: &mut Vec<f64>| {
                step[unknown] = -by;
                let mut point = point.clone();
                equations.take(&mut point, step);
                equations.system(&point).unwrap().rows
            };
            let (plus, minus) = (moved(STEP, &mut step), moved(-STEP, &mut step));
            for row in 0..system.rows.len() {
                let (entry, slope) = (system.jacobian[(row, unknown)], (plus[row] - minus[row]) / (2.0 * STEP));
                let size =
                    1.0 + system.sizes[row] + system.jacobian.row(row).iter().fold(0.0, |most, x| x.abs().max(most));
                assert!((slope - entry).abs() < 1e-7 * size, "{round} {row} {unknown}: {slope} {entry}");
            }
        }
        checked[count - 1] += 1;
        open += usize::from(!equations.open.is_empty());
    }
    assert!(checked.iter().all(|count| *count > 40) && open > 20, "{checked:?} {open}");
}

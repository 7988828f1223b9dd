//! Runs from states at random: the same impacts.

use nalgebra::DVector;
use vibrochain_eventsim::{Limits, Simulation, Time};
use vibrochain_testkit::{Random, Ranges};

use crate::matrices;

#[test]
fn runs_of_a_chain_are_those_of_a_structure() {
    let mut random = Random(17);
    let (mut impacts, mut worst) = (0, 0.0f64);
    for number in 0..20 {
        let ranges = if number % 4 == 0 { Ranges::CONSERVATIVE } else { Ranges::FORCED };
        let model = random.model(&Ranges { sites: [1, 9], ..ranges });
        let n = model.chain().sites();
        let asymmetry = model.asymmetry();
        let place: Vec<f64> = (0..n).map(|_| asymmetry + random.between(-0.9, 0.9)).collect();
        let velocity: Vec<f64> = (0..n).map(|_| random.between(-2.0, 2.0)).collect();
        let psi = random.between(0.0, model.period());
        let matrices = matrices(&model);
        let modal = matrices.modal().unwrap();
        let modes =
            matrices.project(&modal, &DVector::from_row_slice(&place), &DVector::from_row_slice(&velocity)).unwrap();
        // Differences grow from impact to impact.
        let until = Limits { impacts: 12, ..Limits::until(Time::new(&model, 4, 0.0)) };
        let (report, one) = Simulation::new(&model, psi, &place, &velocity).unwrap().collect(&until);
        let mut simulation = Simulation::of_modes(modal, model.omega(), psi, &modes).unwrap();
        let (other, two) = simulation.collect(&until);
        assert_eq!(one.len(), two.len(), "{number} {model}: {report:?} {other:?}");
        for (a, b) in one.iter().zip(&two) {
            assert_eq!((a.contact, a.barrier, a.kind), (b.contact, b.barrier, b.kind), "{number} {model}: {a:?} {b:?}");
            let apart = (a.time.to_f64() - b.time.to_f64()).abs() / model.period();
            worst = worst.max(apart).max((a.velocity_after - b.velocity_after).abs());
        }
        impacts += one.len();
    }
    assert!(impacts > 150 && worst < 1e-12, "{impacts} {worst:e}");
}

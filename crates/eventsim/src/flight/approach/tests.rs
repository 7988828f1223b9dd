//! The bound of what a contact sees of a mode.

use super::*;
use vibrochain_lattice::ModeShape;
use vibrochain_testkit::Random;

/// Modes that turn, stretch and shear, die, stay or grow, of real shape and complex: no contact sees more of them than the bound, and of each
/// kind one nearly sees that much.
#[test]
fn what_a_contact_sees_of_a_mode_is_within_its_bound() {
    let mut random = Random(31);
    let mut nearest = [[0.0_f64; 3]; 3];
    for round in 0..4000 {
        let (kind, fate) = (round % 3, (round / 3) % 3);
        let frequency = random.log(0.1, 5.0);
        let decay = [random.log(1e-3, 2.0), 0.0, -random.log(1e-3, 0.5)][fate];
        let square = [frequency * frequency, -frequency * frequency, 0.0][kind];
        let shape = ModeShape { contacts: vec![1.0], coordinates: Vec::new(), still: 0.0 };
        let mode = LinearMode::oscillator(decay, square, &shape, &[]);
        let [row, y] = [(); 2].map(|()| [random.between(-1.0, 1.0), random.between(-1.0, 1.0)]);
        let row = if random.chance(0.5) { [row[0], 0.0] } else { row };
        let h = random.log(1e-3, 5.0);
        let most = (0..=400).fold(0.0, |most: f64, i| {
            let flown = mode.turn.act(mode.flight(h * f64::from(i) / 400.0), y);
            most.max((row[0] * flown[0] + row[1] * flown[1]).abs())
        });
        let bound = bound(&mode, row, y, h);
        assert!(most <= bound * (1.0 + 1e-12), "{mode:?} {row:?} {y:?} {h}: {most} {bound}");
        // Of one that stretches while it dies or stays less is told than sinh is.
        let near = &mut nearest[kind][fate];
        *near = near.max(most / bound);
    }
    assert!(nearest.iter().flatten().all(|near| *near > 0.9), "{nearest:?}");
}

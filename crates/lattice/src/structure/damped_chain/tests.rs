//! Chains' modes against more digits, critical ones, and what is refused.

use super::*;
use crate::kernel::turn::Turn;
use crate::modes::row::Ends;

const STOP: Contact = Contact { lower: None, upper: Some(1.0), restitution: 0.9 };

fn at(n: usize) -> (Vec<(usize, f64)>, Contact) {
    (vec![(n, 1.0)], STOP)
}

/// Rates, decays and shapes at mass 1 of five masses by mpmath in 50 digits (`eigsy` of the matrices).
#[test]
fn modes_are_right_to_the_last_digit() {
    let right = [
        (
            RowEnds::Alike(Ends::Free),
            0.3,
            [
                (0.44718564377672054, 0.005, 0.4472135954999579),
                (0.484061924084877, 0.06229490168751577, 0.3717480344601845),
                (0.5414124821635521, 0.21229490168751577, 0.1954395075848548),
                (0.5510299934225421, 0.39770509831248424, 0.6015009550075456),
                (0.5116859624393673, 0.5477050983124843, 0.5116672736016927),
            ],
        ),
        (
            RowEnds::Alike(Ends::Free),
            1.1,
            [
                (0.44718564377672054, 0.005, 0.4472135954999579),
                (0.43810573250491086, 0.21508130618755786, 0.3717480344601845),
                (0.49714465093436255, 0.7650813061875579, 0.1954395075848548),
                (1.2751418089191746, 1.4449186938124423, 0.6015009550075456),
                (1.8487555803965412, 1.9949186938124424, 0.5116672736016927),
            ],
        ),
        (
            RowEnds::Alike(Ends::Fixed),
            0.3,
            [
                (0.47408076119545767, 0.045192378864668405, 0.5),
                (0.5253332275803616, 0.155, 0.5),
                (0.5540532465386337, 0.305, 0.0),
                (0.5412716508371744, 0.45499999999999996, 0.5),
                (0.5041799598004025, 0.5648076211353316, 0.5),
            ],
        ),
        (
            RowEnds::Alike(Ends::Fixed),
            1.1,
            [
                (0.4511958287075387, 0.1523720558371175, 0.5),
                (0.08958236433584477, 0.555, 0.5),
                (0.9061042986323374, 1.105, 0.0),
                (1.4963371946189135, 1.655, 0.5),
                (1.9132766856477093, 2.0576279441628826, 0.5),
            ],
        ),
        (
            RowEnds::FixedFree,
            0.3,
            [
                (0.45585876153820976, 0.017152107915650784, 0.32601867960931696),
                (0.5071947705223586, 0.10854177981641448, 0.5968847876668415),
                (0.5502116243428582, 0.26230554851801446, 0.16989112404918136),
                (0.5463568323436341, 0.4296245039005659, 0.4557341406552499),
                (0.5075259938890275, 0.5573760598493543, 0.5485287319805897),
            ],
        ),
        (
            RowEnds::FixedFree,
            1.1,
            [
                (0.4534814624337792, 0.04955772902405287, 0.32601867960931696),
                (0.3479508220816104, 0.38465319266018644, 0.5968847876668415),
                (0.7266549021203463, 0.9484536778993864, 0.16989112404918136),
                (1.3987941771291128, 1.5619565143020753, 0.4557341406552499),
                (1.8852553446715135, 2.0303788861142995, 0.5485287319805897),
            ],
        ),
        (
            RowEnds::Alike(Ends::Closed),
            0.3,
            [
                (0.44718564377672054, 0.005, 0.4472135954999579),
                (0.5414124821635521, 0.21229490168751577, 0.1954395075848548),
                (0.5414124821635521, 0.21229490168751577, 0.6015009550075456),
                (0.5116859624393673, 0.5477050983124843, 0.5116672736016927),
                (0.5116859624393673, 0.5477050983124843, 0.3717480344601845),
            ],
        ),
        (
            RowEnds::Alike(Ends::Closed),
            1.1,
            [
                (0.44718564377672054, 0.005, 0.4472135954999579),
                (0.49714465093436255, 0.7650813061875579, 0.1954395075848548),
                (0.49714465093436255, 0.7650813061875579, 0.6015009550075456),
                (1.8487555803965412, 1.9949186938124424, 0.5116672736016927),
                (1.8487555803965412, 1.9949186938124424, 0.3717480344601845),
            ],
        ),
    ];
    let mut checked = 0;
    for (ends, coupling_damping, modes) in right {
        let numbers =
            DampedChain { gamma1: 0.2, gamma2: 0.1, damping: 0.01, coupling_damping, ..DampedChain::new(5, ends) };
        let modal = DampedChain { contacts: vec![at(1)], ..numbers }.modal().unwrap();
        for (k, (mode, (rate, decay, shape))) in modal.modes().iter().zip(modes).enumerate() {
            let hold = |what: &str, value: f64, told: f64, right: f64| {
                let off = (value - right).abs();
                let most = 4.0 * f64::EPSILON * right.abs();
                assert!(
                    off <= told + 0.5 * f64::EPSILON * right.abs() && told <= most,
                    "{ends:?} {k} {what}: {off:e} {told:e}"
                );
            };
            let (poles, size) = (mode.errors.poles, rate + decay);
            assert!(
                (mode.rate - rate).abs() + (mode.decay - decay).abs() <= poles && poles <= 2.0 * f64::EPSILON * size,
                "{ends:?} {k}"
            );
            hold("shape", mode.rows[0][0].abs(), mode.errors.rows[0], shape);
            hold("impulse", mode.columns[0][1].abs(), mode.errors.columns[0], shape / rate);
            checked += 1;
        }
    }
    assert_eq!(checked, 40);
}

/// Two masses between free ends: κ is 0 and 2. Dashpots that make the second mode critical do so to the last bit, and one beside it is not.
#[test]
fn critical_modes_are_critical() {
    let two = DampedChain {
        gamma1: 0.25,
        gamma2: 1.0,
        contacts: vec![at(0)],
        ..DampedChain::new(2, RowEnds::Alike(Ends::Free))
    };
    let turn = |damping: f64, mode: usize| {
        let modal = DampedChain { damping, ..two.clone() }.modal().unwrap();
        let mode = &modal.modes()[mode];
        assert!(mode.errors.poles <= 4.0 * f64::EPSILON, "{:e}", mode.errors.poles);
        (mode.turn, mode.decay)
    };
    assert_eq!(turn(1.0, 0), (Turn::Parabolic, 0.5));
    assert_eq!(turn(3.0, 1), (Turn::Parabolic, 1.5));
    assert_eq!(turn(3.0 * (1.0 + f64::EPSILON), 1).0, Turn::Hyperbolic);
    assert_eq!(turn(3.0 * (1.0 - f64::EPSILON), 1).0, Turn::Circular);
    assert_eq!(turn(-3.0, 1), (Turn::Parabolic, -1.5));
}

/// What no spring holds is rigid, with a dashpot or without; what falls over is refused, and so are numbers and sizes that do not fit.
#[test]
fn chains_without_an_answer_are_refused() {
    let free = DampedChain { gamma2: 0.3, contacts: vec![at(2)], ..DampedChain::new(6, RowEnds::Alike(Ends::Free)) };
    for damping in [0.0, 0.1, -0.1] {
        let modal = DampedChain { damping, ..free.clone() }.modal().unwrap();
        let rigid: Vec<bool> = modal.modes().iter().map(LinearMode::is_rigid).collect();
        assert_eq!(rigid, [true, false, false, false, false, false]);
    }
    // −γ₂κ₀ of three walled masses, rounded: rigid; a little less falls.
    let lowest = 2.0 - 2f64.sqrt();
    let walled = DampedChain {
        gamma1: -lowest,
        gamma2: 1.0,
        contacts: vec![at(0)],
        ..DampedChain::new(3, RowEnds::Alike(Ends::Fixed))
    };
    assert!(walled.modal().unwrap().modes()[0].is_rigid());
    let error = |chain: DampedChain| chain.modal().unwrap_err();
    let falls = error(DampedChain { gamma1: -lowest - 1e-12, ..walled.clone() });
    assert!(matches!(falls, StructureError::Unstable { square } if (square + 1e-12).abs() < 1e-15), "{falls}");
    let stiff = error(DampedChain { gamma1: 1.0, damping: 2e6, ..walled.clone() });
    assert!(matches!(stiff, StructureError::Overdamped { mode: 0, .. }), "{stiff}");
    let told = |chain: DampedChain, told: &str| {
        let error = error(chain).to_string();
        assert!(error.contains(told), "{error}");
    };
    let load = |number: u32, size: usize| vec![(number, vec![C::new(1.0, 0.0); size])];
    told(DampedChain { sites: 0, ..free.clone() }, "sites = 0 is out of range");
    told(DampedChain { modes: Some(0), ..free.clone() }, "modes = 0 is out of range");
    told(DampedChain { gamma2: f64::NAN, ..free.clone() }, "gamma2 = NaN is out of range");
    told(DampedChain { damping: 2e100, ..free.clone() }, "damping = 2e100 is out of range");
    told(
        DampedChain { static_load: vec![1.0], ..free.clone() },
        "the static load has 1 entries where the structure needs 6",
    );
    told(DampedChain { loads: load(1, 5), ..free.clone() }, "the load has 5 entries");
    told(DampedChain { loads: load(0, 6), ..free.clone() }, "harmonic of the load = 0");
    told(DampedChain { contacts: vec![at(6)], ..free.clone() }, "a mass of contact 0 = 6 is out of range");
    told(DampedChain { contacts: vec![at(1), (vec![(2, 0.0)], STOP)], ..free.clone() }, "contact 1 has no weight");
    told(DampedChain { contacts: Vec::new(), ..free.clone() }, "no contact");
    // The middle one of three stands still in the second mode, and two move alike in the first one.
    let pair = DampedChain { contacts: vec![(vec![(0, 1.0), (5, -1.0)], STOP)], modes: Some(1), ..free.clone() };
    told(pair.clone(), "contact 0 does not move in the first 1 modes");
    assert_eq!(DampedChain { modes: Some(2), ..pair }.modal().unwrap().modes().len(), 2);
    let moved = free.project(&free.modal().unwrap(), &[0.0; 6], &[0.0; 5]).unwrap_err();
    assert!(moved.to_string().contains("the velocity has 5 entries"), "{moved}");
}

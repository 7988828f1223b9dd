//! Modes of damped chains in closed form against matrices that are put together spring by spring: as eigenvectors of these, and against the
//! modes that eigensolvers find, of rings and rows of all ends, with dashpots on masses and between them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use nalgebra::{DMatrix, DVector};
use vibrochain::lattice::{
    Chain, Complex, Contact, DampedChain, Ends, LinearMode, ModalStructure, RowEnds, Structure, StructureError,
};
use vibrochain_testkit::{Random, stiffness};

type C = Complex<f64>;

/// L of springs of 1 between neighbours.
fn coupling(sites: usize, ends: RowEnds) -> DMatrix<f64> {
    let row = |ends: Ends| stiffness(&Chain::new(sites, 0.0, 1.0).unwrap().with_ends(ends));
    match ends {
        RowEnds::Alike(ends) => row(ends),
        RowEnds::FixedFree => {
            let mut matrix = row(Ends::Fixed);
            matrix[(sites - 1, sites - 1)] -= 1.0;
            matrix
        }
    }
}

/// The same structure by its matrices. Numbers are sixty-fourths, so that their entries are exact.
fn dense(chain: &DampedChain) -> Structure {
    let n = chain.sites;
    let (unit, coupling) = (DMatrix::identity(n, n), coupling(n, chain.ends));
    let weights = |places: &[(usize, f64)]| {
        let mut weights = DVector::zeros(n);
        places.iter().for_each(|(place, weight)| weights[*place] = *weight);
        weights
    };
    let is_damped = chain.damping != 0.0 || chain.coupling_damping != 0.0;
    Structure {
        mass: unit.clone(),
        stiffness: &unit * chain.gamma1 + &coupling * chain.gamma2,
        damping: if is_damped {
            &unit * chain.damping + &coupling * chain.coupling_damping
        } else {
            DMatrix::default()
        },
        contacts: chain.contacts.iter().map(|(places, contact)| (weights(places), *contact)).collect(),
        static_load: DVector::from_vec(chain.static_load.clone()),
        loads: chain.loads.iter().map(|(number, load)| (*number, DVector::from_vec(load.clone()))).collect(),
        modes: chain.modes,
    }
}

/// Any chain: soft and stiff, rigid, damped not at all, a little, beyond critical, or so that it grows.
fn chain(random: &mut Random) -> DampedChain {
    let sites = 1 + random.below(16);
    let ends = RowEnds::ALL[random.below(4)];
    let sixty_fourths = |random: &mut Random, most: usize| random.below(most + 1) as f64 / 64.0;
    let mut number = |zero: f64, most: usize| if random.chance(zero) { 0.0 } else { sixty_fourths(random, most) };
    let (gamma1, gamma2) = (number(0.2, 64), number(0.15, 64));
    let (damping, coupling_damping) = (number(0.3, 96), number(0.4, 96));
    let damping = if random.chance(0.15) { -damping } else { damping };
    // Where all masses may move alike they do so critically.
    let (gamma1, damping) = if random.chance(0.1) { (0.25 * damping * damping, damping) } else { (gamma1, damping) };
    let stop = Contact { lower: None, upper: Some(1.0), restitution: 0.9 };
    let mut contacts = vec![(vec![(random.below(sites), 1.0)], stop), (vec![(0, 1.0)], stop)];
    if sites > 1 {
        contacts.push((vec![(0, 1.0), (1 + random.below(sites - 1), -1.0)], stop));
    }
    let uniform = random.chance(0.5);
    let load = |random: &mut Random| {
        let one = C::new(1.0, 0.0);
        (0..sites)
            .map(|_| if uniform { one } else { C::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0)) })
            .collect()
    };
    let loads = vec![(1, load(random)), (3, load(random))];
    let static_load = if random.chance(0.5) { vec![1.0; sites] } else { Vec::new() };
    DampedChain {
        gamma1,
        gamma2,
        damping,
        coupling_damping,
        contacts,
        static_load,
        loads,
        ..DampedChain::new(sites, ends)
    }
}

/// What an impulse at one contact does to another after a time, with a bound of its error.
fn answer(modal: &ModalStructure, to: usize, from: usize, time: f64) -> (f64, f64) {
    let of = |mode: &LinearMode| {
        let (flight, size) = (mode.flight(time), |[x, y]: [f64; 2]| x.hypot(y));
        let value = mode.turn.pair(mode.rows[to], flight, mode.columns[from]);
        let grown = flight.even.abs() + flight.odd.abs();
        let rounding = 8.0 * f64::EPSILON * grown * size(mode.rows[to]) * size(mode.columns[from]);
        // |d/dλ e^{λt}| is t e^{λt}, of the faster pole.
        let of_poles = mode.errors.poles * time * (grown + (-mode.decay * time).exp()) * (1.0 + mode.rate * time);
        (
            value,
            grown * mode.errors_between(to, from)
                + size(mode.rows[to]) * size(mode.columns[from]) * of_poles
                + rounding,
        )
    };
    modal.modes().iter().map(of).fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1))
}

/// Shapes and frequencies solve the matrices: (K − Ω²)φ = 0, (C − 2δ)φ = 0, ΦΦᵀ = 1.
fn solves(chain: &DampedChain, modal: &ModalStructure, what: &str) {
    let (matrices, n) = (dense(chain), chain.sites);
    let shapes = DMatrix::from_fn(n, modal.modes().len(), |i, k| modal.modes()[k].coordinates[i][0]);
    let near = 8.0
        * f64::EPSILON
        * (1.0 + chain.gamma1.abs() + 4.0 * chain.gamma2.abs() + chain.damping.abs() + 4.0 * chain.coupling_damping);
    assert!((shapes.tr_mul(&shapes) - DMatrix::identity(n, n)).amax() <= n as f64 * f64::EPSILON, "{what}");
    for (k, mode) in modal.modes().iter().enumerate() {
        let shape = shapes.column(k).into_owned();
        let square = mode.decay * mode.decay + mode.turn.sign() * mode.rate * mode.rate;
        let bent = &matrices.stiffness * &shape - &shape * square;
        assert!(bent.amax() <= near * (1.0 + mode.decay * mode.decay), "{what} mode {k}: {:e}", bent.amax());
        if !matrices.damping.is_empty() {
            let damped = &matrices.damping * &shape - &shape * (2.0 * mode.decay);
            assert!(damped.amax() <= near, "{what} mode {k}: {:e}", damped.amax());
        }
        for (i, (places, _)) in chain.contacts.iter().enumerate() {
            let seen: f64 = places.iter().map(|(n, weight)| shape[*n] * weight).sum();
            assert!((mode.rows[i][0] - seen).abs() <= 2.0 * f64::EPSILON, "{what} mode {k} contact {i}");
        }
    }
}

/// The two agree within what both tell of their errors.
fn agree(modal: &ModalStructure, other: &ModalStructure, what: &str) {
    assert_eq!(modal.modes().len(), other.modes().len(), "{what}");
    // Of the matrices, modes of one frequency may stand in any order, and real poles in any pairs.
    let poles = |modal: &ModalStructure| -> Vec<(C, f64)> {
        // Sums of decay and rate are rounded, too.
        let told = |mode: &LinearMode| mode.errors.poles + f64::EPSILON * (mode.decay.abs() + mode.rate);
        modal.modes().iter().flat_map(|mode| mode.rates().map(|pole| (pole, told(mode)))).collect()
    };
    let mut left = poles(other);
    for (pole, told) in poles(modal) {
        let place = left.iter().position(|(right, as_told)| (right - pole).norm() <= told + as_told);
        left.remove(place.unwrap_or_else(|| panic!("{what}: {pole} {told:e} of {left:?}")));
    }
    let contacts = modal.contacts().len();
    for (to, from) in (0..contacts).flat_map(|to| (0..contacts).map(move |from| (to, from))) {
        for time in [0.3, 1.9] {
            let ((value, told), (right, as_told)) = (answer(modal, to, from, time), answer(other, to, from, time));
            assert!(
                (value - right).abs() <= told + as_told,
                "{what} {to} {from} {time}: {value} {right} {told:e} {as_told:e}"
            );
        }
    }
    for place in 0..2 {
        let found = [modal, other].map(|modal| modal.steady_at(place, 0.83));
        let [Ok(found), Ok(right)] = found else { continue };
        let [told, as_told] = [modal, other].map(|modal| modal.steady_errors_at(place, 0.83, 0.0));
        for i in 0..contacts {
            let off = (found[i] - right[i]).norm();
            assert!(
                off <= told[i] + as_told[i] + 1e-15,
                "{what} load {place} at {i}: {off:e} {:e} {:e}",
                told[i],
                as_told[i]
            );
        }
    }
}

#[test]
fn closed_forms_are_the_modes_of_the_matrices() {
    let mut random = Random(53);
    let (mut rigid, mut creeping, mut critical, mut growing, mut refused) = (0, 0, 0, 0, 0);
    for round in 0..400 {
        let chain = chain(&mut random);
        let what = format!("round {round}: {chain:?}");
        let modal = chain.modal().unwrap_or_else(|error| panic!("{what}: {error}"));
        solves(&chain, &modal, &what);
        match dense(&chain).modal() {
            Ok(other) => {
                agree(&modal, &other, &what);
                let rigid = |modal: &ModalStructure| modal.modes().iter().filter(|mode| mode.is_rigid()).count();
                assert_eq!(rigid(&modal), rigid(&other), "{what}");
            }
            // Without springs between neighbours an eigensolver has no way to tell modes apart that dashpots do tell apart.
            Err(error) => {
                let known = matches!(error, StructureError::RigidDamped | StructureError::Defective { .. });
                assert!(known && chain.gamma2 == 0.0 && chain.coupling_damping > 0.0, "{what}: {error}");
                refused += 1;
            }
        }
        for mode in modal.modes() {
            rigid += usize::from(mode.is_rigid());
            creeping += usize::from(mode.turn.sign() < 0.0);
            critical += usize::from(mode.turn.sign() == 0.0 && mode.decay != 0.0);
            growing += usize::from(mode.decay < 0.0);
        }
        // What is left of a state that modes are made of is the state.
        let state = |random: &mut Random| (0..chain.sites).map(|_| random.between(-1.0, 1.0)).collect::<Vec<f64>>();
        let (place, velocity) = (state(&mut random), state(&mut random));
        let xi = chain.project(&modal, &place, &velocity).unwrap();
        for i in 0..chain.sites {
            let (mut at, mut moving) = (0.0, 0.0);
            for (mode, xi) in modal.modes().iter().zip(&xi) {
                at += mode.coordinates[i][0] * xi[0];
                moving += mode.coordinates[i][0] * mode.turn.act(mode.generator(), *xi)[0];
            }
            assert!((at - place[i]).abs() < 1e-14 && (moving - velocity[i]).abs() < 1e-13, "{what} mass {i}");
        }
    }
    let counts = [rigid, creeping, critical, growing];
    assert!(counts.iter().zip([50, 300, 5, 100]).all(|(count, least)| *count >= least), "{counts:?}");
    assert!(refused < 20, "{refused}");
}

/// The slowest modes alone, where no pair of a ring is cut in two; effective masses of all; and the same is refused for the same reason.
#[test]
fn fewer_modes_and_refusals_are_those_of_the_matrices() {
    let mut random = Random(54);
    let (mut kept, mut refused) = (0, 0);
    for round in 0..400 {
        let mut chain = chain(&mut random);
        if random.chance(0.5) {
            chain.gamma1 -= random.below(64) as f64 / 64.0;
        } else {
            chain.gamma1 += 1.0 / 64.0;
            chain.gamma2 += 1.0 / 64.0;
        }
        let all = chain.sites;
        chain.modes = Some(1 + random.below(all));
        let what = format!("round {round}: {chain:?}");
        let masses = dense(&chain).effective_masses().unwrap();
        let near = chain.effective_masses().iter().zip(&masses).all(|(own, right)| (own - right).abs() < 1e-15 * right);
        assert!(near && masses.len() == chain.contacts.len(), "{what}");
        match (chain.modal(), dense(&chain).modal()) {
            (Ok(modal), Ok(other)) => {
                let whole = DampedChain { modes: None, ..chain.clone() }.modal().unwrap();
                let (last, next) = (modal.modes().last().unwrap(), whole.modes().get(modal.modes().len()));
                let square = |mode: &LinearMode| mode.decay * mode.decay + mode.turn.sign() * mode.rate * mode.rate;
                if next.is_none_or(|next| square(next) - square(last) > 1e-9) {
                    agree(&modal, &other, &what);
                    kept += usize::from(modal.modes().len() < all);
                }
            }
            (Err(StructureError::Unstable { square }), Err(StructureError::Unstable { square: right })) => {
                assert!((square - right).abs() < 1e-14, "{what}: {square} {right}");
                refused += 1;
            }
            (one, other) => {
                let unmoved = |one: &Result<_, _>| match one {
                    Err(StructureError::Unmoved { contact, .. }) => Some(*contact),
                    _ => None,
                };
                let (one, other) = (unmoved(&one), unmoved(&other));
                // Of modes of one frequency, some of which are left out, a contact may see any.
                let modes = chain.modes.unwrap_or_default();
                let may = chain.ends == RowEnds::Alike(Ends::Closed) && modes < all || chain.gamma2 == 0.0;
                assert!(
                    one == other && one.is_some() || may && (one.is_some() || other.is_some()),
                    "{what}: {one:?} {other:?}"
                );
                refused += 1;
            }
        }
    }
    assert!(kept > 80 && refused > 80, "{kept} {refused}");
}
